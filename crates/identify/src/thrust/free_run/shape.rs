//! The static curve of a thrust model, and where its lag stands.

use super::record::CommandRecord;
use super::signal::{Between, lagged};
use crate::delayed::DelayedSignal;

/// The battery's voltage when the command of a row acts, in the middle of that time where it is held: a dead time is that of the
/// command line, and the voltage at the motors has none. A product of both that is delayed as a whole is therefore that of the
/// command and a later voltage.
pub(crate) fn acting_voltage(
    time: &[f64],
    volts: &[f64],
    between: Between,
    dead_time_s: f64,
) -> Vec<f64> {
    if volts.is_empty() {
        return Vec::new();
    }
    let mut signal = DelayedSignal::new(time, volts);
    let middle = |k: usize| match (between, time.get(k + 1)) {
        (Between::Held, Some(next)) => 0.5 * (time[k] + next),
        _ => time[k],
    };
    (0..time.len())
        .map(|k| signal.at(middle(k) + dead_time_s))
        .collect()
}

/// What the sum of columns is.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Output {
    /// `√T`: the steady value of the root is a polynomial of throttle, behind the lag.
    Root,
    /// `T`: a polynomial of each motor's lagged throttle, summed.
    Thrust,
}

/// Static curve and lag.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct Shape {
    /// Of what the curve is.
    pub output: Output,
    /// Degree of the polynomial.
    pub degree: usize,
    /// Whether there is a term of throttle times battery voltage.
    pub battery: bool,
}

impl Shape {
    /// Coefficients of the curve.
    pub(crate) fn coefficients(self) -> usize {
        self.degree + 1 + usize::from(self.battery)
    }

    /// One column for each coefficient over a record.
    pub(crate) fn columns(
        self,
        record: &CommandRecord,
        between: Between,
        lag_s: f64,
        dead_time_s: f64,
    ) -> Vec<Vec<f64>> {
        let n = record.time.len();
        let behind = |u: &[f64]| lagged(&record.time, u, between, lag_s, dead_time_s);
        let volts = |i: usize| record.battery.as_ref().map_or(f64::NAN, |v| v[i]);
        let mut out = Vec::with_capacity(self.coefficients());
        match self.output {
            Output::Root => {
                let s = &record.motors[0];
                out.push(vec![1.0; n]);
                for k in 1..=self.degree {
                    let power: Vec<f64> = s.iter().map(|s| s.powi(k as i32)).collect();
                    out.push(behind(&power));
                }
                if let Some(volts) = &record.battery {
                    let acting = acting_voltage(&record.time, volts, between, dead_time_s);
                    let product: Vec<f64> = s.iter().zip(acting).map(|(s, v)| s * v).collect();
                    out.push(behind(&product));
                }
            }
            Output::Thrust => {
                out = vec![vec![0.0; n]; self.coefficients()];
                for motor in &record.motors {
                    let u = behind(motor);
                    for i in 0..n {
                        let mut power = 1.0;
                        for column in &mut out[..=self.degree] {
                            column[i] += power;
                            power *= u[i];
                        }
                        if self.battery {
                            out[self.degree + 1][i] += u[i] * volts(i);
                        }
                    }
                }
            }
        }
        out
    }

    /// Thrust from the sum of columns.
    pub(crate) fn thrust(self, z: f64) -> f64 {
        match self.output {
            Output::Root => z * z.abs(),
            Output::Thrust => z,
        }
    }

    /// Its derivative.
    pub(crate) fn slope(self, z: f64) -> f64 {
        match self.output {
            Output::Root => 2.0 * z.abs(),
            Output::Thrust => 1.0,
        }
    }
}
