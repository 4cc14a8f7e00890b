//! Clipping: the closed chains around a region, cut at the sides and seams of the rectangle.
//!
//! Parts outside of the rectangle go; parts beyond a seam move to the other side. Where a part ends
//! at the rectangle's border, the border is followed counter-clockwise to the next start of a part
//! (K. Weiler and P. Atherton 1977).

use glam::DVec2;

use super::arc::straight;
use super::closed_polygon::signed_area;
use super::places::Rectangle;
use crate::brep::crossings_with_line;
use crate::error::Result;
use crate::nurbs::NurbsCurve;
use crate::progress::Silent;

/// Curves this close to a side, as a share of the rectangle, lie on it.
const ON_SIDE: f64 = 1e-9;

/// A closed loop of curves in the rectangle, and the chains that it consists of.
#[derive(Clone, Debug)]
pub(super) struct ClippedLoop {
    pub curves: Vec<NurbsCurve>,
    pub chains: Vec<usize>,
}

/// A part of a chain inside the rectangle, from border to border.
#[derive(Clone, Debug)]
struct Run {
    chain: usize,
    curves: Vec<NurbsCurve>,
    /// The positions of its ends on the rectangle's border.
    ends: [f64; 2],
}

impl Run {
    fn new(chain: usize, mut curves: Vec<NurbsCurve>, rectangle: &Rectangle) -> Result<Self> {
        let last = curves.len() - 1;
        curves[0] = with_end(&curves[0], 0, rectangle)?;
        curves[last] = with_end(&curves[last], curves[last].control_points().len() - 1, rectangle)?;
        let ends = [start(&curves[0]), end(&curves[last])].map(|at| position(rectangle, at));
        Ok(Self { chain, curves, ends })
    }
}

/// The loops in the rectangle of the closed chains around one region. `is_sliver` judges parts that
/// begin and end at the same side.
pub(super) fn clipped(
    chains: &[&[NurbsCurve]],
    rectangle: &Rectangle,
    is_sliver: impl Fn(&[NurbsCurve]) -> bool,
) -> Result<Vec<ClippedLoop>> {
    let (mut loops, mut runs) = (vec![], vec![]);
    for (chain, curves) in chains.iter().enumerate() {
        match runs_of(chain, curves, rectangle)? {
            Cut::Whole(curves) => loops.push(ClippedLoop { curves, chains: vec![chain] }),
            Cut::Runs(found) => runs.extend(found),
        }
    }
    // Data that end at a side follow it: the sliver between them and the side is not a bay.
    runs.retain(|run| {
        let [from, to] = run.ends;
        !(from <= to && from.floor() == to.floor() && is_sliver(&run.curves))
    });
    let is_outer = |of: &ClippedLoop| signed_area(&of.curves) > 0.0;
    if runs.is_empty() && !loops.iter().any(is_outer) {
        let curves = (0..4).map(|k| straight(corner(rectangle, k), corner(rectangle, k + 1)));
        loops.push(ClippedLoop { curves: curves.collect::<Result<_>>()?, chains: vec![] });
    }
    loops.extend(joined(runs, rectangle)?);
    Ok(loops)
}

/// A chain inside the rectangle, or its parts.
enum Cut {
    Whole(Vec<NurbsCurve>),
    Runs(Vec<Run>),
}

