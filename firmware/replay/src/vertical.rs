//! Steps of the vertical controller.

use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, GuardedState};
use touchdown_flight::ground_effect::{GroundEffectState, Validity};
use touchdown_flight::method::{Feedforward, Method, VerticalLanding, VerticalSettings};
use touchdown_flight::vertical_controller::{VerticalController, VerticalControllerState};
use touchdown_flight::{Command, Measurement};
use touchdown_lander::models::FlightModels;

use crate::words::{Port, Reader, Writer};

/// State of the controller.
pub(crate) type State = VerticalControllerState<f32, GuardedState<f32, GroundEffectState<f32>>>;

/// Settings of a recording: method, and the angular frequency of the deck's heave (rad/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalRecording {
    /// The method.
    pub method: Method,
    /// Angular frequency of the heave for the deck filter, rad/s; none without the filter.
    pub deck_angular_frequency: Option<f32>,
    /// Height at which the descent begins, m.
    pub start_height_m: f32,
}

impl VerticalRecording {
    /// The words of the settings.
    #[must_use]
    pub fn words(&self) -> [u32; 3] {
        let method = Method::ALL.iter().position(|&m| m == self.method);
        [
            u32::try_from(method.unwrap_or(0)).unwrap_or(0),
            self.deck_angular_frequency.unwrap_or(0.0).to_bits(),
            self.start_height_m.to_bits(),
        ]
    }

    /// Reads the settings from the words of a recording.
    pub fn read(port: &mut impl Port) -> Option<Self> {
        let method = *Method::ALL.get(port.word()? as usize)?;
        let [w, start_height_m] = port.numbers()?;
        Some(Self {
            method,
            deck_angular_frequency: (w > 0.0).then_some(w),
            start_height_m,
        })
    }

    /// The controller with the models fitted at the paper's ground effect.
    #[must_use]
    pub fn controller(&self) -> Option<VerticalController<f32>> {
        let models = FlightModels::paper();
        let landing = VerticalLanding {
            mass_kg: 1.37,
            gravity_mps2: 9.81,
            start_height_m: self.start_height_m,
            deck_angular_frequency: self.deck_angular_frequency,
            deck_acceleration: self.deck_angular_frequency.is_some(),
        };
        let ground_effect = match self.method.feedforward() {
            Feedforward::Dynamic => models.dynamic,
            _ => Guarded::new(GroundEffectModel::None, Validity::default()),
        };
        VerticalSettings::default()
            .controller(self.method, &landing, models.thrust, ground_effect)
            .ok()
    }
}

/// One step; not inlined, so that a measured call holds the whole step.
#[inline(never)]
pub fn vertical_step(
    controller: &VerticalController<f32>,
    state: &mut State,
    measurement: &Measurement<f32>,
    dt: f32,
) -> Command<f32> {
    controller.step(state, measurement, dt)
}

/// Inputs of a call: dt, height, relative velocity, vehicle's velocity, acceleration.
pub(crate) fn replay(port: &mut impl Port) -> Option<()> {
    let recording = VerticalRecording::read(port)?;
    let controller = recording.controller()?;
    let start = Measurement {
        height_m: recording.start_height_m,
        ..Measurement::default()
    };
    let hover = controller.thrust.throttle_for(1.37 * 9.81);
    let mut state = controller.initial(&start, hover);
    while let Some(dt) = port.number() {
        let [height_m, relative, vehicle, acceleration_mps2] = port.numbers()?;
        let measurement = Measurement {
            height_m,
            relative_velocity_mps: relative,
            vehicle_velocity_mps: vehicle,
            acceleration_mps2,
        };
        port.begin();
        let command = vertical_step(&controller, &mut state, &measurement, dt);
        port.end();
        port.put(command.thrust_n);
        port.put(command.throttle);
        port.put(command.ground_effect_n);
    }
    Some(())
}
