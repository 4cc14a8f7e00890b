//! The curves of a border: smooth arcs between corners, moved out to the true border.

use glam::DVec2;

use super::arc::Arc;
use super::border::Border;
use super::corner_check::checked;
use super::corners::Candidates;
use super::level::Level;
use super::offset::outward;
use super::places::Rectangle;
use super::settings::{ArcSettings, SplineSettings};
use super::spline_fit::{Form, Targets};
use crate::error::Result;
use crate::nurbs::NurbsCurve;

const SETTINGS: ArcSettings = ArcSettings::STANDARD;

/// A closed chain of curves in (u, v), unwrapped.
#[derive(Clone, Debug)]
pub(super) struct LoopCurves {
    pub curves: Vec<NurbsCurve>,
    pub corners: usize,
}

/// The curves of a border; `None` if the places do not determine them.
pub(super) fn loop_curves(
    border: &Border,
    rectangle: &Rectangle,
    level: Level,
) -> Result<Option<LoopCurves>> {
    let mut corners = match level.corner_cost {
        Some(cost) => checked(border, Candidates::of(border), cost)?,
        None => vec![],
    };
    while !corners.is_empty() {
        let arcs = arcs(border, &corners, level)?;
        let count = arcs.len();
        let bends = |k: usize| {
            let angle = arcs[k].bend(&arcs[(k + 1) % count], border.tangents[arcs[k].last]);
            angle >= SETTINGS.min_bend.to_radians()
        };
        let sharp: Vec<usize> = (0..count).filter(|k| bends(*k)).map(|k| arcs[k].last).collect();
        if sharp.len() == count {
            let arcs = arcs
                .into_iter()
                .map(|arc| arc.moved(border, rectangle, level))
                .collect::<Result<Vec<_>>>()?;
            let curves = joined(border, &arcs)?;
            return Ok(Some(LoopCurves { curves, corners: count }));
        }
        corners = sharp;
        corners.sort_unstable();
    }
    let smooth = smooth(border, level)?;
    Ok(smooth.map(|curve| LoopCurves { curves: vec![curve], corners: 0 }))
}

/// The arcs between corners, each from one to the next.
fn arcs(border: &Border, corners: &[usize], level: Level) -> Result<Vec<Arc>> {
    let count = border.len();
    let next = |k: usize| match corners.get(k + 1) {
        Some(corner) => *corner,
        None => corners[0] + count,
    };
    (0..corners.len()).map(|k| Arc::fit(border, (corners[k], next(k)), level.closeness)).collect()
}

/// One periodic curve through all places, moved outward.
fn smooth(border: &Border, level: Level) -> Result<Option<NurbsCurve>> {
    let length = border.length();
    let at: Vec<f64> = border.along[..border.len()].iter().map(|along| along / length).collect();
    let form = Form::Periodic(border.shift);
    let targets = |uv| Targets { at: &at, uv, tangents: &border.tangents };
    let chosen = targets(&border.uv).choose(form, (border.spacing, length), level.closeness)?;
    let Some(fit) = chosen else { return Ok(None) };
    let depth: Vec<f64> = border.depth.iter().map(|depth| level.offset * depth).collect();
    let moved = outward(&fit.curve, &targets(&border.uv), &depth)?;
    let fit = targets(&moved).fit(form, fit.count, SplineSettings::STANDARD.fairness)?;
    Ok(fit.map(|fit| fit.curve))
}

/// The curves of arcs that end where they meet.
fn joined(border: &Border, arcs: &[Arc]) -> Result<Vec<NurbsCurve>> {
    let count = arcs.len();
    let turn = |k: usize| if k == 0 { border.shift } else { DVec2::ZERO };
    let meetings: Vec<DVec2> = (0..count)
        .map(|k| {
            // The arc before the first one is a turn behind.
            arcs[(k + count - 1) % count].meeting(
                &arcs[k],
                turn(k),
                border,
                SETTINGS.reach * border.spacing,
            )
        })
        .collect();
    (0..count)
        .map(|k| {
            let end = meetings[(k + 1) % count] + turn((k + 1) % count);
            arcs[k].between(meetings[k], end)
        })
        .collect()
}
