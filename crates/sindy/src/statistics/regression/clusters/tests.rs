use rand::{RngExt, SeedableRng};

use super::super::least_squares;
use super::*;
use crate::{Library, Samples};

#[test]
fn analytic_cluster_errors_grow_with_correlation_inside_groups() {
    // y = 1 + e_g: one draw for each group of 100 rows. The error of the mean is sd/√groups, not
    // sd/√rows.
    let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
    let mut samples = Samples::new(&["y"]);
    let draws: Vec<f64> = (0..40).map(|_| rng.random_range(-1.0..1.0)).collect();
    for d in &draws {
        samples.push_group(vec![vec![1.0 + d; 100]]).unwrap();
    }
    let library = Library::parse(&["1"]).unwrap();
    let grams = Gram::accumulate(&library, "y", &samples).unwrap();
    let xi = least_squares(&Gram::total(&grams), &[true]);
    let se = cluster_errors(&grams, &xi, &[true]).unwrap()[0];
    let mean = draws.iter().sum::<f64>() / 40.0;
    let sd = (draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 39.0).sqrt();
    // With equal groups the sandwich is sd/√groups exactly.
    assert!((se - sd / 40f64.sqrt()).abs() < 1e-12, "{se}");
    assert!(cluster_errors(&grams[..1], &xi, &[true]).is_none());
    let two = Library::parse(&["1", "y^2"]).unwrap();
    let two = Gram::accumulate(&two, "y", &samples).unwrap();
    let flat = DVector::from_vec(vec![1.0, 0.0]);
    assert!(cluster_errors(&two[..2], &flat, &[true; 2]).is_none());
    assert!(cluster_errors(&two[..3], &flat, &[true; 2]).is_some());
}

/// Terms of the draws, the first few of which are fitted.
const TERMS: [&str; 8] = ["1", "a", "b", "c", "a*b", "a^2", "b^2", "c^2"];

/// A draw of `y = 0` on the first `k` terms: statistics by group, and the least squares. Noise wanders, with a correlation
/// of 0.95 from row to row: inside groups that each have columns of their own, or (`one`) through one record that is cut
/// into groups.
fn draw(seed: u64, groups: usize, k: usize, one: bool) -> (Vec<Gram>, DVector<f64>) {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    // Sums of twelve uniform draws are as good as normal here.
    let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let rows = 60;
    let mut samples = Samples::new(&["a", "b", "c", "y"]);
    let steady = 1.0 / (1.0_f64 - 0.95 * 0.95).sqrt();
    let mut noise = steady * normal();
    let mut shape: Vec<f64> = (0..9).map(|_| normal()).collect();
    for g in 0..groups {
        if !one && g > 0 {
            noise = steady * normal();
            shape = (0..9).map(|_| normal()).collect();
        }
        let column = |k: usize, i: usize| {
            let (mean, swing, w) = (shape[3 * k], shape[3 * k + 1], shape[3 * k + 2]);
            match one {
                true => (0.13 / (k + 1) as f64 * (g * rows + i) as f64 + 3.0 * mean).sin(),
                false => 0.7 * mean + swing * (0.1 * (1.0 + w.abs()) * i as f64).sin(),
            }
        };
        let mut columns = vec![Vec::new(); 4];
        for i in 0..rows {
            noise = 0.95 * noise + normal();
            (0..3).for_each(|k| columns[k].push(column(k, i)));
            columns[3].push(noise);
        }
        samples.push_group(columns).unwrap();
    }
    let library = Library::parse(&TERMS[..k]).unwrap();
    let grams = Gram::accumulate(&library, "y", &samples).unwrap();
    let xi = least_squares(&Gram::total(&grams), &vec![true; k]);
    (grams, xi)
}

/// The share of coefficients over all draws whose interval holds 0.
fn coverage(
    (groups, k, one): (usize, usize, bool),
    draws: u64,
    interval: impl Fn(&[Gram], &DVector<f64>, usize) -> [f64; 2],
) -> f64 {
    let mut hits = 0;
    for seed in 0..draws {
        let (grams, xi) = draw(seed, groups, k, one);
        let holds = |j: &usize| {
            let [low, high] = interval(&grams, &xi, *j);
            low <= 0.0 && 0.0 <= high
        };
        hits += (0..k).filter(holds).count();
    }
    hits as f64 / (draws as usize * k) as f64
}

#[test]
fn analytic_intervals_cover_what_they_say() {
    for (groups, k) in [(10, 4), (10, 8), (12, 6), (37, 8)] {
        let clusters = Clusters {
            groups,
            coefficients: k,
        };
        let share = coverage((groups, k, false), 400, |grams, xi, j| {
            let errors = cluster_errors(grams, xi, &vec![true; k]).unwrap();
            clusters.interval(xi[j], errors[j]).unwrap()
        });
        // 400 draws of a share of 0.95 scatter by 0.011 where all coefficients of a draw go together.
        assert!(
            (0.92..=0.995).contains(&share),
            "{groups} groups, {k} terms: {share}"
        );
    }
}

