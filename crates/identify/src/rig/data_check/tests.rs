use super::*;
use crate::settings::IdentificationSettings;

/// Eight logs of 12 s at 100 Hz: a throttle each, a deck that moves by three sines, the static law of height, 0.05 N of
/// noise.
fn trials() -> Vec<GroundTrial> {
    (0..8).map(trial).collect()
}

fn trial(index: u32) -> GroundTrial {
    let i = f64::from(index);
    let time_s: Vec<f64> = (0..1200).map(|k| 0.01 * f64::from(k)).collect();
    let rates = [0.7 + 0.3 * i, 2.1 + 0.5 * i, 5.0 + 0.4 * i];
    let height = |t: f64| 0.35 + 0.08 * rates.iter().map(|w| (w * t + i).sin()).sum::<f64>();
    let velocity = |t: f64| -0.08 * rates.iter().map(|w| w * (w * t + i).cos()).sum::<f64>();
    let free_n = 10.0 + 0.7 * i;
    let lift = |z: f64| free_n * (0.12 / (1.0 + (z / 0.2).powi(2)) - 0.01);
    let rows = time_s.len();
    let over = |f: &dyn Fn(f64) -> f64| time_s.iter().map(|t| f(*t)).collect::<Vec<f64>>();
    GroundTrial {
        name: format!("t{index}"),
        throttle: vec![0.4 + 0.03 * i; rows],
        height_m: over(&height),
        deck_velocity_mps: over(&velocity),
        vehicle_velocity_mps: vec![0.0; rows],
        free_air_thrust_n: vec![free_n; rows],
        // The sine is of no period of the motion.
        force_n: over(&|t| lift(height(t)) + 0.05 * (171.3 * t).sin()),
        truth_n: None,
        time_s,
    }
}

fn of(change: impl Fn(&mut GroundTrial)) -> Result<Vec<DataWarning>> {
    let mut trials = trials();
    trials.iter_mut().for_each(change);
    check(&trials, &IdentificationSettings::default().ground_effect)
}

/// The warnings as sentences.
fn warned(change: impl Fn(&mut GroundTrial)) -> String {
    let warnings = of(change).unwrap();
    let sentences: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    sentences.join("\n")
}

fn measured(trial: &mut GroundTrial, change: impl Fn(f64) -> f64) {
    let pairs = trial.force_n.iter_mut().zip(&trial.free_air_thrust_n);
    pairs.for_each(|(force, free)| *force = change(*force + free) - free);
}

#[test]
fn prop_a_log_as_it_should_be_has_no_warning() {
    assert_eq!(of(|_| {}).unwrap(), []);
    // A tenth of the rate, 10 Hz, 5 mm of noise of the height: still no wrong sign.
    let slow = |t: &mut GroundTrial| {
        let each = |c: &mut Vec<f64>| *c = c.iter().copied().step_by(10).collect();
        for column in [
            &mut t.time_s,
            &mut t.height_m,
            &mut t.deck_velocity_mps,
            &mut t.vehicle_velocity_mps,
            &mut t.free_air_thrust_n,
            &mut t.force_n,
        ] {
            each(column);
        }
        let noise = t.time_s.iter().map(|t| 0.005 * (171.3 * t).sin());
        t.height_m.iter_mut().zip(noise).for_each(|(z, n)| *z += n);
    };
    assert_eq!(of(slow).unwrap(), []);
}

