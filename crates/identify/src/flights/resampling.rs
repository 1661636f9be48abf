//! Confidence intervals of the numbers, by resampling whole flights (bootstrap).

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::fit::Fit;
use super::likeliest::Rival;
use super::model::{ModelValues, Segment};
use super::normal::hold;
use crate::estimate::Estimate;

/// Fewest flights (or armed intervals) that are resampled.
/// Two blocks have one degree of freedom, for which Student's t is 12.7: no interval is worth that.
pub(super) const FEWEST: usize = 3;

/// Flights' worth of evidence that the likelihood of one flight is right.
/// Ten: one flight has a Student's t of 2.2. Half trusts the scatter of three flights sooner, twice later.
const PRIOR_FLIGHTS: f64 = 10.0;

/// What is resampled for the uncertainty.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ResamplingUnit {
    /// Whole flights.
    Flights,
    /// Armed intervals, for fewer than three flights.
    Runs,
    /// Correlated residuals of fewer than three runs.
    Residuals,
    /// The likelihood of all trajectories.
    Trajectories,
    /// Single hovers, and the scatter of flights beyond theirs.
    Hovers,
}

impl ResamplingUnit {
    /// In a word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Flights => "flights",
            Self::Runs => "runs of the motors",
            Self::Residuals => "runs, by the correlation of residuals",
            Self::Trajectories => "trajectories, by their likelihood",
            Self::Hovers => "hovers",
        }
    }
}

/// Draws of all shared numbers.
#[derive(Clone, Debug)]
pub struct Resampling {
    /// The resampled units.
    pub blocks: ResamplingUnit,
    /// How many there are of them.
    pub count: usize,
    /// How many flights there are.
    flights: usize,
    draws: Vec<Vec<f64>>,
    /// Draws of whole flights beside those of the likelihood.
    of_flights: Option<Vec<Vec<f64>>>,
    /// Draws by the scatter of slopes between stretches of time beside those of the likelihood.
    of_stretches: Option<Vec<Vec<f64>>>,
    /// The numbers of the same model fitted to heights with twice the noise.
    noisier: Option<Vec<f64>>,
    /// The numbers of the same model fitted as if no disturbance outlasted a row.
    white: Option<Vec<f64>>,
    /// Models with other curves that the flights do not exclude.
    rivals: Vec<Rival>,
    widen: f64,
    student: f64,
}

impl Resampling {
    /// Draws `resamples` sets of flights with replacement. Each is solved by one Gauss–Newton step from the fit, in which
    /// the scales and height errors of the runs follow.
    #[must_use]
    pub fn of(fit: &Fit, pieces: &[Segment], resamples: usize, seed: u64) -> Self {
        let flights = distinct(pieces.iter().map(|p| p.flight));
        let (blocks, of_piece): (ResamplingUnit, Vec<usize>) = if flights.len() >= FEWEST {
            let place = |p: &Segment| flights.iter().position(|f| *f == p.flight).unwrap_or(0);
            (ResamplingUnit::Flights, pieces.iter().map(place).collect())
        } else if pieces.len() >= FEWEST {
            (ResamplingUnit::Runs, (0..pieces.len()).collect())
        } else {
            return Self::of_residuals(fit, pieces, resamples, seed);
        };
        let count = of_piece.iter().max().map_or(0, |m| m + 1);
        let draws = block_draws(fit, &of_piece, count, resamples, seed);
        let k = count as f64;
        Self {
            blocks,
            count,
            flights: count,
            draws,
            of_flights: None,
            of_stretches: None,
            noisier: None,
            white: white(fit, pieces),
            rivals: Vec::new(),
            widen: (k / (k - 1.0)).sqrt(),
            student: student(k - 1.0),
        }
    }

    /// From draws of hovers that were made elsewhere, widened by what flights differ by beyond their hovers, as in
    /// [`Self::of_trajectories`].
    pub(super) fn of_hovers(
        count: usize,
        draws: Vec<Vec<f64>>,
        flights: usize,
        of_flights: Option<Vec<Vec<f64>>>,
    ) -> Self {
        let k = count as f64;
        let degrees = (PRIOR_FLIGHTS + flights as f64 - 1.0).min(k - 1.0);
        Self {
            blocks: ResamplingUnit::Hovers,
            count,
            flights,
            draws,
            of_flights,
            of_stretches: None,
            noisier: None,
            white: None,
            rivals: Vec::new(),
            widen: (k / (k - 1.0)).sqrt(),
            student: student(degrees),
        }
    }

