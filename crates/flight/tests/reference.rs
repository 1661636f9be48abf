//! References, deck filter and touchdown against closed forms.

use touchdown_flight::deck::HarmonicFilter;
use touchdown_flight::metrics::{LandingMetrics, LandingMetricsState};
use touchdown_flight::reference::{Exponential, Reference, Terminal};
use touchdown_flight::touchdown::{TouchdownDetector, TouchdownState};

fn descent(c_per_s: f64, start_height_m: f64) -> Exponential<f64> {
    Exponential {
        c_per_s,
        start_height_m,
        end_height_m: 0.0,
    }
}

#[test]
fn paper_times_of_descent() {
    // C t at 0.1 m, rounded to four decimals.
    let ct = |z0: f64| descent(1.0, z0).time_to_height_s(0.1).unwrap();
    assert!((ct(0.8) - 3.6070).abs() < 6e-5);
    assert!((ct(0.5) - 2.9943).abs() < 6e-5);
    // Times, rounded to the decimals given.
    let time = |c: f64, z0: f64| descent(c, z0).time_to_height_s(0.1).unwrap();
    assert!((time(0.7073, 0.8) - 5.10).abs() < 6e-3);
    assert!((time(0.5566, 0.5) - 5.38).abs() < 6e-3);
    assert!((time(0.1, 0.8) - 36.1).abs() < 6e-2);
    assert!((time(0.1, 0.5) - 29.9).abs() < 6e-2);
    assert_eq!(descent(1.0, 0.5).time_to_height_s(0.6), None);
    assert_eq!(descent(1.0, 0.5).time_to_height_s(0.0), None);
}

#[test]
fn analytic_exponential_reference() {
    let reference = descent(0.7073, 0.8);
    reference.validate().unwrap();
    // Fastest at t = 1/C, C z0 / e.
    let fastest = reference.at(1.0 / 0.7073);
    assert!((fastest.velocity_mps + 0.7073 * 0.8 * (-1.0_f64).exp()).abs() < 1e-15);
    assert!(fastest.acceleration_mps2.abs() < 1e-15);
    derivatives_agree(|t| Reference::Exponential(reference).at(t), 0.3);
    // Before the start: the start.
    assert_eq!(reference.at(-1.0).height_m, 0.8);
    assert_eq!(reference.at(-1.0).velocity_mps, 0.0);
}

#[test]
fn analytic_terminal_reference() {
    let reference = Terminal::<f64> {
        start_height_m: 0.5,
        end_height_m: 0.1,
        sink_rate_mps: 0.03,
        duration_s: 2.5,
    };
    reference.validate().unwrap();
    let (start, end) = (reference.at(0.0), reference.at(2.5 - 1e-9));
    assert_eq!(
        (start.height_m, start.velocity_mps, start.acceleration_mps2),
        (0.5, 0.0, 0.0)
    );
    // A nanosecond before the end: within rates (0.5 m/s², 3 m/s³) times 1e-9.
    assert!((end.height_m - 0.1).abs() < 1e-9);
    assert!((end.velocity_mps + 0.03).abs() < 1e-8);
    assert!(end.acceleration_mps2.abs() < 1e-8);
    assert!((reference.at(3.5).height_m - 0.07).abs() < 1e-15);
    derivatives_agree(|t| Reference::Terminal(reference).at(t), 1.1);
}

fn derivatives_agree(at: impl Fn(f64) -> touchdown_flight::reference::ReferencePoint<f64>, t: f64) {
    let h = 1e-4;
    let (before, here, after) = (at(t - h), at(t), at(t + h));
    let velocity = (after.height_m - before.height_m) / (2.0 * h);
    let acceleration = (after.velocity_mps - before.velocity_mps) / (2.0 * h);
    // Central differences: h² / 6 times third derivatives below 10.
    assert!((velocity - here.velocity_mps).abs() < 2e-8);
    assert!((acceleration - here.acceleration_mps2).abs() < 2e-8);
}

