//! The landings that are recorded.

use std::f64::consts::PI;

use touchdown_flight::real::Real;
use touchdown_flight::{Attitude, Command, Measurement, Method, Vector};
use touchdown_lander::computer::{ComputerOutput, NormalReading, Sensed};
use touchdown_lander::estimate::relative::{
    BarometerReading, BeaconReading, GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};
use touchdown_replay::{
    Callee, ComputerRecording, ModelCall, VerticalRecording, computer_step, record, vertical_step,
};
use touchdown_sim::SimError;
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::landing::space::{Case, SpaceLander, SpaceLanding};
use touchdown_sim::landing::vertical::{LandingScenario, land};

/// A landing of a case with the computer in single precision.
#[derive(Clone, Debug)]
pub struct SingleLanding {
    /// Its recording.
    pub recording: Recording,
    /// How it ended.
    pub landing: SpaceLanding,
}

/// A recording: its name and its words.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Name of its files.
    pub name: String,
    /// Callee, settings and inputs.
    pub words: Vec<u32>,
    /// Whether the vehicle landed, flown by the controller in single precision.
    pub landed: bool,
}

/// Period of the controllers, s.
const DT: f32 = 0.01;
/// Seed of all trials.
pub const SEED: u64 = 1;

/// All recordings: models, vertical landings and landings in space.
///
/// # Errors
/// None of these scenarios is refused; the simulator's type says that others are.
pub fn recordings() -> Result<Vec<Recording>, SimError> {
    let mut all = Vec::new();
    for (name, deck) in [("lag", false), ("lag-deck-filter", true)] {
        let vertical = vertical(name, deck)?;
        if deck {
            all.extend(models(&vertical));
        }
        all.push(vertical);
    }
    let start = ComputerRecording {
        start_height_m: 0.8,
        throttle: 0.5,
    };
    all.push(Recording {
        name: "computer-start".to_owned(),
        words: [&[Callee::ComputerStart.word()][..], &start.words()].concat(),
        landed: true,
    });
    for case in [Case::Paper, Case::Sea, Case::Nan] {
        let lander = SpaceLander::new(&case.scenario())?;
        all.push(space(case, &lander, 0)?.recording);
    }
    Ok(all)
}

#[allow(clippy::cast_possible_truncation)]
fn narrow(x: f64) -> f32 {
    x as f32
}

/// A vertical landing of the method `dynamic` on a deck that heaves by 0.05 m at 0.5 Hz.
fn vertical(name: &str, deck_filter: bool) -> Result<Recording, SimError> {
    let scenario = LandingScenario {
        deck: DeckMotion::Sine {
            amplitude_m: 0.05,
            frequency_hz: 0.5,
            phase_rad: 0.0,
        },
        ..LandingScenario::default()
    };
    let recording = VerticalRecording {
        method: Method::Dynamic,
        deck_angular_frequency: deck_filter.then_some(narrow(PI)),
        start_height_m: narrow(scenario.start_height_m),
    };
    let mut words = vec![Callee::Vertical.word()];
    words.extend(recording.words());
    let controller = recording.controller();
    let mut state = controller.as_ref().map(|controller| {
        let start = Measurement {
            height_m: recording.start_height_m,
            ..Measurement::default()
        };
        let hover = controller.thrust.throttle_for(1.37 * 9.81);
        controller.initial(&start, hover)
    });
    let mut fly = |measured: &Measurement<f64>| {
        let measurement = Measurement {
            height_m: narrow(measured.height_m),
            relative_velocity_mps: narrow(measured.relative_velocity_mps),
            vehicle_velocity_mps: narrow(measured.vehicle_velocity_mps),
            acceleration_mps2: narrow(measured.acceleration_mps2),
        };
        words.extend(
            [
                DT,
                measurement.height_m,
                measurement.relative_velocity_mps,
                measurement.vehicle_velocity_mps,
                measurement.acceleration_mps2,
            ]
            .map(f32::to_bits),
        );
        let (Some(controller), Some(state)) = (&controller, &mut state) else {
            return Command::default();
        };
        let command = vertical_step(controller, state, &measurement, DT);
        Command {
            thrust_n: command.thrust_n.to_f64(),
            throttle: command.throttle.to_f64(),
            ground_effect_n: command.ground_effect_n.to_f64(),
        }
    };
    let landing = land(&scenario, 0, SEED, &mut fly, false)?;
    Ok(Recording {
        name: format!("vertical-{name}"),
        words,
        landed: landing.t_l_s.is_some(),
    })
}

/// Single models under the measurements of a vertical landing and a varying throttle.
fn models(vertical: &Recording) -> Vec<Recording> {
    let names = ["polynomial", "lag", "guarded-lag", "thrust-library"];
    let calls = ModelCall::ALL.into_iter().zip(names);
    calls
        .map(|(call, name)| {
            let mut words = vec![Callee::Model(call).word()];
            // After the callee and three words of settings.
            for (i, step) in vertical.words[4..].chunks_exact(5).enumerate() {
                let [dt, height, relative, vehicle] = [0, 1, 2, 3].map(|k| f32::from_bits(step[k]));
                // A throttle about hover that the ground effect and the rotors follow.
                let throttle = 0.5 + 0.1 * narrow((0.05 * i as f64).sin());
                let inputs = [dt, throttle, 13.4, height, vehicle, vehicle - relative];
                words.extend(inputs.map(f32::to_bits));
            }
            Recording {
                name: format!("model-{name}"),
                words,
                landed: true,
            }
        })
        .collect()
}

