//! Equations that switch. The integrator's steps are so short that one across a switch errs by less than a thousandth of the
//! states' scatter.

use super::{Candidates, Clock, PLAIN, System, Task};

/// What the systems here share.
const SWITCHES: System = System {
    states: &["x", "v"],
    inputs: &["u"],
    clock: Clock::Every(0.04),
    substeps: 400,
    task: Task::Hybrid,
    ..PLAIN
};

/// A mass with friction whose force is a relay's.
pub(crate) const RELAY: System = System {
    name: "relay control",
    truth: &[&[("v", 1.0)], &[("v", -0.4), ("u", 1.0), ("sign(x)", -1.5)]],
    candidates: Candidates::Terms(&[
        "1", "x", "v", "u", "x^2", "x*v", "v^2", "x^3", "v^3", "sign(x)", "sign(v)",
    ]),
    runs: &[
        (&[1.0, 0.0], &["0.8*cos(1.3*t)"]),
        (&[-0.5, 1.0], &["0.6*sin(0.7*t) + 0.5*cos(2.1*t)"]),
    ],
    ..SWITCHES
};

/// An oscillator that meets a stiff spring at x = 1.
pub(crate) const STOP: System = System {
    name: "one-sided stop",
    truth: &[
        &[("v", 1.0)],
        &[
            ("x", -1.0),
            ("v", -0.1),
            ("u", 1.0),
            ("max(x - 1, 0)", -25.0),
        ],
    ],
    candidates: Candidates::Terms(&[
        "1",
        "x",
        "v",
        "u",
        "x^2",
        "x*v",
        "v^2",
        "x^3",
        "v^3",
        "max(x - 1, 0)",
        "min(x + 1, 0)",
    ]),
    runs: &[
        (&[0.0, 2.0], &["0.6*cos(1.1*t)"]),
        (&[-1.5, 0.0], &["0.5*sin(0.8*t) + 0.4*cos(1.7*t)"]),
    ],
    ..SWITCHES
};

/// A driven oscillator with dry friction.
pub(crate) const DRY_FRICTION: System = System {
    name: "dry friction",
    truth: &[
        &[("v", 1.0)],
        &[("x", -4.0), ("u", 1.0), ("tanh(20*v)", -0.6)],
    ],
    candidates: Candidates::Terms(&[
        "1",
        "x",
        "v",
        "u",
        "x^2",
        "x*v",
        "v^2",
        "x^3",
        "v^3",
        "sign(x)",
        "tanh(20*v)",
    ]),
    runs: &[
        (&[1.0, 0.0], &["1.8*cos(1.4*t)"]),
        (&[-0.8, 1.0], &["1.2*sin(0.9*t) + cos(2.3*t)"]),
    ],
    ..SWITCHES
};
