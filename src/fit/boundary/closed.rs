//! Closed boundary: the likeliest smooth closed curve at which the points of a sheet without
//! corners end.

use std::f64::consts::PI;

use glam::DVec2;
use rayon::prelude::*;

use super::super::patches::Patches;
use super::likelihood::{DEGREE, Likelihood, height, sums};
use super::polar_projection::{CENTER, PolarProjection, direction, outermost_points, turn_of};
use super::settings::{BoundarySettings, ClosedBoundarySettings};
use super::strips::empty_area;
use crate::error::Result;
use crate::nurbs::{Basis, KnotVector, NurbsSurface};

const SETTINGS: ClosedBoundarySettings = ClosedBoundarySettings::STANDARD;
const BOUNDARY: BoundarySettings = BoundarySettings::STANDARD;

/// A smooth closed curve in the unit square around its center.
pub(crate) struct ClosedBoundary {
    /// Distances from the center, by the fraction of a full turn.
    knots: KnotVector,
    radii: Vec<f64>,
    /// The radius by which circles near the center of the unit disc are scaled.
    center_radius: f64,
}

impl ClosedBoundary {
    /// The likeliest boundary of parameters, moved outward by `border`. `None` if it has corners or
    /// a notch. The parameters belong to a surface with isocurves of these lengths; the points have
    /// noise.
    pub(crate) fn around(
        uv: &[DVec2],
        surface: &NurbsSurface,
        size: DVec2,
        noise: f64,
        border: f64,
    ) -> Result<Option<Self>> {
        if !has_empty_corners(uv) {
            return Ok(None);
        }
        // The curve may be simpler in the parameters, along the surface or in projection. The most
        // certain one is used.
        let patches = Patches::of(surface);
        let candidates = [
            PolarProjection::Parameters,
            PolarProjection::arc_length(&patches),
            PolarProjection::planar(&patches, uv),
        ];
        let projected = |projection: &PolarProjection<'_>| {
            let curve = PolarCurve::around(uv, projection, projection.noise(noise, size))?;
            let Some((uncertainty, radii)) = curve.parameter_radii(projection, border) else {
                return Ok(None);
            };
            let boundary = Self::through(&radii)?;
            Ok(uv.iter().all(|uv| boundary.is_around(*uv)).then_some((uncertainty, boundary)))
        };
        let found = candidates.par_iter().map(projected).collect::<Result<Vec<_>>>()?;
        let most_certain = found.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        Ok(most_certain.map(|(_, boundary)| boundary))
    }

    /// The curve with these distances from the center, evenly over a full turn.
    fn through(values: &[f64]) -> Result<Self> {
        let knots = KnotVector::periodic_uniform(DEGREE, SETTINGS.directions)?;
        // A quasi-interpolant with the approximation order of cubics.
        let value = |i: usize| values[i % SETTINGS.directions];
        let radius =
            |i: usize| (8.0 * value(i) - value(i + SETTINGS.directions - 1) - value(i + 1)) / 6.0;
        let radii = (0..SETTINGS.directions).map(|i| radius(i + SETTINGS.directions - 1)).collect();
        let mean = values.iter().sum::<f64>() / SETTINGS.directions as f64;
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        Ok(Self { knots, radii, center_radius: mean.min(SETTINGS.max_center_radius * least) })
    }

    /// The distance from the center in a direction.
    fn radius(&self, from: DVec2) -> f64 {
        height(&self.radii, &Basis::<4>::at(&self.knots, turn_of(from)))
    }

    /// Places on the curve, and their images on the border of the unit square.
    pub(crate) fn boundary_pairs(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        let places = directions().map(|from| CENTER + self.radius(from) * from);
        places.zip(square_boundary())
    }

    fn is_around(&self, uv: DVec2) -> bool {
        let from = uv - CENTER;
        from.length() <= (1.0 + SETTINGS.max_excess) * self.radius(from)
    }

    /// Maps the inside of the curve to the unit square: along rays to the unit disc, so that
    /// circles gradually become the curve, then to the square. Neither map folds, whatever the
    /// curve. Places outside are moved to the curve.
    pub(crate) fn mapped_to_square(&self, uv: &[DVec2]) -> Vec<DVec2> {
        // Places moved to the curve must lie exactly on the border. Otherwise rounding would decide
        // whether their projections are on the border.
        let exact = |at: f64| if at.min(1.0 - at) < SETTINGS.rounding { at.round() } else { at };
        let mapped = |uv: &DVec2| {
            let at = CENTER + 0.5 * disc_to_square(self.in_disc(*uv - CENTER));
            DVec2::new(exact(at.x), exact(at.y))
        };
        uv.par_iter().map(mapped).collect()
    }

    /// The place in the unit disc whose image is at (center radius · r + (radius - center radius) ·
    /// r³) from the center.
    fn in_disc(&self, from: DVec2) -> DVec2 {
        let distance = from.length();
        if distance == 0.0 {
            return DVec2::ZERO;
        }
        let radius = self.radius(from);
        let (near, far) = (self.center_radius, radius - self.center_radius);
        let mut share = (distance / radius).min(1.0);
        let goal = share * radius;
        for _ in 0..SETTINGS.ray_steps {
            let short = goal - share * (near + far * share * share);
            share = (share + short / (near + 3.0 * far * share * share)).clamp(0.0, 1.0);
        }
        share / distance * from
    }
}

