//! The constrained Delaunay triangulation of the strip between a face's loops and its kept cells.

use glam::DVec2;
use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Coordinates below which a point is on the axis: the triangulation refuses smaller ones.
const MIN_COORDINATE: f64 = 1e-60;

/// A point of the triangulation.
#[derive(Clone, Copy, Debug)]
struct Site {
    at: Point2<f64>,
    node: usize,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// A triangle of the strip, counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct StripTriangle {
    pub nodes: [usize; 3],
    /// Whether each side, from a node to the next one, is on a loop or a kept cell.
    pub fixed: [bool; 3],
    /// The node opposite to each side in the next triangle.
    pub opposite: [Option<usize>; 3],
}

/// The triangulation, in scaled (u, v).
#[derive(Debug)]
pub(super) struct StripTriangulation {
    scale: DVec2,
    cdt: ConstrainedDelaunayTriangulation<Site>,
}

impl StripTriangulation {
    /// Triangulates places in (u, v) with fixed sides.
    ///
    /// Returns the fixed sides that another one crosses, or that a place lies on, if there are any.
    pub(super) fn new(
        places: impl Iterator<Item = DVec2>,
        fixed: Vec<[usize; 2]>,
        scale: DVec2,
    ) -> Result<Self, Vec<[usize; 2]>> {
        let sites: Vec<Site> =
            places.enumerate().map(|(node, uv)| Site { at: site(scale * uv), node }).collect();
        let (count, sides) = (sites.len(), fixed.clone());
        let mut conflicts = vec![];
        let cdt =
            ConstrainedDelaunayTriangulation::<Site>::try_bulk_load_cdt(sites, fixed, |side| {
                conflicts.push(side);
            });
        let Ok(cdt) = cdt else { return Err(sides) };
        if cdt.num_vertices() == count {
            let vertex = FixedVertexHandle::from_index;
            let missing =
                |side: &[usize; 2]| !cdt.exists_constraint(vertex(side[0]), vertex(side[1]));
            conflicts.extend(sides.into_iter().filter(missing));
        } else if conflicts.is_empty() {
            return Err(sides);
        }
        if conflicts.is_empty() { Ok(Self { scale, cdt }) } else { Err(conflicts) }
    }

    /// Adds a node inside the strip; returns whether its place was free.
    pub(super) fn insert(&mut self, uv: DVec2, node: usize) -> bool {
        let count = self.cdt.num_vertices();
        let at = site(self.scale * uv);
        // A point on a vertex would replace its node.
        let taken = matches!(self.cdt.locate(at), spade::PositionInTriangulation::OnVertex(_));
        !taken && self.cdt.insert(Site { at, node }).is_ok() && self.cdt.num_vertices() > count
    }

    /// The triangles of the strip: an odd number of fixed sides away from the outside.
    pub(super) fn triangles(&self) -> Vec<StripTriangle> {
        let mut odd: Vec<Option<bool>> = vec![None; self.cdt.num_all_faces()];
        odd[self.cdt.outer_face().index()] = Some(false);
        let hull = self.cdt.convex_hull().map(|edge| (edge.rev(), false));
        let mut ahead: Vec<_> = hull.collect();
        while let Some((edge, parity)) = ahead.pop() {
            let face = edge.face();
            if odd[face.index()].is_some() {
                continue;
            }
            let parity = parity != edge.is_constraint_edge();
            odd[face.index()] = Some(parity);
            if let Some(inner) = face.as_inner() {
                ahead.extend(inner.adjacent_edges().map(|edge| (edge.rev(), parity)));
            }
        }
        let inside = self.cdt.inner_faces().filter(|face| odd[face.index()] == Some(true));
        let triangle = |face: spade::handles::FaceHandle<'_, _, Site, _, _, _>| {
            let edges = face.adjacent_edges();
            StripTriangle {
                nodes: edges.map(|edge| edge.from().data().node),
                fixed: edges.map(DirectedEdgeHandle::is_constraint_edge),
                opposite: edges.map(|edge| Some(edge.rev().opposite_vertex()?.data().node)),
            }
        };
        inside.map(triangle).collect()
    }
}

/// A point that the triangulation accepts.
fn site(at: DVec2) -> Point2<f64> {
    let coordinate = |x: f64| if x.abs() < MIN_COORDINATE { 0.0 } else { x };
    Point2::new(coordinate(at.x), coordinate(at.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARES: [(f64, f64); 8] = [
        (0.0, 0.0),
        (3.0, 0.0),
        (3.0, 3.0),
        (0.0, 3.0),
        (1.0, 1.0),
        (2.0, 1.0),
        (2.0, 2.0),
        (1.0, 2.0),
    ];

    fn around(first: usize) -> impl Iterator<Item = [usize; 2]> {
        (0..4).map(move |k| [first + k, first + (k + 1) % 4])
    }

    #[test]
    fn the_strip_lies_between_the_fixed_sides() {
        let places = SQUARES.into_iter().map(DVec2::from);
        let fixed = around(0).chain(around(4)).collect();
        let strip = StripTriangulation::new(places, fixed, DVec2::new(2.0, 0.5)).unwrap();
        let triangles = strip.triangles();
        assert_eq!(triangles.len(), 8);
        let area = |triangle: &StripTriangle| {
            let [a, b, c] = triangle.nodes.map(|k| DVec2::from(SQUARES[k]));
            (b - a).perp_dot(c - a) / 2.0
        };
        assert_eq!(triangles.iter().map(area).sum::<f64>(), 8.0);
        assert_eq!(triangles.iter().flat_map(|t| t.fixed).filter(|fixed| *fixed).count(), 8);
    }

    #[test]
    fn sides_that_cross_are_reported() {
        let places = SQUARES.into_iter().map(DVec2::from);
        let found = StripTriangulation::new(places, vec![[0, 2], [1, 3]], DVec2::ONE).unwrap_err();
        assert!(found.contains(&[0, 2]) || found.contains(&[1, 3]));
    }
}
