//! The problems: a system, what is done to its data, and terms that its library lacks.

use crate::corruption::Corruption::{self, *};
use crate::systems::*;

/// One problem.
#[derive(Clone, Copy)]
pub(crate) struct Problem {
    pub(crate) system: System,
    pub(crate) corruption: Corruption,
    /// Terms of the truth that the library does not have.
    pub(crate) without: &'static [&'static str],
}

impl Problem {
    pub(crate) fn name(&self) -> String {
        let without = match self.without {
            [] => String::new(),
            all => format!(", without {}", all.join(", ")),
        };
        format!("{}: {}{without}", self.system.name, self.corruption.name())
    }

    /// What it asks of a program.
    pub(crate) fn class(&self) -> &'static str {
        match self.system.task {
            Task::Positions => return "position only",
            Task::Hybrid => return "hybrid",
            Task::Diffusion(_) => return "state-dependent diffusion",
            Task::Disturbed(_) => return "process noise",
            Task::States => {}
        }
        match self.system.clock {
            Clock::Map => "maps",
            Clock::Logarithmic(..) => "stiff",
            Clock::Every(_) => self.corruption.class(),
        }
    }

    /// Whether the library holds the truth.
    pub(crate) fn is_complete(&self) -> bool {
        self.without.is_empty()
    }
}

const fn of(system: System, corruption: Corruption) -> Problem {
    lacks(system, corruption, &[])
}

const fn lacks(
    system: System,
    corruption: Corruption,
    without: &'static [&'static str],
) -> Problem {
    Problem {
        system,
        corruption,
        without,
    }
}

