//! Equilibria with known places and eigenvalues.

use super::{model, one};
use crate::model::{Equilibrium, Model, Search, Stability, Time};
use crate::problems;

/// Places come from Newton's method at full precision, eigenvalues from matrices of entries up to 30:
/// roundings of 1e-15 times a condition of at most 1000.
const CLOSE: f64 = 1e-11;

fn assert_at(found: &Equilibrium, expected: &[f64]) {
    for (a, b) in found.state.iter().zip(expected) {
        assert!((a - b).abs() < CLOSE, "{found:?} against {expected:?}");
    }
}

fn lorenz(rho: f64) -> Model {
    model(
        &["x", "y", "z"],
        &[],
        &[
            &[("x", -10.0), ("y", 10.0)],
            &[("x", rho), ("y", -1.0), ("x*z", -1.0)],
            &[("z", -8.0 / 3.0), ("x*y", 1.0)],
        ],
    )
}

#[test]
fn analytic_lorenz() {
    let search = Search::new(&[(-30.0, 30.0), (-30.0, 30.0), (-10.0, 60.0)]);
    // The pair is stable for ρ between 1 and 24.74.
    for (rho, pair) in [(28.0, Stability::Saddle), (14.0, Stability::StableFocus)] {
        let found = search.run(&lorenz(rho)).unwrap();
        assert_eq!(found.equilibria.len(), 3, "{found:?}");
        let side = (8.0 / 3.0 * (rho - 1.0)).sqrt();
        let [left, origin, right] = &found.equilibria[..] else {
            panic!()
        };
        assert_at(left, &[-side, -side, rho - 1.0]);
        assert_at(origin, &[0.0, 0.0, 0.0]);
        assert_at(right, &[side, side, rho - 1.0]);
        assert_eq!(
            [left, origin, right].map(|e| e.stability),
            [pair, Stability::Saddle, pair]
        );
        // At the origin: -β and (-(σ+1) ± sqrt((σ-1)² + 4σρ))/2.
        let root = (81.0 + 40.0 * rho).sqrt();
        let expected = [(-11.0 + root) / 2.0, -8.0 / 3.0, (-11.0 - root) / 2.0];
        for (value, expected) in origin.eigenvalues.iter().zip(expected) {
            assert!(
                (value.re - expected).abs() < CLOSE && value.im == 0.0,
                "{value}"
            );
        }
    }
}

#[test]
fn analytic_classes_of_the_catalogue() {
    let classes = |problem: problems::Problem, ranges: &[(f64, f64)]| {
        let found = Search::new(ranges).run(&problem.model().unwrap()).unwrap();
        found
            .equilibria
            .into_iter()
            .map(|e| (e.state, e.stability))
            .collect::<Vec<_>>()
    };
    let duffing = classes(problems::duffing(), &[(-2.0, 2.0), (-2.0, 2.0)]);
    let kinds: Vec<Stability> = duffing.iter().map(|(_, s)| *s).collect();
    assert_eq!(
        kinds,
        [
            Stability::StableFocus,
            Stability::Saddle,
            Stability::StableFocus
        ]
    );
    // A double eigenvalue 1.
    let van_der_pol = classes(problems::van_der_pol(), &[(-3.0, 3.0), (-3.0, 3.0)]);
    assert_eq!(van_der_pol, [(vec![0.0, 0.0], Stability::UnstableNode)]);
    let lotka = classes(problems::lotka_volterra(), &[(-0.5, 3.0), (-0.5, 3.0)]);
    assert_eq!(lotka[0].1, Stability::Saddle);
    assert_eq!(lotka[1].1, Stability::Centre);
    assert!((lotka[1].0[0] - 1.0).abs() < CLOSE && (lotka[1].0[1] - 0.5).abs() < CLOSE);
    let oscillator = classes(problems::damped_oscillator(), &[(-3.0, 3.0), (-3.0, 3.0)]);
    assert_eq!(oscillator, [(vec![0.0, 0.0], Stability::StableFocus)]);
}

/// Truth: z = (c ± sqrt(c² - 4ab)) / 2a, x = a z, y = -z.
#[test]
fn analytic_rossler() {
    let problem = problems::rossler().model().unwrap();
    let found = Search::new(&[(-10.0, 10.0), (-40.0, 10.0), (-10.0, 40.0)])
        .run(&problem)
        .unwrap();
    let root = (5.7_f64 * 5.7 - 4.0 * 0.04).sqrt();
    let [near, far] = &found.equilibria[..] else {
        panic!("{found:?}")
    };
    for (e, z) in [(near, (5.7 - root) / 0.4), (far, (5.7 + root) / 0.4)] {
        assert_at(e, &[0.2 * z, -z, z]);
    }
}

