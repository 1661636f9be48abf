//! A running median against single-sample dropouts.

/// Replaces each value by the median of the `samples` values around it, without gaps. Near the ends
/// the window shrinks symmetrically.
pub(crate) fn running_median(values: &mut [f64], samples: usize) {
    let rows: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_nan()).collect();
    let known: Vec<f64> = rows.iter().map(|&i| values[i]).collect();
    let mut around = Vec::with_capacity(samples);
    for (at, &row) in rows.iter().enumerate() {
        let reach = (samples / 2).min(at).min(known.len() - 1 - at);
        around.clear();
        around.extend_from_slice(&known[at - reach..=at + reach]);
        let (_, median, _) = around.select_nth_unstable_by(reach, f64::total_cmp);
        values[row] = *median;
    }
}

#[cfg(test)]
mod tests {
    use super::running_median;

    #[test]
    fn analytic_a_dropout_goes_and_gaps_stay() {
        let mut values = [1.0, 2.0, f64::NAN, 0.0, 3.0, 4.0, f64::NAN, 5.0];
        running_median(&mut values, 3);
        let expected = [1.0, 1.0, f64::NAN, 2.0, 3.0, 4.0, f64::NAN, 5.0];
        assert_eq!(format!("{values:?}"), format!("{expected:?}"));
        running_median(&mut [], 3);
    }
}
