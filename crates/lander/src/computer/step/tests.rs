//! Each part of a step on its own, against hand-computed figures.

use touchdown_flight::{Attitude, Vector};

use crate::computer::tests::{DT, State, computer};
use crate::computer::{Computer, NormalReading, Sensed};
use crate::estimate::deck::{DeckEstimator, DeckEstimatorState, DeckMotionPrediction, Harmonic};
use crate::estimate::relative::{ImuSample, Reading, RelativeEstimate, TagReading};
use crate::space_controller::Motion;
use crate::state_machine::OperatorRequest;

/// A hovering vehicle's inertial unit, and the deck's normal where it is seen.
fn sensed(normal: Option<Vector<f64>>) -> Sensed<'static, f64> {
    Sensed {
        imu: ImuSample {
            specific_force_mps2: Vector::UP * 9.81,
            attitude: Attitude::LEVEL,
        },
        readings: &[],
        deck_normal: normal.map(|normal| NormalReading { normal, age_s: 0.0 }),
        battery_share: 1.0,
        contact: None,
        request: OperatorRequest::None,
    }
}

/// The deck estimator after a minute of a heave.
fn watched(
    estimator: &DeckEstimator<f64>,
    heave_m: impl Fn(f64) -> f64,
) -> DeckEstimatorState<f64> {
    watched_for(60, estimator, heave_m)
}

fn watched_for(
    seconds: u32,
    estimator: &DeckEstimator<f64>,
    heave_m: impl Fn(f64) -> f64,
) -> DeckEstimatorState<f64> {
    let mut state = estimator.initial();
    for i in 0..100 * seconds {
        estimator.step(&mut state, Some(heave_m(f64::from(i) * DT)), DT);
    }
    assert!(state.count() > 0);
    state
}

#[test]
fn analytic_after_a_gap_one_normal_counts_for_one_filter_time() {
    let computer = computer();
    let mut state: State = computer.initial(0.5);
    for _ in 0..500 {
        computer.estimate(&mut state, &sensed(None), DT);
    }
    assert_eq!(state.normal, Vector::UP);
    // The camera looks along the body's axes but for the attitude in the settings.
    let tilted = Vector::new(0.1, 0.0, 1.0);
    let seen = computer.relative.tag.attitude.unrotate(tilted);
    computer.estimate(&mut state, &sensed(Some(seen)), DT);
    let share = 1.0 - (-1.0_f64).exp();
    let whole = tilted.direction().unwrap();
    // The gap of 5 s counts as one time constant: 63 % of the way, not all of it.
    assert!(
        (state.normal.x - share * whole.x).abs() < 1e-12,
        "{:?}",
        state.normal
    );
    assert!((state.normal.z - (1.0 + share * (whole.z - 1.0))).abs() < 1e-12);
    // The next reading, one step later, counts for that step alone.
    let before = state.normal.x;
    computer.estimate(&mut state, &sensed(Some(seen)), DT);
    let step = 1.0 - (-DT / computer.normal_filter_s).exp();
    assert!((state.normal.x - before - step * (whole.x - before)).abs() < 1e-12);
    let tilt_rad = state.normal.x.atan2(state.normal.z);
    assert!((state.tilt_rad - tilt_rad).abs() < 1e-12);
}

#[test]
fn analytic_a_deck_too_fast_to_land_on_is_followed_at_the_speed_limit() {
    let computer = computer();
    let limit_mps = computer.state_machine.deck_speed_mps;
    let acting_s = computer.guidance.acting_s;
    for (amplitude_m, w) in [(0.1, 2.0), (1.2, 1.5)] {
        let mut state: State = computer.initial(0.5);
        state.deck = watched(&computer.deck, |t| amplitude_m * (w * t).sin());
        let mut estimate = computer.relative.ahead(&state.relative, 0.0);
        estimate.deck_velocity_mps = Vector::UP * (amplitude_m * w);
        computer.watch_sea(&mut state, &estimate, DT);
        let whole = computer.deck_ahead(&state, acting_s).acceleration_mps2;
        let speed_mps: f64 = (0..state.deck.count())
            .filter_map(|k| state.deck.harmonic(k))
            .map(|h| h.amplitude_m * h.angular_frequency)
            .sum();
        assert!((speed_mps - amplitude_m * w).abs() < 0.05 * amplitude_m * w);
        let slowed = computer.deck_acceleration_ahead(&state);
        let expected = whole * (limit_mps / speed_mps).min(1.0);
        assert!((slowed - expected).abs() < 1e-12, "{slowed} {expected}");
        // 0.2 m/s is followed whole, 1.8 m/s is not.
        assert_eq!(slowed == whole, amplitude_m * w < limit_mps);
        assert!(whole.abs() > 1e-3);
    }
}

