//! The report of a ground effect from flights.

use touchdown_identify::FittedCard;
use touchdown_identify::flights::hover::ThrustLaw;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::{Basis, Flight, GroundEffect, Refusal, Route};
use touchdown_identify::warning::Warning;
use touchdown_model::Form;
use touchdown_report::{Callout, Cell, Color, Figure, Panel, Report, Series, Table};

use super::{About, Overview, Shown, armed_intervals, card_blocks, parameters, slug};
use crate::colors::{FLIGHTS, INPUT, TRUTH, of_flight, of_form};
use crate::error::Result;
use crate::page::{folded_figures, put_table, show};

/// Logs drawn over time at most.
const DRAWN: usize = 8;
/// Heights drawn, in R.
const HIGHEST: f64 = 8.0;

/// The ground effect of flights.
#[derive(Clone, Copy, Debug)]
pub struct FlightFit<'a> {
    /// The flights.
    pub flights: &'a [Flight],
    /// The model.
    pub found: &'a GroundEffect,
    /// Its numbers, the routes to it, and what is not identified.
    pub result: &'a FlightResult,
    /// Its cards.
    pub cards: &'a [&'a FittedCard],
}

impl FlightFit<'_> {
    /// The report, with its figures.
    ///
    /// # Errors
    /// A figure or table that cannot be drawn.
    pub fn shown(&self, about: &About<'_>) -> Result<Shown> {
        let overview = Overview::of("Ground effect from flights", about);
        let figures = figures(self.flights, self.found, self.result);
        let report = report(&overview, self.result, self.cards, &figures)?;
        Ok(Shown { figures, report })
    }
}

/// What a person should know beside the warnings of the fit: `given` is whether a thrust card was given, `thrust` the
/// thrust card that the flights make.
#[must_use]
pub fn flight_warnings(
    result: &FlightResult,
    given: bool,
    of_logs: Vec<String>,
    thrust: Option<&FittedCard>,
) -> Vec<String> {
    let of_card = |route: &Route| {
        matches!(
            route.basis,
            Basis::Hovers {
                law: ThrustLaw::Card,
                ..
            }
        )
    };
    let mut all = Vec::new();
    if given && !result.routes.iter().any(of_card) {
        let why = "the thrust card is not used, because the logs have the specific force, measured or from poses";
        all.push(why.to_string());
    }
    all.extend(of_logs);
    match thrust {
        Some(thrust) => {
            // What the card of the ground effect says as well is said once.
            let once = |w: &&Warning| !matches!(w, Warning::ThrottleBetweenRows { .. });
            let own = thrust.warnings.iter().filter(once);
            all.extend(own.map(|w| format!("thrust card: {w}")));
        }
        None => all.push(
            "no thrust card: it needs the mass ([flight] mass_kg), the accelerometer and the motors' lag (throttle logged \
             fast enough)"
                .to_string(),
        ),
    }
    all
}

/// Residual over height with the curve and its band; then each log with what was used of it.
fn figures(flights: &[Flight], found: &GroundEffect, result: &FlightResult) -> Vec<Figure> {
    let mut out = vec![over_height(flights, found, result)];
    out.extend(over_lag(found));
    let residuals = found.fit.residuals(&found.pieces);
    for (index, flight) in flights.iter().enumerate().take(DRAWN) {
        let color = of_flight(index, flights.len());
        out.push(over_time(index, color, flight, found, &residuals));
    }
    out
}

