use std::fs;
use std::path::Path;
use std::process::Command;

use touchdown_flight::Method;

use super::{Language, Precision, VERTICAL_NAME, export, export_vertical};
use crate::card::{Card, Form, Outside, Term, VelocityInput};
use crate::flight::psi_definitions;
use crate::published;

/// A card of every form that flies, with every behaviour above its heights and both inputs of
/// velocity among them.
pub(super) fn cards() -> Vec<Card> {
    let published = |text| Card::parse(text, "published").unwrap();
    let mut cards = vec![published(published::EQ_11), published(published::EQ_12)];
    // Eq. (8) of one rotor, for a vehicle of four.
    let mut of_one = published(published::EQ_11);
    of_one.name = "of one rotor".into();
    of_one.measured_rotors = Some(1);
    of_one.vehicle.rotors = Some(4);
    cards.push(of_one);
    cards.extend(forms().iter().map(|(form, terms)| of_form(*form, terms)));
    cards
}

type Terms = &'static [(&'static str, &'static str, f64)];

/// Coefficients near those that identification finds on the virtual rig.
fn forms() -> [(Form, Terms); 8] {
    const CUBIC: Terms = &[
        ("T", "1", 0.1),
        ("T", "s", 9.7),
        ("T", "s^2", 21.3),
        ("T", "s^3", -4.9),
    ];
    const MAP: [(&str, &str, f64); 4] = [
        ("h", "1", -0.0085),
        ("h", "psi1", 0.052),
        ("h", "psi2", 0.122),
        ("h", "psi3", 0.036),
    ];
    [
        (
            Form::FirstOrder,
            &[("c0", "1", 6.9), ("c1", "1", 0.31), ("T_m", "1", 0.057)],
        ),
        (
            Form::StaticSqrt,
            &[
                ("x", "1", 0.3),
                ("x", "s", 8.1),
                ("x", "s^2", -2.7),
                ("x", "s^3", 0.4),
                ("T_m", "1", 0.06),
            ],
        ),
        (Form::StaticThrust, CUBIC),
        (Form::Empirical, &[("mu", "1", 1.96)]),
        (Form::Static, &MAP),
        (
            Form::Derivative,
            &[
                ("f'", "1", 0.8),
                ("f'", "f", -7.1),
                ("f'", "s", 2.3),
                ("f'", "z", -3.7),
                ("f'", "v_p*v_q", 0.6),
            ],
        ),
        (
            Form::Ratio,
            &[
                ("y'", "1", -0.1),
                ("y'", "y", -6.7),
                ("y'", "psi2", 1.3),
                ("y'", "v_p", -0.2),
                ("y'", "v_p*psi3", 0.7),
            ],
        ),
        (
            Form::Lag,
            &[
                MAP[0],
                MAP[1],
                MAP[2],
                MAP[3],
                ("k", "1", -0.03),
                ("k", "psi3", 0.093),
                ("tau", "1", 0.156),
            ],
        ),
    ]
}

fn of_form(form: Form, terms: Terms) -> Card {
    let is_ground = Form::GROUND_EFFECT.contains(&form);
    let base = if is_ground {
        published::EQ_12
    } else {
        published::EQ_11
    };
    let mut card = Card::parse(base, "base").unwrap();
    card.name = format!("1st {} /* card */", form.name());
    card.form = form;
    let of = |&(of, expression, value): &(&str, &str, f64)| Term {
        of: of.into(),
        expression: expression.into(),
        value,
        std_error: None,
        ci95: None,
        unit: "1".into(),
        mark: None,
        upper_bound: None,
    };
    card.terms = terms.iter().map(of).collect();
    let (constants, definitions) = psi_definitions([0.08, 0.2, 0.45]);
    card.constants = constants;
    card.constants
        .extend([("r".to_owned(), 0.12), ("h_r".to_owned(), 0.05)]);
    card.definitions = definitions;
    if matches!(form, Form::Lag | Form::Empirical) {
        card.validity.outside = Outside::Fade;
        card.validity.velocity_input = Some(VelocityInput::NegativeRelative);
    }
    card
}

