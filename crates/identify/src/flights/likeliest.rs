//! The form of the model that makes the trajectories likeliest, and the laws of the curve that they do not exclude.

use super::fit::Fit;
use super::model::{Curve, ModelTerms};
use super::selection::ModelSelection;
use super::trajectory::{self, Tracked, track_shape, with_latency};

/// Twice the logarithm of a ratio of likelihoods that a richer model needs: odds of 150 to 1, as where held-out flights decide.
const EVIDENCE: f64 = 10.0;

/// The same that a latency of the accelerometer needs: by chance there is as much in 1 of 100 sets of flights without one (χ² of one
/// degree of freedom, one-sided), as for a throttle that is logged late. What is not taken is a rival.
const EVIDENCE_OF_LATENCY: f64 = 5.4;

/// Probability below which another curve counts as excluded: one in fifty widens no interval by more than a seventh of what it
/// would move a number by. Half or twice moves no coverage.
const LEAST_PROBABILITY: f64 = 0.02;

/// A model with another law of the static curve, with a lag, or with or without a latency of the accelerometer, which the flights do
/// not exclude.
#[derive(Clone, Debug)]
pub(super) struct Rival {
    pub(super) fit: Fit,
    /// Its probability, where all models are equally likely beforehand.
    pub(super) probability: f64,
    /// The model that it differs from in one term only; `None` where that is the model of the numbers.
    pub(super) instead_of: Option<Fit>,
}

impl Rival {
    /// A model beside one that was chosen.
    pub(super) fn beside(other: Tracked, chosen: &Tracked) -> Self {
        Self {
            probability: 1.0 / (1.0 + (0.5 * (other.cost - chosen.cost)).exp()),
            fit: other.fit,
            instead_of: None,
        }
    }
}

/// Drift and second term of throttle, one after the other, each taken with very strong evidence. Without an accelerometer,
/// forces from heights are too noisy to choose by.
pub(super) fn likeliest_motors(
    choice: &mut ModelSelection<'_>,
    mut best: Tracked,
    units: trajectory::Settings,
) -> Tracked {
    for (name, drift) in [("drift", true), ("second term of throttle", false)] {
        let before = best.fit.shape;
        let shape = ModelTerms {
            battery: drift || before.battery,
            curvature: !drift || before.curvature,
            ..before
        };
        let Some(rival) = track_shape(choice.pieces, shape, &best, units) else {
            continue;
        };
        let evidence = best.cost - rival.cost;
        let take = rival.fit.converged && evidence > EVIDENCE;
        choice.note(name, shape, evidence, take);
        if take {
            best = rival;
        }
    }
    best
}

/// The same with a latency of the accelerometer where the flights support one, and the other of the two models where they do not
/// exclude it.
pub(super) fn likeliest_latency(
    choice: &mut ModelSelection<'_>,
    best: Tracked,
    units: trajectory::Settings,
) -> (Tracked, Option<Rival>) {
    let with = with_latency(choice.pieces, &best, units);
    let Some(rival) = with.filter(Tracked::is_trusted) else {
        return (best, None);
    };
    let evidence = best.cost - rival.cost;
    let take = evidence > EVIDENCE_OF_LATENCY;
    choice.note(
        "latency of the accelerometer",
        rival.fit.shape,
        evidence,
        take,
    );
    let (chosen, other) = if take { (rival, best) } else { (best, rival) };
    let rival = rival_of_motion(other, &chosen);
    (chosen, rival)
}

/// A late accelerometer over a ground at rest, or a ground that moves: the one that explains more readings, then the likelier; and
/// the other one where the flights do not exclude it.
///
/// A logged climb rate that one of them leaves out has no part in its cost.
pub(super) fn late_or_other(
    choice: &mut ModelSelection<'_>,
    late: Tracked,
    other: Tracked,
) -> (Tracked, Option<Rival>) {
    let climb_counts = |t: &Tracked| t.noise.climb_mps.is_finite();
    let (late_counts, other_counts) = (climb_counts(&late), climb_counts(&other));
    let evidence = other.cost - late.cost;
    let take = (late_counts && !other_counts)
        || (late_counts == other_counts && evidence > EVIDENCE_OF_LATENCY);
    choice.note(
        "late accelerometer over a ground at rest",
        late.fit.shape,
        evidence,
        take,
    );
    let (chosen, left) = if take { (late, other) } else { (other, late) };
    let rival = (late_counts == other_counts)
        .then(|| rival_of_motion(left, &chosen))
        .flatten();
    (chosen, rival)
}

/// The other explanation of the motion, where the flights do not exclude it.
fn rival_of_motion(other: Tracked, chosen: &Tracked) -> Option<Rival> {
    // The curve and the lag of the wake are chosen later: what they move is not of the latency.
    let other = Rival {
        instead_of: Some(chosen.fit.clone()),
        ..Rival::beside(other, chosen)
    };
    (other.probability > LEAST_PROBABILITY).then_some(other)
}

/// The likeliest law of the static curve, and those that the flights do not exclude.
///
/// Laws differ where no height was flown, and far from the ground: an exponential dies away, images go with 1/z². A law with
/// more numbers has to have very strong evidence to be taken, but it is a rival all the same.
pub(super) fn likeliest_curve(
    choice: &mut ModelSelection<'_>,
    first: Tracked,
    units: trajectory::Settings,
) -> (Tracked, Vec<Rival>) {
    let shape = first.fit.shape;
    let mut all = vec![first];
    for curve in [Curve::Exponential, Curve::Empirical, Curve::Rational] {
        if curve == shape.curve || shape.curve == Curve::Free {
            continue;
        }
        let shape = ModelTerms {
            curve,
            fountain_lag: false,
            ..shape
        };
        let rival = track_shape(choice.pieces, shape, &all[0], units);
        // A rival is as white as the first, or nearly white.
        let rival =
            rival.filter(|r| r.is_trusted() || (!all[0].is_trusted() && r.is_nearly_white()));
        all.extend(rival);
    }
    let mut best = 0;
    for (k, rival) in all.iter().enumerate().skip(1) {
        let richer = rival.fit.shape.curve.many() > all[best].fit.shape.curve.many();
        let evidence = all[best].cost - rival.cost;
        let take = evidence > if richer { EVIDENCE } else { 0.0 };
        choice.note(
            rival.fit.shape.curve.name(),
            rival.fit.shape,
            evidence,
            take,
        );
        if take {
            best = k;
        }
    }
    let likeliest = all.iter().map(|t| t.cost).fold(f64::INFINITY, f64::min);
    let weight = |t: &Tracked| (0.5 * (likeliest - t.cost)).exp();
    let sum: f64 = all.iter().map(weight).sum();
    let chosen = all.swap_remove(best);
    let rivals = all.into_iter().map(|t| Rival {
        probability: weight(&t) / sum,
        fit: t.fit,
        instead_of: None,
    });
    let rivals = rivals.filter(|r| r.probability > LEAST_PROBABILITY);
    (chosen, rivals.collect())
}
