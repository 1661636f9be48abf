//! A fit as text for people.

use std::fmt::Write as _;

use sindy::{Model, Outcome};

use super::object::{FitObject, Front, TermObject};
use super::score::TestObject;
use crate::named::Named;
use crate::numbers::{decimals, significant};
use crate::trajectories::past;

/// Sizes of equations that are shown beyond the chosen one.
const BEYOND: usize = 4;

/// Equations, coefficients with intervals, front, choice and test.
pub(super) fn text(model: &Model, object: &FitObject) -> String {
    let mut out = format!("{model:.5}\n");
    out.push_str(&past::words(model));
    out.push_str(&coefficients(&object.equations));
    if let Some(all) = &object.diffusion {
        out.push_str(&diffusion(all));
    }
    out.push_str(&disturbances(&object.front));
    out.push_str(&front(&object.front));
    let choice = &object.choice;
    let _ = write!(out, "\nchoice    {}", wrapped(&choice.reason));
    let _ = write!(out, "\nsmoothing {}", wrapped(&choice.smoothing));
    let _ = write!(out, "\noutcome   {}", words(object.outcome));
    if let Some(stability) = &object.stability {
        let words = stability.certificate.to_string();
        let _ = write!(out, "\nstability {}", wrapped(&words));
    }
    let _ = write!(out, "\ndata      {}", wrapped(&object.data.summary()));
    if let Some(test) = &object.test {
        out.push_str(&self::test(test));
    }
    out
}

/// Text in lines of at most a hundred letters, those after the first indented.
pub(crate) fn wrapped(text: &str) -> String {
    let mut out = String::new();
    let mut length = 0;
    for word in text.split(' ') {
        if length > 0 && length + word.chars().count() > 90 {
            out.push_str("\n         ");
            length = 0;
        }
        if !out.is_empty() {
            out.push(' ');
        }
        out.push_str(word);
        length += word.chars().count() + 1;
    }
    out
}

/// A table with columns as wide as their widest cell, numbers to the right.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>], left: &[usize]) -> String {
    let width = |c: usize| {
        let cells = rows.iter().map(|r| r[c].chars().count());
        cells.chain([header[c].len()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &[String]| {
        let mut line = String::from(" ");
        for (c, (cell, &width)) in cells.iter().zip(&widths).enumerate() {
            let _ = match left.contains(&c) {
                true => write!(line, " {cell:<width$} "),
                false => write!(line, " {cell:>width$} "),
            };
        }
        line.trim_end().to_owned() + "\n"
    };
    let header: Vec<String> = header.iter().map(ToString::to_string).collect();
    let mut out = line(&header);
    rows.iter().for_each(|row| out.push_str(&line(row)));
    out
}

/// Head of the table of coefficients.
pub(crate) const COEFFICIENTS: [&str; 7] = [
    "state",
    "term",
    "coefficient",
    "±",
    "95 % from",
    "to",
    "inclusion",
];

/// State, term and numbers of every coefficient.
pub(crate) fn coefficient_rows(equations: &Named<Vec<TermObject>>) -> Vec<Vec<String>> {
    let rows = equations
        .iter()
        .flat_map(|(state, terms)| terms.iter().map(move |t| coefficient(state, t)));
    rows.collect()
}

/// The table of coefficients.
pub(crate) fn coefficients(equations: &Named<Vec<TermObject>>) -> String {
    table(&COEFFICIENTS, &coefficient_rows(equations), &[0, 1])
}

/// Numbers of a term, all to the place of the second digit of the standard error.
fn coefficient(state: &str, term: &TermObject) -> Vec<String> {
    let decimals = term.std_error.and_then(decimals);
    let number = |value: f64| match decimals {
        Some(decimals) => format!("{value:.decimals$}"),
        None => significant(value, 6),
    };
    let maybe = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), number);
    vec![
        state.to_owned(),
        term.term.clone(),
        number(term.coefficient),
        maybe(term.std_error),
        maybe(term.interval.map(|i| i[0])),
        maybe(term.interval.map(|i| i[1])),
        term.inclusion.map_or("-".to_owned(), |p| format!("{p:.2}")),
    ]
}

