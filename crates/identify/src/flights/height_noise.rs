//! Noise of measured heights, and the bias that it makes in a fit along them.

use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;

use super::fit::{Fit, fit};
use super::model::Segment;
use crate::thrust::plateau::median;

/// Fits with added noise, over which the mean is taken: it halves what the noise moves at random. Each takes a fit's time.
const DRAWS: usize = 4;

/// White noise of the measured heights (m), standard deviation, from their third differences: motion hardly moves those.
///
/// The median of their amounts is 0.6745 standard deviations of normal noise, and their variance is 1 + 9 + 9 + 1 times
/// that of a height.
pub(super) fn noise_of_heights(pieces: &[Segment]) -> f64 {
    let thirds = pieces.iter().flat_map(|p| {
        let known: Vec<f64> = p
            .range_m
            .iter()
            .copied()
            .filter(|z| z.is_finite())
            .collect();
        let third = |w: &[f64]| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs();
        known.windows(4).map(third).collect::<Vec<f64>>()
    });
    median(thirds).map_or(0.0, |m| m / (0.6745 * 20.0_f64.sqrt()))
}

/// The numbers of a fit with twice the variance of noise in its heights, and the same disturbance. By what they move, noise
/// of the heights has moved them already (J. R. Cook and L. A. Stefanski, J. Am. Stat. Assoc. 89, 1994). A fit that does not
/// converge counts as far as it came: numbers that move far have wide intervals.
pub(super) fn with_twice_the_noise(
    found: &Fit,
    pieces: &[Segment],
    noise_radii: f64,
    seed: u64,
) -> Vec<f64> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut mean = vec![0.0; found.theta.len()];
    for _ in 0..DRAWS {
        let of_piece = |p| noisier(p, noise_radii, &mut random);
        let noisy: Vec<Segment> = pieces.iter().map(of_piece).collect();
        let again = fit(&noisy, found.shape, Some(found)).settled(&noisy);
        for (mean, value) in mean.iter_mut().zip(again.theta) {
            *mean += value / DRAWS as f64;
        }
    }
    mean
}

/// A segment with noise added where its height was measured, held in between.
fn noisier(piece: &Segment, noise_radii: f64, random: &mut Pcg64) -> Segment {
    let mut noise = 0.0;
    let heights = piece.height.iter().zip(&piece.range_m).map(|(z, range)| {
        if range.is_finite() {
            let white: f64 = StandardNormal.sample(random);
            noise = noise_radii * white;
        }
        z + noise
    });
    Segment {
        height: heights.collect(),
        ..piece.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flights::drift::Drift;

    #[test]
    fn analytic_noise_of_heights_beside_their_motion() {
        let mut random = Pcg64::seed_from_u64(1);
        let range = (0..3000).map(|i| {
            let t = 0.02 * f64::from(i);
            let new: f64 = StandardNormal.sample(&mut random);
            // Every other row has no height.
            if i % 2 == 1 {
                f64::NAN
            } else {
                0.3 + 0.1 * (2.0 * t).sin() + 0.004 * new
            }
        });
        let piece = Segment {
            flight: 0,
            run: 0,
            time_s: Vec::new(),
            throttle: Vec::new(),
            logged_throttle: Vec::new(),
            height: Vec::new(),
            climb_mps: Vec::new(),
            drift: Drift::Unknown,
            on_s: None,
            force: Vec::new(),
            accelerometer: true,
            range_m: range.collect(),
            climb_measured_mps: Vec::new(),
            tilt_rad: Vec::new(),
            rows: Vec::new(),
            bias_sd: 1.0,
        };
        // 1500 correlated differences give it to some per cent; the motion adds 0.1 (2 × 0.04)³/√2/√20 = 0.01 mm.
        let found = noise_of_heights(&[piece]);
        assert!((found - 0.004).abs() < 0.0004, "{found}");
    }
}
