//! Uniform tessellation: a regular grid of parameters.

use glam::{DVec2, DVec3};

use super::TriangleMesh;
use super::options::MAX_TRIANGLES;
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsSurface, Outside};
use crate::progress::Observer;

/// A grid of `n_u` × `n_v` vertices, evenly spaced in the surface's parameters, two triangles to a
/// cell.
///
/// ```
/// use neurbs::{DVec3, mesh::UniformGrid, nurbs::NurbsSurface, progress::Silent};
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
/// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
/// let mesh = UniformGrid::new(3, 4)?.tessellate(&surface, &mut Silent)?;
/// assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (12, 12));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UniformGrid {
    n_u: usize,
    n_v: usize,
}

/// Output arrays of a tessellation, in memory of the caller.
///
/// Their lengths are the numbers of vertices and of triangles.
pub struct MeshSlices<'a> {
    /// See [`TriangleMesh::vertices`].
    pub vertices: &'a mut [DVec3],
    /// See [`TriangleMesh::triangles`].
    pub triangles: &'a mut [[u32; 3]],
    /// See [`TriangleMesh::normals`].
    pub normals: &'a mut [DVec3],
    /// See [`TriangleMesh::uv`].
    pub uv: &'a mut [DVec2],
}

impl UniformGrid {
    /// A grid of `n_u` × `n_v` vertices.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has fewer than 2 vertices, or the mesh would have more than
    /// [`MAX_TRIANGLES`].
    pub fn new(n_u: usize, n_v: usize) -> Result<Self> {
        let cells = n_u.saturating_sub(1).checked_mul(n_v.saturating_sub(1));
        let fits = cells.is_some_and(|cells| cells <= MAX_TRIANGLES / 2);
        if n_u >= 2 && n_v >= 2 && fits {
            return Ok(Self { n_u, n_v });
        }
        let must =
            format!("(n_u, n_v) of at least 2 each and at most {MAX_TRIANGLES} triangles in all");
        let triangles = cells.map_or(f64::INFINITY, |cells| 2.0 * cells as f64);
        let got = format!("({n_u}, {n_v}), which makes {triangles:.3e} triangles");
        Err(Error::parameter("shape", must, got))
    }

    /// Number of vertices along u and v.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.n_u, self.n_v)
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.n_u * self.n_v
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        2 * (self.n_u - 1) * (self.n_v - 1)
    }

    /// The mesh of a surface on this grid. Vertex (i, j) has the index `i * n_v + j`.
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn tessellate(
        &self,
        surface: &NurbsSurface,
        observer: &mut dyn Observer,
    ) -> Result<TriangleMesh> {
        let mut mesh = TriangleMesh {
            vertices: vec![DVec3::ZERO; self.vertices()],
            triangles: vec![[0; 3]; self.triangles()],
            normals: vec![DVec3::ZERO; self.vertices()],
            uv: vec![DVec2::ZERO; self.vertices()],
            max_deviation: None,
        };
        let out = MeshSlices {
            vertices: &mut mesh.vertices,
            triangles: &mut mesh.triangles,
            normals: &mut mesh.normals,
            uv: &mut mesh.uv,
        };
        self.tessellate_into(surface, out, observer)?;
        Ok(mesh)
    }

    /// As [`UniformGrid::tessellate`], with arrays of the caller.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a slice has the wrong length; [`Error::Interrupted`] if the
    /// observer stops it.
    pub fn tessellate_into(
        &self,
        surface: &NurbsSurface,
        MeshSlices { vertices, triangles, normals, uv }: MeshSlices<'_>,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_length("uv", uv.len(), self.vertices())?;
        check_length("triangles", triangles.len(), self.triangles())?;
        let (u, v) = (
            evenly_spaced(surface.knots_u(), self.n_u),
            evenly_spaced(surface.knots_v(), self.n_v),
        );
        surface.evaluate_grid(&u, &v, vertices, Some(normals), Outside::Refuse, observer)?;
        for (row, &u) in uv.chunks_exact_mut(self.n_v).zip(&u) {
            for (at, &v) in row.iter_mut().zip(&v) {
                *at = DVec2::new(u, v);
            }
        }
        for (row, triangles) in triangles.chunks_exact_mut(2 * (self.n_v - 1)).enumerate() {
            for (col, pair) in triangles.chunks_exact_mut(2).enumerate() {
                pair.copy_from_slice(&self.cell(row, col));
            }
        }
        Ok(())
    }

    /// The cells, row by row: four vertices each, counter-clockwise about `∂/∂u × ∂/∂v`.
    ///
    /// ```
    /// let grid = neurbs::mesh::UniformGrid::new(2, 3)?;
    /// assert_eq!(grid.quads().collect::<Vec<_>>(), [[0, 3, 4, 1], [1, 4, 5, 2]]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    pub fn quads(&self) -> impl Iterator<Item = [u32; 4]> {
        let cols = self.n_v - 1;
        (0..(self.n_u - 1) * cols).map(move |k| self.quad(k / cols, k % cols))
    }

    /// The two triangles of a cell, counter-clockwise about `∂/∂u × ∂/∂v`.
    fn cell(&self, row: usize, col: usize) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.quad(row, col);
        [[a, b, c], [a, c, d]]
    }

    #[expect(clippy::cast_possible_truncation, reason = "MAX_TRIANGLES keeps vertices under 2^32")]
    fn quad(&self, row: usize, col: usize) -> [u32; 4] {
        let vertex = |i: usize, j: usize| ((row + i) * self.n_v + col + j) as u32;
        [vertex(0, 0), vertex(1, 0), vertex(1, 1), vertex(0, 1)]
    }
}

