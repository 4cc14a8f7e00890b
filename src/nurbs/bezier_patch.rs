//! Bézier patches of a surface, for bounding boxes, closest points and integrals.
//!
//! On each pair of spans the surface is one polynomial or rational patch. Its Bézier control points
//! bound it, and they converge to it quadratically when the patch is halved.

use glam::{DVec2, DVec3, DVec4};

use super::basis::{Row, with_capacity};
use super::control_net::bounds;
use super::curve_family::CurveFamily;
use super::knot_vector::KnotVector;
use super::partials::Partials;
use super::surface::NurbsSurface;
use super::work_blocks::collect_in_steps;
use crate::error::Result;
use crate::progress::InterruptCheck;

/// A part of a surface over a rectangle of its parameters, in Bézier form.
#[derive(Clone, Debug)]
pub(crate) struct BezierPatch {
    /// Homogeneous control points, row by row.
    net: Vec<DVec4>,
    degree_u: usize,
    degree_v: usize,
    pub u: (f64, f64),
    pub v: (f64, f64),
}

impl BezierPatch {
    /// Returns the patches of a surface, row by row, and their numbers along u and v.
    pub(crate) fn of(
        surface: &NurbsSurface,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<(Vec<Self>, (usize, usize))> {
        let whole = surface.bezier_form(check_interrupt)?;
        let (degree_u, degree_v) = (whole.knots_u().degree(), whole.knots_v().degree());
        let (u, v) = (whole.knots_u().breaks(), whole.knots_v().breaks());
        let (net, cols) = (whole.homogeneous(), whole.shape().1);
        let patch = |i: usize, j: usize| {
            let row = |k: usize| &net[(i * degree_u + k) * cols + j * degree_v..][..=degree_v];
            let net = (0..=degree_u).flat_map(row).copied().collect();
            Self { net, degree_u, degree_v, u: (u[i], u[i + 1]), v: (v[j], v[j + 1]) }
        };
        let shape = (u.len() - 1, v.len() - 1);
        let patches = collect_in_steps(shape, check_interrupt, |rows| {
            rows.flat_map(|i| (0..shape.1).map(move |j| patch(i, j)))
        })?;
        Ok((patches, shape))
    }

    /// Returns the pieces of a curve as patches of degree 0 in v.
    pub(super) fn of_curves(
        curve: &CurveFamily,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Vec<Self>> {
        let form = curve.bezier_form(check_interrupt)?;
        let (degree_u, breaks) = (form.knots.degree(), form.knots.breaks());
        let (degree_v, v) = (0, (0.0, 1.0));
        let patch = |(k, ends): (usize, &[f64])| {
            let net = form.points[k * degree_u..=(k + 1) * degree_u].to_vec();
            Self { net, degree_u, degree_v, u: (ends[0], ends[1]), v }
        };
        Ok(breaks.windows(2).enumerate().map(patch).collect())
    }

    /// The homogeneous control points, row by row.
    pub(super) fn net(&self) -> &[DVec4] {
        &self.net
    }

    /// Returns the patch as a surface.
    pub(super) fn surface(&self, rational: bool) -> Result<NurbsSurface> {
        let knots_u = KnotVector::clamped(self.degree_u, self.u, [])?;
        let knots_v = KnotVector::clamped(self.degree_v, self.v, [])?;
        let knots = [knots_u, knots_v];
        NurbsSurface::from_homogeneous(self.net.clone(), rational, knots, &mut || Ok(()))
    }

    /// Moves the center of the patch's bounding box to the origin, where rounding is smallest.
    /// Returns the moved patch and the diagonal of the box.
    pub(crate) fn centered(&self) -> (Self, f64) {
        let (low, high) = bounds(self.points());
        let middle = low.midpoint(high);
        let net = self.net.iter().map(|h| (h.truncate() - h.w * middle).extend(h.w));
        (Self { net: net.collect(), ..self.clone() }, low.distance(high))
    }

    /// The control points in space.
    pub(crate) fn points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.net.iter().map(|h| h.truncate() / h.w)
    }

    /// The control point in row i and column j.
    pub(super) fn control(&self, i: usize, j: usize) -> DVec3 {
        let h = self.homogeneous(i, j);
        h.truncate() / h.w
    }

    /// The homogeneous control point in row i and column j.
    pub(super) fn homogeneous(&self, i: usize, j: usize) -> DVec4 {
        self.net[i * (self.degree_v + 1) + j]
    }

    /// The rectangle of parameters, as its smallest and largest corner.
    pub(super) fn rectangle(&self) -> [DVec2; 2] {
        [DVec2::new(self.u.0, self.v.0), DVec2::new(self.u.1, self.v.1)]
    }

    /// The degrees in u and v.
    pub(crate) fn degrees(&self) -> (usize, usize) {
        (self.degree_u, self.degree_v)
    }

    /// Halves the patch in u (de Casteljau's algorithm; The NURBS Book, A1.7).
    pub(super) fn halves_u(&self) -> (Self, Self) {
        let ((start, end), middle) = (self.u, f64::midpoint(self.u.0, self.u.1));
        let stride = self.degree_v + 1;
        let (mut first, mut second) = (self.clone(), self.clone());
        halve(&mut first.net, &mut second.net, self.degree_u, stride, 0..stride);
        (first.u, second.u) = ((start, middle), (middle, end));
        (first, second)
    }

    /// Halves the patch in v.
    pub(super) fn halves_v(&self) -> (Self, Self) {
        let ((start, end), middle) = (self.v, f64::midpoint(self.v.0, self.v.1));
        let (stride, rows) = (self.degree_v + 1, self.degree_u + 1);
        let (mut first, mut second) = (self.clone(), self.clone());
        let starts = (0..rows).map(|row| row * stride);
        halve(&mut first.net, &mut second.net, self.degree_v, 1, starts);
        (first.v, second.v) = ((start, middle), (middle, end));
        (first, second)
    }

    /// Evaluates the point with its first and second derivatives at (s, t) in the unit square.
    pub(super) fn partials(&self, s: f64, t: f64) -> Partials {
        let degree = self.degree_u.max(self.degree_v);
        with_capacity!(degree, CAPACITY => self.partials_within::<CAPACITY>(s, t))
    }

    /// The same for degrees below `CAPACITY`.
    fn partials_within<const CAPACITY: usize>(&self, s: f64, t: f64) -> Partials {
        let rows = bernstein::<CAPACITY>(self.degree_u, s);
        let columns = bernstein::<CAPACITY>(self.degree_v, t);
        let mut sums = [DVec4::ZERO; 6];
        for (k, row) in self.net.chunks_exact(self.degree_v + 1).enumerate() {
            let mut along = [DVec4::ZERO; 3];
            for (l, point) in row.iter().enumerate() {
                for (sum, factors) in along.iter_mut().zip(&columns) {
                    *sum += factors[l] * *point;
                }
            }
            sums[0] += rows[0][k] * along[0];
            sums[1] += rows[1][k] * along[0];
            sums[2] += rows[0][k] * along[1];
            sums[3] += rows[2][k] * along[0];
            sums[4] += rows[1][k] * along[1];
            sums[5] += rows[0][k] * along[2];
        }
        Partials::new(sums)
    }

    /// Evaluates the homogeneous point with its first derivatives at (s, t) in the unit square.
    pub(super) fn tangents(&self, s: f64, t: f64) -> [DVec4; 3] {
        let degree = self.degree_u.max(self.degree_v);
        with_capacity!(degree, CAPACITY => self.tangents_within::<CAPACITY>(s, t))
    }

    /// The same for degrees below `CAPACITY`.
    fn tangents_within<const CAPACITY: usize>(&self, s: f64, t: f64) -> [DVec4; 3] {
        let rows = bernstein::<CAPACITY>(self.degree_u, s);
        let columns = bernstein::<CAPACITY>(self.degree_v, t);
        let mut sums = [DVec4::ZERO; 3];
        for (k, row) in self.net.chunks_exact(self.degree_v + 1).enumerate() {
            let mut along = [DVec4::ZERO; 2];
            for (l, point) in row.iter().enumerate() {
                along[0] += columns[0][l] * *point;
                along[1] += columns[1][l] * *point;
            }
            sums[0] += rows[0][k] * along[0];
            sums[1] += rows[1][k] * along[0];
            sums[2] += rows[0][k] * along[1];
        }
        sums
    }

    /// Sums the rows of the net weighted by `factors`: the control points of an isocurve.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(crate) fn row<const CAPACITY: usize>(
        &self,
        factors: &Row<CAPACITY>,
    ) -> BezierPatchRow<CAPACITY> {
        let mut points = [DVec4::ZERO; CAPACITY];
        for (row, factor) in self.net.chunks_exact(self.degree_v + 1).zip(factors) {
            points.iter_mut().zip(row).for_each(|(sum, point)| *sum += *factor * *point);
        }
        BezierPatchRow { points, order: self.degree_v + 1 }
    }

