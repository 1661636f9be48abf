//! Throttle to thrust: static maps, lags, eq. (7) and eq. (8).

mod choice;
mod credible;
mod drift;
mod first_order;
mod follows;
mod free_run;
mod lagged;
mod library;
mod measured_rotors;
mod output_error;
pub mod plateau;
mod record;
mod repeats;
mod rotor;
mod saturated;
mod search;
mod sign;
mod spikes;
mod statics;
#[cfg(test)]
mod test_stand;
pub(crate) mod unbroken;

pub use first_order::first_order;
pub use library::library;
pub use statics::steady_points;

use choice::Candidate;
use free_run::signal::{Between, lagged as lagged_signal, unfolded};
use measured_rotors::MeasuredRotors;
use output_error::{HELD, LagFit, LagForm};
use repeats::measured_thrust;
use saturated::without_saturated;
use spikes::without_spikes;

use std::ops::Range;

use touchdown_model::Card;
use touchdown_model::card::{Form, Kind};
use touchdown_trial::Trial;

use crate::delayed::delayed;
use crate::error::{Error, Result};
use crate::fitted::{FittedCard, Origin};
use crate::prediction::{Columns, Predictor};
use crate::settings::{IdentificationSettings, ThrustForm};
use crate::warning::{Warning, sentences};

/// Smallest motion of the throttle that a dynamic model is fitted to.
/// The resolution of a command in microseconds.
const LEAST_MOTION: f64 = 1e-3;

/// Thrust of one rotor above which it is taken for grams (N): rotors of 0.4 m radius give less, and 200 g are a small motor's.
/// At half of it, large rotors are warned of; at twice, motors of 400 g are not.
const MOST_OF_ONE_ROTOR_N: f64 = 200.0;

/// Fits one card to `trials` together, in the form of the settings or, without one, in the form that predicts held-out
/// parts best in free run: a static curve, eq. (7), a root behind a lag, a lag on every motor, or eq. (8), each with and
/// without the battery's voltage where that was measured. Of forms within one standard error, the simplest is taken.
///
/// The card has the number of rotors that were measured: that of the settings, or of the logs' throttles or speeds
/// (`throttle_1`, `rotor_rpm_1`, …). Logs with motion are of a whole vehicle; any other log is taken for one rotor's, with
/// a warning.
///
/// # Errors
/// A channel that the form needs and that a trial lacks, a value that no channel has, a thrust that does not follow the
/// throttle, or too few data.
pub fn fit(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    for trial in trials {
        credible::check(trial)?;
        sign::check(trial, &throttle(trial)?)?;
    }
    follows::check_changes(trials)?;
    let (cleaned, spikes) = without_spikes(trials)?;
    let (mut measured, slow_sensor) = measured_thrust(cleaned)?;
    let saturation = without_saturated(&mut measured)?;
    let trials = &measured[..];
    let (candidate, forms) = match settings.thrust.form {
        Some(form) => {
            let battery = settings.thrust.battery;
            let lag = !matches!(form, ThrustForm::StaticSqrt | ThrustForm::StaticThrust);
            (Candidate { form, lag, battery }, Vec::new())
        }
        None => {
            let choice = choice::choose(trials, settings)?;
            (choice.candidate, choice.scores)
        }
    };
    let mut fitted = fit_form(trials, settings, candidate, origin)?;
    fitted.forms = forms;
    fitted.check_finite()?;
    if let Some(saturation) = saturation {
        saturation.bound(&mut fitted.card, trials);
        fitted.warnings.push(saturation.warning());
    }
    let found = follows::inverted(&fitted.card, trials);
    let found = found.or_else(|| drift::of_thrust(&fitted.card, trials));
    fitted.warnings.extend(found);
    let rotors = MeasuredRotors::of(trials, &settings.vehicle);
    fitted.card.measured_rotors = rotors.in_card(&settings.vehicle);
    if rotors == MeasuredRotors::OneAssumed {
        fitted.warnings.push(Warning::OneRotorAssumed);
    }
    fitted
        .warnings
        .extend(spikes.into_iter().chain(slow_sensor));
    let most_n = trials.iter().map(sign::most_n).fold(0.0, f64::max);
    if fitted.card.measured_rotors == Some(1) && most_n > MOST_OF_ONE_ROTOR_N {
        fitted.warnings.push(Warning::Grams { most_n });
    }
    fitted.card.warnings.extend(sentences(&fitted.warnings));
    Ok(fitted)
}

fn fit_form(
    trials: &[Trial],
    settings: &IdentificationSettings,
    candidate: Candidate,
    origin: &Origin,
) -> Result<FittedCard> {
    let Candidate { form, lag, battery } = candidate;
    let mut settings = settings.clone();
    settings.thrust.battery = battery;
    match (form, lag) {
        (ThrustForm::Library, _) => library(trials, &settings, origin),
        (_, true) => {
            let form = LagForm {
                form,
                degree: settings.thrust.degree,
                battery,
            };
            LagFit::new(trials, &settings, form)?.card(trials, origin)
        }
        (_, false) => statics::fit(trials, &settings, form, origin),
    }
}

