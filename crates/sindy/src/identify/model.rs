//! From a fit to the identification's result: model, fronts, reason and warnings.

use std::borrow::Cow;

use super::all_rows::OnAllRows;
use super::evidence::{TermEvidence, intervals};
use super::follow::FollowedModel;
use super::rank::RankedModel;
use super::regress::{FRONT_NODES, Statistics, signed_subsets};
use super::run::IdentificationRun;
use super::{Candidate, Choice, Equation, FrontPoint, Identification, ratio};
use crate::error::SindyError;
use crate::model::{Model, Term};
use crate::solve::exact::Subset;
use crate::solve::fit::Fit;
use crate::solve::outcome::Outcome;
use crate::solve::sign::Sign;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::{Alternative, OutputErrorFit, Piece};

/// Coefficients of all candidates, the evidence for them, and the equations.
pub(super) type WrittenRegression = (Vec<f64>, Vec<TermEvidence>, Vec<Equation>);

impl IdentificationRun<'_> {
    /// A model from the coefficients of all candidates and the evidence for them.
    fn model(&self, coefficients: &[f64], all: &[TermEvidence]) -> Result<Model, SindyError> {
        let mut at = 0;
        let mut equations = Vec::new();
        for (library, known) in &self.libraries {
            let mut terms = known.terms.clone();
            for term in library.terms() {
                if coefficients[at] != 0.0 {
                    let worth = all[at];
                    let mut kept =
                        Term::new(term.clone(), coefficients[at]).with_inclusion(worth.inclusion());
                    if worth.std_error.is_finite() {
                        kept = kept.with_std_error(worth.std_error);
                    }
                    terms.push(kept);
                }
                at += 1;
            }
            equations.push(terms);
        }
        Model::new(self.time, self.data.states(), self.data.inputs(), equations)
    }

    /// States that are measured.
    fn measured(&self) -> usize {
        self.data.states().len() - self.positions.len()
    }

    /// Noise of a state; there is none of a velocity that is not measured.
    pub(super) fn noise_of(&self, i: usize) -> f64 {
        match i < self.measured() {
            true => self.noise.sigma[i],
            false => f64::NAN,
        }
    }

    fn choice(&self, ranked: &RankedModel, method: &str, reason: String) -> Choice {
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
        ranked: &[RankedModel],
        followed: &FollowedModel,
        from: &Statistics,
    ) -> Result<Identification, SindyError> {
        let moved = self.stable_fit(&followed.fit, from);
        let fit = self.in_terms(&followed.fit);
        let fit = &match &moved {
            Some(moved) => Cow::Owned(self.with_moved(&fit, moved)),
            None => fit,
        };
        let evidence: Vec<TermEvidence> = (0..fit.coefficients.len())
            .map(|j| TermEvidence::of_output_error(fit, j))
            .collect();
        let model = self.model(&fit.coefficients, &evidence)?;
        let residual = fit.residual();
        let mut equations = Vec::new();
        let mut diffusion = self.diffusion_terms(fit);
        let mut at = 0;
        for (i, (library, known)) in self.libraries.iter().enumerate() {
            let own = at..at + library.len();
            let chosen: Vec<bool> = fit.coefficients[own.clone()]
                .iter()
                .map(|c| *c != 0.0)
                .collect();
            let point = |point: &Alternative| {
                let kept = |j| point.support.contains(&j);
                let support: Vec<bool> = own.clone().map(kept).collect();
                FrontPoint {
                    terms: named(library.names(), &support),
                    error: point.error,
                    proven: point.proven,
                    chosen: support == chosen,
                }
            };
            equations.push(Equation {
                state: self.data.states()[i].clone(),
                noise: self.noise_of(i),
                residual: (i < self.measured()).then_some(residual[i]),
                front: fit.fronts[i].iter().map(point).collect(),
                unit: match fit.disturbance {
                    None => {
                        "root mean square of the trajectories' residuals, in units of the noise"
                    }
                    Some(_) => {
                        "root mean square of the prediction errors, in units of their expected size"
                    }
                },
                disturbance: fit.disturbance.as_ref().map(|d| d.process[i].sqrt()),
                diffusion: std::mem::take(&mut diffusion[i]),
                intervals: known.before(intervals(
                    &fit.coefficients[own.clone()],
                    &evidence[own.clone()],
                )),
            });
            at = own.end;
        }
        let start = &ranked[followed.start];
        let method = match fit.disturbance {
            None => "output_error",
            Some(_) => "prediction_error",
        };
        let choice = self.choice(
            start,
            method,
            self.reason_of_fit(fit, start, followed.on_all_rows),
        );
        let mut warnings = self.warnings_of_model(&model, fit, followed)?;
        warnings.extend(self.doubtful(&fit.coefficients, &evidence));
        self.warnings.extend(warnings);
        let outcome = fit.outcome;
        let lost = moved.map_or(0.0, |m| m.lost);
        Ok(self.finish(model, equations, (choice, lost), ranked, outcome))
    }

    /// What calls a model by output error into question.
    fn warnings_of_model(
        &self,
        model: &Model,
        fit: &OutputErrorFit,
        followed: &FollowedModel,
    ) -> Result<Vec<String>, SindyError> {
        let mut out = self.warnings_of_fit(followed);
        out.extend(self.contradicted_by_trajectories(followed));
        out.extend(self.broken_by_trajectories(Some(followed)));
        out.extend(self.unmoved(model, fit));
        out.extend(self.lack_of_map(model, Some(followed))?);
        out.extend(self.no_diffusion(fit));
        out.extend(self.warnings_of_multiples(fit));
        out.extend(self.as_likely_trajectories(fit));
        Ok(out)
    }

    fn reason_of_fit(
        &self,
        fit: &OutputErrorFit,
        start: &RankedModel,
        on_all_rows: Option<OnAllRows>,
    ) -> String {
        let terms = fit.coefficients.iter().filter(|c| **c != 0.0).count();
        let leave = match terms {
            1 => "term leaves",
            _ => "terms leave",
        };
        if fit.disturbance.is_some() {
            return format!(
                "prediction error: a system that is disturbed; over {} every other term is worth less than its penalty; \
                 started from {} ({}){}",
                count(fit.arcs, "record"),
                start.regression.name,
                count(fit.iterations, "step"),
                self.reason_of_diffusion(fit)
            );
        }
        let there = match on_all_rows {
            Some(OnAllRows::Refined) => {
                format!(
                    " on the {} rows on which terms were chosen",
                    self.settings.rows
                )
            }
            _ => String::new(),
        };
        format!(
            "output error: {terms} {leave} {} times the estimated noise over {} of the data; every other term is worth less \
             than its penalty{there}; started from {} ({})",
            ratio(self.misfit(fit)),
            count(fit.arcs, "arc"),
            start.regression.name,
            count(fit.iterations, "step")
        )
    }

    pub(super) fn of_regression(
        mut self,
        ranked: &[RankedModel],
        statistics: &[Statistics],
        yardstick: &[Piece<'_>],
        followed: Option<&FollowedModel>,
    ) -> Result<Identification, SindyError> {
        // Statistics of the smoothing that the best model came from.
        let from = statistics
            .iter()
            .find(|s| s.smoothing == ranked[0].regression.smoothing)
            .unwrap_or(&statistics[0]);
        let (best, worth) = self.likelier_regression(&ranked[0], from, yardstick);
        let best = &best;
        let (mut coefficients, mut evidence, mut equations) = match &self.conserved {
            Some(conserved) => self.joint_equations(conserved, best, from)?,
            None => self.separate_equations(best, from, worth)?,
        };
        let exchanges = self.exchanges(best, from, &mut evidence);
        let moved = self.stable_regression(&best.coefficients, from);
        if let Some(moved) = &moved {
            coefficients = self.with_added(moved, &mut evidence);
            let mut first = 0;
            for (equation, (library, _)) in equations.iter_mut().zip(&self.libraries) {
                let own = first..first + library.len();
                first = own.end;
                equation.intervals = intervals(&coefficients[own.clone()], &evidence[own]);
            }
        }
        let model = self.model(&coefficients, &evidence)?;
        let reason = format!(
            "{}: of {} regressions the fewest terms ({}) among those with the least free-run error ({} times the \
             noise)",
            best.regression.name,
            ranked.len(),
            model.terms(),
            ratio(best.free_run)
        );
        let choice = self.choice(best, best.regression.solver, reason);
        let warnings = self.warnings_of_regression(best, &coefficients, &evidence);
        self.warnings.extend(warnings);
        let as_likely = self.as_likely_regressions(exchanges);
        self.warnings.extend(as_likely);
        let against = self.contradicted_by_regression(from)?;
        self.warnings.extend(against);
        let freed = followed.map_or(&[][..], |f| &f.without_known);
        let against = self.contradicted_known(freed);
        self.warnings.extend(against);
        let mut against = self.broken_by_trajectories(followed);
        if against.is_empty() {
            against = self.broken_by_regression(from, best, yardstick)?;
        }
        self.warnings.extend(against);
        let lack = self.lack_of_map(&model, None)?;
        self.warnings.extend(lack);
        let mut outcomes = best.regression.fits.iter().map(|f| f.outcome);
        let outcome = outcomes
            .find(|o| !o.is_success())
            .unwrap_or(Outcome::Converged);
        let lost = moved.map_or(0.0, |m| m.lost);
        Ok(self.finish(model, equations, (choice, lost), ranked, outcome))
    }

    /// Coefficients of all candidates, the evidence for them, and the equations of a regression of each equation.
    fn separate_equations(
        &self,
        best: &RankedModel,
        from: &Statistics,
        worth: Vec<Vec<TermEvidence>>,
    ) -> Result<WrittenRegression, SindyError> {
        let mut evidence = Vec::new();
        let mut equations = Vec::new();
        let fits = best.regression.fits.iter().zip(&from.grams);
        for ((i, (fit, parts)), own) in fits.enumerate().zip(worth) {
            let total = Gram::total(parts);
            equations.push(Equation {
                state: self.data.states()[i].clone(),
                noise: self.noise_of(i),
                residual: None,
                disturbance: None,
                diffusion: Vec::new(),
                front: front(&total, &self.signs[i], fit, self.libraries[i].0.names())?,
                unit: match self.settings.discrete {
                    true => "root mean square error of the next sample",
                    false => "root mean square error of the slope",
                },
                intervals: self.libraries[i]
                    .1
                    .before(intervals(fit.coefficients.as_slice(), &own)),
            });
            evidence.extend(own);
        }
        Ok((best.coefficients.clone(), evidence, equations))
    }

    fn finish(
        mut self,
        model: Model,
        equations: Vec<Equation>,
        (mut choice, lost): (Choice, f64),
        ranked: &[RankedModel],
        outcome: Outcome,
    ) -> Identification {
        if lost > 0.0 {
            choice.reason.push_str(&format!(
                "; its coefficients then moved to the nearest stable ones, which lose {lost:.1} of twice the log-likelihood"
            ));
        }
        let stability = self.stability(&model, lost);
        if self.stable.is_some() && stability.is_none() {
            self.warnings.push(
                "no proof was found that the model is stable: its trajectories may grow without bound. Use more data, or fewer \
                 candidate terms"
                    .to_owned(),
            );
        }
        let candidate = |r: &RankedModel| Candidate {
            name: r.regression.name.clone(),
            terms: self.terms_of(r),
            free_run: r.free_run,
        };
        Identification {
            model,
            equations,
            choice,
            candidates: ranked.iter().map(candidate).collect(),
            outcome,
            inputs_between: self.inputs.between,
            data: self.data.report(),
            stability,
            warnings: self.warnings,
        }
    }
}

/// The best subset of every size, and where the fit's own terms stand among them.
fn front(
    total: &Gram,
    signs: &[Sign],
    fit: &Fit,
    names: &[String],
) -> Result<Vec<FrontPoint>, SindyError> {
    if names.is_empty() {
        return Ok(Vec::new());
    }
    let subsets = signed_subsets(total, signs, FRONT_NODES)?;
    let weight = total.weight().max(f64::MIN_POSITIVE);
    let point = |s: &Subset| FrontPoint {
        terms: named(names, &s.fit.support),
        error: (s.fit.residual_sum / weight).sqrt(),
        proven: s.fit.outcome == Outcome::Optimal,
        chosen: s.fit.support == fit.support,
    };
    Ok(subsets.sizes.iter().map(point).collect())
}

/// A count with its noun.
pub(super) fn count(n: usize, thing: &str) -> String {
    match n {
        1 => format!("1 {thing}"),
        n => format!("{n} {thing}s"),
    }
}

pub(super) fn named(names: &[String], support: &[bool]) -> Vec<String> {
    let kept = names.iter().zip(support).filter(|(_, s)| **s);
    kept.map(|(n, _)| n.clone()).collect()
}
