//! Oscillators and populations with one weak term that polynomials imitate.

use super::{Candidates, Clock, PLAIN, System};

const WITH_DRAG: &[&str] = &[
    "1", "x", "v", "x^2", "x*v", "v^2", "x^3", "x^2*v", "x*v^2", "v^3", "v*abs(v)",
];

pub(crate) const QUADRATIC_DRAG: System = System {
    name: "quadratic drag",
    states: &["x", "v"],
    truth: &[&[("v", 1.0)], &[("x", -1.5), ("v*abs(v)", -0.25)]],
    candidates: Candidates::Terms(WITH_DRAG),
    runs: &[(&[2.2, 0.0], &[])],
    clock: Clock::Every(0.08),
    rows: 500,
    ..PLAIN
};

const WITH_FRICTION: &[&str] = &[
    "1",
    "x",
    "v",
    "x^2",
    "x*v",
    "v^2",
    "x^3",
    "x^2*v",
    "x*v^2",
    "v^3",
    "tanh(25*v)",
];

pub(crate) const WEAK_FRICTION: System = System {
    name: "weak dry friction",
    states: &["x", "v"],
    truth: &[
        &[("v", 1.0)],
        &[("x", -3.0), ("v", -0.08), ("tanh(25*v)", -0.12)],
    ],
    candidates: Candidates::Terms(WITH_FRICTION),
    runs: &[(&[1.8, 0.0], &[])],
    rows: 500,
    ..PLAIN
};

const WITH_SATURATION: &[&str] = &[
    "1",
    "x",
    "y",
    "x^2",
    "x*y",
    "y^2",
    "x^3",
    "x^2*y",
    "x*y^2",
    "y^3",
    "x*y/(1 + 0.5*x)",
];

pub(crate) const WEAK_SATURATION: System = System {
    name: "weak saturation",
    truth: &[
        &[("x", 1.0), ("x^2", -0.2), ("x*y/(1 + 0.5*x)", -0.8)],
        &[("x*y/(1 + 0.5*x)", 0.6), ("y", -0.5)],
    ],
    candidates: Candidates::Terms(WITH_SATURATION),
    runs: &[(&[2.5, 0.8], &[]), (&[0.8, 0.4], &[])],
    clock: Clock::Every(0.1),
    rows: 400,
    ..PLAIN
};
