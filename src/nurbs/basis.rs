//! B-spline basis functions and their first derivatives.

use super::knot_vector::{KnotVector, MAX_DEGREE};

/// Most basis functions that differ from zero at one parameter.
pub(super) const MAX_ORDER: usize = MAX_DEGREE + 1;

/// The basis functions that differ from zero at one parameter, with their first derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Basis {
    /// Index of the first control point that they belong to.
    pub first: usize,
    /// The values; `degree + 1` of them count, the rest is zero.
    pub values: [f64; MAX_ORDER],
    /// The derivatives by the parameter, likewise.
    pub slopes: [f64; MAX_ORDER],
}

impl Basis {
    /// The basis functions at `u` (The NURBS Book, A2.2 and equation 2.7).
    pub(super) fn at(knots: &KnotVector, u: f64) -> Self {
        let (degree, span) = (knots.degree(), knots.span(u));
        let t = knots.as_slice();
        let mut values = [0.0; MAX_ORDER];
        let mut slopes = [0.0; MAX_ORDER];
        values[0] = 1.0;
        for p in 1..=degree {
            // From the functions of degree p - 1 to those of degree p; each contributes its share
            // `left` to the right neighbour and `1 - left` to itself.
            let last = p == degree;
            let order = p as f64;
            let mut carried = 0.0;
            let mut carried_slope = 0.0;
            for i in 0..p {
                let (from, to) = (t[span + 1 + i - p], t[span + 1 + i]);
                let share = values[i] / (to - from);
                values[i] = carried + (to - u) * share;
                carried = (u - from) * share;
                if last {
                    slopes[i] = carried_slope - order * share;
                    carried_slope = order * share;
                }
            }
            values[p] = carried;
            if last {
                slopes[p] = carried_slope;
            }
        }
        Self { first: span - degree, values, slopes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cox and de Boor's definition, recursive and slow.
    fn definition(t: &[f64], i: usize, p: usize, u: f64) -> f64 {
        if p == 0 {
            return f64::from(u8::from(t[i] <= u && u < t[i + 1]));
        }
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        ratio(u - t[i], t[i + p] - t[i]) * definition(t, i, p - 1, u)
            + ratio(t[i + p + 1] - u, t[i + p + 1] - t[i + 1]) * definition(t, i + 1, p - 1, u)
    }

    #[test]
    fn values_and_slopes_follow_the_definition() {
        for p in 1..=MAX_DEGREE {
            let inner = [0.2, 0.2, 0.5, 0.55];
            let inner = if p == 1 { &inner[1..] } else { &inner[..] };
            let ends = |value| std::iter::repeat_n(value, p + 1);
            let t: Vec<f64> = ends(0.0).chain(inner.iter().copied()).chain(ends(1.0)).collect();
            let knots = KnotVector::new(p, t.clone()).unwrap();
            for step in 0..100 {
                let u = f64::from(step) / 100.0;
                let basis = Basis::at(&knots, u);
                let (mut sum, mut slope_sum) = (0.0, 0.0);
                for k in 0..=p {
                    let i = basis.first + k;
                    assert!((basis.values[k] - definition(&t, i, p, u)).abs() < 1e-13);
                    // Equation 2.7: a derivative is a difference of functions one degree lower.
                    let order = f64::from(u8::try_from(p).unwrap());
                    let part = |i: usize| {
                        let width = t[i + p] - t[i];
                        if width > 0.0 { order * definition(&t, i, p - 1, u) / width } else { 0.0 }
                    };
                    assert!((basis.slopes[k] - (part(i) - part(i + 1))).abs() < 1e-11);
                    sum += basis.values[k];
                    slope_sum += basis.slopes[k];
                }
                assert!((sum - 1.0).abs() < 1e-14);
                assert!(slope_sum.abs() < 1e-11);
            }
        }
    }
}
