use super::ensemble::Ensembled;
use super::*;
use crate::model::{Inputs, Limits, Simulation, Term, Time};
use crate::statistics::gram::Accumulate;
use crate::{Gram, Library, Model, Samples, Solver, Stlsq};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};

/// `x_i = φ x_{i-1} + e_i`, with e uniform in ±1, after 200 steps to settle.
fn autoregression(rng: &mut rand_pcg::Pcg64, n: usize, phi: f64) -> Vec<f64> {
    let mut x = 0.0;
    let mut draw = || {
        x = phi * x + rng.random_range(-1.0..1.0);
        x
    };
    (0..200).for_each(|_| {
        draw();
    });
    (0..n).map(|_| draw()).collect()
}

#[test]
fn xval_block_lengths_of_arch() {
    // arch 8.0.0, `optimal_block_length(x)["circular"]`, on autoregressions driven by a linear congruential
    // generator.
    let mut s = 12345_u64;
    let e: Vec<f64> = (0..1200)
        .map(|_| {
            s = (1_103_515_245 * s + 12345) % (1 << 31);
            s as f64 / f64::from(1_u32 << 31) - 0.5
        })
        .collect();
    for (n, phi, expected) in [
        (1200, 0.8, 25.75945619926248),
        (300, 0.5, 9.13686728485304),
        (1200, 0.0, 2.64515698467316),
        (1000, -0.6, 19.44189595953379),
        (400, 0.97, 31.832190281178374),
    ] {
        let mut v = 0.0;
        let x: Vec<f64> = e[..n]
            .iter()
            .map(|e| {
                v = phi * v + e;
                v
            })
            .collect();
        let found = block_length(&[x]);
        // The same sums in another order.
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{n} {phi}: {found} {expected}"
        );
    }
}

#[test]
fn prop_block_lengths_of_odd_series_are_finite() {
    for series in [
        vec![],
        vec![vec![]],
        vec![vec![1.0]],
        vec![vec![2.0; 100]],
        vec![vec![f64::NAN; 50]],
        vec![vec![0.0, 1.0]],
    ] {
        assert_eq!(block_length(&series), 1.0, "{series:?}");
    }
    // Alternating: a long-run variance of nearly zero, and a bound.
    let zigzag: Vec<f64> = (0..100).map(|i| f64::from(i % 2)).collect();
    assert!((1.0..=30.0).contains(&block_length(&[zigzag])));
    // Parts that are not correlated with each other: nearly the length of one of them alone, for so many more rows.
    let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
    let parts: Vec<Vec<f64>> = (0..8).map(|_| autoregression(&mut rng, 500, 0.8)).collect();
    let all = block_length(&parts);
    // The theory for φ = 0.8: (1.5 (2 φ/(1 - φ²))²)^⅓ n^⅓ = 3.09 · 15.9; estimates scatter by a third.
    assert!((30.0..70.0).contains(&all), "{all}");
    let mut holes = parts.clone();
    holes.iter_mut().for_each(|p| p[100] = f64::NAN);
    assert!((block_length(&holes) / all - 1.0).abs() < 0.1);
}

#[test]
fn prop_intervals_cover_the_truth_under_correlated_noise() {
    let library = Library::parse(&["1", "x"]).unwrap();
    let truth = [1.0, 2.0];
    let (mut covered, mut naive) = ([0; 2], [0; 2]);
    let solver = on_support(vec![true; 2]);
    for seed in 0..200 {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut samples = Samples::new(&["x", "y"]);
        for _ in 0..4 {
            let x = autoregression(&mut rng, 500, 0.9);
            let noise = autoregression(&mut rng, 500, 0.8);
            let y = x
                .iter()
                .zip(noise)
                .map(|(x, e)| 1.0 + 2.0 * x + e)
                .collect();
            samples.push_group(vec![x, y]).unwrap();
        }
        let equation: (_, &dyn Solver) = (Accumulate::new(&library, "y"), &solver);
        let bootstrap = Bootstrap::new(300, seed).unwrap();
        let blocks = bootstrap.run(&[equation], &samples).unwrap().remove(0);
        let short = bootstrap.resampling(Resampling::Rows(5));
        let short = short.run(&[equation], &samples).unwrap().remove(0);
        for j in 0..2 {
            let inside = |e: &Ensembled| e.lower[j] <= truth[j] && truth[j] <= e.upper[j];
            covered[j] += usize::from(inside(&blocks.ensemble));
            naive[j] += usize::from(inside(&short.ensemble));
        }
    }
    for j in 0..2 {
        // 95 % intervals in 90 to 99 % of 200 draws (three standard deviations of 1.5 % about 95 %).
        assert!((180..=198).contains(&covered[j]), "{covered:?} {naive:?}");
    }
    // Blocks of five rows do not hold a correlation that lasts for some ten: they cover too rarely.
    assert!(naive.iter().all(|n| *n < 170), "{naive:?}");
}

