//! Selection of the model by cross-validation over flights.

mod motors;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::FlightSettings;
use super::fit::{ErrorSquares, Fit, fit, settle};
use super::lag::lag;
use super::model::{Curve, ModelTerms, Segment};
use super::normal::hold;
use super::resampling::{Resampling, moved, prior};
use crate::estimate::Estimate;

/// Errors beyond so many standard deviations of the plain model's count as that.
/// A row beyond it is an impact, not evidence. Half changes nothing; twice lets single rows add a drift (measured).
const CLIP: f64 = 4.0;
/// Twice the logarithm of a ratio of likelihoods that is very strong evidence (Kass & Raftery, "Bayes Factors", 1995).
/// Odds of 150 to 1. Half is odds of 12 to 1, which chance reaches among the many curves that are tried.
const VERY_STRONG: f64 = 10.0;

/// Error of one candidate on held-out flights.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// What it has beside the plain model.
    pub name: String,
    /// Its shape.
    pub shape: ModelTerms,
    /// Root mean square error on held-out flights, over all rows (g); absent where the likelihood of trajectories decided.
    pub rmse: Option<f64>,
    /// The same in ground effect; absent where no row is.
    pub rmse_near: Option<f64>,
    /// Twice the logarithm of its likelihood over that of the model before; absent where held-out flights decided.
    pub evidence: Option<f64>,
    /// Whether it was chosen.
    pub chosen: bool,
}

/// Squares on flights left out: flight by flight, `[all rows, rows in ground effect]`.
struct HeldOutErrors {
    of: Vec<[ErrorSquares; 2]>,
}

impl HeldOutErrors {
    fn rmse(&self, of: usize) -> f64 {
        let sum: f64 = self.of.iter().map(|s| s[of].plain).sum();
        let rows: f64 = self.of.iter().map(|s| s[of].rows).sum();
        (sum / rows).sqrt()
    }

    /// Mean and standard error, over flights, of how much greater our squares of prediction are than those of `other`.
    fn excess(&self, other: &Self, of: usize) -> (f64, f64) {
        let each: Vec<f64> = self
            .of
            .iter()
            .zip(&other.of)
            .filter(|(s, _)| s[of].rows > 0.0)
            .map(|(s, o)| s[of].white - o[of].white)
            .collect();
        let n = each.len() as f64;
        let mean = each.iter().sum::<f64>() / n;
        let sd = (each.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        (mean, sd / n.sqrt())
    }
}

/// Takes the flights out in turn (runs, where there are fewer than three flights).
fn unseen(fit: &Fit, pieces: &[Segment], near: f64, clip: f64) -> HeldOutErrors {
    let by_flight = pieces.iter().any(|p| p.flight >= 2);
    let of = |i: usize| if by_flight { pieces[i].flight } else { i };
    let many = (0..pieces.len()).map(of).max().map_or(0, |m| m + 1);
    let n = fit.theta.len();
    let (prior, _) = prior(fit);
    let total = fit
        .reduced
        .iter()
        .fold(prior, |sum: DMatrix<f64>, r| sum + &r.matrix);
    let mut out = HeldOutErrors {
        of: vec![[ErrorSquares::default(); 2]; many],
    };
    for out_of in 0..many {
        let mut matrix = total.clone();
        let mut vector = DVector::zeros(n);
        let held: Vec<usize> = (0..pieces.len()).filter(|&i| of(i) == out_of).collect();
        for &i in &held {
            matrix -= &fit.reduced[i].matrix;
            vector -= &fit.reduced[i].vector;
        }
        hold(&mut matrix, &mut vector, &fit.held);
        let Some(solved) = matrix.cholesky() else {
            continue;
        };
        let theta = moved(fit, &solved.solve(&vector));
        for &i in &held {
            let piece = &pieces[i];
            let from = fit.locals[i];
            let is_near = |k: usize| piece.height.get(k).is_some_and(|z| *z < near);
            let (local, all) = settle(piece, fit, &theta, from, clip, &|_| true);
            let (_, near) = settle(piece, fit, &theta, local, clip, &is_near);
            for (sum, more) in out.of[out_of].iter_mut().zip([all, near]) {
                sum.plain += more.plain;
                sum.white += more.white;
                sum.rows += more.rows;
            }
        }
    }
    out
}

/// A choice in the making.
pub(super) struct ModelSelection<'a> {
    pub(super) pieces: &'a [Segment],
    /// Heights below this are in ground effect, in R.
    near: f64,
    /// Greatest error of a row (gravities), the same for all candidates.
    clip: f64,
    /// The model so far.
    pub(super) best: Fit,
    unseen: HeldOutErrors,
    /// All that was tried.
    pub(super) tried: Vec<Candidate>,
}

