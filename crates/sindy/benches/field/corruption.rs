//! What is done to the true states of a system before they are fitted.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal, StudentT};
use rand_pcg::Pcg64;

/// Noise and losses; sizes are in percent of a state's standard deviation over all trajectories.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Corruption {
    /// Nothing.
    None,
    White(f64),
    /// White noise of percent for each state in turn.
    WhiteEach(&'static [f64]),
    /// `e[k] = phi e[k-1] + white`, of this size in the stationary state: `phi`, percent.
    Autoregressive(f64, f64),
    /// A random walk of this root mean square over each trajectory.
    Walk(f64),
    /// Student's t with two degrees of freedom (its variance is infinite), scaled by percent.
    HeavyTails(f64),
    /// Each value times 1 + noise of percent.
    Proportional(f64),
    /// White noise of 0.2 % and then rounding to steps of percent.
    Quantised(f64),
    /// Rounding to steps of percent, and nothing else: an encoder.
    Encoder(f64),
    /// White noise of 1 %; percent of the values are off by 3 to 10 standard deviations.
    Outliers(f64),
    /// White noise of 1 %; percent of the rows are NaN.
    Missing(f64),
    /// White noise of 1 %; of each state in turn one row in so many is measured.
    Rates(&'static [usize]),
    /// White noise of percent; rows at random times, up to 0.4 steps off.
    Irregular(f64),
    /// The states are driven by white noise: percent in one unit of time (a map: in each iteration).
    Process(f64),
    /// As before, and white noise on the measured values: percent of each.
    ProcessAndWhite(f64, f64),
}

impl Corruption {
    pub(crate) fn name(self) -> String {
        match self {
            Self::None => "none".into(),
            Self::White(p) => format!("white {p} %"),
            Self::WhiteEach(p) => format!("white {p:?} %"),
            Self::Autoregressive(phi, p) => format!("AR {phi}, {p} %"),
            Self::Walk(p) => format!("random walk {p} %"),
            Self::HeavyTails(p) => format!("Student t(2) {p} %"),
            Self::Proportional(p) => format!("proportional {p} %"),
            Self::Quantised(p) => format!("quantised {p} %"),
            Self::Encoder(p) => format!("encoder, steps of {p} %"),
            Self::Outliers(p) => format!("outliers {p} %"),
            Self::Missing(p) => format!("NaN rows {p} %"),
            Self::Rates(rows) => format!("rates {rows:?}"),
            Self::Irregular(p) => format!("irregular times, white {p} %"),
            Self::Process(p) => format!("process noise {p} %"),
            Self::ProcessAndWhite(p, w) => format!("process noise {p} %, white {w} %"),
        }
    }

    /// Which of them are alike.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::None => "no noise",
            Self::White(_) | Self::WhiteEach(_) => "white noise",
            Self::Proportional(_) => "proportional noise",
            Self::Autoregressive(..) => "coloured noise (AR)",
            Self::Walk(_) => "random walk",
            Self::HeavyTails(_) => "heavy tails",
            Self::Quantised(_) | Self::Encoder(_) => "quantised",
            Self::Outliers(_) => "outliers",
            Self::Missing(_) => "missing rows",
            Self::Rates(_) => "different rates",
            Self::Irregular(_) => "irregular times",
            Self::Process(_) | Self::ProcessAndWhite(..) => "process noise",
        }
    }

    /// Percent of the noise that drives the states.
    pub(crate) fn process(self) -> f64 {
        match self {
            Self::Process(p) | Self::ProcessAndWhite(p, _) => p,
            _ => 0.0,
        }
    }

    /// Spoils the states of one trajectory, whose standard deviations are `sd`.
    pub(crate) fn apply(self, states: &mut [Vec<f64>], sd: &[f64], rng: &mut Pcg64) {
        for (i, column) in states.iter_mut().enumerate() {
            match self {
                Self::None | Self::Process(_) => {}
                Self::White(p) | Self::Irregular(p) | Self::ProcessAndWhite(_, p) => {
                    white(column, 0.01 * p * sd[i], rng);
                }
                Self::WhiteEach(p) => white(column, 0.01 * p[i] * sd[i], rng),
                Self::Autoregressive(phi, p) => autoregressive(column, phi, 0.01 * p * sd[i], rng),
                Self::Walk(p) => walk(column, 0.01 * p * sd[i], rng),
                Self::HeavyTails(p) => heavy(column, 0.01 * p * sd[i], rng),
                Self::Proportional(p) => {
                    column
                        .iter_mut()
                        .for_each(|v| *v *= 1.0 + 0.01 * p * normal(rng));
                }
                Self::Quantised(p) => {
                    white(column, 0.002 * sd[i], rng);
                    round(column, 0.01 * p * sd[i]);
                }
                Self::Encoder(p) => round(column, 0.01 * p * sd[i]),
                Self::Outliers(p) => {
                    white(column, 0.01 * sd[i], rng);
                    for v in column.iter_mut() {
                        if rng.random_range(0.0..100.0) < p {
                            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                            *v += sign * sd[i] * rng.random_range(3.0..10.0);
                        }
                    }
                }
                Self::Missing(_) => white(column, 0.01 * sd[i], rng),
                Self::Rates(rows) => {
                    white(column, 0.01 * sd[i], rng);
                    for (row, v) in column.iter_mut().enumerate() {
                        if row % rows[i] != i % rows[i] {
                            *v = f64::NAN;
                        }
                    }
                }
            }
        }
        if let Self::Missing(p) = self {
            for row in 0..states[0].len() {
                if rng.random_range(0.0..100.0) < p {
                    states.iter_mut().for_each(|column| column[row] = f64::NAN);
                }
            }
        }
    }
}

pub(crate) fn normal(rng: &mut Pcg64) -> f64 {
    StandardNormal.sample(rng)
}

fn white(column: &mut [f64], size: f64, rng: &mut Pcg64) {
    column.iter_mut().for_each(|v| *v += size * normal(rng));
}

fn round(column: &mut [f64], step: f64) {
    column
        .iter_mut()
        .for_each(|v| *v = (*v / step).round() * step);
}

fn autoregressive(column: &mut [f64], phi: f64, size: f64, rng: &mut Pcg64) {
    let innovation = (1.0 - phi * phi).sqrt();
    let mut e = normal(rng);
    for v in column {
        *v += size * e;
        e = phi * e + innovation * normal(rng);
    }
}

fn walk(column: &mut [f64], size: f64, rng: &mut Pcg64) {
    let mut at = 0.0;
    let path: Vec<f64> = column
        .iter()
        .map(|_| {
            at += normal(rng);
            at
        })
        .collect();
    let rms = (path.iter().map(|e| e * e).sum::<f64>() / path.len() as f64).sqrt();
    for (v, e) in column.iter_mut().zip(path) {
        *v += size * e / rms;
    }
}

fn heavy(column: &mut [f64], size: f64, rng: &mut Pcg64) {
    // Two degrees of freedom are a valid parameter.
    if let Ok(t) = StudentT::new(2.0) {
        column.iter_mut().for_each(|v| *v += size * t.sample(rng));
    }
}