#[test]
fn analytic_blocks_groups_and_limits_are_as_asked() {
    let library = Library::parse(&["1", "x"]).unwrap();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
    let mut samples = Samples::new(&["x", "y", "z"]);
    for _ in 0..30 {
        let x = autoregression(&mut rng, 50, 0.5);
        let shift: f64 = rng.random_range(-1.0..1.0);
        let y = x.iter().map(|x| 1.0 + 2.0 * x + shift).collect();
        let z = x
            .iter()
            .map(|x| -x + 0.1 * rng.random_range(-1.0..1.0))
            .collect();
        samples.push_group(vec![x, y, z]).unwrap();
    }
    let solver = on_support(vec![true; 2]);
    let y: (_, &dyn Solver) = (Accumulate::new(&library, "y"), &solver);
    let z: (_, &dyn Solver) = (Accumulate::new(&library, "z"), &solver);
    let bootstrap = Bootstrap::new(400, 5).unwrap();
    let rows = bootstrap
        .resampling(Resampling::Rows(20))
        .run(&[y], &samples)
        .unwrap();
    assert_eq!((rows[0].block_rows, rows[0].blocks), (20, 90));
    assert_eq!(rows[0].correlation_rows, None);
    let groups = bootstrap
        .resampling(Resampling::Groups)
        .run(&[y], &samples)
        .unwrap();
    assert_eq!((groups[0].block_rows, groups[0].blocks), (50, 30));
    let parts = Gram::accumulate(&library, "y", &samples).unwrap();
    let xi = &groups[0].fit.coefficients;
    let sandwich = crate::statistics::regression::cluster_errors(&parts, xi, &[true; 2]).unwrap();
    // 400 replicates give a standard error to 4 %, and 30 groups agree with their limit to some 10 %.
    assert!((groups[0].std_error[0] / sandwich[0] - 1.0).abs() < 0.25);
    // Shifts of whole groups are seen by groups, not by blocks of 20 rows.
    assert!(groups[0].std_error[0] > 1.3 * rows[0].std_error[0]);
    assert!(groups[0].ensemble.upper[0] > groups[0].ensemble.lower[0]);
    let narrow = bootstrap.level(0.5).unwrap().resampling(Resampling::Groups);
    let narrow = narrow.run(&[y], &samples).unwrap();
    let width = |i: &Intervals| i.ensemble.upper[0] - i.ensemble.lower[0];
    assert!(width(&narrow[0]) < 0.6 * width(&groups[0]));

    // Two equations are resampled alike, with the longer of the two blocks.
    let both = bootstrap.run(&[y, z], &samples).unwrap();
    assert_eq!(
        (both[0].block_rows, both[0].blocks),
        (both[1].block_rows, both[1].blocks)
    );
    assert_eq!(both[0].correlation_rows, both[1].correlation_rows);
    let alone = bootstrap.resampling(Resampling::Rows(both[0].block_rows));
    assert_eq!(
        alone.run(&[z], &samples).unwrap()[0].ensemble,
        both[1].ensemble
    );
    let select = Stlsq::new(0.02, 0.0).unwrap();
    let found = bootstrap
        .run(&[(z.0, &select)], &samples)
        .unwrap()
        .remove(0);
    assert_eq!(found.fit.support, [false, true]);
    assert_eq!(found.ensemble.inclusion[1], 1.0);
    assert!(found.ensemble.inclusion[0] < 0.5);

    let members = models(
        Time::Continuous,
        &["x", "v"],
        &[],
        &[(&library, &both[0]), (&library, &both[1])],
    )
    .unwrap();
    assert_eq!(members.len(), 400);
    let value = members[7].equations()[1][1].coefficient;
    assert_eq!(value, both[1].ensemble.coefficients[(1, 7)]);
    let other = Bootstrap::new(10, 1).unwrap().run(&[z], &samples).unwrap();
    let pair = [(&library, &both[0]), (&library, &other[0])];
    assert!(models(Time::Continuous, &["x", "v"], &[], &pair).is_err());
    assert!(
        models::<&str>(Time::Continuous, &[], &[], &[])
            .unwrap()
            .is_empty()
    );

    assert!(Bootstrap::new(1, 0).is_err() && bootstrap.level(0.0).is_err());
    assert!(
        bootstrap
            .resampling(Resampling::Rows(0))
            .run(&[y], &samples)
            .is_err()
    );
    let whole = bootstrap.resampling(Resampling::Rows(1_000_000));
    assert!(whole.run(&[y], &Samples::new(&["x", "y"])).is_err());
    let wrong = on_support(vec![true; 3]);
    assert!(bootstrap.run(&[(y.0, &wrong)], &samples).is_err());
    assert!(bootstrap.run(&[], &samples).unwrap().is_empty());
}

