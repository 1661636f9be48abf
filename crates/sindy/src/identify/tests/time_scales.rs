//! Stiff systems whose rows are evenly spaced in the logarithm of time.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::quiet;
use crate::identify::{Identification, Identify, Settings};
use crate::{Dataset, Library};

/// Rows of `x' = fast (y - x), y' = slow x - y` from two starts, by its eigenvalues, with noise of these standard deviations.
fn relaxation(fast: f64, slow: f64, noise: f64) -> Dataset {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut data = Dataset::new(&["x", "y"], &[] as &[&str]).unwrap();
    let root = ((fast + 1.0).powi(2) - 4.0 * fast * (1.0 - slow)).sqrt();
    let rates = [0.5 * (root - fast - 1.0), -0.5 * (root + fast + 1.0)];
    // Of x = 1: x' = rate x = fast (y - x).
    let partners = rates.map(|rate| 1.0 + rate / fast);
    let times = (0..300).map(|k| match k {
        0 => 0.0,
        k => 1e-2 / fast * (800.0 * fast).powf(f64::from(k - 1) / 298.0),
    });
    let times: Vec<f64> = times.collect();
    for [x, y] in [[2.0, 0.5], [-0.5, 1.5]] {
        let second = (y - partners[0] * x) / (partners[1] - partners[0]);
        let parts = [x - second, second];
        let mut value = |t: f64, of: &dyn Fn(usize) -> f64| {
            let all = (0..2).map(|k| of(k) * parts[k] * (rates[k] * t).exp());
            let z: f64 = StandardNormal.sample(&mut rng);
            all.sum::<f64>() + noise * z
        };
        let x: Vec<f64> = times.iter().map(|t| value(*t, &|_| 1.0)).collect();
        let y: Vec<f64> = times.iter().map(|t| value(*t, &|k| partners[k])).collect();
        data.push("run", times.clone(), vec![x, y], None).unwrap();
    }
    data
}

fn found(data: &Dataset) -> Identification {
    let library = Library::polynomial(&["x", "y"], 2).unwrap();
    Identify::new(library).run(data, &mut quiet()).unwrap()
}

fn is_ambiguous(found: &Identification) -> bool {
    found
        .warnings
        .iter()
        .any(|w| w.contains("other terms are equally likely"))
}

#[test]
fn analytic_a_stiff_linear_system_is_found_with_its_rates() {
    for (noise, bound) in [(0.0, 1e-6), (1e-3, 1e-2)] {
        let found = found(&relaxation(1e4, 0.2, noise));
        let equations: Vec<Vec<(String, f64)>> = found
            .model
            .equations()
            .iter()
            .map(|equation| {
                equation
                    .iter()
                    .map(|t| (t.expression.to_string(), t.coefficient))
                    .collect()
            })
            .collect();
        let truth = [("x", -1e4), ("y", 1e4)];
        assert_eq!(equations[0].len(), 2, "{}", found.model);
        for ((name, value), (term, coefficient)) in equations[0].iter().zip(truth) {
            // Without noise the integrator's error; with it, some 100 rows hold the fast motion of size 1.
            assert!(
                name == term && (value / coefficient - 1.0).abs() < bound,
                "{}",
                found.model
            );
        }
        assert_eq!(found.choice.method, "output_error");
    }
}

#[test]
fn analytic_a_multiple_of_a_fast_equation_that_noise_hides_is_warned_of() {
    // On x = y the equation of y is (slow - 1) y. While x moves by 1, y moves by slow / fast = 5e-4, which 1 % of noise hides.
    let hidden = found(&relaxation(1e3, 0.5, 1e-2));
    assert!(
        is_ambiguous(&hidden),
        "{}\n{:?}",
        hidden.model,
        hidden.warnings
    );
    let clear = found(&relaxation(1e3, 0.5, 0.0));
    assert!(!is_ambiguous(&clear), "{:?}", clear.warnings);
    let terms: Vec<usize> = clear.model.equations().iter().map(Vec::len).collect();
    assert_eq!(terms, [2, 2], "{}", clear.model);
}

#[test]
fn analytic_an_equation_that_is_known_whole_leaves_the_others_to_be_found() {
    let library = Library::polynomial(&["x", "y"], 1).unwrap();
    for noise in [0.0, 1e-3] {
        let settings = Settings {
            known: vec!["x' = -1000*x + 1000*y".into()],
            ..Settings::default()
        };
        let identify = Identify::new(library.clone()).settings(settings).unwrap();
        let data = relaxation(1e3, 0.2, noise);
        let found = identify.run(&data, &mut quiet()).unwrap();
        let own = &found.model.equations()[1];
        // A multiple 2e-4 of the known equation is hidden by noise of 0.1 %, and y' = -0.8 y is then as likely.
        let hidden = noise > 0.0 && own.len() == 1;
        assert!(hidden || own.len() == 2, "{}", found.model);
        assert_eq!(is_ambiguous(&found), noise > 0.0, "{:?}", found.warnings);
        let slow: f64 = own.iter().map(|t| t.coefficient).sum();
        // 600 rows over eight decays.
        assert!((slow + 0.8).abs() < 0.01, "{}", found.model);
    }
    // The velocity of a position is known whole: q'' = -3 q' - 2 q, by its solution 2 exp(-t) - exp(-2 t).
    let time: Vec<f64> = (0..220)
        .map(|k| 1e-4 * 1e5_f64.powf(f64::from(k) / 219.0))
        .collect();
    let noise = |t: f64| 1e-4 * (1e4 * (1e3 * t).sin()).sin();
    let position = |t: &f64| 2.0 * (-t).exp() - (-2.0 * t).exp() + noise(*t);
    let mut data = Dataset::new(&["q"], &[] as &[&str]).unwrap();
    let column = time.iter().map(position).collect();
    data.push("run", time, vec![column], None).unwrap();
    let settings = Settings {
        second_order: vec!["q".into()],
        ..Settings::default()
    };
    let library = Library::polynomial(&["q", "q_dot"], 1).unwrap();
    let identify = Identify::new(library).settings(settings).unwrap();
    let found = identify.run(&data, &mut quiet()).unwrap();
    let own = &found.model.equations()[1];
    assert_eq!(own.len(), 2, "{}", found.model);
    for (term, truth) in own.iter().zip([-2.0, -3.0]) {
        // Errors of 1e-4 on 220 rows of a decay of size 1.
        assert!(
            (term.coefficient / truth - 1.0).abs() < 0.02,
            "{}",
            found.model
        );
    }
}
