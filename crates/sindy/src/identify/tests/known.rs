//! Known parts of equations, and equations of second order.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use crate::identify::tests::quiet;
use crate::model::{Inputs, Model, Simulation, Term, Time};
use crate::{Dataset, Identification, Identify, Library, identify::Settings};

/// An oscillator of second order: `v' = Σ c θ(x, v, u)`, its runs and when they are sampled.
pub(super) struct Oscillator {
    pub(super) truth: Vec<(&'static str, f64)>,
    pub(super) starts: Vec<[f64; 2]>,
    step: f64,
    pub(super) rows: usize,
    input: &'static str,
}

impl Oscillator {
    fn model(&self) -> Model {
        let terms = self.truth.iter().map(|(t, c)| Term::parse(t, *c).unwrap());
        let position = vec![Term::parse("x_dot", 1.0).unwrap()];
        let equations = vec![position, terms.collect()];
        Model::new(Time::Continuous, &["x", "x_dot"], &["u"], equations).unwrap()
    }

    /// Positions with white noise of `percent` of their scatter (and velocities with as much of theirs), and the input.
    pub(super) fn data(&self, percent: f64, seed: u64, velocity: bool) -> Dataset {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let states: &[&str] = if velocity { &["x", "x_dot"] } else { &["x"] };
        let mut data = Dataset::new(states, &["u"]).unwrap();
        let time: Vec<f64> = (0..self.rows).map(|k| self.step * k as f64).collect();
        let formula = Inputs::formulas(&[self.input]).unwrap();
        let u: Vec<f64> = time.iter().map(|t| formula.at(*t).unwrap()[0]).collect();
        for start in &self.starts {
            let inputs = Inputs::formulas(&[self.input]).unwrap();
            let model = self.model();
            let run = model
                .simulate(start, &time, &inputs, &Simulation::adaptive())
                .unwrap();
            let mut columns = run.states;
            columns.truncate(states.len());
            for column in &mut columns {
                let n = column.len() as f64;
                let mean = column.iter().sum::<f64>() / n;
                let sd = (column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
                for v in column.iter_mut() {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    *v += 0.01 * percent * sd * z;
                }
            }
            columns.push(u.clone());
            data.push("run", time.clone(), columns, None).unwrap();
        }
        data
    }

    /// Terms that are too many or lack, intervals that hold the truth, and intervals, of the second equation.
    fn judge(&self, found: &Identification) -> (usize, usize, usize) {
        let own = &found.model.equations()[1];
        let intervals = &found.equations[1].intervals;
        let at = |text: &str| {
            let term = Term::parse(text, 1.0).unwrap().expression;
            own.iter().position(|t| t.expression == term)
        };
        let hits: Vec<(usize, f64)> = self
            .truth
            .iter()
            .filter_map(|(t, c)| at(t).map(|k| (k, *c)))
            .collect();
        let wrong = own.len() + self.truth.len() - 2 * hits.len();
        let held = hits
            .iter()
            .filter(|(k, c)| intervals[*k].is_some_and(|[low, high]| low <= *c && *c <= high));
        (wrong, held.count(), hits.len())
    }
}

pub(super) fn duffing() -> Oscillator {
    Oscillator {
        truth: vec![("x", 1.0), ("x_dot", -0.2), ("x^3", -1.0)],
        starts: vec![[2.0, 0.0], [-0.2, 1.5]],
        step: 0.05,
        rows: 800,
        input: "0",
    }
}

pub(super) fn pendulum() -> Oscillator {
    Oscillator {
        truth: vec![("x_dot", -0.15), ("sin(x)", -4.0)],
        starts: vec![[2.5, 0.0], [-1.2, 3.0]],
        step: 0.03,
        rows: 800,
        input: "0",
    }
}

pub(super) fn driven() -> Oscillator {
    Oscillator {
        truth: vec![("x", 1.0), ("x_dot", -0.3), ("x^3", -1.0), ("u", 1.0)],
        starts: vec![[0.5, 0.0], [-1.0, 0.3]],
        step: 0.05,
        rows: 800,
        input: "0.5*cos(1.2*t)",
    }
}

pub(super) fn second_order() -> Settings {
    Settings {
        second_order: vec!["x".into()],
        ..Settings::default()
    }
}

/// The candidates of the oscillators: polynomials, or what swings.
fn libraries() -> [(Oscillator, Library); 3] {
    let swing = [
        "1",
        "x",
        "x_dot",
        "x^2",
        "x*x_dot",
        "x_dot^2",
        "x^3",
        "x_dot^3",
        "sin(x)",
        "cos(x)",
        "x_dot*sin(x)",
        "x_dot*cos(x)",
    ];
    let cubic = |names: &[&str]| Library::polynomial(names, 3).unwrap();
    [
        (duffing(), cubic(&["x", "x_dot"])),
        (pendulum(), Library::parse(&swing).unwrap()),
        (driven(), cubic(&["x", "x_dot", "u"])),
    ]
}

pub(super) fn run(library: &Library, settings: Settings, data: &Dataset) -> Identification {
    let identify = Identify::new(library.clone()).settings(settings).unwrap();
    identify.run(data, &mut quiet()).unwrap()
}

#[test]
fn analytic_second_order_is_found_from_noisy_positions_alone() {
    let (mut held, mut all) = (0, 0);
    for (system, library) in libraries() {
        for seed in 0..2 {
            let found = run(&library, second_order(), &system.data(1.0, seed, false));
            let (wrong, own, of) = system.judge(&found);
            assert_eq!((wrong, of), (0, system.truth.len()), "{}", found.model);
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
            assert_eq!(found.choice.method, "output_error");
            // What is known is exact, and nothing is stated of a velocity that was not measured.
            let position = &found.model.equations()[0];
            assert_eq!((position.len(), position[0].coefficient), (1, 1.0));
            assert_eq!(found.equations[0].intervals, [None]);
            let velocity = &found.equations[1];
            assert!(velocity.noise.is_nan() && velocity.residual.is_none());
            held += own;
            all += of;
        }
    }
    // 18 intervals of 95 %, correlated within a fit: 15 or fewer that hold are expected in 6 % of draws.
    assert!(held >= 15, "{held} of {all}");
}

#[test]
fn analytic_a_known_equation_is_kept_and_a_known_part_is_not_fitted() {
    let system = driven();
    let library = Library::polynomial(&["x", "x_dot", "u"], 3).unwrap();
    let data = system.data(1.0, 7, true);
    let known = |texts: &[&str]| Settings {
        known: texts.iter().map(ToString::to_string).collect(),
        ..Settings::default()
    };
    let found = run(&library, known(&["x' = x_dot", "x_dot' = u + ..."]), &data);
    let text = format!("{:.2}", found.model);
    assert!(
        text.starts_with("x' = 1.0*x_dot\nx_dot' = 1.0*u + "),
        "{text}"
    );
    let own = &found.model.equations()[1];
    assert_eq!((own.len(), own[0].std_error), (4, None), "{text}");
    let (wrong, _, _) = system.judge(&found);
    assert_eq!(wrong, 0, "{text}");
    // A known part that is wrong shows: the right one is looked for around it, and u is no longer a candidate.
    let wrong = run(&library, known(&["x_dot' = 0.5*u + ..."]), &data);
    assert!(!wrong.warnings.is_empty(), "{}", wrong.model);
    assert_eq!(wrong.model.equations()[1][0].coefficient, 0.5);
}

#[test]
fn analytic_known_coefficients_that_are_wrong_are_named_and_right_ones_are_not() {
    let system = duffing();
    let library = Library::polynomial(&["x", "x_dot"], 3).unwrap();
    let contradicted = |known: &str, seed: u64| {
        let settings = Settings {
            known: vec![known.to_string()],
            ..Settings::default()
        };
        let found = run(&library, settings, &system.data(1.0, seed, true));
        let about = found.warnings.into_iter();
        about
            .filter(|w| w.contains("contradict the known coefficient"))
            .collect::<Vec<String>>()
    };
    for seed in 0..3 {
        // A whole equation, and parts that terms of the library nearly make up for.
        for (wrong, of) in [
            ("x' = 1.1*x_dot", "1.1 of x_dot in x'"),
            ("x_dot' = -0.25*x_dot + ...", "-0.25 of x_dot in x_dot'"),
            ("x_dot' = -1.1*x^3 + ...", "-1.1 of x^3 in x_dot'"),
        ] {
            let said = contradicted(wrong, seed);
            assert!(
                said.len() == 1 && said[0].contains(of),
                "{wrong} {seed}: {said:?}"
            );
        }
        for right in [
            "x' = x_dot",
            "x_dot' = -0.2*x_dot + ...",
            "x_dot' = -x^3 + ...",
        ] {
            assert_eq!(contradicted(right, seed), [""; 0]);
        }
    }
}

#[test]
fn analytic_a_small_coefficient_is_named_with_its_digits() {
    let mut noise = rand_pcg::Pcg64::seed_from_u64(1);
    let time: Vec<f64> = (0..1000).map(|k| 1e3 * f64::from(k)).collect();
    let decay = time
        .iter()
        .map(|t| 3.0 * (-2e-6 * t).exp() + noise.random_range(-1e-3..1e-3));
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    let columns = vec![decay.collect()];
    data.push("run", time, columns, None).unwrap();
    let settings = Settings {
        known: vec!["x' = -3e-6*x + ...".to_string()],
        ..Settings::default()
    };
    let library = Library::polynomial(&["x"], 2).unwrap();
    let found = run(&library, settings, &data);
    // The standard error is about 2e-9, two units of the last digit that is shown; the seed decides that digit.
    let named =
        |w: &String| w.contains("-0.000003 of x in x': a model in which it is -2.000e-6 ± ");
    assert!(found.warnings.iter().any(named), "{:?}", found.warnings);
}

#[test]
fn prop_known_parts_that_make_no_sense_are_refused() {
    let data = duffing().data(1.0, 0, true);
    let library = Library::polynomial(&["x", "x_dot"], 2).unwrap();
    let refused = |known: &[&str], second_order: &[&str]| {
        let own = |texts: &[&str]| texts.iter().map(ToString::to_string).collect();
        let settings = Settings {
            known: own(known),
            second_order: own(second_order),
            ..Settings::default()
        };
        let identify = Identify::new(library.clone()).settings(settings).unwrap();
        identify.run(&data, &mut quiet()).unwrap_err().to_string()
    };
    for (known, says) in [
        (&["x' - v"][..], "an equation, such as x' = v"),
        (&["y' = x"], "one of x', x_dot' before `=`, found `y'`"),
        (&["x' = x_dot + ..."; 2], "each equation once"),
        (
            &["x' = w"],
            "`known`: expected terms of x, x_dot, u, found `w`",
        ),
        (
            &["x' = x_dot", "x_dot' = -x"],
            "of which a part is not known",
        ),
    ] {
        let error = refused(known, &[]);
        assert!(error.contains(says), "{error}");
    }
    assert!(refused(&[], &["y"]).contains("`y`"));
    // What the velocity is may be said again, and not otherwise.
    let of_positions = |known: &[&str]| {
        let identify = Identify::new(library.clone()).settings(Settings {
            known: known.iter().map(ToString::to_string).collect(),
            ..second_order()
        });
        let data = duffing().data(1.0, 0, false);
        identify.unwrap().run(&data, &mut quiet())
    };
    let positions = of_positions(&["x' = 2*x_dot"]).unwrap_err().to_string();
    assert!(
        positions.contains("x' = x_dot, as the setting `second_order` says, found `x' = 2*x_dot`"),
        "{positions}"
    );
    assert!(of_positions(&["x' = x_dot"]).is_ok());
    // Its velocity is there already.
    assert!(refused(&[], &["x"]).contains("`x_dot`"));
}