impl<'a> ModelSelection<'a> {
    pub(super) fn start(pieces: &'a [Segment], shape: ModelTerms, near: f64) -> Self {
        let best = fit(pieces, shape, None);
        let clip = CLIP * best.sigma;
        let unseen = unseen(&best, pieces, near, clip);
        let mut out = Self {
            pieces,
            near,
            clip,
            best,
            unseen,
            tried: Vec::new(),
        };
        let candidate = out.candidate("plain", shape, &out.unseen, true);
        out.tried.push(candidate);
        out
    }

    fn candidate(
        &self,
        name: &str,
        shape: ModelTerms,
        unseen: &HeldOutErrors,
        chosen: bool,
    ) -> Candidate {
        Candidate {
            name: name.to_string(),
            shape,
            rmse: Some(unseen.rmse(0)),
            rmse_near: Some(unseen.rmse(1)).filter(|r| r.is_finite()),
            evidence: None,
            chosen,
        }
    }

    /// Accepts a richer shape if it predicts held-out flights better by more than one standard error of the difference.
    /// With fewer than two flights or armed intervals there is no cross-validation, and no term is added.
    pub(super) fn offer(&mut self, name: &str, shape: ModelTerms, near_only: bool) -> bool {
        self.offer_for(name, shape, near_only, 0.0)
    }

    /// The same for an effect that other terms approximate: it requires very strong evidence.
    pub(super) fn offer_sternly(&mut self, name: &str, shape: ModelTerms, near_only: bool) -> bool {
        self.offer_for(name, shape, near_only, VERY_STRONG)
    }

    fn offer_for(&mut self, name: &str, shape: ModelTerms, near_only: bool, least: f64) -> bool {
        let richer = fit(self.pieces, shape, Some(&self.best));
        let of_richer = unseen(&richer, self.pieces, self.near, self.clip);
        let (gain, error) = self.unseen.excess(&of_richer, usize::from(near_only));
        let take = richer.converged && gain > error && self.evidence(gain) > least;
        self.consider(name, richer, of_richer, take)
    }

    /// Accepts a poorer shape unless it predicts held-out flights worse by more than one standard error of the difference.
    pub(super) fn do_without(&mut self, name: &str, shape: ModelTerms, near_only: bool) -> bool {
        let poorer = fit(self.pieces, shape, Some(&self.best));
        let of_poorer = unseen(&poorer, self.pieces, self.near, self.clip);
        let (gain, error) = of_poorer.excess(&self.unseen, usize::from(near_only));
        let take = poorer.converged && !(gain > error);
        self.consider(name, poorer, of_poorer, take)
    }

    /// Records a candidate, and continues from it if it is accepted.
    fn consider(&mut self, name: &str, tried: Fit, unseen: HeldOutErrors, take: bool) -> bool {
        let candidate = self.candidate(name, tried.shape, &unseen, take);
        if take {
            for c in &mut self.tried {
                c.chosen = false;
            }
            (self.best, self.unseen) = (tried, unseen);
        }
        self.tried.push(candidate);
        take
    }

