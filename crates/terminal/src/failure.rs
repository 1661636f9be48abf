//! What a command that fails prints.

use std::io::Write as _;

use crate::escape;

/// The object of a command that fails, on one line.
pub(crate) fn refusal(error: &str, outcome: &str) -> String {
    let object = serde_json::json!({ "error": error, "outcome": outcome });
    escape::json(&object.to_string()).into_owned()
}

/// Prints why a command fails: text on standard error, and the object where JSON was asked for.
pub(crate) fn failure(json: bool, error: &str, outcome: &str) {
    let _ = writeln!(anstream::stderr(), "error: {}", escape::text(error));
    if json {
        let _ = writeln!(anstream::stdout(), "{}", refusal(error, outcome));
    }
}
