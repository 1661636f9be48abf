//! Reading, checking and writing cards.

use std::fmt::Display;
use std::path::Path;

use sindy_expr::Expr;
use touchdown_files::TomlError;

use crate::card::{Card, SCHEMA, Term};
use crate::error::CardError;
use crate::unit;

impl Card {
    /// Reads a card.
    ///
    /// # Errors
    /// A file that cannot be read, is not TOML, has another schema, an unknown or missing key, or a
    /// value that makes no sense.
    pub fn read(path: &Path) -> Result<Self, CardError> {
        let text = touchdown_files::read_text(path).map_err(|source| CardError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Parses a card; `file` names it in errors.
    ///
    /// # Errors
    /// As [`Card::read`].
    pub fn parse(text: &str, file: &str) -> Result<Self, CardError> {
        let text_error = |e: toml::de::Error| CardError::Text {
            file: file.to_string(),
            message: TomlError::new(text, &e).to_string(),
        };
        let table: toml::Table = toml::from_str(text).map_err(text_error)?;
        match table.get("schema").and_then(toml::Value::as_integer) {
            Some(v) if v == i64::from(SCHEMA) => {}
            found => {
                let found = match (found, table.get("schema")) {
                    (Some(v), _) => v.to_string(),
                    (None, Some(v)) => format!("`{v}`"),
                    (None, None) => "no such key".to_string(),
                };
                return Err(CardError::Schema {
                    file: file.to_string(),
                    expected: SCHEMA,
                    found,
                });
            }
        }
        let card: Self = toml::from_str(text).map_err(text_error)?;
        card.check(file)?;
        Ok(card)
    }

    /// The card as TOML text; reading it back gives the same card to the bit.
    ///
    /// # Errors
    /// A card that breaks the rules of [`Card::check`].
    pub fn to_toml(&self) -> Result<String, CardError> {
        self.check(&self.name)?;
        toml::to_string_pretty(self).map_err(|e| CardError::Text {
            file: self.name.clone(),
            message: e.to_string(),
        })
    }

    /// Writes the card: to a temporary file beside, then renamed, so that no half-written card is left.
    ///
    /// # Errors
    /// A card that breaks the rules, or a file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), CardError> {
        let text = self.to_toml()?;
        touchdown_files::write(path, text.as_bytes()).map_err(|source| CardError::Write {
            path: path.to_owned(),
            source,
        })
    }

    /// Checks what the types cannot: finite numbers, ordered ranges, expressions that parse, units of the terms, positive
    /// mass.
    ///
    /// # Errors
    /// The first value that makes no sense, with its key.
    pub fn check(&self, file: &str) -> Result<(), CardError> {
        if self.name.is_empty() || self.name.contains(['/', '\\']) {
            let found = format!("`{}`", self.name);
            return bad(file, "name", "a name without slashes", &found);
        }
        if let Some((key, expected, found)) = self.vehicle.fault() {
            return bad(file, key, expected, &found);
        }
        if self.measured_rotors == Some(0) {
            return bad(file, "measured_rotors", "at least 1", &0);
        }
        for (name, range) in &self.validity.inputs {
            check_range(file, &format!("validity.inputs.{name}"), *range)?;
        }
        if let Some(range) = self.validity.output {
            check_range(file, "validity.output", range)?;
        }
        for (name, value) in &self.constants {
            if !value.is_finite() {
                return bad(file, format!("constants.{name}"), "a finite number", value);
            }
        }
        if self.terms.is_empty() {
            return bad(file, "terms", "at least one term", &"none");
        }
        for (i, term) in self.terms.iter().enumerate() {
            check_term(file, &format!("terms[{i}]"), term)?;
            if let Some(unit) = unit::fault(&term.of, &term.expression, &term.unit) {
                let found = format!("`{}`", term.unit);
                let expected = format!(
                    "`{unit}`, the unit of `{}` in `{}`",
                    term.expression, term.of
                );
                return bad(file, format!("terms[{i}].unit"), &expected, &found);
            }
        }
        for (i, term) in self.terms.iter().enumerate() {
            check_expression(file, format!("terms[{i}].expression"), &term.expression)?;
        }
        for (name, text) in &self.definitions {
            check_expression(file, format!("definitions.{name}"), text)?;
        }
        Ok(())
    }
}

fn bad(
    file: &str,
    key: impl Into<String>,
    expected: &str,
    found: &dyn Display,
) -> Result<(), CardError> {
    Err(CardError::Value {
        card: file.to_string(),
        key: key.into(),
        expected: expected.into(),
        found: found.to_string(),
    })
}

fn check_range(file: &str, key: &str, [lo, hi]: [f64; 2]) -> Result<(), CardError> {
    if lo.is_finite() && hi.is_finite() && lo <= hi {
        return Ok(());
    }
    let found = format!("[{lo}, {hi}]");
    bad(file, key, "[min, max] with min <= max, finite", &found)
}

fn check_term(file: &str, key: &str, term: &Term) -> Result<(), CardError> {
    if !term.value.is_finite() {
        return bad(file, format!("{key}.value"), "a finite number", &term.value);
    }
    if let Some(se) = term.std_error
        && !(se >= 0.0 && se.is_finite())
    {
        let key = format!("{key}.std_error");
        return bad(file, key, "a finite number, at least 0", &se);
    }
    if let Some(bound) = term.upper_bound
        && !(bound.is_finite() && bound >= term.value)
    {
        let key = format!("{key}.upper_bound");
        return bad(file, key, "a finite number, not below the value", &bound);
    }
    if let Some([low, high]) = term.ci95
        && !(low.is_finite() && high.is_finite() && (low..=high).contains(&term.value))
    {
        return bad(
            file,
            format!("{key}.ci95"),
            "[low, high], finite, with the value between them",
            &format!("[{low}, {high}]"),
        );
    }
    Ok(())
}

fn check_expression(file: &str, key: String, text: &str) -> Result<(), CardError> {
    match Expr::parse(text) {
        Ok(_) => Ok(()),
        Err(e) => bad(file, key, "an expression", &format!("`{text}`: {e}")),
    }
}
