//! How a fit is printed: the JSON object, and the summary table.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use touchdown::Error;
use touchdown::pages::identify::Overview;
use touchdown_identify::FittedCard;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::forms::FormScore;
use touchdown_identify::front::Front;
use touchdown_model::{Card, Mark};
use touchdown_terminal::escape;

/// One fit, as it is printed and written.
#[derive(Serialize)]
pub(crate) struct Fitted {
    /// The log, or how many.
    pub(crate) log: String,
    /// The card's file; null where none was written.
    pub(crate) card: Option<String>,
    /// The model's form.
    pub(crate) form: String,
    /// Coefficients by name.
    pub(crate) coefficients: BTreeMap<String, Coefficient>,
    /// The lag (s); null where the form has none.
    pub(crate) lag_s: Option<f64>,
    /// Root mean square residual.
    pub(crate) rmse: Quantity,
    /// Rows or plateaus that the fit used.
    pub(crate) rows_used: usize,
    /// Rows that were dropped because something is wrong with them.
    pub(crate) rows_dropped: usize,
    /// The forms that were tried, with their errors on held-out parts; absent where the form was given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) forms: Vec<FormScore>,
    /// The best subset of every size beside the fit's own terms; null for forms that choose none.
    pub(crate) front: Option<Box<Front>>,
    /// Results of flights in addition to the card; absent if thrust was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) flight: Option<Box<FlightResult>>,
    /// What a user should know.
    pub(crate) warnings: Vec<String>,
    /// Names of the coefficients in the card's order.
    #[serde(skip)]
    order: Vec<String>,
}

/// A log, or a form of model, that could not be fitted.
#[derive(Serialize)]
pub(crate) struct Failed {
    /// The log.
    pub(crate) log: String,
    /// The form that was asked for, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) form: Option<String>,
    /// Why.
    pub(crate) error: String,
}

/// A log's fit, or why there is none.
#[derive(Serialize)]
#[serde(untagged)]
pub(crate) enum Outcome {
    Fitted(Fitted),
    Failed(Failed),
}

