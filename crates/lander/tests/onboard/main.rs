//! The landing computer in flight: loss and return of what it sees, decks that move,
//! headings, delays.

#[path = "../common/mod.rs"]
mod common;
mod loop_delays;
mod memory;
mod watching;
mod world;

use touchdown_flight::Vector;
use touchdown_lander::computer::NormalReading;
use touchdown_lander::state_machine::{OperatorRequest, Phase, Reason};
use world::{DT, State, WEIGHT_N, World, computer};

#[test]
fn analytic_the_heading_of_the_start_is_kept() {
    let computer = computer();
    computer.validate().unwrap();
    for yaw_rad in [1.571, -2.5] {
        let mut state: State = computer.initial(World::throttle());
        let mut world = World::new(yaw_rad);
        let mut seen = [false; 3];
        for i in 0..1200 {
            // Broken off at half of the way.
            if world.height_m() < 0.45 {
                world.request = OperatorRequest::Abort;
            }
            let output = world.step(&computer, &mut state);
            seen[0] |= output.state_machine.phase == Phase::Descend;
            seen[1] |= output.state_machine.phase == Phase::GoAround;
            seen[2] |= output.target.is_some();
            if let Some(command) = output.command {
                // Rounding; turned about the vertical alone.
                let error = command.attitude.yaw_rad() - yaw_rad;
                assert!(error.abs() < 1e-2, "{i} {yaw_rad} {error}");
            }
        }
        assert_eq!(seen, [true; 3]);
    }
}

#[test]
fn analytic_a_touchdown_that_is_not_felt_for_a_step_keeps_the_thrust() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    let mut thrust_n = WEIGHT_N;
    let mut idle = 0;
    for i in 0..3000 {
        // Not felt for three steps of every ten at first, far from the 0.2 s of a bounce.
        world.contact = ((5..60).contains(&idle) && i % 10 < 3).then_some(false);
        let output = world.step(&computer, &mut state);
        if output.state_machine.phase == Phase::Disarmed {
            assert!(idle > 30, "{idle}");
            return;
        }
        let now_n = output.command.unwrap().thrust_n;
        if output.state_machine.phase == Phase::Touchdown {
            idle += 1;
            // Taken back or held, never raised.
            assert!(now_n <= thrust_n + 1e-9, "{i}: {thrust_n} to {now_n}");
        }
        thrust_n = now_n;
    }
    panic!("not landed: {:?}", state.phase());
}

#[test]
fn analytic_the_normal_of_the_deck_follows_in_its_time_constant() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    // The deck as a camera at 33 Hz sees it: level, then 0.2 rad.
    for i in 0..600 {
        let tilt = if i >= 200 { 0.2_f64 } else { 0.0 };
        let normal = Vector::new(tilt.sin(), 0.0, tilt.cos());
        let camera = computer.relative.tag.attitude;
        let output = world.step_with(&computer, &mut state, |sensed| {
            sensed.deck_normal = (i % 3 == 0).then_some(NormalReading {
                normal: camera.unrotate(normal),
                age_s: 0.0,
            });
        });
        if i == 199 {
            assert_eq!(output.state_machine.phase, Phase::Wait);
        }
        if i >= 200 && output.state_machine.reason == Some(Reason::Deck) {
            // 0.14 of 0.2 rad: -ln(0.3) of 0.2 s, at the next look.
            let after_s = DT * f64::from(i - 200);
            assert!((0.2..=0.27).contains(&after_s), "{after_s}");
            return;
        }
    }
    panic!("a deck of 0.2 rad was never too steep");
}
