//! Rows without weight: short runs are bridged, long ones are missing.

/// Rows without weight, one after the other, that are bridged by a straight line; over more, the line is off by the
/// signal's curvature.
pub(crate) const BRIDGED: usize = 3;

/// Puts straight lines through runs of up to `longest` rows without weight, NaN through longer ones and those at the ends.
pub(crate) fn bridge(time: &[f64], columns: &mut [Vec<f64>], weights: &[f64], longest: usize) {
    let n = weights.len();
    let mut row = 0;
    while row < n {
        if weights[row] > 0.0 {
            row += 1;
            continue;
        }
        let end = (row..n).find(|&k| weights[k] > 0.0).unwrap_or(n);
        for column in columns.iter_mut() {
            for k in row..end {
                column[k] = if row == 0 || end == n || end - row > longest {
                    f64::NAN
                } else {
                    let part = (time[k] - time[row - 1]) / (time[end] - time[row - 1]);
                    column[row - 1] + part * (column[end] - column[row - 1])
                };
            }
        }
        row = end;
    }
}
