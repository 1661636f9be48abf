//! Summary of a flight.

use serde::Serialize;
use touchdown_lander::state_machine::Phase;

use super::touch::EstimatedTouch;
use super::{Companion, Ending, Stage};
use crate::autopilot::{Autopilot, Firmware};
use crate::camera::CameraSummary;
use crate::checklist::Checklist;
use crate::clock::SyncReport;
use crate::parameters::Change;
use crate::readings::IgnoredReadings;
use crate::timing::Quantiles;
use crate::wire::WireCounts;

/// Summary of a flight.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The stage.
    pub stage: Stage,
    /// Why control ended, or was handed over.
    pub ending: Option<Ending>,
    /// The autopilot.
    pub autopilot: Option<Autopilot>,
    /// Version of its firmware.
    pub firmware: Option<Firmware>,
    /// System id of the vehicle.
    pub system_id: Option<u8>,
    /// The checklist as it was last.
    pub checklist: Checklist,
    /// Parameters that were changed.
    pub parameters: Vec<Change>,
    /// Synchronisation of the clocks.
    pub time: Option<SyncReport>,
    /// The autopilot's thrust setpoint in hover, as found before control.
    pub hover_thrust: Option<f64>,
    /// Time in control, s.
    pub in_control_s: f64,
    /// Setpoints sent while in control.
    pub setpoints: u64,
    /// Ticks in control that came more than 5 ms late.
    pub late_ticks: u64,
    /// Deviation of the period from 10 ms while setpoints were streamed.
    pub jitter: Option<Quantiles>,
    /// Age of the newest reading when a setpoint was sent in control.
    pub reading_age: Option<Quantiles>,
    /// The touch, by the landing computer's estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touch: Option<EstimatedTouch>,
    /// Last phase of the landing computer in control.
    pub phase: Option<Phase>,
    /// Frames on the wire.
    pub wire: WireCounts,
    /// Messages of other systems and components.
    pub other_senders: u64,
    /// The camera, if the companion has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSummary>,
    /// Readings that were not used.
    pub ignored_readings: IgnoredReadings,
}

impl Companion {
    /// The summary of the flight so far.
    #[must_use]
    pub fn summary(&self) -> Summary {
        Summary {
            stage: self.stage,
            ending: self.ending,
            autopilot: self.vehicle.map(|vehicle| vehicle.autopilot),
            firmware: self.vehicle.and_then(|vehicle| vehicle.firmware),
            system_id: self.vehicle.map(|vehicle| vehicle.system),
            checklist: self.checklist.clone(),
            parameters: self.parameters.changes().to_vec(),
            time: self.clock.report(),
            hover_thrust: self.echo.hover(),
            in_control_s: self.in_control_us as f64 * 1e-6,
            setpoints: self.setpoints,
            late_ticks: self.late_ticks,
            jitter: self.jitter.quantiles(),
            reading_age: self.reading_ages.quantiles(),
            touch: self.touch.touch(),
            phase: self.phase(),
            wire: self.decoder.counts,
            other_senders: self.other_senders,
            camera: self
                .camera
                .as_ref()
                .map(crate::camera::CameraWatch::summary),
            ignored_readings: self.inbox.ignored,
        }
    }
}
