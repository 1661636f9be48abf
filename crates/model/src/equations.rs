//! The equations of a card: the expressions of its form, filled with its terms.

use sindy_expr::Expr;
use touchdown_flight::ground_effect::Empirical;

use crate::card::{Card, Kind};
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

    /// The form's equations with this card's coefficients in LaTeX (an `aligned` environment of `amsmath`), each
    /// coefficient with so many significant digits (1 to 17).
    ///
    /// # Errors
    /// Those of [`Self::equations`].
    pub fn to_latex(&self, digits: usize) -> Result<String, CardError> {
        let equations = self.equations()?;
        let latex = |text: &str| {
            // The term of a constant reads as its coefficient.
            let text = &text.replace("*(1)", "");
            let filled = with_numbers(text, &equations.parameters, digits.clamp(1, 17));
            let parsed = Expr::parse(&filled);
            let parsed = parsed.map_err(|e| self.lacks("expressions", format!("`{text}`: {e}")))?;
            Ok::<_, CardError>(parsed.to_latex())
        };
        let mut lines = Vec::new();
        if let (Some(state), Some(rate)) = (equations.state, &equations.rate) {
            let state = Expr::variable(state).to_latex();
            lines.push(format!(r"\dot{{{state}}} &= {}", latex(rate)?));
        }
        let output = match self.kind {
            Kind::Thrust => "T",
            Kind::GroundEffect => "f",
        };
        lines.push(format!("{output} &= {}", latex(&equations.output)?));
        Ok(format!(
            "\\begin{{aligned}}\n{}\n\\end{{aligned}}\n",
            lines.join(" \\\\\n")
        ))
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

/// An expression of [`Equations`] with numbers in place of its parameters.
fn with_numbers(text: &str, parameters: &[f64], digits: usize) -> String {
    // From the last on, because `p1` begins `p10`.
    let numbered = parameters.iter().enumerate().rev();
    numbered.fold(text.to_string(), |text, (i, value)| {
        let rounded = |value: f64| format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
        let size = rounded(value.abs());
        let text = match value.is_sign_negative() {
            true => text.replace(&format!(" + p{i}*"), &format!(" - {size}*")),
            false => text,
        };
        text.replace(&format!("p{i}"), &format!("({})", rounded(*value)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_coefficients_stand_in_the_equations_with_their_signs() {
        let text = "(p0*(s) + p1*(x) + p10*(psi1))";
        let mut parameters = vec![0.0; 11];
        (parameters[0], parameters[1], parameters[10]) = (-1.0, -2.345_67, 12_345.0);
        assert_eq!(
            with_numbers(text, &parameters, 3),
            "((-1)*(s) - 2.35*(x) + (12300)*(psi1))"
        );
        let card = Card::parse(crate::published::EQ_11, "eq11").unwrap();
        let latex = card.to_latex(3).unwrap();
        assert!(
            latex.contains(r"\dot{x} &=") && latex.contains("T &="),
            "{latex}"
        );
        assert!(
            !latex.contains("p_") && !latex.contains(r"\cdot 1"),
            "{latex}"
        );
    }
}
