//! Recognises channels among the columns of a table, by their names, units and sizes.

use super::motors::{Groups, motors, rotors};
use super::suggest::quoted;
use super::thrust::{ask_which, beside_throttle};
use super::units::{force_factor, last_word_of_force, quantity, quantity_of};
use crate::ColumnSummary;

/// A guess: a channel and the columns that contain it.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Guess {
    pub(crate) channel: &'static str,
    pub(crate) expression: String,
    /// Remark for the user to check, if the guess needs more than a name and a unit.
    pub(crate) check: Option<String>,
    /// The columns, by their places.
    pub(crate) columns: Vec<usize>,
    /// Number of motors whose mean the expression is; 0 for a single column.
    pub(crate) averaged: usize,
    /// Expressions with remarks, one of which the user has to choose; the guess has no expression of its own then.
    pub(crate) choices: Vec<(String, String)>,
}

/// Channels that go by these names already.
const OURS: [&str; 8] = [
    "throttle",
    "thrust_n",
    "specific_force_mps2",
    "tilt_rad",
    "height_m",
    "vehicle_velocity_mps",
    "battery_v",
    "rotor_rpm",
];

/// Words for a thrust.
pub(crate) const THRUST: [&str; 6] = [
    "thrust",
    "force",
    "weight",
    "load cell",
    "loadcell",
    "load_cell",
];
/// Words in a column's name, its unit, the channel and the factor: `channel = factor * column`.
const WORDS: [(&[&str], &str, &str, &str); 12] = [
    (&["torque"], "nm", "torque_n_m", ""),
    (&["volt", "bat"], "v", "battery_v", ""),
    (&["volt", "bat"], "mv", "battery_v", "1e-3 * "),
    (&["batt. volts"], "", "battery_v", ""),
    (&["current"], "a", "current_a", ""),
    (&["current"], "ma", "current_a", "1e-3 * "),
    (&["amps"], "", "current_a", ""),
    (&["speed", "rotor", "motor", "rpm"], "rpm", "rotor_rpm", ""),
    (&["rpm"], "", "rotor_rpm", ""),
    (&["height", "altitude"], "m", "height_m", ""),
    (
        &["height", "altitude", "range"],
        "cm",
        "height_m",
        "0.01 * ",
    ),
    (
        &["height", "altitude", "range"],
        "mm",
        "height_m",
        "1e-3 * ",
    ),
];

/// Whole names, reduced to letters and digits, and their channel.
const NAMES: [(&[&str], &str); 4] = [
    (
        &[
            "az",
            "accz",
            "accelz",
            "accelerationz",
            "accelerometerz",
            "linearaccelerationz",
            "imuaccz",
            "imuaz",
            "imuup",
            "accup",
            "accelup",
            "accelerationup",
            "azup",
            "stateestimateaz",
        ],
        "specific_force_mps2",
    ),
    (
        &[
            "z",
            "posz",
            "positionz",
            "height",
            "altitude",
            "alt",
            "agl",
            "range",
            "zrange",
            "rangez",
            "distance",
            "rangefinder",
            "lidar",
            "sonar",
            "tof",
            "rangefloor",
            "stateestimatez",
        ],
        "height_m",
    ),
    (
        &[
            "vz",
            "velz",
            "velocityz",
            "climb",
            "climbrate",
            "verticalspeed",
            "verticalvelocity",
        ],
        "vehicle_velocity_mps",
    ),
    (
        &[
            "vbat",
            "vbatt",
            "battery",
            "batt",
            "bat",
            "batteryvoltage",
            "voltage",
            "pmvbat",
            "pmvbatmv",
        ],
        "battery_v",
    ),
];
/// Units that such names have, and their factors.
const UNITS: [(&str, &str, &str); 11] = [
    ("specific_force_mps2", "m/s2", ""),
    ("specific_force_mps2", "m/s^2", ""),
    ("specific_force_mps2", "m/s²", ""),
    ("specific_force_mps2", "mps2", ""),
    ("specific_force_mps2", "g", "9.80665 * "),
    ("height_m", "m", ""),
    ("height_m", "cm", "0.01 * "),
    ("height_m", "mm", "1e-3 * "),
    ("vehicle_velocity_mps", "m/s", ""),
    ("vehicle_velocity_mps", "mps", ""),
    ("vehicle_velocity_mps", "cm/s", "0.01 * "),
];
/// Words in the names of range finders.
const RANGES: [&str; 3] = ["range", "distance", "lidar"];
/// Names of short-range sensors, which often read in cm and at most `SHORT_M`.
const SHORT: [&str; 2] = ["sonar", "tof"];
const SHORT_M: f64 = 10.0;
/// Statistics at the end of a name.
const STATISTICS: [&str; 6] = ["_mean", "_avg", "_average", "_median", " mean", " avg"];
/// Words for what was commanded, not measured.
const COMMANDS: [&str; 13] = [
    "cmd",
    "command",
    "commanded",
    "setpoint",
    "sp",
    "desired",
    "des",
    "target",
    "ref",
    "reference",
    "demand",
    "req",
    "requested",
];
/// Newtons to a gram.
const GRAMS: &str = "9.80665e-3 * ";
/// Greatest thrust of a motor on a stand, N: those of drones that carry people have 1000, but theirs are no tables of
/// unknown units. Half of it is within reach of large stands; twice of it is passed by 40 g in newtons.
pub(crate) const MOST_N: f64 = 200.0;
/// Times that thrust below zero exceeds thrust above it, if the sensor is mounted upside down. Noise about zero and
/// the air behind a rotor give less than one.
const UPSIDE_DOWN: f64 = 3.0;

