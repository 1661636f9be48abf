//! The guidance: what it orders for what is to be flown.

use touchdown_flight::reference::{Reference, Terminal};
use touchdown_flight::{Attitude, Real, Vector};
use touchdown_lander::guidance::{Guidance, GuidanceCommand};
use touchdown_lander::space_controller::{Motion, Target};
use touchdown_lander::state_machine::{Frame, Maneuver};

fn motion<R: Real>(height_m: f64) -> Motion<R> {
    let vector = |x, y, z| Vector::new(R::from_f64(x), R::from_f64(y), R::from_f64(z));
    Motion {
        position_m: vector(0.3, -0.1, height_m),
        relative_velocity_mps: vector(0.02, 0.01, -0.1),
        vehicle_velocity_mps: vector(0.05, -0.02, 0.2),
        acceleration_mps2: Vector::ZERO,
        attitude: Attitude::LEVEL,
        deck_normal: Vector::UP,
    }
}

fn target<R: Real>(order: GuidanceCommand<R>) -> Target<R> {
    match order {
        GuidanceCommand::Track(target) => target,
        other => panic!("no target: {other:?}"),
    }
}

const DECK: Maneuver<f64> = Maneuver::Hover {
    height_m: 0.8,
    frame: Frame::Deck,
};

fn plan(duration_s: f64) -> Reference<f64> {
    Reference::Terminal(Terminal {
        start_height_m: 0.8,
        end_height_m: 0.1,
        sink_rate_mps: 0.03,
        duration_s,
    })
}

#[test]
fn analytic_a_hover_is_reached_within_rates() {
    let guidance = Guidance::<f64>::default();
    guidance.validate().unwrap();
    for start in [0.2, 0.79, 3.0] {
        let mut state = guidance.initial();
        let mut at = motion(start);
        at.relative_velocity_mps.z = 0.0;
        let (mut z, mut v) = (start, 0.0);
        let mut time_s = 0.0;
        for i in 0..1000 {
            let order = guidance.step(&mut state, DECK, None, &at, Vector::ZERO, 0.01);
            let to = target(order);
            let point = to.vertical;
            assert_eq!(to.position_m, Vector::ZERO);
            assert!(point.velocity_mps.abs() <= 0.5 + 1e-12);
            // Braking on √(2 a s) in steps takes up to half as much again.
            assert!((point.velocity_mps - v).abs() <= 0.01 * (1.0 + 1e-9));
            assert!((point.height_m - z - 0.01 * point.velocity_mps).abs() < 1e-12);
            // Never beyond by more than a step's part.
            assert!((point.height_m - 0.8) * (start - 0.8) > -0.01);
            (z, v) = (point.height_m, point.velocity_mps);
            if (z - 0.8).abs() > 1e-3 {
                time_s = 0.01 * f64::from(i);
            }
        }
        assert!((z - 0.8).abs() < 1e-6 && v.abs() < 1e-4, "{start} {z} {v}");
        // Distance over rate, and rate over acceleration for both ends.
        let distance: f64 = f64::abs(start - 0.8);
        assert!(time_s < distance / 0.5 + 1.0, "{start} {time_s}");
    }
}

#[test]
fn analytic_the_way_to_a_hover_begins_at_no_more_than_twice_the_climb_rate() {
    let guidance = Guidance::<f64>::default();
    for (estimated_mps, begins_mps) in [(-1.8, -1.0), (-0.4, -0.4), (2.5, 1.0)] {
        let mut at = motion(0.8);
        at.relative_velocity_mps.z = estimated_mps;
        let order = guidance.step(&mut guidance.initial(), DECK, None, &at, Vector::ZERO, 0.01);
        let change: f64 = target(order).vertical.velocity_mps - begins_mps;
        // One step at 1 m/s².
        assert!(change.abs() <= 0.01 + 1e-12, "{estimated_mps} {change}");
    }
}

