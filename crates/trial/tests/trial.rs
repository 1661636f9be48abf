//! The trial's invariants, units, windows and resampling.

use proptest::prelude::*;
use touchdown_trial::{Provenance, Source, Trial, TrialError, Unit, unit_of};

fn ramp(n: usize, period_s: f64) -> Trial {
    let time_s: Vec<f64> = (0..n).map(|i| i as f64 * period_s).collect();
    let value = time_s.iter().map(|t| 2.0 * t + 1.0).collect();
    Trial::new("ramp", time_s)
        .unwrap()
        .with_channel("height_m", value)
        .unwrap()
}

#[test]
fn analytic_bad_stamps_are_named() {
    assert_eq!(
        Trial::new("t", vec![0.0, 1.0, 1.0]).unwrap_err(),
        TrialError::TimeNotIncreasing {
            row: 2,
            previous: 1.0,
            found: 1.0
        }
    );
    let error = Trial::new("t", vec![0.0, f64::NAN]).unwrap_err();
    assert!(matches!(error, TrialError::TimeNotFinite { row: 1, .. }));
    let error = Trial::new("t", vec![f64::INFINITY]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "time_s, row 0: expected a finite stamp, found inf"
    );
}

#[test]
fn analytic_bad_channels_are_named() {
    let trial = ramp(3, 0.1);
    let error = trial
        .clone()
        .with_channel("thrust_n", vec![0.0])
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "channel \"thrust_n\": expected 3 rows as in time_s, found 1"
    );
    let error = trial
        .clone()
        .with_channel("x", vec![0.0, f64::NEG_INFINITY, 0.0]);
    assert!(matches!(error, Err(TrialError::Infinite { row: 1, .. })));
    let error = trial.clone().with_channel("height_m", vec![0.0; 3]);
    assert!(matches!(error, Err(TrialError::Duplicate { .. })));
    for name in ["", " x", "time_s", "a\nb"] {
        let error = trial.clone().with_channel(name, vec![0.0; 3]);
        assert!(
            matches!(error, Err(TrialError::ChannelName { .. })),
            "{name:?}"
        );
    }
    assert_eq!(
        trial.require("thrust_n").unwrap_err().to_string(),
        "trial \"ramp\" has no channel \"thrust_n\"; it has time_s, height_m"
    );
}

#[test]
fn analytic_insert_replaces_and_keeps_order() {
    let mut trial = ramp(2, 1.0);
    assert!(trial.insert("throttle", vec![0.0, 1.0]).unwrap().is_none());
    let old = trial.insert("height_m", vec![5.0, 6.0]).unwrap().unwrap();
    assert_eq!(old, [1.0, 3.0]);
    let names: Vec<&str> = trial.channels().map(|(name, _)| name).collect();
    assert_eq!(names, ["height_m", "throttle"]);
    assert_eq!(trial.channel("time_s").unwrap(), trial.time_s());
}

#[test]
fn analytic_units_follow_the_name() {
    for (name, unit) in [
        ("time_s", Unit::Second),
        ("thrust_n", Unit::Newton),
        ("height_m", Unit::Metre),
        ("vehicle_velocity_mps", Unit::MetrePerSecond),
        ("acceleration_mps2", Unit::MetrePerSecondSquared),
        ("battery_v", Unit::Volt),
        ("rotor_rpm", Unit::RevolutionPerMinute),
        ("rotor_rpm_4", Unit::RevolutionPerMinute),
        ("torque_n_m", Unit::NewtonMetre),
        ("current_a", Unit::Ampere),
        ("throttle", Unit::Dimensionless),
        ("throttle_1", Unit::Dimensionless),
        ("_n", Unit::Dimensionless),
        ("n", Unit::Dimensionless),
    ] {
        assert_eq!(unit_of(name), unit, "{name}");
    }
}

#[test]
fn analytic_period_is_the_median_step() {
    let odd = Trial::new("t", vec![0.0, 1.0, 2.0, 9.0]).unwrap();
    assert_eq!(odd.period_s(), Some(1.0));
    let even = Trial::new("t", vec![0.0, 1.0, 4.0]).unwrap();
    assert_eq!(even.period_s(), Some(2.0));
    assert_eq!(even.duration_s(), 4.0);
    assert!(!even.is_uniform(0.4) && even.is_uniform(0.5));
    let one = Trial::new("t", vec![3.0]).unwrap();
    assert_eq!((one.period_s(), one.duration_s()), (None, 0.0));
    assert!(one.is_uniform(0.0) && !one.is_empty());
}

#[test]
fn analytic_window_takes_both_ends() {
    let part = ramp(5, 1.0).window(1.0, 3.0).unwrap();
    assert_eq!(part.time_s(), [1.0, 2.0, 3.0]);
    assert_eq!(part.channel("height_m").unwrap(), [3.0, 5.0, 7.0]);
    assert_eq!(part.provenance().notes, ["window 1 s to 3 s"]);
    assert!(ramp(5, 1.0).window(10.0, 20.0).unwrap().is_empty());
    assert_eq!(ramp(5, 1.0).window(2.0, f64::INFINITY).unwrap().len(), 3);
    assert!(matches!(
        ramp(5, 1.0).window(3.0, 1.0),
        Err(TrialError::Window { .. })
    ));
}

