//! How well faces match shapes.

use neurbs::trim::Trim;
use neurbs::{DVec2, Face};

use super::shapes::Shape;

/// Farthest that a found corner lies from a true one, in spacings.
const NEAR: f64 = 3.5;

/// How well a face matches a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measures {
    /// Area of the symmetric difference over perimeter and spacing.
    pub(crate) error: f64,
    pub(crate) faces: usize,
    pub(crate) holes: usize,
    pub(crate) true_holes: usize,
    /// True corners that were found.
    pub(crate) corners: usize,
    pub(crate) true_corners: usize,
    pub(crate) false_corners: usize,
}

impl Measures {
    pub(crate) fn of(made: &Trim, shape: &Shape, count: usize) -> Self {
        let spacing = shape.spacing(count);
        let rings = rings(made);
        let joints = joints(made);
        let near = |a: &DVec2, b: &DVec2| a.distance(*b) < NEAR * spacing;
        let found = |corner: &&DVec2| joints.iter().any(|joint| near(joint, corner));
        let wrong = |joint: &&DVec2| !shape.corners.iter().any(|corner| near(joint, corner));
        Self {
            error: difference(&rings, &shape.rings) / (perimeter(&shape.rings) * spacing),
            faces: made.faces.len(),
            holes: rings.len() - made.faces.len(),
            true_holes: shape.rings.len() - 1,
            corners: shape.corners.iter().filter(found).count(),
            true_corners: shape.corners.len(),
            false_corners: joints.iter().filter(wrong).count(),
        }
    }
}

/// The loops of all faces as polygons.
pub(crate) fn rings(made: &Trim) -> Vec<Vec<DVec2>> {
    let loops = made.faces.iter().flat_map(Face::loops);
    let polygon = |of: &neurbs::brep::Loop| {
        let curves = of.curves().iter();
        let points = curves.flat_map(|curve| {
            let (from, to) = curve.knots().domain();
            let count = 8 * curve.control_points().len();
            (0..count)
                .map(move |k| from + (to - from) * k as f64 / count as f64)
                .map(|at| curve.point(at).truncate())
        });
        points.collect()
    };
    loops.map(polygon).collect()
}

/// Where curves of a loop meet at more than 20 degrees.
fn joints(made: &Trim) -> Vec<DVec2> {
    let mut joints = vec![];
    for of in made.faces.iter().flat_map(Face::loops) {
        let curves = of.curves();
        for (k, curve) in curves.iter().enumerate() {
            let ends = curve.control_points();
            let next = curves[(k + 1) % curves.len()].control_points();
            let (along, ahead) = (ends[ends.len() - 1] - ends[ends.len() - 2], next[1] - next[0]);
            if along.angle_between(ahead).to_degrees() > 20.0 {
                joints.push(next[0].truncate());
            }
        }
    }
    joints
}

fn sides(rings: &[Vec<DVec2>]) -> impl Iterator<Item = (DVec2, DVec2)> {
    rings.iter().flat_map(|ring| (0..ring.len()).map(|k| (ring[k], ring[(k + 1) % ring.len()])))
}

fn perimeter(rings: &[Vec<DVec2>]) -> f64 {
    sides(rings).map(|(a, b)| a.distance(b)).sum()
}

/// The area inside rings, holes left out.
pub(crate) fn area(rings: &[Vec<DVec2>]) -> f64 {
    difference(rings, &[])
}

/// Where a line of constant y crosses rings, in order.
pub(crate) fn crossings(rings: &[Vec<DVec2>], y: f64) -> Vec<f64> {
    let crossed = sides(rings).filter(|(a, b)| (a.y > y) != (b.y > y));
    let mut found: Vec<f64> =
        crossed.map(|(a, b)| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)).collect();
    found.sort_by(f64::total_cmp);
    found
}

/// The area that is inside of one shape and outside of the other.
fn difference(a: &[Vec<DVec2>], b: &[Vec<DVec2>]) -> f64 {
    const ROWS: u32 = 1000;
    let heights = || a.iter().chain(b).flatten().map(|at| at.y);
    let (low, high) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let step = (high - low) / f64::from(ROWS);
    let row = |k: u32| {
        let y = low + step * (f64::from(k) + 0.5);
        // Each crossing of either shape turns the difference on or off.
        let mut all = crossings(a, y);
        all.extend(crossings(b, y));
        all.sort_by(f64::total_cmp);
        all.chunks_exact(2).map(|pair| pair[1] - pair[0]).sum::<f64>() * step
    };
    (0..ROWS).map(row).sum()
}
