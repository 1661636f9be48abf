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
//! Its steps, in order, without any setting:
//!
//! 1. gives rows that lack a state no weight, or takes each state at its own times where more than one in twenty of its samples
//!    is followed by such rows; sets single gross errors of the states aside, leaves terms out that are a multiple of a simpler one on every row,
//!    sees what inputs are between their samples (held, linear, cubic), estimates each state's noise, and smooths with a
//!    strength taken from the data, where most of them rest from the part that moves, and over the number of the row where
//!    steps of time run over orders of magnitude;
//! 2. *regresses*: slopes and weak form, each by best subsets (exact, by the Bayesian criterion) and by SR3 over a
//!    grid of λ and ν (its choice by cross-validation over blocks, and every other support on it);
//! 3. ranks these models by *free-run error*: short simulations from smoothed states against the measured
//!    ones, the one yardstick that all of them share; where none can be run, the best subsets of one to four terms
//!    are models too;
//! 4. refines the best by [`output_error`](crate::trajectory::output_error), which judges all candidate terms again by the
//!    trajectory itself, from several starts until two agree;
//! 5. accepts that model if its trajectories follow the data to within the noise, or if what they leave is noise of the
//!    measurement by a test, of whatever colour and size; if not, fits a system with disturbances, and accepts it if its
//!    prediction errors are noise by tests; tries shorter arcs if not (the system is disturbed otherwise, or not in the
//!    library), and else keeps the best regression.
//!
//! Weights of rows (the inverse of their noise's variance, to a factor) count in regressions on slopes, in free runs and in
//! the output error. The noise estimate, smoothing and the weak form take all rows that have any weight alike: their
//! results are then equally unbiased, but less accurate than they could be. A warning states it where weights differ.
//!
//! [`Identification`] holds the choice, its reason, and every equation's front of terms against error.
//! Random numbers are not used. Rows that do not fit into memory pass once through [`stream`].

mod absent;
mod all_rows;
mod conserve;
mod contradictions;
mod diffusion;
mod discrete;
mod disturbed;
mod evidence;
mod exchange;
mod follow;
pub mod implicit;
mod inputs;
mod known;
mod likelier;
mod map_noise;
mod map_outliers;
mod missing;
mod model;
mod neighbours;
mod outliers;
mod prepare;
mod proportional;
mod rank;
pub(crate) mod regress;
mod result;
mod run;
mod screen;
mod second_order;
mod settings;
mod signs;
mod size;
mod stable;
pub mod stream;
#[cfg(test)]
mod tests;
mod time_scales;
mod uneven;
mod warnings;

pub use missing::aligned;
pub use result::{
    Candidate, Choice, DiffusionTerm, Equation, FrontPoint, Identification, Progress, ratio,
};
pub use second_order::{velocity, with_velocities};
pub use settings::{Between, Method, NoiseSource, Score, Settings, Smoothing};
pub use stable::Stability;
pub use stream::{Columns, PartialSums};

use std::borrow::Cow;

