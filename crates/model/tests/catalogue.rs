//! Each form of the catalogue against its kernel in flight.

use sindy_expr::Expr;
use touchdown_flight::ground_effect::{GroundEffect as _, GroundEffectInput};
use touchdown_flight::thrust::ThrustState;
use touchdown_model::card::{Card, Form, Kind, Provenance, Status, Term, Validity, Vehicle};
use touchdown_model::flight::psi_definitions;

/// A card with every term that the kernel of a form holds; no coefficient is round.
fn card(form: Form, kind: Kind) -> Card {
    let (mut constants, definitions) = psi_definitions([0.08, 0.20, 0.45]);
    constants.extend([("r".to_string(), 0.12), ("h_r".to_string(), 0.05)]);
    let parts = form.entry().unwrap().parts;
    let names = parts
        .iter()
        .flat_map(|p| p.terms.iter().map(|t| (p.name, *t)));
    let terms = names.enumerate().map(|(i, (of, expression))| Term {
        of: of.into(),
        expression: expression.into(),
        // Falling with the state, as every form that flies does.
        value: if matches!(expression, "y" | "f" | "x") {
            -2.3
        } else {
            0.137 + 0.0713 * i as f64
        },
        std_error: None,
        ci95: None,
        unit: String::new(),
        mark: None,
        upper_bound: None,
    });
    Card {
        schema: 1,
        name: "test".into(),
        kind,
        form,
        status: Status::Fitted,
        equation: String::new(),
        description: String::new(),
        warnings: Vec::new(),
        diverged: false,
        measured_rotors: None,
        vehicle: Vehicle::default(),
        validity: Validity {
            inputs: [("z".to_string(), [0.05, 2.0])].into(),
            output: Some([-0.9, 100.0]),
            ..Validity::default()
        },
        constants,
        definitions,
        provenance: Provenance::default(),
        terms: terms.collect(),
        scores: Vec::new(),
    }
}

/// The value of an expression of a card's equations.
fn value(card: &Card, text: &str, parameters: &[f64], of: &[(&str, f64)]) -> f64 {
    let mut expr = Expr::parse(text).unwrap();
    for (name, by) in &card.definitions {
        expr = expr.substitute(name, &Expr::parse(by).unwrap());
    }
    let constants = card.constants.iter().map(|(n, v)| (n.clone(), *v));
    let parameters = parameters
        .iter()
        .enumerate()
        .map(|(i, v)| (format!("p{i}"), *v));
    let given = of.iter().map(|(n, v)| ((*n).to_string(), *v));
    for (name, v) in constants.chain(parameters).chain(given) {
        expr = expr.substitute(&name, &Expr::constant(v));
    }
    expr.simplify().as_constant().unwrap()
}

#[test]
fn prop_ground_effect_forms_are_their_kernels() {
    let input = GroundEffectInput {
        thrust_n: 12.7,
        throttle: 0.47,
        height_m: 0.23,
        vehicle_velocity_mps: -0.11,
        deck_velocity_mps: 0.19,
        ..GroundEffectInput::default()
    };
    // The state of a model that rested at another height before.
    let before = GroundEffectInput {
        height_m: 0.61,
        ..input
    };
    for form in Form::GROUND_EFFECT {
        let card = card(form, Kind::GroundEffect);
        let equations = card.equations().unwrap();
        let kernel = card.ground_effect().unwrap().model;
        let at = kernel.rest(&before);
        let state = at.value().unwrap_or(f64::NAN);
        let name = form.entry().unwrap().state.unwrap_or("none");
        let of = [
            (name, state),
            ("T", input.thrust_n),
            ("s", input.throttle),
            ("z", input.height_m),
            ("v_q", input.vehicle_velocity_mps),
            ("v_p", input.deck_velocity_mps),
        ];
        let value = |text: &str| value(&card, text, &equations.parameters, &of);
        let force_n = kernel.lift(&at, &input).total_n(input.thrust_n);
        // Roundings of sums of a dozen terms of order one.
        let found = value(&equations.output);
        assert!(
            (found - force_n).abs() < 1e-12,
            "{form:?} {found} {force_n}"
        );
        let Some(rate) = &equations.rate else {
            assert_eq!(at.value(), None);
            continue;
        };
        // An exact step over h moves by h y' (1 + h y''/2 + ...): half of 2.3e-6 relatively.
        let h = 1e-6;
        let mut next = at;
        kernel.advance(&mut next, &input, h);
        let (found, slope) = (value(rate), (next.value().unwrap() - state) / h);
        assert!(
            (found - slope).abs() < 1e-5 * found.abs(),
            "{form:?} {found} {slope}"
        );
    }
}

