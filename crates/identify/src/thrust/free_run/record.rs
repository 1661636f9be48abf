//! Unbroken rows of trials for output error.

use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::thrust::unbroken::HOLE_PERIODS;

/// Greatest rate over the median one up to which a throttle has one rate: stamps of a logger vary by less, a sine's by more
/// (1.41).
const ONE_RATE: f64 = 1.3;
/// Rows that a record has at least, to be more than a start.
const LEAST_ROWS: usize = 20;

/// Rows with known commands; thrust may have gaps.
#[derive(Clone, Debug)]
pub(crate) struct CommandRecord {
    /// Times (s).
    pub time: Vec<f64>,
    /// Throttle of each motor, or the one throttle.
    pub motors: Vec<Vec<f64>>,
    /// Battery voltage (V), without gaps; none where it is not asked for.
    pub battery: Option<Vec<f64>>,
    /// Measured thrust (N); NaN in gaps.
    pub thrust: Vec<f64>,
}

impl CommandRecord {
    /// The records of trials, with the throttles of single motors (`each`) or their mean.
    ///
    /// # Errors
    /// A missing channel, a throttle that stands still, or no unbroken rows.
    pub(crate) fn of(trials: &[Trial], each: bool, battery: bool) -> Result<Vec<Self>> {
        let mut out = Vec::new();
        for trial in trials {
            let mean;
            let motors: Vec<&[f64]> = if each {
                crate::thrust::motors(trial)?
            } else {
                mean = crate::thrust::throttle(trial)?;
                vec![&mean]
            };
            crate::thrust::check_moves(trial.name(), motors.iter().copied())?;
            let voltage = match battery {
                true => Some(filled(trial.time_s(), trial.require("battery_v")?)),
                false => None,
            };
            let thrust = trial.require("thrust_n")?;
            let known = |i: &usize| {
                motors.iter().all(|m| m[*i].is_finite())
                    && voltage.as_ref().is_none_or(|v| v[*i].is_finite())
            };
            let rows: Vec<usize> = (0..trial.len()).filter(known).collect();
            let time = trial.time_s();
            let longest = HOLE_PERIODS
                * crate::thrust::plateau::median(periods(time, &rows)).unwrap_or(f64::INFINITY);
            for run in rows.chunk_by(|&a, &b| time[b] - time[a] <= longest) {
                let pick = |c: &[f64]| run.iter().map(|&i| c[i]).collect::<Vec<_>>();
                let record = Self {
                    time: pick(time),
                    motors: motors.iter().map(|m| pick(m)).collect(),
                    battery: voltage.as_deref().map(pick),
                    thrust: pick(thrust),
                };
                let measured = record.thrust.iter().filter(|f| f.is_finite()).count();
                if measured >= LEAST_ROWS {
                    out.push(record);
                }
            }
        }
        if out.is_empty() {
            return Err(Error::data(
                trials.first().map_or("no trial", Trial::name),
                format!("unbroken throttle over at least {LEAST_ROWS} samples of thrust"),
                "fewer",
            ));
        }
        Ok(out)
    }

    /// How fast the throttles change, where they do (1/s).
    fn rates(&self) -> impl Iterator<Item = f64> {
        let rates = |motor: &'_ Vec<f64>| {
            let steps = motor.windows(2).zip(self.time.windows(2));
            let rates = steps.map(|(u, t)| ((u[1] - u[0]) / (t[1] - t[0])).abs());
            rates.filter(|rate| *rate > 0.0).collect::<Vec<_>>()
        };
        self.motors.iter().flat_map(rates)
    }

    /// Times of the measured thrust.
    pub(crate) fn measured_times(&self) -> impl Iterator<Item = f64> {
        let pairs = self.time.iter().zip(&self.thrust);
        pairs.filter(|(_, f)| f.is_finite()).map(|(t, _)| *t)
    }
}

fn periods(time: &[f64], rows: &[usize]) -> impl Iterator<Item = f64> {
    rows.windows(2).map(|w| time[w[1]] - time[w[0]])
}

/// Whether throttles rise and fall at one rate alone. A lag then shifts both branches as hysteresis does, and at no other rate
/// by another amount.
pub(crate) fn has_one_rate(records: &[CommandRecord]) -> bool {
    let all = || records.iter().flat_map(CommandRecord::rates);
    let usual = crate::thrust::plateau::median(all());
    usual.is_some_and(|usual| all().all(|rate| rate < ONE_RATE * usual))
}

/// Median time between measurements of thrust (s).
pub(crate) fn period_s(records: &[CommandRecord]) -> f64 {
    let all = records.iter().flat_map(|r| {
        let times: Vec<f64> = r.measured_times().collect();
        times.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>()
    });
    crate::thrust::plateau::median(all).unwrap_or(f64::INFINITY)
}

/// A slow channel at every row: lines across its gaps, held before its first and after its last value.
pub(crate) fn filled(time: &[f64], values: &[f64]) -> Vec<f64> {
    let known: Vec<usize> = (0..values.len())
        .filter(|&i| values[i].is_finite())
        .collect();
    let pick = |c: &[f64]| known.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let (at, v) = (pick(time), pick(values));
    if v.is_empty() {
        return vec![f64::NAN; time.len()];
    }
    let mut signal = crate::delayed::DelayedSignal::new(&at, &v);
    time.iter().map(|t| signal.at(*t)).collect()
}
