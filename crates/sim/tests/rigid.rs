//! The vehicle in six degrees of freedom: its special cases, deck and edge, inertia, drag.

use touchdown_sim::STEP_S;
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::plant::{Plant, PlantSettings, Surface};
use touchdown_sim::body::rigid::{Disturbance, RigidState, RigidVehicle};
use touchdown_sim::body::vertical::VerticalVehicle;
use touchdown_sim::deck::rigid::{Axis, DeckCoordinates, DeckPose, RigidDeck, RigidMotion, Tone};
use touchdown_sim::deck::{DeckMotion, DeckPoint};

fn vehicle_of(settings: &PlantSettings) -> RigidVehicle {
    RigidVehicle::new(settings, &BodySettings::default()).expect("valid settings")
}

fn vehicle() -> RigidVehicle {
    vehicle_of(&PlantSettings::default())
}

/// Turn about one of the axes x, y, z.
fn turn(axis: usize, angle_rad: f64) -> [f64; 4] {
    let (sin, cos) = (0.5 * angle_rad).sin_cos();
    let mut q = [cos, 0.0, 0.0, 0.0];
    q[axis + 1] = sin;
    q
}

#[test]
fn analytic_level_and_centred_it_is_the_vertical_vehicle() {
    let surfaces = [Surface::Plate, Surface::Ground, Surface::Absent];
    let plates = surfaces.map(|surface| PlantSettings {
        surface,
        ..PlantSettings::default()
    });
    for settings in plates.into_iter().chain([PlantSettings::exponential()]) {
        let motion = DeckMotion::Sine {
            amplitude_m: 0.05,
            frequency_hz: 0.5,
            phase_rad: 0.4,
        };
        let deck = RigidMotion::from(motion).build(9.81, 0, 0).expect("valid");
        let plant = Plant::new(&settings).expect("valid settings");
        let vertical = VerticalVehicle::new(plant, settings.mass_kg, 0.01);
        let rigid = vehicle_of(&settings).with_thrust_scale_error([0.01; 4]);
        let (mut a, throttle) = vertical.balanced(0.5, motion.at(0.0));
        let (mut b, same) = rigid.balanced(0.5, &deck.at(0.0));
        assert_eq!(throttle, same);
        for step in 0..3_000 {
            let t = f64::from(step) * STEP_S;
            let times = [t, t + 0.5 * STEP_S, t + STEP_S];
            // Down to 0.08 m and up again, with a disturbance.
            let s = throttle - 0.02 * (2.2 * t).sin();
            let n = 0.3 * (17.0 * t).sin();
            let points: [DeckPoint; 3] = times.map(|t| motion.at(t));
            vertical.step(&mut a, &points, s, n, STEP_S);
            let poses: [DeckPose; 3] = times.map(|t| deck.at(t));
            let disturbance = Disturbance {
                turbulence_n: [0.25 * n; 4],
                ..Disturbance::default()
            };
            rigid.step(&mut b, &poses, &[s; 4], &disturbance, STEP_S);
            // 3000 steps of rounding in other orders.
            assert!((a.height_m - b.position_m[2]).abs() < 1e-9, "{t}");
            assert!((a.velocity_mps - b.velocity_mps[2]).abs() < 1e-9, "{t}");
            for i in 0..4 {
                assert!((a.plant.root_thrust - b.rotors.root_thrust[i]).abs() < 1e-9);
                assert!((a.plant.inflow[0] - b.rotors.inflow[i]).abs() < 1e-9);
            }
            assert!((a.plant.inflow[1] - b.rotors.fountain).abs() < 1e-9);
        }
        let moved = b.position_m[0].abs() + b.position_m[1].abs() + b.rates[2].abs();
        // Forces of equal rotors cancel up to their rounding.
        assert!(moved < 1e-12, "{moved}");
    }
}

