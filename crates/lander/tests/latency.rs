//! The estimator of a latency that readings do not tell.

mod common;

use common::noise::Noise;
use touchdown_flight::{Attitude, Real, Vector};
use touchdown_lander::estimate::latency::{LatencyEstimator, LatencyState};
use touchdown_lander::estimate::relative::{
    ImuSample, RangeReading, Reading, RelativeFilter, TagReading,
};

const DT: f64 = 0.01;
const G: f64 = 9.81;

/// Motion along x: place relative to the deck and acceleration of the vehicle.
type Motion = (f64, f64);

/// A vehicle that swings above a deck at rest.
fn swing(amplitude_m: f64, t: f64) -> Motion {
    let w = 5.0;
    let place = amplitude_m * (w * t).sin();
    (place, -w * w * place)
}

/// A vehicle that follows a deck `late_s` behind; the deck sways by a metre at the period of 5 s.
fn follow(late_s: f64, t: f64) -> Motion {
    let w = std::f64::consts::TAU / 5.0;
    let (deck, vehicle) = ((w * t).sin(), (w * (t - late_s)).sin());
    (vehicle - deck, -w * w * vehicle)
}

/// A flight whose readings are later than they say.
#[derive(Clone, Copy)]
struct Flight {
    height_m: f64,
    /// Stamped age of the readings.
    age_s: f64,
    /// Age beyond the stamped one.
    late_s: f64,
    /// Error of the measured acceleration along x.
    drift_mps2: f64,
    /// Noise of the camera.
    noise_m: f64,
    /// Steps from one view to the next.
    every: usize,
    seconds: usize,
}

impl Default for Flight {
    fn default() -> Self {
        Self {
            height_m: 0.8,
            age_s: 0.04,
            late_s: 0.0,
            drift_mps2: 0.0,
            noise_m: 0.001,
            every: 3,
            seconds: 10,
        }
    }
}

impl Flight {
    fn late(late_s: f64) -> Self {
        Self {
            late_s,
            ..Self::default()
        }
    }
}

/// The latency that is found in a flight of this motion.
fn found<R: Real>(flight: &Flight, motion: impl Fn(f64) -> Motion) -> f64 {
    let Flight {
        height_m,
        age_s,
        late_s,
        ..
    } = *flight;
    let n = R::from_f64;
    // The thrust tilts with the acceleration.
    let tilt_of = |acceleration: f64| (acceleration / G).atan();
    let filter = RelativeFilter::<R>::default();
    let estimator = LatencyEstimator::<R>::default();
    estimator.validate().unwrap();
    let mut relative = filter.initial::<32, 32>();
    let mut state: LatencyState<R> = estimator.initial();
    let mut noise = Noise::new(3);
    for step in 1..=100 * flight.seconds {
        let t = DT * step as f64;
        let (_, acceleration) = motion(t);
        let tilt = tilt_of(acceleration);
        let attitude =
            |tilt: f64| Attitude::from_rotation_vector(Vector::new(R::ZERO, n(tilt), R::ZERO));
        let felt = Vector::new(n(acceleration + flight.drift_mps2), R::ZERO, n(G));
        let imu = ImuSample {
            specific_force_mps2: attitude(tilt).unrotate(felt),
            attitude: attitude(tilt),
        };
        filter.step(&mut relative, &imu, &[], n(DT));
        let seen = (step % flight.every == 0).then(|| {
            let (place, acceleration) = motion(t - age_s - late_s);
            let below = Vector::new(n(-place), R::ZERO, n(-height_m));
            let body = attitude(tilt_of(acceleration)).unrotate(below);
            let camera = filter.tag.attitude.unrotate(body);
            let wrong = Vector::new(
                n(flight.noise_m * noise.normal()),
                n(flight.noise_m * noise.normal()),
                R::ZERO,
            );
            Reading::Tag(TagReading {
                position_m: camera + wrong,
                covariance_m2: [[R::ZERO; 3]; 3],
                age_s: n(age_s),
            })
        });
        estimator.step(&mut state, &filter, &relative, seen.as_slice(), n(DT));
    }
    state.latency_s().to_f64()
}

