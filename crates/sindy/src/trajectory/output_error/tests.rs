use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};

use super::select::Search;
use super::*;
use crate::library::Library;
use crate::model::Time;

fn strings(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}

#[test]
fn analytic_a_step_and_its_sensitivities_against_differences() {
    let library = Library::parse(&["x", "y", "x*y", "sin(x)", "u"]).unwrap();
    let system = System::new(
        Time::Continuous,
        &strings(&["x", "y"]),
        &strings(&["u"]),
        &[library.clone(), library],
    )
    .unwrap();
    let c: Vec<f64> = (0..10).map(|k| 0.3 * (f64::from(k) * 1.7).sin()).collect();
    let run = |x: &[f64], c: &[f64], sensitive: bool| {
        let mut out = system.blank();
        let u = [&[0.2][..], &[0.3], &[0.4]];
        system.step(x, (0.05, u), sensitive, &mut system.work(c), &mut out);
        out
    };
    let x = [0.7, -0.4];
    let at = run(&x, &c, true);
    let e = 1e-6;
    for j in 0..2 {
        let mut moved = x;
        moved[j] += e;
        for i in 0..2 {
            let difference = (run(&moved, &c, false).state[i] - at.state[i]) / e;
            // Differences with 1e-6 are good to 1e-6; so is the fourth order at a step of 0.05.
            assert!((at.transition[(i, j)] - difference).abs() < 3e-6);
        }
    }
    for k in 0..10 {
        let mut moved = c.clone();
        moved[k] += e;
        for i in 0..2 {
            let difference = (run(&x, &moved, false).state[i] - at.state[i]) / e;
            assert!((at.forcing[(i, k)] - difference).abs() < 3e-6, "{i} {k}");
        }
    }
}

