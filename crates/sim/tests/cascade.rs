//! Attitude and rate control: mixing, limits, responses, flight.

use touchdown_sim::STEP_S;
use touchdown_sim::air::turbulence::RotorTurbulence;
use touchdown_sim::air::wind::{DrydenSettings, Wind, WindSettings};
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::cascade::{AttitudeSetpoint, Cascade, CascadeSettings, CascadeState};
use touchdown_sim::body::plant::{PlantSettings, Surface};
use touchdown_sim::body::rigid::{Disturbance, RigidState, RigidVehicle};
use touchdown_sim::body::rotors::{RotorPlace, RotorsState};
use touchdown_sim::deck::rigid::{DeckPose, RigidMotion, SeaSettings};
use touchdown_sim::random::{Purpose, Stream};

const W: f64 = 1.37 * 9.81;

fn vehicle(surface: Surface) -> RigidVehicle {
    let plant = PlantSettings {
        surface,
        ..PlantSettings::default()
    };
    RigidVehicle::new(&plant, &BodySettings::default()).expect("valid settings")
}

fn cascade() -> Cascade {
    Cascade::new(&CascadeSettings::default(), &vehicle(Surface::Plate)).expect("valid settings")
}

fn turn(axis: usize, angle_rad: f64) -> [f64; 4] {
    let (sin, cos) = (0.5 * angle_rad).sin_cos();
    let mut q = [cos, 0.0, 0.0, 0.0];
    q[axis + 1] = sin;
    q
}

fn setpoint(attitude: [f64; 4]) -> AttitudeSetpoint {
    AttitudeSetpoint {
        thrust_n: W,
        attitude,
        yaw_rate: 0.0,
        body_rates: None,
    }
}

/// Angle about an axis of an attitude that is turned little about the others.
fn angle(state: &RigidState, axis: usize) -> f64 {
    2.0 * state.attitude[axis + 1].atan2(state.attitude[0])
}

/// Flies `steps` from hover in free air with a setpoint; returns angles about `axis`.
fn fly(wanted: &AttitudeSetpoint, axis: usize, steps: u32) -> (RigidState, Vec<f64>) {
    let vehicle = vehicle(Surface::Absent);
    let cascade = Cascade::new(&CascadeSettings::default(), &vehicle).expect("valid settings");
    let decks = [DeckPose::default(); 3];
    let (mut state, throttle) = vehicle.balanced(5.0, &decks[0]);
    let (mut control, mut sent) = (CascadeState::default(), [throttle; 4]);
    let mut angles = Vec::new();
    for step in 0..steps {
        if step % 2 == 0 {
            sent = cascade
                .step(&mut control, state.attitude, state.rates, wanted)
                .throttle;
        }
        vehicle.step(&mut state, &decks, &sent, &Disturbance::default(), STEP_S);
        angles.push(angle(&state, axis));
    }
    (state, angles)
}

#[test]
fn analytic_mixer_is_the_inverse_of_the_vehicle() {
    let (a, kappa) = (0.16, 0.016);
    for torque in [[0.1, -0.2, 0.02], [-0.3, 0.05, -0.03], [0.0; 3]] {
        let (f, given_up) = cascade().mix(W, torque);
        assert_eq!(given_up, [0.0; 3]);
        // Rounding only.
        assert!((f.iter().sum::<f64>() - W).abs() < 1e-12);
        assert!((a * (f[0] + f[1] - f[2] - f[3]) - torque[0]).abs() < 1e-12);
        assert!((a * (f[1] + f[2] - f[0] - f[3]) - torque[1]).abs() < 1e-12);
        assert!((kappa * (f[0] - f[1] + f[2] - f[3]) - torque[2]).abs() < 1e-12);
    }
}

#[test]
fn analytic_throttles_hold_their_thrusts_on_one_battery() {
    let vehicle = vehicle(Surface::Plate);
    let motor = vehicle.rotors().plant().motor();
    for thrusts in [[3.36; 4], [2.0, 4.5, 3.0, 3.5], [0.2, 0.3, 0.2, 0.3]] {
        let s = cascade().throttles(thrusts);
        let load = 0.25 * s.iter().sum::<f64>();
        for i in 0..4 {
            let x = (4.0_f64 * thrusts[i]).sqrt();
            // At rest: rounding of a rate of order 100.
            assert!(motor.derivative_at_load(x, s[i], load).abs() < 1e-11);
        }
        // So do the rotors of the vehicle.
        let rotors = vehicle.rotors();
        let state = RotorsState {
            root_thrust: thrusts.map(|t: f64| (4.0 * t).sqrt()),
            ..RotorsState::default()
        };
        let places = [RotorPlace::default(); 4];
        let target = rotors.target(&state.root_thrust, &places);
        let rate = rotors.derivative(&state, &target, &s, &places);
        assert!(rate.root_thrust.iter().all(|r| r.abs() < 1e-11), "{rate:?}");
    }
}

