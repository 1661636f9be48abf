//! The report of `touchdown validate`.

use rayon::prelude::*;
use touchdown_campaign::progress::Progress;
use touchdown_model::{Form, Kind};
use touchdown_report::{Callout, Cell, Color, Figure, Panel, Report, Series, Table};

use super::colors::{MEASURED, TRUTH, of_models};
use super::identify::slug;
use super::page;
use crate::error::Result;

/// Samples that all figures of a report draw together, about: more make it slow to open.
const DRAWN_SAMPLES: usize = 200_000;

/// Columns of words at the head of the table of errors: card, form, log, seen.
const WORDS: usize = 4;

/// One free run.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// Name of the card.
    pub card: &'a str,
    /// What it models.
    pub kind: Kind,
    /// Its form, which decides the colour.
    pub form: Form,
    /// Name of the log.
    pub log: &'a str,
    /// Time (s).
    pub time_s: &'a [f64],
    /// Measured (N).
    pub measured_n: &'a [f64],
    /// Without noise (N), where that is known.
    pub truth_n: Option<&'a [f64]>,
    /// Predicted (N).
    pub predicted_n: &'a [f64],
}

/// What the report begins with.
#[derive(Clone, Copy, Debug)]
pub struct Overview<'a> {
    /// The command that redoes it.
    pub command: &'a str,
    /// Head of the table of errors.
    pub header: &'a [String],
    /// Its rows.
    pub rows: &'a [Vec<String>],
    /// What a reader should know.
    pub warnings: &'a [String],
}

/// A figure for each log and kind of model: measured and predicted, error below.
///
/// # Errors
/// None today; drawing itself is checked by the report.
pub fn figures(
    drawn: &[Drawn<'_>],
    logs: &[String],
    progress: &dyn Progress,
) -> Result<Vec<Figure>> {
    // Prediction and error of every run.
    let samples: usize = drawn.iter().map(|d| 2 * d.time_s.len()).sum();
    let every = samples.div_ceil(DRAWN_SAMPLES).max(1);
    let mut cards: Vec<(&str, Form)> = Vec::new();
    for run in drawn {
        if !cards.contains(&(run.card, run.form)) {
            cards.push((run.card, run.form));
        }
    }
    let colors = of_models(&cards.iter().map(|(_, form)| *form).collect::<Vec<_>>());
    let color = |run: &Drawn<'_>| {
        let place = cards.iter().position(|(card, _)| *card == run.card);
        place.map_or(Color::GREY, |place| colors[place])
    };
    let of_log = |(index, log): (usize, &String)| -> Vec<Figure> {
        let of_kind = |kind: Kind| {
            let runs: Vec<&Drawn<'_>> = drawn
                .iter()
                .filter(|d| d.log == log && d.kind == kind)
                .collect();
            (!runs.is_empty()).then(|| figure((index, log), kind, &runs, &color, every))
        };
        let made = [Kind::Thrust, Kind::GroundEffect]
            .into_iter()
            .filter_map(of_kind);
        let made = made.collect();
        progress.step();
        made
    };
    Ok(logs.par_iter().enumerate().flat_map(of_log).collect())
}

