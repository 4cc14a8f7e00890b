//! Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi's rotations; some of them by iteration.

use pulp::{Arch, Simd, WithSimd};

/// Sweeps over all pairs; ten are enough for 100 rows, and convergence ends it earlier.
const SWEEPS: usize = 60;

/// Vectors that are iterated beside those that are wanted: the more, the sooner the others are gone.
const MORE: usize = 6;

/// Iterations at most, some ten are enough where few eigenvalues stand out; and the residual at which they end, as a
/// share of the matrix.
const ITERATIONS: usize = 24;
const SOLVED: f64 = 1e-13;

/// So many of the eigenvalues of a symmetric matrix, the largest, each with its vector of length 1: by iteration where
/// few stand out, and otherwise as [`symmetric`] finds all. Fewer if the matrix has not so many.
pub(super) fn largest(matrix: Vec<f64>, size: usize, count: usize) -> Vec<(f64, Vec<f64>)> {
    let found = iterated(&matrix, size, count);
    found.unwrap_or_else(|| {
        let mut all = symmetric(matrix, size);
        all.truncate(count);
        all
    })
}

/// The same by orthogonal iteration from the matrix's first columns (Golub and Van Loan, Matrix Computations, section
/// 8.2); `None` if that does not end.
fn iterated(matrix: &[f64], size: usize, count: usize) -> Option<Vec<(f64, Vec<f64>)>> {
    let block = count + MORE;
    if size <= block {
        return None;
    }
    let norm = dot(matrix, matrix).sqrt();
    let rows = || matrix.chunks_exact(size);
    let mut vectors: Vec<Vec<f64>> = rows().take(block).map(<[f64]>::to_vec).collect();
    for _ in 0..ITERATIONS {
        orthonormalize(&mut vectors)?;
        let images: Vec<Vec<f64>> =
            vectors.iter().map(|vector| combined(rows(), vector, size)).collect();
        // Rayleigh's and Ritz's: the eigenvectors among what the vectors span.
        let mixed = |i: usize| dot(&vectors[i / block], &images[i % block]);
        let pairs = symmetric((0..block * block).map(mixed).collect(), block);
        let turned = |all: &[Vec<f64>], shares: &[f64]| {
            combined(all.iter().map(Vec::as_slice), shares, size)
        };
        let off = |(value, shares): &(f64, Vec<f64>)| {
            let (vector, image) = (turned(&vectors, shares), turned(&images, shares));
            vector.iter().zip(image).map(|(v, i)| (i - value * v).powi(2)).sum::<f64>().sqrt()
        };
        if pairs[..count].iter().all(|pair| off(pair) <= SOLVED * norm) {
            let found = pairs.into_iter().take(count);
            return Some(found.map(|(value, shares)| (value, turned(&vectors, &shares))).collect());
        }
        vectors = pairs.iter().map(|(_, shares)| turned(&images, shares)).collect();
    }
    None
}

/// The sum of vectors, each so many times.
fn combined<'a>(vectors: impl Iterator<Item = &'a [f64]>, times: &[f64], size: usize) -> Vec<f64> {
    let mut sum = vec![0.0; size];
    for (vector, times) in vectors.zip(times) {
        sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += times * value);
    }
    sum
}

/// Gram's and Schmidt's, each vector twice for the sake of rounding; `None` if they span less than there are of them.
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
        if left <= SOLVED * length {
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

/// The eigenvalues of a symmetric matrix, largest first, each with its vector of length 1.
///
/// `matrix` holds `size * size` numbers. O(size³) a sweep (Golub and Van Loan, Matrix Computations,
/// section 8.5).
pub(super) fn symmetric(matrix: Vec<f64>, size: usize) -> Vec<(f64, Vec<f64>)> {
    Arch::new().dispatch(Rotations { matrix, size })
}

/// A matrix that is turned until it is diagonal.
struct Rotations {
    matrix: Vec<f64>,
    size: usize,
}

impl WithSimd for Rotations {
    type Output = Vec<(f64, Vec<f64>)>;

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { mut matrix, size } = self;
        let mut vectors = vec![0.0; size * size];
        (0..size).for_each(|i| vectors[i * size + i] = 1.0);
        let norm: f64 = matrix.iter().map(|value| value * value).sum();
        let negligible = f64::EPSILON * norm.sqrt() / size as f64;
        for _ in 0..SWEEPS {
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

/// Turns axes p and q so that their mixed element becomes zero; rows of `vectors` turn with them.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
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
    // The other columns change as the rows did.
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
    fn vectors_are_stretched_by_their_values() {
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
    fn the_largest_are_those_of_all() {
        let (size, mut random) = (40, Random::new(5));
        // Places in the plane and a little of everything, or of nothing but chance.
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
    fn a_diagonal_is_its_own_answer() {
        let pairs = symmetric(vec![1.0, 0.0, 0.0, 3.0], 2);
        assert_eq!(pairs, [(3.0, vec![0.0, 1.0]), (1.0, vec![1.0, 0.0])]);
    }
}
