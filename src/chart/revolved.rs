//! Revolved chart: angles about a principal axis, and lengths along the profile.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::angles::{Angles, circle_center, radius, unit};
use super::hypothesis::Hypothesis;
use super::input::ChartInput;
use super::kind::Kind;
use super::settings::RevolvedSettings;
use super::traits::Chart;
use crate::cloud::Plane;
use crate::numeric::quantile;

const SETTINGS: RevolvedSettings = RevolvedSettings::STANDARD;

/// Tubes, sheets cut open and tori about the principal axes.
pub(super) struct Revolved;

impl Chart for Revolved {
    fn name(&self) -> &'static str {
        "revolved"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Sheet, Kind::Tube, Kind::Torus]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        const NAMES: [&str; 3] = ["revolved 1", "revolved 2", "revolved 3"];
        let around = NAMES.into_iter().enumerate().flat_map(|(axis, name)| {
            Cylindrical::about(input, axis).hypotheses(name, axis + 1 == NAMES.len())
        });
        around.collect()
    }
}

/// Cylindrical coordinates of points about a principal axis.
struct Cylindrical {
    angles: Angles,
    radius: f64,
    /// Distance from the axis and height along it, relative to their mean and in their principal
    /// axes.
    profile: Vec<DVec2>,
}

impl Cylindrical {
    /// The coordinates about the principal axis with this number. A long surface gets a bent axis.
    fn about(input: &ChartInput<'_>, axis: usize) -> Self {
        let (center, axes) = (input.observations.axes().center, input.observations.axes().axes);
        let (up, a, b) = (axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        let points = input.observations.points();
        let local = |point: &DVec3| {
            let apart = *point - center;
            (DVec2::new(apart.dot(a), apart.dot(b)), apart.dot(up))
        };
        let (mut places, heights): (Vec<DVec2>, Vec<f64>) = points.iter().map(local).unzip();
        let middle = circle_center(&places);
        for place in &mut places {
            *place -= middle;
        }
        if unit(&heights).1 > SETTINGS.min_bent_length * radius(&places)
            && let Some(line) = center_line(&places, &heights)
        {
            let along = places.iter_mut().zip(&heights);
            along.for_each(|(place, z)| *place -= line[0] + *z * (line[1] + *z * line[2]));
        }
        let profile: Vec<DVec3> = places
            .iter()
            .zip(&heights)
            .map(|(place, z)| DVec3::new(place.length(), *z, 0.0))
            .collect();
        let principal = Plane::of(profile.iter().copied());
        Self {
            radius: radius(&places),
            profile: profile.iter().map(|point| principal.local(*point).truncate()).collect(),
            angles: Angles::of(places.into_iter()),
        }
    }

    /// The tube, torus and open sheet in these coordinates. Only the shortest axis gives a torus.
    fn hypotheses(&self, name: &'static str, shortest: bool) -> Vec<Hypothesis> {
        let along: Vec<f64> = self.profile.iter().map(|point| point.x).collect();
        let (v, length) = unit(&along);
        let pairs = |u: &[f64], v: &[f64]| {
            u.iter().zip(v).map(|(u, v)| DVec2::new(*u, *v)).collect::<Vec<DVec2>>()
        };
        let mut found = Vec::new();
        if self.angles.closed() {
            let uv = pairs(&self.angles.turns, &v);
            found.push(Hypothesis::new(name, Kind::Tube, uv, [TAU * self.radius, length]));
            let around = Angles::of(self.profile.iter().copied());
            let section = radius(&self.profile);
            let nearest =
                quantile(self.profile.iter().map(|point| point.length()), SETTINGS.hollow_share);
            if shortest && around.closed() && nearest > SETTINGS.min_hollow_radius * section {
                let uv = pairs(&self.angles.turns, &around.turns);
                let lengths = [TAU * self.radius, TAU * section];
                found.push(Hypothesis::new(name, Kind::Torus, uv, lengths));
            }
        }
        if self.angles.gap() > SETTINGS.min_cut_gap {
            let uv = pairs(&self.angles.cut(), &v);
            let lengths = [(TAU - self.angles.gap()) * self.radius, length];
            found.push(Hypothesis::new(name, Kind::Sheet, uv, lengths));
        }
        found
    }
}

/// The quadratic fitted to the centers of circles in slices of equally many points.
fn center_line(places: &[DVec2], heights: &[f64]) -> Option<[DVec2; 3]> {
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|a, b| heights[*a].total_cmp(&heights[*b]));
    let slices = order
        .chunks(order.len().div_ceil(SETTINGS.slices))
        .filter(|slice| slice.len() >= SETTINGS.min_slice_points);
    let centers = slices.map(|slice| {
        let inside: Vec<DVec2> = slice.iter().map(|&i| places[i]).collect();
        let height = slice.iter().map(|&i| heights[i]).sum::<f64>() / slice.len() as f64;
        (height, circle_center(&inside))
    });
    quadratic(&centers.collect::<Vec<_>>())
}

/// The quadratic fitted to values at heights; `None` if they do not determine it.
fn quadratic(values: &[(f64, DVec2)]) -> Option<[DVec2; 3]> {
    let (mut matrix, mut right) = (glam::DMat3::ZERO, [DVec3::ZERO; 2]);
    for (z, value) in values {
        let row = DVec3::new(1.0, *z, z * z);
        matrix += glam::DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        right[0] += value.x * row;
        right[1] += value.y * row;
    }
    let [x, y] = right.map(|right| matrix.inverse() * right);
    let terms = [0, 1, 2].map(|k| DVec2::new(x[k], y[k]));
    terms.iter().all(|term| term.is_finite()).then_some(terms)
}
