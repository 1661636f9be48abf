//! Partial sums: what a pass over some of the sources leaves.

mod stored;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::Columns;
use super::clusters::ClusterSums;
use super::finish;
use super::kept::KeptPieces;
use super::pass::{HEAD, Pass, Passed, Place};
use super::slopes::Plan;
use crate::data::dataset::DataReport;
use crate::data::samples::BlockSource;
use crate::error::{SindyError, require};
use crate::identify::{Identification, Identify, Progress, Settings};
use crate::library::Library;

/// The format of partial sums between processes.
const FORMAT: u32 = 1;

/// What all partial sums of one identification share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Common {
    columns: Columns,
    /// One for each state.
    libraries: Vec<Library>,
    settings: Settings,
    /// Names of all sources, in the order of summation.
    sources: Vec<String>,
    plan: Plan,
    /// By source, the rows before it that decided the plan; sources that are not here had no part in it.
    before: Vec<usize>,
}

/// Sums of 2^`level` sources, of which `first` is the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Node {
    level: u32,
    first: usize,
    report: DataReport,
    slopes: Vec<ClusterSums>,
    weak: Option<ClusterSums>,
}

/// The sums that a pass over some of the sources (files, trajectories) leaves, for an identification from all of them.
///
/// [`Identify::partial_sums`] makes empty ones. Their plan (smoothing, clusters) comes from the first 50 000 rows of all
/// sources, so all workers need the same. [`PartialSums::add`] passes over one source, [`PartialSums::merge`] takes the
/// sums of another worker, and [`PartialSums::identify`] ends the identification as [`Identify::run_stream`] does.
///
/// The sums of sources are added as a binary tree over their numbers: first those of 0 and 1, of 2 and 3, then these
/// pairs, and so on. The tree is the same for every division among workers and every order of arrival, and so are all bits
/// of the result. Neighbours are added as soon as both are there: a worker that has a range of `n` sources holds the sums
/// of at most `2 log2 n` parts.
///
/// ```
/// use sindy::identify::{Columns, PartialSums};
/// use sindy::{BlockSource, Identify, Library, Samples};
///
/// // x' = 1 - x, from four starts.
/// let run = |start: f64| {
///     let time: Vec<f64> = (0..500).map(|i| 0.01 * f64::from(i)).collect();
///     let x = time.iter().map(|t| 1.0 + (start - 1.0) * (-t).exp()).collect();
///     let mut samples = Samples::new(&["t", "x"]);
///     samples.push_group(vec![time, x]).map(|()| samples)
/// };
/// let runs = [run(3.0)?, run(2.0)?, run(0.0)?, run(-1.0)?];
/// let sources: Vec<&dyn BlockSource> = runs.iter().map(|r| r as _).collect();
/// let names = ["a", "b", "c", "d"];
///
/// let identify = Identify::new(Library::polynomial(&["x"], 2)?);
/// let empty = identify.partial_sums(&Columns::new("t", &["x"], &[])?, &names, &sources)?;
/// let (mut one, mut two) = (empty.clone(), empty);
/// one.add(0, sources[0])?;
/// one.add(3, sources[3])?;
/// two.add(1, sources[1])?;
/// assert_eq!(two.missing(), ["a", "c", "d"]);
/// two.add(2, sources[2])?;
/// let mut all = PartialSums::from_json(&two.to_json()?)?; // from another process
/// all.merge(one)?;
/// let found = all.identify(&mut |_| ())?;
/// assert_eq!(found.data.rows, 2000);
/// assert_eq!(found.model.terms(), 2, "{}", found.model);
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "stored::Stored")]
pub struct PartialSums {
    format: u32,
    common: Common,
    /// By their first source.
    nodes: Vec<Node>,
    kept: KeptPieces,
}

impl Node {
    fn end(&self) -> usize {
        self.first + (1 << self.level)
    }

    /// Appends the sums of the sources behind these.
    fn append(&mut self, next: &Self) {
        let (own, more) = (&mut self.report, &next.report);
        own.trajectories += more.trajectories;
        own.rows += more.rows;
        own.stretches += more.stretches;
        own.missing_rows += more.missing_rows;
        own.holes += more.holes;
        own.short_rows += more.short_rows;
        own.uniform &= more.uniform;
        let pairs = self.slopes.iter_mut().zip(&next.slopes);
        pairs.for_each(|(own, more)| own.append(more));
        if let (Some(own), Some(more)) = (&mut self.weak, &next.weak) {
            own.append(more);
        }
    }
}

impl Identify {
    /// Empty partial sums for an identification from `sources`, which have these `names`. Sources are passed over in their
    /// order until 50 000 rows were there ([`HEAD_ROWS`](super::HEAD_ROWS)), for the plan. Rows behind them are not used, so
    /// a source may end there.
    ///
    /// # Errors
    /// As [`Identify::run_stream`]; names that are not one for each source.
    pub fn partial_sums<S: AsRef<str>>(
        &self,
        columns: &Columns,
        names: &[S],
        sources: &[&dyn BlockSource],
    ) -> Result<PartialSums, SindyError> {
        let libraries = self.streamed(columns)?;
        let names: Vec<String> = names.iter().map(|n| n.as_ref().to_owned()).collect();
        if names.len() != sources.len() {
            return Err(SindyError::shape(
                "names of sources",
                sources.len(),
                names.len(),
            ));
        }
        for source in sources {
            columns.places(source.names())?;
        }
        let mut pass = Pass::new(columns, &libraries, &self.settings)?;
        let mut before = Vec::new();
        for source in sources {
            if pass.is_decided() {
                break;
            }
            before.push(pass.seen());
            pass.take(*source, true)?;
            pass.next_source()?;
        }
        let plan = pass.end()?.plan;
        Ok(PartialSums {
            format: FORMAT,
            common: Common {
                columns: columns.clone(),
                libraries,
                settings: self.settings.clone(),
                sources: names,
                plan,
                before,
            },
            nodes: Vec::new(),
            kept: KeptPieces::new(),
        })
    }
}

