//! Fits that keep invariants.

use rand::{RngExt, SeedableRng};

use crate::identify::prepare;
use crate::identify::regress;
use crate::identify::tests::{against_truth, quiet};
use crate::identify::{Method, Settings};
use crate::model::{Inputs, Simulation};
use crate::problems::{Problem, Trajectory};
use crate::statistics::gram::Gram;
use crate::{Dataset, Identification, Identify, Library, problems};

const PENDULUM: &str = "v^2/2 - 4*cos(x)";

/// A pendulum, with a damping and an invariant.
fn pendulum(damping: f64) -> Problem {
    let mut equation = vec![("sin(x)", -4.0)];
    if damping != 0.0 {
        equation.push(("v", -damping));
    }
    Problem {
        name: "pendulum",
        states: vec!["x", "v"],
        inputs: Vec::new(),
        terms: [
            "1",
            "x",
            "v",
            "x^2",
            "x*v",
            "v^2",
            "sin(x)",
            "v*sin(x)",
            "v^2*sin(x)",
            "v^3",
        ]
        .map(String::from)
        .to_vec(),
        truth: vec![vec![("v", 1.0)], equation],
        trajectories: vec![Trajectory {
            start: vec![2.0, 0.5],
            inputs: Vec::new(),
        }],
        step: 0.04,
        rows: 500,
    }
}

fn fit(problem: &Problem, percent: f64, seed: u64, settings: Settings) -> Identification {
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for record in problem.noisy(percent, seed).unwrap() {
        data.push("run", record.time, record.states, None).unwrap();
    }
    let library = problem.library().unwrap();
    let identify = Identify::new(library).settings(settings).unwrap();
    identify.run(&data, &mut quiet()).unwrap()
}

fn conserving(invariants: &[&str]) -> Settings {
    Settings {
        conserve: invariants.iter().map(ToString::to_string).collect(),
        ..Settings::default()
    }
}

fn contradictions(found: &Identification) -> usize {
    let about = |w: &&String| w.contains("contradict that");
    found.warnings.iter().filter(about).count()
}

#[test]
fn analytic_a_pendulum_keeps_its_energy_and_intervals_hold() {
    let problem = pendulum(0.0);
    let (mut held, mut all, mut drifts) = (0, 0, 0);
    for (percent, seed) in [(1.0, 1), (1.0, 2), (5.0, 1), (5.0, 2), (5.0, 3)] {
        let found = fit(&problem, percent, seed, conserving(&[PENDULUM]));
        let (error, exact) = against_truth(&problem, &found.model);
        // The frequency over 20 time units of noise: 5 % of it alters it by about 0.1 %.
        assert!(exact && error < 3e-3, "{error} {}", found.model);
        let of = |i: usize| found.model.equations()[i][0].coefficient;
        // The ratio that the invariant fixes, to rounding.
        assert!((of(1) / of(0) + 4.0).abs() < 1e-14, "{}", found.model);
        let errors = |i: usize| found.model.equations()[i][0].std_error.unwrap();
        assert!((errors(1) / errors(0) - 4.0).abs() < 1e-9);
        for (i, truth) in [(0, 1.0), (1, -4.0)] {
            let [low, high] = found.equations[i].intervals[0].unwrap();
            held += usize::from(low <= truth && truth <= high);
            all += 1;
            let chosen = found.equations[i].front.iter().filter(|p| p.chosen);
            assert_eq!(chosen.count(), 1);
        }
        assert_eq!(contradictions(&found), 0, "{:?}", found.warnings);
        assert_eq!(found.choice.method, "output_error");

        let energy = |found: &Identification| {
            let time: Vec<f64> = (0..400).map(|i| 0.25 * f64::from(i)).collect();
            let run =
                found
                    .model
                    .simulate(&[2.0, 0.5], &time, &Inputs::none(), &Simulation::adaptive());
            let states = run.unwrap().states;
            let at = |k: usize| states[1][k].powi(2) / 2.0 - 4.0 * states[0][k].cos();
            let moved = (0..time.len()).map(|k| (at(k) - at(0)).abs());
            moved.fold(0.0, f64::max)
        };
        // Over 100 time units the integrator's tolerance is left.
        assert!(energy(&found) < 1e-5, "{}", energy(&found));
        let free = fit(&problem, percent, seed, Settings::default());
        drifts += usize::from(energy(&free) > 1e-3);
    }
    // 95 % intervals of five independent fits: all but one hold in 98 % of draws.
    assert!(held >= all - 2, "{held} of {all}");
    assert_eq!(drifts, 5);
}

