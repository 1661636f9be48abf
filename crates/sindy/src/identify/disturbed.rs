//! Systems that are disturbed: whether disturbances explain what trajectories leave.
//!
//! A missing term looks like a disturbance to the filter, which follows it with a larger gain. Two things tell them apart. What a
//! filter with the right variances has not predicted is white, at all lags. And a missing term depends on the state, so that rows that are
//! neighbours there are wrong alike, in one step or in the sum of several.

use std::ops::ControlFlow;

use super::follow::{FollowedModel, Search};
use super::neighbours;
use super::run::IdentificationRun;
use super::{NoiseSource, Progress, uneven};
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::trajectory::output_error::disturbed::{self, Innovations};
use crate::trajectory::output_error::{
    self, OutputErrorFit, Piece, Settings, Sources, Start, Step, System,
};

/// Level of each test: of truly disturbed systems one in twenty is refused by all together, and goes on as one whose noise is not
/// explained.
const LEVEL: f64 = 0.01;
/// Rows whose prediction errors are summed and compared among neighbours: what a missing term does in one step hides in the noise,
/// and adds up.
const SUMMED: [usize; 3] = [1, 8, 32];

/// How a model is compared with data.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    /// Along arcs of at most this number of nodes.
    Arcs(usize),
    /// Row by row, by a filter.
    Filter(Sources),
}

impl Way {
    /// The search for terms and coefficients.
    pub(super) fn search(
        self,
        system: &System,
        pieces: &[Piece<'_>],
        (start, limits): (&Start, &Settings),
        progress: &mut dyn FnMut(Step<'_>) -> ControlFlow<()>,
    ) -> Option<OutputErrorFit> {
        match self {
            Self::Arcs(_) => output_error::search(system, pieces, start, limits, progress),
            Self::Filter(sources) => {
                disturbed::search(system, pieces, (start, sources), limits, progress)
            }
        }
    }
}

/// What is estimated where the source of the noise is given; nothing where it is the measurement, or is to be found.
pub(super) fn sources(noise: NoiseSource) -> Option<Sources> {
    match noise {
        NoiseSource::Automatic | NoiseSource::Measurement => None,
        NoiseSource::Process => Some(Sources::Process),
        NoiseSource::Both => Some(Sources::Both),
    }
}

/// What tests say of prediction errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surprises {
    /// Whether neighbouring rows are not correlated.
    pub white: bool,
    /// The least probability that errors which do not depend on the state would be as alike among neighbours as these.
    pub alike: f64,
    /// The state whose squared errors depend on the state most, and the least probability, for all states together, that those of
    /// constant size would; `None` above [`LEVEL`].
    pub uneven: Option<(usize, f64)>,
    /// Whether terms of the diffusion were looked for.
    pub with_diffusion: bool,
}

impl Surprises {
    /// Whether they are noise.
    pub(super) fn are_noise(self) -> bool {
        self.white && self.alike > LEVEL
    }

    /// Why they are not.
    pub(super) fn warning(self) -> String {
        let why = match self.white {
            false => {
                "errors of the next row are correlated with those of the row before".to_owned()
            }
            true => format!(
                "rows that are neighbours have prediction errors that are alike (p = {:.2})",
                self.alike
            ),
        };
        format!("{why}: the system is not disturbed by white noise, or is not in the library")
    }

    /// That the size of disturbances depends on the state in a way that the model does not have.
    pub(super) fn warning_of_size(self, states: &[String]) -> Option<String> {
        let (i, p) = self.uneven?;
        let state = &states[i];
        Some(match self.with_diffusion {
            false => format!(
                "squared prediction errors of {state} depend on the state (p = {p:.0e}): the disturbance has no constant variance. \
                 `--noise process --diffusion 'poly(2)'` (setting `diffusion`) finds its terms"
            ),
            true => format!(
                "squared prediction errors of {state} still depend on the state (p = {p:.0e}): a term is not in the library of \
                 `--diffusion`"
            ),
        })
    }
}

impl FollowedModel {
    /// How it was compared with data.
    pub(super) fn way(&self) -> Way {
        let Some(disturbance) = &self.fit.disturbance else {
            return Way::Arcs(self.longest);
        };
        Way::Filter(disturbance.sources)
    }
}

impl IdentificationRun<'_> {
    /// The best model of a disturbed system, with what tests say of it.
    pub(super) fn disturbed(
        &self,
        search: &Search<'_>,
        sources: Sources,
        progress: &mut dyn FnMut(Progress),
    ) -> Option<FollowedModel> {
        let mut found = self.best_of_starts(search, Way::Filter(sources), progress)?;
        // Where the source is not given, prediction errors that are correlated refuse the model.
        if self.settings.noise != NoiseSource::Automatic {
            self.drop_doubtful(&mut found, search);
        }
        let innovations = disturbed::innovations(search.system, search.pieces, &found.fit)?;
        found.surprises = Some(Surprises {
            white: innovations.white,
            alike: alike(&innovations),
            uneven: most_uneven(&innovations),
            with_diffusion: self.diffusion.is_some(),
        });
        Some(found)
    }

