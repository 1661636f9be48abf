//! Dormand–Prince 5(4) with continuous output of order 4.
//!
//! Coefficients: J. R. Dormand & P. J. Prince, "A family of embedded Runge–Kutta formulae", J. Comput.
//! Appl. Math. 6 (1980). Continuous output, starting step and step control: E. Hairer, S. P. Nørsett &
//! G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed. (1993), II.4 to II.6.

use super::limits::{Run, RunOutcome};
use super::simulate::{Flow, Plan};

/// Times of the stages 2 to 7 within a step.
const C: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// Weights of the earlier stages in stages 2 to 7; the last row gives the step itself.
const A: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Weights of the error estimate: those of order 5 less those of order 4.
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Weights of the last coefficient of the continuous output.
const D: [f64; 7] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// Step control: safety factor, smallest and largest change, and the weight of the step before.
const SAFETY: f64 = 0.9;
const SHRINK: f64 = 0.2;
const GROW: f64 = 10.0;
const BETA: f64 = 0.04;

pub(super) fn integrate(
    flow: &mut Flow<'_>,
    plan: &Plan<'_>,
    tolerance: (f64, f64),
    start: &[f64],
    run: &mut Run,
) -> RunOutcome {
    let (first, last) = (plan.time[0], plan.time[plan.time.len() - 1]);
    let mut steps = Steps::new(tolerance, start);
    let mut wanted = &plan.time[1..];
    let mut from = first;
    // Without a second time there is nothing to do.
    let ends = plan
        .inputs
        .breaks(first, last)
        .iter()
        .chain((last > first).then_some(&last));
    for &to in ends {
        if let Err(outcome) = segment(flow, plan, &mut steps, (from, to), &mut wanted, run) {
            return outcome;
        }
        from = to;
    }
    RunOutcome::Finished
}

/// Integrates over `[from, to]`, where the inputs are smooth.
fn segment(
    flow: &mut Flow<'_>,
    plan: &Plan<'_>,
    s: &mut Steps,
    (from, to): (f64, f64),
    wanted: &mut &[f64],
    run: &mut Run,
) -> Result<(), RunOutcome> {
    let mut t = from;
    flow.drive.enter(from, to);
    flow.eval(t, &s.x, &mut s.k[0]);
    if !s.k[0].iter().all(|v| v.is_finite()) {
        return Err(RunOutcome::BlewUp { time: t });
    }
    if s.step == 0.0 {
        s.step = s.first_step(flow, from, to);
    }
    let mut rejected = false;
    while t < to {
        if run.steps == plan.step_limit {
            return Err(RunOutcome::StepLimit { time: t });
        }
        run.steps += 1;
        let reaches_end = t + 1.01 * s.step >= to;
        let h = if reaches_end { to - t } else { s.step };
        let error = s.attempt(flow, t, h);
        if error <= 1.0 {
            let end = if reaches_end { to } else { t + h };
            if let Some(outcome) = plan.guard.violated(end, &s.next) {
                return Err(outcome);
            }
            s.emit(wanted, t, h, end, run);
            let proposed = h * s.accepted_factor(error);
            // A step that the end shortens does not predict the next step's length.
            let grown = if rejected { proposed.min(h) } else { proposed };
            s.step = if reaches_end {
                grown.max(s.step)
            } else {
                grown
            };
            s.advance();
            rejected = false;
            t = end;
        } else {
            let shrink = if error.is_finite() {
                (SAFETY / error.powf(0.2 - 0.75 * BETA)).clamp(SHRINK, 1.0)
            } else {
                SHRINK
            };
            s.step = h * shrink;
            rejected = true;
            if t + s.step <= t + 4.0 * f64::EPSILON * t.abs() {
                return Err(if error.is_finite() {
                    RunOutcome::StepTooSmall { time: t }
                } else {
                    RunOutcome::BlewUp { time: t }
                });
            }
        }
    }
    Ok(())
}

/// The state of the integration.
struct Steps {
    relative: f64,
    absolute: f64,
    x: Vec<f64>,
    next: Vec<f64>,
    stage: Vec<f64>,
    k: [Vec<f64>; 7],
    /// The next step, 0 before the first.
    step: f64,
    /// The error of the last accepted step.
    error_before: f64,
}

impl Steps {
    fn new((relative, absolute): (f64, f64), start: &[f64]) -> Self {
        let n = start.len();
        Self {
            relative,
            absolute,
            x: start.to_vec(),
            next: vec![0.0; n],
            stage: vec![0.0; n],
            k: [(); 7].map(|()| vec![0.0; n]),
            step: 0.0,
            error_before: 1e-4,
        }
    }

