//! Polar chart: distance from a center along the surface, and angle about it.

use glam::{DVec2, DVec3};

use super::hypothesis::Hypothesis;
use super::input::{ChartInput, Graph};
use super::kind::Kind;
use super::settings::PolarSettings;
use super::traits::Chart;
use crate::cloud::Plane;
use crate::numeric::quantile;

const SETTINGS: PolarSettings = PolarSettings::STANDARD;

/// Domes, bulbs and cones, by geodesic polar coordinates.
pub(super) struct Polar;

impl Chart for Polar {
    fn name(&self) -> &'static str {
        "polar"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Sheet]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        let graphs = [("polar", Graph::Surface), ("polar tight", Graph::Tight)];
        graphs.into_iter().filter_map(|(name, graph)| polar(name, graph, input)).collect()
    }
}

/// The sheet around the most central landmark.
fn polar(name: &'static str, graph: Graph, input: &ChartInput<'_>) -> Option<Hypothesis> {
    let (map, points) = (input.landmark_map(graph)?, input.observations.points());
    let reach = |distances: &Vec<f64>| distances.iter().copied().fold(0.0, f64::max);
    let central = (0..map.landmarks.len())
        .min_by(|&a, &b| reach(&map.distances[a]).total_cmp(&reach(&map.distances[b])))?;
    let (center, distances) = (points[map.landmarks[central]], &map.distances[central]);
    let near = quantile(distances.iter().copied(), SETTINGS.cap_share);
    let cap = points.iter().zip(distances).filter(|(_, d)| **d <= near).map(|(point, _)| *point);
    let normal = Plane::of(cap.collect::<Vec<_>>()).normal();
    let inwards = input.observations.axes().center - center;
    let aside = inwards.dot(normal).abs() < SETTINGS.min_inward_cosine * inwards.length();
    let axis = if aside { normal } else { inwards.normalize_or(normal) };
    let (a, b) = axis.any_orthonormal_pair();
    let longest = reach(distances);
    let place = |(point, distance): (&DVec3, &f64)| {
        let apart = *point - center;
        let way = DVec2::new(apart.dot(a), apart.dot(b)).normalize_or_zero();
        0.5 * (square(distance / longest * way) + 1.0)
    };
    let uv = points.iter().zip(distances).map(place).collect();
    Some(Hypothesis::new(name, Kind::Sheet, uv, [2.0 * longest; 2]))
}

/// Maps the unit disc to the square [-1, 1]² (the elliptical grid mapping: C. Fong, *Analytical
/// methods for squaring the disc*, 2014).
fn square(place: DVec2) -> DVec2 {
    let DVec2 { x, y } = place;
    let (own, cross) = (2.0 + x * x - y * y, 8.0_f64.sqrt());
    let side = |base: f64, twice: f64| {
        0.5 * ((base + twice).max(0.0).sqrt() - (base - twice).max(0.0).sqrt())
    };
    let found = DVec2::new(side(own, cross * x), side(4.0 - own, cross * y));
    found.clamp(-DVec2::ONE, DVec2::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_maps_to_the_whole_square() {
        let corner = square(DVec2::from_angle(std::f64::consts::FRAC_PI_4));
        assert!(corner.distance(DVec2::ONE) < 1e-7, "{corner}");
        assert!(square(DVec2::X).distance(DVec2::X) < 1e-12);
        assert_eq!(square(DVec2::ZERO), DVec2::ZERO);
    }
}
