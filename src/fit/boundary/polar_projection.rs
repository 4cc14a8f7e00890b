//! Polar projections: maps of the domain around its center to a plane, in which a closed boundary
//! may be simple.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2, DVec3};

use super::super::patches::Patches;
use super::settings::{BoundarySettings, ClosedBoundarySettings};
use super::strips::lowest_in_strips;
use crate::nurbs::gauss;

const SETTINGS: ClosedBoundarySettings = ClosedBoundarySettings::STANDARD;
const BOUNDARY: BoundarySettings = BoundarySettings::STANDARD;

pub(super) const CENTER: DVec2 = DVec2::splat(0.5);

/// A map of offsets from the domain's center to a plane.
pub(super) enum PolarProjection<'a> {
    /// The offset itself.
    Parameters,
    /// The same direction, with the arc length on the surface as distance.
    ArcLength(&'a Patches<'a>, Vec<(f64, f64)>),
    /// Orthogonal projection to a plane, scaled so that the boundary is about as long as wide.
    Planar(&'a Patches<'a>, WhitenedPlane),
}

impl<'a> PolarProjection<'a> {
    pub(super) fn arc_length(patches: &'a Patches<'a>) -> Self {
        Self::ArcLength(patches, gauss::rule(SETTINGS.ray_steps))
    }

    pub(super) fn planar(patches: &'a Patches<'a>, uv: &[DVec2]) -> Self {
        Self::Planar(patches, WhitenedPlane::of(patches, uv))
    }

    pub(super) fn project(&self, from: DVec2) -> DVec2 {
        match self {
            Self::Parameters => from,
            Self::ArcLength(patches, rule) => {
                let speed = |share: f64| {
                    let tangents = patches.at(CENTER + share * from);
                    (from.x * tangents.u + from.y * tangents.v).length()
                };
                let length: f64 = rule.iter().map(|&(share, weight)| weight * speed(share)).sum();
                length * from.normalize_or_zero()
            }
            Self::Planar(patches, plane) => plane.place(patches.at(CENTER + from).point),
        }
    }

    /// The size of noise in the projection, for a surface with isocurves of these lengths.
    pub(super) fn noise(&self, noise: f64, size: DVec2) -> f64 {
        match self {
            Self::Parameters => 0.5 * (noise / size).element_sum(),
            Self::ArcLength(..) => noise,
            Self::Planar(_, plane) => {
                let [first, _, second] = plane.factor;
                0.5 * (noise / first + noise / second)
            }
        }
    }

    /// The radius in a direction at which `beyond` of the projected place rises to zero, by false
    /// position with halved ends (the Illinois method). Beyond the square it is extrapolated
    /// linearly. `None` if it is too far, or the center is beyond.
    pub(super) fn radius_at_zero(
        &self,
        direction: DVec2,
        beyond: impl Fn(DVec2) -> f64,
    ) -> Option<f64> {
        let side = 0.5 / direction.abs().max_element();
        let beyond = |radius: f64| beyond(self.project(radius * direction));
        let (start, end) = (beyond(0.0), beyond(side));
        if start >= 0.0 {
            return None;
        }
        if end <= 0.0 {
            let rise = (end - beyond((1.0 - SETTINGS.extrapolation_base) * side)).max(0.0);
            let farther = -SETTINGS.extrapolation_base * end / rise;
            return (farther < SETTINGS.max_extrapolation).then_some((1.0 + farther) * side);
        }
        let (mut low, mut high) = ((0.0, start), (side, end));
        let (mut radius, mut last) = (side, 0.0);
        for _ in 0..SETTINGS.ray_steps {
            radius = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let there = beyond(radius);
            let again = there * last > 0.0;
            let half = if again { 0.5 } else { 1.0 };
            if there < 0.0 {
                (low, high.1) = ((radius, there), half * high.1);
            } else {
                (high, low.1) = ((radius, there), half * low.1);
            }
            if there == 0.0 {
                break;
            }
            last = there;
        }
        Some(radius)
    }
}

/// The fraction of a full turn for a direction from the center.
pub(super) fn turn_of(from: DVec2) -> f64 {
    (from.to_angle() + PI) / TAU
}

pub(super) fn direction(turn: f64) -> DVec2 {
    DVec2::from_angle(TAU * turn - PI)
}

/// The outermost points in sectors around the center. Points are given by the fraction of a full
/// turn and the squared distance.
pub(super) fn outermost_points(polar: impl Iterator<Item = (f64, f64)> + Clone) -> Vec<(f64, f64)> {
    let outer = lowest_in_strips(polar.map(|(turn, square)| (turn, -square)), BOUNDARY.strips);
    outer.into_iter().flatten().map(|(turn, square)| (turn, -square)).collect()
}

/// A plane across the mean normal of a surface. Origin and axes are chosen so that the area within
/// the boundary has the second moments of a disc, as an ellipse has. The density of the points does
/// not matter.
pub(super) struct WhitenedPlane {
    origin: DVec3,
    axes: [DVec3; 2],
    middle: DVec2,
    /// Cholesky factor of the moments.
    factor: [f64; 3],
}

