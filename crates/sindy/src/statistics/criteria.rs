//! Information criteria and Bayesian evidence of a least-squares fit, from the Gram statistics.
//!
//! With `n` rows, `k` terms and residual sum of squares `R`, and `K = k + 1` (the noise variance counts):
//!
//! ```text
//! AIC  = n ln(R/n) + 2 K
//! AICc = AIC + 2 K (K + 1) / (n - K - 1)        infinite where n <= K + 1
//! BIC  = n ln(R/n) + K ln n
//! ```
//!
//! The evidence is the probability of the data after the coefficients are integrated out, with a normal
//! prior of one width on the coefficients of the (unit root mean square) columns and normal noise; both
//! variances are those that make it largest (Minka's and MacKay's type-II maximum likelihood):
//!
//! ```text
//! ln p(y) = n/2 ln(n/S) - n/2 (1 + ln 2π) - 1/2 Σ ln(1 + γ_i/ρ),    S = min over ξ  |y - Θ ξ|² + ρ |ξ|²
//! ```
//!
//! over the ratio ρ of noise variance to prior variance, γ the eigenvalues of the scaled Gram matrix.
//!
//! All four assume independent errors. Errors of a time series are correlated, and then `n` rows hold as
//! much as fewer: give that number as `effective_rows`, and the sums are scaled to it.
//!
//! `R` cannot be resolved below the rounding of `yᵀ y`, about 4e-15 (p + 1) of it, and is not taken to be
//! smaller.
//!
//! Sources: K. P. Burnham, D. R. Anderson, "Model Selection and Multimodel Inference" (2002);
//! G. Schwarz, Annals of Statistics 6 (1978); D. J. C. MacKay, Neural Computation 4 (1992).

use nalgebra::{DMatrix, DVector};

use crate::error::{SindyError, above_zero, same_size};
use crate::numerics::golden_section;
use crate::statistics::gram::Gram;
use crate::statistics::normal::{Factor, Normal};

/// What models are compared by. A smaller score is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// Akaike's criterion.
    Aic,
    /// Akaike's criterion, corrected for few rows.
    Aicc,
    /// The Bayesian (Schwarz) criterion.
    Bic,
    /// Bayesian evidence; the score is `-2 ln p(y)`.
    Evidence,
}

impl Criterion {
    /// The score of the least-squares fit of `gram` on `support`; smaller is better. `effective_rows`
    /// replaces the number of rows where errors are correlated.
    ///
    /// # Errors
    /// Statistics that no solver can use ([`check`](crate::statistics::gram::check)), a support of another length,
    /// `effective_rows` not positive.
    pub fn score(
        self,
        gram: &Gram,
        support: &[bool],
        effective_rows: Option<f64>,
    ) -> Result<f64, SindyError> {
        let normal = Normal::new(gram)?;
        same_size("entries of the support", normal.p, support.len())?;
        let rows = rows(gram, effective_rows)?;
        let index: Vec<usize> = (0..normal.terms.len())
            .filter(|&j| support[normal.terms[j]])
            .collect();
        let terms = support.iter().filter(|s| **s).count();
        Ok(self.of_subset(&normal, &index, terms, rows))
    }

    /// The score of a subset of the columns of `normal`, counted as `terms` terms.
    pub(crate) fn of_subset(
        self,
        normal: &Normal,
        index: &[usize],
        terms: usize,
        rows: f64,
    ) -> f64 {
        if self == Self::Evidence {
            return -2.0 * log_evidence(normal, index, rows);
        }
        let mut factor = Factor::new(index.len());
        let mut used: Vec<usize> = Vec::with_capacity(index.len());
        for &j in index {
            // A column that depends on those before explains nothing more.
            if factor.push(
                |c| normal.g[(j, used.get(c).copied().unwrap_or(j))],
                normal.b[j],
            ) {
                used.push(j);
            }
        }
        self.of_share(normal, 1.0 - factor.explained(), terms, rows)
    }

