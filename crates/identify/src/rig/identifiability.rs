//! Before the fit: what the data identify, and what to record to cure what they do not.

use std::fmt;

use serde::{Serialize, Serializer};
use sindy::statistics::regression::least_squares;
use sindy::trajectory::delay::{apparent_delay, first_order_lag};
use sindy::uncertainty::identifiability::{self, examine};
use sindy::{Gram, Library, Samples};
use touchdown_model::Form;

use super::GroundTrial;
use super::data_check::{self, DataWarning};
use super::derivative::{live_library, samples, zero_terms};
use super::statics::{StaticMap, psi};
use crate::settings::IdentificationSettings;
use crate::thrust::plateau::median;

/// Lag around which confounding is judged (s): the middle of what wakes of small rotors show.
/// It only serves to weigh the data: the fit itself has a free lag.
const NOMINAL_LAG_S: f64 = 0.2;
/// Variance inflation from which lag and velocity count as confounded.
/// The usual limit of a variance inflation factor (Marquardt 1970).
const CONFOUNDED_FROM: f64 = 10.0;
/// Condition from which coefficients trade off against each other.
/// The usual limit of a condition index (Belsley, Kuh and Welsch 1980).
const CONDITION_FROM: f64 = 30.0;
/// Largest shift that delays are searched in (s).
/// Five nominal lags; longer shifts find the period of the motion instead.
const LONGEST_DELAY_S: f64 = 1.0;

/// What the data identify.
#[derive(Clone, Debug, Serialize)]
pub struct Identifiability {
    /// The library of eq. (9) on these data.
    pub library: identifiability::Identifiability,
    /// Library terms that are zero throughout the data and therefore removed.
    pub left_out: Vec<String>,
    /// Variance inflation of the lag by the velocity terms: how much less information the data contain on the lag once
    /// the velocity terms are fitted as well.
    pub lag_inflation: f64,
    /// Whether lag and deck velocity are confounded.
    pub confounded: bool,
    /// Apparent delay (dead time and lag) of the force behind its static value, median over the trials in
    /// which height moves (s).
    pub force_delay_s: Option<f64>,
    /// What to record to cure what is missing, or to correct in the map.
    pub advice: Vec<Advice>,
}

/// What to record to cure what is missing, or to correct in the map, with the figure that shows the need; a sentence in results.
#[derive(Clone, Debug, PartialEq)]
pub enum Advice {
    /// Unit, sign or zero of a channel is in doubt.
    Correct(DataWarning),
    /// Terms in v_q are zero throughout the data.
    MoveVehicle,
    /// An input hardly moves.
    Vary {
        /// Its name.
        input: String,
        /// Its standard deviation.
        sd: f64,
    },
    /// Lag and deck velocity are confounded.
    AddMultiSine {
        /// Variance inflation of the lag by the velocity terms.
        lag_inflation: f64,
    },
    /// Coefficients of eq. (9) trade off against each other.
    RecordIndependently {
        /// Condition of its library on these data.
        condition: f64,
    },
}

/// Examines `trials` before anything is fitted.
///
/// # Errors
/// Heights or thrusts that no force rig measures, or data that the library cannot be evaluated on.
pub fn examine_trials(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
) -> crate::Result<Identifiability> {
    let doubts = data_check::check(trials, &settings.ground_effect)?;
    let samples = samples(trials, settings)?;
    let (library, grams) = live_library(&samples, settings)?;
    let report = examine(&library, &Gram::total(&grams), &samples)?;
    let left_out = zero_terms(&library, settings);
    let lengths = settings.ground_effect.lengths_m();
    let h = StaticMap::fit(trials, lengths)?.coefficients();
    let lag_inflation = lag_inflation(trials, h, lengths)?;
    let mut found = Identifiability {
        library: report,
        left_out,
        lag_inflation,
        confounded: !(lag_inflation < CONFOUNDED_FROM),
        force_delay_s: force_delay(trials, h, lengths),
        advice: doubts.into_iter().map(Advice::Correct).collect(),
    };
    let records = found.records();
    found.advice.extend(records);
    Ok(found)
}

impl Identifiability {
    /// What to correct and to record for forms: the library of eq. (9) matters to that form alone.
    pub fn advice_for(&self, forms: &[Form]) -> impl Iterator<Item = &Advice> {
        let of_library = forms.contains(&Form::Derivative);
        let advice = self.advice.iter();
        advice.filter(move |a| of_library || !matches!(a, Advice::RecordIndependently { .. }))
    }