#[test]
fn prop_mixer_gives_way_in_order() {
    let cascade = cascade();
    // Yaw gives way first: roll stays whole.
    let (f, given_up) = cascade.mix(W, [0.3, 0.0, 2.0]);
    assert!(given_up[2] > 0.0 && given_up[0] == 0.0 && given_up[1] == 0.0);
    assert!((0.16 * (f[0] + f[1] - f[2] - f[3]) - 0.3).abs() < 1e-12);
    // At full thrust, thrust gives way to roll.
    let (f, given_up) = cascade.mix(20.4, [0.3, 0.0, 0.0]);
    assert!(given_up[0] > 0.0 && given_up[1] == 0.0);
    assert!((0.16 * (f[0] + f[1] - f[2] - f[3]) - 0.3).abs() < 1e-12);
    // With little thrust, roll gives way (no air mode): thrust is not raised.
    let (f, given_up) = cascade.mix(1.0, [0.5, 0.0, 0.0]);
    assert!(given_up[1] > 0.0 && (f.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

proptest::proptest! {
    #[test]
    fn prop_throttles_are_in_range_whatever_comes(
        thrust in -50.0_f64..100.0, x in -9.0_f64..9.0, y in -9.0_f64..9.0, z in -9.0_f64..9.0,
        q in proptest::array::uniform4(-1.0_f64..1.0), w in proptest::array::uniform4(-1.0_f64..1.0),
        bad in 0_usize..6,
    ) {
        let cascade = cascade();
        let mut control = CascadeState::default();
        let size = q.iter().map(|v| v * v).sum::<f64>().sqrt();
        proptest::prop_assume!(size > 0.1);
        let attitude = q.map(|v| v / size);
        let mut wanted = AttitudeSetpoint { thrust_n: thrust, attitude: w, yaw_rate: 0.3, body_rates: None };
        for step in 0..4 {
            let mut rates = [x, y, z];
            if step == 2 && bad < 3 {
                rates[bad] = f64::NAN;
            } else if step == 2 {
                wanted.attitude[bad - 2] = f64::INFINITY;
            }
            let out = cascade.step(&mut control, attitude, rates, &wanted);
            for s in out.throttle {
                proptest::prop_assert!((0.0..=1.0).contains(&s), "{}", s);
            }
        }
    }
}

#[test]
fn prop_steps_of_attitude_are_quick_and_damped() {
    for (axis, within_s) in [(0, 0.5), (1, 0.5), (2, 2.5)] {
        let wanted = 0.2;
        let (state, angles) = fly(&setpoint(turn(axis, wanted)), axis, 4_000);
        let greatest = angles.iter().copied().fold(0.0, f64::max);
        assert!(greatest < 1.2 * wanted, "{axis}: overshoot to {greatest}");
        let last_off = angles
            .iter()
            .rposition(|a| (a - wanted).abs() > 0.1 * wanted);
        let settled_s = last_off.map_or(0.0, |i| i as f64 * STEP_S);
        assert!(settled_s < within_s, "{axis}: {settled_s} s");
        // Climb damping of the rolling rotors is all that pulls: the integral holds it off.
        assert!((angles[3_999] - wanted).abs() < 0.01 * wanted, "{axis}");
        assert!(state.rates.iter().all(|r| r.abs() < 0.02), "{axis}");
    }
}

#[test]
fn analytic_rates_asked_for() {
    let cascade = cascade();
    let level = [1.0, 0.0, 0.0, 0.0];
    // Small angles: gain times angle, 2 sin(θ/2); yaw by its own gain, whatever its weight (to θ³).
    let rates = cascade.rate_setpoint(level, &setpoint(turn(0, 0.05)));
    assert!(
        (rates[0] - 6.5 * 2.0 * 0.025_f64.sin()).abs() < 1e-9,
        "{rates:?}"
    );
    let rates = cascade.rate_setpoint(level, &setpoint(turn(2, 0.05)));
    assert!((rates[2] - 2.8 * 0.05).abs() < 1e-4, "{rates:?}");
    // The limits, and the same attitude with the other sign.
    let far = cascade.rate_setpoint(turn(0, -0.7), &setpoint(turn(0, 0.7)));
    assert_eq!(far[0], 3.84);
    let same = cascade.rate_setpoint(turn(0, 0.3), &setpoint(turn(0, 0.3).map(|v| -v)));
    assert!(same.iter().all(|r| r.abs() < 1e-9), "{same:?}");
    // A tilt of 80° is flown as 45°: at 0.785 rad nothing is left to do.
    let held = cascade.rate_setpoint(turn(1, 0.785), &setpoint(turn(1, 1.4)));
    assert!(held.iter().all(|r| r.abs() < 1e-9), "{held:?}");
    // Yaw rate is about the world's vertical.
    let mut turning = setpoint(turn(0, 0.5));
    turning.yaw_rate = 1.0;
    let rates = cascade.rate_setpoint(turn(0, 0.5), &turning);
    assert!((rates[1] - 0.5_f64.sin()).abs() < 1e-9 && (rates[2] - 0.5_f64.cos()).abs() < 1e-9);
}

#[test]
fn prop_it_holds_its_attitude_over_a_sea_in_wind() {
    let vehicle = vehicle(Surface::Plate);
    let cascade = Cascade::new(&CascadeSettings::default(), &vehicle).expect("valid settings");
    let sea = RigidMotion::Sea(SeaSettings::default());
    let deck = sea.build(9.81, 5, 0).expect("valid");
    let deck = deck.splined(0.0, 20.1, 0.1).expect("valid times");
    let settings = WindSettings {
        steady_mps: [2.0, 1.0, 0.0],
        dryden: DrydenSettings::low_altitude(6.0, 3.0).ok(),
        gust: None,
        airwake: None,
    };
    let mut wind = Wind::new(&settings, STEP_S, 5, 0).expect("valid");
    let stream = Stream::new(5, 0, Purpose::Turbulence);
    let mut turbulence = RotorTurbulence::new(stream, 0.15, STEP_S, [0.0; 4]);
    let (mut state, throttle) = vehicle.balanced(0.8, &deck.at(0.0));
    let (mut control, mut sent) = (CascadeState::default(), [throttle; 4]);
    let mut disturbance = Disturbance::default();
    let (mut tilt, mut off): (f64, f64) = (0.0, 0.0);
    for step in 0..20_000 {
        let t = f64::from(step) * STEP_S;
        let poses = [t, t + 0.5 * STEP_S, t + STEP_S].map(|t| deck.at(t));
        if step % 2 == 0 {
            // A plain position loop above it: where the deck is, 0.8 m up.
            let pull = |k: usize, up: f64| {
                let error = state.position_m[k] - poses[0].origin_m[k] - up;
                let rate = state.velocity_mps[k] - poses[0].velocity_mps[k];
                (-3.0 * error - 3.0 * rate).clamp(-4.0, 4.0)
            };
            let (ax, ay, az) = (pull(0, 0.0), pull(1, 0.0), pull(2, 0.8));
            let (pitch, roll) = ((ax / 9.81).atan(), (-ay / 9.81).atan());
            let (a, b) = (turn(1, pitch), turn(0, roll));
            let wanted = AttitudeSetpoint {
                thrust_n: 1.37 * (9.81 + az),
                attitude: [a[0] * b[0], a[0] * b[1], a[2] * b[0], -a[2] * b[1]],
                yaw_rate: 0.0,
                body_rates: None,
            };
            let (q, w) = (state.attitude, state.rates);
            sent = cascade.step(&mut control, q, w, &wanted).throttle;
        }
        let loads = vehicle.step(&mut state, &poses, &sent, &disturbance, STEP_S);
        let sd = vehicle
            .rotors()
            .turbulence_sd_n(&state.rotors.root_thrust, &loads.target);
        disturbance.turbulence_n = turbulence.step(sd);
        wind.step();
        disturbance.wind_mps = wind.velocity_mps();
        tilt = tilt.max(state.axes()[2][2].clamp(-1.0, 1.0).acos());
        off = (0..2).fold(off, |off, k| {
            off.max((state.position_m[k] - poses[2].origin_m[k]).abs())
        });
    }
    // Wind of 2.2 m/s drags 0.9 N (4° of tilt, 0.2 m without an integral); seas of 0.5 m and gusts do the rest.
    assert!(
        state.is_finite() && tilt < 0.35 && off < 0.8,
        "{tilt} {off}"
    );
}

#[test]
fn prop_bad_settings_name_key_and_number() {
    let bad = CascadeSettings {
        gyro_cutoff_hz: 400.0,
        ..CascadeSettings::default()
    };
    let message = bad.validate().expect_err("above half the rate").to_string();
    assert!(
        message.contains("gyro_cutoff_hz") && message.contains("400"),
        "{message}"
    );
    let text = toml::to_string(&CascadeSettings::default()).expect("settings are text");
    let read: CascadeSettings = toml::from_str(&text).expect("read back");
    assert_eq!(read, CascadeSettings::default());
    assert!(toml::from_str::<CascadeSettings>("roll_p = 6.5").is_err());
}
