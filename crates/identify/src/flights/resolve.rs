//! What of lags and climb the logs carry, and what is refused.

use super::FlightSettings;
use super::ground::Refusal;
use super::model::ModelTerms;
use super::selection::ModelSelection;

/// A lag whose standard error is greater than this share of it is not resolved.
/// 2.5 standard errors from zero, and still a number within a factor of two. Twice would report lags that reach zero.
const RESOLVED: f64 = 0.4;

/// What an acceleration that is smoothed over a fifth of a second does not show.
pub(super) fn of_poses(what: &str) -> Refusal {
    Refusal {
        what: what.into(),
        found: "specific force from poses, smoothed over 0.2 s".into(),
        record: "the accelerometer (`specific_force_mps2`) at 100 Hz or more".into(),
    }
}

/// What to record for a lag.
const QUICK: &str = "quick climbs and descents below two rotor radii, back and forth within a second, in several flights";

fn of_lag(found: String) -> Refusal {
    Refusal {
        what: "lag of the wake".into(),
        found,
        record: QUICK.into(),
    }
}

fn without_lag(shape: ModelTerms) -> ModelTerms {
    ModelTerms {
        wake_lag: false,
        fountain_lag: false,
        ..shape
    }
}

/// Keeps the wake's lag only where flights left out want it; says whether they do.
pub(super) fn wants_lag(choice: &mut ModelSelection<'_>, refused: &mut Vec<Refusal>) -> bool {
    let shape = without_lag(choice.best.shape);
    let without = choice.do_without("without the wake's lag", shape, true);
    if without {
        refused.push(of_lag(
            "flights left out are predicted no better with it".into(),
        ));
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
    refused.push(of_lag(tau.map_or_else(
        || "no interval".to_string(),
        |t| {
            format!(
                "{:.3} s, 95 % interval {:.3} to {:.3} s",
                t.value, t.ci95[0], t.ci95[1]
            )
        },
    )));
    let with = choice.best.clone();
    choice.replace("without the wake's lag", without_lag(with.shape), &with);
}

/// Keeps a climb damping that differs near the ground only where flights left out want it and it is not zero.
pub(super) fn climb_near_ground(
    choice: &mut ModelSelection<'_>,
    settings: &FlightSettings,
    refused: &mut Vec<Refusal>,
) {
    let mut refuse = |found: String, record: &str| {
        refused.push(Refusal {
            what: "effect of climb and sink on the ground effect".into(),
            found,
            record: record.into(),
        });
    };
    if !choice.best.shape.damping {
        return refuse(
            "no climb rate".into(),
            "height or climb rate at 20 Hz or more",
        );
    }
    let record =
        "climbs and descents through the same heights below two rotor radii at 0.1 to 0.5 m/s";
    let lag = choice.lag(settings);
    let before = choice.best.clone();
    let shape = ModelTerms {
        near_damping: true,
        ..before.shape
    };
    if !choice.offer_sternly("damping near the ground", shape, true) {
        return refuse(
            "flights left out are predicted no better with it".into(),
            record,
        );
    }
    let near = choice.estimate("near_damping", settings);
    // A lag shows as an effect of climb, and the other way round: what moves the lag is not told apart from it.
    let moves_lag = lag
        .zip(choice.lag(settings))
        .is_some_and(|(before, after)| (after.value - before.value).abs() > before.std_error);
    if moves_lag || near.is_none_or(|n| !n.differs_from_zero()) {
        choice.replace("without damping near the ground", before.shape, &before);
        let why = if moves_lag {
            "it cannot be told from the wake's lag"
        } else {
            "its interval holds zero"
        };
        refuse(why.into(), record);
    }
}
