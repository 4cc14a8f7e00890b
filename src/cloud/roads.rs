//! The ways between points along a surface whose folds may be close to one another.

use glam::DVec3;
use rayon::prelude::*;

use super::kd_tree::KdTree;
use super::neighbor_graph::{Edge, Front, NeighborGraph};
use super::plane::Plane;
use crate::error::Result;
use crate::progress::Listen;

/// Each point is joined to this many nearest ones: enough to hang together, too few to reach the
/// next fold.
const NEIGHBORS: usize = 8;

/// An edge leaves the planes at both its ends, which lie alike, to the same side at more than this
/// product of sines, 24 degrees at both, only if it leads to another fold. One across a bend leaves them
/// to opposite sides.
const STEEP: f64 = 0.16;

/// The same for an edge with a plane at one end only: 45 degrees.
const STEEP_AT_ONE: f64 = 0.5;

/// The same for an edge that is short, 60 degrees at both: across a crease or a step there are such.
const STEEP_IF_SHORT: f64 = 0.75;

/// Rank of the neighbour whose distance is the spacing at a point, and how many spacings long an edge is
/// at most that is short.
const SPACING: usize = 3;
const SHORT: f64 = 1.3;

/// Share of the second principal deviation of neighbours in the third below which they lie in a plane; and
/// least share of the first in the second: the plane of a curve, as points along a scan line are, is not
/// that of the surface.
const FLAT: f64 = 0.3;
const BROAD: f64 = 0.2;

/// Points whose nearest ones are found between two reports: a few milliseconds.
const POINTS_PER_REPORT: usize = 1024;

/// The ways between points along a surface.
pub(crate) struct Roads {
    pub(crate) graph: NeighborGraph,
    /// How many ways to nearest neighbours were looked at.
    pub(crate) ways: usize,
    /// Which of them are not taken, as they seem to lead to another fold, and from where.
    pub(crate) crossing: Vec<(usize, Edge)>,
}

impl Roads {
    /// Joins each point to its nearest ones, but not to another fold of the cloud that they are of, and pieces
    /// by their shortest bridge.
    pub(crate) fn of(points: &[DVec3], cloud: &[DVec3], listen: &mut Listen<'_>) -> Result<Self> {
        let (tree, of_cloud) = (KdTree::new(points), KdTree::new(cloud));
        let look = |from: u32| -> (Vec<Edge>, Option<DVec3>) {
            let mut found = Vec::new();
            of_cloud.nearest_where(
                points[from as usize],
                NEIGHBORS,
                f64::INFINITY,
                &mut found,
                |_| true,
            );
            let plane = Plane::of(found.iter().map(|near| cloud[near.index as usize]));
            let [long, wide, thick] = plane.deviations;
            let normal = (thick < FLAT * wide && wide > BROAD * long).then(|| plane.normal());
            tree.nearest_to(from, NEIGHBORS, &mut found);
            (found.iter().map(Edge::from).collect(), normal)
        };
        let all: Vec<u32> = (0..).zip(points).map(|(index, _)| index).collect();
        let mut seen: Vec<(Vec<Edge>, Option<DVec3>)> = Vec::with_capacity(points.len());
        for piece in all.chunks(POINTS_PER_REPORT) {
            listen()?;
            seen.par_extend(piece.par_iter().map(|&from| look(from)));
        }
        let leaves = |from: usize, edge: &Edge| {
            let to = edge.to as usize;
            let spacing = |at: usize| seen[at].0.get(SPACING - 1).map_or(0.0, |edge| edge.length);
            let short = edge.length <= SHORT * spacing(from).min(spacing(to));
            crosses(points[to] - points[from], short, seen[from].1, seen[to].1)
        };
        let parted = |(from, (edges, _)): (usize, &(Vec<Edge>, _))| -> (Vec<Edge>, Vec<Edge>) {
            edges.iter().partition(|edge| !leaves(from, edge))
        };
        let ways = seen.iter().map(|(edges, _)| edges.len()).sum();
        let (mut lists, others): (Vec<_>, Vec<_>) = seen.par_iter().enumerate().map(parted).unzip();
        let from_all = (0..).zip(others);
        let crossing =
            from_all.flat_map(|(from, ways)| ways.into_iter().map(move |way| (from, way)));
        let crossing = crossing.collect();
        let apart = NeighborGraph::symmetric(lists.clone());
        for (from, to) in bridges(points, &apart, listen)? {
            let length = points[from].distance(points[to]);
            lists[from].push(Edge { to: u32::try_from(to).unwrap_or(u32::MAX), length });
        }
        Ok(Self { graph: NeighborGraph::symmetric(lists), ways, crossing })
    }
}

