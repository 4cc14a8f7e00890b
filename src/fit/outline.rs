//! The closed smooth line at which the points of a sheet without corners end.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::edge::{NOTCHED, empty_ground, lowest};
use super::likelihood::{DEGREE, Likelihood, height, sums, weighted};
use super::patches::Patches;
use crate::error::Result;
use crate::nurbs::{Basis, KnotVector, NurbsSurface, gauss};

/// Width and height of the square's corners, the share of the mean density of places that an empty
/// one has less than, and how many places it would have at that density for this to be said.
const CORNER: f64 = 0.2;
const EMPTY: f64 = 0.5;
const TELLING: f64 = 12.0;

/// Corners that are empty, at least, where an outline is round: another one may be full where places
/// are dense.
const EMPTY_CORNERS: usize = 3;

/// Control points of a line, and what its bending may cost: the likeliest counts (see
/// [`Likelihood::stiffness`]). The search begins with one in the middle.
const CONTROL_POINTS: usize = 16;
const STIFFNESSES: [f64; 5] = [30.0, 3.0, 0.3, 0.03, 0.003];

/// A line stays between these heights: its distance from the middle, squared, is 1 less the height
/// times the mean.
const BOUNDS: (f64, f64) = (-2.0, 0.9);

/// Scale of the blur that the search begins with.
const FIRST_SCALE: f64 = 0.2;

/// Depth of the ground behind a line whose places say how dense they are there, and their least
/// density, as a share of the mean.
const GROUND: f64 = 0.3;
const SPARSEST: f64 = 0.1;

/// How far a surface goes on beyond an outline for each spacing of border that is asked for: so many
/// standard deviations of where it lies.
const BEYOND: f64 = 2.5;

/// Spacings of the points, and sizes of the noise in them, that a place may lie outside of a smooth
/// outline.
const OUTSIDE: (f64, f64) = (0.25, 4.0);

/// Sectors around the middle whose outermost places tell how far places reach.
const SECTORS: usize = 24;

/// Control points of an outline in the square.
const RADII: usize = 64;

/// Places along a ray at which its length is measured.
const RAY_PLACES: usize = 8;

/// Steps towards the place on a ray at a given length, and of Newton's method towards a place inside
/// an outline; and the square of the move at which these end.
const RAY_STEPS: usize = 5;
const STEPS: usize = 12;
const SETTLED: f64 = 1e-10;

/// What is added to the square of the Jacobian: where an outline is smooth at a corner of the square,
/// it is singular.
const DAMPING: f64 = 1e-6;

const MIDDLE: DVec2 = DVec2::splat(0.5);

/// A smooth line in the unit square around its middle.
pub(super) struct Outline {
    /// Distances from the middle, by the share of the way round.
    knots: KnotVector,
    radii: Vec<f64>,
    corners: [DVec2; 4],
}

impl Outline {
    /// The likeliest outline of parameters, if it has no corners and no notch, moved out by this
    /// border. They lie on the surface, whose isocurves are so long; the points are blurred by noise.
    pub(super) fn around(
        uv: &[DVec2],
        surface: &NurbsSurface,
        size: DVec2,
        noise: f64,
        border: f64,
    ) -> Result<Option<Self>> {
        if !has_empty_corners(uv) {
            return Ok(None);
        }
        let rays = Rays { patches: Patches::of(surface), rule: gauss::rule(RAY_PLACES) };
        let flat_noise = 0.5 * (noise / size).element_sum();
        // Outlines are simpler in the square or on the surface: what counts is where they are surer.
        let (flat, long) = rayon::join(
            || Line::around(uv, DVec2::length, flat_noise),
            || Line::around(uv, |from| rays.length(from), noise),
        );
        let (flat, long) = (flat?, long?);
        if flat.follows && (flat.doubt() <= long.doubt() || !long.follows) {
            return Self::through(|way| flat.distance(way, border)).map(Some);
        }
        if !long.follows {
            return Ok(None);
        }
        let reach = |way| rays.reach(direction(way), long.distance(way, border));
        Self::through(reach).map(Some)
    }

