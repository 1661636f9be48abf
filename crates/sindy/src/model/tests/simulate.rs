//! Runs over time.

use super::input::{TIME, VALUE};
use super::{model, one};
use crate::model::{
    Inputs, Integrator, Interpolation, Limits, Model, RunOutcome, Simulation, Time,
};
use crate::problems;

fn tight() -> Simulation {
    Simulation::new(Integrator::DormandPrince {
        relative: 1e-13,
        absolute: 1e-14,
    })
}

/// Runs from 0 over `times` with both integrators and compares with reference rows.
fn check(
    model: &Model,
    start: &[f64],
    inputs: &Inputs,
    expected: &[(f64, &[f64])],
    tolerance: f64,
) {
    let times: Vec<f64> = [0.0]
        .into_iter()
        .chain(expected.iter().map(|(t, _)| *t))
        .collect();
    for how in [tight(), Simulation::fixed(2e-4)] {
        let run = model.simulate(start, &times, inputs, &how).unwrap();
        assert_eq!(run.outcome, RunOutcome::Finished);
        for (row, (t, values)) in expected.iter().enumerate() {
            for (state, value) in run.states.iter().zip(*values) {
                let error = (state[row + 1] - value).abs();
                assert!(
                    error < tolerance,
                    "{how:?} at {t}: {} against {value}",
                    state[row + 1]
                );
            }
        }
    }
}

// Reference values: SciPy 1.17.1, solve_ivp(method="DOP853", rtol=3e-14, atol=1e-15).

/// Tolerance: rounding of 1e-15 times numbers of about 30, grown e-fold in each 1.1 time units along the
/// attractor and up to a hundredfold within one turn.
#[test]
fn xval_lorenz() {
    check(
        &problems::lorenz().model().unwrap(),
        &[-8.0, 7.0, 27.0],
        &Inputs::none(),
        &[
            (
                0.37,
                &[12.147442750089462, 16.86765651473916, 25.808701679572206],
            ),
            (
                1.0,
                &[5.52367664006872, 9.518798956833404, 13.58349971452726],
            ),
            (
                2.0,
                &[-12.598717408172767, -20.78263802164428, 20.842192722987633],
            ),
        ],
        1e-9,
    );
}

/// Tolerance: 1e-13 a step over about a thousand steps, on a stable limit cycle.
#[test]
fn xval_van_der_pol() {
    check(
        &problems::van_der_pol().model().unwrap(),
        &[1.0, 0.0],
        &Inputs::none(),
        &[
            (0.123, &[0.9924422266623278, -0.12280398453994947]),
            (5.0, &[0.19633507239827613, 2.995784241011468]),
            (20.0, &[-0.41259568128341423, 1.7950171965814687]),
        ],
        1e-10,
    );
}

/// Tolerance: as for Van der Pol; errors along the orbit grow linearly.
#[test]
fn xval_lotka_volterra() {
    check(
        &problems::lotka_volterra().model().unwrap(),
        &[1.8, 1.3],
        &Inputs::none(),
        &[
            (0.777, &[0.649237588504023, 1.4543679843713873]),
            (10.0, &[0.3916125705753196, 1.1518348257040667]),
            (20.0, &[0.24846190528474488, 0.47385179932260596]),
        ],
        1e-11,
    );
}

/// Tolerance: as for Van der Pol.
#[test]
fn xval_duffing_under_a_formula_of_time() {
    check(
        &problems::duffing().model().unwrap(),
        &[1.0, 0.0],
        &Inputs::formulas(&["0.5*cos(1.2*t)"]).unwrap(),
        &[
            (3.3, &[0.46306914775664304, -0.4750414727577692]),
            (10.0, &[0.14396252881659763, -0.048163431244547736]),
        ],
        1e-11,
    );
}

