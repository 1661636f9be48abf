//! The Lotka–Volterra equations.

use super::{Problem, Trajectory, monomials};

/// The Lotka–Volterra equations with α = 2/3, β = 4/3, γ = δ = 1
///
/// ```text
/// x' = α x - β x y
/// y' = δ x y - γ y
/// ```
///
/// from (1.8, 1.3), 5000 samples at a step of 0.01, cubic library. δ x - γ log x + β y - α log y is
/// conserved; the solutions turn around the rest at (γ/δ, α/β).
///
/// Sources: A. J. Lotka, *Elements of Physical Biology* (1925); V. Volterra, "Fluctuations in the
/// abundance of a species considered mathematically", Nature 118 (1926).
#[must_use]
pub fn lotka_volterra() -> Problem {
    Problem {
        name: "Lotka–Volterra",
        states: vec!["x", "y"],
        inputs: Vec::new(),
        terms: monomials(&["x", "y"], 3),
        truth: vec![
            vec![("x", 2.0 / 3.0), ("x*y", -4.0 / 3.0)],
            vec![("y", -1.0), ("x*y", 1.0)],
        ],
        trajectories: vec![Trajectory {
            start: vec![1.8, 1.3],
            inputs: Vec::new(),
        }],
        step: 0.01,
        rows: 5000,
    }
}
