//! The Rössler system.

use super::{Problem, Trajectory, monomials};

/// The Rössler system with a = b = 0.2, c = 5.7
///
/// ```text
/// x' = -y - z
/// y' = x + a y
/// z' = b + x z - c z
/// ```
///
/// from (1, 1, 0), 5000 samples at a step of 0.02, cubic library. Chaotic.
///
/// Source: O. E. Rössler, "An equation for continuous chaos", Phys. Lett. A 57 (1976).
#[must_use]
pub fn rossler() -> Problem {
    Problem {
        name: "Rössler",
        states: vec!["x", "y", "z"],
        inputs: Vec::new(),
        terms: monomials(&["x", "y", "z"], 3),
        truth: vec![
            vec![("y", -1.0), ("z", -1.0)],
            vec![("x", 1.0), ("y", 0.2)],
            vec![("1", 0.2), ("z", -5.7), ("x*z", 1.0)],
        ],
        trajectories: vec![Trajectory {
            start: vec![1.0, 1.0, 0.0],
            inputs: Vec::new(),
        }],
        step: 0.02,
        rows: 5000,
    }
}
