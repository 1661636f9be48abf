//! Fits that are made stable, and what the result says of it.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::StableCandidates;
use super::nearest::Fitted;
use crate::identify::conserve::Conserved;
use crate::identify::evidence::TermEvidence;
use crate::identify::regress::Statistics;
use crate::identify::run::IdentificationRun;
use crate::model::{Model, StabilityCertificate};
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::OutputErrorFit;

/// The least variance of an equation's errors, as a share of its mean square, as for invariants: slopes are not believed to
/// better than 0.1 %.
const LEAST: f64 = 1e-6;

/// Why all trajectories of the identified model stay bounded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    /// The proof.
    #[serde(flatten)]
    pub certificate: StabilityCertificate,
    /// Twice the log-likelihood that stability costs, in its quadratic approximation; 0 where the fit was stable as it was.
    pub lost: f64,
}

/// Coefficients of a fit that were moved: of the search's candidates.
#[derive(Clone, Debug)]
pub(in crate::identify) struct StableCoefficients {
    pub coefficients: Vec<f64>,
    /// Candidates of the search that were added.
    pub added: Vec<usize>,
    pub lost: f64,
}

impl StableCandidates {
    /// The nearest stable coefficients to those of a fit; `None` where it is stable as it is. `information` gives that of these
    /// candidates. `conserved` has the fields that the candidates of the search are.
    fn moved(
        &self,
        fit: &[f64],
        conserved: Option<&Conserved>,
        information: impl Fn(&[usize]) -> DMatrix<f64>,
    ) -> Option<Result<StableCoefficients, ()>> {
        let field = |j: usize| match conserved {
            Some(conserved) => conserved.fields[j].clone(),
            None => vec![(j, 1.0)],
        };
        let diagonal: Vec<usize> = (0..fit.len())
            .filter(|&j| matches!(field(j)[..], [(c, _)] if self.diagonal.contains(&c)))
            .collect();
        let mut kept: Vec<usize> = (0..fit.len()).filter(|&j| fit[j] != 0.0).collect();
        let mut added = Vec::new();
        for attempt in 0..2 {
            let forms: Vec<_> = kept.iter().map(|&j| self.form_of(&field(j))).collect();
            let own: Vec<usize> = (0..kept.len())
                .filter(|&k| diagonal.contains(&kept[k]))
                .collect();
            let fitted = Fitted {
                coefficients: &DVector::from_iterator(kept.len(), kept.iter().map(|&j| fit[j])),
                information: &information(&kept),
                forms: &forms,
                diagonal: &own,
                mean: &self.mean,
                rms: self.rms,
                slowest: self.slowest,
            };
            if attempt == 0 && fitted.is_stable() {
                return None;
            }
            if let Some(nearest) = fitted.nearest() {
                let mut coefficients = vec![0.0; fit.len()];
                for (&j, a) in kept.iter().zip(nearest.coefficients.iter()) {
                    coefficients[j] = *a;
                }
                return Some(Ok(StableCoefficients {
                    coefficients,
                    added,
                    lost: nearest.lost,
                }));
            }
            added = diagonal
                .iter()
                .copied()
                .filter(|j| !kept.contains(j))
                .collect();
            kept.extend(&added);
        }
        Some(Err(()))
    }
}

/// The information of these candidates of a search, from regressions with these coefficients.
fn of_regressions(from: &Statistics, coefficients: &[f64], kept: &[usize]) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(kept.len(), kept.len());
    let mut first = 0;
    for parts in &from.grams {
        let total = Gram::total(parts);
        let count = total.xty.len();
        let own = DVector::from_column_slice(&coefficients[first..first + count]);
        let weight = total.weight().max(1.0);
        let least = LEAST * total.yty / weight;
        let variance = (total.residual_sum(&own) / weight)
            .max(least)
            .max(f64::MIN_POSITIVE);
        for (a, &i) in kept.iter().enumerate() {
            for (b, &j) in kept.iter().enumerate() {
                let here = |k: usize| (first..first + count).contains(&k);
                if here(i) && here(j) {
                    out[(a, b)] = total.xtx[(i - first, j - first)] / variance * from.independent;
                }
            }
        }
        first += count;
    }
    out
}