#[test]
fn analytic_the_plan_is_followed_with_its_delays_and_pressed_on() {
    let guidance = Guidance::<f64>::default();
    let mut state = guidance.initial();
    let deck = Vector::new(0.0, 0.0, 0.4);
    for i in 0..1500 {
        // What the planner says later does not matter.
        let said = plan(2.5 + 0.01 * f64::from(i));
        let fly = if i < 150 {
            Maneuver::Descend
        } else {
            Maneuver::Commit
        };
        let order = guidance.step(&mut state, fly, Some(&said), &motion(0.5), deck, 0.01);
        let to = target(order);
        let t = 0.01 * f64::from(i);
        let (sensed, acting) = (plan(2.5).at(t - 0.02), plan(2.5).at(t + 0.04));
        // A clock of hundreds of roundings.
        let lowest = sensed.height_m.max(0.1 - 0.15);
        assert!((to.vertical.height_m - lowest).abs() < 1e-12);
        assert!((to.vertical.velocity_mps - sensed.velocity_mps).abs() < 1e-12);
        assert!((to.vertical.acceleration_mps2 - acting.acceleration_mps2).abs() < 1e-12);
        assert_eq!(to.deck_acceleration_mps2, deck);
    }
    // A new descent takes the new plan; without one it holds its height.
    guidance.step(&mut state, DECK, None, &motion(0.5), deck, 0.01);
    let order = guidance.step(
        &mut state,
        Maneuver::Descend,
        None,
        &motion(0.5),
        deck,
        0.01,
    );
    assert!(target(order).vertical.velocity_mps.abs() < 0.2);
    let order = guidance.step(
        &mut state,
        Maneuver::Descend,
        Some(&plan(2.5)),
        &motion(0.5),
        deck,
        0.01,
    );
    assert_eq!(target(order).vertical.height_m, 0.8);
}

#[test]
fn analytic_in_the_world_only_velocities_count() {
    let guidance = Guidance::<f64>::default();
    let world = Maneuver::Hover {
        height_m: 0.8,
        frame: Frame::World,
    };
    // Speeds, and how fast they are taken up.
    for (fly, wanted, rate) in [(world, 0.0, 1.0), (Maneuver::ClimbAway, 0.5, 3.0)] {
        let mut state = guidance.initial();
        let mut climb = 0.2;
        for i in 0..200 {
            // The deck and the place are anything.
            let mut at = motion(0.5);
            at.position_m.z += f64::from(i % 7);
            at.relative_velocity_mps.z -= f64::from(i % 5);
            let deck = Vector::new(9.0, 9.0, 9.0);
            let to = target(guidance.step(&mut state, fly, None, &at, deck, 0.01));
            // What the controller's law sees: no error of place ...
            assert_eq!(to.position_m, at.position_m);
            assert_eq!(to.vertical.height_m, at.position_m.z);
            // ... and v - v_ref = v_q - climb, whatever the deck.
            let error = at.relative_velocity_mps.z - to.vertical.velocity_mps;
            let before = climb;
            climb = f64::clamp(wanted, climb - 0.01 * rate, climb + 0.01 * rate);
            assert!((error - (0.2 - climb)).abs() < 1e-12, "{i}");
            let ahead = to.vertical.acceleration_mps2;
            assert!(
                (ahead - (climb - before) / 0.01).abs() < 1e-9,
                "{i} {ahead}"
            );
            let side = (at.relative_velocity_mps - to.velocity_mps).horizontal();
            assert!((side - at.vehicle_velocity_mps.horizontal()).norm() < 1e-15);
            assert_eq!(to.deck_acceleration_mps2, Vector::ZERO);
        }
        assert!((climb - wanted).abs() < 1e-12);
    }
}

#[test]
fn analytic_idle_and_off() {
    let guidance = Guidance::<f32>::default();
    let mut state = guidance.initial();
    let at = motion(0.1);
    let order = guidance.step(&mut state, Maneuver::Idle, None, &at, Vector::ZERO, 0.01);
    assert_eq!(order, GuidanceCommand::Idle { rate_n_per_s: 40.0 });
    let order = guidance.step(&mut state, Maneuver::Disarm, None, &at, Vector::ZERO, 0.01);
    assert_eq!(order, GuidanceCommand::Off);
    let bad = Guidance::<f32> {
        climb_mps: f32::NAN,
        ..guidance
    };
    let error = bad.validate().unwrap_err().to_string();
    assert!(error.starts_with("guidance.climb_mps"), "{error}");
}
