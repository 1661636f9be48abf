//! The figure of a fit: terms against error, data against the model's free run, slopes that are left.

use std::path::Path;

use sindy::Model;
use touchdown_report::{Color, Figure, Panel, Report, Series};

use super::object::FitObject;
use super::score::Test;
use super::show;
use crate::drawing;
use crate::error::Result;
use crate::simulate::figure::course;

/// Writes the figure: a page of all, or one picture of the front and the first trajectory (a test one if there is). Training
/// trajectories that are not in memory are left out.
pub(super) fn write(
    path: &Path,
    model: &Model,
    object: &FitObject,
    fitted: Option<&Test>,
    test: Option<&Test>,
) -> Result<()> {
    drawing::write(
        path,
        || picture(model, object, test.or(fitted)),
        || page(model, object, fitted, test),
    )
}

fn picture(model: &Model, object: &FitObject, judged: Option<&Test>) -> Figure {
    let mut figure = front(object);
    let Some(judged) = judged else {
        return figure;
    };
    figure.title = "Terms against error (large: chosen), free run, slopes left".to_owned();
    if let Some(run) = judged.runs.first() {
        figure.panels.extend(course(model, run, 1).panels);
    }
    figure.panels.extend(residuals(model, judged, 0).panels);
    figure
}

fn page(
    model: &Model,
    object: &FitObject,
    fitted: Option<&Test>,
    test: Option<&Test>,
) -> touchdown_report::Result<Report> {
    let mut page = Report::new("Identification");
    page.fact("sindy", object.version);
    page.section("Model").code(show::text(model, object));
    page.section("Terms against error").figure(&front(object))?;
    for (title, judged) in [("Training", fitted), ("Test", test)] {
        let Some(judged) = judged else { continue };
        page.section(title);
        for (i, run) in judged.runs.iter().enumerate() {
            page.figure(&course(model, run, i + 1))?;
            page.figure(&residuals(model, judged, i))?;
        }
    }
    Ok(page)
}

fn front(object: &FitObject) -> Figure {
    let mut panel = Panel::new("terms", "error").log_y();
    for (i, (state, front)) in object.front.iter().enumerate() {
        let part = |chosen: bool| -> (Vec<f64>, Vec<f64>) {
            let points = front.points.iter().filter(|p| p.chosen || !chosen);
            points.map(|p| (p.terms as f64, p.error)).unzip()
        };
        let ((terms, errors), chosen) = (part(false), part(true));
        panel = panel
            .series(Series::lines_points(state, &terms, &errors).color(Color::Cycle(i)))
            .series(
                Series::points("", &chosen.0, &chosen.1)
                    .color(Color::Cycle(i))
                    .width(4.0),
            );
    }
    Figure::new("front", "Terms against error")
        .caption("The best equation of each number of terms; large points are the model's.")
        .panel(panel)
}

/// Slope of the data minus that of the model.
fn residuals(model: &Model, judged: &Test, run: usize) -> Figure {
    let name = judged.runs.get(run).map_or("", |r| r.task.name.as_str());
    let mut figure = Figure::new(
        format!("residual-{}", run + 1),
        format!("{name}: slopes left"),
    )
    .caption("Slope of the smoothed data minus slope of the model.")
    .share_x();
    if let Some(Some(slopes)) = judged.slopes.get(run) {
        for (i, state) in model.states().iter().enumerate() {
            let both = slopes.measured[i].iter().zip(&slopes.modelled[i]);
            let left: Vec<f64> = both.map(|(a, b)| a - b).collect();
            let panel = Panel::new("time", format!("{state}', data - model"))
                .series(Series::line("", &slopes.time, &left))
                .series(Series::horizontal("", 0.0));
            figure = figure.panel(panel);
        }
    }
    figure
}
