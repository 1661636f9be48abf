//! Least squares over all runs: Gauss–Newton with Levenberg's damping; scale and height error of each run are
//! eliminated from its normal equations.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rayon::prelude::*;

use super::coloured_noise::ColouredNoise;
use super::differences::Differences;
use super::model::{ModelTerms, ModelValues, Parameter, Segment};
use super::normal::{FitColumns, HUBER, NormalEquations, ReducedEquations, hold, normal_equations};

/// Steps at most.
/// Gauss-Newton ends in far fewer where there is a minimum: more only delay the refusal of a fit that has none.
const MOST_STEPS: usize = 60;
/// Standard deviation of the residual that a first fit starts from (gravities); it settles within a few steps.
const FIRST_SIGMA: f64 = 0.1;
/// Damping at the start, and from which the search ends.
const FIRST_DAMPING: f64 = 1e-4;
const MOST_DAMPING: f64 = 1e9;
/// Step of the height error for derivatives, in R.
/// The curve bends over a radius or two: the difference is within 1 % of the slope, and rounding is far below.
const BIAS_STEP: f64 = 0.02;
/// Longest move of a height error in one step, in R.
/// Two priors: a larger step leaves the range in which the curve is nearly straight.
const BIAS_MOST: f64 = 0.3;

/// What belongs to one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentOffsets {
    /// Thrust scale k: specific force at hover's throttle, in gravities.
    pub scale: f64,
    /// Constant error of the height b, in R.
    pub bias: f64,
}

impl SegmentOffsets {
    pub(super) fn moved(self, by: Vector2<f64>) -> Self {
        Self {
            scale: self.scale + by.x,
            bias: self.bias + by.y.clamp(-BIAS_MOST, BIAS_MOST),
        }
    }
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// What the model has.
    pub shape: ModelTerms,
    /// Its numbers, in the order of [`ModelTerms::parameters`].
    pub theta: Vec<f64>,
    /// Scale and height error of each run.
    pub locals: Vec<SegmentOffsets>,
    /// Standard deviation of the residual, in gravities.
    pub sigma: f64,
    /// The disturbance that outlasts a row, if the fit accounts for one.
    pub colour: Option<ColouredNoise>,
    /// Rows that counted.
    pub rows: usize,
    /// Steps taken.
    pub steps: usize,
    /// Whether the steps converged.
    pub converged: bool,
    /// Numbers at their bound.
    pub(super) held: Vec<usize>,
    pub(super) reduced: Vec<ReducedEquations>,
}

impl Fit {
    /// A number by name; `None` where the shape has none of it.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        self.index(name).map(|i| self.theta[i])
    }

    pub(super) fn index(&self, name: &str) -> Option<usize> {
        self.shape.parameters().iter().position(|p| p.name == name)
    }

    /// The values for simulation.
    #[must_use]
    pub fn values(&self) -> ModelValues {
        ModelValues::of(&self.shape, &self.theta)
    }

    /// Modelled specific force of every row that counts, run by run.
    #[must_use]
    pub fn predict(&self, pieces: &[Segment]) -> Vec<Vec<f64>> {
        let values = self.values();
        pieces
            .par_iter()
            .zip(&self.locals)
            .map(|(piece, local)| {
                let run = piece.simulate(&values, local.bias);
                run.into_iter().map(|y| local.scale * y).collect()
            })
            .collect()
    }

    /// Measured less modelled specific force of every row that counts, run by run.
    #[must_use]
    pub fn residuals(&self, pieces: &[Segment]) -> Vec<Vec<f64>> {
        pieces
            .iter()
            .zip(self.predict(pieces))
            .map(|(p, run)| {
                p.rows
                    .iter()
                    .zip(run)
                    .map(|(&i, y)| p.force[i] - y)
                    .collect()
            })
            .collect()
    }

    /// The same model with the disturbance that its residuals show: thrice, for the better the model, the clearer the
    /// disturbance.
    pub(super) fn coloured(&self, pieces: &[Segment]) -> Self {
        let step_s = Segment::median_step_s(pieces);
        let mut out = self.clone();
        for _ in 0..3 {
            let colour = ColouredNoise::of(pieces, &out.residuals(pieces), step_s);
            out = Self { colour, ..out };
            if colour.is_none() {
                break;
            }
            out = fit(pieces, self.shape, Some(&out));
        }
        out
    }

    pub(super) fn prior(&self) -> DMatrix<f64> {
        let sd = self
            .shape
            .parameters()
            .iter()
            .map(|p| p.prior_sd.powi(-2))
            .collect::<Vec<_>>();
        DMatrix::from_diagonal(&DVector::from_vec(sd))
    }
}

