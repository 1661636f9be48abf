//! Models whose trajectories stay bounded: `sindy fit --stable`.

use crate::common::{csv, fails, json, number, says, words, write};

/// A slowly decaying oscillation that is noisy.
fn oscillation() -> String {
    csv("t,x,v", 300, |row| {
        let t = 0.05 * row as f64;
        let noise = |k: f64| 0.02 * (1e4 * (t + k).sin()).sin();
        let size = (-0.1 * t).exp();
        vec![
            t,
            size * (2.0 * t).cos() + noise(0.3),
            -2.0 * size * (2.0 * t).sin() + noise(0.7),
        ]
    })
}

#[test]
fn analytic_a_stable_model_has_its_proof_as_text_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "decay.csv", &oscillation());
    let fit = words("fit {} --states x,v --library poly(1) --stable", &[&data]);
    let said = says(&fit);
    assert!(said.contains("stability"), "{said}");
    let found = json(0, &fit);
    let rate = number(&found["stability"]["largest_real_part"]);
    // Of 300 rows with noise of 1.4 %, the decay of 0.1 is known to some percent.
    assert!((rate + 0.1).abs() < 0.02, "{found}");
    // Without the option there is no such key.
    let free = json(0, &words("fit {} --states x,v --library poly(1)", &[&data]));
    assert!(free["stability"].is_null(), "{free}");
}

#[test]
fn prop_a_library_or_option_that_does_not_go_with_it_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "decay.csv", &oscillation());
    for (more, named) in [
        (
            "--library poly(3)",
            "in the states, or of inputs alone, such as poly(2), found `x^3`",
        ),
        ("--library poly(1) --constraint [x':v]=0", "--constraint"),
        ("--library poly(1) --discrete", "--discrete"),
        ("--library poly(1) --stream", "--stream"),
        ("--library poly(1) --second-order", "--second-order"),
    ] {
        let fit = format!("fit {{}} --states x,v --stable {more}");
        let error = fails(2, &words(&fit, &[&data]));
        assert!(error.contains(named), "{more}: {error}");
    }
}

#[test]
fn analytic_without_a_library_candidates_suit_a_bounded_model() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "decay.csv", &oscillation());
    let with_input = csv("t,x,v,wind speed", 300, |row| {
        let line = oscillation();
        let cells = line.lines().nth(row + 1).unwrap().split(',');
        let mut cells: Vec<f64> = cells.map(|c| c.parse().unwrap()).collect();
        cells.push((0.3 * row as f64).sin());
        cells
    });
    let driven = write(folder.path(), "driven.csv", &with_input);
    let plain = words("fit {} --states x,v --stable", &[&data]);
    let mut beside = words("fit {} --states x,v --stable --inputs", &[&driven]);
    beside.push("wind speed".into());
    for fit in [plain, beside] {
        let found = json(0, &fit);
        for (state, term, truth) in [("x", "v", 1.0), ("v", "x", -4.0)] {
            let own = found["equations"][state].as_array().unwrap();
            let of = own.iter().find(|t| t["term"] == term).unwrap();
            // Noise of 1.4 % on 300 rows over five turns.
            let off = number(&of["coefficient"]) / truth - 1.0;
            assert!(off.abs() < 0.02, "{found}");
        }
        assert!(!found["stability"].is_null(), "{found}");
    }
}
