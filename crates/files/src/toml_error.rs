//! Errors of TOML files in one sentence.

use std::fmt;
use std::ops::Range;

use sindy_expr::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

/// Where a TOML file is wrong, what was expected there and what was found.
///
/// `Display` writes the line, the key and the sentence: ``line 2, key `flight.mass_kgg`: unknown key; the nearest known
/// key is `mass_kg` ``.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TomlError {
    /// Line from 1, where it is known.
    pub line: Option<usize>,
    /// The key with its tables, dotted; empty where the text is no TOML.
    pub key: String,
    /// What was expected and what was found.
    pub message: String,
}

impl TomlError {
    /// The error of reading `text`, or of a table that was merged from it. Without the text there is no line.
    #[must_use]
    pub fn new(text: &str, error: &Error) -> Self {
        let unknown = unknown_key(error.message());
        let keys = keys_of(error);
        let place = DeTable::parse(text)
            .ok()
            .and_then(|table| match error.span() {
                Some(span) => at_span(table.get_ref(), span.start),
                None => at_key(table.get_ref(), &keys),
            })
            .unwrap_or(Place { keys, span: None });
        let place = match unknown {
            Some(name) => place.below(text, name, error.span().map_or(0, |span| span.start)),
            None => place,
        };
        let start = place.span.or(error.span()).map(|span| span.start);
        Self {
            line: start.map(|start| 1 + text.bytes().take(start).filter(|&b| b == b'\n').count()),
            key: place.keys.join("."),
            message: sentence(error.message()),
        }
    }
}

impl fmt::Display for TomlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.line.map(|line| format!("line {line}"));
        let key = (!self.key.is_empty()).then(|| format!("key `{}`", self.key));
        let place: Vec<String> = line.into_iter().chain(key).collect();
        if !place.is_empty() {
            write!(f, "{}: ", place.join(", "))?;
        }
        f.write_str(&self.message)
    }
}

/// A key with its tables, and the bytes of the text that hold it or its value.
#[derive(Clone, Debug, Default)]
struct Place {
    keys: Vec<String>,
    span: Option<Range<usize>>,
}

impl Place {
    /// The key of that name in this table, or else in one inside it: errors in a table of several kinds only span the table,
    /// from byte `at`.
    fn below(self, text: &str, name: &str, at: usize) -> Self {
        if self.keys.last().is_some_and(|last| last == name) {
            return self;
        }
        let table = DeTable::parse(text).ok();
        let mut found =
            table.map_or_else(Vec::new, |table| named(table.get_ref(), &self.keys, name));
        found.sort_by_key(|place| (!place.begins_from(at), place.keys.len()));
        found.into_iter().next().unwrap_or_else(|| Self {
            keys: [self.keys, vec![name.to_owned()]].concat(),
            span: self.span,
        })
    }

    fn begins_from(&self, at: usize) -> bool {
        self.span.as_ref().is_some_and(|span| span.start >= at)
    }
}

/// All keys of that name in the table of dotted keys, and in tables inside it, in the order of the text.
fn named(table: &DeTable<'_>, keys: &[String], name: &str) -> Vec<Place> {
    let mut found = Vec::new();
    for (key, value) in table {
        let below = match keys.split_first() {
            Some((first, below)) if key.get_ref() == first => below,
            Some(_) => continue,
            None if key.get_ref() == name => {
                found.push(Place {
                    keys: vec![name.to_owned()],
                    span: Some(key.span()),
                });
                continue;
            }
            None => &[],
        };
        for mut place in named_inside(value, below, name) {
            place.keys.insert(0, key.get_ref().to_string());
            found.push(place);
        }
    }
    found
}

/// The same in a table or a list of tables.
fn named_inside(value: &Spanned<DeValue<'_>>, keys: &[String], name: &str) -> Vec<Place> {
    match value.get_ref() {
        DeValue::Table(table) => named(table, keys, name),
        DeValue::Array(values) => values
            .iter()
            .flat_map(|value| named_inside(value, keys, name))
            .collect(),
        _ => Vec::new(),
    }
}

