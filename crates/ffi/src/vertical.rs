//! The vertical controller.

use core::ffi::c_void;
use core::mem::{align_of, size_of};
use core::ptr::addr_of_mut;

use touchdown_flight::SettingsError;
use touchdown_flight::error::{finite, not_negative};
use touchdown_flight::ground_effect::{
    Empirical, GroundEffectModel, GroundEffectState, Guarded, GuardedState, Validity,
};
use touchdown_flight::method::{Feedforward, Method, VerticalLanding, VerticalSettings};
use touchdown_flight::vertical_controller::{VerticalController, VerticalControllerState};
use touchdown_flight::{Command, Measurement};
use touchdown_lander::models::FlightModels;

use crate::error::{td_error, td_setting};
use crate::memory::{Placed, check, check_optional, fits, live, place, read, write};
use crate::models::td_models;
use crate::refusal::Refusal;
use crate::vehicle::{method, td_method, td_vehicle};

/// Size of the memory of a `td_vertical` on every target, bytes; `td_vertical_size` returns that
/// of this one, which is less.
pub const TD_VERTICAL_SIZE: usize = 512;
/// Alignment of that memory, bytes.
pub const TD_VERTICAL_ALIGN: usize = 8;

const _: () = fits::<td_vertical>(TD_VERTICAL_SIZE, TD_VERTICAL_ALIGN);

/// Settings of the vertical controller.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_vertical_settings {
    /// The vehicle.
    pub vehicle: td_vehicle,
    /// Its models.
    pub models: td_models,
    /// A `td_method` up to `TD_METHOD_SSC`.
    pub method: u32,
    /// Height above the deck at which the descent begins, m.
    pub start_height_m: f32,
    /// Height above the deck at which it ends, m.
    pub end_height_m: f32,
    /// Rate C of the descent, eq. (13), 1/s.
    pub descent_rate_per_s: f32,
    /// Frequency of the deck's heave, Hz; 0 for a deck at rest.
    pub deck_frequency_hz: f32,
}

/// What the sensors measured. z is up.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_measurement {
    /// Height of the reference point above the deck, m.
    pub height_m: f32,
    /// Velocity relative to the deck, m/s.
    pub relative_velocity_mps: f32,
    /// Velocity of the vehicle in the world, m/s.
    pub vehicle_velocity_mps: f32,
    /// Acceleration of the vehicle, gravity removed, m/s^2.
    pub acceleration_mps2: f32,
}

/// What the controller asks of the rotors until the next step.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_command {
    /// Free-air thrust, N.
    pub thrust_n: f32,
    /// Throttle in [0, 1].
    pub throttle: f32,
    /// Ground-effect force that the law counts on, N.
    pub ground_effect_n: f32,
}

/// A vertical controller and its state, in the caller's memory.
pub struct td_vertical {
    mark: u32,
    controller: VerticalController<f32>,
    state: VerticalControllerState<f32, GuardedState<f32, GroundEffectState<f32>>>,
}

impl Placed for td_vertical {
    const MARK: u32 = u32::from_be_bytes(*b"tdV1");

    fn mark(place: *mut Self) -> *mut u32 {
        // SAFETY: an address within the same memory; nothing is read.
        unsafe { addr_of_mut!((*place).mark) }
    }
}

impl td_vertical_settings {
    fn standard() -> Self {
        let settings = VerticalSettings::<f32>::default();
        Self {
            vehicle: td_vehicle::standard(),
            models: td_models::new(&FlightModels::default()),
            method: td_method::Dynamic as u32,
            // From where the paper's landings on the ground begin.
            start_height_m: 0.8,
            end_height_m: settings.end_height_m,
            descent_rate_per_s: settings.c_per_s,
            deck_frequency_hz: 0.0,
        }
    }

