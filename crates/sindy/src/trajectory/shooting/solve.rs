//! Gauss–Newton with Levenberg's damping over parameters and window starts.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Record;
use super::model::OdeModel;
use super::normal::{Back, Reduced, Stretch, WindowEquations};
use super::propagate::{self, Window};
use super::settings::{Parameter, Shooting};
use crate::error::SindyError;

/// Windows that are simulated side by side: enough for vector registers, few enough for the first-level
/// cache.
const LANES: usize = 32;

/// A full step that lowers the cost by less than this share ends the search: far below what a standard error resolves.
const CONVERGED: f64 = 1e-9;
/// A rejected step below this share of every parameter is within the rounding of the cost, whose minimum is flat.
const SMALL_STEP: f64 = 1e-7;
/// Share of the cost that its rounding may add: a sum of up to a million squares, each of them rounded.
const ROUNDING: f64 = 1e-12;
/// Size that counts as that of a parameter near zero.
const SMALL_PARAMETER: f64 = 1e-3;
/// Levenberg's damping, relative to the diagonal: where it starts and begins again, its least and its largest value. All
/// but the first steps are full Gauss–Newton steps; ten times other values cost a step or two.
const LEAST_USED_DAMPING: f64 = 1e-6;
const LEAST_DAMPING: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e9;

/// Parameters and window starts, with their linearisation and cost.
struct Iterate {
    theta: DVector<f64>,
    starts: Vec<DVector<f64>>,
    parts: Vec<WindowEquations>,
    cost: f64,
}

/// Why the refinement ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A full step no longer lowers the cost by more than a billionth.
    Converged,
    /// The iteration limit was reached first.
    IterationLimit,
    /// No damping finds a lower cost, but the last step was not small; or the model blows up at the start.
    Stalled,
}

/// The refined parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// The parameters, in the model's order.
    pub parameters: Vec<f64>,
    /// Standard errors robust to correlation inside groups; NaN unless there are more groups than parameters, for a
    /// parameter at its bound, and for one on which no residual depends.
    pub std_errors: Vec<f64>,
    /// Correlation of the estimates, p x p, from the normal matrix.
    pub correlation: DMatrix<f64>,
    /// Root mean square residual over all windows, in the output's unit.
    pub rmse: f64,
    /// Residuals that were taken.
    pub residuals: usize,
    /// Steps that were taken.
    pub iterations: usize,
    /// Why it ended.
    pub outcome: Outcome,
}

impl Refined {
    fn of(
        at: &Iterate,
        (std_errors, correlation): (Vec<f64>, DMatrix<f64>),
        iterations: usize,
        outcome: Outcome,
    ) -> Self {
        let residuals: usize = at.parts.iter().map(|p| p.count).sum();
        let squares: f64 = at.parts.iter().map(|p| p.squares).sum();
        Self {
            parameters: at.theta.as_slice().to_vec(),
            std_errors,
            correlation,
            rmse: (squares / residuals.max(1) as f64).sqrt(),
            residuals,
            iterations,
            outcome,
        }
    }

    /// The start itself, from which the model blows up: it has no slope to follow.
    fn blown_up(start: &Iterate) -> Self {
        let p = start.theta.len();
        let unknown = (vec![f64::NAN; p], DMatrix::from_element(p, p, f64::NAN));
        Self {
            rmse: f64::INFINITY,
            ..Self::of(start, unknown, 0, Outcome::Stalled)
        }
    }
}

