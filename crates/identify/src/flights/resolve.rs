//! Whether the logs identify the wake's lag and the effect of climb.

use super::FlightSettings;
use super::model::ModelTerms;
use super::selection::ModelSelection;
use crate::refusal::Refusal;

/// A lag whose standard error is greater than this share of it is not resolved.
/// 2.5 standard errors from zero, and still a number within a factor of two. Twice would report lags that reach zero.
const RESOLVED: f64 = 0.4;

fn without_lag(shape: ModelTerms) -> ModelTerms {
    ModelTerms {
        wake_lag: false,
        fountain_lag: false,
        ..shape
    }
}

/// Keeps the wake's lag only where it predicts held-out flights better; returns whether it does.
pub(super) fn wants_lag(choice: &mut ModelSelection<'_>, refused: &mut Vec<Refusal>) -> bool {
    let shape = without_lag(choice.best.shape);
    let without = choice.do_without("without the wake's lag", shape, true);
    if without {
        refused.push(Refusal::WakeLagPredictsNoBetter);
    }
    !without
}

/// Keeps it only where its interval is narrow enough.
pub(super) fn resolve_lag(
    choice: &mut ModelSelection<'_>,
    settings: &FlightSettings,
    refused: &mut Vec<Refusal>,
) {
    let tau = choice.lag(settings);
    if let Some(tau) = tau
        && tau.ci95[0] > 0.0
        && tau.std_error < RESOLVED * tau.value
    {
        return;
    }
    refused.push(Refusal::WakeLagUnresolved(tau));
    let with = choice.best.clone();
    choice.replace("without the wake's lag", without_lag(with.shape), &with);
}

/// Keeps a climb damping that differs near the ground only where it predicts held-out flights better and is not zero.
pub(super) fn climb_near_ground(
    choice: &mut ModelSelection<'_>,
    settings: &FlightSettings,
    refused: &mut Vec<Refusal>,
) {
    if !choice.best.shape.damping {
        return refused.push(Refusal::NoClimbRate);
    }
    let lag = choice.lag(settings);
    let before = choice.best.clone();
    let shape = ModelTerms {
        near_damping: true,
        ..before.shape
    };
    if !choice.offer_sternly("damping near the ground", shape, true) {
        return refused.push(Refusal::ClimbPredictsNoBetter);
    }
    let near = choice.estimate("near_damping", settings);
    // A lag shows as an effect of climb, and the other way round: what moves the lag is confounded with it.
    let moves_lag = lag
        .zip(choice.lag(settings))
        .is_some_and(|(before, after)| (after.value - before.value).abs() > before.std_error);
    if moves_lag || near.is_none_or(|n| !n.differs_from_zero()) {
        choice.replace("without damping near the ground", before.shape, &before);
        refused.push(if moves_lag {
            Refusal::ClimbConfoundedWithLag
        } else {
            Refusal::ClimbMayBeZero
        });
    }
}
