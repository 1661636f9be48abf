//! `touchdown fly`.

mod camera;
mod flight;
mod interrupt;
mod pool;
mod recorder;
mod view;

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;
use touchdown::settings;
use touchdown::{Error, Result};
use touchdown_campaign::cards::CardPaths;
use touchdown_campaign::vehicle::check_lift;
use touchdown_flight::touch::{CRASH_MPS, HARD_SHARE};
use touchdown_link::LinkError;
use touchdown_link::companion::{Session, Summary};
use touchdown_link::recording::{Recorder, Recording};
use touchdown_link::settings::FlightSettings;
use touchdown_link::wire::signing::{Signing, SigningKey, signature_time};
use touchdown_model::Card;
use touchdown_terminal::Done;

use super::args::fly::FlyArgs;
use super::context::Context;
use super::live::Live;
use super::output;
use interrupt::Interrupt;

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
            let Loaded { settings, files } = load(path)?;
            for (what, file) in &files {
                output::replaces_not(&args.out, what, file)?;
            }
            let session = Session {
                take_control: args.take_control,
                set_parameters: args.set_parameters,
                signing: signing(&settings)?,
            };
            let interrupt = Interrupt::watch(context, &args.out);
            let live = args.live.map(|address| Live::start(context, address));
            let watcher = live.transpose()?.map(|live| live.watcher());
            let record = || {
                let recorder = Recorder::create(&args.out, &settings, &session)?;
                Ok(recorder.watched_by(watcher))
            };
            let (summary, recorded) =
                flight::fly(context, &settings, &session, record, &interrupt)?;
            context.say(&closing(&summary, &args.out));
            context.line_object(&Flown {
                recording: &args.out,
                flight: &summary,
            });
            recorded.map(|()| Done::Whole)
        }
        (None, None) => Err(Error::Arguments(
            "a flight needs its settings: touchdown settings fly > flight.toml".to_string(),
        )),
    }
}

/// What a flight is made of.
pub(super) struct Loaded {
    /// The settings, with their cards in place of the models.
    pub settings: FlightSettings,
    /// The files that they were read from, and what each is.
    files: Vec<(&'static str, PathBuf)>,
}

/// Reads the settings and the cards that they name.
pub(super) fn load(path: &Path) -> Result<Loaded> {
    let mut settings: FlightSettings = settings::read(path)?;
    let cards = std::mem::take(&mut settings.cards);
    let cards = CardPaths {
        thrust: cards.thrust,
        empirical: cards.empirical,
        dynamic: cards.dynamic,
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    let cards = cards.from(folder);
    let mut files = vec![("settings", path.to_owned())];
    let named = [&cards.thrust, &cards.empirical, &cards.dynamic];
    files.extend(
        named
            .into_iter()
            .flatten()
            .map(|card| ("card", card.clone())),
    );
    if let Some(file) = &mut settings.signing.key_file {
        *file = folder.join(&file);
        files.push(("key", file.clone()));
    }
    if let Some(images) = &mut settings.camera.folder {
        *images = folder.join(&images);
    }
    settings.camera.check().map_err(LinkError::from)?;
    let rotors = settings.vehicle.rotors;
    let model = |card: &Card| Ok(card.thrust_model_of(rotors)?);
    if let Some(card) = cards.put_into(&model, &mut settings.models)? {
        let weight_n = settings.vehicle.mass_kg * settings.vehicle.gravity_mps2;
        check_lift(&card, &settings.models.thrust, weight_n)?;
    }
    Ok(Loaded { settings, files })
}

/// The key that the settings name.
fn key(settings: &FlightSettings) -> Result<Option<SigningKey>> {
    let Some(file) = &settings.signing.key_file else {
        return Ok(None);
    };
    let unfit = |reason: String| {
        Error::Arguments(format!("signing.key_file: {}: {reason}", file.display()))
    };
    let text = std::fs::read_to_string(file).map_err(|e| unfit(e.to_string()))?;
    SigningKey::from_text(&text).map(Some).map_err(unfit)
}

/// The signing of a flight that begins now.
fn signing(settings: &FlightSettings) -> Result<Option<Signing>> {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let unix_us = since.map_or(0, |since| since.as_micros());
    let start = signature_time(u64::try_from(unix_us).unwrap_or(u64::MAX));
    Ok(key(settings)?.map(|key| Signing {
        key,
        link_id: settings.signing.link_id,
        start,
    }))
}

/// The closing summary, after the note that names the ending.
fn closing(summary: &Summary, out: &Path) -> String {
    let mut lines = Vec::new();
    if summary.setpoints > 0 {
        lines.push(format!(
            "in control for {:.1} s, {} setpoints, {} late ticks",
            summary.in_control_s, summary.setpoints, summary.late_ticks
        ));
    }
    if let Some(touch) = summary.touch {
        lines.push(format!(
            "{}: the estimated speed at the touch is {:.2} m/s (hard above {:.2}, a crash above {CRASH_MPS} m/s)",
            touch.class.words(),
            touch.speed_mps,
            HARD_SHARE * CRASH_MPS
        ));
    }
    for (what, times) in [
        ("deviation of the period from 10 ms", summary.jitter),
        (
            "age of the newest reading at a setpoint",
            summary.reading_age,
        ),
    ] {
        if let Some(times) = times {
            lines.push(format!(
                "{what}: median {:.2} ms, 99 % {:.2} ms, 99.9 % {:.2} ms, greatest {:.2} ms",
                times.p50_ms, times.p99_ms, times.p999_ms, times.greatest_ms
            ));
        }
    }
    lines.push(format!("recording: {}", out.display()));
    lines.join("\n")
}

fn replay(context: &Context, path: &Path) -> Result<Done> {
    let recording = Recording::read(path)?;
    let replay = touchdown_link::replay::replay(&recording, key(&recording.settings)?)?;
    if replay.cut_off {
        context.warn(
            "the recording has no end, as after a kill: it was replayed up to its last whole event",
        );
    }
    if let Some(difference) = &replay.difference {
        let sent = |messages: &[String]| match messages {
            [] => "nothing".to_string(),
            messages => messages.join(", "),
        };
        return Err(Error::data(
            path.display().to_string(),
            format!(
                "the bytes of the flight, {} at {:.6} s upon event {} ({})",
                sent(&difference.recorded),
                difference.time_s,
                difference.index,
                difference.event,
            ),
            sent(&difference.replayed),
        ));
    }
    context.object(&replay);
    context.say(&format!(
        "{} events, {} bytes sent: all as in the flight.",
        replay.events, replay.sent_bytes
    ));
    Ok(Done::with_loss(replay.cut_off))
}