/// Whether a way between points, short or not, at which the surface has these normals as far as they are
/// known, leads to another fold.
fn crosses(way: DVec3, short: bool, from: Option<DVec3>, to: Option<DVec3>) -> bool {
    let squared = way.length_squared();
    match (from, to) {
        (Some(from), Some(to)) => {
            let alike = from.dot(to).signum();
            let steep = if short { STEEP_IF_SHORT } else { STEEP };
            alike * from.dot(way) * to.dot(way) > steep * squared
        }
        (Some(normal), None) | (None, Some(normal)) => {
            !short && normal.dot(way).powi(2) > STEEP_AT_ONE * squared
        }
        (None, None) => false,
    }
}

/// The shortest ways by which all pieces hang together (Prim's algorithm): each joins the nearest piece to
/// those that hang together with point 0 already.
fn bridges(
    points: &[DVec3],
    roads: &NeighborGraph,
    listen: &mut Listen<'_>,
) -> Result<Vec<(usize, usize)>> {
    let mut distances = vec![f64::INFINITY; points.len()];
    let mut piece_of = vec![0; points.len()];
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    let mut front = Front::default();
    for seed in (0..).take(points.len()) {
        if distances[seed as usize].is_infinite() {
            roads.walk(&[seed], f64::INFINITY, &mut distances, &mut front);
            let mut members: Vec<usize> = front.reached.iter().map(|&node| node as usize).collect();
            members.sort_unstable();
            for &member in &members {
                piece_of[member] = pieces.len();
            }
            pieces.push(members);
        }
    }
    // The shortest way from the pieces joined so far, squared, and its start, for each of the others' points.
    let mut others: Vec<(usize, f64, usize)> = (0..points.len())
        .filter(|&to| piece_of[to] != 0)
        .map(|to| (to, f64::INFINITY, usize::MAX))
        .collect();
    let (mut bridges, mut last) = (Vec::new(), 0);
    while !others.is_empty() {
        listen()?;
        others.par_iter_mut().for_each(|(to, length, start)| {
            for &from in &pieces[last] {
                let way = points[from].distance_squared(points[*to]);
                if (way, from) < (*length, *start) {
                    (*length, *start) = (way, from);
                }
            }
        });
        let order = |a: &&(usize, f64, usize), b: &&(usize, f64, usize)| {
            a.1.total_cmp(&b.1).then(a.2.cmp(&b.2)).then(a.0.cmp(&b.0))
        };
        let Some(&(to, _, from)) = others.iter().min_by(order) else { break };
        bridges.push((from, to));
        last = piece_of[to];
        others.retain(|other| piece_of[other.0] != last);
    }
    Ok(bridges)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_from_fold_to_fold_is_told_from_one_across_a_bend() {
        let sideways =
            |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let up = Some(DVec3::Z);
        // Straight up from a level place to another, whichever sides their normals are on.
        assert!(crosses(2.0 * DVec3::Z, true, up, up));
        assert!(crosses(DVec3::Z, true, up, Some(-DVec3::Z)));
        assert!(crosses(DVec3::new(0.6, 0.0, 1.0), false, up, None));
        // A chord over a ridge of 80 degrees, and a way down a step.
        let ridge = crosses(DVec3::X, false, Some(sideways(-40.0)), Some(sideways(40.0)));
        let step = crosses(DVec3::new(1.0, 0.0, 1.0), true, up, up);
        let unknown = crosses(DVec3::Z, false, None, None);
        assert!(!ridge && !step && !unknown);
    }

    #[test]
    fn each_piece_is_joined_to_the_nearest_one_before() {
        let pair = |x: f64| [DVec3::X * x, DVec3::new(x + 1.0, 0.0, 0.0)];
        let points: Vec<DVec3> = [0.0, 20.0, 9.0, 50.0].into_iter().flat_map(pair).collect();
        let edge = |to: u32| vec![Edge { to, length: 1.0 }];
        let lists = (0..8).map(|i: u32| edge(i ^ 1)).collect();
        let pieces = NeighborGraph::symmetric(lists);
        let found = bridges(&points, &pieces, &mut || Ok(())).unwrap();
        assert_eq!(found, [(1, 4), (5, 2), (3, 6)]);
    }

    #[test]
    fn pieces_are_bridged() {
        let square =
            |x: f64| (0..20).map(move |i| DVec3::new(x + f64::from(i % 5), f64::from(i / 5), 0.0));
        let points: Vec<DVec3> = square(0.0).chain(square(30.0)).collect();
        let distances =
            Roads::of(&points, &points, &mut || Ok(())).unwrap().graph.distances_from(&[0]);
        assert!(distances.iter().all(|d| d.is_finite()));
    }
}
