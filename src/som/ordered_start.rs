//! Ordered initial positions: on the principal plane, by angles, or by distances along the surface.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::eigen;
use super::geodesic;
use super::lattice::Lattice;
use super::nearest_lists::NearestLists;
use super::node_sums::Channels;
use super::octree::Octree;
use super::options::{Kernel, Neighborhood};
use super::random::Random;
use super::sampling::{place_nodes, subsample};
use super::smoothing::smooth;
use super::topology::{Cells, Topology};
use crate::cloud::{self, Bounds};
use crate::error::Result;
use crate::progress::{self, InterruptCheck, Observer, Stage};

/// Largest number of points whose distances along the surface are computed.
const MAX_GEODESIC_SAMPLE: usize = 3000;

/// Largest number of points whose angles are computed for a closed lattice.
const MAX_ANGLE_SAMPLE: usize = 20_000;

/// Smoothing radius of an open lattice's initial positions, as a share of its longer side. It
/// suffices for lattices with more nodes than points.
const OPEN_RADIUS: f64 = 1.0 / 6.0;

/// Smoothing radius of a closed lattice. A wider one would shrink the lattice around its axis; this
/// one shrinks it by a tenth.
const CLOSED_RADIUS: f64 = 1.0 / 14.0;

/// Smallest smoothing radius, in cells.
const MIN_RADIUS: f64 = 0.8;

/// Ordered on the principal plane, over the whole extent of the points. Closed lattices are ordered
/// by the points' angles about the principal axes.
pub(super) fn principal(
    points: &[DVec3],
    lattice: &Lattice,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec3>> {
    let frame = PrincipalFrame::of(points, check_interrupt)?;
    if lattice.topology() != Topology::Sheet {
        return closed(points, lattice, &frame, check_interrupt);
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for piece in cloud::batches(points, check_interrupt) {
        for &point in piece? {
            let local = frame.apply(point);
            (low, high) = (low.min(local), high.max(local));
        }
    }
    let size = high - low;
    let layout = Layout::of(lattice, check_interrupt)?;
    place_nodes(lattice.len(), check_interrupt, |node| {
        let uv = layout.place(node);
        frame.undo(DVec3::new(low.x + uv.x * size.x, low.y + uv.y * size.y, 0.0))
    })
}

/// Ordered by distances along the surface. Closed lattices as in [`principal`].
pub(super) fn geodesic(
    points: &[DVec3],
    lattice: &Lattice,
    random: &mut Random,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec3>> {
    if lattice.topology() != Topology::Sheet {
        return principal(points, lattice, check_interrupt);
    }
    let chosen = random.sample(points.len().min(MAX_GEODESIC_SAMPLE), points.len());
    let sample: Vec<DVec3> = chosen.into_iter().map(|index| points[index]).collect();
    match geodesic::unroll_listening(&sample, check_interrupt)? {
        Some(places) => {
            let uv = in_unit_square(&places);
            smoothed_nodes(&sample, &uv, lattice, radius(lattice, OPEN_RADIUS), check_interrupt)
        }
        None => principal(points, lattice, check_interrupt),
    }
}

/// Node positions for points with known coordinates in the unit square. Each node is a smoothed
/// mean of the points around it on the lattice. On an open grid x runs along the longer side; on a
/// closed one x runs around the rows and y around the columns.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
///
/// # Panics
///
/// If `points` is empty.
pub fn spread_out(
    points: &[DVec3],
    uv: &[DVec2],
    lattice: &Lattice,
    observer: &mut dyn Observer,
) -> Result<Vec<DVec3>> {
    let closed = lattice.topology() != Topology::Sheet;
    let share = if closed { CLOSED_RADIUS } else { OPEN_RADIUS };
    let mut check_interrupt = progress::interrupt_check(observer, Stage::Training, points.len());
    smoothed_nodes(points, uv, lattice, radius(lattice, share), &mut check_interrupt)
}

/// The start of a tube or torus, by the points' angles.
///
/// A tube's axis is the principal axis about which the points' radii vary least. A torus turns
/// about the axis of least extent; its section turns about the circle in the middle.
fn closed(
    points: &[DVec3],
    lattice: &Lattice,
    frame: &PrincipalFrame,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec3>> {
    let sample = subsample(points, MAX_ANGLE_SAMPLE);
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
    smoothed_nodes(&sample, &uv, lattice, radius(lattice, CLOSED_RADIUS), check_interrupt)
}

/// The axis about which the radii vary least relative to their mean.
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

/// Permutes coordinates cyclically so that `axis` becomes the last.
fn last(p: DVec3, axis: usize) -> DVec3 {
    DVec3::new(p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis])
}

/// Node coordinates in the unit square.
enum Layout {
    /// A grid has the longer of its sides along x.
    Grid { rows: usize, cols: usize },
    /// A graph has coordinates by Isomap.
    Embedded(Vec<DVec2>),
}

impl Layout {
    fn of(lattice: &Lattice, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let (rows, cols) = lattice.shape();
        if lattice.is_grid() {
            return Ok(Self::Grid { rows, cols });
        }
        let drawn = geodesic::draw_graph(lattice.len(), &lattice.edges(), check_interrupt)?;
        let in_line = || (0..lattice.len()).map(|i| DVec2::new(i as f64, 0.0)).collect();
        Ok(Self::Embedded(in_unit_square(&drawn.unwrap_or_else(in_line))))
    }

    fn place(&self, node: usize) -> DVec2 {
        match *self {
            Self::Grid { rows, cols } => {
                let u = (node / cols) as f64 / (rows - 1) as f64;
                let v = (node % cols) as f64 / (cols - 1) as f64;
                if rows >= cols { DVec2::new(u, v) } else { DVec2::new(v, u) }
            }
            Self::Embedded(ref places) => places[node],
        }
    }

    /// The node nearest to each place of the unit square. On a closed lattice x runs around the
    /// rows and y around the columns.
    fn owners(
        &self,
        uv: &[DVec2],
        lattice: &Lattice,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Vec<usize>> {
        match *self {
            Self::Grid { rows, cols } => {
                let (closed_u, closed_v) = lattice.topology().closed();
                let turned = lattice.topology() == Topology::Sheet && rows < cols;
                let owner = |place: &DVec2| {
                    let (u, v) = if turned { (place.y, place.x) } else { (place.x, place.y) };
                    nearest(u, rows, closed_u) * cols + nearest(v, cols, closed_v)
                };
                Ok(uv.iter().map(owner).collect())
            }
            Self::Embedded(ref places) => {
                let nodes: Vec<DVec3> = places.iter().map(|p| p.extend(0.0)).collect();
                let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) };
                let boxes = Octree::new(&bounds, uv.len(), nodes.len());
                let tree = NearestLists::new(&nodes, boxes, 1, check_interrupt)?;
                let mut lookup = tree.lookup();
                Ok(uv.iter().map(|&p| lookup.nearest(p.extend(0.0)).0).collect())
            }
        }
    }
}

/// The nearest of `count` nodes on a line or ring of length 1.
fn nearest(along: f64, count: usize, closed: bool) -> usize {
    let cells = if closed { count } else { count - 1 };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to the number of nodes"
    )]
    let index = (along * cells as f64).round() as usize;
    if closed { index % count } else { index.min(count - 1) }
}

