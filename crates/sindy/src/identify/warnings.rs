//! Warnings about data and fits.

use super::NoiseSource;
use super::all_rows::OnAllRows;
use super::evidence::TermEvidence;
use super::follow::{FollowedModel, SAME_COLOUR};
use super::known::KnownPart;
use super::model::count;
use super::rank::RankedModel;
use super::ratio;
use super::regress::Statistics;
use super::run::{CORRELATED, FOLLOWS, IdentificationRun};
use crate::data::dataset::{DataReport, Stretch};
use crate::data::samples::Samples;
use crate::error::SindyError;
use crate::library::Library;
use crate::model::Model;
use crate::solve::outcome::Outcome;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::OutputErrorFit;
use crate::uncertainty::identifiability::examine;

/// Terms of one warning that are named, at most.
const NAMED: usize = 10;
/// A condition of the scaled library above which collinear terms are named: intervals are ten thousand times those of
/// separate terms. A warning only.
const CONDITION: f64 = 1e4;

/// Warnings about the data before anything is fitted; `samples` are all usable rows.
pub(super) fn of_data(
    report: &DataReport,
    statistics: &Statistics,
    libraries: &[(Library, KnownPart)],
    samples: &Samples,
) -> Result<Vec<String>, SindyError> {
    let mut out = Vec::new();
    if report.stretches == report.trajectories && report.missing_rows > 0 {
        out.push(format!(
            "left out: {} with missing values, before the first or after the last value of some column",
            count(report.missing_rows, "row")
        ));
    } else if report.missing_rows + report.holes + report.short_rows > 0 {
        out.push(format!(
            "gaps split the trajectories into {} stretches: {} with missing values, {} of time, {} in stretches too short to use",
            report.stretches,
            count(report.missing_rows, "row"),
            count(report.holes, "jump"),
            count(report.short_rows, "row")
        ));
    }
    for (i, parts) in statistics.grams.iter().enumerate() {
        let (library, _) = &libraries[i];
        if library.is_empty() || libraries[..i].contains(&libraries[i]) {
            continue;
        }
        let total = Gram::total(parts);
        if total.skipped > 0 {
            out.push(format!(
                "{} of {} left out of the regression: a term of the library is not finite there",
                total.skipped,
                count(total.skipped + total.rows, "row")
            ));
        }
        let found = examine(library, &total, samples)?;
        if !found.zero_terms.is_empty() {
            out.push(format!(
                "terms that are zero throughout: {}",
                listed(&found.zero_terms)
            ));
        }
        for (condition, terms) in found.collinear.iter().filter(|c| c.0 > CONDITION) {
            let what = match condition.is_finite() {
                true => format!("nearly collinear terms (condition {condition:.1e})"),
                false => "collinear terms".to_owned(),
            };
            out.push(format!("{what}: {}", listed(terms)));
        }
        for column in found.inputs.iter().filter(|c| c.hardly_excited) {
            out.push(format!(
                "column `{}` hardly moves: mean {:.4}, standard deviation {:.2e}",
                column.name, column.mean, column.sd
            ));
        }
    }
    out.dedup();
    Ok(out)
}

/// The first of some terms by name, and how many more there are.
fn listed(terms: &[String]) -> String {
    match terms.len().saturating_sub(NAMED) {
        0 | 1 => terms.join(", "),
        more => format!("{} and {more} more", terms[..NAMED].join(", ")),
    }
}

/// A warning where weights above 0 differ by more than a tenth.
pub(super) fn weights_differ<'a>(weights: impl Iterator<Item = &'a f64>) -> Option<String> {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for &w in weights.filter(|w| **w > 0.0) {
        (least, most) = (least.min(w), most.max(w));
    }
    (most > 1.1 * least).then(|| {
        format!(
            "weights differ ({:.1} times): regressions on slopes and the output error use them; the noise estimate, smoothing \
             and the weak form count all rows that have a weight alike",
            most / least
        )
    })
}

