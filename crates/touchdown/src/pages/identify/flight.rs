//! The report of a ground effect from flights.

use touchdown_report::{Callout, Cell, Color, Figure, Panel, Report, Series, Table};

use super::{Overview, card_blocks, slug};
use crate::error::Result;
use crate::identify::Made;
use crate::identify::flight::result::FlightResult;
use crate::identify::flight::{Basis, Flight, GroundEffect};
use crate::pages::page::show;

/// Logs drawn over time at most.
const DRAWN: usize = 8;
/// Heights drawn, in R.
const HIGHEST: f64 = 8.0;

/// Residual over height with the curve and its band; then each log with what was used of it.
#[must_use]
pub fn figures(flights: &[Flight], found: &GroundEffect, result: &FlightResult) -> Vec<Figure> {
    let mut out = vec![over_height(flights, found, result)];
    out.extend(over_lag(found));
    let residuals = found.fit.residuals(&found.pieces);
    for (index, flight) in flights.iter().enumerate().take(DRAWN) {
        out.push(match found.basis {
            Basis::Hovers { .. } => hovers_over_time(index, flight, found),
            _ => over_time(index, flight, found, &residuals),
        });
    }
    out
}

fn over_height(flights: &[Flight], found: &GroundEffect, result: &FlightResult) -> Figure {
    let r = found.rotor_radius_m;
    let values = found.fit.values();
    let runs = found.fit.predict(&found.pieces);
    let mut panel = Panel::new("Height (m)", "Thrust over free air − 1");
    for (index, flight) in flights.iter().enumerate() {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        let of_flight = found.pieces.iter().zip(&runs).zip(&found.fit.locals);
        for ((piece, run), local) in of_flight.filter(|((p, _), _)| p.flight == index) {
            for (&i, modelled) in piece.rows.iter().zip(run) {
                let z = piece.height[i] + local.bias;
                if z < HIGHEST {
                    // The curve at rest, and what the whole model leaves of the measured force.
                    x.push(z * r);
                    y.push(values.at_rest(z) + piece.force[i] / modelled - 1.0);
                }
            }
        }
        let dots = Series::points(&flight.name, &x, &y)
            .color(Color::Cycle(index))
            .width(if found.hovers.is_empty() { 0.8 } else { 4.0 });
        panel = panel.series(dots);
    }
    let x: Vec<f64> = result.ratio.iter().map(|a| a.height_m).collect();
    let of = |f: fn(&crate::identify::flight::spread::Sure) -> f64| -> Vec<f64> {
        result.ratio.iter().map(|a| f(&a.ratio)).collect()
    };
    panel = panel
        .series(Series::band(
            "95 % interval",
            &x,
            &of(|s| s.ci95[0]),
            &of(|s| s.ci95[1]),
        ))
        .series(Series::line(result.curve, &x, &of(|s| s.value)).color(Color::BLACK));
    let hovers = "Thrust over that out of ground effect, at each hover at rest, each flight in its colour, with the static curve and its \
                  95 % interval. Drift and each run's own scale and height error are taken off.";
    let caption = if found.hovers.is_empty() {
        "Specific force over what the model has of it out of ground effect, each flight in its colour, with the static \
         curve and its 95 % interval. Motors, drift, climb and each run's own scale and height error are taken off."
    } else {
        hovers
    };
    Figure::new("residual-over-height", "Ground effect over height")
        .caption(caption)
        .panel(panel)
}

/// Error over lags; none where there is none to look for.
fn over_lag(found: &GroundEffect) -> Option<Figure> {
    let profiles = found.lag_profiles();
    if profiles.is_empty() {
        return None;
    }
    let mut figure = Figure::new("error-over-lag", "Lags").caption(
        "Root mean square error of the specific force over the lag of the motors and over that of the wake, all else fitted to each; \
         the dashed lines are the fitted lag and its 95 % interval. Where the wake's has none, it was refused: the error hardly knows it.",
    );
    for (index, profile) in profiles.iter().enumerate() {
        let mg: Vec<f64> = profile.rmse.iter().map(|r| 1e3 * r).collect();
        let mut panel = Panel::new(format!("Lag of the {} (s)", profile.name), "Error (mg)")
            .series(Series::line("", &profile.lag_s, &mg).color(Color::Cycle(index)));
        let sure = match profile.name {
            "motors" => found.spread.number(&found.fit, "T_m"),
            _ => found.lag_s(),
        };
        if let Some(sure) = sure.filter(|_| profile.taken) {
            for (x, name, color) in [
                (sure.value, "fitted", Color::BLACK),
                (sure.ci95[0], "95 % interval", Color::GREY),
                (sure.ci95[1], "", Color::GREY),
            ] {
                panel = panel.series(Series::vertical(name, x).color(color));
            }
        }
        figure = figure.panel(panel);
    }
    Some(figure)
}

