//! Minimisation of a function of one or two lags.

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
    let (mut a, mut b) = (
        grid[best.saturating_sub(1)],
        grid[(best + 1).min(POINTS - 1)],
    );
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    while b - a > 1e-5 * b {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - golden * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + golden * (b - a);
            fd = f(d);
        }
    }
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
