//! The automatic identification: from a data set to a model with one call.
//!
//! ```
//! use sindy::{Dataset, Identify, Library, problems};
//!
//! let problem = problems::lotka_volterra();
//! let mut data = Dataset::new(&problem.states, &problem.inputs)?;
//! for record in problem.noisy(5.0, 1)? {
//!     data.push("run", record.time, record.states, None)?;
//! }
//! let library = Library::polynomial(&["x", "y"], 3)?;
//! let found = Identify::new(library).run(&data, &mut |_| ())?;
//! assert_eq!(found.model.terms(), 4); // x' = a x - b x y, y' = -c y + d x y
//! println!("{:.3}\n{}", found.model, found.choice.reason);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! What it does, in order, with nothing to be set:
//!
//! 1. estimates each state's noise, and smooths with a strength taken from the data;
//! 2. *regresses*: slopes and weak form, each by best subsets (exact, by the Bayesian criterion) and by SR3
//!    (λ and ν by cross-validation over blocks);
//! 3. ranks these models by *free-run error*: short simulations from smoothed states against the measured
//!    ones, the one yardstick that all of them share;
//! 4. refines the best by [`output_error`](crate::output_error), which judges all candidate terms anew by the
//!    trajectory itself, from several starts until two agree;
//! 5. accepts that model if its trajectories follow the data to within the noise, tries shorter arcs if they
//!    do not (the system is disturbed, or not in the library), and else keeps the best regression.
//!
//! [`Identification`] says what was chosen and why, with every equation's front of terms against error.
//! Random numbers are not used.

mod model;
mod prepare;
mod regress;
mod settings;
#[cfg(test)]
mod tests;

use serde::Serialize;

pub use settings::{Method, Settings, Smoothing};

use crate::dataset::{DataReport, Dataset, Stretch};
use crate::error::SindyError;
use crate::gram::Gram;
use crate::identifiability::examine;
use crate::library::Library;
use crate::model::{Model, Time};
use crate::outcome::Outcome;
use crate::output_error::{self, Found, Piece, Start, System, free_run};
use prepare::{Noise, Slopes};
use regress::{Regression, Statistics};

/// A fit follows the data if it leaves no state more than this times its noise.
const FOLLOWS: f64 = 1.5;
/// Candidates above which the output error looks only at terms that regressions met.
const MOST_CANDIDATES: usize = 400;
/// Starts of the output error, at most.
const STARTS: usize = 3;
/// A condition of the scaled library above which collinear terms are named.
const CONDITION: f64 = 1e4;

/// What the automatic identification is doing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Progress {
    /// Smoothing and differentiating.
    Smoothing,
    /// Regressing, with these slopes.
    Regression {
        /// Where slopes come from.
        smoothing: String,
    },
    /// A Gauss–Newton step of the output error.
    OutputError {
        /// The start, from 0.
        start: usize,
        /// Steps from this start.
        step: usize,
        /// Terms kept at present.
        terms: usize,
        /// Largest share of a state's noise that is left, 1 being the aim.
        misfit: f64,
    },
}

/// Why the model is what it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// How coefficients were determined: `output_error`, `best_subset` or `sr3`.
    pub method: String,
    /// λ of SR3, one for each equation, where it made the start or the model.
    pub lambda: Option<Vec<f64>>,
    /// ν of SR3, likewise.
    pub nu: Option<Vec<f64>>,
    /// Where slopes came from.
    pub smoothing: String,
    /// In a sentence or two.
    pub reason: String,
}

/// One number of terms of one equation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontPoint {
    /// The best terms of this number.
    pub terms: Vec<String>,
    /// Their error, in [`Equation::unit`].
    pub error: f64,
    /// Whether no other terms of this number are better, by proof.
    pub proven: bool,
    /// Whether these are the model's terms.
    pub chosen: bool,
}

/// One equation and its alternatives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equation {
    /// The state.
    pub state: String,
    /// Estimated noise on it.
    pub noise: f64,
    /// Root mean square of what the model leaves of it, as far as trajectories were followed.
    pub residual: Option<f64>,
    /// Terms against error, the other equations held.
    pub front: Vec<FrontPoint>,
    /// What the front's error is.
    pub unit: &'static str,
}

/// A model that was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Solver and smoothing.
    pub name: String,
    /// Terms in all equations.
    pub terms: usize,
    /// Root mean square of short simulations from smoothed states, in units of the noise.
    pub free_run: f64,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The model, with standard errors and inclusion probabilities.
    pub model: Model,
    /// One for each state.
    pub equations: Vec<Equation>,
    /// What was chosen and why.
    pub choice: Choice,
    /// Everything that was compared.
    pub candidates: Vec<Candidate>,
    /// Why the last solver stopped.
    pub outcome: Outcome,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// What the data hold.
    pub data: DataReport,
}

