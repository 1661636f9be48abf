//! Signs that coefficients must have.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use super::known::{driven, duffing, pendulum, run, second_order};
use crate::identify::tests::quiet;
use crate::identify::{Method, Score};
use crate::model::Term;
use crate::{Dataset, Identification, Identify, Library, identify::Settings};

fn texts(signs: &[&str]) -> Vec<String> {
    signs.iter().map(ToString::to_string).collect()
}

/// The coefficient of a term in an equation; 0 where it is left out.
fn coefficient(found: &Identification, equation: usize, term: &str) -> f64 {
    let expression = Term::parse(term, 1.0).unwrap().expression;
    let mut own = found.model.equations()[equation].iter();
    own.find(|t| t.expression == expression)
        .map_or(0.0, |t| t.coefficient)
}

/// Whether two models have the same terms and coefficients, to what the search calls settled: a hundredth of a standard error.
fn alike(a: &Identification, b: &Identification) -> bool {
    let of = |f: &Identification| f.model.equations().concat();
    let (a, b) = (of(a), of(b));
    let near = |(a, b): (&Term, &Term)| {
        let off = (a.coefficient - b.coefficient).abs();
        a.expression == b.expression && off <= 0.01 * a.std_error.unwrap_or(0.0)
    };
    a.len() == b.len() && a.iter().zip(&b).all(near)
}

fn contradictions(found: &Identification) -> usize {
    let about = |w: &&String| w.contains("contradict the sign");
    found.warnings.iter().filter(about).count()
}

#[test]
fn analytic_a_damping_that_noise_turns_round_is_left_out_and_others_stay_as_they_are() {
    // A damping of 0.0001 with 5 % of noise: its standard error is 0.0002, and three draws of ten turn it round. With hardly any
    // penalty it stays in the model all the same.
    let mut system = pendulum();
    system.truth[0].1 = -0.0001;
    system.starts.truncate(1);
    system.rows = 400;
    let library = Library::parse(&["x_dot", "sin(x)"]).unwrap();
    let free = Settings {
        known: texts(&["x' = x_dot"]),
        penalty: 0.001,
        ..Settings::default()
    };
    let signed = Settings {
        signs: texts(&["x_dot': x_dot < 0"]),
        ..free.clone()
    };
    let mut turned = 0;
    for seed in 0..8 {
        let data = system.data(5.0, seed, true);
        let (without, with) = (
            run(&library, free.clone(), &data),
            run(&library, signed.clone(), &data),
        );
        let damping = coefficient(&without, 1, "x_dot");
        if damping <= 0.0 {
            assert!(alike(&with, &without), "{} {}", with.model, without.model);
            continue;
        }
        turned += 1;
        assert_eq!(with.model.equations()[1].len(), 1, "{}", with.model);
        let sine = &with.model.equations()[1][0];
        // Four standard errors, the estimate of the unconstrained fit of this term.
        let error = (sine.coefficient + 4.0).abs();
        assert!(error < 4.0 * sine.std_error.unwrap(), "{}", with.model);
        assert_eq!(contradictions(&with), 0, "{:?}", with.warnings);
    }
    assert!(turned > 0);
}

#[test]
fn analytic_a_sign_that_is_true_changes_nothing_and_one_that_is_false_is_warned_of() {
    let library = Library::polynomial(&["x", "x_dot"], 3).unwrap();
    let data = duffing().data(1.0, 1, false);
    let with = |signs: &[&str]| {
        let settings = Settings {
            signs: texts(signs),
            ..second_order()
        };
        run(&library, settings, &data)
    };
    let free = with(&[]);
    let signed = with(&["x'': x_dot < 0", "x_dot': x^3 <= 0", "x'': x > 0"]);
    assert!(alike(&signed, &free), "{} {}", signed.model, free.model);
    assert_eq!(contradictions(&signed), 0);
    let wrong = with(&["x'': x_dot > 0"]);
    assert!(coefficient(&wrong, 1, "x_dot") >= 0.0, "{}", wrong.model);
    assert_eq!(contradictions(&wrong), 1, "{:?}", wrong.warnings);
    let said = wrong
        .warnings
        .iter()
        .find(|w| w.contains("contradict"))
        .unwrap();
    assert!(
        said.contains("x_dot in x_dot'") && said.contains("is -0.20"),
        "{said}"
    );
}

