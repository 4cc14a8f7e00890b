//! Samplings of shapes, and the surface on which they lie.

use std::f64::consts::TAU;
use std::sync::Arc;

use neurbs::nurbs::{KnotVector, NurbsSurface};
use neurbs::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::shapes::{Shape, inside};

/// A random number generator.
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    pub(crate) fn number(&mut self) -> f64 {
        self.0.random()
    }

    /// A point from the standard normal distribution (G. E. P. Box and M. E. Muller 1958).
    pub(crate) fn normal(&mut self) -> DVec2 {
        let radius = (-2.0 * (1.0 - self.number()).ln()).sqrt();
        radius * DVec2::from_angle(TAU * self.number())
    }

    /// A point in the unit square.
    pub(crate) fn point(&mut self) -> DVec2 {
        DVec2::new(self.number(), self.number())
    }
}

/// How points are distributed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sampling {
    Random,
    /// A rotated grid.
    Grid,
    /// The density falls tenfold along x.
    Falling,
    /// Scan lines that are six steps apart.
    Lines,
}

impl Sampling {
    /// About `count` points in a shape.
    pub(crate) fn points(self, shape: &Shape, count: usize, random: &mut Random) -> Vec<DVec2> {
        let spacing = shape.spacing(count);
        match self {
            Self::Random => scattered(shape, count, random, |_| 1.0),
            Self::Falling => scattered(shape, count, random, |x| 0.1_f64.powf(x)),
            Self::Grid => lattice(shape, DVec2::splat(spacing), 0.3, random),
            Self::Lines => {
                lattice(shape, spacing * DVec2::new(1.0 / 6_f64.sqrt(), 6_f64.sqrt()), 0.0, random)
            }
        }
    }
}

/// Random points; the density depends on x.
fn scattered(
    shape: &Shape,
    count: usize,
    random: &mut Random,
    density: impl Fn(f64) -> f64,
) -> Vec<DVec2> {
    let mut points = vec![];
    while points.len() < count {
        let at = random.point();
        if inside(&shape.rings, at) && random.number() < density(at.x) {
            points.push(at);
        }
    }
    points
}

/// A lattice with these steps, rotated, at a random offset.
fn lattice(shape: &Shape, step: DVec2, angle: f64, random: &mut Random) -> Vec<DVec2> {
    let offset = random.point() * step;
    #[expect(clippy::cast_possible_truncation, reason = "some hundreds")]
    let range = (2.0 / step.min_element()).ceil() as i32;
    let at = |i: i32, j: i32| {
        let at = DVec2::new(f64::from(i), f64::from(j)) * step;
        DVec2::from_angle(angle).rotate(at) + offset + 0.5
    };
    let all = (-range..range).flat_map(|i| (-range..range).map(move |j| at(i, j)));
    let box_ = |at: &DVec2| at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::ONE).all();
    all.filter(box_).filter(|at| inside(&shape.rings, *at)).collect()
}

/// The box around points, with a margin.
pub(crate) fn grown_box(points: &[DVec2], margin: f64) -> (DVec2, DVec2) {
    let low = points.iter().copied().reduce(DVec2::min).unwrap();
    let high = points.iter().copied().reduce(DVec2::max).unwrap();
    (low - margin, high + margin)
}

/// A wavy height field whose parameters are x and y.
pub(crate) fn sheet((low, high): (DVec2, DVec2)) -> Arc<NurbsSurface> {
    let knots = KnotVector::clamped_uniform(3, 14).unwrap();
    let places = knots.greville();
    let height = |at: DVec2| 0.08 * (3.0 * at.x).sin() * (2.0 * at.y).cos();
    let at = |u: &f64, v: &f64| low + (high - low) * DVec2::new(*u, *v);
    let net: Vec<DVec3> = places
        .iter()
        .flat_map(|u| places.iter().map(move |v| at(u, v)))
        .map(|at| at.extend(height(at)))
        .collect();
    let surface = NurbsSurface::new(net, None, knots.clone(), knots).unwrap();
    Arc::new(surface.with_domain((low.x, high.x), (low.y, high.y)).unwrap())
}
