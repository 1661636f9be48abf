//! The simulator, so that programs in C and C++ can land on a computer.
//!
//! The simulator calls the program's function in each control period and flies what it returns.

use core::ffi::{CStr, c_char, c_void};
use std::boxed::Box;
use std::vec::Vec;

use touchdown_flight::{Attitude, Command, Measurement, Vector};
use touchdown_lander::computer::{ComputerOutput, Sensed};
use touchdown_lander::estimate::relative::Reading;
use touchdown_lander::space_controller::SpaceCommand;
use touchdown_lander::state_machine::{OperatorRequest, Phase};
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::landing::space::{Case, SpaceLander, SpaceOutcome};
use touchdown_sim::landing::vertical::{LandingScenario, Outcome, land};

use crate::computer::{
    td_barometer, td_beacon, td_computer_output, td_gnss, td_phase, td_range, td_reading,
    td_reading_data, td_reading_kind, td_request, td_sensed, td_tag,
};
use crate::error::td_error;
use crate::memory::{check, read, write};
use crate::numbers::numbered;
use crate::vertical::td_measurement;

/// How a landing ended.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_outcome {
    /// On the deck.
    Landed = 0,
    /// Hit something, hit the deck too hard, or tipped over.
    Crashed = 1,
    /// Not down by the end of the time.
    TimedOut = 2,
    /// Flew away, or its state was no number any more.
    Diverged = 3,
    /// Gave the landing up and holds.
    GivenUp = 4,
}

/// A landing, by the true state.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_landing {
    /// A `td_outcome`.
    pub outcome: u32,
    /// T_L: time from the start of the descent to the touch, s; NaN without one.
    pub landing_time_s: f64,
    /// V_L: speed relative to the deck at the touch, m/s; NaN without one.
    pub touch_speed_mps: f64,
}

/// Flies a control period of 10 ms: gives the throttle to hold. `user` is what the caller handed
/// over.
pub type td_vertical_pilot =
    Option<unsafe extern "C" fn(user: *mut c_void, measurement: *const td_measurement) -> f32>;

/// Flies a step of `dt_s` seconds: fills in the output, as `td_computer_step` does, and returns its
/// code. A code other than `TD_ERROR_NONE` and `TD_ERROR_SENSOR_NOT_FINITE` stops the rotors.
pub type td_space_pilot = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        sensed: *const td_sensed,
        dt_s: f32,
        output: *mut td_computer_output,
    ) -> u32,
>;

/// A vertical landing: the paper's quadrotor in turbulent air, with noisy sensors.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_vertical_world {
    /// Height above the deck at the start, m.
    pub start_height_m: f64,
    /// Amplitude of the deck's heave, m.
    pub deck_amplitude_m: f64,
    /// Frequency of the deck's heave, Hz; 0 for a deck at rest.
    pub deck_frequency_hz: f64,
    /// Index of the trial; trials differ in vehicle, phase of the deck and noise.
    pub trial: u64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A case of the simulator in six degrees of freedom.
pub struct td_world {
    lander: SpaceLander,
    start_height_m: f32,
    start_throttle: f32,
}

#[allow(clippy::cast_possible_truncation)]
fn narrow(x: f64) -> f32 {
    x as f32
}

fn measured(measurement: &Measurement<f64>) -> td_measurement {
    td_measurement {
        height_m: narrow(measurement.height_m),
        relative_velocity_mps: narrow(measurement.relative_velocity_mps),
        vehicle_velocity_mps: narrow(measurement.vehicle_velocity_mps),
        acceleration_mps2: narrow(measurement.acceleration_mps2),
    }
}

/// Flies a vertical landing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_world_land_vertical(
    world: *const td_vertical_world,
    pilot: td_vertical_pilot,
    user: *mut c_void,
    landing: *mut td_landing,
) -> td_error {
    let fly = || -> Result<(), td_error> {
        check(landing)?;
        let pilot = pilot.ok_or(td_error::NullPointer)?;
        // SAFETY: as the crate's documentation requires of every pointer.
        let world = unsafe { read(world) }?;
        let scenario = LandingScenario {
            start_height_m: world.start_height_m,
            deck: if world.deck_frequency_hz == 0.0 {
                DeckMotion::Still
            } else {
                DeckMotion::Sine {
                    amplitude_m: world.deck_amplitude_m,
                    frequency_hz: world.deck_frequency_hz,
                    phase_rad: 0.0,
                }
            },
            ..LandingScenario::default()
        };
        let mut controller = |measurement: &Measurement<f64>| {
            let measurement = measured(measurement);
            Command {
                // SAFETY: the caller's function, with the caller's address and a measurement.
                throttle: f64::from(unsafe { pilot(user, &raw const measurement) }),
                ..Command::default()
            }
        };
        let flown = land(&scenario, world.trial, world.seed, &mut controller, false)
            .map_err(|_| td_error::World)?;
        let outcome = match flown.outcome {
            Outcome::Landed => td_outcome::Landed,
            Outcome::Crashed => td_outcome::Crashed,
            Outcome::TimedOut => td_outcome::TimedOut,
            Outcome::Diverged => td_outcome::Diverged,
        };
        let flown = td_landing {
            outcome: outcome as u32,
            landing_time_s: flown.t_l_s.unwrap_or(f64::NAN),
            touch_speed_mps: flown.v_l_mps.unwrap_or(f64::NAN),
        };
        // SAFETY: as the crate's documentation requires of every pointer.
        unsafe { write(landing, flown) }
    };
    fly().into()
}