    /// The parameters of the surface at shares of the patch's sides.
    pub(super) fn parameters(&self, s: f64, t: f64) -> (f64, f64) {
        let place = |(start, end): (f64, f64), share: f64| {
            if share == 1.0 { end } else { start + share * (end - start) }
        };
        (place(self.u, s), place(self.v, t))
    }
}

/// Homogeneous control points of an isocurve of a patch.
pub(crate) struct BezierPatchRow<const CAPACITY: usize> {
    points: [DVec4; CAPACITY],
    order: usize,
}

impl<const CAPACITY: usize> BezierPatchRow<CAPACITY> {
    /// Sums the control points weighted by `factors`.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(crate) fn sum(&self, factors: &Row<CAPACITY>) -> DVec4 {
        let points = self.points[..self.order].iter().zip(factors);
        points.map(|(point, factor)| *factor * *point).sum()
    }
}

/// Splits Bézier curves of this degree at their middle.
///
/// A curve begins at each of `starts`, and its control points are `stride` apart. `first` and
/// `second` initially contain the same curves; they become the first and second halves.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(crate) fn halve(
    first: &mut [DVec4],
    second: &mut [DVec4],
    degree: usize,
    stride: usize,
    starts: impl IntoIterator<Item = usize>,
) {
    for start in starts {
        for level in 1..=degree {
            for k in (level..=degree).rev() {
                let at = start + k * stride;
                first[at] = 0.5 * (first[at] + first[at - stride]);
            }
            second[start + (degree - level) * stride] = first[start + degree * stride];
        }
    }
}

