//! Symmetric positive definite systems whose rows begin at different columns.

/// The lower half of a symmetric matrix; each row is stored from its first nonzero column on.
///
/// Cholesky's elimination fills nothing in before a row's first entry (A. George and J. W.-H. Liu
/// 1981, chapter 4). Systems of periodic splines have a band and a few full rows at the end.
#[derive(Clone, Debug)]
pub(super) struct NormalMatrix {
    rows: Vec<(usize, Vec<f64>)>,
}

/// Smallest pivot as a share of the diagonal entry before elimination. Below it, nothing but
/// rounding is left.
const MIN_PIVOT: f64 = 1e-13;

impl NormalMatrix {
    pub(super) fn new(size: usize) -> Self {
        Self { rows: (0..size).map(|i| (i, vec![0.0])).collect() }
    }

    /// Adds a value at row i and column j, and at row j and column i.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let (i, j) = (i.max(j), i.min(j));
        let (first, entries) = &mut self.rows[i];
        if j < *first {
            entries.splice(0..0, std::iter::repeat_n(0.0, *first - j));
            *first = j;
        }
        entries[j - *first] += value;
    }

    /// Solves in place; false if the matrix is not positive definite.
    pub(super) fn solve(mut self, right: &mut [f64]) -> bool {
        for i in 0..self.rows.len() {
            let (done, rest) = self.rows.split_at_mut(i);
            let (first, row) = &mut rest[0];
            let diagonal = row[i - *first];
            for j in *first..i {
                let (other_first, other) = &done[j];
                let from = (*first).max(*other_first);
                let product: f64 =
                    (from..j).map(|k| row[k - *first] * other[k - *other_first]).sum();
                row[j - *first] = (row[j - *first] - product) / other[j - *other_first];
            }
            let pivot = diagonal - row[..i - *first].iter().map(|x| x * x).sum::<f64>();
            if pivot.is_nan() || pivot <= MIN_PIVOT * diagonal {
                return false;
            }
            row[i - *first] = pivot.sqrt();
        }
        for (i, (first, row)) in self.rows.iter().enumerate() {
            let product: f64 = (*first..i).map(|k| row[k - *first] * right[k]).sum();
            right[i] = (right[i] - product) / row[i - *first];
        }
        for (i, (first, row)) in self.rows.iter().enumerate().rev() {
            right[i] /= row[i - *first];
            for k in *first..i {
                right[k] -= row[k - *first] * right[i];
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_with_full_rows_are_solved() {
        let size = 12;
        let entry = |i: usize, j: usize| match (i.abs_diff(j), i.max(j)) {
            (0, _) => 4.0,
            (1 | 2, _) => 0.7,
            (_, 11) => 0.1,
            _ => 0.0,
        };
        let mut matrix = NormalMatrix::new(size);
        for i in 0..size {
            (0..=i).filter(|j| entry(i, *j) != 0.0).for_each(|j| matrix.add(j, i, entry(i, j)));
        }
        let solution: Vec<f64> = (0..size).map(|k| (k as f64).sin()).collect();
        let row = |i: usize| (0..size).map(|j| entry(i, j) * solution[j]).sum();
        let mut right: Vec<f64> = (0..size).map(row).collect();
        assert!(matrix.solve(&mut right));
        assert!(right.iter().zip(&solution).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn singular_matrices_are_refused() {
        let mut matrix = NormalMatrix::new(2);
        for (i, j) in [(0, 0), (1, 0), (1, 1)] {
            matrix.add(i, j, 1.0);
        }
        assert!(!matrix.solve(&mut [1.0, 1.0]));
    }
}
