//! B-spline basis functions and their derivatives at one parameter (The NURBS Book, chapter 2).

use super::knot_vector::{KnotVector, MAX_DEGREE};

/// Maximal number of nonzero basis functions at one parameter.
pub(crate) const MAX_ORDER: usize = MAX_DEGREE + 1;

/// The nonzero basis functions at one parameter, with their first derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basis<const ORDER: usize> {
    /// Index of the control point of the first function.
    pub first: usize,
    /// The values.
    pub values: [f64; ORDER],
    /// The derivatives with respect to the parameter.
    pub slopes: [f64; ORDER],
}

impl<const ORDER: usize> Basis<ORDER> {
    /// Evaluates the `ORDER = degree + 1` nonzero basis functions at `u` (The NURBS Book, A2.2 and
    /// equation 2.7).
    ///
    /// In the step from degree k - 1 to degree k, each function passes one part to its right
    /// neighbor and keeps the rest.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(crate) fn at(knots: &KnotVector, u: f64) -> Self {
        let span = knots.span(u);
        let t = knots.as_slice();
        let from = window::<_, ORDER>(t, span + 1 - ORDER).map(|knot| u - knot);
        let to = window::<_, ORDER>(t, span + 1).map(|knot| knot - u);
        let mut values = [0.0; ORDER];
        let mut slopes = [0.0; ORDER];
        values[0] = 1.0;
        for k in 1..ORDER {
            let reciprocals = window::<_, ORDER>(knots.reciprocals(k), span + 1);
            let (mut carried, mut carried_slope) = (0.0, 0.0);
            for i in 0..k {
                let share = values[i] * reciprocals[i];
                values[i] = carried + to[i] * share;
                carried = from[ORDER - k + i] * share;
                if k == ORDER - 1 {
                    slopes[i] = carried_slope - k as f64 * share;
                    carried_slope = k as f64 * share;
                }
            }
            values[k] = carried;
            slopes[k] = carried_slope;
        }
        Self { first: span + 1 - ORDER, values, slopes }
    }

    /// Appends zeros up to `MAX_ORDER` functions.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn padded(self) -> Basis<MAX_ORDER> {
        let mut padded = Basis { first: self.first, ..Basis::default() };
        padded.values[..ORDER].copy_from_slice(&self.values);
        padded.slopes[..ORDER].copy_from_slice(&self.slopes);
        padded
    }
}

impl<const ORDER: usize> Default for Basis<ORDER> {
    fn default() -> Self {
        Self { first: 0, values: [0.0; ORDER], slopes: [0.0; ORDER] }
    }
}

/// Evaluates an expression in which a constant is the order (degree + 1) of a degree that is only
/// known at run time.
macro_rules! with_order {
    ($degree:expr, $order:ident => $body:expr) => {
        with_order!($degree, $order => $body, 1 2 3 4 5 6 7 8)
    };
    ($degree:expr, $order:ident => $body:expr, $($known:literal)*) => {
        match $degree {
            $($known => {
                const $order: usize = $known + 1;
                $body
            })*
            _ => {
                const $order: usize = $crate::nurbs::MAX_DEGREE + 1;
                $body
            }
        }
    };
}
pub(super) use with_order;

/// Returns the `N` items from index `first`.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(crate) fn window<T, const N: usize>(items: &[T], first: usize) -> &[T; N] {
    items[first..].first_chunk().expect("spans lie inside their tables")
}

/// Evaluates [`Basis::at`] for a degree that is only known at run time.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(crate) fn padded(knots: &KnotVector, u: f64) -> Basis<MAX_ORDER> {
    // Most surfaces are cubic, so this degree is inlined in every caller.
    if knots.degree() == 3 { Basis::<4>::at(knots, u).padded() } else { padded_of_any(knots, u) }
}

/// Writes the `degree + 1` nonzero basis functions at `u` to `values`, for a degree that is only
/// known at run time. Returns the index of the control point of the first function.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(crate) fn values_at(knots: &KnotVector, u: f64, values: &mut [f64]) -> usize {
    // Avoids writing the padding to memory.
    if knots.degree() == 3 {
        let basis = Basis::<4>::at(knots, u);
        values.copy_from_slice(&basis.values);
        return basis.first;
    }
    let basis = padded_of_any(knots, u);
    values.copy_from_slice(&basis.values[..values.len()]);
    basis.first
}

fn padded_of_any(knots: &KnotVector, u: f64) -> Basis<MAX_ORDER> {
    with_order!(knots.degree(), ORDER => Basis::<ORDER>::at(knots, u).padded())
}

/// Values or derivatives of one order; the entries after the first `degree + 1` are zero.
pub(crate) type Row = [f64; MAX_ORDER];

/// The nonzero basis functions at one parameter, with derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BasisDerivatives<const ROWS: usize> {
    /// Index of the control point of the first function.
    pub first: usize,
    /// `rows[k]` contains the k-th derivatives.
    pub rows: [Row; ROWS],
}

