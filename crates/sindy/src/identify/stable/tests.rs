use crate::identify::tests::{against_truth, quiet};
use crate::identify::{Identification, Settings};
use crate::model::{Model, StabilityCertificate};
use crate::problems::{Problem, Trajectory};
use crate::{Dataset, Identify, Library, problems};

/// x' = v, v' = -4 x - d v, over few turns.
fn oscillator(damping: f64, rows: usize) -> Problem {
    Problem {
        name: "oscillator",
        states: vec!["x", "v"],
        inputs: Vec::new(),
        terms: ["x", "v"].map(String::from).to_vec(),
        truth: vec![vec![("v", 1.0)], vec![("x", -4.0), ("v", -damping)]],
        trajectories: vec![Trajectory {
            start: vec![1.0, 0.0],
            inputs: Vec::new(),
        }],
        step: 0.05,
        rows,
    }
}

fn fit(problem: &Problem, percent: f64, seed: u64, stable: bool) -> Identification {
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for record in problem.noisy(percent, seed).unwrap() {
        data.push("run", record.time, record.states, None).unwrap();
    }
    let settings = Settings {
        stable,
        ..Settings::default()
    };
    let identify = Identify::new(problem.library().unwrap());
    let identify = identify.settings(settings).unwrap();
    identify.run(&data, &mut quiet()).unwrap()
}

fn growth(model: &Model) -> f64 {
    let (a, _) = model.jacobian().unwrap().at(&[0.0, 0.0], &[]).unwrap();
    crate::model::stability::form::largest_real_part(&a)
}

fn contradicts(found: &Identification) -> bool {
    found
        .warnings
        .iter()
        .any(|w| w.contains("contradict that the system is stable"))
}

#[test]
fn analytic_a_growing_fit_of_a_damped_oscillator_becomes_stable() {
    let mut grew = 0;
    for seed in 0..8 {
        // The damping of 0.002 is far below its standard error after two turns.
        let problem = oscillator(0.002, 120);
        let free = fit(&problem, 5.0, seed, false);
        if growth(&free.model) < 0.0 {
            continue;
        }
        grew += 1;
        let stable = fit(&problem, 5.0, seed, true);
        assert!(growth(&stable.model) < 0.0, "{}", stable.model);
        let stability = stable.stability.as_ref().unwrap();
        let is_linear = matches!(stability.certificate, StabilityCertificate::Linear { .. });
        assert!(is_linear, "{stability:?}");
        assert!(
            stability.lost > 0.0 && !contradicts(&stable),
            "{stability:?} {:?}",
            stable.warnings
        );
    }
    assert!(grew > 0);
}

#[test]
fn prop_a_stable_fit_is_left_to_the_last_digit() {
    let problem = oscillator(0.4, 300);
    let (free, stable) = (fit(&problem, 2.0, 1, false), fit(&problem, 2.0, 1, true));
    assert_eq!(free.model, stable.model);
    assert_eq!(stable.stability.unwrap().lost, 0.0);
    assert!(!stable.choice.reason.contains("moved"));
}

#[test]
fn analytic_an_unstable_truth_is_warned_of() {
    let found = fit(&oscillator(-0.2, 300), 1.0, 1, true);
    assert!(
        found
            .choice
            .reason
            .contains("moved to the nearest stable ones")
    );
    assert!(
        growth(&found.model) < 0.0 && contradicts(&found),
        "{:?}",
        found.warnings
    );
}

#[test]
fn analytic_noisy_lorenz_has_its_terms_and_is_trapped() {
    let mut problem = problems::lorenz();
    let library = Library::polynomial(&["x", "y", "z"], 2).unwrap();
    problem.terms = library.names().to_vec();
    let found = fit(&problem, 1.0, 3, true);
    let (error, exact) = against_truth(&problem, &found.model);
    // 1 % of noise on 5000 rows; free fits have errors of 1e-3.
    assert!(exact && error < 0.01, "{error} {}", found.model);
    let certificate = found.stability.unwrap().certificate;
    let StabilityCertificate::Trapping(region) = certificate else {
        panic!("{certificate:?}")
    };
    // The rate is that of y, which is 1.
    assert!((region.rate - 1.0).abs() < 0.1, "{region:?}");
    // Coefficients of x*z and x*y keep the energy.
    let of = |i: usize, name: &str| {
        let terms = found.model.equations()[i].iter();
        let mut own = terms.filter(|t| t.expression.to_string() == name);
        own.next().unwrap().coefficient
    };
    assert!((of(1, "x*z") + of(2, "x*y")).abs() < 1e-12);
}