#[test]
fn prop_only_the_place_relative_to_the_deck_counts() {
    // Deck and vehicle moved and tilted together: the same forces in the body.
    let tone = |axis, amplitude, phase_rad| Tone {
        axis,
        amplitude,
        frequency_hz: 0.3,
        phase_rad,
    };
    let motion = RigidMotion::Sines {
        tones: vec![
            tone(Axis::Surge, 0.3, 0.2),
            tone(Axis::Sway, 0.2, 0.9),
            tone(Axis::Heave, 0.4, 0.5),
            tone(Axis::Roll, 0.3, 1.0),
            tone(Axis::Pitch, 0.25, 2.0),
        ],
    };
    let deck: RigidDeck = motion.build(9.81, 0, 0).expect("valid motion");
    let vehicle = vehicle();
    let base = DeckPose::default();
    let (mut level, _) = vehicle.balanced(0.15, &base);
    level.position_m = [0.3, -0.2, 0.15];
    level.rotors.root_thrust = [3.5, 3.6, 3.7, 3.8];
    let expected = vehicle.loads(&level, &base, &Disturbance::default());
    for i in 0..20 {
        let mut pose = deck.at(0.17 * f64::from(i));
        let [roll, pitch] = [3, 4].map(|k| deck.coordinates(0.17 * f64::from(i)).value[k]);
        let arm: [f64; 3] =
            std::array::from_fn(|k| (0..3).map(|j| pose.axes[j][k] * level.position_m[j]).sum());
        let mut moved = level;
        moved.position_m = std::array::from_fn(|k| pose.origin_m[k] + arm[k]);
        // R_y(pitch) R_x(roll).
        let (a, b) = (turn(1, pitch), turn(0, roll));
        moved.attitude = [a[0] * b[0], a[0] * b[1], a[2] * b[0], -a[2] * b[1]];
        // At rest with each other: first both still.
        (pose.velocity_mps, pose.angular_velocity) = ([0.0; 3], [0.0; 3]);
        let still = vehicle.loads(&moved, &pose, &Disturbance::default());
        // Then both moving, with no upwash to tell the two apart: P u and w differ, so only the
        // places are compared.
        let places = vehicle.places(&moved, &pose, [0.0; 3]);
        let straight = vehicle.places(&level, &base, [0.0; 3]);
        for rotor in 0..4 {
            // Rounding only.
            assert!((still.rotor_n[rotor] - expected.rotor_n[rotor]).abs() < 1e-12);
            for k in 0..3 {
                let (a, b) = (places[rotor].place_m[k], straight[rotor].place_m[k]);
                assert!((a - b).abs() < 1e-14);
            }
        }
        // A vehicle that rides with the deck: every rotor climbs as fast as the deck below it.
        let riding = deck.at(0.17 * f64::from(i));
        moved.velocity_mps = riding.point_velocity(arm);
        let body = moved.axes();
        moved.rates = std::array::from_fn(|k| {
            (0..3)
                .map(|j| body[k][j] * riding.angular_velocity[j])
                .sum()
        });
        for rotor in vehicle.places(&moved, &riding, [0.0; 3]) {
            assert!(
                (rotor.climb_mps - rotor.deck_mps).abs() < 1e-14,
                "{rotor:?}"
            );
        }
    }
}

#[test]
fn prop_steps_converge_across_the_edge() {
    // Over the edge at 2 m/s, rolling: 1 ms against 0.1 ms.
    let vehicle = vehicle();
    let run = |steps: u32| {
        let dt = 0.5 / f64::from(steps);
        let decks = [DeckPose::default(); 3];
        let (mut state, throttle) = vehicle.balanced(0.2, &decks[0]);
        state.position_m[1] = 0.3;
        (state.velocity_mps[1], state.rates[0]) = (2.0, -0.3);
        for _ in 0..steps {
            vehicle.step(
                &mut state,
                &decks,
                &[throttle; 4],
                &Disturbance::default(),
                dt,
            );
        }
        state
    };
    let (coarse, fine) = (run(500), run(5_000));
    assert!(fine.position_m[1] > 1.2, "it crossed the edge");
    for k in 0..3 {
        // What a rotor sees of the plate is of order two in the step: below a micrometre.
        let moved = (coarse.position_m[k] - fine.position_m[k]).abs();
        assert!(moved < 1e-6, "{k}: {moved}");
        let turned = (coarse.rates[k] - fine.rates[k]).abs();
        assert!(turned < 1e-5, "{k}: {turned}");
    }
}

