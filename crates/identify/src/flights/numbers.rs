//! The numbers of a ground effect, with their intervals.

use serde::Serialize;

use super::drift::DRIFT_S;
use super::ground::{Basis, GroundEffect};
use super::hover::ThrustLaw;
use super::model::{ModelValues, Segment};
use crate::estimate::Estimate;

/// Share of a decay that no resampling shows. It rests on the little lift at three rotor radii, beside which the zero of the
/// accelerometer and the turbulence are uncertain. Without it 29 of 35 intervals of independent vehicles held (`flight_coverage`),
/// with it 46 of 46 of other seeds.
const DECAY_BIAS: f64 = 0.05;

/// Share of the throttle's period that is a standard error of the motors' lag beside the others: commands between two rows, which
/// a log does not show, make it short. By 0.14 of the period on average, root mean square 0.16, at most 0.35, over 32 sets of flights
/// (`flight_cases`, `between-rows`, sets 3001 to 3032).
const LAG_BETWEEN_ROWS: f64 = 0.16;

/// Share of a row that is a standard error of the accelerometer's latency beside the others: no latency describes a low-pass filter
/// at all frequencies. Root mean square of the error 0.10 of a row of 10 ms, at most 0.18, over 16 sets of flights (`flight_cases`,
/// the four cases of late accelerometers, sets 1 to 4), where the others gave 0.05. Behind filters it is below the latency at low frequencies.
const LATENCY_OF_ROWS: f64 = 0.1;

/// By how much a range may come before the accelerometer above a ground that moves (s).
const EARLIEST_RANGE_S: f64 = 0.01;

/// Latency of a range above a ground that moves, from which it is warned of (s).
const LATEST_RANGE_S: f64 = 0.06;

/// A number of the model, with its unit.
#[derive(Clone, Debug, Serialize)]
pub struct Number {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Value and interval.
    #[serde(flatten)]
    pub estimate: Estimate,
}

impl Number {
    /// Its name in words.
    #[must_use]
    pub fn words(&self) -> String {
        match self.name.as_str() {
            "T_m" => "motor lag T_m".to_string(),
            name => name.replace('_', " "),
        }
    }
}

impl GroundEffect {
    /// Ratio of thrust to that out of ground effect, minus one, at rest at a height (m).
    #[must_use]
    pub fn ratio(&self, height_m: f64) -> Option<Estimate> {
        let z = height_m / self.rotor_radius_m;
        self.of_curve(|v| v.at_rest(z))
    }

    /// Mean lift over the heights `near` relative to that over `far` (m), as a share of thrust.
    #[must_use]
    pub fn extra_lift(&self, near: [f64; 2], far: [f64; 2]) -> Option<Estimate> {
        const POINTS: usize = 20;
        let r = self.rotor_radius_m;
        self.of_curve(|v| {
            let mean = |[a, b]: [f64; 2]| -> f64 {
                let at = |k: usize| a + (b - a) * (k as f64 + 0.5) / POINTS as f64;
                (0..POINTS).map(|k| v.at_rest(at(k) / r)).sum::<f64>() / POINTS as f64
            };
            mean(near) - mean(far)
        })
    }

    /// Decay of the curve between half a rotor radius and three, as that of an exponential (1/m).
    #[must_use]
    pub fn decay_per_m(&self) -> Option<Estimate> {
        let [a, b] = [0.5, 3.0];
        let found =
            self.of_curve(|v| (v.at_rest(a) / v.at_rest(b)).ln() / ((b - a) * self.rotor_radius_m));
        found.map(|found| found.beside(DECAY_BIAS * found.value))
    }

    /// A property of the curve.
    pub(super) fn of_curve(&self, f: impl Fn(&ModelValues) -> f64) -> Option<Estimate> {
        self.spread.of_model(&self.fit, f)
    }

    /// The wake's lag (s), where it was resolved: of a wake with several, the single one that follows it best.
    #[must_use]
    pub fn lag_s(&self) -> Option<Estimate> {
        self.lag
    }

