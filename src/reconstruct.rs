//! The whole job: scattered points in, a surface and its mesh out.

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::error::Result;
use crate::mesh::{TriangleMesh, UniformGrid};
use crate::nurbs::{MAX_DEGREE, NurbsSurface, OrderedSurface, check_degree};
use crate::point_cloud::{self, Bounds};
use crate::progress::Observer;
use crate::som::{Lattice, SelfOrganizingMap, SomOptions, StoppedBy};

/// How to reconstruct; the default derives everything from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReconstructOptions {
    /// How the surface comes from the points.
    pub method: Method,
    /// What the lattice is to the surface.
    pub surface: OrderedSurface,
    /// Rows and columns of the lattice, and so of the control net; `None`: see
    /// [`Lattice::for_points`], but no more of a Bézier surface than it can have.
    pub grid: Option<(usize, usize)>,
    /// Degree of the surface in both directions, lowered where the net has too few rows or
    /// columns for it.
    pub degree: usize,
    /// Seed of everything random; the same seed gives the same bits.
    pub seed: u64,
    /// See [`SomOptions::max_steps`].
    pub max_steps: Option<u64>,
    /// See [`SomOptions::reach`]; in the points' unit.
    pub reach: Option<f64>,
    /// See [`SomOptions::min_change`]; in the points' unit.
    pub min_change: Option<f64>,
}

impl Default for ReconstructOptions {
    fn default() -> Self {
        Self {
            method: Method::Paper,
            surface: OrderedSurface::ControlNet,
            grid: None,
            degree: 3,
            seed: 0,
            max_steps: None,
            reach: None,
            min_change: None,
        }
    }
}

/// How the surface comes from the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's method: the surface of the trained lattice, by [`ReconstructOptions::surface`].
    Paper,
}

impl Method {
    /// The method's name, as Python and the command line spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
        }
    }
}

/// What [`reconstruct`] returns; everything in the points' own frame and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The surface.
    pub surface: NurbsSurface,
    /// The trained map.
    pub som: SelfOrganizingMap,
    /// How it went.
    pub report: Report,
}

/// How a reconstruction went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Number of points.
    pub points: usize,
    /// Length of the diagonal of the points' bounding box, in their unit.
    pub diagonal: f64,
    /// Rows and columns of the control net.
    pub grid: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// Presentations made.
    pub steps: u64,
    /// The paper's t₀; see [`SelfOrganizingMap::ordered_at`].
    pub ordered_at: u64,
    /// What ended the training.
    pub stopped_by: StoppedBy,
    /// Points on the lattice at the end; see [`SelfOrganizingMap::reached`].
    pub reached: usize,
    /// Largest move of a node during the last epoch, in the points' unit; `None` if not even one
    /// was finished.
    pub change: Option<f64>,
    /// Mean distance from a point to its nearest node, in the points' unit.
    pub quantization_error: f64,
    /// Time spent on checking the points, and on training and measuring the map.
    pub training_time: Duration,
}

impl Reconstruction {
    /// The surface as triangles, on the grid of [`UniformGrid::for_surface`].
    ///
    /// # Errors
    ///
    /// Those of [`UniformGrid::for_surface`]; [`crate::Error::Interrupted`] if the observer stops
    /// it.
    pub fn tessellate(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        UniformGrid::for_surface(&self.surface)?.tessellate(&self.surface, observer)
    }
}

/// Turns scattered points into a NURBS surface; [`Reconstruction::tessellate`] turns that into
/// triangles.
///
/// By the paper's method: a Kohonen network learns the points, and its lattice becomes the control
/// net of a clamped B-spline surface, a grid to interpolate, or a Bézier net. Points that are in
/// order already need no network: [`OrderedSurface::through`] is this last stage.
///
/// # Errors
///
/// Those of [`point_cloud::check`]; [`crate::Error::Parameter`] for an option out of its range;
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn reconstruct(
    points: &[DVec3],
    options: &ReconstructOptions,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let start = Instant::now();
    check_degree(options.degree)?;
    let bounds = point_cloud::checked_bounds(points, observer)?;
    let som = learn(points, &bounds, options, observer)?;
    let quantization_error = som.quantization_error(points, observer)?;
    let training_time = start.elapsed();
    let surface = options.surface.through(som.codebook(), som.lattice.shape(), options.degree)?;
    let report = Report {
        points: points.len(),
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        steps: som.steps,
        ordered_at: som.ordered_at,
        stopped_by: som.stopped_by,
        reached: som.reached,
        change: som.change,
        quantization_error,
        training_time,
    };
    Ok(Reconstruction { surface, som, report })
}

/// Trains the map by the paper's section 4.
fn learn(
    points: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let lattice = match options.grid {
        Some((rows, cols)) => Lattice::quad(rows, cols)?,
        None if options.surface == OrderedSurface::Bezier => {
            let (rows, cols) = Lattice::for_points(points.len()).shape();
            Lattice::quad(rows.min(MAX_DEGREE + 1), cols.min(MAX_DEGREE + 1))?
        }
        None => Lattice::for_points(points.len()),
    };
    options.surface.check_shape(lattice.shape())?;
    let som_options = SomOptions {
        seed: options.seed,
        max_steps: options.max_steps,
        reach: options.reach,
        min_change: options.min_change,
        ..SomOptions::paper()
    };
    SelfOrganizingMap::fit_within(bounds, points, lattice, &som_options, observer)
}
