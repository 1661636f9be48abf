//! The computer of the default settings, for the unit tests of its parts.

use super::{Computer, ComputerState};
use crate::models::FlightModels;
use crate::settings::{ControlSettings, LoopTiming, SensorNumbers, VehicleNumbers};
use touchdown_flight::ground_effect::{GroundEffect, Guarded};

pub(super) const DT: f64 = 0.01;

pub(super) type State = ComputerState<f64, <Guarded<f64> as GroundEffect<f64>>::State>;

pub(super) fn computer() -> Computer<f64> {
    ControlSettings::default()
        .computer(
            &FlightModels::default(),
            &VehicleNumbers::default(),
            &SensorNumbers::default(),
            &LoopTiming::default(),
            0.8,
        )
        .unwrap()
}
