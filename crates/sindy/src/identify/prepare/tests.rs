use rand::{RngExt, SeedableRng};

use super::*;
use crate::identify::known::KnownPart;
use crate::identify::regress::of_slopes;
use crate::library::Library;
use crate::statistics::regression::least_squares;

/// A data set of one state in runs of so many rows with so much uniform noise.
fn runs(of: &[(usize, f64)]) -> Dataset {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    for &(rows, noise) in of {
        let time: Vec<f64> = (0..rows).map(|i| 0.01 * i as f64).collect();
        let x = time
            .iter()
            .map(|t| (3.0 * t).sin() + noise * rng.random_range(-1.0..1.0))
            .collect();
        data.push("run", time, vec![x], None).unwrap();
    }
    data
}

#[test]
fn analytic_the_noise_is_that_of_the_middle_trajectory() {
    let data = runs(&[(400, 0.01), (400, 0.01), (400, 1.0)]);
    let found = noise(&data.stretches(), 1);
    // Uniform noise of ±0.01 is 0.00577, the larger estimate of two; that of the loud run is a hundred times as much.
    assert!((0.004..0.012).contains(&found.sigma[0]), "{found:?}");
    assert_eq!(found.tolerated[0], found.sigma[0]);
    assert!(found.floor[0] < 1e-5);
}

#[test]
fn prop_pieces_keep_to_the_rows_that_are_asked_for() {
    let data = runs(&[(3000, 0.01), (40, 0.01), (900, 0.01)]);
    let stretches = data.stretches();
    let slopes = with(&stretches, 1, FiniteDifference::new(2).unwrap().into()).unwrap();
    for most in [100, 500, 1999, 2500] {
        let found = pieces(&stretches, 1, &slopes, &[], most);
        let longest = found.iter().map(|p| p.time.len()).max().unwrap();
        let rows: usize = found.iter().map(|p| p.time.len()).sum();
        // A piece is never longer than all of them may be; their number is rounded up by one.
        assert!(longest <= most.min(2000), "{most}: {longest}");
        assert!(rows <= 2 * most && 2 * rows >= most, "{most}: {rows}");
        assert_eq!(found[0].time[0], 0.0);
    }
    let all = pieces(&stretches, 1, &slopes, &[], 5000);
    assert_eq!(all.len(), 3);
}

#[test]
fn analytic_regressions_weigh_their_rows() {
    // x' = 2 in rows of weight 3, x' = 1 in those of weight 1.
    let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
    let x: Vec<f64> = time
        .iter()
        .map(|t| if *t < 1.0 { 2.0 * t } else { t + 1.0 })
        .collect();
    let weights = time.iter().map(|t| if *t < 1.0 { 3.0 } else { 1.0 });
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    data.push("run", time.clone(), vec![x], Some(weights.collect()))
        .unwrap();
    let stretches = data.stretches();
    let slopes = with(&stretches, 1, FiniteDifference::new(2).unwrap().into()).unwrap();
    let library = Library::parse(&["1"]).unwrap();
    let found = of_slopes(
        &data,
        &stretches,
        &[(library, KnownPart::default())],
        &slopes,
        4,
    )
    .unwrap();
    let slope = least_squares(&crate::Gram::total(&found.grams[0]), &[true])[0];
    // (3 · 2 + 1)/4, but for the one row in between.
    assert!((slope - 1.75).abs() < 0.01, "{slope}");
}