/// Writes an export, compiles it with warnings as errors, and runs its comparison.
fn run(card: &Card, precision: Precision, compiler: &str, level: &str) {
    let folder = tempfile::tempdir().unwrap();
    for file in export(card, Language::C, precision).unwrap() {
        fs::write(folder.path().join(&file.name), file.text).unwrap();
    }
    let label = format!("{} {precision:?}", card.name);
    make(folder.path(), &label, compiler, level);
}

fn make(folder: &Path, label: &str, compiler: &str, level: &str) {
    let make = Command::new("make")
        .args([
            "test",
            &format!("CC={compiler}"),
            &format!("CFLAGS={level}"),
        ])
        .current_dir(folder)
        .output()
        .unwrap();
    let text = [make.stdout, make.stderr].concat();
    let text = String::from_utf8_lossy(&text);
    assert!(make.status.success(), "{label} {compiler} {level}: {text}");
}

/// The controller of a method, beside the exports of its cards.
fn run_vertical(
    cards: &[&Card],
    method: Method,
    precision: Precision,
    compiler: &str,
    level: &str,
) {
    let folder = tempfile::tempdir().unwrap();
    let write = |files: Vec<super::ExportedFile>| {
        let name = files[0].name.trim_end_matches(".c").to_owned();
        fs::create_dir(folder.path().join(&name)).unwrap();
        for file in files {
            fs::write(folder.path().join(&name).join(&file.name), file.text).unwrap();
        }
    };
    for card in cards {
        write(export(card, Language::C, precision).unwrap());
    }
    write(export_vertical(cards[0], cards.get(1).copied(), method, precision).unwrap());
    let label = format!("{} {precision:?}", method.name());
    make(&folder.path().join(VERTICAL_NAME), &label, compiler, level);
}

fn is_there(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| Path::new(&folder).join(program).exists())
}

#[test]
fn xval_c_computes_the_bits_of_rust() {
    for compiler in ["gcc", "clang"].into_iter().filter(|c| is_there(c)) {
        for level in ["-O0", "-O1", "-O2", "-O3"] {
            for card in cards() {
                for precision in [Precision::Single, Precision::Double] {
                    run(&card, precision, compiler, level);
                }
            }
        }
    }
}

#[test]
fn prop_every_name_of_a_card_compiles() {
    let Some(compiler) = ["gcc", "clang"].into_iter().find(|c| is_there(c)) else {
        return;
    };
    // Words of the exported code, headers of C, and types.
    const NAMES: [&str; 17] = [
        "lag",
        "linear",
        "family",
        "finite",
        "library",
        "deck",
        "air",
        "map",
        "math",
        "string",
        "main",
        "near",
        "vertical",
        "touchdown",
        "uint32_t",
        "é-é",
        "R(1.5) REAL NAME_x",
    ];
    let cards = cards();
    let of = |form: Form| cards.iter().find(|card| card.form == form).unwrap();
    for name in NAMES {
        for form in [Form::Lag, Form::Ratio, Form::Library] {
            let mut card = of(form).clone();
            card.name = name.into();
            card.measured_rotors = Some(1);
            card.vehicle.rotors = Some(4);
            run(&card, Precision::Single, compiler, "-O0");
        }
        let mut thrust = of(Form::Library).clone();
        thrust.name = name.into();
        let air = of(Form::Lag);
        run_vertical(
            &[&thrust, air],
            Method::Dynamic,
            Precision::Single,
            compiler,
            "-O0",
        );
    }
}

#[test]
fn prop_what_the_precision_or_the_models_do_not_hold_is_refused() {
    let cards = cards();
    let of = |form: Form| cards.iter().find(|card| card.form == form).unwrap();
    let refused = |card: &Card, expected: &str| {
        for language in [Language::C, Language::Rust, Language::CSettings] {
            let error = export(card, language, Precision::Single)
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{error}");
        }
    };
    let mut card = of(Form::Lag).clone();
    card.terms[1].value = 1e39;
    assert!(export(&card, Language::C, Precision::Double).is_ok());
    refused(&card, "in the precision of the export");
    let mut card = of(Form::FirstOrder).clone();
    card.terms[2].value = 1e-50;
    refused(&card, "in the precision of the export");
    let mut card = of(Form::StaticThrust).clone();
    card.terms[2].value = 2500.0;
    refused(&card, "below 900 N");
}

