//! The swept and drawn keys of a sweep file, and setting them in a scenario.

use std::collections::HashSet;

use toml::{Table, Value};

use super::draw::Distribution;
use crate::settings_file::merge;

/// A key that makes no sense, and why.
pub(super) type KeyError = (String, String);

/// A place in a scenario that has keys below it.
enum Entry<'a> {
    Table(&'a mut Table),
    Array(&'a mut Vec<Value>),
}

impl<'a> Entry<'a> {
    fn of(value: &'a mut Value) -> Option<Self> {
        match value {
            Value::Table(table) => Some(Self::Table(table)),
            Value::Array(array) => Some(Self::Array(array)),
            _ => None,
        }
    }
}

/// The lists of a grid, whose keys may be dotted, quoted or not.
pub(super) fn lists(
    above: &str,
    table: &Table,
    out: &mut Vec<(String, Vec<Value>)>,
) -> std::result::Result<(), KeyError> {
    for (key, value) in table {
        let key = format!("{above}{key}");
        match value {
            Value::Array(values) if values.is_empty() => {
                return Err((
                    key,
                    "expected at least one value, found an empty list".into(),
                ));
            }
            Value::Array(values) => {
                out.push((key, values.clone()));
            }
            Value::Table(below) => lists(&format!("{key}."), below, out)?,
            _ => return Err((key, format!("expected a list of values, found {value}"))),
        }
    }
    Ok(())
}

/// A value that stands twice in a list, if one does.
pub(super) fn twice(values: &[Value]) -> Option<&Value> {
    let mut seen = HashSet::new();
    values.iter().find(|value| {
        // Both zeros are one number.
        let text = value.as_float().map_or_else(
            || value.to_string(),
            |number| Value::Float(number + 0.0).to_string(),
        );
        !seen.insert(text)
    })
}

/// The distributions of a sweep.
pub(super) fn distributions(
    above: &str,
    table: &Table,
    out: &mut Vec<(String, Distribution)>,
) -> std::result::Result<(), KeyError> {
    for (key, value) in table {
        let key = format!("{above}{key}");
        match value {
            Value::Table(below)
                if !below.get("kind").is_some_and(Value::is_str)
                    && below.values().all(Value::is_table) =>
            {
                distributions(&format!("{key}."), below, out)?;
            }
            Value::Table(_) => {
                let of: Distribution = value.clone().try_into().map_err(|e: toml::de::Error| {
                    (key.clone(), format!("{}, found {value}", e.message()))
                })?;
                of.check().map_err(|message| (key.clone(), message))?;
                out.push((key, of));
            }
            _ => {
                return Err((
                    key,
                    format!(
                        "expected a distribution such as {{ kind = \"uniform\", min = 0.0, max = 1.0 }}, found {value}"
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Sets a dotted key; parts that are numbers are places in lists.
pub(super) fn set(table: &mut Table, key: &str, value: &Value) -> std::result::Result<(), String> {
    let mut parts = key.split('.').peekable();
    let mut here = Entry::Table(table);
    while let Some(part) = parts.next() {
        let last = parts.peek().is_none();
        let below = match here {
            Entry::Table(table) if last => {
                merge(table, Table::from_iter([(part.to_string(), value.clone())]));
                return Ok(());
            }
            Entry::Table(table) => table
                .entry(part)
                .or_insert_with(|| Value::Table(Table::new())),
            Entry::Array(array) => {
                let length = array.len();
                let item = part
                    .parse::<usize>()
                    .ok()
                    .and_then(|place| array.get_mut(place));
                let item = item.ok_or_else(|| {
                    format!("expected a place from 0 to below {length} in a list, found `{part}`")
                })?;
                if last {
                    *item = value.clone();
                    return Ok(());
                }
                item
            }
        };
        here = Entry::of(below).ok_or_else(|| format!("`{part}` has no keys below it"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_keys_reach_into_tables_and_lists() {
        let mut table: Table =
            toml::from_str("a = { b = 1.0, c = 2.0 }\nl = [{ x = 1 }, { x = 2 }]\n").unwrap();
        set(&mut table, "a.b", &5.0.into()).unwrap();
        set(&mut table, "l.1.x", &7.into()).unwrap();
        set(&mut table, "a.d.e", &true.into()).unwrap();
        let expected: Table = toml::from_str(
            "a = { b = 5.0, c = 2.0, d = { e = true } }\nl = [{ x = 1 }, { x = 7 }]\n",
        )
        .unwrap();
        assert_eq!(table, expected);
        // A table keeps what is not given; one of another kind is replaced whole.
        set(
            &mut table,
            "a",
            &Value::Table(toml::from_str("c = 3.0").unwrap()),
        )
        .unwrap();
        assert_eq!(table["a"]["b"], 5.0.into());
        set(
            &mut table,
            "a",
            &Value::Table(toml::from_str("kind = \"still\"").unwrap()),
        )
        .unwrap();
        assert!(table["a"].get("b").is_none());
        assert!(
            set(&mut table, "l.2.x", &1.into())
                .unwrap_err()
                .contains("below 2")
        );
        assert!(
            set(&mut table, "l.0.x.y", &1.into())
                .unwrap_err()
                .contains("`x`")
        );
    }

    #[test]
    fn prop_values_that_stand_twice_are_found_in_long_lists() {
        let mut values: Vec<Value> = (0..200_000).map(|i| f64::from(i).into()).collect();
        assert_eq!(twice(&values), None);
        values.push((-0.0).into());
        assert_eq!(twice(&values), Some(&(-0.0).into()));
        // A whole number and its float are two values.
        assert_eq!(twice(&[1.into(), 1.0.into()]), None);
        let table = |text: &str| Value::Table(toml::from_str(text).unwrap());
        let (a, b) = (table("a = 1\nb = 2"), table("b = 2\na = 1"));
        assert_eq!(twice(&[a, b.clone()]), Some(&b));
    }

    #[test]
    fn prop_keys_may_be_quoted_or_not() {
        let read = |text: &str| {
            let mut out = Vec::new();
            lists("", &toml::from_str(text).unwrap(), &mut out).unwrap();
            out
        };
        assert_eq!(read("\"a.b\" = [1]"), read("a.b = [1]"));
        let mut out = Vec::new();
        let text = "a.b = { kind = \"uniform\", min = 0.0, max = 1.0 }";
        distributions("", &toml::from_str(text).unwrap(), &mut out).unwrap();
        assert_eq!(out[0].0, "a.b");
    }
}
