//! Stiff systems, whose rows are evenly spaced in the logarithm of time.

use super::{Candidates, Clock, PLAIN, System};

/// Relative shares of the species, the second in units of 1e-5.
pub(crate) const ROBERTSON: System = System {
    name: "Robertson",
    states: &["a", "b", "c"],
    truth: &[
        &[("a", -0.04), ("b*c", 0.1)],
        &[("a", 4000.0), ("b*c", -1e4), ("b^2", -300.0)],
        &[("b^2", 3e-3)],
    ],
    candidates: Candidates::Degree(2),
    runs: &[(&[1.0, 0.0, 0.0], &[]), (&[0.6, 0.0, 0.4], &[])],
    clock: Clock::Logarithmic(1e-5, 40.0),
    rows: 400,
    // The fastest rate is some 7000 in one unit of time, and Runge-Kutta is stable to 2.7 of it.
    longest: 2.5e-4,
    ..PLAIN
};

/// Two states that a fast exchange holds together, and a slow decay: eigenvalues -1 and -1e4.
pub(crate) const FAST_EXCHANGE: System = System {
    name: "fast exchange",
    truth: &[
        &[("x", -5000.5), ("y", 4999.5)],
        &[("x", 4999.5), ("y", -5000.5)],
    ],
    candidates: Candidates::Degree(2),
    runs: &[(&[2.0, 0.0], &[]), (&[-0.5, 1.5], &[])],
    clock: Clock::Logarithmic(1e-6, 5.0),
    rows: 300,
    longest: 1e-4,
    ..PLAIN
};

/// Substrate, complex and product of an enzyme (Michaelis and Menten), complex and enzyme in units of the enzyme, of which there is
/// a thousandth of the substrate.
pub(crate) const ENZYME: System = System {
    name: "enzyme",
    states: &["s", "c", "p"],
    truth: &[
        &[("s", -1.0), ("c", 0.5), ("s*c", 1.0)],
        &[("s", 1e3), ("c", -1.5e3), ("s*c", -1e3)],
        &[("c", 1.0)],
    ],
    candidates: Candidates::Degree(2),
    runs: &[(&[1.0, 0.0, 0.0], &[]), (&[2.5, 0.2, 0.3], &[])],
    clock: Clock::Logarithmic(1e-5, 20.0),
    rows: 300,
    longest: 5e-4,
    ..PLAIN
};

/// Half a turn and more of a relaxation oscillation: rows are too far apart to see the jump at t = 82 itself.
pub(crate) const RELAXATION: System = System {
    name: "Van der Pol, mu 100",
    truth: &[
        &[("y", 1.0)],
        &[("x", -1.0), ("y", 100.0), ("x^2*y", -100.0)],
    ],
    runs: &[(&[2.0, 0.0], &[]), (&[0.1, -1.0], &[])],
    clock: Clock::Logarithmic(1e-4, 100.0),
    rows: 600,
    longest: 1e-4,
    ..PLAIN
};

/// The Belousov-Zhabotinsky reaction of Field and Noyes: one spike.
pub(crate) const OREGONATOR: System = System {
    name: "Oregonator",
    states: &["x", "y", "z"],
    truth: &[
        &[
            ("x", 77.27),
            ("y", 77.27),
            ("x*y", -77.27),
            ("x^2", -77.27 * 8.375e-6),
        ],
        &[
            ("y", -1.0 / 77.27),
            ("z", 1.0 / 77.27),
            ("x*y", -1.0 / 77.27),
        ],
        &[("x", 0.161), ("z", -0.161)],
    ],
    candidates: Candidates::Degree(2),
    runs: &[(&[1.0, 2.0, 3.0], &[]), (&[4.0, 1.1, 4.0], &[])],
    clock: Clock::Logarithmic(1e-4, 30.0),
    rows: 600,
    longest: 1e-5,
    ..PLAIN
};
