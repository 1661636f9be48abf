//! Steps of the whole vehicle per second of processor time, one core: Runge–Kutta at 1 kHz, four
//! rotors with their ground effect, a deck in a sea of 100 waves (as a spline), turbulence, Dryden
//! gusts, legs, attitude control at 500 Hz, an outer loop at 100 Hz.
//!
//! Time is that of the thread on the processor (`/proc/thread-self/schedstat`, else the clock), so
//! that the figure holds on a busy machine; the best and the median of several runs are printed.
#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use touchdown_sim::STEP_S;
use touchdown_sim::air::turbulence::RotorTurbulence;
use touchdown_sim::air::wind::{DrydenSettings, Wind, WindSettings};
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::cascade::{AttitudeSetpoint, Cascade, CascadeSettings, CascadeState};
use touchdown_sim::body::contact::{ContactLog, LegSettings};
use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::body::rigid::{Disturbance, RigidVehicle};
use touchdown_sim::deck::rigid::{DeckPose, RigidDeck, RigidMotion, SeaSettings};
use touchdown_sim::random::{Purpose, Stream};

/// A descent of 10 s.
const STEPS: u32 = 10_000;
/// Descents of a run: the system's account of a thread's time is a few ms late.
const DESCENTS: u32 = 25;
const RUNS: usize = 11;

/// Time of this thread on the processor, s; the clock's where the system does not tell.
fn processor_s(start: Instant) -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

#[derive(Clone, Copy, PartialEq)]
enum What {
    /// The vehicle alone, over a still deck.
    Vehicle,
    /// With the deck's motion.
    Deck,
    /// With turbulence and gusts.
    Air,
    /// With legs, attitude control and an outer loop: a landing.
    All,
}

struct World {
    vehicle: RigidVehicle,
    cascade: Cascade,
    deck: RigidDeck,
    wind: WindSettings,
}

fn descend(world: &World, what: What) -> [f64; 3] {
    let World {
        vehicle,
        cascade,
        deck,
        wind,
    } = world;
    let (mut state, throttle) = vehicle.balanced(0.8, &deck.at(0.0));
    let start = state;
    let mut wind = Wind::new(wind, STEP_S, 1, 0).expect("valid settings");
    let stream = Stream::new(1, 0, Purpose::Turbulence);
    let mut turbulence = RotorTurbulence::new(stream, 0.15, STEP_S, [0.0; 4]);
    let (mut control, mut sent) = (CascadeState::default(), [throttle; 4]);
    let mut wanted = AttitudeSetpoint {
        thrust_n: 13.44,
        attitude: state.attitude,
        yaw_rate: 0.0,
        body_rates: None,
    };
    let (mut disturbance, mut log) = (Disturbance::default(), ContactLog::default());
    let mut pose = deck.at(0.0);
    for step in 0..STEPS {
        let t = f64::from(step) * STEP_S;
        let poses = if what == What::Vehicle {
            [DeckPose::default(); 3]
        } else {
            [pose, deck.at(t + 0.5 * STEP_S), deck.at(t + STEP_S)]
        };
        pose = poses[2];
        if what == What::All {
            if step % 10 == 0 {
                // From 0.8 m down onto the deck, above its centre; without an integral or a model
                // of ground effect the reference has to go below the deck.
                let height = 0.8 - 0.12 * t;
                let pull = |k: usize, up: f64| {
                    let error = state.position_m[k] - poses[0].origin_m[k] - up;
                    let rate = state.velocity_mps[k] - poses[0].velocity_mps[k];
                    (-3.0 * error - 3.0 * rate).clamp(-4.0, 4.0)
                };
                let (ax, ay, az) = (pull(0, 0.0), pull(1, 0.0), pull(2, height));
                let (pitch, roll) = (0.5 * ax / 9.81, -0.5 * ay / 9.81);
                wanted.thrust_n = 1.37 * (9.81 + az);
                wanted.attitude = [1.0, roll, pitch, 0.0];
            }
            if step % 2 == 0 {
                let (q, w) = (state.attitude, state.rates);
                sent = cascade.step(&mut control, q, w, &wanted).throttle;
            }
        }
        let loads = vehicle.step(&mut state, &poses, &sent, &disturbance, STEP_S);
        if what == What::Air || what == What::All {
            let roots = &state.rotors.root_thrust;
            let sd = vehicle.rotors().turbulence_sd_n(roots, &loads.target);
            disturbance.turbulence_n = turbulence.step(sd);
            wind.step();
            disturbance.wind_mps = wind.velocity_mps();
        }
        if what == What::All {
            vehicle.log_contact(&mut log, t + STEP_S, &state, &poses[2]);
        } else {
            // Without a pilot: held in place.
            (state.position_m, state.velocity_mps) = (start.position_m, start.velocity_mps);
            (state.attitude, state.rates) = (start.attitude, start.rates);
        }
    }
    assert!(state.is_finite());
    if what == What::All {
        assert!(log.first_touch_s.is_some(), "it lands: {log:?}");
    }
    state.position_m
}

fn main() {
    let clock = Instant::now();
    let plant = PlantSettings::default();
    let vehicle = RigidVehicle::new(&plant, &BodySettings::default())
        .and_then(|v| v.with_legs(&LegSettings::default(), &plant))
        .expect("defaults are valid");
    let cascade = Cascade::new(&CascadeSettings::default(), &vehicle).expect("valid settings");
    let sea = RigidMotion::Sea(SeaSettings::default());
    let deck = sea.build(9.81, 1, 0).expect("valid settings");
    let world = World {
        vehicle,
        cascade,
        deck: deck.splined(0.0, 10.1, 0.1).expect("valid times"),
        wind: WindSettings {
            steady_mps: [1.0, 0.0, 0.0],
            dryden: DrydenSettings::low_altitude(6.0, 3.0).ok(),
            gust: None,
            airwake: None,
        },
    };
    let cases = [
        (What::Vehicle, "vehicle"),
        (What::Deck, "+ deck in a sea"),
        (What::Air, "+ turbulence and gusts"),
        (What::All, "+ legs and control: a landing"),
    ];
    println!("steps per second of processor time, in millions: best, median of {RUNS}");
    for (what, name) in cases {
        let mut rates: Vec<f64> = (0..RUNS)
            .map(|_| {
                let start = processor_s(clock);
                for _ in 0..DESCENTS {
                    black_box(descend(black_box(&world), what));
                }
                1e-6 * f64::from(DESCENTS * STEPS) / (processor_s(clock) - start)
            })
            .collect();
        rates.sort_by(f64::total_cmp);
        println!("{name:32} {:6.3} {:6.3}", rates[RUNS - 1], rates[RUNS / 2]);
    }
}
