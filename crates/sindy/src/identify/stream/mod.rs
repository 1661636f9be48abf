//! The automatic identification of rows that need not fit into memory.
//!
//! [`Identify::run_stream`] passes once over any [`BlockSource`]. The first 50 000 rows decide how slopes are taken
//! (smoothing, half-width of the weak form); from then on rows are differentiated in overlapping windows, so that
//! slopes are those of whole trajectories, and go into the statistics of each equation. Blocks of rows are dealt
//! out in turn to up to 60 clusters. The memory after the pass is small: sums for each cluster, and evenly spread
//! pieces of the trajectories ([`Settings::rows`] rows at most, of which about 10 000 are run). From these come
//!
//! - best subsets with their certificates (with a penalty for all rows, and for no more than [`Settings::rows`]: the
//!   errors of smoothing do not average out, and to enough rows each would be worth a term), and SR3 with λ and ν by cross-validation over
//!   [`Settings::folds`] sets of clusters,
//! - the choice among them by free run over the pieces, as in [`Identify::run`],
//! - standard errors from the scatter between clusters ([`ClusterErrors`](crate::statistics::regression::ClusterErrors)),
//!   which respect correlation within a block (1024 rows or more).
//!
//! There is no output error: it would need the rows again. Where trajectories fit into memory, [`Identify::run`] is
//! more accurate on noisy data.
//!
//! ```
//! use sindy::identify::Columns;
//! use sindy::{Identify, Library, OwnedBlock, Stream};
//!
//! // x' = 1.2 u - 0.5 x, three trajectories, in blocks of 500 rows.
//! let blocks = (0..12).map(|k| {
//!     let time: Vec<f64> = (0..500).map(|i| 0.01 * f64::from(500 * (k % 4) + i)).collect();
//!     let u = time.iter().map(|t| t.sin()).collect();
//!     let decay = |t: f64| f64::from(k / 4 + 1) * (-0.5 * t).exp();
//!     let x = time.iter().map(|&t| decay(t) + 0.48 * t.sin() - 0.96 * t.cos()).collect();
//!     Ok(OwnedBlock { group: k as usize / 4, columns: vec![time, x, u] })
//! });
//! let source = Stream::new(&["t", "x", "u"], 3, blocks);
//! let columns = Columns::new("t", &["x"], &["u"])?;
//! let library = Library::polynomial(&["x", "u"], 2)?;
//! let found = Identify::new(library).run_stream(&source, &columns, &mut |_| ())?;
//! assert_eq!(found.data.rows, 6000);
//! assert_eq!(found.model.terms(), 2, "{}", found.model);
//! # Ok::<(), sindy::SindyError>(())
//! ```

mod clusters;
mod finish;
mod kept;
mod partial;
mod pass;
mod slopes;
mod sums;
#[cfg(test)]
mod tests;
mod window;

#[cfg(doc)]
use super::Settings;
use super::{Identification, Identify, Method, NoiseSource, Progress};
use crate::data::dataset::Dataset;
use crate::data::samples::{BlockSource, position};
use crate::error::{SindyError, require};
use crate::library::Library;
pub use partial::PartialSums;
use pass::Pass;
use serde::{Deserialize, Serialize};

/// The rows that decide how slopes are taken.
pub const HEAD_ROWS: usize = pass::HEAD;

/// The roles of a source's columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Columns {
    time: String,
    states: Vec<String>,
    inputs: Vec<String>,
    weights: Option<String>,
}

impl Columns {
    /// Columns of times, states and inputs by their names.
    ///
    /// # Errors
    /// No states, an empty name, or a name that stands twice.
    pub fn new<S: AsRef<str>>(time: &str, states: &[S], inputs: &[S]) -> Result<Self, SindyError> {
        let names = Dataset::new(states, inputs)?;
        if time.is_empty() || names.names().iter().any(|n| n == time) {
            return Err(SindyError::setting(
                "time",
                "a column that is neither a state nor an input",
                format!("`{time}`"),
            ));
        }
        Ok(Self {
            time: time.to_owned(),
            states: names.states().to_vec(),
            inputs: names.inputs().to_vec(),
            weights: None,
        })
    }

    /// The same with a column of weights: finite, at least 0, relative to each other. Up to three rows in succession
    /// without weight are bridged by a straight line where slopes are needed; more, and all in discrete time, count as
    /// missing.
    #[must_use]
    pub fn weights(self, column: &str) -> Self {
        Self {
            weights: Some(column.to_owned()),
            ..self
        }
    }

    /// Their number.
    fn width(&self) -> usize {
        1 + self.states.len() + self.inputs.len() + usize::from(self.weights.is_some())
    }

    /// Time, states, inputs, weights: their places among `names`.
    fn places(&self, names: &[String]) -> Result<Vec<usize>, SindyError> {
        std::iter::once(&self.time)
            .chain(&self.states)
            .chain(&self.inputs)
            .chain(&self.weights)
            .map(|name| position(names, name))
            .collect()
    }
}

impl Identify {
    /// Identifies a model of the rows of `source` in one pass, in memory that does not grow with them; see
    /// [the module](self) for what differs from [`Identify::run`].
    ///
    /// Each group is a trajectory, with its rows in the order of time. Blocks of a group follow each other: a group
    /// that comes back after another begins a new trajectory. NaN in a state or an input, and jumps of time, split
    /// a trajectory and are counted, as by [`Dataset::push`].
    ///
    /// # Errors
    /// The method [`Method::OutputError`], known parts or second order; names without a column; no usable rows, or fewer than terms; infinite values,
    /// times that do not increase, weights that are negative or not finite (rows count over the whole pass);
    /// libraries that are not one or one per state; a pass that failed ([`BlockSource::failure`]).
    pub fn run_stream(
        &self,
        source: &dyn BlockSource,
        columns: &Columns,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        let libraries = self.streamed(columns)?;
        columns.places(source.names())?;
        let mut pass = Pass::new(columns, &libraries, &self.settings)?;
        progress(Progress::Smoothing);
        pass.take(source, false)?;
        finish::of(pass.end()?, columns, libraries, &self.settings, progress)
    }

    /// The library of each state, where the settings suit rows that are passed over once.
    fn streamed(&self, columns: &Columns) -> Result<Vec<Library>, SindyError> {
        require(
            self.settings.method != Method::OutputError,
            "method",
            "automatic or regression (rows that are passed over once cannot be followed again)",
            "output_error",
        )?;
        require(
            self.settings.noise == NoiseSource::Automatic,
            "noise",
            "automatic in a stream",
            format!("{:?}", self.settings.noise).to_lowercase(),
        )?;
        require(!self.settings.stable, "stable", "false in a stream", true)?;
        for (key, texts) in [
            ("known", &self.settings.known),
            ("second_order", &self.settings.second_order),
            ("signs", &self.settings.signs),
            ("conserve", &self.settings.conserve),
            ("constraints", &self.settings.constraints),
        ] {
            let expected = "none in a stream";
            require(texts.is_empty(), key, expected, texts.join(", "))?;
        }
        self.per_state(columns.states.len())
    }
}