/// Guesses at the channels among columns of numbers, each channel once, in the order of columns.
pub(crate) fn channels(columns: &[ColumnSummary]) -> Vec<Guess> {
    let mut found: Vec<Guess> = Vec::new();
    let mut taken = vec![false; columns.len()];
    let groups = Groups::of(columns);
    for at in 0..columns.len() {
        let column = &columns[at];
        // Of a group that is known already.
        if column.text.is_some() || column.count == 0 || taken[at] {
            continue;
        }
        let measured = || {
            rotors(at, columns, &groups)
                .or_else(|| by_word(at, column))
                .or_else(|| by_name(at, column))
        };
        let guess = ours(at, column)
            .or_else(|| measured().filter(|_| !is_command(&column.name)))
            .or_else(|| motors(at, columns, &groups));
        if let Some(guess) = guess
            && !found.iter().any(|known| known.channel == guess.channel)
        {
            guess.columns.iter().for_each(|&at| taken[at] = true);
            found.push(guess);
        }
    }
    ask_which(columns, &mut found);
    beside_throttle(columns, &mut found);
    found
}

fn ours(at: usize, column: &ColumnSummary) -> Option<Guess> {
    let channel = OURS.iter().find(|known| **known == column.name)?;
    // A throttle of ours lies in [0, 1]; another one has to be scaled.
    (*channel != "throttle" || column.max <= Some(1.0)).then(|| Guess {
        channel,
        expression: quoted(&column.name),
        columns: vec![at],
        ..Guess::default()
    })
}

pub(crate) fn by_word(at: usize, column: &ColumnSummary) -> Option<Guess> {
    let name = without_statistic(&column.name);
    let (base, unit) = quantity_of(name, column.unit.as_deref());
    if THRUST.iter().any(|word| base.contains(word)) {
        let bare = || last_word_of_force(name).filter(|_| unit.is_empty());
        let factor = force_factor(&unit).or_else(bare)?;
        return Some(measured(at, column, "thrust_n", factor));
    }
    let quoted = quoted(&column.name);
    let (channel, expression) = if unit == "us" && (base.contains("esc") || base.contains("pwm")) {
        ("throttle", format!("({quoted} - 1000) / 1000"))
    } else {
        let alike =
            |words: &[&str], of: &str| unit == of && words.iter().any(|word| base.contains(word));
        let (.., channel, factor) = WORDS.iter().find(|(words, of, ..)| alike(words, of))?;
        return Some(measured(at, column, channel, factor));
    };
    Some(Guess {
        channel,
        expression,
        columns: vec![at],
        ..Guess::default()
    })
}