/// Fits a shape, from the values of an earlier fit where they have the same name.
#[must_use]
pub fn fit(pieces: &[Segment], shape: ModelTerms, from: Option<&Fit>) -> Fit {
    let parameters = shape.parameters();
    let theta: Vec<f64> = parameters
        .iter()
        .map(|p| from.and_then(|f| f.value(p.name)).unwrap_or(p.start))
        .collect();
    let locals = match from {
        Some(f) if f.locals.len() == pieces.len() => f.locals.clone(),
        _ => vec![
            SegmentOffsets {
                scale: 1.0,
                bias: 0.0
            };
            pieces.len()
        ],
    };
    let sigma = from.map_or(FIRST_SIGMA, |f| f.sigma);
    let colour = from.and_then(|f| f.colour);
    let system = FitSystem {
        pieces,
        shape,
        parameters: &parameters,
        colour,
        differences: Differences::OneSided,
    };
    let mut search = Search {
        now: system.assemble(&theta, &locals, sigma),
        theta,
        locals,
        sigma,
        damping: FIRST_DAMPING,
        converged: false,
    };
    let mut steps = 0;
    while steps < MOST_STEPS && !search.converged && search.damping <= MOST_DAMPING {
        steps += 1;
        search.step(&system);
    }
    // Where the steps converged, which the last of them may have reached.
    let (gradient, _) = total(&search.now, &parameters, &search.theta);
    let held = at_bounds(&parameters, &search.theta, &gradient);
    Fit {
        shape,
        theta: search.theta,
        locals: search.locals,
        sigma: search.sigma,
        colour,
        rows: pieces.iter().map(|p| p.rows.len()).sum(),
        steps,
        converged: search.converged,
        held,
        reduced: search.now.into_iter().map(|a| a.reduced).collect(),
    }
}

/// Where the Gauss–Newton steps are.
struct Search {
    theta: Vec<f64>,
    locals: Vec<SegmentOffsets>,
    sigma: f64,
    /// Levenberg's damping, relative to the diagonal.
    damping: f64,
    converged: bool,
    /// The normal equations here.
    now: Vec<NormalEquations>,
}

impl Search {
    /// One damped step; it is taken if the squares fall.
    fn step(&mut self, system: &FitSystem<'_>) {
        let parameters = system.parameters;
        let (mut gradient, mut hessian) = total(&self.now, parameters, &self.theta);
        let held = at_bounds(parameters, &self.theta, &gradient);
        hold(&mut hessian, &mut gradient, &held);
        let mut damped = hessian.clone();
        for i in 0..self.theta.len() {
            damped[(i, i)] *= 1.0 + self.damping;
        }
        let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
            self.damping = (self.damping * 10.0_f64).max(1e-6);
            return;
        };
        let next: Vec<f64> = (0..self.theta.len())
            .map(|i| (self.theta[i] + step[i]).clamp(parameters[i].min, parameters[i].max))
            .collect();
        let moved = next.iter().zip(&self.theta).map(|(to, from)| to - from);
        let shift = DVector::from_iterator(next.len(), moved);
        let locals = self.locals_after(&shift);
        let then = system.assemble(&next, &locals, self.sigma);
        let before = cost(&self.now, parameters, &self.theta);
        let after = cost(&then, parameters, &next);
        if after.is_finite() && after <= before * (1.0 + 1e-12) {
            self.converged = before - after < 1e-7 * before
                && shift.dot(&(&hessian * &shift)).abs() < 1e-3 + 1e-7 * before;
            (self.theta, self.locals) = (next, locals);
            self.damping = (self.damping * 0.2).max(1e-9);
            self.settle_sigma(system, then);
        } else {
            self.damping *= 10.0;
            // No step is short enough to lower the squares: this is their minimum.
            self.converged = self.damping > MOST_DAMPING;
        }
    }

    /// Scales and height errors after a shift of the shared numbers.
    fn locals_after(&self, shift: &DVector<f64>) -> Vec<SegmentOffsets> {
        let equations = self.now.iter().zip(&self.locals);
        equations
            .map(|(a, l)| l.moved(a.local(shift) / (1.0 + self.damping)))
            .collect()
    }

    /// The residual's standard deviation settles with the fit: the equations are weighted again where it moves by more than
    /// one per cent.
    fn settle_sigma(&mut self, system: &FitSystem<'_>, then: Vec<NormalEquations>) {
        let (rows, square) = then
            .iter()
            .fold((0.0, 0.0), |(n, s), a| (n + a.weight, s + a.square));
        let freedom = (rows - self.theta.len() as f64).max(1.0);
        let better = self.sigma * (square / freedom).sqrt().max(1e-9);
        if (better / self.sigma - 1.0).abs() > 0.01 {
            self.converged = false;
            self.sigma = better;
            self.now = system.assemble(&self.theta, &self.locals, self.sigma);
        } else {
            self.now = then;
        }
    }
}

