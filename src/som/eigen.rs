//! Eigenvalues and eigenvectors of small symmetric matrices: Jacobi rotations, or orthogonal
//! iteration for the largest.

use pulp::{Arch, Simd, WithSimd};

/// Jacobi sweeps over all pairs, at most. Convergence usually ends them after ten.
const MAX_SWEEPS: usize = 60;

/// Vectors iterated besides the requested ones. More of them converge in fewer iterations.
const EXTRA_VECTORS: usize = 6;

/// Orthogonal iterations, at most. About ten suffice where few eigenvalues dominate.
const MAX_ITERATIONS: usize = 24;

/// Largest residual of a converged eigenpair, as a share of the matrix norm.
const MAX_RESIDUAL: f64 = 1e-13;

/// The `count` largest eigenvalues of a symmetric matrix, each with its unit eigenvector, or fewer
/// if the matrix is smaller. Uses orthogonal iteration, and [`symmetric`] if that does not
/// converge.
pub(super) fn largest(matrix: Vec<f64>, size: usize, count: usize) -> Vec<(f64, Vec<f64>)> {
    let found = iterated(&matrix, size, count);
    found.unwrap_or_else(|| {
        let mut all = symmetric(matrix, size);
        all.truncate(count);
        all
    })
}

/// The same by orthogonal iteration from the matrix's first columns; `None` if it does not
/// converge. Golub and Van Loan, *Matrix Computations*, section 8.2.
fn iterated(matrix: &[f64], size: usize, count: usize) -> Option<Vec<(f64, Vec<f64>)>> {
    let block = count + EXTRA_VECTORS;
    if size <= block {
        return None;
    }
    let norm = dot(matrix, matrix).sqrt();
    let rows = || matrix.chunks_exact(size);
    let mut vectors: Vec<Vec<f64>> = rows().take(block).map(<[f64]>::to_vec).collect();
    for _ in 0..MAX_ITERATIONS {
        orthonormalize(&mut vectors)?;
        let images: Vec<Vec<f64>> =
            vectors.iter().map(|vector| combined(rows(), vector, size)).collect();
        // Rayleigh-Ritz: the eigenvectors within the span of the vectors.
        let mixed = |i: usize| dot(&vectors[i / block], &images[i % block]);
        let pairs = symmetric((0..block * block).map(mixed).collect(), block);
        let turned = |all: &[Vec<f64>], shares: &[f64]| {
            combined(all.iter().map(Vec::as_slice), shares, size)
        };
        let off = |(value, shares): &(f64, Vec<f64>)| {
            let (vector, image) = (turned(&vectors, shares), turned(&images, shares));
            vector.iter().zip(image).map(|(v, i)| (i - value * v).powi(2)).sum::<f64>().sqrt()
        };
        if pairs[..count].iter().all(|pair| off(pair) <= MAX_RESIDUAL * norm) {
            let found = pairs.into_iter().take(count);
            return Some(found.map(|(value, shares)| (value, turned(&vectors, &shares))).collect());
        }
        vectors = pairs.iter().map(|(_, shares)| turned(&images, shares)).collect();
    }
    None
}

/// The linear combination of vectors with these factors.
fn combined<'a>(vectors: impl Iterator<Item = &'a [f64]>, times: &[f64], size: usize) -> Vec<f64> {
    let mut sum = vec![0.0; size];
    for (vector, times) in vectors.zip(times) {
        sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += times * value);
    }
    sum
}

/// Gram-Schmidt, applied twice against rounding; `None` if the vectors are linearly dependent.
fn orthonormalize(vectors: &mut [Vec<f64>]) -> Option<()> {
    for i in 0..vectors.len() {
        let (before, rest) = vectors.split_at_mut(i);
        let own = &mut rest[0];
        let length = dot(own, own).sqrt();
        for other in before.iter().chain(before.iter()) {
            let common = dot(own, other);
            own.iter_mut().zip(other).for_each(|(own, other)| *own -= common * other);
        }
        let left = dot(own, own).sqrt();
        if left <= MAX_RESIDUAL * length {
            return None;
        }
        for value in own.iter_mut() {
            *value /= left;
        }
    }
    Some(())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// All eigenvalues of a symmetric matrix, largest first, each with its unit eigenvector.
///
/// `matrix` has `size * size` elements. O(size³) per sweep. Golub and Van Loan, *Matrix
/// Computations*, section 8.5.
pub(super) fn symmetric(matrix: Vec<f64>, size: usize) -> Vec<(f64, Vec<f64>)> {
    Arch::new().dispatch(Rotations { matrix, size })
}

/// A matrix to be diagonalized by Jacobi rotations.
struct Rotations {
    matrix: Vec<f64>,
    size: usize,
}

impl WithSimd for Rotations {
    type Output = Vec<(f64, Vec<f64>)>;

    #[expect(clippy::inline_always, reason = "inlined into the code for each register width")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { mut matrix, size } = self;
        let mut vectors = vec![0.0; size * size];
        (0..size).for_each(|i| vectors[i * size + i] = 1.0);
        let norm: f64 = matrix.iter().map(|value| value * value).sum();
        let negligible = f64::EPSILON * norm.sqrt() / size as f64;
        for _ in 0..MAX_SWEEPS {
            let off: f64 = pairs(size).map(|(p, q)| matrix[p * size + q].powi(2)).sum();
            if off <= f64::EPSILON.powi(2) * norm {
                break;
            }
            for (p, q) in pairs(size) {
                if matrix[p * size + q].abs() > negligible {
                    rotate(&mut matrix, &mut vectors, size, p, q);
                }
            }
        }
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|&a, &b| matrix[b * size + b].total_cmp(&matrix[a * size + a]));
        let pair = |i: usize| (matrix[i * size + i], vectors[i * size..(i + 1) * size].to_vec());
        order.into_iter().map(pair).collect()
    }
}

