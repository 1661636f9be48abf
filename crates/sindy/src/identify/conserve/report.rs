//! Results under invariants and relations: equations, and warnings where the data contradict one.

use std::borrow::Cow;
use std::ops::Range;

use super::terms::kept;
use super::{Conserved, DVector};
use crate::error::SindyError;
use crate::identify::evidence::intervals;
use crate::identify::follow::FollowedModel;
use crate::identify::model::{WrittenRegression, named};
use crate::identify::rank::{BETTER, RankedModel};
use crate::identify::regress::{self, FRONT_NODES, Statistics, signed_subsets};
use crate::identify::run::IdentificationRun;
use crate::identify::{Equation, FrontPoint};
use crate::solve::outcome::Outcome;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::{OutputErrorFit, Piece, Start, free_run};

/// Unit of the errors of joint fronts.
const UNIT: &str = "root mean square error of all slopes, in units of what each equation leaves alone (at least 0.1 % of its slopes)";

impl Conserved {
    /// For each invariant, how fast a model changes it, as a share of what its terms exchange, in the range of the data.
    pub(in crate::identify) fn shares(&self, coefficients: &[f64]) -> Vec<f64> {
        let xi = DVector::from_column_slice(coefficients);
        let rates = &self.changes * &xi;
        let parts = self.changes.abs() * xi.abs();
        let count = self.invariants.len();
        let size = |values: &DVector<f64>, q: usize| {
            let own = values.iter().skip(q).step_by(count);
            own.map(|v| v * v).sum::<f64>().sqrt()
        };
        (0..count)
            .map(|q| size(&rates, q) / size(&parts, q).max(f64::MIN_POSITIVE))
            .collect()
    }

    /// Where a search without invariants starts: from the coefficients of a fit that keeps them.
    pub(in crate::identify) fn free_start(
        &self,
        start: Start,
        from: &OutputErrorFit,
        statistics: &Statistics,
    ) -> Start {
        Start {
            coefficients: self.terms(&from.coefficients),
            sigma: from.sigma.clone(),
            term_rms: regress::term_rms(&statistics.separate),
            chosen_from: self.candidates,
            colour: from.colour.clone(),
            ..start
        }
    }

    /// A warning that a likelier model does not keep the invariants and relations: how far it is off each of them, the farthest first.
    fn contradicted(&self, free: &[f64]) -> Vec<String> {
        if self.invariants.is_empty() && self.relations.is_empty() {
            return vec![
                "the data contradict that the quadratic terms keep the energy |x|²/2: a model without this condition is more than 20 times as \
                 likely. Check the units of the states, the data, and what the library lacks"
                    .to_owned(),
            ];
        }
        let shares = self.invariants.iter().zip(self.shares(free));
        let invariants = shares.map(|(e, share)| (share, &e.text, true));
        let relations = self.relations.iter();
        let relations = relations.map(|r| (r.broken_by(free), &r.text, false));
        let mut all: Vec<(f64, &String, bool)> = invariants.chain(relations).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let warning = match all.as_slice() {
            [(share, text, true)] => format!(
                "the data contradict that `{text}` is conserved: without invariants the model is more than 20 times as likely, and \
                 changes it by {} of what its terms exchange. Check the invariant, the data, and what the library lacks",
                percent(*share)
            ),
            [(share, text, false)] => format!(
                "the data contradict `{text}`: without constraints the model is more than 20 times as likely, and its coefficients are \
                 off by {} of the largest of them. Check the constraint, the data, and what the library lacks",
                percent(*share)
            ),
            several => {
                let each = several.iter().map(|(share, text, conserved)| {
                    let what = if *conserved { " (conserved)" } else { "" };
                    format!("`{text}`{what} is off by {}", percent(*share))
                });
                format!(
                    "the data contradict what is to hold: without it the model is more than 20 times as likely. There {}. What is off by \
                     little may be true: check the first, the data, and what the library lacks",
                    each.collect::<Vec<_>>().join(", ")
                )
            }
        };
        vec![warning]
    }
}

