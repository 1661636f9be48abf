//! Relations between coefficients: fits that keep them, and texts that are refused.

use crate::identify::Settings;
use crate::identify::tests::{against_truth, quiet};
use crate::problems::{Problem, Trajectory};
use crate::{Dataset, Identification, Identify, Library, SindyError, problems};

fn under(constraints: &[&str]) -> Settings {
    Settings {
        constraints: constraints.iter().map(ToString::to_string).collect(),
        ..Settings::default()
    }
}

/// A fit of a problem's states, or of the first few of them.
fn fit(
    problem: &Problem,
    (percent, seed): (f64, u64),
    measured: usize,
    settings: Settings,
) -> Result<Identification, SindyError> {
    let names = &problem.states[..measured];
    let mut data = Dataset::new(names, &problem.inputs)?;
    for mut record in problem.noisy(percent, seed)? {
        record.states.truncate(measured);
        data.push("run", record.time, record.states, None)?;
    }
    let identify = Identify::new(problem.library()?).settings(settings)?;
    identify.run(&data, &mut quiet())
}

/// The coefficient of a term in an equation.
fn coefficient(found: &Identification, equation: usize, term: &str) -> f64 {
    let all = found.model.equations()[equation].iter();
    let own = all.filter(|t| t.expression.to_string() == term);
    own.map(|t| t.coefficient).sum()
}

fn contradicted(found: &Identification) -> bool {
    found.warnings.iter().any(|w| w.contains("contradict `"))
}

/// Two masses, each on a spring of its own, with a spring between them: x'' = -3 x + y, y'' = -2.5 y + x - 0.2 y^3, with friction.
fn masses() -> Problem {
    Problem {
        name: "masses",
        states: vec!["x", "y", "x_dot", "y_dot"],
        inputs: Vec::new(),
        terms: ["x", "y", "x_dot", "y_dot", "x^3", "y^3", "x^2*y", "x*y^2"]
            .map(String::from)
            .to_vec(),
        truth: vec![
            vec![("x_dot", 1.0)],
            vec![("y_dot", 1.0)],
            vec![("x", -3.0), ("y", 1.0), ("x_dot", -0.1)],
            vec![("x", 1.0), ("y", -2.5), ("y^3", -0.2), ("y_dot", -0.1)],
        ],
        trajectories: vec![Trajectory {
            start: vec![1.0, -0.5, 0.0, 1.0],
            inputs: Vec::new(),
        }],
        step: 0.05,
        rows: 600,
    }
}

#[test]
fn analytic_a_ratio_that_is_true_is_kept_to_rounding_and_narrows_intervals() {
    let problem = problems::lorenz();
    let (mut held, mut all) = (0, 0);
    for seed in 1..4 {
        let with = fit(&problem, (5.0, seed), 3, under(&["[x': x] = -[x': y]"])).unwrap();
        let free = fit(&problem, (5.0, seed), 3, Settings::default()).unwrap();
        let (error, exact) = against_truth(&problem, &with.model);
        // The noise of 5 % alters the free fit by about 1e-3.
        assert!(exact && error < 3e-3, "{error} {}", with.model);
        let [x, y] = ["x", "y"].map(|term| coefficient(&with, 0, term));
        assert!((x + y).abs() <= 1e-14 * y, "{x} {y}");
        let width = |found: &Identification| {
            let [low, high] = found.equations[0].intervals[0].unwrap();
            high - low
        };
        assert!(
            width(&with) < width(&free),
            "{} {}",
            width(&with),
            width(&free)
        );
        for (equation, terms) in with
            .model
            .equations()
            .iter()
            .zip(&problem.truth)
            .enumerate()
            .map(|(i, (_, t))| (i, t))
        {
            for (term, truth) in terms {
                let own = with.model.equations()[equation].iter();
                let at = own
                    .map(|t| t.expression.to_string())
                    .position(|t| t == *term);
                let [low, high] = with.equations[equation].intervals[at.unwrap()].unwrap();
                held += usize::from(low <= *truth && *truth <= high);
                all += 1;
            }
        }
        assert!(!contradicted(&with), "{:?}", with.warnings);
    }
    // Of 21 intervals of 95 %, 18 or more hold in 98 % of draws if they are independent.
    assert!(held >= all - 3, "{held} of {all}");
}

