//! Arcs: the smooth parts of a border between two corners.

use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};

use super::arc_length::shares;
use super::border::Border;
use super::level::{Closeness, Level};
use super::offset::outward;
use super::places::Rectangle;
use super::settings::{ArcSettings, SplineSettings};
use super::spline_fit::{Form, Targets};
use super::stretch::Stretch;
use crate::error::Result;
use crate::nurbs::NurbsCurve;

const SETTINGS: ArcSettings = ArcSettings::STANDARD;

/// A smooth part of a border, with the curve fitted to it.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    /// The place of its end on the border.
    pub last: usize,
    stretch: Stretch,
    curve: NurbsCurve,
    /// Control points; 2 for a straight line.
    count: usize,
    /// Share of the arc along which directions at its ends are measured: those of the curve itself
    /// are noisy.
    lever: f64,
}

impl Arc {
    /// The arc from a corner to the next, whose index may be a turn ahead.
    ///
    /// Places close to the corners are left out: the discs that found the border round them off.
    pub(super) fn fit(
        border: &Border,
        (first, last): (usize, usize),
        closeness: Closeness,
    ) -> Result<Self> {
        let stretch = Stretch::of(border, &[core(border, (first, last))]);
        let chosen = stretch.choose(border.spacing, closeness)?;
        let (curve, count) = match chosen {
            Some(fit) => (fit.curve, fit.count),
            None => (straight(border.uv_at(first), border.uv_at(last))?, 2),
        };
        let lever = (SETTINGS.lever * border.spacing / stretch.length).min(0.5);
        Ok(Self { last: last % border.len(), stretch, curve, count, lever })
    }

    /// The angle in space between its end and the start of the next arc.
    pub(super) fn bend(&self, next: &Self, tangents: [DVec3; 2]) -> f64 {
        let direction = |step: DVec2| in_space(step, tangents);
        let angle = direction(self.end().1).angle_between(direction(next.start().1));
        if angle.is_nan() { 0.0 } else { angle }
    }

    /// The arc moved outward, by the depth of its places times `offset`. A straight arc beside a
    /// side of the rectangle moves beyond the side: it becomes part of it.
    pub(super) fn moved(
        mut self,
        border: &Border,
        rectangle: &Rectangle,
        level: Level,
    ) -> Result<Self> {
        let depth: Vec<f64> = self.stretch.depth.iter().map(|depth| level.offset * depth).collect();
        let targets = self.stretch.targets();
        let moved = outward(&self.curve, &targets, &depth)?;
        let targets = Targets { uv: &moved, ..targets };
        let form = Form::Open([None; 2]);
        let fit = if moved.len() > self.count {
            targets.fit(form, self.count, SplineSettings::STANDARD.fairness)?
        } else {
            None
        };
        if let Some(fit) = fit {
            self.curve = fit.curve;
        }
        self.stretch.uv = moved;
        if self.count == 2 {
            self.snap(border, rectangle)?;
        }
        Ok(self)
    }

    /// Moves a straight arc whose ends are close to a side beyond the side.
    fn snap(&mut self, border: &Border, rectangle: &Rectangle) -> Result<()> {
        let [start, end] = [self.start().0, self.end().0];
        let near = SETTINGS.snap * border.spacing;
        for d in 0..2 {
            if rectangle.closed[d] {
                continue;
            }
            let speed =
                self.stretch.tangents.iter().map(|tangents| tangents[d].length()).sum::<f64>()
                    / self.stretch.tangents.len() as f64;
            for (side, outward) in [(rectangle.low[d], -1.0), (rectangle.high[d], 1.0)] {
                let is_near = |at: DVec2| (at[d] - side).abs() * speed < near;
                if is_near(start) && is_near(end) && speed > 0.0 {
                    let [mut start, mut end] = [start, end];
                    start[d] = side + outward * near / speed;
                    end[d] = start[d];
                    self.curve = straight(start, end)?;
                    for at in &mut self.stretch.uv {
                        at[d] = start[d];
                    }
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// The point at the start, and the direction there.
    fn start(&self) -> (DVec2, DVec2) {
        let start = self.curve.point(0.0).truncate();
        (start, self.curve.point(self.lever).truncate() - start)
    }

    /// The point at the end, and the direction there.
    fn end(&self) -> (DVec2, DVec2) {
        let end = self.curve.point(1.0).truncate();
        (end, end - self.curve.point(1.0 - self.lever).truncate())
    }

    /// Where the arc, moved back by a turn and carried on straight, meets the start of the next
    /// one. If that is farther from the corner than `reach`, it is halfway between the ends.
    pub(super) fn meeting(&self, next: &Self, turn: DVec2, border: &Border, reach: f64) -> DVec2 {
        let (end, along) = self.end();
        let (start, ahead) = next.start();
        let end = end - turn;
        let tangents = border.tangents[self.last];
        let corner = border.uv[self.last];
        let sine = along.perp_dot(ahead) / (along.length() * ahead.length());
        let meeting = end + along * ((start - end).perp_dot(ahead) / along.perp_dot(ahead));
        let near = |at: DVec2| in_space(at - corner, tangents).length() < reach;
        if sine.abs() > SETTINGS.min_sine && near(meeting) { meeting } else { 0.5 * (end + start) }
    }

    /// The arc's curve fitted again with given ends.
    pub(super) fn between(&self, start: DVec2, end: DVec2) -> Result<NurbsCurve> {
        if self.count == 2 || self.stretch.uv.len() <= self.count {
            return straight(start, end);
        }
        let all = [start].into_iter().chain(self.stretch.uv.iter().copied()).chain([end]);
        let all: Vec<DVec2> = all.collect();
        let tangent = |k: usize| self.stretch.tangents[k.min(self.stretch.tangents.len() - 1)];
        let steps = all.windows(2).enumerate();
        let at = shares(steps.map(|(k, pair)| in_space(pair[1] - pair[0], tangent(k)).length()));
        let inner = &at[1..at.len() - 1];
        let targets = Targets { at: inner, uv: &self.stretch.uv, tangents: &self.stretch.tangents };
        let form = Form::Open([Some(start), Some(end)]);
        match targets.fit(form, self.count, SplineSettings::STANDARD.fairness)? {
            Some(fit) => Ok(fit.curve),
            None => straight(start, end),
        }
    }
}

/// A straight curve in (u, v).
pub(super) fn straight(from: DVec2, to: DVec2) -> Result<NurbsCurve> {
    NurbsCurve::line(from.extend(0.0), to.extend(0.0))
}

/// A step in (u, v), in space.
pub(super) fn in_space(step: DVec2, [by_u, by_v]: [DVec3; 2]) -> DVec3 {
    step.x * by_u + step.y * by_v
}

/// The places from a corner to the next that are not rounded off.
pub(super) fn core(border: &Border, (first, last): (usize, usize)) -> RangeInclusive<usize> {
    let (start, length) = (border.along_at(first), border.along_at(last) - border.along_at(first));
    let cut = (SETTINGS.rounding * border.spacing).min(length * SETTINGS.rounding_share);
    let is_inner = |k: &usize| (cut..=length - cut).contains(&(border.along_at(*k) - start));
    let from = (first..=last).find(is_inner).unwrap_or(first);
    let to = (first..=last).rev().find(is_inner).unwrap_or(last);
    if to >= from + 2 { from..=to } else { first..=last }
}
