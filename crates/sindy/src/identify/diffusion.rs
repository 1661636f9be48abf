//! Diffusions that depend on the state: what is looked for, and how the result is written.

use super::evidence::TermEvidence;
use super::run::IdentificationRun;
use super::{DiffusionTerm, NoiseSource, Settings};
use crate::data::dataset::{Dataset, Stretch, is_constant};
use crate::error::{SindyError, require};
use crate::library::Library;
use crate::trajectory::output_error::{OutputErrorFit, System};

/// Candidate terms of all states together, at most: the time grows with the square of their number.
const MOST_CANDIDATES: usize = 200;

/// Refuses settings that do not go together with a diffusion.
pub(super) fn check(settings: &Settings) -> Result<(), SindyError> {
    if settings.diffusion.is_empty() {
        return Ok(());
    }
    let refused = |expected: &str| {
        let found = settings.diffusion.join(", ");
        Err(SindyError::setting("diffusion", expected, found))
    };
    if settings.discrete {
        return refused("none in discrete time");
    }
    if !settings.second_order.is_empty() {
        return refused("none beside `second_order`");
    }
    match settings.noise {
        NoiseSource::Process | NoiseSource::Both => Ok(()),
        NoiseSource::Automatic | NoiseSource::Measurement => {
            refused("none unless `noise` is `process` or `both`")
        }
    }
}

/// The library of the squared diffusions; `None` where disturbances are taken to be constant.
pub(super) fn library(
    settings: &Settings,
    data: &Dataset,
    stretches: &[Stretch<'_>],
) -> Result<Option<Library>, SindyError> {
    if settings.diffusion.is_empty() {
        return Ok(None);
    }
    let mut states = data.states().iter().enumerate();
    if let Some((_, still)) = states.find(|(i, _)| is_constant(stretches, *i)) {
        return Err(SindyError::setting(
            "diffusion",
            "states that change",
            format!("one value of {still} in all rows: make it an input, or leave it out"),
        ));
    }
    let library = Library::specifications(&settings.diffusion, &data.names())?;
    let candidates = data.states().len() * library.len();
    require(
        candidates <= MOST_CANDIDATES,
        "diffusion",
        format!("at most {MOST_CANDIDATES} candidate terms of all states together"),
        candidates,
    )?;
    Ok(Some(library))
}

/// The system with the candidates of its diffusion.
pub(super) fn of(
    system: System,
    data: &Dataset,
    library: Option<&Library>,
) -> Result<System, SindyError> {
    match library {
        None => Ok(system),
        Some(library) => system.with_diffusion(&data.names(), library),
    }
}

impl IdentificationRun<'_> {
    /// The terms of each state's squared diffusion, where they were looked for and found.
    pub(super) fn diffusion_terms(&self, fit: &OutputErrorFit) -> Vec<Vec<DiffusionTerm>> {
        let none = vec![Vec::new(); self.data.states().len()];
        let found = fit.disturbance.as_ref().and_then(|d| d.diffusion.as_ref());
        let (Some(library), Some(found)) = (&self.diffusion, found) else {
            return none;
        };
        let terms: usize = found
            .coefficients
            .iter()
            .flatten()
            .filter(|c| **c != 0.0)
            .count();
        let degrees = (found.values as f64 - terms as f64).max(1.0);
        let of = |i: usize| {
            let kept = (0..library.len()).filter(move |&j| found.coefficients[i][j] != 0.0);
            let term = |j: usize| {
                let worth = TermEvidence {
                    std_error: found.std_errors[i][j],
                    degrees,
                    evidence: found.evidence[i][j],
                    ..TermEvidence::NONE
                };
                let coefficient = found.coefficients[i][j];
                DiffusionTerm {
                    term: library.names()[j].clone(),
                    coefficient,
                    std_error: worth.std_error,
                    inclusion: worth.inclusion(),
                    interval: worth.interval(coefficient),
                }
            };
            kept.map(term).collect()
        };
        (0..none.len()).map(of).collect()
    }

    /// What is to be known of the diffusion that was looked for: in the reason of the choice.
    pub(super) fn reason_of_diffusion(&self, fit: &OutputErrorFit) -> String {
        let terms = self.diffusion_terms(fit);
        if terms.iter().all(Vec::is_empty) {
            return String::new();
        }
        let constant = |of: &Vec<DiffusionTerm>| of.iter().all(|t| t.term == "1");
        let depends = self.data.states().iter().zip(&terms);
        let depends: Vec<&str> = depends
            .filter(|(_, of)| !constant(of))
            .map(|(state, _)| state.as_str())
            .collect();
        match depends.as_slice() {
            [] => "; the variance of every disturbance is a constant".into(),
            some => format!(
                "; the variance of the disturbance of {} depends on the state",
                some.join(", ")
            ),
        }
    }

    /// A warning where no sum of terms is a variance.
    pub(super) fn no_diffusion(&self, fit: &OutputErrorFit) -> Option<String> {
        let found = fit.disturbance.as_ref().and_then(|d| d.diffusion.as_ref());
        let asked = self.diffusion.is_some() && fit.disturbance.is_some();
        (asked && found.is_none()).then(|| {
            "no sum of few terms of the diffusion's library is positive on all rows, as a variance has to be: its variance is \
             taken to be constant. Add `1` or squares to `--diffusion`"
                .into()
        })
    }
}