#[test]
fn analytic_an_input_moves_the_rest() {
    let model = model(&["x"], &["u"], &[&[("x", -2.0), ("u", 3.0)]]);
    let found = Search::new(&[(-5.0, 5.0)])
        .input(&[2.0])
        .run(&model)
        .unwrap();
    assert_at(&found.equilibria[0], &[3.0]);
    assert_eq!(found.equilibria[0].stability, Stability::StableNode);
    let outside = Search::new(&[(-1.0, 1.0)])
        .input(&[2.0])
        .run(&model)
        .unwrap();
    assert!(outside.equilibria.is_empty());
    assert_eq!((outside.inside, outside.outside), (0, outside.starts));
}

#[test]
fn analytic_multiple_none_and_a_line() {
    let range = [(-1.0, 2.0)];
    // A triple root, where Newton's method converges linearly.
    let cube = Search::new(&range)
        .run(&model(&["x"], &[], &[&[("x^3", -1.0)]]))
        .unwrap();
    let [only] = &cube.equilibria[..] else {
        panic!("{cube:?}")
    };
    assert_eq!(only.stability, Stability::NonHyperbolic);
    assert!(cube.inside > 150, "{cube:?}");
    // A double root off the origin: x² - 2x·0.7 + 0.49, met to the square root of rounding.
    let touch = model(&["x"], &[], &[&[("x^2", 1.0), ("x", -1.4), ("1", 0.49)]]);
    let touch = Search::new(&range).run(&touch).unwrap();
    let [only] = &touch.equilibria[..] else {
        panic!("{touch:?}")
    };
    assert!((only.state[0] - 0.7).abs() < 1e-7);
    let none = Search::new(&range)
        .run(&model(&["x"], &[], &[&[("1", 1.0), ("x^2", 1.0)]]))
        .unwrap();
    assert!(
        none.equilibria.is_empty() && none.inside + none.outside == 0,
        "{none:?}"
    );
    let constant = Search::new(&range)
        .run(&model(&["x"], &[], &[&[("1", 1.0)]]))
        .unwrap();
    assert!(constant.equilibria.is_empty());
    let line = model(
        &["x", "y"],
        &[],
        &[&[("x", 1.0), ("y", -1.0)], &[("x", 2.0), ("y", -2.0)]],
    );
    let line = Search::new(&[(-1.0, 1.0), (-1.0, 1.0)])
        .starts(20)
        .run(&line)
        .unwrap();
    assert!(line.equilibria.len() > 10);
    for e in &line.equilibria {
        assert_eq!(e.stability, Stability::NonHyperbolic);
        assert!((e.state[0] - e.state[1]).abs() < CLOSE);
    }
    // A slope without bound: log(x) x' has its rest at 1 and no value below 0.
    let log = Search::new(&[(-1.0, 3.0)])
        .run(&model(&["x"], &[], &[&[("log(x)", -1.0)]]))
        .unwrap();
    let [only] = &log.equilibria[..] else {
        panic!("{log:?}")
    };
    assert_at(only, &[1.0]);
}

/// Truth: x[k+1] = r x (1 - x) rests at 0 (slope r) and 1 - 1/r (slope 2 - r).
#[test]
fn analytic_fixed_points_of_the_logistic_map() {
    for (r, at_zero, other) in [
        (2.5, Stability::UnstableNode, Stability::StableNode),
        (3.2, Stability::UnstableNode, Stability::UnstableNode),
        (3.0, Stability::UnstableNode, Stability::NonHyperbolic),
    ] {
        let law = vec![[one("x", r).remove(0), one("x^2", -r).remove(0)].concat()];
        let map = Model::new(Time::Discrete { period: 1.0 }, &["x"], &[], law).unwrap();
        let found = Search::new(&[(-0.5, 1.5)]).run(&map).unwrap();
        let [zero, upper] = &found.equilibria[..] else {
            panic!("{found:?}")
        };
        assert_at(zero, &[0.0]);
        assert_at(upper, &[1.0 - 1.0 / r]);
        assert_eq!((zero.stability, upper.stability), (at_zero, other), "{r}");
        assert!((upper.eigenvalues[0].re - (2.0 - r)).abs() < CLOSE);
    }
}

#[test]
fn bad_searches_are_refused() {
    let model = model(&["x"], &["u"], &[&[("x", 1.0)]]);
    let text = |search: Search| search.run(&model).unwrap_err().to_string();
    assert!(text(Search::new(&[])).contains("expected 1, found 0"));
    assert!(text(Search::new(&[(1.0, 1.0)])).contains("1 to 1 for `x`"));
    assert!(text(Search::new(&[(f64::NAN, 1.0)])).contains("NaN to 1"));
    assert!(text(Search::new(&[(0.0, f64::INFINITY)])).contains("inf"));
    assert!(text(Search::new(&[(0.0, 1.0)]).starts(0)).contains("`starts`"));
    assert!(text(Search::new(&[(0.0, 1.0)]).input(&[1.0, 2.0])).contains("expected 1, found 2"));
    assert!(text(Search::new(&[(0.0, 1.0)]).input(&[f64::NAN])).contains("input: sample 0"));
}
