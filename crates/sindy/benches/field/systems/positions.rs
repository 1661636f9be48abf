//! Oscillators whose positions alone are measured; states are positions, and then their velocities.

use super::{Candidates, Clock, PLAIN, System, Task};

/// With friction; it swings, and the second trajectory begins with a turn over the top.
pub(crate) const PENDULUM_POSITION: System = System {
    name: "pendulum, position",
    states: &["q", "q_dot"],
    truth: &[&[("q_dot", 1.0)], &[("q_dot", -0.15), ("sin(q)", -4.0)]],
    candidates: Candidates::Terms(&[
        "1",
        "q",
        "q_dot",
        "q^2",
        "q*q_dot",
        "q_dot^2",
        "q^3",
        "q_dot^3",
        "sin(q)",
        "cos(q)",
        "q_dot*sin(q)",
        "q_dot*cos(q)",
    ]),
    runs: &[(&[2.6, 0.0], &[]), (&[-2.0, 3.5], &[])],
    clock: Clock::Every(0.03),
    task: Task::Positions,
    ..PLAIN
};

/// Two wells with friction.
pub(crate) const DUFFING_POSITION: System = System {
    name: "Duffing, position",
    states: &["x", "x_dot"],
    truth: &[
        &[("x_dot", 1.0)],
        &[("x", 1.2), ("x_dot", -0.25), ("x^3", -0.8)],
    ],
    runs: &[(&[2.2, 0.0], &[]), (&[-0.3, 1.8], &[])],
    task: Task::Positions,
    ..PLAIN
};

pub(crate) const VAN_DER_POL_POSITION: System = System {
    name: "Van der Pol, position",
    states: &["x", "x_dot"],
    truth: &[
        &[("x_dot", 1.0)],
        &[("x", -1.0), ("x_dot", 1.2), ("x^2*x_dot", -1.2)],
    ],
    runs: &[(&[0.2, 0.0], &[]), (&[3.0, -1.0], &[])],
    clock: Clock::Every(0.04),
    task: Task::Positions,
    ..PLAIN
};

/// Two masses between walls: linear springs, a cubic one at the first wall, dampers.
pub(crate) const COUPLED_POSITIONS: System = System {
    name: "two oscillators, positions",
    states: &["a", "b", "a_dot", "b_dot"],
    truth: &[
        &[("a_dot", 1.0)],
        &[("b_dot", 1.0)],
        &[("a", -3.0), ("b", 1.0), ("a_dot", -0.1), ("a^3", -1.5)],
        &[("a", 1.0), ("b", -2.0), ("b_dot", -0.08)],
    ],
    runs: &[
        (&[1.5, -0.5, 0.0, 0.0], &[]),
        (&[-0.4, 1.2, 1.0, 0.5], &[]),
        (&[0.8, 0.9, -1.5, 0.0], &[]),
    ],
    rows: 600,
    task: Task::Positions,
    ..PLAIN
};
