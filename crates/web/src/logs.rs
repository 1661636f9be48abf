//! Logs of an identification, with its settings.

use std::path::{Path, PathBuf};

use touchdown_campaign::settings_file;
use touchdown_identify::settings::VehicleSettings;
use touchdown_identify::{IdentificationSettings, Origin};
use touchdown_log::{Findings, Map};
use touchdown_model::card::{Input, Vehicle};
use touchdown_trial::Trial;

use crate::Stages;
use crate::inspect::parse_map;
use crate::request::{Data, Error, Result};

/// Name of the settings in messages.
const SETTINGS: &str = "the settings";
/// Rows of all logs of one identification. A fit of a thrust took 770 bytes a row (500 000 rows, measured in Chromium), and a browser gives
/// a calculation 4 GB.
const MOST_ROWS: usize = 4_000_000;

/// Logs, read and mapped, with the settings of their identification.
pub(crate) struct Logs {
    /// The files, without their folders.
    pub(crate) names: Vec<PathBuf>,
    pub(crate) map: Option<Map>,
    pub(crate) settings: IdentificationSettings,
    pub(crate) trials: Vec<Trial>,
    pub(crate) findings: Vec<Findings>,
}

impl Logs {
    pub(crate) fn read(data: &Data, stages: Stages<'_>) -> Result<Self> {
        let map = data.map.as_deref().map(parse_map).transpose()?;
        let mut settings: IdentificationSettings = settings_file::parse(&data.settings, SETTINGS)?;
        settings.check(SETTINGS)?;
        settings.vehicle = with_fields(settings.vehicle, data.vehicle)?;
        let of_map = map.as_ref().map(Map::vehicle).unwrap_or_default();
        let mut settings = settings.of_vehicle(VehicleSettings {
            mass_kg: of_map.mass_kg,
            rotor_radius_m: of_map.rotor_radius_m,
            arm_m: of_map.arm_m,
            rotors: of_map.rotors,
            measured_rotors: of_map.measured_rotors,
        });
        let flight = &mut settings.flight;
        flight.mass_kg = flight.mass_kg.or(map.as_ref().and_then(Map::mass_kg));
        let mut trials = Vec::new();
        let mut findings = Vec::new();
        for (k, path) in data.logs.iter().enumerate() {
            let (name, of) = (file_name(path), data.logs.len());
            stages(&format!("Reading {name} ({} of {of})", k + 1));
            let (trial, found) = touchdown_log::read_trial(path, map.as_ref())?;
            check_rows(trials.iter().map(Trial::len).sum::<usize>() + trial.len())?;
            trials.push(trial.with_name(stem(path)));
            findings.push(found);
        }
        if trials.is_empty() {
            return Err(Error::Data("expected at least one log".to_string()));
        }
        Ok(Self {
            names: data.logs.iter().map(|p| file_name(p).into()).collect(),
            map,
            settings,
            trials,
            findings,
        })
    }

    /// Whether nothing measured the thrust of any log.
    pub(crate) fn are_flights(&self) -> bool {
        self.trials.iter().all(|t| t.channel("thrust_n").is_none())
    }

    pub(crate) fn origin(&self, data: &Data) -> Result<Origin> {
        let known = &self.settings.vehicle;
        let vehicle = Vehicle {
            name: self.map.as_ref().map_or("", Map::description).to_string(),
            mass_kg: known.mass_kg,
            rotor_radius_m: known.rotor_radius_m,
            rotors: known.rotors,
            arm_m: known.arm_m,
        };
        let mut origin = Origin::of(&self.trials, vehicle);
        origin
            .provenance
            .inputs
            .extend(data.map.as_ref().map(|text| Input {
                name: "map.toml".to_string(),
                sha256: touchdown_log::sha256(text.as_bytes()),
            }));
        let text = settings_file::to_toml(&self.settings)?;
        origin.provenance.settings_sha256 = Some(touchdown_log::sha256(text.as_bytes()));
        Ok(origin)
    }

    /// What a person should know of each log, with its name.
    pub(crate) fn warnings_by_log(&self) -> Vec<(PathBuf, String)> {
        let each = self.names.iter().zip(&self.findings);
        let warnings = each.flat_map(|(name, findings)| {
            let all = findings.warnings.iter().cloned().chain(findings.loss());
            all.map(|text| (name.clone(), text))
        });
        warnings.collect()
    }

    pub(crate) fn rows_dropped(&self) -> usize {
        self.findings.iter().map(Findings::rows_dropped).sum()
    }
}

fn check_rows(found: usize) -> Result<()> {
    if found <= MOST_ROWS {
        return Ok(());
    }
    Err(Error::Data(format!(
        "an identification in a browser takes at most {MOST_ROWS} rows of all logs; found {found} or more. In the map, [[windows]] takes \
         parts of a log, and [resample] makes its rows fewer. The command `touchdown identify` has no such limit."
    )))
}

/// The vehicle of the settings with the numbers of the page's fields; a number that both state must be the same.
fn with_fields(settings: VehicleSettings, fields: VehicleSettings) -> Result<VehicleSettings> {
    let rotors = |of: VehicleSettings| of.rotors.map(f64::from);
    for (label, key, set, field) in [
        ("Mass (kg)", "mass_kg", settings.mass_kg, fields.mass_kg),
        (
            "Rotor radius (m)",
            "rotor_radius_m",
            settings.rotor_radius_m,
            fields.rotor_radius_m,
        ),
        ("Rotors", "rotors", rotors(settings), rotors(fields)),
    ] {
        if let (Some(set), Some(field)) = (set, field)
            && set.to_bits() != field.to_bits()
        {
            return Err(Error::Data(format!(
                "expected one {key}; found {field} in the field {label} and {set} in the table [vehicle] of {SETTINGS}"
            )));
        }
    }
    Ok(fields.or(settings))
}

/// The last part of a path.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The file's name without its extension.
fn stem(path: &Path) -> String {
    path.file_stem()
        .map_or_else(|| "log".to_string(), |s| s.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_one_row_too_many_is_refused_with_what_to_do() {
        assert!(check_rows(MOST_ROWS).is_ok());
        let error = check_rows(MOST_ROWS + 1).unwrap_err().to_string();
        assert!(
            error.contains("found 4000001") && error.contains("[resample]"),
            "{error}"
        );
    }

    #[test]
    fn analytic_fields_and_settings_state_one_vehicle() {
        let settings = VehicleSettings {
            arm_m: Some(0.2),
            mass_kg: Some(1.37),
            ..VehicleSettings::default()
        };
        let field = |mass_kg| VehicleSettings {
            mass_kg: Some(mass_kg),
            rotors: Some(4),
            ..VehicleSettings::default()
        };
        let both = with_fields(settings, field(1.37)).unwrap();
        assert_eq!(
            (both.arm_m, both.mass_kg, both.rotors),
            (Some(0.2), Some(1.37), Some(4))
        );
        let error = with_fields(settings, field(1.4)).unwrap_err().to_string();
        assert_eq!(
            error,
            "expected one mass_kg; found 1.4 in the field Mass (kg) and 1.37 in the table [vehicle] of the settings"
        );
    }
}
