use nalgebra::{DMatrix, DVector};

use super::centre::centre;
use super::form::{QuadraticForm, TermForm, largest_eigenvalue};
use super::{NoCertificate, StabilityCertificate};
use crate::model::{Inputs, Model, Simulation, Term, Time};
use crate::problems;

fn model(states: &[&str], inputs: &[&str], equations: &[&[(&str, f64)]]) -> Model {
    let terms = |row: &&[(&str, f64)]| {
        let term = |(text, c): &(&str, f64)| Term::parse(text, *c).unwrap();
        row.iter().map(term).collect()
    };
    let equations = equations.iter().map(terms).collect();
    Model::new(Time::Continuous, states, inputs, equations).unwrap()
}

fn form(model: &Model) -> QuadraticForm {
    let mut form = QuadraticForm::zeros(model.states().len());
    for (i, equation) in model.equations().iter().enumerate() {
        for term in equation {
            let own = TermForm::of(&term.expression, model.states()).unwrap();
            form.add(i, &own, term.coefficient);
        }
    }
    form
}

#[test]
fn analytic_lorenz_is_trapped_about_sigma_plus_rho() {
    let lorenz = problems::lorenz().model().unwrap();
    let form = form(&lorenz);
    assert!(form.keeps_energy());
    let known = DVector::from_column_slice(&[0.0, 0.0, 38.0]);
    let diagonal = DMatrix::from_diagonal(&DVector::from_column_slice(&[-10.0, -1.0, -8.0 / 3.0]));
    // Sums and differences of 10, 28 and 38 are exact.
    assert_eq!(form.symmetric(&known), diagonal);
    let (m, value) = centre(&form, &DVector::from_column_slice(&[1.0, 2.0, 20.0]));
    // The rate of y bounds the eigenvalue, and the last smoothing is 1e-5 of |A| = 31.
    assert!((value + 1.0).abs() < 3e-4, "{value} at {m}");
    // The eigenvalue rises by (z - 38)² / (4 · 9) near the centre: 3e-4 are 0.1.
    assert!((m[2] - 38.0).abs() < 0.1, "{m}");
}

#[test]
fn analytic_trajectories_from_far_away_enter_the_ball() {
    let lorenz = problems::lorenz().model().unwrap();
    let found = lorenz
        .stability_certificate(&[0.0, 0.0, 25.0], &[])
        .unwrap();
    let Ok(StabilityCertificate::Trapping(region)) = found else {
        panic!("{found:?}")
    };
    let distance = |x: &[f64]| {
        let each = x.iter().zip(&region.centre).map(|(x, m)| (x - m).powi(2));
        each.sum::<f64>().sqrt()
    };
    let time: Vec<f64> = (0..=2000).map(|k| 0.005 * f64::from(k)).collect();
    for start in [
        [900.0, 0.0, 0.0],
        [0.0, -900.0, 0.0],
        [300.0, 400.0, -800.0],
    ] {
        let run = lorenz
            .simulate(&start, &time, &Inputs::none(), &Simulation::adaptive())
            .unwrap();
        let mut inside = false;
        for k in 0..run.time.len() {
            let x: Vec<f64> = (0..3).map(|i| run.states[i][k]).collect();
            // A ball that was entered is not left. The integrator's error is below 1e-3.
            let within = distance(&x) <= region.radius + 1e-3;
            assert!(within || !inside, "{x:?} left the ball");
            inside |= within;
        }
        assert!(distance(&start) > region.radius && inside, "{start:?}");
    }
}

#[test]
fn prop_the_centre_is_a_minimum_of_the_eigenvalue() {
    let lorenz = problems::lorenz().model().unwrap();
    let form = form(&lorenz);
    let (m, value) = centre(&form, &DVector::zeros(3));
    for k in 0..3 {
        for by in [-0.5, 0.5] {
            let mut beside = m.clone();
            beside[k] += by;
            // The last smoothing is 1e-5 of |A| = 31.
            assert!(largest_eigenvalue(&form.symmetric(&beside)) > value - 3e-4);
        }
    }
}