    /// Lag of the motors (s), where its interval is above zero, with what the rows of the log do not show of the commands.
    #[must_use]
    pub fn motor_lag_s(&self) -> Option<Estimate> {
        self.motor_lag_estimate_s().filter(|lag| lag.ci95[0] > 0.0)
    }

    /// The same, also where its interval contains zero: such a lag is not identifiable from a dead time.
    pub(super) fn motor_lag_estimate_s(&self) -> Option<Estimate> {
        let measured = self.basis == Basis::Accelerometer;
        let found = self.spread.number(&self.fit, "T_m").filter(|_| measured)?;
        Some(found.beside(LAG_BETWEEN_ROWS * self.clock_s()))
    }

    /// The delay from command to acceleration: dead time and lag of the motors together (s), where lags were identified.
    ///
    /// The interval contains the clock of the log, as that of [`GroundEffect::dead_time_s`] does.
    #[must_use]
    pub fn delay_s(&self) -> Option<Estimate> {
        let (lag, dead) = (self.fit.index("T_m")?, self.fit.index("dead_time")?);
        let by_lines_s = self.by_lines_s();
        let after_log = self
            .spread
            .estimate(&self.fit, |theta, _| theta[lag] + theta[dead] - by_lines_s);
        // Of a command that acts before it is logged the lag alone is left.
        let of_lag = self.motor_lag_s()?;
        self.of_command(after_log?, of_lag.value, of_lag.ci95[0])
    }

    /// The dead time from command to motors (s), where lags were identified.
    ///
    /// A log does not know when in the period before a row its throttle was commanded: a dead time that counts from the row may
    /// be longer by that period, and is not below zero. `None` where commands act longer than that before they are logged, and where the
    /// interval of the motors' lag contains zero.
    #[must_use]
    pub fn dead_time_s(&self) -> Option<Estimate> {
        self.motor_lag_s()?;
        let dead = self.fit.index("dead_time")?;
        if self.fit.held.contains(&dead) {
            // At a bound there is no interval.
            return None;
        }
        let by_lines_s = self.by_lines_s();
        let after_log = self
            .spread
            .estimate(&self.fit, |theta, _| theta[dead] - by_lines_s)?;
        self.of_command(after_log, 0.0, 0.0)
    }

    /// The latency of the accelerometer against height and command (s), where the flights support one; `None` also at its bound.
    #[must_use]
    pub fn accelerometer_latency_s(&self) -> Option<Estimate> {
        let latency = self.fit.index("accelerometer_latency")?;
        let held = self.fit.held.contains(&latency);
        let found = (!held).then(|| self.spread.number(&self.fit, "accelerometer_latency"))?;
        Some(found?.beside(LATENCY_OF_ROWS * self.step_s()))
    }

    /// How late the accelerometer is (s), where that is more than is harmless: against height and throttle, or above a ground that
    /// moves against the height alone.
    pub(super) fn accelerometer_late_s(&self) -> Option<f64> {
        let after_range = self.range_latency_s.map(|latency_s| -latency_s);
        let after_range = after_range.filter(|late_s| *late_s > EARLIEST_RANGE_S);
        self.fit.long_latency_s().or(after_range)
    }

    /// The latency of the range against accelerometer and throttle (s), where no range finder and its link explain it.
    pub(super) fn range_late_s(&self) -> Option<f64> {
        self.range_latency_s
            .filter(|latency_s| *latency_s > LATEST_RANGE_S)
    }

    /// A time that counts from the command, from one that counts from its log; its least value, and the least end of its interval.
    fn of_command(&self, after_log: Estimate, least: f64, least_end: f64) -> Option<Estimate> {
        let unknown = self.basis != Basis::Accelerometer || self.logged_late_s().is_some();
        let clock_s = self.clock_s();
        (!unknown).then(|| Estimate {
            value: after_log.value.max(least),
            std_error: after_log.std_error,
            ci95: [
                after_log.ci95[0].max(least_end),
                after_log.ci95[1] + clock_s,
            ],
        })
    }