#[test]
fn analytic_a_swing_tells_the_delay() {
    let swinging = |t| swing(0.03, t);
    for late_s in [0.0, 0.013, 0.05, 0.1, 0.15, 0.2] {
        let flight = Flight::late(late_s);
        // 1 mm of noise on 3 cm, 200 readings: 1 mm / (0.11 m/s √200) is less than a
        // millisecond; the parabola through delays 20 ms apart is good to a tenth of that.
        let error = found::<f64>(&flight, swinging) - late_s;
        assert!(error.abs() < 2e-3, "{late_s} {error}");
        let error = found::<f32>(&flight, swinging) - late_s;
        assert!(error.abs() < 2e-3, "{late_s} {error}");
        // A levelling error of 5 mrad is slower than the memory.
        let drifting = Flight {
            drift_mps2: 0.05,
            ..flight
        };
        let error = found::<f64>(&drifting, swinging) - late_s;
        assert!(error.abs() < 3e-3, "{late_s} {error}");
    }
    // Beyond what is looked for it is as much as that.
    assert_eq!(found::<f64>(&Flight::late(0.25), swinging), 0.22);
}

#[test]
fn analytic_of_old_readings_the_delays_that_are_remembered_are_told_apart() {
    let old = |late_s| Flight {
        age_s: 0.14,
        ..Flight::late(late_s)
    };
    let swinging = |t| swing(0.03, t);
    // Stamped 0.14 s old: 0.16 s more is the last compared latency within 0.31 s.
    for late_s in [0.0, 0.03, 0.06, 0.1] {
        // As above.
        let error = found::<f64>(&old(late_s), swinging) - late_s;
        assert!(error.abs() < 2e-3, "{late_s} {error}");
    }
    // Beside the last one, the acceleration before the memory is held for two steps.
    let error = found::<f64>(&old(0.14), swinging) - 0.14;
    assert!(error.abs() < 4e-3, "{error}");
    let error = found::<f64>(&old(0.2), swinging) - 0.16;
    assert!(error.abs() < 1e-12, "{error}");
}

#[test]
fn analytic_a_swing_tells_the_delay_to_a_slow_camera() {
    for every in [5, 7, 10] {
        for late_s in [0.0, 0.1, 0.2] {
            let slow = Flight {
                every,
                ..Flight::late(late_s)
            };
            let error = found::<f64>(&slow, |t| swing(0.03, t)) - late_s;
            // A third of the views of the test above, and an acceleration of 0.75 m/s² that is held for 0.03 s at most.
            assert!(error.abs() < 4e-3, "{every} {late_s} {error}");
        }
    }
}

#[test]
fn analytic_following_a_deck_that_sways_is_no_latency() {
    for (height_m, behind_s) in [(0.8, 0.1), (0.8, 0.3), (0.8, 0.5), (2.5, 0.1), (5.0, 0.1)] {
        // The noise of a camera that sees a tag of 0.4 m from 2.5 m.
        let flight = Flight {
            height_m,
            noise_m: 0.005,
            seconds: 20,
            ..Flight::default()
        };
        let found = found::<f64>(&flight, |t| follow(behind_s, t));
        assert_eq!(found, 0.0, "{height_m} {behind_s}");
    }
}

/// Vertical motion: height above the deck and acceleration of the vehicle.
fn bounce(t: f64) -> Motion {
    let w = 7.5;
    let height = 0.15 * (w * t).sin();
    (0.8 + height, -w * w * height)
}

/// A vehicle that follows a deck a tenth of a second behind; the deck heaves by 5 cm at 1 Hz.
fn follow_heave(t: f64) -> Motion {
    let w = std::f64::consts::TAU;
    let (deck, vehicle) = ((w * t).sin(), (w * (t - 0.1)).sin());
    (0.8 + 0.05 * (vehicle - deck), -w * w * 0.05 * vehicle)
}