/// The automatic identification.
#[derive(Clone, Debug)]
pub struct Identify {
    libraries: Vec<Library>,
    settings: Settings,
}

impl Identify {
    /// With one library for all equations and the automatic choice throughout.
    #[must_use]
    pub fn new(library: Library) -> Self {
        Self::per_equation(vec![library])
    }

    /// With a library for each equation, in the order of the states.
    #[must_use]
    pub fn per_equation(libraries: Vec<Library>) -> Self {
        Self {
            libraries,
            settings: Settings::default(),
        }
    }

    /// The same with other settings.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn settings(self, settings: Settings) -> Result<Self, SindyError> {
        settings.validate()?;
        Ok(Self { settings, ..self })
    }

    /// Identifies a model of `data`; `progress` hears what is being done.
    ///
    /// # Errors
    /// No data, fewer rows than terms, libraries that are not one or one per state, terms with unknown
    /// names, a smoothing that does not suit the times.
    pub fn run(
        &self,
        data: &Dataset,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        let n = data.states().len();
        let libraries = match self.libraries.len() {
            1 => vec![self.libraries[0].clone(); n],
            found if found == n => self.libraries.clone(),
            found => {
                return Err(SindyError::Shape {
                    what: "libraries (one, or one per state)",
                    expected: n,
                    found,
                });
            }
        };
        let time = match self.settings.discrete {
            false => Time::Continuous,
            true => Time::Discrete {
                period: data.report().period,
            },
        };
        let stretches = data.stretches();
        let rows: usize = stretches.iter().map(|s| s.time.len()).sum();
        let terms = libraries.iter().map(Library::len).max().unwrap_or(0);
        if rows <= terms {
            return Err(SindyError::Shape {
                what: "usable rows (more than the library has terms)",
                expected: terms + 1,
                found: rows,
            });
        }
        Run {
            data,
            settings: &self.settings,
            system: System::new(time, data.states(), data.inputs(), &libraries)?,
            libraries,
            time,
            noise: prepare::noise(&stretches, n),
            stretches,
            warnings: Vec::new(),
        }
        .go(progress)
    }
}

/// One identification under way.
struct Run<'a> {
    data: &'a Dataset,
    settings: &'a Settings,
    libraries: Vec<Library>,
    system: System,
    time: Time,
    stretches: Vec<Stretch<'a>>,
    noise: Noise,
    warnings: Vec<String>,
}

/// A model by regression, with what it is ranked by.
struct Ranked {
    regression: Regression,
    coefficients: Vec<f64>,
    free_run: f64,
}