/// Squares of one run's errors: as they are, and as errors of prediction one step ahead.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ErrorSquares {
    pub(super) plain: f64,
    pub(super) white: f64,
    pub(super) rows: f64,
}

/// Scale and height error of one run for given shared numbers, and its squares over the rows that `counts`, each error
/// at most `clip`.
pub(super) fn settle(
    piece: &Segment,
    fit: &Fit,
    theta: &[f64],
    from: SegmentOffsets,
    clip: f64,
    counts: &dyn Fn(usize) -> bool,
) -> (SegmentOffsets, ErrorSquares) {
    let values = ModelValues::of(&fit.shape, theta);
    // The height error moves no motor.
    let roots = piece.roots(&values);
    let at = |bias: f64| {
        let lifts = piece.lifts(&values, bias, &roots);
        piece.forces(&values, bias, &roots, &lifts)
    };
    let mut local = from;
    let precision = piece.bias_sd.powi(-2);
    for _ in 0..4 {
        let base = at(local.bias);
        let raised = at(local.bias + BIAS_STEP);
        let mut outer = Matrix2::new(1e-12, 0.0, 0.0, precision);
        let mut own = Vector2::new(0.0, -precision * local.bias);
        for (row, &i) in piece.rows.iter().enumerate() {
            let r = (piece.force[i] - local.scale * base[row]) / fit.sigma;
            let w = if r.abs() > HUBER {
                HUBER / r.abs()
            } else {
                1.0
            };
            let slope = local.scale * (raised[row] - base[row]) / BIAS_STEP;
            let mine = Vector2::new(base[row], slope) / fit.sigma;
            outer += w * mine * mine.transpose();
            own += w * r * mine;
        }
        let d = outer.try_inverse().unwrap_or_else(Matrix2::zeros) * own;
        local.scale += d.x;
        local.bias += d.y.clamp(-BIAS_MOST, BIAS_MOST);
    }
    let run = at(local.bias);
    let plain: Vec<f64> = run
        .iter()
        .zip(&piece.rows)
        .map(|(y, &i)| piece.force[i] - local.scale * y)
        .collect();
    let mut white = plain.clone();
    if let Some(colour) = fit.colour {
        colour.filter(piece, [&mut white]);
    }
    let mut out = ErrorSquares::default();
    // A single wild row does not decide.
    let square = |r: f64| r.powi(2).min(clip * clip);
    for ((plain, white), _) in plain
        .iter()
        .zip(&white)
        .zip(&piece.rows)
        .filter(|(_, i)| counts(**i))
    {
        out.plain += square(*plain);
        out.white += square(*white);
        out.rows += 1.0;
    }
    (local, out)
}

/// What stays the same during a fit.
pub(super) struct FitSystem<'a> {
    pub(super) pieces: &'a [Segment],
    pub(super) shape: ModelTerms,
    pub(super) parameters: &'a [Parameter],
    pub(super) colour: Option<ColouredNoise>,
    pub(super) differences: Differences,
}

