//! Parameters: asked for, changed where the operator allows it, and written back.

use super::{Companion, Stage, due, messages};
use crate::checklist::wanted;

/// Time between two requests to write a parameter back, µs.
const AGAIN_US: i64 = 200_000;
/// Longest time for writing back, µs.
const RESTORE_US: i64 = 5_000_000;

impl Companion {
    /// Asks for parameters that are not known, and changes those that do not fit if that is allowed.
    pub(super) fn ask_for_parameters(&mut self, out: &mut Vec<u8>) {
        let Some(vehicle) = self.vehicle else { return };
        for name in vehicle.autopilot.parameters() {
            let Some(value) = self.parameters.get(name) else {
                self.send(&messages::parameter(vehicle.system, name), out);
                continue;
            };
            let Some(right) = wanted(name, value, &self.settings.limits) else {
                continue;
            };
            if !self.session.set_parameters {
                continue;
            }
            if let Some(change) = self.parameters.change(name, right) {
                self.notes.push(format!(
                    "parameter {name}: {} becomes {}, until the end of this command",
                    change.before as f32, change.after as f32
                ));
            }
            if let Some((change, unanswered)) = self.parameters.asks(name) {
                if unanswered {
                    self.notes.push(format!(
                        "parameter {name}: the autopilot has not confirmed the change; it is asked for once a second"
                    ));
                }
                let (value, kind) = change.forth(vehicle.autopilot);
                let message = messages::set_parameter(vehicle.system, name, value, kind);
                self.send(&message, out);
            }
        }
    }

    /// Writes changed parameters back, once the vehicle does not follow the companion any more.
    pub(super) fn restore(&mut self, out: &mut Vec<u8>) {
        let Some(vehicle) = self.vehicle else { return };
        let now = self.times.now;
        let left = self.parameters.unrestored().count();
        if left == 0 {
            self.notes.push("all parameters are as before".to_string());
            self.enter(Stage::Ended);
            return;
        }
        if now - self.times.stage > RESTORE_US {
            for change in self.parameters.unrestored() {
                let known = if change.confirmed {
                    "was NOT written back"
                } else {
                    "may be changed: the autopilot confirmed neither the change nor the old value"
                };
                let (name, before) = (change.name, change.before as f32);
                self.notes
                    .push(format!("parameter {name} {known}. Set it to {before}"));
            }
            self.enter(Stage::Ended);
            return;
        }
        let follows = vehicle.following && vehicle.armed;
        if !follows && due(&mut self.times.command, now, AGAIN_US) {
            for change in self.parameters.unrestored() {
                let (value, kind) = change.back(vehicle.autopilot);
                let message = messages::set_parameter(vehicle.system, change.name, value, kind);
                self.encoder.write_at(&message, now, out);
            }
        }
    }
}
