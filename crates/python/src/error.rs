//! Errors of the library as Python exceptions.

use std::any::Any;

use pyo3::import_exception;
use pyo3::prelude::*;

// The classes stand in `python/sindy/_errors.py`, where people and type checkers read them.
import_exception!(sindy._errors, SindyError);
import_exception!(sindy._errors, InternalError);

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

/// A text in JSON from the Python side that does not read: settings with unknown keys or values.
pub(crate) fn settings(key: &str, error: &serde_json::Error) -> PyErr {
    let found = error.to_string();
    // Line and column are of a text that the caller never saw.
    let found = found.split(" at line ").next().unwrap_or(&found);
    fault(
        format!("setting `{key}`: {found}"),
        key,
        "known keys and values",
        found,
    )
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
