mod absent;
mod all_rows;
mod diffusion;
mod disturbed;
mod known;
mod noise;
mod rates;
mod rows;
mod signs;
mod time_scales;

use rand::{RngExt, SeedableRng};

use super::*;
use crate::model::Model;
use crate::problems::{self, Problem};
use crate::solve::outcome::Outcome;

pub(super) fn data_of(problem: &Problem, percent: f64, seed: u64) -> Dataset {
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for record in problem.noisy(percent, seed).unwrap() {
        let mut columns = record.states;
        columns.extend(record.inputs);
        data.push("run", record.time, columns, None).unwrap();
    }
    data
}

pub(super) fn quiet() -> impl FnMut(Progress) {
    |_| ()
}

/// Relative 2-norm of the coefficients' error, and whether the terms are the true ones.
pub(super) fn against_truth(problem: &Problem, model: &Model) -> (f64, bool) {
    let library = problem.library().unwrap();
    let (mut wrong, mut norm, mut exact) = (0.0, 0.0, true);
    for (row, equation) in problem.coefficients().iter().zip(model.equations()) {
        for (term, truth) in library.terms().iter().zip(row) {
            let found = equation
                .iter()
                .find(|t| t.expression == *term)
                .map_or(0.0, |t| t.coefficient);
            wrong += (found - truth).powi(2);
            norm += truth * truth;
            exact &= (found != 0.0) == (*truth != 0.0);
        }
    }
    ((wrong / norm).sqrt(), exact)
}

#[test]
fn analytic_known_systems_are_found_in_noise_without_being_told_anything() {
    // Bounds: twice the median of five seeds when written, all of them far below what regression on slopes
    // reaches with the true terms given.
    for (problem, percent, bound) in [
        (problems::lorenz(), 10.0, 4e-3),
        (problems::van_der_pol(), 10.0, 6e-3),
        (problems::lotka_volterra(), 5.0, 4e-3),
        (problems::ground_effect(), 5.0, 3e-2),
    ] {
        let data = data_of(&problem, percent, 3);
        let found = Identify::new(problem.library().unwrap())
            .run(&data, &mut quiet())
            .unwrap();
        let (error, exact) = against_truth(&problem, &found.model);
        assert!(
            exact && error < bound,
            "{}: {error} {}",
            problem.name,
            found.model
        );
        assert_eq!(found.choice.method, "output_error");
        assert_eq!(found.outcome, Outcome::Converged);
        for equation in &found.equations {
            assert!(equation.front.iter().filter(|p| p.chosen).count() == 1);
            // The residual is the noise that was added: 5000 samples or more scatter by 1 %.
            let left = equation.residual.unwrap() / equation.noise;
            assert!((left - 1.0).abs() < 0.15, "{left}");
        }
    }
}

#[test]
fn analytic_errors_of_a_coarse_integrator_are_not_taken_for_terms() {
    // Data without noise from Runge–Kutta at the sampling step, as people make it first: its error is as
    // significant as anything, and no one wants it in the model.
    let problem = problems::lorenz();
    let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
    let run = problem
        .model()
        .unwrap()
        .simulate(
            &[-8.0, 7.0, 27.0],
            &time,
            &crate::model::Inputs::none(),
            &crate::model::Simulation::fixed(0.01),
        )
        .unwrap();
    let mut data = Dataset::new(&problem.states, &[]).unwrap();
    data.push("run", time, run.states, None).unwrap();
    let found = Identify::new(problem.library().unwrap())
        .run(&data, &mut quiet())
        .unwrap();
    let (error, exact) = against_truth(&problem, &found.model);
    // The integrator's flow is that of a system whose terms differ by some 1e-5.
    assert!(exact && error < 1e-3, "{error} {}", found.model);
}

#[test]
fn analytic_standard_errors_are_those_of_repeated_draws() {
    let problem = problems::lotka_volterra();
    let library = problem.library().unwrap();
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in 0..6 {
        let found = Identify::new(library.clone())
            .run(&data_of(&problem, 5.0, seed), &mut quiet())
            .unwrap();
        for (equation, truth) in found.model.equations().iter().zip(&problem.truth) {
            for (term, (_, c)) in equation.iter().zip(truth) {
                let z = (term.coefficient - c) / term.std_error.unwrap();
                assert!(term.inclusion.unwrap() > 0.99);
                squares += z * z;
                count += 1.0;
            }
        }
    }
    // 24 squares of standard scores, strongly correlated within a draw: their mean scatters by about 0.5.
    let mean: f64 = squares / count;
    assert!((0.3..2.5).contains(&mean), "{mean}");
}

