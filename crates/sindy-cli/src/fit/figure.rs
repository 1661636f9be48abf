//! The figure of a fit: terms against error, data against the model's free run, residual slopes.

use std::path::Path;

use sindy::Model;
use touchdown_report::{Callout, Cell, Color, Figure, Panel, Report, Series, Table};

use super::object::{FitObject, Front, TermObject};
use super::score::Test;
use super::show;
use crate::drawing;
use crate::error::Result;
use crate::named::Named;
use crate::numbers::significant;
use crate::simulate::figure::course;
use crate::simulate::object::{RunObject, VALID};

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
    let mut figure = front(&object.front);
    let Some(judged) = judged else {
        return figure;
    };
    figure.title = "Terms against error (large: chosen), free run, residual slopes".to_owned();
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
    let judged = test.or(fitted);
    let (kind, verdict) = verdict(model, object, judged);
    page.verdict(kind, verdict);
    match judged.and_then(|judged| judged.runs.first()) {
        Some(run) => page.figure(&course(model, run, 1))?,
        None => page.figure(&front(&object.front))?,
    };
    page.section("Model").code(format!("{model:.5}"));
    page.table(coefficients(&object.equations))?;
    for warning in &object.warnings {
        page.callout(Callout::Warning, warning);
    }
    page.folded("Terms, choice and data as text", |inner| {
        inner.code(show::text(model, object));
        Ok::<(), touchdown_report::Error>(())
    })?;
    if judged.is_some() {
        page.section("Terms against error")
            .figure(&front(&object.front))?;
    }
    for (title, part) in [("Training", fitted), ("Test", test)] {
        let Some(part) = part else { continue };
        page.section(title);
        let shown = judged.is_some_and(|judged| std::ptr::eq(judged, part));
        trajectory(&mut page, model, part, 0, shown)?;
        if part.runs.len() > 1 {
            page.folded("More trajectories", |inner| {
                (1..part.runs.len()).try_for_each(|i| trajectory(inner, model, part, i, false))
            })?;
        }
    }
    Ok(page)
}

/// The table of coefficients.
pub(crate) fn coefficients(equations: &Named<Vec<TermObject>>) -> Table {
    let [state, term, numbers @ ..] = show::COEFFICIENTS;
    let mut table = Table::new("Coefficients.")
        .text_column(state)
        .text_column(term);
    for name in numbers {
        table = table.number_column(name, "");
    }
    for row in show::coefficient_rows(equations) {
        let cells = row.into_iter().enumerate();
        table = table.row(cells.map(|(column, cell)| match cell.as_str() {
            "-" => Cell::missing(),
            number if column > 1 => number.replace('-', "−").into(),
            _ => cell.into(),
        }));
    }
    table.note(
        "±: standard error. Inclusion: the share of resamplings (bootstrap) that keep the term.",
    )
}

/// The free run of a trajectory, where it is not `shown` already, and its residual slopes.
fn trajectory(
    page: &mut Report,
    model: &Model,
    part: &Test,
    index: usize,
    shown: bool,
) -> touchdown_report::Result<()> {
    if let Some(run) = part.runs.get(index).filter(|_| !shown) {
        page.figure(&course(model, run, index + 1))?;
    }
    if part.slopes.get(index).is_some_and(Option::is_some) {
        page.figure(&residuals(model, part, index))?;
    }
    Ok(())
}

/// Equations of more letters than this are counted in the verdict instead of quoted.
const QUOTED: usize = 160;

/// The equations, and how well their free run predicts.
fn verdict(model: &Model, object: &FitObject, judged: Option<&Test>) -> (Callout, String) {
    let equations = format!("{model:.4}");
    let lines: Vec<String> = equations.lines().map(|line| format!("`{line}`")).collect();
    let terms: usize = object.equations.iter().map(|(_, terms)| terms.len()).sum();
    let found = match equations.len() {
        0..=QUOTED => format!("The data follow {}.", lines.join(" and ")),
        _ => format!(
            "{} equations with {terms} terms in all describe the data.",
            model.states().len()
        ),
    };
    let free_runs = judged.iter().flat_map(|judged| &judged.object.free_run);
    let worst = RunObject::worst_error(free_runs.map(|free| &free.run));
    let predicts = match worst {
        Some((error, state)) => format!(
            " In free run from the first row, without corrections, the error is at most {} % of the standard deviation (`{state}`).",
            significant(100.0 * error, 2)
        ),
        None => String::new(),
    };
    let doubts = match object.warnings.len() {
        0 => String::new(),
        1 => " One warning below qualifies this.".into(),
        n => format!(" {n} warnings below qualify this."),
    };
    let predicted = worst.is_none_or(|(error, _)| error < VALID);
    let kind = if predicted && object.warnings.is_empty() {
        Callout::Success
    } else {
        Callout::Warning
    };
    (kind, format!("{found}{predicts}{doubts}"))
}

/// Terms against error.
pub(crate) fn front(fronts: &Named<Front>) -> Figure {
    let mut panel = Panel::new("terms", "error").log_y();
    for (i, (state, front)) in fronts.iter().enumerate() {
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
        format!("{name}: residual slopes"),
    )
    .caption("Slope of the smoothed data minus slope of the model.")
    .share_x();
    if let Some(Some(slopes)) = judged.slopes.get(run) {
        for (i, state) in model.states().iter().enumerate() {
            let both = slopes.measured[i].iter().zip(&slopes.modelled[i]);
            let left: Vec<f64> = both.map(|(a, b)| a - b).collect();
            let panel = Panel::new("time", format!("{state}', data - model"))
                .series(Series::line("", &slopes.time, &left).color(Color::Cycle(i)))
                .series(Series::horizontal("", 0.0));
            figure = figure.panel(panel);
        }
    }
    figure
}
