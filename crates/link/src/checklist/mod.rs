//! The checklist before control.

mod camera;
mod parameters;
#[cfg(test)]
mod tests;

use serde::Serialize;

pub(crate) use parameters::{Thrust, wanted};

use crate::autopilot::{Autopilot, Firmware};
use crate::camera::CameraWatch;
use crate::clock::SyncReport;
use crate::parameters::Parameters;
use crate::readings::Source;
use crate::settings::FlightSettings;

/// Drift of the autopilot's clock beyond which a warning stands, in parts per million. Quartz is wrong by less than 100. In
/// the second over which answers are compared, 1000 make times of readings wrong by 1 ms; twice of it is a fifth of a period.
const DRIFT_PPM: f64 = 1000.0;

/// How an item is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As it should be.
    Good,
    /// Control is possible, with the consequence that the sentence names.
    Warning,
    /// Not known yet.
    Waiting,
    /// Control is refused.
    Refused,
}

/// An item of the checklist.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Item {
    /// Name of the parameter, sensor or quantity.
    pub name: &'static str,
    /// The verdict.
    pub verdict: Verdict,
    /// The value found, and its consequence.
    pub sentence: String,
}

impl Item {
    /// Verdict, name and sentence.
    fn line(&self) -> String {
        let mark = match self.verdict {
            Verdict::Good => "ok     ",
            Verdict::Warning => "warning",
            Verdict::Waiting => "waiting",
            Verdict::Refused => "REFUSED",
        };
        format!("{mark}  {}: {}", self.name, self.sentence)
    }
}

/// The checklist.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checklist {
    /// The items.
    pub items: Vec<Item>,
}

/// Inputs of the checklist.
pub(crate) struct Facts<'a> {
    pub(crate) settings: &'a FlightSettings,
    pub(crate) autopilot: Autopilot,
    pub(crate) firmware: Option<Firmware>,
    pub(crate) parameters: &'a Parameters,
    pub(crate) rates_hz: Option<[f64; 5]>,
    pub(crate) sync: Option<SyncReport>,
    pub(crate) battery: Option<f64>,
    /// Throttle of the thrust card at the weight.
    pub(crate) hover_throttle: f64,
    /// The autopilot's thrust setpoint for the weight, found in hover.
    pub(crate) hover_found: Option<f64>,
    /// Whether the autopilot reports which setpoints it follows.
    pub(crate) echoes: bool,
    /// Whether the vehicle flies by itself or by its pilot, so that its hover can be measured.
    pub(crate) flies: bool,
    /// The companion's own camera.
    pub(crate) camera: Option<&'a CameraWatch>,
}

impl Checklist {
    /// A list with an item, for schemas.
    pub(crate) fn example() -> Self {
        let item = Item {
            name: "",
            verdict: Verdict::Good,
            sentence: String::new(),
        };
        Self { items: vec![item] }
    }

    /// The worst verdict; [`Verdict::Waiting`] for an empty list.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let worst = self.items.iter().map(|item| item.verdict).max();
        worst.unwrap_or(Verdict::Waiting)
    }

    /// A line for each item whose verdict is not that of `before`: for each, if `before` is of another list.
    #[must_use]
    pub fn changes(&self, before: &[Verdict]) -> String {
        let comparable = before.len() == self.items.len();
        let changed = |k: usize, item: &Item| !comparable || before[k] != item.verdict;
        let lines = self.items.iter().enumerate();
        let lines = lines.filter(|(k, item)| changed(*k, item));
        let lines: Vec<_> = lines.map(|(_, item)| item.line()).collect();
        lines.join("\n")
    }

    pub(crate) fn of(facts: &Facts<'_>) -> Self {
        let mut items = vec![facts.firmware()];
        let judge = |name: &&'static str| facts.parameter(name);
        items.extend(facts.autopilot.parameters().iter().map(judge));
        items.extend((0..Source::ALL.len()).map(|k| facts.rate(k)));
        items.extend(facts.camera());
        items.push(facts.time());
        items.push(facts.weight());
        items.push(facts.echo());
        items.push(facts.battery());
        Self { items }
    }
}

fn item(name: &'static str, (verdict, sentence): (Verdict, String)) -> Item {
    Item {
        name,
        verdict,
        sentence,
    }
}

