//! One identification, from slopes to the accepted model.

use super::inputs;
use super::prepare::{self, Noise, Slopes};
use super::regress::{self, Regression, Statistics};
use super::{Identification, Method, Progress, Settings, Smoothing, warnings};
use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::{Interpolation, Time};
use crate::solve::outcome::Outcome;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::{self, Found, Piece, Start, System, free_run};

/// A fit follows the data if it leaves no state more than this times its noise.
pub(super) const FOLLOWS: f64 = 1.5;
/// Candidates above which the output error looks only at terms that regressions met.
const MOST_CANDIDATES: usize = 400;
/// Rows that models are ranked on, about.
pub(super) const RANKED: usize = 10_000;
/// Starts of the output error, at most.
const STARTS: usize = 3;
/// Residuals that stand for less than one in so many independent ones are correlated.
pub(super) const CORRELATED: f64 = 2.0;

/// One identification under way.
pub(super) struct Run<'a> {
    pub data: &'a Dataset,
    pub settings: &'a Settings,
    pub libraries: Vec<Library>,
    pub system: System,
    pub time: Time,
    pub stretches: Vec<Stretch<'a>>,
    pub noise: Noise,
    pub inputs: inputs::Choice,
    pub warnings: Vec<String>,
}

/// What the output error found.
pub(super) struct Followed {
    /// The ranked model that it started from.
    pub start: usize,
    pub found: Found,
    /// Nodes of an arc, at most; `usize::MAX` where trajectories were followed as far as chaos allows.
    pub longest: usize,
}

/// A model by regression, with what it is ranked by.
pub(super) struct Ranked {
    pub regression: Regression,
    pub coefficients: Vec<f64>,
    pub free_run: f64,
}

