//! One card on one trial, in free run: what `touchdown validate` and the Python package report.

use std::ops::Range;

use touchdown_model::{Card, Form};
use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::flights::FlightSettings;
use crate::flights::judge::{FlightCards, Held, IntervalFactors, judge};
use crate::prediction::time_constants_s;
use crate::rig::{self as ground_effect, GroundTrial};
use crate::scores::Errors;
use crate::settings::GroundEffectSettings;
use crate::thrust;
use crate::thrust::unbroken::unbroken;
use crate::thrust_scale::ThrustCause;

/// A free run with its errors (N).
#[derive(Clone, Debug)]
pub struct FreeRun {
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Measured force (N).
    pub measured_n: Vec<f64>,
    /// True force (N), where the log is of the virtual rig.
    pub truth_n: Option<Vec<f64>>,
    /// Predicted force (N).
    pub predicted_n: Vec<f64>,
    /// Against the measurement.
    pub measured: Errors,
    /// Against the truth.
    pub truth: Option<Errors>,
    /// The measurement against the truth.
    pub noise_floor: Option<Errors>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Scale and height offset of each armed interval, where the log is one of a flight.
    pub intervals: Vec<IntervalFactors>,
}

/// Share of a range by which an input may leave the card's validity box without a warning.
const SLACK: f64 = 0.01;

/// Lags of a card that a log lasts at least: after three, 5 % of an error at the start remain.
const LEAST_LAGS: f64 = 3.0;
/// Rows that errors are of at least: a root mean square of ten errors is uncertain by 22 %.
const LEAST_ROWS: usize = 10;

/// A thrust card on the trial of a stand. After a hole in the log the free run starts again.
///
/// # Errors
/// Channels that the card needs and the trial lacks, or no row with a measurement and a prediction.
pub fn judge_thrust(card: &Card, trial: &Trial) -> Result<FreeRun> {
    let parts = Parts::of(card, trial.time_s());
    let predicted = parts.run(|rows| {
        let time = trial.time_s();
        thrust::predict(card, &trial.window(time[rows.start], time[rows.end - 1])?)
    })?;
    let measured = trial.require("thrust_n")?;
    let noise_floor = trial
        .channel("truth_thrust_n")
        .and_then(|truth| Errors::of(measured, truth));
    let throttle = thrust::throttle(trial)?;
    let mut warnings = leaves_box(card, "s", "throttle", &throttle);
    warnings.extend(parts.warning());
    let cause = ThrustCause::of(&predicted, measured);
    warnings
        .extend(cause.map(|cause| format!("the measured thrust is not that of the card. {cause}")));
    let gaps = predicted.iter().filter(|p| p.is_nan()).count();
    if gaps > 0 {
        warnings.push(format!(
            "{gaps} of {} rows have a gap in an input; they do not enter the errors",
            trial.len()
        ));
    }
    finish(
        trial.name(),
        &parts,
        measured.to_vec(),
        trial.channel("truth_free_air_n").map(<[f64]>::to_vec),
        predicted,
        noise_floor,
        warnings,
    )
}

/// A ground-effect card on a prepared trial of a force rig; `trial` is the whole one. After a hole in the log the free run
/// starts again.
///
/// # Errors
/// As of [`judge_thrust`].
pub fn judge_ground(card: &Card, ground: &GroundTrial, trial: &Trial) -> Result<FreeRun> {
    let noise_floor = match (trial.channel("thrust_n"), trial.channel("truth_thrust_n")) {
        (Some(measured), Some(truth)) => Errors::of(measured, truth),
        _ => None,
    };
    let mut warnings = leaves_box(card, "z", "height", &ground.height_m);
    warnings.extend(leaves_box(card, "s", "throttle", &ground.throttle));
    warnings.extend(data_doubts(card, ground));
    let parts = Parts::of(card, &ground.time_s);
    warnings.extend(parts.warning());
    let predicted = parts.run(|rows| {
        // A prepared trial has no gaps: what is no number is a run that has left all bounds.
        let run = ground_effect::predict(card, &ground.part(rows))?.into_iter();
        Ok(run
            .map(|f| if f.is_nan() { f64::INFINITY } else { f })
            .collect())
    })?;
    finish(
        &ground.name,
        &parts,
        ground.force_n.clone(),
        ground.truth_n.clone(),
        predicted,
        noise_floor,
        warnings,
    )
}

