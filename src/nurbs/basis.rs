//! B-spline basis functions and their derivatives at one parameter (The NURBS Book, chapter 2).

use super::knot_vector::{KnotVector, MAX_DEGREE};

/// Maximal number of nonzero basis functions at one parameter.
pub(crate) const MAX_ORDER: usize = MAX_DEGREE + 1;

/// Order up to which inner loops are compiled for each order. Higher degrees are rare; loops over
/// them have lengths known at run time.
pub(crate) const MAX_COMPILED_ORDER: usize = 10;

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
    /// Evaluates the nonzero basis functions at `u` (The NURBS Book, A2.2 and equation 2.7).
    ///
    /// `ORDER` is that of [`with_order`]. Functions after the first `degree + 1` are zero.
    ///
    /// In the step from degree k - 1 to degree k, each function passes one part to its right
    /// neighbor and keeps the rest.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(crate) fn at(knots: &KnotVector, u: f64) -> Self {
        if ORDER == MAX_ORDER {
            return Self::of_any_degree(knots, u);
        }
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

    /// Evaluates the functions by loops whose lengths are known at run time.
    fn of_any_degree(knots: &KnotVector, u: f64) -> Self {
        let BasisDerivatives { first, rows: [values, slopes] } =
            BasisDerivatives::<2, ORDER>::at(knots, u);
        Self { first, values, slopes }
    }

    /// Appends zeros, or drops those at the end, up to `CAPACITY` functions.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn padded<const CAPACITY: usize>(self) -> Basis<CAPACITY> {
        let mut padded = Basis { first: self.first, ..Basis::default() };
        let count = ORDER.min(CAPACITY);
        padded.values[..count].copy_from_slice(&self.values[..count]);
        padded.slopes[..count].copy_from_slice(&self.slopes[..count]);
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
///
/// For degrees above 9, which are rare, the constant is [`MAX_ORDER`]; [`order_of`] then returns
/// the order.
macro_rules! with_order {
    ($degree:expr, $order:ident => $body:expr) => {
        with_order!($degree, $order => $body, 1 2 3 4 5 6 7 8 9)
    };
    ($degree:expr, $order:ident => $body:expr, $($known:literal)*) => {
        match $degree {
            $($known => {
                const $order: usize = $known + 1;
                $body
            })*
            _ => {
                const $order: usize = $crate::nurbs::MAX_ORDER;
                $body
            }
        }
    };
}
pub(super) use with_order;

/// Evaluates an expression in which a constant is the capacity of rows for a degree: short for
/// degrees up to 9, because clearing and copying of long rows takes longer than most sums.
macro_rules! with_capacity {
    ($degree:expr, $capacity:ident => $body:expr) => {
        if $degree < $crate::nurbs::MAX_COMPILED_ORDER {
            const $capacity: usize = $crate::nurbs::MAX_COMPILED_ORDER;
            $body
        } else {
            const $capacity: usize = $crate::nurbs::MAX_ORDER;
            $body
        }
    };
}
pub(super) use with_capacity;

/// The order of a degree for which [`with_order`] chose `ORDER`; a constant for degrees up to 9.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(super) fn order_of<const ORDER: usize>(degree: usize) -> usize {
    if ORDER == MAX_ORDER { degree + 1 } else { ORDER }
}

/// Returns the `N` items from index `first`.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(crate) fn window<T, const N: usize>(items: &[T], first: usize) -> &[T; N] {
    items[first..].first_chunk().expect("spans lie inside their tables")
}

/// Evaluates [`Basis::at`] for a degree that is only known at run time and below `CAPACITY`.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(crate) fn padded<const CAPACITY: usize>(knots: &KnotVector, u: f64) -> Basis<CAPACITY> {
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
    values_of_any(knots, u, values)
}

fn values_of_any(knots: &KnotVector, u: f64, values: &mut [f64]) -> usize {
    with_order!(knots.degree(), ORDER => {
        let basis = Basis::<ORDER>::at(knots, u);
        values.copy_from_slice(&basis.values[..values.len()]);
        basis.first
    })
}

