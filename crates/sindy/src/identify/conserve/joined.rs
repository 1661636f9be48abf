//! Statistics of all equations as those of one, over the fields that keep the invariants.
//!
//! With the fields as columns of N, `ξ = N a`, and the variance σ_i² of the errors of equation i,
//!
//! ```text
//! Σ_i | y_i - Θ_i N_i a |² / σ_i²   =   aᵀ G a - 2 aᵀ b + c,     G = Σ_i N_iᵀ G_i N_i / σ_i²,  b = Σ_i N_iᵀ b_i / σ_i²
//! ```
//!
//! is a regression like any other. σ_i² is what the best subset of the equation alone leaves, so that the invariant, were it false,
//! does not hide in it.

use nalgebra::{DMatrix, DVector};

use super::Conserved;
use super::fields::Field;
use crate::error::SindyError;
use crate::identify::regress::{NODES, Statistics, signed_subsets};
use crate::solve::fit::Fit;
use crate::statistics::criteria::{Criterion, TWENTY_TO_ONE};
use crate::statistics::gram::Gram;

/// The least variance of an equation's errors, as a share of its mean square: errors of differentiation are systematic, so slopes are
/// not believed to better than 0.1 %. It also keeps the equations' weights within a factor of a million.
const LEAST: f64 = 1e-6;

/// Statistics over sums of columns: `Sᵀ G S`, `Sᵀ b`. They have no triangular factor.
pub(super) fn summed(gram: &Gram, sums: &DMatrix<f64>) -> Gram {
    Gram {
        xtx: sums.tr_mul(&(&gram.xtx * sums)),
        xty: sums.tr_mul(&gram.xty),
        triangle: None,
        ..gram.clone()
    }
}

/// The factors of candidates `first..first + count` in each field: count x fields.
fn factors(fields: &[Field], first: usize, count: usize) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(count, fields.len());
    for (column, field) in fields.iter().enumerate() {
        for &(candidate, factor) in field {
            if (first..first + count).contains(&candidate) {
                out[(candidate - first, column)] = factor;
            }
        }
    }
    out
}

/// The best subset of one equation alone, its score by the Bayesian criterion, and the variance of its errors.
struct Alone {
    fit: Fit,
    score: f64,
    variance: f64,
}

impl Alone {
    fn of(total: &Gram, independent: f64) -> Result<Self, SindyError> {
        let weight = total.weight().max(1.0);
        let rows = counted(total, independent, total.xty.len());
        let found = signed_subsets(total, &[], NODES)?;
        let fit = match total.xty.is_empty() {
            true => &found.sizes[0].fit,
            false => &found.choose(total, Criterion::Bic, Some(rows))?.fit,
        };
        let mean_square = total.yty / weight;
        let variance = (fit.residual_sum / weight).max(LEAST * mean_square);
        let variance = if variance > 0.0 { variance } else { 1.0 };
        let terms = (fit.terms() + 1) as f64;
        Ok(Self {
            score: rows * variance.ln() + terms * rows.ln(),
            fit: fit.clone(),
            variance,
        })
    }
}

/// Rows that count where errors of neighbours are correlated.
fn counted(total: &Gram, independent: f64, terms: usize) -> f64 {
    (total.rows as f64 * independent).max(2.0 * terms.max(1) as f64)
}

impl Conserved {
    /// Statistics over the fields, with what they were made from beside them.
    pub(in crate::identify) fn join(&self, of: Statistics) -> Result<Statistics, SindyError> {
        let blocks = of.grams.first().map_or(0, Vec::len);
        let mut joined = vec![Gram::zeros(self.fields.len()); blocks];
        let mut first = 0;
        for parts in &of.grams {
            let total = Gram::total(parts);
            let count = total.xty.len();
            let sums = factors(&self.fields, first, count);
            first += count;
            let weight = 1.0 / Alone::of(&total, of.independent)?.variance;
            for (all, part) in joined.iter_mut().zip(parts) {
                let mut own = summed(part, &sums);
                own.xtx *= weight;
                own.xty *= weight;
                own.yty *= weight;
                own.sum_y *= weight.sqrt();
                all.merge(&own);
            }
        }
        Ok(Statistics {
            smoothing: of.smoothing,
            grams: vec![joined],
            independent: of.independent,
            separate: of.grams,
        })
    }

    /// Root mean square of each field over the data: the largest over equations, as a share of the equation's slopes.
    pub(in crate::identify) fn field_rms(&self, from: &Statistics) -> Vec<f64> {
        let mut largest = vec![0.0_f64; self.fields.len()];
        let mut first = 0;
        for parts in &from.separate {
            let total = Gram::total(parts);
            let count = total.xty.len();
            let own = summed(&total, &factors(&self.fields, first, count));
            first += count;
            let slopes = total.target_rms() * total.weight().max(1.0).sqrt();
            for (largest, square) in largest.iter_mut().zip(own.xtx.diagonal().iter()) {
                *largest = largest.max(square.max(0.0).sqrt() / slopes);
            }
        }
        largest
    }

    /// The coefficients of best subsets of each equation that keep nothing, if they are more likely than these of all candidates by
    /// odds of 20 to 1.
    pub(super) fn likelier_alone(
        &self,
        from: &Statistics,
        fields: usize,
        coefficients: &[f64],
    ) -> Result<Option<Vec<f64>>, SindyError> {
        let (mut first, mut kept, mut free) = (0, 0.0, 0.0);
        let mut alone = Vec::new();
        let mut most: f64 = 1.0;
        for parts in &from.separate {
            let total = Gram::total(parts);
            let count = total.xty.len();
            let own = DVector::from_column_slice(&coefficients[first..first + count]);
            first += count;
            let rows = counted(&total, from.independent, count);
            let found = Alone::of(&total, from.independent)?;
            let weight = total.weight().max(1.0);
            let variance = (total.residual_sum(&own) / weight).max(LEAST * total.yty / weight);
            // The variance of the errors counts as a parameter in both.
            kept += rows * variance.max(f64::MIN_POSITIVE).ln() + rows.ln();
            free += found.score;
            most = most.max(rows);
            alone.extend(found.fit.coefficients.iter().copied());
        }
        kept += fields as f64 * most.ln();
        Ok((kept - free > TWENTY_TO_ONE).then_some(alone))
    }
}
