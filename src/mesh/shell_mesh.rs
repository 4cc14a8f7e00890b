//! Triangles of faces and shells within a certified tolerance.
//!
//! 1. Connected whole faces get the meshes of their surfaces, with common vertices on edges.
//! 2. Each other edge is divided once; both faces take its points, so that the mesh has no cracks.
//! 3. In each other face, the cells of its surface that no loop comes near are kept as they are.
//! 4. A constrained Delaunay triangulation in (u, v) fills the strip between them and the loops. It
//!    gets more points until each of its triangles is certified.
//! 5. Vertices get their indices, in the order of the faces.
//!
//! Faces are independent, so the result does not depend on the number of threads.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use super::edge_points::{EdgePoints, divide};
use super::face_mesh::{Attempt, FaceMesh, FaceMesher, scale};
use super::mesh_join::{join, overused};
use super::options::Limits;
use super::outline::Origin;
use super::parallel_map::{MIN_PARALLEL_TRIANGLES, parallel_map};
use super::partition::too_many_triangles;
use super::whole_faces::mesh_whole_faces;
use super::{TessellateOptions, TriangleMesh};
use crate::brep::{Edge, Face, Shell};
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{Observer, Silent};

/// Rounds in which edges that cross in a triangulation are divided again, at most.
const MAX_ROUNDS: usize = 16;

/// Patches of a surface from which on it is tessellated by all threads.
const MANY_PATCHES: usize = 1 << 12;

/// Relative error of the area by which too many triangles are refused.
const AREA_ACCURACY: f64 = 0.1;

/// Halvings of a closed edge at least: with fewer than three chords it would have no area.
const MIN_HALVINGS_OF_CLOSED: u32 = 2;

/// The triangles of a shell.
///
/// ```
/// use neurbs::{DVec3, Face, NurbsSurface, Shell, mesh::TessellateOptions, progress::Silent};
/// let ball = |x: f64| Face::whole(NurbsSurface::sphere(x * DVec3::X, 1.0)?);
/// let shell = Shell::new(vec![ball(0.0)?, ball(3.0)?], None)?;
/// let found = shell.tessellate(&TessellateOptions::default(), &mut Silent)?;
/// assert_eq!(found.faces.len(), found.mesh.triangles.len());
/// assert_eq!(found.mesh.view().euler_characteristic(), 4);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShellMesh {
    /// The triangles of all faces. Normals are those of the faces. Faces share the vertices on their
    /// common edges; these have the normal and the parameters of the first face.
    pub mesh: TriangleMesh,
    /// The index of the face of each triangle.
    pub faces: Vec<u32>,
}