/// A measured channel by a name with a unit. A thrust that is mostly below zero comes from a sensor that is mounted
/// upside down, and one of hundreds of newtons is in grams.
pub(crate) fn measured(
    at: usize,
    column: &ColumnSummary,
    channel: &'static str,
    factor: &str,
) -> Guess {
    let (min, max) = (column.min.unwrap_or(0.0), column.max.unwrap_or(0.0));
    let is_thrust = channel == "thrust_n";
    let is_down = is_thrust && -min > UPSIDE_DOWN * max.max(0.0) && min < 0.0;
    let is_grams = is_thrust && factor.is_empty() && max.max(-min) > MOST_N;
    let factor = if is_grams { GRAMS } else { factor };
    let sign = if is_down { "-" } else { "" };
    let checks = [
        is_grams.then_some("in g by its size"),
        is_down.then_some("turned to be up by its sign"),
    ];
    let checks: Vec<&str> = checks.into_iter().flatten().collect();
    Guess {
        channel,
        expression: format!("{sign}{factor}{}", quoted(&column.name)),
        check: (!checks.is_empty()).then(|| checks.join(", and ")),
        columns: vec![at],
        ..Guess::default()
    }
}

/// A name without the statistic at its end: `rpm` for `rpm_mean`.
fn without_statistic(name: &str) -> &str {
    let cut = STATISTICS.iter().find_map(|end| {
        let at = name.len().checked_sub(end.len())?;
        let ending = name.get(at..)?;
        ending.eq_ignore_ascii_case(end).then(|| &name[..at])
    });
    cut.unwrap_or(name)
}

/// Whether a name denotes a commanded quantity. Only the throttle is a command.
pub(crate) fn is_command(name: &str) -> bool {
    let words = name.split(|c: char| !c.is_alphanumeric());
    words
        .map(str::to_lowercase)
        .any(|word| COMMANDS.contains(&word.as_str()))
}

/// Letters and digits.
pub(crate) fn plain(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

fn by_name(at: usize, column: &ColumnSummary) -> Option<Guess> {
    let channel_of = |name: &str| {
        let alike = NAMES.iter().find(|(names, _)| names.contains(&name));
        alike.map(|&(_, channel)| channel)
    };
    let (base, unit) = quantity(column);
    let factor_of = |channel: &str| {
        let known = UNITS
            .iter()
            .find(|(of, known, _)| *of == channel && *known == unit);
        known.map(|&(.., factor)| factor)
    };
    let stated = channel_of(&plain(&base)).and_then(|channel| Some((channel, factor_of(channel)?)));
    let (channel, factor, check) = match stated {
        Some((channel, factor)) => (channel, factor, None),
        None => {
            let channel = channel_of(&plain(&column.name))?;
            let (factor, what) = by_size(channel, column)?;
            (channel, factor, Some(format!("in {what} by its size")))
        }
    };
    // Channels are positive upwards, and the specific force contains gravity.
    let is_down = match channel {
        "specific_force_mps2" | "height_m" => column.median < Some(0.0),
        _ => false,
    };
    let check = match (channel, check) {
        (_, Some(check)) if is_down => Some(format!("{check}, and turned to be up by its sign")),
        (_, None) if is_down => Some("turned to be up by its sign".to_owned()),
        ("vehicle_velocity_mps", None) => Some("up is positive".to_owned()),
        ("vehicle_velocity_mps", Some(check)) => Some(format!("{check}; up is positive")),
        (_, check) => check,
    };
    let sign = if is_down { "-" } else { "" };
    Some(Guess {
        channel,
        expression: format!("{sign}{factor}{}", quoted(&column.name)),
        check,
        columns: vec![at],
        ..Guess::default()
    })
}

/// Factor and unit with which the values have a plausible size.
fn by_size(channel: &str, column: &ColumnSummary) -> Option<(&'static str, &'static str)> {
    let (min, median, max) = (column.min?, column.median?.abs(), column.max?);
    let largest = min.abs().max(max.abs());
    let name = plain(&column.name);
    let is_range = RANGES.iter().any(|word| name.contains(word));
    match channel {
        "specific_force_mps2" if (0.5..2.0).contains(&median) => Some(("9.80665 * ", "g")),
        "specific_force_mps2" if (4.0..20.0).contains(&median) => Some(("", "m/s²")),
        "height_m" if SHORT.contains(&name.as_str()) => (largest <= SHORT_M).then_some(("", "m")),
        "height_m" if largest <= 100.0 => Some(("", "m")),
        // Range finders read at most 10 m here; an altitude above the sea is not a height.
        "height_m" if largest <= 10_000.0 && is_range => Some(("1e-3 * ", "mm")),
        "vehicle_velocity_mps" if largest <= 30.0 => Some(("", "m/s")),
        "battery_v" if (2.0..100.0).contains(&median) => Some(("", "V")),
        "battery_v" if (2000.0..100_000.0).contains(&median) => Some(("1e-3 * ", "mV")),
        _ => None,
    }
}
