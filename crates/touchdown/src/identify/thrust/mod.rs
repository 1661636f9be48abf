//! Throttle to thrust: static maps, lags, eq. (7) and eq. (8).

mod dynamic;
mod lagged;
pub mod plateau;
mod rotor;
mod search;
mod statics;

pub use dynamic::{first_order, library};

use touchdown_model::Card;
use touchdown_model::card::Form;
use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::identify::making::{Made, Origin};
use crate::identify::settings::{IdentificationSettings, ThrustForm};
use crate::predict::{Columns, Predictor};

/// Rows up to which a trial without plateaus is read as one steady point a row.
const FEW_ROWS: usize = 60;

/// Fits one card to `trials` together, in the form of the settings or, without one, in the form that the
/// data call for: plateaus give a static map, single motors' throttles a lag on each, several trials the
/// library of eq. (8), one trial eq. (7).
///
/// # Errors
/// A channel that the form needs and that a trial lacks, or too few data.
pub fn fit(trials: &[Trial], settings: &IdentificationSettings, origin: &Origin) -> Result<Made> {
    let form = match settings.thrust.form {
        Some(form) => form,
        None => choose(trials, settings)?,
    };
    let mut made = match form {
        ThrustForm::StaticSqrt | ThrustForm::StaticThrust => {
            statics::fit(trials, settings, form, origin)
        }
        ThrustForm::LaggedMotors => lagged::fit(trials, settings, origin),
        ThrustForm::FirstOrder => first_order(trials, settings, origin),
        ThrustForm::Library => library(trials, settings, origin),
    }?;
    made.card.warnings.extend(made.warnings.iter().cloned());
    Ok(made)
}

fn choose(trials: &[Trial], settings: &IdentificationSettings) -> Result<ThrustForm> {
    let mut steady = true;
    for trial in trials {
        let found = plateau::find(trial, settings.thrust.settle_s)?;
        steady &= found.len() >= 4 || trial.len() <= FEW_ROWS;
    }
    Ok(if steady {
        ThrustForm::StaticSqrt
    } else if trials.iter().all(|t| t.channel("throttle_1").is_some()) {
        ThrustForm::LaggedMotors
    } else if trials.len() > 1 {
        ThrustForm::Library
    } else {
        ThrustForm::FirstOrder
    })
}

/// The throttles of single motors (`throttle_1`, `throttle_2`, …), or the one `throttle`.
fn motors(trial: &Trial) -> Result<Vec<&[f64]>> {
    let each: Vec<&[f64]> = (1..)
        .map_while(|k| trial.channel(&format!("throttle_{k}")))
        .collect();
    if each.is_empty() {
        Ok(vec![trial.require("throttle")?])
    } else {
        Ok(each)
    }
}

/// The mean throttle: `throttle`, or the mean of the single motors' where there is no such channel.
fn throttle(trial: &Trial) -> Result<Vec<f64>> {
    if let Some(values) = trial.channel("throttle") {
        return Ok(values.to_vec());
    }
    let each = motors(trial)?;
    let n = each.len() as f64;
    Ok((0..trial.len())
        .map(|i| each.iter().map(|c| c[i]).sum::<f64>() / n)
        .collect())
}

/// A signal `delay_s` later: interpolated linearly, held at its first value before that.
#[must_use]
pub fn delayed(time: &[f64], values: &[f64], delay_s: f64) -> Vec<f64> {
    if delay_s == 0.0 {
        return values.to_vec();
    }
    let mut k = 0;
    time.iter()
        .map(|&now| {
            let t = now - delay_s;
            while k + 1 < time.len() && time[k + 1] <= t {
                k += 1;
            }
            if t <= time[0] || k + 1 >= time.len() {
                return values[k];
            }
            let share = (t - time[k]) / (time[k + 1] - time[k]);
            values[k] + share * (values[k + 1] - values[k])
        })
        .collect()
}

/// The dead time of a thrust card [s]; zero where it has none.
#[must_use]
pub fn dead_time_s(card: &Card) -> f64 {
    card.coefficient("dead_time", "1")
}

/// The free-air thrust [N] of a card along a throttle, from rest at its first value.
///
/// # Errors
/// A card that does not run on throttle alone, or an empty or gappy throttle.
pub fn free_air(card: &Card, name: &str, time: &[f64], throttle: &[f64]) -> Result<Vec<f64>> {
    let Some(&first) = throttle.first().filter(|s| s.is_finite()) else {
        return Err(Error::data(name, "a throttle at the first sample", "none"));
    };
    let dynamic = matches!(card.form, Form::Library | Form::FirstOrder)
        || card.form == Form::StaticSqrt && card.terms_of("T_m").next().is_some();
    let start = if dynamic {
        card.thrust_model()?.rest(first).powi(2)
    } else {
        0.0
    };
    let columns = Columns {
        throttle,
        ..Columns::default()
    };
    Predictor::new(card)?.run(name, time, &columns, start)
}

/// The thrust [N] that a card predicts over a trial in free run, from the measured thrust at its start
/// (the mean of the first 0.1 s).
///
/// # Errors
/// A card that does not run on the trial's channels.
pub fn predict(card: &Card, trial: &Trial) -> Result<Vec<f64>> {
    match card.form {
        Form::LaggedMotors => return lagged::predict(card, trial),
        Form::RotorLag => {
            return Err(Error::data(
                &card.name,
                "a thrust model",
                "a rotor-speed model",
            ));
        }
        _ => {}
    }
    let time = trial.time_s();
    let throttle = delayed(time, &throttle(trial)?, dead_time_s(card));
    let thrust = trial.require("thrust_n")?;
    let near: Vec<f64> = time
        .iter()
        .zip(thrust)
        .take_while(|(t, _)| **t <= time[0] + 0.1)
        .map(|(_, f)| *f)
        .filter(|f| f.is_finite())
        .collect();
    let start = if near.is_empty() {
        thrust
            .iter()
            .copied()
            .find(|f| f.is_finite())
            .unwrap_or(0.0)
    } else {
        near.iter().sum::<f64>() / near.len() as f64
    };
    let columns = Columns {
        throttle: &throttle,
        battery_v: trial.channel("battery_v").unwrap_or(&[]),
        ..Columns::default()
    };
    Predictor::new(card)?.run(trial.name(), time, &columns, start)
}