#[test]
fn prop_a_change_of_latency_forgets_the_deck_for_a_second() {
    let computer = computer();
    let mut state: State = computer.initial(0.5);
    let deck = watched(&computer.deck, |t| 0.1 * (2.0 * t).sin());
    // Half a second after a change nothing that is seen is kept.
    state.deck = deck;
    state.mistimed_s = 0.5;
    assert!(!computer.estimate_latency(&mut state, &[], DT));
    assert_eq!((state.deck.count(), state.deck.observed_s()), (0, 0.0));
    assert!((state.mistimed_s - 0.51).abs() < 1e-12);
    // After the second it is.
    state.deck = deck;
    state.mistimed_s = 0.995;
    computer.estimate_latency(&mut state, &[], DT);
    assert_eq!(state.deck.count(), deck.count());
    // At the start nothing was mistimed.
    let mut fresh: State = computer.initial(0.5);
    fresh.deck = deck;
    computer.estimate_latency(&mut fresh, &[], DT);
    assert_eq!(fresh.deck.count(), deck.count());
}

#[test]
fn analytic_a_latency_that_is_found_is_reported_once_and_forgets_the_deck() {
    let computer = computer();
    let mut state: State = computer.initial(0.5);
    let deck = watched(&computer.deck, |t| 0.1 * (2.0 * t).sin());
    state.deck = deck;
    // A swing of 3 cm at 5 rad/s; a view every third step, 0.1 s later than its stamp says.
    let (w, age_s, hidden_s) = (5.0_f64, 0.04, 0.1);
    let place = |t: f64| 0.03 * (w * t).sin();
    let tilted = |t: f64| {
        let tilt_rad = (-w * w * place(t) / 9.81).atan();
        Attitude::from_rotation_vector(Vector::new(0.0, tilt_rad, 0.0))
    };
    let mut changes = 0;
    for step in 1..=1000 {
        let t = DT * f64::from(step);
        let sampled = t - computer.relative.imu.delay_s;
        let felt = Vector::new(-w * w * place(sampled), 0.0, 9.81);
        let imu = ImuSample {
            specific_force_mps2: tilted(sampled).unrotate(felt),
            attitude: tilted(sampled),
        };
        computer.relative.step(&mut state.relative, &imu, &[], DT);
        let seen = (step % 3 == 0).then(|| {
            let then = t - age_s - hidden_s;
            let body = tilted(then).unrotate(Vector::new(-place(then), 0.0, -0.8));
            let position = computer.relative.tag.attitude.unrotate(body);
            Reading::Tag(TagReading {
                position_m: position,
                covariance_m2: [[0.0; 3]; 3],
                age_s,
            })
        });
        changes += u32::from(computer.estimate_latency(&mut state, seen.as_slice(), DT));
        if changes == 0 {
            assert_eq!(state.deck.count(), deck.count(), "{t}");
        }
    }
    assert!((state.latency.latency_s() - hidden_s).abs() < 0.01);
    // From none to 0.1 s: one change above 30 ms; what the deck did before it is forgotten.
    assert_eq!(changes, 1);
    assert_eq!(state.deck.count(), 0);
}