#[test]
fn prop_other_libraries_and_settings_are_refused() {
    let mut problem = oscillator(0.4, 100);
    let run = |problem: &Problem| {
        let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
        for record in problem.noisy(1.0, 0).unwrap() {
            let columns = [record.states, record.inputs].concat();
            data.push("run", record.time, columns, None).unwrap();
        }
        let settings = Settings {
            stable: true,
            ..Settings::default()
        };
        let identify = Identify::new(problem.library().unwrap());
        let identify = identify.settings(settings).unwrap();
        identify.run(&data, &mut quiet()).unwrap_err().to_string()
    };
    problem.terms = ["x", "v", "x^3"].map(String::from).to_vec();
    let error = run(&problem);
    assert!(
        error.contains("degree 1 or 2") && error.contains("`x^3`"),
        "{error}"
    );
    problem.inputs = vec!["u"];
    problem.terms = ["x", "v", "u", "v*u"].map(String::from).to_vec();
    problem.trajectories[0].inputs = vec!["sin(t)".into()];
    let error = run(&problem);
    assert!(
        error.contains("such as poly(2, x, v), and terms of the inputs, found `v*u`"),
        "{error}"
    );
    problem = oscillator(0.1, 100);
    problem.terms = vec!["v".into(), "x^2".into()];
    let error = run(&problem);
    assert!(
        error.contains("the candidate `x` in the equation of x"),
        "{error}"
    );
    let both = Settings {
        stable: true,
        conserve: vec!["x".into()],
        ..Settings::default()
    };
    assert!(
        both.validate()
            .unwrap_err()
            .to_string()
            .contains("`conserve`")
    );
}

/// Three states that exchange energy, x' = g x + 2 y z, y' = -x z - y, z' = -x y - z. Whatever the centre, the energy about it
/// grows along x by g.
fn exchange(growth: f64) -> Problem {
    let library = Library::polynomial(&["x", "y", "z"], 2).unwrap();
    let own: Vec<(&str, f64)> = match growth {
        0.0 => vec![("y*z", 2.0)],
        growth => vec![("x", growth), ("y*z", 2.0)],
    };
    Problem {
        name: "exchange",
        states: vec!["x", "y", "z"],
        inputs: Vec::new(),
        terms: library.names().to_vec(),
        truth: vec![
            own,
            vec![("x*z", -1.0), ("y", -1.0)],
            vec![("x*y", -1.0), ("z", -1.0)],
        ],
        trajectories: vec![Trajectory {
            start: vec![0.5, 2.0, -1.5],
            inputs: Vec::new(),
        }],
        step: 0.01,
        rows: 600,
    }
}

#[test]
fn analytic_a_quadratic_fit_that_is_not_trapped_moves_and_gains_diagonal_terms() {
    for growth in [0.0, 0.5] {
        let found = fit(&exchange(growth), 0.5, 1, true);
        // Without growth a decay as slow as the margin is a proof, and costs next to nothing.
        assert_eq!(contradicts(&found), growth > 0.0, "{:?}", found.warnings);
        let StabilityCertificate::Trapping(region) = found.stability.unwrap().certificate else {
            panic!("{}", found.model)
        };
        let jacobian = found.model.jacobian().unwrap();
        let (a, _) = jacobian.at(&region.centre, &[]).unwrap();
        let symmetric = (&a + a.transpose()) * 0.5;
        let largest = symmetric.symmetric_eigenvalues().max();
        let is_proof = largest < 0.0 && (largest + region.rate).abs() < 1e-9;
        assert!(is_proof, "{largest} {region:?}");
        let mut own = found.model.equations()[0].iter();
        assert!(
            own.any(|t| t.expression.to_string() == "x"),
            "{}",
            found.model
        );
    }
}

#[test]
fn analytic_a_model_without_terms_decays_over_the_data_and_says_what_was_added() {
    // Noise alone: nothing moves.
    let mut data = Dataset::new(&["x", "v"], &[] as &[&str]).unwrap();
    let time: Vec<f64> = (0..200).map(|k| 0.05 * f64::from(k)).collect();
    let noise = |seed: f64| {
        time.iter()
            .map(|t| (1e4 * (t + seed).sin()).sin())
            .collect()
    };
    let columns = vec![noise(0.3), noise(0.7)];
    data.push("run", time.clone(), columns, None).unwrap();
    let settings = Settings {
        stable: true,
        method: crate::identify::Method::Regression,
        penalty: 1e3,
        ..Settings::default()
    };
    let identify = Identify::new(Library::polynomial(&["x", "v"], 1).unwrap());
    let identify = identify.settings(settings).unwrap();
    let found = identify.run(&data, &mut quiet()).unwrap();
    // A ten thousandth of one decay over the data, at least.
    assert!(growth(&found.model) < -0.9e-4 / 9.95, "{}", found.model);
    let said = |w: &String| w.contains("added are `x` in x', `v` in v'");
    assert!(found.warnings.iter().any(said), "{:?}", found.warnings);
}