/// Units, signs and zeros of the log that cannot be right, or do not fit together.
fn data_doubts(card: &Card, ground: &GroundTrial) -> Vec<String> {
    let mut settings = GroundEffectSettings::default();
    let radius_m = card.vehicle.rotor_radius_m;
    settings.rotor_radius_m = radius_m.unwrap_or(settings.rotor_radius_m);
    let mut lengths_m = settings.lengths_m();
    for (length, name) in lengths_m.iter_mut().zip(["l1", "l2", "l3"]) {
        *length = card.constants.get(name).copied().unwrap_or(*length);
    }
    settings.lengths_m = Some(lengths_m);
    ground_effect::data_check::check(std::slice::from_ref(ground), &settings).map_or_else(
        |refusal| vec![refusal.to_string()],
        |doubts| doubts.iter().map(ToString::to_string).collect(),
    )
}

/// A card on the log of a flight: by the specific force, in each armed interval.
///
/// # Errors
/// Those of [`judge`].
pub fn judge_flight(
    cards: &FlightCards<'_>,
    trial: &Trial,
    settings: &FlightSettings,
    held: Held,
) -> Result<FreeRun> {
    let flight = judge(trial, cards, settings, held)?;
    let judged: Vec<f64> = flight
        .throttle
        .iter()
        .zip(&flight.measured_n)
        .map(|(s, f)| if f.is_finite() { *s } else { f64::NAN })
        .collect();
    let mut warnings = leaves_box(cards.thrust, "s", "throttle", &judged);
    if let Some(card) = cards.ground_effect {
        // Above the box the model fades; below it nothing was identified.
        warnings.extend(leaves_box_below(card, "z", "height", &flight.height_m));
    }
    for interval in flight
        .intervals
        .iter()
        .filter(|i| i.height_offset_is_at_bound)
    {
        warnings.push(format!(
            "the height offset of armed interval {} is at its bound of {:.3} m: the card does not predict it, or its heights have \
             another zero; state it by --height-offset",
            interval.number,
            interval.height_offset_m.unwrap_or(f64::NAN)
        ));
    }
    let mut out = finish(
        trial.name(),
        &Parts::of_flight(flight.time_s),
        flight.measured_n,
        None,
        flight.predicted_n,
        None,
        warnings,
    )?;
    out.intervals = flight.intervals;
    Ok(out)
}

/// The rows of a log that free runs go through, each from a start of its own.
struct Parts {
    time_s: Vec<f64>,
    rows: Vec<Range<usize>>,
    /// Whether a run starts from the measurement. Lagged motors start at rest under their command.
    from_measurement: bool,
    /// Longest time constant of a card with a state (s).
    lag_s: Option<f64>,
}

impl Parts {
    /// A card without a state runs through holes.
    fn of(card: &Card, time_s: &[f64]) -> Self {
        let from_measurement = card.equations().is_ok_and(|e| e.rate.is_some());
        let has_state = from_measurement || card.form == Form::LaggedMotors;
        let lag_s = time_constants_s(card).reduce(f64::max);
        let mut rows = match has_state {
            true => unbroken(time_s),
            false => std::iter::once(0..time_s.len()).collect(),
        };
        rows.retain(|rows| !rows.is_empty());
        Self {
            time_s: time_s.to_vec(),
            rows,
            from_measurement,
            lag_s: lag_s.filter(|_| has_state),
        }
    }

    /// A flight: its runs start from the commands, in each armed interval.
    fn of_flight(time_s: Vec<f64>) -> Self {
        Self {
            rows: std::iter::once(0..time_s.len()).collect(),
            time_s,
            from_measurement: false,
            lag_s: None,
        }
    }

    /// The runs of all parts, one after the other. A part that cannot be run is a gap, unless it is the only one.
    fn run(&self, run: impl Fn(Range<usize>) -> Result<Vec<f64>>) -> Result<Vec<f64>> {
        let mut runs: Vec<Result<Vec<f64>>> = self.rows.iter().cloned().map(run).collect();
        if runs.iter().all(Result::is_err) && !runs.is_empty() {
            return runs.swap_remove(0);
        }
        let lengths = self.rows.iter().map(Range::len);
        let filled = runs
            .into_iter()
            .zip(lengths)
            .map(|(run, rows)| run.unwrap_or_else(|_| vec![f64::NAN; rows]));
        Ok(filled.flatten().collect())
    }

