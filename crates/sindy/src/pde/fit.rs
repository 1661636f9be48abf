//! From the weak system of a field to its equation: terms, coefficients without the bias of noise, errors.

use nalgebra::{DMatrix, DVector};

use super::system::WeakField;
use crate::error::SindyError;
use crate::identify::regress::{FRONT_NODES, best_subsets, relevant};
use crate::solve::exact::BestSubsets;
use crate::statistics::criteria::{Criterion, evidence_for};
use crate::statistics::gram::Gram;
use crate::statistics::regression::pseudo_inverse;

/// The noise's covariance is subtracted only where the smallest eigenvalue of the scaled normal matrix keeps at least this share
/// of itself. Below it, the error of the subtraction is as large as the rest.
const LEFT: f64 = 0.2;
/// The share of a sum of squares that sums over windows lose to rounding.
const ROUNDING: f64 = 1e-15;
/// A residual above that of the noise counts at this many standard deviations: a level of 1 %.
const SURE: f64 = 2.326;

/// The equation of a field.
pub(super) struct FieldFit {
    /// Places of its terms among the candidates.
    pub(super) terms: Vec<usize>,
    pub(super) estimate: Estimate,
    /// By term, the evidence for it.
    pub(super) evidence: Vec<f64>,
    /// Independent windows less coefficients.
    pub(super) degrees: f64,
    /// The best subset of every size, with the bias of noise in them.
    pub(super) subsets: BestSubsets,
    /// The chosen terms among all candidates.
    pub(super) chosen: Vec<bool>,
}

/// Coefficients of given terms.
pub(super) struct Estimate {
    pub(super) coefficients: Vec<f64>,
    pub(super) std_errors: Vec<f64>,
    /// Root mean square of the residual over that which noise explains.
    pub(super) misfit: f64,
    /// Whether that is more than chance, at a level of 1 %.
    pub(super) misses: bool,
    /// The residual's share of the left side, as root mean squares.
    pub(super) unexplained: f64,
    /// Root mean square of the residual.
    pub(super) residual: f64,
    /// Whether the bias of noise was taken away.
    pub(super) corrected: bool,
    /// Twice the negative log-likelihood.
    cost: f64,
}

