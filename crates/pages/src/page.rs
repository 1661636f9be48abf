//! A report in the making with the figures that it shows, and the marks that all reports share.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use touchdown_campaign::statistics::{Share, Summary};
use touchdown_identify::scores::Errors;
use touchdown_report::{Cell, Color, Figure, Report, Series, Table};

use super::glossary::TERMS;
use crate::error::{Error, Result};

/// A report and its figures.
pub struct Page {
    /// The report.
    pub report: Report,
    out: PathBuf,
    figures: Vec<Figure>,
}

impl Page {
    /// An empty page; `out` is the folder that [`Self::finish`] writes into.
    #[must_use]
    pub fn new(title: &str, subtitle: &str, out: &Path) -> Self {
        Self {
            report: report(title, subtitle),
            out: out.to_owned(),
            figures: Vec::new(),
        }
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.report.paragraph(text);
    }

    /// Adds a table, a long one behind its caption.
    ///
    /// # Errors
    /// Rows that do not fit the columns.
    pub fn table(&mut self, table: Table) -> Result<()> {
        put_table(&mut self.report, table)
    }

    /// Adds tables behind a line.
    pub fn folded_tables(&mut self, summary: &str, tables: Vec<Table>) -> Result<()> {
        self.report.folded(summary, |inner| {
            tables
                .into_iter()
                .try_for_each(|table| inner.table(table).map(drop))
        })?;
        Ok(())
    }

    /// Adds a figure.
    ///
    /// # Errors
    /// A figure that cannot be drawn.
    pub fn figure(&mut self, figure: Figure) -> Result<()> {
        self.report.figure(&figure)?;
        self.figures.push(figure);
        Ok(())
    }

    /// Adds figures behind a line.
    pub fn folded_figures(
        &mut self,
        summary: &str,
        figures: impl Iterator<Item = Figure>,
    ) -> Result<()> {
        let figures: Vec<Figure> = figures.collect();
        folded_figures(&mut self.report, summary, figures.iter())?;
        self.figures.extend(figures);
        Ok(())
    }

    /// The figures' names so far, as files under the folder of results.
    pub fn figure_names(&self) -> Vec<&str> {
        self.figures.iter().map(|f| f.id.as_str()).collect()
    }

    /// Writes `figures/*.svg`, `figures/*.png` and `report.html`.
    pub fn finish(self) -> Result<()> {
        write(&self.out, &self.figures, &self.report)
    }
}

/// An empty report that explains the terms of all pages.
pub fn report(title: &str, subtitle: &str) -> Report {
    let mut report = Report::new(title);
    report
        .glossary(TERMS)
        .subtitle(subtitle)
        .fact("Version", env!("CARGO_PKG_VERSION"));
    report
}

/// Tables with more rows than this are folded away: they fill a screen.
const LONG: usize = 14;

/// Commands of more letters than this are folded away: they fill half a screen.
const LONG_COMMAND: usize = 1200;

/// Adds a table, a long one behind its caption.
pub fn put_table(report: &mut Report, mut table: Table) -> Result<()> {
    if table.rows.len() <= LONG {
        report.table(table)?;
        return Ok(());
    }
    let caption = table.caption.replace(['`', '*'], "");
    let summary = format!(
        "{} ({} rows)",
        caption.trim_end_matches('.'),
        table.rows.len()
    );
    table.caption.clear();
    report.folded(summary, |inner| inner.table(table).map(drop))?;
    Ok(())
}

/// Adds figures behind a line; nothing where there are none.
pub fn folded_figures<'a>(
    report: &mut Report,
    summary: &str,
    figures: impl Iterator<Item = &'a Figure>,
) -> Result<()> {
    let mut figures = figures.peekable();
    if figures.peek().is_some() {
        report.folded(summary, |inner| {
            figures.try_for_each(|figure| inner.figure(figure).map(drop))
        })?;
    }
    Ok(())
}

/// The last section: the command that makes the page again, and its settings, folded away.
pub fn how_made(
    report: &mut Report,
    command: &str,
    settings: Option<(&str, String)>,
) -> Result<()> {
    report.section("How to redo this");
    if command.len() > LONG_COMMAND {
        report.folded("The command, with all its logs", |inner| {
            inner.code(command);
            Ok::<(), Error>(())
        })?;
    } else {
        report.code(command);
    }
    if let Some((file, toml)) = settings {
        report.folded(format!("Settings: {file}"), |inner| {
            inner.code(toml);
            Ok::<(), Error>(())
        })?;
    }
    Ok(())
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
    let place = folder.join("figures");
    std::fs::create_dir_all(&place).map_err(|e| Error::file(&place, e))?;
    let figures: Vec<&Figure> = figures.into_iter().collect();
    figures
        .par_iter()
        .try_for_each(|figure| figure.write(&place).map(drop))?;
    report.write(folder.join("report.html"))?;
    Ok(())
}

