//! The equations of a card: the expressions of its form, filled with its terms.

use touchdown_flight::ground_effect::Empirical;

use crate::card::Card;
use crate::catalogue::{Part, Start};
use crate::error::CardError;

/// The equations of a card as expressions in its parameters `p0`, `p1`, … and its definitions.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    /// The state's name; none for maps without memory.
    pub state: Option<&'static str>,
    /// Its rate.
    pub rate: Option<String>,
    /// Thrust or force, N.
    pub output: String,
    /// The state at the start.
    pub start: Start,
    /// The values of `p0`, `p1`, ….
    pub parameters: Vec<f64>,
}

impl Card {
    /// The form's expressions with this card's terms as parameters.
    ///
    /// # Errors
    /// A form that needs more than one throttle, or a part that the card lacks.
    pub fn equations(&self) -> Result<Equations, CardError> {
        let entry = self.form.entry().ok_or_else(|| {
            self.lacks(
                "a form that predicts from one throttle",
                format!("{:?}", self.form),
            )
        })?;
        let mut parameters = Vec::new();
        let mut by: Vec<(&str, String)> = Vec::new();
        let mut at_rest = None;
        for part in entry.parts {
            if part.optional && self.terms_of(part.name).next().is_none() {
                at_rest = entry.at_rest;
            } else {
                by.push((part.name, self.part(part, &mut parameters)?));
            }
        }
        let constant = |name: &str| self.constants.get(name).copied().unwrap_or(0.0);
        by.extend([
            ("r", constant("r").to_string()),
            ("h_r", constant("h_r").to_string()),
            ("q_max", Empirical::<f64>::Q_MAX.to_string()),
        ]);
        let fill = |text: &str| {
            by.iter().fold(text.to_string(), |text, (name, by)| {
                text.replace(&format!("{{{name}}}"), by)
            })
        };
        Ok(match at_rest {
            Some(output) => Equations {
                state: None,
                rate: None,
                output: fill(output),
                start: Start::None,
                parameters,
            },
            None => Equations {
                state: entry.state,
                rate: entry.rate.map(fill),
                output: fill(entry.output),
                start: entry.start,
                parameters,
            },
        })
    }

    /// A part as an expression in new parameters.
    fn part(&self, part: &Part, parameters: &mut Vec<f64>) -> Result<String, CardError> {
        let mut parameter = |value: f64| {
            parameters.push(value);
            format!("p{}", parameters.len() - 1)
        };
        let values: Vec<f64> = self.terms_of(part.name).map(|t| t.value).collect();
        if part.terms == ["1"] {
            return match values[..] {
                [value] => Ok(parameter(value)),
                _ => Err(self.lacks(
                    &format!("one term of `{}`", part.name),
                    values.len().to_string(),
                )),
            };
        }
        let terms: Vec<String> = self
            .terms_of(part.name)
            .map(|t| format!("{}*({})", parameter(t.value), t.expression))
            .collect();
        if terms.is_empty() {
            return Err(self.lacks(&format!("terms of `{}`", part.name), "none".into()));
        }
        Ok(format!("({})", terms.join(" + ")))
    }

    fn lacks(&self, expected: &str, found: String) -> CardError {
        CardError::Value {
            card: self.name.clone(),
            key: "terms".into(),
            expected: expected.into(),
            found,
        }
    }
}
