//! Without noise the truth, with noise errors as large as stated.

use crate::common::noise::Noise;
use touchdown_flight::Attitude;
use touchdown_lander::estimate::relative::{
    ImuModel, ImuSample, RangeModel, RangeReading, Reading, RelativeFilter,
};

use crate::truth::*;

#[test]
fn analytic_noise_free_over_a_deck_at_rest() {
    let filter = still(mounted());
    filter.validate().unwrap();
    let mut state: State = filter.initial();
    let bias = V::new(0.02, -0.03, 0.04);
    let mut last = None;
    for step in 1..=2000 {
        let t = step as f64 * DT;
        let all = readings(&STILL, &filter, step, [0.02, 0.055, 0.12]);
        let estimate = filter.step(&mut state, &STILL.imu(t, bias), &all, DT);
        if step > 500 {
            let [position, velocity] = worst(&estimate, &STILL.at(t));
            // The mean force of a step moves the place by j dt³/12 less than 1e-7 m a
            // step; the biases are still settling at 5 s.
            assert!(
                position < 3e-4 && velocity < 2e-3,
                "{t}: {position} {velocity}"
            );
        }
        last = Some(estimate);
    }
    let estimate = last.unwrap();
    // Learnt from the place alone, within what its standard deviation leaves.
    assert!((estimate.bias_mps2 - bias).norm() < 1e-3);
    let health = filter.health(&state);
    assert!(!health.diverged && health.range.fresh && health.tag.fresh && health.gnss.fresh);
    assert_eq!(
        health.range.rejected + health.tag.rejected + health.gnss.rejected,
        0
    );
}

#[test]
fn analytic_noise_free_over_the_heaving_deck() {
    let filter = mounted();
    let mut state: State = filter.initial();
    let mut sum = [0.0; 3];
    for step in 1..=2000 {
        let t = step as f64 * DT;
        let all = readings(&PAPER_DECK, &filter, step, [0.02, 0.055, 0.12]);
        let estimate = filter.step(&mut state, &PAPER_DECK.imu(t, V::ZERO), &all, DT);
        if step > 500 {
            let truth = PAPER_DECK.at(t);
            let [position, velocity] = worst(&estimate, &truth);
            // The prior's acceleration 0.6 m/s² that is not known over the age of 20 ms
            // and the filter's lag of twice as much: a t²/2 = 1 mm, a t = 36 mm/s.
            assert!(
                position < 2e-3 && velocity < 0.03,
                "{t}: {position} {velocity}"
            );
            sum[0] += position * position;
            sum[1] += velocity * velocity;
            sum[2] += (estimate.deck_velocity_mps.z - truth.deck_velocity).powi(2);
        }
    }
    // Two thirds of the largest; the deck's velocity has the error of the difference.
    let rms = sum.map(|s| (s / 1500.0).sqrt());
    assert!(rms[0] < 1.4e-3 && rms[1] < 0.02 && rms[2] < 0.02, "{rms:?}");
}

#[test]
fn analytic_precision_of_a_fitted_line() {
    // No process noise: the filter is the least-squares line through the readings,
    // whose standard errors are known (here also the Cramér–Rao bound).
    let filter = RelativeFilter {
        imu: ImuModel {
            noise_density: 0.0,
            bias_sd_mps2: 0.0,
            bias_walk: 0.0,
            attitude_sd_rad: 0.0,
            ..ImuModel::default()
        },
        range: RangeModel {
            noise_sd_m: 0.02,
            quantum_m: 0.0,
            jitter_s: 0.0,
            ..RangeModel::default()
        },
        ..still(RelativeFilter::default())
    };
    let mut state: State = filter.initial();
    let mut noise = Noise::new(3);
    let imu = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    let n = 200;
    let (mut sums, mut last) = ([0.0; 2], None);
    for step in 1..=n {
        let x = f64::from(step) * DT;
        let y = 5.0 - 0.4 * x + 0.02 * noise.normal();
        let centred = x - DT * 0.5 * f64::from(n + 1);
        sums[0] += y;
        sums[1] += y * centred;
        let range = Reading::Range(RangeReading::level(y, 0.0));
        last = Some(filter.step(&mut state, &imu, &[range], DT));
    }
    let n = f64::from(n);
    let spread = DT * DT * n * (n * n - 1.0) / 12.0;
    let slope = sums[1] / spread;
    let end = sums[0] / n + slope * DT * 0.5 * (n - 1.0);
    let estimate = last.unwrap();
    // The prior of 10 m and 2 m/s weighs (0.02/10)²/200 and (0.017/2)².
    assert!((estimate.velocity_mps.z / slope - 1.0).abs() < 2e-4);
    assert!((estimate.height_m() - end).abs() < 1e-5);
    let sd = [
        0.02 * (2.0 * (2.0 * n - 1.0) / (n * (n + 1.0))).sqrt(),
        0.02 / spread.sqrt(),
    ];
    assert!((estimate.position_sd_m.z / sd[0] - 1.0).abs() < 1e-4);
    assert!((estimate.relative_velocity_sd_mps.z / sd[1] - 1.0).abs() < 1e-4);
}

