use super::*;
use crate::derivative::tests::signals::{Column, gauss, lorenz_rhs, simulate};

type System = (&'static str, Vec<f64>, Vec<Column>);

fn systems(n: usize) -> [System; 3] {
    let (t1, lorenz) = simulate(lorenz_rhs, [-8.0, 7.0, 27.0], n, 0.002);
    let vdp = |[x, y]: [f64; 2]| [y, 2.0 * (1.0 - x * x) * y - x];
    let (t2, vdp) = simulate(vdp, [1.0, 0.0], n, 0.01);
    let lv = |[x, y]: [f64; 2]| [2.0 / 3.0 * x - 4.0 / 3.0 * x * y, x * y - y];
    let (t3, lv) = simulate(lv, [1.8, 1.3], n, 0.01);
    [
        ("Lorenz", t1, lorenz),
        ("Van der Pol", t2, vdp),
        ("Lotka-Volterra", t3, lv),
    ]
}

fn spread(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
}

/// Root mean square error of the slope away from the ends, with a filter.
fn slope_error(filter: SavitzkyGolay, t: &[f64], y: &[f64], truth: &[f64]) -> f64 {
    let h = filter.window() / 2;
    let out = filter.apply(t, y).unwrap().derivative;
    let inner = h..y.len() - h;
    let sum: f64 = inner.clone().map(|i| (out[i] - truth[i]).powi(2)).sum();
    (sum / inner.len() as f64).sqrt()
}

/// The choice against the best of all filters that were tried (degrees 2 to 8, windows 12 % apart), found with the
/// truth.
///
/// Measured (worst of the states and of three seeds; 5000 samples, 1 / 5 / 10 / 20 % noise):
/// Lorenz 1.00 / 1.03 / 1.11 / 1.10, Van der Pol 1.00 / 1.10 / 1.06 / 1.04,
/// Lotka-Volterra 1.06 / 1.01 / 1.03 / 1.09.
#[test]
fn analytic_slope_error_is_close_to_the_best_window_with_the_truth() {
    let search = SavgolSearch::default();
    for (name, t, states) in systems(5000) {
        for percent in [1.0, 5.0, 10.0, 20.0] {
            let mut worst = 1.0f64;
            for seed in 0..3 {
                for (k, (x, dx)) in states.iter().enumerate() {
                    let sigma = 0.01 * percent * spread(x);
                    let noise = gauss(100 * seed + k as u64, x.len());
                    let y: Vec<f64> = x.iter().zip(noise).map(|(x, e)| x + sigma * e).collect();
                    let choice = choose_savgol(&[(&t, &y)], &search).unwrap();
                    let ours = slope_error(choice.filter, &t, &y, dx);
                    let best = choice
                        .candidates
                        .iter()
                        .map(|c| slope_error(c.filter, &t, &y, dx))
                        .fold(f64::INFINITY, f64::min);
                    worst = worst.max(ours / best);
                    // The estimate of the error itself: noise level (3 %) and pilot.
                    assert!(
                        (choice.slope_error / ours).ln().abs() < 0.4,
                        "{choice}: {ours}"
                    );
                }
            }
            assert!(worst < 1.3, "{name}, {percent} %: {worst}");
        }
    }
}

#[test]
fn prop_without_noise_the_slope_is_as_good_as_differences() {
    for (name, t, states) in systems(2000) {
        let (x, dx) = &states[0];
        let choice = choose_savgol(&[(&t, x)], &SavgolSearch::default()).unwrap();
        // A smooth signal sampled this finely: at least five digits.
        let error = slope_error(choice.filter, &t, x, dx);
        assert!(error < 1e-5 * spread(dx), "{name} {choice} {error}");
    }
}

#[test]
fn prop_trajectories_share_a_window_and_short_or_flat_ones_are_no_trap() {
    let [(_, t, lorenz), ..] = systems(5000);
    let y: Vec<f64> = lorenz[1]
        .0
        .iter()
        .zip(gauss(1, 5000))
        .map(|(x, e)| x + e)
        .collect();
    let search = SavgolSearch::default();
    let whole = choose_savgol(&[(&t, &y)], &search).unwrap();
    let parts: Vec<(&[f64], &[f64])> = t.chunks(1000).zip(y.chunks(1000)).collect();
    let parted = choose_savgol(&parts, &search).unwrap();
    // The same data less the ends: a neighbouring window.
    let ratio = parted.filter.window() as f64 / whole.filter.window() as f64;
    assert!((0.75..1.35).contains(&ratio), "{whole} {parted}");
    assert_eq!(whole.reason, SavgolReason::Balance);

    for n in [25, 30, 60] {
        let choice = choose_savgol(&[(&t[..n], &y[..n])], &search).unwrap();
        assert!(choice.slope_error.is_finite() && choice.filter.window() <= n);
        let flat = choose_savgol(&[(&t[..n], &vec![4.0; n])], &search).unwrap();
        assert_eq!(flat.reason, SavgolReason::NoNoise);
    }
}

#[test]
fn prop_a_window_cut_short_is_said() {
    let t: Vec<f64> = (0..3000).map(|i| 1e-3 * f64::from(i)).collect();
    let y: Vec<f64> = t
        .iter()
        .zip(gauss(2, 3000))
        .map(|(t, e)| t.sin() + 0.1 * e)
        .collect();
    let choice = choose_savgol(&[(&t, &y)], &SavgolSearch::new(&[2], 51).unwrap()).unwrap();
    assert_eq!(choice.reason, SavgolReason::LongestWindow);
    assert_eq!((choice.filter.window(), choice.edge), (51, 25));
}

#[test]
fn prop_bad_input_is_named() {
    assert!(SavgolSearch::new(&[], 99).is_err() && SavgolSearch::new(&[0], 99).is_err());
    assert!(SavgolSearch::new(&[2], 8).is_err());
    let search = SavgolSearch::default();
    let t: Vec<f64> = (0..50).map(f64::from).collect();
    let uneven: Vec<f64> = t.iter().map(|t| t * t).collect();
    let twice: Vec<f64> = t.iter().map(|t| 2.0 * t).collect();
    assert!(matches!(
        choose_savgol(&[], &search),
        Err(SindyError::TooShort { .. })
    ));
    let short = choose_savgol(&[(&t[..24], &t[..24])], &search);
    assert!(matches!(
        short,
        Err(SindyError::TooShort {
            needed: 25,
            found: 24
        })
    ));
    for series in [
        vec![(&uneven[..], &t[..])],
        vec![(&t[..], &t[..]), (&twice[..], &t[..])],
    ] {
        let refused = choose_savgol(&series, &search);
        assert!(matches!(
            refused,
            Err(SindyError::Setting { key: "time", .. })
        ));
    }
    // A degree that no window of this length carries.
    let steep = SavgolSearch::new(&[10], 99).unwrap();
    let refused = choose_savgol(&[(&t[..25], &t[..25])], &steep);
    assert!(matches!(
        refused,
        Err(SindyError::Setting { key: "degrees", .. })
    ));
}

#[test]
fn prop_a_search_among_one_degree_finds_it() {
    let t: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
    let y: Vec<f64> = t.iter().map(|t| (3.0 * t).sin()).collect();
    let search = SavgolSearch::default().degrees(&[6]).unwrap();
    let choice = choose_savgol(&[(&t, &y)], &search).unwrap();
    assert_eq!(choice.filter.degree(), 6);
    assert!(SavgolSearch::default().degrees(&[11]).is_err());
}