impl IdentificationRun<'_> {
    /// The fit by output error with coefficients that are stable, and what was moved.
    pub(in crate::identify) fn stable_fit(
        &mut self,
        fit: &OutputErrorFit,
        from: &Statistics,
    ) -> Option<StableCoefficients> {
        let information = |kept: &[usize]| {
            let covariance = &fit.covariance;
            // Terms that were added have none.
            let whole =
                covariance.nrows() == kept.len() && covariance.iter().all(|v| v.is_finite());
            let root = whole.then(|| covariance.clone().cholesky()).flatten();
            let inverse = root.map(|root| root.inverse());
            match inverse {
                Some(inverse) => inverse / fit.correlation,
                None => of_regressions(from, &fit.coefficients, kept),
            }
        };
        self.moved(&fit.coefficients, information)
    }

    /// The same of a regression.
    pub(in crate::identify) fn stable_regression(
        &mut self,
        coefficients: &[f64],
        from: &Statistics,
    ) -> Option<StableCoefficients> {
        self.moved(coefficients, |kept| {
            of_regressions(from, coefficients, kept)
        })
    }

    fn moved(
        &mut self,
        coefficients: &[f64],
        information: impl Fn(&[usize]) -> DMatrix<f64>,
    ) -> Option<StableCoefficients> {
        let stable = self.stable.as_ref()?;
        match stable.moved(coefficients, self.conserved.as_ref(), information)? {
            Ok(moved) => {
                let added = self.added(&moved);
                if !added.is_empty() {
                    let states = self.data.states();
                    let name = |&c: &usize| &states[stable.forms[c].0];
                    let names: Vec<String> = added
                        .iter()
                        .map(|c| format!("`{0}` in {0}'", name(c)))
                        .collect();
                    self.warnings.push(format!(
                        "no coefficients of the chosen terms are stable: added are {}, whose sizes are those of a stable model nearby and have \
                         no errors",
                        names.join(", ")
                    ));
                }
                if moved.lost > TWENTY_TO_ONE {
                    self.warnings.push(format!(
                        "the data contradict that the system is stable: the nearest stable coefficients lose {:.1} of twice the \
                         log-likelihood ({TWENTY_TO_ONE:.1} are odds of 20 to 1). Check the data, what the library lacks, and whether \
                         the system is stable",
                        moved.lost
                    ));
                }
                Some(moved)
            }
            Err(()) => None,
        }
    }

    /// Coefficients of all candidate terms after the move. Those that were added have no standard error.
    pub(in crate::identify) fn with_added(
        &self,
        moved: &StableCoefficients,
        evidence: &mut [TermEvidence],
    ) -> Vec<f64> {
        for candidate in self.added(moved) {
            evidence[candidate].std_error = f64::INFINITY;
        }
        self.all_terms(&moved.coefficients)
    }

    /// A fit in candidate terms with the coefficients after the move. Standard errors stay those of the fit.
    pub(in crate::identify) fn with_moved(
        &self,
        fit: &OutputErrorFit,
        moved: &StableCoefficients,
    ) -> OutputErrorFit {
        let mut fit = fit.clone();
        fit.coefficients = self.all_terms(&moved.coefficients);
        for candidate in self.added(moved) {
            fit.std_errors[candidate] = f64::INFINITY;
        }
        fit
    }

    /// Coefficients of candidate terms from those of the search's candidates.
    fn all_terms(&self, of_search: &[f64]) -> Vec<f64> {
        match &self.conserved {
            Some(conserved) => conserved.terms(of_search),
            None => of_search.to_vec(),
        }
    }

    /// Candidate terms that were added.
    fn added(&self, moved: &StableCoefficients) -> Vec<usize> {
        let candidate = |&j: &usize| match &self.conserved {
            Some(conserved) => conserved.fields[j][0].0,
            None => j,
        };
        moved.added.iter().map(candidate).collect()
    }

    /// The certificate of the model, if a stable one was asked for and found.
    pub(in crate::identify) fn stability(&self, model: &Model, lost: f64) -> Option<Stability> {
        let stable = self.stable.as_ref()?;
        let n = self.data.states().len();
        let inputs = self.data.inputs().len();
        let row = |s: &crate::data::dataset::Stretch<'_>, k: usize| -> Vec<f64> {
            (0..inputs).map(|c| s.columns[n + c][k]).collect()
        };
        let rows: Vec<Vec<f64>> = match inputs {
            0 => Vec::new(),
            _ => self
                .stretches
                .iter()
                .flat_map(|s| (0..s.time.len()).map(move |k| row(s, k)))
                .collect(),
        };
        let found = model.stability_certificate(stable.mean.as_slice(), &rows);
        let certificate = found.ok()?.ok()?;
        Some(Stability { certificate, lost })
    }
}
