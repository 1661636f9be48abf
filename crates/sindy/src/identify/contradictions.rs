//! Whether the data contradict signs, invariants or known parts: the fit without them from where the one with them has ended.

use super::follow::{FollowedModel, Search};
use super::known::{self, KnownPart, left_side};
use super::regress::Statistics;
use super::run::{CORRELATED, IdentificationRun};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::Term;
use crate::model::print::Number;
use crate::solve::sign::{Sign, broken, is_constrained};
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::statistics::regression::student_95;
use crate::trajectory::output_error::{self, OutputErrorFit, Piece, Start, System, silent};

/// A known term that has another coefficient in a fit in which known terms are free.
#[derive(Clone, Debug)]
pub(super) struct FreedTerm {
    equation: usize,
    known: Term,
    /// The coefficient with its standard error; `None` where the term is left out.
    found: Option<[f64; 2]>,
}

impl IdentificationRun<'_> {
    /// The coefficients of the fit without signs from where the one with signs ended, if they break a sign and are more likely by
    /// odds of 20 to 1.
    pub(super) fn without_signs(
        &self,
        found: &FollowedModel,
        search: &Search<'_>,
    ) -> Option<Vec<f64>> {
        if !is_constrained(search.signs) {
            return None;
        }
        let mut start = self.start(&found.fit.coefficients, &found.fit.sigma, search);
        start.signs.clear();
        start.colour.clone_from(&found.fit.colour);
        let correlation = found.fit.correlation;
        let mut limits = self.limits(found.longest);
        limits.penalty *= correlation;
        let free =
            found
                .way()
                .search(search.system, search.pieces, (&start, &limits), &mut silent)?;
        let likelier = is_likelier(&free, &found.fit, correlation);
        let breaks = broken(search.signs, &free.coefficients).next().is_some();
        (likelier && breaks).then_some(free.coefficients)
    }

    /// The coefficients of the fit without invariants, of all candidate terms, if it is more likely by odds of 20 to 1: over whole
    /// trajectories, or over the arcs that the model was found with. The residual of the fit with invariants is correlated where
    /// these are false, so that of the fit without them counts.
    pub(super) fn without_invariants(
        &self,
        found: &FollowedModel,
        search: &Search<'_>,
        statistics: &Statistics,
    ) -> Option<Vec<f64>> {
        let conserved = self.conserved.as_ref()?;
        let whole = (found.longest != usize::MAX).then_some(usize::MAX);
        whole
            .into_iter()
            .chain([found.longest])
            .find_map(|longest| {
                let mut limits = self.limits(longest);
                let run = |system: &System, start: &Start, limits: &output_error::Settings| {
                    found
                        .way()
                        .search(system, search.pieces, (start, limits), &mut silent)
                };
                let start = self.start(&found.fit.coefficients, &found.fit.sigma, search);
                let kept = match longest == found.longest {
                    true => found.fit.clone(),
                    false => run(search.system, &start, &limits)?,
                };
                let start = conserved.free_start(start, &kept, statistics);
                let mut free = run(&conserved.free, &start, &limits)?;
                if free.correlation > CORRELATED {
                    limits.penalty *= free.correlation;
                    free = run(&conserved.free, &start, &limits)?;
                }
                let likelier = is_likelier(&free, &kept, free.correlation);
                likelier.then_some(free.coefficients)
            })
    }

    /// The known terms that have another coefficient where all of them are free beside the terms of the model, if that is more
    /// likely by odds of 20 to 1. What is false in a known part is otherwise made up for by terms that should not be there, and
    /// leaves no residual.
    pub(super) fn without_known(
        &self,
        found: &FollowedModel,
        pieces: &[Piece<'_>],
    ) -> Vec<FreedTerm> {
        self.freed(found, pieces).unwrap_or_default()
    }

    /// The known parts that the settings give. Others are those of linearised equations.
    fn given(&self) -> Result<Vec<KnownPart>, SindyError> {
        let settings = self.settings;
        let (known, second_order) = (&settings.known, &settings.second_order);
        known::of(known, self.data, second_order, settings.discrete)
    }

    fn freed(&self, found: &FollowedModel, pieces: &[Piece<'_>]) -> Option<Vec<FreedTerm>> {
        // Under invariants fields are the candidates.
        if self.conserved.is_some() {
            return None;
        }
        let given = self.given().ok()?;
        // What says that a velocity is the derivative of its position is true by definition.
        let is_freed = |i: usize| {
            let own = &self.libraries[i].1;
            !self.positions.contains(&i) && !own.terms.is_empty() && given[i] == *own
        };
        (0..self.libraries.len()).find(|&i| is_freed(i))?;
        let (mut first, mut coefficients) = (0, Vec::new());
        let (mut libraries, mut kept_known, mut freed) = (Vec::new(), Vec::new(), Vec::new());
        let mut signs = Vec::new();
        for (equation, (library, known)) in self.libraries.iter().enumerate() {
            let own = &found.fit.coefficients[first..first + library.len()];
            first += library.len();
            let mut terms = Vec::new();
            for j in (0..own.len()).filter(|&j| own[j] != 0.0) {
                terms.push(library.terms()[j].clone());
                coefficients.push(own[j]);
                signs.push(self.signs[equation].get(j).copied().unwrap_or(Sign::Any));
            }
            let (open, kept) = match is_freed(equation) {
                true => (&known.terms[..], Vec::new()),
                false => (&[][..], known.terms.clone()),
            };
            for term in open {
                freed.push((coefficients.len(), equation, term));
                terms.push(term.expression.clone());
                coefficients.push(term.coefficient);
                signs.push(Sign::Any);
            }
            libraries.push(Library::of(terms));
            kept_known.push(kept);
        }
        let system = self.system_of_terms(self.data.inputs(), &libraries, &kept_known)?;
        let correlation = found.fit.correlation;
        let mut limits = self.limits(found.longest);
        limits.penalty *= correlation;
        // Sizes of terms, which nothing else asks for here, are not known of known terms.
        limits.relevance = 0.0;
        let start = Start {
            term_rms: vec![1.0; coefficients.len()],
            coefficients,
            sigma: found.fit.sigma.clone(),
            floor: self.noise.floor.clone(),
            chosen_from: first,
            signs,
            colour: found.fit.colour.clone(),
        };
        let way = found.way();
        let free = way.search(&system, pieces, (&start, &limits), &mut silent)?;
        if !is_likelier(&free, &found.fit, correlation) {
            return None;
        }
        let other = |(j, equation, known): (usize, usize, &Term)| {
            let (value, error) = (
                free.coefficients[j],
                free.std_errors[j] * correlation.sqrt(),
            );
            let away = (value - known.coefficient).abs() > student_95(f64::INFINITY) * error;
            (value == 0.0 || away).then(|| FreedTerm {
                equation,
                known: known.clone(),
                found: (value != 0.0).then_some([value, error]),
            })
        };
        Some(freed.into_iter().filter_map(other).collect())
    }

    /// What freed terms say of the known parts.
    pub(super) fn contradicted_known(&self, freed: &[FreedTerm]) -> Vec<String> {
        let of = |freed: &FreedTerm| {
            let left = left_side(&self.data.states()[freed.equation], self.settings.discrete);
            let term = &freed.known.expression;
            let what = match freed.found {
                Some([value, error]) => {
                    let shown = |value, digits| Number::new(value, Some(digits)).text();
                    let (value, error) = (shown(value, 4), shown(error, 2));
                    format!("a model in which it is {value} ± {error}")
                }
                None => "a model without the term".to_string(),
            };
            format!(
                "the data contradict the known coefficient {} of {term} in {left}: {what} is more than 20 times as likely. \
                 Check the known part, the data, and what the library lacks",
                freed.known.coefficient
            )
        };
        freed.iter().map(of).collect()
    }
}

/// Whether a fit is more likely than another one by odds of 20 to 1. Correlated residuals hold the information of fewer
/// independent ones.
fn is_likelier(fit: &OutputErrorFit, than: &OutputErrorFit, correlation: f64) -> bool {
    let score = |fit: &OutputErrorFit| {
        let terms = fit.coefficients.iter().filter(|c| **c != 0.0).count() as f64;
        (fit.score - terms * fit.penalty) / correlation + terms * fit.penalty
    };
    score(than) - score(fit) > TWENTY_TO_ONE
}
