//! Small dense symmetric matrices: Cholesky factorization and solution.

/// A square matrix, row by row.
pub(super) struct DenseMatrix {
    size: usize,
    pub(super) values: Vec<f64>,
}

impl DenseMatrix {
    pub(super) fn new(size: usize) -> Self {
        Self { size, values: vec![0.0; size * size] }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.size..(i + 1) * self.size]
    }

    fn trace(&self) -> f64 {
        (0..self.size).map(|i| self.values[i * self.size + i]).sum()
    }

    /// Adds a share of the mean diagonal element to the diagonal.
    pub(super) fn add_ridge(&mut self, share: f64) {
        let ridge = share * self.trace() / self.size as f64;
        (0..self.size).for_each(|i| self.values[i * self.size + i] += ridge);
    }

    /// The lower triangular L with L Lᵀ = self. `None` if the matrix is not positive definite.
    /// O(size³ / 3) (Golub and Van Loan, *Matrix Computations*, section 4.2).
    pub(super) fn cholesky(&self) -> Option<Self> {
        let mut lower = Self::new(self.size);
        for i in 0..self.size {
            for j in 0..=i {
                let dot: f64 =
                    lower.row(i)[..j].iter().zip(&lower.row(j)[..j]).map(|(a, b)| a * b).sum();
                let left = self.values[i * self.size + j] - dot;
                lower.values[i * self.size + j] = if i == j {
                    if left <= 0.0 || !left.is_finite() {
                        return None;
                    }
                    left.sqrt()
                } else {
                    left / lower.values[j * self.size + j]
                };
            }
        }
        Some(lower)
    }

    /// For a factor L: the solution x of L Lᵀ x = right.
    pub(super) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = right.to_vec();
        for i in 0..self.size {
            let dot: f64 = self.row(i)[..i].iter().zip(&x).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - dot) / self.row(i)[i];
        }
        for i in (0..self.size).rev() {
            x[i] /= self.row(i)[i];
            let value = x[i];
            for (x, factor) in x[..i].iter_mut().zip(&self.row(i)[..i]) {
                *x -= factor * value;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_definite_systems_are_solved_and_others_are_refused() {
        let matrix = DenseMatrix { size: 2, values: vec![4.0, 1.0, 1.0, 3.0] };
        let factor = matrix.cholesky().unwrap();
        let x = factor.solve(&[6.0, 7.0]);
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
        assert!(DenseMatrix { size: 1, values: vec![-1.0] }.cholesky().is_none());
    }
}
