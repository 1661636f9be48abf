//! The deck estimator against truth.

mod common;

use common::deck::{DT, Score, Sines, paper_deck, run};
use common::noise::Noise;
use proptest::prelude::*;
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};

fn displacement(sd: f64) -> DeckEstimator<f64> {
    DeckEstimator::new(Observed::Displacement, sd)
}

fn velocity(sd: f64) -> DeckEstimator<f64> {
    DeckEstimator::new(Observed::Velocity, sd)
}

#[test]
fn analytic_the_papers_deck_is_found_in_a_period_and_predicted() {
    for (estimator, bound) in [(displacement(0.005), 0.06), (velocity(0.03), 0.13)] {
        estimator.validate().unwrap();
        for horizon in [0.09, 1.0] {
            let mut score = Score::default();
            for seed in 0..12 {
                let deck = paper_deck(0.6 * seed as f64);
                let state = run(&estimator, &deck, seed, [6.0, 15.0], horizon, &mut score);
                let harmonic = state.harmonic(0).unwrap();
                // Ten times the standard error of 15 s of readings, 8e-4 and 5e-3.
                let off = (harmonic.angular_frequency - std::f64::consts::PI).abs();
                assert!(off < 0.05 && (harmonic.amplitude_m - 0.05).abs() < 0.005);
            }
            // A fit to all readings of 6 s would give 1 % and 2 %; until then the rate
            // of forgetting is still being learnt.
            let relative = score.relative();
            assert!(relative.iter().all(|&e| e < bound), "{relative:?}");
            // Overstated while it is learnt, never understated.
            let coverage = score.coverage();
            assert!(coverage.iter().all(|&c| c > 0.95), "{coverage:?}");
        }
    }
}

#[test]
fn analytic_a_fast_motion_as_small_as_the_noise_is_found() {
    let estimator = displacement(0.005);
    // Amplitude, m; frequency, Hz.
    for (amplitude_m, frequency_hz) in [(0.005, 1.0), (0.005, 1.4), (0.008, 2.1)] {
        let w = std::f64::consts::TAU * frequency_hz;
        let mut score = Score::default();
        for seed in 0..12 {
            let deck = Sines(vec![[amplitude_m, w, 0.6 * seed as f64]]);
            let state = run(&estimator, &deck, 70 + seed, [8.0, 20.0], 0.2, &mut score);
            // Twenty times the standard error of 20 s of readings, sqrt(24/N) σ/(A T) = 5e-3 rad/s: most of them are forgotten.
            let near = (0..state.count())
                .filter_map(|k| state.harmonic(k))
                .any(|harmonic| (harmonic.angular_frequency - w).abs() < 0.1);
            assert!(near, "{frequency_hz} Hz, {seed}");
        }
        // Four parameters from 800 readings err by σ sqrt(8/800) = 0.1 σ, 0.14 of the motion. Three times that is for what is
        // forgotten; without a tone the error is 1.
        let relative = score.relative();
        assert!(
            relative.iter().all(|&e| e < 0.42),
            "{frequency_hz} Hz, {relative:?}"
        );
    }
}

#[test]
fn analytic_frequency_comes_near_the_cramer_rao_bound() {
    // Amplitude A, N readings of σ over T: var ω ≥ 24 σ²/(A² N T²) (Rife & Boorstyn 1974).
    let (mut sum, runs, time) = (0.0, 30, 30.0);
    let estimator = displacement(0.005);
    for seed in 0..runs {
        let deck = paper_deck(0.9 * seed as f64);
        let mut score = Score::default();
        let state = run(&estimator, &deck, 50 + seed, [time, time], 0.0, &mut score);
        let strongest = (0..state.count())
            .filter_map(|k| state.harmonic(k))
            .reduce(|a, b| if b.amplitude_m > a.amplitude_m { b } else { a })
            .unwrap();
        sum += (strongest.angular_frequency - std::f64::consts::PI).powi(2);
    }
    let rms = (sum / runs as f64).sqrt();
    let bound = (24.0 * 0.01 / (time / DT * time * time)).sqrt();
    // The first seconds are forgotten while coherence is being learnt: twice the bound
    // stands for two thirds of the record.
    assert!(rms < 2.5 * bound, "{rms} {bound}");
    // And nobody is better than the bound: 30 runs, ± 13 %.
    assert!(rms > 0.6 * bound, "{rms} {bound}");
}