#[test]
fn analytic_systems_that_are_not_bounded_have_no_region() {
    // The quadratic part keeps the energy, and z grows alone: no centre changes its rate of 1.
    let grows = model(
        &["x", "y", "z"],
        &[],
        &[
            &[("x", -1.0), ("x*y", 1.0)],
            &[("y", -1.0), ("x^2", -1.0)],
            &[("z", 1.0)],
        ],
    );
    let found = grows.stability_certificate(&[0.0; 3], &[]).unwrap();
    let Err(NoCertificate::NotDefinite(value)) = found else {
        panic!("{found:?}")
    };
    assert!((value - 1.0).abs() < 1e-12, "{value}");
    // x' = x² leaves all bounds in a finite time.
    let explodes = model(&["x"], &[], &[&[("x", -1.0), ("x^2", 1.0)]]);
    let found = explodes.stability_certificate(&[0.0], &[]).unwrap();
    // T = 3 Q of the one coefficient.
    assert_eq!(found, Err(NoCertificate::Energy(3.0)));
}

#[test]
fn analytic_linear_equations_are_judged_by_their_eigenvalues() {
    let oscillator = |damping: f64| {
        let v: &[(&str, f64)] = &[("x", -4.0), ("v", -damping), ("sin(u)", 1.0)];
        model(&["x", "v"], &["u"], &[&[("v", 1.0)], v])
    };
    // The eigenvalues are -d/2 ± i sqrt(4 - d²/4), to rounding.
    let found = oscillator(0.2)
        .stability_certificate(&[0.0; 2], &[])
        .unwrap();
    let Ok(StabilityCertificate::Linear { largest_real_part }) = found else {
        panic!("{found:?}")
    };
    assert!((largest_real_part + 0.1).abs() < 1e-12);
    let found = oscillator(-0.2)
        .stability_certificate(&[0.0; 2], &[])
        .unwrap();
    assert!(matches!(found, Err(NoCertificate::Growing(v)) if (v - 0.1).abs() < 1e-12));
}

#[test]
fn analytic_the_radius_grows_with_the_inputs() {
    // About 0: A_S = -1, so the radius is the largest |u| of the rows.
    let forced = model(
        &["x", "y"],
        &["u"],
        &[
            &[("x", -1.0), ("x*y", 1.0), ("u", 1.0)],
            &[("y", -1.0), ("x^2", -1.0)],
        ],
    );
    let rows = [vec![0.5], vec![-3.0]];
    let found = forced.stability_certificate(&[0.0; 2], &rows).unwrap();
    let Ok(StabilityCertificate::Trapping(region)) = found else {
        panic!("{found:?}")
    };
    // A centre that smoothing leaves 1e-5 off shifts the radius by as much.
    assert!(
        (region.rate * region.radius - 3.0).abs() < 0.01,
        "{region:?}"
    );
    // Without rows the input is zero, and the origin is at rest.
    let found = forced.stability_certificate(&[0.0; 2], &[]).unwrap();
    assert!(matches!(found, Ok(StabilityCertificate::Trapping(r)) if r.radius < 0.01));
}

#[test]
fn prop_other_terms_are_refused_by_name() {
    for term in ["x^3", "x*u", "sin(x)", "x/y"] {
        let other = model(
            &["x", "y"],
            &["u"],
            &[&[("x", -1.0), (term, 1.0)], &[("y", -1.0)]],
        );
        let found = other.stability_certificate(&[0.0; 2], &[]).unwrap();
        assert_eq!(found, Err(NoCertificate::Term(term.to_owned())));
    }
    let map = Model::new(
        Time::Discrete { period: 1.0 },
        &["x"],
        &[],
        vec![vec![Term::parse("x", 0.5).unwrap()]],
    )
    .unwrap();
    let found = map.stability_certificate(&[0.0], &[]).unwrap();
    assert_eq!(found, Err(NoCertificate::Discrete));
}