    fn through(radius: impl Fn(f64) -> f64 + Sync) -> Result<Self> {
        let knots = KnotVector::periodic_uniform(DEGREE, RADII)?;
        let at = |i: usize| radius((i as f64 - 1.0).rem_euclid(RADII as f64) / RADII as f64);
        let values: Vec<f64> = (0..RADII).into_par_iter().map(at).collect();
        // A quasi-interpolant, as near as cubics are.
        let around = |i: usize| values[(i + RADII - 1) % RADII] + values[(i + 1) % RADII];
        let radii = (0..RADII).map(|i| (8.0 * values[i] - around(i)) / 6.0).collect();
        let mut outline = Self { knots, radii, corners: [DVec2::ZERO; 4] };
        outline.corners = [0, 1, 2, 3].map(|side| outline.at(side, 0.0).0);
        Ok(outline)
    }

    /// The place at a share of the way along a side, counter-clockwise, and its derivative.
    fn at(&self, side: usize, share: f64) -> (DVec2, DVec2) {
        let way = ((side as f64 + share + 0.5) / 4.0).rem_euclid(1.0);
        let basis = Basis::<4>::at(&self.knots, way);
        let radius = height(&self.radii, &basis);
        let slope = weighted(&self.radii, basis.first, &basis.slopes);
        let direction = direction(way);
        let by = 0.25 * (slope * direction + TAU * radius * direction.perp());
        (MIDDLE + radius * direction, by)
    }

    /// The place of the unit square's (s, t) inside the outline, blended between its sides, and its
    /// derivatives (S. A. Coons, *Surfaces for computer-aided design of space forms*, 1967).
    fn blend(&self, DVec2 { x: s, y: t }: DVec2) -> (DVec2, DMat2) {
        let (low, low_s) = self.at(0, s);
        let (right, right_t) = self.at(1, t);
        let (high, high_s) = self.at(2, 1.0 - s);
        let (left, left_t) = self.at(3, 1.0 - t);
        let [a, b, c, d] = self.corners;
        let at = low.lerp(high, t) + left.lerp(right, s) - a.lerp(b, s).lerp(d.lerp(c, s), t);
        let by_s = low_s.lerp(-high_s, t) + right - left - (b - a).lerp(c - d, t);
        let by_t = (-left_t).lerp(right_t, s) + high - low - (d - a).lerp(c - b, s);
        (at, DMat2::from_cols(by_s, by_t))
    }

    /// Parameters in the square that the outline bounds.
    pub(super) fn squared(&self, uv: &[DVec2]) -> Vec<DVec2> {
        uv.par_iter().map(|&uv| self.inverse(uv)).collect()
    }

    fn inverse(&self, goal: DVec2) -> DVec2 {
        let mut st = goal;
        for _ in 0..STEPS {
            let (at, by) = self.blend(st);
            let square = by.transpose() * by + DMat2::from_diagonal(DVec2::splat(DAMPING));
            let step = square.inverse() * (by.transpose() * (goal - at));
            let next = (st + step).clamp(DVec2::ZERO, DVec2::ONE);
            let moved = next.distance_squared(st);
            st = next;
            if moved < SETTLED {
                break;
            }
        }
        st
    }
}

/// Whether so many corners of the unit square are emptier than chance would leave them that an outline
/// is round.
fn has_empty_corners(uv: &[DVec2]) -> bool {
    let expected = uv.len() as f64 * 0.5 * CORNER * CORNER;
    let mut counts = [0.0; 4];
    for uv in uv {
        let far = DVec2::ONE - *uv;
        for (count, depths) in
            counts.iter_mut().zip([*uv, DVec2::new(far.x, uv.y), far, DVec2::new(uv.x, far.y)])
        {
            *count += f64::from(u8::from(depths.element_sum() < CORNER));
        }
    }
    let empty = counts.into_iter().filter(|count| *count < EMPTY * expected).count();
    expected >= TELLING && empty >= EMPTY_CORNERS
}

fn direction(way: f64) -> DVec2 {
    DVec2::from_angle(TAU * way - PI)
}