/// x' = -x + x²/4 + u, the reference integrated from sample to sample. Tolerance: as for Van der Pol,
/// on a contracting system.
#[test]
fn xval_sampled_inputs() {
    let model = model(&["x"], &["u"], &[&[("x", -1.0), ("x^2", 0.25), ("u", 1.0)]]);
    let expected = [
        (
            Interpolation::ZeroOrderHold,
            [
                0.3495656202153338,
                0.6770756055770505,
                0.029656236195730143,
                1.4293734707370755,
                1.2358876119719222,
            ],
        ),
        (
            Interpolation::Linear,
            [
                0.5302760384552865,
                0.2728336616344485,
                0.4170418154387721,
                0.9990215352343955,
                0.7750630084370193,
            ],
        ),
        (
            Interpolation::Cubic,
            [
                0.6922678172152676,
                0.24358217984006092,
                0.34882714591006403,
                1.536968295246133,
                1.0917261621964274,
            ],
        ),
    ];
    for (how, values) in expected {
        let inputs = Inputs::sampled(&TIME, &[&VALUE], how).unwrap();
        let rows: Vec<[f64; 1]> = values.map(|v| [v]).to_vec();
        let rows: Vec<(f64, &[f64])> = TIME[1..]
            .iter()
            .copied()
            .zip(rows.iter().map(<[f64; 1]>::as_slice))
            .collect();
        check(&model, &[0.5], &inputs, &rows, 1e-11);
        // Asked only for the end: the samples between are met all the same.
        check(&model, &[0.5], &inputs, &rows[4..], 1e-11);
    }
}

/// Truth: e^-t. The output between steps is of order 4, so its error may exceed the tolerance of the
/// steps somewhat: a factor of 100 is allowed.
#[test]
fn analytic_dense_output_keeps_the_tolerance() {
    let model = model(&["x"], &[], &[&[("x", -1.0)]]);
    let times: Vec<f64> = (0..=1000).map(|k| 0.01 * f64::from(k)).collect();
    for relative in [1e-4, 1e-6, 1e-8, 1e-10] {
        let how = Simulation::new(Integrator::DormandPrince {
            relative,
            absolute: 0.0,
        });
        let run = model
            .simulate(&[1.0], &times, &Inputs::none(), &how)
            .unwrap();
        // Far fewer steps than rows: most rows are from the continuous output.
        assert!(run.steps < 400, "{}", run.steps);
        let worst = times
            .iter()
            .zip(&run.states[0])
            .map(|(t, x)| (x * t.exp() - 1.0).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 100.0 * relative, "{relative}: {worst}");
    }
}

/// Truth: e^-t. Halving the step divides the error of an order-4 method by 16, here to within 10 %.
#[test]
fn analytic_fixed_steps_have_order_4() {
    let model = model(&["x"], &[], &[&[("x", -1.0)]]);
    let error = |step| {
        let run = model.simulate(
            &[1.0],
            &[0.0, 1.0],
            &Inputs::none(),
            &Simulation::fixed(step),
        );
        (run.unwrap().states[0][1] - (-1.0_f64).exp()).abs()
    };
    let ratio = error(0.1) / error(0.05);
    assert!((ratio / 16.0 - 1.0).abs() < 0.1, "{ratio}");
}

/// Truth: x' = x² from 1 is 1/(1-t).
#[test]
fn analytic_blow_up_is_an_outcome() {
    let model = model(&["x"], &[], &[&[("x^2", 1.0)]]);
    let times: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
    for (how, within) in [
        (Simulation::adaptive(), 1e-6),
        (Simulation::fixed(1e-3), 0.02),
    ] {
        let run = model
            .simulate(&[1.0], &times, &Inputs::none(), &how)
            .unwrap();
        let RunOutcome::BlewUp { time } = run.outcome else {
            panic!("{:?}", run.outcome)
        };
        // Adaptive steps follow the solution to 1e12; fixed ones overshoot within some steps.
        assert!((time - 1.0).abs() < within, "{time}");
        assert!(run.states[0].iter().all(|x| x.is_finite()));
        assert_eq!(run.time.len(), run.states[0].len());
        assert!(
            (run.states[0][9] - 10.0).abs() < 1e-4,
            "{:?}",
            run.states[0]
        );
    }
}

