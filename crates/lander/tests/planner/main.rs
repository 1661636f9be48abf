//! The touchdown planner against forecasts that are known.

mod limits;

use touchdown_lander::planner::{DeckOutlook, Plan, Planner, Verdict};

/// A heave `a sin(w t + phase)` that is known exactly.
fn sine(a: f64, w: f64, phase: f64) -> impl Fn(f64) -> DeckOutlook<f64> {
    move |t: f64| DeckOutlook {
        velocity_mps: a * w * (w * t + phase).cos(),
        acceleration_mps2: -a * w * w * (w * t + phase).sin(),
        ..DeckOutlook::default()
    }
}

const TAU: f64 = core::f64::consts::TAU;

fn planner() -> Planner<f64> {
    let planner = Planner::default();
    planner.validate().unwrap();
    planner
}

/// Samples of the reference of a plan: greatest speed down and acceleration.
fn sampled(plan: &Plan<f64>) -> (f64, f64) {
    (0..=2000)
        .map(|i| {
            plan.reference
                .at(plan.reference.duration_s * f64::from(i) / 2000.0)
        })
        .fold((0.0, 0.0), |(v, a): (f64, f64), at| {
            (v.max(-at.velocity_mps), a.max(at.acceleration_mps2.abs()))
        })
}

#[test]
fn analytic_over_a_still_deck_it_goes_at_once_and_short() {
    let planner = planner();
    let verdict = planner.assess(0.0, 0.8, false, &|_: f64| DeckOutlook::default());
    let plan = verdict.plan().unwrap();
    assert!(plan.quiescent);
    // The shortest on the grid of 10/128 s.
    let d = plan.reference.duration_s;
    assert!((2.2..2.2 + 10.0 / 128.0).contains(&d), "{d}");
    assert_eq!(plan.reference.sink_rate_mps, 0.03);
    assert_eq!(plan.reference.end_height_m, 0.1);
    plan.reference.validate().unwrap();
    // Only the relative speed is used: 0.03 of 0.15 m/s.
    assert!((plan.severity - 0.2).abs() < 1e-15);
    // The paper's deck asks for no waiting either: 0.157 of 0.25 m/s at most.
    for i in 0..20 {
        let deck = sine(0.05, 0.5 * TAU, 0.05 * TAU * f64::from(i));
        let plan = planner.assess(0.0, 0.5, false, &deck).plan().unwrap();
        assert!(plan.quiescent && plan.severity <= 0.63);
    }
}

#[test]
fn analytic_quiet_comes_first_and_then_time() {
    let planner = planner();
    // A little too tilted before 2.9 s, a little less than too tilted after.
    let step = |t: f64| DeckOutlook {
        tilt_rad: if t < 2.9 { 0.101 } else { 0.099 },
        ..DeckOutlook::default()
    };
    let plan = planner.assess(0.0, 0.8, false, &step).plan().unwrap();
    // Cheaper at once, by 0.1 a second against 0.02; but then not quiet.
    assert!(plan.quiescent && plan.reference.duration_s > 2.9);
    // Getting better by 0.05 a second is not worth 0.1; by 0.2 it is.
    let better = |rate: f64| {
        move |t: f64| DeckOutlook {
            tilt_rad: 0.1 * (0.9 - rate * t),
            ..DeckOutlook::default()
        }
    };
    let soon = planner.assess(0.0, 0.8, false, &better(0.05));
    assert!(soon.plan().unwrap().reference.duration_s < 2.3);
    let late = planner.assess(0.0, 0.8, false, &better(0.2));
    assert!(late.plan().unwrap().reference.duration_s > 3.4);
}

