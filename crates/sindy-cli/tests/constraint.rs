//! Relations between coefficients: `sindy fit --constraint`.

use crate::common::{csv, fails, files, json, run, text, words, write};
use crate::conserve::{coefficients, swing, with};

#[test]
fn analytic_a_relation_holds_to_rounding_from_arguments_and_settings() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let settings = "[identify]\nconstraints = [\"[x': v] = -[v': x]\"]\n";
    let settings = write(folder.path(), "s.toml", settings);
    let fit = words("fit {} --states x,v", &[&data]);
    let argument = with(&fit, &["--constraint", "-2*[v': x] - 2*[x': v] = 0"]);
    let file = with(&fit, &["--settings", settings.to_str().unwrap()]);
    for args in [&argument, &file] {
        let found = json(0, args);
        let (a, b) = coefficients(&found["equations"]);
        // Errors within 0.5 % of 500 rows over 30 radians.
        assert!((a - 3.0).abs() < 0.01, "{a}");
        assert!((a + b).abs() < 1e-14 * a, "{a} {b}");
        assert!(
            !found["warnings"].to_string().contains("contradict"),
            "{found}"
        );
    }
    let wrong = run(with(&fit, &["--constraint", "[x': v] = [v': x]"]));
    let warned = text(&wrong.stderr);
    assert!(
        warned.contains("the data contradict `[x': v] = [v': x]`"),
        "{warned}"
    );
}

#[test]
fn prop_relations_that_make_no_sense_are_refused_and_no_file_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let model = folder.path().join("model.json");
    let before = files(folder.path());
    let fit = words("fit {} --states x,v", &[&data]);
    for (more, says) in [
        (&["x' = v"][..], "a relation such as"),
        (&["[x': v] = 3"], "without a constant"),
        (&["[x': w] = 0"], "a candidate term of x'"),
        (&["[w': v] = 0"], "one of x', v'"),
        (&["[x': v] = 0", "--sign", "x': v > 0"], "--sign"),
        (&["[x': v] = 0", "--discrete"], "--discrete"),
        (&["[x': v] = 0", "--stream"], "--stream"),
    ] {
        let path = ["--model", model.to_str().unwrap()];
        let more = [&["--constraint"], more, &path].concat();
        let error = fails(2, &with(&fit, &more));
        assert!(
            error.contains(says) && error.contains("constrain"),
            "{more:?}: {error}"
        );
    }
    assert_eq!(files(folder.path()), before);
}
