//! What holds whatever comes: outliers, numbers that are none, single precision, refused settings.

use proptest::prelude::*;
use touchdown_flight::{Attitude, Real, Vector};
use touchdown_lander::estimate::relative::{
    BarometerReading, BeaconReading, GnssVelocity, ImuSample, RangeModel, RangeReading, Reading,
    RelativeFilter, RelativeState, TagModel, TagReading,
};

use crate::truth::*;

#[test]
fn analytic_outliers_divergence_and_restart() {
    let filter = mounted();
    let mut state: State = filter.initial();
    let run = |state: &mut State, steps: std::ops::Range<usize>, jump: f64| {
        for step in steps {
            let t = step as f64 * DT;
            let mut all = readings(&PAPER_DECK, &filter, step, [0.02, 0.05, 0.12]);
            for reading in &mut all {
                if let Reading::Range(range) = reading {
                    range.distance_m += jump;
                }
            }
            filter.step(state, &PAPER_DECK.imu(t, V::ZERO), &all, DT);
        }
        filter.health(state)
    };
    assert!(!run(&mut state, 1..300, 0.0).diverged);
    // One wild reading is left out and forgotten.
    let one = run(&mut state, 300..301, 1.0);
    assert_eq!((one.range.rejected, one.range.rejected_in_a_row), (1, 1));
    assert!(!one.diverged);
    assert_eq!(run(&mut state, 301..400, 0.0).range.rejected_in_a_row, 0);
    // A sensor that has jumped for good: ten readings of 50 Hz.
    let jumped = run(&mut state, 400..420, 1.0);
    assert!(jumped.diverged && !jumped.range.fresh);
    filter.restart(&mut state);
    let anew = run(&mut state, 420..600, 0.0);
    assert!(!anew.diverged && anew.range.fresh && anew.range.nis < 2.0);
    let estimate = filter.ahead(&state, 0.0);
    assert!((estimate.position_m - PAPER_DECK.at(5.99).position).norm() < 2e-3);
}

#[test]
fn analytic_nothing_not_finite_gets_in() {
    let filter = mounted();
    let mut state: State = filter.initial();
    for step in 1..200 {
        let all = readings(&STILL, &filter, step, [0.0; 3]);
        filter.step(&mut state, &STILL.imu(step as f64 * DT, V::ZERO), &all, DT);
    }
    let before = filter.ahead(&state, DT);
    let bad = [f64::NAN, f64::INFINITY];
    let mut all = Vec::new();
    for value in bad {
        all.push(Reading::Range(RangeReading::level(value, 0.0)));
        all.push(Reading::Range(RangeReading::level(1.0, value)));
        all.push(Reading::Tag(TagReading {
            position_m: V::new(0.0, value, 1.0),
            covariance_m2: [[0.0; 3]; 3],
            age_s: 0.0,
        }));
        all.push(Reading::Gnss(GnssVelocity {
            velocity_mps: V::new(value, 0.0, 0.0),
            age_s: 0.0,
        }));
        all.push(Reading::Barometer(BarometerReading {
            altitude_m: value,
            age_s: 0.0,
        }));
    }
    let imu = ImuSample {
        specific_force_mps2: V::new(0.0, 0.0, f64::NAN),
        attitude: Attitude::LEVEL,
    };
    let after = filter.step(&mut state, &imu, &all, DT);
    // The last acceleration is held, nothing else happened.
    assert_eq!(after, before);
    let health = filter.health(&state);
    assert_eq!(
        [
            health.imu.not_finite,
            health.range.not_finite,
            health.tag.not_finite
        ],
        [1, 4, 2]
    );
    assert_eq!(
        [health.gnss.not_finite, health.barometer.not_finite],
        [2, 2]
    );
    for _ in 0..10 {
        filter.step(&mut state, &imu, &[], DT);
    }
    let health = filter.health(&state);
    assert!(!health.imu.fresh && !health.diverged);
    // Ages grow by the time that passes.
    assert!((health.imu.age_s - 0.11).abs() < 1e-12);
}

fn convert<R: Real>(v: V) -> Vector<R> {
    Vector::from_array(v.to_array().map(R::from_f64))
}