#[test]
fn analytic_invariants_that_are_false_are_warned_of_and_true_ones_are_not() {
    for method in [Method::Automatic, Method::Regression, Method::OutputError] {
        let with = |invariant: &str| Settings {
            method,
            ..conserving(&[invariant])
        };
        let true_one = fit(&pendulum(0.0), 1.0, 5, with(PENDULUM));
        assert_eq!(contradictions(&true_one), 0, "{:?}", true_one.warnings);
        // A damping of 0.01 takes a fifth of the energy away in 20 time units, one of 0.05 two thirds. Short free runs of
        // regressions hardly show the first.
        let damping = match method {
            Method::Regression => 0.05,
            _ => 0.01,
        };
        let damped = fit(&pendulum(damping), 1.0, 5, with(PENDULUM));
        assert_eq!(
            contradictions(&damped),
            1,
            "{method:?} {:?}",
            damped.warnings
        );
        let wrong = fit(&pendulum(0.0), 1.0, 5, with("v^2/2 - 3.6*cos(x)"));
        assert_eq!(contradictions(&wrong), 1, "{method:?} {:?}", wrong.warnings);
        // What was asked for is kept all the same.
        let of = |i: usize| wrong.model.equations()[i][0].coefficient;
        assert!((of(1) / of(0) + 3.6).abs() < 1e-14, "{}", wrong.model);
    }
}

#[test]
fn analytic_several_equations_share_their_coefficients() {
    let problem = problems::lotka_volterra();
    let both = ["x - log(x) + 4/3*y - 2/3*log(y)"];
    for method in [Method::Automatic, Method::Regression] {
        let settings = Settings {
            method,
            ..conserving(&both)
        };
        let found = fit(&problem, 5.0, 1, settings);
        let (error, exact) = against_truth(&problem, &found.model);
        // One number is estimated from 5000 rows.
        assert!(exact && error < 5e-3, "{error} {}", found.model);
        assert_eq!(contradictions(&found), 0, "{:?}", found.warnings);
    }
}

#[test]
fn prop_joint_statistics_are_the_weighted_sum_of_the_equations() {
    let problem = pendulum(0.0);
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for record in problem.noisy(5.0, 3).unwrap() {
        data.push("run", record.time, record.states, None).unwrap();
    }
    let library = Library::parse(&["x", "v", "sin(x)", "v*sin(x)", "v^2", "x*v"]).unwrap();
    let identify = Identify::new(library).settings(conserving(&["v^2/2 - 4*cos(x)"]));
    let checked = identify.unwrap().with_run(&data, |run| {
        let stretches = &run.stretches;
        let filters = prepare::filters(stretches, 2, true, 1.0)?;
        let slopes = prepare::by(filters.as_deref(), stretches, 2)?;
        let plain = regress::of_slopes(run.data, stretches, &run.libraries, &slopes, 5)?;
        let conserved = run.conserved.as_ref().unwrap();
        let joined = conserved.join(plain)?;
        let joint = Gram::total(&joined.grams[0]);
        let totals: Vec<Gram> = joined.separate.iter().map(|g| Gram::total(g)).collect();
        let fields = conserved.fields.len();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        // With weights w: joint residual = w_0 r_0 + w_1 r_1. The weights follow from two points and hold at all others.
        let mut rows = Vec::new();
        for _ in 0..6 {
            let a: Vec<f64> = (0..fields).map(|_| rng.random_range(-1.0..1.0)).collect();
            let xi = conserved.terms(&a);
            let own = |i: usize| {
                let part = nalgebra::DVector::from_column_slice(&xi[6 * i..6 * i + 6]);
                totals[i].residual_sum(&part)
            };
            rows.push((
                own(0),
                own(1),
                joint.residual_sum(&nalgebra::DVector::from_vec(a)),
            ));
        }
        let (a, b) = (rows[0], rows[1]);
        let determinant = a.0 * b.1 - a.1 * b.0;
        let weights = [
            (a.2 * b.1 - a.1 * b.2) / determinant,
            (a.0 * b.2 - a.2 * b.0) / determinant,
        ];
        for row in &rows {
            let sum = weights[0] * row.0 + weights[1] * row.1;
            assert!((row.2 / sum - 1.0).abs() < 1e-9, "{row:?} {weights:?}");
        }
        Ok(weights)
    });
    let weights = checked.unwrap();
    assert!(weights.iter().all(|w| *w > 0.0), "{weights:?}");
}
