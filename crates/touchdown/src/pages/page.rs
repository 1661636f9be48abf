//! A report in the making with the figures that it shows, and the marks that all reports share.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use touchdown_report::{Cell, Color, Figure, Report, Table};

use crate::error::{Error, Result};
use crate::identify::settings::GroundEffectForm;
use crate::score::Errors;
use crate::statistics::Summary;
use touchdown_flight::Method;

/// Grey of raw measurements: seen, but behind everything else.
pub(super) const MEASURED: Color = Color::Rgb(0xB8, 0xBE, 0xC6);
/// Published figures.
pub(super) const PUBLISHED: Color = Color::Rgb(0xB0, 0x00, 0x30);

/// A report and its figures.
pub(super) struct Page {
    /// The report.
    pub(super) report: Report,
    out: PathBuf,
    figures: Vec<Figure>,
}

impl Page {
    pub(super) fn new(title: &str, out: &Path) -> Self {
        Self {
            report: Report::new(title),
            out: out.to_owned(),
            figures: Vec::new(),
        }
    }

    pub(super) fn text(&mut self, text: impl Into<String>) {
        self.report.paragraph(text);
    }

    pub(super) fn table(&mut self, table: Table) -> Result<()> {
        self.report.table(table)?;
        Ok(())
    }

    pub(super) fn figure(&mut self, figure: Figure) -> Result<()> {
        self.report.figure(&figure)?;
        self.figures.push(figure);
        Ok(())
    }

    /// The figures' names so far, as files under the folder of results.
    pub(super) fn figure_names(&self) -> Vec<&str> {
        self.figures.iter().map(|f| f.id.as_str()).collect()
    }

    /// Writes `figures/*.svg`, `figures/*.png` and `report.html`.
    pub(super) fn finish(self) -> Result<()> {
        let folder = self.out.join("figures");
        std::fs::create_dir_all(&folder).map_err(|e| Error::file(&folder, e))?;
        self.figures
            .par_iter()
            .try_for_each(|figure| figure.write(&folder).map(drop))?;
        self.report.write(self.out.join("report.html"))?;
        Ok(())
    }
}

/// The values in order, and the share of them below each in %: a curve of steps from its first value, with nothing below.
pub(super) fn shares_below(values: impl Iterator<Item = f64>) -> (Vec<f64>, Vec<f64>) {
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
pub(super) fn show(value: f64, decimals: usize) -> String {
    Cell::number(value, decimals).shown().to_string()
}

/// A number of three decimals, or a dash.
pub(super) fn maybe(value: Option<f64>) -> String {
    show(value.unwrap_or(f64::NAN), 3)
}

/// `mean / worst`.
pub(super) fn errors(errors: Option<Errors>) -> Cell {
    errors.map_or_else(Cell::missing, |e| {
        Cell::text(format!("{} / {}", show(e.mae, 3), show(e.worst, 2)))
    })
}

/// `mean ± standard deviation`.
pub(super) fn spread(summary: Option<Summary>, decimals: usize) -> Cell {
    summary.map_or_else(Cell::missing, |s| {
        Cell::plus_minus(s.mean, s.sd.unwrap_or(f64::NAN), decimals)
    })
}

/// Half the 95 % interval of the mean.
pub(super) fn half_interval(summary: Option<Summary>, decimals: usize) -> Cell {
    summary
        .and_then(|s| s.ci95)
        .map_or_else(Cell::missing, |[low, high]| {
            Cell::text(format!("±\u{a0}{}", show(0.5 * (high - low), decimals)))
        })
}

/// One colour a method, in all figures.
pub(super) fn method_color(method: Method) -> Color {
    Color::Cycle(match method {
        Method::Dynamic => 0,
        Method::Empirical => 1,
        Method::Imbc => 2,
        Method::Ssc => 3,
        _ => 5,
    })
}

/// One colour a form, in all figures; those that are flown have their method's.
pub(super) fn form_color(form: GroundEffectForm) -> Color {
    Color::Cycle(match form {
        GroundEffectForm::Lag => 0,
        GroundEffectForm::Empirical => 1,
        GroundEffectForm::Static => 2,
        GroundEffectForm::Derivative => 3,
        GroundEffectForm::Ratio => 4,
    })
}

/// What a form is called in tables and legends.
pub(super) fn form_title(form: GroundEffectForm) -> &'static str {
    match form {
        GroundEffectForm::Empirical => "eq. (2), fitted μ",
        GroundEffectForm::Static => "static map T h(z)",
        GroundEffectForm::Derivative => "eq. (9), SR3",
        GroundEffectForm::Ratio => "ratio form",
        GroundEffectForm::Lag => "lag form",
    }
}

/// Means of `values` over consecutive blocks of `seconds`, and the middles of the blocks.
pub(super) fn block_means(time_s: &[f64], values: &[f64], seconds: f64) -> [Vec<f64>; 2] {
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
pub(super) fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
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
