//! Throttle to rotor speed: dead time, then a first-order lag towards the speed of the level,
//! `τ n' = p(s(t - d)) - n`.

use sindy::statistics::regression::Clusters;
use sindy::trajectory::shooting::{OdeModel, Parameter, Record, Shooting};
use touchdown_model::card::Term;
use touchdown_trial::Trial;

use super::free_run::signal::Between;
use super::plateau::median;
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::settings::IdentificationSettings;

/// Seconds after a step in which the rotor's answer is looked at.
/// Ten lags of small rotors. Half cuts the answer of large ones, twice asks for longer steps.
const ANSWER_S: f64 = 0.6;
/// Longest dead time, and shortest lag, that are looked for (s).
/// Longer ones are not of a command line but of a logger's clock.
const LONGEST_DEAD_TIME_S: f64 = 0.15;
/// As in `first_order`.
const SHORTEST_LAG_S: f64 = 2e-3;
/// Smallest step of rotor speed, as a share of the largest, that is used.
/// A smaller step is of the order of what a speed sensor scatters.
const LEAST_STEP: f64 = 0.02;

/// A fitted rotor lag.
pub(super) struct RotorLag {
    pub(super) lag_s: f64,
    lag_error_s: f64,
    dead_time_s: f64,
    dead_time_error_s: f64,
    steps: usize,
    rmse_share: f64,
    /// How much shorter and longer the dead time may be, by the clock of the log (s).
    clock_s: [f64; 2],
}

impl RotorLag {
    /// Lag and dead time as terms of a card; their standard errors rest on the steps.
    pub(super) fn terms(&self) -> [Term; 2] {
        let clusters = Clusters {
            groups: self.steps,
            coefficients: 2,
        };
        let lag = Estimate::clustered(self.lag_s, self.lag_error_s, clusters);
        let mut dead_time = Estimate::clustered(self.dead_time_s, self.dead_time_error_s, clusters);
        let [sooner, later] = self.clock_s;
        let [low, high] = dead_time.ci95;
        dead_time.ci95 = [(low - sooner).max(0.0), high + later];
        [
            term("T_m", "1", lag, "s"),
            term("dead_time", "1", dead_time, "s"),
        ]
    }

    pub(super) fn describe(&self) -> String {
        format!(
            "rotor speed after {} steps of throttle: dead time {:.4} ± {:.4} s, lag {:.4} ± {:.4} s, rms residual {:.1} % of the step; a load cell slower than the rotor shows a longer lag",
            self.steps,
            self.dead_time_s,
            self.dead_time_error_s,
            self.lag_s,
            self.lag_error_s,
            100.0 * self.rmse_share
        )
    }
}

/// One step: time since the step, and the share of the way that the rotor has gone.
struct Step {
    time: Vec<f64>,
    share: Vec<f64>,
}

pub(super) fn fit(trials: &[Trial], settings: &IdentificationSettings) -> Result<RotorLag> {
    let mut steps = Vec::new();
    for trial in trials {
        steps.extend(find_steps(trial)?);
    }
    if steps.len() < 3 {
        return Err(Error::data(
            trials.first().map_or("no trial", Trial::name),
            "at least 3 steps of throttle that the rotor's speed answers",
            steps.len().to_string(),
        ));
    }
    let period_s = period_s(trials);
    let records: Vec<Record<'_>> = steps
        .iter()
        .enumerate()
        .map(|(group, step)| Record {
            time: &step.time,
            inputs: vec![&step.time],
            measured: &step.share,
            start: Vec::new(),
            group,
        })
        .collect();
    let longest = settings.thrust.max_lag_s;
    let (lag_s, dead_time_s) = first_guess(&steps);
    let parameters = [
        Parameter::free(lag_s.clamp(SHORTEST_LAG_S, longest)).within(SHORTEST_LAG_S, longest),
        Parameter::free(dead_time_s).within(0.0, LONGEST_DEAD_TIME_S),
    ];
    let shooting = Shooting {
        window: f64::INFINITY,
        every: 1,
        start_sd: 0.0,
        ..Shooting::default()
    };
    // A command that changes at a sample, or at any time of the period before it: the mean of the answers to all of these.
    let at_sample = "1 - exp(-max(t - d, 0)/tau)".to_string();
    let before = format!("max(t - d + {period_s}, 0)");
    let within = format!(
        "({before} - max(t - d, 0) + tau*(exp(-{before}/tau) - exp(-max(t - d, 0)/tau)))/{period_s}"
    );
    let fits = [at_sample, within].map(|answer| {
        let model = OdeModel::new(&[], &["t"], &["tau", "d"], &[], &answer)?;
        shooting.refine(&model, &records, &parameters)
    });
    let [held, spread] = fits;
    let (held, spread) = (held?, spread?);
    let rows = steps.iter().map(|s| s.time.len()).sum();
    let between = Between::likelier(held.rmse.powi(2), spread.rmse.powi(2), rows);
    let refined = match between {
        Between::Linear => spread,
        Between::Held => held,
    };
    Ok(RotorLag {
        clock_s: between.clock_s(period_s),
        lag_s: refined.parameters[0],
        lag_error_s: refined.std_errors[0],
        dead_time_s: refined.parameters[1],
        dead_time_error_s: refined.std_errors[1],
        steps: steps.len(),
        rmse_share: refined.rmse,
    })
}