/// A coefficient.
#[derive(Clone, Serialize)]
pub(crate) struct Coefficient {
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
#[derive(Serialize)]
pub(crate) struct Quantity {
    pub(crate) value: f64,
    pub(crate) unit: String,
}

impl Fitted {
    pub(crate) fn of(log: String, made: &FittedCard, card: Option<&Path>, dropped: usize) -> Self {
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
    pub(crate) fn of(log: String, form: Option<&str>, error: &Error) -> Self {
        Self {
            log,
            form: form.map(String::from),
            error: error.to_string(),
        }
    }
}

/// A form by its name in cards.
pub(crate) fn form(card: &Card) -> String {
    serde_json::to_value(card.form)
        .ok()
        .and_then(|v| v.as_str().map(String::from))
        .unwrap_or_default()
}

/// The coefficients by unique names, in the card's order: a part with one constant term is called by the part
/// (`T_m`), all others by part and term (`x:s^2`).
pub(crate) fn coefficients(card: &Card) -> Vec<(String, Coefficient)> {
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
pub(crate) struct Summary {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Summary {
    pub(crate) fn of(outcomes: &[Outcome]) -> Self {
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

    /// What a report of these fits begins with.
    pub(crate) fn overview<'a>(&'a self, title: &'a str, command: &'a str) -> Overview<'a> {
        Overview {
            title,
            command,
            header: &self.header,
            rows: &self.rows,
        }
    }

    /// As CSV.
    pub(crate) fn csv(&self) -> String {
        csv(&self.header, &self.rows)
    }

    /// As text for a terminal. Coefficients are left out where there are too many of them for a line; of the
    /// remarks the first words stand there, the rest went to standard error.
    pub(crate) fn text(&self) -> String {
        const MOST_COLUMNS: usize = 13;
        let last = self.header.len() - 1;
        let wide = self.header.len() > MOST_COLUMNS;
        let keep = |i: usize| !wide || i < 2 || i + 5 >= self.header.len();
        let pick = |row: &[String]| -> Vec<String> {
            row.iter()
                .enumerate()
                .filter(|(i, _)| keep(*i))
                .map(|(i, cell)| {
                    if i == last {
                        shortened(cell)
                    } else {
                        cell.clone()
                    }
                })
                .collect()
        };
        let rows: Vec<Vec<String>> = self.rows.iter().map(|r| pick(r)).collect();
        text_table(&pick(&self.header), &rows)
    }
}

/// The forms that were tried, as text for a terminal.
pub(crate) fn forms(scores: &[FormScore]) -> String {
    let header = FORMS_HEADER.map(String::from);
    let rows: Vec<Vec<String>> = scores.iter().map(form_row).collect();
    text_table(&header, &rows)
}

/// Columns of the table of forms.
const FORMS_HEADER: [&str; 6] = [
    "form",
    "parameters",
    "held-out RMSE (N)",
    "standard error (N)",
    "chosen",
    "why not",
];

fn form_row(score: &FormScore) -> Vec<String> {
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_string(), digits);
    vec![
        score.name(),
        score.parameters.to_string(),
        number(score.held_out_rmse_n),
        number(score.std_error_n),
        if score.chosen { "yes" } else { "" }.to_string(),
        score
            .error
            .clone()
            .map_or_else(String::new, |e| shortened(&e)),
    ]
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

/// The first line of a remark, at most 60 letters.
fn shortened(text: &str) -> String {
    const MOST: usize = 60;
    let line = text.lines().next().unwrap_or_default();
    if line.chars().count() <= MOST && !text.contains('\n') {
        return line.to_string();
    }
    let cut: String = line.chars().take(MOST).collect();
    format!("{}…", cut.trim_end())
}

/// Five significant digits.
pub(crate) fn digits(value: f64) -> String {
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

/// Columns side by side: numbers at the right, words at the left.
pub(crate) fn text_table(header: &[String], rows: &[Vec<String>]) -> String {
    // A cell may be a name from a file, and stays in its row.
    let shown = |cells: &[String]| -> Vec<String> {
        let cells = cells.iter().map(|cell| escape::line(cell).into_owned());
        cells.collect()
    };
    let header = &shown(header)[..];
    let rows: Vec<Vec<String>> = rows.iter().map(|row| shown(row)).collect();
    let length = |cell: &String| cell.chars().count();
    let widths: Vec<usize> = (0..header.len())
        .map(|i| {
            rows.iter()
                .filter_map(|r| r.get(i))
                .chain([&header[i]])
                .map(length)
                .max()
                .unwrap_or(0)
        })
        .collect();
    let number = |cell: &String| cell.is_empty() || cell == "–" || cell.parse::<f64>().is_ok();
    let right: Vec<bool> = (0..header.len())
        .map(|i| !rows.is_empty() && rows.iter().filter_map(|r| r.get(i)).all(number))
        .collect();
    let line = |cells: &[String]| {
        let mut out = String::new();
        for (i, cell) in cells.iter().enumerate() {
            let pad = " ".repeat(widths[i].saturating_sub(length(cell)));
            if right[i] {
                out.push_str(&pad);
                out.push_str(cell);
            } else {
                out.push_str(cell);
                out.push_str(&pad);
            }
            out.push_str("  ");
        }
        out.trim_end().to_string()
    };
    let mut lines = vec![line(header)];
    lines.extend(rows.iter().map(|r| line(r)));
    lines.join("\n")
}

/// Rows as CSV.
pub(crate) fn csv(header: &[String], rows: &[Vec<String>]) -> String {
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

    #[test]
    fn analytic_cells_are_quoted_and_aligned() {
        let header = ["a".to_string(), "b".to_string()];
        let rows = [vec!["x,\"y\"".to_string(), "1.5".to_string()]];
        assert_eq!(csv(&header, &rows), "a,b\n\"x,\"\"y\"\"\",1.5\n");
        assert_eq!(text_table(&header, &rows), "a        b\nx,\"y\"  1.5");
    }
}
