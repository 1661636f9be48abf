//! What of a campaign is there.

use rayon::prelude::*;
use serde::Serialize;

use super::points::Sweep;
use super::store::Store;
use crate::error::{Error, Result};
use crate::place::Place;

/// A block whose file is there and cannot be used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BrokenBlock {
    /// Which block.
    pub block: u64,
    /// What is wrong with it.
    pub error: String,
}

/// What of a campaign is there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CampaignStatus {
    /// Version of this shape.
    pub schema: u32,
    /// Version of the program.
    pub version: &'static str,
    /// SHA-256 of the sweep.
    pub sweep_sha256: String,
    /// Whether all blocks are there and whole.
    pub complete: bool,
    /// Blocks of the campaign.
    pub blocks: u64,
    /// Whole blocks that are there.
    pub blocks_there: u64,
    /// Blocks that are not there, as ranges: from the first to before the second, as `--blocks` takes them.
    pub missing: Vec<[u64; 2]>,
    /// Blocks that are there and not whole.
    pub broken: Vec<BrokenBlock>,
    /// Landings of the campaign.
    pub landings: u64,
    /// Landings that are there: rows of the whole blocks.
    pub rows: u64,
}

/// Reads what of a campaign is there; every block is read whole.
///
/// # Errors
/// A place without a campaign, with a block that cannot be read, or with a file among its blocks that is none of them.
pub fn status(place: &Place) -> Result<CampaignStatus> {
    let sweep = Sweep::of(place)?;
    let store = Store::of(place);
    let present = store.present()?;
    let blocks = sweep.blocks();
    if let Some(block) = present.iter().find(|block| **block >= blocks) {
        return Err(Error::data(
            store.path(*block).display().to_string(),
            format!("blocks 0 to {}", blocks - 1),
            format!("block {block}"),
        ));
    }
    let read: Vec<(u64, Result<u64>)> = present
        .par_iter()
        .map(|&block| {
            (
                block,
                store.read(&sweep, block).map(|rows| rows.len() as u64),
            )
        })
        .collect();
    let mut rows = 0;
    let mut broken = Vec::new();
    for (block, read) in read {
        match read {
            Ok(of_block) => rows += of_block,
            // Nobody knows what a file holds that cannot be read.
            Err(error @ Error::File { .. }) => return Err(error),
            Err(error) => broken.push(BrokenBlock {
                block,
                error: error.to_string(),
            }),
        }
    }
    let missing = ranges((0..blocks).filter(|block| present.binary_search(block).is_err()));
    Ok(CampaignStatus {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        sweep_sha256: sweep.sha256().to_string(),
        complete: missing.is_empty() && broken.is_empty(),
        blocks,
        blocks_there: (present.len() - broken.len()) as u64,
        missing,
        broken,
        landings: sweep.landings(),
        rows,
    })
}

/// Increasing numbers as ranges of neighbours.
fn ranges(numbers: impl Iterator<Item = u64>) -> Vec<[u64; 2]> {
    let mut ranges: Vec<[u64; 2]> = Vec::new();
    for number in numbers {
        match ranges.last_mut() {
            Some(last) if last[1] == number => last[1] += 1,
            _ => ranges.push([number, number + 1]),
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_neighbours_are_one_range() {
        assert_eq!(
            ranges([0, 1, 4, 6, 7, 8].into_iter()),
            [[0, 2], [4, 5], [6, 9]]
        );
        assert!(ranges(std::iter::empty()).is_empty());
    }
}