    /// Root mean square of `values` over the tolerances at `scale`. A state at exactly zero with no
    /// absolute tolerance is given the smallest normal one.
    fn norm(&self, values: impl Iterator<Item = f64>, scale: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        for (j, value) in values.enumerate() {
            let tolerance = self.absolute + self.relative * scale(j);
            sum += (value / tolerance.max(f64::MIN_POSITIVE)).powi(2);
        }
        (sum / self.x.len() as f64).sqrt()
    }

    /// The starting step: one whose explicit Euler step is small and whose error of order 5 is about a
    /// hundredth of the tolerance.
    fn first_step(&mut self, flow: &mut Flow<'_>, from: f64, to: f64) -> f64 {
        let size = |j: usize| self.x[j].abs();
        let d0 = self.norm(self.x.iter().copied(), size);
        let d1 = self.norm(self.k[0].iter().copied(), size);
        let span = to - from;
        let usable = d0 >= 1e-5 && d1 >= 1e-5 && d0.is_finite() && d1.is_finite();
        let h0 = if usable { 0.01 * d0 / d1 } else { 1e-6 * span }.min(span);
        for j in 0..self.x.len() {
            self.stage[j] = self.x[j] + h0 * self.k[0][j];
        }
        flow.eval(from + h0, &self.stage, &mut self.k[1]);
        let change = self.k[1].iter().zip(&self.k[0]).map(|(a, b)| a - b);
        let d2 = self.norm(change, |j| self.x[j].abs()) / h0;
        let largest = d1.max(d2);
        let h1 = if largest <= 1e-15 || !largest.is_finite() {
            (1e-6 * span).max(1e-3 * h0)
        } else {
            (0.01 / largest).powf(0.2)
        };
        let h = (100.0 * h0).min(h1).min(span);
        // Underflow would leave nothing to shrink from.
        h.max(8.0 * f64::EPSILON * from.abs())
            .max(f64::MIN_POSITIVE)
    }

    /// Computes the step into `next` and returns its error in units of the tolerance.
    fn attempt(&mut self, flow: &mut Flow<'_>, t: f64, h: f64) -> f64 {
        let n = self.x.len();
        for (i, weights) in A.iter().enumerate() {
            let (done, rest) = self.k.split_at_mut(i + 1);
            for j in 0..n {
                let mut slope = 0.0;
                for (k, weight) in done.iter().zip(weights) {
                    slope += weight * k[j];
                }
                self.stage[j] = self.x[j] + h * slope;
            }
            flow.eval(t + C[i] * h, &self.stage, &mut rest[0]);
        }
        self.next.copy_from_slice(&self.stage);
        let error = (0..n).map(|j| h * self.weighted(&E, j));
        self.norm(error, |j| self.x[j].abs().max(self.next[j].abs()))
    }

    fn weighted(&self, weights: &[f64; 7], j: usize) -> f64 {
        self.k.iter().zip(weights).map(|(k, w)| w * k[j]).sum()
    }

    /// How much longer the step after an accepted one may be.
    fn accepted_factor(&mut self, error: f64) -> f64 {
        let factor = SAFETY * self.error_before.powf(BETA) / error.powf(0.2 - 0.75 * BETA);
        self.error_before = error.max(1e-4);
        factor.clamp(SHRINK, GROW)
    }

    /// Gives the wanted times up to `end` of the step from `t` of length `h`.
    fn emit(&mut self, wanted: &mut &[f64], t: f64, h: f64, end: f64, run: &mut Run) {
        while let Some((&at, later)) = wanted.split_first()
            && at <= end
        {
            *wanted = later;
            if at == end {
                run.push(at, &self.next);
                continue;
            }
            let s = (at - t) / h;
            for j in 0..self.x.len() {
                let rise = self.next[j] - self.x[j];
                let bend = h * self.k[0][j] - rise;
                let twist = rise - h * self.k[6][j] - bend;
                let last = h * self.weighted(&D, j);
                let inner = bend + s * (twist + (1.0 - s) * last);
                self.stage[j] = self.x[j] + s * (rise + (1.0 - s) * inner);
            }
            run.push(at, &self.stage);
        }
    }

    /// The last stage of an accepted step is the first of the next.
    fn advance(&mut self) {
        std::mem::swap(&mut self.x, &mut self.next);
        self.k.swap(0, 6);
    }
}