impl IdentificationRun<'_> {
    /// The candidates of each equation among those of all.
    fn candidates(&self) -> Vec<Range<usize>> {
        let mut first = 0;
        let own = self.libraries.iter().map(|(library, _)| {
            let own = first..first + library.len();
            first = own.end;
            own
        });
        own.collect()
    }

    /// A fit by output error over candidate terms, whatever the system's candidates are.
    pub(in crate::identify) fn in_terms<'f>(
        &self,
        fit: &'f OutputErrorFit,
    ) -> Cow<'f, OutputErrorFit> {
        match &self.conserved {
            Some(conserved) => Cow::Owned(conserved.terms_of_fit(fit, &self.candidates())),
            None => Cow::Borrowed(fit),
        }
    }

    /// Terms of a ranked model in all equations.
    pub(in crate::identify) fn terms_of(&self, ranked: &RankedModel) -> usize {
        match &self.conserved {
            Some(conserved) => {
                let all = conserved.terms(&ranked.coefficients);
                all.iter().filter(|c| **c != 0.0).count()
            }
            None => ranked.terms(),
        }
    }

    /// A warning, if a model by output error without invariants and relations is more likely by odds of 20 to 1.
    pub(in crate::identify) fn broken_by_trajectories(
        &self,
        followed: Option<&FollowedModel>,
    ) -> Vec<String> {
        let free = followed.and_then(|f| f.without_invariants.as_ref());
        match (&self.conserved, free) {
            (Some(conserved), Some(free)) => conserved.contradicted(free),
            _ => Vec::new(),
        }
    }

    /// The same for best subsets of a regression. Noise in the terms alters slopes systematically, in different equations
    /// differently, so the free run has to be better as well.
    pub(in crate::identify) fn broken_by_regression(
        &self,
        from: &Statistics,
        best: &RankedModel,
        yardstick: &[Piece<'_>],
    ) -> Result<Vec<String>, SindyError> {
        let Some(conserved) = &self.conserved else {
            return Ok(Vec::new());
        };
        let coefficients = conserved.terms(&best.coefficients);
        let free = conserved.likelier_alone(from, best.terms(), &coefficients)?;
        let free = free.filter(|free| {
            let sigma = &self.noise.sigma;
            free_run(&conserved.free, yardstick, free, sigma) < BETTER * best.free_run
        });
        Ok(free.map_or_else(Vec::new, |free| conserved.contradicted(&free)))
    }

    /// Coefficients of all candidates, the evidence for them, and the equations of a regression over fields.
    pub(in crate::identify) fn joint_equations(
        &self,
        conserved: &Conserved,
        best: &RankedModel,
        from: &Statistics,
    ) -> Result<WrittenRegression, SindyError> {
        let (fit, parts) = (&best.regression.fits[0], &from.grams[0]);
        let total = Gram::total(parts);
        let coefficients = conserved.terms(&best.coefficients);
        let evidence = conserved.evidence_of_regression(fit, (parts, &total), from.independent);
        let subsets = signed_subsets(&total, &[], FRONT_NODES)?;
        let weight = total.weight().max(f64::MIN_POSITIVE);
        let supports: Vec<Vec<usize>> = subsets
            .sizes
            .iter()
            .map(|s| kept(s.fit.coefficients.as_slice()))
            .collect();
        let chosen = kept(fit.coefficients.as_slice());
        let mut equations = Vec::new();
        for (i, own) in self.candidates().into_iter().enumerate() {
            let names = self.libraries[i].0.names();
            let point = |(at, terms): (usize, Vec<usize>)| {
                let subset = &subsets.sizes[at].fit;
                let support: Vec<bool> = own.clone().map(|k| terms.contains(&k)).collect();
                FrontPoint {
                    terms: named(names, &support),
                    error: (subset.residual_sum / weight).sqrt(),
                    proven: subset.outcome == Outcome::Optimal,
                    chosen: supports[at] == chosen,
                }
            };
            let shown = conserved.shown(&supports, &chosen, &own);
            equations.push(Equation {
                state: self.data.states()[i].clone(),
                noise: self.noise_of(i),
                residual: None,
                disturbance: None,
                diffusion: Vec::new(),
                front: shown.into_iter().map(point).collect(),
                unit: UNIT,
                intervals: self.libraries[i]
                    .1
                    .before(intervals(&coefficients[own.clone()], &evidence[own])),
            });
        }
        Ok((coefficients, evidence, equations))
    }
}