#[test]
fn analytic_uneven_times_gaps_and_weights_are_no_obstacle() {
    let problem = problems::van_der_pol();
    let record = problem.noisy(2.0, 5).unwrap().remove(0);
    let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
    // A third of the rows at random, a stretch missing, and spikes that carry no weight.
    let keep: Vec<usize> = (0..record.time.len())
        .filter(|_| rng.random_bool(0.35))
        .collect();
    let pick = |c: &Vec<f64>| -> Vec<f64> { keep.iter().map(|&i| c[i]).collect() };
    let mut columns: Vec<Vec<f64>> = record.states.iter().map(pick).collect();
    // Four rows in succession are not bridged.
    columns[0][700..704].fill(f64::NAN);
    let mut weights = vec![1.0; keep.len()];
    for k in (50..keep.len()).step_by(97) {
        columns[1][k] += 0.5;
        weights[k] = 0.0;
    }
    let mut data = Dataset::new(&problem.states, &[]).unwrap();
    data.push("run", pick(&record.time), columns, Some(weights))
        .unwrap();
    assert!(!data.report().uniform);
    let found = Identify::new(problem.library().unwrap())
        .run(&data, &mut quiet())
        .unwrap();
    let (error, exact) = against_truth(&problem, &found.model);
    // 1700 samples with 2 %: the 10 % bound above is generous.
    assert!(
        exact && error < 6e-3,
        "{error} {} {:?}",
        found.model,
        found.choice
    );
    assert!(found.warnings.iter().any(|w| w.contains("gaps")));
}

#[test]
fn analytic_coarse_short_records_are_integrated_finely_enough() {
    // x' = -x with one sample a time constant: one Runge-Kutta step between samples is off by 2 %.
    let time: Vec<f64> = (0..5).map(f64::from).collect();
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    for k in 0..40 {
        let start = 1.0 + 0.1 * f64::from(k);
        let x = time.iter().map(|t| start * (-t).exp()).collect();
        data.push("run", time.clone(), vec![x], None).unwrap();
    }
    let found = Identify::new(Library::parse(&["x"]).unwrap())
        .run(&data, &mut quiet())
        .unwrap();
    let rate = found.model.equations()[0][0].coefficient;
    assert!((rate + 1.0).abs() < 1e-4, "{rate}");
}

#[test]
fn prop_the_scale_of_weights_means_nothing() {
    let problem = problems::van_der_pol();
    let record = problem.noisy(5.0, 2).unwrap().remove(0);
    let models: Vec<String> = [1.0, 100.0]
        .iter()
        .map(|w| {
            let mut data = Dataset::new(&problem.states, &[]).unwrap();
            let weights = vec![*w; record.time.len()];
            data.push(
                "run",
                record.time.clone(),
                record.states.clone(),
                Some(weights),
            )
            .unwrap();
            let found = Identify::new(problem.library().unwrap())
                .run(&data, &mut quiet())
                .unwrap();
            assert_eq!(found.choice.method, "output_error");
            format!("{:.6}", found.model)
        })
        .collect();
    assert_eq!(models[0], models[1]);
}