#[test]
fn analytic_a_state_out_of_range_is_an_outcome() {
    let model = model(&["x", "y"], &[], &[&[("1", 1.0)], &[]]);
    let limits = Limits::default()
        .range("x", -1.0, 0.55)
        .range("y", 0.0, 10.0);
    let times = [0.0, 0.25, 0.5, 0.75, 1.0];
    let how = Simulation::fixed(0.25).limits(limits.clone());
    let run = model
        .simulate(&[0.0, 5.0], &times, &Inputs::none(), &how)
        .unwrap();
    let left = RunOutcome::OutOfRange {
        time: 0.75,
        state: "x".to_owned(),
    };
    assert_eq!(run.outcome, left);
    assert_eq!(run.time, [0.0, 0.25, 0.5]);
    let run = model
        .simulate(&[0.0, 11.0], &times, &Inputs::none(), &how)
        .unwrap();
    assert_eq!(
        run.outcome,
        RunOutcome::OutOfRange {
            time: 0.0,
            state: "y".to_owned()
        }
    );
    assert!(run.time.is_empty());
    let how = Simulation::adaptive().limits(limits);
    let run = model
        .simulate(&[0.0, 5.0], &times, &Inputs::none(), &how)
        .unwrap();
    assert!(matches!(run.outcome, RunOutcome::OutOfRange { time, .. } if time > 0.55));
}

/// Truth: x' = -1/x from 1 is sqrt(1-2t), which ends at t = 1/2 with an infinite slope.
#[test]
fn analytic_an_end_of_the_solution_is_found() {
    let model = model(&["x"], &[], &[&[("1/x", -1.0)]]);
    let run = model
        .simulate(
            &[1.0],
            &[0.0, 1.0],
            &Inputs::none(),
            &Simulation::adaptive(),
        )
        .unwrap();
    let RunOutcome::StepTooSmall { time } = run.outcome else {
        panic!("{:?}", run.outcome)
    };
    // The end carries the integration error, about the tolerance of 1e-8; ten times that.
    assert!((time - 0.5).abs() < 1e-7, "{time}");
}

#[test]
fn ends_without_a_derivative_or_with_too_many_steps_are_outcomes() {
    let root = model(&["x"], &[], &[&[("sqrt(x)", 1.0)]]);
    let none = Inputs::none();
    for how in [Simulation::adaptive(), Simulation::fixed(0.1)] {
        let run = root.simulate(&[-1.0], &[0.0, 1.0], &none, &how).unwrap();
        assert!(
            matches!(run.outcome, RunOutcome::BlewUp { .. }),
            "{:?}",
            run.outcome
        );
        assert_eq!(run.time, [0.0]);
        let decay = model(&["x"], &[], &[&[("x", -1.0)]]);
        let run = decay
            .simulate(&[1.0], &[0.0, 100.0], &none, &how.clone().step_limit(5))
            .unwrap();
        assert!(
            matches!(run.outcome, RunOutcome::StepLimit { .. }),
            "{:?}",
            run.outcome
        );
        // One time: nothing to do but to begin.
        let run = decay.simulate(&[1.0], &[3.0], &none, &how).unwrap();
        assert_eq!((run.outcome, run.time), (RunOutcome::Finished, vec![3.0]));
    }
}

/// Truth: x[k+1] = 4 x (1 - x) from sin²(a) is sin²(2^k a). Each step doubles the error.
#[test]
fn analytic_logistic_map() {
    let law = vec![[one("x", 4.0).remove(0), one("x^2", -4.0).remove(0)].concat()];
    let model = Model::new(Time::Discrete { period: 0.5 }, &["x"], &[], law).unwrap();
    let start = 0.3_f64.sin().powi(2);
    let run = model
        .iterate(&[start], 20, &[], &Limits::default())
        .unwrap();
    assert_eq!(run.outcome, RunOutcome::Finished);
    assert_eq!((run.time[20], run.time.len()), (10.0, 21));
    for (k, x) in run.states[0].iter().enumerate() {
        let expected = (0.3 * 2.0_f64.powi(k as i32)).sin().powi(2);
        assert!(
            (x - expected).abs() < 1e-15 * 2.0_f64.powi(k as i32 + 2),
            "{k}"
        );
    }
    let run = model.iterate(&[2.0], 20, &[], &Limits::default()).unwrap();
    assert!(matches!(run.outcome, RunOutcome::BlewUp { .. }));
    let times = [0.0, 1.0];
    assert!(
        model
            .simulate(&[0.1], &times, &Inputs::none(), &Simulation::adaptive())
            .is_err()
    );
}

