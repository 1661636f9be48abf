//! Steps of the landing computer.

use core::hint::black_box;

use touchdown_flight::ground_effect::{GroundEffectState, GuardedState};
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::computer::{Computer, ComputerOutput, ComputerState, NormalReading, Sensed};
use touchdown_lander::estimate::relative::{
    BarometerReading, BeaconReading, GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::{ControlSettings, LoopTiming, SensorNumbers, VehicleNumbers};
use touchdown_lander::state_machine::OperatorRequest;

use crate::words::{Port, Reader, Writer};

/// State of the computer.
pub type State = ComputerState<f32, GuardedState<f32, GroundEffectState<f32>>>;

/// Most readings of a step. 100 Hz and sensors of at most 50 Hz bring a handful, also after a
/// gap.
const READINGS: usize = 16;

/// Settings of a recording. Everything else has its default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputerRecording {
    /// Height at which the landing begins, m.
    pub start_height_m: f32,
    /// Throttle at the start.
    pub throttle: f32,
}

impl ComputerRecording {
    /// The words of the settings.
    #[must_use]
    pub fn words(&self) -> [u32; 2] {
        [self.start_height_m.to_bits(), self.throttle.to_bits()]
    }

    /// The computer with default settings, models, vehicle and sensors.
    #[must_use]
    pub fn computer(&self) -> Option<Computer<f32>> {
        ControlSettings::default()
            .computer(
                &FlightModels::default(),
                &VehicleNumbers::default(),
                &SensorNumbers::default(),
                &LoopTiming::default(),
                self.start_height_m,
            )
            .ok()
    }
}

/// One step; not inlined, so that a measured call holds the whole step.
#[inline(never)]
pub fn computer_step(
    computer: &Computer<f32>,
    state: &mut State,
    sensed: &Sensed<'_, f32>,
    dt: f32,
) -> ComputerOutput<f32> {
    computer.step(state, sensed, dt)
}

/// The first state, which is written where the caller keeps it; not inlined, so that a measured call
/// holds the whole start.
#[inline(never)]
#[must_use]
pub fn computer_start(computer: &Computer<f32>, throttle: f32) -> State {
    computer.initial(throttle)
}

/// The words of a step's inputs, for the replay.
pub fn record(sensed: &Sensed<'_, f32>, dt: f32, mut put: impl FnMut(u32)) {
    let mut number = |x: f32| put(x.to_bits());
    let numbers = |xs: &[f32], number: &mut dyn FnMut(f32)| xs.iter().for_each(|&x| number(x));
    number(dt);
    let imu = &sensed.imu;
    numbers(&imu.specific_force_mps2.to_array(), &mut number);
    numbers(&imu.attitude.to_quaternion(), &mut number);
    number(sensed.battery_share);
    let normal = sensed.deck_normal.unwrap_or(NormalReading {
        normal: Vector::ZERO,
        age_s: -1.0,
    });
    numbers(&normal.normal.to_array(), &mut number);
    number(normal.age_s);
    let readings = &sensed.readings[..sensed.readings.len().min(READINGS)];
    #[allow(clippy::cast_precision_loss)]
    number(readings.len() as f32);
    for reading in readings {
        match reading {
            Reading::Range(range) => {
                number(0.0);
                number(range.distance_m);
                numbers(&range.deck_normal.to_array(), &mut number);
            }
            Reading::Tag(tag) => {
                number(1.0);
                numbers(&tag.position_m.to_array(), &mut number);
                for row in tag.covariance_m2 {
                    numbers(&row, &mut number);
                }
            }
            Reading::Gnss(gnss) => {
                number(2.0);
                numbers(&gnss.velocity_mps.to_array(), &mut number);
            }
            Reading::Barometer(barometer) => {
                number(3.0);
                number(barometer.altitude_m);
            }
            Reading::Beacon(beacon) => {
                number(4.0);
                numbers(&beacon.position_m.to_array(), &mut number);
                numbers(&beacon.deck_velocity_mps.to_array(), &mut number);
            }
        }
        number(reading.age_s());
    }
}

