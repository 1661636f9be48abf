//! What is judged before control. Nothing is changed: a parameter that does not fit is for its owner to set.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::autopilot::Autopilot;
use crate::clock::SyncReport;
use crate::readings::Source;
use crate::settings::{FlightSettings, ThrottleSide};
use crate::thrust_curve::ThrustCurve;

/// How an item is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As it should be.
    Good,
    /// Control is possible; the sentence says what to expect.
    Warning,
    /// Not known yet.
    Waiting,
    /// Control is refused.
    Refused,
}

/// An item of the checklist.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Item {
    /// What is judged.
    pub name: &'static str,
    /// The verdict.
    pub verdict: Verdict,
    /// What was found, and what it means.
    pub sentence: String,
}

/// The checklist.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checklist {
    /// The items.
    pub items: Vec<Item>,
}

/// What the checklist judges.
pub(crate) struct Facts<'a> {
    pub(crate) settings: &'a FlightSettings,
    pub(crate) autopilot: Autopilot,
    pub(crate) parameters: &'a BTreeMap<&'static str, f64>,
    pub(crate) rates_hz: Option<[f64; 5]>,
    pub(crate) sync: Option<SyncReport>,
    pub(crate) battery: Option<f64>,
    /// Throttle of the thrust card at the weight.
    pub(crate) hover_throttle: f64,
}