#[test]
fn regress_settings_of_eq_2_do_not_lose_its_offset() {
    let cards = cards();
    let card = cards
        .iter()
        .find(|card| card.form == Form::Empirical)
        .unwrap();
    let text = |card: &Card| {
        export(card, Language::CSettings, Precision::Single).unwrap()[0]
            .text
            .clone()
    };
    assert!(!text(card).contains("_mu =") && text(card).contains("rotor offset"));
    let mut without = card.clone();
    without.constants.insert("h_r".into(), 0.0);
    assert!(text(&without).contains("_mu ="));
}

#[test]
fn xval_the_vertical_controller_in_c_computes_the_bits_of_rust() {
    let cards = cards();
    let of = |form: Form| cards.iter().find(|card| card.form == form).unwrap();
    let thrust = of(Form::Library);
    let exports: [(Method, &[&Card]); 3] = [
        (Method::Dynamic, &[thrust, of(Form::Lag)]),
        (
            Method::Empirical,
            &[of(Form::FirstOrder), of(Form::Empirical)],
        ),
        (Method::Ssc, &[of(Form::StaticThrust)]),
    ];
    for compiler in ["gcc", "clang"].into_iter().filter(|c| is_there(c)) {
        for level in ["-O0", "-O1", "-O2", "-O3"] {
            // Every export holds all laws and replays them; the others differ in their models.
            let exports = if level == "-O2" {
                &exports[..]
            } else {
                &exports[..1]
            };
            for (method, cards) in exports.iter().copied() {
                for precision in [Precision::Single, Precision::Double] {
                    run_vertical(cards, method, precision, compiler, level);
                }
            }
        }
    }
}

#[test]
fn regress_the_vertical_controller_refuses_cards_that_its_method_does_not_use() {
    let cards = cards();
    let of = |form: Form| cards.iter().find(|card| card.form == form).unwrap();
    let refused = |method, thrust, air, expected: &str| {
        let error = export_vertical(thrust, air, method, Precision::Single).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    };
    let (thrust, lag) = (of(Form::Library), of(Form::Lag));
    refused(Method::Dynamic, thrust, None, "expected its card as well");
    refused(Method::Feedback, thrust, Some(lag), "leave this card out");
    refused(Method::Empirical, thrust, Some(lag), "does not feed");
    refused(Method::DynamicObserver, thrust, Some(lag), "in space only");
    let mut light = thrust.clone();
    light.vehicle.mass_kg = None;
    refused(Method::Imbc, &light, None, "vehicle.mass_kg");
}

#[test]
fn regress_single_precision_has_no_double_and_no_recursion() {
    let cards = cards();
    let mut exports: Vec<_> = cards
        .iter()
        .map(|card| export(card, Language::C, Precision::Single).unwrap())
        .collect();
    exports.push(export_vertical(&cards[0], None, Method::Imbc, Precision::Single).unwrap());
    for files in exports {
        for file in files
            .iter()
            .filter(|file| !file.name.ends_with("_test.c") && file.name != "Makefile")
        {
            assert!(!file.text.contains("double"), "{}", file.name);
            assert!(!file.text.contains("REAL"), "{}", file.name);
            assert!(!file.text.contains('@'), "{}", file.name);
        }
    }
}

#[test]
fn prop_no_text_of_a_card_is_code() {
    let mut card = cards().remove(0);
    card.name = "a*/int x;/*\r\nint y;\u{2028}int z;".into();
    card.equation = "b*/int x;\nint y;".into();
    card.warnings = vec!["c*/int x;\rint y;".into()];
    for (language, comment) in [(Language::C, "/*"), (Language::Rust, "//")] {
        for file in export(&card, language, Precision::Single).unwrap() {
            let of_card = |line: &&str| line.contains("int x;") || line.contains("int y;");
            for line in file.text.lines().filter(of_card) {
                let line = line.trim_start();
                let commented = line.starts_with(comment) || line.starts_with('*');
                assert!(
                    commented && !line.contains("*/int"),
                    "{}: {line}",
                    file.name
                );
            }
            assert!(!file.text.contains(['\r', '\u{2028}']), "{}", file.name);
        }
    }
}
