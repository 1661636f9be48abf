//! Routes to the ground effect check one another, on flights of independent vehicles whose truth is known.

mod common {
    pub mod vertical;
}

use common::vertical::{Vehicle, another, fly, thrust_card};
use touchdown_identify::flights::hover::ThrustLaw;
use touchdown_identify::flights::{Basis, FlightSettings, Route, Routed, ground_effect_by_routes};
use touchdown_model::Card;
use touchdown_trial::Trial;

const SPEED: Basis = Basis::Hovers {
    law: ThrustLaw::RotorSpeed,
};
const CARD: Basis = Basis::Hovers {
    law: ThrustLaw::Card,
};

/// Four flights with accelerometer and rotor speed; the accelerometer's readings are multiplied by `scale`.
fn identify(vehicle: &Vehicle, seed: u64, scale: f64, card: Option<&Card>) -> Routed {
    let settings = FlightSettings {
        rotor_radius_m: Some(vehicle.rotor_radius_m),
        ..FlightSettings::default()
    };
    let trials: Vec<Trial> = (seed..seed + 4)
        .map(|seed| {
            let mut trial = fly(vehicle, seed);
            if let Some(force) = trial.channel("specific_force_mps2") {
                let force = force.iter().map(|f| scale * f).collect();
                trial.insert("specific_force_mps2", force).unwrap();
            }
            trial
        })
        .collect();
    let trials: Vec<&Trial> = trials.iter().collect();
    ground_effect_by_routes(&trials, &settings, card).unwrap()
}

fn vehicle() -> Vehicle {
    Vehicle {
        rotor_speed: true,
        ..Vehicle::default()
    }
}

/// The lifts of a route against the truth, each by its half interval.
fn errors(route: &Route, vehicle: &Vehicle) -> Vec<f64> {
    let truth = [0.5, 1.0, 2.0].into_iter().zip(vehicle.lifts(4.0));
    let found = route.extra_lift.iter().map(|at| {
        let truth = truth.clone().find(|(radii, _)| *radii == at.radii);
        let half = 0.5 * (at.lift.ci95[1] - at.lift.ci95[0]);
        (at.lift.value - truth.unwrap().1).abs() / half
    });
    found.collect()
}

#[test]
fn analytic_routes_that_are_right_agree_with_each_other_and_the_truth() {
    let vehicle = vehicle();
    let routed = identify(&vehicle, 81_000, 1.0, Some(&thrust_card(&vehicle)));
    let bases: Vec<Basis> = routed.routes.iter().map(|r| r.basis).collect();
    assert_eq!(bases, [Basis::Accelerometer, Basis::Poses, SPEED, CARD]);
    assert!(routed.warnings.is_empty(), "{:?}", routed.warnings);
    for route in &routed.routes {
        assert!(route.refused.is_none(), "{route:?}");
        let errors = errors(route, &vehicle);
        assert!(errors.len() >= 2, "{route:?}");
        // One in 400 intervals of three standard errors misses by chance; the seeds are fixed.
        assert!(errors.iter().all(|e| *e < 1.5), "{errors:?} {route:?}");
    }
}

#[test]
fn analytic_an_accelerometer_with_a_wrong_scale_is_named_and_does_not_move_the_lift() {
    let vehicle = vehicle();
    let routed = identify(&vehicle, 82_000, 1.1, None);
    let named = |f: &touchdown_identify::flights::Flight| {
        f.notes.iter().any(|n| n.to_string().contains("1.1"))
    };
    let by_force = identify_notes(&vehicle);
    assert!(by_force.iter().all(named));
    let taken = routed.routes.iter().find(|r| r.taken).unwrap();
    let errors = errors(taken, &vehicle);
    assert!(errors.iter().all(|e| *e < 1.5), "{errors:?} {taken:?}");
}

/// The flights with the wrong scale, as they are read.
fn identify_notes(vehicle: &Vehicle) -> Vec<touchdown_identify::flights::Flight> {
    let settings = FlightSettings::default();
    (82_000..82_002)
        .map(|seed| {
            let mut trial = fly(vehicle, seed);
            let force = trial.require("specific_force_mps2").unwrap();
            let force = force.iter().map(|f| 1.1 * f).collect();
            trial.insert("specific_force_mps2", force).unwrap();
            touchdown_identify::flights::Flight::of(&trial, &settings).unwrap()
        })
        .collect()
}

#[test]
fn analytic_a_thrust_card_of_another_vehicle_is_outvoted() {
    let vehicle = vehicle();
    let routed = identify(
        &vehicle,
        83_000,
        1.0,
        Some(&thrust_card(&another(&vehicle))),
    );
    let taken = routed.routes.iter().find(|r| r.taken).unwrap();
    assert_ne!(taken.basis, CARD);
    let errors = errors(taken, &vehicle);
    assert!(errors.iter().all(|e| *e < 1.5), "{errors:?} {taken:?}");
    let sentences: Vec<String> = routed.warnings.iter().map(ToString::to_string).collect();
    assert!(
        sentences.iter().any(|s| s.contains("thrust by the card")),
        "{sentences:?} {:?}",
        routed.routes
    );
}
