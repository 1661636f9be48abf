//! Time in the equations: `sindy fit --inputs t`.

use crate::common::{csv, fails, json, number, words, write};

/// A number between -1 and 1 that looks random.
fn noise(i: usize) -> f64 {
    ((12.9898 * i as f64).sin() * 43758.5453).fract()
}

#[test]
fn analytic_time_stands_in_the_equations_where_it_is_an_input() {
    let folder = tempfile::tempdir().unwrap();
    // x' = -x + cos(2 t) from its solution without the part that dies away.
    let row = |i: usize| {
        let t = 0.02 * i as f64;
        let x = 0.2 * (2.0 * t).cos() + 0.4 * (2.0 * t).sin() + 0.8 * (-t).exp();
        vec![t, x + 0.003 * noise(i)]
    };
    let data = write(folder.path(), "driven.csv", &csv("t,x", 600, row));
    let model = folder.path().join("m.json");
    for time in ["", "--time t"] {
        let fit = format!("fit {{}} --states x --inputs t {time} --terms {{}} --model {{}}");
        let terms = write(
            folder.path(),
            "terms.txt",
            "1\nx\nx^2\nx^3\nt\ncos(2*t)\nsin(2*t)\n",
        );
        let object = json(0, &words(&fit, &[&data, &terms, &model]));
        let found = object["equations"]["x"].as_array().unwrap();
        let terms: Vec<&str> = found.iter().map(|t| t["term"].as_str().unwrap()).collect();
        assert_eq!(terms, ["x", "cos(2*t)"], "{object:#}");
        for (term, truth) in found.iter().zip([-1.0, 1.0]) {
            // 600 rows with errors of 0.5 % of x: ten times the expected error of 0.1 %.
            assert!(
                (number(&term["coefficient"]) - truth).abs() < 0.01,
                "{term}"
            );
        }
    }
    // Without the input, the error says what lacks.
    let terms = write(folder.path(), "terms.txt", "x\ncos(2*t)\n");
    for arguments in ["--library poly(1)+cos(2*t)", "--terms {}"] {
        let without = format!("fit {{}} --states x {arguments}");
        let error = fails(2, &words(&without, &[&data, &terms]));
        let expected = "expected one of: x (and t with --inputs t), found `t`";
        assert!(error.contains(expected), "{error}");
    }
    // Beside the data time is found again; alone it is a formula.
    let beside = json(0, &words("simulate {} --data {}", &[&model, &data]));
    assert_eq!(beside["runs"][0]["rows"], 600);
    let alone = "simulate {} --start x=1 --until 2 --step 0.1 --input t=t";
    let alone = json(0, &words(alone, &[&model]));
    assert_eq!(alone["runs"][0]["rows"], 21, "{alone:#}");
}