/// The squared diffusion of each state, and the table of its coefficients.
fn diffusion(all: &Named<Vec<TermObject>>) -> String {
    let mut out = "\nvariance of disturbances in a unit of time\n".to_owned();
    for (state, terms) in all.iter().filter(|(_, terms)| !terms.is_empty()) {
        let _ = write!(out, "var(d{state})/dt =");
        for (k, term) in terms.iter().enumerate() {
            out.push_str(match (k, term.coefficient < 0.0) {
                (0, false) => " ",
                (0, true) => " -",
                (_, false) => " + ",
                (_, true) => " - ",
            });
            out.push_str(&significant(term.coefficient.abs(), 5));
            match term.term.as_str() {
                "1" => {}
                sum if sum.contains(' ') => {
                    let _ = write!(out, "*({sum})");
                }
                factor => {
                    let _ = write!(out, "*{factor}");
                }
            }
        }
        out.push('\n');
    }
    out.push_str(&coefficients(all));
    out
}

/// Sizes of disturbances and of noise, where the system is taken to be disturbed.
fn disturbances(fronts: &Named<Front>) -> String {
    let rows: Vec<Vec<String>> = fronts
        .iter()
        .filter_map(|(state, front)| {
            let noise = front.residual.map_or("-".to_owned(), |r| significant(r, 3));
            let size = significant(front.disturbance?, 3);
            Some(vec![state.to_owned(), size, noise])
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = [
        "state",
        "disturbance in a unit of time",
        "noise of the measurement",
    ];
    format!("\nstandard deviations\n{}", table(&head, &rows, &[0]))
}

/// Terms against error, the chosen row marked; sizes far from any choice are left out.
pub(crate) fn front(fronts: &Named<Front>) -> String {
    let mut out = String::new();
    for (state, front) in fronts.iter() {
        let chosen = front.points.iter().filter(|p| p.chosen).map(|p| p.terms);
        let last = chosen.max().unwrap_or(0) + BEYOND;
        let rows: Vec<Vec<String>> = front
            .points
            .iter()
            .filter(|p| p.terms <= last)
            .map(|p| {
                let mark = if p.chosen { "<- chosen" } else { "" };
                vec![
                    p.terms.to_string(),
                    significant(p.error, 5),
                    p.names.join(", "),
                    mark.to_owned(),
                ]
            })
            .collect();
        if !rows.is_empty() {
            let _ = writeln!(out, "\nterms against error of {state} ({})", front.unit);
            out.push_str(&table(&["terms", "error", "of", ""], &rows, &[2, 3]));
        }
    }
    out
}

fn test(test: &TestObject) -> String {
    let mut out = String::new();
    let percent = |relative: Option<f64>| match relative {
        Some(r) => format!(" ({:.2} % of its scatter)", 100.0 * r),
        None => String::new(),
    };
    for (state, error) in test.derivative.iter().flat_map(Named::iter) {
        let relative = percent(error.relative);
        let _ = write!(
            out,
            "\ntest      slope of {state}: error {:.4e}{relative}",
            error.rmse
        );
    }
    for free in &test.free_run {
        let outcome = free.run.outcome.replace('_', " ");
        let _ = write!(
            out,
            "\ntest      free run of {}: {outcome}, valid for {} of {}",
            free.run.name,
            significant(free.valid_time, 5),
            significant(free.length, 5)
        );
        for (i, (state, rmse)) in free.run.rmse.iter().flat_map(Named::iter).enumerate() {
            let relative = free.run.relative.as_ref().and_then(|r| *r.value(i));
            let relative = percent(relative);
            let rmse = significant(*rmse, 4);
            let _ = write!(out, "\n          error of {state}: {rmse}{relative}");
        }
    }
    out
}

/// An outcome in words.
pub(crate) fn words(outcome: Outcome) -> String {
    let name = format!("{outcome:?}");
    let mut words = String::new();
    for (i, c) in name.char_indices() {
        if c.is_uppercase() && i > 0 {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_long_lines_are_wrapped() {
        let text = vec!["word"; 30].join(" ");
        let lines: Vec<String> = wrapped(&text).lines().map(str::to_owned).collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[0].len() <= 90 && lines[1].starts_with("          word"));
    }
}