#[test]
fn prop_what_is_held_within_a_step_is_no_error() {
    // Down at 0.4 m/s into the ground effect of a deck that heaves and rolls: 1 ms against 0.1 ms.
    let vehicle = vehicle();
    let tone = |axis, amplitude, frequency_hz| Tone {
        axis,
        amplitude,
        frequency_hz,
        phase_rad: 0.3,
    };
    let motion = RigidMotion::Sines {
        tones: vec![tone(Axis::Heave, 0.05, 0.5), tone(Axis::Roll, 0.05, 0.3)],
    };
    let deck: RigidDeck = motion.build(9.81, 0, 0).expect("valid motion");
    let run = |steps: u32| {
        let dt = 0.5 / f64::from(steps);
        let (mut state, throttle) = vehicle.balanced(0.3, &deck.at(0.0));
        state.velocity_mps[2] -= 0.4;
        for step in 0..steps {
            let t = dt * f64::from(step);
            let poses = [t, t + 0.5 * dt, t + dt].map(|t| deck.at(t));
            let calm = Disturbance::default();
            vehicle.step(&mut state, &poses, &[throttle; 4], &calm, dt);
        }
        state
    };
    let (coarse, fine) = (run(500), run(5_000));
    let below = deck.at(0.5).origin_m[2];
    let height_m = fine.position_m[2] - below;
    assert!((0.05..0.25).contains(&height_m), "it came down: {height_m}");
    for k in 0..3 {
        // Measured 2.8e-8 m and (below) 2.2e-8: the targets are 3 µs late.
        let moved = (coarse.position_m[k] - fine.position_m[k]).abs();
        assert!(moved < 1e-7, "{k}: {moved}");
    }
    for i in 0..4 {
        let late = (coarse.rotors.inflow[i] - fine.rotors.inflow[i]).abs();
        assert!(late < 1e-7, "{i}: {late}");
    }
}

/// Without air: rotors stopped, no surface, no drag, no weight to speak of.
fn in_vacuum(inertia_kg_m2: [f64; 3]) -> RigidVehicle {
    let settings = PlantSettings {
        surface: Surface::Absent,
        climb_damping_ns_per_m: 0.0,
        ..PlantSettings::default()
    };
    let body = BodySettings {
        inertia_kg_m2,
        drag_ns_per_m: 0.0,
        drag_ns2_per_m2: 0.0,
        ..BodySettings::default()
    };
    RigidVehicle::new(&settings, &body).expect("valid settings")
}

#[test]
fn analytic_free_rotation() {
    let run = |vehicle: &RigidVehicle, rates: [f64; 3]| {
        let mut state = RigidState {
            rates,
            ..RigidState::default()
        };
        let decks = [DeckPose::default(); 3];
        for _ in 0..2_000 {
            vehicle.step(
                &mut state,
                &decks,
                &[0.0; 4],
                &Disturbance::default(),
                STEP_S,
            );
        }
        state
    };
    // A symmetric top precesses at (I_z - I_x)/I_x r about its axis.
    let top = run(&in_vacuum([0.0125, 0.0125, 0.022]), [1.0, 0.5, 3.0]);
    let angle: f64 = (0.022 - 0.0125) / 0.0125 * 3.0 * 2.0;
    let (sin, cos) = angle.sin_cos();
    let expected = [cos - 0.5 * sin, sin + 0.5 * cos, 3.0];
    for k in 0..3 {
        // Order four at 2 rad/s and 1 ms: (2e-3)⁵/120 a step, 2000 steps.
        assert!((top.rates[k] - expected[k]).abs() < 1e-11, "{k}");
    }
    // No symmetry: angular momentum in the world and energy stay.
    let inertia = [0.010, 0.015, 0.022];
    let start = [2.0, 4.0, -3.0];
    let tumbling = run(&in_vacuum(inertia), start);
    let axes = tumbling.axes();
    for k in 0..3 {
        let momentum: f64 = (0..3)
            .map(|j| axes[j][k] * inertia[j] * tumbling.rates[j])
            .sum();
        // Order four at 5 rad/s and 1 ms, 2000 steps, of 0.06 kg m²/s.
        assert!((momentum - inertia[k] * start[k]).abs() < 1e-10, "{k}");
    }
    let energy = |w: [f64; 3]| (0..3).map(|k| inertia[k] * w[k] * w[k]).sum::<f64>();
    assert!((energy(tumbling.rates) - energy(start)).abs() < 1e-10);
    // Free fall beside it: exact for RK4 up to 2000 additions.
    assert!((tumbling.position_m[2] + 0.5 * 9.81 * 4.0).abs() < 1e-10);
}

