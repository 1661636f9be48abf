//! What the computer keeps of readings, and of itself while it cannot see.

use touchdown_flight::Vector;
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuSample, RangeReading, Reading, RelativeFilter, RelativeState,
};
use touchdown_lander::state_machine::{OperatorRequest, Phase};

use crate::world::{DT, GRAVITY, Rate, State, WEIGHT_N, World, computer};

fn still() -> ImuSample<f64> {
    ImuSample {
        specific_force_mps2: Vector::UP * GRAVITY,
        attitude: touchdown_flight::Attitude::LEVEL,
    }
}

#[test]
fn prop_stamps_of_the_future_are_refused_and_block_nothing() {
    let filter = RelativeFilter::<f64>::default();
    let mut state: RelativeState<f64> = filter.initial();
    let gnss = |age_s| {
        Reading::Gnss(GnssVelocity {
            velocity_mps: Vector::ZERO,
            age_s,
        })
    };
    // Two seconds of a clock that is ahead, by any amount.
    for i in 0..200 {
        let age_s = [-1000.0, -0.5, -1e9, -0.02][i % 4];
        filter.step(&mut state, &still(), &[gnss(age_s)], DT);
    }
    assert_eq!(filter.health(&state).gnss.used, 0);
    assert_eq!(filter.health(&state).gnss.unusable, 200);
    for _ in 0..100 {
        let readings = [Reading::Range(RangeReading::level(0.8, 0.0)), gnss(0.0)];
        filter.step(&mut state, &still(), &readings, DT);
    }
    let health = filter.health(&state);
    assert_eq!([health.gnss.used, health.range.used], [100, 100]);
    assert!(!health.diverged);
}

#[test]
fn prop_readings_at_high_rates_are_all_used() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    let rate = |every, age| Some(Rate { every, age });
    world.range = rate(1, 2);
    world.tag = rate(3, 4);
    world.gnss = rate(20, 20);
    world.barometer = rate(2, 3);
    world.request = OperatorRequest::Abort;
    let mut health = None;
    for _ in 0..2000 {
        health = Some(world.step(&computer, &mut state).health);
    }
    let health = health.unwrap();
    // But for those that would be older than the world.
    assert!(health.range.used >= 1990, "{:?}", health.range);
    assert!(health.tag.used >= 660, "{:?}", health.tag);
    assert!(health.gnss.used >= 98, "{:?}", health.gnss);
}

#[test]
fn prop_many_readings_in_one_step_are_all_used() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    world.request = OperatorRequest::Abort;
    let mut used = [0; 2];
    for i in 0..1000 {
        let output = world.step_with(&computer, &mut state, |sensed| {
            // A range finder of 200 Hz that is asked ten times a second.
            let range = |k: u32| Reading::Range(RangeReading::level(0.8, 0.005 * f64::from(k)));
            let count = if i % 10 == 0 { 20 } else { 0 };
            let mut readings: Vec<_> = (0..count).rev().map(range).collect();
            readings.extend_from_slice(sensed.readings);
            // Outlives the step, which is all that is asked for.
            sensed.readings = Box::leak(readings.into_boxed_slice());
        });
        used = [output.health.range.used, output.health.tag.used];
    }
    // 2000 and the world's own 500, but for those from before the start; the tag's 333 come last
    // in every step.
    assert!(used[0] >= 2480 && used[1] >= 330, "{used:?}");
}

#[test]
fn analytic_models_go_on_while_it_hovers_unseeing() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    // Rotors that give less than they should: in control, more is asked for.
    world.thrust_scale = 0.9;
    world.request = OperatorRequest::Abort;
    for _ in 0..300 {
        world.step(&computer, &mut state);
    }
    let modelled = |state: &State| state.vertical().unwrap().thrust.thrust_n();
    // Within what still swings.
    assert!((modelled(&state) - WEIGHT_N / 0.9).abs() < 0.3);
    (world.range, world.tag, world.gnss) = (None, None, None);
    let mut blind = 0;
    for _ in 0..4000 {
        let output = world.step(&computer, &mut state);
        blind = if output.target.is_none() {
            blind + 1
        } else {
            0
        };
        if blind == 60 {
            // Ten time constants after: what is sent now.
            let sent_n = output.command.unwrap().thrust_n;
            assert!((modelled(&state) - sent_n).abs() < 1e-2);
            // The mean of what held it, which swung in the first second.
            assert!((sent_n - WEIGHT_N / 0.9).abs() < 0.3, "{sent_n}");
            return;
        }
    }
    panic!("in control without any reading for 40 s");
}

#[test]
fn analytic_a_restart_in_a_go_around_goes_on_climbing() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    let mut descended = 0;
    for i in 0..2000 {
        let output = world.step_with(&computer, &mut state, |sensed| {
            if descended > 60 {
                // The deck seems to be two metres lower from one step to the next.
                let moved = sensed.readings.iter().map(|reading| match *reading {
                    Reading::Range(range) => Reading::Range(RangeReading {
                        distance_m: range.distance_m + 2.0,
                        ..range
                    }),
                    Reading::Tag(mut tag) => {
                        let camera = computer.relative.tag.attitude;
                        tag.position_m += camera.unrotate(Vector::UP * -2.0);
                        Reading::Tag(tag)
                    }
                    other => other,
                });
                sensed.readings = Box::leak(moved.collect::<Vec<_>>().into_boxed_slice());
            }
        });
        descended += usize::from(output.state_machine.phase == Phase::Descend);
        if output.state_machine.phase == Phase::GoAround {
            assert!(output.target.is_some(), "{i} hovers");
            let slow = output.estimate.velocity_mps - world.velocity_mps;
            assert!(slow.norm() < 0.3, "{i} {slow:?}");
        }
        if descended > 60 && output.state_machine.phase == Phase::Approach {
            // Found anew, two metres higher.
            assert!(output.estimate.height_m() > 2.0);
            return;
        }
    }
    panic!("no new approach: {:?}", state.phase());
}
