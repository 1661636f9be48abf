//! Throttle to thrust: static maps, lags, eq. (7) and eq. (8).

mod first_order;
mod lagged;
mod library;
pub mod plateau;
mod record;
mod rotor;
mod search;
mod sign;
mod statics;

pub use first_order::first_order;
pub use library::library;
pub use statics::steady_points;

use lagged::LaggedMotors;

use std::ops::Range;

use touchdown_model::Card;
use touchdown_model::card::{Form, Kind};
use touchdown_trial::Trial;

use crate::delayed::delayed;
use crate::error::{Error, Result};
use crate::fitted::{FittedCard, Origin};
use crate::prediction::{Columns, Predictor};
use crate::settings::{IdentificationSettings, ThrustForm};
use crate::warning::sentences;

/// Rows up to which a trial without plateaus is read as one steady point a row.
/// Tables of manufacturers have up to 40 rows; a record of a second has more than 60.
const FEW_ROWS: usize = 60;

/// Smallest motion of the throttle that a dynamic model is fitted to.
/// The resolution of a command in microseconds.
const LEAST_MOTION: f64 = 1e-3;

/// Fits one card to `trials` together, in the form of the settings or, without one, in the form that the
/// data call for: plateaus give a static map, single motors' throttles a lag on each, several trials the
/// library of eq. (8), one trial eq. (7).
///
/// # Errors
/// A channel that the form needs and that a trial lacks, or too few data.
pub fn fit(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    for trial in trials {
        sign::check(trial, &throttle(trial)?)?;
    }
    let form = match settings.thrust.form {
        Some(form) => form,
        None => choose(trials, settings)?,
    };
    let mut fitted = match form {
        ThrustForm::StaticSqrt | ThrustForm::StaticThrust => {
            statics::fit(trials, settings, form, origin)
        }
        ThrustForm::LaggedMotors => {
            let motors = LaggedMotors::fit(trials, &settings.thrust)?;
            Ok(motors.card(trials, &settings.thrust, origin))
        }
        ThrustForm::FirstOrder => first_order(trials, settings, origin),
        ThrustForm::Library => library(trials, settings, origin),
    }?;
    fitted.check_finite()?;
    fitted.card.warnings.extend(sentences(&fitted.warnings));
    Ok(fitted)
}

