//! What noise of the states does to a model's slopes.

use super::System;

impl System {
    /// Standard deviation of each equation's right-hand side at each row, by noise of deviation `sigma` in the states. By equation, then
    /// row; `columns` are states and inputs.
    pub(crate) fn slope_noise(
        &self,
        coefficients: &[f64],
        columns: &[&[f64]],
        sigma: &[f64],
    ) -> Vec<Vec<f64>> {
        let mut work = self.work(coefficients);
        let rows = columns.first().map_or(0, |c| c.len());
        let mut out = vec![Vec::with_capacity(rows); self.n];
        for row in 0..rows {
            let at: Vec<f64> = columns.iter().map(|c| c[row]).collect();
            let jacobian = &mut work.jacobian[0];
            let scratch = (&mut work.gradient, &mut work.scratch);
            self.jacobian(&at, &work.slopes, scratch.0, scratch.1, jacobian);
            for (equation, out) in out.iter_mut().enumerate() {
                let noise = jacobian.row(equation).transpose();
                let squares = noise
                    .iter()
                    .zip(sigma)
                    .map(|(j, sigma)| (j * sigma).powi(2));
                out.push(squares.sum::<f64>().sqrt());
            }
        }
        out
    }
}