#[test]
fn analytic_resampling_a_line_gives_the_line() {
    let fine = ramp(11, 0.1).resample_linear(0.025).unwrap();
    assert_eq!(fine.len(), 41);
    for (t, h) in fine.time_s().iter().zip(fine.channel("height_m").unwrap()) {
        // A line is its own interpolant; what is left is rounding of a few operations near 3,
        // and the shift of at most 1e-6 periods by which a grid point takes a sample as its own.
        assert!((h - (2.0 * t + 1.0)).abs() < 1e-7, "{t} {h}");
    }
}

#[test]
fn analytic_resampling_does_not_bridge_gaps() {
    let mut trial = ramp(40, 0.1);
    let mut holed = trial.channel("height_m").unwrap().to_vec();
    holed[5] = f64::NAN;
    // A load cell that reports in every fourth row.
    let slow: Vec<f64> = (0..40)
        .map(|i| if i % 4 == 0 { i as f64 } else { f64::NAN })
        .collect();
    trial.insert("height_m", holed).unwrap();
    trial.insert("thrust_n", slow).unwrap();
    let fine = trial.resample_linear(0.05).unwrap();
    let height = fine.channel("height_m").unwrap();
    let missing: Vec<usize> = (0..height.len()).filter(|&i| height[i].is_nan()).collect();
    assert_eq!(missing, [9, 10, 11]);
    // Joined between its reports, absent after the last (row 36, grid point 72).
    let thrust = fine.channel("thrust_n").unwrap();
    assert!(thrust[..=72].iter().all(|v| !v.is_nan()));
    assert!(thrust[73..].iter().all(|v| v.is_nan()));
    assert!((thrust[3] - 1.5).abs() < 1e-12); // rounding of numbers near 1
    let wide = trial.resample_linear_within(0.05, 0.21).unwrap();
    assert!(!wide.channel("height_m").unwrap()[10].is_nan());
    assert!(wide.channel("thrust_n").unwrap()[3].is_nan());
}

#[test]
fn analytic_resampling_does_not_bridge_a_hole_in_the_record() {
    let mut time_s: Vec<f64> = (0..10).map(|i| i as f64 * 0.1).collect();
    time_s.extend((0..10).map(|i| 5.0 + i as f64 * 0.1));
    let trial = Trial::new("hole", time_s.clone())
        .unwrap()
        .with_channel("throttle", time_s)
        .unwrap();
    let even = trial.resample_linear(0.1).unwrap();
    let throttle = even.channel("throttle").unwrap();
    assert!(!throttle[9].is_nan() && throttle[20].is_nan() && !throttle[52].is_nan());
}

#[test]
fn analytic_bad_periods_are_errors() {
    for period_s in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-12] {
        assert!(
            matches!(
                ramp(5, 1.0).resample_linear(period_s),
                Err(TrialError::Period { .. })
            ),
            "{period_s}"
        );
    }
    let late = Trial::new("late", vec![1e17, 1e17 + 64.0]).unwrap();
    assert!(late.resample_linear(1.0).is_err());
    assert!(ramp(5, 1.0).resample_linear_within(0.1, -0.1).is_err());
}

#[test]
fn analytic_provenance_is_kept() {
    let trial = ramp(3, 1.0)
        .with_provenance(Provenance::new(Source::VirtualRig {
            seed: 7,
            scenario: "ramp".into(),
        }))
        .with_name("other");
    let part = trial.window(0.0, 1.0).unwrap();
    assert_eq!(part.name(), "other");
    assert_eq!(part.provenance().source, trial.provenance().source);
    assert!(trial.provenance().notes.is_empty() && part.provenance().notes.len() == 1);
}

proptest! {
    #[test]
    fn prop_resampled_values_lie_between_the_samples(
        steps in prop::collection::vec(0.01_f64..1.0, 1..40),
        values in prop::collection::vec(prop::option::weighted(0.8, -1e3_f64..1e3), 41),
        period_s in 0.01_f64..0.5,
    ) {
        let mut time_s = vec![0.0];
        for step in &steps {
            time_s.push(time_s[time_s.len() - 1] + step);
        }
        let values: Vec<f64> = values[..time_s.len()].iter().map(|v| v.unwrap_or(f64::NAN)).collect();
        let (low, high) = values.iter().filter(|v| !v.is_nan())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let trial = Trial::new("t", time_s).unwrap().with_channel("x", values).unwrap();
        let even = trial.resample_linear(period_s).unwrap();
        // Grid stamps are products t0 + k·T: each is rounded to about 1e-14 of at most 40 s.
        prop_assert!(even.is_uniform(1e-9));
        for v in even.channel("x").unwrap().iter().filter(|v| !v.is_nan()) {
            // A convex combination, but for rounding of numbers up to 1e3.
            prop_assert!(*v >= low - 1e-9 && *v <= high + 1e-9);
        }
    }
}