/// Evenly distributed directions.
fn directions() -> impl Iterator<Item = DVec2> {
    (0..SETTINGS.directions).map(|i| direction(i as f64 / SETTINGS.directions as f64))
}

/// The images on the border of the unit square of evenly distributed directions.
pub(super) fn square_boundary() -> impl Iterator<Item = DVec2> {
    directions().map(|from| CENTER + 0.5 * disc_to_square(from))
}

/// The point (x, y) of the square [-1, 1]² for (u, v) of the unit disc: u² = x² (1 - y² / 2) and v²
/// = y² (1 - x² / 2). It is smooth except at the corners.
fn disc_to_square(DVec2 { x: u, y: v }: DVec2) -> DVec2 {
    let place = |along: f64, across: f64| {
        let (sum, twice) = (2.0 + along * along - across * across, 8.0_f64.sqrt() * along);
        let root = |square: f64| 0.5 * square.max(0.0).sqrt();
        (root(sum + twice) - root(sum - twice)).clamp(-1.0, 1.0)
    };
    DVec2::new(place(u, v), place(v, u))
}

/// Whether at least three corners of the unit square are emptier than by chance, as for a round
/// boundary. The fourth may be full if points are dense there.
fn has_empty_corners(uv: &[DVec2]) -> bool {
    let count = uv.len() as f64;
    // With four expected points, two standard deviations fewer are none.
    let size = (8.0 / count).sqrt().max(SETTINGS.corner);
    let expected = count * 0.5 * size * size;
    let is_empty = |corner: &DVec2| {
        let inside = |uv: &&DVec2| (**uv - *corner).abs().element_sum() < size;
        let found = uv.iter().filter(inside).count() as f64;
        found < 0.5 * expected && found <= expected - 2.0 * expected.sqrt() + SETTINGS.rounding
    };
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let empty = corners.iter().filter(|corner| is_empty(corner)).count();
    size <= SETTINGS.max_corner && empty > 2
}

/// A closed curve around the center in one polar projection.
struct PolarCurve {
    knots: KnotVector,
    /// See [`ClosedBoundarySettings::heights`], with their standard deviations.
    heights: Vec<f64>,
    deviations: Vec<f64>,
    /// The mean of the squared distances from the center.
    mean: f64,
    /// Whether no point lies far outside, and no area inside is empty.
    follows: bool,
}

