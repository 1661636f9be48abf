//! Control laws against closed forms.

use crate::common;

use common::{GRAVITY, MASS_KG, WEIGHT_N, map};
use touchdown_flight::control::channel::{ChannelInput, VerticalChannel, ground_input};
use touchdown_flight::control::{
    Composite, ControlInput, Demand, Gains, Imbc, ImbcState, Law, Saturation, Ssc, SscState,
};
use touchdown_flight::ground_effect::{GroundEffectModel, Lift};
use touchdown_flight::reference::ReferencePoint;
use touchdown_flight::thrust::{FirstOrder, ThrustModel};
use touchdown_flight::{Limits, Measurement};

fn hover(height_m: f64, relative_velocity_mps: f64, reference_m: f64) -> ControlInput<f64> {
    ControlInput {
        height_m,
        relative_velocity_mps,
        reference: ReferencePoint {
            height_m: reference_m,
            ..ReferencePoint::default()
        },
        deck_acceleration_mps2: 0.0,
        mass_kg: MASS_KG,
        gravity_mps2: GRAVITY,
    }
}

#[test]
fn analytic_composite_law() {
    let law = Composite::<f64>::default();
    law.validate().unwrap();
    let input = ControlInput {
        reference: ReferencePoint {
            height_m: 0.4,
            velocity_mps: -0.1,
            acceleration_mps2: 0.05,
        },
        deck_acceleration_mps2: 0.3,
        ..hover(0.45, -0.08, 0.0)
    };
    let mut state = law_state(0.02);
    let lift = Lift {
        ratio: 0.08,
        force_n: 0.5,
    };
    let demand = law.demand(&state, &input, lift);
    let s = (-0.08 + 0.1) + 2.0 * 0.05;
    let base = 1.37 * (0.3 + 0.05 - 2.0 * 0.02) - 4.0 * s - 0.02 + 1.37 * 9.81;
    // Roundings of numbers of order ten.
    assert!((demand.sliding_mps - s).abs() < 1e-15);
    assert!((demand.thrust_n - (base - 0.5) / 1.08).abs() < 1e-13);
    // The feed-forward is exact: thrust and lift together make the base.
    assert!((demand.thrust_n + lift.total_n(demand.thrust_n) - base).abs() < 1e-13);
    law.advance(&mut state, &demand, Saturation::No, 0.01);
    assert!((state.integral_n - (0.02 + 0.01 * s * 0.01)).abs() < 1e-16);
}

fn law_state(integral_n: f64) -> touchdown_flight::control::CompositeState<f64> {
    touchdown_flight::control::CompositeState { integral_n }
}

#[test]
fn analytic_integral_stops_at_saturation() {
    let law = Composite::<f64>::default();
    let up = Demand {
        thrust_n: 30.0,
        sliding_mps: -1.0,
    };
    let mut state = law_state(0.0);
    // Too low: s < 0 asks for more thrust, of which there is none.
    law.advance(&mut state, &up, Saturation::High, 0.01);
    assert_eq!(state.integral_n, 0.0);
    // It may always unwind.
    law.advance(&mut state, &up, Saturation::Low, 0.01);
    assert!(state.integral_n < 0.0);
    // And never leaves its limit.
    for _ in 0..1000 {
        law.advance(&mut state, &up, Saturation::No, 1.0);
    }
    assert_eq!(state.integral_n, -law.gains.integral_limit_n);
    law.advance(&mut state, &up, Saturation::No, f64::NAN);
    let bad = Demand {
        sliding_mps: f64::NAN,
        ..up
    };
    law.advance(&mut state, &bad, Saturation::No, 0.01);
    assert_eq!(state.integral_n, -law.gains.integral_limit_n);
}

/// Flies a point mass with immediate thrust and `f(z, T)` for 60 s from 0.6 m,
/// the reference at `reference_m`; gives the final height.
fn fly(gains: Gains<f64>, reference_m: f64, force: impl Fn(f64, f64) -> f64) -> f64 {
    let law = Composite { gains };
    let limits = Limits::<f64>::default();
    let mut state = law_state(0.0);
    let (mut z, mut v, dt) = (0.6, 0.0, 0.002);
    for _ in 0..30_000 {
        let demand = law.demand(&state, &hover(z, v, reference_m), Lift::default());
        let thrust = limits.thrust(demand.thrust_n);
        v += dt * ((thrust + force(z, thrust)) / MASS_KG - GRAVITY);
        z += dt * v;
        law.advance(&mut state, &demand, Saturation::No, dt);
    }
    z
}

#[test]
fn paper_constant_error_leaves_an_eighth() {
    let gains = Gains {
        k_i: 0.0,
        ..Gains::default()
    };
    for e in [-0.4, 0.2, 0.8] {
        let z = fly(gains, 0.4, |_, _| e);
        // The slowest pole is near -2 1/s: after 60 s nothing is left but rounding.
        assert!((z - 0.4 - e / 8.0).abs() < 1e-9, "{e}: {z}");
    }
}

