//! Legs on decks: rest, bounce, energy, friction, tip-over, the edge.

use touchdown_sim::STEP_S;
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::contact::{ContactLog, LegSettings};
use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::body::rigid::{Disturbance, RigidState, RigidVehicle};
use touchdown_sim::deck::rigid::{Axis, DeckPose, RigidDeck, RigidMotion, Tone};

const M: f64 = 1.37;
const G: f64 = 9.81;

fn vehicle(legs: &LegSettings) -> RigidVehicle {
    let body = BodySettings {
        drag_ns_per_m: 0.0,
        drag_ns2_per_m2: 0.0,
        ..BodySettings::default()
    };
    let plant = PlantSettings::default();
    let vehicle = RigidVehicle::new(&plant, &body).expect("valid settings");
    vehicle.with_legs(legs, &plant).expect("valid legs")
}

/// At a height, rotors stopped.
fn at(height_m: f64) -> RigidState {
    RigidState {
        position_m: [0.0, 0.0, height_m],
        ..RigidState::default()
    }
}

fn still() -> RigidDeck {
    RigidDeck::Still
}

/// A deck that stands at an angle about y (bow down): a quarter period after the start of a slow sine.
fn tilted(pitch_rad: f64) -> DeckPose {
    let tone = Tone {
        axis: Axis::Pitch,
        amplitude: pitch_rad,
        frequency_hz: 0.25,
        phase_rad: 0.0,
    };
    let motion = RigidMotion::Sines { tones: vec![tone] };
    let mut pose = motion.build(G, 0, 0).expect("valid").at(1.0);
    (pose.velocity_mps, pose.angular_velocity) = ([0.0; 3], [0.0; 3]);
    pose
}

/// Runs with rotors stopped and calls `look` after each step.
fn run(
    vehicle: &RigidVehicle,
    state: &mut RigidState,
    deck: impl Fn(f64) -> DeckPose,
    steps: u32,
    mut look: impl FnMut(f64, &RigidState, &DeckPose),
) -> ContactLog {
    let mut log = ContactLog::default();
    for step in 0..steps {
        let t = f64::from(step) * STEP_S;
        let poses = [deck(t), deck(t + 0.5 * STEP_S), deck(t + STEP_S)];
        vehicle.step(state, &poses, &[0.0; 4], &Disturbance::default(), STEP_S);
        vehicle.log_contact(&mut log, t + STEP_S, state, &poses[2]);
        look(t + STEP_S, state, &poses[2]);
    }
    log
}

fn energy_j(vehicle: &RigidVehicle, state: &RigidState, deck: &DeckPose) -> f64 {
    let square = |v: [f64; 3]| v.map(|x| x * x);
    let [a, b, c] = square(state.velocity_mps);
    let [p, q, r] = square(state.rates);
    let kinetic = 0.5 * M * (a + b + c) + 0.5 * (0.0125 * (p + q) + 0.022 * r);
    kinetic + M * G * state.position_m[2] + vehicle.spring_energy_j(state, deck)
}

#[test]
fn analytic_rest_on_the_deck() {
    let vehicle = vehicle(&LegSettings::default());
    let mut state = at(0.1);
    let log = run(&vehicle, &mut state, |t| still().at(t), 2_000, |_, _, _| {});
    // Feet at 0.1 m below, legs pressed by W/(4 k); decay of e^(-36 t).
    let expected = 0.1 - M * G / 8_000.0;
    assert!(
        (state.position_m[2] - expected).abs() < 1e-9,
        "{:?}",
        state.position_m
    );
    assert_eq!((log.feet_down, log.bounces, log.tipped_s), (4, 0, None));
    assert!(log.slide_m == 0.0 && log.greatest_tilt_rad < 1e-9);
}