#[test]
fn analytic_joined_candidates_step_as_their_sums() {
    let library = Library::parse(&["x", "y", "x*y", "sin(x)"]).unwrap();
    let names = strings(&["x", "y"]);
    let libraries = [library.clone(), library];
    let sums = vec![
        vec![(1, 1.0), (4, -2.0)],
        vec![(2, 0.5), (7, 3.0), (4, 0.25)],
    ];
    for time in [Time::Continuous, Time::Discrete { period: 1.0 }] {
        let plain = System::new(time, &names, &[], &libraries).unwrap();
        let joined = plain.joined(&sums);
        assert_eq!((joined.size(), joined.groups.len()), (2, 1));
        let a = [0.7, -0.4];
        let matrix = DMatrix::from_fn(8, 2, |k, j| {
            let own = sums[j].iter().find(|(old, _)| *old == k);
            own.map_or(0.0, |(_, factor)| *factor)
        });
        let xi = &matrix * DVector::from_column_slice(&a);
        let run = |system: &System, c: &[f64]| {
            let mut out = system.blank();
            let u = [&[][..], &[], &[]];
            system.step(&[0.3, 0.8], (0.1, u), true, &mut system.work(c), &mut out);
            out
        };
        let (own, all) = (run(&joined, &a), run(&plain, xi.as_slice()));
        // Rounding.
        let off = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax();
        assert!(
            own.state
                .iter()
                .zip(&all.state)
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        assert!(off(&own.transition, &all.transition) < 1e-15);
        assert!(off(&own.forcing, &(&all.forcing * &matrix)) < 1e-15);
    }
}

/// Normal equations of random columns, the target being `ξ` on them plus noise.
fn random(seed: u64, n: usize, xi: &[f64], noise: f64) -> (DMatrix<f64>, DVector<f64>, f64) {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let x = DMatrix::from_fn(n, xi.len(), |_, _| rng.random_range(-1.0..1.0));
    let mut y = &x * DVector::from_column_slice(xi);
    y.iter_mut()
        .for_each(|v| *v += noise * rng.random_range(-1.0..1.0));
    (x.transpose() * &x, x.transpose() * &y, y.dot(&y))
}

#[test]
fn analytic_the_search_finds_planted_terms_from_any_start() {
    let truth = [0.0, 1.0, 0.0, -0.5, 0.0, 0.0, 0.25, 0.0];
    let (xtx, xty, yty) = random(1, 400, &truth, 0.1);
    for start in [[0.0; 8], [1.0; 8], [1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0]] {
        let xi = DVector::from_column_slice(&start);
        // What is left at the start.
        let xtr = &xty - &xtx * &xi;
        let rtr = yty - 2.0 * xi.dot(&xty) + xi.dot(&(&xtx * &xi));
        let mut search = Search::new(&xtx, &xtr, rtr, &xi);
        search.descend(0.1);
        let support: Vec<bool> = truth.iter().map(|c| *c != 0.0).collect();
        assert_eq!(search.support, support);
        for (found, truth) in search.coefficients().iter().zip(&truth) {
            // Noise of 0.06 on 400 rows of 0.58: standard errors of 0.005; four of them.
            assert!((found - truth).abs() < 0.02);
        }
    }
}

proptest! {
    #[test]
    fn prop_adding_and_dropping_in_any_order_is_least_squares(
        seed in 0u64..1000,
        moves in prop::collection::vec(0usize..6, 1..20),
        start in prop::collection::vec(-2.0..2.0f64, 6),
    ) {
        let (xtx, xty, yty) = random(seed, 40, &[0.3, 0.0, 1.0, -1.0, 0.0, 2.0], 0.2);
        let xi = DVector::from_column_slice(&start);
        let xtr = &xty - &xtx * &xi;
        let rtr = yty - 2.0 * xi.dot(&xty) + xi.dot(&(&xtx * &xi));
        let mut search = Search::new(&xtx, &xtr, rtr, &xi);
        for &j in &moves {
            let (before, change, add) = (search.residual(), search.change(j), !search.support[j]);
            search.toggle(j);
            let expected = if add { before - change } else { before + change };
            // Sums of order 100 of 40 rows.
            prop_assert!((search.residual() - expected).abs() < 1e-8);
        }
        let held: Vec<usize> = (0..6).filter(|&j| search.support[j]).collect();
        let a = xtx.select_rows(&held).select_columns(&held);
        let b = DVector::from_fn(held.len(), |i, _| xty[held[i]]);
        let solved = a.cholesky().unwrap().solve(&b);
        for (i, &j) in held.iter().enumerate() {
            prop_assert!((search.coefficients()[j] - solved[i]).abs() < 1e-8);
        }
        prop_assert!((search.residual() - (yty - solved.dot(&b))).abs() < 1e-8);
    }
}

#[test]
fn analytic_a_linear_decay_from_a_wrong_start() {
    let library = Library::parse(&["1", "x", "x^2", "x^3"]).unwrap();
    let system = System::new(Time::Continuous, &strings(&["x"]), &[], &[library]).unwrap();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
    let time: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
    let truth: Vec<f64> = time.iter().map(|t| 2.0 * (-1.5 * t).exp()).collect();
    let x: Vec<f64> = truth
        .iter()
        .map(|x| x + 0.02 * rng.random_range(-1.0..1.0))
        .collect();
    let piece = Piece {
        time: &time,
        states: vec![&x],
        inputs: vec![],
        between: vec![],
        weights: None,
        seen: Vec::new(),
        smooth: vec![truth.clone()],
    };
    let start = Start {
        colour: Vec::new(),
        signs: Vec::new(),
        coefficients: vec![0.5, -1.0, -0.3, 0.0],
        sigma: vec![0.012],
        floor: vec![1e-9],
        term_rms: vec![1.0; 4],
        chosen_from: 4,
    };
    let mut steps = 0;
    let found = search(&system, &[piece], &start, &Settings::default(), &mut |_| {
        steps += 1;
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    assert_eq!(steps, found.iterations);
    let kept: Vec<bool> = found.coefficients.iter().map(|c| *c != 0.0).collect();
    assert_eq!(kept, [false, true, false, false], "{found:?}");
    // Uniform noise of ±0.02 is 0.0115 in standard deviation; its estimate scatters by 4 %.
    assert!((found.sigma[0] / 0.01155 - 1.0).abs() < 0.12);
    assert!((found.coefficients[1] + 1.5).abs() < 4.0 * found.std_errors[1]);
    // Known closed form of the standard error to a factor: σ / √Σ(∂x/∂ξ)², the start being free as well.
    assert!(
        found.std_errors[1] > 1e-3 && found.std_errors[1] < 5e-3,
        "{:?}",
        found.std_errors
    );
    assert_eq!(found.fronts[0][1].support, [1]);
    assert!(found.fronts[0].iter().all(|p| p.proven));
    // N = 400 values, P = 4 candidates.
    let penalty = 400_f64.ln() + 2.0 * 4_f64.ln();
    assert!((found.penalty - penalty).abs() < 1e-12);
    // What the one term is worth is what its standard error says, which the noise is estimated in.
    let z = found.coefficients[1] / found.std_errors[1];
    assert!(((found.evidence[1] + penalty) / (z * z) - 1.0).abs() < 1e-6);
    // Uniform, independent noise.
    assert!(found.correlation < 1.6, "{}", found.correlation);
}

#[test]
fn analytic_the_penalty_counts_the_candidates_that_were_left_out_before() {
    let system = decay();
    let time: Vec<f64> = (0..100).map(|i| 0.02 * f64::from(i)).collect();
    let x: Vec<f64> = time.iter().map(|t| (-t).exp()).collect();
    let of = |chosen_from| {
        let piece = Piece {
            time: &time,
            states: vec![&x],
            inputs: vec![],
            between: vec![],
            weights: None,
            seen: Vec::new(),
            smooth: vec![x.clone()],
        };
        let start = Start {
            colour: Vec::new(),
            signs: Vec::new(),
            coefficients: vec![0.0, -1.0, 0.0, 0.0],
            sigma: vec![1e-3],
            floor: vec![1e-3],
            term_rms: vec![1.0; 4],
            chosen_from,
        };
        search(&system, &[piece], &start, &Settings::default(), &mut silent).unwrap()
    };
    let (own, of_thousand) = (of(4), of(1000));
    // 2 ln P, P = 1000 for 4: the rest is the same number.
    let more = 2.0 * 250_f64.ln();
    assert!((of_thousand.penalty - own.penalty - more).abs() < 1e-12);
    assert!((own.evidence[1] - of_thousand.evidence[1] - more).abs() < 1e-6 * own.evidence[1]);
}

/// `x'` of a cubic in x.
fn decay() -> System {
    let library = Library::parse(&["1", "x", "x^2", "x^3"]).unwrap();
    System::new(Time::Continuous, &strings(&["x"]), &[], &[library]).unwrap()
}

/// `x' = -1.5 x` without noise, from a start, with noise that is believed to be `floor` at least.
fn exact_decay(coefficients: [f64; 4], floor: f64) -> Option<OutputErrorFit> {
    let system = decay();
    let time: Vec<f64> = (0..200).map(|i| 0.02 * f64::from(i)).collect();
    let x: Vec<f64> = time.iter().map(|t| 2.0 * (-1.5 * t).exp()).collect();
    let piece = Piece {
        time: &time,
        states: vec![&x],
        inputs: vec![],
        between: vec![],
        weights: None,
        seen: Vec::new(),
        smooth: vec![x.clone()],
    };
    let start = Start {
        colour: Vec::new(),
        signs: Vec::new(),
        coefficients: coefficients.to_vec(),
        sigma: vec![floor],
        floor: vec![floor],
        term_rms: vec![1.0; 4],
        chosen_from: 4,
    };
    search(&system, &[piece], &start, &Settings::default(), &mut silent)
}

#[test]
fn analytic_no_more_is_believed_than_the_floor_of_the_noise() {
    let [a, b] = [1e-3, 2e-3].map(|f| exact_decay([0.0, -1.4, 0.0, 0.0], f).unwrap());
    assert_eq!((a.sigma[0], b.sigma[0]), (1e-3, 2e-3));
    // Residuals are those of the integrator, far below either; standard errors are in proportion to the floor.
    assert!((b.std_errors[1] / a.std_errors[1] - 2.0).abs() < 1e-3);
    assert!(a.std_errors[1] > 1e-4, "{:?}", a.std_errors);
    for found in [a, b] {
        let kept: Vec<bool> = found.coefficients.iter().map(|c| *c != 0.0).collect();
        assert_eq!(kept, [false, true, false, false]);
    }
}

#[test]
fn analytic_terms_are_exchanged_where_neither_adding_nor_dropping_helps() {
    // y = a x₁, and x₂ at a small angle to x₁: from x₂, adding x₁ gains half a penalty, dropping x₂ costs hundreds.
    let (a, angle) = (30.0_f64, 0.5_f64.sqrt() / 30.0);
    let (cos, sin) = (angle.cos(), angle.sin());
    let xtx = DMatrix::from_row_slice(2, 2, &[1.0, cos, cos, 1.0]);
    let xty = DVector::from_vec(vec![a, a * cos]);
    let xi = DVector::from_vec(vec![0.0, a * cos]);
    let xtr = &xty - &xtx * &xi;
    let mut search = Search::new(&xtx, &xtr, (a * sin).powi(2), &xi);
    assert_eq!(search.support, [false, true]);
    assert!(search.change(0) < 1.0 && search.change(1) > 100.0);
    search.descend(1.0);
    assert_eq!(search.support, [true, false]);
    assert!((search.coefficients()[0] - a).abs() < 1e-9 && search.residual() < 1e-9);
}

#[test]
fn prop_nothing_is_proven_where_terms_were_screened() {
    for (terms, proven) in [(10, true), (40, false)] {
        let mut truth = vec![0.0; terms];
        (truth[1], truth[4]) = (1.0, -1.0);
        let (xtx, xty, yty) = random(2, 500, &truth, 0.1);
        let xi = DVector::zeros(terms);
        let mut search = Search::new(&xtx, &xty, yty, &xi);
        search.descend(0.1);
        let members: Vec<usize> = (0..terms).collect();
        let front = search.front(&members, 500);
        assert!(front.len() > 3);
        assert!(
            front.iter().all(|p| p.proven == proven),
            "{terms}: {front:?}"
        );
    }
}

#[test]
fn prop_every_change_of_the_search_keeps_the_signs_and_foresees_them() {
    let signs = [
        Sign::Negative,
        Sign::Any,
        Sign::Positive,
        Sign::Negative,
        Sign::Positive,
        Sign::Any,
    ];
    for seed in 0..40 {
        let (xtx, xty, yty) = random(seed, 30, &[0.3, -0.4, -0.2, 0.2, 0.3, 0.1], 1.0);
        let xi = DVector::from_vec(vec![0.2, -0.3, 0.0, 0.1, 0.2, 0.0]);
        let xtr = &xty - &xtx * &xi;
        let rtr = yty - 2.0 * xty.dot(&xi) + xi.dot(&(&xtx * &xi));
        let mut search = Search::new(&xtx, &xtr, rtr, &xi).with_signs(&signs);
        let holds = |search: &Search| {
            let found = search.coefficients();
            signs.iter().zip(found.iter()).all(|(s, c)| s.allows(*c))
        };
        assert!(holds(&search));
        for j in 0..signs.len() {
            let foreseen = search.keeps_signs(j);
            let mut after = search.clone();
            after.toggle(j);
            assert_eq!(foreseen, holds(&after), "{seed} {j}");
        }
        search.descend(0.5);
        assert!(holds(&search));
        search.exact(&[(0..6).collect()], 0.5, 30);
        assert!(holds(&search));
    }
}

/// Two searches from points that the same steps lead away from.
#[test]
fn prop_searches_meet_at_the_same_terms_and_coefficients() {
    let at = |longest: usize, coefficients: [f64; 3]| Settled {
        longest,
        coefficients: coefficients.to_vec(),
        std_errors: vec![0.2, 0.0, 0.1],
    };
    let here = at(16, [1.0, 0.0, -2.0]);
    // A tenth of a standard error.
    assert!(here.meets(&at(16, [1.019, 0.0, -2.009])));
    assert!(!here.meets(&at(16, [1.021, 0.0, -2.0])));
    assert!(!here.meets(&at(16, [1.0, 1e-9, -2.0])));
    assert!(!here.meets(&at(64, [1.0, 0.0, -2.0])));
}
