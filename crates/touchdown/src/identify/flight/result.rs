//! What is told of an identification from flights, beside the card.

use serde::Serialize;

use super::Flight;
use super::choose::Candidate;
use super::ground::{Basis, GroundEffect, Refused};
use super::hover::Hover;
use super::numbers::Number;
use super::phases::Run;
use super::pieces::LeftOut;
use super::spread::{Blocks, Sure};

/// Heights at which the curve is printed.
const POINTS: usize = 25;

/// The curve at one height.
#[derive(Clone, Debug, Serialize)]
pub struct At {
    /// Height as logged (m).
    pub height_m: f64,
    /// Thrust over that out of ground effect, minus one.
    #[serde(flatten)]
    pub ratio: Sure,
}

/// One run of the motors.
#[derive(Clone, Debug, Serialize)]
pub struct RunResult {
    /// The log.
    pub log: String,
    /// Motors on and off, stand before.
    #[serde(flatten)]
    pub run: Run,
    /// Rows that counted; none where the run was left out.
    pub rows_used: usize,
    /// Specific force at the throttle of hover, in gravities.
    pub thrust_scale: Option<f64>,
    /// Constant error of the height (m).
    pub height_error_m: Option<f64>,
}

/// All that flights said.
#[derive(Clone, Debug, Serialize)]
pub struct FlightResult {
    /// What it was identified from.
    pub basis: Basis,
    /// Law of the static curve.
    pub curve: &'static str,
    /// Throttle in hover.
    pub hover_throttle: f64,
    /// Numbers of the model.
    pub numbers: Vec<Number>,
    /// The static curve.
    pub ratio: Vec<At>,
    /// What intervals rest on, and how many there are of it.
    pub intervals_from: Blocks,
    /// Count of those.
    pub blocks: usize,
    /// Runs of the motors.
    pub runs: Vec<RunResult>,
    /// Hovers at rest, if it was identified from them.
    pub hovers: Vec<Hover>,
    /// Models that were tried.
    pub tried: Vec<Candidate>,
    /// What was not identified, why, and what to record.
    pub refused: Vec<Refused>,
    /// Rows that were left out, and why.
    pub left_out: Vec<LeftOut>,
}

impl GroundEffect {
    /// All that is told; `flights` are those that it was identified from.
    #[must_use]
    pub fn result(&self, flights: &[Flight]) -> FlightResult {
        let [lo, hi] = self.heights_m;
        let hi = hi.min(lo + 8.0 * self.rotor_radius_m);
        let ratio = (0..POINTS)
            .map(|k| lo + (hi - lo) * k as f64 / (POINTS - 1) as f64)
            .filter_map(|height_m| {
                Some(At {
                    height_m,
                    ratio: self.ratio(height_m)?,
                })
            })
            .collect();
        let mut runs = Vec::new();
        for (index, (flight, phases)) in flights.iter().zip(&self.phases).enumerate() {
            for (number, run) in phases.runs.iter().enumerate() {
                let place = self
                    .pieces
                    .iter()
                    .position(|p| p.flight == index && p.run == number);
                let local = place.map(|i| self.fit.locals[i]);
                runs.push(RunResult {
                    log: flight.name.clone(),
                    run: run.clone(),
                    rows_used: place.map_or(0, |i| self.pieces[i].rows.len()),
                    thrust_scale: local.map(|l| l.scale),
                    height_error_m: local.map(|l| l.bias * self.rotor_radius_m),
                });
            }
        }
        FlightResult {
            basis: self.basis,
            hovers: self.hovers.clone(),
            curve: self.fit.shape.curve.name(),
            hover_throttle: self.hover_throttle,
            numbers: self.numbers(),
            ratio,
            intervals_from: self.spread.blocks,
            blocks: self.spread.count,
            runs,
            tried: self.tried.clone(),
            refused: self.refused.clone(),
            left_out: self.left_out.clone(),
        }
    }
}
