//! Cards: written and read back to the bit, checked, turned into flight models.

use proptest::prelude::*;
use touchdown_model::card::{
    Card, Form, Input, Kind, Provenance, Score, Status, Term, Validity, Vehicle,
};
use touchdown_model::flight::psi_definitions;
use touchdown_model::{CardError, published};

fn card(values: [f64; 7]) -> Card {
    let (constants, definitions) = psi_definitions([0.08, 0.20, 0.45]);
    let names = [
        ("tau", "1"),
        ("h", "1"),
        ("h", "psi1"),
        ("h", "psi2"),
        ("h", "psi3"),
        ("k", "1"),
        ("k", "psi3"),
    ];
    Card {
        schema: 1,
        name: "lag".into(),
        kind: Kind::GroundEffect,
        form: Form::Lag,
        status: Status::Fitted,
        equation: "y = G + k(z) v_p".into(),
        description: "a \"quoted\" text, with\nlines".into(),
        warnings: vec!["w".into()],
        diverged: false,
        measured_rotors: Some(2),
        vehicle: Vehicle {
            rotors: Some(4),
            arm_m: Some(0.226),
            name: "test".into(),
            mass_kg: Some(1.37),
            rotor_radius_m: None,
        },
        validity: Validity {
            inputs: [("z".to_string(), [0.1, 0.85])].into(),
            output: Some([-0.1, 0.6]),
            ..Validity::default()
        },
        constants,
        definitions,
        provenance: Provenance {
            source: "test".into(),
            inputs: vec![Input {
                name: "a.csv".into(),
                sha256: "00".into(),
            }],
            ..Provenance::default()
        },
        terms: names
            .iter()
            .zip(values)
            .map(|((of, expression), value)| Term {
                of: (*of).into(),
                expression: (*expression).into(),
                value,
                std_error: Some(value.abs() / 7.0),
                ci95: Some([value - value.abs() / 3.0, value + value.abs() / 3.0]),
                unit: "1".into(),
                mark: None,
                upper_bound: None,
            })
            .collect(),
        scores: vec![Score {
            trial: "approach".into(),
            seen: false,
            kind: "free_run".into(),
            mae: 0.1,
            rmse: 0.2,
            worst: 0.3,
            unit: "N".into(),
        }],
    }
}

proptest! {
    #[test]
    fn prop_written_and_read_back_to_the_bit(values in prop::array::uniform7(-1e300..1e300f64), tiny in -1e-300..1e-300f64) {
        let mut values = values;
        values[3] = tiny;
        let card = card(values);
        let text = card.to_toml().unwrap();
        let back = Card::parse(&text, "card.toml").unwrap();
        for (a, b) in card.terms.iter().zip(&back.terms) {
            prop_assert_eq!(a.value.to_bits(), b.value.to_bits());
        }
        prop_assert_eq!(card, back);
    }

    #[test]
    fn prop_any_text_is_a_card_or_an_error(text in ".{0,200}") {
        let _ = Card::parse(&text, "x.toml");
    }
}

#[test]
fn prop_file_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sub/lag.toml");
    let card = card([0.2; 7]);
    card.write(&path).unwrap();
    assert_eq!(Card::read(&path).unwrap(), card);
    let mut broken = card.clone();
    broken.terms[0].value = f64::NAN;
    assert!(broken.write(&path).is_err());
    assert_eq!(
        Card::read(&path).unwrap(),
        card,
        "the good card is still there"
    );
    assert_eq!(
        std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
        1,
        "no leftovers"
    );
}

