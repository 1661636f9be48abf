//! Recognises the time column of a table and its unit.

use super::recognise::channels;
use super::tally::{Tally, TimeColumn, View};
use super::units::{quantity_of, words};
use crate::{Column, ColumnKind};

/// Words for time. A name that begins or ends with `time`, or ends with `stamp`, counts as well.
const WORDS: [&str; 12] = [
    "t", "ts", "clock", "elapsed", "epoch", "unix", "uptime", "zeit", "tijd", "tiempo", "tempo",
    "czas",
];
/// Units as the last word of a name, and their seconds. Those from `sec` on suffice as a name.
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
/// Long units of time; a column with one of them is not a guess.
const LONG_UNITS: [&str; 9] = [
    "min", "mins", "minutes", "h", "hr", "hours", "day", "days", "week",
];
/// Words for counters of rows or turns, which exclude a column.
const COUNTS: [&str; 12] = [
    "seq", "sequence", "index", "idx", "id", "count", "counter", "cnt", "step", "steps",
    "timestep", "number",
];
/// Words for other quantities that may increase evenly. They exclude a column unless its name also
/// contains a word for time. A number at their end is ignored.
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
/// Least number of stamps of an increasing column. Fewer values increase by chance.
const FEWEST: usize = 10;
/// Largest share of negative steps, for stamps out of order. It is the loss that [`Findings`]
/// tolerates.
///
/// [`Findings`]: crate::Findings
const BACKWARD: f64 = 0.01;
/// Part of the stamps that may be like the one before, where the name contains time or its unit,
/// and where nothing but the steps does.
const ALIKE: [f64; 2] = [0.5, 0.1];
/// Least share of steps between half and twice the median step in an evenly increasing column.
const EVEN: f64 = 0.9;

/// The likely time column: the first with a clear name or date-time stamps, or else one that
/// increases as time does, with preference for a name that contains a word for time.
pub(crate) fn time_among(columns: &[Column], numbers: &[usize]) -> Option<TimeColumn> {
    let named = columns.iter().find_map(time_of);
    named.or_else(|| rising(columns, numbers))
}

/// The time column, if its name or its date-time stamps are clear.
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
    let (base, unit) = quantity_of(&column.name, column.unit());
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

/// Among the columns that increase as time does, the one with the clearest name; the first of equals.
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

/// Hint of a column's name at a time.
struct NameHint {
    speaks: bool,
    unit_s: Option<f64>,
}

/// The hint of a name; none for the name of another quantity.
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
    // Brackets contain a unit, or an index of an array.
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

/// The seconds of a unit of time.
fn seconds(unit: &str) -> Option<f64> {
    let known = UNITS.iter().find(|&&(name, _)| name == unit);
    known.map(|&(_, unit_s)| unit_s)
}

/// Clearness of the name of a column that increases as time does; none for other columns.
fn rises(column: &Column) -> Option<(u8, TimeColumn)> {
    if column.is_text() {
        return None;
    }
    let NameHint { speaks, unit_s } = named(&column.name)?;
    let unit_s = match column.unit() {
        None => unit_s,
        // A row of units speaks of another quantity.
        Some(unit) => Some(seconds(&quantity_of("", Some(unit)).1)?),
    };
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
        // A column that restarts, such as the nanoseconds of a second, ends far below the sum of its
        // positive steps.
        let gained = stamps[stamps.len() - 1] - stamps[0];
        part(backward) <= BACKWARD && gained >= 0.9 * forward.iter().sum::<f64>()
    } else {
        let even = |step: &&f64| (0.5 * median..=2.0 * median).contains(*step);
        let even = forward.iter().filter(even).count();
        // Whole numbers with a step of one are row numbers.
        backward == 0 && part(even + alike) >= EVEN && !(whole && median == 1.0)
    };
    // Whole seconds with several rows in each are too coarse.
    let is_coarse = unit_s == Some(1.0) && whole && alike > 0;
    if !is_rising || is_coarse || part(alike) > ALIKE[usize::from(!is_told)] {
        return None;
    }
    let guess = if is_told {
        "a guess from its name and its increasing values"
    } else {
        "a guess from its even steps (is it the time?)"
    };
    let column = TimeColumn {
        name: column.name.clone(),
        unit_s: unit_s.unwrap_or(1.0),
        stated: unit_s.is_some(),
        guess: Some(guess),
    };
    Some((2 * u8::from(speaks) + u8::from(unit_s.is_some()), column))
}

/// Median step above which a message asks about milliseconds, s. A log slower than 0.1 Hz is too slow
/// for any identification here.
const LONG_STEP_S: f64 = 10.0;
/// Median step from which a long log is asked about, s: logs of 1 kHz in ms have it.
pub(crate) const SLOW_STEP_S: f64 = 1.0;
/// Longest log of steps from a second on that is no question, s. Multirotors and stands run for minutes, on a tether or
/// by a generator for an hour or two. A log of 100 Hz in ms is that long after 11 s.
const LONG_LOG_S: f64 = 3.0 * 3600.0;

/// Whether a log of this median step (s) and number of rows is so slow that its time may be in ms.
pub(crate) fn is_slow(step_s: f64, rows: usize) -> bool {
    step_s > LONG_STEP_S || step_s >= SLOW_STEP_S && step_s * rows as f64 > LONG_LOG_S
}

/// A unit that stamps suggest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LikelyUnit {
    pub(crate) name: &'static str,
    pub(crate) unit_s: f64,
    /// The figures that suggest the unit.
    pub(crate) by: &'static str,
}

/// Least median step of a column of unknown unit that suggests ms, us or ns.
const LIKELY: [(f64, &str, f64); 3] = [(1.0, "ms", 1e-3), (400.0, "us", 1e-6), (4e5, "ns", 1e-9)];
/// Times since 1970 in s, ms, us and ns: the least value, of the year 2001 (2096 is four times as
/// much), and the longest step. A longer step suggests a shorter unit since the start of a computer.
const UNIX: [(f64, f64, &str, f64); 4] = [
    (1e9, 60.0, "s", 1.0),
    (1e12, 6e4, "ms", 1e-3),
    (1e15, 2e6, "us", 1e-6),
    (1e18, f64::INFINITY, "ns", 1e-9),
];

/// The unit that stamps of this size and median step suggest, if seconds are not likely: a time since
/// 1970, or else a rate between 2.5 Hz and 2.5 kHz.
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

/// Median steps of a column of unknown unit that may be seconds as well as milliseconds: logs of 0.2 to 2.5 Hz, or of 200 Hz
/// to 2.5 kHz. Benches are logged as slowly as autopilots are logged fast.
const AMBIGUOUS: std::ops::Range<f64> = 0.4..5.0;

/// Whether stamps of this size and median step may be seconds as well as milliseconds.
pub(crate) fn is_ambiguous(step: f64, largest: f64) -> bool {
    let by_steps = likely_unit(step, largest).is_none_or(|likely| likely.by == "steps");
    // Seconds since 1970 are known by their size, too.
    by_steps && largest < UNIX[0].0 && AMBIGUOUS.contains(&step)
}