    /// Of a fit by the likelihood of its trajectories: normal draws by Fisher's information, widened by what flights differ
    /// by beyond it.
    ///
    /// Flights that differ by more than their likelihood allows show what the model does not know. Their share of variance,
    /// from resampled flights, has few degrees of freedom; it is averaged with 1, the share of a true model, at the weight of
    /// [`PRIOR_FLIGHTS`], and never below 1. So more flights never know less.
    pub(super) fn of_trajectories(
        fit: &Fit,
        slopes: &[DVector<f64>],
        pieces: &[Segment],
        resamples: usize,
        seed: u64,
    ) -> Self {
        let flights = distinct(pieces.iter().map(|p| p.flight));
        let place = |p: &Segment| flights.iter().position(|f| *f == p.flight).unwrap_or(0);
        let of_piece: Vec<usize> = pieces.iter().map(place).collect();
        let count = flights.len();
        let degrees = PRIOR_FLIGHTS + count as f64 - 1.0;
        Self {
            blocks: ResamplingUnit::Trajectories,
            count,
            flights: count,
            draws: normal_draws(fit, 1.0, resamples, seed),
            of_flights: (count >= FEWEST)
                .then(|| block_draws(fit, &of_piece, count, resamples, seed)),
            of_stretches: stretch_draws(fit, slopes, resamples, seed),
            noisier: None,
            white: None,
            rivals: Vec::new(),
            widen: 1.0,
            student: student(degrees),
        }
    }

    /// With the numbers that heights of twice the noise gave: what they move by is a standard error beside the others.
    pub(super) fn beside_bias(self, noisier: Vec<f64>) -> Self {
        Self {
            noisier: Some(noisier),
            ..self
        }
    }

    /// With models of other curves: what they differ by is a standard error beside the others, at the weight of their
    /// probability.
    pub(super) fn beside_rivals(self, rivals: Vec<Rival>) -> Self {
        Self { rivals, ..self }
    }

    /// How many draws there are.
    pub(super) fn drawn(&self) -> usize {
        self.draws.len()
    }

    /// Too few runs to draw from: normal errors, with the correlation of neighbouring residuals.
    fn of_residuals(fit: &Fit, pieces: &[Segment], resamples: usize, seed: u64) -> Self {
        let inflation = correlation_inflation(fit, pieces).sqrt();
        let draws = normal_draws(fit, inflation, resamples, seed);
        Self {
            blocks: ResamplingUnit::Residuals,
            count: pieces.len(),
            flights: 1,
            draws,
            of_flights: None,
            of_stretches: None,
            noisier: None,
            white: white(fit, pieces),
            rivals: Vec::new(),
            widen: 1.0,
            student: 1.96,
        }
    }

