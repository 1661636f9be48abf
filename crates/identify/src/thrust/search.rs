//! Minimisation of a function of one or two lags.

use sindy::numerics::golden_section;

/// Relative width to which the place of the minimum is narrowed: the cost there is flat to its square.
const NARROW: f64 = 1e-5;

/// Smallest value of `f` over `[lo, hi]` (both above 0): a logarithmic grid, then golden sections around
/// its best point.
pub(super) fn minimise(lo: f64, hi: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    const POINTS: usize = 32;
    let grid: Vec<f64> = (0..POINTS)
        .map(|k| lo * (hi / lo).powf(k as f64 / (POINTS - 1) as f64))
        .collect();
    let values: Vec<f64> = grid.iter().map(|&x| f(x)).collect();
    let best = (0..POINTS)
        .min_by(|&a, &b| values[a].total_cmp(&values[b]))
        .unwrap_or(0);
    let around = [
        grid[best.saturating_sub(1)],
        grid[(best + 1).min(POINTS - 1)],
    ];
    let [a, b] = golden_section(around, |a, b| b - a > NARROW * b, f);
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_minimum_of_a_bumpy_parabola() {
        let f = |x: f64| (x.ln() - 0.07_f64.ln()).powi(2) + 1e-6 * (40.0 * x).sin();
        // Golden sections stop at a relative width of 1e-5; the bumps move the minimum by less than 1e-4.
        assert!((minimise(1e-3, 1.0, f) - 0.07).abs() < 1e-4);
    }
}
