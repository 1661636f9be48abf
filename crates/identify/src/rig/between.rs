//! What the height did between the rows of a slow log.
//!
//! A straight line between two rows cuts the turning points of a motion: of a sine of frequency ν it leaves
//! `1 - (2π ν Δt)²/12` of the amplitude. A fitted lag is then too short, for it has to take less of the motion away. A cubic through
//! four rows keeps the turning points.

use super::GroundTrial;

/// Time between rows up to which lines are taken (s). A sine of 1.5 Hz, the fastest usual motion of a rig, loses 0.5 %.
const LONGEST_LINE_S: f64 = 0.025;
/// What times in decimals lack or have too much, in parts of a step.
const ROUNDING: f64 = 1e-6;
/// Greatest ratio of neighbouring steps in time across which a cubic is taken: next to a hole its slopes are of another motion.
const ONE_RATE: f64 = 2.5;

/// A trial with rows between those of the log, in which the force has a gap.
pub(super) struct FineTrial {
    /// The trial with all rows.
    pub(super) trial: GroundTrial,
    /// Places of the rows of the log.
    rows: Vec<usize>,
}

impl FineTrial {
    /// `None` for a log whose rows are close enough for lines.
    pub(super) fn of(trial: &GroundTrial) -> Option<Self> {
        let parts = parts(&trial.time_s);
        if parts.iter().all(|n| *n == 1) {
            return None;
        }
        let mut rows = vec![0];
        for n in &parts {
            rows.push(rows[rows.len() - 1] + n);
        }
        let cubic = |c: &[f64]| filled(&trial.time_s, c, &parts, true);
        let lines = |c: &[f64]| filled(&trial.time_s, c, &parts, false);
        let mut fine = GroundTrial {
            name: trial.name.clone(),
            time_s: lines(&trial.time_s),
            // Commands and thrusts may jump.
            throttle: lines(&trial.throttle),
            free_air_thrust_n: lines(&trial.free_air_thrust_n),
            height_m: cubic(&trial.height_m),
            deck_velocity_mps: cubic(&trial.deck_velocity_mps),
            vehicle_velocity_mps: cubic(&trial.vehicle_velocity_mps),
            force_n: Vec::new(),
            truth_n: None,
        };
        fine.force_n = vec![f64::NAN; fine.time_s.len()];
        for (row, force) in rows.iter().zip(&trial.force_n) {
            fine.force_n[*row] = *force;
        }
        Some(Self { trial: fine, rows })
    }

    /// A column of the log, joined by lines.
    pub(super) fn joined(&self, trial: &GroundTrial, column: &[f64]) -> Vec<f64> {
        let parts: Vec<usize> = self.rows.windows(2).map(|r| r[1] - r[0]).collect();
        filled(&trial.time_s, column, &parts, false)
    }

    /// Of a column of all rows, those of the log.
    pub(super) fn at_rows(&self, column: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|row| column[*row]).collect()
    }
}

/// In how many parts each step in time is split: one where a line is enough, or where the neighbours are of another rate.
fn parts(time: &[f64]) -> Vec<usize> {
    let step: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    let split = |i: usize| {
        let around = &step[i.saturating_sub(1)..(i + 2).min(step.len())];
        let one_rate = around
            .iter()
            .all(|s| *s <= ONE_RATE * step[i] && step[i] <= ONE_RATE * s);
        match one_rate && step[i] > LONGEST_LINE_S {
            true => (step[i] / LONGEST_LINE_S - ROUNDING).ceil() as usize,
            false => 1,
        }
    };
    (0..step.len()).map(split).collect()
}

/// A column with each step in time split in `parts`: by the cubic with the slopes of parabolas through three rows, or by lines.
fn filled(time: &[f64], column: &[f64], parts: &[usize], cubic: bool) -> Vec<f64> {
    let mut out = Vec::new();
    for (i, n) in parts.iter().enumerate() {
        let (dt, a, b) = (time[i + 1] - time[i], column[i], column[i + 1]);
        let slopes = [i, i + 1].map(|k| slope(time, column, k));
        for part in 0..*n {
            let u = part as f64 / *n as f64;
            let line = (1.0 - u) * a + u * b;
            let bow = ((1.0 - u) * (slopes[0] * dt - (b - a)) - u * (slopes[1] * dt - (b - a)))
                * u
                * (1.0 - u);
            out.push(if cubic && part > 0 { line + bow } else { line });
        }
    }
    out.extend(column.last());
    out
}

/// Slope at row `k` of the parabola through it and its neighbours; at an end, of the line.
fn slope(time: &[f64], column: &[f64], k: usize) -> f64 {
    let of_step = |i: usize| (column[i + 1] - column[i]) / (time[i + 1] - time[i]);
    if k == 0 {
        return of_step(0);
    }
    if k + 1 == time.len() {
        return of_step(k - 1);
    }
    let (before, after) = (time[k] - time[k - 1], time[k + 1] - time[k]);
    (after * of_step(k - 1) + before * of_step(k)) / (before + after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_cubic_keeps_the_turning_points_of_a_sine() {
        // 1.2 Hz in rows of 0.1 s.
        let time: Vec<f64> = (0..100).map(|i| 0.1 * f64::from(i)).collect();
        let sine = |t: f64| (7.54 * t).sin();
        let column: Vec<f64> = time.iter().map(|t| sine(*t)).collect();
        let parts = parts(&time);
        assert_eq!(parts, vec![4; 99]);
        let fine = filled(&time, &time, &parts, false);
        let worst = |cubic: bool| {
            let values = filled(&time, &column, &parts, cubic);
            let inner = fine.iter().zip(values).skip(4).take(388);
            inner.map(|(t, v)| (v - sine(*t)).abs()).fold(0.0, f64::max)
        };
        // A line misses the top by 1 - cos(7.54·0.05) = 7 %; the slope of the parabola errs by (7.54·0.1)²/6 = 9 % of
        // 0.754, of which a quarter of the step makes 0.6 %.
        assert!(
            worst(false) > 0.06 && worst(true) < 0.015,
            "{} {}",
            worst(false),
            worst(true)
        );
    }

    #[test]
    fn prop_fast_rows_and_holes_are_left_alone() {
        let at = |steps: &[f64]| {
            let mut t = 0.0;
            let rest = steps.iter().map(|s| {
                t += s;
                t
            });
            let times: Vec<f64> = std::iter::once(0.0).chain(rest).collect();
            parts(&times)
        };
        assert_eq!(at(&[0.01, 0.02, 0.02]), [1, 1, 1]);
        assert_eq!(at(&[0.1, 0.1, 20.0, 0.1, 0.1]), [4, 1, 1, 1, 4]);
    }
}
