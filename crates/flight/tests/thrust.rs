//! Thrust models against printed and closed-form values.

use touchdown_flight::thrust::{
    FirstOrder, LaggedThrottle, Library, ROOT_THRUST_MIN, StaticThrust, ThrustModel, ThrustState,
};

fn first_order() -> ThrustModel<f64> {
    ThrustModel::FirstOrder(FirstOrder {
        c0: 6.9,
        c1: 0.3,
        t_m_s: 0.06,
    })
}

fn static_map() -> ThrustModel<f64> {
    ThrustModel::Static(StaticThrust {
        coefficients: [0.35, 8.0, -1.0, -2.5],
        t_m_s: 0.06,
    })
}

#[test]
fn paper_rest_thrust() {
    let model = ThrustModel::<f64>::published();
    for (s, thrust) in [
        (0.2, 4.880),
        (0.3, 8.088),
        (0.4, 11.092),
        (0.4869, 13.440),
        (0.5, 13.768),
        (0.6, 16.047),
        (0.8, 19.268),
        (1.0, 20.476),
    ] {
        let x = model.rest(s);
        // Reference values are rounded to three decimals; 0.4869 itself stands for
        // hover and is rounded to four, worth 26 N times 5e-5.
        let tolerance = if s == 0.4869 { 1.4e-3 } else { 6e-4 };
        assert!(
            (x * x - thrust).abs() < tolerance,
            "s {s}: {} != {thrust}",
            x * x
        );
        let single = ThrustModel::<f32>::published().rest(s as f32);
        // f32: about 20 roundings of 6e-8 in terms up to 60, over a slope of 3.
        assert!((f64::from(single) - x).abs() < 3e-5);
    }
}

#[test]
fn paper_throttle_for_thrust() {
    let model = ThrustModel::<f64>::published();
    for (thrust, s) in [
        (10.0, 0.3625),
        (11.0, 0.3968),
        (12.0, 0.4324),
        (13.0, 0.4698),
        (14.0, 0.5094),
        (15.0, 0.5518),
        (16.0, 0.5977),
    ] {
        let found = model.throttle_for(thrust);
        // Reference values are rounded to four decimals.
        assert!((found - s).abs() < 6e-5, "T {thrust}: {found} != {s}");
        let single = ThrustModel::<f32>::published().throttle_for(thrust as f32);
        // f32: roundings of 6e-8 in terms up to 60, over a slope of 15 or more.
        assert!((f64::from(single) - found).abs() < 5e-6);
    }
}

#[test]
fn paper_eigenvalue_at_rest() {
    let model = ThrustModel::<f64>::published();
    for (s, eigenvalue) in [(0.3, -2.926), (0.5, -4.913), (0.8, -7.225)] {
        let (x, h) = (model.rest(s), 1e-5);
        let slope = (model.derivative(x + h, s) - model.derivative(x - h, s)) / (2.0 * h);
        // Rounded to three decimals; the central difference adds less than 1e-8.
        assert!((slope - eigenvalue).abs() < 6e-4, "s {s}: {slope}");
    }
}

#[test]
fn paper_step_response() {
    let model = ThrustModel::<f64>::published();
    // The coefficients and the start as printed, one millisecond a step.
    let mut state = ThrustState { x: 2.844_017_5 };
    let mut done = 0;
    for (ms, x) in [
        (100, 3.118_543),
        (200, 3.319_594),
        (500, 3.611_114),
        (1000, 3.701_729),
    ] {
        while done < ms {
            model.step(&mut state, 0.5, 1e-3);
            done += 1;
        }
        // Rounded to six decimals, from a start rounded to seven.
        assert!((state.x - x).abs() < 1e-6, "{ms} ms: {} != {x}", state.x);
    }
}

#[test]
fn analytic_step_size_does_not_matter() {
    let model = ThrustModel::<f64>::published();
    let (mut fine, mut coarse) = (ThrustState { x: 2.844 }, ThrustState { x: 2.844 });
    for _ in 0..1000 {
        model.step(&mut fine, 0.5, 1e-3);
    }
    model.step(&mut coarse, 0.5, 1.0);
    // Fourth order at 20 ms and rates of 5 1/s: (5 · 0.02)^5 / 120 · 50 steps < 1e-5.
    assert!((fine.x - coarse.x).abs() < 1e-5);
}

#[test]
fn analytic_first_order_exponential() {
    let model = first_order();
    let mut state = ThrustState { x: 1.0 };
    for _ in 0..7 {
        model.step(&mut state, 0.5, 0.01);
    }
    let exact = 3.75 + (1.0 - 3.75) * (-0.07_f64 / 0.06).exp();
    // Seven exact steps of a few roundings each.
    assert!((state.x - exact).abs() < 1e-14);
    // The inverse of a line.
    assert!((model.throttle_for(3.75 * 3.75) - 0.5).abs() < 1e-15);
}

