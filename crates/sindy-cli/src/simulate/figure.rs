//! Figures of runs: each state over time, measured and simulated.

use std::path::Path;

use sindy::Model;
use touchdown_report::{Color, Figure, Panel, Report, Series};

use super::Simulated;
use crate::drawing;
use crate::error::Result;

/// Measurements stand behind everything else.
const MEASURED: Color = Color::Rgb(0xB8, 0xBE, 0xC6);

/// Writes the figure: all runs on a page, the first one in a picture.
pub(crate) fn write(path: &Path, model: &Model, simulated: &[Simulated]) -> Result<()> {
    drawing::write(
        path,
        || {
            simulated
                .first()
                .map_or_else(|| Figure::new("run", "No run"), |s| course(model, s, 1))
        },
        || {
            let mut page = Report::new("Simulation");
            page.section("Model").code(format!("{model:.5}"));
            page.section("Runs");
            for (i, s) in simulated.iter().enumerate() {
                page.figure(&course(model, s, i + 1))?;
            }
            Ok(page)
        },
    )
}

/// Each state over time.
pub(crate) fn course(model: &Model, simulated: &Simulated, number: usize) -> Figure {
    let Simulated { task, run } = simulated;
    let mut figure = Figure::new(format!("run-{number}"), task.name.clone())
        .caption("The model runs freely from the first row.")
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
