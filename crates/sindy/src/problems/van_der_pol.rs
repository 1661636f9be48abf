//! The Van der Pol oscillator.

use super::{Problem, Trajectory, monomials};

/// The Van der Pol oscillator with μ = 2
///
/// ```text
/// x' = y
/// y' = μ (1 - x^2) y - x
/// ```
///
/// from (1, 0), 5000 samples at a step of 0.01, cubic library. Every solution but the rest at the origin
/// (an unstable node at this μ) goes to one limit cycle.
///
/// Source: B. van der Pol, "On relaxation-oscillations", Phil. Mag. 2 (1926).
#[must_use]
pub fn van_der_pol() -> Problem {
    Problem {
        name: "Van der Pol",
        states: vec!["x", "y"],
        inputs: Vec::new(),
        terms: monomials(&["x", "y"], 3),
        truth: vec![
            vec![("y", 1.0)],
            vec![("x", -1.0), ("y", 2.0), ("x^2*y", -2.0)],
        ],
        trajectories: vec![Trajectory {
            start: vec![1.0, 0.0],
            inputs: Vec::new(),
        }],
        step: 0.01,
        rows: 5000,
    }
}
