//! Minimisation of a function of one variable by golden section.

/// Narrows `[low, high]` around a minimum of `cost`, by one evaluation a step, while `wide(low, high)`; returns the interval
/// that is left. The minimum of a function with one valley is in it.
///
/// ```
/// let [low, high] = sindy::numerics::golden_section([0.0, 2.0], |a, b| b - a > 1e-6, |x| (x - 0.3_f64).powi(2));
/// assert!(low <= 0.3 && 0.3 <= high);
/// ```
pub fn golden_section(
    [mut low, mut high]: [f64; 2],
    wide: impl Fn(f64, f64) -> bool,
    mut cost: impl FnMut(f64) -> f64,
) -> [f64; 2] {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let mut x = [high - ratio * (high - low), low + ratio * (high - low)];
    let mut f = x.map(&mut cost);
    while wide(low, high) {
        if f[0] <= f[1] {
            high = x[1];
            x = [high - ratio * (high - low), x[0]];
            f = [cost(x[0]), f[0]];
        } else {
            low = x[0];
            x = [x[1], low + ratio * (high - low)];
            f = [f[1], cost(x[1])];
        }
    }
    [low, high]
}

/// Share of a grid's step to which [`minimum_on_grid`] narrows the place of the minimum; the cost there is flat, and off by
/// about its square.
const NARROW: f64 = 1e-3;

/// The minimum of `cost` on `[low, high]`, as place and cost: the best of a grid of `points`, refined by golden section
/// between its neighbours. Values that are not finite count as infinite.
pub(crate) fn minimum_on_grid(
    low: f64,
    high: f64,
    points: usize,
    mut cost: impl FnMut(f64) -> f64,
) -> (f64, f64) {
    let mut finite = |x: f64| match cost(x) {
        value if value.is_finite() => value,
        _ => f64::INFINITY,
    };
    let step = (high - low) / (points - 1) as f64;
    let mut best = (low, f64::INFINITY);
    for k in 0..points {
        let x = low + step * k as f64;
        let value = finite(x);
        if value < best.1 {
            best = (x, value);
        }
    }
    let around = [(best.0 - step).max(low), (best.0 + step).min(high)];
    golden_section(
        around,
        |a, b| b - a > NARROW * step,
        |x| {
            let value = finite(x);
            if value < best.1 {
                best = (x, value);
            }
            value
        },
    );
    best
}
