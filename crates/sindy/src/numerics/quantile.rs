//! Quantiles of values.

/// The quantile of sorted values at the share `q`, with linear interpolation between neighbours.
///
/// # Panics
/// No values.
#[must_use]
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let (i, t) = (at.floor() as usize, at.fract());
    let next = sorted[(i + 1).min(sorted.len() - 1)];
    sorted[i] + t * (next - sorted[i])
}

/// The value nearest to the quantile at the share `q`, in any order; NaN of none.
pub(crate) fn nearest_quantile(values: &mut [f64], q: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let place = ((values.len() - 1) as f64 * q).round() as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// The median, in any order; of an even number the upper of the two in the middle, none of none.
pub(crate) fn upper_median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
