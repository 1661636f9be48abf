use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::*;
use crate::library::Library;
use crate::model::{Interpolation, Time};
use crate::trajectory::output_error::silent;

const H: f64 = 0.05;

/// `dx = (b u - a x) dt + √q dw`, exactly from row to row under a held input, and noise of variance r on it.
struct Relaxation {
    a: f64,
    b: f64,
    q: f64,
    r: f64,
}

/// Columns of a run.
struct Run {
    time: Vec<f64>,
    x: Vec<f64>,
    u: Vec<f64>,
}

impl Relaxation {
    fn run(&self, rows: usize, seed: u64) -> Run {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let decay = (-self.a * H).exp();
        let driven = (self.q * (1.0 - decay * decay) / (2.0 * self.a)).sqrt();
        let mut x = 0.0;
        let mut run = Run {
            time: (0..rows).map(|k| H * k as f64).collect(),
            x: Vec::new(),
            u: (0..rows)
                .map(|k| f64::from(u8::from(k / 40 % 2 == 0)))
                .collect(),
        };
        for k in 0..rows {
            run.x.push(x + self.r.sqrt() * normal());
            x = decay * x + (1.0 - decay) * self.b / self.a * run.u[k] + driven * normal();
        }
        run
    }

    /// The fit of the candidates 1, x, u, x^2 from half the true coefficients.
    fn fit(&self, run: &Run, sources: Sources, holes: bool) -> OutputErrorFit {
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        let library = Library::parse(&["1", "x", "u", "x^2"]).unwrap();
        let time = Time::Continuous;
        let system = System::new(time, &names(&["x"]), &names(&["u"]), &[library]).unwrap();
        let weights: Vec<f64> = (0..run.time.len())
            .map(|k| f64::from(u8::from(!holes || k % 7 != 3)))
            .collect();
        let piece = Piece {
            time: &run.time,
            states: vec![&run.x],
            inputs: vec![&run.u],
            between: vec![Interpolation::ZeroOrderHold],
            weights: holes.then_some(&weights),
            seen: Vec::new(),
            smooth: vec![run.x.clone()],
        };
        let start = Start {
            coefficients: vec![0.0, -0.5 * self.a, 0.5 * self.b, 0.0],
            sigma: vec![(self.q * H + self.r).sqrt()],
            floor: vec![1e-6],
            term_rms: vec![1.0; 4],
            chosen_from: 4,
            signs: Vec::new(),
            colour: Vec::new(),
        };
        let settings = Settings::default();
        search(&system, &[piece], (&start, sources), &settings, &mut silent).unwrap()
    }
}

#[test]
fn analytic_coefficients_and_variances_of_a_disturbed_relaxation() {
    // Mostly disturbance, both alike, mostly noise of the measurement; a tenth of the rows' variance each way.
    for (q, r) in [(0.2, 1e-4), (0.05, 2.5e-3), (0.02, 1e-2)] {
        let truth = Relaxation {
            a: 1.0,
            b: 2.0,
            q,
            r,
        };
        let (mut held, mut process, mut noise) = (0, 0.0, 0.0);
        for seed in 0..20 {
            let fit = truth.fit(&truth.run(2000, seed), Sources::Both, seed % 2 == 0);
            assert_eq!(fit.outcome, Outcome::Converged, "{q} {seed}");
            let kept: Vec<bool> = fit.coefficients.iter().map(|c| *c != 0.0).collect();
            assert_eq!(
                kept,
                [false, true, true, false],
                "{q} {seed}: {:?}",
                fit.coefficients
            );
            for (j, true_value) in [(1, -truth.a), (2, truth.b)] {
                let z = (fit.coefficients[j] - true_value) / fit.std_errors[j];
                held += usize::from(z.abs() < 1.96);
            }
            let found = fit.disturbance.unwrap();
            process += found.process[0] / q / 20.0;
            noise += found.measurement[0] / r / 20.0;
        }
        // 40 intervals of 95 %: 33 or fewer hold in 1 of 1000 draws; two of a seed are correlated.
        assert!(held >= 33, "{q}: {held} of 40");
        // 20 estimates of 5 to 10 % each from 2000 rows, narrowed to 5 %.
        assert!((process - 1.0).abs() < 0.08, "{q}: {process}");
        // The smallest r is a hundredth of what a step adds, of which correlations of neighbours resolve 1/√2000 = 0.022: its
        // estimates, none below zero, scatter by twice the truth.
        let near = if r < 1e-3 {
            noise < 3.5
        } else {
            (noise - 1.0).abs() < 0.08
        };
        assert!(near, "{r}: {noise}");
    }
}

