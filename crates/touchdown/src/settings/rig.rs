//! The scenario file of `touchdown rig`.

use serde::{Deserialize, Serialize};
use touchdown_campaign::settings_file::check_seed;
use touchdown_sim::body::plant::Plant;
use touchdown_sim::rig::sets::{self, Extent};
use touchdown_sim::rig::{RigSettings, RigTrial};

use crate::error::{Error, Result};

/// A standard set of rig trials.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RigSet {
    /// Five ramps and five sines of throttle, plate removed.
    ThrustTraining,
    /// A ramp and a sine, plate removed.
    ThrustValidation,
    /// As `thrust_training`, plate at 0.75 m.
    ThrustTrainingWithPlate,
    /// As `thrust_validation`, plate at 0.75 m.
    ThrustValidationWithPlate,
    /// The paper's three scenarios.
    GroundEffectPaper,
    /// The paper's scenarios, multi-sine plate motion and slow sweeps.
    GroundEffectRich,
    /// Vehicle and plate both in motion.
    GroundEffectMoving,
    /// As `ground_effect_moving`, at other throttles.
    GroundEffectMovingValidation,
    /// Approaches, triangles and sines at 10 to 16 N.
    GroundEffectValidation,
}

impl RigSet {
    /// The name, as in files and folders.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ThrustTraining => "thrust_training",
            Self::ThrustValidation => "thrust_validation",
            Self::ThrustTrainingWithPlate => "thrust_training_with_plate",
            Self::ThrustValidationWithPlate => "thrust_validation_with_plate",
            Self::GroundEffectPaper => "ground_effect_paper",
            Self::GroundEffectRich => "ground_effect_rich",
            Self::GroundEffectMoving => "ground_effect_moving",
            Self::GroundEffectMovingValidation => "ground_effect_moving_validation",
            Self::GroundEffectValidation => "ground_effect_validation",
        }
    }

    /// The trials.
    ///
    /// # Errors
    /// A plant that makes no sense.
    pub fn trials(self, settings: &RigSettings) -> Result<Vec<RigTrial>> {
        Ok(match self {
            Self::ThrustTraining => sets::thrust_training(false, Extent::Full),
            Self::ThrustValidation => sets::thrust_validation(false),
            Self::ThrustTrainingWithPlate => sets::thrust_training(true, Extent::Full),
            Self::ThrustValidationWithPlate => sets::thrust_validation(true),
            Self::GroundEffectPaper => sets::ground_effect_paper(Extent::Full),
            Self::GroundEffectRich => sets::ground_effect_rich(Extent::Full),
            Self::GroundEffectMoving => sets::ground_effect_moving(Extent::Full),
            Self::GroundEffectMovingValidation => {
                sets::ground_effect_moving_validation(Extent::Full)
            }
            Self::GroundEffectValidation => {
                sets::ground_effect_validation(Plant::new(&settings.plant)?.motor(), Extent::Full)
            }
        })
    }
}

/// What `touchdown rig` runs.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigScenario {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Standard sets to run, each into a folder of its name.
    pub sets: Vec<RigSet>,
    /// The rig.
    pub rig: RigSettings,
    /// Further trials, into the folder `trials`.
    pub trials: Vec<RigTrial>,
}

impl Default for RigScenario {
    fn default() -> Self {
        Self {
            seed: 1,
            sets: vec![
                RigSet::ThrustTraining,
                RigSet::ThrustValidation,
                RigSet::GroundEffectRich,
                RigSet::GroundEffectValidation,
            ],
            rig: RigSettings::default(),
            trials: Vec::new(),
        }
    }
}

impl RigScenario {
    /// Checks all settings; `file` names them in errors.
    ///
    /// # Errors
    /// The first setting out of range, names that are not fit for files, or nothing to run.
    pub fn check(&self, file: &str) -> Result<()> {
        let bad = |key: &str, message: String| Error::Settings {
            file: file.to_string(),
            message: format!("key `{key}`: {message}"),
        };
        check_seed(self.seed, file)?;
        self.rig.validate().map_err(|e| bad("rig", e.to_string()))?;
        if self.sets.is_empty() && self.trials.is_empty() {
            return Err(bad(
                "sets",
                "expected a set, or `[[trials]]`; found neither".into(),
            ));
        }
        for (i, set) in self.sets.iter().enumerate() {
            if self.sets[..i].contains(set) {
                return Err(bad("sets", format!("`{}` stands twice", set.name())));
            }
        }
        for (i, trial) in self.trials.iter().enumerate() {
            let fit = |c: char| c.is_alphanumeric() || "-_.".contains(c);
            if trial.name.is_empty() || trial.name.starts_with('.') || !trial.name.chars().all(fit)
            {
                let expected = "expected letters, digits, `-`, `_` and `.`";
                return Err(bad(
                    &format!("trials[{i}].name"),
                    format!("{expected}; found `{}`", trial.name),
                ));
            }
            if self.trials[..i].iter().any(|t| t.name == trial.name) {
                return Err(bad(
                    &format!("trials[{i}].name"),
                    format!("`{}` stands twice", trial.name),
                ));
            }
        }
        Ok(())
    }
}