/// The latency that is found in four seconds of this motion by range alone, and whether the relative estimator ever diverged.
fn found_by_height(late_s: f64, motion: impl Fn(f64) -> Motion) -> (f64, bool) {
    let age_s = 0.03;
    let filter = RelativeFilter::default();
    let estimator = LatencyEstimator::default();
    let mut relative = filter.initial::<32, 32>();
    let mut state: LatencyState<f64> = estimator.initial();
    let mut noise = Noise::new(5);
    let mut diverged = false;
    for step in 1..=400 {
        let t = DT * f64::from(step);
        let imu = ImuSample {
            specific_force_mps2: Vector::UP * (G + motion(t).1),
            attitude: Attitude::LEVEL,
        };
        // A range every second step.
        let seen = (step % 2 == 0).then(|| {
            let height_m = motion(t - age_s - late_s).0 + 0.005 * noise.normal();
            // Every tenth reading says that there was no echo.
            let distance_m = if step % 20 == 0 { 60.0 } else { height_m };
            Reading::Range(RangeReading::level(distance_m, age_s))
        });
        filter.step(&mut relative, &imu, seen.as_slice(), DT);
        estimator.step(&mut state, &filter, &relative, seen.as_slice(), DT);
        diverged |= filter.health(&relative).diverged;
    }
    (state.latency_s(), diverged)
}

#[test]
fn analytic_old_heights_tell_the_delay_where_the_estimate_diverges() {
    for late_s in [0.1, 0.15, 0.2] {
        let (found, diverged) = found_by_height(late_s, bounce);
        assert!(diverged, "{late_s}");
        // Half of the distance between two compared latencies.
        assert!((found - late_s).abs() < 0.01, "{late_s} {found}");
    }
    assert_eq!(found_by_height(0.0, bounce), (0.0, false));
}

#[test]
fn analytic_following_a_deck_that_heaves_fast_is_no_latency() {
    assert_eq!(found_by_height(0.0, follow_heave), (0.0, false));
}

#[test]
fn prop_a_vehicle_at_rest_tells_nothing() {
    for late_s in [0.0, 0.1] {
        let resting = Flight {
            drift_mps2: 0.02,
            seconds: 60,
            ..Flight::late(late_s)
        };
        assert_eq!(found::<f64>(&resting, |t| swing(0.0, t)), 0.0);
    }
    // Nor does a moment of swinging.
    let short = Flight {
        seconds: 1,
        ..Flight::late(0.1)
    };
    assert_eq!(found::<f64>(&short, |t| swing(0.03, t)), 0.0);
}

#[test]
fn prop_gaps_disorder_and_numbers_that_are_none_are_borne() {
    let filter = RelativeFilter::<f64>::default();
    let estimator = LatencyEstimator::<f64>::default();
    let mut relative = filter.initial::<32, 32>();
    let mut state = estimator.initial();
    for step in 0..3000 {
        let imu = ImuSample {
            specific_force_mps2: Vector::UP * G,
            attitude: Attitude::LEVEL,
        };
        filter.step(&mut relative, &imu, &[], DT);
        if step == 1500 {
            filter.restart(&mut relative);
        }
        let tag = |x: f64, age_s: f64| {
            Reading::Tag(TagReading {
                position_m: Vector::new(x, 0.0, 0.8),
                covariance_m2: [[0.0; 3]; 3],
                age_s,
            })
        };
        let readings = match step % 97 {
            0..40 => vec![tag(0.0, 0.04)],
            40..50 => vec![tag(f64::NAN, 0.04), tag(0.0, f64::INFINITY)],
            50..60 => vec![tag(0.0, 0.02), tag(0.0, 0.09), tag(0.0, 0.02)],
            60..65 => vec![tag(0.0, 5.0)],
            _ => vec![],
        };
        estimator.step(&mut state, &filter, &relative, &readings, DT);
        assert_eq!(state.latency_s(), 0.0, "{step}");
    }
}

#[test]
fn prop_settings_that_cannot_be_are_refused_by_name() {
    let good = LatencyEstimator::<f64>::default();
    for (bad, words) in [
        (
            LatencyEstimator {
                greatest_s: 0.3,
                ..good
            },
            ["latency.greatest_s", "0.3"],
        ),
        (
            LatencyEstimator {
                memory_s: 0.0,
                ..good
            },
            ["latency.memory_s", "0"],
        ),
        (
            LatencyEstimator {
                evidence_s: f64::NAN,
                ..good
            },
            ["latency.evidence_s", "NaN"],
        ),
        (
            LatencyEstimator {
                least_evidence: -1.0,
                ..good
            },
            ["latency.least_evidence", "-1"],
        ),
    ] {
        let error = bad.validate().unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}
