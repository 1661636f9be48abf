//! Systems `dx = f dt + g dW` with known drift f and squared diffusion g². The candidates of both are polynomials.

use super::{Candidates, Clock, PLAIN, System, Task};

/// What the systems here share.
const ONE_STATE: System = System {
    states: &["x"],
    candidates: Candidates::Degree(2),
    clock: Clock::Every(0.02),
    // The error of half a step of Euler and Maruyama is a hundredth of what a row adds.
    substeps: 50,
    ..PLAIN
};

pub(crate) const BLACK_SCHOLES: System = System {
    name: "geometric Brownian motion",
    truth: &[&[("x", 0.8)]],
    task: Task::Diffusion(&[&[("x^2", 0.09)]]),
    runs: &[
        (&[1.0], &[]),
        (&[2.0], &[]),
        (&[0.5], &[]),
        (&[1.5], &[]),
        (&[3.0], &[]),
        (&[0.8], &[]),
        (&[1.2], &[]),
        (&[2.5], &[]),
    ],
    clock: Clock::Every(0.01),
    rows: 250,
    ..ONE_STATE
};

pub(crate) const MEAN_REVERSION: System = System {
    name: "geometric Brownian motion with mean reversion",
    truth: &[&[("1", 1.2), ("x", -1.2)]],
    task: Task::Diffusion(&[&[("x^2", 0.16)]]),
    runs: &[(&[3.0], &[]), (&[0.3], &[]), (&[1.0], &[])],
    rows: 2000,
    ..ONE_STATE
};

/// Its diffusion is a constant.
pub(crate) const ORNSTEIN_UHLENBECK: System = System {
    name: "Ornstein-Uhlenbeck",
    truth: &[&[("x", -1.0)]],
    task: Task::Diffusion(&[&[("1", 0.25)]]),
    runs: &[(&[2.0], &[]), (&[-1.0], &[])],
    clock: Clock::Every(0.05),
    rows: 1500,
    ..ONE_STATE
};

/// Langevin's equation in two wells, with noise that grows away from the middle.
pub(crate) const LANGEVIN: System = System {
    name: "Langevin, double well",
    truth: &[&[("x", 2.0), ("x^3", -2.0)]],
    task: Task::Diffusion(&[&[("1", 0.2), ("x^2", 0.4)]]),
    candidates: Candidates::Degree(3),
    runs: &[(&[1.5], &[]), (&[-1.5], &[]), (&[0.0], &[]), (&[0.3], &[])],
    rows: 2500,
    ..ONE_STATE
};

pub(crate) const COX_INGERSOLL_ROSS: System = System {
    name: "Cox-Ingersoll-Ross",
    truth: &[&[("1", 2.0), ("x", -2.0)]],
    task: Task::Diffusion(&[&[("x", 0.36)]]),
    runs: &[(&[3.0], &[]), (&[0.2], &[]), (&[1.0], &[])],
    rows: 2000,
    ..ONE_STATE
};

/// Populations stay so large that none dies out.
pub(crate) const DEMOGRAPHIC: System = System {
    name: "Lotka-Volterra with demographic noise",
    states: &["x", "y"],
    truth: &[&[("x", 1.1), ("x*y", -0.4)], &[("y", -0.4), ("x*y", 0.1)]],
    task: Task::Diffusion(&[&[("x", 0.004)], &[("y", 0.002)]]),
    runs: &[(&[6.0, 2.0], &[]), (&[5.0, 4.0], &[])],
    clock: Clock::Every(0.05),
    rows: 1000,
    ..ONE_STATE
};

/// Rows are so seldom that a constant and the state hardly differ from a constant and its square.
pub(crate) const SLOW_REVERSION: System = System {
    name: "slow reversion",
    truth: &[&[("1", 1.5), ("x", -0.5)]],
    task: Task::Disturbed(&[&[("1", 0.16)]]),
    runs: &[(&[3.0], &[])],
    clock: Clock::Every(0.1),
    rows: 3000,
    ..ONE_STATE
};

/// Noise acts on the velocity alone.
pub(crate) const PUSHED_OSCILLATOR: System = System {
    name: "pushed oscillator",
    states: &["x", "v"],
    truth: &[&[("v", 1.0)], &[("x", -2.0), ("v", -0.3), ("x^3", -0.5)]],
    task: Task::Disturbed(&[&[], &[("1", 2.0)]]),
    candidates: Candidates::Degree(3),
    runs: &[(&[1.0, 0.0], &[])],
    clock: Clock::Every(0.05),
    rows: 5000,
    substeps: 50,
    ..ONE_STATE
};