#[test]
fn analytic_a_map_in_discrete_time() {
    // The Hénon map with noise on what is measured.
    let (mut x, mut y) = (0.1_f64, 0.1_f64);
    let mut rng = rand_pcg::Pcg64::seed_from_u64(2);
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    for _ in 0..600 {
        (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
        xs.push(x + 1e-3 * rng.random_range(-1.0..1.0));
        ys.push(y + 1e-3 * rng.random_range(-1.0..1.0));
    }
    let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
    data.push("map", (0..600).map(f64::from).collect(), vec![xs, ys], None)
        .unwrap();
    let settings = Settings {
        discrete: true,
        ..Settings::default()
    };
    let found = Identify::new(Library::polynomial(&["x", "y"], 3).unwrap())
        .settings(settings)
        .unwrap()
        .run(&data, &mut quiet())
        .unwrap();
    let text = format!("{:.2}", found.model);
    assert_eq!(found.model.terms(), 4, "{text}");
    let of = |i: usize, term: &str| {
        let mut terms = found.model.equations()[i].iter();
        terms
            .find(|t| t.expression.to_string() == term)
            .map_or(0.0, |t| t.coefficient)
    };
    for (i, term, truth) in [
        (0, "1", 1.0),
        (0, "y", 1.0),
        (0, "x^2", -1.4),
        (1, "x", 0.3),
    ] {
        // Noise of 6e-4 on 600 samples of unit size: standard errors below 1e-4, and a bias of the same order
        // from noise in the regressors; ten times either.
        assert!((of(i, term) - truth).abs() < 2e-3, "{text}");
    }
}

#[test]
fn prop_a_disturbed_system_is_said_to_be_disturbed() {
    // dx = (1 - x) dt + disturbance, measured almost exactly: no trajectory of any model follows it.
    let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
    let (mut x, mut force) = (0.0, 0.0);
    let mut xs = Vec::new();
    for _ in 0..4000 {
        force += -0.02 * force + 0.3 * rng.random_range(-1.0..1.0);
        x += 0.01 * (1.0 - x + force);
        xs.push(x + 1e-4 * rng.random_range(-1.0..1.0));
    }
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    data.push(
        "run",
        (0..4000).map(|i| 0.01 * f64::from(i)).collect(),
        vec![xs],
        None,
    )
    .unwrap();
    let found = Identify::new(Library::polynomial(&["x"], 3).unwrap())
        .run(&data, &mut quiet())
        .unwrap();
    let said = found.warnings.iter().any(|w| w.contains("disturbed"));
    assert!(said, "{:?} {:?}", found.choice, found.warnings);
}

#[test]
fn prop_bad_input_is_refused_or_warned_of() {
    let library = Library::polynomial(&["x", "y"], 3).unwrap();
    let run = |data: &Dataset| Identify::new(library.clone()).run(data, &mut quiet());
    let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
    assert!(run(&data).unwrap_err().to_string().contains("usable rows"));
    data.push(
        "short",
        vec![0.0, 1.0],
        vec![vec![1.0, 2.0], vec![1.0, 2.0]],
        None,
    )
    .unwrap();
    assert!(
        run(&data)
            .unwrap_err()
            .to_string()
            .contains("more than the library")
    );
    // A constant state, and two states that are the same.
    let time: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
    let x: Vec<f64> = time.iter().map(|t| (-t).exp()).collect();
    for y in [vec![2.0; 400], x.clone(), vec![0.0; 400]] {
        let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
        data.push("run", time.clone(), vec![x.clone(), y], None)
            .unwrap();
        let found = run(&data).unwrap();
        assert!(
            found
                .warnings
                .iter()
                .any(|w| w.contains("collinear") || w.contains("hardly")),
            "{:?}",
            found.warnings
        );
        let all: Vec<f64> = found
            .model
            .equations()
            .iter()
            .flatten()
            .map(|t| t.coefficient)
            .collect();
        assert!(all.iter().all(|c| c.is_finite()));
    }
    let two = Identify::per_equation(vec![library.clone(); 3]);
    assert!(two.run(&data, &mut quiet()).is_err());
    let unknown = Identify::new(Library::parse(&["throttle"]).unwrap());
    let mut long = Dataset::new(&["x", "y"], &[]).unwrap();
    long.push("run", time.clone(), vec![x.clone(), x.clone()], None)
        .unwrap();
    let error = unknown.run(&long, &mut quiet()).unwrap_err().to_string();
    assert!(error.contains("throttle"), "{error}");
    let bad = Settings {
        nus: vec![0.0],
        ..Settings::default()
    };
    assert!(
        Identify::new(library.clone())
            .settings(bad)
            .unwrap_err()
            .to_string()
            .contains("nus")
    );
}

#[test]
fn analytic_every_score_finds_the_terms_and_sr3_says_where_on_the_grid() {
    let problem = problems::van_der_pol();
    let data = data_of(&problem, 0.5, 4);
    for score in [Score::FreeRun, Score::LeftOut, Score::Bic, Score::Evidence] {
        let settings = Settings {
            score,
            method: Method::Regression,
            smoothing: Smoothing::Weak,
            ..Settings::default()
        };
        let found = Identify::new(problem.library().unwrap())
            .settings(settings)
            .unwrap()
            .run(&data, &mut quiet())
            .unwrap();
        let (error, _) = against_truth(&problem, &found.model);
        // Half a percent of noise; the weak form with the true terms is at 4e-4.
        assert!(error < 0.01, "{score:?}: {error} {}", found.model);
        let grid = found
            .candidates
            .iter()
            .filter(|c| c.name.contains("lambda"))
            .count();
        assert_eq!(grid > 0, score == Score::FreeRun);
        assert_eq!(found.choice.lambda.is_some(), found.choice.method == "sr3");
    }
}

#[test]
fn prop_every_smoothing_and_method_can_be_asked_for() {
    let problem = problems::lotka_volterra();
    let data = data_of(&problem, 1.0, 1);
    for smoothing in [
        Smoothing::Weak,
        Smoothing::SavitzkyGolay {
            window: 31,
            degree: 4,
        },
        Smoothing::Spline,
    ] {
        let settings = Settings {
            smoothing,
            method: Method::Regression,
            ..Settings::default()
        };
        let found = Identify::new(problem.library().unwrap())
            .settings(settings)
            .unwrap()
            .run(&data, &mut quiet())
            .unwrap();
        assert_ne!(found.choice.method, "output_error");
        let name = match smoothing {
            Smoothing::Weak => "weak",
            Smoothing::Spline => "spline",
            _ => "window 31",
        };
        assert!(found.choice.smoothing.contains(name), "{:?}", found.choice);
        // One percent of noise: regression has the right terms' coefficients to a few percent.
        let (error, _) = against_truth(&problem, &found.model);
        assert!(error < 0.1, "{name}: {error} {}", found.model);
    }
}

/// `x' = v, v' = -x - 0.2 v - x³ + u` by small steps, the input constant from sample to sample where `held`.
fn driven(held: bool, u: impl Fn(f64) -> f64) -> Dataset {
    let (dt, n, fine) = (0.1, 600, 200);
    let (mut x, mut v) = (0.5, 0.0);
    let mut columns: [Vec<f64>; 4] = Default::default();
    for k in 0..n {
        let t = f64::from(k) * dt;
        for (column, value) in columns.iter_mut().zip([t, x, v, u(t)]) {
            column.push(value);
        }
        for i in 0..fine {
            let h = dt / f64::from(fine);
            let mid = u(if held {
                t
            } else {
                t + (f64::from(i) + 0.5) * h
            });
            let slope = |x: f64, v: f64| -x - 0.2 * v - x * x * x + mid;
            let (xm, vm) = (x + 0.5 * h * v, v + 0.5 * h * slope(x, v));
            (x, v) = (x + h * vm, v + h * slope(xm, vm));
        }
    }
    let names = |n: &[&str]| n.iter().map(|n| (*n).into()).collect::<Vec<String>>();
    let mut data = Dataset::new(&names(&["x", "v"]), &names(&["u"])).unwrap();
    let [time, columns @ ..] = columns;
    data.push("run", time, columns.to_vec(), None).unwrap();
    data
}

#[test]
fn analytic_coarsely_sampled_inputs_are_followed_between_samples() {
    let random: Vec<f64> = {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        (0..600).map(|_| rng.random_range(-3.0..3.0)).collect()
    };
    // Smooth with 20 samples a period, switched, and another value at every sample: straight lines would leave
    // terms in these noise-free data that are not there.
    for data in [
        driven(false, |t| 1.5 * (std::f64::consts::PI * t).cos()),
        driven(true, |t| 2.0 * (2.2 * t + 0.1).sin().signum()),
        driven(true, |t| random[(t * 10.0).round() as usize]),
    ] {
        let library = Library::polynomial(&["x", "v", "u"], 3).unwrap();
        let found = Identify::new(library).run(&data, &mut quiet()).unwrap();
        let text = format!("{:.3}", found.model);
        assert_eq!(
            text.trim(),
            "x' = 1.00*v\nv' = -1.00*x - 0.200*v + 1.00*u - 1.00*x^3"
        );
    }
}

#[test]
fn analytic_a_record_that_rests_most_of_the_time_is_fitted_where_it_moves() {
    // x = exp(-2 t) cos 9 t, y its companion: over after 2 of 40 s; noise 1 % of the scatter of the whole.
    let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
    let time: Vec<f64> = (0..4000).map(|i| 0.01 * f64::from(i)).collect();
    let mut noisy = |wave: fn(f64) -> f64| -> Vec<f64> {
        let of = |t: &f64| (-2.0 * t).exp() * wave(9.0 * t);
        time.iter()
            .map(|t| of(t) + 1e-3 * rng.random_range(-1.0..1.0))
            .collect()
    };
    let columns = vec![noisy(f64::cos), noisy(|a| -a.sin())];
    let mut data = Dataset::new(&["x", "y"].map(String::from), &[]).unwrap();
    data.push("run", time, columns, None).unwrap();
    let library = Library::polynomial(&["x", "y"], 3).unwrap();
    let found = Identify::new(library).run(&data, &mut quiet()).unwrap();
    let truth = [
        vec![("x", -2.0), ("y", 9.0)],
        vec![("x", -9.0), ("y", -2.0)],
    ];
    for (equation, truth) in found.model.equations().iter().zip(truth) {
        let terms: Vec<String> = equation.iter().map(|t| t.expression.to_string()).collect();
        assert_eq!(terms, truth.iter().map(|t| t.0).collect::<Vec<_>>());
        for (term, (_, value)) in equation.iter().zip(truth) {
            // Some 100 samples of a signal 600 times the noise, over one time constant.
            assert!((term.coefficient - value).abs() < 0.1, "{}", found.model);
        }
    }
}