impl Facts<'_> {
    fn firmware(&self) -> Item {
        let name = self.autopilot.name();
        let mode = self.autopilot.follows_in();
        let judged = match self.firmware {
            Some(firmware) if firmware >= self.autopilot.oldest() => (
                Verdict::Good,
                format!("{name} {firmware}; it follows the companion in {mode}."),
            ),
            Some(firmware) => (
                Verdict::Warning,
                format!(
                    "{name} {firmware} is older than {}, the oldest version whose behaviour was compared with this program.",
                    self.autopilot.oldest()
                ),
            ),
            None => (
                Verdict::Warning,
                format!("{name} of an unknown version: it has not answered the request for it."),
            ),
        };
        item("autopilot", judged)
    }

    fn rate(&self, k: usize) -> Item {
        let rates = &self.settings.rates;
        // Positions of the deck by the companion's own camera come with its frames.
        let target_hz = match self.camera {
            Some(_) => self.settings.camera.rate_hz,
            None => rates.target_hz,
        };
        let asked = [
            rates.attitude_hz,
            rates.imu_hz,
            rates.range_hz,
            rates.velocity_hz,
            target_hz,
        ][k];
        let judged = match self.rates_hz.map(|rates| rates[k]) {
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
        item(Source::ALL[k].message(), judged)
    }

    fn time(&self) -> Item {
        let judged = match self.sync {
            Some(sync) if sync.answers >= 5 => {
                let limit = self.settings.limits.round_trip_s;
                let drifts = sync.drift_ppm.abs() - sync.drift_error_ppm > DRIFT_PPM;
                let (verdict, consequence) = if sync.round_trip_s > limit {
                    (Verdict::Refused, "")
                } else if drifts {
                    let why = ": no clock of a flight controller is that wrong, a simulator that cannot keep real time is; \
                               times of readings are wrong by a thousandth of a second or more";
                    (Verdict::Warning, why)
                } else {
                    (Verdict::Good, "")
                };
                let sentence = format!(
                    "round trip {:.2} ms (at most {:.0} ms), offset {:.4} s, drift {:.0} ppm{consequence}.",
                    sync.round_trip_s * 1e3,
                    limit * 1e3,
                    sync.offset_s,
                    sync.drift_ppm
                );
                (verdict, sentence)
            }
            _ => (
                Verdict::Waiting,
                "waits for five answers to TIMESYNC.".to_string(),
            ),
        };
        item("time", judged)
    }

    /// The weight as the vehicle carries it in hover, against mass and thrust card.
    fn weight(&self) -> Item {
        let judged = match (self.hover_found, self.thrust()) {
            (Some(found), Some(thrust)) => {
                let card = thrust.setpoint(self.hover_throttle, 1.0);
                let verdict = self.apart(card, found);
                let sentence = format!(
                    "the autopilot hovers at {found:.3}, the thrust card and `vehicle.mass_kg` at {card:.3}; at most {} apart is accepted.",
                    self.settings.limits.hover_thrust
                );
                (verdict, sentence)
            }
            // Control before the measurement would take a wrong mass or card for granted.
            (None, Some(_)) if self.echoes && self.flies => (
                Verdict::Waiting,
                "is being measured: let the vehicle hover for three seconds.".to_string(),
            ),
            _ => (
                Verdict::Warning,
                "not measured: let the vehicle hover for three seconds, with ATTITUDE_TARGET on the link.".to_string(),
            ),
        };
        item("weight", judged)
    }

    /// The verdict on two hover thrusts.
    fn apart(&self, a: f64, b: f64) -> Verdict {
        let limit = self.settings.limits.hover_thrust;
        let apart = (a - b).abs();
        if apart <= 0.5 * limit {
            Verdict::Good
        } else if apart <= limit {
            Verdict::Warning
        } else {
            Verdict::Refused
        }
    }

    fn echo(&self) -> Item {
        let judged = if self.echoes {
            (
                Verdict::Good,
                "the autopilot reports which setpoints it follows.".to_string(),
            )
        } else {
            (
                Verdict::Warning,
                "the autopilot does not report which setpoints it follows; rejected ones will not be noticed.".to_string(),
            )
        };
        item("ATTITUDE_TARGET", judged)
    }

    fn battery(&self) -> Item {
        let judged = match self.battery {
            Some(share) => (Verdict::Good, format!("{:.0} % remain.", share * 100.0)),
            None => (
                Verdict::Warning,
                "the autopilot does not report the remaining energy; the companion will not abort for it."
                    .to_string(),
            ),
        };
        item("battery", judged)
    }
}
