//! Cards on the logs of flights: what is held, and the factors of each armed interval.

use touchdown::Result;
use touchdown_identify::flights::FlightSettings;
use touchdown_identify::flights::judge::{FlightCards, Held};
use touchdown_identify::validation::{FreeRun, judge_flight};
use touchdown_log::Map;
use touchdown_model::{Card, Kind};
use touchdown_trial::Trial;

use super::Results;
use crate::cli::args::identify::ValidateArgs;

/// The columns of [`factors`].
pub(super) const HEADER: [&str; 8] = [
    "card",
    "log",
    "armed interval",
    "from s",
    "to s",
    "rows",
    "thrust scale",
    "height offset m",
];

/// How flights are judged.
pub(super) struct Flights {
    settings: FlightSettings,
    rotors: Option<u32>,
    held: Held,
}

impl Flights {
    pub(super) fn of(args: &ValidateArgs, map: Option<&Map>) -> Self {
        let vehicle = map.map(Map::vehicle).unwrap_or_default();
        Self {
            settings: FlightSettings {
                mass_kg: vehicle.mass_kg,
                rotor_radius_m: vehicle.rotor_radius_m,
                ..FlightSettings::default()
            },
            rotors: vehicle.rotors,
            held: Held {
                scale: args.scale,
                height_offset_m: args.height_offset,
            },
        }
    }

    /// A card on the log of a flight; `free_air` is the thrust card that a ground-effect card needs.
    pub(super) fn judge(
        &self,
        card: &Card,
        free_air: Option<&Card>,
        trial: &Trial,
    ) -> Result<FreeRun> {
        let cards = match (card.kind, free_air) {
            (Kind::GroundEffect, Some(thrust)) => FlightCards {
                thrust,
                ground_effect: Some(card),
                rotors: self.rotors,
            },
            _ => FlightCards {
                thrust: card,
                ground_effect: None,
                rotors: self.rotors,
            },
        };
        Ok(judge_flight(&cards, trial, &self.settings, self.held)?)
    }
}

/// Scale and height offset of every armed interval, a row each.
pub(super) fn factors(results: &Results<'_>) -> Vec<Vec<String>> {
    let [card, log] = super::names_in_tables(results);
    let held = |text: String, held: bool| if held { format!("{text} (held)") } else { text };
    let of_row = |r: &super::Row| -> Vec<Vec<String>> {
        let of = |i: &touchdown_identify::flights::judge::IntervalFactors| {
            let offset = i.height_offset_m.map_or_else(
                || "–".to_string(),
                |m| held(format!("{m:+.4}"), i.height_offset_is_held),
            );
            vec![
                card(&r.card),
                log(&r.log),
                i.number.to_string(),
                format!("{:.1}", i.time_s[0]),
                format!("{:.1}", i.time_s[1]),
                i.rows.to_string(),
                held(format!("{:.4}", i.scale), i.scale_is_held),
                offset,
            ]
        };
        r.armed_intervals.iter().map(of).collect()
    };
    results.results.iter().flat_map(of_row).collect()
}