    /// The score for a residual that is the given share of `yᵀ y` (not for [`Criterion::Evidence`],
    /// which needs more than the residual).
    pub(crate) fn of_share(self, normal: &Normal, share: f64, terms: usize, rows: f64) -> f64 {
        let mean_square = share.max(normal.floor) * normal.unit * normal.weight;
        let k = (terms + 1) as f64;
        let fit = rows * mean_square.ln();
        match self {
            Self::Aic => fit + 2.0 * k,
            Self::Bic => fit + k * rows.ln(),
            _ if rows > k + 1.0 => fit + 2.0 * k + 2.0 * k * (k + 1.0) / (rows - k - 1.0),
            _ => f64::INFINITY,
        }
    }
}

/// Twice the logarithm of odds of 20 to 1: models whose scores differ by less are about as likely, and are told.
pub(crate) const TWENTY_TO_ONE: f64 = 5.991_464_547_107_98;

/// The number of rows that criteria use.
pub(crate) fn rows(gram: &Gram, effective_rows: Option<f64>) -> Result<f64, SindyError> {
    match effective_rows {
        None => Ok(gram.effective_rows()),
        Some(n) => above_zero("effective_rows", n),
    }
}

/// Width in `ln ρ` to which the evidence's maximum is narrowed. Its square is far below rounding of the evidence: a width
/// ten times as large changes no digit.
const NARROW: f64 = 1e-9;

/// `ln p(y)` with both variances at their most probable values.
fn log_evidence(normal: &Normal, index: &[usize], rows: f64) -> f64 {
    let k = index.len();
    let (gamma, q2): (Vec<f64>, Vec<f64>) = if k == 0 {
        (vec![], vec![])
    } else {
        let b = DVector::from_fn(k, |i, _| normal.b[index[i]]);
        let g = DMatrix::from_fn(k, k, |i, c| normal.g[(index[i], index[c])]);
        let eigen = g.symmetric_eigen();
        let q = eigen.eigenvectors.tr_mul(&b);
        eigen
            .eigenvalues
            .iter()
            .zip(q.iter())
            .map(|(l, q)| (l.max(0.0), q * q))
            .unzip()
    };
    // With columns and target of unit length S/n and γ/ρ do not change if ρ is taken relative to n.
    let value = |ln_rho: f64| {
        let rho = ln_rho.exp();
        let explained: f64 = gamma.iter().zip(&q2).map(|(l, q)| q / (l + rho)).sum();
        let occam: f64 = gamma.iter().map(|l| (l / rho).ln_1p()).sum();
        -0.5 * (rows * (1.0 - explained).max(normal.floor).ln() + occam)
    };
    // One hump as a rule, but not always: the best point of a coarse grid, then golden section.
    let grid = |i: i32| f64::from(i) * std::f64::consts::LN_10 - 0.5 * rows.ln();
    let best = (-16..=16)
        .max_by(|&a, &b| value(grid(a)).total_cmp(&value(grid(b))))
        .unwrap_or(0);
    let around = [grid(best - 1), grid(best + 1)];
    let [low, high] = golden_section(around, |a, b| b - a > NARROW, |x| -value(x));
    let constant = (2.0 * std::f64::consts::PI * normal.unit * normal.weight).ln();
    value(0.5 * (low + high)) - 0.5 * rows * (1.0 + constant)
}

