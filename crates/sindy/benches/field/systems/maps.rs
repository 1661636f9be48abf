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
