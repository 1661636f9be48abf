//! Landings of a scenario.

use std::ops::Range;
use std::path::Path;

use serde::Serialize;
use touchdown_campaign::progress::Silent;
use touchdown_campaign::recording;
use touchdown_campaign::sweep::{self, LandingRow, Sweep};
use touchdown_lander::state_machine::Phase;
use touchdown_sim::body::plant::Surface;
use touchdown_sim::landing::space::{SpaceLanding, TraceRow};

use crate::request::{Error, Result};

/// One landing.
#[derive(Debug, Serialize)]
pub(crate) struct Landing {
    /// The row of `landings.csv`, column by column.
    row: Vec<(&'static str, String)>,
    /// What of the vehicle follows from the cards, in a line.
    vehicle: Option<String>,
    /// Half the side of the deck, m; none where it has no edge.
    deck_half_side_m: Option<f64>,
    rotor_radius_m: f64,
    /// Distance of neighbouring rotor axes.
    rotor_spacing_m: f64,
    rotor_height_m: f64,
    /// Distance of the feet from the vertical axis, and their depth below the reference point.
    feet_m: [f64; 2],
    weight_n: f64,
    frames: Frames,
}

/// Time series of a landing, a value for every step of the landing computer.
#[derive(Debug, Default, Serialize)]
struct Frames {
    time_s: Vec<f64>,
    position_m: Vec<[f64; 3]>,
    /// w, x, y, z.
    attitude: Vec<[f64; 4]>,
    deck_m: Vec<[f64; 3]>,
    deck_normal: Vec<[f64; 3]>,
    /// Height above the deck along its normal.
    height_m: Vec<f64>,
    estimated_height_m: Vec<f64>,
    target_height_m: Vec<Option<f64>>,
    velocity_mps: Vec<f64>,
    rotor_n: Vec<[f64; 4]>,
    feet_n: Vec<[f64; 4]>,
    ground_effect_n: Vec<f64>,
    counted_ground_effect_n: Vec<f64>,
    deck_mps: Vec<f64>,
    estimated_deck_mps: Vec<f64>,
    phase: Vec<Phase>,
}

impl Frames {
    fn push(&mut self, row: &TraceRow) {
        self.time_s.push(row.time_s);
        self.position_m.push(row.position_m);
        self.attitude.push(row.attitude);
        self.deck_m.push(row.deck_m);
        self.deck_normal.push(row.deck_normal);
        self.height_m.push(row.relative_m[2]);
        self.estimated_height_m.push(row.estimated_m[2]);
        self.target_height_m
            .push(row.target.map(|[height, _]| height));
        self.velocity_mps.push(row.relative_mps[2]);
        self.rotor_n.push(row.rotor_n);
        self.feet_n.push(row.feet_n);
        self.ground_effect_n.push(row.ground_effect_n);
        self.counted_ground_effect_n
            .push(row.counted_ground_effect_n);
        self.deck_mps.push(row.deck_mps[2]);
        self.estimated_deck_mps.push(row.estimated_deck_mps);
        self.phase.push(row.phase);
    }
}

/// Flies a landing of a scenario for its frames.
pub(crate) fn one(path: &Path, landing: u64) -> Result<Landing> {
    let sweep = Sweep::read(path, None, None)?;
    let flown = fly(&sweep, landing)?;
    let scenario = &sweep.settings().scenario;
    let mut frames = Frames::default();
    let rows = flown.trace.iter().flat_map(|trace| &trace.rows);
    rows.for_each(|row| frames.push(row));
    let plant = &scenario.plant;
    Ok(Landing {
        row: cells(&LandingRow::of(landing, &flown)),
        vehicle: sweep.vehicle().map(str::to_owned),
        deck_half_side_m: (plant.surface == Surface::Plate).then_some(0.5 * plant.plate_side_m),
        rotor_spacing_m: plant.rotor_spacing_m,
        rotor_radius_m: plant.rotor_radius_m,
        rotor_height_m: plant.rotor_height_m,
        feet_m: [scenario.legs.radius_m, scenario.legs.depth_m],
        weight_n: plant.mass_kg * plant.gravity_mps2,
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