impl Run<'_> {
    fn go(mut self, progress: &mut dyn FnMut(Progress)) -> Result<Identification, SindyError> {
        progress(Progress::Smoothing);
        let n = self.data.states().len();
        let (slopes, statistics) = self.regressions(progress)?;
        self.look_at_data(&statistics[0])?;
        let pieces = prepare::pieces(&self.stretches, n, &slopes, self.settings.rows);
        let mut ranked = Vec::new();
        for statistics in &statistics {
            for regression in regress::solve(statistics, self.settings)? {
                let coefficients: Vec<f64> = regression
                    .fits
                    .iter()
                    .flat_map(|f| f.coefficients.iter().copied())
                    .collect();
                ranked.push(Ranked {
                    free_run: free_run(&self.system, &pieces, &coefficients, &self.noise.sigma),
                    coefficients,
                    regression,
                });
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
            _ => self.output_error(&ranked, &pieces, progress),
        };
        let follows = found
            .as_ref()
            .is_some_and(|(_, f)| self.misfit(f) <= FOLLOWS);
        match found {
            Some((start, found)) if follows || self.settings.method == Method::OutputError => {
                self.of_output_error(&ranked, start, &found)
            }
            Some((start, found)) => {
                let free = free_run(
                    &self.system,
                    &pieces,
                    &found.coefficients,
                    &self.noise.sigma,
                );
                if free < 0.98 * ranked[0].free_run {
                    self.of_output_error(&ranked, start, &found)
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
        let (data, stretches) = (self.data, &self.stretches);
        let n = data.states().len();
        let folds = self.settings.folds;
        let mut all = Vec::new();
        if self.settings.discrete {
            all.push(prepare::raw(stretches, n));
        } else if let Some(method) = self.settings.smoothing.differentiator()? {
            all.push(prepare::with(stretches, n, method)?);
        } else {
            let uniform = data.report().uniform;
            all.push(prepare::chosen(stretches, n, uniform, 1.0)?);
            if uniform && self.settings.smoothing == Smoothing::Automatic {
                all.push(prepare::chosen(stretches, n, uniform, 2.0)?);
            }
        }
        let mut statistics = Vec::new();
        for slopes in &all {
            progress(Progress::Regression {
                smoothing: slopes.name.clone(),
            });
            statistics.push(regress::of_slopes(
                data,
                stretches,
                &self.libraries,
                slopes,
                folds,
            )?);
        }
        let weak = matches!(
            self.settings.smoothing,
            Smoothing::Automatic | Smoothing::Weak
        );
        if weak && !self.settings.discrete {
            progress(Progress::Regression {
                smoothing: "weak form".into(),
            });
            let found = regress::of_weak_form(data, stretches, &self.libraries, folds)?;
            if self.settings.smoothing == Smoothing::Weak && found.is_some() {
                statistics.clear();
            }
            statistics.extend(found);
        }
        Ok((all.swap_remove(0), statistics))
    }

    /// Warnings about the data before anything is fitted.
    fn look_at_data(&mut self, statistics: &Statistics) -> Result<(), SindyError> {
        let report = self.data.report();
        if report.missing_rows + report.holes + report.short_rows > 0 {
            self.warnings.push(format!(
                "gaps split the trajectories into {} stretches: {} rows with missing values, {} jumps of time, {} \
                 rows in stretches too short to use",
                report.stretches, report.missing_rows, report.holes, report.short_rows
            ));
        }
        let all = self.data.samples()?;
        for (i, parts) in statistics.grams.iter().enumerate() {
            if self.libraries[..i].contains(&self.libraries[i]) {
                continue;
            }
            let total = Gram::total(parts);
            if total.skipped > 0 {
                self.warnings.push(format!(
                    "{} of {} rows left out of the regression: a term of the library is not finite there",
                    total.skipped,
                    total.skipped + total.rows
                ));
            }
            let found = examine(&self.libraries[i], &total, &all)?;
            if !found.zero_terms.is_empty() {
                self.warnings.push(format!(
                    "terms that are zero throughout: {}",
                    found.zero_terms.join(", ")
                ));
            }
            for (condition, terms) in found.collinear.iter().filter(|c| c.0 > CONDITION) {
                self.warnings.push(format!(
                    "nearly collinear terms (condition {condition:.1e}): {}",
                    terms.join(", ")
                ));
            }
            for column in found.inputs.iter().filter(|c| c.hardly_excited) {
                self.warnings.push(format!(
                    "column `{}` hardly moves: mean {:.4}, standard deviation {:.2e}",
                    column.name, column.mean, column.sd
                ));
            }
        }
        self.warnings.dedup();
        Ok(())
    }

    /// The largest share of a state's noise that is left.
    fn misfit(&self, found: &Found) -> f64 {
        found
            .sigma
            .iter()
            .zip(&self.noise.sigma)
            .map(|(left, noise)| left / noise)
            .fold(0.0, f64::max)
    }

    /// The output error from the best starts; with shorter arcs where whole trajectories cannot be followed.
    fn output_error(
        &self,
        ranked: &[Ranked],
        pieces: &[Piece<'_>],
        progress: &mut dyn FnMut(Progress),
    ) -> Option<(usize, Found)> {
        let mut best: Option<(usize, Found)> = None;
        for longest in [usize::MAX, 32, 8] {
            let mut tried: Vec<Vec<bool>> = Vec::new();
            for (index, start) in ranked.iter().enumerate() {
                let support: Vec<bool> = start.coefficients.iter().map(|c| *c != 0.0).collect();
                if tried.len() == STARTS || tried.contains(&support) {
                    continue;
                }
                let number = tried.len();
                tried.push(support);
                let limits = output_error::Settings {
                    growth: self.settings.growth,
                    iterations: self.settings.iterations,
                    penalty: self.settings.penalty,
                    longest,
                };
                let from = Start {
                    coefficients: start.coefficients.clone(),
                    sigma: self.noise.sigma.clone(),
                    floor: self.noise.floor.clone(),
                    candidates: self.screened(ranked),
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
                    Some((_, b)) if found.score > b.score - 1.0 => {
                        let agree = (found.score - b.score).abs() <= 1.0;
                        if agree && found.outcome == Outcome::Converged {
                            break;
                        }
                    }
                    _ => best = Some((index, found)),
                }
            }
            if best
                .as_ref()
                .is_some_and(|(_, f)| self.misfit(f) <= FOLLOWS)
            {
                return best;
            }
            if longest > 8 {
                // Scores of differently cut arcs do not compare.
                best = None;
            }
        }
        best
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