#[test]
fn analytic_limits_of_the_descent() {
    let mut planner = planner();
    planner.descent.duration_min_s = 0.5;
    let still = |_: f64| DeckOutlook::default();
    let plan = |p: &Planner<f64>, height: f64| p.assess(0.0, height, false, &still).plan();
    // By speed: 15/8 · 0.7 m / T about 0.7 m/s, a little less for the sink rate.
    let by_speed = plan(&planner, 0.8).unwrap();
    let (speed, _) = sampled(&by_speed);
    assert!(speed <= 0.7 && speed > 0.65, "{speed}");
    // By acceleration: 5.77 D/T².
    planner.descent.acceleration_mps2 = 0.6;
    let by_acceleration = plan(&planner, 0.8).unwrap();
    let (_, acceleration) = sampled(&by_acceleration);
    assert!(acceleration <= 0.6 && acceleration > 0.55, "{acceleration}");
    // The deck's own acceleration takes its part.
    let moving = sine(0.05, 0.5 * TAU, 0.0);
    let slower = planner.assess(0.0, 0.3, false, &moving).plan().unwrap();
    let (_, acceleration) = sampled(&slower);
    assert!(acceleration <= 0.6 - 0.49, "{acceleration}");
    // Too high for what is left of time.
    planner.descent.speed_mps = 0.3;
    assert_eq!(planner.assess(0.0, 0.8, true, &still), Verdict::OutOfReach);
    assert_eq!(
        planner.assess(0.0, f64::NAN, true, &still),
        Verdict::OutOfReach
    );
    assert_eq!(planner.assess(0.0, 0.05, true, &still), Verdict::OutOfReach);
}

/// Waits over a deck until the planner goes; the time of the start, and the plan.
fn wait(planner: &Planner<f64>, deck: &impl Fn(f64) -> DeckOutlook<f64>) -> (f64, Plan<f64>) {
    let mut state = planner.initial();
    for i in 0..20_000 {
        let now = 0.02 * f64::from(i);
        let ahead = |t: f64| deck(now + t);
        let dt = if i == 0 { 0.0 } else { 0.02 };
        if let Some(plan) = planner.step(&mut state, 0.8, false, &ahead, dt).plan() {
            return (now, plan);
        }
    }
    panic!("never goes");
}

#[test]
fn analytic_a_slow_swell_is_met_where_it_is_quiet() {
    let planner = planner();
    // 0.3 m at 0.2 Hz: up to 0.377 m/s, too fast by half.
    let w = 0.2 * TAU;
    let (mut gained, mut blind) = (0.0, 0.0);
    for i in 0..50 {
        let phase = TAU * f64::from(i) / 50.0;
        let deck = sine(0.3, w, phase);
        let (start, plan) = wait(&planner, &deck);
        assert!(plan.quiescent);
        // Windows come twice a period: never more than half of one is waited.
        assert!(start <= 2.5 + 0.05, "{start}");
        let touchdown = start + plan.reference.duration_s;
        for part in [-0.1, 0.0, 0.1] {
            let speed = deck(touchdown + part).velocity_mps.abs();
            // The dwell is looked at in steps of the grid, which lie outside it.
            assert!(speed <= 0.25 + 1e-9, "{i} {speed}");
        }
        gained += deck(touchdown).velocity_mps.powi(2);
        blind += deck(2.2).velocity_mps.powi(2);
    }
    // Going at once meets the sine anywhere: a²w²/2 on average, exactly for phases
    // all around.
    assert!((blind / 50.0 - 0.5 * (0.3 * w).powi(2)).abs() < 1e-12);
    assert!(gained < 0.5 * blind, "{gained} {blind}");
}

#[test]
fn analytic_the_phase_can_be_chosen() {
    let mut planner = planner();
    let w = 0.2 * TAU;
    let peak = 0.3 * w * w;
    // On the crest: accelerating downward, nearly at rest.
    planner.quiescence.acceleration_min_mps2 = -1.2 * peak;
    planner.quiescence.acceleration_max_mps2 = -0.6 * peak;
    planner.quiescence.relative_speed_mps = 0.2;
    planner.validate().unwrap();
    for i in 0..20 {
        let deck = sine(0.3, w, TAU * f64::from(i) / 20.0);
        let (start, plan) = wait(&planner, &deck);
        let at = deck(start + plan.reference.duration_s);
        assert!(at.acceleration_mps2 <= -0.6 * peak, "{at:?}");
        assert!(start <= 5.0 + 0.05);
    }
}