/// The evidence for a term: twice the fall of the log-likelihood without it, less the penalty for it.
///
/// Worth and error are one thing seen twice: with z the coefficient over its error on d degrees of freedom, dropping the
/// term costs `(d + 1) ln(1 + z²/d)` in twice the log-likelihood. The penalty is `ln N + 2 ln P` for N independent rows, as in
/// the output error: each of the P candidates had its chance to look like a term.
pub(crate) fn evidence_for(square: f64, degrees: f64, rows: f64, candidates: usize) -> f64 {
    let penalty = rows.ln() + 2.0 * (candidates as f64).ln();
    (degrees + 1.0) * (square / degrees).ln_1p() - penalty
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::normal::tests::{random_gram, reference};

    fn support(index: &[usize]) -> Vec<bool> {
        (0..6).map(|j| index.contains(&j)).collect()
    }

    #[test]
    fn xval_criteria_of_numpy_and_evidence_of_scipy() {
        // NumPy 2.4: residuals of `lstsq` in the formulas above. SciPy 1.17: the density of y, normal with
        // covariance σ² I + τ² Θ Θᵀ (columns divided by their root mean square), made as large as
        // possible over (σ, τ) by Nelder-Mead on the dense 60 x 60 matrix.
        let gram = reference();
        let cases: [(&[usize], [f64; 4]); 6] = [
            (
                &[],
                [
                    -29.405726817885736,
                    -29.336761300644355,
                    -27.311382255663634,
                    -69.43344858333747,
                ],
            ),
            (
                &[0],
                [
                    -29.4746975472774,
                    -29.26417123148793,
                    -25.2860084228332,
                    -69.26694431804262,
                ],
            ),
            (
                &[3],
                [
                    -51.058999099362445,
                    -50.84847278357297,
                    -46.87030997491824,
                    -59.78616200120377,
                ],
            ),
            (
                &[0, 1, 4, 5],
                [
                    -345.74306212544025,
                    -344.63195101432916,
                    -335.27133931432974,
                    73.8802017712922,
                ],
            ),
            (
                &[0, 1, 2, 4, 5],
                [
                    -396.3585394396974,
                    -394.77363377932005,
                    -383.7924720663648,
                    93.65066576534969,
                ],
            ),
            (
                &[0, 1, 2, 3, 4, 5],
                [
                    -394.67790178877067,
                    -392.52405563492454,
                    -380.017489853216,
                    89.53693575825798,
                ],
            ),
        ];
        for (index, [aic, aicc, bic, evidence]) in cases {
            let score = |c: Criterion| c.score(&gram, &support(index), None).unwrap();
            // Residual shares down to 1e-3 lose three digits of sixteen, times 60 rows.
            assert!((score(Criterion::Aic) - aic).abs() < 1e-9);
            assert!((score(Criterion::Aicc) - aicc).abs() < 1e-9);
            assert!((score(Criterion::Bic) - bic).abs() < 1e-9);
            // Nelder-Mead stops within 1e-12 of its maximum, which is flat there.
            assert!((score(Criterion::Evidence) + 2.0 * evidence).abs() < 1e-8);
        }
    }

    #[test]
    fn analytic_fewer_effective_rows_weigh_the_fit_less() {
        let gram = reference();
        let s = support(&[0, 1, 5]);
        let full = Criterion::Aic.score(&gram, &s, None).unwrap();
        let half = Criterion::Aic.score(&gram, &s, Some(30.0)).unwrap();
        // n ln(R/n) is proportional to n, 2 K is not: K = 4.
        assert!((half - (0.5 * (full - 8.0) + 8.0)).abs() < 1e-10);
        assert!(Criterion::Aic.score(&gram, &s, Some(0.0)).is_err());
        assert!(Criterion::Aic.score(&gram, &[true], None).is_err());
        assert_eq!(
            Criterion::Aicc.score(&gram, &s, Some(5.0)).unwrap(),
            f64::INFINITY
        );
    }

    #[test]
    fn prop_exact_targets_and_repeated_columns_give_finite_scores() {
        // No noise at all: the residual is rounding, and one more term must not look better.
        let gram = random_gram(6, 80, &[1.0, -2.0, 0.0], 0.4, 0.0);
        let twice = Gram {
            xtx: DMatrix::from_element(2, 2, 4.0),
            xty: DVector::from_element(2, 3.0),
            yty: 5.0,
            ..Gram::zeros(2)
        };
        let twice = Gram { rows: 10, ..twice };
        for c in [
            Criterion::Aic,
            Criterion::Aicc,
            Criterion::Bic,
            Criterion::Evidence,
        ] {
            let two = c.score(&gram, &[true, true, false], None).unwrap();
            let three = c.score(&gram, &[true; 3], None).unwrap();
            assert!(two.is_finite() && two < three, "{c:?}: {two} {three}");
            let one = c.score(&twice, &[true, false], None).unwrap();
            let both = c.score(&twice, &[true, true], None).unwrap();
            // The same model with more terms: never better (evidence: the prior merely widens).
            assert!(one.is_finite() && both >= one - 1e-9, "{c:?}: {one} {both}");
        }
    }
}
