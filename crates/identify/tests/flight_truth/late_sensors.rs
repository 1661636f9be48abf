//! Accelerometers and ranges that are late.

use touchdown_identify::Origin;
use touchdown_identify::flights::{Flight, ground_effect};
use touchdown_identify::warning::Warning;

use super::settings_of;
use super::vertical::found::{Cell, QUANTITIES, identify};
use super::vertical::{Vehicle, fly};

#[test]
fn analytic_a_late_accelerometer_biases_no_number() {
    // Height and climb rate show a force before the accelerometer does.
    let vehicle = Vehicle {
        accelerometer_late_s: 0.015,
        ..Vehicle::default()
    };
    let found = match identify(&vehicle, 79_000, 3) {
        Cell::Found(found, _) => found,
        Cell::Refused(why) => panic!("{why}"),
    };
    let names = QUANTITIES.iter().chain([&"accelerometer latency"]);
    for ((name, truth), found) in names.zip(vehicle.truth()).zip(*found) {
        let found = found.unwrap_or_else(|| panic!("{name}: not identified"));
        let half = 0.5 * (found.ci95[1] - found.ci95[0]);
        // One in 400 intervals of three standard errors misses by chance; the seed is fixed.
        assert!(
            (found.value - truth).abs() < 1.5 * half,
            "{name}: {found:?}, truth {truth}"
        );
    }
}

#[test]
fn regress_a_long_latency_is_no_moving_ground() {
    // A log without stamps of the sensor. It passed for a ground that moves, with a climb damping of two to four times the truth,
    // and nothing warned of it.
    let vehicle = Vehicle {
        accelerometer_late_s: 0.05,
        ..Vehicle::default()
    };
    let all = settings_of(&vehicle);
    let log = Flight::of(&fly(&vehicle, 79_100), &all.flight).unwrap();
    let found = ground_effect(&[log], &all.flight).unwrap();
    assert!(found.noise.is_some_and(|n| n.ground.is_none()));
    let numbers = found.numbers();
    let of = |name: &str| numbers.iter().find(|n| n.name == name).unwrap().estimate;
    for (name, truth) in [
        ("accelerometer_latency", vehicle.accelerometer_late_s),
        ("damping", vehicle.damping_s_per_m),
        ("T_m", vehicle.motor_lag_s),
    ] {
        let (found, half) = (of(name), 0.5 * (of(name).ci95[1] - of(name).ci95[0]));
        // One in 400 intervals of three standard errors misses by chance; the seed is fixed.
        assert!(
            (found.value - truth).abs() < 1.5 * half,
            "{name}: {found:?}, truth {truth}"
        );
    }
    // A filter with as long a latency would bias them.
    let [late, range] = told(&found.card(&all, &Origin::default()).warnings);
    assert_eq!(
        [late, range],
        [found.fit.value("accelerometer_latency"), None]
    );
}

/// What a card says of late sensors (s): the accelerometer, the range.
pub(crate) fn told(warnings: &[Warning]) -> [Option<f64>; 2] {
    let mut late = [None; 2];
    for warning in warnings {
        match warning {
            Warning::AccelerometerLate { latency_s } => late[0] = Some(*latency_s),
            Warning::RangeLate { latency_s } => late[1] = Some(*latency_s),
            _ => {}
        }
    }
    late
}

#[test]
fn prop_late_sensors_are_warned_of_where_the_ground_may_move() {
    let said = |vehicle: Vehicle| {
        let all = settings_of(&vehicle);
        let log = Flight::of(&fly(&vehicle, 79_200), &all.flight).unwrap();
        let found = ground_effect(&[log], &all.flight).unwrap();
        assert!(found.noise.is_some_and(|n| n.ground.is_some()));
        told(&found.card(&all, &Origin::default()).warnings)
    };
    // That it is late is known, not how late: of one flight the motion of the ground takes a part, and 0.05 s are found as 0.032.
    let near =
        |found: Option<f64>, truth: f64| found.is_some_and(|s| (s / truth - 1.0).abs() < 0.5);
    let late = said(Vehicle {
        ground_mps: 0.05,
        accelerometer_late_s: 0.05,
        ..Vehicle::default()
    });
    assert!(near(late[0], 0.05) && late[1].is_none(), "{late:?}");
    // A range finder and its link take 0.02 to 0.05 s: no word of it. From 0.08 s on this autopilot cannot fly.
    let late_range = |range_late_s, ground_mps| {
        said(Vehicle {
            ground_mps,
            range_late_s,
            ..Vehicle::default()
        })
    };
    assert_eq!(late_range(0.04, 0.04), [None; 2]);
    let late = late_range(0.07, 0.0);
    assert!(late[0].is_none() && near(late[1], 0.07), "{late:?}");
}