#[test]
fn analytic_after_the_waiting_it_takes_the_best_there_is() {
    let planner = planner();
    // Never quiescent: tilted by 0.12 to 0.18 rad, least every 7 s.
    let w = TAU / 7.0;
    for i in 0..20 {
        let phase = TAU * f64::from(i) / 20.0;
        let deck = |t: f64| DeckOutlook {
            tilt_rad: 0.15 + 0.03 * (w * t + phase).cos(),
            ..DeckOutlook::default()
        };
        let (start, plan) = wait(&planner, &deck);
        assert!(!plan.quiescent);
        // Not before the deadline is in sight, never after it.
        assert!(start > 23.0 && start <= 30.0 + 0.03, "{start}");
        let at = deck(start + plan.reference.duration_s).tilt_rad;
        // The least of the last seconds: half the dwell, a step of the grid and the
        // cost of time (0.1/s of 0.1 rad) keep it off the very least.
        assert!(at < 0.125, "{phase} {at}");
    }
    // Steadily worse: at once, when that is in sight; steadily better: at the end.
    let slope = |rate: f64| {
        move |t: f64| DeckOutlook {
            tilt_rad: 0.5 + rate * t,
            ..DeckOutlook::default()
        }
    };
    let last_look = 30.0 - (10.0 - 3.5);
    let (start, _) = wait(&planner, &slope(0.01));
    assert!((start - last_look).abs() < 0.15, "{start}");
    let (start, _) = wait(&planner, &slope(-0.01));
    assert!((start - 30.0).abs() < 0.15, "{start}");
}

#[test]
fn regress_a_tilt_beyond_its_limit_does_not_hide_the_calmest_time() {
    // 0.3 of 0.1 rad at all times; 0.5 of 0.25 m/s, and none around 3.1 s.
    let planner = planner();
    let tilted = |t: f64| DeckOutlook {
        velocity_mps: if (2.9..3.3).contains(&t) { 0.0 } else { 0.5 },
        tilt_rad: 0.3,
        ..DeckOutlook::default()
    };
    let plan = planner.assess(0.0, 0.8, true, &tilted).plan().unwrap();
    // A dwell of 0.1 s to either side, on the grid of 10/128 s.
    let d = plan.reference.duration_s;
    assert!((3.0..3.2).contains(&d), "{d}");
    // The tilt's share of 3 and the relative speed's of 0.2: rounding only.
    assert!(!plan.quiescent && (plan.severity - 3.2).abs() < 1e-12);
}

#[test]
fn analytic_in_a_hurry_it_goes_at_once() {
    let planner = planner();
    let rough = |_: f64| DeckOutlook {
        velocity_mps: 1.0,
        ..DeckOutlook::default()
    };
    let waiting = planner.assess(0.0, 0.8, false, &rough);
    assert_eq!(waiting, Verdict::Wait { window_in_s: None });
    let plan = planner.assess(0.0, 0.8, true, &rough).plan().unwrap();
    assert!(!plan.quiescent && (plan.severity - 4.0).abs() < 1e-12);
    // A window is announced: it opens at 6 s and can be met 3.5 s before.
    let opens = |t: f64| DeckOutlook {
        velocity_mps: if t < 6.0 { 1.0 } else { 0.0 },
        ..DeckOutlook::default()
    };
    let Verdict::Wait {
        window_in_s: Some(window_in_s),
    } = planner.assess(0.0, 0.8, false, &opens)
    else {
        panic!("does not wait");
    };
    // Half the dwell and up to two steps of 10/128 s.
    assert!((2.6..2.84).contains(&window_in_s), "{window_in_s}");
}

#[test]
fn analytic_uncertainty_counts() {
    let planner = planner();
    let deck = |sd: f64| {
        move |t: f64| DeckOutlook {
            velocity_mps: 0.1,
            velocity_sd_mps: sd * t,
            ..DeckOutlook::default()
        }
    };
    let sure = planner.assess(0.0, 0.8, false, &deck(0.0)).plan().unwrap();
    let unsure = planner.assess(0.0, 0.8, false, &deck(0.01)).plan().unwrap();
    let t = unsure.reference.duration_s;
    // (0.1 + sd)/0.25, at the later edge of the dwell.
    assert!((sure.severity - 0.4).abs() < 1e-12);
    assert!(unsure.severity > (0.1 + 0.01 * t) / 0.25);
    // Half of the standard deviation is added to the sink rate.
    assert!((unsure.reference.sink_rate_mps - (0.03 + 0.005 * t)).abs() < 1e-12);
    // Up to its limit.
    let lost = planner.assess(0.0, 0.8, true, &deck(1.0)).plan().unwrap();
    assert_eq!(lost.reference.sink_rate_mps, 0.08);
}

