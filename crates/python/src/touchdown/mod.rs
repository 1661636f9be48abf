//! Trials, identification, model cards, landings and campaigns for the package `touchdown`.

pub(crate) mod campaign;
pub(crate) mod card;
pub(crate) mod commanded;
pub(crate) mod identify;
pub(crate) mod land;
pub(crate) mod policy;
pub(crate) mod reproduce;
pub(crate) mod space;
pub(crate) mod trial;
pub(crate) mod validate;
pub(crate) mod vertical;

use pyo3::PyErr;
use pyo3::exceptions::PyOSError;
use touchdown_log::LogError;

use crate::error::fault;

/// An error of reading: the sentence names file, place, expected and found.
fn of_log(key: &str, error: &LogError) -> PyErr {
    let (expected, found) = match error {
        LogError::MapValue {
            expected, found, ..
        } => (expected.clone(), found.clone()),
        LogError::Excess { most, found, .. } => (format!("at most {most}"), found.clone()),
        LogError::NotText { found, .. } => {
            ("a text table in UTF-8".to_owned(), (*found).to_owned())
        }
        LogError::UnknownColumn {
            found, available, ..
        } => (format!("one of {}", available.join(", ")), found.clone()),
        other => ("a log that can be read".to_owned(), other.to_string()),
    };
    fault(error.to_string(), key, &expected, &found)
}

/// An error of identification or of a prediction.
fn of_identify(error: &touchdown_identify::Error) -> PyErr {
    use touchdown_identify::Error as E;
    let message = error.to_string();
    match error {
        E::Identification(inner) => crate::error::of(inner),
        E::Data {
            trial,
            expected,
            found,
        } => fault(message, trial, expected, found),
        E::Trial(touchdown_trial::TrialError::Missing {
            channel, available, ..
        }) => {
            let found = available.join(", ");
            fault(message, channel, "a channel of the trial", &found)
        }
        E::Settings {
            file,
            message: text,
        } => fault(message.clone(), file, "known keys and values", text),
        other => fault(
            message,
            "data",
            "what the sentence says",
            &other.to_string(),
        ),
    }
}

/// An error of a report: of the disk, or of what the report is of.
fn of_page(error: &touchdown_pages::Error) -> PyErr {
    use touchdown_pages::Error as E;
    match error {
        E::Identification(e) => of_identify(e),
        E::Campaign(e) => of_campaign(e),
        other => PyOSError::new_err(other.to_string()),
    }
}

/// An error of a card.
fn of_card(error: &touchdown_model::CardError) -> PyErr {
    use touchdown_model::CardError as E;
    let message = error.to_string();
    match error {
        E::Value {
            key,
            expected,
            found,
            ..
        } => fault(message, key, expected, found),
        E::Schema {
            expected, found, ..
        } => fault(message, "schema", &expected.to_string(), found),
        other => fault(message, "card", "a model card", &other.to_string()),
    }
}

/// The part of a sentence between two marks.
fn between<'a>(text: &'a str, from: &str, to: &[&str]) -> Option<&'a str> {
    let rest = &text[text.find(from)? + from.len()..];
    let end = to.iter().filter_map(|mark| rest.find(mark)).min();
    Some(&rest[..end.unwrap_or(rest.len())])
}

/// An error of landings. Faults of settings are sentences, with key, expected and found in them.
fn of_campaign(error: &touchdown_campaign::Error) -> PyErr {
    use touchdown_campaign::Error as E;
    let message = error.to_string();
    match error {
        E::Card(error) => of_card(error),
        E::Simulation(error) => of_sim(error),
        // A disk or a server may fail for a while. The caller did nothing wrong and may try again.
        E::File { source, .. } => std::io::Error::new(source.kind(), message).into(),
        E::Data {
            trial,
            expected,
            found,
        } => fault(message, trial, expected, found),
        _ => {
            let part = |from, to: &[&str]| between(&message, from, to).unwrap_or_default();
            let key = ["setting `", "`"].map(|mark| part(mark, &["`"]));
            let key = key.into_iter().find(|key| !key.is_empty());
            let key = key.unwrap_or("scenario");
            let expected = match part("expected ", &[", found", "; found"]) {
                "" => "what the sentence says",
                expected => expected,
            };
            let found = match part("found ", &[]) {
                "" => message.as_str(),
                found => found,
            };
            fault(message.clone(), key, expected, found)
        }
    }
}

/// An error of the simulator.
fn of_sim(error: &touchdown_sim::SimError) -> PyErr {
    use touchdown_sim::SimError as E;
    let message = error.to_string();
    match error {
        E::Setting {
            key,
            expected,
            found,
        } => fault(message, key, expected, found),
        other => fault(
            message,
            "scenario",
            "one that can be flown",
            &other.to_string(),
        ),
    }
}
