//! A face as strips for integrals: its curves, cut where they cross knots of the surface.
//!
//! On each patch, the region of the face is bounded by the parts of curves on it and by parts of
//! its upper side. Each has a strip down to the lower side; the lateral sides have none.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::crease::split_at;
use super::face::Face;
use super::loops::bridged;
use super::plane_curves::crossings_with_line;
use super::strip::{Integrand, SizedPatch, Strip};
use crate::error::Result;
use crate::nurbs::{BezierCurve, BezierPatch, NurbsCurve, interrupt_check};
use crate::progress::Observer;

/// Cuts closer than this share of a curve's domain are one, and parts of a patch's upper side
/// narrower than this share of it are rounding.
const ROUNDING: f64 = 1e-13;

/// The strips whose integrals sum up to that over a face, with the origin moved to `origin`.
pub(super) fn strips(
    face: &Face,
    integrand: Integrand,
    origin: DVec3,
    observer: &mut dyn Observer,
) -> Result<Vec<Strip>> {
    let surface = face.surface().transformed(&DAffine3::from_translation(-origin))?;
    let (patches, (_, rows)) = BezierPatch::of(&surface, &mut interrupt_check(observer))?;
    let patches = patches.into_iter().map(|patch| Arc::new(SizedPatch::new(patch))).collect();
    let sign = match integrand {
        Integrand::Volume if face.is_reversed() => -1.0,
        Integrand::Volume | Integrand::Area => 1.0,
    };
    let breaks = [surface.knots_u().breaks(), surface.knots_v().breaks()];
    let mut columns: Vec<Vec<(usize, BezierCurve)>> = vec![vec![]; breaks[0].len() - 1];
    for of_loop in face.loops() {
        for curve in bridged(of_loop)? {
            for part in split_at_breaks(curve, &breaks)? {
                for piece in BezierCurve::of(&part)? {
                    let [middle, ..] = piece.derivatives(0.5);
                    let (i, j) = (span(&breaks[0], middle.x), span(&breaks[1], middle.y));
                    columns[i].push((j, piece));
                }
            }
        }
    }
    let lowest = face.outer().curves().iter().flat_map(NurbsCurve::control_points);
    let lowest = lowest.map(|point| point.y).fold(f64::INFINITY, f64::min);
    let grid = Grid { patches, rows, breaks, lowest, sign, integrand };
    Ok(columns.into_iter().enumerate().flat_map(|(i, pieces)| grid.column(i, pieces)).collect())
}

/// Splits a curve in (u, v) where it crosses the knots of a surface.
fn split_at_breaks(curve: NurbsCurve, breaks: &[Vec<f64>; 2]) -> Result<Vec<NurbsCurve>> {
    let mut cuts = vec![];
    for (k, axis) in [DVec2::X, DVec2::Y].into_iter().enumerate() {
        let along = || curve.control_points().iter().map(|point| point[k]);
        let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::MIN, f64::max));
        for &value in breaks[k].iter().filter(|value| low < **value && **value < high) {
            cuts.extend(crossings_with_line(&curve, axis, value)?);
        }
    }
    let (start, end) = curve.knots().domain();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| *a - *b <= ROUNDING * (end - start));
    split_at(curve, cuts)
}

/// The index of the span that contains a value; the nearest one outside of all.
fn span(breaks: &[f64], value: f64) -> usize {
    breaks[1..breaks.len() - 1].partition_point(|knot| *knot <= value)
}

/// The patches of a face's surface.
struct Grid {
    patches: Vec<Arc<SizedPatch>>,
    /// The number of patches along v.
    rows: usize,
    breaks: [Vec<f64>; 2],
    /// A v below the whole face. Bases as high as possible keep strips small.
    lowest: f64,
    sign: f64,
    integrand: Integrand,
}

impl Grid {
    /// The strips in a column of patches, from the pieces of curves in it with their rows.
    fn column(&self, i: usize, mut pieces: Vec<(usize, BezierCurve)>) -> Vec<Strip> {
        let (from, to) = (self.breaks[0][i], self.breaks[0][i + 1]);
        pieces.sort_by_key(|(j, _)| *j);
        let mut strips = vec![];
        // Places on the upper side of the row where the number of times that the face lies below
        // the curves above changes.
        let mut changes: Vec<(f64, i32)> = vec![];
        for j in (0..self.rows).rev() {
            let top = self.breaks[1][j + 1];
            for (a, b, times) in intervals(&mut changes, ROUNDING * (to - from)) {
                let side = BezierCurve::line(DVec3::new(b, top, 0.0), DVec3::new(a, top, 0.0));
                let strip = self.strip((i, j), side);
                strips.push(Strip { sign: strip.sign * f64::from(times), ..strip });
            }
            while pieces.last().is_some_and(|(row, _)| *row == j) {
                let Some((_, piece)) = pieces.pop() else { break };
                let (start, end) = (piece.start().x, piece.end().x);
                let times = if end < start { 1 } else { -1 };
                changes.extend([(start.min(end), times), (start.max(end), -times)]);
                strips.push(self.strip((i, j), piece));
            }
        }
        strips
    }

    fn strip(&self, (i, j): (usize, usize), curve: BezierCurve) -> Strip {
        Strip {
            patch: Arc::clone(&self.patches[i * self.rows + j]),
            curve: Arc::new(curve),
            base: self.breaks[1][j].max(self.lowest),
            sign: self.sign,
            integrand: self.integrand,
            along: (0.0, 1.0),
            across: (0.0, 1.0),
        }
    }
}

/// The intervals longer than `shortest` between changes of a count, with the count where it is not
/// zero. Sorts the changes.
fn intervals(changes: &mut [(f64, i32)], shortest: f64) -> Vec<(f64, f64, i32)> {
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<(f64, f64, i32)> = vec![];
    let mut times = 0;
    for pair in changes.windows(2) {
        times += pair[0].1;
        let (from, to) = (pair[0].0, pair[1].0);
        if times == 0 || to - from <= shortest {
            continue;
        }
        match found.last_mut() {
            Some(last) if last.2 == times && from - last.1 <= shortest => last.1 = to,
            _ => found.push((from, to, times)),
        }
    }
    found
}
