//! From ranges to predictions of the deck.

mod common;

use common::deck::{DT, paper_deck};
use common::noise::Noise;
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuSample, RangeReading, Reading, RelativeFilter, RelativeState,
};

#[test]
fn analytic_chain_from_range_to_deck_prediction() {
    // Range finder in whole centimetres, IMU and GNSS with noise; a hover at 1.2 m above
    // the paper's deck; sightings of the relative estimator feed the deck estimator.
    let filter = RelativeFilter::<f64>::default();
    let mut relative: RelativeState<f64, 32, 32> = filter.initial();
    let estimator = DeckEstimator {
        delay_s: 0.02,
        offset_rate_sd: 0.1,
        offset_rate_drift: 0.02,
        ..DeckEstimator::new(Observed::Displacement, 0.006)
    };
    let mut state = estimator.initial();
    let mut noise = Noise::new(6);
    let deck = paper_deck(0.0);
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for step in 1..3000 {
        let t = f64::from(step) * DT;
        let imu = ImuSample {
            specific_force_mps2: Vector::new(0.0, 0.0, 9.81 + 0.02 + 0.15 * noise.normal()),
            attitude: Attitude::LEVEL,
        };
        let mut readings = Vec::new();
        if step % 2 == 0 {
            let range = 1.2 - deck.at(t - 0.02)[0] + 0.005 * noise.normal();
            let whole = (range * 100.0).round() / 100.0;
            readings.push(Reading::Range(RangeReading::level(whole, 0.02)));
        }
        if step % 20 == 0 {
            readings.push(Reading::Gnss(GnssVelocity {
                velocity_mps: Vector::new(0.0, 0.0, 0.1 * noise.normal()),
                age_s: 0.1,
            }));
        }
        filter.step(&mut relative, &imu, &readings, DT);
        let sighting = filter.deck_sighting(&relative);
        estimator.step(&mut state, sighting.map(|s| s.displacement_m), DT);
        if t > 15.0 {
            let p = estimator.predict(&state, 0.09);
            let then = deck.at(t + 0.09);
            sum[0] += (p.velocity_mps - then[1]).powi(2);
            sum[1] += (p.acceleration_mps2 - then[2]).powi(2);
            count += 1.0;
        }
    }
    let rms = sum.map(|s| (s / count).sqrt());
    // Of 0.111 m/s and 0.349 m/s², where the readings leave 1 cm each and the vehicle's
    // velocity 0.04 m/s: within a seventh.
    assert!(rms[0] < 0.016 && rms[1] < 0.05, "{rms:?}");
}
