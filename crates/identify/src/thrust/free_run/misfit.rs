//! Whether the answer to steps is that of one lag: residuals after steps beside those on settled plateaus.
//!
//! ```text
//! misfit² = Σ_steps min_δ |r - r̄ - δ ∂T/∂d|² / (ν σ²)
//! ```
//!
//! over the rows within three lags of each step. r̄ and σ are mean and standard deviation of the residuals r where the answer
//! has settled, so that an error of the static curve does not count. δ is a shift of each step in time, because a log does not
//! know when within a period a command changed. ν is the number of rows less one for each step.

use std::ops::Range;

use super::solve::{Free, Problem, Solution};

/// Lags after which an answer has settled: a hundredth of the step is left, and the model knows of that.
const SETTLED: f64 = 5.0;
/// Lags after a step that hold nearly all of its answer: a twentieth of the step is left.
const ANSWER: f64 = 3.0;
/// Settled rows that a plateau needs: its mean is then known to 0.3 of the noise.
const LEAST_ROWS: usize = 10;
/// Steps that a judgement needs.
const LEAST_STEPS: usize = 5;

impl Problem<'_> {
    /// Residuals after steps in units of those on plateaus, about 1 for an answer with one lag; none without steps between
    /// settled plateaus.
    pub(crate) fn misfit(&self, at: &Solution) -> Option<f64> {
        if self.records.iter().any(|r| r.motors.len() > 1) {
            return None;
        }
        let dead_time = Free {
            dead_time: true,
            ..Free::CURVE
        };
        let (by, predicted) = self.derivatives(at, dead_time);
        let by_time = by.last()?;
        let residual: Vec<f64> = (self.measured.iter().zip(&predicted))
            .map(|(m, p)| m - p)
            .collect();
        let (mut noise, mut answers) = (Sum::default(), Sum::default());
        let mut steps = 0;
        for plateau in self.plateaus() {
            let since_s = |i: usize| self.time_s(i) - plateau.start_s - at.dead_time_s;
            let rows = || plateau.rows.clone();
            let settled: Vec<f64> = rows()
                .filter(|&i| since_s(i) > SETTLED * at.lag_s)
                .map(|i| residual[i])
                .collect();
            if settled.len() < LEAST_ROWS {
                continue;
            }
            let mean = settled.iter().sum::<f64>() / settled.len() as f64;
            noise.add(settled.iter().map(|r| r - mean), 1);
            let answer: Vec<usize> = rows().filter(|&i| since_s(i) < ANSWER * at.lag_s).collect();
            if plateau.after_step && answer.len() > 1 {
                let product = |a: &dyn Fn(usize) -> f64| -> f64 {
                    answer.iter().map(|&i| a(i) * by_time[i]).sum()
                };
                let square = product(&|i| by_time[i]);
                let along = product(&|i| residual[i] - mean);
                let shift_s = if square > 0.0 { along / square } else { 0.0 };
                let rest = answer
                    .iter()
                    .map(|&i| residual[i] - mean - shift_s * by_time[i]);
                answers.add(rest, 1);
                steps += 1;
            }
        }
        let ratio = answers.variance()? / noise.variance()?;
        (steps >= LEAST_STEPS && ratio.is_finite()).then(|| ratio.sqrt())
    }

    fn time_s(&self, measurement: usize) -> f64 {
        let (record, row) = self.rows[measurement];
        self.records[record].time[row]
    }

    /// Measurements of one held throttle each.
    fn plateaus(&self) -> Vec<Plateau> {
        let throttle = |&(record, row): &(usize, usize)| self.records[record].motors[0][row];
        let mut out: Vec<Plateau> = Vec::new();
        let mut from = 0;
        for run in self
            .rows
            .chunk_by(|a, b| a.0 == b.0 && throttle(a) == throttle(b))
        {
            let (record, row) = run[0];
            let of = &self.records[record];
            // The command may have come at a row without thrust.
            let held = of.motors[0][..row].iter().rev();
            let before = held.take_while(|u| **u == of.motors[0][row]).count();
            out.push(Plateau {
                rows: from..from + run.len(),
                start_s: of.time[row - before],
                after_step: row > before,
            });
            from += run.len();
        }
        out
    }
}

/// Measurements of one held throttle.
struct Plateau {
    rows: Range<usize>,
    /// When the command came (s).
    start_s: f64,
    /// Whether another command was before it.
    after_step: bool,
}

/// A sum of squares and its degrees of freedom.
#[derive(Default)]
struct Sum {
    squares: f64,
    freedom: usize,
}

impl Sum {
    fn add(&mut self, values: impl ExactSizeIterator<Item = f64>, parameters: usize) {
        self.freedom += values.len() - parameters;
        self.squares += values.map(|v| v * v).sum::<f64>();
    }

    fn variance(&self) -> Option<f64> {
        (self.freedom > 0).then(|| self.squares / self.freedom as f64)
    }
}
