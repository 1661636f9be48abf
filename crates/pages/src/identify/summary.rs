//! Fits as tables and JSON have them.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use serde::Serialize;
use touchdown_identify::FittedCard;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::forms::FormScore;
use touchdown_identify::front::Front;
use touchdown_model::{Card, Mark};

/// One fit, as it is printed and written.
#[derive(Debug, Serialize)]
pub struct Fitted {
    /// The log, or how many.
    pub log: String,
    /// The card's file; null where none was written.
    pub card: Option<String>,
    /// The model's form.
    pub form: String,
    /// Coefficients by name.
    pub coefficients: BTreeMap<String, Coefficient>,
    /// The lag (s); null where the form has none.
    pub lag_s: Option<f64>,
    /// Root mean square residual.
    pub rmse: Quantity,
    /// Rows or plateaus that the fit used.
    pub rows_used: usize,
    /// Rows that were dropped because something is wrong with them.
    pub rows_dropped: usize,
    /// The forms that were tried, with their errors on held-out parts; absent where the form was given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forms: Vec<FormScore>,
    /// The best subset of every size beside the fit's own terms; null for forms that choose none.
    pub front: Option<Box<Front>>,
    /// Results of flights in addition to the card; absent if thrust was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flight: Option<Box<FlightResult>>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Names of the coefficients in the card's order.
    #[serde(skip)]
    order: Vec<String>,
}

/// A log, or a form of model, that could not be fitted.
#[derive(Debug, Serialize)]
pub struct Failed {
    /// The log.
    pub log: String,
    /// The form that was asked for, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<String>,
    /// Why.
    pub error: String,
}

/// A log's fit, or why there is none.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Outcome {
    /// The fit.
    Fitted(Fitted),
    /// Why there is none.
    Failed(Failed),
}

/// A coefficient.
#[derive(Clone, Debug, Serialize)]
pub struct Coefficient {
    value: f64,
    std_error: Option<f64>,
    /// 95 % confidence interval.
    ci95: Option<[f64; 2]>,
    unit: String,
    /// Why there is no interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    mark: Option<Mark>,
    /// 95 % upper bound, where the data show no more.
    #[serde(skip_serializing_if = "Option::is_none")]
    upper_bound: Option<f64>,
}

impl Coefficient {
    /// The value with its mark: a bound as a bound, a value without interval with the reason.
    fn text(&self) -> String {
        match (self.mark, self.upper_bound) {
            (None, _) => digits(self.value),
            (Some(Mark::UpperBound), Some(bound)) => format!("≤{}", digits(bound)),
            (Some(mark), _) => format!("{} ({})", digits(self.value), mark.words()),
        }
    }
}

/// A number with its unit.
#[derive(Debug, Serialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

impl Fitted {
    /// A fit of `log`; `card` is the file of its card, `dropped` the rows that something is wrong with.
    #[must_use]
    pub fn of(log: String, made: &FittedCard, card: Option<&Path>, dropped: usize) -> Self {
        let named = coefficients(&made.card);
        Self {
            log,
            card: card.map(|p| p.display().to_string()),
            form: form(&made.card),
            order: named.iter().map(|(name, _)| name.clone()).collect(),
            coefficients: named.into_iter().collect(),
            lag_s: made.lag_s,
            rmse: Quantity {
                value: made.rmse,
                unit: made.rmse_unit.to_string(),
            },
            rows_used: made.rows_used,
            rows_dropped: dropped,
            forms: made.forms.clone(),
            front: made.front.clone().map(Box::new),
            flight: None,
            warnings: touchdown_identify::warning::sentences(&made.warnings),
        }
    }
}

impl Failed {
    /// Why there is no fit of `log`.
    #[must_use]
    pub fn of(log: String, form: Option<&str>, error: &dyn Display) -> Self {
        Self {
            log,
            form: form.map(String::from),
            error: error.to_string(),
        }
    }
}

/// A form by its name in cards.
#[must_use]
pub fn form(card: &Card) -> String {
    serde_json::to_value(card.form)
        .ok()
        .and_then(|v| v.as_str().map(String::from))
        .unwrap_or_default()
}