fn decay(k: f64) -> Model {
    let terms = vec![vec![Term::parse("x", -k).unwrap()]];
    Model::new(Time::Continuous, &["x"], &[], terms).unwrap()
}

#[test]
fn analytic_bands_of_decays() {
    // 41 rates, evenly spread: the 90 % band is between the third and the third last.
    let members: Vec<Model> = (0..41).map(|i| decay(1.0 + 0.01 * f64::from(i))).collect();
    let time: Vec<f64> = (0..11).map(|i| 0.1 * f64::from(i)).collect();
    let run = |m: &Model| m.simulate(&[1.0], &time, &Inputs::none(), &Simulation::adaptive());
    let band = Band::of_runs(&members, 0.9, run).unwrap();
    assert_eq!((band.finished(), band.members.clone()), (41, vec![41; 11]));
    for (k, t) in time.iter().enumerate() {
        for (found, rate) in [
            (&band.lower, 1.38),
            (&band.middle, 1.2),
            (&band.upper, 1.02),
        ] {
            // The integrator's tolerance of 1e-8 in each of some ten steps.
            assert!((found[0][k] - (-rate * t).exp()).abs() < 1e-6);
        }
    }
    let band = Band::of_predictions(&members, &[&[1.0, -2.0, f64::NAN]], 0.9).unwrap();
    // Products of two numbers of order one.
    assert!((band.lower[0][0] + 1.38).abs() < 1e-12 && (band.upper[0][0] + 1.02).abs() < 1e-12);
    assert!((band.lower[0][1] - 2.04).abs() < 1e-12 && (band.upper[0][1] - 2.76).abs() < 1e-12);
    assert!(band.lower[0][2].is_nan());
    assert_eq!(band.members, [41, 41, 0]);
    assert!(Band::of_predictions(&members[..1], &[&[1.0]], 0.9).is_err());
    assert!(Band::of_predictions(&members, &[&[1.0]], 1.0).is_err());
    assert!(Band::of_predictions(&members, &[], 0.9).is_err());
}

#[test]
fn analytic_members_that_blow_up_are_counted() {
    // x' = a x² from 1 blows up at 1/a: at 0.5 for two of five.
    let members: Vec<Model> = [0.1, 0.2, 0.3, 2.0, 2.0]
        .map(|a| {
            let terms = vec![vec![Term::parse("x^2", a).unwrap()]];
            Model::new(Time::Continuous, &["x"], &[], terms).unwrap()
        })
        .to_vec();
    let time: Vec<f64> = (0..11).map(|i| 0.1 * f64::from(i)).collect();
    let how = Simulation::adaptive().limits(Limits::default().blow_up_above(1e6));
    let run = |m: &Model| m.simulate(&[1.0], &time, &Inputs::none(), &how);
    let band = Band::of_runs(&members, 0.9, run).unwrap();
    assert_eq!((band.finished(), band.outcomes.len()), (3, 5));
    assert_eq!(band.lower[0].len(), 11);
    assert_eq!((band.members[4], band.members[6]), (5, 3));
    assert!(band.upper[0].iter().all(|v| v.is_finite()));
    // With three of five gone the band ends where they do.
    let more = [&members[1..], &members[3..4]].concat();
    let band = Band::of_runs(&more, 0.9, run).unwrap();
    assert!(
        (5..=6).contains(&band.lower[0].len()),
        "{}",
        band.lower[0].len()
    );
    let uneven = |m: &Model| {
        let end = 1.0 + m.equations()[0][0].coefficient;
        m.simulate(&[1.0], &[0.0, 0.1 * end], &Inputs::none(), &how)
    };
    assert!(Band::of_runs(&members, 0.9, uneven).is_err());
    let refused = |m: &Model| m.simulate(&[], &time, &Inputs::none(), &how);
    assert!(Band::of_runs(&members, 0.9, refused).is_err());
}

