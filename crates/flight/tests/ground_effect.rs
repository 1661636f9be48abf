//! Ground-effect models against printed and closed-form values.

use proptest::prelude::*;
use touchdown_flight::Real;
use touchdown_flight::ground_effect::{
    Empirical, GroundEffect, GroundEffectInput, GroundEffectModel, Guarded, Lag, Outside,
    Polynomial, Ratio, StaticMap, Validity, VelocityInput,
};

const WEIGHT_N: f64 = 13.4397;

fn at(height_m: f64) -> GroundEffectInput<f64> {
    GroundEffectInput {
        thrust_n: WEIGHT_N,
        throttle: 0.4869,
        height_m,
        ..GroundEffectInput::default()
    }
}

/// Identified on a virtual rig.
fn lag<R: Real>() -> Lag<R> {
    Lag {
        map: StaticMap::new([-0.00901, 0.04948, 0.12176, 0.03698].map(R::from_f64)),
        k: [-0.0353, 0.1067].map(R::from_f64),
        tau_s: R::from_f64(0.162),
    }
}

/// Identified on a virtual rig.
fn ratio<R: Real>() -> Ratio<R> {
    Ratio::new(
        [
            -0.0311, -3.7681, 0.1613, 0.4663, 0.1354, 0.1646, -0.0047, 1.2235, -0.5224,
        ]
        .map(R::from_f64),
    )
}

#[test]
fn paper_polynomial_rest() {
    let model = Polynomial::<f64>::published();
    // Reference values are rounded to the decimals given.
    for (z, f, tolerance) in [(0.1, 0.9495, 6e-5), (0.2, 0.76, 6e-3), (0.5, -3.22, 6e-3)] {
        let rest = model.rest(&at(z));
        assert!((rest - f).abs() < tolerance, "z {z}: {rest} != {f}");
    }
    // Zero at 0.300 m: the slope is -10 N/m, the height rounded to 0.5 mm.
    assert!(model.rest(&at(0.2995)) > 0.0 && model.rest(&at(0.3005)) < 0.0);
}

#[test]
fn paper_polynomial_extrema() {
    let model = Polynomial::<f64>::published();
    // Maximum over height at 0.1170 m, minimum over throttle at 0.4030, each
    // rounded to 5e-5: the slope of a quadratic changes sign across that.
    let slope = |z: f64| model.rest(&at(z + 1e-6)) - model.rest(&at(z - 1e-6));
    assert!(slope(0.11695) > 0.0 && slope(0.11705) < 0.0);
    let rest = |s: f64| {
        model.rest(&GroundEffectInput {
            throttle: s,
            ..at(0.2)
        })
    };
    let slope = |s: f64| rest(s + 1e-6) - rest(s - 1e-6);
    assert!(slope(0.40290) < 0.0 && slope(0.40305) > 0.0);
}

#[test]
fn paper_polynomial_depends_on_relative_velocity() {
    let model = Polynomial::<f64>::published();
    for (vp, vq) in [(0.1, 0.0), (0.0, -0.2), (0.15, -0.1), (-0.2, -0.25)] {
        let input = GroundEffectInput {
            deck_velocity_mps: vp,
            vehicle_velocity_mps: vq,
            ..at(0.2)
        };
        let v = vq - vp;
        let relative = model.derivative(0.0, &at(0.2)) - 1.05 * v - 0.55 * v * v;
        // The printed coefficients differ from the relative form's by up to
        // 0.001 (linear) and 0.015 (quadratic): 0.002 N/s at these velocities.
        assert!((model.derivative(0.0, &input) - relative).abs() < 2e-3);
    }
}

#[test]
fn analytic_exact_steps() {
    let input = GroundEffectInput {
        deck_velocity_mps: 0.08,
        ..at(0.18)
    };
    // One step of a second equals a hundred of ten milliseconds, and the closed
    // form of a first-order lag.
    fn halves<M: GroundEffect<f64, State = f64>>(
        model: &M,
        input: &GroundEffectInput<f64>,
        b: f64,
    ) {
        let rest = model.rest(input);
        let (mut one, mut many) = (0.0, 0.0);
        model.step(&mut one, input, 1.0);
        for _ in 0..100 {
            model.step(&mut many, input, 0.01);
        }
        let exact = rest * (1.0 - b.exp());
        // A hundred steps of a few roundings of numbers of order one.
        assert!((one - exact).abs() < 1e-13, "{one} != {exact}");
        assert!((many - exact).abs() < 1e-13, "{many} != {exact}");
    }
    halves(&Polynomial::published(), &input, -0.088);
    halves(&ratio(), &input, -3.7681);
    halves(&lag(), &input, -1.0 / 0.162);
}