impl PartialSums {
    /// Passes over the source with this number among all sources and adds its sums.
    ///
    /// # Errors
    /// A number without a source, or of one that is in the sums already; as [`Identify::run_stream`]. The sums are then as
    /// they were.
    pub fn add(&mut self, number: usize, source: &dyn BlockSource) -> Result<(), SindyError> {
        let Some(name) = self.common.sources.get(number) else {
            let expected = format!("a number below {}", self.common.sources.len());
            return Err(SindyError::setting("source", expected, number));
        };
        require(
            !self
                .nodes
                .iter()
                .any(|n| (n.first..n.end()).contains(&number)),
            "source",
            "each source once",
            format!("{name} again"),
        )?;
        let Common {
            columns,
            libraries,
            settings,
            plan,
            before,
            ..
        } = &self.common;
        let place = Place {
            source: number,
            before: before.get(number).copied().unwrap_or(HEAD),
        };
        let mut pass = Pass::planned(columns, libraries, settings, plan, place)?;
        pass.take(source, false)?;
        let Passed {
            report,
            slopes,
            weak,
            kept,
            ..
        } = pass.end()?;
        self.kept.merge(kept, settings.rows);
        self.insert(Node {
            level: 0,
            first: number,
            report,
            slopes: slopes.into_iter().map(ClusterSums::trimmed).collect(),
            weak: weak.map(ClusterSums::trimmed),
        });
        Ok(())
    }

    /// Adds the sums of another worker.
    ///
    /// # Errors
    /// Sums of another identification (columns, libraries, settings, sources, plan: the first that differs is named), and a
    /// source that is in both. The sums are then as they were.
    pub fn merge(&mut self, other: Self) -> Result<(), SindyError> {
        let own = &self.common;
        if let Some(reason) = stored::difference(own, &other.common) {
            return Err(SindyError::PartialSums { reason });
        }
        for node in &other.nodes {
            let both = |n: &&Node| n.first < node.end() && node.first < n.end();
            if let Some(twice) = self.nodes.iter().find(both) {
                let name = &own.sources[twice.first.max(node.first)];
                return Err(SindyError::PartialSums {
                    reason: format!("expected each source once, found {name} in two of them"),
                });
            }
        }
        self.kept.merge(other.kept, self.common.settings.rows);
        other.nodes.into_iter().for_each(|node| self.insert(node));
        Ok(())
    }

    /// The names of all sources, in the order of summation.
    #[must_use]
    pub fn sources(&self) -> &[String] {
        &self.common.sources
    }

    /// The names of the sources that are not in the sums.
    #[must_use]
    pub fn missing(&self) -> Vec<&str> {
        let mut out = Vec::new();
        let mut next = 0;
        let all = &self.common.sources;
        let ends = self.nodes.iter().map(|n| (n.first, n.end()));
        for (first, end) in ends.chain([(all.len(), 0)]) {
            out.extend(all[next..first].iter().map(String::as_str));
            next = end;
        }
        out
    }

    /// The rows that are in the sums.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.nodes.iter().map(|n| n.report.rows).sum()
    }

    /// The identification from the sums of all sources, as by [`Identify::run_stream`].
    ///
    /// # Errors
    /// A source that is not in the sums; as [`Identify::run_stream`].
    pub fn identify(
        self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        if let Some(first) = self.missing().first() {
            let (count, all) = (self.missing().len(), self.common.sources.len());
            return Err(SindyError::PartialSums {
                reason: format!(
                    "expected those of all {all} sources, found none of {count} of them, the first of which is {first}"
                ),
            });
        }
        let Common {
            columns,
            libraries,
            settings,
            plan,
            ..
        } = self.common;
        let mut nodes = self.nodes.into_iter();
        let Some(mut total) = nodes.next() else {
            return Err(SindyError::setting("sources", "at least one", "none"));
        };
        nodes.for_each(|next| total.append(&next));
        let passed = Passed {
            plan,
            report: total.report,
            slopes: total.slopes,
            weak: total.weak,
            kept: self.kept,
        };
        finish::of(passed, &columns, libraries, &settings, progress)
    }

    /// Puts sums at their place, and adds neighbours that are complete.
    fn insert(&mut self, mut node: Node) {
        loop {
            let sibling = node.first ^ (1 << node.level);
            let same = |n: &Node| (n.first, n.level) == (sibling, node.level);
            let Some(at) = self.nodes.iter().position(same) else {
                break;
            };
            let other = self.nodes.remove(at);
            let (mut left, right) = match other.first < node.first {
                true => (other, node),
                false => (node, other),
            };
            left.append(&right);
            left.level += 1;
            node = left;
        }
        let at = self.nodes.partition_point(|n| n.first < node.first);
        self.nodes.insert(at, node);
    }
}
