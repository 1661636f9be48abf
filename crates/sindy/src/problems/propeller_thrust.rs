//! A throttle-to-thrust model with terms other than monomials.

use super::{Problem, Trajectory, monomials};

/// A published fit of the thrust of a multirotor's propellers: x is the square root of the thrust in √N,
/// s the throttle in [0, 1], time in seconds,
///
/// ```text
/// x' = 0.215 - 0.650 x + 13.882 s + 11.815 s^2 - 0.123 x^3 - 12.825 s^3
///      - 16.647 exp(-x) s - 1.457 sin(x) s
/// ```
///
/// from 2.844 (the rest at s = 0.3), 3000 samples at 100 Hz under a smooth throttle between 0.2 and 0.6;
/// library: cubic in x and s, exp(-x) s, sin(x) s. The model means something for x above 0.3 only: near
/// zero it has an unstable branch.
///
/// Source: equation (11) of "Data-Driven Modeling of Ground Effect For UAV Landing on a Vertical
/// Oscillating Platform".
#[must_use]
pub fn propeller_thrust() -> Problem {
    let mut terms = monomials(&["x", "s"], 3);
    terms.extend(["exp(-x)*s", "sin(x)*s"].map(str::to_owned));
    Problem {
        name: "propeller thrust",
        states: vec!["x"],
        inputs: vec!["s"],
        terms,
        truth: vec![vec![
            ("1", 0.215),
            ("x", -0.650),
            ("s", 13.882),
            ("s^2", 11.815),
            ("x^3", -0.123),
            ("s^3", -12.825),
            ("exp(-x)*s", -16.647),
            ("sin(x)*s", -1.457),
        ]],
        trajectories: vec![Trajectory {
            start: vec![2.8440175],
            inputs: vec!["0.4 + 0.12*sin(1.3*t) + 0.08*sin(4.1*t + 1)".to_owned()],
        }],
        step: 0.01,
        rows: 3000,
    }
}
