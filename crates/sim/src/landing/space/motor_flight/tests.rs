//! Motor signals in, readings out; the release of deck and wind.

use super::*;
use crate::landing::space::{Case, FaultClock, FaultySensor, NanBurst, SpaceScenario};

const FIELD: [f64; 3] = [0.0, 0.2, -0.4];

fn lander(scenario: &SpaceScenario) -> SpaceLander {
    SpaceLander::new(scenario).expect("a valid scenario")
}

#[test]
fn analytic_a_vehicle_with_stopped_motors_stands_on_a_deck_that_is_held_and_reports_its_weight() {
    let lander = lander(&Case::Paper.scenario());
    let mut flight = lander.motor_flight(0, 1, FIELD).unwrap();
    let deck = flight.truth().deck.origin_m;
    let (mut sum, mut fixes) = (0.0, 0);
    for step in 0..2000 {
        assert_eq!(flight.advance(MotorSignals::default()).unwrap(), None);
        if step >= 1000 && step % 4 == 0 {
            let readings = flight.take_readings();
            sum += readings.specific_force_mps2.expect("no fault")[2];
            fixes += usize::from(readings.gnss.is_some());
        }
    }
    // White noise of 0.24 m/s² in 250 samples, and a bias with a standard deviation of 0.03 m/s²: four of them.
    assert!((sum / 250.0 - 9.81).abs() < 0.14, "{}", sum / 250.0);
    // Ten a second.
    assert!((9..=11).contains(&fixes), "{fixes}");
    let truth = flight.truth();
    assert_eq!(truth.deck.origin_m, deck);
    let feet_n: f64 = truth.feet_n.iter().sum();
    // At rest to a hundredth of its weight after 2 s.
    assert!((feet_n / (1.37 * 9.81) - 1.0).abs() < 0.01, "{feet_n}");
    flight.release_deck();
    for _ in 0..1500 {
        flight.advance(MotorSignals::default()).unwrap();
    }
    assert_ne!(flight.truth().deck.origin_m, deck);
}

#[test]
fn analytic_the_wind_rises_with_the_deck_that_is_released() {
    let mut scenario = Case::Still.scenario();
    scenario.wind.steady_mps = [6.0, 0.0, 0.0];
    let lander = lander(&scenario);
    let mut flight = lander.motor_flight(0, 1, FIELD).unwrap();
    let wind_after = |flight: &mut MotorFlight<'_>, steps| {
        for _ in 0..steps {
            flight.advance(MotorSignals::default()).unwrap();
        }
        flight.truth().wind_mps[0]
    };
    assert_eq!(flight.truth().wind_mps, [0.0; 3]);
    assert_eq!(wind_after(&mut flight, 500), 0.0);
    flight.release_deck();
    // The share 3u² − 2u³ at u = 1/4, 1/2, 1 of 2 s, up to rounding.
    for (share, steps) in [(0.15625, 500), (0.5, 500), (1.0, 1000), (1.0, 500)] {
        let wind_mps = wind_after(&mut flight, steps);
        assert!((wind_mps - 6.0 * share).abs() < 1e-12, "{wind_mps}");
    }
}

#[test]
fn prop_a_gust_begins_after_the_release_of_the_deck() {
    let mut scenario = Case::Still.scenario();
    scenario.wind.gust = Some(crate::air::wind::GustSettings {
        velocity_mps: [0.0, 4.0, 0.0],
        start_s: 2.5,
        rise_s: 0.5,
        hold_s: 1.0,
    });
    let lander = lander(&scenario);
    let mut flight = lander.motor_flight(0, 1, FIELD).unwrap();
    let mut gusts = [0.0_f64; 2];
    for (gust, seconds) in gusts.iter_mut().zip([4, 4]) {
        for _ in 0..seconds * 1000 {
            flight.advance(MotorSignals::default()).unwrap();
            *gust = gust.max(flight.truth().wind_mps[1]);
        }
        flight.release_deck();
    }
    // In calm air first, then of its full speed, up to rounding.
    assert_eq!(gusts[0], 0.0);
    assert!((gusts[1] - 4.0).abs() < 1e-9, "{gusts:?}");
}

#[test]
fn prop_a_sensor_that_gives_no_number_reports_nothing() {
    let mut scenario = Case::Still.scenario();
    scenario.faults.since = FaultClock::Start;
    let burst = |sensor| NanBurst {
        sensor,
        from_s: 0.5,
        to_s: 9.0,
    };
    scenario.faults.nan = [FaultySensor::Gnss, FaultySensor::Imu, FaultySensor::Range]
        .map(burst)
        .to_vec();
    let lander = lander(&scenario);
    let mut flight = lander.motor_flight(0, 1, FIELD).unwrap();
    flight.release_deck();
    let count = |flight: &mut MotorFlight<'_>| {
        let mut counts = [0; 4];
        for _ in 0..400 {
            flight.advance(MotorSignals::default()).unwrap();
            let readings = flight.take_readings();
            for (count, some) in counts.iter_mut().zip([
                readings.gnss.is_some(),
                readings.specific_force_mps2.is_some(),
                readings.range_m.is_some(),
                readings.barometer_m.is_some(),
            ]) {
                *count += usize::from(some);
            }
        }
        counts
    };
    assert!(count(&mut flight).iter().all(|count| *count > 0));
    // Readings that were under way arrive, up to 0.11 s late.
    for _ in 0..300 {
        flight.advance(MotorSignals::default()).unwrap();
    }
    flight.take_readings();
    let [gnss, imu, range, barometer] = count(&mut flight);
    assert_eq!([gnss, imu, range], [0; 3]);
    assert!(barometer > 0);
}

#[test]
fn prop_a_fall_onto_the_deck_is_judged_by_its_speed() {
    let lander = lander(&Case::Still.scenario().without_noise());
    let mut flight = lander.motor_flight(0, 1, FIELD).unwrap();
    let mut peak_m = 0.0_f64;
    // Twice the weight for 0.4 s.
    for step in 0..4000 {
        // Idling rotors: stopped ones in the air end the landing.
        let signal = if step < 400 { 0.9 } else { 0.03 };
        if step == 400 {
            flight.begin_descent();
        }
        let outcome = flight.advance(MotorSignals([signal; 4])).unwrap();
        peak_m = peak_m.max(flight.truth().relative_m[2]);
        if let Some(outcome) = outcome {
            assert!(outcome.crashed(), "{outcome:?} from {peak_m} m");
            assert!(flight.has_touched());
            let flown = flight.finish(outcome);
            let touch = flown.landing.touch.unwrap();
            // It fell from its peak, with rotors that take 0.1 s to stop.
            let free = (2.0 * 9.81 * (peak_m - 0.1)).sqrt();
            assert!(
                (0.5 * free..free).contains(&touch.v_l_mps),
                "{touch:?} {free}"
            );
            return;
        }
    }
    panic!("it never came down");
}
