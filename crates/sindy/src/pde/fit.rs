//! From the weak system of a field to its equation: terms, coefficients without the bias of noise, errors.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::alternatives::HiddenTerm;
use super::blocks::BlockCovariance;
use super::system::WeakField;
use crate::error::SindyError;
use crate::identify::regress::{FRONT_NODES, best_subsets, relevant};
use crate::solve::exact::BestSubsets;
use crate::statistics::criteria::{Criterion, evidence_for};
use crate::statistics::gram::Gram;
use crate::statistics::regression::{Refits, pseudo_inverse};

/// The noise's covariance is subtracted only where the smallest eigenvalue of the scaled normal matrix keeps at least this share
/// of itself. Below it, the error of the subtraction is as large as the rest.
const LEFT: f64 = 0.2;
/// The share of a sum of squares that sums over windows lose to rounding.
const ROUNDING: f64 = 1e-15;
/// Terms that explain more than this share of the left side's sum of squares explain most of it.
pub(super) const MOST: f64 = 0.5;
/// A residual below this share of the left side is the error of sums and of the data's own digits.
pub(super) const SMALL: f64 = 1e-4;
/// A residual above that of the noise counts at this many standard deviations: a level of 1 %.
pub(super) const SURE: f64 = 2.326;

/// The equation of a field.
pub(super) struct FieldFit {
    /// Places of its terms among the candidates.
    pub(super) terms: Vec<usize>,
    pub(super) estimate: Estimate,
    /// By term, the evidence for it.
    pub(super) evidence: Vec<f64>,
    pub(super) preferred: Preferred,
    /// The best subset of every size, with the bias of noise in them.
    pub(super) subsets: BestSubsets,
    /// The other candidates, the one that could contribute most first.
    pub(super) hidden: Vec<HiddenTerm>,
    /// Other terms that explain the data about as well, best first.
    pub(super) rivals: Vec<Vec<usize>>,
}

/// The best subset by the Bayesian criterion, of terms that need not be certain.
pub(super) struct Preferred {
    pub(super) terms: Vec<usize>,
    /// Its share of the left side's sum of squares.
    pub(super) explained: f64,
}

/// Coefficients of given terms.
pub(super) struct Estimate {
    pub(super) coefficients: Vec<f64>,
    pub(super) std_errors: Vec<f64>,
    /// Degrees of freedom of these errors: independent windows less coefficients, or blocks less one.
    pub(super) degrees: f64,
    /// Root mean square of the residual over that which noise explains.
    pub(super) misfit: f64,
    /// Whether that is more than chance, at a level of 1 %.
    pub(super) misses: bool,
    /// The residual's share of the left side, as root mean squares.
    pub(super) unexplained: f64,
    /// Root mean square of the residual.
    pub(super) residual: f64,
    /// The sum of squares that noise does not explain.
    beyond: f64,
    /// Whether the bias of noise was taken away.
    pub(super) corrected: bool,
    /// Twice the negative log-likelihood.
    cost: f64,
}

impl Estimate {
    /// Whether the residual is noise, or less than half of what noise does not explain of the left side, `signal`. Terms that
    /// are significant and explain less than that replace others that are not in the library.
    fn explains_most(&self, signal: f64) -> bool {
        !self.misses || self.beyond <= (1.0 - MOST) * signal
    }
}

