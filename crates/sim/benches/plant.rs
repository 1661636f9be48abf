//! Steps per second of the plant, on the rig and in landings.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use touchdown_flight::types::Command;
use touchdown_sim::STEP_S;
use touchdown_sim::air::turbulence::RotorTurbulence;
use touchdown_sim::air::wind::{DrydenSettings, Wind, WindSettings};
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::plant::{Plant, PlantSettings};
use touchdown_sim::body::rigid::{Disturbance, RigidVehicle};
use touchdown_sim::body::vertical::VerticalVehicle;
use touchdown_sim::deck::DeckPoint;
use touchdown_sim::deck::rigid::{RigidMotion, SeaSettings};
use touchdown_sim::landing::vertical::LandingScenario;
use touchdown_sim::landing::vertical::land;
use touchdown_sim::random::{Purpose, Stream};
use touchdown_sim::rig::sets::{Extent, ground_effect_paper};
use touchdown_sim::rig::{RigSettings, run};

fn main() {
    divan::main();
}

/// The vertical vehicle alone: 10 000 Runge–Kutta steps above a still deck.
#[divan::bench]
fn vertical_steps(bencher: Bencher<'_, '_>) {
    let settings = PlantSettings::default();
    let plant = Plant::new(&settings).expect("defaults are valid");
    let vehicle = VerticalVehicle::new(plant, settings.mass_kg, 0.0);
    let deck = DeckPoint::default();
    let (start, throttle) = vehicle.balanced(0.3, deck);
    bencher.counter(ItemsCount::new(10_000_usize)).bench(|| {
        let mut state = black_box(start);
        for _ in 0..10_000 {
            vehicle.step(&mut state, &[deck; 3], throttle, 0.0, STEP_S);
        }
        state
    });
}

/// A whole landing of 40 s that never lands, with noise: 40 000 steps.
#[divan::bench(args = [false, true])]
fn landing_steps(bencher: Bencher<'_, '_>, oscillating: bool) {
    let scenario = if oscillating {
        LandingScenario::oscillating_deck()
    } else {
        LandingScenario::default()
    };
    let hover = scenario.nominal_start().expect("defaults are valid");
    bencher.counter(ItemsCount::new(40_000_usize)).bench(|| {
        let mut pilot = |m: &touchdown_flight::types::Measurement<f64>| Command {
            throttle: hover.throttle + 0.2 * (0.4 - m.height_m) - 0.2 * m.relative_velocity_mps,
            ..Command::default()
        };
        land(&scenario, 0, 1, &mut pilot, false)
    });
}

/// A rig trial of 60 s: 60 000 steps, with sensor and record.
#[divan::bench]
fn rig_steps(bencher: Bencher<'_, '_>) {
    let settings = RigSettings::default();
    let trial = ground_effect_paper(Extent::Quick).swap_remove(0);
    bencher
        .counter(ItemsCount::new(60_000_usize))
        .bench(|| run(&settings, &trial, 1));
}

/// A deck in a sea of 100 waves: 10 000 poses, wave by wave and as a spline.
#[divan::bench(args = [false, true])]
fn deck_poses(bencher: Bencher<'_, '_>, splined: bool) {
    let sea = RigidMotion::Sea(SeaSettings::default());
    let mut deck = sea.build(9.81, 1, 0).expect("defaults are valid");
    if splined {
        deck = deck.splined(0.0, 10.0, 0.1).expect("valid times");
    }
    bencher.counter(ItemsCount::new(10_000_usize)).bench(|| {
        for i in 0..10_000 {
            black_box(deck.at(black_box(0.001 * f64::from(i))));
        }
    });
}

/// The whole vehicle: 10 000 Runge–Kutta steps over a deck that heaves, rolls and pitches in a sea
/// (as a spline), with turbulence and Dryden gusts, the attitude held.
#[divan::bench(args = [false, true])]
fn rigid_steps(bencher: Bencher<'_, '_>, disturbed: bool) {
    let settings = PlantSettings::default();
    let vehicle = RigidVehicle::new(&settings, &BodySettings::default()).expect("valid");
    let sea = RigidMotion::Sea(SeaSettings::default());
    let deck = sea.build(9.81, 1, 0).expect("valid");
    let deck = deck.splined(0.0, 10.1, 0.1).expect("valid times");
    let wind = WindSettings {
        dryden: DrydenSettings::low_altitude(6.0, 4.0).ok(),
        ..WindSettings::default()
    };
    let (start, throttle) = vehicle.balanced(0.5, &deck.at(0.0));
    bencher.counter(ItemsCount::new(10_000_usize)).bench(|| {
        let mut state = black_box(start);
        let mut wind = Wind::new(&wind, STEP_S, 1, 0).expect("valid");
        let stream = Stream::new(1, 0, Purpose::Turbulence);
        let mut turbulence = RotorTurbulence::new(stream, 0.15, STEP_S, [0.01; 4]);
        let mut disturbance = Disturbance::default();
        let mut pose = deck.at(0.0);
        for step in 0..10_000 {
            let t = f64::from(step) * STEP_S;
            let poses = [pose, deck.at(t + 0.5 * STEP_S), deck.at(t + STEP_S)];
            pose = poses[2];
            let loads = vehicle.step(&mut state, &poses, &[throttle; 4], &disturbance, STEP_S);
            // Held in place: a flight without a pilot would leave.
            state.position_m = [0.1, 0.05, 0.6];
            state.attitude = start.attitude;
            (state.velocity_mps, state.rates) = ([0.0; 3], [0.0; 3]);
            if disturbed {
                let sd = vehicle
                    .rotors()
                    .turbulence_sd_n(&state.rotors.root_thrust, &loads.target);
                disturbance.turbulence_n = turbulence.step(sd);
                wind.step();
                disturbance.wind_mps = wind.velocity_mps();
            }
        }
        state
    });
}