#[test]
fn analytic_states_without_noise_are_a_regression_on_the_exact_step() {
    // With r = 0 and one state the estimate is that of y[k+1] on y[k] and u[k]: decay and gain of the exact step.
    let truth = Relaxation {
        a: 1.0,
        b: 2.0,
        q: 0.05,
        r: 0.0,
    };
    let run = truth.run(4000, 7);
    let fit = truth.fit(&run, Sources::Process, false);
    let (mut xtx, mut xty) = (nalgebra::Matrix2::zeros(), nalgebra::Vector2::zeros());
    for k in 0..run.x.len() - 1 {
        let row = nalgebra::Vector2::new(run.x[k], run.u[k]);
        xtx += row * row.transpose();
        xty += row * run.x[k + 1];
    }
    let least = xtx.try_inverse().unwrap() * xty;
    let a = -least[0].ln() / H;
    let b = least[1] * a / (1.0 - least[0]);
    // The search ends where a step is a hundredth of a standard error.
    let near =
        |j: usize, value: f64| (fit.coefficients[j] - value).abs() < 0.02 * fit.std_errors[j];
    assert!(near(1, -a) && near(2, b), "{a} {b}: {:?}", fit.coefficients);
    assert_eq!(fit.sigma, [1e-6]);
}

/// An oscillator `x' = v, v' = -x - v/4` whose velocity alone is disturbed, in 200 steps from row to row.
fn pushed(rows: usize, seed: u64) -> [Vec<f64>; 2] {
    let mut rng = Pcg64::seed_from_u64(seed);
    let h = H / 200.0;
    let mut out = [Vec::new(), Vec::new()];
    let (mut x, mut v) = (1.0, 0.0);
    for _ in 0..rows {
        out[0].push(x);
        out[1].push(v);
        for _ in 0..200 {
            let z: f64 = StandardNormal.sample(&mut rng);
            let pushed = v - h * (x + 0.25 * v) + 0.3 * h.sqrt() * z;
            x += 0.5 * h * (v + pushed);
            v = pushed;
        }
    }
    out
}

#[test]
fn prop_a_state_without_noise_ends_the_search_as_soon_as_others() {
    let columns = pushed(2000, 3);
    let time: Vec<f64> = (0..2000).map(|k| H * f64::from(k)).collect();
    let library = Library::parse(&["x", "v", "x*v"]).unwrap();
    let names = ["x".to_owned(), "v".to_owned()];
    let libraries = [library.clone(), library];
    let system = System::new(Time::Continuous, &names, &[], &libraries).unwrap();
    let piece = Piece {
        time: &time,
        states: columns.iter().map(Vec::as_slice).collect(),
        inputs: vec![],
        between: vec![],
        weights: None,
        seen: Vec::new(),
        smooth: columns.to_vec(),
    };
    let start = Start {
        coefficients: vec![0.0, 0.9, 0.0, -0.9, -0.2, 0.0],
        sigma: vec![1e-3, 0.05],
        floor: vec![1e-6; 2],
        term_rms: vec![0.3; 6],
        chosen_from: 6,
        signs: Vec::new(),
        colour: Vec::new(),
    };
    let settings = Settings::default();
    let by = (&start, Sources::Both);
    let fit = search(&system, &[piece], by, &settings, &mut silent).unwrap();
    // Its variances fall from step to step without end.
    assert_eq!(fit.outcome, Outcome::Converged);
    assert!(fit.iterations <= 20, "{}", fit.iterations);
    let kept: Vec<bool> = fit.coefficients.iter().map(|c| *c != 0.0).collect();
    assert_eq!(kept, [false, true, false, true, true, false]);
}

#[test]
fn prop_values_beyond_the_finite_numbers_end_the_search() {
    let truth = Relaxation {
        a: 1.0,
        b: 2.0,
        q: 0.05,
        r: 1e-3,
    };
    let run = truth.run(200, 1);
    let huge = Run {
        x: run.x.iter().map(|x| 1e200 * x).collect(),
        ..run
    };
    let library = Library::parse(&["x", "x^2"]).unwrap();
    let system = System::new(Time::Continuous, &["x".to_owned()], &[], &[library]).unwrap();
    let piece = Piece {
        time: &huge.time,
        states: vec![&huge.x],
        inputs: vec![],
        between: vec![],
        weights: None,
        seen: Vec::new(),
        smooth: vec![huge.x.clone()],
    };
    let start = Start {
        coefficients: vec![-1.0, 1.0],
        sigma: vec![1e198],
        floor: vec![1e194],
        term_rms: vec![1e200, 1e300],
        chosen_from: 2,
        signs: Vec::new(),
        colour: Vec::new(),
    };
    let found = search(
        &system,
        &[piece],
        (&start, Sources::Both),
        &Settings::default(),
        &mut silent,
    );
    assert!(found.is_none());
}
