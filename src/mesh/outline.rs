//! The loops of a face as polygons in (u, v).

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::edge_points::EdgePoints;
use crate::brep::Shell;
use crate::nurbs::NurbsCurve;

/// Height of the parabola that replaces a slanted straight line, as a share of its length. Above
/// rounding for thousands of points, and far below any tolerance.
const BEND: f64 = 1e-9;

/// Where a corner of a face's triangles comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Origin {
    /// A vertex of the shell.
    Vertex(usize),
    /// A point inside an edge of the shell: the edge and the index of the point.
    Edge(usize, usize),
    /// A point inside the face.
    Inside,
}

/// A corner of a face's triangles. Several may be one vertex of the mesh: at poles and seams.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub uv: DVec2,
    pub point: DVec3,
    pub origin: Origin,
}

/// A side of a loop's polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub nodes: [usize; 2],
    /// The edge and the index of its chord; `None` at a pole.
    pub chord: Option<(usize, usize)>,
    /// How far the curve is from this side, in lengths like those in space.
    pub bulge: f64,
}

/// The loops of a face.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    pub nodes: Vec<Node>,
    pub sides: Vec<Side>,
}

impl Outline {
    /// The polygons of a face in a shell; `at_poles` are parameters at which sides at poles are
    /// divided.
    pub(super) fn new(
        shell: &Shell,
        face: usize,
        edges: &[EdgePoints],
        at_poles: &[DVec2],
    ) -> Self {
        let mut this = Self::default();
        for (in_loop, coedges) in shell.coedges(face).iter().enumerate() {
            let first = this.nodes.len();
            for (place, coedge) in coedges.iter().enumerate() {
                let Some(edge) = coedge.edge else {
                    let ends = [0, coedge.curve.control_points().len() - 1];
                    let ends = ends.map(|k| coedge.curve.control_points()[k].truncate());
                    let point = shell.vertices()[coedge.vertex];
                    this.add_pole((coedge.vertex, point), ends, at_poles);
                    continue;
                };
                let uses = &shell.edges()[edge].uses;
                let here = |used: &crate::brep::EdgeUse| {
                    (used.face, used.in_loop, used.place) == (face, in_loop, place)
                };
                let used = uses.iter().position(here).unwrap_or(0);
                let divided = &edges[edge];
                let last = divided.points.len() - 1;
                for step in 0..last {
                    let k = if coedge.forward { step } else { last - step };
                    let chord = if coedge.forward { step } else { last - step - 1 };
                    let origin = if step == 0 {
                        Origin::Vertex(coedge.vertex)
                    } else {
                        Origin::Edge(edge, k)
                    };
                    let share = step as f64 / last as f64;
                    let uv = divided.points[k].uv[used] + bend(&coedge.curve, share);
                    let point = divided.points[k].point;
                    let bulge = divided.bulges[chord][used];
                    this.add(Node { uv, point, origin }, Some((edge, chord)), bulge);
                }
            }
            if let Some(side) = this.sides.last_mut() {
                side.nodes[1] = first;
            }
        }
        this
    }

    /// Adds a node with the side that begins there.
    fn add(&mut self, node: Node, chord: Option<(usize, usize)>, bulge: f64) {
        let k = self.nodes.len();
        self.nodes.push(node);
        self.sides.push(Side { nodes: [k, k + 1], chord, bulge });
    }

    /// Adds the nodes along a pole.
    fn add_pole(
        &mut self,
        (vertex, point): (usize, DVec3),
        [from, to]: [DVec2; 2],
        at_poles: &[DVec2],
    ) {
        let along = to - from;
        let near = f64::EPSILON * (from.abs() + to.abs()).max_element();
        let share = |uv: &DVec2| {
            let share = (uv - from).dot(along) / along.length_squared();
            let on_line = (from + share * along).distance(*uv) <= 4.0 * near;
            (on_line && 0.0 < share && share < 1.0).then_some(share)
        };
        let mut shares: Vec<f64> = at_poles.iter().filter_map(share).collect();
        shares.push(0.0);
        shares.sort_by(f64::total_cmp);
        shares.dedup();
        for share in shares {
            let origin = Origin::Vertex(vertex);
            self.add(Node { uv: from + share * along, point, origin }, None, 0.0);
        }
    }

    /// Whether a point lies inside, by the even-odd rule.
    pub(super) fn contains(&self, at: DVec2) -> bool {
        let crosses = |side: &Side| {
            let [a, b] = side.nodes.map(|k| self.nodes[k].uv);
            (a.y <= at.y) != (b.y <= at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        self.sides.iter().filter(|side| crosses(side)).count() % 2 == 1
    }

    /// The chords of the sides that cross one of some sides, these included.
    pub(super) fn crossing(&self, sides: &[[usize; 2]]) -> BTreeSet<(usize, usize)> {
        let uv = |nodes: [usize; 2]| nodes.map(|k| self.nodes[k].uv);
        let crossed = |side: &&Side| {
            sides.iter().any(|other| {
                let same = |k: usize| other.contains(&side.nodes[k]);
                same(0) && same(1) || !same(0) && !same(1) && cross(uv(side.nodes), uv(*other))
            })
        };
        self.sides.iter().filter(crossed).filter_map(|side| side.chord).collect()
    }
}

/// Moves points of a slanted straight line into the face by a parabola, more than rounding does.
///
/// Points that rounding moves out of the face would span slivers with their neighbors.
fn bend(curve: &NurbsCurve, share: f64) -> DVec2 {
    let &[from, to] = curve.control_points() else { return DVec2::ZERO };
    let along = (to - from).truncate();
    if along.x == 0.0 || along.y == 0.0 {
        return DVec2::ZERO;
    }
    BEND * share * (1.0 - share) * along.perp()
}

/// Whether two segments meet.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}