/// In the order of the table.
pub(crate) const PROBLEMS: &[Problem] = &[
    of(BRUSSELATOR, White(1.0)),
    of(PENDULUM, White(1.0)),
    of(FITZHUGH_NAGUMO, White(1.0)),
    of(SIR, White(1.0)),
    of(ROSSLER, White(1.0)),
    of(LORENZ_96, White(1.0)),
    of(CHUA, White(1.0)),
    of(RIGID_BODY, White(1.0)),
    of(SELKOV, White(1.0)),
    of(FORCED_DUFFING, White(1.0)),
    of(SWITCHED, White(1.0)),
    of(QUADRATIC_DRAG, White(1.0)),
    of(WEAK_FRICTION, White(1.0)),
    of(WEAK_SATURATION, White(1.0)),
    of(LORENZ, White(0.1)),
    of(LORENZ, WhiteEach(&[0.5, 5.0, 10.0])),
    of(LOTKA_VOLTERRA, Proportional(2.0)),
    of(BRUSSELATOR, Autoregressive(0.5, 2.0)),
    of(LOTKA_VOLTERRA, Autoregressive(0.5, 2.0)),
    of(PENDULUM, Autoregressive(0.5, 2.0)),
    of(LORENZ, Autoregressive(0.5, 2.0)),
    of(FITZHUGH_NAGUMO, Autoregressive(0.5, 2.0)),
    of(CHUA, Autoregressive(0.5, 2.0)),
    of(FORCED_DUFFING, Autoregressive(0.5, 2.0)),
    of(RIGID_BODY, Autoregressive(0.5, 2.0)),
    of(BRUSSELATOR, Autoregressive(0.9, 0.5)),
    of(LOTKA_VOLTERRA, Autoregressive(0.9, 0.5)),
    of(PENDULUM, Autoregressive(0.9, 0.5)),
    of(LORENZ, Autoregressive(0.9, 0.5)),
    of(VAN_DER_POL, Autoregressive(0.9, 0.5)),
    of(ROSSLER, Autoregressive(0.9, 0.5)),
    of(SELKOV, Autoregressive(0.9, 0.5)),
    of(BRUSSELATOR, Walk(2.0)),
    of(LOTKA_VOLTERRA, Walk(2.0)),
    of(PENDULUM, Walk(2.0)),
    of(LORENZ, Walk(2.0)),
    of(DUFFING, Walk(2.0)),
    of(LOTKA_VOLTERRA, HeavyTails(0.5)),
    of(FITZHUGH_NAGUMO, HeavyTails(0.5)),
    of(LORENZ, HeavyTails(0.5)),
    of(SELKOV, HeavyTails(0.5)),
    of(VAN_DER_POL, Quantised(5.0)),
    of(LOTKA_VOLTERRA, Quantised(5.0)),
    of(PENDULUM, Quantised(5.0)),
    of(LORENZ, Outliers(1.0)),
    of(BRUSSELATOR, Outliers(1.0)),
    of(SIR, Outliers(1.0)),
    of(LORENZ, Missing(10.0)),
    of(FITZHUGH_NAGUMO, Missing(10.0)),
    of(PENDULUM, Missing(10.0)),
    of(LORENZ, Missing(50.0)),
    of(BRUSSELATOR, Missing(40.0)),
    of(LORENZ, Rates(&[1, 5, 10])),
    of(BRUSSELATOR, Rates(&[3, 2])),
    of(PENDULUM, Rates(&[1, 10])),
    of(LOTKA_VOLTERRA, Rates(&[2, 2])),
    of(SIR, Rates(&[4, 1])),
    of(FORCED_DUFFING, Rates(&[1, 8])),
    of(VAN_DER_POL, Irregular(1.0)),
    of(LOTKA_VOLTERRA, Irregular(1.0)),
    of(ROSSLER, Irregular(1.0)),
    of(VAN_DER_POL, Process(2.0)),
    of(DUFFING, Process(2.0)),
    of(LORENZ, Process(2.0)),
    of(DOUBLE_WELL, Process(20.0)),
    of(LOTKA_VOLTERRA, ProcessAndWhite(2.0, 1.0)),
    of(SLOW_REVERSION, None),
    of(SLOW_REVERSION, White(5.0)),
    of(PUSHED_OSCILLATOR, None),
    of(HENON, Process(0.5)),
    of(HENON, White(0.1)),
    of(LOGISTIC, Process(0.5)),
    of(LOGISTIC, White(0.1)),
    of(DELAYED_LOGISTIC, Process(1.0)),
    of(DELAYED_LOGISTIC, White(1.0)),
    of(HENON, White(1.0)),
    of(TWO_POPULATIONS, None),
    of(TWO_POPULATIONS, White(1.0)),
    of(TWO_POPULATIONS, White(3.0)),
    of(DRIVEN_MAP, White(1.0)),
    of(DRIVEN_MAP, Outliers(1.0)),
    of(DRIVEN_MAP, Outliers(3.0)),
    of(TWO_POPULATIONS, Outliers(1.0)),
    of(ROBERTSON, None),
    of(ROBERTSON, White(0.1)),
    of(FAST_EXCHANGE, None),
    of(FAST_EXCHANGE, White(0.1)),
    of(ENZYME, None),
    of(ENZYME, White(0.1)),
    of(RELAXATION, None),
    of(RELAXATION, White(0.1)),
    of(OREGONATOR, None),
    of(GROUND_EFFECT, White(10.0)),
    of(GROUND_EFFECT, White(20.0)),
    of(GROUND_EFFECT, Autoregressive(0.5, 10.0)),
    of(PENDULUM_POSITION, White(1.0)),
    of(DUFFING_POSITION, White(1.0)),
    of(VAN_DER_POL_POSITION, White(1.0)),
    of(COUPLED_POSITIONS, White(1.0)),
    of(PENDULUM_POSITION, Autoregressive(0.5, 2.0)),
    of(DUFFING_POSITION, Autoregressive(0.5, 2.0)),
    of(VAN_DER_POL_POSITION, Autoregressive(0.5, 2.0)),
    of(COUPLED_POSITIONS, Autoregressive(0.5, 2.0)),
    of(PENDULUM_POSITION, Encoder(1.0)),
    of(DUFFING_POSITION, Encoder(1.0)),
    of(VAN_DER_POL_POSITION, Encoder(1.0)),
    of(COUPLED_POSITIONS, Encoder(1.0)),
    of(RELAY, White(1.0)),
    of(STOP, White(1.0)),
    of(DRY_FRICTION, White(1.0)),
    of(RELAY, Autoregressive(0.9, 0.5)),
    of(STOP, Autoregressive(0.9, 0.5)),
    of(DRY_FRICTION, Autoregressive(0.9, 0.5)),
    of(BLACK_SCHOLES, None),
    of(MEAN_REVERSION, None),
    of(ORNSTEIN_UHLENBECK, None),
    of(LANGEVIN, None),
    of(COX_INGERSOLL_ROSS, None),
    of(DEMOGRAPHIC, None),
    of(LANGEVIN, White(3.0)),
    lacks(PENDULUM, White(1.0), &["sin(q)"]),
    lacks(BRUSSELATOR, White(1.0), &["x^2*y"]),
    lacks(VAN_DER_POL, White(1.0), &["x^2*y"]),
    lacks(LORENZ, White(1.0), &["x*z"]),
    lacks(DUFFING, White(1.0), &["x^3"]),
    lacks(HOLLING, White(1.0), &["x*y/(1 + x)"]),
    lacks(LOTKA_VOLTERRA, Autoregressive(0.5, 2.0), &["x*y"]),
    lacks(FITZHUGH_NAGUMO, Autoregressive(0.9, 0.5), &["v^3"]),
    lacks(RIGID_BODY, Autoregressive(0.5, 2.0), &["p*r"]),
    lacks(SELKOV, Walk(2.0), &["x^2*y"]),
    lacks(LORENZ, Rates(&[1, 5, 10]), &["x*z"]),
    lacks(PENDULUM, Rates(&[1, 10]), &["sin(q)"]),
    lacks(PENDULUM_POSITION, White(1.0), &["sin(q)"]),
    lacks(DUFFING_POSITION, White(1.0), &["x^3"]),
    lacks(RELAY, White(1.0), &["sign(x)"]),
    lacks(STOP, White(1.0), &["max(x - 1, 0)"]),
    lacks(DRY_FRICTION, White(1.0), &["tanh(20*v)"]),
    lacks(QUADRATIC_DRAG, White(1.0), &["v*abs(v)"]),
    lacks(QUADRATIC_DRAG, White(0.3), &["v*abs(v)"]),
    lacks(WEAK_FRICTION, White(1.0), &["tanh(25*v)"]),
    lacks(WEAK_FRICTION, White(3.0), &["tanh(25*v)"]),
    lacks(WEAK_SATURATION, White(1.0), &["x*y/(1 + 0.5*x)"]),
    lacks(HENON, Process(0.5), &["x^2"]),
    lacks(VAN_DER_POL, Process(2.0), &["x^2*y"]),
    lacks(DUFFING, Process(2.0), &["x^3"]),
    lacks(LORENZ, Process(2.0), &["x*z"]),
    lacks(LOTKA_VOLTERRA, ProcessAndWhite(2.0, 1.0), &["x*y"]),
];
