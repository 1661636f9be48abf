//! The report of `touchdown inspect`.

use touchdown_log::{Table, TimeBase};
use touchdown_report::{Callout, Cell, Figure, Panel, Report, Series};
use touchdown_trial::{Trial, Unit, unit_of};

use super::identify::slug;
use super::page;
use crate::error::{Error, Result};

/// Panels in one figure.
const PANELS: usize = 6;

/// One log in the report.
#[derive(Clone, Debug)]
pub struct Section {
    /// The file.
    pub title: String,
    /// Rows and time base in a line.
    pub about: String,
    /// Head and rows of the table of topics, for a log that has some.
    pub topics: Option<(Vec<String>, Vec<Vec<String>>)>,
    /// Head of the table of columns; empty where there is none.
    pub header: Vec<String>,
    /// A row a column.
    pub rows: Vec<Vec<String>>,
    /// What a reader should know.
    pub warnings: Vec<String>,
    /// A map to start from.
    pub suggested_map: Option<String>,
    /// Plots of every column.
    pub figures: Vec<Figure>,
}

/// Plots of every channel of a trial over time. `index` keeps the figures of two logs apart.
#[must_use]
pub fn of_trial(index: usize, name: &str, trial: &Trial) -> Vec<Figure> {
    let columns = trial.channels().map(|(channel, values)| {
        let label = match unit_of(channel) {
            Unit::Dimensionless => channel.to_string(),
            unit => format!("{channel} ({unit})"),
        };
        (label, values)
    });
    figures(index, name, "Time (s)", trial.time_s(), columns)
}

/// Plots of every column of numbers over the time base, or over the rows where there is none.
#[must_use]
pub fn of_table(index: usize, name: &str, table: &Table, time: Option<&TimeBase>) -> Vec<Figure> {
    let base = time.and_then(|t| Some((table.column(&t.column)?, t)));
    let (label, x): (&str, Vec<f64>) = match base {
        Some((column, t)) => {
            let first = column
                .values()
                .iter()
                .copied()
                .find(|v| v.is_finite())
                .unwrap_or(0.0);
            let since = |v: &f64| (v - first) * t.unit_s;
            (
                "Time from the first row (s)",
                column.values().iter().map(since).collect(),
            )
        }
        None => ("Row", (0..table.len()).map(|i| i as f64).collect()),
    };
    let columns = table
        .columns()
        .iter()
        .filter(|c| !c.is_text() && base.is_none_or(|(b, _)| b.name() != c.name()))
        .map(|c| (c.name().to_string(), c.values()));
    figures(index, name, label, &x, columns)
}

fn figures<'a>(
    index: usize,
    name: &str,
    x_label: &str,
    x: &[f64],
    columns: impl Iterator<Item = (String, &'a [f64])>,
) -> Vec<Figure> {
    let panels: Vec<Panel> = columns
        .filter(|(_, values)| values.iter().any(|v| v.is_finite()))
        .map(|(label, values)| {
            // A channel that is slower than the table has gaps between its values; they are not gaps in time.
            let (t, v): (Vec<f64>, Vec<f64>) = x
                .iter()
                .zip(values)
                .filter(|(_, v)| v.is_finite())
                .map(|(t, v)| (*t, *v))
                .unzip();
            let series = if t.len() <= 60 {
                Series::lines_points("", &t, &v)
            } else {
                Series::line("", &t, &v)
            };
            Panel::new(x_label, label).series(series.width(1.2))
        })
        .collect();
    panels
        .chunks(PANELS)
        .enumerate()
        .map(|(k, chunk)| {
            let id = format!("{:03}-{}-{}", index + 1, slug(name), k + 1);
            let mut figure = Figure::new(id, name)
                .caption("Every value over time; lines join neighbours over gaps.")
                .share_x();
            for panel in chunk {
                figure = figure.panel(panel.clone());
            }
            figure
        })
        .collect()
}

/// A table whose columns in `numbers` hold numbers.
fn table(
    title: &str,
    header: &[String],
    rows: &[Vec<String>],
    numbers: std::ops::Range<usize>,
) -> touchdown_report::Table {
    let mut table = touchdown_report::Table::new(title);
    for (i, name) in header.iter().enumerate() {
        table = if numbers.contains(&i) {
            table.number_column(name, "")
        } else {
            table.text_column(name)
        };
    }
    for row in rows {
        table = table.row(row.iter().map(Cell::text));
    }
    table
}

/// The report.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn report(command: &str, sections: &[Section]) -> Result<Report> {
    let mut report = page::report("Logs", "Columns, units, rates and gaps");
    report.fact("Logs", sections.len().to_string());
    let (kind, verdict) = verdict(sections);
    report.verdict(kind, verdict);
    let mut figures = sections.iter().flat_map(|section| &section.figures);
    if let Some(first) = figures.next() {
        report.figure(first)?;
    }
    if let Some((first, others)) = sections.split_first() {
        report.section(&first.title);
        of_log(&mut report, first, first.figures.iter().skip(1))?;
        if !others.is_empty() {
            report.section("The other logs");
        }
        for section in others {
            report.folded(&section.title, |inner| {
                of_log(inner, section, section.figures.iter())
            })?;
        }
    }
    page::how_made(&mut report, command, None)?;
    Ok(report)
}

/// What a log holds: warnings, topics, columns, a map to start from, and plots.
fn of_log<'a>(
    report: &mut Report,
    section: &Section,
    mut figures: impl Iterator<Item = &'a Figure>,
) -> Result<()> {
    report.paragraph(&section.about);
    for warning in &section.warnings {
        report.callout(Callout::Warning, warning);
    }
    if let Some((header, rows)) = &section.topics {
        page::put_table(report, table("Topics.", header, rows, 1..7))?;
    }
    if !section.header.is_empty() {
        page::put_table(
            report,
            table("Columns.", &section.header, &section.rows, 2..8),
        )?;
    }
    if let Some(map) = &section.suggested_map {
        report.folded("A map to start from", |inner| {
            inner.code(map);
            Ok::<(), Error>(())
        })?;
    }
    figures.try_for_each(|figure| Ok(report.figure(figure).map(drop)?))
}

/// How much was read and how many warnings there are.
fn verdict(sections: &[Section]) -> (Callout, String) {
    let columns: usize = sections.iter().map(|s| s.rows.len()).sum();
    let warnings: usize = sections.iter().map(|s| s.warnings.len()).sum();
    let logs = page::count(sections.len(), "log");
    let read = match columns {
        0 => format!("{logs} can be read."),
        _ => format!(
            "{logs} can be read, with {}.",
            page::count(columns, "column")
        ),
    };
    match warnings {
        0 => (
            Callout::Success,
            format!("{read} Nothing in them needs a warning."),
        ),
        _ => (
            Callout::Warning,
            format!(
                "{read} Read the {} below before you use them.",
                page::count(warnings, "warning")
            ),
        ),
    }
}