#[test]
fn prop_errors_name_file_key_expected_and_found() {
    let text = card([0.2; 7]).to_toml().unwrap();
    let error = |text: &str| Card::parse(text, "my.toml").unwrap_err();
    let schema = error(&text.replace("schema = 1", "schema = 7"));
    assert!(matches!(schema, CardError::Schema { .. }));
    assert_eq!(
        schema.to_string(),
        "my.toml: key `schema`: expected 1, found 7"
    );
    let unknown = error(&text.replace("unit = \"N\"", "unit = \"N\"\ncolour = 3")).to_string();
    assert!(
        unknown.contains("my.toml") && unknown.contains("colour"),
        "{unknown}"
    );
    assert!(unknown.contains("line"), "{unknown}");
    let mass = error(&text.replace("mass_kg = 1.37", "mass_kg = -1.37")).to_string();
    assert!(
        mass.contains("vehicle.mass_kg") && mass.contains("-1.37"),
        "{mass}"
    );
    let unit = error(&text.replacen("unit = \"1\"", "unit = \"kN\"", 1)).to_string();
    assert!(
        unit.contains(
            "my.toml: key `terms[0].unit`: expected `s`, the unit of `1` in `tau`, found `kN`"
        ),
        "{unit}"
    );
    let expression = error(&text.replace("\"psi1\"", "\"psi1 +\"")).to_string();
    assert!(expression.contains("psi1 +"), "{expression}");
    assert!(matches!(
        Card::read(std::path::Path::new("/no/such.toml")),
        Err(CardError::Read { .. })
    ));
}

#[test]
fn prop_flight_model_carries_the_coefficients() {
    let card = card([0.162, -0.009, 0.049, 0.122, 0.037, -0.035, 0.107]);
    let flight = card.ground_effect().unwrap();
    let touchdown_flight::ground_effect::GroundEffectModel::Lag(lag) = flight.model else {
        panic!("a lag card becomes a lag model")
    };
    assert_eq!(
        (lag.tau_s, lag.map.h, lag.k),
        (0.162, [-0.009, 0.049, 0.122, 0.037], [-0.035, 0.107])
    );
    assert!(
        card.thrust_model()
            .unwrap_err()
            .to_string()
            .contains("thrust card")
    );
    let mut odd = card.clone();
    odd.terms[1].expression = "z^3".into();
    assert!(odd.ground_effect().unwrap_err().to_string().contains("z^3"));
}

#[test]
fn paper_cards_are_the_published_models() {
    let eq11 = Card::parse(published::EQ_11, "eq11").unwrap();
    let eq12 = Card::parse(published::EQ_12, "eq12").unwrap();
    assert_eq!(
        (eq11.status, eq12.status),
        (Status::Published, Status::Published)
    );
    assert!(
        eq12.warnings
            .iter()
            .any(|w| w.contains("Not fit for feedforward"))
    );
    // The same numbers as the flight crate's own published constructors.
    let thrust = touchdown_flight::thrust::ThrustModel::published();
    assert_eq!(eq11.thrust_model().unwrap(), thrust);
    let flight = eq12.ground_effect().unwrap();
    let polynomial = touchdown_flight::ground_effect::Polynomial::<f64>::published();
    assert_eq!(
        flight.model,
        touchdown_flight::ground_effect::GroundEffectModel::Polynomial(polynomial)
    );
}

#[test]
fn regress_terms_of_unknown_parts_are_refused() {
    let refused = |card: &Card| {
        let error = match card.kind {
            Kind::Thrust => card.thrust_model().unwrap_err(),
            Kind::GroundEffect => card.ground_effect().unwrap_err(),
        };
        error.to_string()
    };
    let mut thrust = Card::parse(published::EQ_11, "thrust").unwrap();
    thrust.form = Form::StaticSqrt;
    for (term, expression) in thrust.terms.iter_mut().zip(["1", "s", "s^2", "s^3", "1"]) {
        (term.of, term.expression) = ("x".into(), expression.into());
    }
    thrust.terms.truncate(5);
    thrust.terms[4].of = "dead_time".into();
    // The delay of a measurement is a part of every thrust card.
    thrust.thrust_model().unwrap();
    thrust.terms[4].of = "tau".into();
    let error = refused(&thrust);
    assert!(
        error.contains(
            "key `terms[4].of`: expected a part of form static_sqrt: x, T_m, found `tau`"
        ),
        "{error}"
    );
    let mut lag = card([0.1; 7]);
    lag.terms.push(Term {
        of: "K".into(),
        ..lag.terms[0].clone()
    });
    let error = refused(&lag);
    assert!(
        error.contains("key `terms[7].of`: expected a part of form lag: tau, h, k, found `K`"),
        "{error}"
    );
}
