//! Settings of whole landings that have to fit each other.

use touchdown_sim::STEP_S;
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::contact::LegSettings;
use touchdown_sim::body::plant::{PlantSettings, Surface};
use touchdown_sim::body::rigid::{Disturbance, RigidState, RigidVehicle};
use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::landing::space::{SpaceLander, SpaceScenario, WeakRotor, land};

type Change = fn(&mut SpaceScenario);

fn changed(change: Change) -> SpaceScenario {
    let mut scenario = SpaceScenario::default();
    change(&mut scenario);
    scenario
}

fn refused(change: Change, words: &[&str]) {
    let error = SpaceLander::new(&changed(change)).map(|_| ()).unwrap_err();
    let error = error.to_string();
    for word in words {
        assert!(error.contains(word), "{word}: {error}");
    }
}

fn taken(change: Change) {
    if let Err(error) = SpaceLander::new(&changed(change)) {
        panic!("{error}");
    }
}

#[test]
fn prop_the_cameras_turn_changes_nothing_but_the_image() {
    let lateral_m = |turn_rad: f64| {
        let mut scenario = SpaceScenario::default().without_noise();
        scenario.start_m = [0.2, -0.1, 0.8];
        scenario.sensors.tag.camera.turn_rad = turn_rad;
        let landing = land(&scenario, 0, 1).unwrap();
        assert!(landing.outcome.landed(), "{turn_rad}: {landing:?}");
        landing.touch.unwrap().lateral_m
    };
    let straight = lateral_m(0.0);
    for turn_rad in [0.4, 1.2, 3.0, -1.6] {
        // Rounding, but for when the centre comes into view.
        let turned = lateral_m(turn_rad);
        assert!(
            (turned - straight).abs() < 1e-3,
            "{turn_rad}: {turned} {straight}"
        );
    }
}

#[test]
fn regress_a_true_vehicle_that_is_none_is_named_by_its_ratio() {
    let lifts = "below 0.0209 kg, the mass that full throttle lifts";
    refused(
        |s| s.truth.thrust = 0.01,
        &["`truth.thrust`", "true `plant.mass_kg`", lifts],
    );
    refused(
        |s| s.truth.mass = 100.0,
        &["`truth.mass`", "true `plant.mass_kg`", "found 137"],
    );
    refused(
        |s| s.truth.arm = 0.1,
        &["`truth.arm`", "true `plant.rotor_spacing_m`"],
    );
    // The stated vehicle is wrong itself.
    refused(
        |s| (s.truth.mass, s.plant.mass_kg) = (1.1, 50.0),
        &["setting `plant.mass_kg`", "found 50"],
    );
}

#[test]
fn prop_images_that_nothing_was_fitted_to_are_refused() {
    let camera = "sensors.tag.camera";
    refused(
        |s| s.sensors.tag.camera.lens_sd_px = 3.0,
        &[camera, "lens_sd_px", "0.6", "found 3"],
    );
    refused(
        |s| s.sensors.tag.camera.noise_sd = 20.0,
        &[camera, "noise_sd", "found 20"],
    );
    refused(
        |s| s.sensors.tag.camera.white_level = 60.0,
        &[camera, "white_level", "220", "found 60"],
    );
    refused(
        |s| s.sensors.tag.camera.gradient[1] = 0.5,
        &[camera, "gradient", "found 0.5"],
    );
    // What the errors follow from by geometry is free.
    taken(|s| s.sensors.tag.camera.focal_px = [300.0; 2]);
}

#[test]
fn prop_tags_lie_on_the_plate_that_is_there() {
    refused(
        |s| s.plant.plate_side_m = 0.45,
        &["sensors.tag.sizes_m", "0.45 m", "found 0.4"],
    );
    taken(|s| s.plant.plate_side_m = 0.5);
    refused(
        |s| s.sensors.tag.sizes_m = vec![1.3],
        &["sensors.tag.sizes_m", "1.5 m", "found 1.3"],
    );
    taken(|s| {
        s.plant.plate_side_m = 2.0;
        s.sensors.tag.sizes_m = vec![1.3];
    });
    // The ground has no edge.
    taken(|s| {
        s.plant.surface = Surface::Ground;
        s.sensors.tag.sizes_m = vec![1.3];
    });
}

#[test]
fn prop_feet_find_room_on_the_plate_that_is_there() {
    // Corners of a square at 0.15 m from its centre: its sides are 0.212 m.
    let narrow: Change = |s| {
        s.plant.plate_side_m = 0.21;
        s.sensors.tag.sizes_m = vec![0.1];
    };
    let words = [
        "legs.radius_m",
        "plant.plate_side_m",
        "0.21",
        "0.148",
        "found 0.15",
    ];
    refused(narrow, &words);
    taken(|s| {
        s.plant.plate_side_m = 0.213;
        s.sensors.tag.sizes_m = vec![0.1];
    });
    // The ground has no edge.
    taken(|s| {
        s.plant.surface = Surface::Ground;
        s.plant.plate_side_m = 0.21;
    });
}

#[test]
fn prop_a_fault_takes_thrust_and_gives_none() {
    refused(
        |s| {
            s.faults.rotor = Some(WeakRotor {
                rotor: 0,
                share: 1.5,
                from_s: 0.0,
            });
        },
        &["`faults.rotor.share`", "found 1.5"],
    );
}

#[test]
fn prop_beliefs_that_are_refused_have_the_keys_of_the_scenario() {
    refused(
        |s| s.believed.mass_kg = Some(3.0),
        &["`believed.mass_kg`", "full throttle", "found 3"],
    );
    refused(
        |s| s.believed.torque_per_thrust_m = Some(-1.0),
        &["`believed.torque_per_thrust_m`", "found -1"],
    );
}

