//! Strips between a line of constant v and a curve above or below it, inside one Bézier patch.
//!
//! By Green's theorem, the strips along the curves around a region make up an integral over it.

use std::sync::Arc;

use glam::DVec3;

use crate::nurbs::{
    BezierCurve, BezierPatch, Estimates, MAX_ORDER, NODE_COUNTS, Region, bernstein, gauss,
};

/// Estimates of an integral agree up to rounding if they differ by less than this fraction of an
/// upper bound of the integrals of its terms.
const ROUNDING: f64 = 4e-15;

/// What is integrated.
#[derive(Clone, Copy, Debug)]
pub(super) enum Integrand {
    /// The element of area.
    Area,
    /// The element of the volume of the cone from the origin: positive if the normal points away.
    Volume,
}

/// A Bézier patch with the size of its rounding errors.
#[derive(Debug)]
pub(super) struct SizedPatch {
    patch: BezierPatch,
    /// The diagonal of the box around the control points.
    extent: f64,
    /// The distance of the farthest control point from the origin.
    reach: f64,
}

impl SizedPatch {
    pub(super) fn new(patch: BezierPatch) -> Self {
        let low = patch.points().fold(DVec3::INFINITY, DVec3::min);
        let high = patch.points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let reach = patch.points().map(DVec3::length).fold(0.0, f64::max);
        Self { patch, extent: low.distance(high), reach }
    }
}

/// A part of the strip between a line of constant v and a curve: the lines from the curve to it,
/// for a part of the curve, cut at two shares of their length.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    pub patch: Arc<SizedPatch>,
    /// The curve in (u, v).
    pub curve: Arc<BezierCurve>,
    /// The v of the line.
    pub base: f64,
    /// 1, or -1 for a reversed face.
    pub sign: f64,
    pub integrand: Integrand,
    /// The shares of the curve's parameter.
    pub along: (f64, f64),
    /// The shares of the lines from the base to the curve.
    pub across: (f64, f64),
}

/// Nodes and weights of the three rules.
pub(super) fn rules() -> [Vec<(f64, f64)>; 3] {
    NODE_COUNTS.map(gauss::rule)
}

impl Region for Strip {
    type Rules = [Vec<(f64, f64)>; 3];

    fn estimates(&self, rules: &Self::Rules) -> Estimates {
        let [(value, bound), (second, _), (third, _)] =
            rules.each_ref().map(|rule| self.integrate(rule));
        Estimates { values: [value, second, third], rounding: ROUNDING * bound }
    }

    fn quarters(&self) -> [Self; 4] {
        let halves = |(from, to): (f64, f64)| {
            let middle = f64::midpoint(from, to);
            [(from, middle), (middle, to)]
        };
        let (along, across) = (halves(self.along), halves(self.across));
        [0, 1, 2, 3].map(|k| Self { along: along[k / 2], across: across[k % 2], ..self.clone() })
    }
}

impl Strip {
    /// The integral by a rule, and an upper bound of that of its terms.
    fn integrate(&self, rule: &[(f64, f64)]) -> (f64, f64) {
        let SizedPatch { patch, extent, reach } = &*self.patch;
        let (degree_u, degree_v) = patch.degrees();
        let (length_u, length_v) = (patch.u.1 - patch.u.0, patch.v.1 - patch.v.0);
        let base = (self.base - patch.v.0) / length_v;
        let place = |(from, to): (f64, f64), share: f64| from + share * (to - from);
        let size = (self.along.1 - self.along.0) * (self.across.1 - self.across.0);
        let (mut sum, mut bound) = (0.0, 0.0);
        for (share, weight) in rule {
            let [at, velocity, _] = self.curve.derivatives(place(self.along, *share));
            let height = (at.y - patch.v.0) / length_v - base;
            // A curve above the base has the region on its left if it runs against u.
            let area = -self.sign * size * weight * height * velocity.x / length_u;
            let [values, slopes, _] =
                bernstein::<MAX_ORDER>(degree_u, (at.x - patch.u.0) / length_u);
            let (row, row_slopes) = (patch.row(&values), patch.row(&slopes));
            for (share, weight) in rule {
                let [values, slopes, _] =
                    bernstein::<MAX_ORDER>(degree_v, base + place(self.across, *share) * height);
                let value = row.sum(&values);
                let point = value.truncate() / value.w;
                let tangent = |d: glam::DVec4| (d.truncate() - d.w * point) / value.w;
                let (by_u, by_v) = (tangent(row_slopes.sum(&values)), tangent(row.sum(&slopes)));
                let (normal, lengths) = (by_u.cross(by_v), by_u.length() + by_v.length());
                let (element, terms) = match self.integrand {
                    Integrand::Area => (normal.length(), extent * lengths),
                    Integrand::Volume => (point.dot(normal) / 3.0, reach * extent * lengths),
                };
                sum += weight * area * element;
                bound += weight * area.abs() * terms;
            }
        }
        (sum, bound)
    }
}
