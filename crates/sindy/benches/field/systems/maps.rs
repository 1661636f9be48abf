//! Maps: one row for each iteration.

use super::{Candidates, Clock, PLAIN, System};

pub(crate) const HENON: System = System {
    name: "Henon map",
    truth: &[&[("1", 1.0), ("x^2", -1.4), ("y", 1.0)], &[("x", 0.3)]],
    runs: &[(&[0.1, 0.1], &[])],
    clock: Clock::Map,
    rows: 600,
    ..PLAIN
};

pub(crate) const LOGISTIC: System = System {
    name: "logistic map",
    states: &["x"],
    truth: &[&[("x", 3.8), ("x^2", -3.8)]],
    candidates: Candidates::Degree(5),
    runs: &[(&[0.3], &[]), (&[0.77], &[])],
    clock: Clock::Map,
    rows: 300,
    ..PLAIN
};

/// The logistic map with a memory of one step.
pub(crate) const DELAYED_LOGISTIC: System = System {
    name: "delayed logistic map",
    truth: &[&[("x", 2.2), ("x*y", -2.2)], &[("x", 1.0)]],
    runs: &[(&[0.3, 0.3], &[]), (&[0.6, 0.5], &[]), (&[0.2, 0.4], &[])],
    clock: Clock::Map,
    rows: 100,
    ..PLAIN
};

/// Prey and predator from year to year.
pub(crate) const TWO_POPULATIONS: System = System {
    name: "two populations, map",
    truth: &[
        &[("x", 3.4), ("x^2", -3.4), ("x*y", -0.3)],
        &[("y", 0.7), ("x*y", 0.9), ("x*y^2", -0.9)],
    ],
    runs: &[(&[0.5, 0.2], &[]), (&[0.3, 0.6], &[])],
    clock: Clock::Map,
    rows: 400,
    ..PLAIN
};

pub(crate) const DRIVEN_MAP: System = System {
    name: "driven map",
    states: &["x"],
    inputs: &["u"],
    truth: &[&[("x", 0.8), ("x^3", -0.15), ("u", 0.4)]],
    runs: &[(
        &[0.2],
        &["sin(0.37*t) + 0.7*sin(0.91*t + 1) + 0.5*sin(1.73*t)"],
    )],
    clock: Clock::Map,
    rows: 700,
    ..PLAIN
};