/// Makes the world of a case by its name, such as "paper" (`touchdown land --space --help` lists
/// them). `td_world_free` ends it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_world_new(name: *const c_char, world: *mut *mut td_world) -> td_error {
    let make = || -> Result<(), td_error> {
        check(name)?;
        check(world)?;
        // SAFETY: the caller's text, which ends with a zero.
        let name = unsafe { CStr::from_ptr(name) };
        let name = name.to_str().map_err(|_| td_error::World)?;
        let scenario = Case::named(name).ok_or(td_error::World)?.scenario();
        let lander = SpaceLander::new(&scenario).map_err(|_| td_error::World)?;
        let controller = &lander.computer().controller;
        let weight_n = controller.mass_kg * controller.gravity_mps2;
        let [_, _, start_height_m] = scenario.start_m;
        let made = td_world {
            start_height_m: narrow(start_height_m),
            start_throttle: narrow(controller.thrust.throttle_for(weight_n)),
            lander,
        };
        // SAFETY: as the crate's documentation requires of every pointer.
        unsafe { write(world, Box::into_raw(Box::new(made))) }
    };
    make().into()
}

/// Ends a world; null does nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_world_free(world: *mut td_world) {
    if !world.is_null() {
        // SAFETY: made by `td_world_new`, and not used any more.
        drop(unsafe { Box::from_raw(world) });
    }
}

/// Height above the deck at which landings begin, m; NaN for a null pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_world_start_height_m(world: *const td_world) -> f32 {
    // SAFETY: null, or made by `td_world_new`.
    unsafe { world.as_ref() }.map_or(f32::NAN, |world| world.start_height_m)
}

/// Throttle at which landings begin; NaN for a null pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_world_start_throttle(world: *const td_world) -> f32 {
    // SAFETY: null, or made by `td_world_new`.
    unsafe { world.as_ref() }.map_or(f32::NAN, |world| world.start_throttle)
}

fn array(v: Vector<f64>) -> [f32; 3] {
    v.to_array().map(narrow)
}

fn reading(reading: &Reading<f64>) -> td_reading {
    let (kind, data) = match reading {
        Reading::Range(of) => (
            td_reading_kind::Range,
            td_reading_data {
                range: td_range {
                    distance_m: narrow(of.distance_m),
                },
            },
        ),
        Reading::Tag(of) => {
            let mut covariance_m2 = [0.0; 9];
            for (to, from) in covariance_m2
                .iter_mut()
                .zip(of.covariance_m2.as_flattened())
            {
                *to = narrow(*from);
            }
            let position_m = array(of.position_m);
            (
                td_reading_kind::Tag,
                td_reading_data {
                    tag: td_tag {
                        position_m,
                        covariance_m2,
                    },
                },
            )
        }
        Reading::Gnss(of) => {
            let velocity_mps = array(of.velocity_mps);
            (
                td_reading_kind::Gnss,
                td_reading_data {
                    gnss: td_gnss { velocity_mps },
                },
            )
        }
        Reading::Barometer(of) => {
            let altitude_m = narrow(of.altitude_m);
            (
                td_reading_kind::Barometer,
                td_reading_data {
                    barometer: td_barometer { altitude_m },
                },
            )
        }
        Reading::Beacon(of) => (
            td_reading_kind::Beacon,
            td_reading_data {
                beacon: td_beacon {
                    position_m: array(of.position_m),
                    deck_velocity_mps: array(of.deck_velocity_mps),
                },
            },
        ),
    };
    td_reading {
        kind: kind as u32,
        age_s: narrow(reading.age_s()),
        data,
    }
}

