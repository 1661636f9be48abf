use super::*;
use crate::model::Term;

fn model(equations: &[&[(&str, f64)]], states: &[&str], inputs: &[&str]) -> Model {
    let term = |(text, c): &(&str, f64)| Term::parse(text, *c).unwrap();
    let equations = equations.iter().map(|e| e.iter().map(term).collect());
    Model::new(Time::Continuous, states, inputs, equations.collect()).unwrap()
}

fn past(input: &str, state: &str, delay: f64) -> Past {
    Past {
        input: input.into(),
        state: state.into(),
        delay,
    }
}

#[test]
fn analytic_a_delayed_decay_is_made_of_polynomials() {
    // x' = -x(t - 1), x = 1 before 0: one more power of t in each unit of time.
    let model = model(&[&[("b", -1.0)]], &["x"], &["b"]);
    let model = model.with_past(vec![past("b", "x", 1.0)]).unwrap();
    let truth = |t: f64| {
        let power = |from: f64, k: i32| (t - from).max(0.0).powi(k);
        1.0 - power(0.0, 1) + power(1.0, 2) / 2.0 - power(2.0, 3) / 6.0
    };
    // Times that hit the steps' ends, and times that miss them by rounding.
    for step in [0.25, 0.1, 0.07] {
        let time: Vec<f64> = (0..=(3.0 / step) as usize)
            .map(|k| k as f64 * step)
            .collect();
        let before: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k) - 1.0).collect();
        let sampled = History::sampled(&before, &[&[1.0; 21]]).unwrap();
        for history in [History::constant(&[1.0]), sampled] {
            let how = Simulation::adaptive();
            let run = model
                .simulate_past(&history, &time, &Inputs::none(), &how)
                .unwrap();
            assert_eq!(
                (run.outcome.clone(), &run.time),
                (RunOutcome::Finished, &time)
            );
            for (t, x) in time.iter().zip(&run.states[0]) {
                // Cubics are exact for these polynomials: the integrator's tolerance.
                assert!((x - truth(*t)).abs() < 1e-6, "{step}, {t}: {x}");
            }
        }
    }
}

#[test]
fn analytic_inputs_from_outside_and_two_delays() {
    // u steps at 1: x = t - 1, y of the past of x by 1, z by 0.3.
    let equations: [&[(&str, f64)]; 3] = [&[("u", 1.0)], &[("a", 1.0)], &[("b", 1.0)]];
    let model = model(&equations, &["x", "y", "z"], &["a", "u", "b"]);
    let model = model
        .with_past(vec![past("a", "x", 1.0), past("b", "x", 0.3)])
        .unwrap();
    assert_eq!(model.outside(), ["u"]);
    let at = [0.0, 1.0, 5.0];
    let u = Inputs::sampled(&at, &[&[0.0, 1.0, 1.0]], Interpolation::ZeroOrderHold).unwrap();
    let time: Vec<f64> = (0..=50).map(|k| 0.1 * f64::from(k)).collect();
    let history = History::constant(&[0.0; 3]);
    let run = model
        .simulate_past(&history, &time, &u, &Simulation::adaptive())
        .unwrap();
    for (k, t) in time.iter().enumerate() {
        let ramp = |from: f64| (t - from).max(0.0);
        let truth = [ramp(1.0), ramp(2.0).powi(2) / 2.0, ramp(1.3).powi(2) / 2.0];
        for (column, truth) in run.states.iter().zip(truth) {
            // A spline across the kink of x, with samples 0.3/16 apart: a tenth of that, squared.
            assert!(
                (column[k] - truth).abs() < 1e-4,
                "{t}: {} {truth}",
                column[k]
            );
        }
    }
}

#[test]
fn prop_bad_pasts_and_histories_are_refused_and_files_read_back() {
    let plain = || model(&[&[("b", -1.0)]], &["x"], &["b", "u"]);
    for (bad, says) in [
        (vec![past("c", "x", 1.0)], "`c`"),
        (vec![past("b", "y", 1.0)], "`y`"),
        (vec![past("b", "x", 0.0)], "positive"),
        (vec![past("b", "x", f64::NAN)], "positive"),
        (vec![past("b", "x", 1.0), past("b", "x", 2.0)], "twice"),
    ] {
        let error = plain().with_past(bad).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
    let model = plain().with_past(vec![past("b", "x", 0.7)]).unwrap();
    let text = model.to_json().unwrap();
    assert_eq!(Model::from_json(&text).unwrap(), model);
    assert_ne!(Model::from_json(&text).unwrap(), plain());
    assert!(Model::from_json(&text.replace("0.7", "-0.7")).is_err());
    let short = History::sampled(&[-0.5, 0.0], &[&[1.0, 1.0]]).unwrap();
    let u = Inputs::constant(&[1.0]).unwrap();
    let how = Simulation::adaptive();
    let error = model
        .simulate_past(&short, &[0.0, 1.0], &u, &how)
        .unwrap_err();
    assert!(error.to_string().contains("history"), "{error}");
    let error = model.simulate_past(&short, &[0.0, 1.0], &Inputs::none(), &how);
    assert!(error.unwrap_err().to_string().contains("from outside"));
}
