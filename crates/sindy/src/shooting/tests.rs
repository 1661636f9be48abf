use super::*;
use rand::{RngExt, SeedableRng};

/// `G' = (h(z) - G)/tau`, `y = G + k v`: a lag with a velocity term, in closed form for steps of z.
fn model() -> OdeModel {
    OdeModel::new(
        &["g"],
        &["z", "v"],
        &["tau", "h0", "h1", "k"],
        &["(h0 + h1*z - g)/tau"],
        "g + k*v",
    )
    .unwrap()
}

struct Data {
    time: Vec<f64>,
    z: Vec<f64>,
    v: Vec<f64>,
    y: Vec<f64>,
    guess: Vec<f64>,
}

fn data(seed: u64, noise: f64) -> Data {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let phase: f64 = rng.random_range(0.0..6.0);
    let (dt, tau, h0, h1, k) = (0.01, 0.3, 0.2, -0.5, 0.15);
    let time: Vec<f64> = (0..1000).map(|i| dt * f64::from(i)).collect();
    let tones = [(0.12, 1.1), (0.07, 2.9), (0.03, 6.3)];
    let z: Vec<f64> = time
        .iter()
        .map(|t| tones.iter().map(|(a, w)| a * (w * t + phase).sin()).sum())
        .collect();
    let v: Vec<f64> = time
        .iter()
        .map(|t| {
            tones
                .iter()
                .map(|(a, w)| -a * w * (w * t + phase).cos())
                .sum()
        })
        .collect();
    // Steady response of the lag to each tone, in closed form.
    let y: Vec<f64> = time
        .iter()
        .zip(&v)
        .map(|(t, v)| {
            let g: f64 = tones
                .iter()
                .map(|(a, w)| {
                    let d = 1.0 + (w * tau).powi(2);
                    a * ((w * t + phase).sin() - w * tau * (w * t + phase).cos()) / d
                })
                .sum();
            h0 + h1 * g + k * v + noise * rng.random_range(-1.0..1.0)
        })
        .collect();
    let guess = y.iter().zip(&v).map(|(y, v)| y - 0.1 * v).collect();
    Data {
        time,
        z,
        v,
        y,
        guess,
    }
}

fn refine(noise: f64, start: [f64; 4]) -> Refined {
    let sets: Vec<Data> = (0..6).map(|s| data(s, noise)).collect();
    let records: Vec<Record<'_>> = sets
        .iter()
        .enumerate()
        .map(|(group, d)| Record {
            time: &d.time,
            inputs: vec![&d.z, &d.v],
            measured: &d.y,
            start: vec![&d.guess],
            group,
        })
        .collect();
    let parameters = [
        Parameter::free(start[0]).within(0.02, 3.0),
        Parameter::free(start[1]),
        Parameter::free(start[2]),
        Parameter::free(start[3]),
    ];
    Shooting::default()
        .refine(&model(), &records, &parameters)
        .unwrap()
}

const TRUTH: [f64; 4] = [0.3, 0.2, -0.5, 0.15];

#[test]
fn analytic_noise_free_parameters_are_recovered() {
    let refined = refine(0.0, [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(refined.outcome, Outcome::Converged);
    for (found, truth) in refined.parameters.iter().zip(TRUTH) {
        // Linear interpolation of the inputs between samples: (w dt)^2/12 of the fastest tone, 3e-4.
        assert!((found - truth).abs() < 1e-3, "{:?}", refined.parameters);
    }
}

#[test]
fn prop_standard_errors_cover_the_truth_under_noise() {
    let refined = refine(0.02, [0.6, 0.1, -0.2, 0.0]);
    assert_eq!(refined.outcome, Outcome::Converged);
    for ((found, truth), se) in refined
        .parameters
        .iter()
        .zip(TRUTH)
        .zip(&refined.std_errors)
    {
        // Six groups: five standard errors (Student's t with 5 degrees of freedom, p about 0.004).
        assert!(
            (found - truth).abs() < 5.0 * se + 1e-3,
            "{found} {truth} {se}"
        );
        assert!(*se < 0.1);
    }
}

#[test]
fn prop_free_run_repeats_the_closed_form() {
    let d = data(1, 0.0);
    let y = model()
        .free_run(&TRUTH, &[d.y[0] - 0.15 * d.v[0]], &d.time, &[&d.z, &d.v])
        .unwrap();
    for (a, b) in y.iter().zip(&d.y) {
        // As above: interpolated inputs.
        assert!((a - b).abs() < 2e-4);
    }
}

#[test]
fn prop_gaps_and_bad_shapes() {
    let mut d = data(2, 0.0);
    d.z[500] = f64::NAN;
    d.y[10] = f64::NAN;
    let record = |inputs| Record {
        time: &d.time,
        inputs,
        measured: &d.y,
        start: vec![&d.guess],
        group: 0,
    };
    let parameters = TRUTH.map(Parameter::free);
    let refined = Shooting::default()
        .refine(&model(), &[record(vec![&d.z, &d.v])], &parameters)
        .unwrap();
    assert!(refined.parameters.iter().all(|v| v.is_finite()));
    // One group carries no standard error.
    assert!(refined.std_errors.iter().all(|v| v.is_nan()));
    assert!(
        Shooting::default()
            .refine(&model(), &[record(vec![&d.z])], &parameters)
            .is_err()
    );
    assert!(
        Shooting {
            window: 0.0,
            ..Shooting::default()
        }
        .refine(&model(), &[record(vec![&d.z, &d.v])], &parameters)
        .is_err()
    );
}

#[test]
fn prop_a_parameter_held_by_its_bound_stays_there() {
    let d = data(3, 0.0);
    let steep = OdeModel::new(&[], &["z"], &["a"], &[], "a*z").unwrap();
    let twice: Vec<f64> = d.z.iter().map(|z| 2.0 * z).collect();
    let record = Record {
        time: &d.time,
        inputs: vec![&d.z],
        measured: &twice,
        start: Vec::new(),
        group: 0,
    };
    // The truth, 2, lies beyond the bound that the search starts at: nothing is left to solve for.
    let held = Parameter::free(1.0).within(0.0, 1.0);
    let refined = Shooting::default()
        .refine(&steep, std::slice::from_ref(&record), &[held])
        .unwrap();
    assert_eq!(refined.parameters, [1.0]);
    assert!(
        refined.std_errors[0].is_nan(),
        "a bound has no standard error"
    );
    let free = Shooting::default()
        .refine(&steep, &[record], &[Parameter::free(1.0)])
        .unwrap();
    // Linear and noise-free: one Gauss–Newton step, damped by 1e-6, then the next.
    assert!((free.parameters[0] - 2.0).abs() < 1e-9);
}
