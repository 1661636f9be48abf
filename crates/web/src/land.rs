//! Landings of a scenario.

use std::ops::Range;
use std::path::Path;

use serde::Serialize;
use touchdown_campaign::progress::Silent;
use touchdown_campaign::recording;
use touchdown_campaign::scene::{Motion, Scene};
use touchdown_campaign::sweep::{self, LandingRow, Sweep};
use touchdown_sim::landing::space::{SpaceLanding, TraceRow};

use crate::request::{Error, Result};

/// One landing.
#[derive(Debug, Serialize)]
pub(crate) struct Landing {
    /// The row of `landings.csv`, column by column.
    row: Vec<(&'static str, String)>,
    /// What of the vehicle follows from the cards, in a line.
    vehicle: Option<String>,
    #[serde(flatten)]
    scene: Scene,
    frames: Frames,
}

/// Time series of a landing, a value for every step of the landing computer.
#[derive(Debug, Default, Serialize)]
struct Frames {
    #[serde(flatten)]
    motion: Motion,
    estimated_height_m: Vec<f64>,
    target_height_m: Vec<Option<f64>>,
    velocity_mps: Vec<f64>,
    counted_ground_effect_n: Vec<f64>,
    deck_mps: Vec<f64>,
    estimated_deck_mps: Vec<f64>,
}

impl Frames {
    fn push(&mut self, row: &TraceRow) {
        self.motion.push(row);
        self.estimated_height_m.push(row.estimated_m[2]);
        self.target_height_m
            .push(row.target.map(|[height, _]| height));
        self.velocity_mps.push(row.relative_mps[2]);
        self.counted_ground_effect_n
            .push(row.counted_ground_effect_n);
        self.deck_mps.push(row.deck_mps[2]);
        self.estimated_deck_mps.push(row.estimated_deck_mps);
    }
}

/// Flies a landing of a scenario for its frames.
pub(crate) fn one(path: &Path, landing: u64) -> Result<Landing> {
    let sweep = Sweep::read(path, None, None)?;
    let flown = fly(&sweep, landing)?;
    let mut frames = Frames::default();
    let rows = flown.trace.iter().flat_map(|trace| &trace.rows);
    rows.for_each(|row| frames.push(row));
    Ok(Landing {
        row: cells(&LandingRow::of(landing, &flown)),
        vehicle: sweep.vehicle().map(str::to_owned),
        scene: Scene::of(&sweep.settings().scenario),
        frames,
    })
}

fn fly(sweep: &Sweep, landing: u64) -> Result<SpaceLanding> {
    if landing >= sweep.landings() {
        return Err(Error::Data(format!(
            "expected a landing from 0 to {}, found {landing}",
            sweep.landings() - 1
        )));
    }
    let (trial, seed) = (landing % sweep.trials(), sweep.settings().seed);
    Ok(sweep.lander(landing)?.land(trial, seed, true)?)
}

/// Landings as rows of `landings.csv`.
pub(crate) fn rows(path: &Path, landings: Range<u64>) -> Result<Vec<Vec<(&'static str, String)>>> {
    let sweep = Sweep::read(path, None, None)?;
    let flown = sweep::rows(&sweep, landings, &Silent)?;
    Ok(flown.iter().map(cells).collect())
}

fn cells(row: &LandingRow) -> Vec<(&'static str, String)> {
    LandingRow::header().into_iter().zip(row.cells()).collect()
}

/// Writes a landing as an MCAP file, which Foxglove and Lichtblick show; its name.
pub(crate) fn record(path: &Path, landing: u64, out: &Path) -> Result<String> {
    let sweep = Sweep::read(path, None, None)?;
    let name = format!("landing-{landing:06}.mcap");
    let traces = sweep::replay(&sweep, &[landing])?;
    for trace in &traces {
        let file = out.join(&name);
        std::fs::write(&file, recording::mcap(trace)?).map_err(|e| Error::Write(file, e))?;
    }
    Ok(name)
}
