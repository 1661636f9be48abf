//! Throttle to rotor speed: dead time, then a first-order lag towards the speed of the level,
//! `τ n' = p(s(t - d)) - n`.

use touchdown_trial::Trial;

use super::plateau::median;
use super::search::minimise;
use crate::error::{Error, Result};
use crate::identify::settings::IdentificationSettings;

/// Seconds after a step in which the rotor's answer is looked at.
const ANSWER_S: f64 = 0.6;
/// Dead times that are searched: up to this, in two rounds.
const LONGEST_DEAD_TIME_S: f64 = 0.15;
/// Smallest step of rotor speed, as a share of the largest, that is used.
const LEAST_STEP: f64 = 0.02;

/// A fitted rotor lag.
pub(super) struct RotorLag {
    pub(super) lag_s: f64,
    pub(super) lag_error_s: f64,
    pub(super) dead_time_s: f64,
    pub(super) dead_time_error_s: f64,
    steps: usize,
    rmse_share: f64,
}

impl RotorLag {
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
    let all: Vec<&Step> = steps.iter().collect();
    let (lag_s, dead_time_s) = solve(&all, settings);
    // Jackknife over steps.
    let n = all.len();
    let without: Vec<(f64, f64)> = (0..n)
        .map(|k| {
            let rest: Vec<&Step> = (0..n).filter(|&j| j != k).map(|j| &steps[j]).collect();
            solve(&rest, settings)
        })
        .collect();
    let error = |pick: fn(&(f64, f64)) -> f64| {
        let mean = without.iter().map(pick).sum::<f64>() / n as f64;
        (without
            .iter()
            .map(|w| (pick(w) - mean).powi(2))
            .sum::<f64>()
            * (n - 1) as f64
            / n as f64)
            .sqrt()
    };
    let samples: usize = steps.iter().map(|s| s.time.len()).sum();
    Ok(RotorLag {
        lag_s,
        lag_error_s: error(|w| w.0),
        dead_time_s,
        dead_time_error_s: error(|w| w.1),
        steps: n,
        rmse_share: (cost(&all, lag_s, dead_time_s) / samples as f64).sqrt(),
    })
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

/// Sum of squared differences from `1 - exp(-(t - d)/τ)`.
fn cost(steps: &[&Step], lag_s: f64, dead_time_s: f64) -> f64 {
    let answer = |t: f64| {
        if t <= dead_time_s {
            0.0
        } else {
            1.0 - (-(t - dead_time_s) / lag_s).exp()
        }
    };
    steps
        .iter()
        .flat_map(|s| s.time.iter().zip(&s.share))
        .map(|(&t, &share)| (share - answer(t)).powi(2))
        .sum()
}

fn solve(steps: &[&Step], settings: &IdentificationSettings) -> (f64, f64) {
    let lag_for = |d: f64| minimise(2e-3, settings.thrust.max_lag_s, |lag| cost(steps, lag, d));
    let d = minimise(1e-4, LONGEST_DEAD_TIME_S, |d| cost(steps, lag_for(d), d));
    (lag_for(d), d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindy::delay::first_order_lag;

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
        // Noise-free: the search stops at a relative width of 1e-5.
        assert!((found.lag_s - lag).abs() < 1e-4, "{}", found.lag_s);
        assert!(
            (found.dead_time_s - dead).abs() < 1e-4,
            "{}",
            found.dead_time_s
        );
    }
}