impl PolarCurve {
    fn around(uv: &[DVec2], projection: &PolarProjection<'_>, noise: f64) -> Result<Self> {
        let place = |uv: &DVec2| {
            let projected = projection.project(*uv - CENTER);
            (turn_of(projected), projected.length_squared())
        };
        let polar: Vec<(f64, f64)> = uv.par_iter().map(place).collect();
        let outer = outermost_points(polar.iter().copied());
        let mean = outer.iter().map(|place| place.1).sum::<f64>() / outer.len().max(1) as f64;
        let places: Vec<(f64, f64)> =
            polar.into_iter().map(|(turn, square)| (turn, 1.0 - square / mean)).collect();

        let first = SETTINGS.penalties[SETTINGS.penalties.len() / 2];
        let knots = KnotVector::periodic_uniform(DEGREE, SETTINGS.control_points)?;
        let all = places.iter().copied();
        let mut likelihood = Likelihood::new(all, places.len(), knots, first, SETTINGS.heights);
        let even = likelihood.slopes.clone();
        let update_density = |likelihood: &mut Likelihood, heights: &[f64]| {
            let behind = likelihood.places.iter();
            let behind = behind
                .filter(|place| place.y < height(heights, &place.basis) + SETTINGS.density_height);
            let found = sums(behind.map(|place| &place.basis), SETTINGS.control_points);
            let dense = found.iter().zip(&even);
            likelihood.slopes = dense
                .map(|(sum, even)| (sum + 1.0) / (SETTINGS.density_height + 1.0 / even))
                .collect();
            likelihood.blur_by_density();
        };
        let mut heights = vec![0.0; SETTINGS.control_points];
        let noise = 2.0 * noise / mean.sqrt();
        let scale = likelihood.find(&mut heights, noise, update_density);
        let here = likelihood.choose_penalty(&mut heights, scale, &SETTINGS.penalties);
        let deviations = likelihood.standard_deviations(&here);
        let curve = |turn: f64| height(&heights, &Basis::at(&likelihood.knots, turn));
        let outside = places.iter().map(|&(turn, y)| curve(turn) - y).fold(0.0, f64::max);
        let spacing = 2.0 * (PI / places.len() as f64).sqrt();
        let follows = outside <= SETTINGS.max_outside.0 * spacing + SETTINGS.max_outside.1 * noise
            && empty_area(&places, curve, 0)
                < BOUNDARY.min_notch + SETTINGS.chance_height / places.len() as f64;
        Ok(Self { knots: likelihood.knots, heights, deviations, mean, follows })
    }

    /// In the parameters, the relative growth of the area by one standard deviation, and the
    /// distances from the center, moved outward by `border`. `None` if the curve does not follow
    /// the points, or the projection does not reach it.
    fn parameter_radii(
        &self,
        projection: &PolarProjection<'_>,
        border: f64,
    ) -> Option<(f64, Vec<f64>)> {
        let moved_outward = |deviations: f64| {
            let beyond = |projected: DVec2| {
                projected.length() - self.distance(turn_of(projected), deviations)
            };
            let radius = |i: usize| {
                projection.radius_at_zero(direction(i as f64 / SETTINGS.directions as f64), beyond)
            };
            (0..SETTINGS.directions).into_par_iter().map(radius).collect::<Option<Vec<f64>>>()
        };
        let (curve, wider) = (moved_outward(0.0).filter(|_| self.follows)?, moved_outward(1.0)?);
        let area_growth: f64 = wider.iter().zip(&curve).map(|(a, b)| (a / b).powi(2) - 1.0).sum();
        Some((
            area_growth / SETTINGS.directions as f64,
            moved_outward(SETTINGS.margin_deviations * border)?,
        ))
    }

