//! The report of `touchdown identify`.

mod flight;
mod ground;
mod runs;
mod thrust;

use std::path::Path;

use touchdown_report::{Callout, Cell, Figure, Report, Table};

use super::front;
use super::page::show;
use crate::error::{Error, Result};
use crate::identify::FittedCard;

pub use flight::{figures as flight_figures, report as flight_report};
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
        let table = all_fits(self.header, self.rows);
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

/// More columns than this do not fit beside each other on a page.
const COLUMNS: usize = 8;

/// The summary: a row for each fit, or a column where few fits have many figures.
fn all_fits(header: &[String], rows: &[Vec<String>]) -> Table {
    let mut table = Table::new("All fits.");
    // What tells the fits apart stands above them.
    let apart = (0..header.len()).find(|&k| {
        let mut values: Vec<&String> = rows.iter().map(|row| &row[k]).collect();
        values.sort();
        values.dedup();
        values.len() == rows.len()
    });
    if let Some(names) = apart.filter(|_| header.len() > COLUMNS && rows.len() < COLUMNS) {
        table = table.text_column(&header[names]);
        for row in rows {
            table = table.text_column(&row[names]);
        }
        for (k, name) in header.iter().enumerate() {
            if k != names && rows.iter().any(|row| !row[k].is_empty()) {
                let cells = rows.iter().map(|row| Cell::text(&row[k]));
                table = table.row([Cell::text(name)].into_iter().chain(cells));
            }
        }
        return table;
    }
    for (i, name) in header.iter().enumerate() {
        let words = rows
            .iter()
            .any(|r| r[i].parse::<f64>().is_err() && !r[i].is_empty());
        table = if words || i == 0 {
            table.text_column(name)
        } else {
            table.number_column(name, "")
        };
    }
    for row in rows {
        table = table.row(row.iter().map(Cell::text));
    }
    table
}

/// Coefficients with their standard errors and intervals, the front, method and warnings of one card.
fn card_blocks(report: &mut Report, made: &FittedCard) -> Result<()> {
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
pub fn front_figure(made: &FittedCard) -> Option<Figure> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_few_fits_with_many_figures_stand_side_by_side() {
        let header: Vec<String> = (0..12).map(|k| format!("c{k}")).collect();
        let row = |form: &str| {
            let mut row = vec![String::new(); 12];
            row[0] = "all".into();
            row[1] = form.into();
            row[5] = "3".into();
            row
        };
        let rows = [row("lag"), row("ratio")];
        let table = all_fits(&header, &rows);
        // What tells the fits apart heads the columns; what none of them has is left out.
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["c1", "lag", "ratio"]);
        assert_eq!(table.rows.len(), 2);
        let wide = all_fits(&header[..3], &[row("lag")[..3].to_vec()]);
        assert_eq!((wide.columns.len(), wide.rows.len()), (3, 1));
    }
}
