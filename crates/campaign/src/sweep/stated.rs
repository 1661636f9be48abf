//! Keys of the scenario that a sweep states itself.

use std::collections::BTreeSet;

use toml::{Table, Value};

/// Dotted keys of the scenario with a value in the sweep's file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedKeys(BTreeSet<String>);

impl StatedKeys {
    /// The keys of `[scenario]` in a sweep's file.
    #[must_use]
    pub(super) fn of(file: &Table) -> Self {
        let mut keys = BTreeSet::new();
        if let Some(Value::Table(scenario)) = file.get("scenario") {
            collect("", scenario, &mut keys);
        }
        Self(keys)
    }

    /// Whether a key, one above it or one below it is stated.
    pub(super) fn states(&self, key: &str) -> bool {
        let above = |other: &str, key: &str| {
            key.strip_prefix(other)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        self.0
            .iter()
            .any(|stated| above(stated, key) || above(key, stated))
    }
}

fn collect(prefix: &str, table: &Table, keys: &mut BTreeSet<String>) {
    for (key, value) in table {
        let key = format!("{prefix}{key}");
        match value {
            Value::Table(below) => collect(&format!("{key}."), below, keys),
            _ => {
                keys.insert(key);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_key_is_stated_with_those_above_and_below_it() {
        let text = "[scenario]\ntimeout_s = 1.0\n[scenario.control.gains]\nk_p = 2.0\n";
        let stated = StatedKeys::of(&toml::from_str(text).unwrap());
        for (key, expected) in [
            ("timeout_s", true),
            ("control.gains.k_p", true),
            ("control.gains", true),
            ("control.gains.k_i", false),
            ("timeout_sx", false),
            ("control.gain", false),
        ] {
            assert_eq!(stated.states(key), expected, "{key}");
        }
    }
}
