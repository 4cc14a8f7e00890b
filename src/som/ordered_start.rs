//! Starts that are in order from the beginning: the principal plane, angles, and distances along
//! the surface.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::geodesic;
use super::initialize::evenly;
use super::lattice::{Lattice, Topology};
use super::options::{Kernel, Neighborhood};
use super::random::Random;
use super::smoothing::{Channels, smooth};
use super::{candidates::Candidates, eigen};
use crate::point_cloud::{self, Bounds};

/// Points that distances along the surface are found for; the cost grows with their square.
const UNROLLED: usize = 3000;

/// Points that the angles of a closed lattice are found for.
const TURNED: usize = 20_000;

/// Radius with which the first nodes of an open lattice listen to points around them on it, as a
/// share of its longer side. Wide enough for lattices with more nodes than points.
const OPEN_RADIUS: f64 = 1.0 / 6.0;

/// The same for closed lattices, which a wide radius would shrink around their axis: this one by
/// a tenth.
const CLOSED_RADIUS: f64 = 1.0 / 14.0;

/// Smallest such radius, in cells.
const LEAST_RADIUS: f64 = 0.8;

/// In order on the principal plane, over the whole extent of the points in it; closed lattices by
/// the points' angles about the principal axes.
pub(super) fn principal(points: &[DVec3], lattice: &Lattice) -> Vec<DVec3> {
    let frame = PrincipalFrame::of(points);
    if lattice.topology() != Topology::Sheet {
        return closed(points, lattice, &frame);
    }
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points
        .iter()
        .map(|&p| frame.apply(p))
        .fold(empty, |(low, high), p| (low.min(p), high.max(p)));
    let size = high - low;
    let place =
        |uv: DVec2| frame.undo(DVec3::new(low.x + uv.x * size.x, low.y + uv.y * size.y, 0.0));
    layout(lattice).into_iter().map(place).collect()
}

/// In order by distances along the surface; closed lattices as by [`principal`], whose angles go
/// along the surface too.
pub(super) fn geodesic(points: &[DVec3], lattice: &Lattice, random: &mut Random) -> Vec<DVec3> {
    if lattice.topology() != Topology::Sheet {
        return principal(points, lattice);
    }
    let mut sample = points.to_vec();
    if points.len() > UNROLLED {
        random.shuffle(&mut sample);
        sample.truncate(UNROLLED);
    }
    match geodesic::unroll(&sample) {
        Some(places) => {
            let low = places.iter().fold(DVec2::INFINITY, |low, &p| low.min(p));
            let high = places.iter().fold(DVec2::NEG_INFINITY, |high, &p| high.max(p));
            let uv: Vec<DVec2> = places.iter().map(|&p| (p - low) / (high - low)).collect();
            settle(&sample, &uv, lattice, OPEN_RADIUS)
        }
        None => principal(points, lattice),
    }
}

/// Nodes among points whose places in the unit square are known, each where the points around it
/// on the lattice say. The rows of a sheet lie along x.
///
/// # Panics
///
/// If there are no points.
#[must_use]
pub fn spread_out(points: &[DVec3], uv: &[DVec2], lattice: &Lattice) -> Vec<DVec3> {
    let closed = lattice.topology() != Topology::Sheet;
    settle(points, uv, lattice, if closed { CLOSED_RADIUS } else { OPEN_RADIUS })
}

/// A tube's or torus's start, by the points' angles.
///
/// The axis of a tube is the principal axis about which the points' distances vary least. A torus
/// turns about its flattest axis, and its section about the ring in the middle.
fn closed(points: &[DVec3], lattice: &Lattice, frame: &PrincipalFrame) -> Vec<DVec3> {
    let sample = evenly(points, TURNED);
    let local: Vec<DVec3> = sample.iter().map(|&p| frame.apply(p)).collect();
    let turn = |x: f64, y: f64| (y.atan2(x) / TAU).rem_euclid(1.0);
    let uv: Vec<DVec2> = if lattice.topology() == Topology::Torus {
        let bounds = local.iter().map(|p| p.truncate().length());
        let (low, high) = bounds.fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
        let ring = 0.5 * (low + high);
        let angles =
            |p: &DVec3| DVec2::new(turn(p.x, p.y), turn(p.truncate().length() - ring, p.z));
        local.iter().map(angles).collect()
    } else {
        let axis = roundest_axis(&local);
        let turned: Vec<DVec3> = local.iter().map(|&p| last(p, axis)).collect();
        let bounds = Bounds::of(&turned);
        let height = bounds.max.z - bounds.min.z;
        let along = |z: f64| if height > 0.0 { (z - bounds.min.z) / height } else { 0.5 };
        turned.iter().map(|p| DVec2::new(turn(p.x, p.y), along(p.z))).collect()
    };
    settle(&sample, &uv, lattice, CLOSED_RADIUS)
}

/// The axis about which distances vary least against their mean.
fn roundest_axis(points: &[DVec3]) -> usize {
    let variation = |axis: usize| {
        let radii = || points.iter().map(|&p| last(p, axis).truncate().length());
        let count = points.len() as f64;
        let mean = radii().sum::<f64>() / count;
        radii().map(|r| (r - mean).powi(2)).sum::<f64>() / count / (mean * mean)
    };
    let axes = (0..3).map(|axis| (axis, variation(axis)));
    axes.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(2, |(axis, _)| axis)
}