#[test]
fn analytic_bounce_of_a_damped_leg() {
    let (k, c): (f64, f64) = (8_000.0, 100.0);
    let vehicle = vehicle(&LegSettings::default());
    for speed in [1.0, 2.0, 3.0] {
        // m δ'' = m g - k δ - c δ' from δ = 0, δ' = speed, until k δ + c δ' = 0.
        let (decay, base) = (0.5 * c / M, M * G / k);
        let w = (k / M - decay * decay).sqrt();
        let sine = (speed - decay * base) / w;
        let depth =
            |t: f64| base + (-decay * t).exp() * (sine * (w * t).sin() - base * (w * t).cos());
        let rate = |t: f64| (depth(t + 1e-7) - depth(t - 1e-7)) / 2e-7;
        let leaves = |t: f64| k * depth(t) + c * rate(t);
        // The greatest speed upwards comes before the leg leaves, when its push falls to the weight.
        let (mut t, mut expected): (f64, f64) = (1e-3, 0.0);
        while leaves(t) > 0.0 && t < 0.1 {
            expected = expected.max(-rate(t));
            t += 1e-6;
        }
        assert!(t < 0.1, "at {speed} m/s it bounces");
        // A hair below the deck, so that the first step begins in contact.
        let mut state = at(0.1 - 1e-12);
        state.velocity_mps[2] = -speed;
        let mut up: f64 = 0.0;
        run(
            &vehicle,
            &mut state,
            |t| still().at(t),
            200,
            |_, s, _| {
                up = up.max(s.velocity_mps[2]);
            },
        );
        // Up to there the equation is linear: RK4 at 76 rad/s and 1 ms, and the grid of times
        // (the second derivative of the speed, 1e4 m/s³, times (0.5 ms)²/2).
        assert!((up - expected).abs() < 1.5e-3, "{speed}: {up} {expected}");
        let flight = up_after(&vehicle, speed);
        // It leaves at -rate(t) and then flies: a kink inside a step, g × 1 ms.
        assert!(
            (flight + rate(t)).abs() < 0.01,
            "{speed}: {flight} {}",
            -rate(t)
        );
    }
}

/// Speed at which a vehicle that touched at `speed` has left the deck.
fn up_after(vehicle: &RigidVehicle, speed: f64) -> f64 {
    let mut state = at(0.1 - 1e-12);
    state.velocity_mps[2] = -speed;
    let mut left = None;
    run(
        vehicle,
        &mut state,
        |t| still().at(t),
        100,
        |_, s, d| {
            let touching = vehicle.feet(s, d)[0].force_n[2] > 0.0;
            if !touching && left.is_none() {
                left = Some(s.velocity_mps[2]);
            }
        },
    );
    left.expect("it leaves the deck")
}

#[test]
fn analytic_elastic_legs_keep_energy() {
    let legs = LegSettings {
        damping_ns_per_m: 0.0,
        tangential_damping_ns_per_m: 0.0,
        friction: 0.0,
        ..LegSettings::default()
    };
    let vehicle = vehicle(&legs);
    for tilt in [0.0_f64, 0.1] {
        let mut state = at(0.16);
        state.attitude = [(0.5 * tilt).cos(), (0.5 * tilt).sin(), 0.0, 0.0];
        let start = energy_j(&vehicle, &state, &still().at(0.0));
        let mut worst: f64 = 0.0;
        let log = run(
            &vehicle,
            &mut state,
            |t| still().at(t),
            1_000,
            |_, s, d| {
                worst = worst.max((energy_j(&vehicle, s, d) - start).abs());
            },
        );
        assert!(log.bounces >= 2, "{log:?}");
        // A spring that begins inside a step: of second order in the step, of 2 J.
        assert!(worst < 2e-3, "{tilt}: {worst}");
    }
}

#[test]
fn prop_damped_legs_only_lose_energy() {
    let vehicle = vehicle(&LegSettings::default());
    for (speed, side, roll) in [(0.3, 0.2, 0.05_f64), (1.0, 0.8, -0.2), (0.1, -0.5, 0.1)] {
        let mut state = at(0.15);
        state.velocity_mps = [side, 0.3 * side, -speed];
        state.attitude = [(0.5 * roll).cos(), (0.5 * roll).sin(), 0.0, 0.0];
        let mut last = energy_j(&vehicle, &state, &still().at(0.0));
        let log = run(
            &vehicle,
            &mut state,
            |t| still().at(t),
            3_000,
            |t, s, d| {
                let now = energy_j(&vehicle, s, d);
                // A foot that touches inside a step brings its damping up to 1 ms early or late.
                assert!(now < last + 2e-3, "{t}: {last} {now}");
                last = now;
            },
        );
        let rest = M * G * (0.1 - M * G / 8_000.0) + 0.5 * 8_000.0 * (M * G / 8_000.0).powi(2);
        // At rest in the end, but for what sticking feet hold: up to 4 (μ N)²/(2 k_t).
        let held = 4.0 * (0.6 * M * G / 4.0_f64).powi(2) / 4_000.0;
        assert!(last - rest > -1e-6 && last - rest < held, "{last} {rest}");
        assert_eq!((log.feet_down, log.tipped_s), (4, None));
    }
}

