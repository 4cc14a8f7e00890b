//! The fit of all points by one surface: knots, fairness, robust weights and tolerance.

use glam::{DVec2, DVec3};

use super::initial_net::initial_shape;
use super::options::ReconstructOptions;
use super::projection::Projection;
use super::robust_weights::outlier_weights;
use super::settings::FitProblemSettings;
use super::surface_fit::SurfaceFit;
use super::trained_map::TrainedMap;
use crate::chart::Kind;
use crate::error::{Error, Result};
use crate::fit::{
    self, Accept, ApproximateOptions, BasePlane, EndedBy, FittedSurface, Growth, HeightOptions,
    approximate, bounded, continued, cutoff_distance, grow_heights, project,
};
use crate::nurbs::ClosestPointSearch;
use crate::progress::Observer;

const SETTINGS: FitProblemSettings = FitProblemSettings::STANDARD;

/// All points of the local frame, the kind of surface that is fitted to them, and the options.
#[derive(Clone, Copy)]
pub(super) struct FitProblem<'a> {
    pub(super) points: &'a [DVec3],
    /// Weights of the squared distances; `None`: 1.
    pub(super) weights: Option<&'a [f64]>,
    pub(super) kind: Kind,
    /// Axes of a height field: two in its plane, and the direction of the heights.
    pub(super) heights: Option<[DVec3; 3]>,
    /// Lengths of the surface along u and v.
    pub(super) lengths: [f64; 2],
    /// Standard deviation of the points' noise.
    pub(super) noise: f64,
    /// Spacing of the points.
    pub(super) spacing: f64,
    /// The tolerance in the local frame.
    pub(super) tolerance: Option<f64>,
    pub(super) options: &'a ReconstructOptions<'a>,
}