#[test]
fn prop_settings_out_of_range_are_named() {
    let good = Terminal {
        start_height_m: 0.8,
        end_height_m: 0.1,
        sink_rate_mps: 0.03,
        duration_s: 2.5,
    };
    good.validate().unwrap();
    // 0.28 m/s is the mean rate; a terminal rate of 2.5 times that is the limit.
    for (bad, key) in [
        (
            Terminal {
                sink_rate_mps: 0.701,
                ..good
            },
            "reference.terminal.sink_rate_mps",
        ),
        (
            Terminal {
                sink_rate_mps: -0.01,
                ..good
            },
            "reference.terminal.sink_rate_mps",
        ),
        (
            Terminal {
                duration_s: 0.0,
                ..good
            },
            "reference.terminal.duration_s",
        ),
        (
            Terminal {
                end_height_m: 0.9,
                ..good
            },
            "reference.terminal.end_height_m",
        ),
    ] {
        let error = bad.validate().unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
    let filter = HarmonicFilter::new(3.0_f64);
    filter.validate().unwrap();
    for bad in [
        HarmonicFilter {
            lead_s: -0.1,
            ..filter
        },
        HarmonicFilter {
            lead_s: f64::NAN,
            ..filter
        },
        HarmonicFilter::new(0.0),
    ] {
        assert!(bad.validate().is_err(), "{bad:?}");
    }
}

#[test]
fn analytic_harmonic_filter_finds_the_acceleration() {
    let w = core::f64::consts::PI; // 0.5 Hz
    let filter = HarmonicFilter {
        lead_s: 0.0,
        ..HarmonicFilter::new(w)
    };
    filter.validate().unwrap();
    let mut state = filter.initial();
    let (amplitude, phase) = (0.05, 0.7);
    let mut worst: f64 = 0.0;
    for i in 0..=1000 {
        let t = 0.01 * f64::from(i);
        let velocity = amplitude * w * (w * t + phase).cos();
        let motion = filter.step(&mut state, velocity, if i == 0 { 0.0 } else { 0.01 });
        if t < 0.49 {
            assert_eq!(motion.acceleration_mps2, 0.0);
        }
        if t >= 6.0 {
            let truth = -amplitude * w * w * (w * t + phase).sin();
            worst = worst.max((motion.acceleration_mps2 - truth).abs());
        }
    }
    // The start's uncertainty, 0.3 m/s against 0.03 a sample, is outweighed by
    // 600 samples to 2e-5 of the amplitude 0.49, and process noise forgets more.
    assert!(worst < 2e-4, "{worst}");
}

#[test]
fn analytic_harmonic_filter_leads() {
    let w = core::f64::consts::PI;
    let filter = HarmonicFilter::new(w);
    let mut state = filter.initial();
    for i in 1..=1000 {
        let t = 0.01 * f64::from(i);
        let motion = filter.step(&mut state, 0.15 * (w * t).cos(), 0.01);
        if t > 6.0 {
            let ahead = w * (t + 0.09);
            // As above, in proportion.
            assert!((motion.velocity_mps - 0.15 * ahead.cos()).abs() < 1e-4);
            assert!((motion.acceleration_mps2 + 0.15 * w * ahead.sin()).abs() < 2e-4);
        }
    }
}

#[test]
fn prop_harmonic_filter_follows_a_change_of_phase() {
    let w = core::f64::consts::PI;
    let filter = HarmonicFilter::new(w);
    let mut state = filter.initial();
    for i in 1..=12_000 {
        let t = 0.01 * f64::from(i);
        let shift = if t < 100.0 { 0.0 } else { 1.0 };
        let motion = filter.step(&mut state, 0.15 * (w * t + shift).cos(), 0.01);
        if t > 119.0 {
            let truth = -0.15 * w * (w * (t + 0.09) + shift).sin();
            // Process over measurement noise (0.002 against 0.03 √0.01) gives a rate
            // of 0.67 1/s, halved over the two states: e^(-0.33 · 19) of the first
            // error 0.45 is 0.001. Without process noise 0.4 would be left.
            assert!((motion.acceleration_mps2 - truth).abs() < 3e-3);
        }
    }
}

#[test]
fn prop_harmonic_filter_survives_gaps_in_single_precision() {
    let w = core::f32::consts::PI;
    let filter = HarmonicFilter::<f32>::new(w);
    let mut state = filter.initial();
    for i in 1..=20_000_i16 {
        let t = 0.01 * f32::from(i);
        let velocity = if i % 7 == 0 {
            f32::NAN
        } else {
            0.15 * (w * (t % 2.0)).cos()
        };
        let motion = filter.step(&mut state, velocity, 0.01);
        assert!(motion.acceleration_mps2.is_finite());
        if t > 6.0 {
            let truth = -0.15 * w * (w * ((t + 0.09) % 2.0)).sin();
            // f32: the test's own time carries 1e-5 s of rounding at 200 s; the
            // filter averages it. 1 % of the amplitude 0.47.
            assert!((motion.acceleration_mps2 - truth).abs() < 5e-3);
        }
    }
}

#[test]
fn analytic_touchdown_is_interpolated() {
    let detector = TouchdownDetector::<f64>::default();
    let mut state = TouchdownState::default();
    // 0.30 m at 0.1 m/s, accelerating: v = -0.1 - 0.02 t, sampled at 0.3 s.
    let mut found = None;
    for i in 0..12 {
        let t = 0.3 * f64::from(i);
        let z = 0.3 - 0.1 * t;
        found = detector.step(&mut state, z, -0.1 - 0.02 * t, 0.3);
        assert_eq!(found.is_some(), t > 2.0);
    }
    let touchdown = found.unwrap();
    // A straight line is interpolated without error but rounding.
    assert!((touchdown.time_s - 2.0).abs() < 1e-14);
    assert!((touchdown.relative_velocity_mps + 0.14).abs() < 1e-14);
}

#[test]
fn prop_touchdown_skips_bad_samples_and_keeps_the_first() {
    let detector = TouchdownDetector::<f64>::default();
    let mut state = TouchdownState::default();
    assert!(detector.step(&mut state, 0.2, -0.1, 9.0).is_none());
    assert!(detector.step(&mut state, f64::NAN, -0.1, 0.5).is_none());
    let first = detector.step(&mut state, 0.05, -0.1, 1.0).unwrap();
    // 0.15 m in 1.5 s across the gap: 0.1 m after 1.0 s.
    assert!((first.time_s - 1.0).abs() < 1e-14);
    assert_eq!(detector.step(&mut state, 0.3, 0.1, 1.0), Some(first));
    assert_eq!(detector.step(&mut state, 0.05, -0.2, 1.0), Some(first));
}

#[test]
fn analytic_metrics_of_a_monotone_descent() {
    let reference = descent(0.5566, 0.5);
    let metrics = LandingMetrics::<f64>::default();
    let mut state = LandingMetricsState::default();
    let mut figures = LandingMetrics::figures(&state);
    for i in 0..1000 {
        let point = reference.at(0.01 * f64::from(i));
        figures = metrics.step(&mut state, point.height_m, point.velocity_mps, 0.01);
    }
    let t_l = reference.time_to_height_s(0.1).unwrap();
    // Interpolation: dt²/8 z'' / v below 1e-5 · 0.08 / 0.09 s.
    assert!((figures.t_l_s.unwrap() - t_l).abs() < 2e-5);
    let v_l = reference.at(t_l).velocity_mps.abs();
    assert!((figures.v_l_mps.unwrap() - v_l).abs() < 2e-6);
    // 0.5 to 0.1 m; trapezoid rule: dt²/12 (z''(T) - z''(0)) below 2e-6.
    assert!((figures.s_l_m - 0.4).abs() < 3e-6, "{}", figures.s_l_m);
}

#[test]
fn analytic_metrics_count_reversals() {
    let metrics = LandingMetrics::<f32>::default();
    let mut state = LandingMetricsState::default();
    let mut figures = LandingMetrics::figures(&state);
    for i in 0..=2000_i16 {
        let t = 0.01 * f32::from(i);
        let w = core::f32::consts::PI;
        figures = metrics.step(
            &mut state,
            0.3 + 0.05 * (w * t).sin(),
            0.05 * w * (w * t).cos(),
            0.01,
        );
    }
    // Ten periods of 4 · 0.05 m; trapezoid at the reversals and f32 below 1e-3.
    assert!((figures.s_l_m - 2.0).abs() < 1e-3);
    assert_eq!(figures.t_l_s, None);
}