#[test]
fn analytic_two_tones() {
    for (estimator, bounds) in [
        (displacement(0.005), [0.3, 0.09]),
        (velocity(0.03), [0.4, 0.06]),
    ] {
        // At first, and when both are known well.
        for (span, bound) in [([6.0, 15.0], bounds[0]), ([20.0, 60.0], bounds[1])] {
            for horizon in [1.0, 2.0] {
                let mut score = Score::default();
                for seed in 0..12 {
                    let phase = seed as f64;
                    let deck = Sines(vec![[0.05, 3.0, 0.7 * phase], [0.03, 5.1, 1.3 * phase]]);
                    let state = run(&estimator, &deck, 100 + seed, span, horizon, &mut score);
                    if span[1] < 60.0 {
                        continue;
                    }
                    for w in [3.0, 5.1] {
                        let near = (0..state.count())
                            .filter_map(|k| state.harmonic(k))
                            .any(|h| (h.angular_frequency - w).abs() < 0.03);
                        // Known to 0.001 rad/s by then.
                        assert!(near, "{seed} {w}");
                    }
                }
                // Sum of the errors of two fits, and some runs that find the second tone
                // late (the search needs two periods and room in its line shape).
                let relative = score.relative();
                assert!(relative.iter().all(|&e| e < bound), "{span:?} {relative:?}");
                let coverage = score.coverage();
                assert!(coverage.iter().all(|&c| c > 0.95), "{coverage:?}");
            }
        }
    }
}

#[test]
fn regress_a_sea_is_predicted_with_honest_errors() {
    // JONSWAP, period 6 s, significant height 0.5 m, twelve seas of 80 s after 40 s.
    // Three harmonics with the best constants for this sea (found off line) leave
    // 0.45, 0.52 and 0.58 of displacement, velocity and acceleration 1 s ahead.
    for (estimator, bound) in [
        (displacement(0.005), [0.55, 0.68, 0.72]),
        (velocity(0.03), [0.5, 0.75, 0.68]),
    ] {
        let mut score = Score::default();
        for seed in 0..12 {
            let sea = Sines::jonswap(0.5, 6.0, seed);
            run(&estimator, &sea, 100 + seed, [40.0, 120.0], 1.0, &mut score);
        }
        let (relative, coverage) = (score.relative(), score.coverage());
        for k in 0..3 {
            assert!(relative[k] < bound[k], "{relative:?}");
        }
        // 160 periods of 6 s in all: 95 % ± 2 %. What is shorter than half the sea's
        // period is not modelled, and its acceleration not counted.
        assert!(coverage[0] > 0.92 && coverage[1] > 0.91, "{coverage:?}");
        assert!(coverage[2] > 0.80, "{coverage:?}");
    }
}

#[test]
fn analytic_a_short_way_ahead_a_sea_is_known() {
    // 0.1 s ahead: errors of the filter, not of the sea.
    let mut score = Score::default();
    for seed in 0..6 {
        let sea = Sines::jonswap(0.5, 6.0, seed);
        run(
            &displacement(0.005),
            &sea,
            seed,
            [40.0, 90.0],
            0.1,
            &mut score,
        );
    }
    // Acceleration known to half of its spread of 0.25 m/s²: a Δt = 13 mm/s, beside what
    // some readings of 5 mm tell of a velocity. The height is that about a mean which
    // the drift of the readings' constant leaves open.
    let rms = score.rms();
    assert!(rms[0] < 0.03 && rms[1] < 0.055, "{rms:?}");
}