/// A closed line around the middle of the square, by distances that mean what they will.
struct Line {
    knots: KnotVector,
    /// See [`BOUNDS`], with their standard deviations.
    heights: Vec<f64>,
    deviations: Vec<f64>,
    /// The mean of the squared distances.
    mean: f64,
    /// Whether no place lies far outside of it, nor is ground empty inside.
    follows: bool,
}

impl Line {
    fn around(uv: &[DVec2], distance: impl Fn(DVec2) -> f64 + Sync, noise: f64) -> Result<Self> {
        let place = |uv: &DVec2| {
            let from = *uv - MIDDLE;
            ((from.to_angle() + PI) / TAU, distance(from).powi(2))
        };
        let polar: Vec<(f64, f64)> = uv.par_iter().map(place).collect();
        let outer = lowest(polar.iter().map(|&(way, square)| (way, -square)), SECTORS);
        let count = outer.iter().flatten().count().max(1) as f64;
        let mean = outer.iter().flatten().map(|place| -place.1).sum::<f64>() / count;
        let places: Vec<(f64, f64)> =
            polar.into_iter().map(|(way, square)| (way, 1.0 - square / mean)).collect();

        let first = STIFFNESSES[STIFFNESSES.len() / 2];
        let knots = KnotVector::periodic_uniform(DEGREE, CONTROL_POINTS)?;
        let all = places.iter().copied();
        let mut likelihood = Likelihood::new(all, places.len(), knots, first, BOUNDS);
        let even = likelihood.slopes.clone();
        let look = |likelihood: &mut Likelihood, heights: &[f64]| {
            let behind = likelihood.places.iter();
            let behind = behind.filter(|place| place.y < height(heights, &place.basis) + GROUND);
            let found = sums(behind.map(|place| &place.basis), CONTROL_POINTS);
            let dense = found.iter().zip(&even);
            likelihood.slopes =
                dense.map(|(sum, even)| (sum / GROUND).max(SPARSEST * even)).collect();
        };
        let mut heights = vec![0.0; CONTROL_POINTS];
        let noise = 2.0 * noise / mean.sqrt();
        let scale = likelihood.find(&mut heights, FIRST_SCALE, noise, look);
        likelihood.stiffen(&mut heights, scale, &STIFFNESSES);
        let deviations = likelihood.deviations(&heights, scale);
        let curve = |way: f64| height(&heights, &Basis::at(&likelihood.knots, way));
        let outside = places.iter().map(|&(way, y)| curve(way) - y).fold(0.0, f64::max);
        let spacing = 2.0 * (PI / places.len() as f64).sqrt();
        let follows = outside <= OUTSIDE.0 * spacing + OUTSIDE.1 * noise
            && empty_ground(&places, curve, 0) < NOTCHED;
        Ok(Self { knots: likelihood.knots, heights, deviations, mean, follows })
    }

    /// The mean standard deviation.
    fn doubt(&self) -> f64 {
        self.deviations.iter().sum::<f64>() / CONTROL_POINTS as f64
    }

    /// The distance of the line from the middle, moved out by this border.
    fn distance(&self, way: f64, border: f64) -> f64 {
        let basis = Basis::at(&self.knots, way);
        let margin = border * BEYOND * height(&self.deviations, &basis);
        (self.mean * (1.0 - height(&self.heights, &basis) + margin)).sqrt()
    }
}

/// The straight lines in the square from its middle.
struct Rays<'a> {
    patches: Patches<'a>,
    /// Shares of a ray and weights for its length.
    rule: Vec<(f64, f64)>,
}