#[test]
fn analytic_rest_of_ratio_and_lag() {
    let psi = |z: f64, l: f64| 1.0 / (1.0 + (z / l).powi(2));
    let z = 0.15;
    let expected =
        (-0.0311 + 0.1613 * psi(z, 0.08) + 0.4663 * psi(z, 0.2) + 0.1354 * psi(z, 0.45)) / 3.7681;
    // The same sum in another order.
    assert!((ratio::<f64>().rest(&at(z)) - expected).abs() < 1e-15);
    let moving = GroundEffectInput {
        deck_velocity_mps: 0.1,
        ..at(z)
    };
    let pushed = 0.1 * (0.1646 - 0.0047 * 0.1 + 1.2235 * psi(z, 0.2) - 0.5224 * psi(z, 0.45));
    assert!((ratio::<f64>().rest(&moving) - expected - pushed / 3.7681).abs() < 1e-15);
    let h = -0.00901 + 0.04948 * psi(z, 0.08) + 0.12176 * psi(z, 0.2) + 0.03698 * psi(z, 0.45);
    let model = lag::<f64>();
    let state = model.rest(&at(z));
    assert!((state - h).abs() < 1e-15);
    let y = h + (-0.0353 + 0.1067 * psi(z, 0.45)) * 0.1;
    assert!((model.lift(&state, &moving).ratio - y).abs() < 1e-15);
}

#[test]
fn analytic_empirical() {
    let model = Empirical {
        mu: 2.23,
        rotor_radius_m: 0.12,
        rotor_offset_m: 0.05,
    };
    // Rotor plane at 0.15 m: T_IGE / T_OGE = 1.098, rounded to three decimals.
    let lift = model.lift(&(), &at(0.10));
    assert!((1.0 + lift.ratio - 1.098).abs() < 6e-4);
    // As a feed-forward it is base (1 - q), q = μ (R / 4z)².
    let q = 2.23 * (0.12_f64 / (4.0 * 0.15)).powi(2);
    assert!((1.0 / (1.0 + lift.ratio) - (1.0 - q)).abs() < 1e-15);
    // q is at most 0.6, also at and below the rotor plane.
    for z in [0.0, -0.05, -1.0] {
        assert!((model.lift(&(), &at(z)).ratio - 1.5).abs() < 1e-12);
    }
    // Level rotors at the same height are the same as one.
    let level = GroundEffectInput {
        rotor_heights_m: Some([0.15; 4]),
        ..at(0.10)
    };
    assert!((model.lift(&(), &level).ratio - lift.ratio).abs() < 1e-15);
}

#[test]
fn analytic_limits_of_a_force_go_with_the_thrust() {
    let model = Polynomial::<f64>::published();
    for (force_n, limited_n) in [(100.0, 6.0), (-100.0, -1.0), (2.5, 2.5)] {
        let mut state = force_n;
        model.limit(&mut state, 10.0, -0.1, 0.6);
        assert_eq!(state, limited_n);
    }
}

#[test]
fn analytic_guard_clamps_and_fades() {
    let map = StaticMap::new([0.0, 0.05, 0.12, 0.04]);
    let validity = Validity {
        height_min_m: 0.1,
        height_max_m: 0.5,
        outside: Outside::Fade,
        ..Validity::default()
    };
    let guarded = Guarded::new(map, validity);
    let state = guarded.rest(&at(0.3));
    let y = |z: f64| guarded.lift(&state, &at(z)).ratio;
    assert_eq!(y(0.02), map.ratio(0.1));
    assert_eq!(y(0.3), map.ratio(0.3));
    // Half of one further range (0.4 m) beyond: half of the lift at the edge.
    assert!((y(0.7) - 0.5 * map.ratio(0.5)).abs() < 1e-15);
    assert_eq!(y(0.9), 0.0);
    assert_eq!(y(5.0), 0.0);
    let clamped = Guarded::new(
        map,
        Validity {
            outside: Outside::Clamp,
            ..validity
        },
    );
    assert_eq!(clamped.lift(&state, &at(5.0)).ratio, map.ratio(0.5));
}

