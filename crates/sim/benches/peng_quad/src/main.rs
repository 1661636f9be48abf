//! touchdown-sim and peng_quad on a landing of 10 s or what it takes, physics at 1 kHz, outer loop at
//! 100 Hz, one core: steps per second of processor time, best of several runs.

#[path = "../fetched/peng.rs"]
#[allow(dead_code, missing_docs)]
mod peng;

#[path = "../../common/mod.rs"]
mod common;

use std::hint::black_box;
use std::time::Instant;

use common::processor_s;
use nalgebra::Vector3;
use touchdown_sim::landing::space::{Batch, Case, SpaceLander, SpaceScenario};

const RUNS: usize = 9;

/// Descents of 10 s: PID of place at 100 Hz, PID of attitude at every step.
fn peng(descents: u32) -> u64 {
    let inertia = [3.04e-3, 0.0, 0.0, 0.0, 4.55e-3, 0.0, 0.0, 0.0, 2.82e-3];
    for _ in 0..descents {
        let mut quad = peng::Quadrotor::new(1e-3, 1.3, 9.81, 0.0, black_box(inertia))
            .expect("its own settings");
        quad.position = Vector3::new(0.1, -0.1, 0.8);
        let mut pid = peng::PIDController::new(
            [[7.1, 7.1, 11.9], [2.4, 2.4, 6.7], [0.0; 3]],
            [[1.5, 1.5, 1.0], [0.13, 0.13, 0.1], [0.0; 3]],
            [10.0; 3],
            [0.5; 3],
            1.3,
            9.81,
        );
        let (mut thrust, mut wanted) = (1.3 * 9.81, quad.orientation);
        for step in 0..10_000 {
            if step % 10 == 0 {
                let sink = 0.07;
                let place = Vector3::new(0.0, 0.0, 0.8 - sink * 1e-3 * step as f32);
                let speed = Vector3::new(0.0, 0.0, -sink);
                let (at, v) = (quad.position, quad.velocity);
                (thrust, wanted) = pid.compute_position_control(&place, &speed, 0.0, &at, &v, 0.01);
            }
            let (q, w) = (quad.orientation, quad.angular_velocity);
            let torque = pid.compute_attitude_control(&wanted, &q, &w, 1e-3);
            quad.update_dynamics_with_controls_rk4(thrust, &torque);
        }
        assert!((quad.position.z - 0.1).abs() < 0.05, "{}", quad.position.z);
        black_box(quad.position);
    }
    u64::from(descents) * 10_000
}

fn main() {
    let turbulent = Case::Paper.scenario();
    let scenario = SpaceScenario {
        turbulence: false,
        ..turbulent.clone()
    };
    let batch = Batch::new(&scenario).expect("a valid scenario");
    let lander = SpaceLander::new(&turbulent).expect("a valid scenario");
    let steps = |landings: Vec<touchdown_sim::landing::space::SpaceLanding>| -> u64 {
        landings.iter().map(|landing| landing.steps).sum()
    };
    let peng = || peng(20);
    let lanes = || steps(batch.land(0..256, 1).expect("a checked scenario"));
    let one = |trial| batch.land_one(trial, 1).expect("a checked scenario");
    let alone = || steps((0..32).map(one).collect());
    let whole = |trial| lander.land(trial, 1, false).expect("a checked scenario");
    let whole = || steps((0..12).map(whole).collect());
    let cases: [(&str, &dyn Fn() -> u64); 4] = [
        ("peng_quad 0.5.6 (f32, no motors, no ground effect)", &peng),
        ("touchdown-sim, by the lane, ideal sensors", &lanes),
        ("touchdown-sim, one at a time, ideal sensors", &alone),
        ("touchdown-sim, whole landings, turbulence", &whole),
    ];
    let start = Instant::now();
    let mut theirs = f64::NAN;
    println!("million steps per second of processor time, best of {RUNS}; over peng_quad");
    for (name, case) in cases {
        let run = |_| {
            let before = processor_s(start);
            let steps = case();
            1e-6 * steps as f64 / (processor_s(start) - before)
        };
        let best = (0..RUNS).map(run).fold(0.0, f64::max);
        if theirs.is_nan() {
            theirs = best;
        }
        println!("{name:52} {best:6.2} {:6.2}", best / theirs);
    }
}
