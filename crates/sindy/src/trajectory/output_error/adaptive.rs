//! Simulation of stiff models between samples: implicit steps as long as their error allows.
//!
//! Steps follow from the trajectory alone, so they are the same whether sensitivities are computed along or not. Sensitivities
//! are those of the steps that were made, so they are exact derivatives of the simulated states.

use super::follow::{Follow, INTEGRATION, Sensitivity};
use super::record::Record;
use super::system::implicit::NODES;
use super::system::{Step, Work};

/// Steps between two samples, at most. A jump from one slow branch to another takes some hundred.
const MOST_STEPS: usize = 1000;
/// A step is chosen for this share of the error that is allowed, so that most pass.
const SAFETY: f64 = 0.9;
/// By how much a step may shrink and grow from one to the next.
const FACTORS: (f64, f64) = (0.1, 5.0);
/// The share of a step that is tried again where its stages cannot be solved.
const UNSOLVED: f64 = 0.25;
/// Noise that errors are compared with where none is given, as a share of a state's scatter: less than disturbances of any use.
const FILTERED: f64 = 1e-3;
/// The last step ends within this share of the interval.
const END: f64 = 1e-12;

impl Follow<'_> {
    /// From sample `row` to the next; NaN where no step is short enough.
    pub(super) fn advance_implicitly(
        &self,
        record: &Record,
        row: usize,
        x: &mut [f64],
        (work, step): (&mut Work, &mut Step),
        mut along: Option<&mut Sensitivity>,
    ) {
        let whole = record.time[row + 1] - record.time[row];
        let (mut done, mut part) = (0.0, 1.0);
        for _ in 0..MOST_STEPS {
            if !x.iter().all(|v| v.is_finite()) {
                return;
            }
            let at = |c: f64| record.inputs_at(row, done + c * part);
            let inputs = [at(0.0), at(NODES[0]), at(NODES[1]), at(NODES[2])];
            let over = (part * whole, &inputs);
            let Some(stages) = self.system.stages(x, over, work) else {
                part *= UNSOLVED;
                continue;
            };
            let size = self.relative_error(record, stages.error.as_slice());
            // The error is of order 4 in the step.
            let factor = (SAFETY * size.powf(-0.25)).clamp(FACTORS.0, FACTORS.1);
            if size > 1.0 {
                part *= factor.min(SAFETY);
                continue;
            }
            let sensitive = along.is_some();
            let ended = self.system.end(x, over, &stages, sensitive, work, step);
            if ended.is_none() {
                break;
            }
            x.copy_from_slice(&step.state);
            if let Some(s) = &mut along {
                s.advance(step);
            }
            done += part;
            if 1.0 - done < END {
                return;
            }
            part = (part * factor).min(1.0 - done);
        }
        x.fill(f64::NAN);
    }

    /// The estimated error of a step over that which is allowed, largest over states. It is that of the embedded formula, of order 4 in
    /// the step, and the step's own is of order 6: where the first is a share `s` of a state's scatter, the second is about `s^(3/2)`,
    /// and that may be as large as for explicit steps.
    fn relative_error(&self, record: &Record, error: &[f64]) -> f64 {
        let of = |(i, error): (usize, &f64)| {
            let scatter = record.spread[i].sqrt();
            // The filter of a disturbed system has no noise of states that is given.
            let sigma = self.sigma.get(i).copied().unwrap_or(FILTERED * scatter);
            let scatter = scatter.max(sigma).max(f64::MIN_POSITIVE);
            error.abs() / (scatter * (INTEGRATION * sigma / scatter).powf(2.0 / 3.0))
        };
        error.iter().enumerate().map(of).fold(0.0, f64::max)
    }
}