impl Checklist {
    /// The worst verdict; [`Verdict::Waiting`] for an empty list.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let worst = self.items.iter().map(|item| item.verdict).max();
        worst.unwrap_or(Verdict::Waiting)
    }

    /// A line for each item.
    #[must_use]
    pub fn text(&self) -> String {
        let lines = self.items.iter().map(|item| {
            let mark = match item.verdict {
                Verdict::Good => "ok     ",
                Verdict::Warning => "warning",
                Verdict::Waiting => "waiting",
                Verdict::Refused => "REFUSED",
            };
            format!("{mark}  {}: {}", item.name, item.sentence)
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    pub(crate) fn of(facts: &Facts<'_>) -> Self {
        let mut items = vec![Item {
            name: "autopilot",
            verdict: Verdict::Good,
            sentence: format!(
                "{}; it follows the companion in {}.",
                facts.autopilot.name(),
                facts.autopilot.follows_in()
            ),
        }];
        let judge = |name: &&'static str| facts.parameter(name);
        items.extend(facts.autopilot.parameters().iter().map(judge));
        items.extend((0..Source::ALL.len()).map(|k| facts.rate(k)));
        items.push(facts.time());
        items.push(facts.battery());
        Self { items }
    }
}

/// The thrust curve of the parameters, once they are known.
pub(crate) fn thrust_curve(
    autopilot: Autopilot,
    parameters: &BTreeMap<&'static str, f64>,
) -> Option<ThrustCurve> {
    let of = |name| parameters.get(name).copied();
    match autopilot {
        Autopilot::Px4 => Some(ThrustCurve::px4(of("THR_MDL_FAC")?)),
        Autopilot::ArduPilot => Some(ThrustCurve::ardupilot(
            of("MOT_THST_EXPO")?,
            of("MOT_SPIN_MIN")?,
            of("MOT_SPIN_MAX")?,
        )),
    }
}

/// The thrust setpoint of a throttle of the thrust card.
pub(crate) fn thrust_setpoint(side: ThrottleSide, curve: ThrustCurve, throttle: f64) -> f64 {
    match side {
        ThrottleSide::MotorSignal => curve.setpoint(throttle),
        ThrottleSide::ThrustSetpoint => throttle.clamp(0.0, 1.0),
    }
}

impl Facts<'_> {
    fn parameter(&self, name: &'static str) -> Item {
        let Some(&value) = self.parameters.get(name) else {
            return Item {
                name,
                verdict: Verdict::Waiting,
                sentence: "asked for, not answered yet.".to_string(),
            };
        };
        let (verdict, meaning) = match name {
            "THR_MDL_FAC" | "MOT_THST_EXPO" => self.curvature(value),
            "MPC_THR_HOVER" | "MOT_THST_HOVER" => self.hover(value),
            "COM_OF_LOSS_T" | "GUID_TIMEOUT" => self.failsafe_time(value),
            "COM_OBL_RC_ACT" => failsafe_mode(value),
            "GUID_OPTIONS" => guided_options(value),
            "EKF2_RNG_CTRL" => range_in_filter(value),
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
            "MOT_SPIN_MIN" | "MOT_SPIN_MAX" if (0.0..=1.0).contains(&value) => {
                (Verdict::Good, "part of the thrust curve.".to_string())
            }
            _ => (Verdict::Refused, "this value makes no sense.".to_string()),
        };
        Item {
            name,
            verdict,
            sentence: format!("{}; {meaning}", rounded(value)),
        }
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

    fn hover(&self, value: f64) -> (Verdict, String) {
        let Some(curve) = thrust_curve(self.autopilot, self.parameters) else {
            return (Verdict::Waiting, "waits for the thrust curve.".to_string());
        };
        let side = self.settings.vehicle.throttle;
        let card = thrust_setpoint(side, curve, self.hover_throttle);
        let limit = self.settings.limits.hover_thrust;
        let off = (card - value).abs();
        let verdict = if off <= 0.5 * limit {
            Verdict::Good
        } else if off <= limit {
            Verdict::Warning
        } else {
            Verdict::Refused
        };
        let sentence = format!(
            "the thrust card and `vehicle.mass_kg` hover at {card:.3}; at most {limit} apart is accepted."
        );
        (verdict, sentence)
    }

    fn failsafe_time(&self, value: f64) -> (Verdict, String) {
        let limit = self.settings.limits.failsafe_s;
        if value > 0.0 && value <= 0.5 * limit {
            (
                Verdict::Good,
                "s after the last setpoint the autopilot acts by itself.".to_string(),
            )
        } else if value > 0.0 && value <= limit {
            let advice = "s without setpoints are long above a moving deck; half of it is better.";
            (Verdict::Warning, advice.to_string())
        } else {
            let sentence = format!("expected at most {limit} s (`limits.failsafe_s`).");
            (Verdict::Refused, sentence)
        }
    }

    fn rate(&self, k: usize) -> Item {
        let rates = &self.settings.rates;
        let asked = [
            rates.attitude_hz,
            rates.imu_hz,
            rates.range_hz,
            rates.velocity_hz,
            rates.target_hz,
        ][k];
        let name = Source::ALL[k].message();
        let (verdict, sentence) = match self.rates_hz.map(|rates| rates[k]) {
            None => (Verdict::Waiting, "counting.".to_string()),
            Some(hz) => {
                let least = rates.least_share * asked;
                let verdict = if hz >= least {
                    Verdict::Good
                } else {
                    Verdict::Refused
                };
                let sentence = format!(
                    "{hz:.0} Hz usable of {asked:.0} Hz; at least {least:.0} Hz are needed."
                );
                (verdict, sentence)
            }
        };
        Item {
            name,
            verdict,
            sentence,
        }
    }

    fn time(&self) -> Item {
        let (verdict, sentence) = match self.sync {
            Some(sync) if sync.answers >= 5 => {
                let limit = self.settings.limits.round_trip_s;
                let verdict = if sync.round_trip_s <= limit {
                    Verdict::Good
                } else {
                    Verdict::Refused
                };
                let sentence = format!(
                    "round trip {:.2} ms (at most {:.0} ms), offset {:.4} s.",
                    sync.round_trip_s * 1e3,
                    limit * 1e3,
                    sync.offset_s
                );
                (verdict, sentence)
            }
            _ => (
                Verdict::Waiting,
                "waits for five answers to TIMESYNC.".to_string(),
            ),
        };
        Item {
            name: "time",
            verdict,
            sentence,
        }
    }

    fn battery(&self) -> Item {
        let (verdict, sentence) = match self.battery {
            Some(share) => (Verdict::Good, format!("{:.0} % remain.", share * 100.0)),
            None => (
                Verdict::Warning,
                "the autopilot does not say what remains; the companion will not abort for it."
                    .to_string(),
            ),
        };
        Item {
            name: "battery",
            verdict,
            sentence,
        }
    }
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
    if value == 0.0 {
        return (
            Verdict::Good,
            "without setpoints PX4 goes to Position mode, which holds.".to_string(),
        );
    }
    (
        Verdict::Refused,
        "if this process ends, PX4 must hold: set 5 (Hold) or 0 (Position).".to_string(),
    )
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

#[cfg(test)]
mod tests {
    use super::*;

    fn px4() -> BTreeMap<&'static str, f64> {
        [
            ("THR_MDL_FAC", 0.0),
            ("MPC_THR_HOVER", 0.5),
            ("COM_OF_LOSS_T", 0.5),
            ("COM_OBL_RC_ACT", 5.0),
            ("EKF2_RNG_CTRL", 0.0),
            ("MPC_LAND_SPEED", 0.7),
            ("LNDMC_Z_VEL_MAX", 0.25),
        ]
        .into()
    }

    fn ardupilot() -> BTreeMap<&'static str, f64> {
        [
            ("GUID_OPTIONS", 8.0),
            ("GUID_TIMEOUT", 0.5),
            ("MOT_THST_EXPO", 0.65),
            ("MOT_THST_HOVER", 0.35),
            ("MOT_SPIN_MIN", 0.15),
            ("MOT_SPIN_MAX", 0.95),
            ("PLND_ENABLED", 0.0),
        ]
        .into()
    }

    fn list(autopilot: Autopilot, parameters: &BTreeMap<&'static str, f64>) -> Checklist {
        Checklist::of(&Facts {
            settings: &FlightSettings::default(),
            autopilot,
            parameters,
            rates_hz: Some([100.0, 100.0, 50.0, 30.0, 20.0]),
            sync: Some(SyncReport {
                answers: 5,
                round_trip_s: 0.001,
                offset_s: 1.0,
                steps: 0,
            }),
            battery: Some(0.8),
            hover_throttle: 0.5,
        })
    }

    #[test]
    fn prop_each_parameter_decides_as_the_table_says() {
        assert_eq!(list(Autopilot::Px4, &px4()).verdict(), Verdict::Good);
        assert_eq!(
            list(Autopilot::ArduPilot, &ardupilot()).verdict(),
            Verdict::Good
        );
        for (autopilot, name, value, verdict) in [
            (Autopilot::Px4, "COM_OBL_RC_ACT", 0.0, Verdict::Good),
            (Autopilot::Px4, "COM_OBL_RC_ACT", 1.0, Verdict::Refused),
            (Autopilot::Px4, "COM_OBL_RC_ACT", 3.0, Verdict::Refused),
            (Autopilot::Px4, "COM_OBL_RC_ACT", 4.0, Verdict::Refused),
            (Autopilot::Px4, "COM_OBL_RC_ACT", f64::NAN, Verdict::Refused),
            (Autopilot::Px4, "COM_OF_LOSS_T", 1.0, Verdict::Warning),
            (Autopilot::Px4, "COM_OF_LOSS_T", 1.5, Verdict::Refused),
            (Autopilot::Px4, "COM_OF_LOSS_T", 0.0, Verdict::Refused),
            (Autopilot::Px4, "EKF2_RNG_CTRL", 1.0, Verdict::Warning),
            (Autopilot::Px4, "MPC_THR_HOVER", 0.4, Verdict::Warning),
            (Autopilot::Px4, "MPC_THR_HOVER", 0.2, Verdict::Refused),
            (Autopilot::Px4, "THR_MDL_FAC", 1.2, Verdict::Refused),
            (Autopilot::ArduPilot, "GUID_OPTIONS", 0.0, Verdict::Refused),
            (Autopilot::ArduPilot, "GUID_OPTIONS", 24.0, Verdict::Good),
            (Autopilot::ArduPilot, "GUID_TIMEOUT", 3.0, Verdict::Refused),
            (Autopilot::ArduPilot, "MOT_SPIN_MIN", -1.0, Verdict::Refused),
        ] {
            let mut parameters = match autopilot {
                Autopilot::Px4 => px4(),
                Autopilot::ArduPilot => ardupilot(),
            };
            parameters.insert(name, value);
            let list = list(autopilot, &parameters);
            let item = list.items.iter().find(|item| item.name == name).unwrap();
            assert_eq!(item.verdict, verdict, "{name} = {value}: {}", item.sentence);
        }
    }

    #[test]
    fn prop_what_is_missing_is_waited_for() {
        let mut parameters = px4();
        parameters.remove("COM_OBL_RC_ACT");
        let list = list(Autopilot::Px4, &parameters);
        assert_eq!(list.verdict(), Verdict::Waiting);
        assert!(list.text().contains("waiting  COM_OBL_RC_ACT"));
    }
}