impl FitProblem<'_> {
    /// Fits the initial net, from the points' projection onto a coarse surface.
    pub(super) fn fit_initial_net(
        &self,
        start: &Projection,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        let weights = self.robust_weights(&start.distances, self.spacing, observer)?;
        let fitted = if self.heights.is_some() {
            self.fit_heights_with(
                self.initial_shape(),
                weights,
                None,
                self.options.fairness,
                observer,
            )?
        } else {
            self.fit_sheet(&bounded(&start.uv, self.kind.closed()), weights, observer)?
        };
        self.reweight(fitted, observer)
    }

    /// Refines the net as far as the points determine it. A net of given size stays.
    ///
    /// If finer nets were not accepted, the second result is the last accepted one.
    pub(super) fn grow(
        &self,
        small: SurfaceFit,
        accept: Accept<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(SurfaceFit, Option<SurfaceFit>)> {
        if self.options.grid.is_some() {
            return Ok((small, None));
        }
        if self.heights.is_some() {
            let grown = self.fit_heights(small.weights, observer)?;
            return Ok((self.reweight(grown, observer)?, None));
        }
        let (weights, fairness) = (small.weights.clone(), self.options.fairness);
        self.continue_fit(&small, weights, fairness, self.growth(), accept, observer)
    }

    /// Refits a surface with other weights and the same net.
    fn refit(
        &self,
        known: &SurfaceFit,
        weights: Vec<f64>,
        fairness: Option<f64>,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        Ok(self.continue_fit(known, weights, fairness, None, &|_, _| Ok(true), observer)?.0)
    }

    /// Refits a surface with other weights and a net that may grow. If finer nets were not
    /// accepted, the second result is the last accepted one.
    fn continue_fit(
        &self,
        known: &SurfaceFit,
        weights: Vec<f64>,
        fairness: Option<f64>,
        growth: Option<Growth>,
        accept: Accept<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(SurfaceFit, Option<SurfaceFit>)> {
        let from = FittedSurface {
            surface: &known.surface,
            uv: &known.uv,
            closed: self.kind.closed(),
            fairness: known.fairness,
        };
        let (points, given) = (self.points, Some(weights.as_slice()));
        let found = continued(points, given, &from, fairness, growth, accept, observer)?;
        let accepted = found.accepted.map(|found| SurfaceFit::new(found, weights.clone()));
        Ok((SurfaceFit::new(found.finest, weights), accepted))
    }

    /// Refits a surface without its outliers until these stay the same, a few times at most.
    fn reweight(&self, mut fitted: SurfaceFit, observer: &mut dyn Observer) -> Result<SurfaceFit> {
        for _ in 0..SETTINGS.max_reweightings {
            let weights = self.robust_weights(&fitted.distances, 0.0, observer)?;
            if same_outliers(&weights, &fitted.weights) {
                break;
            }
            fitted = if self.heights.is_some() {
                let (net, fairness) = (fitted.surface.shape(), Some(fitted.fairness));
                let again = self.fit_heights_with(net, weights, None, fairness, observer)?;
                SurfaceFit { ended_by: fitted.ended_by, ..again }
            } else {
                self.refit(&fitted, weights, self.options.fairness, observer)?
            };
        }
        Ok(fitted)
    }

    /// Fits a surface from a trained map alone.
    pub(super) fn fit_map(
        &self,
        map: &TrainedMap,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        let weights = self.robust_weights(&[], 0.0, observer)?;
        let fitted = if self.heights.is_some() {
            self.fit_heights(weights, observer)?
        } else {
            let mut uv = Vec::with_capacity(self.points.len());
            let take = |places: &[DVec2]| uv.extend_from_slice(places);
            map.map.lattice_places(self.points, SETTINGS.extrapolation, observer, take)?;
            self.fit_sheet(&bounded(&uv, self.kind.closed()), weights, observer)?
        };
        Ok(self.grow(fitted, &|_, _| Ok(true), observer)?.0)
    }

    /// Refits a surface with this fairness and the same net.
    pub(super) fn refit_with_fairness(
        &self,
        known: &SurfaceFit,
        fairness: f64,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        self.refit(known, known.weights.clone(), Some(fairness), observer)
    }

    /// Refines the net until the tolerance holds. Returns `None` without a tolerance, and if no
    /// nearer surface is found: neither its rms nor its largest distance may be larger.
    pub(super) fn grow_to_tolerance(
        &self,
        fitted: &SurfaceFit,
        accept: Accept<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Option<SurfaceFit>> {
        let Some(tolerance) = self.tolerance else { return Ok(None) };
        let growth = Growth { tolerance: Some(tolerance), most: self.options.max_control_points };
        let mut best: Option<SurfaceFit> = None;
        // Almost no fairness lets the surface follow regions with few points.
        for fairness in [self.options.fairness, Some(SETTINGS.min_fairness)] {
            let from = best.as_ref().unwrap_or(fitted);
            if from.max() <= tolerance {
                break;
            }
            let weights = from.weights.clone();
            let nearer = if self.heights.is_some() {
                self.fit_heights_with(
                    self.initial_shape(),
                    weights,
                    Some(growth),
                    fairness,
                    observer,
                )
            } else {
                let grown = Some(growth);
                self.continue_fit(from, weights, fairness, grown, accept, observer).map(|all| all.0)
            };
            match nearer {
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Ok(nearer) if nearer.max() <= from.max() && nearer.rms() <= from.rms() => {
                    best = Some(nearer);
                }
                _ => {}
            }
        }
        Ok(best)
    }

    /// The given weights, reduced at outliers. A point nearer than `min_distance`, or within the
    /// noise, is no outlier.
    fn robust_weights(
        &self,
        distances: &[f64],
        min_distance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Vec<f64>> {
        let mut weights =
            self.weights.map_or_else(|| vec![1.0; self.points.len()], <[f64]>::to_vec);
        if self.options.robust
            && !distances.is_empty()
            && let Some(found) = outlier_weights(
                self.points,
                distances,
                min_distance.max(cutoff_distance(self.noise)),
                observer,
            )?
        {
            weights.iter_mut().zip(found).for_each(|(weight, share)| *weight *= share);
        }
        Ok(weights)
    }

    /// Growth without a tolerance; `None` if the size of the net is given.
    fn growth(&self) -> Option<Growth> {
        let free = self.options.grid.is_none();
        free.then_some(Growth { tolerance: None, most: self.options.max_control_points })
    }

    /// The degrees that a net of this shape allows.
    fn degree(&self, (rows, cols): (usize, usize)) -> (usize, usize) {
        (self.options.degree.min(rows - 1), self.options.degree.min(cols - 1))
    }

    /// Rows and columns of the initial net.
    pub(super) fn initial_shape(&self) -> (usize, usize) {
        initial_shape(self.points.len(), self.kind, self.lengths, self.options)
    }

    /// Fits a sheet, tube or torus with the initial net from these parameters.
    fn fit_sheet(
        &self,
        uv: &[DVec2],
        weights: Vec<f64>,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        let net = self.initial_shape();
        let options = ApproximateOptions {
            net,
            degree: self.degree(net),
            closed: self.kind.closed(),
            fairness: self.options.fairness,
            border: self.options.border.unwrap_or(SETTINGS.border),
            ..ApproximateOptions::default()
        };
        let found = approximate(self.points, uv, Some(&weights), &options, observer)?;
        Ok(SurfaceFit::new(found, weights))
    }

    /// Fits a height field whose net grows if it may.
    fn fit_heights(&self, weights: Vec<f64>, observer: &mut dyn Observer) -> Result<SurfaceFit> {
        self.fit_heights_with(
            self.initial_shape(),
            weights,
            self.growth(),
            self.options.fairness,
            observer,
        )
    }

    /// Fits a height field with this net, weights, growth and fairness.
    fn fit_heights_with(
        &self,
        net: (usize, usize),
        weights: Vec<f64>,
        growth: Option<Growth>,
        fairness: Option<f64>,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        let [along, across, up] = self.heights.unwrap_or(DVec3::AXES);
        let base = BasePlane { axes: [along, across], up };
        let options = HeightOptions { net, degree: self.degree(net), fairness };
        let most = net.0 * net.1;
        let limits = growth.unwrap_or(Growth { tolerance: None, most });
        let (fit, ended_by) =
            grow_heights(self.points, Some(&weights), &base, &options, limits, observer)?;
        let ended_by = if growth.is_none() { EndedBy::Grid } else { ended_by };
        let (uv, distances) = project(&fit.surface, (false, false), self.points, &fit.uv);
        let squares = |all: &[f64]| {
            all.iter().zip(&weights).map(|(off, weight)| weight * off * off).sum::<f64>()
        };
        // Cross-validation measures heights; this ratio turns them into distances.
        let slope = squares(&distances) / squares(&fit.residuals);
        let expected = fit.expected.is_finite().then_some(slope * fit.expected);
        let (surface, fairness) = (fit.surface, fit.fairness);
        Ok(SurfaceFit {
            surface,
            uv,
            distances,
            weights,
            fairness,
            expected,
            iterations: 1,
            ended_by,
        })
    }

    /// Fits weights of the control points, and keeps them if the surface is nearer then.
    pub(super) fn fit_weights(
        &self,
        fitted: SurfaceFit,
        observer: &mut dyn Observer,
    ) -> Result<SurfaceFit> {
        let weights = Some(fitted.weights.as_slice());
        let surface = fit::fit_weights(&fitted.surface, self.points, weights, observer)?;
        if surface == fitted.surface {
            return Ok(fitted);
        }
        let (uv, distances) =
            ClosestPointSearch::new(&surface)?.closest_parameters(self.points, observer)?;
        Ok(SurfaceFit { surface, uv, distances, ..fitted })
    }
}

/// Whether two sets of weights leave out the same points.
fn same_outliers(some: &[f64], others: &[f64]) -> bool {
    some.iter().zip(others).all(|(a, b)| (*a == 0.0) == (*b == 0.0))
}
