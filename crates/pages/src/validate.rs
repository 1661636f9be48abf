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

/// Columns of words at the head of the tables of errors: card, form, log, seen.
const WORDS: usize = 4;
/// That of the log, or of how many logs.
const LOG: usize = 2;
/// That of whether the log was part of the fit.
const SEEN: usize = 3;

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
    /// The force without noise (N), where it is known.
    pub truth_n: Option<&'a [f64]>,
    /// Predicted (N).
    pub predicted_n: &'a [f64],
}

/// The verdict at the head of the report.
#[derive(Clone, Copy, Debug)]
pub struct Overview<'a> {
    /// The command that redoes it.
    pub command: &'a str,
    /// Head of the tables of errors.
    pub header: &'a [String],
    /// Errors of each card on each log.
    pub rows: &'a [Vec<String>],
    /// Errors of each card over all logs that it has not seen.
    pub pooled_rows: &'a [Vec<String>],
    /// The cards, for the verdict.
    pub cards: &'a [UnseenError],
    /// What a reader should know.
    pub warnings: &'a [String],
    /// Head of the table of armed intervals.
    pub factors_header: &'a [&'a str],
    /// Scale and height offset of each armed interval of a flight.
    pub factors: &'a [Vec<String>],
}

/// The error of a card over the logs that it has not seen.
#[derive(Clone, Debug)]
pub struct UnseenError {
    /// The card's file.
    pub card: String,
    /// What it models.
    pub kind: Kind,
    /// The number of logs.
    pub logs: usize,
    /// Mean absolute error against the measurement (N).
    pub mae_n: Option<f64>,
    /// The measurement's own (N), where the truth is known.
    pub noise_mae_n: Option<f64>,
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
        _ => "the first measurements",
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
        "Free run of the models: each starts from {start}, and no measurement corrects it. Below: its error against the {to}.{}",
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
    if let Some(first) = overview.pooled_rows.first() {
        let caption = match common(overview.pooled_rows, LOG) {
            true => format!("Errors over {} logs.", first[LOG]),
            false => "Errors over all logs that a card has not seen.".to_owned(),
        };
        report.table(errors(&caption, overview.header, overview.pooled_rows))?;
    }
    let seen = match overview.rows {
        [first, ..] if common(overview.rows, SEEN) => match first[SEEN].as_str() {
            "yes" => " All of them were part of the cards' fits.",
            "no" => " None of them was part of a card's fit.",
            _ => " The cards do not say which logs they were fitted to.",
        },
        _ => "",
    };
    let caption = format!("Errors on each log.{seen}");
    let of_logs = errors(&caption, overview.header, overview.rows);
    page::put_table(&mut report, of_logs)?;
    if !overview.factors.is_empty() {
        page::put_table(&mut report, factors(overview))?;
    }
    for warning in overview.warnings {
        report.callout(Callout::Warning, warning);
    }
    page::folded_figures(
        &mut report,
        "Free runs on the other logs",
        figures.iter().skip(1),
    )?;
    page::how_made(&mut report, overview.command, None)?;
    Ok(report)
}

/// Remarks on columns of the tables of errors, each by the beginning of the column's name.
const REMARKS: [(&str, &str); 4] = [
    ("seen", "Seen: whether the log was part of the card's fit."),
    ("worst", "Worst: the largest absolute error."),
    (
        "MAE to truth",
        "Truth: the force without sensor noise and turbulence, which a virtual rig knows.",
    ),
    ("noise", "Noise: the error of the measurement itself."),
];

/// Whether several rows have one value in a column.
fn common(rows: &[Vec<String>], column: usize) -> bool {
    rows.len() > 1 && rows.iter().all(|row| row[column] == rows[0][column])
}

