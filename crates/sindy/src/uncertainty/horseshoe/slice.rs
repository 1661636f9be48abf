//! Slice sampling of one number: draws that keep a density invariant, without a step size to tune.
//!
//! Source: R. M. Neal, "Slice sampling", Annals of Statistics 31 (2003), figures 3 and 5.

use rand::RngExt;
use rand_pcg::Pcg64;

/// The height of the slice, in logarithms: uniform below the density at the present point.
fn level(log_density: f64, rng: &mut Pcg64) -> f64 {
    // In (0, 1], so that the logarithm is finite.
    log_density + (1.0 - rng.random::<f64>()).ln()
}

/// The next draw after `at`, from a slice inside fixed ends. Leaves the density cut off at these ends invariant, whatever the
/// number of its modes: every mode is in reach of every other.
pub(super) fn between(
    ends: (f64, f64),
    at: f64,
    log_density: impl Fn(f64) -> f64,
    rng: &mut Pcg64,
) -> f64 {
    let level = level(log_density(at), rng);
    shrink(ends, at, level, log_density, rng)
}

/// The next draw after `at`, from a slice whose ends are stepped out by `width` until the density is below it.
pub(super) fn stepping_out(
    width: f64,
    at: f64,
    log_density: impl Fn(f64) -> f64,
    rng: &mut Pcg64,
) -> f64 {
    let level = level(log_density(at), rng);
    let mut low = at - width * rng.random::<f64>();
    let mut high = low + width;
    while log_density(low) > level {
        low -= width;
    }
    while log_density(high) > level {
        high += width;
    }
    shrink((low, high), at, level, log_density, rng)
}

/// Draws inside the ends until a draw is in the slice; each one that is not becomes an end.
fn shrink(
    (mut low, mut high): (f64, f64),
    at: f64,
    level: f64,
    log_density: impl Fn(f64) -> f64,
    rng: &mut Pcg64,
) -> f64 {
    loop {
        let next = low + (high - low) * rng.random::<f64>();
        // Ends that no number separates have met at the present point.
        if !(low < next && next < high) {
            return at;
        }
        if log_density(next) >= level {
            return next;
        }
        if next < at {
            low = next;
        } else {
            high = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::resample::generator;

    /// Mean and variance of draws one after the other.
    fn moments(mut next: impl FnMut(f64) -> f64, draws: usize) -> (f64, f64) {
        let (mut x, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for _ in 0..draws {
            x = next(x);
            sum += x;
            squares += x * x;
        }
        let n = draws as f64;
        (sum / n, squares / n - (sum / n).powi(2))
    }

    #[test]
    fn analytic_moments_of_a_normal_and_of_two_separate_modes() {
        let n = 40_000;
        let mut rng = generator(1, 0);
        let normal = |x: f64| -0.5 * (x - 1.0).powi(2) / 4.0;
        let (mean, variance) = moments(|x| stepping_out(1.0, x, normal, &mut rng), n);
        // Five standard errors of 40 000 draws whose autocorrelation time is about 2: 2/√20 000 and 4·√(2/20 000).
        assert!((mean - 1.0).abs() < 0.071, "{mean}");
        assert!((variance - 4.0).abs() < 0.2, "{variance}");
        // Half of the mass at -10 and half at 10, with nothing between: the fixed ends reach both.
        let twice = |x: f64| -0.5 * (x.abs() - 10.0).powi(2);
        let (mean, variance) = moments(|x| between((-20.0, 20.0), x, twice, &mut rng), n);
        // The side changes about every third draw: standard error 10/√(40 000/5) = 0.11, five of them.
        assert!(mean.abs() < 0.56, "{mean}");
        assert!((variance - 101.0).abs() < 1.0, "{variance}");
    }

    #[test]
    fn prop_a_density_of_one_point_keeps_the_point() {
        let mut rng = generator(2, 0);
        let spike = |x: f64| if x == 0.25 { 0.0 } else { f64::NEG_INFINITY };
        assert_eq!(between((0.0, 1.0), 0.25, spike, &mut rng), 0.25);
        assert_eq!(stepping_out(1.0, 0.25, spike, &mut rng), 0.25);
    }
}