impl WhitenedPlane {
    fn of(patches: &Patches<'_>, uv: &[DVec2]) -> Self {
        let (mut along, mut normal) = (DVec3::ZERO, DVec3::ZERO);
        for uv in uv {
            let tangents = patches.at(*uv);
            along += tangents.u;
            normal += tangents.u.cross(tangents.v);
        }
        let up = normal.normalize_or(DVec3::Z);
        let first = along.reject_from_normalized(up);
        let first = first.try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
        let mut found = Self {
            origin: patches.at(CENTER).point,
            axes: [first, up.cross(first)],
            middle: DVec2::ZERO,
            factor: [1.0, 0.0, 1.0],
        };
        let places: Vec<DVec2> = uv.iter().map(|uv| found.place(patches.at(*uv).point)).collect();
        let outer = outermost_points(places.iter().map(|p| (turn_of(*p), p.length_squared())));
        let corners: Vec<DVec2> =
            outer.into_iter().map(|(turn, square)| square.sqrt() * direction(turn)).collect();
        let (middle, moments) = moments(&corners);
        let first = moments.x_axis.x.max(f64::MIN_POSITIVE).sqrt();
        let mixed = moments.x_axis.y / first;
        let second = (moments.y_axis.y - mixed * mixed).max(f64::MIN_POSITIVE).sqrt();
        (found.middle, found.factor) = (middle, [first, mixed, second]);
        found
    }

    fn place(&self, point: DVec3) -> DVec2 {
        let from = self.axes.map(|axis| axis.dot(point - self.origin));
        let from = DVec2::from_array(from) - self.middle;
        let [first, mixed, second] = self.factor;
        let x = from.x / first;
        DVec2::new(x, (from.y - mixed * x) / second)
    }
}

/// The centroid of the area of a counterclockwise polygon around zero, and the second moments about
/// it.
fn moments(polygon: &[DVec2]) -> (DVec2, DMat2) {
    let squared = |p: DVec2| DMat2::from_cols(p * p.x, p * p.y);
    let (mut area, mut first, mut second) = (f64::MIN_POSITIVE, DVec2::ZERO, DMat2::ZERO);
    for (i, &a) in polygon.iter().enumerate() {
        // The moments of a triangle with a corner at zero.
        let b = polygon[(i + 1) % polygon.len()];
        let twice = a.perp_dot(b);
        area += 0.5 * twice;
        first += twice / 6.0 * (a + b);
        second += (squared(a) + squared(b) + squared(a + b)) * (twice / 24.0);
    }
    let middle = first / area;
    (middle, second * (1.0 / area) - squared(middle))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::nurbs::{KnotVector, NurbsSurface};

    /// A surface over the unit square.
    pub(in super::super) fn surface(point: impl Fn(DVec2) -> DVec3) -> NurbsSurface {
        let knots = KnotVector::clamped_uniform(3, 12).unwrap();
        let at = knots.greville();
        let net = at.iter().flat_map(|&u| at.iter().map(move |&v| DVec2::new(u, v))).map(point);
        NurbsSurface::clamped(net.collect(), (12, 12), 3).unwrap()
    }

    #[test]
    fn arc_lengths_are_found_on_curved_surfaces() {
        let cone = surface(|uv| (uv - CENTER).extend(2.0 * uv.distance(CENTER)));
        let patches = Patches::of(&cone);
        let projection = PolarProjection::arc_length(&patches);
        for turn in 0..24 {
            let towards = DVec2::from_angle(0.26 * f64::from(turn));
            for length in [0.1, 0.5, 0.9] {
                let radius = projection
                    .radius_at_zero(towards, |projected| projected.length() - length)
                    .unwrap();
                let found = projection.project(radius * towards);
                assert!((found.length() / length - 1.0).abs() < 1e-6, "{turn} {length} {found}");
                assert!(found.normalize().distance(towards) < 1e-12);
            }
        }
    }

    #[test]
    fn ellipses_are_projected_to_discs_for_any_density() {
        let leaning = surface(|uv| DVec3::new(3.0 * uv.x + uv.y, uv.y, 0.4 * uv.x));
        let patches = Patches::of(&leaning);
        let spiral = |i: i32| {
            let radius = 0.45 * (f64::from(i) / 4000.0).sqrt();
            CENTER + radius * DVec2::from_angle(2.4 * f64::from(i))
        };
        let dense = |uv: &DVec2| uv.x < 0.4 || uv.y > 0.7 || (uv.x * 1e4) % 3.0 < 1.0;
        let uv: Vec<DVec2> = (0..4000).map(spiral).filter(dense).collect();
        let projection = PolarProjection::planar(&patches, &uv);
        for turn in 0..24 {
            // The second moments of a disc are a quarter of its squared radius.
            let projected = projection.project(0.45 * DVec2::from_angle(0.26 * f64::from(turn)));
            assert!((projected.length() - 2.0).abs() < 0.12, "{turn} {projected}");
        }
        let noise = projection.noise(0.01, DVec2::ONE);
        assert!((0.01..0.1).contains(&noise), "{noise}");
    }

    #[test]
    fn rays_are_extrapolated_only_a_little() {
        let towards = DVec2::from_angle(0.3);
        let radius = |wanted: f64| {
            PolarProjection::Parameters
                .radius_at_zero(towards, |projected| projected.length() - wanted)
        };
        assert!((radius(0.55).unwrap() - 0.55).abs() < 1e-12);
        assert!(radius(0.9).is_none() && radius(0.0).is_none());
        // The border of a hemisphere is the outermost curve in projection.
        let ball = surface(|uv| {
            let from = 3.4 * (uv - CENTER);
            let (sine, cosine) = from.length().sin_cos();
            (sine * from.normalize_or_zero()).extend(cosine)
        });
        let patches = Patches::of(&ball);
        let uv: Vec<DVec2> =
            (0..900).map(|i| DVec2::new(f64::from(i % 30), f64::from(i / 30)) / 30.0).collect();
        let above = PolarProjection::planar(&patches, &uv);
        let outermost_points = above.project(DVec2::new(0.5, 0.0)).length();
        assert!(
            above
                .radius_at_zero(DVec2::X, |projected| projected.length() - 1.001 * outermost_points)
                .is_none()
        );
    }
}
