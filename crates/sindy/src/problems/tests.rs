//! The catalogue against closed forms, and its promises.

use super::{Problem, all, damped_oscillator, ground_effect, lotka_volterra, propeller_thrust};

fn worst(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn every_problem_is_whole() {
    for problem in all() {
        let model = problem.model().unwrap();
        let library = problem.library().unwrap();
        let coefficients = problem.coefficients();
        // Every true term is among the candidates.
        let found = coefficients.iter().flatten().filter(|c| **c != 0.0).count();
        assert_eq!(found, model.terms(), "{}", problem.name);
        assert!(coefficients.iter().all(|row| row.len() == library.len()));
        let records = problem.clean().unwrap();
        assert_eq!(records.len(), problem.trajectories.len());
        for record in &records {
            assert_eq!(record.time.len(), problem.rows);
            let columns = record
                .states
                .iter()
                .chain(&record.inputs)
                .chain(&record.derivatives);
            for column in columns {
                assert_eq!(column.len(), problem.rows);
                assert!(column.iter().all(|v| v.abs() < 1000.0), "{}", problem.name);
            }
        }
    }
}

#[test]
fn analytic_damped_oscillator() {
    let record = damped_oscillator().clean().unwrap().remove(0);
    let expected = |t: f64| 2.0 * (-0.1 * t).exp() * (2.0 * t).cos();
    // Steps of 0.001 with an error of about (2 h)^5/120 each, over 25 000 steps.
    let rows = record.time.iter().zip(&record.states[0]);
    assert!(worst(rows.map(|(t, x)| x - expected(*t))) < 1e-11);
}

#[test]
fn analytic_lotka_volterra_conserves_its_integral() {
    let record = lotka_volterra().clean().unwrap().remove(0);
    let rows = record.states[0].iter().zip(&record.states[1]);
    let integral = |x: f64, y: f64| x - x.ln() + 4.0 / 3.0 * y - 2.0 / 3.0 * y.ln();
    let first = integral(1.8, 1.3);
    // As above.
    assert!(worst(rows.map(|(x, y)| integral(*x, *y) - first)) < 1e-11);
}

/// Reference values: the rest of equation (11) at throttles of 0.3 and 0.5 is a thrust of 8.088 N and
/// 13.768 N, printed to 3 decimals.
#[test]
fn analytic_propeller_thrust_rests_where_it_should() {
    let model = propeller_thrust().model().unwrap();
    for (throttle, thrust) in [(0.3, 8.088), (0.5, 13.768)] {
        let found = crate::model::Search::new(&[(1.0, 6.0)])
            .input(&[throttle])
            .run(&model)
            .unwrap();
        let x = found.equilibria[0].state[0];
        assert!((x * x - thrust).abs() < 5e-4, "{x}");
    }
}

/// Reference values: at throttle 0.4869 equation (12) rests at f(z = 0.1 m) = 0.9495 N, f(0.2 m) = 0.76 N.
#[test]
fn analytic_ground_effect_rests_where_it_should() {
    let model = ground_effect().model().unwrap();
    for (z, force, digits) in [(0.1, 0.9495, 1e-4), (0.2, 0.76, 5e-3)] {
        let search = crate::model::Search::new(&[(-5.0, 5.0)]).input(&[0.4869, z, 0.0, 0.0]);
        let found = search.run(&model).unwrap();
        assert!(
            (found.equilibria[0].state[0] - force).abs() < digits,
            "{found:?}"
        );
    }
}

/// The velocities are the derivatives of the heights: z = q - p.
#[test]
fn analytic_ground_effect_inputs_are_consistent() {
    for record in ground_effect().clean().unwrap() {
        let [_, z, v_p, v_q] = &record.inputs[..] else {
            panic!()
        };
        let h = 0.01;
        let differences =
            (1..z.len() - 1).map(|i| (z[i + 1] - z[i - 1]) / (2.0 * h) - (v_q[i] - v_p[i]));
        // h²/6 of a third derivative of at most 2 m/s³.
        assert!(worst(differences) < 4e-5);
        assert!(z.iter().all(|z| *z > 0.02), "above the platform");
    }
}

#[test]
fn analytic_noise_has_the_size_asked_for_and_repeats() {
    let problem = damped_oscillator();
    let (clean, noisy) = (problem.clean().unwrap(), problem.noisy(10.0, 7).unwrap());
    assert_eq!(noisy, problem.noisy(10.0, 7).unwrap());
    assert_ne!(noisy, problem.noisy(10.0, 8).unwrap());
    assert_eq!(problem.noisy(0.0, 7).unwrap(), clean);
    for (a, b) in clean[0].states.iter().zip(&noisy[0].states) {
        let n = a.len() as f64;
        let mean = a.iter().sum::<f64>() / n;
        let deviation = (a.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let noise = (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / n).sqrt();
        // 2500 draws give the size to 1/sqrt(5000) = 1.4 %; four times that.
        assert!(
            (noise / deviation / 0.1 - 1.0).abs() < 0.06,
            "{}",
            noise / deviation
        );
    }
    assert!(problem.noisy(-1.0, 0).is_err() && problem.noisy(f64::NAN, 0).is_err());
}

#[test]
fn a_changed_problem_that_does_not_fit_is_an_error() {
    let changed = |change: fn(&mut Problem)| {
        let mut problem = damped_oscillator();
        change(&mut problem);
        problem.clean()
    };
    assert!(changed(|p| p.trajectories[0].start = vec![1.0]).is_err());
    assert!(changed(|p| p.truth[0] = vec![("q", 1.0)]).is_err());
    let blown = changed(|p| p.truth[0] = vec![("x^3", 10.0)])
        .unwrap_err()
        .to_string();
    assert!(blown.contains("BlewUp"), "{blown}");
}
