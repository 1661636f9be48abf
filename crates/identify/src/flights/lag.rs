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

/// The lag of a fit (s) with its uncertainty; `None` where the model has none, or where it stands at a bound of its search:
/// there no draw of the runs moves it, and its interval would be a point.
pub(super) fn lag(fit: &Fit, pieces: &[Segment], spread: &Resampling) -> Option<Estimate> {
    if fit.index("tau").is_some_and(|i| fit.held.contains(&i)) {
        return None;
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flights::fit::fit;
    use crate::flights::made::up_and_down;
    use crate::flights::model::{Curve, ModelTerms};

    /// A lift `0.2 exp(-z)` that follows the height at once, and heights that were logged `late` samples of 0.01 s later.
    fn run(late: usize, flight: usize) -> Segment {
        let at_once = up_and_down(flight, |h, _| 1.0 + 0.2 * (-h).exp());
        let logged: Vec<f64> = (0..at_once.height.len())
            .map(|i| at_once.height[i.saturating_sub(late)])
            .collect();
        Segment {
            range_m: logged.clone(),
            height: logged,
            ..at_once
        }
    }

    #[test]
    fn regress_a_lag_at_its_lower_bound_is_no_number() {
        let shape = ModelTerms {
            wake_lag: true,
            ..ModelTerms::plain(Curve::Exponential, false, false)
        };
        // Heights 0.05 s late ask for a lag below zero. At the bound of the search it was a lag of 0.005 s that no draw moved.
        let pieces: Vec<Segment> = (0..5).map(|flight| run(5, flight)).collect();
        let late = fit(&pieces, shape, None);
        assert_eq!(late.value("tau"), Some(0.005));
        let spread = Resampling::of(&late, &pieces, 200, 1);
        assert!(lag(&late, &pieces, &spread).is_none());
    }
}
