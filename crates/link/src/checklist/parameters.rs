//! Parameters: what each value means, and which value would be right.

use super::{Facts, Item, Verdict, item};
use crate::autopilot::Autopilot;
use crate::parameters::Parameters;
use crate::settings::{LimitSettings, ThrottleSide};
use crate::thrust_curve::ThrustCurve;

/// The way from a throttle of the thrust card to the autopilot's thrust setpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thrust {
    side: ThrottleSide,
    curve: ThrustCurve,
    /// Whether the autopilot divides the thrust by the cosine of the tilt.
    boosted: bool,
}

/// Smallest cosine of the tilt by which ArduPilot divides.
const LEAST_COSINE: f64 = 0.1;

impl Thrust {
    /// The way by these parameters, once they are known.
    pub(crate) fn of(
        autopilot: Autopilot,
        side: ThrottleSide,
        parameters: &Parameters,
    ) -> Option<Self> {
        let of = |name| parameters.get(name);
        let (curve, boosted) = match autopilot {
            Autopilot::Px4 => (ThrustCurve::px4(of("THR_MDL_FAC")?), false),
            Autopilot::ArduPilot => {
                let expo = of("MOT_THST_EXPO")?;
                let curve = ThrustCurve::ardupilot(expo, of("MOT_SPIN_MIN")?, of("MOT_SPIN_MAX")?);
                (curve, of("ATC_ANGLE_BOOST")? != 0.0)
            }
        };
        Some(Self {
            side,
            curve,
            boosted,
        })
    }

    /// The thrust setpoint of a throttle, at this cosine of the commanded tilt.
    pub(crate) fn setpoint(self, throttle: f64, cosine: f64) -> f64 {
        let level = match self.side {
            ThrottleSide::MotorSignal => self.curve.setpoint(throttle),
            ThrottleSide::ThrustSetpoint => throttle.clamp(0.0, 1.0),
        };
        if self.boosted {
            level * cosine.clamp(LEAST_COSINE, 1.0)
        } else {
            level
        }
    }
}

impl Facts<'_> {
    pub(super) fn thrust(&self) -> Option<Thrust> {
        Thrust::of(
            self.autopilot,
            self.settings.vehicle.throttle,
            self.parameters,
        )
    }

    pub(super) fn parameter(&self, name: &'static str) -> Item {
        let Some(value) = self.parameters.get(name) else {
            return item(
                name,
                (Verdict::Waiting, "asked for, not answered yet.".to_string()),
            );
        };
        let (verdict, meaning) = match name {
            "THR_MDL_FAC" | "MOT_THST_EXPO" => self.curvature(value),
            "MPC_THR_HOVER" | "MOT_THST_HOVER" => self.hover(value),
            "COM_OF_LOSS_T" | "GUID_TIMEOUT" => self.failsafe_time(value),
            "MOT_SPIN_MIN" | "MOT_SPIN_MAX" => self.spin(value),
            "COM_OBL_RC_ACT" => failsafe_mode(value),
            "GUID_OPTIONS" => guided_options(value),
            "EKF2_RNG_CTRL" => range_in_filter(value),
            "ATC_ANGLE_BOOST" => angle_boost(value),
            "MC_BAT_SCALE_EN" | "MOT_BAT_VOLT_MAX" => battery_scale(value),
            "LNDMC_Z_VEL_MAX" => (
                Verdict::Good,
                "on a faster deck PX4 never reports that it landed; the companion sends the disarm.".to_string(),
            ),
            "MPC_LAND_SPEED" => (
                Verdict::Good,
                "the speed of PX4's own landing (m/s), which the companion does not use.".to_string(),
            ),
            "PLND_ENABLED" => (
                Verdict::Good,
                "ArduPilot's own precision landing acts in LAND only, not in GUIDED.".to_string(),
            ),
            _ => (Verdict::Refused, "this value makes no sense.".to_string()),
        };
        item(name, (verdict, format!("{}; {meaning}", rounded(value))))
    }

    fn curvature(&self, value: f64) -> (Verdict, String) {
        if !(0.0..=1.0).contains(&value) {
            return (Verdict::Refused, "expected 0 to 1.".to_string());
        }
        let side = match self.settings.vehicle.throttle {
            ThrottleSide::MotorSignal => {
                "the card maps the motors' signal, so setpoints go through this curve."
            }
            ThrottleSide::ThrustSetpoint => {
                "the card maps thrust setpoints, so they are sent without this curve."
            }
        };
        (Verdict::Good, side.to_string())
    }

    fn spin(&self, value: f64) -> (Verdict, String) {
        let of = |name| self.parameters.get(name).unwrap_or(f64::NAN);
        let ordered = of("MOT_SPIN_MIN") < of("MOT_SPIN_MAX");
        if ordered && (0.0..=1.0).contains(&value) {
            (Verdict::Good, "part of the thrust curve.".to_string())
        } else {
            let expected = "expected 0 to 1, and MOT_SPIN_MIN below MOT_SPIN_MAX.";
            (Verdict::Refused, expected.to_string())
        }
    }

    fn hover(&self, value: f64) -> (Verdict, String) {
        let Some(thrust) = self.thrust() else {
            return (Verdict::Waiting, "waits for the thrust curve.".to_string());
        };
        let card = thrust.setpoint(self.hover_throttle, 1.0);
        let sentence = format!(
            "the thrust card and `vehicle.mass_kg` hover at {card:.3}; at most {} apart is accepted.",
            self.settings.limits.hover_thrust
        );
        (self.apart(card, value), sentence)
    }

    fn failsafe_time(&self, value: f64) -> (Verdict, String) {
        let limit = self.settings.limits.failsafe_s;
        if value > 0.0 && value <= 0.5 * limit {
            (
                Verdict::Good,
                "so many seconds after the last setpoint the autopilot acts by itself.".to_string(),
            )
        } else if value > 0.0 && value <= limit {
            let advice = "this time (s) is long: from 0.35 m a descent reached the deck within 0.5 s. 0.2 s is better.";
            (Verdict::Warning, advice.to_string())
        } else {
            let sentence = format!("expected above 0 s, at most {limit} s (`limits.failsafe_s`).");
            (Verdict::Refused, sentence)
        }
    }
}