#[test]
fn analytic_a_stiffness_is_symmetric_where_positions_alone_are_measured() {
    let problem = masses();
    let settings = Settings {
        second_order: vec!["x".into(), "y".into()],
        ..under(&["[x'': y] = [y'': x]"])
    };
    let found = fit(&problem, (1.0, 1), 2, settings).unwrap();
    let (error, exact) = against_truth(&problem, &found.model);
    // 1 % noise on 600 rows of the positions of a damped motion.
    assert!(exact && error < 2e-2, "{error} {}", found.model);
    let (a, b) = (coefficient(&found, 2, "y"), coefficient(&found, 3, "x"));
    assert!((a - b).abs() <= 1e-14 * a, "{a} {b}");
    let lengths = found.equations.iter().zip(found.model.equations());
    assert!(
        lengths
            .clone()
            .all(|(e, terms)| e.intervals.len() == terms.len())
    );
    assert!(!contradicted(&found), "{:?}", found.warnings);
}

#[test]
fn analytic_relations_and_the_invariant_that_they_state_give_one_model() {
    let problem = Problem {
        name: "rotation",
        states: vec!["x", "v"],
        inputs: Vec::new(),
        terms: ["x", "v"].map(String::from).to_vec(),
        truth: vec![vec![("v", 2.0)], vec![("x", -3.0)]],
        trajectories: vec![Trajectory {
            start: vec![1.0, 0.0],
            inputs: Vec::new(),
        }],
        step: 0.05,
        rows: 300,
    };
    let invariant = Settings {
        conserve: vec!["3*x^2 + 2*v^2".into()],
        ..Settings::default()
    };
    let of = |settings| fit(&problem, (2.0, 1), 2, settings).unwrap();
    let kept = of(invariant);
    let same = of(under(&[
        "[v': x]/3 = -[x': v]/2",
        "[x': x] = 0",
        "[v': v] = 0",
    ]));
    for (i, term) in [(0, "v"), (1, "x")] {
        let (a, b) = (coefficient(&kept, i, term), coefficient(&same, i, term));
        // The same minimum, reached in steps that stop at 1e-9 of a coefficient.
        assert!((a - b).abs() < 1e-8 * a.abs(), "{a} {b}");
    }
}

#[test]
fn analytic_a_false_relation_is_warned_of_and_a_true_one_beside_known_parts_is_not() {
    let problem = problems::lorenz();
    let false_one = fit(&problem, (1.0, 1), 3, under(&["[x': x] = -2*[x': y]"])).unwrap();
    assert!(contradicted(&false_one), "{:?}", false_one.warnings);
    // One of two is true, and off by little.
    let both = under(&["[x': x] = -[x': y]", "[y': y] = 5*[y': x*z]"]);
    let found = fit(&problem, (1.0, 1), 3, both).unwrap();
    let warned: Vec<&String> = found
        .warnings
        .iter()
        .filter(|w| w.contains("contradict"))
        .collect();
    assert_eq!(warned.len(), 1, "{warned:?}");
    let places = ["[y': y] =", "[x': x] ="].map(|text| warned[0].find(text).unwrap());
    assert!(
        places[0] < places[1] && warned[0].contains("may be true"),
        "{warned:?}"
    );
    let settings = Settings {
        known: vec!["z' = x*y + ...".into()],
        ..under(&["28*[y': y] = [y': x*z]*28"])
    };
    let found = fit(&problem, (1.0, 1), 3, settings).unwrap();
    let (error, exact) = against_truth(&problem, &found.model);
    // 1 % of noise alters the free fit by about 1e-4.
    assert!(exact && error < 1e-3, "{error} {}", found.model);
    assert!(!contradicted(&found), "{:?}", found.warnings);
    let z = &found.model.equations()[2];
    let known = z.iter().position(|t| t.std_error.is_none()).unwrap();
    assert_eq!(z[known].expression.to_string(), "x*y");
    assert_eq!(found.equations[2].intervals.len(), z.len());
    assert!(found.equations[2].intervals[known].is_none());
}

