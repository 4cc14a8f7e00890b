//! Clipping: the closed chains around a region, cut at the sides and seams of the rectangle.
//!
//! Parts outside of the rectangle go; parts beyond a seam move to the other side. Where a part ends
//! at the rectangle's border, the border is followed counter-clockwise to the next start of a part
//! (K. Weiler and P. Atherton 1977).

use glam::DVec2;

use super::arc::straight;
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
    let mut pieces: Vec<(Option<[i64; 2]>, NurbsCurve)> = vec![];
    for curve in curves {
        for piece in divided(curve, rectangle)? {
            pieces.push(placed(&piece, rectangle)?);
        }
    }
    let first =
        (0..pieces.len()).find(|k| pieces[*k].0 != pieces[(k + pieces.len() - 1) % pieces.len()].0);
    let Some(first) = first else {
        let is_inside = pieces.first().is_some_and(|(cell, _)| cell.is_some());
        let curves = pieces.into_iter().map(|(_, curve)| curve).collect();
        return Ok(if is_inside { Cut::Whole(curves) } else { Cut::Runs(vec![]) });
    };
    pieces.rotate_left(first);
    let groups = pieces.chunk_by(|a, b| a.0 == b.0).filter(|group| group[0].0.is_some());
    let runs = groups.map(|group| {
        Run::new(chain, group.iter().map(|(_, curve)| curve.clone()).collect(), rectangle)
    });
    Ok(Cut::Runs(runs.collect::<Result<_>>()?))
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

/// The turn in which a part lies, with the part moved into the rectangle; no turn if it is outside.
fn placed(curve: &NurbsCurve, rectangle: &Rectangle) -> Result<(Option<[i64; 2]>, NurbsCurve)> {
    let (from, to) = curve.knots().domain();
    let middle = (curve.point(0.5 * (from + to)).truncate() - rectangle.low) / rectangle.size();
    let mut cell = [0; 2];
    let mut moved = DVec2::ZERO;
    for d in 0..2 {
        if rectangle.closed[d] {
            moved[d] = middle[d].floor();
            #[expect(clippy::cast_possible_truncation, reason = "a few turns")]
            (cell[d] = moved[d] as i64);
        } else if !(ON_SIDE..=1.0 - ON_SIDE).contains(&middle[d]) {
            return Ok((None, curve.clone()));
        }
    }
    if moved == DVec2::ZERO {
        return Ok((Some(cell), curve.clone()));
    }
    let step = (moved * rectangle.size()).extend(0.0);
    let points = curve.control_points().iter().map(|point| point - step).collect();
    Ok((Some(cell), NurbsCurve::new(points, None, curve.knots().clone())?))
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
pub(super) fn start(curve: &NurbsCurve) -> DVec2 {
    curve.control_points()[0].truncate()
}

/// The end of a curve.
pub(super) fn end(curve: &NurbsCurve) -> DVec2 {
    curve.control_points()[curve.control_points().len() - 1].truncate()
}

/// Twice the area inside a closed loop, from samples; positive if it is counter-clockwise.
pub(super) fn signed_area(curves: &[NurbsCurve]) -> f64 {
    polygon_area(&sampled(curves))
}

/// Twice the signed area of a polygon.
fn polygon_area(polygon: &[DVec2]) -> f64 {
    let origin = polygon[0];
    let count = polygon.len();
    (0..count).map(|k| (polygon[k] - origin).perp_dot(polygon[(k + 1) % count] - origin)).sum()
}

/// Points along a closed loop: some for each control point.
pub(super) fn sampled(curves: &[NurbsCurve]) -> Vec<DVec2> {
    let points = |curve: &NurbsCurve| {
        let (from, to) = curve.knots().domain();
        let count = if curve.knots().degree() == 1 { 1 } else { 4 * curve.control_points().len() };
        let step = (to - from) / count as f64;
        (0..count).map(|k| curve.point(from + step * k as f64).truncate()).collect::<Vec<_>>()
    };
    curves.iter().flat_map(points).collect()
}

/// Whether a point is inside a polygon, by even and odd crossings.
pub(super) fn is_inside(polygon: &[DVec2], at: DVec2) -> bool {
    let mut inside = false;
    for k in 0..polygon.len() {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        if (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}