    fn controller(&self) -> Result<VerticalController<f32>, Refusal> {
        let method = method(self.method)?;
        if !Method::VERTICAL.contains(&method) {
            return Err(Refusal::unknown(
                "method",
                "TD_METHOD_SSC or below: the others need an inertial unit",
                self.method,
            ));
        }
        not_negative("deck_frequency_hz", self.deck_frequency_hz)?;
        let models = self.models.models(method, &self.vehicle)?;
        let ground_effect = match method.feedforward() {
            Feedforward::None => Guarded::new(GroundEffectModel::None, Validity::default()),
            Feedforward::Empirical => Guarded::new(
                GroundEffectModel::Empirical(Empirical {
                    mu: models.mu,
                    rotor_radius_m: self.vehicle.rotor_radius_m,
                    rotor_offset_m: 0.0,
                }),
                Validity::default(),
            ),
            Feedforward::Dynamic => models.dynamic,
        };
        let moves = self.deck_frequency_hz != 0.0;
        let landing = VerticalLanding {
            mass_kg: self.vehicle.mass_kg,
            gravity_mps2: self.vehicle.gravity_mps2,
            start_height_m: self.start_height_m,
            deck_angular_frequency: moves
                .then_some(core::f32::consts::TAU * self.deck_frequency_hz),
            deck_acceleration: moves,
        };
        let settings = VerticalSettings {
            c_per_s: self.descent_rate_per_s,
            end_height_m: self.end_height_m,
            limits: self.vehicle.numbers().limits(),
            ..VerticalSettings::default()
        };
        Ok(settings.controller(method, &landing, models.thrust, ground_effect)?)
    }
}

impl td_measurement {
    /// Checks the measurement when the descent begins.
    fn check(&self) -> Result<(), SettingsError> {
        finite("start.height_m", self.height_m)?;
        finite("start.relative_velocity_mps", self.relative_velocity_mps)?;
        finite("start.vehicle_velocity_mps", self.vehicle_velocity_mps)?;
        finite("start.acceleration_mps2", self.acceleration_mps2)
    }

    fn measurement(&self) -> Measurement<f32> {
        Measurement {
            height_m: self.height_m,
            relative_velocity_mps: self.relative_velocity_mps,
            vehicle_velocity_mps: self.vehicle_velocity_mps,
            acceleration_mps2: self.acceleration_mps2,
        }
    }
}

/// Size of a `td_vertical` on this target, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn td_vertical_size() -> usize {
    size_of::<td_vertical>()
}

/// Alignment of a `td_vertical` on this target, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn td_vertical_align() -> usize {
    align_of::<td_vertical>()
}

/// Settings of the paper's quadrotor, from 0.8 m onto a deck at rest.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_vertical_settings_default(
    settings: *mut td_vertical_settings,
) -> td_error {
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { write(settings, td_vertical_settings::standard()) }.into()
}

/// Makes a controller in `memory` of `size` bytes, and its handle. `start` is the measurement,
/// `throttle` what is being sent when the descent begins. `setting` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_vertical_init(
    memory: *mut c_void,
    size: usize,
    settings: *const td_vertical_settings,
    start: *const td_measurement,
    throttle: f32,
    vertical: *mut *mut td_vertical,
    setting: *mut td_setting,
) -> td_error {
    let init = || -> Result<(), Refusal> {
        let place = place::<td_vertical>(memory, size)?;
        check(vertical)?;
        check_optional(setting)?;
        // SAFETY: as the crate's documentation requires of every pointer.
        let (settings, start) = unsafe { (read(settings)?, read(start)?) };
        start.check()?;
        finite("throttle", throttle)?;
        let controller = settings.controller()?;
        let state = controller.initial(&start.measurement(), throttle);
        // SAFETY: `place` was checked, and is the caller's memory of that size. The mark comes last.
        unsafe {
            addr_of_mut!((*place).controller).write(controller);
            addr_of_mut!((*place).state).write(state);
            td_vertical::mark(place).write(td_vertical::MARK);
            write(vertical, place)?;
        }
        Ok(())
    };
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { Refusal::report(init(), setting) }
}

/// One control period of `dt_s` seconds: takes the measurement at its beginning, gives the command
/// to hold until its end. The command is always finite and within the limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_vertical_step(
    vertical: *mut td_vertical,
    measurement: *const td_measurement,
    dt_s: f32,
    command: *mut td_command,
) -> td_error {
    let step = || -> Result<(), td_error> {
        check(command)?;
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return Err(td_error::TimeStep);
        }
        // SAFETY: as the crate's documentation requires of every pointer.
        let (vertical, measurement) = unsafe { (live(vertical)?, read(measurement)?) };
        let measurement = measurement.measurement();
        let Command {
            thrust_n,
            throttle,
            ground_effect_n,
        } = vertical
            .controller
            .step(&mut vertical.state, &measurement, dt_s);
        let found = td_command {
            thrust_n,
            throttle,
            ground_effect_n,
        };
        // SAFETY: as the crate's documentation requires of every pointer.
        unsafe { write(command, found) }?;
        if measurement.is_finite() {
            Ok(())
        } else {
            Err(td_error::SensorNotFinite)
        }
    };
    step().into()
}
