//! The Lorenz system.

use super::{Problem, Trajectory, monomials};

/// The Lorenz system with σ = 10, ρ = 28, β = 8/3
///
/// ```text
/// x' = σ (y - x)
/// y' = x (ρ - z) - y
/// z' = x y - β z
/// ```
///
/// from (-8, 7, 27), 5000 samples at a step of 0.002, cubic library. Chaotic: the largest Lyapunov
/// exponent is 0.906, so that errors grow e-fold in 1.1 units of time.
///
/// Source: E. N. Lorenz, "Deterministic nonperiodic flow", J. Atmos. Sci. 20 (1963).
#[must_use]
pub fn lorenz() -> Problem {
    Problem {
        name: "Lorenz",
        states: vec!["x", "y", "z"],
        inputs: Vec::new(),
        terms: monomials(&["x", "y", "z"], 3),
        truth: vec![
            vec![("x", -10.0), ("y", 10.0)],
            vec![("x", 28.0), ("y", -1.0), ("x*z", -1.0)],
            vec![("z", -8.0 / 3.0), ("x*y", 1.0)],
        ],
        trajectories: vec![Trajectory {
            start: vec![-8.0, 7.0, 27.0],
            inputs: Vec::new(),
        }],
        step: 0.002,
        rows: 5000,
    }
}
