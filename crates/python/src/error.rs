//! Errors of the library as Python exceptions.

use std::any::Any;

use pyo3::import_exception;
use pyo3::prelude::*;
use serde::de::DeserializeOwned;

// The classes stand in `python/sindy/_errors.py`, where people and type checkers read them.
import_exception!(sindy._errors, SindyError);
import_exception!(sindy._errors, InternalError);

/// How Serde's error of an unknown key begins.
const UNKNOWN: &str = "unknown field ";

/// A fault with its three parts.
pub(crate) fn fault(message: String, key: &str, expected: &str, found: &str) -> PyErr {
    let [key, expected, found] = [key, expected, found].map(str::to_owned);
    SindyError::new_err((message, key, expected, found))
}

/// An error of the library.
pub(crate) fn of(error: &sindy::SindyError) -> PyErr {
    use sindy::SindyError as E;
    let (key, expected, found) = match error {
        E::Setting {
            key,
            expected,
            found,
        } => ((*key).to_owned(), expected.clone(), found.clone()),
        E::Shape {
            what,
            expected,
            found,
        } => ((*what).to_owned(), expected.to_string(), found.to_string()),
        E::TooShort { needed, found } => {
            let expected = format!("at least {needed}");
            ("samples".to_owned(), expected, found.to_string())
        }
        E::NotFinite { what, index } => {
            let found = format!("sample {index} is not");
            (what.clone(), "finite numbers".to_owned(), found)
        }
        E::Range { what, found } => {
            let expected = "a sum of squares from 1e-290 to 1e308".to_owned();
            (what.clone(), expected, format!("{found:e}"))
        }
        E::Magnitude {
            what,
            expected,
            found,
        } => (what.clone(), expected.clone(), format!("{found:e}")),
        E::TimeNotIncreasing { index } => {
            let found = format!("sample {index} is not after the one before");
            ("t".to_owned(), "increasing times".to_owned(), found)
        }
        E::UnknownColumn { name, known } => {
            ("names".to_owned(), format!("one of {known}"), name.clone())
        }
        E::DuplicateTerm { name } => {
            let expected = "terms that differ".to_owned();
            ("library".to_owned(), expected, format!("`{name}` twice"))
        }
        E::Expression { text, reason } => {
            let expected = format!("an expression ({reason})");
            ("library".to_owned(), expected, text.clone())
        }
        E::Specification {
            expected, found, ..
        } => ("library".to_owned(), expected.clone(), found.clone()),
        E::Singular { what } => {
            let expected = "equations with one solution".to_owned();
            ((*what).to_owned(), expected, "singular ones".to_owned())
        }
        E::Json { reason } => {
            let expected = "a model in JSON".to_owned();
            ("json".to_owned(), expected, reason.clone())
        }
        // The remaining kinds say what is wrong in one sentence.
        other => ("data".to_owned(), String::new(), other.to_string()),
    };
    fault(error.to_string(), &key, &expected, &found)
}

/// Reads a text in JSON from the Python side. An error names the setting that cannot be read, and for an unknown key the table
/// that holds the key. `key` names the whole text.
pub(crate) fn read<T: DeserializeOwned>(key: &str, text: &str) -> PyResult<T> {
    let mut json = serde_json::Deserializer::from_str(text);
    serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        let at = if error.inner().to_string().starts_with(UNKNOWN) {
            path.rsplit_once('.').map_or("", |(parent, _)| parent)
        } else {
            path.trim_matches('.')
        };
        settings(if at.is_empty() { key } else { at }, error.inner())
    })
}

/// What does not read or write as JSON: settings with unknown keys or values.
pub(crate) fn settings(key: &str, error: &serde_json::Error) -> PyErr {
    let said = error.to_string();
    // Line and column are of a text that the caller never saw.
    let said = said.split(" at line ").next().unwrap_or(&said);
    let (found, expected) = said
        .split_once(", expected ")
        .map_or((said, "known keys and values"), |(f, e)| (f, in_python(e)));
    let kinds = [
        UNKNOWN,
        "unknown variant ",
        "invalid type: ",
        "invalid value: ",
    ];
    let found = kinds
        .iter()
        .find_map(|kind| found.strip_prefix(kind))
        .unwrap_or(found);
    fault(
        format!("setting `{key}`: expected {expected}, found {found}"),
        key,
        expected,
        found,
    )
}

/// What is expected, in place of the name of a type in Rust.
fn in_python(expected: &str) -> &str {
    match expected {
        "usize" | "u64" | "u32" | "u16" | "u8" => "a whole number from 0",
        "f64" => "a number",
        "a boolean" => "True or False",
        "a string" => "a text",
        "a sequence" => "a list",
        "a map" => "a dict",
        name if name.starts_with("struct ") => "a dict",
        name if name.starts_with("a tuple ") || name.starts_with("an array ") => "a list",
        other => other,
    }
}

/// A panic: a defect, not a fault of the caller.
pub(crate) fn panic(payload: &(dyn Any + Send)) -> PyErr {
    let text = payload
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    InternalError::new_err(format!("the library failed: {text}"))
}