/// Where the time axis of a log begins: at its own zero, or at its start where stamps are those of a calendar (s).
fn origin_s(flight: &Flight) -> f64 {
    const CALENDAR_S: f64 = 1e6;
    let first = flight.time_s.first().copied().unwrap_or(0.0);
    if first.abs() > CALENDAR_S { first } else { 0.0 }
}

fn since(origin_s: f64, time_s: &[f64]) -> Vec<f64> {
    time_s.iter().map(|t| t - origin_s).collect()
}

/// A log over time with its hovers.
fn hovers_over_time(index: usize, flight: &Flight, found: &GroundEffect) -> Figure {
    let origin_s = origin_s(flight);
    let t = &since(origin_s, &flight.time_s);
    let mut throttle = Panel::new("Time (s)", "Throttle")
        .series(Series::line("logged", t, &flight.throttle).color(Color::GREY));
    let mut height = Panel::new("Time (s)", "Height (m)")
        .series(Series::line("", t, &flight.height_m).color(Color::GREY));
    let mut ratio = Panel::new("Time (s)", "Thrust over free air");
    let mut name = "hovers used";
    for h in found.hovers.iter().filter(|h| h.flight == index) {
        let x = [h.from_s - origin_s, h.to_s - origin_s];
        let bar = |name: &str, y: f64| {
            Series::line(name, &x, &[y, y])
                .color(Color::Cycle(index))
                .width(3.0)
        };
        throttle = throttle.series(bar(name, h.throttle));
        height = height.series(bar("", h.height_m));
        ratio = ratio.series(bar("", h.ratio));
        name = "";
    }
    Figure::new(
        format!("flight-{:02}-{}", index + 1, slug(&flight.name)),
        format!("{} over time", flight.name),
    )
    .caption("Throttle and height, with the hovers at rest that were used in colour; below, the ratio of thrusts at each.")
    .share_x()
    .panel(throttle)
    .panel(height)
    .panel(ratio.series(Series::horizontal("", 1.0)))
}

fn over_time(
    index: usize,
    flight: &Flight,
    found: &GroundEffect,
    residuals: &[Vec<f64>],
) -> Figure {
    let origin_s = origin_s(flight);
    let t = &since(origin_s, &flight.time_s);
    let mut throttle = Panel::new("Time (s)", "Throttle")
        .series(Series::line("logged", t, &flight.throttle).color(Color::GREY));
    let mut height = Panel::new("Time (s)", "Height (m)")
        .series(Series::line("", t, &flight.height_m).color(Color::GREY));
    let mut left = Panel::new("Time (s)", "Measured − model (g)");
    for (piece, residual) in found
        .pieces
        .iter()
        .zip(residuals)
        .filter(|(p, _)| p.flight == index)
    {
        // Where rows are missing the line breaks.
        let n = piece.time_s.len();
        let mut used = [vec![f64::NAN; n], vec![f64::NAN; n], vec![f64::NAN; n]];
        for (&i, r) in piece.rows.iter().zip(residual) {
            used[0][i] = piece.throttle[i] * found.hover_throttle;
            used[1][i] = piece.height[i] * found.rotor_radius_m;
            used[2][i] = *r;
        }
        let name = format!("used, run {}", piece.run + 1);
        let line = |name: &str, y: &[f64]| {
            Series::line(name, &since(origin_s, &piece.time_s), y).color(Color::Cycle(index))
        };
        throttle = throttle.series(line(&name, &used[0]));
        height = height.series(line("", &used[1]));
        left = left.series(line("", &used[2]));
    }
    Figure::new(format!("flight-{:02}-{}", index + 1, slug(&flight.name)), format!("{} over time", flight.name))
        .caption("Throttle and height, with what was used in colour; below, what the model leaves of the specific force.")
        .share_x()
        .panel(throttle)
        .panel(height)
        .panel(left.series(Series::horizontal("", 0.0)))
}