impl Shell {
    /// The faces as triangles that lie within a certified tolerance of them everywhere.
    ///
    /// Faces share the vertices on their common edges: the mesh of a closed shell is closed. A
    /// shell of one face without loops of its own gives the mesh of its surface.
    ///
    /// `max_deviation` exceeds the tolerance only where the gap between two faces at an edge does
    /// so. The same bits for any number of threads. `max_aspect` applies away from edges;
    /// `split_seams` to a shell of one whole surface only.
    ///
    /// # Errors
    ///
    /// - Those of [`NurbsSurface::tessellate`].
    /// - [`Error::Shell`] if loops of a face cross or touch.
    pub fn tessellate(
        &self,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<ShellMesh> {
        if let [face] = self.faces()
            && !face.is_trimmed()
        {
            let mesh = whole_mesh(face, options, observer)?;
            return Ok(ShellMesh { faces: vec![0; mesh.triangles.len()], mesh });
        }
        let surfaces: Vec<&NurbsSurface> =
            self.faces().iter().map(|face| &**face.surface()).collect();
        let limits = options.limits(&surfaces)?;
        check_max_edge(self, options, &limits, observer)?;
        let least = least_halvings(self);
        let mut meshes = mesh_whole_faces(self, options, &limits, &least, observer)?;
        let faces = self.faces().iter().zip(&meshes);
        let scale = |(face, mesh): (&Face, &Option<_>)| {
            mesh.as_ref().map_or_else(|| scale(face), |_| DVec2::ONE)
        };
        let scales: Vec<DVec2> = faces.map(scale).collect();
        let is_left = |edge: usize| meshes[self.edges()[edge].uses[0].face].is_none();
        let left: Vec<usize> = (0..self.edges().len()).filter(|edge| is_left(*edge)).collect();
        let mut edges = divide_edges(self, &left, &least, (&scales, &limits), observer)?;
        let mut forbidden = BTreeSet::new();
        for _ in 0..MAX_ROUNDS {
            let mesher = FaceMesher {
                shell: self,
                edges: &edges,
                scales: &scales,
                options,
                limits: &limits,
            };
            let crossing = mesh_faces(mesher, &forbidden, &mut meshes, observer)?;
            if crossing.is_empty() {
                let shared = overused(&meshes);
                if shared.is_empty() {
                    let done: Vec<&FaceMesh> = meshes.iter().flatten().collect();
                    let deviation = edges.iter().map(|edge| edge.deviation).fold(0.0, f64::max);
                    let (mesh, faces) = join(self.faces(), &done, deviation);
                    return Ok(ShellMesh { mesh, faces });
                }
                forbidden.extend(shared.iter().map(|(_, side)| *side));
                for (face, _) in shared {
                    meshes[face] = None;
                }
                continue;
            }
            for (edge, chords) in crossing {
                edges[edge] =
                    divide(self, (edge, 0), &scales, &limits, Some((&edges[edge], &chords)))?;
                for used in &self.edges()[edge].uses {
                    meshes[used.face] = None;
                }
            }
        }
        let must = "have loops that neither cross nor touch";
        Err(Error::Shell { must, got: "loops that are too close to triangulate".into() })
    }
}

/// Checks that triangles with sides up to `max_edge` are not too many.
fn check_max_edge(
    shell: &Shell,
    options: &TessellateOptions,
    limits: &Limits,
    observer: &mut dyn Observer,
) -> Result<()> {
    let Some(edge) = limits.edge else { return Ok(()) };
    // The largest triangle with such sides has equal ones.
    let least = shell.area(AREA_ACCURACY, observer)? / (0.25 * 3.0_f64.sqrt() * edge * edge);
    if least > options.max_triangles as f64 {
        let must = format!("large enough for at most {} triangles", options.max_triangles);
        let got = format!("{edge:e}, which takes at least {least:.1e}");
        return Err(Error::parameter("max_edge", must, got));
    }
    Ok(())
}

impl Face {
    /// The face as triangles that lie within a certified tolerance of it everywhere.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsCurve, NurbsSurface};
    /// use neurbs::{mesh::TessellateOptions, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y)?;
    /// let center = DVec3::new(0.5, 0.5, 0.0);
    /// let turn = std::f64::consts::TAU;
    /// let circle = NurbsCurve::arc(center, 0.25 * DVec3::X, 0.25 * DVec3::Y, turn)?;
    /// let disc = Face::trimmed(plane, vec![vec![circle]])?;
    /// let options = TessellateOptions { tolerance: Some(1e-4), ..Default::default() };
    /// let mesh = disc.tessellate(&options, &mut Silent)?;
    /// assert!((mesh.view().area() / (turn / 8.0) - 1.0).abs() < 1e-3);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Shell::new`] and [`Shell::tessellate`].
    pub fn tessellate(
        &self,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<TriangleMesh> {
        if !self.is_trimmed() {
            return whole_mesh(self, options, observer);
        }
        Ok(Shell::new(vec![self.clone()], None)?.tessellate(options, observer)?.mesh)
    }
}

/// The mesh of a face without loops of its own.
fn whole_mesh(
    face: &Face,
    options: &TessellateOptions,
    observer: &mut dyn Observer,
) -> Result<TriangleMesh> {
    let mut mesh = face.surface().tessellate(options, observer)?;
    if face.is_reversed() {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
    }
    Ok(mesh)
}

/// How often each edge is halved at least, so that no two of the chords have the same ends.
fn least_halvings(shell: &Shell) -> Vec<u32> {
    let ends = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let mut between: BTreeMap<[usize; 2], u32> = BTreeMap::new();
    for edge in shell.edges() {
        *between.entry(ends(edge.vertices)).or_default() += 1;
    }
    let least = |edge: &Edge| match edge.vertices {
        [a, b] if a == b => MIN_HALVINGS_OF_CLOSED,
        vertices => u32::from(between[&ends(vertices)] > 1),
    };
    shell.edges().iter().map(least).collect()
}

/// Divides some edges; the others get no points.
fn divide_edges(
    shell: &Shell,
    some: &[usize],
    least: &[u32],
    (scales, limits): (&[DVec2], &Limits),
    observer: &mut dyn Observer,
) -> Result<Vec<EdgePoints>> {
    let mut all = vec![EdgePoints::default(); least.len()];
    let job =
        |(): &mut (), edge: usize| (edge, divide(shell, (edge, least[edge]), scales, limits, None));
    let triangles = MIN_PARALLEL_TRIANGLES + some.len();
    parallel_map(some.iter().copied(), triangles, observer, job, |(edge, points)| {
        all[edge] = points?;
        Ok(())
    })?;
    Ok(all)
}

/// Triangulates the faces without a mesh. Returns the chords that must be divided before, by edge.
fn mesh_faces(
    mesher: FaceMesher<'_>,
    forbidden: &BTreeSet<[Origin; 2]>,
    meshes: &mut [Option<FaceMesh>],
    observer: &mut dyn Observer,
) -> Result<BTreeMap<usize, BTreeSet<usize>>> {
    let missing = (0..meshes.len()).filter(|face| meshes[*face].is_none());
    let is_large = |face: &usize| {
        let (rows, cols) = mesher.shell.faces()[*face].surface().shape();
        rows * cols >= MANY_PATCHES
    };
    let (large, small): (Vec<usize>, Vec<usize>) = missing.partition(is_large);
    let mut found = vec![];
    // The threads share the work of a large face.
    for face in large {
        found.push((face, mesher.mesh(face, forbidden, observer)?));
    }
    let job = |(): &mut (), face: usize| (face, mesher.mesh(face, forbidden, &mut Silent));
    parallel_map(small, usize::MAX, observer, job, |(face, attempt)| {
        found.push((face, attempt?));
        Ok(())
    })?;
    let mut crossing: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for (face, attempt) in found {
        match attempt {
            Attempt::Done(mesh) => meshes[face] = Some(mesh),
            Attempt::Crossing(chords) if chords.is_empty() => {
                let must = "have loops that neither cross nor touch";
                return Err(Error::Shell { must, got: format!("others at face {face}") });
            }
            Attempt::Crossing(chords) => {
                for (edge, chord) in chords {
                    crossing.entry(edge).or_default().insert(chord);
                }
            }
        }
    }
    let triangles: usize = meshes.iter().flatten().map(|mesh| mesh.triangles.len()).sum();
    if triangles > mesher.options.max_triangles {
        return Err(too_many_triangles(mesher.options, mesher.limits, triangles as f64));
    }
    Ok(crossing)
}