#[test]
fn analytic_delay_is_made_good() {
    // Readings 0.08 s old: predictions from now are those of readings without delay for
    // a horizon that much longer, at the time at which they were made.
    let delayed = DeckEstimator {
        delay_s: 0.08,
        ..displacement(0.005)
    };
    let (mut late, mut prompt) = (Score::default(), Score::default());
    let deck = paper_deck(0.4);
    let shifted = paper_deck(0.4 - 0.08 * std::f64::consts::PI);
    run(&delayed, &deck, 3, [10.0, 20.0], 0.5, &mut late);
    run(
        &displacement(0.005),
        &shifted,
        3,
        [10.0, 20.0],
        0.58,
        &mut prompt,
    );
    for k in 0..3 {
        // The same readings: rounding of the phase.
        assert!((late.error2[k] / prompt.error2[k] - 1.0).abs() < 1e-6);
    }
}

#[test]
fn analytic_readings_without_noise() {
    // Believed to 0.1 mm, and exact.
    let mut estimator = displacement(1e-4);
    estimator.offset_drift = 0.0;
    estimator.offset_rate_drift = 0.0;
    let mut state = estimator.initial();
    let deck = paper_deck(1.0);
    for step in 0..3000 {
        estimator.step(&mut state, Some(deck.at(f64::from(step) * DT)[0] - 3.0), DT);
    }
    let p = estimator.predict(&state, 1.0);
    let then = deck.at(30.99);
    // A thousandth of the amplitude and below what is said.
    assert!((p.displacement_m - then[0]).abs() < 5e-5);
    assert!((p.velocity_mps - then[1]).abs() < 1.6e-4);
    assert!(p.displacement_sd_m < 2e-4);
}

#[test]
fn analytic_a_deck_at_rest_has_no_harmonics() {
    let estimator = displacement(0.005);
    for seed in 0..20 {
        let mut state = estimator.initial();
        let mut noise = Noise::new(seed);
        for _ in 0..3000 {
            estimator.step(&mut state, Some(12.0 + 0.005 * noise.normal()), DT);
        }
        assert_eq!(state.count(), 0, "{seed}");
        let p = estimator.predict(&state, 1.0);
        assert_eq!((p.displacement_m, p.velocity_mps), (0.0, 0.0));
        // Velocities over 0.08 s have a noise of 0.03 m/s, of which half is
        // said to be motion at most, at the middle of the band (1.8 rad/s).
        assert!(
            p.displacement_sd_m < 0.012 && p.velocity_sd_mps < 0.025,
            "{p:?}"
        );
    }
}

#[test]
fn analytic_gaps_and_readings_that_are_not_finite() {
    let estimator = displacement(0.005);
    let mut state = estimator.initial();
    let mut noise = Noise::new(4);
    let deck = paper_deck(0.0);
    for step in 0..2000 {
        let t = f64::from(step) * DT;
        let y = deck.at(t)[0] + 0.005 * noise.normal();
        let reading = match step {
            // Two seconds of nothing, one of nonsense, a wild one, and every third lost.
            1000..1200 => None,
            1300..1400 => Some([f64::NAN, f64::INFINITY][step as usize % 2]),
            1500 => Some(50.0),
            _ if step % 3 == 0 => None,
            _ => Some(y),
        };
        estimator.step(&mut state, reading, DT);
        if step > 1000 {
            let p = estimator.predict(&state, 0.5);
            let then = deck.at(t + 0.5);
            // A tone is carried through; a wild reading counts as four deviations.
            assert!((p.displacement_m - then[0]).abs() < 0.006, "{t}");
        }
    }
    assert_eq!(state.not_finite(), 100);
}

#[test]
fn analytic_the_deck_changes_its_period() {
    let estimator = displacement(0.005);
    let mut state = estimator.initial();
    let mut noise = Noise::new(8);
    let mut worst: f64 = 0.0;
    // Phase is continuous: 0.5 Hz until 30 s, then 0.3 Hz and twice as high.
    let at = |t: f64| {
        if t < 30.0 {
            0.05 * (std::f64::consts::PI * t).sin()
        } else {
            0.1 * (0.6 * std::f64::consts::PI * (t - 30.0)).sin()
        }
    };
    for step in 0..7000 {
        let t = f64::from(step) * DT;
        estimator.step(&mut state, Some(at(t) + 0.005 * noise.normal()), DT);
        if t > 64.0 {
            let p = estimator.predict(&state, 1.0);
            worst = worst.max((p.displacement_m - at(t + 1.0)).abs());
        }
    }
    // Learnt anew within 34 s, ten periods, to an eighth of the amplitude.
    assert!(worst < 0.012, "{worst}");
}