    /// Takes the curve that predicts flights left out best in ground effect, if that is better than the exponential, which
    /// is where we start, by more than one standard error and with very strong evidence. An exponential dies away and all
    /// others go with 1/z², which moves what flight out of ground effect is: a choice by chance would cost more than the
    /// curve near the ground gains.
    pub(super) fn curves(&mut self) {
        let of_curve = |curve, fountain_lag| ModelTerms {
            curve,
            fountain_lag,
            ..self.best.shape
        };
        let mut shapes = vec![
            of_curve(Curve::Empirical, false),
            of_curve(Curve::Rational, false),
            of_curve(Curve::Images, false),
        ];
        if self.best.shape.wake_lag {
            shapes.push(of_curve(Curve::Images, true));
        }
        let rivals: Vec<(Fit, HeldOutErrors)> = shapes
            .into_iter()
            .map(|shape| {
                let rival = fit(self.pieces, shape, Some(&self.best));
                let of_rival = unseen(&rival, self.pieces, self.near, self.clip);
                (rival, of_rival)
            })
            .collect();
        for (rival, of_rival) in &rivals {
            let name = match rival.shape.fountain_lag {
                true => "images and a lag of the fountain",
                false => rival.shape.curve.name(),
            };
            let candidate = self.candidate(name, rival.shape, of_rival, false);
            self.tried.push(candidate);
        }
        let of = |u: &HeldOutErrors| self.unseen.excess(u, 1).0;
        let best = rivals
            .into_iter()
            .filter(|(rival, _)| rival.converged)
            .max_by(|a, b| of(&a.1).total_cmp(&of(&b.1)));
        let Some((rival, of_rival)) = best else {
            return;
        };
        let (gain, error) = self.unseen.excess(&of_rival, 1);
        if gain > error && self.evidence(gain) > VERY_STRONG {
            for c in &mut self.tried {
                c.chosen = c.shape == rival.shape;
            }
            (self.best, self.unseen) = (rival, of_rival);
        }
    }

    /// Records a candidate that was judged by its likelihood.
    pub(super) fn note(&mut self, name: &str, shape: ModelTerms, evidence: f64, chosen: bool) {
        if chosen {
            for c in &mut self.tried {
                c.chosen = false;
            }
        }
        self.tried.push(Candidate {
            name: name.to_string(),
            shape,
            rmse: None,
            rmse_near: None,
            evidence: Some(evidence),
            chosen,
        });
    }

    /// Twice the logarithm of the likelihood ratio on held-out flights, from the mean gain of squares in a flight.
    fn evidence(&self, gain: f64) -> f64 {
        gain * self.unseen.of.len() as f64 / self.best.sigma.powi(2)
    }

    /// Changes to another shape without cross-validation.
    pub(super) fn replace(&mut self, name: &str, shape: ModelTerms, from: &Fit) {
        self.best = fit(self.pieces, shape, Some(from));
        self.unseen = unseen(&self.best, self.pieces, self.near, self.clip);
        for c in &mut self.tried {
            c.chosen = false;
        }
        let candidate = self.candidate(name, shape, &self.unseen, true);
        self.tried.push(candidate);
    }

    /// Adds the disturbance of the residuals to the model.
    pub(super) fn colour(&mut self) {
        self.best = self.best.coloured(self.pieces);
        self.unseen = unseen(&self.best, self.pieces, self.near, self.clip);
    }

    /// A number of the model so far.
    pub(super) fn estimate(&self, name: &str, settings: &FlightSettings) -> Option<Estimate> {
        Resampling::of(&self.best, self.pieces, settings.resamples, settings.seed)
            .number(&self.best, name)
    }

    /// The lag of the model so far.
    pub(super) fn lag(&self, settings: &FlightSettings) -> Option<Estimate> {
        let spread = Resampling::of(&self.best, self.pieces, settings.resamples, settings.seed);
        lag(&self.best, self.pieces, &spread)
    }
}
