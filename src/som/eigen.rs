//! Eigenvalues and eigenvectors of small symmetric matrices.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd;
use faer::{Mat, MatRef, Par, Spec};

/// The eigenvalues of a symmetric matrix, largest first, each with its vector of length 1; `None` if they are
/// not found, as of numbers that are not finite.
///
/// `matrix` holds `size * size` numbers. O(size³).
pub(super) fn symmetric(matrix: &[f64], size: usize) -> Option<Vec<(f64, Vec<f64>)>> {
    // On one thread, so that their number changes no bit.
    let (par, params) = (Par::Seq, Spec::default());
    let wanted = evd::ComputeEigenvectors::Yes;
    let scratch = evd::self_adjoint_evd_scratch::<f64>(size, wanted, par, params);
    let (mut values, mut vectors) = (Diag::zeros(size), Mat::zeros(size, size));
    evd::self_adjoint_evd(
        MatRef::from_row_major_slice(matrix, size, size),
        values.as_mut(),
        Some(vectors.as_mut()),
        par,
        MemStack::new(&mut MemBuffer::new(scratch)),
        params,
    )
    .ok()?;
    let pair = |i: usize| (values[i], vectors.col(i).iter().copied().collect());
    Some((0..size).rev().map(pair).collect())
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
        let pairs = symmetric(&matrix, size).unwrap();
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
    fn a_diagonal_is_its_own_answer() {
        let pairs = symmetric(&[1.0, 0.0, 0.0, 3.0], 2).unwrap();
        assert_eq!(pairs.iter().map(|pair| pair.0).collect::<Vec<_>>(), [3.0, 1.0]);
        assert_eq!(pairs[0].1.iter().map(|x| x.abs()).collect::<Vec<_>>(), [0.0, 1.0]);
    }
}