#[test]
fn prop_texts_that_are_no_relations_are_refused_with_what_is_expected() {
    let problem = problems::van_der_pol();
    let of = |text: &str| {
        let settings = under(&[text]);
        fit(&problem, (1.0, 1), 2, settings)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    for (text, says) in [
        ("", "a relation such as [x': y] = -[y': x]"),
        ("[x': y]", "a relation such as"),
        ("[x': y] = [y': x] = 0", "a relation such as"),
        ("[x': y = [y': x]", "a relation such as"),
        ("x': y] = 0", "a relation such as"),
        ("[x': y] = * 2", "a relation such as"),
        ("1 = 2", "a relation such as"),
        (
            "[x': y] = x",
            "coefficients in brackets, such as [x': y], and numbers",
        ),
        ("[x': y] = 3", "without a constant"),
        ("[x': y]*[y': x] = 0", "each times a number"),
        ("1/[x': y] = 0", "each times a number"),
        ("[x': y] = [x': y]", "does not hold for all"),
        ("[x: y] = 0", "one of x', y' before `:`"),
        ("[y] = 0", "an equation, `:` and a term in each bracket"),
        ("[x': 2*y] = 0", "a term without a factor"),
        (
            "[x': sin(x)] = 0",
            "a candidate term of x', without those that are known: 1, x, y",
        ),
        ("[x': ] = 0", "an equation, `:` and a term in each bracket"),
    ] {
        let error = of(text);
        assert!(
            error.contains("`constraints`") && error.contains(says),
            "{text}: {error}"
        );
    }
    let known = Settings {
        known: vec!["x' = y".into()],
        ..under(&["[x': y] = -[y': x]"])
    };
    let error = fit(&problem, (1.0, 1), 2, known).unwrap_err().to_string();
    assert!(
        error.contains("an equation that is not known (that of x is)"),
        "{error}"
    );
    let signs = Settings {
        signs: vec!["x': y > 0".into()],
        ..under(&["[x': y] = -[y': x]"])
    };
    let discrete = Settings {
        discrete: true,
        ..under(&["[x': y] = -[y': x]"])
    };
    for (settings, says) in [
        (signs, "beside `signs`"),
        (discrete, "none in discrete time"),
    ] {
        let error = settings.validate().unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn analytic_relations_that_leave_no_model_are_refused() {
    let library = Library::parse(&["x"]).unwrap();
    let mut data = Dataset::new(&["x"], &[] as &[&str]).unwrap();
    let time: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
    let decay = time.iter().map(|t| (-t).exp()).collect();
    data.push("run", time, vec![decay], None).unwrap();
    let identify = Identify::new(library)
        .settings(under(&["[x': x] = 0"]))
        .unwrap();
    let error = identify.run(&data, &mut quiet()).unwrap_err().to_string();
    assert!(
        error.contains("expected a model that keeps all of them"),
        "{error}"
    );
}

#[test]
fn analytic_names_with_blanks_stand_in_quotes_as_they_are_printed() {
    let time: Vec<f64> = (0..400).map(|k| 0.02 * f64::from(k)).collect();
    let columns = [f64::sin, f64::cos].map(|f| time.iter().map(|t| f(2.0 * t)).collect());
    let names = ["q (rad)", "w (rad)"];
    let mut data = Dataset::new(&names, &[] as &[&str]).unwrap();
    data.push("run", time, columns.to_vec(), None).unwrap();
    let text = "[\"q (rad)\"': \"w (rad)\"] = -[w (rad)': \"q (rad)\"]";
    let identify = Identify::new(Library::polynomial(&names, 1).unwrap());
    let identify = identify.settings(under(&[text])).unwrap();
    let found = identify.run(&data, &mut quiet()).unwrap();
    let own = |i: usize| found.model.equations()[i][0].coefficient;
    assert!(
        (own(0) + own(1)).abs() < 1e-14 * own(0) && (own(0) - 2.0).abs() < 1e-4,
        "{}",
        found.model
    );
}