/// Median time between rows (s).
fn period_s(trials: &[Trial]) -> f64 {
    let all = trials.iter().flat_map(|t| t.time_s().windows(2));
    median(all.map(|w| w[1] - w[0])).unwrap_or(0.0)
}

/// Start values of lag and dead time: the median times after which a tenth, and 1 - 1/e, of the way is gone.
fn first_guess(steps: &[Step]) -> (f64, f64) {
    let gone = |share: f64| {
        let times = steps.iter().filter_map(|s| {
            let at = s.share.iter().position(|v| *v >= share)?;
            Some(s.time[at])
        });
        median(times).unwrap_or(0.0)
    };
    let dead_time_s = gone(0.1).min(0.5 * LONGEST_DEAD_TIME_S);
    (gone(1.0 - (-1.0_f64).exp()) - dead_time_s, dead_time_s)
}

/// The steps of a trial whose levels before and after are steady.
fn find_steps(trial: &Trial) -> Result<Vec<Step>> {
    let throttle = super::throttle(trial)?;
    let (time, speed) = (trial.time_s(), trial.require("rotor_rpm")?);
    let rows: Vec<usize> = (0..time.len())
        .filter(|&i| throttle[i].is_finite())
        .collect();
    let runs: Vec<&[usize]> = rows.chunk_by(|&a, &b| throttle[a] == throttle[b]).collect();
    let level = |run: &[usize]| {
        let (start, end) = (time[run[0]], time[run[run.len() - 1]]);
        (end - start > ANSWER_S + 0.2)
            .then(|| {
                median(
                    run.iter()
                        .filter(|&&i| time[i] > start + ANSWER_S)
                        .map(|&i| speed[i]),
                )
            })
            .flatten()
    };
    let levels: Vec<Option<f64>> = runs.iter().map(|r| level(r)).collect();
    let largest = levels.iter().flatten().copied().fold(0.0, f64::max);
    let mut out = Vec::new();
    for k in 1..runs.len() {
        let (Some(before), Some(after)) = (levels[k - 1], levels[k]) else {
            continue;
        };
        // A rotor that starts from or falls to standstill follows another law.
        if (after - before).abs() < LEAST_STEP * largest || before.min(after) < 0.05 * largest {
            continue;
        }
        let at = time[runs[k][0]];
        let answer = runs[k]
            .iter()
            .copied()
            .filter(|&i| time[i] - at <= ANSWER_S && speed[i].is_finite());
        let (t, share) = answer
            .map(|i| (time[i] - at, (speed[i] - before) / (after - before)))
            .unzip();
        out.push(Step { time: t, share });
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindy::trajectory::delay::first_order_lag;

    #[test]
    fn analytic_lag_and_dead_time_of_a_made_staircase() {
        let (dead, lag) = (0.036, 0.034);
        let time: Vec<f64> = (0..3000).map(|i| 0.007 * f64::from(i)).collect();
        let throttle: Vec<f64> = (0..3000).map(|i| 0.2 + 0.1 * f64::from(i / 500)).collect();
        let target: Vec<f64> = throttle.iter().map(|s| 20_000.0 * s.sqrt()).collect();
        let speed = first_order_lag(&time, &target, lag, dead);
        let trial = Trial::new("steps", time)
            .unwrap()
            .with_channel("throttle", throttle)
            .unwrap()
            .with_channel("rotor_rpm", speed)
            .unwrap();
        let found = fit(&[trial], &IdentificationSettings::default()).unwrap();
        // Noise-free and exact between the samples: the refinement ends within a relative 1e-4 of its minimum.
        assert!((found.lag_s - lag).abs() < 1e-4, "{}", found.lag_s);
        assert!(
            (found.dead_time_s - dead).abs() < 1e-4,
            "{}",
            found.dead_time_s
        );
    }
}