impl FitSystem<'_> {
    pub(super) fn assemble(
        &self,
        theta: &[f64],
        locals: &[SegmentOffsets],
        sigma: f64,
    ) -> Vec<NormalEquations> {
        self.pieces
            .par_iter()
            .zip(locals)
            .map(|(piece, local)| {
                let columns = self.columns(piece, *local, theta, sigma);
                normal_equations(&columns, piece.bias_sd, local.bias)
            })
            .collect()
    }

    fn columns(
        &self,
        piece: &Segment,
        local: SegmentOffsets,
        theta: &[f64],
        sigma: f64,
    ) -> FitColumns {
        let values = ModelValues::of(&self.shape, theta);
        let roots = piece.roots(&values);
        let lifts = piece.lifts(&values, local.bias, &roots);
        let base = piece.forces(&values, local.bias, &roots, &lifts);
        // What a number does not move is not computed again.
        let of = |moved: &ModelValues| {
            let own_roots = (!moved.has_motors_of(&values)).then(|| piece.roots(moved));
            let roots = own_roots.as_ref().unwrap_or(&roots);
            let own_lifts =
                (!moved.has_wake_of(&values)).then(|| piece.lifts(moved, local.bias, roots));
            piece.forces(
                moved,
                local.bias,
                roots,
                own_lifts.as_ref().unwrap_or(&lifts),
            )
        };
        let slope = |to: &[f64], from: &[f64], step: f64| -> Vec<f64> {
            let by = local.scale / (step * sigma);
            to.iter()
                .zip(from)
                .map(|(to, from)| (to - from) * by)
                .collect()
        };
        let shared = (0..theta.len())
            .map(|k| {
                let moved = |by: f64| {
                    let mut there = theta.to_vec();
                    there[k] += by;
                    let forces = of(&ModelValues::of(&self.shape, &there));
                    (forces, there[k] - theta[k])
                };
                match self.differences.ends(&self.parameters[k], theta[k]) {
                    [0.0, by] => {
                        let (forces, step) = moved(by);
                        slope(&forces, &base, step)
                    }
                    ends => {
                        let [(low, from), (high, to)] = ends.map(moved);
                        slope(&high, &low, to - from)
                    }
                }
            })
            .collect();
        let raised = local.bias + BIAS_STEP;
        let lifts = piece.lifts(&values, raised, &roots);
        let by_bias = slope(
            &piece.forces(&values, raised, &roots, &lifts),
            &base,
            BIAS_STEP,
        );
        let residual = piece
            .rows
            .iter()
            .zip(&base)
            .map(|(&i, b)| (piece.force[i] - local.scale * b) / sigma)
            .collect();
        let by_scale = base.iter().map(|b| b / sigma).collect();
        let mut out = FitColumns {
            residual,
            shared,
            own: [by_scale, by_bias],
        };
        if let Some(colour) = self.colour {
            let all = std::iter::once(&mut out.residual)
                .chain(&mut out.shared)
                .chain(&mut out.own);
            colour.filter(piece, all);
        }
        out
    }
}

/// Numbers at a bound that the squares would have beyond it.
pub(super) fn at_bounds(
    parameters: &[Parameter],
    theta: &[f64],
    gradient: &DVector<f64>,
) -> Vec<usize> {
    let pushed = |i: &usize| {
        let (p, v, g) = (&parameters[*i], theta[*i], gradient[*i]);
        (v <= p.min && g < 0.0) || (v >= p.max && g > 0.0)
    };
    (0..theta.len()).filter(pushed).collect()
}

/// Gradient and matrix of all runs and of what is known beforehand.
pub(super) fn total(
    now: &[NormalEquations],
    parameters: &[Parameter],
    theta: &[f64],
) -> (DVector<f64>, DMatrix<f64>) {
    let n = theta.len();
    let mut gradient = DVector::zeros(n);
    let mut hessian = DMatrix::zeros(n, n);
    for a in now {
        gradient += &a.reduced.vector;
        hessian += &a.reduced.matrix;
    }
    for (i, p) in parameters.iter().enumerate() {
        let precision = p.prior_sd.powi(-2);
        hessian[(i, i)] += precision;
        gradient[i] -= precision * (theta[i] - p.start);
    }
    (gradient, hessian)
}

fn cost(now: &[NormalEquations], parameters: &[Parameter], theta: &[f64]) -> f64 {
    let known: f64 = parameters
        .iter()
        .zip(theta)
        .map(|(p, v)| ((v - p.start) / p.prior_sd).powi(2))
        .sum();
    known + now.iter().map(|a| a.cost).sum::<f64>()
}