    /// What to record.
    fn records(&self) -> Vec<Advice> {
        let mut advice = Vec::new();
        if self.left_out.iter().any(|t| t.contains("v_q")) {
            advice.push(Advice::MoveVehicle);
        }
        let inputs = self.library.inputs.iter().filter(|i| i.hardly_excited);
        advice.extend(inputs.map(|i| Advice::Vary {
            input: i.name.clone(),
            sd: i.sd,
        }));
        if self.confounded {
            advice.push(Advice::AddMultiSine {
                lag_inflation: self.lag_inflation,
            });
        }
        let condition = self.library.condition;
        if condition > CONDITION_FROM {
            advice.push(Advice::RecordIndependently { condition });
        }
        advice
    }
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Correct(doubt) => doubt.fmt(f),
            Self::MoveVehicle => f.write_str(
                "the vehicle never moved: terms in v_q cannot be identified on this rig; move the vehicle, or treat v_q as an \
                 approximation in flight",
            ),
            Self::Vary { input, sd } => write!(f, "`{input}` hardly moved (sd {sd:.3}): vary it"),
            Self::AddMultiSine { lag_inflation } => write!(
                f,
                "lag and deck velocity are confounded (variance inflation {lag_inflation:.0}): add multi-sine deck motion, \
                 0.6 to 7 rad/s, so that fast and slow motion at the same height differ"
            ),
            Self::RecordIndependently { condition } => write!(
                f,
                "the library of eq. (9) has condition {condition:.0}: its single coefficients mean little, only their sum \
                 does; use bounded functions of height, or record more heights and throttles independently"
            ),
        }
    }
}

impl Serialize for Advice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn static_ratio(h: [f64; 4], lengths: [f64; 3], z: f64) -> f64 {
    h[0] + (0..3)
        .map(|i| h[i + 1] / (1.0 + (z / lengths[i]).powi(2)))
        .sum::<f64>()
}

/// Variance inflation of the lag: the sensitivity of the lagged static map to its lag, regressed on the
/// velocity terms and on the sensitivities to the map's own coefficients.
fn lag_inflation(trials: &[GroundTrial], h: [f64; 4], lengths: [f64; 3]) -> crate::Result<f64> {
    let mut samples = Samples::new(&["z", "v_p", "by_lag"]);
    let step = 0.05 * NOMINAL_LAG_S;
    for t in trials {
        let map: Vec<f64> = t
            .height_m
            .iter()
            .map(|&z| static_ratio(h, lengths, z))
            .collect();
        let more = first_order_lag(&t.time_s, &map, NOMINAL_LAG_S + step, 0.0);
        let less = first_order_lag(&t.time_s, &map, NOMINAL_LAG_S - step, 0.0);
        let by_lag = more
            .iter()
            .zip(&less)
            .map(|(a, b)| (a - b) / (2.0 * step))
            .collect();
        samples.push_group(vec![
            t.height_m.clone(),
            t.deck_velocity_mps.clone(),
            by_lag,
        ])?;
    }
    let [p1, p2, p3] = psi(lengths);
    let velocity = format!("v_p*{p3}");
    let library = Library::parse(&["1".into(), p1, p2, p3, "v_p".into(), velocity])?;
    let gram = Gram::total(&Gram::accumulate(&library, "by_lag", &samples)?);
    if gram.yty <= 0.0 {
        return Ok(f64::INFINITY);
    }
    let fit = least_squares(&gram, &[true; 6]);
    Ok(gram.yty / gram.residual_sum(&fit))
}

/// Median apparent delay of the measured ratio behind the static one.
fn force_delay(trials: &[GroundTrial], h: [f64; 4], lengths: [f64; 3]) -> Option<f64> {
    let delays: Vec<f64> = trials
        .iter()
        .filter_map(|t| {
            let dt = (t.time_s.last()? - t.time_s.first()?) / (t.time_s.len().max(2) - 1) as f64;
            let expected: Vec<f64> = t
                .height_m
                .iter()
                .zip(&t.free_air_thrust_n)
                .map(|(&z, thrust)| thrust * static_ratio(h, lengths, z))
                .collect();
            let moves = t.height_m.iter().any(|z| (z - t.height_m[0]).abs() > 1e-3);
            let found = apparent_delay(
                &expected,
                &t.force_n,
                (LONGEST_DELAY_S / dt).round() as usize,
            )?;
            (moves && found.correlation > 0.8).then_some(found.samples * dt)
        })
        .collect();
    median(delays.into_iter())
}
