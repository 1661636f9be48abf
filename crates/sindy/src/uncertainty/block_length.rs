//! How long the blocks of a bootstrap must be.

/// The length of block, in rows, that is best for the variance of the mean of a correlated series,
///
/// ```text
/// b = (2 g² / D)^⅓ n^⅓,   g = Σ_k λ(k/M) |k| R(k),   D = 4/3 (Σ_k λ(k/M) R(k))²
/// ```
///
/// with `R` the autocovariances, `λ` the trapezoidal window (1 up to one half, then down to 0 at 1), and `M` twice
/// the first lag from which the autocorrelation stays below `2 √(log₁₀ n / n)`, for at least five lags. At least
/// 1 and at most `3 √n`, and a third of the rows.
///
/// The series may come in several parts (trajectories), which are not correlated with each other, and may
/// have gaps (values that are not finite). A constant series gives 1.
///
/// Sources: D. N. Politis, H. White, Econometric Reviews 23 (2004); A. Patton, D. N. Politis, H. White,
/// Econometric Reviews 28 (2009).
#[must_use]
pub fn block_length(series: &[Vec<f64>]) -> f64 {
    let finite = || series.iter().flatten().filter(|v| v.is_finite());
    let n = finite().count() as f64;
    if n < 2.0 {
        return 1.0;
    }
    let mean = finite().sum::<f64>() / n;
    let covariance = |lag: usize| {
        let pairs = series
            .iter()
            .flat_map(|part| part.iter().zip(part.iter().skip(lag)));
        pairs
            .map(|(a, b)| (a - mean) * (b - mean))
            .filter(|product| product.is_finite())
            .sum::<f64>()
            / n
    };
    let run = 5.max(n.log10() as usize);
    let longest = n.sqrt().ceil() as usize + run;
    let small = 2.0 * (n.log10() / n).sqrt();
    let mut r: Vec<f64> = Vec::new();
    let mut quiet = 0;
    let mut window = longest;
    for lag in 0..=longest {
        r.push(covariance(lag));
        quiet = if r[lag].abs() < small * r[0] {
            quiet + 1
        } else {
            0
        };
        if quiet == run {
            window = longest.min(2 * (lag + 1 - run).max(1));
            break;
        }
    }
    if !(r[0] > 0.0) {
        return 1.0;
    }
    // The window may reach beyond the lags that were looked at so far.
    while r.len() <= window {
        r.push(covariance(r.len()));
    }
    let (mut slope, mut long_run) = (0.0, r[0]);
    for (k, r) in r.iter().enumerate().take(window + 1).skip(1) {
        let at = k as f64 / window as f64;
        let weight = 2.0 * (2.0 * (1.0 - at)).min(1.0);
        slope += weight * k as f64 * r;
        long_run += weight * r;
    }
    let best = (1.5 * (slope / long_run).powi(2) * n).cbrt();
    let most = (3.0 * n.sqrt()).min(n / 3.0).ceil();
    // A long-run variance of zero would ask for an endless block.
    if best.is_finite() {
        best.clamp(1.0, most)
    } else {
        most
    }
}
