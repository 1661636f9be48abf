//! A trial, prepared: the force extracted, the columns at hand.

use std::ops::Range;

use sindy::SavitzkyGolay;
use sindy::derivative::savgol::Smoothed;
use sindy::statistics::regression::Clusters;
use sindy::trajectory::shooting::Record;
use touchdown_model::card::{Card, Form, Term};
use touchdown_trial::Trial;

use super::between::FineTrial;
use crate::delayed::delayed;
use crate::error::{Error, Result};
use crate::fitted::range;
use crate::prediction::{Columns, Predictor};
use crate::settings::IdentificationSettings;
use crate::thrust;
use crate::warning::Warning;

/// A trial with the ground-effect force extracted.
#[derive(Clone, Debug)]
pub struct GroundTrial {
    /// The trial's name.
    pub name: String,
    /// Time (s).
    pub time_s: Vec<f64>,
    /// Throttle.
    pub throttle: Vec<f64>,
    /// Height above the deck (m).
    pub height_m: Vec<f64>,
    /// Deck velocity (m/s).
    pub deck_velocity_mps: Vec<f64>,
    /// Vehicle velocity (m/s).
    pub vehicle_velocity_mps: Vec<f64>,
    /// Free-air thrust, by the thrust card (N).
    pub free_air_thrust_n: Vec<f64>,
    /// Measured force beyond it (N).
    pub force_n: Vec<f64>,
    /// The plant's own force with turbulence and sensor noise off, shifted by the rig's nominal latency,
    /// where the trial is of the virtual rig (N).
    pub truth_n: Option<Vec<f64>>,
}

/// The channels in which a gap costs the row.
const CHANNELS: [&str; 5] = [
    "throttle",
    "thrust_n",
    "height_m",
    "deck_velocity_mps",
    "vehicle_velocity_mps",
];

/// The trial without the rows in which a channel that the force needs has a gap, and how many those are. Channels
/// that the trial lacks are passed over.
///
/// # Errors
/// None: rows of a trial make a trial.
pub fn without_gaps(trial: &Trial) -> Result<(Trial, usize)> {
    let needed: Vec<&[f64]> = CHANNELS.iter().filter_map(|c| trial.channel(c)).collect();
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| needed.iter().all(|c| c[i].is_finite()))
        .collect();
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let mut whole = Trial::new(trial.name(), pick(trial.time_s()))?;
    for (name, values) in trial.channels() {
        whole.insert(name, pick(values))?;
    }
    let whole = whole.with_provenance(trial.provenance().clone());
    Ok((whole, trial.len() - rows.len()))
}

/// Extracts the force from a trial with `throttle`, `thrust_n` and `height_m`; `deck_velocity_mps` and
/// `vehicle_velocity_mps` are zero where there is no such channel. All inputs are shifted by the dead time of
/// the thrust card, so that they are as late as the load cell is.
///
/// # Errors
/// A channel that is missing, or a thrust card that cannot be run on the trial.
pub fn prepare(trial: &Trial, thrust_card: &Card) -> Result<GroundTrial> {
    let measured = trial.require("thrust_n")?;
    let throttle = trial.require("throttle")?;
    let height = trial.require("height_m")?;
    let zeros = vec![0.0; trial.len()];
    // The load cell measures the ground effect as well, so the run cannot start from its reading. It starts from rest at
    // the first throttle.
    let free_air_thrust_n = thrust::free_air(thrust_card, trial.name(), trial.time_s(), throttle)?;
    let force_n = measured
        .iter()
        .zip(&free_air_thrust_n)
        .map(|(f, t)| f - t)
        .collect();
    let truth_n = match (
        trial.channel("truth_thrust_n"),
        trial.channel("truth_free_air_n"),
    ) {
        (Some(total), Some(free)) => Some(total.iter().zip(free).map(|(f, t)| f - t).collect()),
        _ => None,
    };
    // The load cell is as late for the ground effect as it was for the thrust.
    let dead_time_s = thrust::dead_time_s(thrust_card);
    let late = |values: &[f64]| delayed(trial.time_s(), values, dead_time_s);
    let or_zero = |name| trial.channel(name).map_or_else(|| zeros.clone(), late);
    Ok(GroundTrial {
        name: trial.name().to_string(),
        time_s: trial.time_s().to_vec(),
        throttle: late(throttle),
        height_m: late(height),
        deck_velocity_mps: or_zero("deck_velocity_mps"),
        vehicle_velocity_mps: or_zero("vehicle_velocity_mps"),
        free_air_thrust_n,
        force_n,
        truth_n,
    })
}

/// The force (N) that a card predicts over a trial in free run, from the true force at its start where
/// it is known, else from the mean of the first 0.2 s.
///
/// # Errors
/// A card that does not fit the trial.
pub fn predict(card: &Card, trial: &GroundTrial) -> Result<Vec<f64>> {
    predict_by(&Predictor::new(card)?, trial)
}

/// As [`predict`], by a card that is prepared already.
pub(super) fn predict_by(predictor: &Predictor, trial: &GroundTrial) -> Result<Vec<f64>> {
    let start = match &trial.truth_n {
        Some(truth) => truth.first().copied().unwrap_or(0.0),
        None => {
            let n = trial
                .time_s
                .partition_point(|t| t - trial.time_s[0] <= 0.2)
                .max(1);
            let finite: Vec<f64> = trial
                .force_n
                .iter()
                .take(n)
                .copied()
                .filter(|v| v.is_finite())
                .collect();
            if finite.is_empty() {
                return Err(Error::data(&trial.name, "a force at the start", "a gap"));
            }
            finite.iter().sum::<f64>() / finite.len() as f64
        }
    };
    let run =
        |trial: &GroundTrial| predictor.run(&trial.name, &trial.time_s, &trial.columns(), start);
    match FineTrial::of(trial) {
        Some(fine) => Ok(fine.at_rows(&run(&fine.trial)?)),
        None => run(trial),
    }
}

