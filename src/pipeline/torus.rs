//! The torus that points lie on whose loops were not both seen.

use glam::{DVec2, DVec3};

use super::Start;
use super::candidate::{Candidate, Placed, Wanted};
use super::job::Fit;
use super::report::Clock;
use super::shape::Shape;
use crate::error::Result;
use crate::fit::lengths;
use crate::nurbs::Outside;
use crate::progress::Observer;
use crate::topology::{Chart, Cloud, Kind, hardly_ends, ring};
use crate::validate::{Body, excursion};

/// How near to one another the ends of a tube are that meet, as a share of its length and in spacings of its points:
/// those of tori whose other loop was too short to be seen had a sixth and 1.3, other tubes three quarters of their
/// length.
const MEETING: (f64, f64) = (0.25, 2.0);

/// How near a torus is to the points then, as a share of the distances of what was found, which had more freedom.
const NEARLY_AS_NEAR: f64 = 2.0;

/// Places along and around a tube that tell whether its ends meet, and points that tell where a torus is.
const LOOKED_AT: usize = 33;
const CHARTED: usize = 2000;

/// Fewer points show no torus, and so many show both of its loops; and how many show that they lie all over one where
/// nothing else does: noisy ones of half as many may lie near a torus whatever they lie on.
const FEWEST: usize = 60;
const LONG: usize = 3000;
const TELLING: usize = 200;

/// How far the places of a torus are from the nearest point at most, and how thick it is at least, in spacings of
/// its points: tori of 150 to 600 points had 1.7 and 1.2, and those that were fitted to what is none 2 or more, or
/// 0.95 and less.
const EMPTIEST: f64 = 1.8;
const THINNEST: f64 = 1.1;

/// How near a sheet is to its points, by root mean square and in their spacings, that goes through no torus: the thinnest
/// would be half as far again.
const CLOSELY: f64 = 0.5;

impl<'a> Wanted<'a> {
    /// The torus instead of a tube or a sheet that was found out, if it is as near to the points: of one that is
    /// thick, or of few points, a loop may be too short to be seen.
    pub(super) fn or_torus(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let free = self.options.kind.is_none() && self.options.init == Start::Auto;
        let (kind, sample) = (found.job.shape.kind, &self.placed.sample);
        if !free || !matches!(kind, Kind::Sheet | Kind::Tube) {
            return Ok(found);
        }
        let few = (FEWEST..LONG).contains(&sample.len());
        if few && ring(sample).is_some() {
            return match self.torus(None, clock, observer) {
                Ok(torus) if !torus.is_body(0.0, observer)? => Ok(found),
                torus => found.or_nearer(torus, NEARLY_AS_NEAR, self.near_enough()),
            };
        }
        let chart = if kind == Kind::Tube { found.closed_across(observer)? } else { None };
        let mut found = found;
        let closed = || self.seen.map_or_else(|| hardly_ends(sample), Cloud::hardly_ends);
        let may_be_closed = || sample.len() >= TELLING && closed() && !found.follows_to_an_end();
        if few && (chart.is_some() || may_be_closed()) {
            match self.torus(None, clock, observer) {
                Ok(torus) if !torus.is_body(THINNEST, observer)? => {}
                torus => found = found.or_nearer(torus, NEARLY_AS_NEAR, self.near_enough())?,
            }
        }
        match chart.filter(|_| found.job.shape.kind == Kind::Tube) {
            Some(chart) => {
                let torus = self.torus(Some(&chart), clock, observer);
                found.or_nearer(torus, NEARLY_AS_NEAR, self.near_enough())
            }
            None => Ok(found),
        }
    }

    /// Where few points of a torus are on the one around a circle, if that is near to them: angles between landmarks
    /// are rough.
    pub(super) fn around_circle(&self, shape: &Shape) -> Option<Chart> {
        let Placed { frame, sample, .. } = self.placed;
        let free = self.options.init == Start::Auto && shape.kind == Kind::Torus;
        let chart = (free && sample.len() < LONG).then(|| ring(sample)).flatten()?;
        Some(frame.undo_chart(chart))
    }

    fn torus(
        &self,
        chart: Option<&Chart>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        self.candidate(Shape::new(Kind::Torus, None), chart, clock, observer)
    }
}

impl Candidate<'_> {
    /// The points where a tube has them, as on a torus, if its ends meet.
    fn closed_across(&self, observer: &mut dyn Observer) -> Result<Option<Chart>> {
        let Fit { surface, uv, .. } = &self.fit;
        let domains = [surface.knots_u().domain(), surface.knots_v().domain()];
        let [(start, end), ends] = domains;
        let u = |i: usize| start + (end - start) * i as f64 / (LOOKED_AT - 1) as f64;
        let [first, last] = [ends.0, ends.1].map(|v| -> Result<Vec<DVec3>> {
            let uv: Vec<DVec2> = (0..LOOKED_AT).map(|i| DVec2::new(u(i), v)).collect();
            let mut places = vec![DVec3::ZERO; uv.len()];
            surface.evaluate(&uv, &mut places, Outside::Refuse, observer)?;
            Ok(places)
        });
        let last = last?;
        let apart =
            |from: DVec3| last.iter().map(|to| from.distance(*to)).fold(f64::INFINITY, f64::min);
        let mut apart: Vec<f64> = first?.into_iter().map(apart).collect();
        apart.sort_by(f64::total_cmp);
        let (around, along) = lengths(surface);
        let (gap, spacing) = (apart[LOOKED_AT / 2], (along * around / uv.len() as f64).sqrt());
        if gap > MEETING.0 * along || gap > MEETING.1 * spacing {
            return Ok(None);
        }
        let step = uv.len().div_ceil(CHARTED).max(1);
        let points = self.job.points.iter().step_by(step).copied().collect();
        let place = |uv: &DVec2| {
            let [u, v] = [0, 1].map(|d| (uv[d] - domains[d].0) / (domains[d].1 - domains[d].0));
            DVec2::new(u, v * along / (along + gap))
        };
        let uv: Vec<DVec2> = uv.iter().step_by(step).map(place).collect();
        let lengths = (around, along + gap);
        let chart = Chart { points, uv, lengths, closed_v: true };
        let chart = self.placed.frame.undo_chart(chart);
        // The ring is the longer way.
        Ok(Some(if lengths.0 < lengths.1 { chart.transposed() } else { chart }))
    }

    /// Whether a sheet follows its points closely to where they end: noise hides that of them, but not of their feet.
    fn follows_to_an_end(&self) -> bool {
        let Fit { surface, uv, distances, .. } = &self.fit;
        let (rows, columns) = lengths(surface);
        let spacing = (rows * columns / uv.len() as f64).sqrt();
        let closely = self.flaws.count() == 0 && self.job.rms(distances) < CLOSELY * spacing;
        let foot = |uv: &DVec2| surface.point(uv.x, uv.y);
        closely && !hardly_ends(&uv.iter().map(foot).collect::<Vec<_>>())
    }

    /// Whether it is at least so many spacings thick, which a sheet that is covered twice is not, and points lie all
    /// over it: tori through the middle of what is closed otherwise come as near to them.
    fn is_body(&self, thinnest: f64, observer: &mut dyn Observer) -> Result<bool> {
        let Body { area, volume } = Body::of(&self.fit.surface, observer)?;
        let spacing = (area / self.job.points.len() as f64).sqrt();
        if 2.0 * volume < thinnest * spacing * area {
            return Ok(false);
        }
        let emptiest = excursion(&self.fit.surface, self.job.points, observer)?.distance;
        Ok(emptiest <= EMPTIEST * spacing)
    }
}
