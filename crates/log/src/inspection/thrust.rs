//! Recognises a thrust without a unit by the columns beside it, and says why a column that looks like a thrust is none.

use super::recognise::{Guess, MOST_N, THRUST, by_word, is_command, measured, plain};
use super::suggest::quoted;
use super::units::{quantity, words};
use crate::ColumnSummary;

/// Names of forces without a unit, in letters and digits.
const FORCES: [&str; 7] = [
    "thrust", "force", "thrustz", "forcez", "fz", "loadcell", "weight",
];
/// Greatest number that is taken for grams: 20 kg, and fewer than the 65535 of a command of 16 bits.
const MOST_G: f64 = 20_000.0;

/// Whether a column is a force without a unit by its name. A small `f` is a frequency.
fn is_force(column: &ColumnSummary) -> bool {
    let name = &column.name;
    column.unit.is_none() && (name.trim() == "F" || FORCES.contains(&plain(name).as_str()))
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

/// Words that tell load cells of one stand apart, besides numbers.
const SIDES: [&str; 18] = [
    "left", "right", "front", "rear", "back", "upper", "lower", "top", "bottom", "l", "r", "a",
    "b", "c", "d", "first", "second", "third",
];
/// Words of the column that is the whole thrust among several, and of the axis that is the thrust among three.
const WHOLE: [&str; 5] = ["total", "sum", "all", "overall", "z"];

/// Asks which of several columns are the thrust. Those whose names differ by a number or a side are load cells of one
/// stand: only the user knows whether each measures a part of the load. Of other columns the first is kept, with the
/// question whether it is the whole thrust.
pub(crate) fn ask_which(columns: &[ColumnSummary], found: &mut [Guess]) {
    let is_known = |at: usize| columns[at].name == "thrust_n";
    let mut known = found.iter_mut();
    let Some(guess) =
        known.find(|guess| guess.channel == "thrust_n" && !is_known(guess.columns[0]))
    else {
        return;
    };
    let mut all: Vec<(Vec<String>, Guess)> = Vec::new();
    for (at, column) in columns.iter().enumerate() {
        let is_measured = column.text.is_none()
            && column.count > 0
            && !column.constant
            && !is_command(&column.name);
        let thrust = by_word(at, column).filter(|one| is_measured && one.channel == "thrust_n");
        let name = words(&quantity(column).0);
        // The same quantity in another unit counts once.
        if let Some(thrust) = thrust
            && all.iter().all(|(known, _)| *known != name)
        {
            all.push((name, thrust));
        }
    }
    if all.len() < 2 {
        return;
    }
    let is_whole =
        |(name, _): &&(Vec<String>, Guess)| name.iter().any(|word| WHOLE.contains(&word.as_str()));
    let whole: Vec<_> = all.iter().filter(is_whole).collect();
    if let [(_, whole)] = &whole[..] {
        (guess.expression, guess.columns) = (whole.expression.clone(), whole.columns.clone());
        guess.check.clone_from(&whole.check);
        return;
    }
    let cells = load_cells(&all);
    if cells.is_empty() {
        let other = quoted(&columns[all[1].1.columns[0]].name).replace(['\n', '\r'], " ");
        let asked = format!("{other} is a force as well: is this the whole thrust?");
        let check = guess.check.take().map(|check| format!("{check}; {asked}"));
        guess.check = Some(check.unwrap_or(asked));
        return;
    }
    let mut sum = cells[0].expression.clone();
    for cell in &cells[1..] {
        match cell.expression.strip_prefix('-') {
            Some(negative) => sum.push_str(&format!(" - {negative}")),
            None => sum.push_str(&format!(" + {}", cell.expression)),
        }
    }
    let whole = "the sum, where each load cell bears a part; of several rotors, state measured_rotors in [vehicle]";
    let alone = |cell: &&Guess| (cell.expression.clone(), "this load cell alone".to_owned());
    guess.choices = vec![(sum, whole.to_owned())];
    guess.choices.extend(cells.iter().map(alone));
    guess.columns = cells.iter().flat_map(|cell| cell.columns.clone()).collect();
    (guess.expression, guess.check) = (String::new(), None);
}

/// The first forces, two or more, whose names differ by a number or a side; nothing without such forces.
fn load_cells(all: &[(Vec<String>, Guess)]) -> Vec<&Guess> {
    let stem = |name: &[String]| -> Vec<String> {
        let words = name
            .iter()
            .map(|word| word.trim_end_matches(|c: char| c.is_ascii_digit()));
        let kept = words.filter(|word| !word.is_empty() && !SIDES.contains(word));
        kept.map(str::to_owned).collect()
    };
    let alike = |of: &[String]| -> Vec<&Guess> {
        let same = all.iter().filter(|(name, _)| stem(name) == of);
        same.map(|(_, cell)| cell).collect()
    };
    let mut groups = all.iter().map(|(name, _)| alike(&stem(name)));
    groups.find(|cells| cells.len() > 1).unwrap_or_default()
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
        .find(|&at| is_force(&columns[at]) && is_of_size(&columns[at]));
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
            ..Guess::default()
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
    let is_thrust = is_force(column) || THRUST.iter().any(|word| name.contains(word));
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
    Some(if !is_force(column) {
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
