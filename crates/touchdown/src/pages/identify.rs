//! The report of `touchdown identify`.

mod ground;
mod thrust;

use std::path::Path;

use touchdown_report::{Callout, Cell, Figure, Report, Table};

use super::front;
use super::page::show;
use crate::error::{Error, Result};
use crate::identify::Made;

pub use ground::{figures as ground_figures, report as ground_report};
pub use thrust::{ThrustFit, figures as thrust_figures, report as thrust_report};

/// What every report of identification begins with.
#[derive(Clone, Copy, Debug)]
pub struct Overview<'a> {
    /// What was identified.
    pub title: &'a str,
    /// The command that redoes it.
    pub command: &'a str,
    /// Head of the summary table.
    pub header: &'a [String],
    /// Its rows; the last cell of each holds the warnings.
    pub rows: &'a [Vec<String>],
}

impl Overview<'_> {
    fn begin(&self) -> Result<Report> {
        let mut report = Report::new(self.title);
        report
            .subtitle("Identified from logs")
            .fact("Version", env!("CARGO_PKG_VERSION"))
            .fact("Fits", self.rows.len().to_string());
        report.section("Summary");
        let mut table = Table::new("All fits.");
        for (i, name) in self.header.iter().enumerate() {
            let words = self
                .rows
                .iter()
                .any(|r| r[i].parse::<f64>().is_err() && !r[i].is_empty());
            table = if words || i == 0 {
                table.text_column(name)
            } else {
                table.number_column(name, "")
            };
        }
        for row in self.rows {
            table = table.row(row.iter().map(Cell::text));
        }
        report.table(table)?;
        Ok(report)
    }

    fn end(&self, report: &mut Report) {
        report
            .section("How this was made")
            .paragraph("The settings stand in `inputs/settings.toml` beside this report.")
            .code(self.command);
    }
}

/// Coefficients with their standard errors and intervals, the front, method and warnings of one card.
fn card_blocks(report: &mut Report, made: &Made) -> Result<()> {
    let card = &made.card;
    let mut table = Table::new(format!("{}.", card.equation))
        .text_column("part")
        .text_column("term")
        .number_column("coefficient", "")
        .number_column("standard error", "")
        .number_column("95 % interval", "")
        .text_column("unit");
    for term in &card.terms {
        table = table.row([
            Cell::text(&term.of),
            Cell::text(&term.expression),
            Cell::number(term.value, 5),
            Cell::maybe(term.std_error, 5),
            term.ci95.map_or_else(Cell::missing, |[low, high]| {
                Cell::text(format!("{} … {}", show(low, 5), show(high, 5)))
            }),
            Cell::text(&term.unit),
        ]);
    }
    let note = "Intervals: Student's t over the trials (or stretches of them), which may be correlated inside. That the terms were \
                chosen on the same data is not in them.";
    report.table(table.note(note))?;
    if !card.scores.is_empty() {
        let mut table = Table::new("Errors on the data of the fit.")
            .text_column("data")
            .text_column("judged by")
            .number_column("MAE", "")
            .number_column("RMSE", "")
            .number_column("worst", "")
            .text_column("unit");
        for s in card.scores.iter().filter(|s| s.seen) {
            table = table.row([
                Cell::text(&s.trial),
                Cell::text(s.kind.replace('_', " ")),
                Cell::number(s.mae, 4),
                Cell::number(s.rmse, 4),
                Cell::number(s.worst, 4),
                Cell::text(&s.unit),
            ]);
        }
        report.table(table)?;
    }
    if let Some(front) = &made.front {
        report.paragraph(front::words(front));
        report.table(front::table("The best subset of every size.", front))?;
    }
    let method = &card.provenance.method;
    report.list(method.iter().map(|(key, value)| format!("{key}: {value}")));
    for warning in &card.warnings {
        report.callout(Callout::Warning, warning);
    }
    Ok(())
}

/// The front of a fit, where it has one.
#[must_use]
pub fn front_figure(made: &Made) -> Option<Figure> {
    let front = made.front.as_ref()?;
    let id = format!("front-{}", slug(&made.card.name));
    Some(front::figure(&id, "Error over the number of terms", front))
}

/// A figure's name: what a file name and an anchor may hold.
pub(super) fn slug(text: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' || c == '_' {
            c
        } else {
            '-'
        }
    };
    text.chars().map(plain).collect()
}

/// Writes figures (SVG and PNG) and the report; draws on all processors.
///
/// # Errors
/// A file that cannot be written.
pub fn write<'a>(
    folder: &Path,
    figures: impl IntoIterator<Item = &'a Figure>,
    report: &Report,
) -> Result<()> {
    use rayon::prelude::*;
    let place = folder.join("figures");
    std::fs::create_dir_all(&place).map_err(|e| Error::file(&place, e))?;
    let figures: Vec<&Figure> = figures.into_iter().collect();
    figures
        .par_iter()
        .try_for_each(|figure| figure.write(&place).map(|_| ()))?;
    report.write(folder.join("report.html"))?;
    Ok(())
}