#[test]
fn prop_thrust_forms_are_their_kernels() {
    let (x, s) = (3.1, 0.47);
    for form in [Form::FirstOrder, Form::Library, Form::StaticSqrt] {
        let card = card(form, Kind::Thrust);
        let equations = card.equations().unwrap();
        let of = [("x", x), ("s", s)];
        let value = |text: &str| value(&card, text, &equations.parameters, &of);
        let kernel = card.thrust_model().unwrap();
        let (found, rate) = (
            value(equations.rate.as_ref().unwrap()),
            kernel.derivative(x, s),
        );
        assert!(
            (found - rate).abs() < 1e-12 * (1.0 + rate.abs()),
            "{form:?} {found} {rate}"
        );
        assert!((value(&equations.output) - x * x).abs() < 1e-14);
    }
    // Without its lag the static root is a map.
    let mut map = card(Form::StaticSqrt, Kind::Thrust);
    map.terms.retain(|t| t.of != "T_m");
    let equations = map.equations().unwrap();
    assert!(equations.rate.is_none() && equations.state.is_none());
    let root = value(&map, &equations.output, &equations.parameters, &[("s", s)]).sqrt();
    let p = |i: usize| map.terms[i].value;
    assert!((root - (p(0) + s * (p(1) + s * (p(2) + s * p(3))))).abs() < 1e-14);
}

#[test]
fn prop_every_thrust_form_flies() {
    let term = |of: &str, expression: &str, value: f64| Term {
        of: of.into(),
        expression: expression.into(),
        value,
        std_error: None,
        ci95: None,
        unit: "1".into(),
        mark: None,
        upper_bound: None,
    };
    let s = 0.47;
    let mut motors = card(Form::StaticSqrt, Kind::Thrust);
    motors.form = Form::LaggedMotors;
    motors.constants.insert("motors".into(), 4.0);
    motors.validity.inputs.insert("u".into(), [3.0, 4.0]);
    motors.terms = vec![
        term("T_m", "1", 0.06),
        term("T", "1", 0.01),
        term("T", "u", 0.2),
        term("T", "u^2", 0.9),
        term("T", "u*battery_v", 0.1),
    ];
    let kernel = motors.thrust_model().unwrap();
    // Four motors at the middle of the battery's voltages.
    let thrust_n = 4.0 * (0.01 + 0.2 * s + 0.9 * s * s + 0.1 * 3.5 * s);
    assert!((kernel.rest(s).powi(2) - thrust_n).abs() < 1e-14);
    // A step of throttle: u follows with the lag, thrust is the polynomial of u.
    let mut state = ThrustState { x: kernel.rest(s) };
    kernel.step(&mut state, 0.8, 0.06);
    let u = 0.8 + (s - 0.8) * (-1.0_f64).exp();
    // The search for u ends within its own tolerance of 1e-9.
    assert!((state.x - kernel.rest(u)).abs() < 1e-7);
    // Its rate, by a difference over a microsecond.
    let h = 1e-6;
    let mut next = state;
    kernel.step(&mut next, 0.3, h);
    let rate = kernel.derivative(state.x, 0.3);
    assert!(((next.x - state.x) / h - rate).abs() < 1e-2 * rate.abs());
    let mut still = motors.clone();
    still.form = Form::StaticThrust;
    still.terms = vec![
        term("T", "1", 0.5),
        term("T", "s", 3.0),
        term("T", "s*u", 1.0),
    ];
    let kernel = still.thrust_model().unwrap();
    assert!((kernel.rest(s).powi(2) - (0.5 + 6.5 * s)).abs() < 1e-13);
    // What left its data in free run does not fly.
    still.diverged = true;
    let error = still.thrust_model().unwrap_err().to_string();
    assert!(error.contains("leaves the data"), "{error}");
}

#[test]
fn prop_equation_numbers_and_what_has_none() {
    let number = |form: Form| form.entry().and_then(|entry| entry.equation);
    assert_eq!(number(Form::Empirical), Some("(2)"));
    assert_eq!(number(Form::FirstOrder), Some("(7)"));
    assert_eq!(number(Form::Library), Some("(8)"));
    assert_eq!(number(Form::Derivative), Some("(9)"));
    assert_eq!((number(Form::Lag), number(Form::RotorLag)), (None, None));
    let mut card = card(Form::Lag, Kind::GroundEffect);
    card.terms.retain(|t| t.of != "tau");
    let error = card.equations().unwrap_err().to_string();
    assert!(error.contains("one term of `tau`, found 0"), "{error}");
}

#[test]
fn prop_names_are_those_of_cards() {
    let forms = [
        Form::StaticSqrt,
        Form::StaticThrust,
        Form::LaggedMotors,
        Form::RotorLag,
        Form::FirstOrder,
        Form::Library,
    ];
    for form in forms.into_iter().chain(Form::GROUND_EFFECT) {
        let in_card = toml::Value::try_from(form).unwrap();
        assert_eq!(in_card.as_str(), Some(form.name()));
    }
    for form in Form::GROUND_EFFECT {
        assert_eq!(Form::ground_effect_named(form.name()), Some(form));
    }
    assert_eq!(Form::ground_effect_named("library"), None);
}