/// A landing of a case, flown by the computer in single precision in the world of its lander.
///
/// # Errors
/// None for the cases of the simulator.
pub fn space(case: Case, lander: &SpaceLander, trial: u64) -> Result<SingleLanding, SimError> {
    let weight_n = lander.computer().controller.mass_kg * lander.computer().controller.gravity_mps2;
    let recording = ComputerRecording {
        start_height_m: narrow(case.scenario().start_m[2]),
        throttle: narrow(lander.computer().controller.thrust.throttle_for(weight_n)),
    };
    let mut words = vec![Callee::Computer.word()];
    words.extend(recording.words());
    let computer = recording.computer();
    let mut state = computer
        .as_ref()
        .map(|computer| computer.initial(recording.throttle));
    let mut fly = |sensed: &Sensed<'_, f64>, _: f64, output: &mut ComputerOutput<f64>| {
        let (Some(computer), Some(state)) = (&computer, &mut state) else {
            return;
        };
        let readings: Vec<_> = sensed.readings.iter().map(reading).collect();
        let sensed = sensed_in_f32(sensed, &readings);
        record(&sensed, DT, |word| words.push(word));
        let flown = computer_step(computer, state, &sensed, DT);
        let machine = &mut output.state_machine;
        machine.phase = flown.state_machine.phase;
        machine.reason = flown.state_machine.reason;
        output.latency_s = flown.latency_s.to_f64();
        output.command =
            flown
                .command
                .map(|command| touchdown_lander::space_controller::SpaceCommand {
                    thrust_n: command.thrust_n.to_f64(),
                    throttle: command.throttle.to_f64(),
                    attitude: attitude_in_f64(command.attitude),
                    ..Default::default()
                });
    };
    let landing = lander.land_with(trial, SEED, false, &mut fly)?;
    let recording = Recording {
        name: format!("computer-{}", case.name()),
        words,
        landed: landing.outcome.landed(),
    };
    Ok(SingleLanding { recording, landing })
}

fn vector(v: Vector<f64>) -> Vector<f32> {
    Vector::new(narrow(v.x), narrow(v.y), narrow(v.z))
}

/// An attitude of double precision; one without numbers stays so.
fn attitude(attitude: Attitude<f64>) -> Attitude<f32> {
    let none = Vector::new(f32::NAN, f32::NAN, f32::NAN);
    Attitude::from_quaternion(attitude.to_quaternion().map(narrow))
        .unwrap_or_else(|| Attitude::from_rotation_vector(none))
}

fn attitude_in_f64(attitude: Attitude<f32>) -> Attitude<f64> {
    Attitude::from_quaternion(attitude.to_quaternion().map(f64::from)).unwrap_or(Attitude::LEVEL)
}

fn reading(reading: &Reading<f64>) -> Reading<f32> {
    match reading {
        Reading::Range(range) => Reading::Range(RangeReading {
            distance_m: narrow(range.distance_m),
            deck_normal: vector(range.deck_normal),
            age_s: narrow(range.age_s),
        }),
        Reading::Tag(tag) => Reading::Tag(TagReading {
            position_m: vector(tag.position_m),
            covariance_m2: tag.covariance_m2.map(|row| row.map(narrow)),
            age_s: narrow(tag.age_s),
        }),
        Reading::Gnss(gnss) => Reading::Gnss(GnssVelocity {
            velocity_mps: vector(gnss.velocity_mps),
            age_s: narrow(gnss.age_s),
        }),
        Reading::Barometer(barometer) => Reading::Barometer(BarometerReading {
            altitude_m: narrow(barometer.altitude_m),
            age_s: narrow(barometer.age_s),
        }),
        Reading::Beacon(beacon) => Reading::Beacon(BeaconReading {
            position_m: vector(beacon.position_m),
            deck_velocity_mps: vector(beacon.deck_velocity_mps),
            age_s: narrow(beacon.age_s),
        }),
    }
}

fn sensed_in_f32<'a>(sensed: &Sensed<'_, f64>, readings: &'a [Reading<f32>]) -> Sensed<'a, f32> {
    Sensed {
        imu: ImuSample {
            specific_force_mps2: vector(sensed.imu.specific_force_mps2),
            attitude: attitude(sensed.imu.attitude),
        },
        readings,
        deck_normal: sensed.deck_normal.map(|normal| NormalReading {
            normal: vector(normal.normal),
            age_s: narrow(normal.age_s),
        }),
        battery_share: narrow(sensed.battery_share),
        contact: sensed.contact,
        request: sensed.request,
    }
}