/// The search for the equations of all fields.
pub(super) struct Search<'a> {
    data: &'a [WeakField<'a>],
    /// The first quantities are candidates.
    candidates: usize,
    /// Covariances of the noise of all quantities, summed over windows.
    noise: DMatrix<f64>,
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
        let most = subsets.choose(&total, Criterion::Bic, Some(self.independent))?;
        let most = most.fit.terms();
        let mut found: Vec<(Vec<usize>, Estimate)> = Vec::new();
        for start in subsets.sizes.iter().filter(|s| s.fit.terms() <= most) {
            let start = relevant(&total, &start.fit, self.relevance);
            let terms = all.iter().copied().filter(|&j| start.support[j]).collect();
            let (terms, estimate) = self.without_doubtful(terms, target, &total);
            if !found.iter().any(|(t, _)| *t == terms) {
                found.push((terms, estimate));
            }
        }
        let penalty = evidence_for(0.0, 1.0, self.independent, self.candidates);
        let score = |(terms, estimate): &(Vec<usize>, Estimate)| {
            (
                !estimate.corrected,
                estimate.cost - penalty * terms.len() as f64,
            )
        };
        found.sort_by(|a, b| {
            let ((a, x), (b, y)) = (score(a), score(b));
            a.cmp(&b).then(x.total_cmp(&y))
        });
        // The subset of no terms is always among them.
        let (terms, estimate) = found.swap_remove(0);
        Ok(FieldFit {
            chosen: all.iter().map(|j| terms.contains(j)).collect(),
            evidence: self.evidence(&estimate),
            degrees: self.degrees(terms.len()),
            terms,
            estimate,
            subsets,
        })
    }

    fn degrees(&self, terms: usize) -> f64 {
        (self.independent - terms as f64).max(1.0)
    }

    fn evidence(&self, estimate: &Estimate) -> Vec<f64> {
        let terms = estimate.coefficients.iter().zip(&estimate.std_errors);
        let squares = terms.map(|(c, e)| (c / e.max(f64::MIN_POSITIVE)).powi(2));
        let degrees = self.degrees(estimate.coefficients.len());
        squares
            .map(|square| evidence_for(square, degrees, self.independent, self.candidates))
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

    /// Least squares on `terms`, less the bias of noise:
    ///
    /// ```text
    /// (Θᵀ Θ - N) ξ = Θᵀ y - n,     Cov ξ = (Θᵀ Θ - N)⁻¹ S (Θᵀ Θ - N)⁻¹
    /// ```
    ///
    /// with N and n the sums of the noise's covariances and S that of the scores. Where the residual is larger than the noise
    /// explains, errors grow with it, and are at least those of a residual that lies along the term.
    fn estimate(&self, terms: &[usize], target: usize, total: &Gram) -> Estimate {
        let s = terms.len();
        // Columns of unit size: their units may lie orders of magnitude apart.
        let size = |j: usize| total.xtx[(j, j)].sqrt().max(f64::MIN_POSITIVE);
        let scale = DVector::from_iterator(s, terms.iter().map(|&j| size(j)));
        let of = |m: &DMatrix<f64>| {
            DMatrix::from_fn(s, s, |a, b| m[(terms[a], terms[b])] / scale[a] / scale[b])
        };
        let whole = of(&total.xtx);
        let less = &whole - of(&self.noise);
        let least = |m: &DMatrix<f64>| m.clone().symmetric_eigenvalues().min();
        let corrected = s == 0 || least(&less) >= LEFT * least(&whole);
        let share = f64::from(u8::from(corrected));
        let right = DVector::from_fn(s, |a, _| {
            (total.xty[terms[a]] - share * self.noise[(terms[a], target)]) / scale[a]
        });
        let matrix = if corrected { less } else { whole };
        let inverse = pseudo_inverse(&matrix);
        let solution = (&inverse * right).component_div(&scale);
        let coefficients: Vec<f64> = solution.iter().copied().collect();

        let mut residual = vec![(target, 1.0)];
        residual.extend(terms.iter().zip(&coefficients).map(|(j, c)| (*j, -c)));
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
            .zip(&coefficients)
            .for_each(|(&j, c)| all[j] = *c);
        let left = total.residual_sum(&all).max(ROUNDING * total.yty);
        let square = left / expected.max(f64::MIN_POSITIVE);
        let misses = square > 1.0 + SURE * (2.0 / self.independent).sqrt();

        let scores = self
            .data
            .iter()
            .map(|d| d.score_covariance(terms, &residual));
        let scores = scores.fold(DMatrix::zeros(s, s), |sum, n| sum + n);
        let scores = DMatrix::from_fn(s, s, |a, b| scores[(a, b)] / scale[a] / scale[b]);
        let spread = &inverse * scores * &inverse;
        let error = |a: usize| {
            let own = spread[(a, a)].max(0.0) * square.max(1.0);
            let along = if misses {
                left * inverse[(a, a)].max(0.0)
            } else {
                0.0
            };
            own.max(along).sqrt() / scale[a]
        };
        // The left side in so few digits is no reason for a term.
        let floor = self.relevance * self.relevance * total.yty;
        let (left_or, expected_or) = (left + floor, (expected + floor).max(f64::MIN_POSITIVE));
        let variance = left_or.max(expected_or);
        Estimate {
            std_errors: (0..s).map(error).collect(),
            coefficients,
            misfit: square.sqrt(),
            misses,
            unexplained: (left / total.yty.max(f64::MIN_POSITIVE)).sqrt(),
            residual: (left / total.rows.max(1) as f64).sqrt(),
            corrected,
            cost: self.independent * (variance.ln() + left_or / variance),
        }
    }
}
