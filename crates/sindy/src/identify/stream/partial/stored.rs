//! Partial sums between processes, and what keeps two of them from being added.

use serde::Deserialize;

use super::{Common, FORMAT, Node, PartialSums};
use crate::error::SindyError;
use crate::identify::stream::clusters::ClusterSums;
use crate::identify::stream::kept::KeptPieces;
use crate::identify::stream::pass::empty;
use crate::identify::stream::sums::shared;
use crate::library::Library;

/// As they were written, not checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Stored {
    format: u32,
    common: Common,
    nodes: Vec<Node>,
    kept: KeptPieces,
}

/// The format of a text, whatever else it holds.
#[derive(Deserialize)]
struct Format {
    format: u32,
}

impl PartialSums {
    /// The sums as text, which reads back exactly.
    ///
    /// # Errors
    /// None that is known: sums are written as they are.
    pub fn to_json(&self) -> Result<String, SindyError> {
        serde_json::to_string(self).map_err(|e| SindyError::PartialSums {
            reason: e.to_string(),
        })
    }

    /// The sums of a text that [`PartialSums::to_json`] made.
    ///
    /// # Errors
    /// Another format, a text that is damaged or cut off, or counts that do not fit to each other.
    pub fn from_json(text: &str) -> Result<Self, SindyError> {
        let reason = |e: serde_json::Error| SindyError::PartialSums {
            reason: e.to_string(),
        };
        let Format { format } = serde_json::from_str(text).map_err(reason)?;
        checked(format).map_err(|reason| SindyError::PartialSums { reason })?;
        serde_json::from_str(text).map_err(reason)
    }
}

/// Refuses another format.
fn checked(format: u32) -> Result<(), String> {
    match format {
        FORMAT => Ok(()),
        found => Err(format!(
            "expected format {FORMAT}, which this version reads, found format {found}"
        )),
    }
}

/// What differs, as it is in the one and in the other.
pub(super) fn difference(own: &Common, theirs: &Common) -> Option<String> {
    fn of<T: PartialEq + std::fmt::Debug>(own: &T, theirs: &T) -> Option<(String, String)> {
        let text = |value: &T| {
            let text = format!("{value:?}");
            match text.char_indices().nth(300) {
                Some((end, _)) => format!("{}…", &text[..end]),
                None => text,
            }
        };
        (own != theirs).then(|| (text(own), text(theirs)))
    }
    let names = |s: &Common| -> Vec<Vec<String>> {
        s.libraries.iter().map(|l| l.names().to_vec()).collect()
    };
    let (a, b) = (&own.columns, &theirs.columns);
    let all = [
        ("time", of(&a.time, &b.time)),
        ("states", of(&a.states, &b.states)),
        ("inputs", of(&a.inputs, &b.inputs)),
        ("weights", of(&a.weights, &b.weights)),
        ("terms", of(&names(own), &names(theirs))),
        ("settings", of(&own.settings, &theirs.settings)),
        ("sources", of(&own.sources, &theirs.sources)),
        (
            "the plan of the first rows",
            of(&(&own.plan, &own.before), &(&theirs.plan, &theirs.before)),
        ),
    ];
    let mut all = all.into_iter();
    all.find_map(|(what, texts)| {
        let (expected, found) = texts?;
        Some(format!(
            "{what}: expected {expected} as in the others, found {found}"
        ))
    })
}

impl TryFrom<Stored> for PartialSums {
    type Error = String;

    fn try_from(stored: Stored) -> Result<Self, String> {
        let Stored {
            format,
            common,
            nodes,
            kept,
        } = stored;
        checked(format)?;
        common.settings.validate().map_err(|e| e.to_string())?;
        let states = common.columns.states.len();
        let fit =
            common.libraries.len() == states && common.plan.fits(states, common.settings.discrete);
        let damaged =
            || "expected sums of one identification, found numbers of different counts".to_owned();
        if !fit {
            return Err(damaged());
        }
        let terms: Vec<usize> = common.libraries.iter().map(Library::len).collect();
        let (slopes, weak) = empty(&common.plan, &shared(&common.libraries), &common.settings);
        let alike = |a: &ClusterSums, b: &ClusterSums| a.fits(&terms, b.clusters, b.block);
        let mut end = 0;
        for node in &nodes {
            let whole = node.first >= end
                && node.first < common.sources.len()
                && node.level < 48
                && node.first.is_multiple_of(1 << node.level)
                && node.end() <= common.sources.len()
                && node.slopes.len() == slopes.len()
                && node.slopes.iter().zip(&slopes).all(|(a, b)| alike(a, b))
                && match (&node.weak, &weak) {
                    (Some(a), Some(b)) => alike(a, b),
                    (None, None) => true,
                    _ => false,
                };
            if !whole {
                return Err(damaged());
            }
            end = node.end();
        }
        if !kept.fits(common.columns.width(), states) {
            return Err(damaged());
        }
        Ok(Self {
            format,
            common,
            nodes,
            kept,
        })
    }
}