#[test]
fn analytic_slide_and_stick() {
    let vehicle = vehicle(&LegSettings::default());
    // From 1 m/s on a level deck: v²/(2 μ g), less what the first touch takes.
    let mut state = at(0.1 - M * G / 8_000.0);
    state.velocity_mps[0] = 1.0;
    let log = run(&vehicle, &mut state, |t| still().at(t), 1_000, |_, _, _| {});
    let expected = 1.0 / (2.0 * 0.6 * G);
    // The feet's springs and the nodding of the body: a few per cent.
    assert!(
        (state.position_m[0] / expected - 1.0).abs() < 0.05,
        "{:?}",
        state.position_m
    );
    assert!((log.slide_m / expected - 1.0).abs() < 0.1, "{log:?}");
    // On 25° it sticks without creeping, on 35° it slides at g (sin - μ cos): atan 0.6 is 31°.
    for (degrees, slides) in [(25.0_f64, false), (35.0, true)] {
        let angle = degrees.to_radians();
        let pose = tilted(angle);
        let mut state = at(0.0);
        state.position_m = pose.axes[2].map(|n| 0.1 * n);
        let half = 0.5 * angle;
        state.attitude = [half.cos(), 0.0, half.sin(), 0.0];
        let settling = if slides { 500 } else { 2_500 };
        run(&vehicle, &mut state, |_| pose, settling, |_, _, _| {});
        let along = |s: &RigidState| -> [f64; 2] {
            let dot = |v: [f64; 3]| (0..3).map(|k| v[k] * pose.axes[0][k]).sum();
            [dot(s.position_m), dot(s.velocity_mps)]
        };
        let [_, before] = along(&state);
        let from = along(&state)[0];
        run(&vehicle, &mut state, |_| pose, 200, |_, _, _| {});
        let [to, after] = along(&state);
        if slides {
            let expected = G * (angle.sin() - 0.6 * angle.cos());
            // Springs still swing a little.
            assert!(
                ((after - before) / 0.2 / expected - 1.0).abs() < 0.02,
                "{after}"
            );
        } else {
            assert!((to - from).abs() < 1e-7, "{from} {to}");
        }
    }
}

#[test]
fn prop_it_tips_when_it_trips() {
    let trip = |side: f64, friction: f64| {
        let legs = LegSettings {
            friction,
            ..LegSettings::default()
        };
        let vehicle = vehicle(&legs);
        let mut state = at(0.1);
        state.velocity_mps = [side, 0.0, -0.2];
        run(&vehicle, &mut state, |t| still().at(t), 1_500, |_, _, _| {})
    };
    let tipped = trip(2.5, 2.0);
    assert!(
        tipped.tipped_s.is_some() && tipped.greatest_tilt_rad > 1.0,
        "{tipped:?}"
    );
    assert_eq!(trip(0.3, 2.0).tipped_s, None);
    // Half the track over the height is 1.06: below it the feet slide first.
    assert_eq!(trip(2.5, 0.6).tipped_s, None);
}