#[test]
fn prop_without_a_prediction_it_never_goes() {
    let planner = planner();
    for bad in [f64::NAN, f64::INFINITY] {
        let none = move |_: f64| DeckOutlook {
            velocity_mps: bad,
            ..DeckOutlook::default()
        };
        for hurry in [false, true] {
            assert_eq!(planner.assess(1e9, 0.8, hurry, &none), Verdict::Blind);
        }
    }
    // Known for two seconds only: too short for a descent.
    let short = |t: f64| DeckOutlook {
        tilt_rad: if t < 2.0 { 0.0 } else { f64::NAN },
        ..DeckOutlook::default()
    };
    assert_eq!(planner.assess(1e9, 0.8, true, &short), Verdict::Blind);
    // Known here and there: touchdown where it is known all around.
    let patchy = |t: f64| DeckOutlook {
        velocity_sd_mps: if (2.0..2.6).contains(&t) { -1.0 } else { 0.0 },
        ..DeckOutlook::default()
    };
    let plan = planner.assess(0.0, 0.8, false, &patchy).plan().unwrap();
    assert!(plan.reference.duration_s > 2.7);
    // Known nowhere for as long as the dwell: 0.1 s of every 0.2 s.
    let flicker = |t: f64| DeckOutlook {
        velocity_mps: if t % 0.2 < 0.1 { 0.0 } else { f64::NAN },
        ..DeckOutlook::default()
    };
    assert_eq!(planner.assess(1e9, 0.8, true, &flicker), Verdict::Blind);
    let negative = |_: f64| DeckOutlook {
        tilt_sd_rad: -0.1,
        ..DeckOutlook::default()
    };
    assert_eq!(planner.assess(1e9, 0.8, true, &negative), Verdict::Blind);
}

#[test]
fn prop_with_the_deck_estimator_a_swell_is_met_where_it_is_quiet() {
    use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
    let planner = planner();
    let estimator = DeckEstimator::<f64>::new(Observed::Velocity, 0.02);
    let (w, dt) = (0.2 * TAU, 0.01);
    let mut met = 0;
    for i in 0..10 {
        let deck = sine(0.3, w, TAU * f64::from(i) / 10.0);
        let mut state = estimator.initial();
        let mut waiting = planner.initial();
        for k in 0..9000 {
            let now = dt * f64::from(k);
            // A ripple of 0.02 m/s stands for noise.
            let noise = 0.02 * (37.0 * now).sin();
            estimator.step(&mut state, Some(deck(now).velocity_mps + noise), dt);
            // A minute to learn the swell, then every tenth of a second.
            if k < 6000 || k % 10 != 0 {
                continue;
            }
            let ahead = |t: f64| DeckOutlook::from_heave(&estimator.predict(&state, t), 0.02, 0.01);
            let verdict = planner.step(&mut waiting, 0.8, false, &ahead, 0.1);
            if let Some(plan) = verdict.plan() {
                let speed = deck(now + plan.reference.duration_s).velocity_mps.abs();
                // The limit, less the standard deviation it was planned with, and one
                // more by which the prediction may be wrong.
                assert!(plan.quiescent && speed < 0.27, "{i} {speed} {plan:?}");
                met += 1;
                break;
            }
        }
    }
    assert_eq!(met, 10);
}

#[test]
fn prop_single_precision_decides_the_same() {
    let planner = Planner::<f32>::default();
    planner.validate().unwrap();
    let double = self::planner();
    for i in 0..40 {
        let phase = TAU * f64::from(i) / 40.0;
        let deck = sine(0.3, 0.2 * TAU, phase);
        let narrow = |t: f32| {
            let at = deck(f64::from(t));
            DeckOutlook {
                velocity_mps: at.velocity_mps as f32,
                acceleration_mps2: at.acceleration_mps2 as f32,
                ..DeckOutlook::default()
            }
        };
        let (a, b) = (
            planner.assess(0.0, 0.8, false, &narrow).plan(),
            double.assess(0.0, 0.8, false, &deck).plan(),
        );
        assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            assert!((f64::from(a.reference.duration_s) - b.reference.duration_s).abs() < 1e-6);
            assert!((f64::from(a.severity) - b.severity).abs() < 1e-5);
        }
    }
}