impl IdentificationRun<'_> {
    /// A warning for each state without terms in its equation that moves by more than the noise: no test can tell what moves it
    /// from noise that is not white.
    pub(super) fn unmoved(&self, model: &Model, fit: &OutputErrorFit) -> Vec<String> {
        let states = model.states().iter().zip(model.equations());
        let left = fit.residual();
        let left = left.iter().zip(&self.noise.tolerated);
        if fit.disturbance.is_some() {
            let empty = states.filter(|(_, equation)| equation.is_empty());
            return empty
                .map(|(state, _)| {
                    format!(
                        "equation of {state} has no terms: all that moves it counts as a disturbance, or is not in the library"
                    )
                })
                .collect();
        }
        let unmoved = states.zip(left).filter(|((_, equation), (left, noise))| {
            equation.is_empty() && **left > FOLLOWS * **noise
        });
        unmoved
            .map(|((state, _), (left, noise))| {
                format!(
                    "equation of {state} has no terms, but {state} leaves {} times the noise that neighbouring samples show: \
                     what moves it is not in the library, is noise that is not white, or disturbs the system (setting `noise`)",
                    ratio(left / noise)
                )
            })
            .collect()
    }

    pub(super) fn warnings_of_fit(&self, followed: &FollowedModel) -> Vec<String> {
        let FollowedModel { fit, longest, .. } = followed;
        let misfit = self.misfit(fit);
        let mut out = Vec::new();
        match followed.independence {
            // The error of the next sample is judged instead.
            _ if fit.disturbance.is_some() => {}
            _ if self.settings.discrete && self.settings.noise == NoiseSource::Automatic => {}
            Some(p) if followed.is_in_noise() && misfit > FOLLOWS => out.push(format!(
                "the model leaves {} times the noise that neighbouring samples show. This residual does not follow the \
                 model's flow (p = {p:.2}): the noise is not white or has heavy tails. If the noise is known to be smaller, the \
                 model lacks a term, an input or a state",
                ratio(misfit)
            )),
            Some(p) if !followed.is_in_noise() => out.push(format!(
                "the residual is small but follows the model's flow (p = {p:.2}): the system is disturbed, or is not in the \
                 library"
            )),
            _ if misfit > FOLLOWS => out.push(format!(
                "the model leaves {} times the noise: the system is disturbed (the setting `noise` takes this as given), or is not in \
                 the library",
                ratio(misfit)
            )),
            _ => {}
        }
        let on_all_rows = match followed.on_all_rows {
            Some(OnAllRows::Leave(left)) => {
                Some(format!("leave {} times the noise on all rows", ratio(left)))
            }
            Some(OnAllRows::Lost) => Some("do not follow all rows".to_string()),
            Some(OnAllRows::Refined) | None => None,
        };
        if let Some(what) = on_all_rows {
            out.push(format!(
                "the terms, which were chosen on {} rows, {what}: coefficients change along the data, or a term is not in the \
                 library; the coefficients are those of the {0} rows",
                self.settings.rows
            ));
        }
        out.extend(self.warnings_of_disturbance(followed));
        out.extend(self.contradicted_known(&followed.without_known));
        let absent = followed.absent.as_ref();
        out.extend(absent.map(|a| a.warning(self.data.states())));
        if fit.outcome != Outcome::Converged {
            out.push(format!(
                "the output error did not converge in {} steps",
                fit.iterations
            ));
        }
        if *longest != usize::MAX && !self.settings.discrete {
            out.push(format!(
                "trajectories are followed in {} only: the system is disturbed, or is not in the library",
                count(fit.arcs, "short arc")
            ));
        }
        let remembers = fit.colour.iter().copied().fold(0.0, f64::max);
        if remembers > SAME_COLOUR {
            out.push(format!(
                "the noise of the measurement is not white: {remembers:.3} of it remains from row to row, which standard errors \
                 and the choice of terms take into account"
            ));
        }
        if fit.correlation > CORRELATED && self.noise.is_visible() {
            out.push(format!(
                "residuals are correlated: the noise is not white, or the model lacks a term. Standard errors are widened {:.1} times",
                fit.correlation.sqrt()
            ));
        }
        out
    }

    /// Whether disturbances are what they are taken for.
    fn warnings_of_disturbance(&self, followed: &FollowedModel) -> Vec<String> {
        let mut out = Vec::new();
        if followed.is_ambiguous {
            out.push(
                "noise of the measurement and disturbances of the system are equally likely here, and give other coefficients: \
                 the setting `noise` says which it is"
                    .into(),
            );
        }
        let automatic = self.settings.noise == NoiseSource::Automatic;
        if automatic
            && followed.fit.disturbance.is_some()
            && self.stretches.iter().any(Stretch::has_slow_state)
        {
            out.push(
                "disturbances explain what trajectories leave. Where few rows hold a state, tests hardly tell them from a term that is \
                 not in the library: the setting `noise` says that the system is disturbed"
                    .into(),
            );
        }
        if let Some(surprises) = followed.surprises
            && !surprises.are_noise()
        {
            out.push(surprises.warning());
        }
        let size = followed.surprises;
        out.extend(size.and_then(|s| s.warning_of_size(self.data.states())));
        out
    }

    pub(super) fn warnings_of_regression(
        &self,
        best: &RankedModel,
        coefficients: &[f64],
        evidence: &[TermEvidence],
    ) -> Vec<String> {
        let mut out = Vec::new();
        if !self.settings.discrete && !(best.free_run <= FOLLOWS) {
            out.push(format!(
                "in free run the model leaves {} times the noise: the system is disturbed, or is not in the \
                 library, or its inputs are not what it was driven by",
                ratio(best.free_run)
            ));
        }
        out.extend(self.doubtful(coefficients, evidence));
        if self.settings.method == super::Method::OutputError {
            out.push("the output error could follow no trajectory; this is a regression".into());
        }
        out
    }

    /// A warning for each equation that has terms which are more likely absent than not.
    pub(super) fn doubtful(&self, coefficients: &[f64], evidence: &[TermEvidence]) -> Vec<String> {
        let mut out = Vec::new();
        let mut own = coefficients.iter().zip(evidence);
        for (state, (library, _)) in self.data.states().iter().zip(&self.libraries) {
            let doubtful: Vec<&str> = library
                .names()
                .iter()
                .zip(&mut own)
                .filter(|(_, (c, worth))| **c != 0.0 && worth.evidence < 0.0)
                .map(|(name, _)| &name[..])
                .collect();
            if !doubtful.is_empty() {
                out.push(format!(
                    "equation of {state}: more likely absent than not: {}",
                    doubtful.join(", ")
                ));
            }
        }
        out
    }
}
