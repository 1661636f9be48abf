//! NormalEquations equations of six unknowns.

/// Vector6 numbers: a translation and a small turn.
pub(super) type Vector6 = [f64; 6];

/// Weighted least squares `min Σ w (row · x - value)²`, as it is summed up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NormalEquations {
    matrix: [Vector6; 6],
    right: Vector6,
}

impl NormalEquations {
    #[inline]
    pub(super) fn add(&mut self, row: &Vector6, value: f64, weight: f64) {
        for i in 0..6 {
            let part = weight * row[i];
            self.right[i] += part * value;
            for j in 0..=i {
                self.matrix[i][j] += part * row[j];
            }
        }
    }

    /// Solution and inverse of the matrix (its covariance for unit weights), with
    /// a diagonal that is larger by the share `damping`; `None` when the rows do
    /// not determine it.
    pub(super) fn solve(&self, damping: f64) -> Option<(Vector6, [Vector6; 6])> {
        // Cholesky's factor L, lower.
        let mut factor = self.matrix;
        for (i, row) in factor.iter_mut().enumerate() {
            row[i] *= 1.0 + damping;
        }
        for i in 0..6 {
            for j in 0..=i {
                let dot: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let rest = factor[i][j] - dot;
                factor[i][j] = if i == j {
                    if !(rest > 0.0 && rest.is_finite()) {
                        return None;
                    }
                    rest.sqrt()
                } else {
                    rest / factor[j][j]
                };
            }
        }
        let substitute = |right: &Vector6| {
            let mut x = *right;
            for i in 0..6 {
                let known: f64 = (0..i).map(|k| factor[i][k] * x[k]).sum();
                x[i] = (x[i] - known) / factor[i][i];
            }
            for i in (0..6).rev() {
                let known: f64 = (i + 1..6).map(|k| factor[k][i] * x[k]).sum();
                x[i] = (x[i] - known) / factor[i][i];
            }
            x
        };
        let mut inverse = [[0.0; 6]; 6];
        for (i, row) in inverse.iter_mut().enumerate() {
            let mut unit = [0.0; 6];
            unit[i] = 1.0;
            *row = substitute(&unit);
        }
        Some((substitute(&self.right), inverse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_solution_and_inverse() {
        // Rows of a matrix with known solution, one more than needed but consistent.
        let x = [1.0, -2.0, 0.5, 3.0, -0.25, 4.0];
        let mut normal = NormalEquations::default();
        let mut matrix = [[0.0; 6]; 6];
        for k in 0..7_u32 {
            let row: Vector6 =
                std::array::from_fn(|i| (f64::from(k + 1) * (i as f64 + 0.3)).sin() + 0.1);
            let value = (0..6).map(|i| row[i] * x[i]).sum();
            let weight = 1.0 + f64::from(k);
            normal.add(&row, value, weight);
            for i in 0..6 {
                for j in 0..6 {
                    matrix[i][j] += weight * row[i] * row[j];
                }
            }
        }
        let (solution, inverse) = normal.solve(0.0).unwrap();
        for i in 0..6 {
            // A condition of up to 1e6 times rounding.
            assert!((solution[i] - x[i]).abs() < 1e-9);
            for j in 0..6 {
                let product: f64 = (0..6).map(|k| matrix[i][k] * inverse[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9);
            }
        }
        let mut flat = NormalEquations::default();
        flat.add(&[1.0; 6], 1.0, 1.0);
        assert!(flat.solve(0.0).is_none());
    }
}