/// Cuts a chain at the sides and seams.
fn runs_of(chain: usize, curves: &[NurbsCurve], rectangle: &Rectangle) -> Result<Cut> {
    let mut pieces = vec![];
    for curve in curves {
        for piece in divided(curve, rectangle)? {
            pieces.push(placed(&piece, rectangle)?);
        }
    }
    // The end of a chain that winds around is some turns ahead of its start.
    let way = (end(&curves[curves.len() - 1]) - start(&curves[0])) / rectangle.size();
    let turns = way.round();
    let is_cut = |k: usize| {
        let (before, after) = (pieces[(k + pieces.len() - 1) % pieces.len()].0, pieces[k].0);
        match (before, after) {
            (Some(before), Some(after)) => {
                before - if k == 0 { turns } else { DVec2::ZERO } != after
            }
            (before, after) => before != after,
        }
    };
    let cuts: Vec<usize> = (0..pieces.len()).filter(|k| is_cut(*k)).collect();
    if cuts.is_empty() {
        let is_inside = pieces.iter().any(|(turn, _)| turn.is_some());
        let curves = pieces.into_iter().map(|(_, curve)| curve).collect();
        return Ok(if is_inside { Cut::Whole(curves) } else { Cut::Runs(vec![]) });
    }
    let mut runs = vec![];
    for (i, &first) in cuts.iter().enumerate() {
        let last = cuts.get(i + 1).map_or(cuts[0] + pieces.len(), |next| *next);
        let own = (first..last).map(|k| &pieces[k % pieces.len()]);
        if pieces[first].0.is_some() {
            runs.push(Run::new(chain, own.map(|(_, curve)| curve.clone()).collect(), rectangle)?);
        }
    }
    Ok(Cut::Runs(runs))
}

/// The parts of a curve between sides and seams.
fn divided(curve: &NurbsCurve, rectangle: &Rectangle) -> Result<Vec<NurbsCurve>> {
    let mut cuts = vec![];
    let points = || curve.control_points().iter().map(|point| point.truncate());
    let low = points().reduce(DVec2::min).unwrap_or_default();
    let high = points().reduce(DVec2::max).unwrap_or_default();
    for d in 0..2 {
        for line in lines(rectangle, d, low[d], high[d]) {
            cuts.extend(crossings_with_line(curve, DVec2::AXES[d], line)?);
        }
    }
    cuts.sort_by(f64::total_cmp);
    let (from, to) = curve.knots().domain();
    cuts.dedup_by(|a, b| *a - *b <= 1e-9 * (to - from));
    cuts.retain(|at| (at - from).min(to - at) > 1e-9 * (to - from));
    let ends: Vec<f64> = [from].into_iter().chain(cuts).chain([to]).collect();
    if ends.len() == 2 {
        return Ok(vec![curve.clone()]);
    }
    ends.windows(2).map(|ends| curve.sub_curve(ends[0], ends[1], &mut Silent)).collect()
}

/// The lines of constant u or v at which curves between two values are cut.
fn lines(rectangle: &Rectangle, d: usize, low: f64, high: f64) -> Vec<f64> {
    let size = rectangle.size()[d];
    if !rectangle.closed[d] {
        let inset = ON_SIDE * size;
        return vec![rectangle.low[d] + inset, rectangle.high[d] - inset];
    }
    let mut line = rectangle.low[d] + size * ((low - rectangle.low[d]) / size).ceil();
    let mut lines = vec![];
    while line <= high {
        lines.push(line);
        line += size;
    }
    lines
}

/// The turns, of closed directions, in which a part lies, with the part moved into the rectangle;
/// no turns if it is outside.
fn placed(curve: &NurbsCurve, rectangle: &Rectangle) -> Result<(Option<DVec2>, NurbsCurve)> {
    let (from, to) = curve.knots().domain();
    let middle = (curve.point(0.5 * (from + to)).truncate() - rectangle.low) / rectangle.size();
    let mut turns = DVec2::ZERO;
    for d in 0..2 {
        if rectangle.closed[d] {
            turns[d] = middle[d].floor();
        } else if !(ON_SIDE..=1.0 - ON_SIDE).contains(&middle[d]) {
            return Ok((None, curve.clone()));
        }
    }
    if turns == DVec2::ZERO {
        return Ok((Some(turns), curve.clone()));
    }
    let step = (turns * rectangle.size()).extend(0.0);
    let points = curve.control_points().iter().map(|point| point - step).collect();
    Ok((Some(turns), NurbsCurve::new(points, None, curve.knots().clone())?))
}

/// A curve whose first or last control point is put on the nearest side of the rectangle.
fn with_end(curve: &NurbsCurve, k: usize, rectangle: &Rectangle) -> Result<NurbsCurve> {
    let mut points = curve.control_points().to_vec();
    let at = points[k].truncate();
    let (d, value) = nearest_side(rectangle, at);
    points[k][d] = value;
    NurbsCurve::new(points, None, curve.knots().clone())
}