impl<const ROWS: usize> BasisDerivatives<ROWS> {
    /// Evaluates the basis functions at `u` and their derivatives up to order `ROWS - 1`.
    pub(crate) fn at(knots: &KnotVector, u: f64) -> Self {
        let mut rows = [[0.0; MAX_ORDER]; ROWS];
        Self { first: derivatives(knots, u, &mut rows), rows }
    }
}

/// Writes the k-th derivatives of the basis functions at `u` to `rows[k]` (The NURBS Book,
/// equations 2.5 and 2.7). Returns the index of the control point of the first function. Costs
/// O(degree²) for each order.
pub(super) fn derivatives(knots: &KnotVector, u: f64, rows: &mut [Row]) -> usize {
    let (degree, span) = (knots.degree(), knots.span(u));
    let t = knots.as_slice();
    rows.fill([0.0; MAX_ORDER]);
    let mut values = [0.0; MAX_ORDER];
    values[0] = 1.0;
    for k in 0..=degree {
        if k > 0 {
            let reciprocals = &knots.reciprocals(k)[span + 1..];
            let mut carried = 0.0;
            for i in 0..k {
                let share = values[i] * reciprocals[i];
                values[i] = carried + (t[span + 1 + i] - u) * share;
                carried = (u - t[span + 1 + i - k]) * share;
            }
            values[k] = carried;
        }
        // Functions of degree k need one differentiation for each remaining degree.
        if let Some(row) = rows.get_mut(degree - k) {
            *row = values;
            (k + 1..=degree).for_each(|level| raise(knots, span, level, row));
        }
    }
    span - degree
}

/// Turns functions of degree `level - 1` into the derivatives of the functions of degree `level`.
fn raise(knots: &KnotVector, span: usize, level: usize, row: &mut [f64; MAX_ORDER]) {
    let reciprocals = &knots.reciprocals(level)[span + 1..];
    let mut carried = 0.0;
    for i in 0..level {
        let share = level as f64 * row[i] * reciprocals[i];
        row[i] = carried - share;
        carried = share;
    }
    row[level] = carried;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The recursive definition by Cox and de Boor, without optimization.
    fn definition(t: &[f64], i: usize, p: usize, u: f64) -> f64 {
        if p == 0 {
            return f64::from(u8::from(t[i] <= u && u < t[i + 1]));
        }
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        ratio(u - t[i], t[i + p] - t[i]) * definition(t, i, p - 1, u)
            + ratio(t[i + p + 1] - u, t[i + p + 1] - t[i + 1]) * definition(t, i + 1, p - 1, u)
    }

    /// Equation 2.7: a derivative is a difference of two functions of the next lower degree.
    fn derivative(t: &[f64], i: usize, p: usize, u: f64, order: usize) -> f64 {
        if order == 0 {
            return definition(t, i, p, u);
        }
        let part = |i: usize| {
            let width = t[i + p] - t[i];
            if width > 0.0 { p as f64 * derivative(t, i, p - 1, u, order - 1) / width } else { 0.0 }
        };
        part(i) - part(i + 1)
    }

    fn knots(p: usize) -> KnotVector {
        let inner = [0.2, 0.2, 0.5, 0.55];
        let inner = if p == 1 { &inner[1..] } else { &inner[..] };
        KnotVector::clamped(p, (0.0, 1.0), inner.to_vec()).unwrap()
    }

    #[test]
    fn values_and_derivatives_follow_the_definition() {
        for p in 1..=6 {
            let knots = knots(p);
            let t = knots.as_slice();
            for u in (0..100).map(|step| f64::from(step) / 100.0) {
                let mut rows = vec![[f64::NAN; MAX_ORDER]; p + 2];
                let first = derivatives(&knots, u, &mut rows);
                for (order, row) in rows.iter().enumerate().take(p + 1) {
                    let size = row.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
                    for (k, value) in row.iter().enumerate().take(p + 1) {
                        let expected = derivative(t, first + k, p, u, order);
                        assert!((value - expected).abs() < 1e-13 * size, "{p} {u} {order}");
                    }
                }
                assert_eq!(rows[p + 1], [0.0; MAX_ORDER]);
            }
        }
    }

    fn fast_agrees<const ORDER: usize>() {
        let knots = knots(ORDER - 1);
        for u in (-10..110).map(|step| f64::from(step) / 100.0) {
            let fast = Basis::<ORDER>::at(&knots, u);
            let any = BasisDerivatives::<2>::at(&knots, u);
            assert_eq!(fast.values, padded(&knots, u).values[..ORDER]);
            let mut values = [0.0; ORDER];
            assert_eq!((values_at(&knots, u, &mut values), values), (fast.first, fast.values));
            assert_eq!(fast.first, any.first);
            for k in 0..ORDER {
                let size = 1.0 + any.rows[1][k].abs();
                assert!((fast.values[k] - any.rows[0][k]).abs() < 1e-14 * size);
                assert!((fast.slopes[k] - any.rows[1][k]).abs() < 1e-14 * size);
            }
        }
    }

    #[test]
    fn unrolled_and_general_functions_agree() {
        fast_agrees::<2>();
        fast_agrees::<3>();
        fast_agrees::<4>();
        fast_agrees::<6>();
        fast_agrees::<10>();
    }
}
