//! The parts of a log between its holes.

use std::ops::Range;

use super::plateau::median;

/// A hole of more periods than these breaks a record: what happened in it is not known.
pub(crate) const HOLE_PERIODS: f64 = 10.0;

/// The rows between steps in time that are longer than [`HOLE_PERIODS`] of the median step.
pub(crate) fn unbroken(time: &[f64]) -> Vec<Range<usize>> {
    let steps = || time.windows(2).map(|t| t[1] - t[0]);
    let longest = HOLE_PERIODS * median(steps()).unwrap_or(f64::INFINITY);
    let after_holes = steps().zip(1..).filter(|(step, _)| *step > longest);
    let mut starts: Vec<usize> = std::iter::once(0)
        .chain(after_holes.map(|(_, row)| row))
        .collect();
    starts.push(time.len());
    starts.windows(2).map(|s| s[0]..s[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_hole_is_ten_periods() {
        assert_eq!(unbroken(&[0.0, 0.1, 0.2, 1.1, 1.2]).len(), 1);
        assert_eq!(unbroken(&[0.0, 0.1, 0.2, 1.3, 1.4]), [0..3, 3..5]);
        assert_eq!(unbroken(&[2.0]).len(), 1);
    }
}
