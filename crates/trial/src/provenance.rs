use serde::{Deserialize, Serialize};

/// Where a trial came from, and what was done to it since.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The origin of the numbers.
    pub source: Source,
    /// What was done to them, in order, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// The origin of a trial's numbers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Source {
    /// Read from a file.
    File {
        /// The path as it was given.
        path: String,
        /// SHA-256 of the file's bytes, in lower-case hexadecimal.
        sha256: String,
    },
    /// Made by the virtual force rig or another simulation.
    VirtualRig {
        /// The seed of its random numbers.
        seed: u64,
        /// The scenario's name.
        scenario: String,
    },
    /// Computed from other values in memory.
    Derived,
}

impl Provenance {
    /// The provenance of numbers that came from `source` and were not touched since.
    #[must_use]
    pub fn new(source: Source) -> Self {
        Self {
            source,
            notes: Vec::new(),
        }
    }
}

impl Default for Provenance {
    /// [`Source::Derived`] without notes.
    fn default() -> Self {
        Self::new(Source::Derived)
    }
}