#[test]
fn analytic_before_the_deck_is_known_its_speed_is_two_standard_deviations() {
    let computer = computer();
    let state: State = computer.initial(0.5);
    let now = DeckMotionPrediction {
        velocity_sd_mps: 0.4,
        ..DeckMotionPrediction::default()
    };
    let mut estimate = computer.relative.ahead(&state.relative, 0.0);
    estimate.deck_velocity_mps = Vector::ZERO;
    let speed =
        |estimate: &RelativeEstimate<f64>| computer.greatest_deck_speed(&state, &now, estimate);
    assert_eq!(speed(&estimate), 0.8);
    estimate.deck_velocity_mps = Vector::UP * -1.5;
    assert_eq!(speed(&estimate), 1.5);
    // Once harmonics are known: all at their fastest at once.
    let mut known = state;
    known.deck = watched(&computer.deck, |t| 0.2 * (1.5 * t).sin());
    estimate.deck_velocity_mps = Vector::ZERO;
    computer.watch_sea(&mut known, &estimate, DT);
    let fastest = computer.greatest_deck_speed(&known, &now, &estimate);
    assert!((fastest - 0.3).abs() < 0.015, "{fastest}");
}

/// Mean frequency of the harmonics and their width about it, weighted by power, in two passes.
fn mean_and_width(deck: &DeckEstimatorState<f64>) -> (f64, f64) {
    let harmonics = || (0..deck.count()).filter_map(|k| deck.harmonic(k));
    let power = |h: &Harmonic<f64>| (h.amplitude_m * h.angular_frequency).powi(2);
    let total: f64 = harmonics().map(|h| power(&h)).sum();
    let mean = harmonics()
        .map(|h| power(&h) * h.angular_frequency)
        .sum::<f64>()
        / total;
    let square =
        |h: &Harmonic<f64>| (h.angular_frequency - mean).powi(2) + h.angular_frequency_sd.powi(2);
    let variance = harmonics().map(|h| power(&h) * square(&h)).sum::<f64>() / total;
    (mean, variance.sqrt())
}

#[test]
fn analytic_the_band_is_as_wide_as_the_harmonics_are_apart_and_uncertain() {
    let computer = computer();
    assert!(computer.band(&computer.deck.initial()).is_none());
    let deck = watched(&computer.deck, |t| {
        0.2 * (1.2 * t).sin() + 0.15 * (2.0 * t).sin()
    });
    let band = computer.band(&deck).unwrap();
    // Weighted by power, (a w)²: 0.0576 at 1.2 rad/s and 0.09 at 2 rad/s.
    let (first, second) = (0.0576_f64, 0.09);
    let mean = (first * 1.2 + second * 2.0) / (first + second);
    let apart = (first * second).sqrt() / (first + second) * 0.8;
    assert!((band.heave_angular_frequency - mean).abs() < 0.02 * mean);
    let wide = apart / mean;
    assert!((band.heave_damping_ratio - wide).abs() < 0.05 * wide);
    let sd_mps = f64::sqrt(0.5 * (first + second));
    assert!((band.heave_velocity_sd_mps - sd_mps).abs() < 0.03 * sd_mps);
    // Early on, one wave of uncertain frequency that is forgotten quickly.
    let early = watched_for(12, &computer.deck, |t| 0.2 * (1.2 * t).sin());
    let unlimited = Computer {
        least_damping_ratio: 1e-3,
        ..computer
    };
    for deck in [deck, early] {
        let band = unlimited.band(&deck).unwrap();
        let (mean, width) = mean_and_width(&deck);
        let wide = (width + deck.forgetting_per_s()) / mean;
        // Neither limit is what is measured here.
        assert!(wide > unlimited.least_damping_ratio, "{wide}");
        assert!(wide < computer.relative.deck.heave_damping_ratio, "{wide}");
        assert!((band.heave_damping_ratio - wide).abs() < 1e-9);
        assert!((band.heave_angular_frequency - mean).abs() < 1e-12);
    }
    // A wave that is known well is no narrower than the least width.
    let known = watched(&computer.deck, |t| 0.2 * (1.2 * t).sin());
    let (mean, width) = mean_and_width(&known);
    assert!((width + known.forgetting_per_s()) / mean < computer.least_damping_ratio);
    let band = computer.band(&known).unwrap();
    assert_eq!(band.heave_damping_ratio, computer.least_damping_ratio);
}