#[test]
fn analytic_what_stopping_rotors_lose_the_body_gains() {
    let settings = PlantSettings {
        surface: Surface::Absent,
        climb_damping_ns_per_m: 0.0,
        ..PlantSettings::default()
    };
    let body = BodySettings {
        inertia_kg_m2: [0.010, 0.015, 0.022],
        torque_per_thrust_m: 0.0,
        drag_ns_per_m: 0.0,
        drag_ns2_per_m2: 0.0,
        rotor_momentum_kg_m2_ps: 0.03,
    };
    let vehicle = RigidVehicle::new(&settings, &body).expect("valid settings");
    let hover_root = (settings.mass_kg * settings.gravity_mps2).sqrt();
    // Equal rotors across the centre: no torque. Front left and rear right turn clockwise.
    let momentum = |state: &RigidState| -> [f64; 3] {
        let [a, b, c, d] = state.rotors.root_thrust;
        let of_rotors = 0.03 * (b + d - a - c) / hover_root;
        let axes = state.axes();
        std::array::from_fn(|k| {
            let of_body = |j: usize| axes[j][k] * body.inertia_kg_m2[j] * state.rates[j];
            (0..3).map(of_body).sum::<f64>() + axes[2][k] * of_rotors
        })
    };
    let mut state = RigidState {
        rates: [2.0, 4.0, -3.0],
        ..RigidState::default()
    };
    let [fast, slow] = [1.3, 0.6].map(|share| share * hover_root);
    state.rotors.root_thrust = [fast, slow, fast, slow];
    let start = momentum(&state);
    assert!(start[2] < -0.1, "most of it is in the rotors: {start:?}");
    let decks = [DeckPose::default(); 3];
    for _ in 0..2_000 {
        let calm = Disturbance::default();
        vehicle.step(&mut state, &decks, &[0.0; 4], &calm, STEP_S);
    }
    assert!(state.rotors.root_thrust[0] < 0.1 * fast, "they stopped");
    for (end, start) in momentum(&state).iter().zip(start) {
        // Order four at 5 rad/s and 1 ms, 2000 steps, of 0.15 kg m²/s; the motors' lag is 50 steps.
        assert!((end - start).abs() < 1e-8, "{end} {start}");
    }
}

#[test]
fn analytic_drag_in_the_rotors_plane() {
    let settings = PlantSettings {
        surface: Surface::Absent,
        ..PlantSettings::default()
    };
    let vehicle = vehicle_of(&settings);
    let (c1, c2, m) = (0.35_f64, 0.02, 1.37);
    let (mut state, throttle) = vehicle.balanced(5.0, &DeckPose::default());
    let (v0, direction) = (6.0, [0.6, -0.8]);
    state.velocity_mps = [6.0 * direction[0], 6.0 * direction[1], 0.0];
    let mut calm = state;
    let decks = [DeckPose::default(); 3];
    for _ in 0..2_000 {
        vehicle.step(
            &mut state,
            &decks,
            &[throttle; 4],
            &Disturbance::default(),
            STEP_S,
        );
    }
    // v' = -(c1 + c2 v) v/m: v = c1 e/(c1 + c2 v0 (1 - e)) v0, e = exp(-c1 t/m).
    let e = (-c1 * 2.0 / m).exp();
    let v = v0 * c1 * e / (c1 + c2 * v0 * (1.0 - e));
    for k in 0..2 {
        // RK4 at 1 ms of a rate of 0.3 1/s: rounding only.
        assert!((state.velocity_mps[k] - v * direction[k]).abs() < 1e-12);
    }
    // Moving with the wind is rest; and the same without one.
    let wind = Disturbance {
        wind_mps: calm.velocity_mps,
        ..Disturbance::default()
    };
    let before = calm.velocity_mps;
    for _ in 0..100 {
        vehicle.step(&mut calm, &decks, &[throttle; 4], &wind, STEP_S);
    }
    for k in 0..3 {
        assert!((calm.velocity_mps[k] - before[k]).abs() < 1e-12);
    }
}