/// Refuses a slice of the wrong length.
pub(super) fn check_length(name: &'static str, got: usize, needed: usize) -> Result<()> {
    if got == needed {
        return Ok(());
    }
    Err(Error::parameter(name, format!("of length {needed}, the size of the mesh"), got))
}

/// Evenly spaced parameters over the domain; the first and the last are exactly its ends.
fn evenly_spaced(knots: &KnotVector, count: usize) -> Vec<f64> {
    let (start, end) = knots.domain();
    let at = |i: usize| i as f64 / (count - 1) as f64;
    (0..count).map(|i| start * (1.0 - at(i)) + end * at(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn triangles_are_counter_clockwise_about_the_normals() {
        let net = (0..16).map(|i| {
            let (x, y) = (f64::from(i / 4), f64::from(i % 4));
            DVec3::new(x, y, 0.2 * (x - 1.0) * (y - 2.0))
        });
        let surface = NurbsSurface::clamped(net.collect(), (4, 4), 3).unwrap();
        let mesh = UniformGrid::new(9, 5).unwrap().tessellate(&surface, &mut Silent).unwrap();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize]);
            let normal = mesh.normals[triangle[0] as usize];
            assert!((b - a).cross(c - a).normalize().dot(normal) > 0.8);
        }
    }

    #[test]
    fn vertices_are_the_surface_points_of_their_parameters() {
        let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
        let knots = |a: f64, b: f64| KnotVector::new(1, vec![a, a, b, b]).unwrap();
        let surface = NurbsSurface::new(net, None, knots(-1.0, 0.1), knots(2.0, 5.0)).unwrap();
        let mesh = UniformGrid::new(4, 8).unwrap().tessellate(&surface, &mut Silent).unwrap();
        assert_eq!(mesh.uv[0], DVec2::new(-1.0, 2.0));
        assert_eq!(mesh.uv[31], DVec2::new(0.1, 5.0));
        for (vertex, at) in mesh.vertices.iter().zip(&mesh.uv) {
            assert!(vertex.distance(surface.point(at.x, at.y)) < 1e-15);
        }
    }

    #[test]
    fn too_few_or_too_many_vertices_are_refused() {
        let message = |n_u, n_v| UniformGrid::new(n_u, n_v).unwrap_err().to_string();
        assert!(message(1, 5).contains("got (1, 5)"));
        assert!(message(20_000, 20_000).contains("7.999e8 triangles"));
        assert!(message(usize::MAX, usize::MAX).contains("inf triangles"));
        assert!(UniformGrid::new(7_072, 7_072).is_ok());
    }
}
