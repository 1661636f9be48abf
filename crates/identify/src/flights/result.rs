//! The result of an identification from flights, beside the card.

use serde::Serialize;

use super::armed_interval_result::{ArmedIntervalResult, ExtraLift};
use super::ground::{Basis, GroundEffect};
use super::hover::Hover;
use super::model::Curve;
use super::numbers::Number;
use super::resampling::ResamplingUnit;
use super::routes::Route;
use super::segments::Excluded;
use super::selection::Candidate;
use super::{Flight, FlightSettings};
use crate::estimate::Estimate;
use crate::refusal::Refusal;

/// Heights at which the curve is printed.
const POINTS: usize = 49;

/// The curve at one height.
#[derive(Clone, Debug, Serialize)]
pub struct At {
    /// Height as logged (m).
    pub height_m: f64,
    /// Thrust over that out of ground effect, minus one.
    #[serde(flatten)]
    pub ratio: Estimate,
}

/// The whole result of an identification from flights.
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
    /// What was resampled for the intervals.
    pub intervals_from: ResamplingUnit,
    /// How many of them there are.
    pub blocks: usize,
    /// Extra lift near the ground by the static curve; absent where none was identified.
    pub extra_lift: Option<ExtraLift>,
    /// Armed intervals.
    pub runs: Vec<ArmedIntervalResult>,
    /// Hovers at rest, if it was identified from them.
    pub hovers: Vec<Hover>,
    /// The routes that the logs allow, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub routes: Vec<Route>,
    /// Models that were tried.
    pub tried: Vec<Candidate>,
    /// What was not identified, why, and what to record.
    pub refused: Vec<Refusal>,
    /// Unused rows, with the reason.
    pub left_out: Vec<Excluded>,
}

impl GroundEffect {
    /// The whole result; `flights` and `settings` are those that it was identified from and by.
    #[must_use]
    pub fn result(&self, flights: &[Flight], settings: &FlightSettings) -> FlightResult {
        let [lo, hi] = self.heights_m;
        let hi = hi.min(lo + 8.0 * self.rotor_radius_m);
        let points = match self.fit.shape.curve {
            Curve::Free => 0,
            _ => POINTS,
        };
        let ratio = (0..points)
            .map(|k| lo + (hi - lo) * k as f64 / (POINTS - 1) as f64)
            .filter_map(|height_m| {
                Some(At {
                    height_m,
                    ratio: self.ratio(height_m)?,
                })
            })
            .collect();
        FlightResult {
            basis: self.basis,
            hovers: self.hovers.clone(),
            curve: self.fit.shape.curve.name(),
            hover_throttle: self.hover_throttle,
            numbers: self.numbers(),
            ratio,
            intervals_from: self.spread.blocks,
            blocks: self.spread.count,
            extra_lift: self.extra_lift_of_curve(settings),
            runs: self.runs(flights, settings),
            routes: Vec::new(),
            tried: self.tried.clone(),
            refused: self.refused.clone(),
            left_out: self.left_out.clone(),
        }
    }
}
