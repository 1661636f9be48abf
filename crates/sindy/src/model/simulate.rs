//! Runs of a model over time.

use super::dopri;
use super::input::{Drive, Inputs, increasing};
use super::limits::{Guard, Limits, Run, RunOutcome};
use super::predict::Workspace;
use super::{Model, Time};
use crate::error::{SindyError, finite, same_size};

/// How the differential equation is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// The classical Runge–Kutta method of order 4 (Kutta 1901): from each requested time (or break of
    /// the inputs) to the next in equal steps, as few as possible, none longer than `step`.
    RungeKutta4 {
        /// Longest step, positive.
        step: f64,
    },
    /// The Runge–Kutta pair of order 5(4) of Dormand & Prince (J. Comput. Appl. Math. 6, 1980), each
    /// step as long as the tolerance allows, with continuous output of order 4 at the requested times
    /// and the step control of Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*,
    /// II.4–6. The root mean square over the states of error / (absolute + relative·|x|) stays below 1
    /// in every step.
    DormandPrince {
        /// Relative tolerance, at least 10⁻¹⁴.
        relative: f64,
        /// Absolute tolerance, not negative.
        absolute: f64,
    },
}

/// How to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    integrator: Integrator,
    limits: Limits,
    step_limit: usize,
}

impl Simulation {
    /// With the given integrator, [`Limits::default`] and at most 10⁷ steps.
    #[must_use]
    pub fn new(integrator: Integrator) -> Self {
        Self {
            integrator,
            limits: Limits::default(),
            step_limit: 10_000_000,
        }
    }

    /// Adaptive steps with a relative tolerance of 10⁻⁸ and an absolute one of 10⁻¹⁰.
    #[must_use]
    pub fn adaptive() -> Self {
        Self::new(Integrator::DormandPrince {
            relative: 1e-8,
            absolute: 1e-10,
        })
    }

    /// Fixed steps of at most `step`.
    #[must_use]
    pub fn fixed(step: f64) -> Self {
        Self::new(Integrator::RungeKutta4 { step })
    }

    /// Where the run ends early.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// The largest number of steps, those that are rejected included.
    #[must_use]
    pub fn step_limit(mut self, steps: usize) -> Self {
        self.step_limit = steps;
        self
    }

    fn check(&self) -> Result<(), SindyError> {
        match self.integrator {
            Integrator::RungeKutta4 { step } if !(step > 0.0) => {
                Err(SindyError::setting("step", "a positive time", step))
            }
            Integrator::DormandPrince { relative, .. } if !(1e-14..1.0).contains(&relative) => Err(
                SindyError::setting("relative", "a tolerance from 1e-14 to below 1", relative),
            ),
            Integrator::DormandPrince { absolute, .. }
                if !(absolute >= 0.0 && absolute.is_finite()) =>
            {
                Err(SindyError::setting(
                    "absolute",
                    "a finite tolerance, not negative",
                    absolute,
                ))
            }
            _ => Ok(()),
        }
    }
}

impl Model {
    /// Integrates a continuous-time model from `start` at `time[0]` and gives the states at all of
    /// `time`, which need not be uniform.
    ///
    /// # Errors
    /// A discrete-time model; a start, times or inputs that do not fit the model, are not finite or do not
    /// cover the run; settings outside their range. That a run ends early is an [`RunOutcome`].
    pub fn simulate(
        &self,
        start: &[f64],
        time: &[f64],
        inputs: &Inputs,
        how: &Simulation,
    ) -> Result<Run, SindyError> {
        if let Time::Discrete { .. } = self.time {
            let found = "discrete time (see `iterate`)";
            return Err(SindyError::setting("model", "continuous time", found));
        }
        self.check_start(start)?;
        how.check()?;
        let guard = how.limits.check(self)?;
        same_size("inputs", self.inputs.len(), inputs.len())?;
        let (Some(&first), Some(&last)) = (time.first(), time.last()) else {
            return Err(SindyError::too_short(1, 0));
        };
        increasing("time", time)?;
        inputs.check_span(first, last)?;

        let mut run = Run::new(start.len(), time.len());
        if let Some(outcome) = guard.violated(first, start) {
            run.outcome = outcome;
            return Ok(run);
        }
        run.push(first, start);
        let mut flow = Flow::new(self, inputs);
        run.outcome = match how.integrator {
            Integrator::RungeKutta4 { step } => {
                let plan = Plan {
                    time,
                    inputs,
                    guard: &guard,
                    step_limit: how.step_limit,
                };
                rk4(&mut flow, &plan, step, start, &mut run)
            }
            Integrator::DormandPrince { relative, absolute } => {
                let plan = Plan {
                    time,
                    inputs,
                    guard: &guard,
                    step_limit: how.step_limit,
                };
                dopri::integrate(&mut flow, &plan, (relative, absolute), start, &mut run)
            }
        };
        run.evaluations = flow.evaluations;
        Ok(run)
    }

