//! Settings that cannot be, and limits that every plan keeps.

use proptest::prelude::*;
use touchdown_lander::planner::{DeckOutlook, Planner, Verdict};

use crate::{TAU, planner, sampled, sine};

#[test]
fn analytic_settings_are_checked() {
    let refused = |change: fn(&mut Planner<f64>), key: &str| {
        let mut bad = planner();
        change(&mut bad);
        let error = bad.validate().unwrap_err().to_string();
        assert!(error.starts_with(key), "{error}");
    };
    refused(|p| p.horizon_s = 3.0, "planner.descent.duration_max_s");
    refused(|p| p.horizon_s = 1000.0, "planner.horizon_s");
    refused(|p| p.wait_s = f64::NAN, "planner.wait_s");
    refused(
        |p| p.descent.sink_rate_max_mps = 0.2,
        "planner.descent.sink_rate_max_mps",
    );
    refused(
        |p| p.descent.duration_min_s = 4.0,
        "planner.descent.duration_min_s",
    );
    refused(
        |p| p.quiescence.acceleration_min_mps2 = 2.0,
        "planner.quiescence.acceleration_min_mps2",
    );
    refused(
        |p| p.quiescence.tilt_rad = 0.0,
        "planner.quiescence.tilt_rad",
    );
}

proptest! {
    #[test]
    fn prop_every_plan_keeps_its_limits(
        tones in proptest::collection::vec((0.0..0.3_f64, 0.3..4.0_f64, 0.0..TAU), 1..4),
        tilt in 0.0..0.3_f64,
        sd in 0.0..0.2_f64,
        height in 0.05..1.6_f64,
        waited in 0.0..60.0_f64,
        hurry in any::<bool>(),
        hole in 0.0..12.0_f64,
    ) {
        let planner = planner();
        let deck = |t: f64| {
            let mut at = DeckOutlook {
                tilt_rad: tilt * (1.3 * t).sin(),
                velocity_sd_mps: sd * t.min(3.0),
                ..DeckOutlook::default()
            };
            for &(a, w, phase) in &tones {
                let one = sine(a, w, phase)(t);
                at.velocity_mps += one.velocity_mps;
                at.acceleration_mps2 += one.acceleration_mps2;
            }
            if (t - hole).abs() < 0.3 {
                at.acceleration_sd_mps2 = f64::NAN;
            }
            at
        };
        match planner.assess(waited, height, hurry, &deck) {
            Verdict::Go(plan) => {
                prop_assert!(plan.reference.validate().is_ok());
                let d = plan.reference.duration_s;
                // From higher than 0.85 m over the end all takes longer, by the root.
                let factor = ((height - 0.1) / 0.85).max(1.0).sqrt();
                prop_assert!(d >= 2.2 * factor - 1e-9 && d <= 3.5 * factor + 1e-9);
                let (speed, acceleration) = sampled(&plan);
                prop_assert!(speed <= 0.7 * factor + 1e-9 && acceleration <= 3.5 + 1e-9);
                prop_assert!((d - hole).abs() > 0.3);
                prop_assert!(plan.severity.is_finite());
                prop_assert_eq!(plan.quiescent, plan.severity <= 1.0);
                // Something other than quiet only when the end of patience, 30 s, is within the
                // horizon: 10 s less a descent of at least 2.2 s, and a step of the grid.
                prop_assert!(plan.quiescent || hurry || waited > 22.2 - 10.0 / 128.0);
            }
            Verdict::Wait { .. } => prop_assert!(!hurry && waited < 30.0),
            Verdict::Blind | Verdict::OutOfReach => {}
        }
    }
}

#[test]
fn analytic_a_descent_from_any_hold_height_is_planned() {
    let planner = planner();
    let still = |_: f64| DeckOutlook::default();
    for height_m in [0.8_f64, 1.5, 2.0, 3.0, 6.0] {
        let verdict = planner.assess(0.0, height_m, false, &still);
        let plan = verdict
            .plan()
            .unwrap_or_else(|| panic!("{height_m}: {verdict:?}"));
        // The acceleration of a quintic is its way over T² times a constant: with T growing as
        // the root of the way it stays that of the shortest descent from 0.95 m, 1.03 m/s².
        let (_, acceleration_mps2) = sampled(&plan);
        assert!(acceleration_mps2 < 1.1, "{height_m}: {acceleration_mps2}");
    }
}