    /// A function of the shared numbers with its uncertainty; `None` where a draw gives no number.
    ///
    /// Resampled flights do not show a bias that all of them have. Where a pilot answers disturbances, least squares are
    /// off by one, and the filter of [`super::coloured_noise`] takes it away, as far as its model of the disturbance holds. What is
    /// left is taken to be anything up to what it took away, Δ: a rectangular distribution of standard deviation Δ/√3
    /// (JCGM 100:2008, 4.3.7), beside that of the drawing. By what twice the noise of the heights moves a number, their own
    /// noise has moved it: that is a standard error more.
    #[must_use]
    pub fn estimate(&self, fit: &Fit, f: impl Fn(&[f64], &ModelValues) -> f64) -> Option<Estimate> {
        let value = f(&fit.theta, &fit.values());
        let variance = |draws: &[Vec<f64>]| {
            let of = |t: &Vec<f64>| f(t, &ModelValues::of(&fit.shape, t));
            let all: Vec<f64> = draws.iter().map(of).collect();
            let n = all.len() as f64;
            let mean = all.iter().sum::<f64>() / n;
            all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)
        };
        let mut sd = variance(&self.draws).sqrt();
        // Correlated innovations: slopes of stretches scatter by more than the likelihood allows.
        if let Some(of_stretches) = &self.of_stretches {
            sd = sd.max(variance(of_stretches).sqrt());
        }
        if let Some(of_flights) = self.of_flights.as_ref().filter(|_| sd > 0.0) {
            let degrees = self.flights as f64 - 1.0;
            let share = (degrees + 1.0) / degrees * variance(of_flights) / (sd * sd);
            let share = (PRIOR_FLIGHTS + degrees * share) / (PRIOR_FLIGHTS + degrees);
            sd *= share.max(1.0).sqrt();
        }
        let moved = |to: &Option<Vec<f64>>| {
            let of = |t: &Vec<f64>| f(t, &ModelValues::of(&fit.shape, t)) - value;
            to.as_ref().map_or(0.0, of)
        };
        let std_error = (sd * self.widen)
            .hypot(moved(&self.white) / 3.0_f64.sqrt())
            .hypot(moved(&self.noisier));
        let half = self.student * std_error;
        (value.is_finite() && half.is_finite()).then_some(Estimate {
            value,
            std_error,
            ci95: [value - half, value + half],
        })
    }

    /// A smooth function of the shared numbers that takes long to compute, by its slopes (the delta method).
    pub(super) fn smooth(&self, fit: &Fit, f: impl Fn(&[f64]) -> f64) -> Option<Estimate> {
        let value = f(&fit.theta);
        let n = self.draws.len() as f64;
        let slopes: Vec<f64> = (0..fit.theta.len())
            .map(|k| {
                let mean = self.draws.iter().map(|t| t[k]).sum::<f64>() / n;
                let square: f64 = self.draws.iter().map(|t| (t[k] - mean).powi(2)).sum();
                // Half a standard deviation to either side.
                let step = 0.5 * (square / n).sqrt();
                if step == 0.0 {
                    return 0.0;
                }
                let at = |by: f64| {
                    let mut there = fit.theta.clone();
                    there[k] += by;
                    f(&there)
                };
                (at(step) - at(-step)) / (2.0 * step)
            })
            .collect();
        let moved = |theta: &[f64]| -> f64 {
            let each = theta.iter().zip(&fit.theta).zip(&slopes);
            each.map(|((t, from), slope)| slope * (t - from)).sum()
        };
        self.estimate(fit, |theta, _| value + moved(theta))
    }

    /// A number by name with its uncertainty.
    #[must_use]
    pub fn number(&self, fit: &Fit, name: &str) -> Option<Estimate> {
        let index = fit.index(name)?;
        let found = self.estimate(fit, |theta, _| theta[index])?;
        // Numbers of a curve of its own have no counterpart in others.
        self.among_rivals(found, |rival| rival.value(name).unwrap_or(found.value))
    }

    /// A property of the model with its uncertainty.
    pub(super) fn of_model(&self, fit: &Fit, f: impl Fn(&ModelValues) -> f64) -> Option<Estimate> {
        let found = self.estimate(fit, |_, values| f(values))?;
        self.among_rivals(found, |rival| f(&rival.values()))
    }

    /// Widens an interval by what a rival finds; `None` where one finds no number.
    fn among_rivals(&self, found: Estimate, of: impl Fn(&Fit) -> f64) -> Option<Estimate> {
        let square = |r: &Rival| {
            let from = r.instead_of.as_ref().map_or(found.value, &of);
            r.probability * (of(&r.fit) - from).powi(2)
        };
        let variance: f64 = self.rivals.iter().map(square).sum();
        variance.is_finite().then(|| found.beside(variance.sqrt()))
    }
}

/// Draws of whole blocks with replacement, each solved by one Gauss–Newton step from the fit.
fn block_draws(
    fit: &Fit,
    of_piece: &[usize],
    count: usize,
    resamples: usize,
    seed: u64,
) -> Vec<Vec<f64>> {
    let n = fit.theta.len();
    let mut matrices = vec![DMatrix::zeros(n, n); count];
    let mut vectors = vec![DVector::zeros(n); count];
    for (reduced, &block) in fit.reduced.iter().zip(of_piece) {
        matrices[block] += &reduced.matrix;
        vectors[block] += &reduced.vector;
    }
    let (prior, pull) = prior(fit);
    let mut random = Pcg64::seed_from_u64(seed);
    (0..resamples)
        .filter_map(|_| {
            let (mut matrix, mut vector) = (prior.clone(), pull.clone());
            for _ in 0..count {
                let block = below(&mut random, count);
                matrix += &matrices[block];
                vector += &vectors[block];
            }
            hold(&mut matrix, &mut vector, &fit.held);
            Some(moved(fit, &matrix.cholesky()?.solve(&vector)))
        })
        .collect()
}

