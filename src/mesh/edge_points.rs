//! The points that divide a shell's edge into chords. Both faces take them.
//!
//! An edge is halved in its parameter until every chord is close to the surfaces of its faces, over
//! the strip of (u, v) between the curve and the straight line that replaces it.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::edge_use::EdgeUse;
use super::options::Limits;
use crate::brep::Shell;
use crate::error::Result;

/// Largest distance of a chord from the surfaces, as a share of the tolerance. Triangles on both
/// sides of an edge that bends across and along it sag about twice as far as the edge.
const CHORD_SHARE: f64 = 0.5;

/// How often an edge is halved at most.
const MAX_HALVINGS: u32 = 20;

/// Share of the tolerance up to which gaps between the faces' edges are part of it.
const GAP_SHARE: f64 = 0.25;

/// A point of an edge.
#[derive(Clone, Debug)]
pub(super) struct EdgePoint {
    pub point: DVec3,
    /// The parameters of the curves in (u, v) of the uses.
    at: Vec<f64>,
    /// The parameters on the surfaces of the uses.
    pub uv: Vec<DVec2>,
}

/// The points of an edge, ends included, in its direction.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgePoints {
    pub points: Vec<EdgePoint>,
    /// For each chord and each use, how far the curve in (u, v) is from the straight line.
    pub bulges: Vec<Vec<f64>>,
    /// The largest certified distance of a chord.
    pub deviation: f64,
}

/// The tolerance for triangles with a corner that is this far from its place on the surface.
pub(super) fn tolerance_with_gap(limits: &Limits, gap: f64) -> f64 {
    limits.tolerance.max((1.0 - GAP_SHARE) * limits.tolerance + gap)
}

/// The division of one edge.
struct Division<'a> {
    uses: Vec<EdgeUse<'a>>,
    limits: &'a Limits,
    /// Distance within which two points are the same.
    near: f64,
    found: EdgePoints,
}

/// Divides an edge of a shell, halved at least `least` times. Of a `known` division, the chords with
/// the indices `again` are halved once more.
pub(super) fn divide(
    shell: &Shell,
    (edge, least): (usize, u32),
    scales: &[DVec2],
    limits: &Limits,
    known: Option<(&EdgePoints, &BTreeSet<usize>)>,
) -> Result<EdgePoints> {
    let of = &shell.edges()[edge];
    let uses: Result<Vec<EdgeUse>> = of
        .uses
        .iter()
        .map(|place| {
            let coedge = &shell.coedges(place.face)[place.in_loop][place.place];
            let face = &shell.faces()[place.face];
            EdgeUse::new(face, &coedge.curve, coedge.forward, scales[place.face])
        })
        .collect();
    let found = EdgePoints::default();
    let mut this = Division { uses: uses?, limits, near: shell.tolerance(), found };
    if let Some((known, again)) = known {
        this.start(known.points[0].clone());
        for (k, pair) in known.points.windows(2).enumerate() {
            this.halve(pair, u32::from(again.contains(&k)), MAX_HALVINGS);
        }
    } else {
        let ends = [0, 1].map(|end| {
            let at: Vec<f64> = this.uses.iter().map(|used| used.ends()[end]).collect();
            let uv = this.uses.iter().zip(&at).map(|(used, at)| used.uv(*at)).collect();
            EdgePoint { point: shell.vertices()[of.vertices[end]], at, uv }
        });
        this.start(ends[0].clone());
        this.halve(&ends, least, MAX_HALVINGS);
    }
    Ok(this.found)
}

impl Division<'_> {
    fn start(&mut self, point: EdgePoint) {
        self.found.points.push(point);
    }

    /// Appends the points after the first of a pair, halved `least` times at least.
    fn halve(&mut self, pair: &[EdgePoint], least: u32, most: u32) {
        let [a, b] = pair else { return };
        let fine = if least > 0 { None } else { self.certified(a, b) };
        if fine.is_none() && most > 0 {
            let middle = self.middle(a, b);
            let (least, most) = (least.saturating_sub(1), most - 1);
            self.halve(&[a.clone(), middle.clone()], least, most);
            self.halve(&[middle, b.clone()], least, most);
            return;
        }
        let bound = fine.unwrap_or_else(|| self.distance(a, b, f64::INFINITY));
        self.found.deviation = self.found.deviation.max(bound);
        let bulge = |(k, used): (usize, &EdgeUse<'_>)| used.bulge([a.at[k], b.at[k]]);
        self.found.bulges.push(self.uses.iter().enumerate().map(bulge).collect());
        self.found.points.push(b.clone());
    }

    /// The point halfway along the first use.
    fn middle(&self, a: &EdgePoint, b: &EdgePoint) -> EdgePoint {
        let first = 0.5 * (a.at[0] + b.at[0]);
        let point = self.uses[0].point(first);
        let mut at = vec![first];
        for (k, used) in self.uses.iter().enumerate().skip(1) {
            at.push(used.closest(point, [a.at[k], b.at[k]], self.near));
        }
        let uv = self.uses.iter().zip(&at).map(|(used, at)| used.uv(*at)).collect();
        EdgePoint { point, at, uv }
    }

    /// The largest distance of the ends from their places on the surfaces.
    fn gap(&self, a: &EdgePoint, b: &EdgePoint) -> f64 {
        let of = |at: &EdgePoint| {
            let gaps = self.uses.iter().zip(&at.at).map(|(used, t)| used.point(*t));
            gaps.map(|point| point.distance(at.point)).fold(0.0, f64::max)
        };
        of(a).max(of(b))
    }

    fn chord_limit(&self, a: &EdgePoint, b: &EdgePoint) -> f64 {
        let gap = self.gap(a, b);
        (CHORD_SHARE * self.limits.tolerance).max(GAP_SHARE * self.limits.tolerance + gap)
    }

    /// An upper bound of the distance of the surfaces from a chord.
    fn distance(&mut self, a: &EdgePoint, b: &EdgePoint, limit: f64) -> f64 {
        let ends = [a.point, b.point];
        let mut most = 0.0_f64;
        for (k, used) in self.uses.iter_mut().enumerate() {
            most = most.max(used.bound([a.at[k], b.at[k]], ends, limit));
        }
        most
    }

    /// The certified distance of a chord within the limits.
    fn certified(&mut self, a: &EdgePoint, b: &EdgePoint) -> Option<f64> {
        if self.limits.edge.is_some_and(|most| a.point.distance(b.point) > most) {
            return None;
        }
        if let Some(cosine) = self.limits.cosine {
            let turned = |(k, used): (usize, &EdgeUse<'_>)| {
                used.normal(a.at[k]).dot(used.normal(b.at[k])) < cosine
            };
            if self.uses.iter().enumerate().any(turned) {
                return None;
            }
        }
        let limit = self.chord_limit(a, b);
        Some(self.distance(a, b, limit)).filter(|bound| *bound <= limit)
    }
}