#[test]
fn prop_single_precision_follows_double() {
    // Every number of the settings is rounded to single precision in both.
    let filter = mounted();
    let coarse = RelativeFilter::<f32> {
        range: RangeModel {
            position_m: convert(filter.range.position_m),
            quantum_m: 0.0,
            ..RangeModel::default()
        },
        tag: TagModel {
            position_m: convert(filter.tag.position_m),
            ..TagModel::default()
        },
        ..RelativeFilter::default()
    };
    let mut state: State = filter.initial();
    let mut single: RelativeState<f32, 32, 64> = coarse.initial();
    for step in 1..=6000 {
        let t = step as f64 * DT;
        let all = readings(&PAPER_DECK, &filter, step, [0.02, 0.055, 0.12]);
        let narrow: Vec<Reading<f32>> = all
            .iter()
            .map(|reading| match reading {
                Reading::Range(range) => Reading::Range(RangeReading::level(
                    range.distance_m as f32,
                    range.age_s as f32,
                )),
                Reading::Tag(tag) => Reading::Tag(TagReading {
                    position_m: convert(tag.position_m),
                    covariance_m2: tag.covariance_m2.map(|row| row.map(|c| c as f32)),
                    age_s: tag.age_s as f32,
                }),
                Reading::Gnss(gnss) => Reading::Gnss(GnssVelocity {
                    velocity_mps: convert(gnss.velocity_mps),
                    age_s: gnss.age_s as f32,
                }),
                Reading::Barometer(_) | Reading::Beacon(_) => unreachable!(),
            })
            .collect();
        let imu = PAPER_DECK.imu(t, V::ZERO);
        let fine = filter.step(&mut state, &imu, &all, DT);
        let imu = ImuSample {
            specific_force_mps2: convert(imu.specific_force_mps2),
            attitude: Attitude::from_quaternion(imu.attitude.to_quaternion().map(|c| c as f32))
                .unwrap(),
        };
        let narrow = coarse.step(&mut single, &imu, &narrow, DT as f32);
        if step > 100 {
            let apart = f64::from(narrow.position_m.z) - fine.position_m.z;
            let speed =
                f64::from(narrow.relative_velocity_mps().z) - fine.relative_velocity_mps().z;
            // Rounding 6e-8 of metres and of g (6e-7 m/s²), amplified by the filter's
            // memory of some seconds; a hundredth of the sensors' noise.
            assert!(
                apart.abs() < 5e-5 && speed.abs() < 5e-4,
                "{t} {apart} {speed}"
            );
            let ratio = f64::from(narrow.position_sd_m.z) / fine.position_sd_m.z;
            // Variances keep three digits after the 10 m of the start.
            assert!((ratio - 1.0).abs() < 1e-2, "{t} {ratio}");
        }
    }
    assert!(!coarse.health(&single).diverged);
}

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -5.0_f32..5.0,
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(0.0),
        1 => prop::num::f32::ANY,
    ]
}

fn any_reading() -> impl Strategy<Value = Reading<f32>> {
    let vector = || prop::array::uniform3(any_number()).prop_map(Vector::from_array);
    let age = || prop_oneof![3 => 0.0_f32..0.1, 1 => any_number()];
    prop_oneof![
        (any_number(), vector(), age()).prop_map(|(distance_m, deck_normal, age_s)| {
            Reading::Range(RangeReading {
                distance_m,
                deck_normal,
                age_s,
            })
        }),
        (any_number(), age())
            .prop_map(|(distance_m, age_s)| Reading::Range(RangeReading::level(distance_m, age_s))),
        (
            vector(),
            prop::array::uniform3(prop::array::uniform3(any_number())),
            age()
        )
            .prop_map(|(position_m, covariance_m2, age_s)| {
                Reading::Tag(TagReading {
                    position_m,
                    covariance_m2,
                    age_s,
                })
            }),
        (vector(), age()).prop_map(|(velocity_mps, age_s)| Reading::Gnss(GnssVelocity {
            velocity_mps,
            age_s
        })),
        (any_number(), age()).prop_map(|(altitude_m, age_s)| {
            Reading::Barometer(BarometerReading { altitude_m, age_s })
        }),
        (vector(), vector(), age()).prop_map(|(position_m, deck_velocity_mps, age_s)| {
            Reading::Beacon(BeaconReading {
                position_m,
                deck_velocity_mps,
                age_s,
            })
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn prop_whatever_comes_the_estimate_is_finite(
        steps in prop::collection::vec(
            (
                prop::collection::vec(any_reading(), 0..4),
                prop::array::uniform3(any_number()),
                any_number(),
            ),
            1..60,
        )
    ) {
        let filter = RelativeFilter::<f32>::default();
        let mut state: RelativeState<f32, 8, 8> = filter.initial();
        for (readings, force, dt) in steps {
            let imu = ImuSample {
                specific_force_mps2: Vector::from_array(force),
                attitude: Attitude::LEVEL,
            };
            let e = filter.step(&mut state, &imu, &readings, dt.min(0.1));
            for v in [
                e.position_m, e.velocity_mps, e.deck_velocity_mps, e.bias_mps2,
                e.position_sd_m, e.relative_velocity_sd_mps, e.velocity_sd_mps,
            ] {
                prop_assert!(v.is_finite(), "{e:?}");
            }
            prop_assert!(e.deck_acceleration_mps2.is_finite() && e.altitude_m.is_finite());
        }
    }
}

#[test]
fn analytic_settings_are_refused_by_name() {
    let refused = |change: fn(&mut RelativeFilter<f64>)| {
        let mut filter = RelativeFilter::<f64>::default();
        change(&mut filter);
        filter.validate().unwrap_err().to_string()
    };
    assert_eq!(
        refused(|f| f.range.noise_sd_m = -0.1),
        "relative.range.noise_sd_m: expected a finite number not below 0, found -0.1"
    );
    assert_eq!(
        refused(|f| f.range.direction = V::ZERO),
        "relative.range.direction: expected a finite number greater than 0, found 0"
    );
    assert_eq!(
        refused(|f| f.gate.rejections = 0),
        "relative.gate.rejections: expected a number of readings not below 1, found 0"
    );
    assert_eq!(
        refused(|f| f.imu.stale_s = f64::NAN),
        "relative.imu.stale_s: expected a finite number greater than 0, found NaN"
    );
}
