//! Models as JSON that reads back bit for bit; the format is described at [`Model::to_json`].

use std::fmt;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::ser::{Error as _, SerializeMap};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Model, Past, Term, Time, written};
use crate::error::SindyError;
use crate::library::parse;

/// The version of the format that is written, and the only one that is read.
const SCHEMA: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: u32,
    time: FileTime,
    states: Vec<String>,
    inputs: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    past: Vec<Past>,
    equations: Equations,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum FileTime {
    Continuous,
    Discrete { period: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTerm {
    term: String,
    coefficient: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    std_error: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    inclusion: Option<f64>,
}

/// Equations by the names of their states, in order, none twice.
struct Equations(Vec<(String, Vec<FileTerm>)>);

impl Serialize for Equations {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (state, terms) in &self.0 {
            map.serialize_entry(state, terms)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Equations {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Map;
        impl<'de> Visitor<'de> for Map {
            type Value = Equations;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with one list of terms for each state")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Equations, A::Error> {
                let mut entries: Vec<(String, Vec<FileTerm>)> = Vec::new();
                let mut seen = std::collections::HashSet::new();
                while let Some(state) = map.next_key::<String>()? {
                    if !seen.insert(state.clone()) {
                        return Err(A::Error::custom(format!(
                            "two equations for the state `{state}`"
                        )));
                    }
                    entries.push((state, map.next_value()?));
                }
                Ok(Equations(entries))
            }
        }
        deserializer.deserialize_map(Map)
    }
}

impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let file_term = |term: &Term| {
            Ok(FileTerm {
                term: written(&term.expression)?,
                coefficient: term.coefficient,
                std_error: term.std_error,
                inclusion: term.inclusion,
            })
        };
        let equations = self
            .states
            .iter()
            .zip(&self.equations)
            .map(|(state, terms)| {
                let terms = terms
                    .iter()
                    .map(file_term)
                    .collect::<Result<_, SindyError>>()?;
                Ok((state.clone(), terms))
            })
            .collect::<Result<_, SindyError>>()
            .map_err(S::Error::custom)?;
        let file = File {
            schema: SCHEMA,
            time: match self.time {
                Time::Continuous => FileTime::Continuous,
                Time::Discrete { period } => FileTime::Discrete { period },
            },
            states: self.states.clone(),
            inputs: self.inputs.clone(),
            past: self.past.clone(),
            equations: Equations(equations),
        };
        file.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Model {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let file = File::deserialize(deserializer)?;
        model(file).map_err(D::Error::custom)
    }
}

fn model(file: File) -> Result<Model, SindyError> {
    check_schema(file.schema)?;
    let time = match file.time {
        FileTime::Continuous => Time::Continuous,
        FileTime::Discrete { period } => Time::Discrete { period },
    };
    let mut given: std::collections::HashMap<String, Vec<FileTerm>> =
        file.equations.0.into_iter().collect();
    let mut equations = Vec::with_capacity(file.states.len());
    for state in &file.states {
        let terms = given.remove(state).ok_or_else(|| {
            SindyError::setting("equations", format!("one for the state `{state}`"), "none")
        })?;
        let terms = terms.into_iter().map(|t| {
            Ok(Term {
                expression: parse(&t.term)?,
                coefficient: t.coefficient,
                std_error: t.std_error,
                inclusion: t.inclusion,
            })
        });
        equations.push(terms.collect::<Result<_, SindyError>>()?);
    }
    if let Some(name) = given.keys().min() {
        let expected = format!("equations for the states {} only", file.states.join(", "));
        return Err(SindyError::setting(
            "equations",
            expected,
            format!("one for `{name}`"),
        ));
    }
    Model::build(time, file.states, file.inputs, equations)?.with_past(file.past)
}

fn check_schema(schema: u32) -> Result<(), SindyError> {
    if schema == SCHEMA {
        return Ok(());
    }
    Err(SindyError::setting("schema", SCHEMA.to_string(), schema))
}

impl Model {
    /// The model as JSON with all digits.
    ///
    /// ```json
    /// { "schema": 1,
    ///   "time": "continuous",
    ///   "states": ["x"],
    ///   "inputs": ["u"],
    ///   "equations": { "x": [ { "term": "x*u", "coefficient": -1.0, "std_error": 0.001, "inclusion": 1.0 } ] } }
    /// ```
    ///
    /// A discrete-time model has `"time": { "discrete": { "period": 0.01 } }`; `std_error` and `inclusion`
    /// stand where they are known, and `"past": [{ "input": "x_ago3", "state": "x", "delay": 0.3 }]` where inputs are what
    /// states were. The same format is behind `serde`'s `Serialize` and `Deserialize`, for
    /// models inside other documents.
    ///
    /// # Errors
    /// None that a model which was built can cause; the serialiser's are passed on.
    pub fn to_json(&self) -> Result<String, SindyError> {
        serde_json::to_string_pretty(self).map_err(|e| json_error(&e))
    }

    /// Reads a model from JSON. What [`Model::to_json`] wrote reads back bit for bit.
    ///
    /// # Errors
    /// [`SindyError::Json`] with line and column for text that is not such a model: unknown, repeated or
    /// missing keys and values of another type; the errors of [`Model::new`] and of the expression parser
    /// for the model; [`SindyError::Setting`] for another schema version.
    pub fn from_json(text: &str) -> Result<Self, SindyError> {
        /// The version alone, so that a later version is not reported as an unknown key.
        #[derive(Deserialize)]
        struct Version {
            schema: u32,
        }
        let version: Version = serde_json::from_str(text).map_err(|e| json_error(&e))?;
        check_schema(version.schema)?;
        model(serde_json::from_str(text).map_err(|e| json_error(&e))?)
    }
}

fn json_error(error: &serde_json::Error) -> SindyError {
    SindyError::Json {
        reason: error.to_string(),
    }
}