#[test]
fn paper_hover_of_pure_feedback() {
    // The reference at the deck: 8 z = f(z, T), T = W - 8 z.
    let gains = Gains {
        k_i: 0.0,
        ..Gains::default()
    };
    let z = fly(gains, 0.0, |z, thrust| map::<f64>().ratio(z) * thrust);
    let (mut low, mut high) = (0.01, 0.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let f = map::<f64>().ratio(middle) * (WEIGHT_N - 8.0 * middle);
        if f > 8.0 * middle {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert!((z - low).abs() < 1e-9, "{z} != {low}");
    // It does not land: the cushion carries it above 0.1 m.
    assert!(low > 0.12 && low < 0.2);
}

#[test]
fn analytic_imbc_internal_model_step_is_exact() {
    let law = Imbc::<f64>::new(3.2);
    law.validate().unwrap();
    // Small contributions, so that the limit of 20 N plays no part.
    let start = ImbcState {
        xi: [0.1, -0.05, 0.08],
    };
    let demand = Demand {
        thrust_n: 0.0,
        sliding_mps: 0.02,
    };
    let mut exact = start;
    law.advance(&mut exact, &demand, Saturation::No, 0.1);
    // The equations as written, by Runge-Kutta at 0.1 ms.
    let (p1, p2, p3, w) = (1.5, 2.0, 2.5, 3.2);
    let (c0, c1, c2) = (p1 * p2 * p3, p1 * p2 + p2 * p3 + p3 * p1, p1 + p2 + p3);
    let rate = |x: [f64; 3]| {
        let u_im = c0 * x[0] + (c1 - w * w) * x[1] + c2 * x[2];
        let u_st = -4.0 * 0.02;
        [x[1], x[2], -c0 * x[0] - c1 * x[1] - c2 * x[2] + u_im + u_st]
    };
    let along =
        |x: [f64; 3], k: [f64; 3], h: f64| [x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2]];
    let (mut x, h) = (start.xi, 1e-4);
    for _ in 0..1000 {
        let k1 = rate(x);
        let k2 = rate(along(x, k1, 0.5 * h));
        let k3 = rate(along(x, k2, 0.5 * h));
        let k4 = rate(along(x, k3, h));
        for i in 0..3 {
            x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    for (found, expected) in exact.xi.iter().zip(x) {
        // Runge-Kutta: (3.2e-4)^4 per unit, and 1000 roundings.
        assert!((found - expected).abs() < 1e-12);
    }
}

#[test]
fn analytic_imbc_rejects_a_sine_of_its_frequency() {
    // A point mass over a heaving deck: the tracking error must vanish although
    // the law is not told the deck's acceleration, nor a constant push.
    let w = core::f64::consts::PI;
    let law = Imbc::<f64>::new(w);
    let mut state = ImbcState::default();
    let (mut z, mut v, dt) = (0.4, 0.0, 0.001);
    let mut worst: f64 = 0.0;
    for i in 0..60_000 {
        let t = dt * f64::from(i);
        let demand = law.demand(&state, &hover(z, v, 0.4));
        let deck_acceleration = -0.05 * w * w * (w * t + 0.3).sin();
        v += dt * ((demand.thrust_n + 0.7) / MASS_KG - GRAVITY - deck_acceleration);
        z += dt * v;
        law.advance(&mut state, &demand, Saturation::No, dt);
        if t > 50.0 {
            worst = worst.max((z - 0.4).abs());
        }
    }
    // What is left is of the order of the integration step: the disturbance of
    // 0.05 m would leave 31 mm without the internal model, the push 87 mm.
    assert!(worst < 2e-4, "{worst}");
}

#[test]
fn prop_imbc_stays_bounded() {
    let law = Imbc::<f64>::new(3.0);
    let mut state = ImbcState::default();
    for i in 0..100_000 {
        let demand = Demand {
            thrust_n: 0.0,
            sliding_mps: if i % 1000 == 0 { 1e6 } else { -1e3 },
        };
        law.advance(&mut state, &demand, Saturation::No, 0.01);
        let u = law.demand(&state, &hover(0.0, 0.0, 0.0)).thrust_n - WEIGHT_N;
        // The contribution is limited to 20 N.
        assert!(u.abs() < 20.0 + 1e-9);
        assert!(state.xi.iter().all(|xi| xi.abs() < 1e9));
    }
}

#[test]
fn analytic_ssc_filter() {
    let law = Ssc::<f64>::default();
    law.validate().unwrap();
    let mut state = SscState { thrust_n: WEIGHT_N };
    let input = ControlInput {
        deck_acceleration_mps2: 0.2,
        ..hover(0.5, 0.1, 0.45)
    };
    let s = 0.1 + 2.0 * 0.05;
    let u = WEIGHT_N + 1.37 * (0.2 - 2.0 * 0.1) - 4.0 * s - 1.5 * (s / 0.15_f64).tanh();
    let decay = (-0.01_f64 / 0.03).exp();
    let expected = u + (WEIGHT_N - u) * decay;
    // Roundings of numbers of order ten.
    assert!((law.demand(&state, &input, 0.01).thrust_n - expected).abs() < 1e-13);
    // The next step starts from what was sent.
    law.advance(&mut state, 12.0);
    let expected = u + (12.0 - u) * decay;
    assert!((law.demand(&state, &input, 0.01).thrust_n - expected).abs() < 1e-13);
    law.advance(&mut state, f64::NAN);
    assert_eq!(state.thrust_n, 12.0);
}

/// Time constant of the motors, s.
const T_M_S: f64 = 0.06;

/// Thrust and saturation while a vehicle at rest asks for a thrust that is `step` times its weight, from the weight on: after
/// each of `steps` periods of `dt` seconds.
fn asked(share: f64, step: f64, steps: u32, dt: f64) -> Vec<(f64, Saturation)> {
    let thrust = ThrustModel::FirstOrder(FirstOrder {
        c0: 5.0,
        c1: 0.5,
        t_m_s: T_M_S,
    });
    let gains = Gains {
        k_i: 0.0,
        ..Gains::default()
    };
    let channel = VerticalChannel {
        mass_kg: MASS_KG,
        gravity_mps2: GRAVITY,
        law: &Law::Composite(Composite { gains }),
        thrust: &thrust,
        motor_lag_share: share,
        ground_effect: &GroundEffectModel::None,
        limits: &Limits::default(),
    };
    channel.validate().unwrap();
    let measurement = Measurement::default();
    let ground = ground_input(&measurement);
    let input = ChannelInput {
        measurement,
        reference: ReferencePoint::default(),
        deck_acceleration_mps2: GRAVITY * (step - 1.0),
        disturbance_n: 0.0,
        cos_tilt: 1.0,
    };
    let mut state = channel.initial(&ground, thrust.throttle_for(WEIGHT_N));
    let period = |_| {
        let lift = Lift::default();
        let output = channel.command(&mut state, &input, lift, dt);
        assert!(output.command.thrust_n <= Limits::<f64>::default().thrust_max_n);
        channel.advance_models(&mut state, &ground, dt);
        (state.thrust.thrust_n(), output.saturation)
    };
    (0..steps).map(period).collect()
}

#[test]
fn analytic_thrust_follows_with_a_share_of_the_motors_lag() {
    for step in [0.8, 1.2] {
        for share in [1.0, 0.7, 0.5] {
            // After the time constant 1/e of the step of √T is left.
            let steps = 600.0 * share;
            let found = asked(share, step, steps as u32, T_M_S / 600.0);
            let left = (found.last().unwrap().0.sqrt() - (step * WEIGHT_N).sqrt())
                / (WEIGHT_N.sqrt() - (step * WEIGHT_N).sqrt());
            // The throttle is held for 1/600 of the time constant, so the rest of 1/e errs by at most 1/600 of itself, 6e-4.
            assert!((left - (-1.0_f64).exp()).abs() < 7e-4, "{share}: {left}");
        }
    }
}

#[test]
fn analytic_no_swing_of_the_thrust_grows_at_half_of_the_lag() {
    // Periods from a fifth to ten times the time constant. Each period leaves 1 - 2 (1 - e^(-dt/T_m)) of the rest of the step of √T.
    for dt in [0.012, 0.06, 0.6] {
        for step in [0.7, 1.2] {
            let wanted = (step * WEIGHT_N).sqrt();
            let mut left = WEIGHT_N.sqrt() - wanted;
            for (thrust_n, saturation) in asked(0.5, step, 400, dt) {
                left *= 2.0 * (-dt / T_M_S).exp() - 1.0;
                // Roundings of 400 steps.
                assert!((thrust_n.sqrt() - wanted - left).abs() < 1e-9);
                assert_eq!(saturation, Saturation::No);
            }
        }
    }
}

#[test]
fn analytic_a_step_beyond_the_greatest_thrust_counts_as_limited() {
    let greatest = Limits::<f64>::default().thrust_max_n / WEIGHT_N;
    let step = 0.95 * greatest;
    // √T would be led from 1 to 1 + 2 (√step - 1), which is beyond: the integral has to wait until the rotors follow.
    let found = asked(0.5, step, 60, 0.01);
    assert_eq!(found[0].1, Saturation::High);
    assert_eq!(found[59].1, Saturation::No);
    assert!(
        asked(1.0, step, 60, 0.01)
            .iter()
            .all(|s| s.1 == Saturation::No)
    );
}