/// A table of errors. A name that ends in ` N` is that of a force. Where all rows have the same log, or all were seen or
/// unseen, the caption says so and the column is left out.
fn errors(caption: &str, header: &[String], rows: &[Vec<String>]) -> Table {
    let stated = |column: &usize| (LOG..=SEEN).contains(column) && common(rows, *column);
    let shown: Vec<usize> = (0..header.len()).filter(|c| !stated(c)).collect();
    let mut table = Table::new(caption);
    for &i in &shown {
        let name = &header[i];
        table = match name.strip_suffix(" N") {
            _ if i < WORDS => table.text_column(name),
            Some(name) => table.number_column(name, "N"),
            None => table.number_column(name, ""),
        };
    }
    for row in rows {
        table = table.row(shown.iter().map(|&i| Cell::text(&row[i])));
    }
    let has = |start: &str| shown.iter().any(|&i| header[i].starts_with(start));
    let remarks = REMARKS.iter().filter(|(start, _)| has(start));
    table.note(
        remarks
            .map(|(_, remark)| *remark)
            .collect::<Vec<_>>()
            .join(" "),
    )
}

/// The table of armed intervals.
fn factors(overview: &Overview<'_>) -> Table {
    let mut table = Table::new(
        "Armed intervals of flights. The least square error gives thrust scale and height offset, but those that were held.",
    );
    for name in overview.factors_header {
        table = table.text_column(*name);
    }
    for row in overview.factors {
        table = table.row(row.iter().map(Cell::text));
    }
    table
}

/// Which card of each kind has the smallest error on the logs that it has not seen.
fn verdict(overview: &Overview<'_>) -> (Callout, String) {
    let kinds = [
        (Kind::Thrust, "thrust"),
        (Kind::GroundEffect, "ground-effect"),
    ];
    let best =
        kinds.map(|(kind, name)| best(name, overview.cards.iter().filter(|c| c.kind == kind)));
    let sentences: Vec<String> = best.into_iter().flatten().collect();
    if sentences.is_empty() {
        return (
            Callout::Warning,
            "No log is unseen by a card; all errors are those on training data.".into(),
        );
    }
    let kind = if overview.warnings.is_empty() {
        Callout::Success
    } else {
        Callout::Warning
    };
    let remarks = super::identify::remarks(overview.warnings.len());
    (kind, format!("{}{remarks}", sentences.join(" ")))
}

/// The card with the smallest error, in a sentence.
fn best<'a>(kind: &str, cards: impl Iterator<Item = &'a UnseenError>) -> Option<String> {
    let judged: Vec<(&UnseenError, f64)> = cards.filter_map(|c| Some((c, c.mae_n?))).collect();
    let (card, mae_n) = judged.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let rank = match judged.len() {
        1 => format!("`{}` predicts the {kind} force:", card.card),
        n => format!("Of {n} {kind} cards, `{}` predicts best:", card.card),
    };
    let noise = card.noise_mae_n.map_or_else(String::new, |noise_n| {
        format!(" The sensor's noise alone is {} N.", page::show(noise_n, 3))
    });
    Some(format!(
        "{rank} its mean absolute error in free run is {} N over {}.{noise}",
        page::show(*mae_n, 3),
        page::count(card.logs, "unseen log")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_words_that_all_rows_share_are_no_column() {
        let words = |row: &[&str]| -> Vec<String> { row.iter().map(ToString::to_string).collect() };
        let header = words(&["card", "form", "log", "seen", "MAE N", "noise MAE N"]);
        let rows = [
            words(&["lag.toml", "lag", "all 35 unseen", "no", "0.08", "0.07"]),
            words(&[
                "static.toml",
                "static",
                "all 35 unseen",
                "no",
                "0.09",
                "0.07",
            ]),
        ];
        let table = errors("Errors.", &header, &rows);
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["card", "form", "MAE", "noise MAE"]);
        assert_eq!(table.rows[1][2].shown(), "0.09");
        assert_eq!(table.notes, ["Noise: the error of the measurement itself."]);
        // A single row keeps its words.
        assert_eq!(errors("Errors.", &header, &rows[..1]).columns.len(), 6);
    }
}
