//! Landings to watch in three dimensions.

use serde_json::Value;
use touchdown_campaign::scene::{Motion, Scene};
use touchdown_sim::landing::space::{SpaceScenario, SpaceTrace};

use crate::error::Result;

/// Every second step of the landing computer: 50 pictures a second are smooth, and 20 s of them take 60 kB.
const EVERY: usize = 2;
/// What is shown of a landing (s): its last part, for a long wait above the deck fills the page.
const LONGEST_S: f64 = 20.0;

/// When landings that are watched together begin (s).
pub fn start_s<'a>(traces: impl IntoIterator<Item = &'a SpaceTrace>) -> f64 {
    let ends = traces.into_iter().filter_map(|trace| trace.rows.last());
    let end_s = ends.map(|row| row.time_s).fold(0.0, f64::max);
    (end_s - LONGEST_S).max(0.0)
}

/// A landing as the page's player reads it.
pub fn watch(scenario: &SpaceScenario, trace: &SpaceTrace, from_s: f64) -> Result<Value> {
    let mut landing = serde_json::to_value(Scene::of(scenario))?;
    let frames = serde_json::to_value(Motion::of(trace, EVERY, from_s))?;
    landing["frames"] = frames;
    Ok(landing)
}
