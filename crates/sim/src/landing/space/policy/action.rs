//! Actions, numbers in [-1, 1], and the commands that they stand for.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;

/// What a command asks for beside thrust (N).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandKind {
    /// Attitude w, x, y, z, of unit length.
    Attitude,
    /// Rates about body axes, rad/s.
    Rates,
}

impl CommandKind {
    /// Numbers of a command.
    #[must_use]
    pub fn numbers(self) -> usize {
        match self {
            Self::Attitude => 5,
            Self::Rates => 4,
        }
    }
}

/// What the numbers of an action are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActionKind {
    /// Thrust, roll and pitch.
    #[default]
    Attitude,
    /// Thrust, and rates about the body's x, y and z.
    Rates,
    /// Thrust alone; the vehicle is kept upright.
    Thrust,
}

impl ActionKind {
    /// Numbers of an action.
    #[must_use]
    pub fn numbers(self) -> usize {
        match self {
            Self::Attitude => 3,
            Self::Rates => 4,
            Self::Thrust => 1,
        }
    }

    /// The kind of its commands.
    #[must_use]
    pub fn command(self) -> CommandKind {
        match self {
            Self::Attitude | Self::Thrust => CommandKind::Attitude,
            Self::Rates => CommandKind::Rates,
        }
    }
}

/// From actions to commands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ActionSettings {
    /// What the numbers are.
    pub kind: ActionKind,
    /// Range of the thrust, which is weight (1 + `thrust_range` a).
    pub thrust_range: f64,
    /// Roll and pitch at an action of 1, rad.
    pub tilt_rad: f64,
    /// Rates at an action of 1, rad/s.
    pub rate_radps: f64,
}

impl Default for ActionSettings {
    /// Half of the weight more or less, 0.25 rad, 2 rad/s.
    fn default() -> Self {
        Self {
            kind: ActionKind::default(),
            thrust_range: 0.5,
            tilt_rad: 0.25,
            rate_radps: 2.0,
        }
    }
}

impl ActionSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first range that is not above 0 or too large, what is expected and what was found.
    pub fn validate(&self) -> Result<(), SimError> {
        for (key, value, most) in [
            ("thrust_range", self.thrust_range, 1.0),
            ("tilt_rad", self.tilt_rad, 1.0),
            ("rate_radps", self.rate_radps, 10.0),
        ] {
            let expected = format!("a number above 0, at most {most}");
            check::that(value > 0.0 && value <= most, key, &expected, value)?;
        }
        Ok(())
    }

    /// Writes the command of an action: thrust in N, then attitude or rates. Numbers beyond 1 count as 1.
    ///
    /// # Panics
    /// With fewer numbers than [`ActionKind::numbers`], or less room than [`CommandKind::numbers`].
    pub fn command(&self, weight_n: f64, action: &[f64], out: &mut [f64]) {
        let number = |k: usize| action[k].clamp(-1.0, 1.0);
        out[0] = weight_n * (1.0 + self.thrust_range * number(0));
        match self.kind {
            ActionKind::Thrust => out[1..5].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]),
            // Roll about x, then pitch about the y that stayed.
            ActionKind::Attitude => {
                let half = |k| libm::sincos(0.5 * self.tilt_rad * number(k));
                let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (half(1), half(2));
                out[1..5].copy_from_slice(&[
                    cos_roll * cos_pitch,
                    sin_roll * cos_pitch,
                    cos_roll * sin_pitch,
                    -sin_roll * sin_pitch,
                ]);
            }
            ActionKind::Rates => {
                for (k, rate) in out[1..4].iter_mut().enumerate() {
                    *rate = self.rate_radps * number(k + 1);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(kind: ActionKind, action: &[f64]) -> Vec<f64> {
        let settings = ActionSettings {
            kind,
            ..ActionSettings::default()
        };
        let mut out = vec![f64::NAN; kind.command().numbers()];
        settings.command(10.0, action, &mut out);
        out
    }

    #[test]
    fn analytic_an_action_is_its_command() {
        assert_eq!(
            command(ActionKind::Thrust, &[0.5]),
            [12.5, 1.0, 0.0, 0.0, 0.0]
        );
        // Beyond the range it is the range.
        assert_eq!(
            command(ActionKind::Rates, &[-3.0, 0.5, -1.0, 2.0]),
            [5.0, 1.0, -2.0, 2.0]
        );
        let roll = command(ActionKind::Attitude, &[0.0, 1.0, 0.0]);
        let (sin, cos) = 0.125_f64.sin_cos();
        // Two last bits: both sines are right to one.
        for (found, expected) in roll.iter().zip([10.0, cos, sin, 0.0, 0.0]) {
            assert!((found - expected).abs() < 4e-16, "{roll:?}");
        }
        // The thrust axis of roll a and pitch b: z = cos a cos b in the product of both turns, of unit length.
        let both = command(ActionKind::Attitude, &[0.0, 0.8, -0.6]);
        let [w, x, y, z] = [both[1], both[2], both[3], both[4]];
        let up = w * w - x * x - y * y + z * z;
        assert!((up - 0.2_f64.cos() * 0.15_f64.cos()).abs() < 1e-15, "{up}");
        assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-15);
    }

    #[test]
    fn prop_ranges_are_checked_by_name() {
        for (key, settings) in [
            (
                "thrust_range",
                ActionSettings {
                    thrust_range: f64::NAN,
                    ..ActionSettings::default()
                },
            ),
            (
                "tilt_rad",
                ActionSettings {
                    tilt_rad: 1.1,
                    ..ActionSettings::default()
                },
            ),
            (
                "rate_radps",
                ActionSettings {
                    rate_radps: 0.0,
                    ..ActionSettings::default()
                },
            ),
        ] {
            let error = settings.validate().unwrap_err().to_string();
            assert!(error.contains(key), "{error}");
        }
        ActionSettings::default().validate().unwrap();
    }
}
