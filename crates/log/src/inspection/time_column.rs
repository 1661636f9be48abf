//! Which column of a table seems to be the time, and in which unit.

use super::recognise::channels;
use super::suggest::base_and_unit;
use super::tally::{Tally, TimeColumn, View};
use crate::{Column, ColumnKind};

/// Words that speak of time; in a name that begins or ends with `time`, or ends with `stamp`, they
/// do as well.
const WORDS: [&str; 12] = [
    "t", "ts", "clock", "elapsed", "epoch", "unix", "uptime", "zeit", "tijd", "tiempo", "tempo",
    "czas",
];
/// Last words that are units; those from `sec` on speak of time by themselves.
const UNITS: [(&str, f64); 19] = [
    ("s", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("ns", 1e-9),
    ("sec", 1.0),
    ("secs", 1.0),
    ("second", 1.0),
    ("seconds", 1.0),
    ("msec", 1e-3),
    ("millis", 1e-3),
    ("milliseconds", 1e-3),
    ("usec", 1e-6),
    ("micros", 1e-6),
    ("microseconds", 1e-6),
    ("nsec", 1e-9),
    ("nanos", 1e-9),
    ("nanosec", 1e-9),
    ("nsecs", 1e-9),
    ("nanoseconds", 1e-9),
];
/// Units of time that are none of these: what has them is not guessed at.
const LONG_UNITS: [&str; 9] = [
    "min", "mins", "minutes", "h", "hr", "hours", "day", "days", "week",
];
/// Words of what counts rows or turns, whatever else the name says.
const COUNTS: [&str; 12] = [
    "seq", "sequence", "index", "idx", "id", "count", "counter", "cnt", "step", "steps",
    "timestep", "number",
];
/// Words of what may rise evenly and is no time, unless the name speaks of time as well; a number
/// behind them does not count.
const OTHERS: [&str; 108] = [
    "row",
    "rows",
    "frame",
    "sample",
    "line",
    "num",
    "no",
    "nr",
    "n",
    "i",
    "packet",
    "msg",
    "message",
    "iteration",
    "iter",
    "loop",
    "cycle",
    "x",
    "y",
    "z",
    "lat",
    "lon",
    "latitude",
    "longitude",
    "dist",
    "distance",
    "odometer",
    "odom",
    "encoder",
    "position",
    "pos",
    "height",
    "altitude",
    "alt",
    "agl",
    "range",
    "m",
    "cm",
    "mm",
    "mah",
    "wh",
    "energy",
    "charge",
    "capacity",
    "consumed",
    "angle",
    "deg",
    "rad",
    "yaw",
    "heading",
    "pitch",
    "roll",
    "phase",
    "temp",
    "temperature",
    "pressure",
    "throttle",
    "pwm",
    "motor",
    "motors",
    "esc",
    "servo",
    "duty",
    "output",
    "cmd",
    "command",
    "setpoint",
    "target",
    "ref",
    "gas",
    "load",
    "thrust",
    "force",
    "weight",
    "torque",
    "g",
    "kg",
    "gf",
    "volt",
    "volts",
    "voltage",
    "v",
    "mv",
    "bat",
    "batt",
    "battery",
    "vbat",
    "current",
    "amps",
    "a",
    "ma",
    "power",
    "w",
    "rpm",
    "speed",
    "velocity",
    "vel",
    "vx",
    "vy",
    "vz",
    "acc",
    "accel",
    "ax",
    "ay",
    "az",
    "gx",
    "gy",
    "gz",
];
/// Fewest stamps that show that a column rises.
const FEWEST: usize = 10;
/// Part of the steps that may go back, as where stamps come out of order.
const BACKWARD: f64 = 0.01;
/// Part of the stamps that may be like the one before, where the name speaks of time or its unit,
/// and where nothing but the steps does.
const ALIKE: [f64; 2] = [0.5, 0.1];
/// Part of the steps that are between half the median step and twice as much in what rises evenly.
const EVEN: f64 = 0.9;

/// The column that seems to be the time: by a name or stamps that leave no doubt, or else one that
/// rises as time does, rather one whose name speaks of time.
pub(crate) fn time_among(columns: &[Column], numbers: &[usize]) -> Option<TimeColumn> {
    let named = columns.iter().find_map(time_of);
    named.or_else(|| rising(columns, numbers))
}

/// The time column, where its name or its date-time stamps leave no doubt.
pub(crate) fn time_of(column: &Column) -> Option<TimeColumn> {
    let found = |unit_s, stated| {
        Some(TimeColumn {
            name: column.name.clone(),
            unit_s,
            stated,
            guess: None,
        })
    };
    if column.kind == ColumnKind::Stamp {
        return found(1.0, true);
    }
    let (base, unit) = base_and_unit(&column.name);
    if column.is_text() || !matches!(base.as_str(), "t" | "time" | "timestamp" | "elapsed time") {
        return None;
    }
    match unit.as_str() {
        "s" | "sec" => found(1.0, true),
        "ms" => found(1e-3, true),
        "us" => found(1e-6, true),
        "ns" => found(1e-9, true),
        "" => found(1.0, false),
        _ => None,
    }
}

/// Of the columns that rise like a time, the one whose name suggests a time most; the first of equals.
fn rising(columns: &[Column], numbers: &[usize]) -> Option<TimeColumn> {
    let mut tally = Tally::new(None);
    let views: Vec<View<'_>> = columns.iter().map(View::of).collect();
    tally.part(&views, numbers);
    let known = channels(&tally.columns(false));
    let free = (0..columns.len()).filter(|at| !known.iter().any(|one| one.columns.contains(at)));
    let candidates = free.filter_map(|at| rises(&columns[at]));
    let mut best: Option<(u8, TimeColumn)> = None;
    for (rank, column) in candidates {
        if best.as_ref().is_none_or(|&(most, _)| rank > most) {
            best = Some((rank, column));
        }
    }
    best.map(|(_, column)| column)
}

/// What a column's name suggests about a time.
struct NameHint {
    speaks: bool,
    unit_s: Option<f64>,
}

/// Nothing for the name of another thing.
fn named(name: &str) -> Option<NameHint> {
    let words = words(name);
    let is_one_of = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let last = words.last().map_or("", String::as_str);
    if is_one_of(&COUNTS) || LONG_UNITS.contains(&last) {
        return None;
    }
    let at = UNITS.iter().position(|&(unit, _)| unit == last);
    let unit = at.filter(|&at| at >= 4 || words.len() > 1);
    let of_time = |word: &String| {
        word.starts_with("time") || word.ends_with("time") || word.ends_with("stamp")
    };
    let speaks =
        is_one_of(&WORDS) || words.iter().any(of_time) || unit.is_some_and(|unit| unit >= 4);
    // What stands in brackets is a unit, or the place in an array.
    let bracketed = name.trim_end().ends_with([')', ']']);
    let is_place = last.chars().all(|c| c.is_ascii_digit());
    let of_other = |word: &String| {
        let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
        OTHERS.contains(&stem)
    };
    let is_other =
        !speaks && words.iter().any(of_other) || bracketed && unit.is_none() && !is_place;
    (!is_other).then(|| NameHint {
        speaks,
        unit_s: unit.map(|at| UNITS[at].1),
    })
}

/// `timeBootMs`, `time_boot_ms` and `Time boot [ms]` as three words in lower case.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for c in name.replace(['µ', 'μ'], "u").chars() {
        if !c.is_alphanumeric() || (was_lower && c.is_uppercase()) {
            words.push(String::new());
        }
        was_lower = c.is_lowercase();
        if let (true, Some(word)) = (c.is_alphanumeric(), words.last_mut()) {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// How much its name tells, for a column that rises like a time.
fn rises(column: &Column) -> Option<(u8, TimeColumn)> {
    if column.is_text() {
        return None;
    }
    let NameHint { speaks, unit_s } = named(&column.name)?;
    let stamps = column.values.iter().copied().filter(|v| v.is_finite());
    let stamps: Vec<f64> = stamps.collect();
    if stamps.len() < FEWEST || 2 * stamps.len() < column.values.len() {
        return None;
    }
    let steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let part = |count: usize| count as f64 / steps.len() as f64;
    let mut forward: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
    forward.sort_by(f64::total_cmp);
    let median = *forward.get(forward.len() / 2)?;
    let backward = steps.iter().filter(|step| **step < 0.0).count();
    let alike = steps.iter().filter(|step| **step == 0.0).count();
    let is_told = speaks || unit_s.is_some();
    let whole = stamps.iter().all(|stamp| stamp.fract() == 0.0);
    let is_rising = if is_told {
        // A column that restarts, as the nanoseconds of a second do, ends far below the sum of its steps.
        let gained = stamps[stamps.len() - 1] - stamps[0];
        part(backward) <= BACKWARD && gained >= 0.9 * forward.iter().sum::<f64>()
    } else {
        let even = |step: &&f64| (0.5 * median..=2.0 * median).contains(*step);
        let even = forward.iter().filter(even).count();
        // A step of one is that of a number of rows.
        backward == 0 && part(even + alike) >= EVEN && !(whole && median == 1.0)
    };
    // Whole seconds with more rows than one in each are too coarse.
    let is_coarse = unit_s == Some(1.0) && whole && alike > 0;
    if !is_rising || is_coarse || part(alike) > ALIKE[usize::from(!is_told)] {
        return None;
    }
    let guess = if is_told {
        "a guess by its name, as it rises"
    } else {
        "a guess, as it rises evenly (is it the time?)"
    };
    let column = TimeColumn {
        name: column.name.clone(),
        unit_s: unit_s.unwrap_or(1.0),
        stated: unit_s.is_some(),
        guess: Some(guess),
    };
    Some((2 * u8::from(speaks) + u8::from(unit_s.is_some()), column))
}

/// A median step above this, in s, is asked about: it may be in milliseconds.
pub(crate) const LONG_STEP_S: f64 = 10.0;

/// A unit that stamps suggest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LikelyUnit {
    pub(crate) name: &'static str,
    pub(crate) unit_s: f64,
    /// Which figures.
    pub(crate) by: &'static str,
}

/// Steps of a column of unknown unit that are likely ones in ms, us and ns: from so many on.
const LIKELY: [(f64, &str, f64); 3] = [(1.0, "ms", 1e-3), (400.0, "us", 1e-6), (4e5, "ns", 1e-9)];
/// Times since 1970 from 2001 to 2096 begin with these, in s, ms, us and ns; and the longest steps
/// with which they are not rather shorter units since the start of a computer.
const UNIX: [(f64, f64, &str, f64); 4] = [
    (1e9, 60.0, "s", 1.0),
    (1e12, 6e4, "ms", 1e-3),
    (1e15, 2e6, "us", 1e-6),
    (1e18, f64::INFINITY, "ns", 1e-9),
];

/// The unit that stamps of this size and with this median step suggest, where seconds are not
/// likely: since 1970, or else at rates between 2.5 Hz and 2.5 kHz.
pub(crate) fn likely_unit(step: f64, largest: f64) -> Option<LikelyUnit> {
    let unix = |&&(from, longest, ..): &&(f64, f64, &str, f64)| {
        (from..4.0 * from).contains(&largest) && step <= longest
    };
    let (name, unit_s, by) = match UNIX.iter().find(unix) {
        Some(&(.., name, unit_s)) => (name, unit_s, "size"),
        None => {
            let unit = LIKELY.iter().rev().find(|(from, ..)| step >= *from);
            unit.map(|&(_, name, unit_s)| (name, unit_s, "steps"))?
        }
    };
    (unit_s != 1.0).then_some(LikelyUnit { name, unit_s, by })
}