#[test]
fn analytic_errors_over_few_groups_cover_95_percent() {
    let cases = [
        (5, 1, true),
        (5, 3, true),
        (5, 4, false),
        (8, 4, true),
        (10, 8, false),
        (20, 6, false),
    ];
    for case in cases {
        let all = vec![true; case.1];
        let share = coverage(case, 1000, |grams, xi, j| {
            let found = ClusterErrors::new(grams, xi, &all).unwrap();
            found.interval(j, xi[j]).unwrap()
        });
        // 1000 draws of a share of 0.95 scatter by 0.007 where all coefficients of a draw go together: three of them.
        assert!((share - 0.95).abs() < 0.021, "{case:?}: {share}");
        if case.0 == 5 {
            let naive = coverage(case, 1000, |grams, xi, j| {
                let half = 1.96 * cluster_errors(grams, xi, &all).unwrap()[j];
                [xi[j] - half, xi[j] + half]
            });
            assert!(naive < 0.9, "{case:?}: {naive}");
        }
    }
}

#[test]
fn analytic_equal_groups_have_the_error_and_degrees_of_a_mean() {
    // The mean of 8 groups of one row each: sd/√8 with 7 degrees of freedom, exactly.
    let y = [0.3, -1.2, 0.8, 2.0, -0.4, 0.1, 1.5, -0.9];
    let mut samples = Samples::new(&["y"]);
    for y in y {
        samples.push_group(vec![vec![y]]).unwrap();
    }
    let library = Library::parse(&["1"]).unwrap();
    let grams = Gram::accumulate(&library, "y", &samples).unwrap();
    let xi = least_squares(&Gram::total(&grams), &[true]);
    let found = ClusterErrors::new(&grams, &xi, &[true]).unwrap();
    let mean = y.iter().sum::<f64>() / 8.0;
    let sd = (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 7.0).sqrt();
    // Rounding of eight numbers.
    assert!(
        (found.std_errors[0] - sd / 8f64.sqrt()).abs() < 1e-12,
        "{found:?}"
    );
    assert!((found.degrees[0] - 7.0).abs() < 1e-9, "{found:?}");
    let [low, high] = found.interval(0, xi[0]).unwrap();
    // Student's t with 7 degrees of freedom at 97.5 %: 2.364624 (tables).
    assert!(((high - low) / 2.0 - 2.364_624 * sd / 8f64.sqrt()).abs() < 1e-6);
    assert!(found.interval(1, 0.0).is_none());
    assert!(ClusterErrors::new(&grams[..1], &xi, &[true]).is_none());
}

#[test]
fn prop_a_group_that_alone_carries_a_term_is_no_certainty() {
    // `b` moves in one group only, which leaves no residual along it.
    let mut samples = Samples::new(&["b", "y"]);
    for g in 0..6 {
        let b = (0..20)
            .map(|i| if g == 2 { f64::from(i).sin() } else { 0.0 })
            .collect();
        let y = (0..20)
            .map(|i| (f64::from(i * i + g) * 1.7).sin())
            .collect();
        samples.push_group(vec![b, y]).unwrap();
    }
    let library = Library::parse(&["b"]).unwrap();
    let grams = Gram::accumulate(&library, "y", &samples).unwrap();
    let xi = least_squares(&Gram::total(&grams), &[true]);
    let found = ClusterErrors::new(&grams, &xi, &[true]).unwrap();
    assert!(found.degrees[0] == 0.0 && found.std_errors[0].is_nan());
    assert!(found.interval(0, xi[0]).is_none());
}

#[test]
fn analytic_students_t_at_the_ends() {
    // Tables: 12.7062 for one degree of freedom, 1.95996 without end.
    assert!((student_95(1.0) - 12.706_205).abs() < 1e-4);
    assert!((student_95(f64::INFINITY) - 1.959_964).abs() < 1e-6);
    // SciPy 1.17.1, stats.t.ppf(0.975, 2000).
    assert!((student_95(2000.0) - 1.961_150_8).abs() < 1e-6);
    // The expansion meets the law where it takes over.
    assert!((student_95(999.9) - student_95(1000.1)).abs() < 1e-5);
    assert!(student_95(0.0).is_nan() && student_95(f64::NAN).is_nan());
}

#[test]
fn analytic_interval_by_the_tables() {
    let clusters = |groups, coefficients| Clusters {
        groups,
        coefficients,
    };
    // Student's t with 5 degrees of freedom at 97.5 %: 2.570582 (tables); √(5/4) for two coefficients.
    let [low, high] = clusters(6, 2).interval(1.0, 0.1).unwrap();
    let half = 0.257_058_2 * 1.25_f64.sqrt();
    assert!((high - 1.0 - half).abs() < 1e-6 && (1.0 - low - half).abs() < 1e-6);
    assert!(clusters(2, 2).interval(1.0, 0.1).is_none());
    assert!(clusters(1, 2).interval(1.0, 0.1).is_none());
    assert!(clusters(6, 2).interval(1.0, f64::NAN).is_none());
}