impl Rays<'_> {
    /// Length on the surface from the middle as far as this.
    fn length(&self, from: DVec2) -> f64 {
        let speed = |share: f64| {
            let tangents = self.patches.at(MIDDLE + share * from);
            (from.x * tangents.u + from.y * tangents.v).length()
        };
        self.rule.iter().map(|&(share, weight)| weight * speed(share)).sum()
    }

    /// How far in a direction one has to go for this length; beyond the square, in proportion.
    fn reach(&self, direction: DVec2, length: f64) -> f64 {
        let side = 0.5 / direction.abs().max_element();
        let mut radius = side;
        for _ in 0..RAY_STEPS {
            let inside = radius.min(side);
            radius = inside * length / self.length(inside * direction);
        }
        radius
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::likelihood::tests::even;
    use super::*;

    /// Parameters evenly over a part of the unit square.
    fn scattered(part: impl Fn(DVec2) -> bool) -> Vec<DVec2> {
        even().map(DVec2::from).filter(|&place| part(place)).collect()
    }

    /// A surface over the unit square.
    fn surface(point: impl Fn(DVec2) -> DVec3) -> NurbsSurface {
        let knots = KnotVector::clamped_uniform(3, 12).unwrap();
        let at = knots.greville();
        let net = at.iter().flat_map(|&u| at.iter().map(move |&v| DVec2::new(u, v))).map(point);
        NurbsSurface::clamped(net.collect(), (12, 12), 3).unwrap()
    }

    fn flat(uv: DVec2) -> DVec3 {
        uv.extend(0.0)
    }

    fn around(uv: &[DVec2], surface: &NurbsSurface) -> Option<Outline> {
        Outline::around(uv, surface, DVec2::ONE, 0.0, 0.5).unwrap()
    }

    #[test]
    fn an_ellipse_becomes_a_square_with_its_corners() {
        let inside = |at: DVec2| ((at - MIDDLE) / DVec2::new(0.45, 0.35)).length();
        let uv = scattered(|at| inside(at) < 1.0);
        let outline = around(&uv, &surface(flat)).unwrap();
        // The spacing of the points is 0.018.
        for i in 0..40 {
            let (at, _) = outline.at(i / 10, (i % 10) as f64 / 10.0);
            assert!((inside(at) - 1.0).abs() < 0.04, "{at} {}", inside(at));
        }
        let squared = outline.squared(&uv);
        for (&uv, &st) in uv.iter().zip(&squared) {
            let (at, by) = outline.blend(st);
            let left = at.distance(uv);
            assert!(left < 1e-6 || inside(uv) > 0.97, "{uv} {st} {left}");
            assert!(by.determinant() > -1e-9, "{st}");
        }
        for corner in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
            let nearest = squared.iter().map(|st| st.distance(corner)).fold(1.0, f64::min);
            assert!(nearest < 0.15, "{corner} {nearest}");
        }
    }

    #[test]
    fn a_cap_is_round_on_the_surface() {
        // Its outline is a circle in space, and a rounded square in the parameters.
        let sphere = |uv: DVec2| {
            let angles = 3.6 * (uv - MIDDLE);
            let (x, y) = (angles.x.sin(), angles.x.cos() * angles.y.sin());
            DVec3::new(x, y, angles.x.cos() * angles.y.cos())
        };
        let cap = surface(sphere);
        let uv = scattered(|at| cap.point(at.x, at.y).z > 0.2);
        let outline = around(&uv, &cap).unwrap();
        for i in 0..40 {
            let (at, _) = outline.at(i / 10, (i % 10) as f64 / 10.0);
            let height = cap.point(at.x, at.y).z;
            assert!((height - 0.2).abs() < 0.03, "{at} {height}");
        }
    }

    #[test]
    fn corners_and_notches_are_left_to_edges() {
        assert!(around(&scattered(|_| true), &surface(flat)).is_none());
        let half = scattered(|at| (at - DVec2::new(0.5, 0.0)).length() < 0.5);
        assert!(around(&half, &surface(flat)).is_none());
        let notch = |at: DVec2| at.distance(MIDDLE) < 0.48 && at.distance(DVec2::Y * 0.5) > 0.35;
        assert!(around(&scattered(notch), &surface(flat)).is_none());
        let few: Vec<DVec2> = scattered(|at| at.distance(MIDDLE) < 0.48);
        assert!(around(&few[..100], &surface(flat)).is_none());
        assert!(around(&[MIDDLE; 1000], &surface(flat)).is_none());
    }
}
