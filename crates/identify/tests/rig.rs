//! The lag form on trials of a force rig that follow it, and the warnings where they do not identify it.

use touchdown_identify::rig::{GroundTrial, fit};
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, Result};
use touchdown_model::{Form, Term};

const TAU_S: f64 = 0.15;
const H: [f64; 4] = [-0.01, 0.06, 0.12, 0.04];
const K: [f64; 2] = [-0.03, 0.09];
const LENGTHS_M: [f64; 3] = [0.08, 0.2, 0.45];

/// The bounded functions of height.
fn psi(z: f64) -> [f64; 3] {
    LENGTHS_M.map(|l| 1.0 / (1.0 + (z / l).powi(2)))
}

fn weighted(weights: &[f64], values: &[f64]) -> f64 {
    weights.iter().zip(values).map(|(w, v)| w * v).sum()
}

/// A trial of 30 s: the deck moves by three sines of 0.1 to 1.5 Hz, the force follows the lag form in steps of a millisecond,
/// and `rate_hz` rows per second are logged with noise of 0.02 N.
fn trial(index: u32, rate_hz: usize) -> GroundTrial {
    let i = f64::from(index);
    let rates = [0.7 + 0.3 * i, 4.1 + 0.2 * i, 8.4 - 0.3 * i];
    let height = |t: f64| 0.35 + 0.08 * rates.iter().map(|w| (w * t + 1.7 * i).sin()).sum::<f64>();
    let velocity = |t: f64| {
        -0.08
            * rates
                .iter()
                .map(|w| w * (w * t + 1.7 * i).cos())
                .sum::<f64>()
    };
    let static_ratio = |t: f64| H[0] + weighted(&H[1..], &psi(height(t)));
    let free_n = 10.0 + 0.5 * i;
    let mut g = static_ratio(0.0);
    let mut rows = Vec::new();
    for step in 0..30_000_usize {
        let t = 0.001 * step as f64;
        if step % (1000 / rate_hz) == 0 {
            let k = K[0] + K[1] * psi(height(t))[2];
            let noise = 0.02 * 1.41 * (171.3 * t + i).sin();
            rows.push((t, free_n * (g + k * velocity(t)) + noise));
        }
        let middle = static_ratio(t + 0.0005);
        g = middle + (g - middle) * (-0.001 / TAU_S).exp();
    }
    let time_s: Vec<f64> = rows.iter().map(|r| r.0).collect();
    GroundTrial {
        name: format!("t{index}"),
        throttle: vec![0.5; time_s.len()],
        height_m: time_s.iter().map(|t| height(*t)).collect(),
        deck_velocity_mps: time_s.iter().map(|t| velocity(*t)).collect(),
        vehicle_velocity_mps: vec![0.0; time_s.len()],
        free_air_thrust_n: vec![free_n; time_s.len()],
        force_n: rows.iter().map(|r| r.1).collect(),
        truth_n: None,
        time_s,
    }
}

fn trials(count: u32, rate_hz: usize) -> Vec<GroundTrial> {
    (0..count).map(|i| trial(i, rate_hz)).collect()
}

fn lag(trials: &[GroundTrial]) -> Result<FittedCard> {
    lag_with(&IdentificationSettings::default(), trials)
}

fn lag_with(settings: &IdentificationSettings, trials: &[GroundTrial]) -> Result<FittedCard> {
    fit(Form::Lag, trials, settings, &Origin::default())
}

fn term<'a>(fitted: &'a FittedCard, of: &str) -> &'a Term {
    fitted.card.terms.iter().find(|t| t.of == of).unwrap()
}

fn warned(fitted: &FittedCard, words: &str) -> bool {
    fitted.card.warnings.iter().any(|w| w.contains(words))
}

#[test]
fn regress_the_lag_of_slow_logs_is_not_short() {
    for (rate_hz, tolerance_s) in [
        // The cubic between rows of 0.1 s leaves 0.3 % at 1.3 Hz. Lines cost 4 to 7 ms.
        (10, 2e-3),
        // Lines between rows of 0.01 s leave 0.07 %; noise of 0.02 N costs less than 0.5 ms.
        (100, 1e-3),
    ] {
        let fitted = lag(&trials(10, rate_hz)).unwrap();
        let tau = term(&fitted, "tau");
        assert!(
            (tau.value - TAU_S).abs() < tolerance_s,
            "{rate_hz} Hz: {tau:?}"
        );
    }
}

