//! Columns with rates of their own.

use crate::common::{fails, json, number, words, write};

/// A damped oscillator under a force, x' = v, v' = -4 x - 0.4 v + u, with an empty cell where `keep(column, row)` does not hold.
fn table(keep: impl Fn(usize, usize) -> bool) -> String {
    let mut out = "t,x,v,u\n".to_owned();
    let (mut x, mut v) = (1.0, 0.0);
    let h = 0.01;
    let force = |t: f64| (1.3 * t).sin();
    for row in 0..2000 {
        let t = h * f64::from(row);
        // Noise of a thousandth of the size, the same in every run.
        let noise = |k: f64| 1e-3 * (1e4 * (t + k).sin()).sin();
        let cells = [x + noise(0.3), v + noise(0.7), force(t)];
        out += &t.to_string();
        for (column, cell) in cells.iter().enumerate() {
            out.push(',');
            if keep(column, row as usize) {
                out += &cell.to_string();
            }
        }
        out.push('\n');
        // Runge and Kutta's method of second order.
        let slope = |x: f64, v: f64, t: f64| (v, -4.0 * x - 0.4 * v + force(t));
        let (a, b) = slope(x, v, t);
        let (c, d) = slope(x + 0.5 * h * a, v + 0.5 * h * b, t + 0.5 * h);
        (x, v) = (x + h * c, v + h * d);
    }
    out
}

#[test]
fn analytic_empty_cells_of_slower_columns_are_no_gaps() {
    let folder = tempfile::tempdir().unwrap();
    // In most rows only one column has a value, and in no row both states have one.
    let keep = |column: usize, row: usize| row % [2, 10, 4][column] == column % 2;
    let data = write(folder.path(), "sensors.csv", &table(keep));
    let fit = words("fit {} --states x,v --inputs u", &[&data]);
    let found = json(0, &fit);
    let equations = &found["equations"];
    for (state, terms) in [
        ("x", vec![("v", 1.0)]),
        ("v", vec![("x", -4.0), ("v", -0.4), ("u", 1.0)]),
    ] {
        let own = equations[state].as_array().unwrap();
        assert_eq!(own.len(), terms.len(), "{equations}");
        for term in own {
            let name = term["term"].as_str().unwrap();
            let truth = terms.iter().find(|(n, _)| *n == name).unwrap().1;
            // Noise of 1e-3 on 1000 and 200 samples, and an input that is interpolated over 0.04.
            let off = (number(&term["coefficient"]) - truth).abs();
            assert!(off < 2e-3, "{term}");
        }
    }
    let said = found["warnings"].to_string();
    for part in [
        "800 of 2000 rows hold no value",
        "of 1200 rows x in 1000, v in 200 hold a value",
    ] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn prop_rows_without_a_state_are_refused_where_every_row_needs_one() {
    let folder = tempfile::tempdir().unwrap();
    let keep = |column: usize, row: usize| row % [2, 10, 1][column] == column % 2;
    let data = write(folder.path(), "sensors.csv", &table(keep));
    let none = "rows in succession that hold all states (in a stream states have one rate, in memory they need not), found none among 2000";
    for (more, says) in [("--discrete", "at least 3"), ("--stream", none)] {
        let fit = format!("fit {{}} --states x,v --inputs u {more}");
        let error = fails(2, &words(&fit, &[&data]));
        assert!(error.contains(says), "{more}: {error}");
    }
    // A state that was never measured.
    let data = write(folder.path(), "none.csv", &table(|column, _| column != 1));
    let error = fails(2, &words("fit {} --states x,v --inputs u", &[&data]));
    assert!(error.contains("values in column `v`"), "{error}");
}

#[test]
fn analytic_a_table_with_empty_cells_judges_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let keep = |column: usize, row: usize| row % [2, 10, 4][column] == column % 2;
    let data = write(folder.path(), "sensors.csv", &table(keep));
    let (model, figure) = (folder.path().join("m.json"), folder.path().join("fit.svg"));
    let fit = "fit {} --states x,v --inputs u --test {} --model {} --figure {}";
    let found = json(0, &words(fit, &[&data, &data, &model, &figure]));
    assert!(model.exists() && figure.exists());
    let run = json(0, &words("simulate {} --data {}", &[&model, &data]));
    // Slopes of interpolated values say nothing.
    assert!(found["test"]["derivative"].is_null(), "{found}");
    for runs in [&found["test"]["free_run"], &run["runs"]] {
        let runs = runs.as_array().unwrap();
        assert_eq!(runs.len(), 1, "{runs:?}");
        for state in ["x", "v"] {
            // Of states whose standard deviation is 0.3 and more, with noise of 1e-3 in the start and in what is compared.
            let error = number(&runs[0]["rmse"][state]);
            assert!(error < 0.01, "{runs:?}");
        }
    }
}

#[test]
fn prop_a_state_of_few_values_and_past_states_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let few = table(|column, row| column != 1 || row % 900 == 0);
    let data = write(folder.path(), "few.csv", &few);
    let error = fails(2, &words("fit {} --states x,v --inputs u", &[&data]));
    assert!(
        error.contains("at least 10 values of `v`, found 3"),
        "{error}"
    );
    let keep = |column: usize, row: usize| row % [2, 10, 1][column] == column % 2;
    let data = write(folder.path(), "sensors.csv", &table(keep));
    let past = words("fit {} --states x,v --inputs u --past x@1", &[&data]);
    assert!(fails(2, &past).contains("at least 3 rows after each other"));
    let both = "fit {} --states x,v --stable --library poly(1) --past x@1";
    assert!(fails(2, &words(both, &[&data])).contains("--past"));
}