#[test]
fn analytic_stopped_rotors_have_no_linear_drag() {
    let settings = PlantSettings {
        surface: Surface::Absent,
        ..PlantSettings::default()
    };
    let vehicle = vehicle_of(&settings);
    let (c2, m, v0) = (0.02, 1.37, 6.0);
    let mut state = RigidState {
        velocity_mps: [v0, 0.0, 0.0],
        ..RigidState::default()
    };
    let decks = [DeckPose::default(); 3];
    for _ in 0..1_000 {
        let still = Disturbance::default();
        vehicle.step(&mut state, &decks, &[0.0; 4], &still, STEP_S);
    }
    // v' = -c2 v²/m over 1 s. RK4 at 1 ms of a rate of 0.1 1/s: rounding only.
    let expected = v0 / (1.0 + c2 * v0 / m);
    assert!((state.velocity_mps[0] - expected).abs() < 1e-12);
}

#[test]
fn analytic_torques_have_their_signs() {
    let settings = PlantSettings {
        surface: Surface::Absent,
        ..PlantSettings::default()
    };
    let vehicle = vehicle_of(&settings);
    let spun = |thrusts: [f64; 4]| {
        let mut state = RigidState::default();
        state.rotors.root_thrust = thrusts.map(|t: f64| (4.0 * t).sqrt());
        let pose = DeckPose::default();
        vehicle.loads(&state, &pose, &Disturbance::default())
    };
    // Left rotors (0, 1) push up: roll to the right, positive about x.
    let roll = spun([4.0, 4.0, 3.0, 3.0]).angular_acceleration;
    // 2 N more on the left, 0.16 m each side, over 0.0125 kg m²: 25.6 1/s².
    assert!((roll[0] - 25.6).abs() < 1e-9 && roll[1].abs() < 1e-9 && roll[2].abs() < 1e-9);
    // Rear rotors (1, 2) push up: nose down, positive about y.
    let pitch = spun([3.0, 4.0, 4.0, 3.0]).angular_acceleration;
    assert!((pitch[1] - 25.6).abs() < 1e-9);
    // Front left and rear right turn clockwise: the body turns anticlockwise.
    let yaw = spun([4.0, 3.0, 4.0, 3.0]).angular_acceleration;
    // 2 N × 0.016 m over 0.022 kg m².
    assert!((yaw[2] - 2.0 * 0.016 / 0.022).abs() < 1e-9);
}

#[test]
fn prop_bad_bodies_name_key_and_number() {
    let refuse = |body: BodySettings| {
        RigidVehicle::new(&PlantSettings::default(), &body)
            .map(|_| ())
            .expect_err("a bad body")
            .to_string()
    };
    let base = BodySettings::default();
    let negative = refuse(BodySettings {
        inertia_kg_m2: [0.01, -0.01, 0.02],
        ..base
    });
    assert!(negative.contains("body.inertia_kg_m2") && negative.contains("-0.01"));
    let flat = refuse(BodySettings {
        inertia_kg_m2: [0.01, 0.01, 0.03],
        ..base
    });
    assert!(flat.contains("sum of the other two") && flat.contains("0.03"));
    let unknown = toml::from_str::<BodySettings>("mass = 1.0");
    assert!(unknown.is_err());
}

#[test]
fn prop_wind_along_the_water_does_not_heave_a_vehicle_over_a_rolling_deck() {
    let vehicle = vehicle();
    let rolled = |roll_rad: f64| DeckCoordinates {
        value: [0.0, 0.0, 0.0, roll_rad, 0.0],
        ..DeckCoordinates::default()
    };
    let level = rolled(0.0).pose();
    // Metres up: no ground effect that could lean with the deck.
    let (state, _) = vehicle.balanced(6.0, &level);
    let lift = |deck: &DeckPose, wind_mps| {
        let disturbance = Disturbance {
            wind_mps,
            ..Disturbance::default()
        };
        let loads = vehicle.loads(&state, deck, &disturbance);
        loads.rotor_n.iter().sum::<f64>()
    };
    for roll_rad in [-0.05, 0.05, 0.2] {
        let deck = rolled(roll_rad).pose();
        let still = lift(&deck, [0.0; 3]);
        for wind_mps in [[8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [-3.0, 5.0, 0.0]] {
            // Rounding only.
            let gained = lift(&deck, wind_mps) - still;
            assert!(gained.abs() < 1e-12, "{roll_rad} {wind_mps:?}: {gained} N");
        }
        // Wind from below lifts, as over a level deck.
        let [leaning, straight] =
            [&deck, &level].map(|d| lift(d, [0.0, 0.0, 1.0]) - lift(d, [0.0; 3]));
        assert!(
            straight > 0.1 && (leaning - straight).abs() < 1e-12,
            "{leaning} {straight}"
        );
    }
}
