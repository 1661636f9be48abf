//! From what was found to a model that says how sure it is.

use super::certainty::{Certainty, certainty, intervals};
use super::regress::{FRONT_NODES, Statistics, best_subsets};
use super::run::{CORRELATED, FOLLOWS, Followed, Ranked, Run};
use super::{Candidate, Choice, Equation, FrontPoint, Identification, ratio};
use crate::error::SindyError;
use crate::model::{Model, Term};
use crate::solve::outcome::Outcome;
use crate::statistics::gram::Gram;

impl Run<'_> {
    /// A model from the coefficients of all candidates and how sure they are.
    fn model(&self, coefficients: &[f64], sure: &[Certainty]) -> Result<Model, SindyError> {
        let mut at = 0;
        let mut equations = Vec::new();
        for library in &self.libraries {
            let mut terms = Vec::new();
            for term in library.terms() {
                if coefficients[at] != 0.0 {
                    let Certainty {
                        std_error,
                        evidence,
                        ..
                    } = sure[at];
                    // Odds are exp(Δ/2) for twice the log-likelihood that the term is worth.
                    let inclusion = 1.0 / (1.0 + (-0.5 * evidence).exp());
                    let mut kept =
                        Term::new(term.clone(), coefficients[at]).with_inclusion(inclusion);
                    if std_error.is_finite() {
                        kept = kept.with_std_error(std_error);
                    }
                    terms.push(kept);
                }
                at += 1;
            }
            equations.push(terms);
        }
        Model::new(self.time, self.data.states(), self.data.inputs(), equations)
    }

    fn candidates(ranked: &[Ranked]) -> Vec<Candidate> {
        ranked
            .iter()
            .map(|r| Candidate {
                name: r.regression.name.clone(),
                terms: r.coefficients.iter().filter(|c| **c != 0.0).count(),
                free_run: r.free_run,
            })
            .collect()
    }

    fn choice(&self, ranked: &Ranked, method: &str, reason: String) -> Choice {
        let points = &ranked.regression.points;
        let of = |value: fn(&(f64, f64)) -> f64| -> Option<Vec<f64>> {
            points.iter().map(|p| p.as_ref().map(value)).collect()
        };
        Choice {
            method: method.into(),
            lambda: of(|p| p.0),
            nu: of(|p| p.1),
            smoothing: ranked.regression.smoothing.clone(),
            reason,
        }
    }

    pub(super) fn of_output_error(
        mut self,
        ranked: &[Ranked],
        followed: &Followed,
    ) -> Result<Identification, SindyError> {
        let (start, found) = (followed.start, &followed.found);
        let misfit = self.misfit(found);
        let terms = found.coefficients.iter().filter(|c| **c != 0.0).count();
        if misfit > FOLLOWS {
            self.warnings.push(format!(
                "the model leaves {} times the noise: the system is disturbed, or is not in the library",
                ratio(misfit)
            ));
        }
        if found.outcome != Outcome::Converged {
            self.warnings.push(format!(
                "the output error did not converge in {} steps",
                found.iterations
            ));
        }
        if followed.longest != usize::MAX {
            self.warnings.push(format!(
                "trajectories are followed in {} only: the system is disturbed, or is not in the library",
                count(found.arcs, "short arc")
            ));
        }
        if found.correlation > CORRELATED && self.noise.is_visible() {
            self.warnings.push(format!(
                "residuals are correlated: standard errors are widened {:.1} times",
                found.correlation.sqrt()
            ));
        }
        let reason = format!(
            "output error: {terms} {} {} times the estimated noise over {} of the data; every other term is worth less \
             than its penalty; started from {} ({})",
            if terms == 1 {
                "term leaves"
            } else {
                "terms leave"
            },
            ratio(misfit),
            count(found.arcs, "arc"),
            ranked[start].regression.name,
            count(found.iterations, "step")
        );
        let sure: Vec<Certainty> = (0..found.coefficients.len())
            .map(|j| Certainty::of_output_error(found, j))
            .collect();
        let model = self.model(&found.coefficients, &sure)?;
        let mut equations = Vec::new();
        let mut at = 0;
        for (i, library) in self.libraries.iter().enumerate() {
            let p = library.len();
            let chosen: Vec<bool> = found.coefficients[at..at + p]
                .iter()
                .map(|c| *c != 0.0)
                .collect();
            let front = found.fronts[i]
                .iter()
                .map(|point| {
                    let support: Vec<bool> =
                        (0..p).map(|j| point.support.contains(&(at + j))).collect();
                    FrontPoint {
                        terms: named(library.names(), &support),
                        error: point.error,
                        proven: point.proven,
                        chosen: support == chosen,
                    }
                })
                .collect();
            let intervals = intervals(&found.coefficients[at..at + p], &sure[at..at + p]);
            at += p;
            equations.push(Equation {
                state: self.data.states()[i].clone(),
                noise: self.noise.sigma[i],
                residual: Some(found.sigma[i]),
                front,
                unit: "root mean square of the trajectories' residuals, in units of the noise",
                intervals,
            });
        }
        Ok(Identification {
            model,
            equations,
            choice: self.choice(&ranked[start], "output_error", reason),
            candidates: Self::candidates(ranked),
            outcome: found.outcome,
            inputs_between: self.inputs.between,
            data: self.data.report(),
            warnings: self.warnings,
        })
    }

    pub(super) fn of_regression(
        mut self,
        ranked: &[Ranked],
        statistics: &[Statistics],
    ) -> Result<Identification, SindyError> {
        let best = &ranked[0];
        // Statistics of the smoothing that the best model came from.
        let from = statistics
            .iter()
            .find(|s| s.smoothing == best.regression.smoothing)
            .unwrap_or(&statistics[0]);
        let mut sure = Vec::new();
        let mut equations = Vec::new();
        for (i, (fit, parts)) in best.regression.fits.iter().zip(&from.grams).enumerate() {
            let total = Gram::total(parts);
            let own = certainty(fit, parts, &total, from.independent);
            let names = self.libraries[i].names();
            let front = best_subsets(&total, FRONT_NODES)?
                .sizes
                .iter()
                .map(|s| FrontPoint {
                    terms: named(names, &s.fit.support),
                    error: (s.fit.residual_sum / total.weight().max(f64::MIN_POSITIVE)).sqrt(),
                    proven: s.fit.outcome == Outcome::Optimal,
                    chosen: s.fit.support == fit.support,
                })
                .collect();
            equations.push(Equation {
                state: self.data.states()[i].clone(),
                noise: self.noise.sigma[i],
                residual: None,
                front,
                unit: match self.settings.discrete {
                    true => "root mean square error of the next sample",
                    false => "root mean square error of the slope",
                },
                intervals: intervals(fit.coefficients.as_slice(), &own),
            });
            sure.extend(own);
        }
        let model = self.model(&best.coefficients, &sure)?;
        let reason = format!(
            "{}: of {} regressions the fewest terms ({}) among those with the least free-run error ({} times the \
             noise)",
            best.regression.name,
            ranked.len(),
            model.terms(),
            ratio(best.free_run)
        );
        if !(best.free_run <= FOLLOWS) {
            self.warnings.push(format!(
                "in free run the model leaves {} times the noise: the system is disturbed, or is not in the \
                 library, or its inputs are not what it was driven by",
                ratio(best.free_run)
            ));
        }
        for (state, equation) in self.data.states().iter().zip(model.equations()) {
            let doubtful: Vec<String> = equation
                .iter()
                .filter(|t| t.inclusion.is_some_and(|p| p < 0.5))
                .map(|t| t.expression.to_string())
                .collect();
            if !doubtful.is_empty() {
                self.warnings.push(format!(
                    "equation of {state}: more likely absent than not: {}",
                    doubtful.join(", ")
                ));
            }
        }
        if self.settings.method == super::Method::OutputError {
            self.warnings
                .push("the output error could follow no trajectory; this is a regression".into());
        }
        let outcome = best
            .regression
            .fits
            .iter()
            .map(|f| f.outcome)
            .find(|o| !o.is_success())
            .unwrap_or(Outcome::Converged);
        Ok(Identification {
            model,
            equations,
            choice: self.choice(best, best.regression.solver, reason),
            candidates: Self::candidates(ranked),
            outcome,
            inputs_between: self.inputs.between,
            data: self.data.report(),
            warnings: self.warnings,
        })
    }
}

/// So many of a thing.
fn count(n: usize, thing: &str) -> String {
    match n {
        1 => format!("1 {thing}"),
        n => format!("{n} {thing}s"),
    }
}

fn named(names: &[String], support: &[bool]) -> Vec<String> {
    let kept = names.iter().zip(support).filter(|(_, s)| **s);
    kept.map(|(n, _)| n.clone()).collect()
}