fn reading(port: &mut impl Port) -> Option<Reading<f32>> {
    let which = port.number()?;
    Some(if which == 0.0 {
        Reading::Range(RangeReading {
            distance_m: port.number()?,
            deck_normal: port.vector()?,
            age_s: port.number()?,
        })
    } else if which == 1.0 {
        Reading::Tag(TagReading {
            position_m: port.vector()?,
            covariance_m2: [port.numbers()?, port.numbers()?, port.numbers()?],
            age_s: port.number()?,
        })
    } else if which == 2.0 {
        Reading::Gnss(GnssVelocity {
            velocity_mps: port.vector()?,
            age_s: port.number()?,
        })
    } else if which == 3.0 {
        Reading::Barometer(BarometerReading {
            altitude_m: port.number()?,
            age_s: port.number()?,
        })
    } else {
        Reading::Beacon(BeaconReading {
            position_m: port.vector()?,
            deck_velocity_mps: port.vector()?,
            age_s: port.number()?,
        })
    })
}

/// The attitude of a recorded quaternion; one without numbers if those are none.
fn attitude(quaternion: [f32; 4]) -> Attitude<f32> {
    let none = Vector::new(f32::NAN, f32::NAN, f32::NAN);
    Attitude::from_quaternion(quaternion).unwrap_or_else(|| Attitude::from_rotation_vector(none))
}

/// One call: the first state.
pub(crate) fn start(port: &mut impl Port) -> Option<()> {
    let [start_height_m, throttle] = port.numbers()?;
    let recording = ComputerRecording {
        start_height_m,
        throttle,
    };
    let computer = recording.computer()?;
    port.begin();
    let state = black_box(computer_start(&computer, throttle));
    port.end();
    port.write(state.phase() as u32);
    Some(())
}

/// Inputs of a call: those that [`record`] writes.
pub(crate) fn replay(port: &mut impl Port) -> Option<()> {
    let [start_height_m, throttle] = port.numbers()?;
    let recording = ComputerRecording {
        start_height_m,
        throttle,
    };
    let computer = recording.computer()?;
    let mut state = computer_start(&computer, throttle);
    let mut readings = [Reading::Range(RangeReading::level(0.0, 0.0)); READINGS];
    while let Some(dt) = port.number() {
        let specific_force_mps2 = port.vector()?;
        let quaternion = port.numbers()?;
        let battery_share = port.number()?;
        let normal = NormalReading {
            normal: port.vector()?,
            age_s: port.number()?,
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = port.number()? as usize;
        for place in readings.get_mut(..count)? {
            *place = reading(port)?;
        }
        let sensed = Sensed {
            imu: ImuSample {
                specific_force_mps2,
                attitude: attitude(quaternion),
            },
            readings: readings.get(..count)?,
            deck_normal: (normal.age_s >= 0.0).then_some(normal),
            battery_share,
            contact: None,
            request: OperatorRequest::None,
        };
        port.begin();
        let output = computer_step(&computer, &mut state, &sensed, dt);
        port.end();
        results(port, &output);
    }
    Some(())
}

/// Writes what a step returned.
fn results(port: &mut impl Port, output: &ComputerOutput<f32>) {
    let machine = &output.state_machine;
    port.write(machine.phase as u32 | u32::from(machine.go_arounds) << 8);
    let command = output.command.unwrap_or_default();
    port.write(u32::from(output.command.is_some()));
    port.put(command.thrust_n);
    port.put(command.throttle);
    port.put_attitude(command.attitude);
    let estimate = &output.estimate;
    port.put_vector(estimate.position_m);
    port.put_vector(estimate.velocity_mps);
    port.put_vector(estimate.deck_velocity_mps);
    port.put_vector(estimate.position_sd_m);
    port.put_vector(estimate.bias_mps2);
    port.put(output.deck.displacement_m);
    port.put(output.deck.velocity_mps);
    port.put(output.deck.acceleration_sd_mps2);
    port.put(output.plan.map_or(-1.0, |plan| plan.reference.duration_s));
    port.put(output.latency_s);
    port.put_vector(output.disturbance_n);
}