/// Turns coordinates round so that the axis becomes the last.
fn last(p: DVec3, axis: usize) -> DVec3 {
    DVec3::new(p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis])
}

/// Where nodes lie in the unit square: a grid's rows along x if there are more of them than
/// columns, so that the longer side gets more nodes; a graph as it is drawn.
fn layout(lattice: &Lattice) -> Vec<DVec2> {
    let (rows, cols) = lattice.shape();
    if lattice.is_grid() {
        let place = |node: usize| {
            let uv = DVec2::new(
                (node / cols) as f64 / (rows - 1) as f64,
                (node % cols) as f64 / (cols - 1) as f64,
            );
            if rows >= cols { uv } else { DVec2::new(uv.y, uv.x) }
        };
        return (0..lattice.len()).map(place).collect();
    }
    let drawn = geodesic::draw(lattice.len(), &lattice.edges());
    let in_line = || (0..lattice.len()).map(|i| DVec2::new(i as f64, 0.0)).collect();
    let places = drawn.unwrap_or_else(in_line);
    let low = places.iter().fold(DVec2::INFINITY, |low, &p| low.min(p));
    let high = places.iter().fold(DVec2::NEG_INFINITY, |high, &p| high.max(p));
    let size = high - low;
    let size = DVec2::select(size.cmpgt(DVec2::ZERO), size, DVec2::ONE);
    places.iter().map(|&p| (p - low) / size).collect()
}

/// Nodes among points whose places in the unit square are known: each node listens to the points
/// around it.
fn settle(points: &[DVec3], uv: &[DVec2], lattice: &Lattice, share: f64) -> Vec<DVec3> {
    let origin = points[0];
    let mut sums = vec![Channels::default(); lattice.len()];
    for (&point, node) in points.iter().zip(owners(uv, lattice)) {
        let local = point - origin;
        for (sum, value) in sums[node].iter_mut().zip([1.0, local.x, local.y, local.z]) {
            *sum += value;
        }
    }
    let (rows, cols) = lattice.shape();
    let side = if lattice.is_grid() { rows.max(cols) } else { lattice.diameter() };
    let mut radius = (share * side as f64).max(LEAST_RADIUS);
    let open_grid = lattice.as_graph().is_none() && lattice.topology() == Topology::Sheet;
    let kernel = if open_grid { Kernel::Linear } else { Kernel::Mean };
    loop {
        let places = smooth(lattice, &sums, Neighborhood::Gaussian, kernel, radius);
        let places: Option<Vec<DVec3>> = places.into_iter().collect();
        if let Some(places) = places {
            return places.into_iter().map(|place| place + origin).collect();
        }
        // A node so far from all points that their weights vanish.
        radius *= 2.0;
    }
}

/// The node nearest to each place in the unit square.
fn owners(uv: &[DVec2], lattice: &Lattice) -> Vec<usize> {
    if lattice.topology() == Topology::Sheet {
        let nodes: Vec<DVec3> = layout(lattice).into_iter().map(|p| p.extend(0.0)).collect();
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) };
        let tree = Candidates::new(&nodes, &bounds, uv.len(), 1);
        return uv.iter().map(|&p| tree.nearest(p.extend(0.0)).0).collect();
    }
    let (rows, cols) = lattice.shape();
    let (closed_u, closed_v) = lattice.topology().closed();
    let index = |along: f64, count: usize, closed: bool| {
        let cells = if closed { count } else { count - 1 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to the number of nodes"
        )]
        let index = (along * cells as f64).round() as usize;
        if closed { index % count } else { index.min(count - 1) }
    };
    uv.iter().map(|p| index(p.x, rows, closed_u) * cols + index(p.y, cols, closed_v)).collect()
}

/// The points' own axes: the directions in which they extend most, next, and least.
struct PrincipalFrame {
    centre: DVec3,
    axes: [DVec3; 3],
}

impl PrincipalFrame {
    fn of(points: &[DVec3]) -> Self {
        let centre = point_cloud::centroid(points);
        let mut covariance = [0.0; 9];
        for &point in points {
            let p = point - centre;
            for (row, value) in p.to_array().into_iter().enumerate() {
                for (col, other) in p.to_array().into_iter().enumerate() {
                    covariance[3 * row + col] += value * other;
                }
            }
        }
        let pairs = eigen::symmetric(covariance.to_vec(), 3);
        let axis = |number: usize| DVec3::from_slice(&pairs[number].1);
        // Each axis points to where its largest coordinate is positive, so that the frame does not
        // depend on the sense that the rotations happen to end with.
        let point_up = |axis: DVec3| {
            let largest = axis.abs().max_position();
            if axis[largest] < 0.0 { -axis } else { axis }
        };
        let (first, second) = (point_up(axis(0)), point_up(axis(1)));
        Self { centre, axes: [first, second, first.cross(second)] }
    }

    fn apply(&self, point: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(point - self.centre)))
    }

    fn undo(&self, local: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.centre + local.x * x + local.y * y + local.z * z
    }
}
