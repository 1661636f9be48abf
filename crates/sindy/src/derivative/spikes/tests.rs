use super::*;
use crate::derivative::tests::signals::gauss;
use crate::problems;

fn rows(found: &[Spike]) -> Vec<usize> {
    found.iter().map(|s| s.row).collect()
}

/// A sine with noise.
fn wave(n: usize, sigma: f64) -> (Vec<f64>, Vec<f64>) {
    let time: Vec<f64> = (0..n).map(|i| 0.01 * i as f64).collect();
    let y = time.iter().zip(gauss(3, n));
    let y = y.map(|(t, e)| (3.0 * t).sin() + sigma * e).collect();
    (time, y)
}

#[test]
fn analytic_spikes_are_found_alone_in_pairs_and_near_ends() {
    for sigma in [0.0, 1e-4, 0.02] {
        let (time, clean) = wave(600, sigma);
        let mut y = clean.clone();
        let wrong = [0, 100, 200, 201, 300, 304, 314, 420, 421, 422, 592, 598];
        for (i, &k) in wrong.iter().enumerate() {
            y[k] += [3.0, -2.0, 5.0][i % 3];
        }
        let found = spikes(&time, &y).unwrap();
        assert_eq!(rows(&found), wrong, "{sigma}");
        for s in &found {
            // Noise of the neighbours and of the sample itself, amplified up to 16 times where the polynomial leaves
            // the record; without noise the polynomial's own error, at the ends a parabola's (third differences of
            // the wave: 3e-5).
            let tolerance = 1e-6 + 4.0 * sigma * if s.row > 3 && s.row < 596 { 3.0 } else { 16.0 };
            let tolerance = tolerance + if s.row > 3 && s.row < 596 { 0.0 } else { 1e-4 };
            assert!((s.value - clean[s.row]).abs() < tolerance, "{sigma}: {s:?}");
            assert!(s.distance > FAR);
        }
    }
}

#[test]
fn analytic_jumps_kinks_and_steps_of_resolution_are_no_spikes() {
    let (time, y) = wave(600, 0.0);
    let jump: Vec<f64> = (0..600)
        .map(|k| y[k] + if k > 300 { 4.0 } else { 0.0 })
        .collect();
    let kink: Vec<f64> = time.iter().map(|t| (t - 3.003).abs()).collect();
    let coarse: Vec<f64> = y.iter().map(|v| (v * 50.0).round() / 50.0).collect();
    let blip: Vec<f64> = (0..600)
        .map(|k| if k % 97 == 5 { 0.01 } else { 0.0 })
        .collect();
    let stairs: Vec<f64> = (0..600).map(|k| y[k / 3 * 3]).collect();
    let square: Vec<f64> = (0..600)
        .map(|k| if (k / 40) % 2 == 0 { 1.0 } else { -1.0 })
        .collect();
    for (name, y) in [
        ("jump", jump),
        ("kink", kink),
        ("coarse", coarse),
        ("blip", blip),
        ("stairs", stairs),
        ("square", square),
    ] {
        assert_eq!(rows(&spikes(&time, &y).unwrap()), [0; 0], "{name}");
    }
}

#[test]
fn prop_no_sample_of_a_known_problem_is_a_spike() {
    // 8 sigma: none is expected in any number of samples that a test can hold.
    for problem in problems::all() {
        for percent in [0.0, 0.01, 1.0, 5.0, 20.0] {
            for seed in 0..3 {
                for record in problem.noisy(percent, seed).unwrap() {
                    for (state, y) in problem.states.iter().zip(&record.states) {
                        let found = spikes(&record.time, y).unwrap();
                        assert!(
                            found.is_empty(),
                            "{}, {percent} %, {state}: {found:?}",
                            problem.name
                        );
                    }
                }
                if percent == 0.0 {
                    break;
                }
            }
        }
    }
}

#[test]
fn prop_few_constant_or_bad_samples() {
    let (time, y) = wave(24, 0.1);
    assert_eq!(spikes(&time, &y).unwrap(), []);
    assert!(spikes(&time, &[]).is_err());
    let (time, y) = wave(100, 0.1);
    assert_eq!(spikes(&time, &[2.5; 100]).unwrap(), []);
    assert!(matches!(
        spikes(&time, &y[1..]),
        Err(SindyError::Shape { .. })
    ));
    // More than 5 %: noise of another kind, or a signal that is like that.
    let (long, often) = wave(300, 0.1);
    let often = often.iter().enumerate();
    let often: Vec<f64> = often
        .map(|(k, v)| v + if k % 15 == 7 { 50.0 } else { 0.0 })
        .collect();
    assert_eq!(spikes(&long, &often).unwrap(), []);
    let mut huge = y.clone();
    huge[50] = 1e300;
    assert_eq!(rows(&spikes(&time, &huge).unwrap()), [50]);
}
