//! Slopes of a model by its numbers from differences, and the last steps of a fit, whose slopes are as exact as differences are.
//!
//! A short one-sided difference loses as many digits to rounding as it is short. Where flights say little of a number, the last bits
//! of `exp` and `ln`, which differ between platforms, then show in its eighth digit. Wide two-sided differences have the same error of
//! curvature and a hundredth of the rounding, at twice the cost: only the fit that is reported ends with them.

use nalgebra::DVector;

use super::fit::{Fit, FitSystem, at_bounds, total};
use super::model::{Parameter, Segment};
use super::normal::hold;

/// Width over the prior standard deviation, one-sided and two-sided: both errors of curvature are about 1e-4 of the slope.
const ONE_SIDED: f64 = 1e-4;
const TWO_SIDED: f64 = 1e-2;
/// Share of its width that bounds leave of a two-sided difference at least: less is as short as a one-sided one.
const LEAST_ROOM: f64 = 1e-2;
/// Last steps at most; three or four are usual.
const MOST_STEPS: usize = 8;
/// Square of a last step, in standard errors, at most: a longer one is none of a fit that has converged.
const LONGEST: f64 = 0.1;
/// Share of the square of a step from which the next one does not count as shorter: what remains is rounding.
const SHORTER: f64 = 0.5;

/// How slopes are taken.
#[derive(Clone, Copy, Debug)]
pub(super) enum Differences {
    OneSided,
    TwoSided,
}

impl Differences {
    /// By how much a number is moved for the two ends of a difference; zero is where it is.
    pub(super) fn ends(self, p: &Parameter, value: f64) -> [f64; 2] {
        let wide = match self {
            Self::OneSided => 0.0,
            Self::TwoSided => TWO_SIDED * p.prior_sd.min(p.max - p.min),
        };
        ends(p, value, wide)
    }
}

/// The two ends of a difference: by `wide` to both sides, or by the width of one-sided ones where that is 0 or bounds leave little.
pub(super) fn ends(p: &Parameter, value: f64, wide: f64) -> [f64; 2] {
    let room = wide.min(p.max - value).min(value - p.min);
    let short = ONE_SIDED * p.prior_sd.min(p.max - p.min);
    if room > LEAST_ROOM * wide {
        [-room, room]
    } else if value + short > p.max {
        [0.0, -short]
    } else {
        [0.0, short]
    }
}

/// The last steps of a fit: until they become no shorter.
pub(super) struct LastSteps {
    before: f64,
    left: usize,
}

impl LastSteps {
    pub(super) fn new() -> Self {
        Self {
            before: LONGEST,
            left: MOST_STEPS,
        }
    }

    /// Whether a step is one of them, from its square in standard errors.
    pub(super) fn include(&mut self, square: f64) -> bool {
        let shorter = square < SHORTER * self.before;
        let goes_on = shorter && self.left > 0;
        if goes_on {
            self.before = square;
            self.left -= 1;
        }
        goes_on
    }
}

impl Fit {
    /// The same fit after Gauss–Newton steps until they become no shorter.
    pub(super) fn settled(self, pieces: &[Segment]) -> Self {
        if !self.converged {
            return self;
        }
        let parameters = self.shape.parameters();
        let system = FitSystem {
            pieces,
            shape: self.shape,
            parameters: &parameters,
            colour: self.colour,
            differences: Differences::TwoSided,
        };
        let mut fit = self;
        let mut now = system.assemble(&fit.theta, &fit.locals, fit.sigma);
        let mut last = LastSteps::new();
        loop {
            let (mut gradient, mut hessian) = total(&now, &parameters, &fit.theta);
            fit.held = at_bounds(&parameters, &fit.theta, &gradient);
            hold(&mut hessian, &mut gradient, &fit.held);
            let Some(step) = hessian.clone().cholesky().map(|c| c.solve(&gradient)) else {
                break;
            };
            if !last.include(step.dot(&(&hessian * &step))) {
                break;
            }
            let there = parameters.iter().zip(&fit.theta).zip(step.iter());
            let theta: Vec<f64> = there
                .map(|((p, from), by)| (from + by).clamp(p.min, p.max))
                .collect();
            let moved = theta.iter().zip(&fit.theta).map(|(to, from)| to - from);
            let shift = DVector::from_iterator(theta.len(), moved);
            let locals = now.iter().zip(&fit.locals);
            fit.locals = locals.map(|(a, l)| l.moved(a.local(&shift))).collect();
            fit.theta = theta;
            now = system.assemble(&fit.theta, &fit.locals, fit.sigma);
        }
        fit.reduced = now.into_iter().map(|a| a.reduced).collect();
        fit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flights::fit::fit;
    use crate::flights::made::up_and_down;
    use crate::flights::model::{Curve, ModelTerms};

    /// A lift with residuals that no model explains; forces are multiplied by `scale`.
    fn piece(flight: usize, scale: f64) -> Segment {
        up_and_down(flight, |h, t| {
            scale * (1.0 + 0.2 * (-h).exp() + 0.02 * (371.0 * t).sin())
        })
    }

    #[test]
    fn prop_the_last_bit_of_forces_moves_no_number_of_a_settled_fit() {
        let shape = ModelTerms::plain(Curve::Exponential, false, false);
        let theta = |scale: f64, settled: bool| {
            let pieces: Vec<Segment> = (0..4).map(|flight| piece(flight, scale)).collect();
            let found = fit(&pieces, shape, None);
            assert!(found.converged);
            if settled {
                found.settled(&pieces).theta
            } else {
                found.theta
            }
        };
        let moved = |settled: bool| {
            let pairs = theta(1.0, settled)
                .into_iter()
                .zip(theta(1.0_f64.next_up(), settled));
            let each = pairs.map(|(a, b)| (a - b).abs() / a.abs().max(1e-3));
            each.fold(0.0, f64::max)
        };
        let (search, end) = (moved(false), moved(true));
        // Measured: 6e-14.
        assert!(end < 1e-12 && end < 0.5 * search, "{end:e} {search:e}");
    }

    #[test]
    fn analytic_differences_stay_within_the_bounds_of_a_number() {
        let shape = ModelTerms::plain(Curve::Exponential, false, true);
        for p in shape.parameters() {
            for value in [p.min, p.start, p.max] {
                for way in [Differences::OneSided, Differences::TwoSided] {
                    let [low, high] = way.ends(&p, value);
                    let ends = [value + low, value + high];
                    assert!(low != high, "{}", p.name);
                    assert!(
                        ends.iter().all(|v| (p.min..=p.max).contains(v)),
                        "{} {ends:?}",
                        p.name
                    );
                }
            }
        }
    }
}