/// The innermost key whose name or value holds byte `at`.
fn at_span(table: &DeTable<'_>, at: usize) -> Option<Place> {
    table.iter().find_map(|(key, value)| {
        let below = inside(value, at);
        let here = [key.span(), value.span()]
            .into_iter()
            .find(|span| span.contains(&at));
        let found = below.or(here.map(|span| Place {
            span: Some(span),
            ..Place::default()
        }));
        found.map(|mut place| {
            place.keys.insert(0, key.get_ref().to_string());
            place
        })
    })
}

/// The innermost key in a table or a list of tables.
fn inside(value: &Spanned<DeValue<'_>>, at: usize) -> Option<Place> {
    match value.get_ref() {
        DeValue::Table(table) => at_span(table, at),
        DeValue::Array(values) => values.iter().find_map(|value| inside(value, at)),
        _ => None,
    }
}

/// The place of dotted keys.
fn at_key(table: &DeTable<'_>, keys: &[String]) -> Option<Place> {
    let (name, below) = keys.split_first()?;
    let (key, value) = table.iter().find(|(key, _)| key.get_ref() == name)?;
    let span = Some(key.span());
    let mut place = match (below, value.get_ref()) {
        ([], _) => Place {
            span,
            ..Place::default()
        },
        (_, DeValue::Table(table)) => at_key(table, below)?,
        _ => return None,
    };
    place.keys.insert(0, name.clone());
    Some(place)
}

/// The keys of an error without a span: its text ends in ``in `a.b` ``.
fn keys_of(error: &Error) -> Vec<String> {
    let text = error.to_string();
    let keys = text
        .trim_end()
        .rsplit('\n')
        .next()
        .and_then(|line| line.strip_prefix("in `")?.strip_suffix('`'));
    keys.map_or_else(Vec::new, |keys| {
        keys.split('.').map(str::to_owned).collect()
    })
}

/// The name of an unknown key.
fn unknown_key(message: &str) -> Option<&str> {
    message
        .strip_prefix("unknown field `")?
        .split_once('`')
        .map(|(name, _)| name)
}

/// The names in backticks.
fn names(list: &str) -> Vec<&str> {
    list.split('`').skip(1).step_by(2).collect()
}

/// `message` with what was expected and what was found in the reader's words.
fn sentence(message: &str) -> String {
    let message = message.trim_end();
    if let Some(name) = unknown_key(message) {
        let known = names(message).split_off(1);
        return match nearest(name, known.iter().copied()) {
            Some(near) => format!("unknown key; the nearest known key is `{near}`"),
            None if known.is_empty() => "unknown key; the table has no keys".to_owned(),
            None => format!("unknown key; expected {}", one_of(&known)),
        };
    }
    if let Some(rest) = message.strip_prefix("unknown variant ") {
        let all = names(rest);
        if let Some((found, known)) = all.split_first() {
            return format!("expected {}, found `{found}`", one_of(known));
        }
    }
    if let Some(rest) = message.strip_prefix("missing field ") {
        return format!("expected the key {rest}, found none");
    }
    let told = ["invalid type: ", "invalid value: ", "invalid length "]
        .into_iter()
        .find_map(|start| message.strip_prefix(start))
        .and_then(|rest| rest.rsplit_once(", expected "));
    match told {
        // A name among some, such as a controller.
        Some((_, "string only")) => "expected a text, found another value".to_owned(),
        Some((found, expected)) => {
            let found = if found == "map" { "a table" } else { found };
            format!("expected {}, found {found}", in_words(expected))
        }
        None => message.replace('\n', "; "),
    }
}

/// Names as a list of which one is expected.
fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match &quoted[..] {
        [one] => one.clone(),
        all => format!("one of {}", all.join(", ")),
    }
}