/// The report.
///
/// # Errors
/// A figure or table that cannot be drawn.
pub fn report(
    overview: &Overview<'_>,
    result: &FlightResult,
    cards: &[&Made],
    figures: &[Figure],
) -> Result<Report> {
    let mut report = overview.begin()?;
    report.section("Ground effect");
    report.paragraph(format!("Identified from {}.", result.basis.name()));
    let (of_logs, first): (Vec<&Figure>, Vec<&Figure>) =
        figures.iter().partition(|f| f.id.starts_with("flight-"));
    for figure in first {
        report.figure(figure)?;
    }
    let mut table = Table::new("Numbers of the model, with 95 % intervals.")
        .text_column("number")
        .number_column("value", "")
        .number_column("standard error", "")
        .number_column("95 % interval", "")
        .text_column("unit");
    for n in &result.numbers {
        let [low, high] = n.sure.ci95;
        table = table.row([
            Cell::text(n.name.replace('_', " ")),
            Cell::number(n.sure.value, 4),
            Cell::number(n.sure.std_error, 4),
            Cell::text(format!("{} … {}", show(low, 4), show(high, 4))),
            Cell::text(&n.unit),
        ]);
    }
    report.table(table.note(format!(
        "Intervals from {} {}, Student's t.",
        result.blocks,
        result.intervals_from.name()
    )))?;
    report.section("Not identified");
    if result.refused.is_empty() {
        report.paragraph("Nothing that was asked of the logs was refused.");
    }
    for r in &result.refused {
        report.callout(
            Callout::Warning,
            format!("{}: {}. To record: {}.", r.what, r.found, r.record),
        );
    }
    report.section("Models tried");
    let mut table = Table::new("Root mean square error of the specific force on flights left out.")
        .text_column("model")
        .number_column("all rows", "mg")
        .number_column("in ground effect", "mg")
        .text_column("taken");
    for c in &result.tried {
        table = table.row([
            Cell::text(&c.name),
            Cell::number(1e3 * c.rmse, 3),
            Cell::maybe(c.rmse_near.map(|r| 1e3 * r), 3),
            Cell::text(if c.chosen { "last" } else { "" }),
        ]);
    }
    report.table(table.note(
        "Each model has what those taken before it have. A richer one is taken if it does better by more than one standard \
         error of the difference between flights.",
    ))?;
    report.section("Flights");
    let mut table = Table::new("Runs of the motors.")
        .text_column("log")
        .number_column("on", "s")
        .number_column("off", "s")
        .number_column("stood at", "m")
        .number_column("rows used", "")
        .number_column("thrust scale", "")
        .number_column("height error", "m");
    for r in &result.runs {
        table = table.row([
            Cell::text(&r.log),
            Cell::maybe(r.run.on_s, 2),
            Cell::maybe(r.run.off_s, 2),
            Cell::maybe(r.run.stood_m, 3),
            Cell::count(r.rows_used),
            Cell::maybe(r.thrust_scale, 4),
            Cell::maybe(r.height_error_m, 4),
        ]);
    }
    report.table(table)?;
    for figure in of_logs {
        report.figure(figure)?;
    }
    if !result.hovers.is_empty() {
        let mut table = Table::new("Hovers at rest, and thrust over that out of ground effect.")
            .text_column("log")
            .number_column("from", "s")
            .number_column("to", "s")
            .number_column("height", "m")
            .number_column("throttle", "")
            .number_column("ratio", "");
        for h in &result.hovers {
            table = table.row([
                Cell::text(&h.log),
                Cell::number(h.from_s, 2),
                Cell::number(h.to_s, 2),
                Cell::number(h.height_m, 4),
                Cell::number(h.throttle, 4),
                Cell::number(h.ratio, 4),
            ]);
        }
        report.table(table)?;
    }
    report.subsection("Left out");
    let mut table = Table::new("Rows that were not used, and why.")
        .text_column("log")
        .number_column("from", "s")
        .number_column("to", "s")
        .text_column("why");
    for l in &result.left_out {
        table = table.row([
            Cell::text(&l.log),
            Cell::number(l.from_s, 2),
            Cell::number(l.to_s, 2),
            Cell::text(&l.why),
        ]);
    }
    report.table(table)?;
    report.section("Cards");
    for made in cards {
        report.subsection(&made.card.name);
        card_blocks(&mut report, made)?;
    }
    overview.end(&mut report);
    Ok(report)
}
