//! Settings from a file.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sindy::Libraries;

use super::args::FitArgs;
use crate::error::{Error, Result};
use touchdown_files::TomlError;
use touchdown_terminal::Done;
use touchdown_terminal::Terminal;

/// The keys of a file of settings; arguments come before it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Settings {
    /// Candidate terms, for all equations or for each.
    pub(super) library: Option<Libraries>,
    /// How the model is chosen.
    pub(super) identify: sindy::identify::Settings,
}

/// The defaults, with a comment on each.
const DEFAULTS: &str = include_str!("../../settings/fit.toml");

/// `sindy settings`.
pub(crate) fn print(terminal: &Terminal) -> Result<Done> {
    if terminal.wants_json() {
        terminal.object(&Settings::default());
    } else {
        terminal.print(DEFAULTS);
    }
    Ok(Done::Whole)
}

/// The settings that the arguments name, checked.
pub(super) fn of(args: &FitArgs) -> Result<Settings> {
    let mut settings = match &args.settings {
        None => Settings::default(),
        Some(path) => read(path)?,
    };
    settings.identify.discrete |= args.discrete;
    settings.identify.stable |= args.stable;
    settings.identify.known.extend(args.known.iter().cloned());
    settings.identify.signs.extend(args.sign.iter().cloned());
    settings
        .identify
        .conserve
        .extend(args.conserve.iter().cloned());
    settings
        .identify
        .constraints
        .extend(args.constraint.iter().cloned());
    settings
        .identify
        .diffusion
        .extend(args.diffusion.iter().cloned());
    if let Some(noise) = args.noise {
        settings.identify.noise = noise.into();
    }
    let positions = args.positions();
    if !positions.is_empty() {
        settings.identify.second_order = positions;
    }
    let place = args.settings.as_deref().unwrap_or(Path::new("settings"));
    let place = place.display().to_string();
    settings
        .identify
        .validate()
        .map_err(Error::refused(place))?;
    Ok(settings)
}

fn read(path: &Path) -> Result<Settings> {
    let text = touchdown_files::read_text(path).map_err(Error::unread(path))?;
    toml::from_str(&text).map_err(|e| Error::Settings {
        file: path.display().to_string(),
        message: TomlError::new(&text, &e).to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_the_printed_settings_are_the_defaults() {
        let printed: Settings = toml::from_str(DEFAULTS).unwrap();
        assert_eq!(printed.identify, sindy::identify::Settings::default());
        assert_eq!(
            printed.library,
            Some(Libraries::shared([super::super::terms::DEFAULT]))
        );
        // Every key is there.
        let all = toml::Table::try_from(sindy::identify::Settings::default()).unwrap();
        let shown: toml::Table = toml::from_str(DEFAULTS).unwrap();
        let shown = shown["identify"].as_table().unwrap();
        assert_eq!(
            all.keys().collect::<Vec<_>>(),
            shown.keys().collect::<Vec<_>>()
        );
    }
}
