//! Models as files.

use proptest::prelude::*;

use super::any_model;
use crate::model::{Model, Term, Time};

const TEXT: &str = r#"{
  "schema": 1,
  "time": {
    "discrete": {
      "period": 0.1
    }
  },
  "states": [
    "x"
  ],
  "inputs": [
    "u"
  ],
  "equations": {
    "x": [
      {
        "term": "x*u^2",
        "coefficient": -0.30000000000000004,
        "std_error": 0.001,
        "inclusion": 1.0
      },
      {
        "term": "1",
        "coefficient": 5e-324
      }
    ]
  }
}"#;

#[test]
fn regress_the_format() {
    let terms = vec![
        Term::parse("x*u^2", -0.1 - 0.2)
            .unwrap()
            .with_std_error(1e-3)
            .with_inclusion(1.0),
        Term::parse("1", 5e-324).unwrap(),
    ];
    let model = Model::new(Time::Discrete { period: 0.1 }, &["x"], &["u"], vec![terms]).unwrap();
    assert_eq!(model.to_json().unwrap(), TEXT);
    assert_eq!(Model::from_json(TEXT).unwrap(), model);
    assert_eq!(serde_json::from_str::<Model>(TEXT).unwrap(), model);
}

#[test]
fn what_is_not_a_model_is_refused() {
    let refused = |from: &str, to: &str, expected: &str| {
        assert!(TEXT.contains(from), "{from}");
        let error = Model::from_json(&TEXT.replacen(from, to, 1))
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(
        "\"schema\": 1",
        "\"schema\": 2, \"novelty\": 0",
        "`schema`: expected 1, found 2",
    );
    refused("\"schema\": 1,", "", "missing field `schema`");
    refused(
        "\"schema\": 1",
        "\"schema\": 1, \"color\": 0",
        "unknown field `color`",
    );
    refused(
        "\"schema\": 1",
        "\"schema\": 1, \"schema\": 1",
        "duplicate field `schema`",
    );
    refused(
        "\"period\": 0.1",
        "\"period\": 0.1, \"unit\": \"s\"",
        "unknown field `unit`",
    );
    refused(
        "\"inclusion\"",
        "\"probability\"",
        "unknown field `probability`",
    );
    refused(
        "\"inclusion\": 1.0",
        "\"inclusion\": 2",
        "expected a probability in [0, 1], found 2",
    );
    refused("\"discrete\"", "\"sampled\"", "unknown variant `sampled`");
    refused("\"period\": 0.1", "\"period\": -1", "`period`");
    refused(
        "\"x\": [",
        "\"x\": [], \"x\": [",
        "two equations for the state `x`",
    );
    refused("\"x\": [", "\"y\": [], \"x\": [", "found one for `y`");
    refused(
        "\"x\": [",
        "\"y\": [",
        "expected one for the state `x`, found none",
    );
    refused("x*u^2", "x*u^", "expression `x*u^`");
    refused("x*u^2", "x*q^2", "unknown name `q`");
    refused("5e-324", "1e999", "number out of range");
    refused("5e-324", "null", "invalid type: null");
    for text in ["", "[]", "{", "null", "\"x\""] {
        assert!(Model::from_json(text).is_err());
    }
    let deep = "[".repeat(100_000);
    assert!(Model::from_json(&deep).is_err());
}

proptest! {
    #[test]
    fn prop_models_read_back_bit_for_bit(model in any_model()) {
        let text = model.to_json().unwrap();
        let back = Model::from_json(&text).unwrap();
        prop_assert_eq!(&back, &model);
        // Equality takes 0 and -0 for the same: compare bits.
        let bits = |m: &Model| -> Vec<[Option<u64>; 3]> {
            let of = |t: &Term| {
                [Some(t.coefficient), t.std_error, t.inclusion].map(|v| v.map(f64::to_bits))
            };
            m.equations().iter().flatten().map(of).collect()
        };
        prop_assert_eq!(bits(&back), bits(&model));
        prop_assert_eq!(back.to_json().unwrap(), text);
    }

    #[test]
    fn prop_damaged_files_never_panic(position in 0..TEXT.len(), byte in 0_u8..128) {
        let mut text = TEXT.as_bytes().to_vec();
        text[position] = byte;
        let text = String::from_utf8(text).unwrap();
        if let Ok(model) = Model::from_json(&text) {
            prop_assert_eq!(Model::from_json(&model.to_json().unwrap()).unwrap(), model);
        }
    }
}
