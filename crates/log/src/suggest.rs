//! Guesses from column names, for messages and suggested maps only: nothing is read by them.

use crate::{Column, ColumnKind, Table};
use touchdown_trial::TIME_CHANNEL;

/// The name most similar to `name`, if any is similar at all.
pub(crate) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    let wanted: Vec<char> = name.to_lowercase().chars().collect();
    if wanted.is_empty() || wanted.len() > 200 {
        return None;
    }
    known
        .map(|candidate| {
            let letters: Vec<char> = candidate.to_lowercase().chars().take(400).collect();
            // A name without its unit is as good as a small slip.
            let distance = if wanted.len() >= 3 && letters.starts_with(&wanted) {
                1
            } else {
                edit_distance(&wanted, &letters)
            };
            (distance, candidate)
        })
        .min_by_key(|&(distance, _)| distance)
        .filter(|&(distance, _)| distance <= (wanted.len() / 3).max(1))
        .map(|(_, candidate)| candidate.to_owned())
}

/// Levenshtein's distance, one row of the table at a time.
fn edit_distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

/// A column that seems to be the time.
pub(crate) struct TimeGuess<'a> {
    pub(crate) column: &'a Column,
    /// Seconds per unit of the column.
    pub(crate) scale_s: f64,
    /// Whether the name tells the unit.
    pub(crate) stated: bool,
}

pub(crate) fn time_of(column: &Column) -> Option<TimeGuess<'_>> {
    let guess = |scale_s, stated| {
        Some(TimeGuess {
            column,
            scale_s,
            stated,
        })
    };
    if column.kind == ColumnKind::Stamp {
        return guess(1.0, true);
    }
    let (base, unit) = base_and_unit(&column.name);
    if column.is_text() || !matches!(base.as_str(), "t" | "time" | "timestamp" | "elapsed time") {
        return None;
    }
    match unit.as_str() {
        "s" | "sec" => guess(1.0, true),
        "ms" => guess(1e-3, true),
        "us" => guess(1e-6, true),
        "ns" => guess(1e-9, true),
        "" => guess(1.0, false),
        _ => None,
    }
}

pub(crate) fn guess_time(table: &Table) -> Option<TimeGuess<'_>> {
    table.columns.iter().find_map(time_of)
}

/// `Thrust (gf)`, `weight[g]`, `t_s` and `TimeUS` as what and unit, in lower case; `µ` is `u`.
fn base_and_unit(name: &str) -> (String, String) {
    let name = name
        .to_lowercase()
        .replace(['µ', 'μ'], "u")
        .replace(['·', '⋅'], "");
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((base, unit)) = name.strip_suffix(close).and_then(|n| n.rsplit_once(open)) {
            return (base.trim().to_owned(), unit.trim().to_owned());
        }
    }
    match name.rsplit_once('_') {
        Some((base, unit)) => (base.to_owned(), unit.to_owned()),
        None => match name
            .strip_prefix("time")
            .filter(|unit| ["ms", "us", "ns"].contains(unit))
        {
            Some(unit) => ("time".to_owned(), unit.to_owned()),
            None => (name, String::new()),
        },
    }
}

/// Words in a column's name, its unit, the channel and the factor: `channel = factor * column`.
const CHANNELS: [(&[&str], &str, &str, &str); 15] = [
    (
        &["thrust", "force", "weight"],
        "gf",
        "thrust_n",
        "9.80665e-3 * ",
    ),
    (
        &["thrust", "force", "weight"],
        "g",
        "thrust_n",
        "9.80665e-3 * ",
    ),
    (
        &["thrust", "force", "weight"],
        "kgf",
        "thrust_n",
        "9.80665 * ",
    ),
    (&["thrust", "force"], "n", "thrust_n", ""),
    (&["torque"], "nm", "torque_n_m", ""),
    (&["volt", "bat"], "v", "battery_v", ""),
    (&["volt", "bat"], "mv", "battery_v", "1e-3 * "),
    (&["batt. volts"], "", "battery_v", ""),
    (&["current"], "a", "current_a", ""),
    (&["current"], "ma", "current_a", "1e-3 * "),
    (&["amps"], "", "current_a", ""),
    (&["speed"], "rpm", "rotor_rpm", ""),
    (&["rpm"], "", "rotor_rpm", ""),
    (&["height", "altitude"], "m", "height_m", ""),
    (&["throttle"], "", "throttle", ""),
];

/// The text of a map to start from. Channels whose unit a column's name tells are filled in; all
/// other columns stand below as comments.
pub(crate) fn map_text(table: &Table) -> String {
    let mut text = String::from("schema = 1\n\n[channels]\n");
    let time = guess_time(table);
    match &time {
        Some(guess) => {
            let quoted = quoted(&guess.column.name);
            let scaled = if guess.scale_s == 1.0 {
                quoted
            } else {
                format!("{:e} * {quoted}", guess.scale_s)
            };
            line(&mut text, TIME_CHANNEL, &scaled);
        }
        None => text.push_str(
            "time_s = 'row * 0.01'  # no column looks like the time: what is the period?\n",
        ),
    }
    let mut made: Vec<&str> = Vec::new();
    let mut rest = Vec::new();
    for column in &table.columns {
        if time
            .as_ref()
            .is_some_and(|guess| guess.column.name == column.name)
        {
            continue;
        }
        let filled = column.values.iter().any(|value| !value.is_nan());
        match channel_of(&column.name) {
            Some((channel, expression)) if filled && !made.contains(&channel) => {
                made.push(channel);
                line(&mut text, channel, &expression);
            }
            _ => rest.push(column),
        }
    }
    for column in rest {
        let what = match column.kind {
            ColumnKind::Text { .. } => ", text",
            _ if column.values.iter().all(|value| value.is_nan()) => ", empty",
            _ => "",
        };
        let name = quoted(&column.name).replace(['\n', '\r'], " ");
        text.push_str(&format!("# {name}{what}\n"));
    }
    text
}

fn channel_of(name: &str) -> Option<(&'static str, String)> {
    let (base, unit) = base_and_unit(name);
    if unit == "us" && (base.contains("esc") || base.contains("pwm")) {
        return Some(("throttle", format!("({} - 1000) / 1000", quoted(name))));
    }
    CHANNELS
        .iter()
        .find(|(words, of, _, _)| unit == *of && words.iter().any(|word| base.contains(word)))
        .map(|&(_, _, channel, factor)| (channel, format!("{factor}{}", quoted(name))))
}

/// A column's name as an expression writes it.
fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

fn line(text: &mut String, channel: &str, expression: &str) {
    // A TOML literal string, unless the name holds what one may not hold.
    let literal = if expression.chars().any(|c| c == '\'' || c.is_control()) {
        basic_string(expression)
    } else {
        format!("'{expression}'")
    };
    text.push_str(&format!("{channel} = {literal}\n"));
}

pub(crate) fn basic_string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