/// The coefficients by unique names, in the card's order: a part with one constant term is called by the part
/// (`T_m`), all others by part and term (`x:s^2`).
#[must_use]
pub fn coefficients(card: &Card) -> Vec<(String, Coefficient)> {
    card.terms
        .iter()
        .map(|term| {
            let alone = term.expression == "1" && card.terms_of(&term.of).count() == 1;
            let name = if alone {
                term.of.clone()
            } else {
                format!("{}:{}", term.of, term.expression)
            };
            let coefficient = Coefficient {
                value: term.value,
                std_error: term.std_error,
                ci95: term.ci95,
                unit: term.unit.clone(),
                mark: term.mark,
                upper_bound: term.upper_bound,
            };
            (name, coefficient)
        })
        .collect()
}

/// A table of fits: a row a log (or form).
#[derive(Clone, Debug)]
pub struct Summary {
    /// Names of the columns; the last is that of the warnings.
    pub header: Vec<String>,
    /// A row a fit.
    pub rows: Vec<Vec<String>>,
}

impl Summary {
    /// The table of these fits.
    #[must_use]
    pub fn of(outcomes: &[Outcome]) -> Self {
        let mut names: Vec<String> = Vec::new();
        for outcome in outcomes {
            if let Outcome::Fitted(f) = outcome {
                names.extend(
                    f.order
                        .iter()
                        .filter(|n| !names.contains(n))
                        .cloned()
                        .collect::<Vec<_>>(),
                );
            }
        }
        let mut header = vec!["log".to_string(), "form".to_string()];
        header.extend(names.iter().cloned());
        header.extend(["rmse", "unit", "rows", "dropped", "warnings"].map(String::from));
        let label = labels(outcomes);
        let rows = outcomes.iter().map(|outcome| match outcome {
            Outcome::Fitted(f) => {
                let mut row = vec![label(&f.log), f.form.clone()];
                row.extend(names.iter().map(|n| {
                    f.coefficients
                        .get(n)
                        .map_or_else(String::new, Coefficient::text)
                }));
                row.extend([
                    digits(f.rmse.value),
                    f.rmse.unit.clone(),
                    f.rows_used.to_string(),
                    f.rows_dropped.to_string(),
                    f.warnings.join("; "),
                ]);
                row
            }
            Outcome::Failed(f) => {
                let mut row = vec![
                    label(&f.log),
                    format!("{} failed", f.form.as_deref().unwrap_or(""))
                        .trim()
                        .to_string(),
                ];
                row.resize(header.len() - 1, String::new());
                row.push(f.error.clone());
                row
            }
        });
        Self {
            rows: rows.collect(),
            header: header.clone(),
        }
    }

    /// As CSV.
    #[must_use]
    pub fn csv(&self) -> String {
        csv(&self.header, &self.rows)
    }
}

/// How logs are called in tables: by file, where all lie in one folder.
fn labels(outcomes: &[Outcome]) -> impl Fn(&str) -> String {
    let folder = |o: &Outcome| {
        let (Outcome::Fitted(Fitted { log, .. }) | Outcome::Failed(Failed { log, .. })) = o;
        Path::new(log).parent().map(Path::to_owned)
    };
    let first = outcomes.first().and_then(folder);
    let one = outcomes.iter().all(|o| folder(o) == first);
    move |log| match Path::new(log).file_name() {
        Some(name) if one => name.to_string_lossy().into_owned(),
        _ => log.to_string(),
    }
}

/// Five significant digits.
#[must_use]
pub fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_string();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{value:.4e}");
    }
    let before = if size < 1.0 { 0 } else { size.log10() as usize };
    format!("{value:.*}", 4_usize.saturating_sub(before).max(1))
}

/// Rows as CSV.
#[must_use]
pub fn csv(header: &[String], rows: &[Vec<String>]) -> String {
    let mut out = String::new();
    for row in std::iter::once(header).chain(rows.iter().map(Vec::as_slice)) {
        touchdown_campaign::csv::line(&mut out, row);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_five_digits() {
        let cases = [
            (0.073_512_3, "0.0735"),
            (12.345_678, "12.346"),
            (-3.0, "-3.0000"),
            (1.234_567e-7, "1.2346e-7"),
            (0.0, "0.0000"),
        ];
        for (value, text) in cases {
            assert_eq!(digits(value), text);
        }
        assert_eq!(digits(f64::NAN), "–");
    }
}