#[test]
fn prop_guard_keeps_states_within_ratios() {
    let guarded = Guarded::new(
        GroundEffectModel::Polynomial(Polynomial::<f64>::published()),
        Validity {
            height_max_m: 1.0,
            ..Validity::default()
        },
    );
    let mut state = guarded.rest(&at(1.0));
    for _ in 0..10_000 {
        guarded.step(&mut state, &at(1.0), 0.01);
    }
    let held = guarded.lift(&state, &at(1.0)).force_n;
    // The least ratio, -0.1, times the thrust; rounding only.
    assert!((held + 0.1 * WEIGHT_N).abs() < 1e-12);
    // It did not wind up: after 2 s at 0.12 m (f' about 0.08 + 0.12 N/s at
    // first) the force has begun to rise.
    for _ in 0..200 {
        guarded.step(&mut state, &at(0.12), 0.01);
    }
    assert!(guarded.lift(&state, &at(0.12)).force_n > held + 0.2);
}

#[test]
fn analytic_negative_relative_velocity() {
    let mut guarded = Guarded::new(lag::<f64>(), Validity::default());
    guarded.velocity = VelocityInput::NegativeRelative;
    let moving = GroundEffectInput {
        deck_velocity_mps: 0.05,
        vehicle_velocity_mps: -0.10,
        ..at(0.2)
    };
    let as_deck = GroundEffectInput {
        deck_velocity_mps: 0.15,
        ..at(0.2)
    };
    let state = guarded.rest(&moving);
    let apart = Guarded::new(lag::<f64>(), Validity::default());
    // 0.05 + 0.10 rounds as 0.15 does, to one unit.
    let difference = guarded.lift(&state, &moving).ratio - apart.lift(&state, &as_deck).ratio;
    assert!(difference.abs() < 1e-16);
}

/// A model of every family.
fn families() -> [GroundEffectModel<f64>; 6] {
    [
        GroundEffectModel::None,
        GroundEffectModel::Empirical(Empirical {
            mu: 1.9,
            rotor_radius_m: 0.12,
            rotor_offset_m: 0.05,
        }),
        GroundEffectModel::StaticMap(lag().map),
        GroundEffectModel::Polynomial(Polynomial::published()),
        GroundEffectModel::Ratio(ratio()),
        GroundEffectModel::Lag(lag()),
    ]
}

/// A measured number: mostly usable, sometimes not finite or huge.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -1.0..1.5,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1e300, -1e300]),
    ]
}

fn any_input() -> impl Strategy<Value = GroundEffectInput<f64>> {
    let numbers = (number(), number(), number(), number(), number());
    (numbers, prop::option::of(prop::array::uniform4(number()))).prop_map(
        |((thrust, throttle_share, height_m, vehicle, deck), rotor_heights_m)| GroundEffectInput {
            thrust_n: WEIGHT_N * thrust,
            throttle: throttle_share,
            height_m,
            vehicle_velocity_mps: vehicle,
            deck_velocity_mps: deck,
            rotor_heights_m,
        },
    )
}

proptest! {
    /// A step is the advance and then the lift, to the bit, whatever is measured.
    #[test]
    fn prop_a_step_within_limits_is_advance_and_lift(
        inputs in prop::collection::vec((any_input(), number()), 1..20),
        fades: bool,
        relative: bool,
    ) {
        for model in families() {
            let mut guarded = Guarded::new(model, Validity::default());
            if fades {
                guarded.validity.outside = Outside::Fade;
            }
            if relative {
                guarded.velocity = VelocityInput::NegativeRelative;
            }
            let mut stepped = guarded.rest(&at(0.4));
            let mut apart = stepped;
            for (input, dt) in &inputs {
                let lift = guarded.step(&mut stepped, input, *dt);
                guarded.advance(&mut apart, input, *dt);
                prop_assert_eq!(lift, guarded.lift(&apart, input));
                prop_assert_eq!(stepped, apart);
                prop_assert!(lift.ratio.is_finite() && lift.force_n.is_finite());
            }
        }
    }

    /// A value that is not finite is the previous one, and every other stays, to the bit.
    #[test]
    fn prop_numbers_that_are_not_finite_are_the_previous_ones(input in any_input()) {
        let previous = at(0.4);
        let filled = input.or_previous(&previous);
        let pairs = [
            (filled.thrust_n, input.thrust_n, previous.thrust_n),
            (filled.throttle, input.throttle, previous.throttle),
            (filled.height_m, input.height_m, previous.height_m),
            (filled.vehicle_velocity_mps, input.vehicle_velocity_mps, previous.vehicle_velocity_mps),
            (filled.deck_velocity_mps, input.deck_velocity_mps, previous.deck_velocity_mps),
        ];
        for (found, given, before) in pairs {
            let expected = if given.is_finite() { given } else { before };
            prop_assert_eq!(found.to_bits(), expected.to_bits());
        }
        let usable = |heights: &[f64; 4]| heights.iter().all(|z| z.is_finite());
        prop_assert_eq!(filled.rotor_heights_m, input.rotor_heights_m.filter(usable));
    }
}

