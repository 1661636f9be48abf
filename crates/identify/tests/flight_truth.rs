//! Ground effect from flights of an independent vehicle whose truth is known, with noise of the height.

mod common {
    pub mod vertical;
}

use common::vertical::{Cell, QUANTITIES, Vehicle, identify};

/// Identifies one set of six flights; every quantity has to be found, climb damping only with an accelerometer. Its interval
/// stretched by half has to hold the truth.
fn holds(vehicle: &Vehicle, seed: u64) {
    let found = match identify(vehicle, seed, 6) {
        Cell::Found(found) => found,
        Cell::Refused(why) => panic!("{why}"),
    };
    for ((name, truth), found) in QUANTITIES.iter().zip(vehicle.truth()).zip(*found) {
        if *name == "damping" && !vehicle.accelerometer {
            // Turbulence would pass for it.
            assert!(found.is_none(), "{name}: {found:?}");
            continue;
        }
        let Some(found) = found else {
            panic!("{name}: not identified");
        };
        let half = 0.5 * (found.ci95[1] - found.ci95[0]);
        // One in 400 intervals of three standard errors misses by chance; the seeds are fixed.
        assert!(
            (found.value - truth).abs() < 1.5 * half,
            "{name}: {found:?}, truth {truth}"
        );
        // An interval as wide as the number would hold anything; a lag is known least.
        assert!(half < 0.7 * truth, "{name}: {found:?}");
    }
}

#[test]
fn analytic_noise_of_the_range_biases_no_number() {
    let vehicle = Vehicle {
        range_noise_m: 0.004,
        range_hz: 50.0,
        ..Vehicle::default()
    };
    holds(&vehicle, 71_000);
}

#[test]
fn analytic_without_accelerometer_the_motion_tells_lift_and_lag() {
    let vehicle = Vehicle {
        accelerometer: false,
        range_noise_m: 0.004,
        range_hz: 25.0,
        ..Vehicle::default()
    };
    holds(&vehicle, 72_000);
}
