//! What each sensor sees, and where it is believed.

use touchdown_flight::Attitude;
use touchdown_lander::estimate::relative::{
    BarometerReading, BeaconReading, GnssVelocity, ImuModel, ImuSample, RangeReading, Reading,
    RelativeFilter, TagModel, TagReading,
};

use crate::truth::*;

#[test]
fn analytic_geometry_of_range_and_tag() {
    // One exact reading, tilted vehicle, tilted deck, mounted sensors.
    let mut filter = still(mounted());
    filter.range.direction = V::new(0.1, -0.05, -1.0).direction().unwrap();
    filter.imu.attitude_sd_rad = 0.0;
    let attitude = Attitude::from_rotation_vector(V::new(0.15, -0.1, 0.7));
    let position = V::new(0.12, -0.3, 1.1);
    let normal = V::new(0.04, -0.03, 1.0).direction().unwrap();
    let sensor = position + attitude.rotate(filter.range.position_m);
    let beam = attitude.rotate(filter.range.direction);
    let distance_m = -normal.dot(sensor) / normal.dot(beam);
    let body = attitude.unrotate(-position) - filter.tag.position_m;
    let mut state: State = filter.initial();
    let imu = ImuSample {
        specific_force_mps2: attitude.unrotate(V::UP * G),
        attitude,
    };
    let tag = Reading::Tag(TagReading {
        position_m: filter.tag.attitude.unrotate(body),
        covariance_m2: [[1e-12; 3]; 3],
        age_s: 0.0,
    });
    let estimate = filter.step(&mut state, &imu, &[tag], DT);
    // Prior 10 m against noise 2 mm: (2e-4)² of 1 m.
    assert!((estimate.position_m - position).norm() < 1e-7);
    // The range agrees: nothing moves.
    let range = Reading::Range(RangeReading {
        distance_m,
        deck_normal: normal,
        age_s: 0.0,
    });
    let mut alone: State = filter.initial();
    for reading in [[tag, range], [range, tag]] {
        let estimate = filter.step(&mut alone, &imu, &reading, 0.0);
        assert!((estimate.position_m - position).norm() < 1e-6);
    }
    let health = filter.health(&alone);
    // Had one disagreed, the gate would have left it out.
    assert_eq!((health.range.used, health.tag.used), (2, 2));
    // The camera looks down: image right is the body's right, image down its rear.
    let camera = TagModel::<f64>::looking_down();
    let down = camera.rotate(V::UP);
    assert!((down + V::UP).norm() < 1e-15);
    assert!((camera.rotate(V::new(1.0, 0.0, 0.0)) - V::new(0.0, -1.0, 0.0)).norm() < 1e-15);
}

#[test]
fn analytic_barometer_only_far_from_the_ground() {
    let filter = still(mounted());
    let imu = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    for (height, expected) in [(2.0, (0, 50)), (8.0, (50, 0))] {
        let mut state: State = filter.initial();
        for _ in 0..50 {
            let all = [
                Reading::Range(RangeReading::level(height, 0.0)),
                Reading::Barometer(BarometerReading {
                    altitude_m: 431.0,
                    age_s: 0.0,
                }),
            ];
            filter.step(&mut state, &imu, &all, DT);
        }
        let barometer = filter.health(&state).barometer;
        assert_eq!((barometer.used, barometer.unusable), expected);
    }
}

#[test]
fn analytic_zero_noise() {
    // Perfect sensors as the filter believes, nothing divides by zero.
    let mut filter = still(mounted());
    filter.imu = ImuModel {
        noise_density: 0.0,
        bias_sd_mps2: 0.0,
        bias_walk: 0.0,
        attitude_sd_rad: 0.0,
        ..filter.imu
    };
    filter.range.noise_sd_m = 0.0;
    filter.range.jitter_s = 0.0;
    filter.validate().unwrap();
    let mut state: State = filter.initial();
    let imu = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    let mut estimate = filter.step(&mut state, &imu, &[], DT);
    for step in 1..100 {
        let height = 2.0 - 0.5 * f64::from(step) * DT;
        let range = Reading::Range(RangeReading::level(height + filter.range.position_m.z, 0.0));
        estimate = filter.step(&mut state, &imu, &[range], DT);
    }
    assert!((estimate.height_m() - 1.505).abs() < 1e-12);
    assert!((estimate.velocity_mps.z + 0.5).abs() < 1e-9);
    assert!(estimate.position_sd_m.z < 1e-9);
}