#[test]
fn prop_thrust_of_another_unit_sign_or_zero_is_refused_by_its_cause() {
    let refused = |change: fn(f64) -> f64| of(|t| measured(t, change)).unwrap_err().to_string();
    for (change, words) in [
        (
            (|f| f / 9.80665e-3) as fn(f64) -> f64,
            "'9.80665e-3 * \"thrust_n\"'",
        ),
        (|f| f / 9.80665, "'9.80665 * \"thrust_n\"'"),
        (
            |f| -f,
            "inverted? Then write into the map: thrust_n = '-\"thrust_n\"'",
        ),
        (|f| f / 4.0, "'4 * \"thrust_n\"'"),
        // The median of the free-air thrusts, 12.45 N, less the lift of 2 %: the tare is 12 N within a few tenths.
        (
            |f| f - 12.2,
            "set to zero while the rotors turned? Then write into the map: thrust_n = '\"thrust_n\" + 1",
        ),
    ] {
        let error = refused(change);
        assert!(error.contains(words), "{error}");
        assert!(
            error.starts_with("t0 and 7 more logs: expected a measured thrust"),
            "{error}"
        );
    }
    // A fifth less than the card: another battery or vehicle. No card of the ground effect expresses that, so there is a warning.
    let text = warned(|t| measured(t, |f| 0.8 * f));
    assert!(
        text.contains("expected 0.90 to 1.60. Check that the thrust card"),
        "{text}"
    );
}

#[test]
fn analytic_a_throttle_in_percent_is_refused() {
    let percent = |t: &mut GroundTrial| t.throttle.iter_mut().for_each(|s| *s *= 100.0);
    let error = of(percent).unwrap_err().to_string();
    assert!(
        error.contains(
            "is it in percent? Then write into the map: throttle = '0.01 * \"throttle\"'"
        ),
        "{error}"
    );
}

#[test]
fn prop_heights_of_another_unit_sign_or_zero_are_refused_or_warned_of() {
    let scaled = |t: &mut GroundTrial, by: f64| t.height_m.iter_mut().for_each(|z| *z *= by);
    let shifted = |t: &mut GroundTrial, by: f64| t.height_m.iter_mut().for_each(|z| *z += by);
    for (by, words) in [
        (1000.0, "height_m = '0.001 * \"height_m\"'"),
        (100.0, "in centimetres with 0.01"),
        (
            -1.0,
            "counted downwards? Then write into the map: height_m = '-\"height_m\"'",
        ),
    ] {
        let error = of(|t| scaled(t, by)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let error = of(|t| shifted(t, 2.5)).unwrap_err().to_string();
    assert!(
        error.contains("expected heights below 0.90 m") && error.contains("all above 2.6"),
        "{error}"
    );
    let text = warned(|t| shifted(t, -0.25));
    assert!(
        text.contains("the rotors cannot be below the deck"),
        "{text}"
    );
}

#[test]
fn prop_velocities_that_do_not_fit_the_height_are_warned_of() {
    let deck = |t: &mut GroundTrial, by: f64| t.deck_velocity_mps.iter_mut().for_each(|v| *v *= by);
    let text = warned(|t| deck(t, -1.0));
    assert!(
        text.contains("write into the map: deck_velocity_mps = '-\"deck_velocity_mps\"'"),
        "{text}"
    );
    let text = warned(|t| deck(t, 1000.0));
    assert!(
        text.contains("deck_velocity_mps = '1.000e-3 * \"deck_velocity_mps\"'"),
        "{text}"
    );
    let text = warned(|t| deck(t, 0.0));
    assert!(text.contains("are missing or zero"), "{text}");
    // The vehicle moves in place of the deck, and its velocity is counted downwards.
    let swap =
        |t: &mut GroundTrial| std::mem::swap(&mut t.deck_velocity_mps, &mut t.vehicle_velocity_mps);
    let text = warned(swap);
    assert!(text.contains("'-\"vehicle_velocity_mps\"'"), "{text}");
    let text = warned(|t| {
        let times = t.time_s.clone();
        t.deck_velocity_mps = times.iter().map(|t| 0.3 * (9.7 * t).sin()).collect();
    });
    assert!(text.contains("the height moves, but not by"), "{text}");
    // A height at rest with noise needs no velocity.
    let text = warned(|t| {
        deck(t, 0.0);
        t.height_m = t
            .time_s
            .iter()
            .map(|t| 0.3 + 0.01 * (171.3 * t).sin())
            .collect();
    });
    assert_eq!(text, "");
}