impl Run<'_> {
    pub(super) fn go(
        mut self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        progress(Progress::Smoothing);
        let n = self.data.states().len();
        let (slopes, statistics) = self.regressions(progress)?;
        self.warnings.extend(warnings::of_data(
            &self.data.report(),
            &statistics[0],
            &self.libraries,
            &self.data.samples()?,
        )?);
        let between = self.inputs.between.clone();
        let pieces = prepare::pieces(&self.stretches, n, &slopes, &between, self.settings.rows);
        let term_rms: Vec<f64> = statistics[0]
            .grams
            .iter()
            .flat_map(|parts| Gram::total(parts).column_rms().as_slice().to_vec())
            .collect();
        let yardstick = prepare::pieces(
            &self.stretches,
            n,
            &slopes,
            &between,
            self.settings.rows.min(RANKED),
        );
        let mut regressions = Vec::new();
        for statistics in &statistics {
            regressions.extend(regress::solve(statistics, self.settings)?);
        }
        if self.settings.discrete {
            self.noise.of_map(&statistics[0], &regressions);
        }
        let rank = |regression: Regression| {
            let fits = regression.fits.iter();
            let coefficients: Vec<f64> =
                fits.flat_map(|f| f.coefficients.iter().copied()).collect();
            Ranked {
                free_run: free_run(&self.system, &yardstick, &coefficients, &self.noise.sigma),
                coefficients,
                regression,
            }
        };
        let mut ranked: Vec<Ranked> = regressions.into_iter().map(rank).collect();
        if !ranked.iter().any(|r| r.free_run.is_finite()) {
            // Criteria keep too much where data hardly tell terms apart.
            for statistics in &statistics {
                ranked.extend(regress::sparse(statistics)?.into_iter().map(rank));
            }
        }
        // Fewer terms first among those that predict alike.
        ranked.sort_by(|a, b| {
            let rounded = |r: &Ranked| (r.free_run * 50.0).round();
            let terms = |r: &Ranked| r.coefficients.iter().filter(|c| **c != 0.0).count();
            rounded(a)
                .total_cmp(&rounded(b))
                .then(terms(a).cmp(&terms(b)))
        });
        let found = match self.settings.method {
            Method::Regression => None,
            _ => self.output_error(&ranked, &pieces, &term_rms, progress),
        };
        let found = match &self.inputs.second {
            Some(second) if !self.settings.discrete => {
                let held = prepare::pieces(&self.stretches, n, &slopes, second, self.settings.rows);
                let second = second.clone();
                self.better(found, &ranked, (&held, second), &term_rms, progress)
            }
            _ => found,
        };
        // What was followed in short pieces only has to predict better than regressions do.
        let follows = found
            .as_ref()
            .is_some_and(|f| f.longest == usize::MAX && self.misfit(&f.found) <= FOLLOWS);
        match found {
            Some(followed)
                if self.settings.method == Method::OutputError
                    || (follows && !self.settings.discrete) =>
            {
                self.of_output_error(&ranked, &followed)
            }
            Some(followed) => {
                let free = free_run(
                    &self.system,
                    &yardstick,
                    &followed.found.coefficients,
                    &self.noise.sigma,
                );
                if free < 0.98 * ranked[0].free_run {
                    self.of_output_error(&ranked, &followed)
                } else {
                    self.of_regression(&ranked, &statistics)
                }
            }
            None => self.of_regression(&ranked, &statistics),
        }
    }

    /// Slopes by every method that is asked for; those of the first stand for the trajectories.
    fn regressions(
        &self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(Slopes, Vec<Statistics>), SindyError> {
        let n = self.data.states().len();
        let smoothing = &self.settings.smoothing;
        let mut statistics = Vec::new();
        if self.settings.discrete {
            let slopes = prepare::raw(&self.stretches, n);
            self.add(&slopes, &self.stretches, &mut statistics, progress)?;
            return Ok((slopes, statistics));
        }
        if let Some(method) = smoothing.differentiator()? {
            let slopes = prepare::with(&self.stretches, n, method)?;
            self.add(&slopes, &self.stretches, &mut statistics, progress)?;
            return Ok((slopes, statistics));
        }
        // Where most of the data rest, what moves comes first, with a smoothing of its own.
        let moving = prepare::moving(&self.stretches, n, &self.noise);
        let mut first = None;
        for (index, part) in moving.iter().chain([&self.stretches]).enumerate() {
            // By name a regression finds its statistics again.
            let place = match moving.is_some() && index == 0 {
                true => ", of what moves",
                false => "",
            };
            let uniform = self.data.report().uniform;
            let both: &[f64] = match *smoothing == Smoothing::Automatic && uniform {
                true => &[1.0, 2.0],
                false => &[1.0],
            };
            for wider in both {
                let filters = prepare::filters(part, n, uniform, *wider)?;
                let mut slopes = prepare::by(filters.as_deref(), part, n)?;
                slopes.name.push_str(place);
                if *smoothing != Smoothing::Weak {
                    self.add(&slopes, part, &mut statistics, progress)?;
                }
                if first.is_none() {
                    first = Some(prepare::by(filters.as_deref(), &self.stretches, n)?);
                }
            }
            if matches!(smoothing, Smoothing::Automatic | Smoothing::Weak) {
                progress(Progress::Regression {
                    smoothing: "weak form".into(),
                });
                let folds = self.settings.folds;
                let weak = regress::of_weak_form(self.data, part, &self.libraries, folds)?;
                statistics.extend(weak.map(|mut weak| {
                    weak.smoothing.push_str(place);
                    weak
                }));
            }
        }
        match first {
            Some(slopes) if !statistics.is_empty() => Ok((slopes, statistics)),
            _ => Err(SindyError::setting(
                "smoothing",
                "stretches that hold a window of the weak form",
                "shorter ones",
            )),
        }
    }

    /// Adds the statistics of slopes.
    fn add(
        &self,
        slopes: &Slopes,
        stretches: &[Stretch<'_>],
        statistics: &mut Vec<Statistics>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(), SindyError> {
        progress(Progress::Regression {
            smoothing: slopes.name.clone(),
        });
        let folds = self.settings.folds;
        statistics.push(regress::of_slopes(
            self.data,
            stretches,
            &self.libraries,
            slopes,
            folds,
        )?);
        Ok(())
    }

    /// The largest share of a state's noise (or of what is tolerated without noise) that is left.
    pub(super) fn misfit(&self, found: &Found) -> f64 {
        found
            .sigma
            .iter()
            .zip(&self.noise.tolerated)
            .map(|(left, noise)| left / noise)
            .fold(0.0, f64::max)
    }

    /// `first`, or what the output error finds with inputs that are something else between samples, if that leaves
    /// less.
    fn better(
        &mut self,
        first: Option<Followed>,
        ranked: &[Ranked],
        (pieces, between): (&[Piece<'_>], Vec<Interpolation>),
        term_rms: &[f64],
        progress: &mut dyn FnMut(Progress),
    ) -> Option<Followed> {
        let second = match self.settings.method {
            Method::Regression => None,
            _ => self.output_error(ranked, pieces, term_rms, progress),
        };
        let left = |found: &Option<Followed>| {
            let found = found.as_ref();
            found.map_or(f64::INFINITY, |f| self.misfit(&f.found))
        };
        if left(&second) < left(&first) {
            self.inputs.between = between;
            second
        } else {
            first
        }
    }

    /// The output error from the best starts; with shorter arcs where whole trajectories cannot be followed.
    fn output_error(
        &self,
        ranked: &[Ranked],
        pieces: &[Piece<'_>],
        term_rms: &[f64],
        progress: &mut dyn FnMut(Progress),
    ) -> Option<Followed> {
        let mut best: Option<Followed> = None;
        for longest in [usize::MAX, 32, 8] {
            let mut tried: Vec<Vec<bool>> = Vec::new();
            for (index, start) in ranked.iter().enumerate() {
                let support: Vec<bool> = start.coefficients.iter().map(|c| *c != 0.0).collect();
                if tried.len() == STARTS || tried.contains(&support) {
                    continue;
                }
                let number = tried.len();
                tried.push(support);
                let limits = self.limits(longest);
                let from = Start {
                    coefficients: start.coefficients.clone(),
                    sigma: self.noise.sigma.clone(),
                    floor: self.noise.floor.clone(),
                    candidates: self.screened(ranked),
                    term_rms: term_rms.to_vec(),
                };
                let found = output_error::search(&self.system, pieces, &from, &limits, &mut |s| {
                    progress(Progress::OutputError {
                        start: number,
                        step: s.step,
                        terms: s.terms,
                        misfit: s
                            .sigma
                            .iter()
                            .zip(&self.noise.sigma)
                            .map(|(left, noise)| left / noise)
                            .fold(0.0, f64::max),
                    });
                });
                let Some(found) = found else { continue };
                match &best {
                    Some(b) if found.score > b.found.score - 1.0 => {
                        let agree = (found.score - b.found.score).abs() <= 1.0;
                        if agree && found.outcome == Outcome::Converged {
                            break;
                        }
                    }
                    _ => {
                        best = Some(Followed {
                            start: index,
                            found,
                            longest,
                        });
                    }
                }
            }
            if best
                .as_ref()
                .is_some_and(|b| self.misfit(&b.found) <= FOLLOWS)
            {
                break;
            }
            if longest > 8 {
                // Scores of differently cut arcs do not compare.
                best = None;
            }
        }
        let mut best = best?;
        if best.found.correlation > CORRELATED {
            // A term is worth as much less as there are fewer independent residuals.
            let mut limits = self.limits(best.longest);
            limits.penalty *= best.found.correlation;
            let from = Start {
                coefficients: best.found.coefficients.clone(),
                sigma: best.found.sigma.clone(),
                floor: self.noise.floor.clone(),
                candidates: self.screened(ranked),
                term_rms: term_rms.to_vec(),
            };
            let again = output_error::search(&self.system, pieces, &from, &limits, &mut |_| ());
            if let Some(found) = again
                && self.misfit(&found) <= FOLLOWS.max(self.misfit(&best.found))
            {
                best.found = found;
            }
        }
        Some(best)
    }

    fn limits(&self, longest: usize) -> output_error::Settings {
        output_error::Settings {
            growth: self.settings.growth,
            iterations: self.settings.iterations,
            penalty: self.settings.penalty,
            longest,
            relevance: self.settings.relevance,
        }
    }

    /// The candidates that the output error looks at: all, or those that a regression met.
    fn screened(&self, ranked: &[Ranked]) -> Option<Vec<bool>> {
        let size = ranked.first()?.coefficients.len();
        if size <= MOST_CANDIDATES {
            return None;
        }
        let mut met = vec![false; size];
        for r in ranked {
            for (met, c) in met.iter_mut().zip(&r.coefficients) {
                *met |= *c != 0.0;
            }
        }
        Some(met)
    }
}