#[test]
fn analytic_errors_are_as_large_as_the_filter_says() {
    // The filter's own model: white force noise, constant bias, a deck at rest,
    // delays. Normalised squared errors of 60 landings, mean 1.
    let filter = RelativeFilter {
        imu: ImuModel {
            bias_walk: 0.0,
            attitude_sd_rad: 0.0,
            ..ImuModel::default()
        },
        ..still(mounted())
    };
    let (mut sum, runs, mut outside) = ([0.0; 4], 100, 0);
    for seed in 0..runs {
        let mut noise = Noise::new(seed);
        let bias = V::from_array([(); 3].map(|()| 0.05 * noise.normal()));
        let mut state: State = filter.initial();
        let mut last = None;
        for step in 1..=600 {
            let t = step as f64 * DT;
            let mut imu = STILL.imu(t, bias);
            let white = [(); 3].map(|()| 0.02 / DT.sqrt() * noise.normal());
            imu.specific_force_mps2 += V::from_array(white);
            let mut all = readings(&STILL, &filter, step, [0.02, 0.05, 0.12]);
            for reading in &mut all {
                match reading {
                    Reading::Range(range) => range.distance_m += 0.005 * noise.normal(),
                    Reading::Tag(tag) => {
                        // Own 1 mm and 2 mm beside it, axis by axis.
                        let white = [(); 3].map(|()| 5e-6_f64.sqrt() * noise.normal());
                        tag.position_m += V::from_array(white);
                    }
                    Reading::Gnss(gnss) => {
                        gnss.velocity_mps += V::new(
                            0.1 * noise.normal(),
                            0.1 * noise.normal(),
                            0.15 * noise.normal(),
                        );
                    }
                    Reading::Barometer(_) | Reading::Beacon(_) => {}
                }
            }
            last = Some(filter.step(&mut state, &imu, &all, DT));
        }
        let (estimate, truth) = (last.unwrap(), STILL.at(6.0));
        let squares = [
            (estimate.height_m() - truth.position.z) / estimate.position_sd_m.z,
            (estimate.velocity_mps.z - truth.velocity.z) / estimate.velocity_sd_mps.z,
            (estimate.position_m.x - truth.position.x) / estimate.position_sd_m.x,
            (estimate.velocity_mps.x - truth.velocity.x) / estimate.velocity_sd_mps.x,
        ];
        for k in 0..4 {
            sum[k] += squares[k] * squares[k];
            outside += usize::from(squares[k].abs() > 1.96);
        }
        let health = filter.health(&state);
        for nis in [health.range.nis, health.tag.nis] {
            // Mean of about 39 squares: 1 ± 0.23 or less.
            assert!(nis > 0.2 && nis < 2.2, "{nis}");
        }
    }
    for mean in sum.map(|s| s / runs as f64) {
        // χ² of 100 degrees: 1 ± 0.14, four of them.
        assert!((mean - 1.0).abs() < 0.57, "{sum:?}");
    }
    // Binomial 400, 5 %: 20 ± 4.4 (pairs correlate: up to 6), four of them.
    assert!(outside < 44, "{outside}");
}