/// The direction and value of the side nearest to a point.
fn nearest_side(rectangle: &Rectangle, at: DVec2) -> (usize, f64) {
    let share = (at - rectangle.low) / rectangle.size();
    let sides = [
        (share.x.abs(), 0, rectangle.low.x),
        ((1.0 - share.x).abs(), 0, rectangle.high.x),
        (share.y.abs(), 1, rectangle.low.y),
        ((1.0 - share.y).abs(), 1, rectangle.high.y),
    ];
    let nearest = sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(sides[0]);
    (nearest.1, nearest.2)
}

/// The position of a point on the border: 0 to 4 counter-clockwise, whole numbers at corners.
fn position(rectangle: &Rectangle, at: DVec2) -> f64 {
    let share = ((at - rectangle.low) / rectangle.size()).clamp(DVec2::ZERO, DVec2::ONE);
    match nearest_side(rectangle, at) {
        (1, value) if value == rectangle.low.y => share.x,
        (0, value) if value == rectangle.high.x => 1.0 + share.y,
        (1, _) => 3.0 - share.x,
        _ => 4.0 - share.y,
    }
}

/// A corner of the rectangle, counter-clockwise from the lowest.
fn corner(rectangle: &Rectangle, k: usize) -> DVec2 {
    let (low, high) = (rectangle.low, rectangle.high);
    [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)][k % 4]
}

/// Joins runs along the border to closed loops.
fn joined(mut runs: Vec<Run>, rectangle: &Rectangle) -> Result<Vec<ClippedLoop>> {
    let mut loops = vec![];
    while let Some(first) = runs.pop() {
        let (start_at, mut at) = (first.ends[0], first.ends[1]);
        let mut of = ClippedLoop { curves: first.curves, chains: vec![first.chain] };
        loop {
            // A start a rounding error behind is here.
            let ahead = |to: f64| (to - at + 1e-12).rem_euclid(4.0);
            let next = (0..runs.len())
                .min_by(|a, b| ahead(runs[*a].ends[0]).total_cmp(&ahead(runs[*b].ends[0])))
                .filter(|k| ahead(runs[*k].ends[0]) < ahead(start_at));
            let to = next.map_or(start_at, |k| runs[k].ends[0]);
            let goal = next.map_or_else(|| start(&of.curves[0]), |k| start(&runs[k].curves[0]));
            of.curves.extend(along_border(
                rectangle,
                (at, to),
                end(&of.curves[of.curves.len() - 1]),
                goal,
            )?);
            let Some(k) = next else { break };
            let run = runs.swap_remove(k);
            at = run.ends[1];
            of.curves.extend(run.curves);
            of.chains.push(run.chain);
        }
        loops.push(of);
    }
    Ok(loops)
}

/// Straight curves along the border from one position to another, counter-clockwise.
fn along_border(
    rectangle: &Rectangle,
    (from, to): (f64, f64),
    start: DVec2,
    goal: DVec2,
) -> Result<Vec<NurbsCurve>> {
    let to = if to + 1e-12 < from { to + 4.0 } else { to };
    let mut places = vec![start];
    let mut k = from.floor() + 1.0;
    while k < to {
        places.push(corner(rectangle, crate::numeric::whole(k)));
        k += 1.0;
    }
    places.push(goal);
    let least = 1e-12 * rectangle.size();
    let far = |pair: &&[DVec2]| (pair[1] - pair[0]).abs().cmpgt(least).any();
    places.windows(2).filter(far).map(|pair| straight(pair[0], pair[1])).collect()
}

/// The start of a curve.
fn start(curve: &NurbsCurve) -> DVec2 {
    curve.control_points()[0].truncate()
}

