//! The report of `touchdown identify`.

mod armed_intervals;
mod flights;
mod ground;
mod parameters;
pub mod summary;
mod thrust;

use touchdown_campaign::settings_file::to_toml;
use touchdown_identify::forms::FormScore;
use touchdown_identify::{FittedCard, IdentificationSettings};
use touchdown_model::{Card, Mark};
use touchdown_report::{Callout, Cell, Figure, Report, Table};

use crate::error::{Error, Result};
use crate::page::show;
use crate::{front, page};

pub use flights::{FlightFit, flight_warnings};
pub use ground::RigFit;
pub use thrust::{ThrustFit, ThrustFits};

use summary::{Outcome, Summary};

/// A report with its figures.
#[derive(Clone, Debug)]
pub struct Shown {
    /// All figures, in the report's order.
    pub figures: Vec<Figure>,
    /// The report.
    pub report: Report,
}

/// What every report of identification has.
#[derive(Clone, Copy, Debug)]
pub struct About<'a> {
    /// The fits, and those that failed.
    pub outcomes: &'a [Outcome],
    /// The command that redoes it.
    pub command: &'a str,
    /// The settings of all fits.
    pub settings: &'a IdentificationSettings,
}

/// What every report of identification begins and ends with.
struct Overview<'a> {
    title: &'a str,
    about: &'a About<'a>,
    summary: Summary,
}

impl<'a> Overview<'a> {
    fn of(title: &'a str, about: &'a About<'a>) -> Self {
        Self {
            title,
            about,
            summary: Summary::of(about.outcomes),
        }
    }

    /// Begins a page with its verdict and the picture that shows it.
    fn begin(
        &self,
        (kind, verdict): (Callout, String),
        picture: Option<&Figure>,
    ) -> Result<Report> {
        let mut report = page::report(self.title, "Identified from logs");
        report
            .fact("Fits", self.summary.rows.len().to_string())
            .verdict(kind, verdict);
        if let Some(picture) = picture {
            report.figure(picture)?;
        }
        Ok(report)
    }

    /// The table of all fits.
    fn all_fits(&self, report: &mut Report) -> Result<()> {
        report.section("All fits");
        page::put_table(report, all_fits(&self.summary.header, &self.summary.rows))
    }

    /// Ends a page with the command.
    fn end(&self, report: &mut Report) -> Result<()> {
        let settings = to_toml(self.about.settings)?;
        page::how_made(
            report,
            self.about.command,
            Some(("settings.toml", settings)),
        )
    }
}

/// How many remarks qualify a result, in a sentence.
pub(crate) fn remarks(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => " One warning below qualifies this.".into(),
        _ => format!(" {count} warnings below qualify this."),
    }
}

/// More columns than this do not fit beside each other on a page.
const COLUMNS: usize = 8;

/// The summary: a row for each fit, or a column where few fits have many figures.
fn all_fits(header: &[String], rows: &[Vec<String>]) -> Table {
    let mut table = Table::new("All fits.");
    // The heading names the difference between the fits.
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

/// Warnings, coefficients with their intervals, errors, and behind folds the front and the method of one card.
fn card_blocks(report: &mut Report, made: &FittedCard) -> Result<()> {
    let card = &made.card;
    for warning in &card.warnings {
        report.callout(Callout::Warning, warning);
    }
    page::put_table(report, coefficients(card))?;
    if card.scores.iter().any(|s| s.seen) {
        page::put_table(report, scores(card))?;
    }
    if !made.forms.is_empty() {
        page::put_table(report, forms(&made.forms))?;
    }
    if let Some(front) = &made.front {
        report.paragraph(front::words(front));
        report.folded("The best subset of every size", |inner| {
            inner
                .table(front::table("The best subset of every size.", front))
                .map(drop)
        })?;
    }
    let method = &card.provenance.method;
    report.folded(format!("How {} was fitted", card.name), |inner| {
        inner.list(method.iter().map(|(key, value)| format!("{key}: {value}")));
        Ok::<(), Error>(())
    })?;
    Ok(())
}

fn coefficients(card: &Card) -> Table {
    let mut table = Table::new(format!("{}.", card.equation))
        .text_column("part")
        .text_column("term")
        .number_column("coefficient", "")
        .number_column("standard error", "")
        .number_column("95 % interval", "")
        .text_column("unit");
    for term in &card.terms {
        let without = || match (term.mark, term.upper_bound) {
            (None, _) => Cell::missing(),
            (Some(Mark::UpperBound), Some(bound)) => {
                Cell::text(format!("upper bound {}", show(bound, 5)))
            }
            (Some(mark), _) => Cell::text(mark.words()),
        };
        table = table.row([
            Cell::text(&term.of),
            Cell::text(&term.expression),
            Cell::number(term.value, 5),
            Cell::maybe(term.std_error, 5),
            term.ci95.map_or_else(without, |ends| interval(ends, 5)),
            Cell::text(&term.unit),
        ]);
    }
    table.note(
        "Intervals: Student's t over the trials or stretches of them, which may be correlated inside. They do not hold the \
         uncertainty of the choice of terms, which was made on the same data.",
    )
}

/// The forms that were tried.
fn forms(scores: &[FormScore]) -> Table {
    let mut table = Table::new("Forms, by the error of their free run on parts held out.")
        .text_column("form")
        .number_column("parameters", "")
        .number_column("held-out RMSE", "N")
        .number_column("standard error", "N")
        .text_column("chosen");
    for score in scores {
        let chosen = match (&score.error, score.chosen) {
            (Some(why), _) => why.as_str(),
            (None, true) => "chosen",
            (None, false) => "",
        };
        table = table.row([
            Cell::text(score.name()),
            Cell::number(score.parameters as f64, 0),
            Cell::maybe(score.held_out_rmse_n, 5),
            Cell::maybe(score.std_error_n, 5),
            Cell::text(chosen),
        ]);
    }
    table.note("Of forms within one standard error of the best, and at most 5 % worse, the one with fewest parameters is chosen.")
}

fn scores(card: &Card) -> Table {
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
    table
}

/// `low … high`.
fn interval([low, high]: [f64; 2], decimals: usize) -> Cell {
    Cell::text(format!(
        "{} … {}",
        show(low, decimals),
        show(high, decimals)
    ))
}

/// The front of a fit, where it has one.
fn front_figure(made: &FittedCard) -> Option<Figure> {
    let front = made.front.as_ref()?;
    let id = format!("front-{}", slug(&made.card.name));
    Some(front::figure(&id, "Error over the number of terms", front))
}

/// A figure's name: what a file name and an anchor may hold.
pub(crate) fn slug(text: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' || c == '_' {
            c
        } else {
            '-'
        }
    };
    text.chars().map(plain).collect()
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
        // The columns are headed by the settings in which the fits differ. Settings that no fit has are omitted.
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["c1", "lag", "ratio"]);
        assert_eq!(table.rows.len(), 2);
        let wide = all_fits(&header[..3], &[row("lag")[..3].to_vec()]);
        assert_eq!((wide.columns.len(), wide.rows.len()), (3, 1));
    }
}