#[test]
fn analytic_inverse_of_rest() {
    for model in [first_order(), static_map(), ThrustModel::published()] {
        model.validate().unwrap();
        let mut last = 0.0;
        // From just above the thrust at zero throttle.
        for i in 2..=200 {
            let thrust = 0.1 * f64::from(i);
            let s = model.throttle_for(thrust);
            assert!(s >= last, "not monotone at {thrust} N: {s} < {last}");
            last = s;
            let x = model.rest(s);
            // Both searches end within roundings (1e-15) over slopes of order one;
            // near full throttle the map is flat and s may be anywhere in 1e-8.
            assert!((x * x - thrust).abs() < 1e-9, "{thrust} N: {}", x * x);
        }
        assert!(model.throttle_for(1e6) <= 1.0);
        assert!(model.throttle_for(f64::NAN) >= 0.0);
        assert!(model.throttle_for(-3.0) == model.throttle_for(0.0));
    }
}

#[test]
fn prop_clamp_keeps_off_the_unstable_branch() {
    let model = ThrustModel::<f64>::published();
    // Without the limit, x diverges from zero for s >= 0.65.
    assert!(model.derivative(0.0, 0.66) < 0.0 || model.derivative(0.0, 0.7) < 0.0);
    for s in [0.65, 0.8, 1.0] {
        let mut state = ThrustState { x: ROOT_THRUST_MIN };
        for _ in 0..500 {
            model.step(&mut state, s, 0.01);
        }
        // Five seconds at rates of 5 1/s or more leave less than 1e-9 of the way.
        assert!((state.x - model.rest(s)).abs() < 1e-6);
    }
}

#[test]
fn prop_bad_input_holds_the_state() {
    for model in [first_order(), static_map(), ThrustModel::published()] {
        let mut state = ThrustState { x: 3.0 };
        for (s, dt) in [
            (f64::NAN, 0.01),
            (0.5, f64::NAN),
            (0.5, -1.0),
            (0.5, f64::INFINITY),
            (f64::INFINITY, 0.01),
        ] {
            model.step(&mut state, s, dt);
            assert_eq!(state.x, 3.0);
        }
        model.step(&mut state, 7.0, 0.01);
        assert!(state.x.is_finite() && state.x > 3.0);
    }
}

#[test]
fn prop_validate_names_key_and_number() {
    let error = FirstOrderWith(-0.1).check();
    assert_eq!(
        error,
        "thrust.first_order.t_m_s: expected a finite number greater than 0, found -0.1"
    );
    let mut library = Library::<f64>::published();
    library.s3 = f64::NAN;
    let error = ThrustModel::Library(library).validate().unwrap_err();
    assert_eq!(
        error.to_string(),
        "thrust.library.s3: expected a finite number, found NaN"
    );
}

struct FirstOrderWith(f64);

impl FirstOrderWith {
    fn check(&self) -> String {
        ThrustModel::FirstOrder(FirstOrder {
            c0: 6.9,
            c1: 0.3,
            t_m_s: self.0,
        })
        .validate()
        .unwrap_err()
        .to_string()
    }
}

#[test]
fn analytic_four_rotors_have_four_times_the_thrust_at_every_throttle() {
    let lagged = ThrustModel::LaggedThrottle(LaggedThrottle {
        coefficients: [0.0, 1.0, 4.0, 0.5],
        t_m_s: 0.05,
    });
    for one in [
        first_order(),
        static_map(),
        ThrustModel::published(),
        lagged,
    ] {
        let four = one.of_rotors(4.0);
        four.validate().unwrap();
        assert_eq!(one.of_rotors(1.0), one);
        // 4 × 0.5 rotors are twice as many.
        let two = four.of_rotors(0.5);
        let mut states = [one, four].map(|model| ThrustState { x: model.rest(0.3) });
        for i in 3..=9 {
            let s = 0.1 * f64::from(i);
            let (thrust, rest) = (one.rest(s).powi(2), four.rest(s).powi(2));
            // Roundings, and the last halving of the search of eq. (8).
            assert!((rest / thrust - 4.0).abs() < 1e-12, "{rest} {thrust}");
            assert!((two.rest(s).powi(2) / thrust - 2.0).abs() < 1e-12);
            assert!((four.throttle_for(4.0 * thrust) - one.throttle_for(thrust)).abs() < 1e-9);
            for (model, state) in [one, four].iter().zip(&mut states) {
                model.step(state, s, 0.03);
            }
            let [x, of_four] = states.map(|state| state.x);
            assert!((of_four / x - 2.0).abs() < 1e-12);
            let rates = (four.derivative(of_four, s), 2.0 * one.derivative(x, s));
            assert!(
                (rates.0 - rates.1).abs() < 1e-9 * rates.1.abs().max(1.0),
                "{rates:?}"
            );
        }
    }
}
