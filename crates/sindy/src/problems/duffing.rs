//! The forced Duffing oscillator.

use super::{Problem, Trajectory, monomials};

/// The forced Duffing oscillator with a double well
///
/// ```text
/// x' = v
/// v' = x - 0.3 v - x^3 + u,   u = 0.5 cos(1.2 t)
/// ```
///
/// from (1, 0), 5000 samples at a step of 0.02; library: cubic in x and v, and u. Chaotic. Without the
/// force it rests at x = ±1 (stable) and at 0 (a saddle).
///
/// Source: G. Duffing, *Erzwungene Schwingungen bei veränderlicher Eigenfrequenz* (1918); these
/// parameters: I. Kovacic & M. J. Brennan (eds.), *The Duffing Equation* (2011).
#[must_use]
pub fn duffing() -> Problem {
    let mut terms = monomials(&["x", "v"], 3);
    terms.push("u".to_owned());
    Problem {
        name: "Duffing",
        states: vec!["x", "v"],
        inputs: vec!["u"],
        terms,
        truth: vec![
            vec![("v", 1.0)],
            vec![("x", 1.0), ("v", -0.3), ("x^3", -1.0), ("u", 1.0)],
        ],
        trajectories: vec![Trajectory {
            start: vec![1.0, 0.0],
            inputs: vec!["0.5*cos(1.2*t)".to_owned()],
        }],
        step: 0.02,
        rows: 5000,
    }
}