/// Two states of a random stable map or of a driven oscillator, and random signs of some of ten candidates of each equation.
fn random_case(seed: u64, discrete: bool) -> (Dataset, Vec<String>) {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let data = match discrete {
        false => driven().data(5.0, seed, true),
        true => {
            let mut columns = vec![Vec::new(); 3];
            let mut state = [0.3, -0.2];
            let a: Vec<f64> = (0..5).map(|_| rng.random_range(-0.6..0.6)).collect();
            for k in 0..300 {
                let u = (0.7 * f64::from(k)).sin();
                for (column, v) in columns.iter_mut().zip([state[0], state[1], u]) {
                    column.push(v);
                }
                let z: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
                let [x, y] = state;
                state = [
                    a[0] * x + a[1] * u * u + 0.1 * z[0],
                    a[2] * x + a[3] * y + a[4] * u + 0.1 * z[1],
                ];
            }
            let mut data = Dataset::new(&["x", "x_dot"], &["u"]).unwrap();
            let time = (0..300).map(f64::from).collect();
            data.push("map", time, columns, None).unwrap();
            data
        }
    };
    let mut signs = Vec::new();
    for state in ["x", "x_dot"] {
        for term in ["1", "x", "x_dot", "u", "x^2", "x*x_dot", "x_dot^2", "u^2"] {
            let mark = ["<", ">", ""][rng.random_range(0..3)];
            let left = if discrete { "[k+1]" } else { "'" };
            if !mark.is_empty() {
                signs.push(format!("{state}{left}: {term} {mark} 0"));
            }
        }
    }
    (data, signs)
}

#[test]
fn prop_no_coefficient_breaks_a_sign_whatever_the_signs_and_the_method() {
    let library = Library::polynomial(&["x", "x_dot", "u"], 2).unwrap();
    let mut free = 0;
    for seed in 0..3 {
        for (discrete, method, score) in [
            (false, Method::Automatic, Score::Automatic),
            (false, Method::OutputError, Score::Automatic),
            (false, Method::Regression, Score::LeftOut),
            (true, Method::Automatic, Score::Automatic),
            (true, Method::OutputError, Score::LeftOut),
        ] {
            let (data, signs) = random_case(seed, discrete);
            let settings = Settings {
                signs: signs.clone(),
                discrete,
                method,
                score,
                penalty: 0.05,
                ..Settings::default()
            };
            let found = run(&library, settings.clone(), &data);
            let broken = |found: &Identification| {
                let all = signs.iter().map(|sign| {
                    let (left, condition) = sign.split_once(": ").unwrap();
                    let (term, mark) = condition.trim_end_matches(" 0").rsplit_once(' ').unwrap();
                    let value = coefficient(found, usize::from(left.starts_with("x_dot")), term);
                    if mark == "<" {
                        value > 0.0
                    } else {
                        value < 0.0
                    }
                });
                all.filter(|b| *b).count()
            };
            assert_eq!(
                broken(&found),
                0,
                "{seed} {method:?}: {signs:?}\n{}",
                found.model
            );
            let without = Settings {
                signs: Vec::new(),
                ..settings
            };
            free += broken(&run(&library, without, &data));
        }
    }
    // The signs bind: without them dozens are broken.
    assert!(free > 10, "{free}");
}

#[test]
fn prop_signs_that_make_no_sense_are_refused() {
    let data = duffing().data(1.0, 0, true);
    let library = Library::polynomial(&["x", "x_dot"], 2).unwrap();
    let refused = |signs: &[&str]| {
        let settings = Settings {
            signs: texts(signs),
            known: texts(&["x' = x_dot", "x_dot' = x^2 + ..."]),
            ..Settings::default()
        };
        let identify = Identify::new(library.clone()).settings(settings).unwrap();
        identify.run(&data, &mut quiet()).unwrap_err().to_string()
    };
    for (signs, says) in [
        (&["x_dot < 0"][..], "an equation, `:` and a sign"),
        (&["y': x < 0"], "one of x', x_dot' before `:`, found `y'`"),
        (&["x_dot[k+1]: x < 0"], "one of x', x_dot' before `:`"),
        (
            &["x_dot': w < 0"],
            "a candidate term of x_dot': 1, x, x_dot, ",
        ),
        (&["x_dot': x^2 < 0"], "a candidate term of x_dot'"),
        (&["x': x_dot > 0"], "an equation that is not known"),
        (&["x_dot': x < 10"], "a term and `< 0` or `> 0`"),
        (&["x_dot': x = 0"], "a term and `< 0` or `> 0`"),
        (&["x_dot': > 0"], "a term and `< 0` or `> 0`"),
        (&["x_dot': 0*x > 0"], "a term and `< 0` or `> 0`"),
        (
            &["x_dot': x < 0", "x_dot': -2*x < 0"],
            "nothing against `x_dot': x < 0`",
        ),
    ] {
        let error = refused(signs);
        assert!(error.contains("`signs`") && error.contains(says), "{error}");
    }
}
