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

fn records(sets: &[Data]) -> Vec<Record<'_>> {
    sets.iter()
        .enumerate()
        .map(|(group, d)| Record {
            time: &d.time,
            inputs: vec![&d.z, &d.v],
            measured: &d.y,
            start: vec![&d.guess],
            group,
        })
        .collect()
}

fn refine(noise: f64, start: [f64; 4]) -> Refined {
    let sets: Vec<Data> = (0..6).map(|s| data(s, noise)).collect();
    let parameters = [
        Parameter::free(start[0]).within(0.02, 3.0),
        Parameter::free(start[1]),
        Parameter::free(start[2]),
        Parameter::free(start[3]),
    ];
    Shooting::default()
        .refine(&model(), &records(&sets), &parameters)
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
fn prop_a_search_from_beside_the_minimum_ends_at_it() {
    // Window starts are held: the parameters alone decide where the minimum is.
    let held = Shooting {
        start_sd: 0.0,
        ..Shooting::default()
    };
    let search = |sets: &[Data], start: &[f64]| {
        let free: Vec<Parameter> = start.iter().map(|v| Parameter::free(*v)).collect();
        let refined = held.refine(&model(), &records(sets), &free).unwrap();
        assert_eq!(refined.outcome, Outcome::Converged);
        refined.parameters
    };
    for seed in 0..8 {
        let sets: Vec<Data> = (6 * seed..6 * seed + 6).map(|s| data(s, 0.02)).collect();
        let minimum = (0..4).fold(vec![0.6, 0.1, -0.2, 0.0], |p, _| search(&sets, &p));
        let distance = |p: &[f64]| {
            p.iter()
                .zip(&minimum)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        for off in [1e-8, -1e-8] {
            let beside: Vec<f64> = minimum.iter().map(|v| v * (1.0 + off)).collect();
            let again = search(&sets, &beside);
            // The cost is the same to its last bits all the way. One step of Gauss-Newton leaves a tenth of the way at most: its
            // rate is the share of the noise in the outputs.
            assert!(
                distance(&again) < 0.2 * distance(&beside),
                "seed {seed}: {again:?} {minimum:?}"
            );
        }
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

#[test]
fn analytic_a_hole_in_the_data_is_crossed_in_steps_that_the_model_can_take() {
    // A lag of 0.3 s over a hole of 4 s: one Runge–Kutta step over it multiplies by about a thousand.
    let d = data(4, 0.0);
    let keep: Vec<usize> = (0..d.time.len())
        .filter(|i| !(30..430).contains(i))
        .collect();
    let pick = |c: &[f64]| keep.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let (time, still) = (pick(&d.time), vec![0.1; keep.len()]);
    let zero = vec![0.0; keep.len()];
    let run = |m: &OdeModel| m.free_run(&TRUTH, &[0.9], &time, &[&still, &zero]).unwrap();
    let careless = run(&model());
    let careful = run(&model().with_max_step(0.1).unwrap());
    // Closed form: the state decays to h0 + h1 z.
    let rest = 0.2 - 0.5 * 0.1;
    for (t, g) in time.iter().zip(&careful) {
        let exact = rest + (0.9 - rest) * (-(t - time[0]) / 0.3_f64).exp();
        // Order four at a third of the lag: (1/3)^5/120 of the step to go.
        assert!((g - exact).abs() < 1e-4, "{t}: {g} {exact}");
    }
    // Without the limit the step over the hole overshoots by hundreds.
    assert!(careless[30].abs() > 1.0);
    assert!(model().with_max_step(0.0).is_err());
}

#[test]
fn analytic_standard_errors_are_those_of_the_groups() {
    // y = a + e_g with one draw for each of 12 groups: the standard error of a is sd/√groups, exactly.
    let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
    let draws: Vec<f64> = (0..12).map(|_| rng.random_range(-1.0..1.0)).collect();
    let time: Vec<f64> = (0..31).map(f64::from).collect();
    let one = vec![1.0; 31];
    let measured: Vec<Vec<f64>> = draws.iter().map(|d| vec![2.0 + d; 31]).collect();
    let records: Vec<Record<'_>> = measured
        .iter()
        .enumerate()
        .map(|(group, y)| Record {
            time: &time,
            inputs: vec![&one],
            measured: y,
            start: Vec::new(),
            group,
        })
        .collect();
    let constant = OdeModel::new(&[], &["u"], &["a"], &[], "a*u").unwrap();
    let whole = Shooting {
        window: f64::INFINITY,
        ..Shooting::default()
    };
    let refined = whole
        .refine(&constant, &records, &[Parameter::free(0.0)])
        .unwrap();
    let mean = draws.iter().sum::<f64>() / 12.0;
    let sd = (draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 11.0).sqrt();
    // Linear: the first step, damped by 1e-6, and the next.
    assert!((refined.parameters[0] - 2.0 - mean).abs() < 1e-9);
    assert!((refined.std_errors[0] - sd / 12f64.sqrt()).abs() < 1e-9);
}

#[test]
fn analytic_a_prior_pulls_as_its_width_says() {
    // n samples of 1 with noise sd 0.1 against a prior 0 ± 0.05: the posterior mean is n/0.01 / (n/0.01 + 400).
    let time: Vec<f64> = (0..31).map(f64::from).collect();
    let one = vec![1.0; 31];
    let record = Record {
        time: &time,
        inputs: vec![&one],
        measured: &one,
        start: Vec::new(),
        group: 0,
    };
    let constant = OdeModel::new(&[], &["u"], &["a"], &[], "a*u").unwrap();
    let whole = Shooting {
        window: f64::INFINITY,
        noise_sd: 0.1,
        every: 3,
        ..Shooting::default()
    };
    let prior = Parameter::free(0.0).prior(0.05);
    let refined = whole.refine(&constant, &[record], &[prior]).unwrap();
    let data = 11.0 / 0.01;
    assert_eq!(refined.residuals, 11);
    assert!((refined.parameters[0] - data / (data + 400.0)).abs() < 1e-9);
}

#[test]
fn prop_a_model_that_blows_up_at_the_start_comes_back_as_it_went() {
    // x' = a x² from 1 is infinite at t = 1/a: long before the end of the record.
    let time: Vec<f64> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
    let one = vec![1.0; 200];
    let record = Record {
        time: &time,
        inputs: vec![&one],
        measured: &one,
        start: vec![&one],
        group: 0,
    };
    let model = OdeModel::new(&["x"], &["u"], &["a"], &["a*x^2*u"], "x").unwrap();
    let whole = Shooting {
        window: f64::INFINITY,
        ..Shooting::default()
    };
    let refined = whole
        .refine(&model, &[record], &[Parameter::free(2.0)])
        .unwrap();
    assert_eq!(refined.parameters, [2.0]);
    assert_eq!(refined.outcome, Outcome::Stalled);
    assert!(refined.std_errors[0].is_nan() && refined.rmse == f64::INFINITY);
}

#[test]
fn prop_parameters_that_make_no_sense_are_named() {
    let d = data(5, 0.0);
    let record = Record {
        time: &d.time,
        inputs: vec![&d.z, &d.v],
        measured: &d.y,
        start: vec![&d.guess],
        group: 0,
    };
    for bad in [
        Parameter::free(1.0).within(2.0, 1.0),
        Parameter::free(f64::NAN),
        Parameter::free(1.0).prior(0.0),
    ] {
        let mut parameters = TRUTH.map(Parameter::free);
        parameters[2] = bad;
        let error = Shooting::default()
            .refine(&model(), std::slice::from_ref(&record), &parameters)
            .unwrap_err();
        assert!(error.to_string().contains("`h1`"), "{error}");
    }
}