    /// The holes in a sentence.
    fn warning(&self) -> Option<String> {
        let starts = self.rows.iter().skip(1).map(|rows| rows.start);
        let holes = starts.map(|row| self.time_s[row] - self.time_s[row - 1]);
        let longest_s = holes.reduce(f64::max)?;
        Some(format!(
            "holes in the log: {}, the longest of {longest_s:.2} s. The free run starts again after each",
            self.rows.len() - 1
        ))
    }

    /// Removes what a run was given at its start from what its errors are of.
    fn without_starts(&self, predicted: &[f64], reference: &[f64]) -> Vec<f64> {
        let known = predicted.iter().zip(reference);
        let mut reference: Vec<f64> = known
            .map(|(p, r)| if p.is_nan() { f64::NAN } else { *r })
            .collect();
        if self.from_measurement {
            for rows in &self.rows {
                let first = rows.clone().find(|row| !predicted[*row].is_nan());
                first.into_iter().for_each(|row| reference[row] = f64::NAN);
            }
        }
        reference
    }

    /// Why the errors of so many rows say little.
    fn too_short(&self, samples: usize) -> Option<String> {
        let lasts = |rows: &Range<usize>| self.time_s[rows.end - 1] - self.time_s[rows.start];
        let longest_s = self.rows.iter().map(lasts).fold(0.0, f64::max);
        match self.lag_s {
            Some(lag_s) if longest_s < LEAST_LAGS * lag_s => Some(format!(
                "the free run lasts {longest_s:.3} s, less than three times the lag of {lag_s:.3} s: its start decides its \
                 errors. Use a longer log"
            )),
            _ if samples < LEAST_ROWS => Some(format!(
                "rows with an error: {samples}, so the errors are uncertain by {:.0} %. Use a longer log",
                100.0 / (2.0 * samples as f64).sqrt()
            )),
            _ => None,
        }
    }
}

fn finish(
    name: &str,
    parts: &Parts,
    measured_n: Vec<f64>,
    truth_n: Option<Vec<f64>>,
    predicted_n: Vec<f64>,
    noise_floor: Option<Errors>,
    mut warnings: Vec<String>,
) -> Result<FreeRun> {
    let against = |reference: &[f64]| {
        // A gap in the inputs is a gap in the prediction: there is nothing to compare.
        Errors::of(&predicted_n, &parts.without_starts(&predicted_n, reference))
    };
    let measured = against(&measured_n).ok_or_else(|| {
        let expected = match parts.from_measurement {
            true => "rows with a measurement and a prediction after the first, which the free run starts from",
            false => "rows with a measurement and a prediction",
        };
        Error::data(name, expected, "none")
    })?;
    if !measured.worst.is_finite() {
        warnings.push("the free run diverges".to_string());
    }
    warnings.extend(parts.too_short(measured.samples));
    Ok(FreeRun {
        truth: truth_n.as_deref().and_then(against),
        measured,
        noise_floor,
        time_s: parts.time_s.clone(),
        measured_n,
        truth_n,
        predicted_n,
        warnings,
        intervals: Vec::new(),
    })
}

/// Warns if an input leaves the card's validity box.
fn leaves_box(card: &Card, symbol: &str, name: &str, values: &[f64]) -> Vec<String> {
    let range = card.validity.inputs.get(symbol);
    range.map_or_else(Vec::new, |range| leaves(*range, name, values))
}

/// The same, below alone.
fn leaves_box_below(card: &Card, symbol: &str, name: &str, values: &[f64]) -> Vec<String> {
    let range = card.validity.inputs.get(symbol);
    let within = |[lo, hi]: [f64; 2]| {
        let below: Vec<f64> = values.iter().map(|v| v.min(hi)).collect();
        leaves([lo, hi], name, &below)
    };
    range.map_or_else(Vec::new, |range| within(*range))
}

fn leaves([lo, hi]: [f64; 2], name: &str, values: &[f64]) -> Vec<String> {
    let known = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (
        known().fold(f64::INFINITY, f64::min),
        known().fold(f64::NEG_INFINITY, f64::max),
    );
    let slack = SLACK * (hi - lo);
    if low >= lo - slack && high <= hi + slack {
        return Vec::new();
    }
    // As many digits as the slack has.
    let digits = (-slack.log10()).ceil().clamp(3.0, 9.0) as usize;
    let [low, high, lo, hi] = [low, high, lo, hi].map(|v| format!("{v:.digits$}"));
    vec![format!(
        "{name} of {low} to {high} is outside the card's validity box of {lo} to {hi}"
    )]
}
