//! The output error from the best regressions, and from shorter arcs where whole trajectories cannot be followed.

use std::ops::ControlFlow;

use super::absent::Absent;
use super::all_rows::OnAllRows;
use super::contradictions::FreedTerm;
use super::disturbed::{Surprises, Way, sources};
use super::evidence::TermEvidence;
use super::prepare::{self, Slopes};
use super::rank::RankedModel;
use super::regress::{self, Statistics};
use super::run::{CORRELATED, FOLLOWS, IdentificationRun};
use super::screen::Screen;
use super::{Method, NoiseSource, Progress};
use crate::solve::outcome::Outcome;
use crate::solve::sign::Sign;
use crate::trajectory::output_error::{
    self, FIRST_ARC, OutputErrorFit, Piece, Settled, Start, Step, System, silent,
};

/// Starts of the output error, at most. Two that agree end the search earlier; with twice as many, systems that two
/// starts already settle take no longer.
const STARTS: usize = 3;

/// Scores (twice the log-likelihood) that differ by no more than this are the same solution: odds of e^½ = 1.6. Solutions
/// with other terms differ by a penalty of ten or more.
const SAME_SCORE: f64 = 1.0;

/// Nodes of an arc, at most, in the order in which they are tried: as far as chaos allows, then two shorter lengths.
/// Disturbances add up along an arc; shorter arcs tolerate larger ones, at the cost of information.
const LONGEST: [usize; 3] = [usize::MAX, 32, 8];

/// Level of the test for a residual that is noise of the measurement: of true models in such noise one in twenty is
/// refused.
const NOT_NOISE: f64 = 0.05;
/// The same for residuals as large as noise, of samples that are far apart: of true models one in a hundred is doubted.
const SPARSE: f64 = 0.01;
/// Rounds between the terms and the colour of the residual, which depend on each other: a first choice takes noise for
/// terms, and leaves a residual that is whiter than the noise. With more rounds nothing was measured.
const COLOUR_ROUNDS: usize = 3;

/// Memories of the noise that differ by no more are the same: it shifts standard errors by some percent.
pub(super) const SAME_COLOUR: f64 = 0.01;

/// A model that was followed through the data.
#[derive(Clone)]
pub(super) struct FollowedModel {
    /// The ranked model that it started from.
    pub start: usize,
    pub fit: OutputErrorFit,
    /// Nodes of an arc, at most; `usize::MAX` where trajectories were followed as far as chaos allows.
    pub longest: usize,
    /// The probability that noise of the measurement would follow the model's flow as its residual does, where that was
    /// asked: where the residual is larger than the noise or correlated.
    pub independence: Option<f64>,
    /// Coefficients of the fit without signs, where it is more likely by odds of 20 to 1.
    pub without_signs: Option<Vec<f64>>,
    /// The same of the fit without invariants, of all candidate terms.
    pub without_invariants: Option<Vec<f64>>,
    /// Known terms that have another coefficient where all are free, if that is more likely by odds of 20 to 1.
    pub without_known: Vec<FreedTerm>,
    /// What tests say of the prediction errors of a disturbed system.
    pub surprises: Option<Surprises>,
    /// Whether a disturbed system is about as likely.
    pub is_ambiguous: bool,
    /// What was seen of its terms on all rows, where they were chosen on a part of them.
    pub on_all_rows: Option<OnAllRows>,
    /// A term that no library has and the data speak for.
    pub absent: Option<Absent>,
}

impl FollowedModel {
    /// Whether its residual is noise of the measurement, however large.
    pub(super) fn is_in_noise(&self) -> bool {
        self.independence.is_some_and(|p| p > NOT_NOISE)
    }
}

/// What every search of an identification shares.
pub(super) struct Search<'s> {
    pub system: &'s System,
    /// Coefficients of the models to start from, best first.
    pub starts: &'s [Vec<f64>],
    pub pieces: &'s [Piece<'s>],
    pub term_rms: &'s [f64],
    /// Candidates that the system's were chosen from.
    pub chosen_from: usize,
    pub signs: &'s [Sign],
}