fn figure(
    (index, log): (usize, &str),
    kind: Kind,
    runs: &[&Drawn<'_>],
    color: &dyn Fn(&Drawn<'_>) -> Color,
    every: usize,
) -> Figure {
    let (name, what) = match kind {
        Kind::Thrust => ("thrust", "Thrust (N)"),
        Kind::GroundEffect => ("ground-effect", "Ground-effect force (N)"),
    };
    let mut above = Panel::new("Time (s)", what);
    let first = runs[0];
    let rows: Vec<usize> = (0..first.time_s.len())
        .filter(|&i| first.measured_n[i].is_finite())
        .step_by(every)
        .collect();
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    above = above.series(
        Series::line("measured", &pick(first.time_s), &pick(first.measured_n)).color(MEASURED),
    );
    if let Some(truth) = first.truth_n {
        let (time, truth) = (thin(first.time_s, every), thin(truth, every));
        above = above.series(Series::dashed("truth", &time, &truth).color(TRUTH));
    }
    let to = if first.truth_n.is_some() {
        "truth"
    } else {
        "measured"
    };
    let start = match (kind, first.truth_n) {
        (Kind::GroundEffect, Some(_)) => "the true force",
        _ => "what is measured in the first moments",
    };
    let mut below = Panel::new("Time (s)", format!("Predicted − {to} (N)"));
    for run in runs {
        let reference = run.truth_n.unwrap_or(run.measured_n);
        let (time, error): (Vec<f64>, Vec<f64>) = (0..run.time_s.len())
            .filter(|&i| reference[i].is_finite())
            .step_by(every)
            .map(|i| (run.time_s[i], run.predicted_n[i] - reference[i]))
            .unzip();
        let color = color(run);
        above = above.series(
            Series::line(
                run.card,
                &thin(run.time_s, every),
                &thin(run.predicted_n, every),
            )
            .color(color),
        );
        below = below.series(Series::line("", &time, &error).color(color));
    }
    Figure::new(
        format!("{:03}-{}-{name}", index + 1, slug(log)),
        log.to_string(),
    )
    .caption(format!(
        "Free run of the models, started from {start}, never corrected by what is measured after; below, the error against the {to}.{}",
        if every > 1 {
            format!(" One in {every} samples is shown.")
        } else {
            String::new()
        }
    ))
    .share_x()
    .panel(above)
    .panel(below.series(Series::horizontal("", 0.0)))
}

/// One in `every` values.
fn thin(values: &[f64], every: usize) -> Vec<f64> {
    values.iter().copied().step_by(every).collect()
}

/// The report.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn report(overview: &Overview<'_>, figures: &[Figure]) -> Result<Report> {
    let mut report = page::report("Validation", "Models in free run on logs");
    let (kind, verdict) = verdict(overview);
    report.verdict(kind, verdict);
    if let Some(first) = figures.first() {
        report.figure(first)?;
    }
    report.section("Errors");
    let mut table = Table::new("Errors in newtons.");
    for (i, name) in overview.header.iter().enumerate() {
        table = if i < WORDS {
            table.text_column(name)
        } else {
            table.number_column(name, "")
        };
    }
    for row in overview.rows {
        table = table.row(row.iter().map(Cell::text));
    }
    page::put_table(&mut report, table)?;
    for warning in overview.warnings {
        report.callout(Callout::Warning, warning);
    }
    if figures.len() > 1 {
        report.section("More free runs");
    }
    for figure in figures.iter().skip(1) {
        report.figure(figure)?;
    }
    page::how_made(&mut report, overview.command, None)?;
    Ok(report)
}

/// The card with the smallest error on its unseen logs.
fn verdict(overview: &Overview<'_>) -> (Callout, String) {
    // Cards, seen and the mean absolute error stand at the head of each row; a last row of each card is over all its logs.
    let unseen = overview.rows.iter().filter(|row| row[3] != "yes");
    let judged = unseen.filter_map(|row| Some((row, row[WORDS].parse::<f64>().ok()?)));
    let mut of_cards: Vec<(&str, &str, f64)> = Vec::new();
    for (row, mae_n) in judged {
        of_cards.retain(|(card, ..)| *card != row[0]);
        of_cards.push((&row[0], &row[2], mae_n));
    }
    let best = of_cards.iter().min_by(|a, b| a.2.total_cmp(&b.2));
    let Some((card, log, mae_n)) = best else {
        return (
            Callout::Warning,
            "No log is unseen by a card; all errors are those on training data.".into(),
        );
    };
    let rank = match of_cards.len() {
        1 => format!("`{card}` predicts"),
        n => format!("Of {n} cards, `{card}` predicts best:"),
    };
    let found = match of_cards.len() {
        1 => format!(
            "{rank} `{log}` with a mean absolute error of {} N in free run.",
            page::show(*mae_n, 3)
        ),
        _ => format!(
            "{rank} its mean absolute error in free run is {} N on `{log}`.",
            page::show(*mae_n, 3)
        ),
    };
    let kind = if overview.warnings.is_empty() {
        Callout::Success
    } else {
        Callout::Warning
    };
    (
        kind,
        format!(
            "{found}{}",
            super::identify::remarks(overview.warnings.len())
        ),
    )
}