/// Scales coordinates to fill the unit square. A direction without extent is only shifted.
fn in_unit_square(places: &[DVec2]) -> Vec<DVec2> {
    let low = places.iter().fold(DVec2::INFINITY, |low, &p| low.min(p));
    let high = places.iter().fold(DVec2::NEG_INFINITY, |high, &p| high.max(p));
    let size = high - low;
    let size = DVec2::select(size.cmpgt(DVec2::ZERO), size, DVec2::ONE);
    places.iter().map(|&p| (p - low) / size).collect()
}

/// This share of the longer side, in cells, and at least [`MIN_RADIUS`].
fn radius(lattice: &Lattice, share: f64) -> f64 {
    let (rows, cols) = lattice.shape();
    let side = if lattice.is_grid() { rows.max(cols) } else { lattice.diameter() };
    (share * side as f64).max(MIN_RADIUS)
}

/// Node positions for points with known coordinates in the unit square: smoothed means of the
/// points around each node.
fn smoothed_nodes(
    points: &[DVec3],
    uv: &[DVec2],
    lattice: &Lattice,
    mut radius: f64,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec3>> {
    let origin = points[0];
    let mut sums = vec![Channels::default(); lattice.len()];
    let owners = Layout::of(lattice, check_interrupt)?.owners(uv, lattice, check_interrupt)?;
    for (&point, node) in points.iter().zip(owners) {
        let local = point - origin;
        for (sum, value) in sums[node].iter_mut().zip([1.0, local.x, local.y, local.z]) {
            *sum += value;
        }
    }
    let open_grid = lattice.cells() == Some(Cells::Quad) && lattice.topology() == Topology::Sheet;
    let kernel = if open_grid { Kernel::Linear } else { Kernel::Mean };
    loop {
        let places =
            smooth(lattice, &sums, Neighborhood::Gaussian, kernel, radius, check_interrupt)?;
        let places: Option<Vec<DVec3>> = places.into_iter().collect();
        if let Some(places) = places {
            return Ok(places.into_iter().map(|place| place + origin).collect());
        }
        // Some node is so far from all points that the weights vanish.
        radius *= 2.0;
    }
}

/// The principal axes of the points, by decreasing extent.
struct PrincipalFrame {
    center: DVec3,
    axes: [DVec3; 3],
}

impl PrincipalFrame {
    fn of(points: &[DVec3], check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let center = cloud::interruptible_centroid(points, check_interrupt)?;
        let mut covariance = [0.0; 9];
        for piece in cloud::batches(points, check_interrupt) {
            for &point in piece? {
                let p = (point - center).to_array();
                for (place, sum) in covariance.iter_mut().enumerate() {
                    *sum += p[place / 3] * p[place % 3];
                }
            }
        }
        let pairs = eigen::symmetric(covariance.to_vec(), 3);
        let axis = |number: usize| DVec3::from_slice(&pairs[number].1);
        // Each axis is oriented so that its largest coordinate is positive: the result does not
        // depend on the signs that the eigensolver returns.
        let point_up = |axis: DVec3| {
            let largest = axis.abs().max_position();
            if axis[largest] < 0.0 { -axis } else { axis }
        };
        let (first, second) = (point_up(axis(0)), point_up(axis(1)));
        Ok(Self { center, axes: [first, second, first.cross(second)] })
    }

    fn apply(&self, point: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(point - self.center)))
    }

    fn undo(&self, local: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.center + local.x * x + local.y * y + local.z * z
    }
}
