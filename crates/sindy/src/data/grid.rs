//! Time grids: the checks of a sampled signal, and the period of a uniform grid.

use crate::error::{SindyError, same_size};

/// Samples that are looked at together: long enough to run in vector instructions, short enough to stop
/// early.
const CHUNK: usize = 1024;

fn any(part: &[f64], bad: impl Fn(f64) -> bool) -> bool {
    part.iter().fold(false, |found, &v| found | bad(v))
}

/// Refuses lengths that differ, fewer than `needed` samples, non-finite values and times that do not
/// increase.
pub(crate) fn check(time: &[f64], y: &[f64], needed: usize) -> Result<(), SindyError> {
    let n = y.len();
    same_size("time and signal", n, time.len())?;
    if n < needed {
        return Err(SindyError::too_short(needed, n));
    }
    for (what, column) in [("signal", y), ("time", time)] {
        if column
            .chunks(CHUNK)
            .any(|part| any(part, |v| !v.is_finite()))
            && let Some(index) = column.iter().position(|v| !v.is_finite())
        {
            return Err(SindyError::NotFinite {
                what: what.into(),
                index,
            });
        }
    }
    let backwards = |w: &[f64]| !(w[1] > w[0]);
    let stands = |from: usize| {
        let part = &time[from..n.min(from + CHUNK + 1)];
        part.windows(2).fold(false, |bad, w| bad | backwards(w))
    };
    if (0..n).step_by(CHUNK).any(stands)
        && let Some(index) = time.windows(2).position(backwards)
    {
        let index = index + 1;
        return Err(SindyError::TimeNotIncreasing { index });
    }
    Ok(())
}

/// The period of a uniform grid of at least two samples, `None` where the grid is not uniform.
///
/// A grid is uniform when no sample is off by more than a millionth of the period: the error that fixed
/// weights then make is of that order, below rounding in any measured signal. Times that are large beside the
/// period (seconds since 1970) may be off by their own rounding as well.
pub(crate) fn uniform_period(time: &[f64]) -> Option<f64> {
    let dt = mean_period(time);
    let start = time[0];
    let allowed = 1e-6 * dt + 4.0 * f64::EPSILON * start.abs().max(time[time.len() - 1].abs());
    let off = |(c, part): (usize, &[f64])| {
        let base = start + dt * (c * CHUNK) as f64;
        part.iter().zip(0u32..).fold(false, |bad, (&t, k)| {
            bad | !((t - base - dt * f64::from(k)).abs() <= allowed)
        })
    };
    (!time.chunks(CHUNK).enumerate().any(off)).then_some(dt)
}

/// The mean period of at least two samples.
pub(crate) fn mean_period(time: &[f64]) -> f64 {
    (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64
}