/// The search for the equations of all fields.
pub(super) struct Search<'a> {
    data: &'a [WeakField<'a>],
    /// The first quantities are candidates.
    pub(super) candidates: usize,
    /// Covariances of the noise of all quantities, summed over windows.
    pub(super) noise: DMatrix<f64>,
    /// Independent windows.
    independent: f64,
    /// Terms below this share of the largest are left out, and so much of the left side is not worth a term.
    relevance: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(data: &'a [WeakField<'a>], candidates: usize, relevance: f64) -> Self {
        let noise = data.iter().map(WeakField::noise).reduce(|sum, n| sum + n);
        Self {
            data,
            candidates,
            noise: noise.unwrap_or_else(|| DMatrix::zeros(0, 0)),
            independent: data
                .iter()
                .map(WeakField::independent)
                .sum::<f64>()
                .max(2.0),
            relevance,
        }
    }

    /// Finds the equation whose left side has the place `target` among the quantities.
    ///
    /// The search starts from the best subset of each size. Terms that are more likely absent than not are removed from each
    /// subset. Of the models that remain, the one with the best penalised likelihood is taken. Models whose bias by noise can be
    /// subtracted come first, because that bias adds false terms.
    pub(super) fn find(&self, target: usize) -> Result<FieldFit, SindyError> {
        let all: Vec<usize> = (0..self.candidates).collect();
        let grams: Vec<Gram> = self.data.iter().map(|d| d.gram(&all, target)).collect();
        let total = Gram::total(&grams);
        let subsets = best_subsets(&total, FRONT_NODES)?;
        let preferred = subsets.choose(&total, Criterion::Bic, Some(self.independent))?;
        let most = preferred.fit.terms();
        let preferred = Preferred {
            terms: all
                .iter()
                .copied()
                .filter(|&j| preferred.fit.support[j])
                .collect(),
            explained: 1.0 - preferred.fit.residual_sum / total.yty.max(f64::MIN_POSITIVE),
        };
        let mut refits = Refits::new(&total, Arc::default());
        let mut starts: Vec<Vec<usize>> = Vec::new();
        for start in subsets.sizes.iter().filter(|s| s.fit.terms() <= most) {
            let start = relevant(&mut refits, &start.fit, self.relevance);
            let terms = all.iter().copied().filter(|&j| start.support[j]).collect();
            if !starts.contains(&terms) {
                starts.push(terms);
            }
        }
        let mut found: Vec<(Vec<usize>, Estimate)> = Vec::new();
        for terms in starts {
            let (terms, estimate) = self.without_doubtful(terms, target, &total);
            if !found.iter().any(|(t, _)| *t == terms) {
                found.push((terms, estimate));
            }
        }
        let of_noise = self.noise[(target, target)];
        found.retain(|(terms, e)| terms.is_empty() || e.explains_most(total.yty - of_noise));
        let score = |(terms, estimate): &(Vec<usize>, Estimate)| {
            let score = estimate.cost + self.penalty() * terms.len() as f64;
            (!estimate.corrected, score)
        };
        found.sort_by(|a, b| {
            let ((a, x), (b, y)) = (score(a), score(b));
            a.cmp(&b).then(x.total_cmp(&y))
        });
        // The subset of no terms is always among them.
        let (terms, estimate) = found.remove(0);
        let others = found.into_iter().map(|(terms, _)| terms).collect();
        Ok(FieldFit {
            hidden: self.hidden(&terms, &estimate, target, &total),
            rivals: self.rivals(&terms, others, target, &total),
            evidence: self.evidence(&estimate),
            terms,
            estimate,
            preferred,
            subsets,
        })
    }

    /// What a term has to lower the cost by.
    pub(super) fn penalty(&self) -> f64 {
        -evidence_for(0.0, 1.0, self.independent, self.candidates)
    }

    pub(super) fn degrees(&self, terms: usize) -> f64 {
        (self.independent - terms as f64).max(1.0)
    }

    fn evidence(&self, estimate: &Estimate) -> Vec<f64> {
        let terms = estimate.coefficients.iter().zip(&estimate.std_errors);
        let squares = terms.map(|(c, e)| (c / e.max(f64::MIN_POSITIVE)).powi(2));
        squares
            .map(|square| evidence_for(square, estimate.degrees, self.independent, self.candidates))
            .collect()
    }

    fn without_doubtful(
        &self,
        mut terms: Vec<usize>,
        target: usize,
        total: &Gram,
    ) -> (Vec<usize>, Estimate) {
        loop {
            let estimate = self.estimate(&terms, target, total);
            let evidence = self.evidence(&estimate);
            let least = (0..terms.len()).min_by(|&a, &b| evidence[a].total_cmp(&evidence[b]));
            match least.filter(|&a| evidence[a] < 0.0) {
                Some(least) => terms.remove(least),
                None => return (terms, estimate),
            };
        }
    }

    /// The covariance of the scores of `terms`, from the noise in `residual`.
    pub(super) fn score_covariance(
        &self,
        terms: &[usize],
        residual: &[(usize, f64)],
    ) -> DMatrix<f64> {
        let parts = self.data.iter();
        let parts = parts.map(|d| d.score_covariance(terms, residual));
        parts.fold(DMatrix::zeros(terms.len(), terms.len()), |sum, n| sum + n)
    }

    /// Least squares on `terms`, less the bias of noise:
    ///
    /// ```text
    /// (Θᵀ Θ - N) ξ = Θᵀ y - n,     Cov ξ = (Θᵀ Θ - N)⁻¹ S (Θᵀ Θ - N)⁻¹
    /// ```
    ///
    /// with N and n the sums of the noise's covariances and S that of the scores. Where the residual is larger than the noise
    /// explains, errors grow with it, and are at least those that scores show by their scatter between distant blocks of windows.
    fn estimate(&self, terms: &[usize], target: usize, total: &Gram) -> Estimate {
        let normal = NormalEquations::new(terms, target, total, &self.noise);
        let coefficients = normal.coefficients();
        let residual = residual_of(target, terms, &coefficients);
        let Residual {
            left,
            expected,
            cost,
        } = self.residual(terms, &coefficients, target, total);
        let square = left / expected.max(f64::MIN_POSITIVE);
        let misses = square > 1.0 + SURE * (2.0 / self.independent).sqrt();

        let own: Vec<usize> = (0..terms.len()).collect();
        let white = normal.spread(&self.score_covariance(terms, &residual), &own);
        let unexplained = (left / total.yty.max(f64::MIN_POSITIVE)).sqrt();
        let blocks = BlockCovariance::new(self.data, terms, &residual)
            .filter(|_| misses && unexplained > SMALL);
        let seen = blocks.as_ref().map(|b| normal.spread(&b.covariance, &own));
        let error = |a: usize| {
            let white = white[(a, a)].max(0.0) * square.max(1.0);
            let seen = match &seen {
                Some(seen) => seen[(a, a)],
                // The error of sums and digits is no noise, and some windows are too few for blocks: a residual along the term.
                None if misses => left * normal.inverse[(a, a)].max(0.0),
                None => 0.0,
            };
            white.max(seen).sqrt() / normal.scale[a]
        };
        let degrees = self.degrees(terms.len());
        Estimate {
            degrees: blocks.map_or(degrees, |b| b.degrees.min(degrees)),
            std_errors: (0..terms.len()).map(error).collect(),
            coefficients,
            misfit: square.sqrt(),
            misses,
            unexplained,
            residual: (left / total.rows.max(1) as f64).sqrt(),
            beyond: left - expected,
            corrected: normal.corrected,
            cost,
        }
    }

    /// What terms with these coefficients leave of the left side.
    pub(super) fn residual(
        &self,
        terms: &[usize],
        coefficients: &[f64],
        target: usize,
        total: &Gram,
    ) -> Residual {
        let residual = residual_of(target, terms, coefficients);
        let mut expected = 0.0;
        for (j, a) in &residual {
            expected += residual
                .iter()
                .map(|(l, b)| a * b * self.noise[(*j, *l)])
                .sum::<f64>();
        }
        let mut all = DVector::zeros(self.candidates);
        terms
            .iter()
            .zip(coefficients)
            .for_each(|(&j, c)| all[j] = *c);
        let left = total.residual_sum(&all).max(ROUNDING * total.yty);
        // The left side in so few digits is no reason for a term.
        let floor = self.relevance * self.relevance * total.yty;
        let (left_or, expected_or) = (left + floor, (expected + floor).max(f64::MIN_POSITIVE));
        let variance = left_or.max(expected_or);
        Residual {
            left,
            expected,
            cost: self.independent * (variance.ln() + left_or / variance),
        }
    }
}