    /// The same where disturbances explain what the model leaves.
    pub(super) fn explained(
        &self,
        search: &Search<'_>,
        progress: &mut dyn FnMut(Progress),
    ) -> Option<FollowedModel> {
        if self.settings.discrete {
            return None;
        }
        let found = self.disturbed(search, Sources::Both, progress)?;
        let explained = found.surprises.is_some_and(Surprises::are_noise);
        explained.then_some(found)
    }

    /// The model in noise of the measurement, or that of a disturbed system where it is more likely by odds of 20 to 1. Only of one
    /// state is this asked: there the test that has accepted the first compares nothing.
    pub(super) fn likelier(
        &self,
        mut model: FollowedModel,
        search: &Search<'_>,
        progress: &mut dyn FnMut(Progress),
    ) -> FollowedModel {
        if self.data.states().len() > 1 || self.settings.noise != NoiseSource::Automatic {
            return model;
        }
        let Some(other) = self.explained(search, progress) else {
            return model;
        };
        let gain = counted(&model.fit) - counted(&other.fit);
        if gain > TWENTY_TO_ONE {
            return other;
        }
        model.is_ambiguous = gain > -TWENTY_TO_ONE;
        model
    }
}

/// The score of a fit, with a penalty for each number that describes its noise: variances, and what it remembers.
fn counted(fit: &OutputErrorFit) -> f64 {
    let above_zero = |values: &[f64]| values.iter().filter(|v| **v > 0.0).count();
    let numbers = match &fit.disturbance {
        Some(noise) => above_zero(&noise.process) + above_zero(&noise.measurement),
        None => fit.sigma.len() + above_zero(&fit.colour),
    };
    fit.score + numbers as f64 * (fit.values as f64).ln()
}

/// The state whose squared innovations depend on the state most, where they do.
fn most_uneven(innovations: &Innovations) -> Option<(usize, f64)> {
    let p = uneven::probabilities(&innovations.points, &innovations.errors);
    // Of several states the least is as small by chance as often.
    let together = p.len() as f64;
    let least = p.into_iter().enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    least
        .map(|(i, p)| (i, together * p))
        .filter(|(_, p)| *p <= LEVEL)
}

/// The least probability over all lengths of sums. Where rows lack states, each state is tested by its own rows.
fn alike(innovations: &Innovations) -> f64 {
    let states = innovations.errors.first().map_or(0, Vec::len);
    let is_lacking = |row: &Vec<f64>| row.iter().any(|e| e.is_nan());
    if !innovations.errors.iter().any(is_lacking) {
        return alike_in(&innovations.points, &innovations.errors);
    }
    let of = |i: usize| {
        let rows = innovations.points.iter().zip(&innovations.errors);
        let own = rows.filter(|(_, row)| !row[i].is_nan());
        let own = own.map(|(point, row)| (point.clone(), vec![row[i]]));
        let (points, errors): (Vec<_>, Vec<_>) = own.unzip();
        alike_in(&points, &errors)
    };
    (0..states).map(of).fold(1.0, f64::min)
}

/// The same of these rows.
fn alike_in(points: &[Vec<f64>], errors: &[Vec<f64>]) -> f64 {
    let rows = errors.len();
    let p = SUMMED.iter().filter_map(|&length| {
        let step = length.max(rows.div_ceil(neighbours::ROWS));
        let points = points.iter().step_by(step).cloned();
        let sums = errors.chunks(step).map(|chunk| {
            let mut sum = vec![0.0; chunk[0].len()];
            for row in &chunk[..length.min(chunk.len())] {
                sum.iter_mut().zip(row).for_each(|(sum, e)| *sum += e);
            }
            sum
        });
        neighbours::independence_of(points.collect(), sums.collect())
    });
    p.fold(1.0, f64::min)
}
