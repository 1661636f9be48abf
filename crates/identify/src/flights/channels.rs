//! The channels of a flight's log: throttle, rotor speed, height and slow quantities, with gaps and spikes handled.

use touchdown_trial::Trial;

use super::FlightSettings;
use super::smooth::{filled, without_spikes};
use crate::error::{Error, Result};
use crate::held::once;
use crate::thrust::{plateau::median, throttle};
use crate::warning::Warning;

/// Fewest values of a throttle: a third of a second of a slow log, fewer hold no flight at all.
const FEWEST_THROTTLES: usize = 20;
/// A throttle above this is in other units than those from 0 to 1.
/// Normalised throttles overshoot 1 by little; microseconds and percent are far above.
const MOST_THROTTLE: f64 = 1.5;
/// Longest time for which a reader holds a value, or joins two by a line (s).
/// Slower range finders are of no use in flight. Half counts values of a 5 Hz sensor twice.
const LONGEST_HELD_S: f64 = 0.2;
/// Distance of a value from the line between its neighbours below which a reader has made it (m, m/s).
/// A log of six decimals is rounded to half of it; of measurements with noise of 0.5 mm, one in 500 is lost by chance.
const BETWEEN: f64 = 1e-6;

/// Median step of a clock (s); infinite for fewer than two stamps.
pub(super) fn median_step(time: &[f64]) -> f64 {
    median(time.windows(2).map(|p| p[1] - p[0])).unwrap_or(f64::INFINITY)
}

/// Median time between two values of the throttle while the motors run (s); checks that it is one.
pub(super) fn throttle_period_s(
    trial: &Trial,
    throttle: &[f64],
    settings: &FlightSettings,
) -> Result<f64> {
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| throttle[i].is_finite())
        .collect();
    if rows.len() < FEWEST_THROTTLES {
        return Err(Error::data(
            trial.name(),
            format!("at least {FEWEST_THROTTLES} rows with a throttle"),
            rows.len().to_string(),
        ));
    }
    let most = rows.iter().map(|&i| throttle[i]).fold(0.0, f64::max);
    if most > MOST_THROTTLE {
        return Err(Error::data(
            trial.name(),
            "a throttle from 0 to 1",
            format!("values up to {most}: divide them in the map"),
        ));
    }
    let time = trial.time_s();
    let running = |i: &usize| throttle[*i] > settings.idle_throttle;
    // A reader holds the values of a slow logger, so only changes show its rate.
    let changes: Vec<f64> = rows
        .iter()
        .zip(rows.iter().skip(1))
        .filter(|(a, b)| running(a) && running(b) && throttle[**a] != throttle[**b])
        .map(|(_, b)| time[*b])
        .collect();
    let stamps: Vec<f64> = rows.iter().map(|&i| time[i]).collect();
    Ok(median_step(&stamps).max(median_step(&changes)))
}

/// Heights without spikes, with short gaps filled and as measured; empty where none is known.
pub(super) fn heights(trial: &Trial, offset_m: f64, notes: &mut Vec<Warning>) -> [Vec<f64>; 2] {
    let time = trial.time_s();
    let logged = trial.channel("height_m").unwrap_or_default();
    let mut height_m: Vec<f64> = logged.iter().map(|z| z + offset_m).collect();
    let spikes = without_spikes(time, &mut height_m);
    if spikes > 0 {
        notes.push(Warning::HeightSpikes(spikes));
    }
    if !height_m.iter().any(|z| z.is_finite()) {
        height_m.clear();
    }
    let mut range_m = measured(time, &height_m);
    // A range that a link repeats differs only by the tilt that it was turned by.
    let tilt = trial.channel("tilt_rad").unwrap_or_default();
    let along = |(i, z): (usize, &f64)| {
        z / tilt
            .get(i)
            .filter(|t| t.is_finite())
            .map_or(1.0, |t| t.cos())
    };
    let along: Vec<f64> = logged.iter().enumerate().map(along).collect();
    for (range, once) in range_m.iter_mut().zip(once(&along).unwrap_or_default()) {
        if once.is_nan() {
            *range = f64::NAN;
        }
    }
    [filled(time, &height_m, false), range_m]
}

/// A channel where it was measured, NaN elsewhere. Readers hold the values of a slow sensor, or join them by lines: a value that
/// repeats the last one, or lies between its neighbours to [`BETWEEN`], is no measurement. After [`LONGEST_HELD_S`] it is one again.
pub(super) fn measured(time: &[f64], values: &[f64]) -> Vec<f64> {
    let known: Vec<usize> = (0..values.len())
        .filter(|&i| values[i].is_finite())
        .collect();
    let mut out = vec![f64::NAN; values.len()];
    let mut last: Option<usize> = None;
    for (k, &i) in known.iter().enumerate() {
        let repeats =
            i > 0 && values[i - 1].is_finite() && last.is_some_and(|l| values[l] == values[i]);
        let between = k > 0
            && known.get(k + 1).is_some_and(|&b| {
                let a = known[k - 1];
                let share = (time[i] - time[a]) / (time[b] - time[a]);
                (values[a] + share * (values[b] - values[a]) - values[i]).abs() < BETWEEN
            });
        if (repeats || between) && last.is_some_and(|l| time[i] - time[l] < LONGEST_HELD_S) {
            continue;
        }
        out[i] = values[i];
        last = Some(i);
    }
    out
}

/// A channel with its short gaps filled on lines; empty where there is no value.
pub(super) fn without_gaps(trial: &Trial, name: &str) -> Vec<f64> {
    match trial.channel(name) {
        Some(values) if values.iter().any(|v| v.is_finite()) => {
            filled(trial.time_s(), values, false)
        }
        _ => Vec::new(),
    }
}

/// Throttle and rotor speed; without throttle, the rotor speed over its greatest value in its place, and that it is that.
pub(super) fn effort(trial: &Trial) -> Result<(Vec<f64>, Vec<f64>, bool)> {
    let known = |c: &[f64]| c.iter().any(|v| v.is_finite());
    let rpm = trial
        .channel("rotor_rpm")
        .filter(|c| known(c))
        .map_or_else(Vec::new, |c| filled(trial.time_s(), c, false));
    match throttle(trial) {
        Ok(throttle) if known(&throttle) || rpm.is_empty() => Ok((throttle, rpm, false)),
        Err(_) if rpm.is_empty() => Err(Error::data(
            trial.name(),
            "what the motors do, as `throttle` (0 to 1) or `rotor_rpm`: record motor commands or rotor speeds with the poses",
            format!("channels {}", names(trial)),
        )),
        _ => {
            let most = rpm.iter().copied().fold(0.0, f64::max);
            Ok((rpm.iter().map(|r| r / most).collect(), rpm, true))
        }
    }
}

/// Gaps of a slow quantity held at the value before, those at the start at the first one; empty where there is none.
pub(super) fn held(values: &[f64]) -> Vec<f64> {
    let Some(mut last) = values.iter().copied().find(|v| v.is_finite()) else {
        return Vec::new();
    };
    let hold = |v: &f64| {
        if v.is_finite() {
            last = *v;
        }
        last
    };
    values.iter().map(hold).collect()
}

fn names(trial: &Trial) -> String {
    let all: Vec<&str> = std::iter::once("time_s")
        .chain(trial.channels().map(|(name, _)| name))
        .collect();
    all.join(", ")
}
