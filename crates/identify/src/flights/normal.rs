//! Normal equations of one armed interval, in which its own scale and height error are eliminated.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

/// Residuals beyond this number of standard deviations have decreasing weight (Huber).
/// Normal noise keeps an efficiency above 0.999, yet impacts that slipped through weigh little. Half costs 1 % of it.
pub(super) const HUBER: f64 = 4.0;

/// Normal equations of one run, with what belongs to it eliminated.
#[derive(Clone, Debug)]
pub(super) struct ReducedEquations {
    pub(super) matrix: DMatrix<f64>,
    pub(super) vector: DVector<f64>,
}

/// Normal equations of one run at a point.
pub(super) struct NormalEquations {
    pub(super) reduced: ReducedEquations,
    pub(super) inner: Matrix2<f64>,
    pub(super) own: Vector2<f64>,
    pub(super) coupling: DMatrix<f64>,
    /// Huber's cost and the prior of the height error.
    pub(super) cost: f64,
    /// Sum of the weights, and the weighted sum of squares.
    pub(super) weight: f64,
    pub(super) square: f64,
}

impl NormalEquations {
    /// The run's own step for a step of the shared numbers.
    pub(super) fn local(&self, shift: &DVector<f64>) -> Vector2<f64> {
        let coupled = self.coupling.tr_mul(shift);
        self.inner * (self.own - Vector2::new(coupled[0], coupled[1]))
    }
}

/// Takes numbers at their bound out of a system: their step is zero, and the others do not reckon with it.
pub(super) fn hold(matrix: &mut DMatrix<f64>, vector: &mut DVector<f64>, held: &[usize]) {
    for &i in held {
        matrix.row_mut(i).fill(0.0);
        matrix.column_mut(i).fill(0.0);
        matrix[(i, i)] = 1.0;
        vector[i] = 0.0;
    }
}

/// One run's residual and its slopes by the shared numbers, the scale and the height error, row by row.
pub(super) struct FitColumns {
    pub(super) residual: Vec<f64>,
    pub(super) shared: Vec<Vec<f64>>,
    pub(super) own: [Vec<f64>; 2],
}

/// The normal equations of weighted least squares (Huber 1964), and what is known of the height error beforehand.
pub(super) fn normal_equations(columns: &FitColumns, bias_sd: f64, bias: f64) -> NormalEquations {
    let n = columns.shared.len();
    let mut hessian = DMatrix::zeros(n, n);
    let mut gradient = DVector::zeros(n);
    let mut coupling = DMatrix::zeros(n, 2);
    let mut outer = Matrix2::zeros();
    let mut own = Vector2::zeros();
    let (mut cost, mut weight, mut square) = (0.0, 0.0, 0.0);
    for (row, &r) in columns.residual.iter().enumerate() {
        let w = if r.abs() > HUBER {
            HUBER / r.abs()
        } else {
            1.0
        };
        cost += if r.abs() > HUBER {
            2.0 * HUBER * r.abs() - HUBER * HUBER
        } else {
            r * r
        };
        weight += w;
        square += w * r * r;
        let mine = Vector2::new(columns.own[0][row], columns.own[1][row]);
        for a in 0..n {
            let ws = w * columns.shared[a][row];
            for b in 0..=a {
                hessian[(a, b)] += ws * columns.shared[b][row];
            }
            gradient[a] += ws * r;
            coupling[(a, 0)] += ws * mine.x;
            coupling[(a, 1)] += ws * mine.y;
        }
        outer += w * mine * mine.transpose();
        own += w * r * mine;
    }
    for a in 0..n {
        for b in 0..a {
            hessian[(b, a)] = hessian[(a, b)];
        }
    }
    let precision = bias_sd.powi(-2);
    outer[(1, 1)] += precision;
    own.y -= precision * bias;
    cost += precision * bias * bias;
    // A run without rows has no scale: its own stays where it is.
    outer[(0, 0)] += 1e-12;
    let inner = outer.try_inverse().unwrap_or_else(Matrix2::zeros);
    let through = &coupling * inner;
    NormalEquations {
        reduced: ReducedEquations {
            matrix: hessian - &through * coupling.transpose(),
            vector: gradient - through * own,
        },
        inner,
        own,
        coupling,
        cost,
        weight,
        square,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_number_at_its_bound_does_not_move_the_others() {
        let mut matrix = DMatrix::from_row_slice(2, 2, &[4.0, 3.0, 3.0, 9.0]);
        let mut vector = DVector::from_row_slice(&[2.0, -5.0]);
        hold(&mut matrix, &mut vector, &[1]);
        let step = matrix.cholesky().unwrap().solve(&vector);
        // Alone, the first goes by 2/4.
        assert!((step[0] - 0.5).abs() < 1e-15 && step[1] == 0.0, "{step}");
    }
}