/// Sums of squares over the windows, and what they are worth.
pub(super) struct Residual {
    left: f64,
    /// What noise explains.
    expected: f64,
    /// Twice the negative log-likelihood.
    pub(super) cost: f64,
}

/// What is left of the left side: quantities and their coefficients.
pub(super) fn residual_of(
    target: usize,
    terms: &[usize],
    coefficients: &[f64],
) -> Vec<(usize, f64)> {
    let mut residual = vec![(target, 1.0)];
    residual.extend(terms.iter().zip(coefficients).map(|(j, c)| (*j, -c)));
    residual
}

/// Normal equations of some terms, less the bias of noise where that can be taken away, with columns of unit size: the units
/// of terms may lie orders of magnitude apart.
pub(super) struct NormalEquations {
    /// Sizes of the columns.
    scale: DVector<f64>,
    inverse: DMatrix<f64>,
    /// Coefficients times `scale`.
    pub(super) solution: DVector<f64>,
    pub(super) corrected: bool,
}

impl NormalEquations {
    pub(super) fn new(terms: &[usize], target: usize, total: &Gram, noise: &DMatrix<f64>) -> Self {
        let s = terms.len();
        let size = |j: usize| total.xtx[(j, j)].sqrt().max(f64::MIN_POSITIVE);
        let scale = DVector::from_iterator(s, terms.iter().map(|&j| size(j)));
        let of = |m: &DMatrix<f64>| {
            DMatrix::from_fn(s, s, |a, b| m[(terms[a], terms[b])] / scale[a] / scale[b])
        };
        let whole = of(&total.xtx);
        let less = &whole - of(noise);
        let least = |m: &DMatrix<f64>| m.clone().symmetric_eigenvalues().min();
        let corrected = s == 0 || least(&less) >= LEFT * least(&whole);
        let share = f64::from(u8::from(corrected));
        let right = DVector::from_fn(s, |a, _| {
            (total.xty[terms[a]] - share * noise[(terms[a], target)]) / scale[a]
        });
        let inverse = pseudo_inverse(if corrected { &less } else { &whole });
        Self {
            solution: &inverse * right,
            inverse,
            scale,
            corrected,
        }
    }

    pub(super) fn coefficients(&self) -> Vec<f64> {
        let found = self.solution.component_div(&self.scale);
        found.iter().copied().collect()
    }

    /// The covariance of `solution` from that of the scores, in which the terms have the places `own`.
    pub(super) fn spread(&self, scores: &DMatrix<f64>, own: &[usize]) -> DMatrix<f64> {
        let s = own.len();
        let scores = DMatrix::from_fn(s, s, |a, b| {
            scores[(own[a], own[b])] / self.scale[a] / self.scale[b]
        });
        &self.inverse * scores * &self.inverse
    }
}
