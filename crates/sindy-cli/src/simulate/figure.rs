//! Figures of runs: each state over time, measured and simulated.

use std::path::Path;

use sindy::Model;
use touchdown_report::{Callout, Color, Figure, Panel, Report, Series};

use super::Simulated;
use super::object::{RunObject, VALID};
use crate::drawing;
use crate::error::Result;
use crate::numbers::significant;

/// Measurements stand behind everything else.
const MEASURED: Color = Color::Rgb(0xB8, 0xBE, 0xC6);

/// Writes the figure: all runs on a page, the first one in a picture.
pub(crate) fn write(
    path: &Path,
    model: &Model,
    simulated: &[Simulated],
    runs: &[RunObject],
) -> Result<()> {
    drawing::write(
        path,
        || {
            simulated
                .first()
                .map_or_else(|| Figure::new("run", "No run"), |s| course(model, s, 1))
        },
        || {
            let mut page = Report::new("Simulation");
            page.fact("sindy", env!("CARGO_PKG_VERSION"));
            let (kind, verdict) = verdict(runs);
            page.verdict(kind, verdict);
            let mut figures = simulated.iter().enumerate();
            if let Some((i, first)) = figures.next() {
                page.figure(&course(model, first, i + 1))?;
            }
            page.section("Model").code(format!("{model:.5}"));
            if simulated.len() > 1 {
                page.folded("The other runs", |inner| {
                    figures.try_for_each(|(i, s)| inner.figure(&course(model, s, i + 1)).map(drop))
                })?;
            }
            Ok(page)
        },
    )
}

/// Whether all runs reach their ends, and how far they are from the measurement.
fn verdict(runs: &[RunObject]) -> (Callout, String) {
    let ended: Vec<&RunObject> = runs.iter().filter(|r| r.outcome != "finished").collect();
    let reached = match (runs, ended.as_slice()) {
        ([one], []) => match one.end {
            Some(end) => format!("The model runs to its end at time {}.", significant(end, 4)),
            None => "The model runs to its end.".to_owned(),
        },
        (_, []) => format!("All {} runs reach their ends.", runs.len()),
        ([one], _) => format!(
            "The run ends early at time {} ({}).",
            one.end.map_or("?".to_owned(), |end| significant(end, 4)),
            one.outcome.replace('_', " ")
        ),
        (_, ended) => format!("{} of {} runs end early.", ended.len(), runs.len()),
    };
    let worst = RunObject::worst_error(runs.iter());
    let error = worst.map_or_else(String::new, |(error, state)| {
        format!(
            " Its largest error is {} % of the standard deviation of the measured state (`{state}`).",
            significant(100.0 * error, 2)
        )
    });
    let kind = match worst {
        _ if !ended.is_empty() => Callout::Failure,
        Some((error, _)) if error > VALID => Callout::Warning,
        Some(_) => Callout::Success,
        None => Callout::Note,
    };
    (kind, format!("{reached}{error}"))
}

/// Each state over time.
pub(crate) fn course(model: &Model, simulated: &Simulated, number: usize) -> Figure {
    let Simulated { task, run } = simulated;
    let mut figure = Figure::new(format!("run-{number}"), task.name.clone())
        .caption("The model runs from the first row; no measurement corrects it.")
        .share_x();
    for (i, name) in model.states().iter().enumerate() {
        let mut panel = Panel::new("time", name.clone());
        if let Some(measured) = &task.measured {
            let measured = Series::line("measured", &task.time, &measured[i]);
            panel = panel.series(measured.color(MEASURED).width(3.0));
        }
        // A state has one colour in all figures.
        panel =
            panel.series(Series::line("model", &run.time, &run.states[i]).color(Color::Cycle(i)));
        figure = figure.panel(panel);
    }
    figure
}