#[test]
fn analytic_discrete_inputs_act_from_their_row() {
    let law = vec![[one("x", 1.0).remove(0), one("u", 1.0).remove(0)].concat()];
    let model = Model::new(Time::Discrete { period: 1.0 }, &["x"], &["u"], law).unwrap();
    let run = model
        .iterate(&[0.0], 3, &[&[1.0, 2.0, 4.0]], &Limits::default())
        .unwrap();
    assert_eq!(run.states[0], [0.0, 1.0, 3.0, 7.0]);
    let short = model.iterate(&[0.0], 4, &[&[1.0, 2.0, 4.0]], &Limits::default());
    assert!(
        short
            .unwrap_err()
            .to_string()
            .contains("at least 4, found 3")
    );
    assert!(model.iterate(&[0.0], 1, &[], &Limits::default()).is_err());
}

#[test]
fn bad_settings_are_refused_with_the_offending_value() {
    let model = model(&["x"], &["u"], &[&[("u", 1.0)]]);
    let held = Inputs::sampled(&TIME, &[&VALUE], Interpolation::Linear).unwrap();
    let text = |start: &[f64], time: &[f64], inputs: &Inputs, how: &Simulation| {
        model
            .simulate(start, time, inputs, how)
            .unwrap_err()
            .to_string()
    };
    let good = Simulation::adaptive();
    assert!(text(&[], &[0.0], &held, &good).contains("expected 1, found 0"));
    assert!(text(&[f64::NAN], &[0.0], &held, &good).contains("start: sample 0"));
    assert!(text(&[0.0], &[], &held, &good).contains("at least 1"));
    assert!(text(&[0.0], &[0.0, 0.0], &held, &good).contains("sample 1"));
    assert!(text(&[0.0], &[0.0, f64::INFINITY], &held, &good).contains("time: sample 1"));
    assert!(text(&[0.0], &[0.0, 3.1], &held, &good).contains("found 0 to 3.1"));
    assert!(text(&[0.0], &[0.0, 1.0], &Inputs::none(), &good).contains("expected 1, found 0"));
    for step in [0.0, -1.0, f64::NAN] {
        assert!(text(&[0.0], &[0.0, 1.0], &held, &Simulation::fixed(step)).contains("`step`"));
    }
    for (relative, absolute) in [(0.0, 1.0), (f64::NAN, 1.0), (1e-3, -1.0), (1e-3, f64::NAN)] {
        let how = Simulation::new(Integrator::DormandPrince { relative, absolute });
        assert!(text(&[0.0], &[0.0, 1.0], &held, &how).contains("tolerance"));
    }
    let how = |limits| Simulation::adaptive().limits(limits);
    let limits = Limits::default().range("q", 0.0, 1.0);
    assert!(text(&[0.0], &[0.0], &held, &how(limits)).contains("no column named `q`"));
    let limits = Limits::default().range("x", 1.0, 1.0);
    assert!(text(&[0.0], &[0.0], &held, &how(limits)).contains("1 to 1 for `x`"));
    let limits = Limits::default().blow_up_above(f64::NAN);
    assert!(text(&[0.0], &[0.0], &held, &how(limits)).contains("`blow_up_above`"));
    assert!(
        model
            .iterate(&[0.0], 1, &[&[0.0]], &Limits::default())
            .is_err()
    );
}
