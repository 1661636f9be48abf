//! Parameters that somebody asked for: whether the autopilot has them, with these values.
//!
//! Autopilots ignore a parameter that they do not know, and print a line that nobody reads. So the pilot asks for each one
//! before it arms.

use mavlink::dialects::common::{MavMessage, PARAM_REQUEST_READ_DATA, PARAM_VALUE_DATA};

use super::pilot::{AUTOPILOT, SECOND_US, due};
use crate::autopilot::Autopilot;
use crate::parameters::{number, same};
use crate::wire::Encoder;

/// Time for which the autopilot may leave the questions unanswered, µs: both answer within 2 s; twenty times of it is the wait for
/// ArduPilot's GNSS.
const PATIENCE_US: u64 = 10 * SECOND_US;

/// Parameters that the autopilot shall have.
#[derive(Clone, Debug)]
pub(super) struct AskedParameters {
    wanted: Vec<Wanted>,
    since_us: Option<u64>,
    asked_us: Option<u64>,
}

#[derive(Clone, Debug)]
struct Wanted {
    name: String,
    value: f64,
    found: Option<f64>,
}

impl AskedParameters {
    pub(super) fn new(parameters: &[(String, f64)]) -> Self {
        let wanted = parameters.iter().map(|(name, value)| Wanted {
            name: name.clone(),
            value: *value,
            found: None,
        });
        Self {
            wanted: wanted.collect(),
            since_us: None,
            asked_us: None,
        }
    }

    /// Whether the autopilot has reported all of them.
    pub(super) fn known(&self) -> bool {
        self.wanted.iter().all(|wanted| wanted.found.is_some())
    }

    /// Takes the value that the autopilot reports of a parameter.
    pub(super) fn take(&mut self, autopilot: Autopilot, answer: &PARAM_VALUE_DATA) {
        let Ok(name) = answer.param_id.to_str() else {
            return;
        };
        for wanted in self.wanted.iter_mut().filter(|wanted| wanted.name == name) {
            wanted.found = Some(number(autopilot, answer));
        }
    }

    /// Asks for those that are not known yet, once a second.
    pub(super) fn ask(
        &mut self,
        now_us: u64,
        system: u8,
        encoder: &mut Encoder,
        out: &mut Vec<u8>,
    ) {
        if self.known() {
            return;
        }
        self.since_us.get_or_insert(now_us);
        if !due(&mut self.asked_us, now_us, SECOND_US) {
            return;
        }
        for wanted in self.wanted.iter().filter(|wanted| wanted.found.is_none()) {
            let question = PARAM_REQUEST_READ_DATA {
                param_index: -1,
                target_system: system,
                target_component: AUTOPILOT,
                param_id: wanted.name.as_str().into(),
            };
            encoder.write(&MavMessage::PARAM_REQUEST_READ(question), out);
        }
    }

    /// What is wrong with them, once it is known.
    pub(super) fn fault(&self, now_us: u64) -> Option<String> {
        let late = self
            .since_us
            .is_some_and(|since_us| now_us.saturating_sub(since_us) > PATIENCE_US);
        self.wanted.iter().find_map(|wanted| {
            let Wanted { name, value, found } = wanted;
            match found {
                Some(found) if same(*found, *value) => None,
                Some(found) => Some(format!(
                    "parameter {name}: expected {value}, the autopilot has {found}"
                )),
                None if late => Some(format!(
                    "parameter {name}: the autopilot has none of that name"
                )),
                None => None,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::MavParamType;

    fn answer(name: &str, value: f32) -> PARAM_VALUE_DATA {
        PARAM_VALUE_DATA {
            param_value: value,
            param_id: name.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            ..PARAM_VALUE_DATA::default()
        }
    }

    #[test]
    fn prop_a_parameter_that_is_missing_or_other_is_a_fault() {
        let asked = [("A".to_string(), 0.1), ("B".to_string(), 2.0)];
        let mut parameters = AskedParameters::new(&asked);
        let (mut encoder, mut out) = (Encoder::new(255, 190), Vec::new());
        parameters.ask(0, 1, &mut encoder, &mut out);
        assert!(!out.is_empty() && parameters.fault(0).is_none());
        parameters.take(Autopilot::ArduPilot, &answer("A", 0.1));
        assert!(!parameters.known() && parameters.fault(PATIENCE_US).is_none());
        let fault = parameters.fault(PATIENCE_US + 1).unwrap();
        assert_eq!(fault, "parameter B: the autopilot has none of that name");
        parameters.take(Autopilot::ArduPilot, &answer("B", 3.0));
        assert!(parameters.known());
        let fault = parameters.fault(0).unwrap();
        assert_eq!(fault, "parameter B: expected 2, the autopilot has 3");
        parameters.take(Autopilot::ArduPilot, &answer("B", 2.0));
        assert_eq!(parameters.fault(PATIENCE_US + 1), None);
    }

    #[test]
    fn prop_without_parameters_nothing_is_asked() {
        let mut parameters = AskedParameters::new(&[]);
        let (mut encoder, mut out) = (Encoder::new(255, 190), Vec::new());
        parameters.ask(0, 1, &mut encoder, &mut out);
        assert!(out.is_empty() && parameters.known() && parameters.fault(u64::MAX).is_none());
    }
}