#[test]
fn prop_nan_does_not_poison() {
    for model in families() {
        let guarded = Guarded::new(model, Validity::default());
        guarded.validate().unwrap();
        let mut state = guarded.rest(&at(0.2));
        let before = guarded.lift(&state, &at(0.2));
        let bad = GroundEffectInput {
            height_m: f64::NAN,
            deck_velocity_mps: f64::INFINITY,
            thrust_n: f64::NAN,
            rotor_heights_m: Some([0.1, f64::NAN, 0.1, 0.1]),
            ..at(0.2)
        };
        for dt in [0.01, f64::NAN, -1.0] {
            let lift = guarded.step(&mut state, &bad, dt);
            // At rest, and the last good values are used: nothing changes.
            assert!((lift.ratio - before.ratio).abs() < 1e-12);
            assert!((lift.force_n - before.force_n).abs() < 1e-12);
        }
        // Started blind, it recovers with the first good input.
        let mut blind = guarded.rest(&GroundEffectInput {
            height_m: f64::NAN,
            ..bad
        });
        for _ in 0..20_000 {
            guarded.step(&mut blind, &at(0.2), 0.01);
        }
        let after = guarded.lift(&blind, &at(0.2));
        // 200 s are 17 time constants of the slowest model: e^-17 = 4e-8.
        assert!((after.ratio - before.ratio).abs() < 1e-6);
        assert!((after.force_n - before.force_n).abs() < 1e-6);
    }
}

#[test]
fn prop_single_precision_agrees() {
    let double = Guarded::new(GroundEffectModel::Lag(lag::<f64>()), Validity::default());
    let single = Guarded::new(GroundEffectModel::Lag(lag::<f32>()), Validity::default());
    let input = |i: i32| {
        let z = 0.3 + 0.2 * (0.02 * f64::from(i)).sin();
        (
            at(z),
            GroundEffectInput {
                thrust_n: WEIGHT_N as f32,
                throttle: 0.4869,
                height_m: z as f32,
                ..GroundEffectInput::default()
            },
        )
    };
    let (a, b) = input(0);
    let (mut s64, mut s32) = (double.rest(&a), single.rest(&b));
    for i in 0..4000 {
        let (a, b) = input(i);
        let y64 = double.step(&mut s64, &a, 0.01).ratio;
        let y32 = single.step(&mut s32, &b, 0.01).ratio;
        // Ratios of order 0.1 with a few roundings of 6e-8, forgotten within 0.2 s.
        assert!((y64 - f64::from(y32)).abs() < 5e-7);
    }
}

#[test]
fn prop_validate_names_key_and_number() {
    let guarded = Guarded::new(
        lag::<f64>(),
        Validity {
            ratio_min: -1.5,
            ..Validity::default()
        },
    );
    assert_eq!(
        guarded.validate().unwrap_err().to_string(),
        "validity.ratio_min: expected a ratio above -1, found -1.5"
    );
    let swapped = Validity {
        height_min_m: 0.9,
        ..Validity::<f64>::default()
    };
    assert_eq!(
        swapped.validate().unwrap_err().to_string(),
        "validity.height_min_m: expected less than validity.height_max_m = 0.85, found 0.9"
    );
}

#[test]
fn analytic_guard_limits_the_lift_s_ratio() {
    // A map of 2 everywhere is held at the greatest ratio, one of -2 at the least.
    for (h0, expected) in [(2.0, 0.6), (-2.0, -0.1), (0.25, 0.25)] {
        let guarded = Guarded::new(StaticMap::new([h0, 0.0, 0.0, 0.0]), Validity::default());
        let mut state = guarded.rest(&at(0.3));
        let lift = guarded.step(&mut state, &at(0.3), 0.01);
        assert_eq!((lift.ratio, lift.force_n), (expected, 0.0));
    }
}
