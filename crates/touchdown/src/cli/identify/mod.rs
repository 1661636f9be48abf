//! `touchdown identify`.

pub(super) mod flights;
pub(super) mod ground;
pub(super) mod load;
pub(super) mod show;
mod thrust;

use std::path::{Path, PathBuf};

use serde::Serialize;
use touchdown::{Error, Result, settings};
use touchdown_identify::settings::VehicleSettings;
use touchdown_identify::{IdentificationSettings, Origin};
use touchdown_log::Map;
use touchdown_model::Card;
use touchdown_model::card::Vehicle;
use touchdown_trial::Trial;

use super::args::identify::{Identify, IdentifyArgs, IdentifyCommon};
use super::context::Context;
use super::output;
use load::word;
use touchdown_pages::identify::summary::Summary;
use touchdown_terminal::Done;

pub(crate) fn run(context: &Context, args: &IdentifyArgs) -> Result<Done> {
    match &args.what {
        Identify::Thrust {
            common,
            form,
            degree,
            battery,
            rotors,
        } => {
            let mut settings = read_settings(common)?;
            let thrust = &mut settings.thrust;
            thrust.form = form.or(thrust.form);
            thrust.degree = degree.unwrap_or(thrust.degree);
            thrust.battery |= *battery;
            let vehicle = &mut settings.vehicle;
            vehicle.measured_rotors = rotors.or(vehicle.measured_rotors);
            settings.check(&settings_name(common))?;
            thrust::run(context, common, &settings)
        }
        Identify::GroundEffect {
            common,
            thrust,
            form,
        } => {
            let settings = read_settings(common)?;
            settings.check(&settings_name(common))?;
            ground::run(context, common, thrust.as_deref(), form, &settings)
        }
    }
}

/// Where results go.
enum Target {
    /// Nowhere.
    None,
    /// One card.
    File(PathBuf),
    /// Cards, tables, figures and a report.
    Folder(PathBuf),
}

impl Target {
    /// A path that ends in `.toml` is a card, any other a folder.
    fn of(out: Option<&Path>) -> Result<Self> {
        let Some(out) = out else {
            return Ok(Self::None);
        };
        let toml = out
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        match (toml, out.is_dir()) {
            (true, true) => Err(Error::Arguments(format!(
                "--out {}: expected a file for the card, found a folder",
                out.display()
            ))),
            (true, false) => Ok(Self::File(out.to_owned())),
            (false, _) if out.is_file() => Err(Error::Arguments(format!(
                "--out {}: expected a folder or a name that ends in .toml, found a file",
                out.display()
            ))),
            (false, _) => Ok(Self::Folder(out.to_owned())),
        }
    }

    /// Path of a card that is called `name` in a folder.
    fn card(&self, name: &str) -> Option<PathBuf> {
        match self {
            Self::None => None,
            Self::File(card) => Some(card.clone()),
            Self::Folder(folder) => Some(folder.join(name)),
        }
    }
}

fn settings_name(common: &IdentifyCommon) -> String {
    common
        .settings
        .as_ref()
        .map_or_else(|| "arguments".to_string(), |p| p.display().to_string())
}

fn read_settings(common: &IdentifyCommon) -> Result<IdentificationSettings> {
    match &common.settings {
        Some(path) => Ok(settings::read(path)?),
        None => Ok(IdentificationSettings::default()),
    }
}

/// The settings with what the map says of the vehicle where they do not.
fn with_vehicle(settings: &IdentificationSettings, map: Option<&Map>) -> IdentificationSettings {
    let of_map = map.map(Map::vehicle).unwrap_or_default();
    settings.clone().of_vehicle(VehicleSettings {
        mass_kg: of_map.mass_kg,
        rotor_radius_m: of_map.rotor_radius_m,
        arm_m: of_map.arm_m,
        rotors: of_map.rotors,
        measured_rotors: of_map.measured_rotors,
    })
}

/// Arguments that a card's command repeats.
struct Command<'a> {
    what: &'a str,
    common: &'a IdentifyCommon,
    more: Vec<String>,
}

impl Command<'_> {
    /// The command that makes a card from `logs` again.
    fn text(&self, logs: &[PathBuf], card: &str) -> String {
        let mut words = vec!["touchdown identify".to_string(), self.what.to_string()];
        let path = |p: &Path| word(&p.display().to_string());
        words.extend(logs.iter().map(|p| path(p)));
        for (option, file) in [
            ("--map", &self.common.map),
            ("--settings", &self.common.settings),
        ] {
            if let Some(file) = file {
                words.extend([option.to_string(), path(file)]);
            }
        }
        words.extend(self.more.iter().cloned());
        words.extend(["--out".to_string(), word(card)]);
        words.join(" ")
    }
}

/// Vehicle, inputs and settings of cards made from `trials`.
fn origin(
    trials: &[Trial],
    map: Option<&Map>,
    common: &IdentifyCommon,
    settings: &IdentificationSettings,
) -> Result<Origin> {
    let known = &settings.vehicle;
    let vehicle = Vehicle {
        name: map.map_or_else(String::new, |m| m.description().to_string()),
        mass_kg: known.mass_kg,
        rotor_radius_m: known.rotor_radius_m,
        rotors: known.rotors,
        arm_m: known.arm_m,
    };
    let mut origin = Origin::of(trials, vehicle);
    origin
        .provenance
        .inputs
        .extend(load::map_input(common.map.as_deref())?);
    let text = settings::to_toml(settings)?;
    origin.provenance.settings_sha256 = Some(touchdown_log::sha256(text.as_bytes()));
    Ok(origin)
}

/// Writes one card. After Ctrl-C the command reports the state of the file.
fn write_card(context: &Context, path: &Path, card: &Card) -> Result<()> {
    let file = path.display().to_string();
    context.if_interrupted(move || {
        format!("{file} is complete or unchanged; run the same command again")
    });
    Ok(card.write(path)?)
}

/// Writes the files of a folder that every kind of identification has: results, summary and settings.
fn write_tables<T: Serialize>(
    folder: &Path,
    results: &T,
    summary: &Summary,
    settings: &IdentificationSettings,
) -> Result<()> {
    output::write(&folder.join("summary.csv"), summary.csv().as_bytes())?;
    let text = settings::to_toml(settings)?;
    output::write(&folder.join("inputs/settings.toml"), text.as_bytes())?;
    // Last: where it stands, all else does.
    output::results(folder, results)
}