#[test]
fn analytic_deck_sightings_show_the_heave() {
    let filter = mounted();
    let mut state: State = filter.initial();
    let (mut seen, mut sum) = (0, 0.0);
    for step in 1..1500 {
        let t = step as f64 * DT;
        let all = readings(&PAPER_DECK, &filter, step, [0.02, 0.05, 0.12]);
        filter.step(&mut state, &PAPER_DECK.imu(t, V::ZERO), &all, DT);
        let sighting = filter.deck_sighting(&state);
        // The first readings are older than the filter.
        assert!(step < 10 || sighting.is_some() == (due(step, 2) || due(step, 3)));
        if let (Some(sighting), true) = (sighting, step > 500) {
            let then = PAPER_DECK.at(t - sighting.age_s);
            // Altitude starts at zero, its own error is constant.
            let constant = sighting.displacement_m - then.deck_height;
            seen += 1;
            sum += constant;
            let mean = sum / f64::from(seen);
            // Vertical velocity from GNSS at 0.15 m/s and the prior let the altitude
            // wander; over 10 s within this, a fifth of the heave.
            assert!((constant - mean).abs() < 0.01, "{t} {constant} {mean}");
        }
    }
}

#[test]
fn analytic_a_broadcast_tells_the_place_once_and_the_velocity_ever_better() {
    let mut filter = still(mounted());
    filter.deck.horizontal_velocity_sd_mps = 8.0;
    filter.initial.velocity_sd_mps = 0.0;
    let mut state: State = filter.initial();
    let rest = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    let beacon = Reading::Beacon(BeaconReading {
        position_m: V::new(20.0, -10.0, 6.0),
        deck_velocity_mps: V::new(3.0, 1.0, 0.0),
        age_s: 0.0,
    });
    for _ in 0..50 {
        filter.step(&mut state, &rest, &[beacon], 0.0);
    }
    let estimate = filter.step(&mut state, &rest, &[], 0.0);
    // Errors of a place do not average out: its deviation is that of one reading, to rounding.
    assert!((estimate.position_sd_m.x - 2.0).abs() < 1e-9);
    assert!((estimate.position_sd_m.z - 3.0).abs() < 1e-9);
    // With halves of the way at each further reading the estimate is there.
    assert!((estimate.position_m - V::new(20.0, -10.0, 6.0)).norm() < 1e-6);
    // Of n readings with 0.15 m/s: 0.15/√n, and the prior of 8 m/s counts for 1e-5 of one.
    assert!((estimate.deck_velocity_sd_mps.x - 0.15 / 50.0_f64.sqrt()).abs() < 1e-4);
    assert!((estimate.deck_velocity_mps.x - 3.0).abs() < 1e-3);
    // A tag that is precise is not disturbed by a later broadcast.
    let tag = Reading::Tag(TagReading {
        position_m: filter
            .tag
            .attitude
            .unrotate(V::new(-18.5, 10.5, -5.0) - filter.tag.position_m),
        covariance_m2: [[1e-6; 3]; 3],
        age_s: 0.0,
    });
    let seen = filter.step(&mut state, &rest, &[tag], 0.0);
    assert!((seen.position_m - V::new(18.5, -10.5, 5.0)).norm() < 0.1);
    let after = filter.step(&mut state, &rest, &[beacon], 0.0);
    assert_eq!(after.position_m, seen.position_m);
}

#[test]
fn analytic_an_unseen_deck_travels_along_with_the_vehicle() {
    let mut filter = still(mounted());
    filter.deck.horizontal_velocity_sd_mps = 8.0;
    filter.initial.velocity_sd_mps = 8.0;
    let rest = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    let gnss = Reading::Gnss(GnssVelocity {
        velocity_mps: V::new(10.0, -4.0, 0.0),
        age_s: 0.0,
    });
    let after = |filter: &RelativeFilter<f64>| {
        let mut state: State = filter.initial();
        for _ in 0..50 {
            filter.step(&mut state, &rest, &[gnss], 0.0);
        }
        filter.step(&mut state, &rest, &[], 0.0)
    };
    // A deck that has nothing to do with the vehicle is not known from its velocity.
    assert_eq!(after(&filter).deck_velocity_mps.x, 0.0);
    filter.initial.follows_sd_mps = 3.0;
    let estimate = after(&filter);
    // Of 50 readings with 0.1 m/s or so the prior of 8 m/s counts for 1e-5.
    for (own, deck) in [
        (estimate.velocity_mps.x, estimate.deck_velocity_mps.x),
        (estimate.velocity_mps.y, estimate.deck_velocity_mps.y),
    ] {
        assert!((own - deck).abs() < 1e-9, "{own} {deck}");
    }
    assert!((estimate.deck_velocity_mps.x - 10.0).abs() < 1e-3);
    // It is as uncertain as said beside the vehicle's own velocity.
    assert!((estimate.relative_velocity_sd_mps.x - 3.0).abs() < 1e-9);
}