/// Shares at places along an axis of names, with their 95 % intervals: the intervals, then the points.
pub fn share_series(name: &str, shares: &[(f64, Share)], color: Color) -> [Series; 2] {
    let (x, y): (Vec<f64>, Vec<f64>) = shares.iter().map(|(at, s)| (*at, 100.0 * s.share)).unzip();
    let at: Vec<f64> = x.iter().flat_map(|at| [*at, *at, f64::NAN]).collect();
    let ends = shares
        .iter()
        .flat_map(|(_, s)| [100.0 * s.ci95[0], 100.0 * s.ci95[1], f64::NAN]);
    [
        Series::line("", &at, &ends.collect::<Vec<f64>>()).color(color),
        Series::points(name, &x, &y).color(color).width(4.0),
    ]
}

/// `1 landing`, `2 landings`.
pub fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

/// The values in order, and the share of them below each in %: a curve of steps from its first value, with nothing below.
pub fn shares_below(values: impl Iterator<Item = f64>) -> (Vec<f64>, Vec<f64>) {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    if let Some(&first) = values.first() {
        values.insert(0, first);
    }
    let shares = (0..values.len()).map(|k| 100.0 * k as f64 / count);
    let shares = shares.collect();
    (values, shares)
}

/// A number as it stands in text.
pub fn show(value: f64, decimals: usize) -> String {
    Cell::number(value, decimals).shown().to_string()
}

/// A number of three decimals, or a dash.
pub fn maybe(value: Option<f64>) -> String {
    show(value.unwrap_or(f64::NAN), 3)
}

/// `mean / worst`.
pub fn errors(errors: Option<Errors>) -> Cell {
    errors.map_or_else(Cell::missing, |e| {
        Cell::text(format!("{} / {}", show(e.mae, 3), show(e.worst, 2)))
    })
}

/// `mean ± standard deviation`.
pub fn spread(summary: Option<Summary>, decimals: usize) -> Cell {
    summary.map_or_else(Cell::missing, |s| {
        Cell::plus_minus(s.mean, s.sd.unwrap_or(f64::NAN), decimals)
    })
}

/// Half the 95 % interval of the mean.
pub fn half_interval(summary: Option<Summary>, decimals: usize) -> Cell {
    summary
        .and_then(|s| s.ci95)
        .map_or_else(Cell::missing, |[low, high]| {
            Cell::text(format!("±\u{a0}{}", show(0.5 * (high - low), decimals)))
        })
}

/// Means of `values` over consecutive blocks of `seconds`, and the middles of the blocks.
pub fn block_means(time_s: &[f64], values: &[f64], seconds: f64) -> [Vec<f64>; 2] {
    let mut means = [Vec::new(), Vec::new()];
    let mut sums = (0.0, 0.0, 0.0);
    let mut block = f64::NAN;
    let mut close = |sums: (f64, f64, f64)| {
        if sums.2 > 0.0 {
            means[0].push(sums.0 / sums.2);
            means[1].push(sums.1 / sums.2);
        }
    };
    for (&t, &v) in time_s.iter().zip(values) {
        let now = (t / seconds).floor();
        if now != block {
            close(sums);
            (sums, block) = ((0.0, 0.0, 0.0), now);
        }
        if v.is_finite() {
            sums = (sums.0 + t, sums.1 + v, sums.2 + 1.0);
        }
    }
    close(sums);
    means
}

/// The differences of two columns.
pub fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_block_means_skip_gaps() {
        let [t, v] = block_means(
            &[0.0, 0.4, 1.0, 1.5, 3.2],
            &[1.0, 3.0, f64::NAN, 5.0, 7.0],
            1.0,
        );
        // Exact but for one rounding of 0.4/2.
        assert!(
            t.iter()
                .zip([0.2, 1.5, 3.2])
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        assert_eq!(v, [2.0, 5.0, 7.0]);
    }

    #[test]
    fn analytic_cells_of_absent_figures_are_dashes() {
        assert_eq!(errors(None), Cell::missing());
        assert_eq!(spread(None, 2), Cell::missing());
        assert_eq!(half_interval(Summary::of(&[1.0]), 2), Cell::missing());
        assert_eq!(spread(Summary::of(&[1.5]), 2).shown(), "1.50");
    }
}
