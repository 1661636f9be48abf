//! One library for all equations, or one for each.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Library;
use crate::error::SindyError;

/// The libraries of a whole system as texts: one for all equations, or a different one for each.
///
/// In a settings file it is a text as for [`Library::specification`], a list of them (their sum), or a table
/// with one of these for each state:
///
/// ```
/// # #[derive(serde::Deserialize)]
/// # struct Settings { library: sindy::Libraries }
/// let same: Settings = serde_json::from_str(r#"{ "library": ["poly(2)", "sin(x)"] }"#)?;
/// let each: Settings = serde_json::from_str(r#"{ "library": { "x": "y", "y": ["poly(2)", "sin(x)"] } }"#)?;
///
/// let states = ["x", "y"];
/// assert_eq!(same.library.build(&states, &[])?[0].len(), 7);
/// assert_eq!(each.library.build(&states, &[])?[0].names(), ["y"]);
/// assert!(same.library.is_shared() && !each.library.is_shared());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Libraries(Written);

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a library such as \"poly(3)\", a list of them, or a table with one for each state"
)]
enum Written {
    Shared(Texts),
    Each(BTreeMap<String, Texts>),
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a library such as \"poly(3)\", or a list of them"
)]
enum Texts {
    One(String),
    Sum(Vec<String>),
}

impl Texts {
    fn new<T: Into<String>>(texts: impl IntoIterator<Item = T>) -> Self {
        let mut texts: Vec<String> = texts.into_iter().map(Into::into).collect();
        match texts.len() {
            1 => Self::One(texts.remove(0)),
            _ => Self::Sum(texts),
        }
    }

    fn build(&self, variables: &[&str]) -> Result<Library, SindyError> {
        match self {
            Self::One(text) => Library::specification(text, variables),
            Self::Sum(texts) => Library::specifications(texts, variables),
        }
    }
}

impl Libraries {
    /// One library for all equations: the sum of the texts.
    #[must_use]
    pub fn shared<T: Into<String>>(texts: impl IntoIterator<Item = T>) -> Self {
        Self(Written::Shared(Texts::new(texts)))
    }

    /// A library for the equation of each state: the sum of its texts.
    #[must_use]
    pub fn each<S, T, L>(equations: impl IntoIterator<Item = (S, L)>) -> Self
    where
        S: Into<String>,
        T: Into<String>,
        L: IntoIterator<Item = T>,
    {
        let equations = equations.into_iter();
        let written = equations.map(|(state, texts)| (state.into(), Texts::new(texts)));
        Self(Written::Each(written.collect()))
    }

    /// The terms of `library` for all equations.
    ///
    /// # Errors
    /// A term that has no text which reads back as that term alone (a constant `exp(1)`, which is written as a
    /// library).
    pub fn of_terms(library: &Library) -> Result<Self, SindyError> {
        let variables = match library.variables() {
            none if none.is_empty() => vec!["x".into()],
            some => some,
        };
        let texts = library.terms().iter().map(|term| {
            let reads = |text: &String| {
                let back = Library::specification(text, &variables).ok();
                let both =
                    back.and_then(|b| Library::sum(&[b, Library::of(vec![term.clone()])]).ok());
                both.is_some_and(|both| both.len() == 1)
            };
            let written = [
                term.to_string(),
                format!("({term})"),
                format!("({})", term.simplify()),
            ];
            written
                .into_iter()
                .find(reads)
                .ok_or_else(|| SindyError::Expression {
                    text: term.to_string(),
                    reason: "is also the name of a library; its text would be ambiguous".into(),
                })
        });
        Ok(Self::shared(texts.collect::<Result<Vec<String>, _>>()?))
    }

    /// Whether all equations have one library.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        matches!(self.0, Written::Shared(_))
    }

    /// The library of each state's equation, over states and inputs, in the order of `states`.
    ///
    /// # Errors
    /// As [`Library::specification`]; a table without one of the states, or with a name that is not a state.
    pub fn build<S: AsRef<str>>(
        &self,
        states: &[S],
        inputs: &[S],
    ) -> Result<Vec<Library>, SindyError> {
        let variables: Vec<&str> = states.iter().chain(inputs).map(AsRef::as_ref).collect();
        match &self.0 {
            Written::Shared(texts) => Ok(vec![texts.build(&variables)?; states.len()]),
            Written::Each(equations) => {
                let states = &variables[..states.len()];
                if let Some(name) = equations.keys().find(|n| !states.contains(&n.as_str())) {
                    return Err(SindyError::setting(
                        "library",
                        format!("one for each state: {}", states.join(", ")),
                        format!("one for `{name}`"),
                    ));
                }
                let library = |state: &&str| match equations.get(*state) {
                    Some(texts) => texts.build(&variables),
                    None => Err(SindyError::setting(
                        "library",
                        format!("one for each state: {}", states.join(", ")),
                        format!("none for `{state}`"),
                    )),
                };
                states.iter().map(library).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_settings_go_in_and_come_out_alike() {
        for text in [
            r#""poly(2)""#,
            r#"["1","x*y"]"#,
            r#"{"x":"poly(1)","y":["x","sin(y)"]}"#,
        ] {
            let read: Libraries = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&read).unwrap(), text);
            assert_eq!(read.build(&["x", "y"], &[]).unwrap().len(), 2);
        }
        let refused = serde_json::from_str::<Libraries>("3").unwrap_err();
        assert!(refused.to_string().contains("poly(3)"), "{refused}");
    }

    #[test]
    fn analytic_each_equation_has_its_library_over_states_and_inputs() {
        let each = Libraries::each([("y", vec!["poly(1)"]), ("x", vec!["u", "x*u"])]);
        let built = each.build(&["x", "y"], &["u"]).unwrap();
        assert_eq!(built[0].names(), ["u", "x*u"]);
        assert_eq!(built[1].names(), ["1", "x", "y", "u"]);
        let missing = each.build(&["x", "y", "z"], &["u"]).unwrap_err();
        assert!(missing.to_string().contains("none for `z`"), "{missing}");
        let foreign = each.build(&["x"], &["u"]).unwrap_err();
        assert!(foreign.to_string().contains("one for `y`"), "{foreign}");
        assert!(Libraries::shared([""; 0]).build(&["x"], &[]).is_err());
    }

    #[test]
    fn prop_terms_become_texts_that_read_back() {
        let terms = [
            "1",
            "x - y",
            "x > 0",
            "y*x",
            "exp(1)*x",
            "(x - y)*sin(x)",
            "1/(1 + x^2)",
        ];
        let library = Library::parse(&terms).unwrap();
        let back = Libraries::of_terms(&library)
            .unwrap()
            .build(&["x", "y"], &[])
            .unwrap();
        let names = [
            "1",
            "x - y",
            "x > 0",
            "x*y",
            "2.718281828459045*x",
            "(x - y)*sin(x)",
            "1/(1 + x^2)",
        ];
        assert_eq!(back[0].names(), names);
        // e^1000 overflows: there is no number to write.
        let never = Library::parse(&["exp(1000)*x"]).unwrap();
        assert!(Libraries::of_terms(&never).is_err());
    }
}
