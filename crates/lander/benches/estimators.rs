//! Time of the estimators' steps at 100 Hz.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuSample, RangeReading, Reading, RelativeFilter, RelativeState, TagReading,
};

const STEPS: usize = 6000;
const DT: f64 = 0.01;

fn main() {
    divan::main();
}

/// A minute of a deck estimator that has found as many harmonics as there are.
#[divan::bench(args = [1, 2, 3])]
fn deck_step(bencher: Bencher<'_, '_>, harmonics: u8) {
    let estimator = DeckEstimator {
        harmonics,
        ..DeckEstimator::new(Observed::Displacement, 0.005)
    };
    let deck = |t: f64| 0.05 * (3.0 * t).sin() + 0.03 * (5.1 * t).sin() + 0.02 * (1.7 * t).cos();
    let mut start = estimator.initial();
    for step in 0..STEPS {
        estimator.step(&mut start, Some(deck(step as f64 * DT)), DT);
    }
    assert_eq!(start.count(), usize::from(harmonics));
    let readings: Vec<f64> = (STEPS..2 * STEPS).map(|k| deck(k as f64 * DT)).collect();
    bencher.counter(ItemsCount::new(STEPS)).bench(|| {
        let mut state = black_box(start);
        for &reading in &readings {
            estimator.step(&mut state, Some(reading), DT);
        }
        state
    });
}

/// A prediction of three harmonics.
#[divan::bench]
fn deck_prediction(bencher: Bencher<'_, '_>) {
    let estimator = DeckEstimator::new(Observed::Displacement, 0.005);
    let mut state = estimator.initial();
    for step in 0..STEPS {
        let t = step as f64 * DT;
        let reading = 0.05 * (3.0 * t).sin() + 0.03 * (5.1 * t).sin() + 0.02 * (1.7 * t).cos();
        estimator.step(&mut state, Some(reading), DT);
    }
    bencher.bench(|| estimator.predict(black_box(&state), black_box(1.0)));
}

/// A minute of the relative estimator: range 50 Hz and 20 ms old, tag 30 Hz and
/// 60 ms old, GNSS 5 Hz and 120 ms old (or all of them punctual).
#[divan::bench(args = [false, true])]
fn relative_step(bencher: Bencher<'_, '_>, late: bool) {
    let filter = RelativeFilter::<f64>::default();
    let imu = ImuSample {
        specific_force_mps2: Vector::UP * 9.81,
        attitude: Attitude::LEVEL,
    };
    let age = |age_s: f64| if late { age_s } else { 0.0 };
    let start: RelativeState<f64, 32, 32> = filter.initial();
    bencher.counter(ItemsCount::new(STEPS)).bench(|| {
        let mut state = black_box(start);
        for step in 0..STEPS {
            let mut readings = [Reading::Range(RangeReading::level(1.0, age(0.02))); 3];
            let mut count = usize::from(step % 2 == 0);
            if step % 3 == 0 {
                readings[count] = Reading::Tag(TagReading {
                    position_m: Vector::UP,
                    covariance_m2: [[0.0; 3]; 3],
                    age_s: age(0.06),
                });
                count += 1;
            }
            if step % 20 == 0 {
                readings[count] = Reading::Gnss(GnssVelocity {
                    velocity_mps: Vector::ZERO,
                    age_s: age(0.12),
                });
                count += 1;
            }
            filter.step(&mut state, &imu, &readings[..count], DT);
        }
        filter.ahead(&state, 0.0)
    });
}