impl Shooting {
    /// Refines `model` on `records`. A model that blows up at the start of the search is returned as it came.
    ///
    /// # Errors
    /// Settings out of range, records that do not fit the model, or no window without gaps.
    pub fn refine(
        &self,
        model: &OdeModel,
        records: &[Record<'_>],
        parameters: &[Parameter],
    ) -> Result<Refined, SindyError> {
        self.check(model, records, parameters)?;
        let stretches = self.stretches(records);
        if stretches.is_empty() {
            return Err(SindyError::too_short(2, 0));
        }
        let guess: Vec<DVector<f64>> = stretches.iter().map(Stretch::guess).collect();
        let clamp = |v: DVector<f64>| {
            DVector::from_fn(v.len(), |j, _| {
                v[j].clamp(parameters[j].min, parameters[j].max)
            })
        };
        let theta = clamp(DVector::from_fn(parameters.len(), |j, _| {
            parameters[j].start
        }));
        let evaluate = |theta: DVector<f64>, starts: Vec<DVector<f64>>| {
            let mut at = Iterate {
                parts: self.linearise(model, &stretches, &theta, &starts),
                theta,
                starts,
                cost: 0.0,
            };
            at.cost = self.cost(&at, parameters, &guess);
            at
        };
        let reduce = |at: &Iterate| self.reduce(at, parameters, &guess);
        let mut at = evaluate(theta, guess.clone());
        if at.cost == f64::INFINITY {
            return Ok(Refined::blown_up(&at));
        }
        let mut damping = LEAST_USED_DAMPING;
        let mut outcome = Outcome::IterationLimit;
        let mut iterations = 0;
        while iterations < self.max_iterations {
            iterations += 1;
            let system = reduce(&at);
            let step = system.step(damping, parameters, &at.theta);
            let theta = clamp(&at.theta + &step);
            let step = &theta - &at.theta;
            let pairs = at.starts.iter().zip(&system.back);
            let starts = pairs.map(|(x, b)| x + b.start_step(&step)).collect();
            let next = evaluate(theta, starts);
            if next.cost <= at.cost {
                let gain = (at.cost - next.cost) / at.cost.max(f64::MIN_POSITIVE);
                at = next;
                damping = (damping * 0.1).max(LEAST_DAMPING);
                if gain < CONVERGED {
                    outcome = Outcome::Converged;
                    break;
                }
            } else {
                let mut pairs = step.iter().zip(&at.theta);
                let small = pairs.all(|(s, t)| s.abs() <= SMALL_STEP * (t.abs() + SMALL_PARAMETER));
                if small || damping > MOST_DAMPING {
                    outcome = match small {
                        true => Outcome::Converged,
                        false => Outcome::Stalled,
                    };
                    // The gradient knows the minimum to more digits than the cost: whether such a step is taken must not depend
                    // on the last bit of a sum, which differs between machines.
                    if small && next.cost <= at.cost * (1.0 + ROUNDING) {
                        at = next;
                    }
                    break;
                }
                damping = (damping * 10.0).max(LEAST_USED_DAMPING);
            }
        }
        let errors = reduce(&at).errors(&stretches, parameters, &at.theta);
        Ok(Refined::of(&at, errors, iterations, outcome))
    }

    /// Windows whose inputs and first guess are finite.
    fn stretches<'a>(&self, records: &'a [Record<'a>]) -> Vec<Stretch<'a>> {
        let mut out = Vec::new();
        for record in records {
            let time = record.time;
            let mut first = 0;
            while first + 1 < time.len() {
                let end = time[first] + self.window;
                let len = time[first..].partition_point(|t| *t <= end);
                let finite = |c: &&[f64]| c[first..first + len].iter().all(|v| v.is_finite());
                let started = record.start.iter().all(|c| c[first].is_finite());
                if len > 1 && started && record.inputs.iter().all(finite) {
                    out.push(Stretch { record, first, len });
                }
                if first + len >= time.len() {
                    break;
                }
                let next = time[first] + self.stride;
                first = time.partition_point(|t| *t < next).max(first + 1);
            }
        }
        out
    }

    fn linearise(
        &self,
        model: &OdeModel,
        stretches: &[Stretch<'_>],
        theta: &DVector<f64>,
        starts: &[DVector<f64>],
    ) -> Vec<WindowEquations> {
        let (n, p) = (model.states.len(), theta.len());
        let chunks: Vec<(&[Stretch<'_>], &[DVector<f64>])> =
            stretches.chunks(LANES).zip(starts.chunks(LANES)).collect();
        let parts: Vec<Vec<WindowEquations>> = chunks
            .into_par_iter()
            .map(|(stretches, starts)| {
                let lanes = stretches.len();
                let inputs: Vec<Vec<&[f64]>> = stretches
                    .iter()
                    .map(|s| {
                        s.record
                            .inputs
                            .iter()
                            .map(|c| &c[s.first..s.first + s.len])
                            .collect()
                    })
                    .collect();
                let windows: Vec<Window<'_>> = stretches
                    .iter()
                    .zip(&inputs)
                    .map(|(s, inputs)| Window {
                        time: &s.record.time[s.first..s.first + s.len],
                        inputs,
                        len: s.len,
                    })
                    .collect();
                let mut x0 = vec![0.0; n * lanes];
                for (lane, x) in starts.iter().enumerate() {
                    (0..n).for_each(|i| x0[i * lanes + lane] = x[i]);
                }
                let mut parts: Vec<WindowEquations> =
                    (0..lanes).map(|_| WindowEquations::zeros(n, p)).collect();
                let mut row = vec![0.0; p + n];
                let sink: propagate::Sink<'_> = &mut |k, y, dy_p, dy_0| {
                    if !k.is_multiple_of(self.every) {
                        return;
                    }
                    for (lane, (stretch, part)) in stretches.iter().zip(&mut parts).enumerate() {
                        if k >= stretch.len {
                            continue;
                        }
                        let measured = stretch.record.measured[stretch.first + k];
                        if measured.is_finite() {
                            (0..p).for_each(|j| row[j] = dy_p[j * lanes + lane]);
                            (0..n).for_each(|j| row[p + j] = dy_0[j * lanes + lane]);
                            part.add(y[lane] - measured, &row, p);
                        }
                    }
                };
                propagate::run(model, theta.as_slice(), &windows, &x0, true, sink);
                parts
            })
            .collect();
        parts.into_iter().flatten().collect()
    }

    fn cost(&self, at: &Iterate, parameters: &[Parameter], guess: &[DVector<f64>]) -> f64 {
        let Iterate {
            parts,
            theta,
            starts,
            ..
        } = at;
        let data: f64 = parts.iter().map(|p| p.squares).sum::<f64>() / self.noise_sd.powi(2);
        let prior: f64 = parameters
            .iter()
            .zip(theta)
            .map(|(p, t)| ((t - p.start) / p.prior_sd).powi(2))
            .sum();
        let start: f64 = if self.start_sd > 0.0 {
            starts
                .iter()
                .zip(guess)
                .map(|(x, g)| (x - g).norm_squared())
                .sum::<f64>()
                / self.start_sd.powi(2)
        } else {
            0.0
        };
        let cost = data + prior + start;
        if cost.is_finite() {
            cost
        } else {
            f64::INFINITY
        }
    }

    /// Eliminates the starts: `(H - H₀ᵀ A⁻¹ H₀) δ = -(g - H₀ᵀ A⁻¹ g₀)`, `A = H₀₀ + prior`.
    fn reduce(&self, at: &Iterate, parameters: &[Parameter], guess: &[DVector<f64>]) -> Reduced {
        let Iterate {
            parts,
            theta,
            starts,
            ..
        } = at;
        let p = theta.len();
        let w = 1.0 / self.noise_sd.powi(2);
        let mut h = DMatrix::zeros(p, p);
        let mut g = DVector::zeros(p);
        let mut back = Vec::with_capacity(parts.len());
        let mut scores = Vec::with_capacity(parts.len());
        for ((part, x), x_guess) in parts.iter().zip(starts).zip(guess) {
            let n = x.len();
            let mut score = &part.g * w;
            h += &part.h * w;
            if n > 0 && self.start_sd > 0.0 {
                let prior = 1.0 / self.start_sd.powi(2);
                let a = &part.h0 * w + DMatrix::identity(n, n) * prior;
                let g0 = &part.g0 * w + (x - x_guess) * prior;
                let h0p = &part.h0p * w;
                let inverse = crate::statistics::regression::pseudo_inverse(&a);
                let gain = &inverse * &h0p;
                h -= h0p.transpose() * &gain;
                score -= gain.transpose() * &g0;
                back.push(Back {
                    offset: -(&inverse * g0),
                    gain: -gain,
                });
            } else {
                back.push(Back {
                    offset: DVector::zeros(n),
                    gain: DMatrix::zeros(n, p),
                });
            }
            g += &score;
            scores.push(score);
        }
        for (j, parameter) in parameters.iter().enumerate() {
            let prior = parameter.prior_sd.powi(-2);
            h[(j, j)] += prior;
            g[j] += prior
                * if prior > 0.0 {
                    theta[j] - parameter.start
                } else {
                    0.0
                };
        }
        Reduced { h, g, back, scores }
    }
}
