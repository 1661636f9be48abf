//! Settings as they stand in TOML files.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use touchdown_files::TomlError;

use crate::error::{Error, Result};

/// Checks a seed: TOML has 64-bit signed numbers.
///
/// # Errors
/// A seed that TOML cannot hold.
pub fn check_seed(seed: u64, file: &str) -> Result<()> {
    if i64::try_from(seed).is_ok() {
        return Ok(());
    }
    Err(Error::Settings {
        file: file.to_string(),
        message: format!("key `seed`: expected at most {}, found {seed}", i64::MAX),
    })
}

/// Reads settings from a TOML file. Keys that the file leaves out, at any depth, have the value that they have in
/// `T::default()`.
///
/// # Errors
/// A file that cannot be read, or keys and values that make no sense, with file, line and key.
pub fn read<T: Default + DeserializeOwned + Serialize>(path: &Path) -> Result<T> {
    read_with_given(path).map(|(settings, _)| settings)
}

/// As [`read`], with the keys that the file has.
pub(crate) fn read_with_given<T: Default + DeserializeOwned + Serialize>(
    path: &Path,
) -> Result<(T, toml::Table)> {
    let file = path.display().to_string();
    let text = touchdown_files::read_text(path).map_err(|e| Error::Settings {
        file: file.clone(),
        message: format!("cannot be read: {e}"),
    })?;
    let settings = parse(&text, &file)?;
    // Text that was just parsed.
    let given = toml::from_str(&text).unwrap_or_default();
    Ok((settings, given))
}

/// As [`read`], from text; `file` names it in errors.
///
/// # Errors
/// Keys and values that make no sense, with file, line and key.
pub fn parse<T: Default + DeserializeOwned + Serialize>(text: &str, file: &str) -> Result<T> {
    let bad = |e: toml::de::Error| Error::Settings {
        file: file.to_string(),
        message: TomlError::new(text, &e).to_string(),
    };
    let given: toml::Table = toml::from_str(text).map_err(bad)?;
    let mut whole: toml::Table = toml::from_str(&to_toml(&T::default())?).map_err(bad)?;
    merge(&mut whole, given);
    whole.try_into().map_err(|merged| {
        // The text as it stands gives the same error with its line, unless it merely leaves keys out.
        match toml::from_str::<T>(text) {
            Err(e) if !e.message().contains("missing field") => bad(e),
            _ => bad(merged),
        }
    })
}

/// Puts `given` over `base`, table by table. A table of another `kind` (or `shape`) replaces the old one whole, and so does one
/// that holds nothing but a form of another name, as a thrust model does.
pub fn merge(base: &mut toml::Table, given: toml::Table) {
    for (key, value) in given {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(old)), toml::Value::Table(new))
                if ["kind", "shape"]
                    .iter()
                    .all(|tag| new.get(*tag).is_none_or(|of| old.get(*tag) == Some(of)))
                    && !are_forms(old, &new) =>
            {
                merge(old, new);
            }
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// Whether both tables hold nothing but a table of one name, and the names differ.
fn are_forms(old: &toml::Table, new: &toml::Table) -> bool {
    let form = |table: &toml::Table| match table.iter().next() {
        Some((name, toml::Value::Table(_))) if table.len() == 1 => Some(name.clone()),
        _ => None,
    };
    matches!((form(old), form(new)), (Some(old), Some(new)) if old != new)
}

/// Settings as TOML text.
///
/// # Errors
/// A value that TOML cannot hold.
pub fn to_toml<T: Serialize>(settings: &T) -> Result<String> {
    toml::to_string(settings).map_err(|e| Error::Settings {
        file: "settings".to_string(),
        message: e.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_form_replaces_a_form_of_another_name_and_a_table_is_merged() {
        let table = |text: &str| toml::from_str::<toml::Table>(text).unwrap();
        let base = "[models]\nmu = 2.0\n[models.thrust.library]\none = 1.0\nx = 3.0\n";
        let merged = |given: &str| {
            let mut whole = table(base);
            merge(&mut whole, table(given));
            whole
        };
        let other = "[models.thrust.static_sqrt]\na = 1.0\n";
        let expected = "[models]\nmu = 2.0\n[models.thrust.static_sqrt]\na = 1.0\n";
        assert_eq!(merged(other), table(expected));
        let expected = "[models]\nmu = 2.0\n[models.thrust.library]\none = 1.0\nx = 4.0\n";
        assert_eq!(
            merged("[models.thrust.library]\nx = 4.0\n"),
            table(expected)
        );
    }
}
