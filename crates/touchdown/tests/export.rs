//! `touchdown export`: code for a flight computer, from a card.

use std::fs;

use crate::common::{fails, json, root};

fn card(name: &str) -> String {
    root()
        .join("crates/model/cards")
        .join(name)
        .display()
        .to_string()
}

#[test]
fn regress_cards_become_folders_of_c() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().display().to_string();
    let cards = [card("paper-eq11.toml"), card("paper-eq12.toml")];
    let results = json(
        0,
        [
            "export", &cards[0], &cards[1], "--to", "c", "--out", &folder,
        ],
    );
    let files = results["files"].as_array().unwrap();
    assert_eq!(files.len(), 8);
    for name in ["paper_eq11", "paper_eq12"] {
        for file in [format!("{name}.c"), format!("{name}.h"), "Makefile".into()] {
            let text = fs::read_to_string(out.path().join(name).join(file)).unwrap();
            assert!(!text.contains("REAL"));
        }
    }
}

#[test]
fn regress_a_card_becomes_a_constant_of_rust() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().display().to_string();
    let card = card("paper-eq11.toml");
    let scalar = ["--precision", "f64", "--out", &folder];
    json(
        0,
        [&["export", &card, "--to", "rust"][..], &scalar].concat(),
    );
    let text = fs::read_to_string(out.path().join("paper_eq11/paper_eq11.rs")).unwrap();
    assert!(text.contains("pub const PAPER_EQ11: touchdown_flight::thrust::ThrustModel<f64>"));
    assert!(text.contains("sin_x_s: -1.457"), "{text}");
}

#[test]
fn regress_a_card_becomes_a_constant_of_settings() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().display().to_string();
    let card = card("paper-eq12.toml");
    let arguments = ["export", &card, "--to", "c-settings", "--out", &folder];
    json(0, arguments);
    let text = fs::read_to_string(out.path().join("paper_eq12/paper_eq12.h")).unwrap();
    assert!(
        text.contains("static const td_ground_effect paper_eq12 = {"),
        "{text}"
    );
    assert!(text.contains("TD_GROUND_EFFECT_FORM_POLYNOMIAL"), "{text}");
    let message = fails(2, [&arguments[..], &["--precision", "f64"]].concat());
    assert!(message.contains("single precision"), "{message}");
}

#[test]
fn regress_a_method_becomes_a_vertical_controller_in_c() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().display().to_string();
    let cards = [card("paper-eq11.toml"), card("paper-eq12.toml")];
    let arguments = |to, cards: &[&String]| {
        let mut arguments = vec!["export".to_owned()];
        arguments.extend(cards.iter().map(|card| (*card).clone()));
        arguments.extend(["--to", to, "--method", "dynamic", "--out", &folder].map(str::to_owned));
        arguments
    };
    let results = json(0, arguments("c", &[&cards[0], &cards[1]]));
    assert_eq!(results["files"].as_array().unwrap().len(), 12);
    let text = fs::read_to_string(out.path().join("vertical/vertical.c")).unwrap();
    assert!(text.contains("paper_eq11_throttle_near(") && text.contains("paper_eq12_step("));
    let message = fails(2, arguments("rust", &[&cards[0], &cards[1]]));
    assert!(message.contains("expected --to c"), "{message}");
    let message = fails(2, arguments("c", &[&cards[1]]));
    assert!(message.contains("one thrust card"), "{message}");
}

#[test]
fn regress_two_cards_of_one_name_are_refused() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().display().to_string();
    let card = card("paper-eq11.toml");
    let message = fails(2, ["export", &card, &card, "--to", "c", "--out", &folder]);
    assert!(message.contains("both named `paper_eq11`"), "{message}");
    assert!(fs::read_dir(out.path()).unwrap().next().is_none());
}