impl IdentificationRun<'_> {
    /// The best model by output error, with the inputs between samples that leave least; `None` where no trajectory could
    /// be followed, or none was asked for.
    pub(super) fn follow(
        &mut self,
        ranked: &[RankedModel],
        slopes: &Slopes,
        statistics: &Statistics,
        progress: &mut dyn FnMut(Progress),
    ) -> Option<FollowedModel> {
        if self.settings.method == Method::Regression {
            return None;
        }
        let states = self.data.states().len();
        let term_rms = match &self.conserved {
            Some(conserved) => conserved.field_rms(statistics),
            None => regress::term_rms(&statistics.grams),
        };
        let screen = Screen::of_large(self, ranked);
        let narrow = |values: &[f64]| match &screen {
            Some(screen) => screen.narrow(values),
            None => values.to_vec(),
        };
        let starts: Vec<Vec<f64>> = ranked.iter().map(|r| narrow(&r.coefficients)).collect();
        let kept_rms = narrow(&term_rms);
        let signs = self.signs.concat();
        let signs = match &screen {
            Some(screen) => screen.narrow(&signs),
            None => signs,
        };
        let mut with_inputs = |between: &[_]| {
            let rows = self.settings.rows;
            let search = Search {
                system: screen.as_ref().map_or(&self.system, |s| &s.system),
                starts: &starts,
                pieces: &prepare::pieces(&self.stretches, states, slopes, between, rows),
                term_rms: &kept_rms,
                chosen_from: term_rms.len(),
                signs: &signs,
            };
            let mut found = self.output_error(&search, progress)?;
            found.without_signs = self.without_signs(&found, &search);
            found.without_invariants = self.without_invariants(&found, &search, statistics);
            if let Some(screen) = &screen {
                screen.widen(&mut found);
            }
            Some(found)
        };
        let mut found = with_inputs(&self.inputs.between);
        let second = self.inputs.second.clone();
        if let Some(between) = second.filter(|_| !self.settings.discrete) {
            let other = with_inputs(&between);
            let left = |followed: &Option<FollowedModel>| {
                let followed = followed.as_ref();
                followed.map_or(f64::INFINITY, |f| self.misfit(&f.fit))
            };
            if left(&other) < left(&found) {
                self.inputs.between = between;
                found = other;
            }
        }
        let mut found = found?;
        let between = &self.inputs.between;
        let rows = self.settings.rows;
        let pieces = prepare::pieces(&self.stretches, states, slopes, between, rows);
        found.without_known = self.without_known(&found, &pieces);
        found.absent = self.absent(&found, &pieces);
        self.on_all_rows(&mut found, slopes, &term_rms, progress);
        Some(found)
    }

    /// The largest share of a state's noise (or of what is tolerated without noise) that is left.
    pub(super) fn misfit(&self, fit: &OutputErrorFit) -> f64 {
        largest_share(&fit.residual(), &self.noise.tolerated)
    }

    /// The output error from the best starts; with shorter arcs where whole trajectories cannot be followed.
    fn output_error(
        &self,
        search: &Search<'_>,
        progress: &mut dyn FnMut(Progress),
    ) -> Option<FollowedModel> {
        if let Some(sources) = sources(self.settings.noise) {
            return self.disturbed(search, sources, progress);
        }
        let mut best = None;
        // Scores of arcs of different lengths are not comparable, so each length starts again.
        for longest in LONGEST {
            best = self.best_of_starts(search, Way::Arcs(longest), progress);
            if let Some(best) = &best {
                if self.misfit(&best.fit) <= FOLLOWS {
                    break;
                }
                if longest == usize::MAX
                    && !self.settings.discrete
                    && let Some(model) = self.in_coloured_noise(best, search)
                {
                    return Some(self.likelier(model, search, progress));
                }
            }
            // In noise of its own a map is a regression.
            if self.settings.noise == NoiseSource::Measurement || self.settings.discrete {
                break;
            }
            if longest == usize::MAX
                && let Some(model) = self.explained(search, progress)
            {
                return Some(model);
            }
        }
        let mut best = best?;
        let correlated = best.fit.correlation > CORRELATED;
        self.drop_doubtful(&mut best, search);
        if self.settings.discrete {
            best.independence = self.independence(&best.fit, search);
            return Some(best);
        }
        // Of samples that are far apart, the noise is not known well enough to say that nothing else is left.
        let sparse = self.stretches.iter().any(|s| !s.seen.is_empty());
        if correlated || sparse {
            let whole = best.longest == usize::MAX && self.misfit(&best.fit) <= FOLLOWS;
            if whole && self.noise.is_visible() {
                let p = self.independence(&best.fit, search);
                best.independence = p.filter(|p| correlated || *p <= SPARSE);
            }
        }
        Some(best)
    }

    /// Chooses terms again where residuals are correlated, for what they are worth there, until none is more likely absent than
    /// not. Where all are likely, a model that follows the data goes on following them.
    pub(super) fn drop_doubtful(&self, best: &mut FollowedModel, search: &Search<'_>) {
        for round in 0..COLOUR_ROUNDS {
            let doubtful = is_doubtful(&best.fit);
            if !(doubtful || round == 0 && best.fit.correlation > CORRELATED) {
                return;
            }
            let Some(fit) = self.less_information(best, search) else {
                return;
            };
            if !doubtful && self.misfit(&fit) > FOLLOWS.max(self.misfit(&best.fit)) {
                return;
            }
            best.fit = fit;
        }
    }

    /// The search again, with terms worth as much less as there are fewer independent residuals.
    fn less_information(
        &self,
        from: &FollowedModel,
        search: &Search<'_>,
    ) -> Option<OutputErrorFit> {
        let mut limits = self.limits(from.longest);
        limits.penalty *= from.fit.correlation;
        let start = self.start(&from.fit.coefficients, &from.fit.sigma, search);
        from.way()
            .search(search.system, search.pieces, (&start, &limits), &mut silent)
    }

    /// The fit of whole trajectories for noise that is not white, if its residual is noise of the measurement: terms are worth
    /// what the colour of the residual leaves. The first choice of terms, which holds more of them, is tested as well: fewer
    /// terms leave more residual, in which a missing one is harder to see.
    fn in_coloured_noise(
        &self,
        found: &FollowedModel,
        search: &Search<'_>,
    ) -> Option<FollowedModel> {
        if let Some(model) = self.remembering(found, search) {
            return Some(model);
        }
        let mut model = found.clone();
        model.independence = self.independence(&model.fit, search);
        for _ in 0..COLOUR_ROUNDS {
            let settled = model.fit.correlation <= CORRELATED && !is_doubtful(&model.fit);
            if !model.is_in_noise() || settled {
                break;
            }
            let before = support(&model.fit.coefficients);
            model.fit = self.less_information(&model, search)?;
            if support(&model.fit.coefficients) == before {
                break;
            }
            model.independence = self.independence(&model.fit, search);
        }
        model.is_in_noise().then_some(model)
    }

    /// The fit of whole trajectories for noise that remembers from row to row, if what is new in its residual is noise of the
    /// measurement. Terms and memory depend on each other.
    fn remembering(&self, found: &FollowedModel, search: &Search<'_>) -> Option<FollowedModel> {
        let mut model = found.clone();
        let mut before = found.fit.colour.clone();
        for _ in 0..COLOUR_ROUNDS {
            let colour = output_error::colour_of(search.system, search.pieces, &model.fit);
            let mut start = self.start(&model.fit.coefficients, &model.fit.residual(), search);
            for (sigma, phi) in start.sigma.iter_mut().zip(&colour) {
                *sigma *= (1.0 - phi * phi).sqrt();
            }
            let moved = before.iter().zip(&colour).map(|(a, b)| (a - b).abs());
            let settled = !before.is_empty() && moved.fold(0.0, f64::max) < SAME_COLOUR;
            before.clone_from(&colour);
            start.colour = colour;
            let limits = self.limits(usize::MAX);
            let pieces = search.pieces;
            model.fit = output_error::search(search.system, pieces, &start, &limits, &mut silent)?;
            if settled {
                break;
            }
        }
        model.independence = self.independence(&model.fit, search);
        let white = output_error::is_white(search.system, search.pieces, &model.fit);
        (white && model.is_in_noise()).then_some(model)
    }

    /// How likely residuals of whole trajectories that are noise of the measurement, of any colour and size, would follow the
    /// model's flow as these do.
    fn independence(&self, fit: &OutputErrorFit, search: &Search<'_>) -> Option<f64> {
        output_error::independence(search.system, search.pieces, fit, &LONGEST[1..])
    }

    /// The best of a few starts with different terms; ends where two agree, or go on from the same point.
    pub(super) fn best_of_starts(
        &self,
        search: &Search<'_>,
        way: Way,
        progress: &mut dyn FnMut(Progress),
    ) -> Option<FollowedModel> {
        let longest = match way {
            Way::Arcs(longest) => longest,
            Way::Filter(_) => usize::MAX,
        };
        let limits = self.limits(longest);
        let mut best: Option<FollowedModel> = None;
        let mut tried: Vec<Vec<bool>> = Vec::new();
        // Where the searches that converged have settled on their way.
        let mut on_the_way: Vec<Settled> = Vec::new();
        for (index, coefficients) in search.starts.iter().enumerate() {
            let support = support(coefficients);
            if tried.len() == STARTS || tried.contains(&support) {
                continue;
            }
            let number = tried.len();
            tried.push(support);
            let from = self.start(coefficients, &self.noise.sigma, search);
            let mut met = false;
            let mut points = Vec::new();
            let mut report = |step: Step<'_>| {
                progress(Progress::OutputError {
                    start: number,
                    step: step.step,
                    terms: step.terms,
                    misfit: largest_share(step.sigma, &self.noise.sigma),
                });
                let Some(settled) = step.settled else {
                    return ControlFlow::Continue(());
                };
                met = on_the_way.iter().any(|point| point.meets(&settled));
                points.push(settled);
                match met {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            };
            let found = way.search(search.system, search.pieces, (&from, &limits), &mut report);
            if met {
                break;
            }
            let Some(fit) = found else { continue };
            if fit.outcome == Outcome::Converged {
                on_the_way.append(&mut points);
            }
            match &best {
                Some(b) if fit.score > b.fit.score - SAME_SCORE => {
                    let agree = (fit.score - b.fit.score).abs() <= SAME_SCORE;
                    if agree && fit.outcome == Outcome::Converged {
                        break;
                    }
                }
                _ => {
                    best = Some(FollowedModel {
                        start: index,
                        fit,
                        longest,
                        independence: None,
                        without_signs: None,
                        without_invariants: None,
                        without_known: Vec::new(),
                        surprises: None,
                        is_ambiguous: false,
                        on_all_rows: None,
                        absent: None,
                    });
                }
            }
        }
        best
    }

    pub(super) fn start(&self, coefficients: &[f64], sigma: &[f64], search: &Search<'_>) -> Start {
        Start {
            coefficients: coefficients.to_vec(),
            sigma: sigma.to_vec(),
            floor: self.noise.floor.clone(),
            term_rms: search.term_rms.to_vec(),
            chosen_from: search.chosen_from,
            signs: search.signs.to_vec(),
            colour: Vec::new(),
        }
    }

    pub(super) fn limits(&self, longest: usize) -> output_error::Settings {
        output_error::Settings {
            growth: self.settings.growth,
            iterations: self.settings.iterations,
            penalty: self.settings.penalty,
            longest,
            first_arc: FIRST_ARC,
            relevance: self.settings.relevance,
        }
    }
}

/// Whether a term is more likely absent than not. Where residuals are correlated, each term is worth less than it was chosen
/// for.
fn is_doubtful(fit: &OutputErrorFit) -> bool {
    let kept = (0..fit.coefficients.len()).filter(|&j| fit.coefficients[j] != 0.0);
    let mut worth = kept.map(|j| TermEvidence::of_output_error(fit, j).evidence);
    worth.any(|evidence| evidence < 0.0)
}

fn support(coefficients: &[f64]) -> Vec<bool> {
    coefficients.iter().map(|c| *c != 0.0).collect()
}

/// The largest of `left` as a share of `noise`.
fn largest_share(left: &[f64], noise: &[f64]) -> f64 {
    let shares = left.iter().zip(noise).map(|(left, noise)| left / noise);
    shares.fold(0.0, f64::max)
}
