//! Trajectory and model together by the filter-error method: maximum likelihood of the innovations of a Kalman filter.
//!
//! Height and climb rate are regressors of the model, and they are measured with noise. A model that is fitted along measured
//! heights has its coefficients biased towards zero (errors in variables), and a climb rate holds the disturbances of the past.
//! Here the model predicts the motion; range, climb rate and accelerometer correct it, each by its own noise:
//!
//! ```text
//! h' = v,   v' = g ((k f(x, h + b, v) + d) cos(tilt) - 1),   d' = -d/t_d + white noise
//! range = h + noise,   climb rate = v + noise,   specific force = k f + d + β + noise
//! minimum over model and noise:  Σ ε²/S + ln S,   ε the innovations, S their variances
//! ```
//!
//! `f` is the model of [`super::model`], `d` turbulence, `β` the accelerometer's error. Thrust scale `k`, height error `b` and
//! `β` of each armed interval are states of the filter that do not change. Without an accelerometer, heights alone correct the
//! motion. An accelerometer may have a latency, which is then a number of the model: its readings correct the motion at the times
//! at which they were felt.
//!
//! R. E. Maine and K. W. Iliff, NASA RP-1138 (1985); R. V. Jategaonkar, "Flight Vehicle System Identification" (2015),
//! chapter 5.

mod clock;
mod equations;
mod filter;
mod kalman;
mod latency;
mod noise;
mod whiteness;

use nalgebra::DVector;
use rayon::prelude::*;

pub use noise::{GroundMotion, Noise};

pub(super) use self::clock::start;
pub(super) use self::filter::Settings;
pub(super) use self::latency::{with_latency, with_long_latency};

pub(super) use self::whiteness::Whiteness;

use self::kalman::Pass;
use super::fit::{Fit, fit};
use super::ground::Basis;
use super::model::{ModelTerms, ModelValues, Parameter, Segment};

/// Rounds of model and noise in turn at most; most fits take three.
const MOST_ROUNDS: usize = 8;
/// Gauss–Newton steps of a round at most; the first round takes four.
const MOST_STEPS: usize = 6;
/// Decrease of minus twice the log-likelihood below which a step, and a round, ends.
/// A standard error is a decrease of 1: a tenth moves a number by a third of it at most, a fiftieth by a seventh.
const OF_ROUND: f64 = 0.1;
const OF_STEP: f64 = 0.02;
/// Shortest share of a Gauss–Newton step that is tried, and the factor from one try to the next.
const SHORTEST: f64 = 0.02;
const SHORTER: f64 = 0.4;

/// A model with the noise under which the flights are likeliest.
#[derive(Clone, Debug)]
pub(super) struct Tracked {
    /// The model; its equations are those of the likelihood.
    pub(super) fit: Fit,
    /// Noise of sensors and air.
    pub(super) noise: Noise,
    /// Minus twice the log-likelihood, with that of the priors.
    pub(super) cost: f64,
    /// How far the innovations are from white noise.
    pub(super) colour: Whiteness,
    /// Half the slope of the cost downwards, of stretches of time.
    pub(super) slopes: Vec<DVector<f64>>,
    /// Latency of the range against accelerometer and throttle (s); absent over a ground at rest.
    pub(super) range_latency_s: Option<f64>,
}

impl Tracked {
    /// Whether the innovations are white enough for their likelihood to be one.
    pub(super) fn is_trusted(&self) -> bool {
        self.fit.converged && self.colour.is_white()
    }

    /// Whether the likelihood is to be preferred to a fit along measured heights.
    ///
    /// A force from poses is smoothed, so that fit has no lag, and its curve is wrong by what the lag moves. Rows that hold
    /// heights of up to a row before (25 ms) colour innovations by 0.2 to 0.4, and move a lag by less than that age.
    pub(super) fn is_preferred(&self, basis: Basis) -> bool {
        self.is_trusted() || (basis == Basis::Poses && self.is_nearly_white())
    }

    /// Whether the innovations are near enough to white that their scatter by stretches of time is an interval.
    pub(super) fn is_nearly_white(&self) -> bool {
        self.fit.converged && self.colour.may_become_white()
    }
}

/// Constants of one problem.
struct Problem<'a> {
    pieces: &'a [Segment],
    shape: ModelTerms,
    parameters: Vec<Parameter>,
    settings: Settings,
}

/// A point of the search.
struct Point {
    theta: Vec<f64>,
    noise: Noise,
    cost: f64,
}

/// Fits model and noise along the trajectories, from a [`start`]; `None` where the flights have no likelihood
/// there. Outcome `converged` of the fit tells whether the rounds came to an end.
pub(super) fn track(pieces: &[Segment], start: &Fit, settings: Settings) -> Option<Tracked> {
    let problem = Problem::of(pieces, start, settings);
    let found = problem.track(start, Noise::first(start), true)?;
    Some(clock::across_zero(pieces, found, settings))
}

/// As [`track`], for what may keep that from being a likelihood: climb rates that a filter gives, whose errors go on from one to
/// the next, and a ground that moves as a deck does. The first of these under which the innovations are white, if any.
///
/// Only with an accelerometer: without one, nothing tells the motion of the ground from that of the vehicle.
pub(super) fn track_beside_others(
    pieces: &[Segment],
    start: &Fit,
    settings: Settings,
) -> Option<Tracked> {
    let problem = Problem::of(pieces, start, settings);
    let [rest, without_climb] = noises_at_rest(pieces, start);
    let above_moving = |noise: Noise| {
        let cost = |noise: &Noise| problem.cost(&start.theta, *noise);
        let all = noise.above_moving_ground().into_iter();
        all.min_by(|a, b| cost(a).total_cmp(&cost(b)))
    };
    let moving = [rest, without_climb].map(|noise| noise.and_then(above_moving));
    [without_climb, moving[0], moving[1]]
        .into_iter()
        .flatten()
        .filter_map(|noise| problem.track(start, noise, true))
        .map(|found| clock::across_zero(pieces, found, settings))
        .find(Tracked::is_trusted)
}