#[test]
fn prop_legs_that_do_not_carry_or_shake_apart_are_refused() {
    refused(
        |s| s.legs.stiffness_n_per_m = 60.0,
        &["legs.stiffness_n_per_m", "at least 134.4", "found 60"],
    );
    refused(
        |s| s.legs.stiffness_n_per_m = 3e6,
        &["legs.stiffness_n_per_m", "at most", "found 3000000"],
    );
    refused(
        |s| s.legs.damping_ns_per_m = 1e3,
        &["legs.damping_ns_per_m", "1000"],
    );
    refused(
        |s| s.legs.tangential_stiffness_n_per_m = 3e6,
        &["legs.tangential_stiffness_n_per_m", "3000000"],
    );
    refused(
        |s| s.legs.tangential_damping_ns_per_m = 1e3,
        &["legs.tangential_damping_ns_per_m", "1000"],
    );
    // A light vehicle is shaken by what a heavy one stands on.
    refused(
        |s| s.body.inertia_kg_m2 = [1e-5, 1e-5, 2e-5],
        &["legs.stiffness_n_per_m", "at most", "found 2000"],
    );
}

/// The vehicle dropped from a centimetre, tilted, with its rotors off: its greatest speed in the
/// last of two seconds, and its height at the end.
fn dropped(legs: &LegSettings) -> (f64, f64) {
    let plant = PlantSettings::default();
    let vehicle = RigidVehicle::new(&plant, &BodySettings::default()).unwrap();
    let vehicle = vehicle.with_legs(legs, &plant).unwrap();
    let mut state = RigidState {
        position_m: [0.0, 0.0, 0.13],
        attitude: [0.0025_f64.cos(), 0.0025_f64.sin(), 0.0, 0.0],
        velocity_mps: [0.05, 0.0, 0.0],
        ..RigidState::default()
    };
    let mut fastest: f64 = 0.0;
    for step in 0..2000 {
        let deck = [DeckPose::default(); 3];
        vehicle.step(
            &mut state,
            &deck,
            &[0.0; 4],
            &Disturbance::default(),
            STEP_S,
        );
        if step > 1000 {
            let speed: f64 = state.velocity_mps.iter().map(|v| v * v).sum();
            fastest = fastest.max(speed.sqrt());
        }
    }
    (fastest, state.position_m[2])
}

#[test]
fn prop_legs_at_the_limits_come_to_rest() {
    let limit = |change: Change| {
        let error = SpaceLander::new(&changed(change))
            .map(|_| ())
            .unwrap_err()
            .to_string();
        let number = error
            .split(" most ")
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap();
        number.parse::<f64>().unwrap()
    };
    let stiff = LegSettings {
        stiffness_n_per_m: limit(|s| s.legs.stiffness_n_per_m = 1e9),
        damping_ns_per_m: limit(|s| s.legs.damping_ns_per_m = 1e9),
        tangential_stiffness_n_per_m: limit(|s| s.legs.tangential_stiffness_n_per_m = 1e9),
        tangential_damping_ns_per_m: limit(|s| s.legs.tangential_damping_ns_per_m = 1e9),
        ..LegSettings::default()
    };
    let (fastest, height_m) = dropped(&stiff);
    // At rest: no force that swings from step to step.
    assert!(fastest < 1e-3, "{fastest} m/s");
    assert!((height_m - 0.1).abs() < 1e-3, "{height_m} m");
    // Four times beyond all of them it does not.
    let beyond = LegSettings {
        stiffness_n_per_m: 4.0 * stiff.stiffness_n_per_m,
        damping_ns_per_m: 4.0 * stiff.damping_ns_per_m,
        tangential_stiffness_n_per_m: 4.0 * stiff.tangential_stiffness_n_per_m,
        tangential_damping_ns_per_m: 4.0 * stiff.tangential_damping_ns_per_m,
        ..stiff
    };
    let (fastest, _) = dropped(&beyond);
    assert!(!(fastest < 1e-2), "{fastest} m/s");
}

#[test]
fn prop_heights_are_those_of_a_vehicle_on_its_legs() {
    refused(
        |s| s.legs.depth_m = 0.12,
        &["landed_height_m", "0.12", "found 0.1"],
    );
    refused(
        |s| (s.legs.depth_m, s.landed_height_m) = (0.109, 0.109),
        &["control.lander.touchdown_height_m", "0.109", "found 0.108"],
    );
    refused(
        |s| {
            (s.legs.depth_m, s.landed_height_m) = (0.12, 0.12);
            s.control.state_machine.touchdown_height_m = 0.128;
        },
        &["control.contact_height_m", "0.12", "found 0.11"],
    );
    refused(
        |s| {
            (s.legs.depth_m, s.landed_height_m) = (0.12, 0.12);
            s.control.state_machine.touchdown_height_m = 0.128;
            s.control.contact_height_m = 0.13;
        },
        &[
            "control.planning.descent.end_height_m",
            "0.12",
            "found 0.11",
        ],
    );
    // All of them moved, longer legs land.
    let scenario = changed(|s| {
        (s.legs.depth_m, s.landed_height_m) = (0.15, 0.15);
        s.control.state_machine.touchdown_height_m = 0.158;
        s.control.contact_height_m = 0.16;
        s.control.planning.descent.end_height_m = 0.16;
    });
    let landing = land(&scenario.without_noise(), 0, 1).unwrap();
    assert!(landing.outcome.landed(), "{landing:?}");
}