/// Draws of a normal distribution about the fit by the scatter of slopes between stretches of time (the sandwich of H. White,
/// Econometrica 50, 1982).
fn stretch_draws(
    fit: &Fit,
    slopes: &[DVector<f64>],
    resamples: usize,
    seed: u64,
) -> Option<Vec<Vec<f64>>> {
    let n = fit.theta.len();
    let (prior, _) = prior(fit);
    let mut total = fit.reduced.iter().fold(prior, |sum, r| sum + &r.matrix);
    hold(&mut total, &mut DVector::zeros(n), &fit.held);
    let inverse = total.try_inverse()?;
    let mut random = Pcg64::seed_from_u64(seed);
    // Each stretch's move, with a random sign and size: their sum has the covariance of the sandwich.
    let moves: Vec<DVector<f64>> = slopes
        .iter()
        .map(|s| {
            let mut s = s.clone();
            for &i in &fit.held {
                s[i] = 0.0;
            }
            &inverse * s
        })
        .collect();
    let draw = |_| {
        let mut sum = DVector::zeros(n);
        for step in &moves {
            let size: f64 = StandardNormal.sample(&mut random);
            sum.axpy(size, step, 1.0);
        }
        moved(fit, &sum)
    };
    Some((0..resamples).map(draw).collect())
}

/// Draws of a normal distribution about the fit, its standard deviations multiplied by `inflation`.
fn normal_draws(fit: &Fit, inflation: f64, resamples: usize, seed: u64) -> Vec<Vec<f64>> {
    let n = fit.theta.len();
    let (prior, _) = prior(fit);
    let mut total = fit.reduced.iter().fold(prior, |sum, r| sum + &r.matrix);
    hold(&mut total, &mut DVector::zeros(n), &fit.held);
    let mut random = Pcg64::seed_from_u64(seed);
    let root = total
        .try_inverse()
        .and_then(nalgebra::Matrix::cholesky)
        .map(|c| c.l());
    (0..resamples)
        .filter_map(|_| {
            let mut white = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
            for &i in &fit.held {
                white[i] = 0.0;
            }
            Some(moved(fit, &(root.as_ref()? * white * inflation)))
        })
        .collect()
}

/// The 97.5 % quantile of Student's t.
fn student(degrees: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |t| t.inverse_cdf(0.975))
}

fn white(fit: &Fit, pieces: &[Segment]) -> Option<Vec<f64>> {
    fit.colour?;
    let blind = Fit {
        colour: None,
        ..fit.clone()
    };
    let refit = super::fit::fit(pieces, fit.shape, Some(&blind)).settled(pieces);
    refit.converged.then_some(refit.theta)
}

fn distinct(values: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut all: Vec<usize> = values.collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Matrix and gradient of what is known beforehand.
pub(super) fn prior(fit: &Fit) -> (DMatrix<f64>, DVector<f64>) {
    let matrix = fit.prior();
    let parameters = fit.shape.parameters();
    let away = DVector::from_fn(fit.theta.len(), |i, _| parameters[i].start - fit.theta[i]);
    let vector = &matrix * away;
    (matrix, vector)
}

/// The numbers after a step, within their bounds.
pub(super) fn moved(fit: &Fit, step: &DVector<f64>) -> Vec<f64> {
    let parameters = fit.shape.parameters();
    (0..fit.theta.len())
        .map(|i| (fit.theta[i] + step[i]).clamp(parameters[i].min, parameters[i].max))
        .collect()
}

/// How much less information correlated residuals contain than as many independent ones: `1 + 2 Σ ρ_k`, summed up to the
/// first correlation that is not positive.
pub(super) fn correlation_inflation(fit: &Fit, pieces: &[Segment]) -> f64 {
    let residuals = fit.residuals(pieces);
    let product = |lag: usize| -> f64 {
        residuals
            .iter()
            .map(|r| {
                r.iter()
                    .zip(r.iter().skip(lag))
                    .map(|(a, b)| a * b)
                    .sum::<f64>()
            })
            .sum()
    };
    let power = product(0);
    let positive = (1..500)
        .map(|k| product(k) / power)
        .take_while(|r| *r > 0.0);
    1.0 + 2.0 * positive.sum::<f64>()
}

/// A number below `n`, each as likely but for one part in 2^64 / n.
pub(super) fn below(random: &mut Pcg64, n: usize) -> usize {
    (random.next_u64() % n as u64) as usize
}
