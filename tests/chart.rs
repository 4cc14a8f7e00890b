//! A new chart takes one type and one entry in the list of charts.

use std::f64::consts::TAU;

use glam::DMat3;
use neurbs::chart::{CHARTS, Chart, ChartInput, Hypothesis, Kind};
use neurbs::observe::{Observations, ObserveSettings};
use neurbs::pipeline::{RankingSettings, rank};
use neurbs::progress::Silent;
use neurbs::{DVec2, DVec3};

/// A sheet rolled up about z, whose radius grows linearly from 1.
struct Spiral {
    /// Growth of the radius per turn.
    pitch: f64,
}

impl Chart for Spiral {
    fn name(&self) -> &'static str {
        "spiral"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Sheet]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        let turns = |point: &DVec3| {
            let angle = (point.y.atan2(point.x) / TAU).rem_euclid(1.0);
            let radius = point.truncate().length();
            angle + ((radius - 1.0) / self.pitch - angle).round()
        };
        let places =
            input.observations.points().iter().map(|point| DVec2::new(turns(point), point.z));
        let places: Vec<DVec2> = places.collect();
        let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = high - low;
        let uv = places.iter().map(|place| (*place - low) / size).collect();
        let around = TAU * (1.0 + 0.5 * self.pitch * size.x) * size.x;
        vec![Hypothesis::new(self.name(), Kind::Sheet, uv, [around, size.y])]
    }
}

/// A roll of three turns; the distance of its layers is about the spacing of its points.
fn roll(pitch: f64) -> Vec<DVec3> {
    let at = |i: u32| {
        let (a, b) = (0.754_877_666_246_693, 0.569_840_290_998_053);
        let turns = 3.0 * (0.5 + a * f64::from(i)).fract();
        let (angle, radius) = (TAU * turns, 1.0 + pitch * turns);
        let z = 2.0 * (0.5 + b * f64::from(i)).fract();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    (0..1200).map(at).collect()
}

#[test]
fn an_additional_chart_is_ranked_and_wins_where_it_fits_best() {
    let pitch = 0.2;
    let points = roll(pitch);
    let spiral = Spiral { pitch };
    let charts: Vec<&dyn Chart> = CHARTS.into_iter().chain([&spiral as &dyn Chart]).collect();
    let observations = Observations::of(&points, ObserveSettings::default());
    let settings = RankingSettings::default();
    let ranked = |charts| {
        rank(&observations, DMat3::IDENTITY, None, charts, &settings, &mut Silent).unwrap()
    };
    let (with, without) = (ranked(&charts), ranked(&CHARTS));
    assert!(with.models.len() > 1);
    let best = &with.models[0];
    assert_eq!((best.hypothesis.chart, best.hypothesis.kind), ("spiral", Kind::Sheet));
    assert!(without.models.iter().all(|model| model.hypothesis.chart != "spiral"));
}
