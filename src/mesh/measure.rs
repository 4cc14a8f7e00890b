//! Measures of a mesh: area, volume, Euler characteristic, boundary.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::MeshView;
use crate::worker_pool;

/// Triangles in a partial sum: a fixed number, so that sums do not depend on the number of threads.
const TRIANGLES_PER_SUM: usize = 1 << 14;

impl MeshView<'_> {
    /// The area of all triangles, in the square of the points' unit.
    ///
    /// ```
    /// use neurbs::{DVec3, mesh::UniformGrid, nurbs::NurbsSurface, progress::Silent};
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
    /// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
    /// let mesh = UniformGrid::new(4, 5)?.tessellate(&surface, &mut Silent)?;
    /// assert!((mesh.view().area() - 1.0).abs() < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn area(&self) -> f64 {
        self.sum(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
    }

    /// The volume that a closed mesh encloses, in the cube of the points' unit.
    ///
    /// Negative if the normals point inwards; `None` if the mesh has a boundary.
    #[must_use]
    pub fn volume(&self) -> Option<f64> {
        if !self.boundary_edges().is_empty() {
            return None;
        }
        // Relative to a vertex, so that meshes far from the origin keep precision.
        let origin = self.vertices.first().copied().unwrap_or_default();
        Some(self.sum(|[a, b, c]| (a - origin).dot((b - origin).cross(c - origin)) / 6.0))
    }

    /// Vertices - edges + triangles: 1 for a disc, 0 for a tube and a torus, 2 for a sphere.
    ///
    /// Vertices that belong to no triangle are ignored.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let mut edges: Vec<(u32, u32)> =
            self.directed_edges().map(|(a, b)| (a.min(b), a.max(b))).collect();
        worker_pool::install(|| edges.par_sort_unstable());
        edges.dedup();
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
        let vertices = used.iter().filter(|used| **used).count();
        let count = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
        count(vertices) - count(edges.len()) + count(self.triangles.len())
    }

    /// The boundary loops, each as the vertices along it; none if the mesh is closed.
    ///
    /// Seen from the side of the normals, the mesh is to the left.
    #[must_use]
    pub fn boundary_loops(&self) -> Vec<Vec<u32>> {
        let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (a, b) in self.boundary_edges() {
            next.entry(a).or_default().push(b);
        }
        let mut loops = vec![];
        while let Some((&start, _)) = next.first_key_value() {
            let (mut boundary, mut at) = (vec![], start);
            while let Some(ends) = next.get_mut(&at) {
                boundary.push(at);
                let ahead = ends.pop();
                if ends.is_empty() {
                    next.remove(&at);
                }
                match ahead {
                    Some(ahead) if ahead != start => at = ahead,
                    _ => break,
                }
            }
            loops.push(boundary);
        }
        loops
    }

    /// The edges that belong to one triangle only, directed as in that triangle, sorted.
    #[must_use]
    pub fn boundary_edges(&self) -> Vec<(u32, u32)> {
        let mut edges: Vec<(u32, u32, bool)> =
            self.directed_edges().map(|(a, b)| (a.min(b), a.max(b), a > b)).collect();
        worker_pool::install(|| edges.par_sort_unstable());
        let runs = edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
        let alone = runs.filter(|run| run.len() == 1).map(|run| run[0]);
        let mut alone: Vec<_> =
            alone.map(|(a, b, back)| if back { (b, a) } else { (a, b) }).collect();
        alone.sort_unstable();
        alone
    }

    fn directed_edges(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
    }

    fn sum(&self, of: impl Fn([DVec3; 3]) -> f64 + Sync) -> f64 {
        let corners = |triangle: &[u32; 3]| triangle.map(|i| self.vertices[i as usize]);
        let sums = self.triangles.par_chunks(TRIANGLES_PER_SUM);
        let sums = sums.map(|part| part.iter().map(|triangle| of(corners(triangle))).sum());
        let sums: Vec<f64> = worker_pool::install(|| sums.collect());
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TessellateOptions, TriangleMesh};
    use super::*;
    use crate::nurbs::NurbsSurface;
    use crate::progress::Silent;

    fn mesh(surface: &NurbsSurface) -> TriangleMesh {
        surface.tessellate(&TessellateOptions::default(), &mut Silent).unwrap()
    }

    #[test]
    fn a_torus_is_closed_and_has_its_exact_volume_and_area() {
        let torus = mesh(&NurbsSurface::torus(DVec3::splat(1e6), 3.0, 1.0).unwrap());
        let (view, volume) = (torus.view(), 2.0 * std::f64::consts::PI.powi(2) * 3.0);
        assert_eq!((view.euler_characteristic(), view.boundary_loops().len()), (0, 0));
        assert!((view.volume().unwrap().abs() / volume - 1.0).abs() < 0.01);
        assert!((view.area() / (4.0 * std::f64::consts::PI.powi(2) * 3.0) - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_square_has_one_boundary_loop_and_no_volume() {
        let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
        let square = mesh(&NurbsSurface::clamped(net, (2, 2), 1).unwrap());
        assert_eq!(square.triangles.len(), 2);
        let view = square.view();
        assert_eq!((view.euler_characteristic(), view.volume()), (1, None));
        let loops = view.boundary_loops();
        assert_eq!((loops.len(), loops[0].len()), (1, 4));
        let turn = |k: usize| square.vertices[loops[0][k % 4] as usize];
        let area: f64 = (0..4).map(|k| turn(k).cross(turn(k + 1)).z / 2.0).sum();
        assert!((area - 1.0).abs() < 1e-15, "counter-clockwise");
    }
}
