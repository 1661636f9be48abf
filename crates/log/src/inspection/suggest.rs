//! Guesses from column names. They only serve messages and suggested maps; no reader uses them.

use super::recognise::Guess;
use super::thrust::why_not;
use crate::{ColumnSummary, TimeBase};
use std::collections::BTreeSet;
use touchdown_trial::TIME_CHANNEL;

/// Rows of a table that is read as steady points. Tables of manufacturers have up to 40; a record of a second has more
/// than 60. Identification takes such a table as a static curve.
const FEW_ROWS: usize = 60;

/// An expression for a column times a factor.
pub(crate) fn scaled(name: &str, factor: f64) -> String {
    if factor == 1.0 {
        quoted(name)
    } else {
        format!("{factor:e} * {}", quoted(name))
    }
}

/// The text of a map to start from. It contains the channels that names, units or sizes suggest;
/// those by size have a comment to check them. All other columns follow as comments, and so does the
/// time if no column contains it. A table with our own names gets no map, unless a column seems to
/// be a channel of another name.
pub(crate) fn map_text(
    columns: &[ColumnSummary],
    guesses: &[Guess],
    time: Option<&TimeBase>,
) -> Option<String> {
    let guessed: BTreeSet<usize> = guesses
        .iter()
        .flat_map(|guess| guess.columns.iter().copied())
        .collect();
    let is_named = |guess: &Guess| columns.iter().any(|column| column.name == guess.channel);
    let numbers = |column: &&ColumnSummary| column.name == TIME_CHANNEL && column.text.is_none();
    if columns.iter().any(|column| numbers(&column)) && guesses.iter().all(is_named) {
        return None;
    }
    let mut text = String::from("schema = 1\n\n");
    vehicle(&mut text, guesses);
    text.push_str("[channels]\n");
    match time {
        Some(base) => time_lines(&mut text, base),
        // A table of steady points has no time: its rows only need an order.
        None if is_bench_table(columns, guesses) => line(
            &mut text,
            TIME_CHANNEL,
            "row",
            Some("no time: each row is taken as one steady point".to_owned()),
        ),
        // It is a comment, so that the map is invalid until the user states the period.
        None => text.push_str(
            "# time_s = 'row * 0.01'  # no column looks like the time: what is the period?\n",
        ),
    }
    for guess in guesses {
        channel_lines(&mut text, guess);
    }
    for (at, column) in columns.iter().enumerate() {
        let is_time = time.is_some_and(|base| base.column == column.name);
        if is_time || guessed.contains(&at) {
            continue;
        }
        let what = match (&column.text, column.count) {
            (Some(example), _) => format!(", text such as {example:?}"),
            (None, 0) => ", empty".to_owned(),
            _ => String::new(),
        };
        let why = why_not(column, guesses).map_or_else(String::new, |why| format!(": {why}"));
        let name = quoted(&column.name).replace(['\n', '\r'], " ");
        text.push_str(&format!("# {name}{what}{why}\n"));
    }
    Some(text)
}

/// The table of the vehicle: how many rotors a measured thrust is of, where the throttle or the speed is the mean of
/// several motors. Each of them would be counted if it were a channel of its own; a mean does not show them.
fn vehicle(text: &mut String, guesses: &[Guess]) {
    let of = |channel: &str| guesses.iter().find(|guess| guess.channel == channel);
    let mean = ["throttle", "rotor_rpm"].into_iter().filter_map(of);
    let mean = mean.into_iter().find(|guess| guess.averaged > 1);
    if let (Some(mean), Some(_)) = (mean, of("thrust_n")) {
        text.push_str(&format!(
            "[vehicle]\nmeasured_rotors = {}  # {} is the mean of so many motors: is thrust_n the thrust of all of them?\n\n",
            mean.averaged, mean.channel
        ));
    }
}

