//! Parameters of the autopilot: read, and changed and written back where the operator allows it.

use std::collections::BTreeMap;

use mavlink::dialects::common::{MavParamType, PARAM_VALUE_DATA};
use serde::Serialize;

use crate::autopilot::Autopilot;

/// Requests, one a second, after which it is said that the autopilot has not confirmed the change.
const UNANSWERED: u32 = 3;

/// Values of parameters as the autopilot last reported them, and the companion's changes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parameters {
    known: BTreeMap<&'static str, (f64, MavParamType)>,
    changes: Vec<Change>,
}

/// A parameter that the companion has changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Its name.
    pub name: &'static str,
    /// Its value before.
    pub before: f64,
    /// The value that the companion asked for.
    pub after: f64,
    /// Whether the autopilot has reported the value that was asked for.
    pub confirmed: bool,
    /// Whether the value before was written back and confirmed.
    pub restored: bool,
    /// How often the value was asked for.
    #[serde(skip)]
    asked: u32,
    #[serde(skip)]
    kind: MavParamType,
}

impl Parameters {
    /// The value, once it is known.
    pub(crate) fn get(&self, name: &str) -> Option<f64> {
        self.known.get(name).map(|(value, _)| *value)
    }

    /// Forgets all values, as after a restart of the autopilot. Changes are still to be written back.
    pub(crate) fn forget(&mut self) {
        self.known.clear();
    }

    /// Takes an answer; whether it is the value of a parameter that is asked for.
    pub(crate) fn take(&mut self, autopilot: Autopilot, answer: &PARAM_VALUE_DATA) -> bool {
        let Ok(id) = answer.param_id.to_str() else {
            return false;
        };
        let Some(name) = autopilot.parameters().iter().find(|name| **name == id) else {
            return false;
        };
        let number = number(autopilot, answer);
        self.known.insert(name, (number, answer.param_type));
        for change in self
            .changes
            .iter_mut()
            .filter(|change| change.name == *name)
        {
            change.restored = same(number, change.before);
            change.confirmed |= same(number, change.after);
        }
        true
    }

    /// Notes a change that is about to be asked for; whether it is new.
    pub(crate) fn change(&mut self, name: &'static str, after: f64) -> Option<Change> {
        let &(before, kind) = self.known.get(name)?;
        if self.changes.iter().any(|change| change.name == name) {
            return None;
        }
        let change = Change {
            name,
            before,
            after,
            confirmed: false,
            restored: false,
            asked: 0,
            kind,
        };
        self.changes.push(change.clone());
        Some(change)
    }

    /// The change of a parameter, which is about to be asked for once more; and whether it is time to say that it is not confirmed.
    pub(crate) fn asks(&mut self, name: &str) -> Option<(Change, bool)> {
        let change = self.changes.iter_mut().find(|c| c.name == name)?;
        change.asked += 1;
        let unanswered = !change.confirmed && change.asked == UNANSWERED;
        Some((change.clone(), unanswered))
    }

    /// The changes.
    pub(crate) fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// The changes that are still to be written back.
    pub(crate) fn unrestored(&self) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(|change| !change.restored)
    }
}

impl Change {
    /// The value before and its type, as the autopilot expects them in `PARAM_SET`.
    pub(crate) fn back(&self, autopilot: Autopilot) -> (f32, MavParamType) {
        (on_the_wire(autopilot, self.before, self.kind), self.kind)
    }

    /// The value asked for and its type, as the autopilot expects them in `PARAM_SET`.
    pub(crate) fn forth(&self, autopilot: Autopilot) -> (f32, MavParamType) {
        (on_the_wire(autopilot, self.after, self.kind), self.kind)
    }
}

/// The value in an answer: PX4 sends the bytes of an integer in the place of the float, ArduPilot its value.
pub(crate) fn number(autopilot: Autopilot, answer: &PARAM_VALUE_DATA) -> f64 {
    match (autopilot, answer.param_type) {
        (Autopilot::Px4, MavParamType::MAV_PARAM_TYPE_INT32) => {
            f64::from(answer.param_value.to_bits().cast_signed())
        }
        _ => f64::from(answer.param_value),
    }
}

/// Whether two values are equal as the wire has them.
pub(crate) fn same(a: f64, b: f64) -> bool {
    (a as f32) == (b as f32)
}

fn on_the_wire(autopilot: Autopilot, value: f64, kind: MavParamType) -> f32 {
    match (autopilot, kind) {
        (Autopilot::Px4, MavParamType::MAV_PARAM_TYPE_INT32) => {
            f32::from_bits((value as i32).cast_unsigned())
        }
        _ => value as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(name: &str, value: f32, kind: MavParamType) -> PARAM_VALUE_DATA {
        PARAM_VALUE_DATA {
            param_value: value,
            param_id: name.into(),
            param_type: kind,
            ..PARAM_VALUE_DATA::default()
        }
    }

    #[test]
    fn prop_integers_of_px4_are_bytes_and_those_of_ardupilot_numbers() {
        let integer = MavParamType::MAV_PARAM_TYPE_INT32;
        let mut parameters = Parameters::default();
        assert!(parameters.take(
            Autopilot::Px4,
            &answer("COM_OBL_RC_ACT", f32::from_bits(3), integer)
        ));
        assert_eq!(parameters.get("COM_OBL_RC_ACT"), Some(3.0));
        assert!(!parameters.take(Autopilot::Px4, &answer("SYS_AUTOSTART", 1.0, integer)));
        let change = parameters.change("COM_OBL_RC_ACT", 5.0).unwrap();
        assert_eq!(change.forth(Autopilot::Px4).0.to_bits(), 5);
        assert_eq!(change.back(Autopilot::Px4).0.to_bits(), 3);
        let mut parameters = Parameters::default();
        parameters.take(Autopilot::ArduPilot, &answer("GUID_OPTIONS", 2.0, integer));
        let change = parameters.change("GUID_OPTIONS", 10.0).unwrap();
        assert_eq!(change.forth(Autopilot::ArduPilot), (10.0, integer));
    }

    #[test]
    fn prop_a_change_counts_once_and_is_restored_by_its_first_value() {
        let real = MavParamType::MAV_PARAM_TYPE_REAL32;
        let mut parameters = Parameters::default();
        let take = |parameters: &mut Parameters, value| {
            parameters.take(Autopilot::Px4, &answer("COM_OF_LOSS_T", value, real));
        };
        assert!(parameters.change("COM_OF_LOSS_T", 0.5).is_none(), "unknown");
        take(&mut parameters, 1.1);
        assert!(parameters.change("COM_OF_LOSS_T", 0.5).is_some());
        take(&mut parameters, 0.5);
        assert!(parameters.change("COM_OF_LOSS_T", 0.4).is_none(), "once");
        assert_eq!(parameters.unrestored().count(), 1);
        take(&mut parameters, 1.1);
        assert_eq!(parameters.unrestored().count(), 0);
        assert_eq!(parameters.changes().len(), 1);
    }
}
