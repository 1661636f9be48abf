//! Flying what is missing of a campaign.

use std::ops::Range;
use std::str::FromStr;

use rayon::prelude::*;
use touchdown_sim::landing::space::SpaceTrace;

use super::points::Sweep;
use super::row::LandingRow;
use super::store::Store;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// A part of a campaign: every N-th block, from the I-th on.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Shard {
    index: u64,
    of: u64,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    fn holds(self, block: u64) -> bool {
        block % self.of == self.index - 1
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

/// What flies the landings of a campaign.
pub trait LandingBackend: Sync {
    /// Why a landing cannot be flown.
    type Error: From<Error> + Send;

    /// Flies a landing, by its place in the campaign. Called from many threads.
    ///
    /// # Errors
    /// What ends the whole campaign: for example settings that make no sense, or a disk that is full.
    fn land(&self, sweep: &Sweep, landing: u64) -> std::result::Result<LandingRow, Self::Error>;
}

/// The simulation of the whole vehicle, reproducible to the bit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Simulation;

impl LandingBackend for Simulation {
    type Error = Error;

    fn land(&self, sweep: &Sweep, landing: u64) -> Result<LandingRow> {
        let (trial, seed) = (landing % sweep.trials(), sweep.settings().seed);
        let flown = sweep.lander(landing)?.land(trial, seed, false)?;
        Ok(LandingRow::of(landing, &flown))
    }
}

/// Flies the blocks of a shard that are not there yet, one after the other, each on all cores, and gives how many
/// of the campaign's blocks are there then.
///
/// # Errors
/// A block that cannot be read or written, and those of the backend.
pub fn fly<B: LandingBackend>(
    backend: &B,
    sweep: &Sweep,
    store: &Store,
    shard: Shard,
    progress: &dyn Progress,
) -> std::result::Result<u64, B::Error> {
    let present = store.present()?;
    for &block in &present {
        store.read(sweep, block)?;
    }
    let missing: Vec<u64> = (0..sweep.blocks())
        .filter(|block| shard.holds(*block) && present.binary_search(block).is_err())
        .collect();
    let landings = missing
        .iter()
        .map(|block| sweep.range(*block))
        .map(|r| r.end - r.start)
        .sum();
    progress.stage("landings", landings);
    let percent = |blocks: usize| 100 * blocks / sweep.blocks() as usize;
    for (flown, &block) in missing.iter().enumerate() {
        let rows = rows_by(backend, sweep, sweep.range(block), progress)?;
        store.write(sweep, block, &rows)?;
        let there = present.len() + flown;
        // A line for every hundredth at most, however many blocks.
        if percent(there + 1) > percent(there) {
            progress.done(&format!(
                "{} of {} blocks written",
                there + 1,
                sweep.blocks()
            ));
        }
    }
    Ok((present.len() + missing.len()) as u64)
}

/// Flies landings of the simulation, by their places in the campaign, on all cores.
///
/// # Errors
/// Those of [`Sweep::lander`]: in large campaigns, not all drawn values have been looked at.
pub fn rows(
    sweep: &Sweep,
    landings: Range<u64>,
    progress: &dyn Progress,
) -> Result<Vec<LandingRow>> {
    rows_by(&Simulation, sweep, landings, progress)
}

fn rows_by<B: LandingBackend>(
    backend: &B,
    sweep: &Sweep,
    landings: Range<u64>,
    progress: &dyn Progress,
) -> std::result::Result<Vec<LandingRow>, B::Error> {
    landings
        .collect::<Vec<u64>>()
        .into_par_iter()
        .with_max_len(1)
        .map(|landing| {
            let row = backend.land(sweep, landing)?;
            progress.step();
            Ok(row)
        })
        .collect()
}

/// Flies landings once more, by their places in the campaign, for their time series.
///
/// # Errors
/// A landing that the campaign does not have, or that an autopilot in the loop flew.
pub fn replay(sweep: &Sweep, landings: &[u64]) -> Result<Vec<SpaceTrace>> {
    if sweep.settings().autopilot.is_some() {
        return Err(Error::Arguments(
            "a landing under an autopilot cannot be flown again to the bit; `software_in_the_loop.record = true` records it while \
             it is flown"
                .to_string(),
        ));
    }
    if let Some(landing) = landings.iter().find(|l| **l >= sweep.landings()) {
        return Err(Error::Arguments(format!(
            "expected a landing from 0 to {}, found {landing}",
            sweep.landings() - 1
        )));
    }
    landings
        .par_iter()
        .map(|&landing| {
            let flown = sweep.lander(landing)?.land(
                landing % sweep.trials(),
                sweep.settings().seed,
                true,
            )?;
            Ok(flown.trace.unwrap_or_default())
        })
        .collect()
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
        for block in 0..10 {
            assert_eq!(shards.iter().filter(|s| s.holds(block)).count(), 1);
        }
        assert_eq!(shards[1].to_string(), "2/3");
    }
}