/// The line of a channel. Where the user has to choose, there is a comment for each choice.
fn channel_lines(text: &mut String, guess: &Guess) {
    if guess.choices.is_empty() {
        line(text, guess.channel, &guess.expression, guess.check.clone());
        return;
    }
    text.push_str(&format!(
        "# {} columns look like {}: remove the # of one line\n",
        guess.columns.len(),
        guess.channel
    ));
    for (expression, remark) in &guess.choices {
        text.push_str("# ");
        line(text, guess.channel, expression, Some(remark.clone()));
    }
}

/// What the suggested map asks, one sentence each.
pub(crate) fn questions(columns: &[ColumnSummary], guesses: &[Guess]) -> Vec<String> {
    let asked = guesses.iter().filter(|guess| !guess.choices.is_empty());
    let question = |guess: &Guess| {
        let names = guess
            .columns
            .iter()
            .map(|&at| format!("{:?}", columns[at].name));
        let names: Vec<String> = names.collect();
        format!(
            "{} look like {}: the map to start from has their sum and each alone as comments. Remove the # of one line",
            names.join(" and "),
            guess.channel
        )
    };
    asked.map(question).collect()
}

/// The line of the time. Where its unit is not clear, there are two lines as comments, so that the map is invalid until the
/// user has chosen one.
fn time_lines(text: &mut String, base: &TimeBase) {
    if let (true, Some(period_s)) = (base.is_ambiguous(), base.period_s) {
        let step = period_s / base.unit_s;
        let guess = base
            .guess
            .map_or_else(String::new, |guess| format!("; {guess}"));
        let name = quoted(&base.column).replace(['\n', '\r'], " ");
        text.push_str(&format!(
            "# {name} does not state its unit, and its steps of {step} may be s or ms: remove the # of one line{guess}\n"
        ));
        for (unit, unit_s) in [("s", 1.0), ("ms", 1e-3)] {
            // Three digits after the point are enough to recognise one's own log.
            let short = |number: f64| (number * 1e3).round() / 1e3;
            let (rate_hz, duration_s) = (
                1.0 / (step * unit_s),
                base.duration_s / base.unit_s * unit_s,
            );
            let check = format!(
                "in {unit}: {} Hz for {} s",
                short(rate_hz),
                short(duration_s)
            );
            text.push_str("# ");
            line(
                text,
                TIME_CHANNEL,
                &scaled(&base.column, unit_s),
                Some(check),
            );
        }
        return;
    }
    let likely = base.likely_unit();
    let unit_s = likely.map_or(base.unit_s, |likely| likely.unit_s);
    let unit = likely.map(|likely| format!("in {} by its {}", likely.name, likely.by));
    let check = match (base.guess, unit) {
        (Some(guess), None) if !base.unit_stated => Some(format!("{guess}; in s by its steps")),
        (Some(guess), None) => Some(guess.to_owned()),
        (Some(guess), Some(unit)) => Some(format!("{guess}; {unit}")),
        (None, unit) => unit,
    };
    line(text, TIME_CHANNEL, &scaled(&base.column, unit_s), check);
}

/// Whether a table has throttle and thrust in few rows.
fn is_bench_table(columns: &[ColumnSummary], guesses: &[Guess]) -> bool {
    let rows = columns.iter().map(|column| column.count + column.gaps);
    let has = |channel: &str| guesses.iter().any(|guess| guess.channel == channel);
    rows.max().is_some_and(|rows| rows <= FEW_ROWS) && has("throttle") && has("thrust_n")
}

/// A column's name as an expression writes it.
pub(crate) fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

fn line(text: &mut String, channel: &str, expression: &str, check: Option<String>) {
    // A TOML literal string, unless the name holds what one may not hold.
    let literal = if expression.chars().any(|c| c == '\'' || c.is_control()) {
        basic_string(expression)
    } else {
        format!("'{expression}'")
    };
    let check = check.map_or_else(String::new, |check| format!("  # {check}"));
    text.push_str(&format!("{channel} = {literal}{check}\n"));
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