impl GroundTrial {
    /// Some of the rows.
    #[must_use]
    pub fn part(&self, rows: Range<usize>) -> Self {
        let of = |column: &[f64]| column[rows.clone()].to_vec();
        Self {
            name: self.name.clone(),
            time_s: of(&self.time_s),
            throttle: of(&self.throttle),
            height_m: of(&self.height_m),
            deck_velocity_mps: of(&self.deck_velocity_mps),
            vehicle_velocity_mps: of(&self.vehicle_velocity_mps),
            free_air_thrust_n: of(&self.free_air_thrust_n),
            force_n: of(&self.force_n),
            truth_n: self.truth_n.as_deref().map(of),
        }
    }

    /// The columns for prediction.
    #[must_use]
    pub fn columns(&self) -> Columns<'_> {
        Columns {
            throttle: &self.throttle,
            height_m: &self.height_m,
            deck_velocity_mps: &self.deck_velocity_mps,
            vehicle_velocity_mps: &self.vehicle_velocity_mps,
            free_air_thrust_n: &self.free_air_thrust_n,
            battery_v: &[],
        }
    }

    /// The force, smoothed, and its derivative.
    pub(super) fn smooth_force(&self, filter: &SavitzkyGolay) -> Result<Smoothed> {
        filter.apply(&self.time_s, &self.force_n).map_err(|e| {
            let expected = format!("an unbroken force over {} samples", filter.window());
            Error::data(&self.name, expected, e.to_string())
        })
    }

    /// What errors are taken against: the truth where it is known, else the measurement.
    #[must_use]
    pub fn reference_n(&self) -> &[f64] {
        self.truth_n.as_deref().unwrap_or(&self.force_n)
    }
}

/// A record of each trial for shooting, with the inputs that `pick` takes from it and its course of states to start from;
/// every trial is a group for standard errors.
pub(super) fn records<'a, const N: usize>(
    trials: &'a [GroundTrial],
    starts: Option<&'a [Vec<f64>]>,
    pick: impl Fn(&'a GroundTrial) -> [&'a [f64]; N],
) -> Vec<Record<'a>> {
    let record = |(group, trial): (usize, &'a GroundTrial)| Record {
        time: &trial.time_s,
        inputs: pick(trial).to_vec(),
        measured: &trial.force_n,
        start: starts.iter().map(|s| s[group].as_slice()).collect(),
        group,
    };
    trials.iter().enumerate().map(record).collect()
}

/// Every trial is a group.
pub(super) fn clusters(trials: &[GroundTrial], coefficients: usize) -> Clusters {
    Clusters {
        groups: trials.len(),
        coefficients,
    }
}

/// Greatest thrust out of ground effect (N).
pub(super) fn greatest_n(trials: &[GroundTrial]) -> f64 {
    let thrusts = trials.iter().flat_map(|t| &t.free_air_thrust_n);
    thrusts.copied().fold(0.0, f64::max)
}

/// Rows of all trials.
pub(super) fn rows(trials: &[GroundTrial]) -> usize {
    trials.iter().map(|t| t.time_s.len()).sum()
}

/// Whether a term has the deck's velocity.
pub(super) fn is_of_deck_velocity(term: &Term) -> bool {
    term.of == "k" || term.expression.contains("v_p")
}

/// The terms of a form with memory that are zero throughout the data, because the deck's velocity is.
pub(super) fn zero_terms(card: &Card, trials: &[GroundTrial]) -> Vec<String> {
    let velocities = || trials.iter().flat_map(|t| &t.deck_velocity_mps);
    if velocities().any(|v| *v != 0.0) {
        return Vec::new();
    }
    let of_velocity = card.terms.iter().filter(|t| is_of_deck_velocity(t));
    of_velocity
        .map(|t| format!("{}:{}", t.of, t.expression))
        .collect()
}

/// Sets a card's validity box to what the trials covered.
pub(super) fn validity(card: &mut Card, trials: &[GroundTrial], settings: &IdentificationSettings) {
    type Column = fn(&GroundTrial) -> &[f64];
    let columns: [(&str, Column); 5] = [
        ("z", |t| &t.height_m),
        ("s", |t| &t.throttle),
        ("v_p", |t| &t.deck_velocity_mps),
        ("v_q", |t| &t.vehicle_velocity_mps),
        ("T", |t| &t.free_air_thrust_n),
    ];
    for (symbol, column) in columns {
        if let Some(box_) = range(trials.iter().flat_map(|t| column(t).iter().copied())) {
            card.validity.inputs.insert(symbol.to_string(), box_);
        }
    }
    if card.form != Form::Derivative {
        card.validity.output = Some(settings.ground_effect.ratio_limits);
    }
    let moves = card
        .validity
        .inputs
        .get("v_q")
        .is_some_and(|[lo, hi]| hi > lo);
    if card.terms.iter().any(is_of_deck_velocity) && !moves {
        card.validity.velocity_input = Some(settings.ground_effect.velocity_input);
        card.warnings.push(Warning::VehicleStoodStill.to_string());
    }
}
