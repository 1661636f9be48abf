//! `touchdown fly`.

mod flight;
mod recorder;

use std::path::Path;

use serde::Serialize;
use touchdown::settings;
use touchdown::{Error, Result};
use touchdown_campaign::cards::CardPaths;
use touchdown_link::companion::Summary;
use touchdown_link::recording::Recording;
use touchdown_link::settings::FlightSettings;
use touchdown_terminal::Done;

use super::args::fly::FlyArgs;
use super::context::Context;

/// The object of `--json`.
#[derive(Serialize)]
struct Flown<'a> {
    recording: &'a Path,
    flight: &'a Summary,
}

pub(crate) fn run(context: &Context, args: &FlyArgs) -> Result<Done> {
    match (&args.replay, &args.settings) {
        (Some(recording), _) => replay(context, recording),
        (None, Some(path)) => {
            let settings = load(path)?;
            let summary = flight::fly(context, &settings, &args.out, args.take_control)?;
            context.say(&format!("recording: {}", args.out.display()));
            context.object(&Flown {
                recording: &args.out,
                flight: &summary,
            });
            Ok(Done::Whole)
        }
        (None, None) => Err(Error::Arguments(
            "a flight needs its settings: touchdown settings fly > flight.toml".to_string(),
        )),
    }
}

/// The settings, with their cards in place of the models.
pub(super) fn load(path: &Path) -> Result<FlightSettings> {
    let mut settings: FlightSettings = settings::read(path)?;
    let cards = std::mem::take(&mut settings.cards);
    let cards = CardPaths {
        thrust: cards.thrust,
        empirical: cards.empirical,
        dynamic: cards.dynamic,
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    cards.from(folder).put_into(&mut settings.models)?;
    Ok(settings)
}

fn replay(context: &Context, path: &Path) -> Result<Done> {
    let recording = Recording::read(path)?;
    let replay = touchdown_link::replay::replay(&recording)?;
    context.object(&replay);
    if replay.cut_off {
        context.warn("the recording has no end, as after a kill; what is whole was run");
    }
    if let Some(difference) = &replay.difference {
        return Err(Error::data(
            path.display().to_string(),
            format!(
                "the bytes of the flight: {}",
                difference.recorded.join(", ")
            ),
            format!(
                "other bytes at {} s, upon event {} ({}): {}",
                difference.time_s,
                difference.index,
                difference.event,
                difference.replayed.join(", ")
            ),
        ));
    }
    context.say(&format!(
        "{} events, {} bytes sent: all as in the flight.",
        replay.events, replay.sent_bytes
    ));
    Ok(Done::with_loss(replay.cut_off))
}
