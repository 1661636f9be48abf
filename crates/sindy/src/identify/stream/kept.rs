//! Pieces of trajectories that are kept for free runs.

use serde::{Deserialize, Serialize};

/// A piece of a trajectory that is kept for free runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Kept {
    /// The source that it is from, and its number among the pieces of that source.
    pub source: usize,
    pub index: usize,
    /// Time, states, inputs, and weights if there are any.
    pub columns: Vec<Vec<f64>>,
    /// Smoothed states.
    pub smooth: Vec<Vec<f64>>,
}

/// Evenly spread pieces: those whose number (source + index) the stride divides. The stride is the least power of two with
/// which they have no more rows than allowed, whatever the order in which they come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptPieces {
    stride: usize,
    /// In the order of the sources and their times.
    pub pieces: Vec<Kept>,
}

impl Kept {
    fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    fn divides(&self, stride: usize) -> bool {
        (self.source + self.index).is_multiple_of(stride)
    }
}

impl KeptPieces {
    pub(super) fn new() -> Self {
        Self {
            stride: 1,
            pieces: Vec::new(),
        }
    }

    /// Whether a piece of this number is to be kept.
    pub(super) fn wants(&self, source: usize, index: usize) -> bool {
        (source + index).is_multiple_of(self.stride)
    }

    /// Keeps a piece, of all of them `limit` rows at most.
    pub(super) fn push(&mut self, piece: Kept, limit: usize) {
        self.pieces.push(piece);
        self.thin(limit);
    }

    /// Keeps the pieces of other sources too.
    pub(super) fn merge(&mut self, other: Self, limit: usize) {
        self.pieces.extend(other.pieces);
        self.pieces.sort_by_key(|k| (k.source, k.index));
        self.stride = self.stride.max(other.stride);
        let stride = self.stride;
        self.pieces.retain(|k| k.divides(stride));
        self.thin(limit);
    }

    /// Whether every piece has so many columns and states, equally long.
    pub(super) fn fits(&self, columns: usize, states: usize) -> bool {
        self.stride.is_power_of_two()
            && self.pieces.iter().all(|k| {
                let mut all = k.columns.iter().chain(&k.smooth);
                k.columns.len() == columns
                    && k.smooth.len() == states
                    && all.all(|c| c.len() == k.rows())
            })
    }

    /// Of too many rows, every other piece goes. That more pieces come can only ask for a larger stride, so the order in
    /// which they come does not matter.
    fn thin(&mut self, limit: usize) {
        let rows = |all: &[Kept]| all.iter().map(Kept::rows).sum::<usize>();
        while rows(&self.pieces) > limit
            && self.pieces.len() > 1
            && self.pieces.iter().any(|k| k.divides(2 * self.stride))
        {
            self.stride *= 2;
            let stride = self.stride;
            self.pieces.retain(|k| k.divides(stride));
        }
    }
}