#[test]
fn analytic_band_of_a_covariance() {
    let library = Library::parse(&["1", "log(x)"]).unwrap();
    let xi = DVector::from_vec(vec![1.0, 2.0]);
    let covariance = DMatrix::from_row_slice(2, 2, &[0.04, -0.01, -0.01, 0.09]);
    let names = ["x".to_string()];
    let e = std::f64::consts::E;
    let band = Band::of_covariance(&library, &xi, &covariance, &names, &[&[1.0, e, -1.0]], 0.95);
    let band = band.unwrap();
    // z of 95 % is 1.959963984540054; variances 0.04 and 0.04 - 0.02 + 0.09.
    let z = 1.959963984540054;
    assert!((band.upper[0][0] - (1.0 + z * 0.2)).abs() < 1e-12);
    assert!((band.lower[0][1] - (3.0 - z * 0.11_f64.sqrt())).abs() < 1e-12);
    assert!(band.lower[0][2].is_nan() && band.middle[0][2].is_nan());
    for (p, z) in [
        (0.5, 0.0),
        (0.75, 0.6744897501960817),
        (0.995, 2.5758293035489004),
    ] {
        // Known to all digits; Newton's method ends at rounding.
        assert!((band::normal_quantile(p) - z).abs() < 1e-12, "{p}");
    }
    // 1 - 10⁻⁹: the difference from one has seven digits.
    assert!((band::normal_quantile(1.0) - 5.997807).abs() < 1e-5);
    let of = |c: &DMatrix<f64>, columns: &[&[f64]], level: f64| {
        Band::of_covariance(&library, &xi, c, &names, columns, level)
    };
    assert!(of(&DMatrix::zeros(3, 3), &[&[1.0]], 0.9).is_err());
    assert!(of(&covariance, &[&[1.0], &[1.0]], 0.9).is_err());
    assert!(of(&covariance, &[&[1.0]], 0.0).is_err());
    assert!(of(&covariance, &[&[]], 0.9).unwrap().middle[0].is_empty());
}

#[test]
fn prop_there_are_at_most_400_blocks() {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(12);
    let mut samples = Samples::new(&["x", "y"]);
    let x: Vec<f64> = (0..8000).map(|_| rng.random_range(-1.0..1.0)).collect();
    let y = x.iter().map(|x| x + rng.random_range(-1.0..1.0)).collect();
    samples.push_group(vec![x, y]).unwrap();
    let library = Library::parse(&["1", "x"]).unwrap();
    let solver = on_support(vec![true; 2]);
    let equation: (_, &dyn Solver) = (Accumulate::new(&library, "y"), &solver);
    let found = Bootstrap::new(10, 1).unwrap().run(&[equation], &samples);
    let found = found.unwrap().remove(0);
    // Independent rows ask for blocks of a few, of which there would be thousands.
    assert!(found.correlation_rows.unwrap() < 15.0, "{found:?}");
    assert_eq!((found.block_rows, found.blocks), (20, 400));
}

#[test]
fn prop_omitted_terms_are_missing_from_replicates_and_not_from_the_fit() {
    let x: Vec<f64> = (0..400).map(|i| (0.37 * f64::from(i)).sin()).collect();
    let y = x.iter().map(|x| 1.0 + 2.0 * x - x.powi(3)).collect();
    let mut samples = Samples::new(&["x", "y"]);
    samples.push_group(vec![x, y]).unwrap();
    let library = Library::parse(&["1", "x", "x^2", "x^3"]).unwrap();
    let solver = Stlsq::new(0.1, 0.0).unwrap();
    let equation = (Accumulate::new(&library, "y"), &solver as &dyn Solver);
    let bootstrap = Bootstrap::new(60, 3).unwrap().omit(1);
    let found = bootstrap.run(&[equation], &samples).unwrap().remove(0);
    assert_eq!(found.fit.terms(), 3);
    // Each replicate lacks one of four; none is offered always.
    assert_eq!(found.ensemble.offered.iter().sum::<usize>(), 60 * 3);
    assert!(found.ensemble.offered.iter().all(|n| *n < 60));
}
