//! Recognises a thrust without a unit by the columns beside it, and says why a column that looks like a thrust is none.

use super::recognise::{Guess, MOST_N, THRUST, is_command, measured, plain};
use super::suggest::quoted;
use crate::ColumnSummary;

/// Names of forces without a unit, in letters and digits.
const FORCES: [&str; 7] = [
    "thrust", "force", "thrustz", "forcez", "fz", "loadcell", "weight",
];
/// Greatest number that is taken for grams: 20 kg, and fewer than the 65535 of a command of 16 bits.
const MOST_G: f64 = 20_000.0;

/// Whether a name is that of a force without a unit. A small `f` is a frequency.
fn is_force(name: &str) -> bool {
    name.trim() == "F" || FORCES.contains(&plain(name).as_str())
}

/// The greatest distance of a column from zero.
fn size(column: &ColumnSummary) -> f64 {
    let ends = [column.min, column.max].map(|end| end.unwrap_or(0.0).abs());
    ends[0].max(ends[1])
}

/// Numbers that vary and may be a force in N or g. From 0 to 1 they are rather a command.
fn is_of_size(column: &ColumnSummary) -> bool {
    column.text.is_none() && !column.constant && size(column) > 1.0 && size(column) <= MOST_G
}

/// Adds the thrust of a bench: a force without a unit beside a throttle or a speed of rotors. A `u` from 0 to 1 beside
/// such a force is the throttle.
pub(crate) fn beside_throttle(columns: &[ColumnSummary], found: &mut Vec<Guess>) {
    let is_known = |found: &[Guess], channel: &str| found.iter().any(|one| one.channel == channel);
    if is_known(found, "thrust_n") {
        return;
    }
    let is_free = |at: &usize| !found.iter().any(|one| one.columns.contains(at));
    let force = (0..columns.len())
        .filter(is_free)
        .find(|&at| is_force(&columns[at].name) && is_of_size(&columns[at]));
    let Some(force) = force else {
        return;
    };
    let is_input = |column: &ColumnSummary| {
        column.name.trim() == "u" && column.min >= Some(0.0) && column.max <= Some(1.0)
    };
    let input = (0..columns.len())
        .filter(is_free)
        .find(|&at| is_input(&columns[at]) && !columns[at].constant);
    if !is_known(found, "throttle")
        && let Some(at) = input
    {
        found.push(Guess {
            channel: "throttle",
            expression: quoted(&columns[at].name),
            check: Some("from 0 to 1 beside a force: is it the throttle?".to_owned()),
            columns: vec![at],
        });
    }
    if is_known(found, "throttle") || is_known(found, "rotor_rpm") {
        let guess = measured(force, &columns[force], "thrust_n", "");
        let unit = (size(&columns[force]) <= MOST_N).then(|| "in N by its size".to_owned());
        let checks: Vec<String> = unit.into_iter().chain(guess.check).collect();
        found.push(Guess {
            check: Some(checks.join(", and ")),
            ..guess
        });
    }
}

/// Why a column that looks like a thrust is not in the map, and the line that takes it.
pub(crate) fn why_not(column: &ColumnSummary, guesses: &[Guess]) -> Option<String> {
    let name = column.name.to_lowercase();
    let is_thrust = is_force(&column.name) || THRUST.iter().any(|word| name.contains(word));
    if !is_thrust || column.text.is_some() || column.count == 0 {
        return None;
    }
    if is_command(&column.name) {
        return Some("commanded, not measured".to_owned());
    }
    if guesses.iter().any(|guess| guess.channel == "thrust_n") {
        return Some("thrust_n is another column".to_owned());
    }
    let quoted = quoted(&column.name).replace(['\n', '\r'], " ");
    let line = format!("thrust_n = '{quoted}'");
    Some(if !is_force(&column.name) {
        format!("a thrust in which unit? In N: {line}; in g: thrust_n = '9.80665e-3 * {quoted}'")
    } else if size(column) > MOST_G {
        "too large for N or g, perhaps a command".to_owned()
    } else if size(column) <= 1.0 {
        format!("from 0 to 1, perhaps a command. If it is a thrust in N: {line}")
    } else {
        format!(
            "a thrust or a command? No column beside it is a throttle. If it is a thrust in N: {line}"
        )
    })
}