fn padded_of_any<const CAPACITY: usize>(knots: &KnotVector, u: f64) -> Basis<CAPACITY> {
    with_order!(knots.degree(), ORDER => Basis::<ORDER>::at(knots, u).padded())
}

/// Values or derivatives of one order; the entries after the first `degree + 1` are zero.
pub(crate) type Row<const CAPACITY: usize = MAX_ORDER> = [f64; CAPACITY];

/// The nonzero basis functions at one parameter, with derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BasisDerivatives<const ROWS: usize, const CAPACITY: usize = MAX_ORDER> {
    /// Index of the control point of the first function.
    pub first: usize,
    /// `rows[k]` contains the k-th derivatives.
    pub rows: [Row<CAPACITY>; ROWS],
}

impl<const ROWS: usize, const CAPACITY: usize> BasisDerivatives<ROWS, CAPACITY> {
    /// Evaluates the basis functions at `u` and their derivatives up to order `ROWS - 1`.
    pub(crate) fn at(knots: &KnotVector, u: f64) -> Self {
        let mut rows = [[0.0; CAPACITY]; ROWS];
        Self { first: derivatives(knots, u, &mut rows), rows }
    }
}

/// Writes the k-th derivatives of the basis functions at `u` to `rows[k]` (The NURBS Book,
/// equations 2.5 and 2.7). Returns the index of the control point of the first function. Costs
/// O(degree²) for each order.
///
/// Rows of orders above the degree stay as they are, so they must be zero.
pub(super) fn derivatives<const CAPACITY: usize>(
    knots: &KnotVector,
    u: f64,
    rows: &mut [Row<CAPACITY>],
) -> usize {
    let (degree, span) = (knots.degree(), knots.span(u));
    let t = knots.as_slice();
    let mut values = [0.0; CAPACITY];
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
fn raise(knots: &KnotVector, span: usize, level: usize, row: &mut [f64]) {
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
                let mut rows = vec![[0.0; MAX_ORDER]; p + 2];
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

    /// Between two knots of full multiplicity the functions are Bernstein polynomials.
    #[test]
    fn functions_of_high_degree_are_bernstein_polynomials() {
        for p in 10..=MAX_DEGREE {
            let knots = KnotVector::clamped(p, (0.0, 1.0), []).unwrap();
            let ways =
                |n: usize, k: usize| (1..=k).fold(1.0, |w, i| w * (n + 1 - i) as f64 / i as f64);
            let bernstein = |n: usize, k: usize, x: f64| {
                let power = |x: f64, k: usize| x.powf(k as f64);
                if k > n { 0.0 } else { ways(n, k) * power(x, k) * power(1.0 - x, n - k) }
            };
            for x in (0..=40).map(|step| f64::from(step) / 40.0) {
                let basis = padded::<MAX_ORDER>(&knots, x);
                let mut values = vec![0.0; p + 1];
                assert_eq!(values_at(&knots, x, &mut values), 0);
                assert_eq!(values, basis.values[..=p]);
                for (k, value) in values.iter().enumerate() {
                    assert!((value - bernstein(p, k, x)).abs() < 1e-14, "{p} {k} {x}");
                    let before = if k > 0 { bernstein(p - 1, k - 1, x) } else { 0.0 };
                    let slope = p as f64 * (before - bernstein(p - 1, k, x));
                    assert!((basis.slopes[k] - slope).abs() < 1e-14 * p as f64, "{p} {k} {x}");
                }
            }
        }
    }

    fn fast_agrees<const ORDER: usize>() {
        let knots = knots(ORDER - 1);
        for u in (-10..110).map(|step| f64::from(step) / 100.0) {
            let fast = Basis::<ORDER>::at(&knots, u);
            let any = BasisDerivatives::<2, MAX_ORDER>::at(&knots, u);
            assert_eq!(fast.values, padded::<MAX_ORDER>(&knots, u).values[..ORDER]);
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