#[test]
fn analytic_friction_bounds_the_thrust_of_a_vehicle_that_leans() {
    let computer = computer();
    let mut state: State = computer.initial(0.5);
    let weight_n = computer.controller.mass_kg * computer.controller.gravity_mps2;
    let rate_n_per_s = computer.guidance.idle_n_per_s;
    let leaning = |slope: f64, across_mps: f64| {
        let mut motion = Motion {
            attitude: Attitude::from_rotation_vector(Vector::new(0.0, slope.atan(), 0.0)),
            deck_normal: Vector::UP,
            ..Motion::default()
        };
        motion.relative_velocity_mps.y = across_mps;
        motion
    };
    let mut slower = |wind: f64, lean: f64, across_mps: f64, share: f64| {
        state.trim_up = Vector::new(wind, 0.0, 1.0).direction().unwrap();
        state.command.thrust_n = share * weight_n;
        computer.idle_slower(&state, &leaning(lean, across_mps))
    };
    let carried = rate_n_per_s / (0.3 * weight_n);
    // T/W at which the wind's force less that of the leaning thrust is the friction 0.6 on what the feet carry:
    // s - T/W l = 0.6 (1 - T/W). At most 0.6, at least 0.15.
    for (wind, lean, across_mps, bound) in [
        (0.4, 0.1, 0.0, 0.2 / 0.5),
        (0.3, 0.2, 0.25, 0.6),
        (0.5, 0.2, 0.0, 0.1 / 0.4),
        // A lean that holds the vehicle by itself, a wind that no friction holds.
        (0.4, 0.7, 0.0, 0.6),
        (0.61, 0.4, 0.0, 0.15),
        // At 0.2625 m/s it slides: the feet hold 0.1 less.
        (0.35, 0.1, 0.2625, 0.15 / 0.5),
        (0.4, 0.1, 1.0, 0.15),
        (0.0, 0.15, 0.0, 0.6),
    ] {
        let below = slower(wind, lean, across_mps, bound - 1e-9);
        assert!((below - carried).abs() < 1e-12, "{wind} {lean}: {below}");
        // Above it the thrust decreases fast: more slowly only by the height of the foot, up to 3.1 times at these slopes.
        let above = slower(wind, lean, across_mps, bound + 1e-9);
        assert!(above < 3.1, "{wind} {lean}: {above}");
    }
    // Level within 0.01 m: on, to nothing.
    assert!(slower(0.4, 0.05, 0.0, 0.3) < 1.2);
    // A deck that turns pushes as well, here by 0.1 of the weight: the rotors may carry a fifth of the weight in place of two.
    assert!((slower(0.4, 0.1, 0.0, 0.3) - carried).abs() < 1e-12);
    state.course_mps2 = Vector::new(0.981, 0.0, 0.0);
    assert!(computer.idle_slower(&state, &leaning(0.1, 0.0)) < 3.1);
}

#[test]
fn analytic_a_deck_that_turned_unseen_is_no_lean() {
    let computer = computer();
    let mut state: State = computer.initial(0.5);
    let weight_n = computer.controller.mass_kg * computer.controller.gravity_mps2;
    let all_feet = computer.guidance.idle_n_per_s / (2.0 * weight_n);
    let mut motion = Motion {
        attitude: Attitude::from_rotation_vector(Vector::new(0.0, 0.15, 0.0)),
        deck_normal: Vector::UP,
        ..Motion::default()
    };
    state.command.thrust_n = 0.1 * weight_n;
    // One foot is lower by 0.15/√2 sin 0.15 - 0.10 (1 - cos 0.15) = 0.0147 m: more than 0.01 m, and than what feet at 0.15 m
    // on a deck seem lower by that leans by 0.03 rad (0.0045 m), less than by 0.04 rad (0.006 m). The tag has never been seen.
    // Below 0.6 m/s friction may still hold it on one foot.
    for (deck_rad, across_mps, stands) in [
        (0.0, 0.7, false),
        (0.03, 0.7, false),
        (0.04, 0.7, true),
        (0.04, 0.5, false),
    ] {
        state.tilt_rad = deck_rad;
        motion.relative_velocity_mps.y = across_mps;
        let slower = computer.idle_slower(&state, &motion);
        // On one foot by at most 0.3 of the weight per second, on all feet by at least twice the weight.
        assert_eq!(
            slower <= all_feet,
            stands,
            "{deck_rad} {across_mps} {slower}"
        );
    }
}