/// Share of `limits.failsafe_s` that `--set-parameters` sets: 0.2 s of 0.5 s, twenty missing setpoints. A descent at 0.5 m/s that is
/// cut off goes on for 0.1 m then, above the deck from 0.35 m; twice of it hit the deck. Half of it trips where a link pauses.
const FAILSAFE_SHARE: f64 = 0.4;

/// The value that `--set-parameters` gives a parameter that does not fit; none where it fits, or where only its owner can
/// know what is right.
pub(crate) fn wanted(name: &str, value: f64, limits: &LimitSettings) -> Option<f64> {
    let half_s = 0.5 * limits.failsafe_s;
    let right = match name {
        "COM_OBL_RC_ACT" if value != 5.0 => 5.0,
        "EKF2_RNG_CTRL" if value != 0.0 => 0.0,
        "COM_OF_LOSS_T" | "GUID_TIMEOUT" if !(value > 0.0 && value <= half_s) => {
            FAILSAFE_SHARE * limits.failsafe_s
        }
        "GUID_OPTIONS" if value >= 0.0 && (value as u32) & 8 == 0 => f64::from((value as u32) | 8),
        _ => return None,
    };
    Some(right)
}

/// Up to four decimals, without trailing zeros.
fn rounded(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_string()
}

fn failsafe_mode(value: f64) -> (Verdict, String) {
    if value == 5.0 {
        return (
            Verdict::Good,
            "without setpoints PX4 holds its position (Hold).".to_string(),
        );
    }
    let sentence = if value == 0.0 {
        "if this process ends, PX4 must hold. By 0 it goes to Position mode, and without a remote control it acts by NAV_RCL_ACT: set 5 (Hold)."
    } else {
        "if this process ends, PX4 must hold: set 5 (Hold)."
    };
    (Verdict::Refused, sentence.to_string())
}

fn guided_options(value: f64) -> (Verdict, String) {
    if value >= 0.0 && (value as u32) & 8 != 0 {
        return (Verdict::Good, "bit 3 is set: thrust is thrust.".to_string());
    }
    (
        Verdict::Refused,
        "without bit 3 (value 8) ArduPilot reads thrust as a climb rate: set it.".to_string(),
    )
}

fn angle_boost(value: f64) -> (Verdict, String) {
    let sentence = if value == 0.0 {
        "the thrust setpoint does not depend on the tilt."
    } else if value == 1.0 {
        "ArduPilot divides the thrust by the cosine of the tilt, so setpoints are multiplied by it."
    } else {
        return (Verdict::Refused, "expected 0 or 1.".to_string());
    };
    (Verdict::Good, sentence.to_string())
}

fn battery_scale(value: f64) -> (Verdict, String) {
    if value <= 0.0 {
        return (
            Verdict::Good,
            "thrust setpoints do not depend on the battery's voltage.".to_string(),
        );
    }
    (
        Verdict::Warning,
        "the autopilot scales thrust by the battery's voltage: the thrust card must come from the same setting.".to_string(),
    )
}

fn range_in_filter(value: f64) -> (Verdict, String) {
    if value == 0.0 {
        return (
            Verdict::Good,
            "PX4's filter does not take the deck for the ground.".to_string(),
        );
    }
    (
        Verdict::Warning,
        "PX4's filter takes the deck for the ground, which disturbs its velocity: 0 is better above a moving deck.".to_string(),
    )
}
