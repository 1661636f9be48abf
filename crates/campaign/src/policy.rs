//! A learned policy, from its file.

use std::path::Path;

use touchdown_sim::landing::space::{Policy, PolicySettings};

use crate::error::{Error, Result};

/// Name of a policy among controllers.
pub const POLICY: &str = "policy";
/// Name of its file in the folder of a campaign or run, beside `sweep.toml`: not one that people give their own.
pub const POLICY_FILE: &str = "sweep-policy.json";

/// A policy with its file.
#[derive(Clone, Debug)]
pub struct PolicyFile {
    /// The policy.
    pub policy: Policy,
    /// The file.
    pub bytes: Vec<u8>,
}

impl PolicyFile {
    /// Reads a policy.
    ///
    /// # Errors
    /// A file that cannot be read, that is not JSON, or whose numbers make no policy.
    pub fn read(path: &Path) -> Result<Self> {
        let text = touchdown_files::read_text(path).map_err(|e| Error::file(path, e))?;
        let bad = |message: String| Error::Settings {
            file: path.display().to_string(),
            message,
        };
        let mut json = serde_json::Deserializer::from_str(&text);
        let settings: PolicySettings = serde_path_to_error::deserialize(&mut json)
            .map_err(|e| bad(sentence(&e.path().to_string(), e.inner())))?;
        json.end()
            .map_err(|e| bad(format!("expected the end of the file, found {e}")))?;
        let policy = Policy::new(settings).map_err(|e| bad(e.to_string()))?;
        let bytes = text.into_bytes();
        Ok(Self { policy, bytes })
    }
}

/// What is wrong at a path in JSON, with key, expected, found and place.
fn sentence(path: &str, error: &serde_json::Error) -> String {
    let said = error.to_string();
    let (said, place) = said.split_once(" at line ").unwrap_or((&said, "?"));
    let (found, expected) = said
        .split_once(", expected ")
        .unwrap_or((said, "a policy in JSON"));
    let key = match path {
        "." => "policy",
        path => path,
    };
    format!("setting `{key}`: expected {expected}, found {found} (line {place})")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use touchdown_sim::landing::space::Observation;

    use super::*;

    /// Thrust alone, against the vertical velocity relative to the deck.
    fn text() -> String {
        let mut row = [0.0; Observation::NUMBERS];
        row[5] = -2.0;
        let [offset, scale] = [[0.0; 19], [1.0; 19]];
        format!(
            "{{\"schema\": 1, \"decision_s\": 0.02, \"action\": {{\"kind\": \"thrust\"}}, \
             \"input\": {{\"offset\": {offset:?}, \"scale\": {scale:?}, \"limit\": 5.0}}, \
             \"layers\": [{{\"weights\": [{row:?}], \"bias\": [-0.5], \"activation\": \"linear\"}}]}}"
        )
    }

    fn read(bytes: &[u8]) -> Result<PolicyFile> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.json");
        std::fs::write(&path, bytes).unwrap();
        PolicyFile::read(&path)
    }

    #[test]
    fn prop_errors_name_file_key_expected_and_found() {
        assert!(read(text().as_bytes()).is_ok());
        for (from, to, said) in [
            (
                "\"schema\": 1",
                "\"schema\": 7",
                vec!["`schema`", "expected 1", "found 7"],
            ),
            (
                "0.02",
                "\"often\"",
                vec![
                    "setting `decision_s`",
                    "expected f64",
                    "\"often\"",
                    "(line 1",
                ],
            ),
            (
                "{\"schema\"",
                "learned",
                vec!["setting `policy`: expected a policy in JSON"],
            ),
            (
                "\"layers\"",
                "\"lairs\"",
                vec!["unknown field `lairs`", "layers"],
            ),
            (
                "\"linear\"",
                "\"cubic\"",
                vec![
                    "setting `layers[0].activation`",
                    "`cubic`",
                    "expected one of `linear`, `tanh`",
                ],
            ),
            (
                "[-0.5]",
                "[]",
                vec!["`layers.0.bias`", "1 numbers", "found 0"],
            ),
            ("5.0", "-5.0", vec!["`input.limit`", "above 0", "-5"]),
        ] {
            let spoiled = text().replace(from, to);
            assert_ne!(spoiled, text());
            let error = read(spoiled.as_bytes()).unwrap_err().to_string();
            for word in said.iter().chain(&["policy.json"]) {
                assert!(error.contains(word), "{word}: {error}");
            }
        }
    }

    proptest! {
        #[test]
        fn prop_a_spoiled_file_is_an_error_or_a_policy(
            at in 0_usize..600, bytes in prop::collection::vec(any::<u8>(), 1..6)
        ) {
            let mut spoiled = text().into_bytes();
            let at = at.min(spoiled.len());
            let until = (at + bytes.len()).min(spoiled.len());
            spoiled.splice(at..until, bytes);
            if let Ok(file) = read(&spoiled) {
                let action = file.policy.action(&[0.5; Observation::NUMBERS]);
                prop_assert_eq!(action.len(), file.policy.settings().action.kind.numbers());
            }
        }
    }
}
