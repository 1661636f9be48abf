//! The exact Jacobian of a model, from the derivatives of its expressions.

use nalgebra::DMatrix;
use sindy_expr::Expr;

use super::Model;
use super::predict::Compiled;
use crate::error::{SindyError, same_size};

/// Derivatives of the right-hand side: `A = ∂f/∂x` and `B = ∂f/∂u`.
///
/// Exact wherever the terms have derivatives; see [`Expr::derivative`] for kinks and jumps.
#[derive(Clone, Debug)]
pub struct Jacobian {
    states: usize,
    inputs: usize,
    expressions: Vec<Vec<Expr>>,
    /// Row by row, states and then inputs in each.
    compiled: Compiled,
}

impl Model {
    /// Differentiates the model.
    ///
    /// # Errors
    /// None that a model which was built can cause; the compiler's are passed on.
    pub fn jacobian(&self) -> Result<Jacobian, SindyError> {
        let columns = self.columns();
        let zero = Expr::constant(0.0);
        let mut derivatives: Vec<Vec<(Expr, f64)>> = Vec::new();
        let mut expressions = Vec::new();
        for terms in &self.equations {
            let mut row = Vec::with_capacity(columns.len());
            for name in &columns {
                let entry: Vec<(Expr, f64)> = terms
                    .iter()
                    .map(|t| (t.expression.derivative(name), t.coefficient))
                    .filter(|(d, _)| *d != zero)
                    .collect();
                row.push(
                    Expr::sum(entry.iter().map(|(d, c)| Expr::constant(*c) * d.clone())).simplify(),
                );
                derivatives.push(entry);
            }
            expressions.push(row);
        }
        let sums: Vec<Vec<(&Expr, f64)>> = derivatives
            .iter()
            .map(|entry| entry.iter().map(|(d, c)| (d, *c)).collect())
            .collect();
        Ok(Jacobian {
            states: self.states.len(),
            inputs: self.inputs.len(),
            expressions,
            compiled: Compiled::of_sums(&columns, &sums)?,
        })
    }
}

impl Jacobian {
    /// The matrices A (states × states) and B (states × inputs) at a state and an input. Entries outside
    /// a derivative's domain are NaN or infinite.
    ///
    /// # Errors
    /// [`SindyError::Shape`] if there is not one value for each state and each input.
    pub fn at(
        &self,
        state: &[f64],
        input: &[f64],
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), SindyError> {
        same_size("state values", self.states, state.len())?;
        same_size("input values", self.inputs, input.len())?;
        let row = [state, input].concat();
        let width = row.len();
        let mut values = vec![0.0; self.states * width];
        self.compiled
            .row(&row, &mut values, &mut self.compiled.workspace());
        let a = DMatrix::from_fn(self.states, self.states, |i, j| values[i * width + j]);
        let b = DMatrix::from_fn(self.states, self.inputs, |i, j| {
            values[i * width + self.states + j]
        });
        Ok((a, b))
    }

    /// The entries as simplified expressions: row i is that of state i, its columns are the states and
    /// then the inputs.
    #[must_use]
    pub fn expressions(&self) -> &[Vec<Expr>] {
        &self.expressions
    }
}