fn choose(trials: &[Trial], settings: &IdentificationSettings) -> Result<ThrustForm> {
    let mut steady = true;
    for trial in trials {
        let found = plateau::find(trial, settings.thrust.settle_s)?;
        steady &= found.len() >= statics::STAIRCASE || trial.len() <= FEW_ROWS;
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
///
/// # Errors
/// A trial that has neither.
pub fn throttle(trial: &Trial) -> Result<Vec<f64>> {
    if let Some(values) = trial.channel("throttle") {
        return Ok(values.to_vec());
    }
    let each = motors(trial)?;
    let n = each.len() as f64;
    Ok((0..trial.len())
        .map(|i| each.iter().map(|c| c[i]).sum::<f64>() / n)
        .collect())
}

/// The dead time of a thrust card (s); zero where it has none.
#[must_use]
pub fn dead_time_s(card: &Card) -> f64 {
    card.coefficient("dead_time", "1")
}

/// The free-air thrust (N) of a card along a throttle, from the steady state of its first value.
///
/// # Errors
/// A card that does not run on throttle alone, or an empty or gappy throttle.
pub fn free_air(card: &Card, name: &str, time: &[f64], throttle: &[f64]) -> Result<Vec<f64>> {
    let Some(&first) = throttle.first() else {
        return Err(Error::data(name, "at least one sample", "none"));
    };
    if let Some(row) = throttle.iter().position(|s| !s.is_finite()) {
        let found = format!("a gap at {} s", time.get(row).unwrap_or(&f64::NAN));
        return Err(Error::data(name, "a throttle in every row", found));
    }
    let dynamic = matches!(card.form, Form::Library | Form::FirstOrder)
        || card.form == Form::StaticSqrt && card.terms_of("T_m").next().is_some();
    let start = if dynamic {
        card.thrust_model()?.rest(first).powi(2)
    } else {
        0.0
    };
    let late = delayed(time, throttle, dead_time_s(card));
    let columns = Columns {
        throttle: &late,
        ..Columns::default()
    };
    Predictor::new(card)?.run(name, time, &columns, start)
}

/// The steady thrust (N) of a card, for each throttle (and battery voltage, where the card has a term of it).
///
/// # Errors
/// A form without a steady state, or a card that is not of thrust.
pub fn at_rest(card: &Card, throttle: &[f64], battery_v: &[f64]) -> Result<Vec<f64>> {
    match card.form {
        Form::StaticSqrt | Form::StaticThrust => {
            let mut fixed = card.clone();
            fixed.terms.retain(|t| t.of == "x" || t.of == "T");
            let rows: Vec<f64> = (0..throttle.len()).map(|i| i as f64).collect();
            let columns = Columns {
                throttle,
                battery_v,
                ..Columns::default()
            };
            Predictor::new(&fixed)?.run(&card.name, &rows, &columns, 0.0)
        }
        Form::LaggedMotors => lagged::at_rest(card, throttle),
        _ => {
            let model = card.thrust_model()?;
            Ok(throttle.iter().map(|s| model.rest(*s).powi(2)).collect())
        }
    }
}

/// The thrust (N) that a card predicts over a trial in free run, from the measured thrust at its start
/// (the mean of the first 0.1 s). Rows with a gap in an input are passed over; they get a gap.
/// A run that diverges to no number at all is infinite from there on.
///
/// # Errors
/// A card that does not run on the trial's channels, or a trial without a row that has them all.
pub fn predict(card: &Card, trial: &Trial) -> Result<Vec<f64>> {
    if card.kind != Kind::Thrust || card.form == Form::RotorLag {
        return Err(Error::data(
            &card.name,
            "a thrust model",
            "a model of another quantity",
        ));
    }
    let inputs = inputs(card, trial)?;
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| inputs.iter().all(|c| c[i].is_finite()))
        .collect();
    if rows.is_empty() {
        return Err(Error::data(
            trial.name(),
            format!("rows in which every input of `{}` is known", card.name),
            format!("none of {}", trial.len()),
        ));
    }
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let time = pick(trial.time_s());
    let run = if card.form == Form::LaggedMotors {
        let motors = inputs.iter().map(|c| pick(c)).collect();
        lagged::predict(card, trial.name(), time, motors)?
    } else {
        let throttle = delayed(&time, &pick(&inputs[0]), dead_time_s(card));
        let battery_v = inputs.get(1).map_or_else(Vec::new, |c| pick(c));
        let columns = Columns {
            throttle: &throttle,
            battery_v: &battery_v,
            ..Columns::default()
        };
        let start = thrust_at_start(trial, time[0])?;
        Predictor::new(card)?.run(trial.name(), &time, &columns, start)?
    };
    let mut out = vec![f64::NAN; trial.len()];
    for (row, value) in rows.into_iter().zip(run) {
        out[row] = if value.is_nan() { f64::INFINITY } else { value };
    }
    Ok(out)
}

/// The channels that a card's free run needs: throttles, and battery voltage where a term has it.
fn inputs(card: &Card, trial: &Trial) -> Result<Vec<Vec<f64>>> {
    if card.form == Form::LaggedMotors {
        return Ok(motors(trial)?.into_iter().map(<[f64]>::to_vec).collect());
    }
    let mut out = vec![throttle(trial)?];
    let has_battery = card.terms.iter().any(|t| {
        sindy_expr::Expr::parse(&t.expression).is_ok_and(|e| e.variables().contains(&"u"))
    });
    if has_battery && matches!(card.form, Form::StaticSqrt | Form::StaticThrust) {
        out.push(trial.require("battery_v")?.to_vec());
    }
    Ok(out)
}

/// Mean thrust over the first 0.1 s from `from_s`, or the first that is known after.
fn thrust_at_start(trial: &Trial, from_s: f64) -> Result<f64> {
    let known = trial
        .time_s()
        .iter()
        .zip(trial.require("thrust_n")?)
        .filter(|(t, f)| **t >= from_s && f.is_finite());
    let near: Vec<f64> = known
        .clone()
        .take_while(|(t, _)| **t <= from_s + 0.1)
        .map(|(_, f)| *f)
        .collect();
    Ok(match near.len() {
        0 => known.map(|(_, f)| *f).next().unwrap_or(0.0),
        n => near.iter().sum::<f64>() / n as f64,
    })
}

/// The rows of a record, in at most `count` pieces of one length.
fn pieces(rows: usize, count: usize) -> impl Iterator<Item = Range<usize>> {
    let size = rows.div_ceil(count);
    let starts = (0..rows).step_by(size);
    starts.map(move |start| start..(start + size).min(rows))
}

/// Throttle that stands still teaches nothing of its effect.
fn check_moves<'a>(name: &str, throttles: impl IntoIterator<Item = &'a [f64]>) -> Result<()> {
    let all = throttles.into_iter().flatten().copied();
    match crate::fitted::range(all) {
        Some([lo, hi]) if hi - lo > LEAST_MOTION => Ok(()),
        Some([lo, hi]) => Err(Error::data(
            name,
            format!("a throttle that moves by more than {LEAST_MOTION}"),
            format!("{lo} to {hi}"),
        )),
        None => Err(Error::data(name, "a throttle", "gaps only")),
    }
}