/// A type of Rust as TOML calls it.
fn in_words(expected: &str) -> &str {
    match expected {
        "f64" | "f32" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u64" | "usize" | "u32" => "a whole number of at least 0",
        "i64" | "i32" => "a whole number",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        other if other.starts_with("struct ") || other.starts_with("internally tagged") => {
            "a table"
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Settings {
        seed: Option<u64>,
        vehicle: Option<Vehicle>,
        deck: Option<Deck>,
        #[serde(default)]
        rows: Vec<Vehicle>,
        #[serde(default)]
        more: BTreeMap<String, f64>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Vehicle {
        mass_kg: f64,
        surface: Option<Surface>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Surface {
        Plate,
        Ground,
    }

    #[derive(Debug, Deserialize)]
    #[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
    #[allow(dead_code)]
    enum Deck {
        Still,
        Sine { amplitude_m: f64 },
        Sines { tones: Vec<Tone> },
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Tone {
        amplitude_m: f64,
    }

    fn error(text: &str) -> String {
        TomlError::new(text, &toml::from_str::<Settings>(text).unwrap_err()).to_string()
    }

    #[test]
    fn prop_an_unknown_key_is_named_with_its_line_its_tables_and_the_nearest_known_key() {
        assert_eq!(
            error("seed = 1\n[vehicle]\nmass_kgg = 1.2\n"),
            "line 3, key `vehicle.mass_kgg`: unknown key; the nearest known key is `mass_kg`"
        );
        assert_eq!(
            error("[vehicle]\nmass_kg = 1\ncolour = 2\n"),
            "line 3, key `vehicle.colour`: unknown key; expected one of `mass_kg`, `surface`"
        );
        assert_eq!(
            error("vehicel.mass_kg = 1\n"),
            "line 1, key `vehicel`: unknown key; the nearest known key is `vehicle`"
        );
        assert_eq!(
            error("[[rows]]\nmass_kg = 1\n[[rows]]\nmas_kg = 1\n"),
            "line 4, key `rows.mas_kg`: unknown key; the nearest known key is `mass_kg`"
        );
    }

    #[test]
    fn prop_a_wrong_value_is_named_with_what_was_expected() {
        assert_eq!(
            error("\nseed = \"one\"\n"),
            "line 2, key `seed`: expected a whole number of at least 0, found string \"one\""
        );
        assert_eq!(
            error("[vehicle]\nmass_kg = 1\nsurface = \"grund\"\n"),
            "line 3, key `vehicle.surface`: expected one of `plate`, `ground`, found `grund`"
        );
        assert_eq!(
            error("vehicle = 3\n"),
            "line 1, key `vehicle`: expected a table, found integer `3`"
        );
        assert_eq!(
            error("[vehicle]\n"),
            "line 1, key `vehicle`: expected the key `mass_kg`, found none"
        );
    }

    #[test]
    fn prop_tables_of_several_kinds_name_the_key_inside() {
        assert_eq!(
            error("[deck]\nkind = \"sine\"\namplitude = 1.0\n"),
            "line 3, key `deck.amplitude`: unknown key; the nearest known key is `amplitude_m`"
        );
        assert_eq!(
            error(
                "[deck]\nkind = \"sines\"\n[[deck.tones]]\namplitude_m = 1\n[[deck.tones]]\namplitude = 1.0\n"
            ),
            "line 6, key `deck.tones.amplitude`: unknown key; the nearest known key is `amplitude_m`"
        );
        assert_eq!(
            error(
                "more.amplitude = 1.0\nseed = 1\n[deck]\nkind = \"sines\"\ntones = [\n  { amplitude_m = 1, amplitude = 2 },\n]\n"
            ),
            "line 6, key `deck.tones.amplitude`: unknown key; the nearest known key is `amplitude_m`"
        );
    }

    #[test]
    fn prop_an_error_of_merged_tables_finds_its_line() {
        let text = "seed = 1\n[vehicle]\nmass_kgg = 1.2\n";
        let merged: toml::Table = toml::from_str(text).unwrap();
        let error = merged.try_into::<Settings>().unwrap_err();
        assert_eq!(
            TomlError::new(text, &error).to_string(),
            "line 3, key `vehicle.mass_kgg`: unknown key; the nearest known key is `mass_kg`"
        );
        assert_eq!(
            TomlError::new("", &error).to_string(),
            "key `vehicle.mass_kgg`: unknown key; the nearest known key is `mass_kg`"
        );
    }

    #[test]
    fn prop_text_that_is_no_toml_is_named_with_its_line() {
        let message = error("seed = 1\nseed = = 2\n");
        assert!(
            message.starts_with("line 2: ") && !message.contains('\n'),
            "{message}"
        );
    }
}