    /// How much longer a dead time is where the throttle goes on lines between its rows, as along measured heights (s).
    fn by_lines_s(&self) -> f64 {
        match self.noise {
            None => 0.5 * self.step_s(),
            Some(_) => 0.0,
        }
    }

    /// Step of the rows of the fit (s).
    pub(super) fn step_s(&self) -> f64 {
        Segment::median_step_s(&self.pieces)
    }

    /// How long before its row a throttle may have been commanded (s): the period of the throttle, or of the rows of the fit.
    fn clock_s(&self) -> f64 {
        self.throttle_period_s.max(self.step_s())
    }

    /// By how much commands act before they are logged (s), where that is more than the log's clock explains.
    pub(super) fn logged_late_s(&self) -> Option<f64> {
        let dead_time_s = self.fit.value("dead_time")? - self.by_lines_s();
        (dead_time_s < -self.clock_s()).then_some(-dead_time_s)
    }

    /// All numbers of the model with their intervals, but those at their bound; heights in metres.
    #[must_use]
    pub fn numbers(&self) -> Vec<Number> {
        let r = self.rotor_radius_m;
        let shown = |name: &str| match self.basis {
            Basis::Accelerometer => true,
            // The smoothing would be part of the estimated motor lag; without an accelerometer, disturbances of the air pass for
            // a loss of thrust with climb.
            Basis::Poses => !matches!(name, "T_m" | "dead_time" | "damping"),
            Basis::Hovers { law } => name != "elasticity" || law == ThrustLaw::Throttle,
        };
        // At a bound there is no interval.
        let held = |name: &str| {
            self.fit
                .index(name)
                .is_some_and(|i| self.fit.held.contains(&i))
        };
        let drifts = self.drift_of_time;
        let parameters = self.fit.shape.parameters();
        let shared = parameters
            .into_iter()
            .filter(|p| shown(p.name) && !held(p.name))
            .filter_map(|p| {
                let estimate = match self.lag.filter(|_| p.name == "tau") {
                    // With what no resampling shows.
                    Some(lag) if !self.fit.shape.fountain_lag => lag,
                    _ if p.name == "T_m" => self.motor_lag_s()?,
                    _ if p.name == "dead_time" => self.dead_time_s()?,
                    _ if p.name == "accelerometer_latency" => self.accelerometer_latency_s()?,
                    _ => self.spread.number(&self.fit, p.name)?,
                };
                let (unit, by) = match (p.unit, p.name) {
                    ("R", _) => ("m", r),
                    (_, "battery") if drifts => ("1/s", 1.0 / DRIFT_S),
                    (unit, _) => (unit, 1.0),
                };
                let name = match p.name {
                    "tau" if self.fit.shape.fountain_lag => "image_lag",
                    "tau" => "lag",
                    "fountain_tau" => "fountain_lag",
                    "battery" if drifts => "drift",
                    name => name,
                };
                Some(Number {
                    name: name.to_string(),
                    unit: unit.to_string(),
                    estimate: Estimate {
                        value: estimate.value * by,
                        std_error: estimate.std_error * by,
                        ci95: estimate.ci95.map(|v| v * by),
                    },
                })
            });
        let decay = self.decay_per_m().map(|estimate| Number {
            name: "decay".into(),
            unit: "1/m".into(),
            estimate,
        });
        let lag = self.lag.filter(|_| self.fit.shape.fountain_lag);
        let lag = lag.map(|estimate| Number {
            name: "lag".into(),
            unit: "s".into(),
            estimate,
        });
        let delay = self.delay_s().map(|estimate| Number {
            name: "delay".into(),
            unit: "s".into(),
            estimate,
        });
        shared.chain(lag).chain(delay).chain(decay).collect()
    }
}