/// Whether thrust comes from the accelerometer of a flight: it also measures other forces, and thrust there is what the weight asks
/// for.
fn is_flight(trial: &Trial) -> bool {
    trial.channel("specific_force_mps2").is_some()
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
    if card.form == Form::LaggedMotors {
        let motors = vec![throttle.to_vec(); lagged::motors_of(card) as usize];
        return lagged::predict(card, name, time, &motors, &[]);
    }
    let dynamic = matches!(card.form, Form::Library | Form::FirstOrder)
        || card.form == Form::StaticSqrt && card.terms_of("T_m").next().is_some();
    let start = if dynamic {
        card.thrust_model()?.rest(first).powi(2)
    } else {
        0.0
    };
    run(card, name, time, throttle, &[], start)
}

/// The thrust (N) of a card of one throttle from `start_n`: exact where the card says what its throttle is between
/// samples, otherwise integrated along straight lines.
fn run(
    card: &Card,
    name: &str,
    time: &[f64],
    throttle: &[f64],
    battery_v: &[f64],
    start_n: f64,
) -> Result<Vec<f64>> {
    let dead_time_s = dead_time_s(card);
    let held = card.constants.get(HELD).map(|held| *held != 0.0);
    let has_lag = card.terms_of("T_m").next().is_some();
    if let (Some(held), true) = (held, has_lag) {
        let between = if held { Between::Held } else { Between::Linear };
        let acting_v = free_run::acting_voltage(time, battery_v, between, dead_time_s);
        let target = root_at_rest(card, throttle, &acting_v)?;
        let lag_s = card.coefficient("T_m", "1");
        let x = lagged_signal(time, &target, between, lag_s, dead_time_s);
        let (first, from_s) = (target[0], time[0]);
        let offset = start_n.max(0.0).sqrt() - first;
        let pairs = x.iter().zip(time);
        return Ok(pairs
            .map(|(x, t)| {
                let x = x + offset * (-(t - from_s) / lag_s).exp();
                x * x.abs()
            })
            .collect());
    }
    let predictor = Predictor::new(card)?;
    if held == Some(true) {
        let (times, s, rows) = unfolded(time, throttle, dead_time_s);
        let columns = Columns {
            throttle: &s,
            ..Columns::default()
        };
        let all = predictor.run(name, &times, &columns, start_n)?;
        let pairs = all.into_iter().zip(rows);
        return Ok(pairs.filter_map(|(v, row)| row.map(|_| v)).collect());
    }
    let late = delayed(time, throttle, dead_time_s);
    let columns = Columns {
        throttle: &late,
        battery_v,
        ..Columns::default()
    };
    predictor.run(name, time, &columns, start_n)
}

/// The root of thrust that a card of one lag tends to, with its sign.
fn root_at_rest(card: &Card, throttle: &[f64], battery_v: &[f64]) -> Result<Vec<f64>> {
    if card.form == Form::FirstOrder {
        let [c0, c1] = ["c0", "c1"].map(|of| card.coefficient(of, "1"));
        return Ok(throttle.iter().map(|s| c0 * s + c1).collect());
    }
    let thrust = at_rest(card, throttle, battery_v)?;
    Ok(thrust
        .into_iter()
        .map(|t| t.signum() * t.abs().sqrt())
        .collect())
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
        Form::LaggedMotors => lagged::at_rest(card, throttle, battery_v),
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
        let count = lagged::motors_of(card) as usize;
        let mut columns: Vec<Vec<f64>> = inputs.iter().map(|c| pick(c)).collect();
        let battery_v = match has_battery(card) {
            true => columns.pop().unwrap_or_default(),
            false => Vec::new(),
        };
        // One throttle drives all motors of the card.
        if columns.len() == 1 {
            columns = vec![columns.remove(0); count];
        }
        lagged::predict(card, trial.name(), &time, &columns, &battery_v)?
    } else {
        let battery_v = inputs.get(1).map_or_else(Vec::new, |c| pick(c));
        let start = thrust_at_start(trial, time[0])?;
        run(
            card,
            trial.name(),
            &time,
            &pick(&inputs[0]),
            &battery_v,
            start,
        )?
    };
    let mut out = vec![f64::NAN; trial.len()];
    for (row, value) in rows.into_iter().zip(run) {
        out[row] = if value.is_nan() { f64::INFINITY } else { value };
    }
    Ok(out)
}

/// The channels that a card's free run needs: throttles, and battery voltage where a term has it.
fn inputs(card: &Card, trial: &Trial) -> Result<Vec<Vec<f64>>> {
    let mut out = match card.form {
        Form::LaggedMotors => motors(trial)?.into_iter().map(<[f64]>::to_vec).collect(),
        _ => vec![throttle(trial)?],
    };
    if has_battery(card) {
        let volts = trial.require("battery_v")?;
        out.push(match card.constants.contains_key(HELD) {
            // A lag runs on through the gaps of a slower channel.
            true => free_run::filled(trial.time_s(), volts),
            false => volts.to_vec(),
        });
    }
    Ok(out)
}

/// Whether a term has the battery's voltage.
fn has_battery(card: &Card) -> bool {
    let name = match card.form {
        Form::LaggedMotors => "battery_v",
        Form::StaticSqrt | Form::StaticThrust => "u",
        _ => return false,
    };
    card.terms.iter().any(|t| {
        sindy_expr::Expr::parse(&t.expression).is_ok_and(|e| e.variables().contains(&name))
    })
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