    /// Iterates a discrete-time model from `start`: the run has one row more than the `steps` asked for,
    /// at times 0, period, 2·period, … Each input has at least `steps` values, of which the k-th acts from
    /// row k to row k+1.
    ///
    /// # Errors
    /// A continuous-time model; a start or inputs that do not fit the model or are not finite; limits
    /// outside their range. That a run ends early is an [`RunOutcome`].
    pub fn iterate(
        &self,
        start: &[f64],
        steps: usize,
        inputs: &[&[f64]],
        limits: &Limits,
    ) -> Result<Run, SindyError> {
        let Time::Discrete { period } = self.time else {
            let found = "continuous time (see `simulate`)";
            return Err(SindyError::setting("model", "discrete time", found));
        };
        self.check_start(start)?;
        let guard = limits.check(self)?;
        same_size("inputs", self.inputs.len(), inputs.len())?;
        for (column, name) in inputs.iter().zip(&self.inputs) {
            if column.len() < steps {
                return Err(SindyError::too_short(steps, column.len()));
            }
            finite(name, column)?;
        }
        let mut run = Run::new(start.len(), 0);
        if let Some(outcome) = guard.violated(0.0, start) {
            run.outcome = outcome;
            return Ok(run);
        }
        run.push(0.0, start);
        let mut evaluator = self.evaluator();
        let (mut state, mut next) = (start.to_vec(), start.to_vec());
        let mut input = vec![0.0; inputs.len()];
        for k in 0..steps {
            for (value, column) in input.iter_mut().zip(inputs) {
                *value = column[k];
            }
            evaluator.eval(&state, &input, &mut next);
            std::mem::swap(&mut state, &mut next);
            (run.evaluations, run.steps) = (k + 1, k + 1);
            let time = period * (k + 1) as f64;
            if let Some(outcome) = guard.violated(time, &state) {
                run.outcome = outcome;
                break;
            }
            run.push(time, &state);
        }
        Ok(run)
    }

    fn check_start(&self, start: &[f64]) -> Result<(), SindyError> {
        same_size(
            "start values (one per state)",
            self.states.len(),
            start.len(),
        )?;
        finite("start", start)
    }
}

/// The task of a run.
pub(super) struct Plan<'a> {
    pub(super) time: &'a [f64],
    pub(super) inputs: &'a Inputs,
    pub(super) guard: &'a Guard,
    pub(super) step_limit: usize,
}

/// The right-hand side along a run: `dx/dt` at (t, x) with the inputs of t.
pub(super) struct Flow<'m> {
    model: &'m Model,
    pub(super) drive: Drive<'m>,
    row: Vec<f64>,
    work: Workspace,
    evaluations: usize,
}

impl<'m> Flow<'m> {
    fn new(model: &'m Model, inputs: &'m Inputs) -> Self {
        Self {
            model,
            drive: inputs.drive(),
            row: vec![0.0; model.states.len() + model.inputs.len()],
            work: model.compiled.workspace(),
            evaluations: 0,
        }
    }

    pub(super) fn eval(&mut self, t: f64, state: &[f64], out: &mut [f64]) {
        let n = state.len();
        self.row[..n].copy_from_slice(state);
        if self.row.len() > n {
            self.drive.eval(t, &mut self.row[n..]);
        }
        self.model.compiled.row(&self.row, out, &mut self.work);
        self.evaluations += 1;
    }
}

fn rk4(
    flow: &mut Flow<'_>,
    plan: &Plan<'_>,
    step: f64,
    start: &[f64],
    run: &mut Run,
) -> RunOutcome {
    let n = start.len();
    let mut x = start.to_vec();
    let mut stage = vec![0.0; n];
    let mut k = [(); 4].map(|()| vec![0.0; n]);
    for window in plan.time.windows(2) {
        let mut from = window[0];
        let ends = plan
            .inputs
            .breaks(window[0], window[1])
            .iter()
            .chain([&window[1]]);
        for &to in ends {
            flow.drive.enter(from, to);
            // A hair over a whole number of steps is rounding.
            let count = ((to - from) / step - 1e-9).ceil().max(1.0);
            let left = plan.step_limit - run.steps;
            if count > left as f64 {
                return RunOutcome::StepLimit { time: from };
            }
            let h = (to - from) / count;
            for i in 0..count as usize {
                let t = from + i as f64 * h;
                flow.eval(t, &x, &mut k[0]);
                for (stage_of, fraction) in [(1, 0.5), (2, 0.5), (3, 1.0)] {
                    for j in 0..n {
                        stage[j] = x[j] + fraction * h * k[stage_of - 1][j];
                    }
                    flow.eval(t + fraction * h, &stage, &mut k[stage_of]);
                }
                for j in 0..n {
                    x[j] += h / 6.0 * (k[0][j] + 2.0 * (k[1][j] + k[2][j]) + k[3][j]);
                }
                run.steps += 1;
                if let Some(outcome) = plan.guard.violated(t + h, &x) {
                    return outcome;
                }
            }
            from = to;
        }
        run.push(window[1], &x);
    }
    RunOutcome::Finished
}