#[test]
fn prop_single_precision_does_as_well() {
    // A constant of 100 m as of an altitude: its rounding, 4e-6 m, is far below the noise.
    let mut scores = [Score::default(), Score::default()];
    let coarse = DeckEstimator::<f32>::new(Observed::Displacement, 0.005);
    for seed in 0..4 {
        let sea = Sines::jonswap(0.5, 6.0, seed);
        run(
            &displacement(0.005),
            &sea,
            seed,
            [40.0, 80.0],
            1.0,
            &mut scores[0],
        );
        run(&coarse, &sea, seed, [40.0, 80.0], 1.0, &mut scores[1]);
    }
    for k in 0..3 {
        // Not bit by bit: decisions on thresholds may fall a round later.
        let ratio = scores[1].relative()[k] / scores[0].relative()[k];
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    }
    let mut state = coarse.initial();
    let mut noise = Noise::new(2);
    let deck = paper_deck(0.3);
    for step in 0..60_000 {
        let y = 100.0 + deck.at(f64::from(step) * DT)[0] + 0.005 * noise.normal();
        coarse.step(&mut state, Some(y as f32), DT as f32);
    }
    let p = coarse.predict(&state, 1.0);
    let then = deck.at(600.99);
    assert!((f64::from(p.displacement_m) - then[0]).abs() < 2e-3);
}

#[test]
fn analytic_settings_are_refused_by_name() {
    let refused = |change: fn(&mut DeckEstimator<f64>)| {
        let mut estimator = displacement(0.005);
        change(&mut estimator);
        estimator.validate().unwrap_err().to_string()
    };
    assert_eq!(
        refused(|e| e.harmonics = 4),
        "deck_estimator.harmonics: expected a number from 1 to 3, found 4"
    );
    assert_eq!(
        refused(|e| e.measurement_sd = 0.0),
        "deck_estimator.measurement_sd: expected a finite number greater than 0, found 0"
    );
    assert_eq!(
        refused(|e| e.shortest_period_s = 20.0),
        "deck_estimator.shortest_period_s: expected less than deck_estimator.longest_period_s = 16, found 20"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn prop_whatever_comes_predictions_are_finite(
        readings in prop::collection::vec(
            prop_oneof![
                6 => (-1.0_f32..1.0).prop_map(Some),
                1 => Just(None),
                1 => prop::num::f32::ANY.prop_map(Some),
            ],
            1..600,
        ),
        dt in prop_oneof![Just(0.01_f32), 0.0_f32..0.3, Just(f32::NAN)],
        horizon in 0.0_f32..5.0,
    ) {
        let estimator = DeckEstimator::<f32>::new(Observed::Displacement, 0.01);
        let mut state = estimator.initial();
        for reading in readings {
            estimator.step(&mut state, reading, dt);
            let p = estimator.predict(&state, horizon);
            let means = [p.displacement_m, p.velocity_mps, p.acceleration_mps2];
            prop_assert!(means.iter().all(|v| v.is_finite()), "{p:?}");
            let sds = [p.displacement_sd_m, p.velocity_sd_mps, p.acceleration_sd_mps2];
            // Infinite while nothing is known, and only then.
            let known = state.observed_s() >= 2.0 * estimator.shortest_period_s;
            let unknown = state.count() == 0 && sds.iter().all(|&sd| sd == f32::INFINITY);
            prop_assert!(unknown || sds.iter().all(|sd| sd.is_finite()), "{p:?}");
            prop_assert!(known || state.count() > 0 || unknown, "{p:?}");
        }
    }
}