use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::{Term, Time};
use crate::trajectory::output_error::System;
use known::KnownPart;
use run::IdentificationRun;

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

    /// A library for each of `n` states.
    fn per_state(&self, n: usize) -> Result<Vec<Library>, SindyError> {
        match self.libraries.as_slice() {
            [one] => Ok(vec![one.clone(); n]),
            all if all.len() == n => Ok(all.to_vec()),
            all => Err(SindyError::shape(
                "libraries (one, or one per state)",
                n,
                all.len(),
            )),
        }
    }

    /// The data as they are worked on: no weight on rows that lack a state, gross errors set aside, velocities added.
    fn prepared<'d>(
        &self,
        data: &'d Dataset,
        warnings: &mut Vec<String>,
    ) -> Result<Cow<'d, Dataset>, SindyError> {
        let mut data = Cow::Borrowed(data);
        // In discrete time nothing may be bridged: the bridge would be the next sample.
        if !self.settings.discrete {
            data = self.complete(data, warnings)?;
        }
        if !self.settings.discrete
            && self.settings.outliers
            && let Some((mended, said)) = outliers::set_aside(&data)?
        {
            warnings.extend(said);
            data = Cow::Owned(mended);
        }
        size::check(&data)?;
        if !self.settings.second_order.is_empty() {
            data = Cow::Owned(with_velocities(&data, &self.settings.second_order)?);
        }
        Ok(data)
    }

    /// The data with something in every row: others are left out, or are between measured values.
    fn complete<'d>(
        &self,
        mut data: Cow<'d, Dataset>,
        warnings: &mut Vec<String>,
    ) -> Result<Cow<'d, Dataset>, SindyError> {
        if let Some((left, warning)) = missing::without_empty_rows(&data)? {
            warnings.push(warning);
            data = Cow::Owned(left);
        }
        if missing::is_by_state(&data) {
            let (aligned, said) = missing::by_state(&data, self.settings.inputs_between)?;
            warnings.extend(said);
            return Ok(Cow::Owned(aligned));
        }
        if let Some((bridged, warning)) = missing::without_weight(&data)? {
            warnings.push(warning);
            data = Cow::Owned(bridged);
        }
        Ok(data)
    }

    /// Identifies a model of `data`; `progress` hears what is being done.
    ///
    /// # Errors
    /// No data, fewer rows than terms, libraries that are not one or one per state, terms with unknown
    /// names, a smoothing that does not suit the times; in discrete time, rows that are neither one period apart nor at
    /// least one and a half.
    pub fn run(
        &self,
        data: &Dataset,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        let mut found = self.with_run(data, |run| run.go(progress))?;
        let left_out = data.report().rows - found.data.rows;
        found.data.rows += left_out;
        found.data.missing_rows += left_out;
        if left_out == 0 && !data.has_own_rates() {
            // As they were given, before rows were bridged.
            found.data = data.report();
        }
        Ok(found)
    }

    /// Time, and the stretches of the data that are looked at.
    fn stretches<'d>(
        &self,
        data: &'d Dataset,
        warnings: &mut Vec<String>,
    ) -> Result<(Time, Vec<Stretch<'d>>), SindyError> {
        let stretches = data.stretches();
        if !self.settings.discrete {
            warnings.extend(warnings::weights_differ(
                stretches.iter().filter_map(|s| s.weights).flatten(),
            ));
            return Ok((Time::Continuous, stretches));
        }
        let period = data.report().period;
        let time = Time::Discrete { period };
        if stretches.is_empty() {
            return Ok((time, stretches));
        }
        let (cut, warning) = discrete::one_period(data, &stretches, period)?;
        warnings.extend(warning);
        Ok((time, discrete::with_weight(&cut)))
    }

    /// Prepares an identification of `data` and hands it to `work`.
    fn with_run<R>(
        &self,
        data: &Dataset,
        work: impl FnOnce(IdentificationRun<'_>) -> Result<R, SindyError>,
    ) -> Result<R, SindyError> {
        let mut warnings = Vec::new();
        let prepared = self.prepared(data, &mut warnings)?;
        let data = &*prepared;
        let second_order = &self.settings.second_order;
        let positions = second_order::places(data, second_order)?;
        let n = data.states().len();
        let known = known::of(
            &self.settings.known,
            data,
            second_order,
            self.settings.discrete,
        )?;
        let libraries: Vec<Library> = self.per_state(n)?;
        let libraries: Vec<(Library, KnownPart)> = libraries
            .iter()
            .zip(known)
            .map(|(library, known)| (known.remaining(library), known))
            .collect();
        let signs = signs::of(
            &self.settings.signs,
            data,
            &libraries,
            self.settings.discrete,
        )?;
        let (libraries, known): (Vec<Library>, Vec<KnownPart>) = libraries.into_iter().unzip();
        let (time, mut stretches) = self.stretches(data, &mut warnings)?;
        if self.settings.discrete
            && self.settings.outliers
            && let Some(without) = map_outliers::set_aside(data, &stretches, &libraries, &known)?
        {
            stretches = without.stretches;
            warnings.extend(without.warnings);
        }
        let libraries = libraries
            .into_iter()
            .map(|library| {
                proportional::without_multiples(library, data, &stretches, &mut warnings)
            })
            .collect::<Result<Vec<_>, SindyError>>()?;
        warnings.dedup();
        let signs = signs::by_candidate(&signs, &libraries, &mut warnings);
        check_rows(stretches.iter().map(|s| s.time.len()).sum(), &libraries)?;
        let terms: Vec<Vec<Term>> = known.iter().map(|k| k.terms.clone()).collect();
        let states = (data.states(), n - positions.len());
        let free = System::with_known(time, states, data.inputs(), &libraries, &terms)?
            .stiff(!self.settings.discrete && prepare::is_steep(&stretches));
        let diffusion = diffusion::library(&self.settings, data, &stretches)?;
        let free = diffusion::of(free, data, diffusion.as_ref())?;
        let stable =
            stable::StableCandidates::of(&self.settings, states.0, &libraries, &stretches)?;
        let (system, conserved) = match stable.as_ref().filter(|s| s.is_quadratic()) {
            Some(stable) => conserve::of_energy(stable.energy_changes(), &libraries, free)?,
            None => conserve::of(&self.settings, data, &libraries, &stretches, free)?,
        };
        let signs = conserved.as_ref().map_or(signs, |_| vec![Vec::new()]);
        let mut noise = prepare::noise(&stretches, n);
        noise.of_velocities(&positions);
        work(IdentificationRun {
            data,
            settings: &self.settings,
            system,
            conserved,
            diffusion,
            stable,
            libraries: libraries.into_iter().zip(known).collect(),
            signs,
            positions,
            time,
            noise,
            inputs: inputs::choose(&stretches, n, self.settings.inputs_between),
            stretches,
            warnings,
        })
    }
}

/// Refuses data of fewer rows than the largest library has terms.
fn check_rows(rows: usize, libraries: &[Library]) -> Result<(), SindyError> {
    let terms = libraries.iter().map(Library::len).max().unwrap_or(0);
    if rows > terms {
        return Ok(());
    }
    let what = "usable rows (more than the library has terms)";
    Err(SindyError::shape(what, terms + 1, rows))
}