/// Noise from which a search starts over a ground at rest: with all readings, and without logged climb rates, where there are some.
fn noises_at_rest(pieces: &[Segment], start: &Fit) -> [Option<Noise>; 2] {
    let rest = Noise::first(start);
    let measured = |p: &Segment| p.climb_measured_mps.iter().any(|v| v.is_finite());
    let without_climb = pieces.iter().any(measured);
    [Some(rest), without_climb.then(|| rest.without_climb_rate())]
}

/// As [`track`], for another shape, from what was found for one.
pub(super) fn track_shape(
    pieces: &[Segment],
    shape: ModelTerms,
    from: &Tracked,
    settings: Settings,
) -> Option<Tracked> {
    let start = fit(pieces, shape, Some(&from.fit));
    // What both shapes have starts where it was found, not where measured heights moved it.
    let parameters = shape.parameters();
    let theta = parameters.iter().zip(&start.theta);
    let theta = theta.map(|(p, v)| from.fit.value(p.name).unwrap_or(*v));
    let start = Fit {
        theta: theta.collect(),
        ..start
    };
    Problem::of(pieces, &start, settings).track(&start, from.noise, false)
}

/// The mean of values with standard errors; `None` where there are none.
fn weighted_mean(all: impl Iterator<Item = [f64; 2]>) -> Option<f64> {
    let [sum, weight] = all.fold([0.0; 2], |[sum, weight], [value, error]| {
        let precision = error.powi(-2);
        [sum + precision * value, weight + precision]
    });
    (weight > 0.0).then(|| sum / weight)
}

impl<'a> Problem<'a> {
    fn of(pieces: &'a [Segment], start: &Fit, settings: Settings) -> Self {
        Self {
            pieces,
            shape: start.shape,
            parameters: start.shape.parameters(),
            settings,
        }
    }

    /// Fits model and noise in turn, from a model and a noise; from a noise found anew by long steps.
    fn track(&self, start: &Fit, noise: Noise, anew: bool) -> Option<Tracked> {
        let mut point = Point {
            cost: self.cost(&start.theta, noise),
            theta: start.theta.clone(),
            noise,
        };
        if !point.cost.is_finite() {
            return None;
        }
        let (mut converged, mut steps) = (false, 0);
        while !converged && steps < MOST_ROUNDS * MOST_STEPS {
            let before = point.cost;
            self.likeliest_noise(&mut point, anew && steps == 0);
            for _ in 0..MOST_STEPS {
                steps += 1;
                let from = point.cost;
                self.step(&mut point)?;
                if from - point.cost < OF_STEP {
                    break;
                }
            }
            converged = before - point.cost < OF_ROUND;
            // What is far from white after a round does not become white.
            let passes = self.passes(&point.theta, point.noise);
            if !Whiteness::of(&passes).may_become_white() {
                return None;
            }
        }
        let equations = if converged {
            self.settle(&mut point)
        } else {
            self.equations(&point, None)
        };
        let passes = self.passes(&point.theta, point.noise);
        Some(Tracked {
            fit: Fit {
                locals: passes.iter().map(|p| p.local).collect(),
                colour: None,
                steps,
                converged,
                held: equations.held,
                reduced: equations.reduced,
                theta: point.theta,
                ..start.clone()
            },
            noise: point.noise,
            cost: point.cost,
            colour: Whiteness::of(&passes),
            range_latency_s: weighted_mean(passes.iter().filter_map(|p| p.range_latency_s)),
            slopes: equations.slopes,
        })
    }

    fn passes(&self, theta: &[f64], noise: Noise) -> Vec<Pass> {
        let values = ModelValues::of(&self.shape, theta);
        self.pieces
            .par_iter()
            .map(|p| filter::pass(p, &values, noise, self.settings))
            .collect()
    }

    /// Minus twice the log-likelihood, with that of the priors.
    fn cost(&self, theta: &[f64], noise: Noise) -> f64 {
        let known = self.parameters.iter().zip(theta);
        let known: f64 = known
            .map(|(p, v)| ((v - p.start) / p.prior_sd).powi(2))
            .sum();
        known
            + self
                .passes(theta, noise)
                .iter()
                .map(|p| p.cost)
                .sum::<f64>()
    }

    fn likeliest_noise(&self, point: &mut Point, anew: bool) {
        let of = |noise| self.cost(&point.theta, noise);
        (point.noise, point.cost) = point.noise.likeliest(point.cost, anew, of);
    }

    /// One step of Gauss–Newton, as long as it lowers the cost; `None` where the equations have no solution.
    fn step(&self, point: &mut Point) -> Option<()> {
        let equations = self.equations(point, None);
        let step = self.within_bounds(&equations, &point.theta)?;
        let mut length = 1.0;
        while length > SHORTEST {
            let next = self.moved(&point.theta, &(length * &step));
            let cost = self.cost(&next, point.noise);
            if cost < point.cost {
                (point.theta, point.cost) = (next, cost);
                break;
            }
            length *= SHORTER;
        }
        Some(())
    }
}