/// The end of a curve.
fn end(curve: &NurbsCurve) -> DVec2 {
    curve.control_points()[curve.control_points().len() - 1].truncate()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use glam::DVec3;

    fn square(closed: [bool; 2]) -> Rectangle {
        Rectangle { low: DVec2::ZERO, high: DVec2::ONE, closed }
    }

    fn circle(u: f64, v: f64, radius: f64) -> Vec<NurbsCurve> {
        let count = 12;
        let at = |k: i32| {
            let angle = f64::from(k) / f64::from(count) * TAU;
            DVec2::new(u, v) + radius * DVec2::from_angle(angle)
        };
        (0..count).map(|k| straight(at(k), at((k + 1) % count)).unwrap()).collect()
    }

    fn areas(chains: &[&[NurbsCurve]], closed: [bool; 2]) -> Vec<f64> {
        let loops = clipped(chains, &square(closed), |_| false).unwrap();
        loops.iter().map(|of| signed_area(&of.curves) / 2.0).collect()
    }

    #[test]
    fn parts_outside_of_the_rectangle_become_sides() {
        let whole = circle(0.5, 0.5, 0.3);
        let polygon = signed_area(&whole) / 2.0;
        assert!((polygon / (PI * 0.09) - 1.0).abs() < 0.05);
        assert_eq!(areas(&[&whole], [false; 2]), [polygon]);
        // A quarter, and all of the rectangle.
        let quarter = areas(&[&circle(0.0, 0.0, 0.3)], [false; 2]);
        assert!((quarter[0] - polygon / 4.0).abs() < 1e-8, "{quarter:?}");
        assert_eq!(areas(&[&circle(0.5, 0.5, 3.0)], [false; 2]), [1.0]);
        // A hole that opens to the side is a bay.
        let hole: Vec<NurbsCurve> =
            circle(0.0, 0.5, 0.3).iter().rev().map(|c| c.reversed(&mut Silent).unwrap()).collect();
        let bay = areas(&[&circle(0.5, 0.5, 3.0), &hole], [false; 2]);
        assert!(bay.len() == 1 && (bay[0] - 1.0 + polygon / 2.0).abs() < 1e-8, "{bay:?}");
    }

    #[test]
    fn loops_are_cut_at_seams() {
        // A disc on the seam is two halves of one face; a rim on a tube runs from seam to seam.
        let disc = areas(&[&circle(1.0, 0.5, 0.3)], [true, false]);
        let polygon = signed_area(&circle(0.5, 0.5, 0.3)) / 2.0;
        assert!(disc.len() == 2 && (disc.iter().sum::<f64>() - polygon).abs() < 1e-8);
        let rim = |v: f64, from: f64, way: f64| {
            let at = |k: i32| DVec2::new(from + way * f64::from(k) / 4.0, v);
            (0..4).map(|k| straight(at(k), at(k + 1)).unwrap()).collect::<Vec<_>>()
        };
        let (bottom, top) = (rim(0.2, 0.3, 1.0), rim(0.7, 0.6, -1.0));
        let loops = clipped(&[&bottom, &top], &square([true, false]), |_| false).unwrap();
        assert_eq!((loops.len(), loops[0].chains.len()), (1, 2));
        assert!((signed_area(&loops[0].curves) / 2.0 - 0.5).abs() < 1e-8);
        // A hole alone on a torus: the seams are the outer loop.
        let hole: Vec<NurbsCurve> =
            circle(0.5, 0.5, 0.3).iter().rev().map(|c| c.reversed(&mut Silent).unwrap()).collect();
        let torus = areas(&[&hole], [true; 2]);
        assert!(torus.len() == 2 && torus.contains(&1.0) && torus.contains(&-polygon));
    }

    #[test]
    fn slivers_at_a_side_belong_to_it() {
        let points = [(-0.1, -0.1), (0.5, 0.002), (1.1, -0.1), (1.1, 0.8), (-0.1, 0.8)];
        let at = |k: usize| {
            let (u, v) = points[k % points.len()];
            DVec3::new(u, v, 0.0)
        };
        let chain: Vec<NurbsCurve> =
            (0..points.len()).map(|k| NurbsCurve::line(at(k), at(k + 1)).unwrap()).collect();
        let curves = |is_sliver: bool| {
            let loops = clipped(&[&chain], &square([false; 2]), |_| is_sliver).unwrap();
            (loops.len(), loops[0].curves.len())
        };
        assert_eq!(curves(false), (1, 7));
        assert_eq!(curves(true), (1, 4));
    }
}
