//! Bernstein polynomials, and the weights of their blossoms on a triangle's coefficients.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use crate::nurbs::MAX_ORDER;

/// The binomial coefficient n over k.
pub(super) fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

/// Writes the `degree + 1` Bernstein polynomials at `x` (*The NURBS Book*, A1.3).
pub(super) fn polynomials(degree: usize, x: f64, row: &mut [f64]) {
    row[0] = 1.0;
    for level in 1..=degree {
        let mut kept = 0.0;
        for value in &mut row[..level] {
            let before = *value;
            *value = kept + (1.0 - x) * before;
            kept = x * before;
        }
        row[level] = kept;
    }
}

/// The weights of the coefficients in each blossom of a degree, at multisets of three arguments.
///
/// The multisets are in the order of [`multi_indices`](super::bezier_triangle::multi_indices). The
/// weights are the coefficients, in powers of s, of the product of 1 - x + x s over all arguments
/// x.
#[inline(always)]
pub(super) fn blossom_weights(degree: usize, [x, y, z]: [f64; 3], out: &mut Vec<f64>) {
    out.clear();
    let mut first = [0.0; MAX_ORDER];
    first[0] = 1.0;
    let mut second = [0.0; MAX_ORDER];
    for a in 0..=degree {
        second[..=degree].copy_from_slice(&first[..=degree]);
        for b in 0..=degree - a {
            let start = out.len();
            out.extend_from_slice(&second[..=degree]);
            for known in a + b..degree {
                multiply(&mut out[start..], known, z);
            }
            multiply(&mut second, a + b, y);
        }
        multiply(&mut first, a, x);
    }
}

/// Multiplies a polynomial of a degree by 1 - x + x s.
#[inline(always)]
fn multiply(polynomial: &mut [f64], degree: usize, x: f64) {
    let Some(next) = polynomial.get_mut(degree + 1) else { return };
    *next = 0.0;
    // Common: corners of triangles often lie on the sides of the square.
    if x == 0.0 {
        return;
    }
    for k in (0..=degree).rev() {
        let value = polynomial[k];
        polynomial[k + 1] += x * value;
        polynomial[k] = (1.0 - x) * value;
    }
}