    /// The distance from the center, moved outward by a number of standard deviations.
    fn distance(&self, turn: f64, out: f64) -> f64 {
        let basis = Basis::at(&self.knots, turn);
        let margin = out * height(&self.deviations, &basis);
        (self.mean * (1.0 - height(&self.heights, &basis) + margin)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec3;

    use super::super::likelihood::tests::even;
    use super::super::polar_projection::tests::surface;
    use super::*;

    /// Parameters evenly over a part of the unit square.
    fn scattered(part: impl Fn(DVec2) -> bool) -> Vec<DVec2> {
        even().map(DVec2::from).filter(|&place| part(place)).collect()
    }

    fn flat(uv: DVec2) -> DVec3 {
        uv.extend(0.0)
    }

    fn around(uv: &[DVec2], surface: &NurbsSurface) -> Option<ClosedBoundary> {
        ClosedBoundary::around(uv, surface, DVec2::ONE, 0.0, 0.5).unwrap()
    }

    /// Places on a boundary.
    fn curve(boundary: &ClosedBoundary) -> impl Iterator<Item = DVec2> {
        let directions = (0..40).map(|i| direction(f64::from(i) / 40.0));
        directions.map(|from| CENTER + boundary.radius(from) * from)
    }

    #[test]
    fn an_ellipse_becomes_a_square_with_its_corners() {
        let inside = |at: DVec2| ((at - CENTER) / DVec2::new(0.45, 0.35)).length();
        let uv = scattered(|at| inside(at) < 1.0);
        let boundary = around(&uv, &surface(flat)).unwrap();
        // The spacing of the points is 0.018.
        for at in curve(&boundary) {
            assert!((inside(at) - 1.0).abs() < 0.04, "{at} {}", inside(at));
        }
        let mapped_to_square = boundary.mapped_to_square(&uv);
        for corner in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
            let nearest = mapped_to_square.iter().map(|st| st.distance(corner)).fold(1.0, f64::min);
            assert!(nearest < 0.15, "{corner} {nearest}");
        }
    }

    #[test]
    fn no_closed_boundary_folds() {
        for depth in [0.0, 0.15, 0.3] {
            for lobes in 2..6 {
                let wave = |turn: f64| 0.4 * (1.0 + depth * (f64::from(lobes) * TAU * turn).cos());
                let radii: Vec<f64> = (0..SETTINGS.directions)
                    .map(|i| wave(i as f64 / SETTINGS.directions as f64))
                    .collect();
                let boundary = ClosedBoundary::through(&radii).unwrap();
                let at = |i: i32, j: i32| {
                    let from = wave(f64::from(j) / 360.0) * direction(f64::from(j) / 360.0);
                    CENTER + f64::from(i) / 20.0 * from
                };
                for (i, j) in (0..20).flat_map(|i| (0..360).map(move |j| (i, j))) {
                    let corners = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
                    let [a, b, c, d] = boundary.mapped_to_square(&corners).try_into().unwrap();
                    let (first, second) = ((b - a).perp_dot(d - a), (d - a).perp_dot(c - a));
                    assert!(first > 0.0 || i == 19, "{depth} {lobes} {i} {j} {first}");
                    assert!(second > 0.0 || i == 0, "{depth} {lobes} {i} {j} {second}");
                }
                let boundary_pairs: Vec<DVec2> = curve(&boundary).collect();
                for st in boundary.mapped_to_square(&boundary_pairs) {
                    let depth = st.min(DVec2::ONE - st).min_element();
                    assert!(depth < 1e-7, "{st} {depth}");
                }
            }
        }
    }

    #[test]
    fn a_cap_is_round_on_the_surface() {
        // Its boundary is a circle in space, and a rounded square in the parameters.
        let sphere = |uv: DVec2| {
            let angles = 3.6 * (uv - CENTER);
            let (x, y) = (angles.x.sin(), angles.x.cos() * angles.y.sin());
            DVec3::new(x, y, angles.x.cos() * angles.y.cos())
        };
        let cap = surface(sphere);
        let uv = scattered(|at| cap.point(at.x, at.y).z > 0.2);
        let boundary = around(&uv, &cap).unwrap();
        for at in curve(&boundary) {
            let height = cap.point(at.x, at.y).z;
            assert!((height - 0.2).abs() < 0.03, "{at} {height}");
        }
    }

    #[test]
    fn corners_and_notches_have_no_closed_boundary() {
        assert!(around(&scattered(|_| true), &surface(flat)).is_none());
        let half = scattered(|at| (at - DVec2::new(0.5, 0.0)).length() < 0.5);
        assert!(around(&half, &surface(flat)).is_none());
        let notch = |at: DVec2| at.distance(CENTER) < 0.48 && at.distance(DVec2::Y * 0.5) > 0.35;
        assert!(around(&scattered(notch), &surface(flat)).is_none());
        let few: Vec<DVec2> = scattered(|at| at.distance(CENTER) < 0.48);
        assert!(around(&few[..50], &surface(flat)).is_none());
        assert!(around(&[CENTER; 1000], &surface(flat)).is_none());
    }
}