#[test]
fn analytic_a_small_vehicle_has_the_model_of_a_large_one_at_its_size() {
    // A rotor radius of 0.03 m in place of 0.12 m, and a fiftieth of the thrust: 0.2 to 0.3 N.
    let (size, force) = (0.25, 0.02);
    let mut trials = trials(10, 100);
    for trial in &mut trials {
        let scaled = |values: &mut Vec<f64>, by: f64| values.iter_mut().for_each(|v| *v *= by);
        scaled(&mut trial.height_m, size);
        scaled(&mut trial.deck_velocity_mps, size);
        scaled(&mut trial.free_air_thrust_n, force);
        scaled(&mut trial.force_n, force);
    }
    let mut settings = IdentificationSettings::default();
    settings.ground_effect.rotor_radius_m *= size;
    let fitted = lag_with(&settings, &trials).unwrap();
    // As of the large vehicle.
    let tau_s = term(&fitted, "tau").value;
    assert!((tau_s - TAU_S).abs() < 1e-3, "{tau_s}");
    let h = fitted.card.terms.iter().filter(|t| t.of == "h");
    let found: Vec<f64> = h.map(|t| t.value).collect();
    // Noise of 0.02 N in 10 N, over 10 logs, leaves 0.001 to each; they trade off by some times that.
    for (value, truth) in found.iter().zip(H) {
        assert!((value - truth).abs() < 0.01, "{found:?}");
    }
    // With the noise of a large load cell, priors would weigh more than the data.
    settings.shooting.noise_n = Some(0.1);
    let pulled = lag_with(&settings, &trials).unwrap();
    let error_s = (term(&pulled, "tau").value - TAU_S).abs();
    assert!(error_s > 2e-3, "{error_s}");
}

#[test]
fn regress_coefficients_of_a_velocity_that_is_missing_have_no_interval() {
    let mut trials = trials(10, 100);
    for trial in &mut trials {
        trial.deck_velocity_mps.fill(0.0);
    }
    let fitted = lag(&trials).unwrap();
    for of_k in fitted.card.terms.iter().filter(|t| t.of == "k") {
        assert_eq!((of_k.value, of_k.std_error, of_k.ci95), (0.0, None, None));
    }
    assert!(term(&fitted, "h").ci95.is_some());
    assert!(
        warned(&fitted, "zero throughout the data: k:1, k:psi3"),
        "{:?}",
        fitted.card.warnings
    );
    assert!(warned(
        &fitted,
        "`deck_velocity_mps` and `vehicle_velocity_mps` are missing or zero"
    ));
}

#[test]
fn regress_too_few_logs_for_intervals_are_told() {
    let few = lag(&trials(7, 100)).unwrap();
    assert!(few.card.terms.iter().all(|t| t.ci95.is_none()));
    assert!(
        warned(&few, "7 are too few for 7 coefficients. Record at least 8"),
        "{:?}",
        few.card.warnings
    );
    let enough = lag(&trials(8, 100)).unwrap();
    assert!(enough.card.terms.iter().all(|t| t.ci95.is_some()));
    assert!(!warned(&enough, "no intervals"));
}

#[test]
fn regress_thrust_in_grams_makes_no_card() {
    let mut trials = trials(8, 100);
    for trial in &mut trials {
        let pairs = trial.force_n.iter_mut().zip(&trial.free_air_thrust_n);
        pairs.for_each(|(f, free)| *f = (*f + free) / 9.80665e-3 - free);
    }
    let error = lag(&trials).unwrap_err().to_string();
    assert!(error.contains("Is `thrust_n` in grams?"), "{error}");
}

#[test]
fn prop_rotors_that_never_turned_are_one_clear_error() {
    let mut trials = trials(8, 100);
    for trial in &mut trials {
        trial.throttle.fill(0.0);
        trial.free_air_thrust_n.fill(0.0);
    }
    let error = lag(&trials).unwrap_err().to_string();
    assert!(error.contains("expected"), "{error}");
}
