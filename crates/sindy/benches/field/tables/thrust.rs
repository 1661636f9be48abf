//! Logs of thrust stands, which are not part of this repository: folders below the one that `TOUCHDOWN_DATA` names. Licences and
//! sources are in the README of each folder.

use std::path::Path;

use super::Table;
use crate::Failure;
use crate::simulate::Rows;

/// This share of a log's rows is for training; its end is held out.
const TRAINING: f64 = 0.75;

/// Rows of the median that removes single samples in which the stand lost the motor's speed. Both programs get its result.
const MEDIAN: usize = 5;

pub(super) fn tables(folder: &Path) -> Result<Vec<Table>, Failure> {
    let stand = folder.join("thrust-7in-rcbenchmark-staircase");
    let scale = folder.join("thrust-crazyflie21-scale");
    let motor = |name, rows: &Rows| {
        let (training, held_out) = divided(rows);
        Table {
            name,
            states: &["w"],
            inputs: &["u"],
            degree: 3,
            discrete: false,
            training,
            held_out,
        }
    };
    Ok(vec![
        motor(
            "speed of a motor, BLHeli32",
            &rows_of_stand(&stand.join("Log_2019-11-09_181347.csv"))?,
        ),
        motor(
            "speed of a motor, ESC32",
            &rows_of_controller(&stand.join("esc32v3_f60-1.csv"))?,
        ),
        Table {
            name: "thrust of a Crazyflie, next row",
            states: &["f"],
            inputs: &["p", "v"],
            degree: 2,
            discrete: true,
            training: rows_of_scale(&scale.join("cf2.1-stock-prop.csv"))?,
            held_out: rows_of_scale(&scale.join("cf21_stock2.csv"))?,
        },
    ])
}

/// Speed in 1000 rpm, command from 0 to 1 by the pulse of 1000 to 2000 µs.
fn rows_of_stand(path: &Path) -> Result<Rows, Failure> {
    let columns = [
        "Time (s)",
        "Motor Electrical Speed (RPM)",
        "ESC signal (µs)",
    ];
    let mut rows = Vec::new();
    for [time, speed, pulse] in cells(path, columns)? {
        if !pulse.is_empty() {
            let speed: f64 = speed.parse()?;
            let pulse: f64 = pulse.parse()?;
            rows.push([time.parse()?, 1e-3 * speed, 1e-3 * (pulse - 1000.0)]);
        }
    }
    Ok(increasing(rows))
}

/// Speed in 1000 rpm, command from 0 to 1. Times are `2019-11-07 18:45:58:868`.
fn rows_of_controller(path: &Path) -> Result<Rows, Failure> {
    let mut rows = Vec::new();
    for [time, speed, duty] in cells(path, ["Timestamp", "RPM", "Duty"])? {
        let clock = time.split(' ').nth(1).unwrap_or(&time);
        let parts = clock.split(':').map(str::parse);
        let parts: Vec<f64> = parts.collect::<Result<_, _>>()?;
        let [hours, minutes, seconds, milliseconds] = parts[..] else {
            return Err(format!(
                "{}: expected hours:minutes:seconds:milliseconds; found `{time}`",
                path.display()
            )
            .into());
        };
        let time = 3600.0 * hours + 60.0 * minutes + seconds + 1e-3 * milliseconds;
        let (speed, duty): (f64, f64) = (speed.parse()?, duty.parse()?);
        rows.push([time, 1e-3 * speed, 1e-2 * duty]);
    }
    Ok(increasing(rows))
}

/// Thrust in 10 gf, command from 0 to 1, battery in V; rows have no times.
fn rows_of_scale(path: &Path) -> Result<Rows, Failure> {
    let (mut thrust, mut command, mut voltage) = (Vec::new(), Vec::new(), Vec::new());
    for [weight, pwm, battery] in cells(path, ["weight[g]", "pwm", "vbat[V]"])? {
        thrust.push(0.1 * weight.parse::<f64>()?);
        command.push(pwm.parse::<f64>()? / 65_535.0);
        voltage.push(battery.parse()?);
    }
    Ok(Rows {
        time: (0..thrust.len()).map(|k| k as f64).collect(),
        states: vec![thrust],
        inputs: vec![command, voltage],
    })
}

/// The cells of columns by name, row by row.
fn cells<const N: usize>(path: &Path, names: [&str; N]) -> Result<Vec<[String; N]>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut lines = text.trim_start_matches('\u{feff}').lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let at = header.iter().position(|h| *h == name);
        *place = at.ok_or(format!("{}: no column `{name}`", path.display()))?;
    }
    let row = |line: &str| {
        let all: Vec<&str> = line.split(',').collect();
        places.map(|k| all.get(k).copied().unwrap_or_default().to_owned())
    };
    Ok(lines.map(row).collect())
}

/// Rows whose time is later than that of all before, with a median of the speed.
fn increasing(rows: Vec<[f64; 3]>) -> Rows {
    let (mut time, mut speed, mut command) = (Vec::new(), Vec::new(), Vec::new());
    for [t, w, u] in rows {
        if time.last().is_none_or(|last| t > *last) {
            time.push(t);
            speed.push(w);
            command.push(u);
        }
    }
    let half = MEDIAN / 2;
    let filtered = (0..speed.len()).map(|k| {
        let window = k.saturating_sub(half)..(k + half + 1).min(speed.len());
        crate::score::median(speed[window].to_vec())
    });
    Rows {
        states: vec![filtered.collect()],
        time,
        inputs: vec![command],
    }
}

fn divided(rows: &Rows) -> (Rows, Rows) {
    let at = (TRAINING * rows.time.len() as f64) as usize;
    let part = |range: std::ops::Range<usize>| Rows {
        time: rows.time[range.clone()].to_vec(),
        states: rows
            .states
            .iter()
            .map(|c| c[range.clone()].to_vec())
            .collect(),
        inputs: rows
            .inputs
            .iter()
            .map(|c| c[range.clone()].to_vec())
            .collect(),
    };
    (part(0..at), part(at..rows.time.len()))
}
