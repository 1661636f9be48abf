//! Settings that the flight side refuses, in words.

use touchdown_flight::SettingsError;

/// A setting that the flight side refuses: its key by `key_of`, what is expected, with the keys in it by `key_of` as well, and what was
/// found. None for an error of a kind that is not known here.
pub fn refused_setting(
    error: &SettingsError,
    key_of: impl Fn(&str) -> String,
) -> Option<(String, String, f64)> {
    Some(match *error {
        SettingsError::NotFinite { key, found } => (key_of(key), "a finite number".into(), found),
        SettingsError::OutOfRange {
            key,
            expected,
            found,
        } => (key_of(key), with_keys(expected, &key_of), found),
        SettingsError::Order {
            lower_key,
            lower,
            upper_key,
            upper,
        } => {
            let expected = format!("less than `{}` = {upper}", key_of(upper_key));
            (key_of(lower_key), expected, lower)
        }
        _ => return None,
    })
}

/// A text with its keys, between backquotes, by `key_of`.
fn with_keys(text: &str, key_of: impl Fn(&str) -> String) -> String {
    let parts = text.split('`').enumerate();
    let parts = parts.map(|(i, part)| match i % 2 {
        0 => part.to_owned(),
        _ => format!("`{}`", key_of(part)),
    });
    parts.collect()
}
