//! Flying what is missing of a campaign.

use std::ops::Range;

use rayon::prelude::*;
use touchdown_sim::landing::space::SpaceTrace;

use super::part::CampaignPart;
use super::points::Sweep;
use super::row::LandingRow;
use super::store::Store;
use crate::error::{Error, Result};
use crate::progress::Progress;

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

/// What of a part is to be flown.
#[derive(Clone, Debug)]
pub struct MissingBlocks {
    /// Blocks of the part that are there.
    there: usize,
    missing: Vec<u64>,
}

/// The blocks of a part that are not there yet. Those that are there are read.
///
/// # Errors
/// A block of the part that is broken.
pub fn missing(sweep: &Sweep, store: &Store, part: CampaignPart) -> Result<MissingBlocks> {
    let present = store.present()?;
    let (there, missing): (Vec<u64>, Vec<u64>) = part
        .blocks(sweep.blocks())
        .partition(|block| present.binary_search(block).is_ok());
    for &block in &there {
        store.read(sweep, block)?;
    }
    let there = there.len();
    Ok(MissingBlocks { there, missing })
}

/// Flies blocks one after the other, each on all cores, and gives how many of the campaign's blocks are there then:
/// others may be writing into the same folder.
///
/// # Errors
/// A block that cannot be written, and those of the backend.
pub fn fly<B: LandingBackend>(
    backend: &B,
    sweep: &Sweep,
    store: &Store,
    MissingBlocks { there, missing }: &MissingBlocks,
    progress: &dyn Progress,
) -> std::result::Result<u64, B::Error> {
    let landings = missing
        .iter()
        .map(|block| sweep.range(*block))
        .map(|r| r.end - r.start)
        .sum();
    progress.stage("landings", landings);
    let own = there + missing.len();
    for (there, &block) in (*there..).zip(missing) {
        let rows = rows_by(backend, sweep, sweep.range(block), progress)?;
        store.write(sweep, block, &rows)?;
        // A line for every hundredth at most, however many blocks.
        if 100 * (there + 1) / own > 100 * there / own {
            progress.done(&format!("{} of {own} blocks written", there + 1));
        }
    }
    Ok(store.present()?.len() as u64)
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
