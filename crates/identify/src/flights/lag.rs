//! The lag of a wake as one number.
//!
//! Images and fountain settle at paces of their own, faster near the ground. One number for all of it is the single lag
//! `τ G' = h(z) - G` that follows the model's ratio G best, by least squares, along the flown heights. Where the model has
//! one lag it is that.

use rayon::prelude::*;
use sindy::numerics::golden_section;

use super::fit::{Fit, SegmentOffsets};
use super::model::{ModelValues, Segment};
use super::resampling::Resampling;
use crate::estimate::Estimate;

/// Lags that are looked for (s).
/// Wider than any wake: half or twice as wide moves no digit of a lag that is shown (measured).
const BOUNDS_S: [f64; 2] = [0.002, 3.0];
/// Share of a lag that the search stops at.
/// A hundredth of a per cent of the lag, far below any standard error.
const CLOSE: f64 = 1e-4;

/// The lag of a fit (s) with its uncertainty; `None` where the model has none.
pub(super) fn lag(fit: &Fit, pieces: &[Segment], spread: &Resampling) -> Option<Estimate> {
    if fit.shape.fountain_lag {
        let of =
            |theta: &[f64]| equivalent_s(&ModelValues::of(&fit.shape, theta), pieces, &fit.locals);
        spread.smooth(fit, of)
    } else {
        spread.number(fit, "tau")
    }
}

/// The single lag closest to the wake of these values along the runs (s).
fn equivalent_s(values: &ModelValues, pieces: &[Segment], locals: &[SegmentOffsets]) -> f64 {
    let courses: Vec<Vec<[f64; 3]>> = pieces
        .par_iter()
        .zip(locals)
        .map(|(piece, local)| piece.wake(values, local.bias))
        .collect();
    let missed = |lag_s: f64| -> f64 {
        courses
            .par_iter()
            .map(|course| {
                let Some([_, first, _]) = course.first() else {
                    return 0.0;
                };
                let (mut g, mut before) = (*first, *first);
                let each = course.iter().map(|&[dt, h, ratio]| {
                    g = super::model::follow(g, [before, h], dt, lag_s);
                    before = h;
                    (g - ratio).powi(2)
                });
                each.sum::<f64>()
            })
            .sum()
    };
    // In the logarithm.
    let missed = |log: f64| missed(log.exp());
    let [lo, hi] = golden_section(BOUNDS_S.map(f64::ln), |lo, hi| hi - lo > CLOSE, missed);
    (0.5 * (lo + hi)).exp()
}