fn sensed(of: &Sensed<'_, f64>, readings: &[td_reading]) -> td_sensed {
    let normal = of.deck_normal;
    td_sensed {
        specific_force_mps2: array(of.imu.specific_force_mps2),
        attitude: of.imu.attitude.to_quaternion().map(narrow),
        readings: readings.as_ptr(),
        readings_count: readings.len(),
        deck_normal: normal.map_or([0.0; 3], |normal| array(normal.normal)),
        deck_normal_age_s: normal.map_or(-1.0, |normal| narrow(normal.age_s)),
        battery_share: narrow(of.battery_share),
        contact: of.contact.map_or(-1, i32::from),
        request: match of.request {
            OperatorRequest::None => td_request::None,
            OperatorRequest::Abort => td_request::Abort,
            OperatorRequest::Restart => td_request::Restart,
            OperatorRequest::Disarm => td_request::Disarm,
        } as u32,
    }
}

fn phase(number: u32) -> Option<Phase> {
    Some(match td_phase::of(number).ok()? {
        td_phase::Approach => Phase::Approach,
        td_phase::Hold => Phase::Hold,
        td_phase::Wait => Phase::Wait,
        td_phase::Descend => Phase::Descend,
        td_phase::Commit => Phase::Commit,
        td_phase::Touchdown => Phase::Touchdown,
        td_phase::Disarmed => Phase::Disarmed,
        td_phase::GoAround => Phase::GoAround,
        td_phase::GivenUp => Phase::GivenUp,
    })
}

numbered!(td_phase: Approach, Hold, Wait, Descend, Commit, Touchdown, Disarmed, GoAround, GivenUp);

/// Puts what the pilot returned in place of what the simulator's own computer did. Reasons stay
/// those of the latter: nothing that flies depends on them.
fn replace(output: &mut ComputerOutput<f64>, by: &td_computer_output) -> Result<(), td_error> {
    output.state_machine.phase = phase(by.phase).ok_or(td_error::UnknownValue)?;
    output.latency_s = f64::from(by.latency_s);
    output.command = (by.rotors == 1).then(|| SpaceCommand {
        thrust_n: f64::from(by.thrust_n),
        throttle: f64::from(by.throttle),
        attitude: Attitude::from_quaternion(by.attitude.map(f64::from)).unwrap_or(Attitude::LEVEL),
        ..SpaceCommand::default()
    });
    Ok(())
}

/// Flies a landing of a trial and a seed. Returns `TD_ERROR_PILOT` if the pilot's code stopped the
/// rotors, and `TD_ERROR_UNKNOWN_VALUE` if its phase did; the landing is written also then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_world_land(
    world: *const td_world,
    trial: u64,
    seed: u64,
    pilot: td_space_pilot,
    user: *mut c_void,
    landing: *mut td_landing,
) -> td_error {
    let fly = || -> Result<(), td_error> {
        check(landing)?;
        check(world)?;
        let pilot = pilot.ok_or(td_error::NullPointer)?;
        // SAFETY: made by `td_world_new`.
        let world = unsafe { &*world };
        let mut failed = None;
        let mut hook = |of: &Sensed<'_, f64>, dt_s: f64, output: &mut ComputerOutput<f64>| {
            let readings: Vec<_> = of.readings.iter().map(reading).collect();
            let sensed = sensed(of, &readings);
            let mut flown = td_computer_output::default();
            // SAFETY: the caller's function, with the caller's address and values of this frame.
            let code = unsafe { pilot(user, &raw const sensed, narrow(dt_s), &raw mut flown) };
            let replaced =
                if code == td_error::None as u32 || code == td_error::SensorNotFinite as u32 {
                    replace(output, &flown)
                } else {
                    Err(td_error::Pilot)
                };
            if let Err(code) = replaced {
                failed.get_or_insert(code);
                output.command = None;
            }
        };
        let flown = (world.lander)
            .land_with(trial, seed, false, &mut hook)
            .map_err(|_| td_error::World)?;
        let touch = flown.touch.as_ref();
        let flown = td_landing {
            outcome: match flown.outcome {
                SpaceOutcome::Landed { .. } => td_outcome::Landed,
                SpaceOutcome::Crashed { .. } | SpaceOutcome::TippedOver => td_outcome::Crashed,
                SpaceOutcome::GivenUp { .. } => td_outcome::GivenUp,
                SpaceOutcome::TimedOut => td_outcome::TimedOut,
            } as u32,
            landing_time_s: touch.map_or(f64::NAN, |touch| touch.t_l_s),
            touch_speed_mps: touch.map_or(f64::NAN, |touch| touch.v_l_mps),
        };
        // SAFETY: as the crate's documentation requires of every pointer.
        unsafe { write(landing, flown) }?;
        failed.map_or(Ok(()), Err)
    };
    fly().into()
}