fn over_height(flights: &[Flight], found: &GroundEffect, result: &FlightResult) -> Figure {
    let r = found.rotor_radius_m;
    let ratios = found.measured_ratios();
    let distinct = flights.len() <= FLIGHTS;
    let each = if distinct {
        ", each flight in its colour,"
    } else {
        ""
    };
    let mut panel = Panel::new("Height (m)", "Thrust over free air − 1");
    for (index, flight) in flights.iter().enumerate() {
        let ours = found.pieces.iter().zip(&ratios);
        let rows = ours.filter(|(p, _)| p.flight == index).flat_map(|(_, r)| r);
        let (x, y): (Vec<f64>, Vec<f64>) = rows
            .filter(|[z, _]| *z < HIGHEST)
            .map(|[z, ratio]| (z * r, *ratio))
            .unzip();
        let name = match (distinct, index) {
            (true, _) => flight.name.as_str(),
            (false, 0) => "measured",
            (false, _) => "",
        };
        let dots = Series::points(name, &x, &y)
            .color(of_flight(index, flights.len()))
            .width(if found.hovers.is_empty() { 0.8 } else { 4.0 });
        panel = panel.series(dots);
    }
    let x: Vec<f64> = result.ratio.iter().map(|a| a.height_m).collect();
    let of = |f: fn(&touchdown_identify::Estimate) -> f64| -> Vec<f64> {
        result.ratio.iter().map(|a| f(&a.ratio)).collect()
    };
    panel = panel
        .series(Series::band(
            "95 % interval",
            &x,
            &of(|s| s.ci95[0]),
            &of(|s| s.ci95[1]),
        ))
        .series(Series::line(result.curve, &x, &of(|s| s.value)).color(TRUTH));
    let caption = if found.hovers.is_empty() {
        format!(
            "Measured specific force relative to that of the model out of ground effect{each} with the static curve and its 95 % interval. \
             The effects of motors, drift and climb, and the scale and height error of each armed interval, are removed."
        )
    } else {
        format!(
            "Thrust relative to that out of ground effect at each hover at rest{each} with the static curve and its 95 % interval. Drift, \
             and the scale and height error of each armed interval, are removed."
        )
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
        "Root mean square error of the specific force over the lag of the motors and over that of the wake, all else fitted to each. \
         Dashed lines: the fitted lag and its 95 % interval. A wake without them has no identified lag: the error hardly depends on it.",
    );
    for profile in &profiles {
        let mg: Vec<f64> = profile.rmse.iter().map(|r| 1e3 * r).collect();
        let (form, sure) = match profile.name {
            "motors" => (Form::LaggedMotors, found.spread.number(&found.fit, "T_m")),
            _ => (Form::Lag, found.lag_s()),
        };
        let mut panel = Panel::new(format!("Lag of the {} (s)", profile.name), "Error (mg)")
            .series(Series::line("", &profile.lag_s, &mg).color(of_form(form)));
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

/// Stretches of a log that were used, or a hover: stamps, throttle, height and what is drawn below.
struct Used {
    name: String,
    color: Color,
    time_s: Vec<f64>,
    throttle: Vec<f64>,
    height_m: Vec<f64>,
    below: Vec<f64>,
}

/// The hovers of a log, with the ratio of thrusts.
fn hovers(index: usize, color: Color, found: &GroundEffect) -> Vec<Used> {
    let ours = found.hovers.iter().filter(|h| h.flight == index);
    ours.enumerate()
        .map(|(k, h)| Used {
            name: if k == 0 { "hovers used" } else { "" }.into(),
            color,
            time_s: vec![h.from_s, h.to_s],
            throttle: vec![h.throttle; 2],
            height_m: vec![h.height_m; 2],
            below: vec![h.ratio; 2],
        })
        .collect()
}

/// The runs of a log, with the residual of the specific force.
fn runs_used(
    index: usize,
    color: Color,
    found: &GroundEffect,
    residuals: &[Vec<f64>],
) -> Vec<Used> {
    let all = found.pieces.iter().zip(residuals);
    all.filter(|(piece, _)| piece.flight == index)
        .map(|(piece, residual)| {
            // Where rows are missing the line breaks.
            let gaps = || vec![f64::NAN; piece.time_s.len()];
            let mut used = Used {
                name: if piece.run == 0 { "used" } else { "" }.into(),
                color,
                time_s: piece.time_s.clone(),
                throttle: gaps(),
                height_m: gaps(),
                below: gaps(),
            };
            for (&i, r) in piece.rows.iter().zip(residual) {
                used.throttle[i] = piece.throttle[i] * found.hover_throttle;
                used.height_m[i] = piece.height[i] * found.rotor_radius_m;
                used.below[i] = *r;
            }
            used
        })
        .collect()
}

/// A log over time with what was used of it.
fn over_time(
    index: usize,
    color: Color,
    flight: &Flight,
    found: &GroundEffect,
    residuals: &[Vec<f64>],
) -> Figure {
    let (used, label, middle, width, caption) = match found.basis {
        Basis::Hovers { .. } => (
            hovers(index, color, found),
            "Thrust over free air",
            1.0,
            3.0,
            "Throttle and height, with the hovers at rest that were used in colour; below, the ratio of thrusts at each.",
        ),
        Basis::Accelerometer | Basis::Poses => (
            runs_used(index, color, found, residuals),
            "Measured − model (g)",
            0.0,
            1.75,
            "Throttle and height, with what was used in colour; below, the residual of the specific force.",
        ),
    };
    let origin_s = origin_s(flight);
    let logged = |name: &str, y: &[f64]| {
        Series::line(name, &since(origin_s, &flight.time_s), y).color(INPUT)
    };
    let mut throttle =
        Panel::new("Time (s)", "Throttle").series(logged("logged", &flight.throttle));
    let mut height = Panel::new("Time (s)", "Height (m)").series(logged("", &flight.height_m));
    let mut below = Panel::new("Time (s)", label);
    for part in used {
        let line = |name: &str, y: &[f64]| {
            Series::line(name, &since(origin_s, &part.time_s), y)
                .color(part.color)
                .width(width)
        };
        throttle = throttle.series(line(&part.name, &part.throttle));
        height = height.series(line("", &part.height_m));
        below = below.series(line("", &part.below));
    }
    Figure::new(
        format!("flight-{:02}-{}", index + 1, slug(&flight.name)),
        format!("{} over time", flight.name),
    )
    .caption(caption)
    .share_x()
    .panel(throttle)
    .panel(height)
    .panel(below.series(Series::horizontal("", middle)))
}

fn report(
    overview: &Overview<'_>,
    result: &FlightResult,
    cards: &[&FittedCard],
    figures: &[Figure],
) -> Result<Report> {
    let (of_logs, first): (Vec<&Figure>, Vec<&Figure>) =
        figures.iter().partition(|f| f.id.starts_with("flight-"));
    let mut first = first.into_iter();
    let mut report = overview.begin(verdict(result), first.next())?;
    report.section("Ground effect");
    report.paragraph(format!("Identified from {}.", result.basis.name()));
    report.table(parameters::table(result))?;
    for figure in first {
        report.figure(figure)?;
    }
    if result.routes.len() > 1 {
        put_table(&mut report, routes(&result.routes))?;
    }
    if !result.refused.is_empty() {
        report.section("Not identified");
    }
    for r in &result.refused {
        report.callout(Callout::Warning, format!("{r}."));
    }
    report.section("Flights");
    if let Some(lift) = &result.extra_lift {
        report.paragraph(format!("By the static curve: {lift}."));
    }
    put_table(&mut report, armed_intervals::table(&result.runs))?;
    logs(&mut report, result, &of_logs)?;
    report.section("Models tried");
    report.table(tried(result))?;
    report.section("Cards");
    for made in cards {
        report.subsection(&made.card.name);
        card_blocks(&mut report, made)?;
    }
    overview.all_fits(&mut report)?;
    overview.end(&mut report)?;
    Ok(report)
}

/// How much the ground adds to thrust, and what could not be identified.
fn verdict(result: &FlightResult) -> (Callout, String) {
    let lift = match &result.extra_lift {
        Some(lift) => {
            let ([a, b], [low, high]) = (lift.near_m, lift.share.ci95.map(|v| show(100.0 * v, 1)));
            format!(
                "Near the ground, at {} to {} m, the thrust is {} % larger than far from it (95 % interval {low} to {high} %).",
                show(a, 2),
                show(b, 2),
                show(100.0 * lift.share.value, 1)
            )
        }
        None => "These flights do not identify a ground effect.".to_string(),
    };
    let refused: Vec<&str> = result.refused.iter().map(Refusal::what).collect();
    match refused.as_slice() {
        [] if result.extra_lift.is_some() => (Callout::Success, lift),
        [] => (Callout::Warning, lift),
        what => (
            Callout::Warning,
            format!("{lift} Not identified: {}.", what.join(", ")),
        ),
    }
}

/// What each sensor says of the ground effect.
fn routes(routes: &[Route]) -> Table {
    let mut table =
        Table::new("The ground effect by each sensor that gives a thrust, with 95 % intervals.")
            .text_column("thrust from")
            .text_column("found")
            .text_column("taken");
    for route in routes {
        let found = route.refused.clone();
        table = table.row([
            Cell::text(route.basis.name()),
            Cell::text(found.unwrap_or_else(|| route.numbers().join("; "))),
            Cell::text(if route.taken { "yes" } else { "" }),
        ]);
    }
    table.note(
        "Of routes that differ by more than their errors, the one that agrees with most others is taken, and a warning names the \
         difference. Of routes that agree, one with an interval less than half as wide is taken.",
    )
}

fn tried(result: &FlightResult) -> Table {
    let mut table = Table::new(
        "Models by their error of the specific force on held-out flights, or by their likelihood.",
    )
    .text_column("model")
    .number_column("all rows", "mg")
    .number_column("in ground effect", "mg")
    .number_column("evidence", "1")
    .text_column("taken");
    for c in &result.tried {
        table = table.row([
            Cell::text(&c.name),
            Cell::maybe(c.rmse.map(|r| 1e3 * r), 3),
            Cell::maybe(c.rmse_near.map(|r| 1e3 * r), 3),
            Cell::maybe(c.evidence, 3),
            Cell::text(if c.chosen { "last" } else { "" }),
        ]);
    }
    table.note(
        "Each model contains those taken before it. A richer model is taken if its error is lower by more than one standard \
         error of the difference between flights. Evidence is twice the logarithm of the likelihood ratio along the \
         trajectories; 10 is needed.",
    )
}

/// The logs over time, one unfolded, with the hovers and with the rows that were not used.
fn logs(report: &mut Report, result: &FlightResult, of_logs: &[&Figure]) -> Result<()> {
    let count = result.runs.chunk_by(|a, b| a.log == b.log).count();
    if count > of_logs.len() {
        report.paragraph(format!(
            "The first {} of {count} logs over time:",
            of_logs.len()
        ));
    }
    if let Some((first, rest)) = of_logs.split_first() {
        report.figure(first)?;
        folded_figures(report, "More logs over time", rest.iter().copied())?;
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
        put_table(report, table)?;
    }
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
    put_table(report, table)
}
