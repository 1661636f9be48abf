//! The damped linear oscillator.

use super::{Problem, Trajectory, monomials};

/// The damped linear oscillator
///
/// ```text
/// x' = -0.1 x + 2 y
/// y' = -2 x - 0.1 y
/// ```
///
/// from (2, 0), 2500 samples at a step of 0.01, cubic library. The solution is x = 2 e^(-0.1 t) cos 2t,
/// y = -2 e^(-0.1 t) sin 2t.
///
/// Source: the first example of S. L. Brunton, J. L. Proctor & J. N. Kutz, "Discovering governing
/// equations from data by sparse identification of nonlinear dynamical systems", PNAS 113 (2016).
#[must_use]
pub fn damped_oscillator() -> Problem {
    Problem {
        name: "damped oscillator",
        states: vec!["x", "y"],
        inputs: Vec::new(),
        terms: monomials(&["x", "y"], 3),
        truth: vec![
            vec![("x", -0.1), ("y", 2.0)],
            vec![("x", -2.0), ("y", -0.1)],
        ],
        trajectories: vec![Trajectory {
            start: vec![2.0, 0.0],
            inputs: Vec::new(),
        }],
        step: 0.01,
        rows: 2500,
    }
}