#[test]
fn prop_it_rides_a_moving_deck() {
    let tone = |axis, amplitude, frequency_hz| Tone {
        axis,
        amplitude,
        frequency_hz,
        phase_rad: 0.0,
    };
    let motion = RigidMotion::Sines {
        tones: vec![
            tone(Axis::Heave, 0.3, 0.2),
            tone(Axis::Sway, 0.2, 0.15),
            tone(Axis::Roll, 0.05, 0.25),
        ],
    };
    let deck = motion.build(G, 0, 0).expect("valid motion");
    let vehicle = vehicle(&LegSettings::default());
    let start = deck.at(0.0);
    let mut state = at(0.1 - M * G / 8_000.0);
    state.velocity_mps = start.velocity_mps;
    let relative = |s: &RigidState, d: &DeckPose| -> [f64; 3] {
        let from: [f64; 3] = std::array::from_fn(|k| s.position_m[k] - d.origin_m[k]);
        std::array::from_fn(|k| (0..3).map(|j| d.axes[k][j] * from[j]).sum())
    };
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    let log = run(
        &vehicle,
        &mut state,
        |t| deck.at(t),
        10_000,
        |_, s, d| {
            let place = relative(s, d);
            for k in 0..3 {
                low[k] = low[k].min(place[k]);
                high[k] = high[k].max(place[k]);
            }
        },
    );
    assert_eq!((log.feet_down, log.bounces), (4, 0));
    for k in 0..3 {
        // Elastic: forces of 5 % of the weight on springs of 8 kN/m, and the swing of the start
        // (the deck rolls at once).
        assert!(high[k] - low[k] < 4e-3, "{k}: {low:?} {high:?}");
    }
}

#[test]
fn analytic_feet_that_ride_the_deck_feel_its_springs_alone() {
    // A vehicle that heaves and rolls with the deck, 1 mm into it: k δ on each foot, no damping, no friction.
    let tone = |axis, amplitude| Tone {
        axis,
        amplitude,
        frequency_hz: 0.4,
        phase_rad: 0.6,
    };
    let motion = RigidMotion::Sines {
        tones: vec![
            tone(Axis::Heave, 0.3),
            tone(Axis::Sway, 0.2),
            tone(Axis::Roll, 0.2),
        ],
    };
    let deck = motion.build(G, 0, 0).expect("valid motion");
    let vehicle = vehicle(&LegSettings::default());
    for i in 0..10 {
        let t = 0.23 * f64::from(i);
        let pose = deck.at(t);
        let arm = std::array::from_fn(|k| {
            0.3 * pose.axes[0][k] - 0.2 * pose.axes[1][k] + 0.099 * pose.axes[2][k]
        });
        let half = 0.5 * deck.coordinates(t).value[3];
        let mut state = RigidState {
            position_m: std::array::from_fn(|k| pose.origin_m[k] + arm[k]),
            velocity_mps: pose.point_velocity(arm),
            attitude: [half.cos(), half.sin(), 0.0, 0.0],
            // Roll alone: the same about the body's x.
            rates: [pose.angular_velocity[0], 0.0, 0.0],
            ..RigidState::default()
        };
        let stuck = vehicle.feet(&state, &pose).map(|foot| Some(foot.place_m));
        state.contact.stuck_m = stuck;
        for foot in vehicle.feet(&state, &pose) {
            // Rounding of 0.1 m times 2000 N/m.
            assert!((foot.force_n[2] - 2.0).abs() < 1e-10, "{foot:?}");
            assert!(foot.force_n[0].abs() < 1e-10 && foot.force_n[1].abs() < 1e-10);
        }
    }
}

#[test]
fn prop_beyond_the_edge_there_is_nothing() {
    let vehicle = vehicle(&LegSettings::default());
    let mut state = at(0.1);
    state.position_m[0] = 0.5;
    state.velocity_mps[0] = 3.0;
    let log = run(&vehicle, &mut state, |t| still().at(t), 1_000, |_, _, _| {});
    assert!(
        log.first_touch_s.is_some() && log.fell_s.is_some(),
        "{log:?}"
    );
    assert!(state.position_m[2] < -0.5);
}

#[test]
fn prop_bad_legs_name_key_and_number() {
    let plant = PlantSettings::default();
    let vehicle = RigidVehicle::new(&plant, &BodySettings::default()).expect("valid");
    let bad = LegSettings {
        stiffness_n_per_m: -2.0,
        ..LegSettings::default()
    };
    let message = vehicle
        .with_legs(&bad, &plant)
        .map(|_| ())
        .expect_err("negative");
    let message = message.to_string();
    assert!(
        message.contains("legs.stiffness_n_per_m") && message.contains("-2"),
        "{message}"
    );
}
