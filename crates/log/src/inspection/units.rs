//! Units of columns: in the name, or in a row of units below the header.

use crate::ColumnSummary;

/// Newtons in a pound of force: 0.453 592 37 kg times 9.806 65 m/s² (both exact).
const LBF: &str = "4.4482216152605 * ";
/// Newtons in an ounce of force, a sixteenth of a pound.
const OZF: &str = "0.27801385095378125 * ";
/// Units of a force as names and tables write them in lower case, and the factor that makes newtons of them. A mass is
/// that of a load cell that is calibrated with weights.
const FORCES: [(&[&str], &str); 7] = [
    (&["n", "newton", "newtons"], ""),
    (&["mn", "millinewton", "millinewtons"], "1e-3 * "),
    (&["kn", "kilonewton", "kilonewtons"], "1e3 * "),
    (
        &["g", "gf", "gram", "grams", "gramf", "gramforce", "gr"],
        "9.80665e-3 * ",
    ),
    (
        &["kg", "kgf", "kilo", "kilos", "kilogram", "kilograms", "kp"],
        "9.80665 * ",
    ),
    (&["lbf", "lb", "lbs", "lbsf", "pound", "pounds"], LBF),
    (&["ozf", "oz", "ounce", "ounces"], OZF),
];

/// The factor from a unit of force to newtons, as an expression writes it.
pub(crate) fn force_factor(unit: &str) -> Option<&'static str> {
    let unit = unit.replace(['-', ' ', '.', '_'], "");
    let known = FORCES
        .iter()
        .find(|(names, _)| names.contains(&unit.as_str()));
    known.map(|&(_, factor)| factor)
}

/// What a column is, and its unit, in lower case: from the row of units, if there is one and the name has no unit in
/// brackets, or else from the name.
pub(crate) fn quantity(column: &ColumnSummary) -> (String, String) {
    quantity_of(&column.name, column.unit.as_deref())
}

/// As [`quantity`] for a name and the cell below it in a row of units.
pub(crate) fn quantity_of(name: &str, unit: Option<&str>) -> (String, String) {
    let is_bracketed = name.trim_end().ends_with([')', ']']);
    let (base, own) = base_and_unit(name);
    match unit.filter(|_| !is_bracketed).map(plain_unit) {
        // The name states the same, as `time_s` does.
        Some(unit) if unit == own => (base, unit),
        Some(unit) => (name.trim().to_lowercase(), unit),
        None => (base, own),
    }
}

/// A cell of a row of units, `[µs]` or `(N)`, as [`base_and_unit`] gives units.
fn plain_unit(unit: &str) -> String {
    let brackets = ['[', ']', '(', ')', '{', '}', '<', '>'];
    simple(unit.trim().trim_matches(brackets).trim())
}

/// A text in lower case, `µ` as `u`, without the dots of products.
fn simple(text: &str) -> String {
    let text = text.to_lowercase().replace(['µ', 'μ'], "u");
    text.replace(['·', '⋅'], "")
}

/// The last word of a name of two words or more, `N` of `Thrust N` and `gf` of `thrustGf`, if it is a unit of force.
pub(crate) fn last_word_of_force(name: &str) -> Option<&'static str> {
    let words = words(name);
    match &words[..] {
        [_, .., last] => force_factor(last),
        _ => None,
    }
}

/// `Thrust (gf)`, `weight[g]`, `t_s` and `TimeUS` as what and unit, in lower case; `µ` is `u`.
pub(crate) fn base_and_unit(name: &str) -> (String, String) {
    let name = simple(name);
    for (open, close) in [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')] {
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

/// `timeBootMs`, `time_boot_ms` and `Time boot [ms]` as three words in lower case.
pub(crate) fn words(name: &str) -> Vec<String> {
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