/// Evaluates the Bernstein polynomials of a degree below `CAPACITY` at `t`, with first and second
/// derivatives.
pub(crate) fn bernstein<const CAPACITY: usize>(degree: usize, t: f64) -> [Row<CAPACITY>; 3] {
    let mut rows = [[0.0; CAPACITY]; 3];
    let mut values = [0.0; CAPACITY];
    values[0] = 1.0;
    for k in 0..=degree {
        if k > 0 {
            let mut carried = 0.0;
            for value in &mut values[..k] {
                let (kept, passed) = ((1.0 - t) * *value, t * *value);
                *value = carried + kept;
                carried = passed;
            }
            values[k] = carried;
        }
        if let Some(row) = rows.get_mut(degree - k) {
            *row = values;
            for level in k + 1..=degree {
                let mut carried = 0.0;
                for value in &mut row[..level] {
                    let share = level as f64 * *value;
                    *value = carried - share;
                    carried = share;
                }
                row[level] = carried;
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn halves_and_partials_agree_with_the_surface() {
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0)
            .unwrap()
            .elevate_degree(0, 2, &mut Silent)
            .unwrap();
        let (patches, shape) = BezierPatch::of(&torus, &mut || Ok(())).unwrap();
        assert_eq!((shape, patches.len()), ((4, 4), 16));
        for patch in &patches {
            let ((a, b), (c, d)) = (patch.halves_u(), patch.halves_v());
            for piece in [patch, &a, &b, &c, &d, &b.halves_v().1] {
                for (s, t) in [(0.0, 0.0), (0.3, 0.9), (0.5, 0.5), (1.0, 0.2)] {
                    let (u, v) = piece.parameters(s, t);
                    let (here, there) = (piece.partials(s, t), torus.partials(u, v));
                    assert!(here.point.distance(there.point) < 1e-14);
                    let (du, dv) = (piece.u.1 - piece.u.0, piece.v.1 - piece.v.0);
                    // At a knot the derivatives of the surface are those of the next patch.
                    if s < 1.0 {
                        assert!(here.u.distance(there.u * du) < 1e-12);
                        assert!(here.vv.distance(there.vv * dv * dv) < 1e-12);
                        assert!(here.uv.distance(there.uv * du * dv) < 1e-12);
                        assert!(here.uu.distance(there.uu * du * du) < 1e-12);
                    }
                }
            }
        }
    }
}
