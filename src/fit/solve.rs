//! The one place where sparse systems are solved.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, Mat, Par, Side, Spec};
use glam::DVec3;

/// An entry of a symmetric matrix on or below its diagonal: row, column, value. Entries of the same
/// place are added.
pub(super) type Entry = Triplet<usize, usize, f64>;

/// Solves a positive definite system for three right-hand sides: Cholesky's factorization after an
/// order that keeps it sparse (approximate minimum degree). On one thread, so that the sums are the
/// same on every machine. `None` if the matrix is not positive definite.
pub(super) fn positive_definite(entries: &[Entry], right: &[DVec3]) -> Option<Vec<DVec3>> {
    let size = right.len();
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, entries).ok()?;
    let symbolic = factorize_symbolic_cholesky(
        matrix.symbolic(),
        Side::Lower,
        SymmetricOrdering::Amd,
        CholeskySymbolicParams::default(),
    )
    .ok()?;
    let mut factor = vec![0.0; symbolic.len_val()];
    let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    symbolic
        .factorize_numeric_llt::<f64>(
            &mut factor,
            matrix.as_ref(),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Spec::default(),
        )
        .ok()?;
    let mut solution = Mat::from_fn(size, 3, |i, axis| right[i][axis]);
    let scratch = symbolic.solve_in_place_scratch::<f64>(3, Par::Seq);
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    LltRef::<'_, usize, f64>::new(&symbolic, &factor).solve_in_place_with_conj(
        Conj::No,
        solution.as_mut(),
        Par::Seq,
        MemStack::new(&mut memory),
    );
    let point = |i: usize| DVec3::new(solution[(i, 0)], solution[(i, 1)], solution[(i, 2)]);
    let points: Vec<DVec3> = (0..size).map(point).collect();
    points.iter().all(|point| point.is_finite()).then_some(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_solve_and_others_are_refused() {
        let entry = |row, col, val| Entry { row, col, val };
        let entries = [entry(0, 0, 4.0), entry(1, 0, 1.0), entry(1, 1, 2.0), entry(1, 1, 1.0)];
        let solved = positive_definite(&entries, &[DVec3::X * 5.0, DVec3::X * 4.0]).unwrap();
        assert!(solved.iter().all(|point| point.distance(DVec3::X) < 1e-15));
        assert!(positive_definite(&[entry(0, 0, -1.0)], &[DVec3::X]).is_none());
    }
}
