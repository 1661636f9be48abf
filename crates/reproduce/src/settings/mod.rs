//! Settings of whole runs, as they stand in TOML files.

pub mod sea;

use std::path::Path;

use serde::{Deserialize, Serialize};
use touchdown_campaign::sweep::SERIES;
use touchdown_identify::IdentificationSettings;
use touchdown_sim::rig::RigSettings;

use crate::error::Result;

pub use touchdown_campaign::settings_file::{parse, read, to_toml};
pub use touchdown_campaign::vertical::settings::LandSettings;

/// Everything that `reproduce` depends on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReproduceSettings {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Landings of every method in every experiment.
    pub trials: usize,
    /// Fewer rig trials, for a fast look.
    pub quick: bool,
    /// The virtual rig.
    pub rig: RigSettings,
    /// Identification.
    pub identification: IdentificationSettings,
    /// Landing on the ground.
    pub ground_landing: LandSettings,
    /// Landing on the oscillating deck.
    pub deck_landing: LandSettings,
    /// Landing at sea, in six degrees of freedom.
    pub sea: sea::SeaSettings,
}

impl Default for ReproduceSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            trials: 40,
            quick: false,
            rig: RigSettings::default(),
            identification: IdentificationSettings::default(),
            ground_landing: LandSettings::ground(),
            deck_landing: LandSettings::deck(),
            sea: sea::SeaSettings::default(),
        }
    }
}

impl ReproduceSettings {
    /// Reads a file. Files that it names with relative paths lie in its folder.
    ///
    /// # Errors
    /// A file that cannot be read, or keys and values that are not known.
    pub fn from_file(path: &Path) -> Result<Self> {
        let mut settings: Self = read(path)?;
        settings.sea = settings.sea.from(path.parent().unwrap_or(Path::new(".")));
        Ok(settings)
    }

    /// The settings of a fast look: fewer rig trials and landings.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            trials: 8,
            quick: true,
            ..Self::default()
        }
    }

    /// The same with the files that they name under the names that they have in a run's folder.
    #[must_use]
    pub fn with_files_here(&self) -> Self {
        let mut here = self.clone();
        if let Some(series) = &mut here.sea.series {
            series.file = SERIES.into();
        }
        here
    }
}

/// What a caller changes in the settings of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Whether to take fewer rig trials, and fewer landings where no settings are given.
    pub quick: bool,
    /// Seed of all random numbers.
    pub seed: Option<u64>,
    /// Landings of every method.
    pub trials: Option<usize>,
}

impl Overrides {
    /// The settings that are given, otherwise the defaults, with these changes.
    #[must_use]
    pub fn of(self, given: Option<ReproduceSettings>) -> ReproduceSettings {
        let mut settings = given.unwrap_or_else(|| match self.quick {
            true => ReproduceSettings::quick(),
            false => ReproduceSettings::default(),
        });
        settings.quick |= self.quick;
        settings.seed = self.seed.unwrap_or(settings.seed);
        settings.trials = self.trials.unwrap_or(settings.trials);
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_fast_look_has_fewer_landings_unless_they_are_given() {
        let quick = Overrides {
            quick: true,
            ..Overrides::default()
        };
        assert_eq!(quick.of(None), ReproduceSettings::quick());
        let given = ReproduceSettings {
            trials: 30,
            seed: 5,
            ..ReproduceSettings::default()
        };
        let expected = ReproduceSettings {
            quick: true,
            ..given.clone()
        };
        assert_eq!(quick.of(Some(given.clone())), expected);
        let more = Overrides {
            trials: Some(3),
            seed: Some(9),
            quick: false,
        };
        let found = more.of(Some(expected));
        assert_eq!((found.trials, found.seed, found.quick), (3, 9, true));
    }

    #[test]
    fn prop_keys_left_out_keep_the_default_of_their_own_place() {
        let text = "[deck_landing.control]\nc_per_s = 0.6\n[deck_landing.scenario.plant]\nturbulence = 0.02\n";
        let read: ReproduceSettings = parse(text, "s.toml").unwrap();
        let mut expected = ReproduceSettings::default();
        expected.deck_landing.control.c_per_s = 0.6;
        expected.deck_landing.scenario.plant.turbulence = 0.02;
        assert_eq!(read, expected);
        let still: ReproduceSettings =
            parse("[deck_landing.scenario.deck]\nkind = \"still\"\n", "s.toml").unwrap();
        assert_eq!(
            still.deck_landing.scenario.deck,
            touchdown_sim::deck::DeckMotion::Still
        );
    }

    #[test]
    fn prop_a_table_may_leave_keys_out_at_any_depth() {
        let text = "[deck_landing.control.gains]\nk_p = 5.0\n[deck_landing.scenario.deck]\namplitude_m = 0.06\n";
        let read: ReproduceSettings = parse(text, "s.toml").unwrap();
        assert_eq!(read.deck_landing.control.gains.k_p, 5.0);
        assert_eq!(read.deck_landing.control.gains.gamma, 2.0);
        assert_eq!(read.deck_landing.scenario.deck.highest_m(), 0.06);
    }

    #[test]
    fn prop_unknown_keys_are_named_with_their_line() {
        let error = parse::<ReproduceSettings>("seed = 1\n\ncolour = 3\n", "s.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("s.toml") && error.contains("line 3") && error.contains("colour"),
            "{error}"
        );
    }

    #[test]
    fn prop_settings_are_read_back_as_they_were_written() {
        let settings = ReproduceSettings {
            seed: 77,
            ..ReproduceSettings::quick()
        };
        assert_eq!(
            parse::<ReproduceSettings>(&to_toml(&settings).unwrap(), "s.toml").unwrap(),
            settings
        );
    }
}