fn pairs(size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..size).flat_map(move |p| (p + 1..size).map(move |q| (p, q)))
}

/// Rotates axes p and q so that their off-diagonal element becomes zero. The rows of `vectors`
/// rotate with them.
#[expect(clippy::inline_always, reason = "inlined into the code for each register width")]
#[inline(always)]
fn rotate(matrix: &mut [f64], vectors: &mut [f64], size: usize, p: usize, q: usize) {
    let mixed = matrix[p * size + q];
    let theta = (matrix[q * size + q] - matrix[p * size + p]) / (2.0 * mixed);
    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    let turned = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
    for values in [&mut *matrix, vectors] {
        let (low, high) = values.split_at_mut(q * size);
        for (a, b) in low[p * size..][..size].iter_mut().zip(&mut high[..size]) {
            (*a, *b) = turned(*a, *b);
        }
    }
    for k in [p, q] {
        let [a, b] = [p, q].map(|column| k * size + column);
        (matrix[a], matrix[b]) = turned(matrix[a], matrix[b]);
    }
    // The matrix is symmetric: copy the changed rows to the columns.
    let (above, rest) = matrix.split_at_mut(p * size);
    let (row_p, rest) = rest.split_at_mut(size);
    let (between, rest) = rest.split_at_mut((q - p - 1) * size);
    let (row_q, below) = rest.split_at_mut(size);
    for (rows, first) in [(above, 0), (between, p + 1), (below, q + 1)] {
        let columns = row_p[first..].iter().zip(&row_q[first..]);
        for (row, (a, b)) in rows.chunks_exact_mut(size).zip(columns) {
            (row[p], row[q]) = (*a, *b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    #[test]
    fn eigenpairs_satisfy_their_equation() {
        let (size, mut random) = (30, Random::new(1));
        let mut matrix = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let value = random.unit() - 0.5;
                (matrix[i * size + j], matrix[j * size + i]) = (value, value);
            }
        }
        let pairs = symmetric(matrix.clone(), size);
        assert!(pairs.windows(2).all(|pair| pair[0].0 >= pair[1].0));
        for (value, vector) in pairs {
            for i in 0..size {
                let row = &matrix[i * size..(i + 1) * size];
                let image: f64 = row.iter().zip(&vector).map(|(a, b)| a * b).sum();
                assert!((image - value * vector[i]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn largest_agrees_with_all_eigenpairs() {
        let (size, mut random) = (40, Random::new(5));
        // Products of points in a plane with a little noise; then noise alone.
        let place: Vec<[f64; 2]> =
            (0..size).map(|_| [random.unit() - 0.5, random.unit()]).collect();
        for (flat, noise) in [(1.0, 1e-3), (0.0, 1.0)] {
            let mut matrix = vec![0.0; size * size];
            for i in 0..size {
                for j in 0..=i {
                    let product = place[i][0] * place[j][0] + place[i][1] * place[j][1];
                    let value = flat * product + noise * (random.unit() - 0.5);
                    (matrix[i * size + j], matrix[j * size + i]) = (value, value);
                }
            }
            let all = symmetric(matrix.clone(), size);
            assert_eq!(iterated(&matrix, size, 2).is_some(), flat > 0.0);
            let some = largest(matrix, size, 2);
            assert_eq!(some.len(), 2);
            for ((value, vector), (of_all, one_of_all)) in some.iter().zip(&all) {
                assert!((value - of_all).abs() < 1e-11);
                assert!((dot(vector, one_of_all).abs() - 1.0).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn diagonal_matrices_have_their_diagonal_as_eigenvalues() {
        let pairs = symmetric(vec![1.0, 0.0, 0.0, 3.0], 2);
        assert_eq!(pairs, [(3.0, vec![0.0, 1.0]), (1.0, vec![1.0, 0.0])]);
    }
}
