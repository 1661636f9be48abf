//! Which blocks of a campaign one run flies.

use std::ops::Range;
use std::str::FromStr;

use crate::error::{Error, Result};

/// Every N-th block of a campaign, from the I-th on.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Shard {
    index: u64,
    of: u64,
}

impl Shard {
    /// Into how many parts the campaign is cut.
    #[must_use]
    pub fn count(self) -> u64 {
        self.of
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text
            .split_once('/')
            .and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((index, of)) if index >= 1 && index <= of => Ok(Self { index, of }),
            _ => Err(format!("expected I/N with I from 1 to N, found {text}")),
        }
    }
}

/// The blocks from one to before another, counted from 0.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct BlockRange {
    from: u64,
    to: u64,
}

impl BlockRange {
    /// The blocks `range`.
    ///
    /// # Errors
    /// An empty range.
    pub fn new(range: Range<u64>) -> std::result::Result<Self, String> {
        let Range {
            start: from,
            end: to,
        } = range;
        match from < to {
            true => Ok(Self { from, to }),
            false => Err(format!("expected A..B with A below B, found {from}..{to}")),
        }
    }
}

impl std::fmt::Display for BlockRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}..{}", self.from, self.to)
    }
}

impl FromStr for BlockRange {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let ends = text
            .split_once("..")
            .and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        let Some((from, to)) = ends else {
            return Err(format!(
                "expected A..B, the blocks from A to before B, found {text}"
            ));
        };
        Self::new(from..to)
    }
}

/// The blocks that one run flies.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum CampaignPart {
    /// All.
    Whole,
    /// Every N-th.
    Shard(Shard),
    /// A range of them.
    Blocks(BlockRange),
}

impl CampaignPart {
    /// Its blocks, of a campaign of so many.
    pub fn blocks(self, of: u64) -> impl Iterator<Item = u64> {
        let (range, step) = match self {
            Self::Whole => (0..of, 1),
            Self::Shard(shard) => (shard.index - 1..of, shard.of),
            Self::Blocks(range) => (range.from..range.to.min(of), 1),
        };
        range.step_by(usize::try_from(step).unwrap_or(usize::MAX))
    }

    /// Whether the block is in it.
    #[must_use]
    pub fn holds(self, block: u64) -> bool {
        match self {
            Self::Whole => true,
            Self::Shard(shard) => block % shard.of == shard.index - 1,
            Self::Blocks(range) => (range.from..range.to).contains(&block),
        }
    }

    /// Refuses blocks that a campaign of `blocks` does not have.
    ///
    /// # Errors
    /// A range that ends after the last block.
    pub(super) fn check(self, blocks: u64) -> Result<()> {
        match self {
            Self::Blocks(range) if range.to > blocks => Err(Error::Arguments(format!(
                "--blocks {range}: expected blocks from 0 to before {blocks}; the campaign has no more"
            ))),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_shards_are_read_and_share_out_every_block_once() {
        for bad in ["5/4", "0/3", "1/0", "a/b", "1", "-1/2", "1/2/3"] {
            assert!(bad.parse::<Shard>().unwrap_err().contains(bad), "{bad}");
        }
        let shards: Vec<Shard> = ["1/3", "2/3", "3/3"].map(|s| s.parse().unwrap()).to_vec();
        let mut all: Vec<u64> = Vec::new();
        for shard in &shards {
            let part = CampaignPart::Shard(*shard);
            let own: Vec<u64> = part.blocks(10).collect();
            assert!((0..10).all(|block| part.holds(block) == own.contains(&block)));
            all.extend(own);
        }
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
        assert_eq!(shards[1].to_string(), "2/3");
        // More shards than blocks: the last ones are empty.
        assert_eq!(CampaignPart::Shard(shards[2]).blocks(2).count(), 0);
    }

    #[test]
    fn prop_ranges_of_blocks_are_read_and_lie_in_the_campaign() {
        for bad in ["5", "5..5", "6..5", "..", "a..b", "1..", "-1..2", "1..=2"] {
            assert!(
                bad.parse::<BlockRange>().unwrap_err().contains(bad),
                "{bad}"
            );
        }
        let range: BlockRange = "2..5".parse().unwrap();
        let part = CampaignPart::Blocks(range);
        assert_eq!(part.blocks(9).collect::<Vec<_>>(), [2, 3, 4]);
        assert!(part.holds(4) && !part.holds(5));
        part.check(5).unwrap();
        let error = part.check(4).unwrap_err().to_string();
        assert!(
            error.contains("2..5") && error.contains("before 4"),
            "{error}"
        );
        assert_eq!(range.to_string(), "2..5");
    }
}
