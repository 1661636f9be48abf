//! Figures and report of thrust models.

use rayon::prelude::*;
use touchdown_model::Form;
use touchdown_report::{Callout, Color, Figure, Panel, Report, Series};
use touchdown_trial::Trial;

use super::{Overview, card_blocks, runs, slug};
use crate::error::Result;
use crate::identify::flight::result::FlightResult;
use crate::identify::thrust::{self, plateau::Plateau};
use crate::identify::{FittedCard, IdentificationSettings};
use crate::progress::Progress;

/// Points of the fitted curve.
const CURVE: usize = 101;

/// One log and the card fitted to it.
#[derive(Clone, Copy, Debug)]
pub struct ThrustFit<'a> {
    /// The log's name, of which the figures' names are made.
    pub name: &'a str,
    /// The log.
    pub trial: &'a Trial,
    /// The fit.
    pub made: &'a FittedCard,
    /// What it says as a log of flights; absent where thrust was measured.
    pub flight: Option<&'a FlightResult>,
}

/// Figures of every fit: thrust and residual over throttle; thrust and residual over time, where the log has a
/// course and not just steady rows.
///
/// # Errors
/// A card that does not run on its own log.
pub fn figures(
    fits: &[ThrustFit<'_>],
    settings: &IdentificationSettings,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Figure>>> {
    fits.par_iter()
        .enumerate()
        .map(|(index, fit)| {
            let id = format!("{:03}-{}", index + 1, slug(fit.name));
            let steady = matches!(fit.made.card.form, Form::StaticSqrt | Form::StaticThrust);
            let made = if steady {
                of_steady(&id, fit, settings)
            } else {
                of_course(&id, fit)
            };
            progress.step();
            let mut made = made?;
            made.extend(super::front_figure(fit.made));
            Ok(made)
        })
        .collect()
}

/// The fitted curve at rest, over the throttles of the log.
fn curve(fit: &ThrustFit<'_>, battery_v: Option<f64>) -> Option<(Vec<f64>, Vec<f64>)> {
    let [lo, hi] = *fit.made.card.validity.inputs.get("s")?;
    let throttle: Vec<f64> = (0..CURVE)
        .map(|i| lo + (hi - lo) * i as f64 / (CURVE - 1) as f64)
        .collect();
    let battery = vec![battery_v.unwrap_or(f64::NAN); CURVE];
    let thrust = thrust::at_rest(&fit.made.card, &throttle, &battery).ok()?;
    Some((throttle, thrust))
}

fn of_steady(
    id: &str,
    fit: &ThrustFit<'_>,
    settings: &IdentificationSettings,
) -> Result<Vec<Figure>> {
    let (points, by_plateau) = thrust::steady_points(std::slice::from_ref(fit.trial), settings)?;
    let throttle: Vec<f64> = points.iter().map(|p| p.throttle).collect();
    let battery: Vec<f64> = points
        .iter()
        .map(|p| p.battery_v.unwrap_or(f64::NAN))
        .collect();
    let fitted = thrust::at_rest(&fit.made.card, &throttle, &battery)?;
    let mut over_throttle = Panel::new("Throttle", "Thrust (N)");
    let mut residual = Panel::new("Throttle", "Measured − fitted (N)");
    let mut over_time = Panel::new("Time (s)", "Measured − fitted (N)");
    for (name, descending, color) in [("up", false, 0), ("down", true, 1)] {
        let chosen: Vec<(&Plateau, f64)> = points
            .iter()
            .zip(fitted.iter().copied())
            .filter(|(p, _)| p.descending == descending)
            .collect();
        if chosen.is_empty() {
            continue;
        }
        let column =
            |f: fn(&(&Plateau, f64)) -> f64| -> Vec<f64> { chosen.iter().map(f).collect() };
        let s = column(|(p, _)| p.throttle);
        let t = column(|(p, _)| p.start_s);
        let r = column(|(p, f)| p.thrust_n - f);
        let (name, color) = (format!("measured, {name}"), Color::Cycle(color));
        let thrust_n = column(|(p, _)| p.thrust_n);
        over_throttle =
            over_throttle.series(Series::points(name.clone(), &s, &thrust_n).color(color));
        residual = residual.series(Series::points("", &s, &r).color(color));
        over_time = over_time.series(Series::points(name, &t, &r).color(color));
    }
    let middle = thrust::plateau::median(battery.iter().copied());
    if let Some((s, t)) = curve(fit, middle) {
        let name = match middle {
            Some(u) if settings.thrust.battery => format!("fitted, at {u:.2} V"),
            _ => "fitted".to_string(),
        };
        over_throttle = over_throttle.series(Series::line(name, &s, &t).color(Color::BLACK));
    }
    let zero = Series::horizontal("", 0.0);
    let what = if by_plateau { "plateaus" } else { "rows" };
    let mut out = vec![
        Figure::new(format!("{id}-curve"), fit.name)
            .caption(format!(
                "Thrust over throttle, {} {what}, the way up and the way down apart; below, what the fit leaves.",
                points.len()
            ))
            .share_x()
            .panel(over_throttle)
            .panel(residual.series(zero.clone())),
    ];
    // Single rows are steady points, each at a time of its own choosing: they have no course.
    if by_plateau {
        let (with_model, _) = course(fit)?;
        out.push(
            Figure::new(format!("{id}-time"), format!("{} over time", fit.name))
                .caption("Measured thrust and free run of the model; below, what the fit leaves at the plateaus.")
                .share_x()
                .panel(with_model)
                .panel(over_time.series(zero)),
        );
    }
    Ok(out)
}

/// Panels of thrust and residual over time.
fn course(fit: &ThrustFit<'_>) -> Result<(Panel, Vec<f64>)> {
    let trial = fit.trial;
    let measured = trial.require("thrust_n")?;
    let predicted = thrust::predict(&fit.made.card, trial)?;
    // Gaps between the rows of a slower channel are no gaps in the line.
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| measured[i].is_finite())
        .collect();
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let panel = Panel::new("Time (s)", "Thrust (N)")
        .series(Series::line("measured", &pick(trial.time_s()), &pick(measured)).color(Color::GREY))
        .series(Series::line("free run", trial.time_s(), &predicted).color(Color::Cycle(0)));
    let residual = measured
        .iter()
        .zip(&predicted)
        .map(|(m, p)| m - p)
        .collect();
    Ok((panel, residual))
}

fn of_course(id: &str, fit: &ThrustFit<'_>) -> Result<Vec<Figure>> {
    let (panel, residual) = course(fit)?;
    let trial = fit.trial;
    let throttle = thrust::throttle(trial)?;
    let measured = trial.require("thrust_n")?;
    let zero = Series::horizontal("", 0.0);
    let mut over_throttle = Panel::new("Throttle", "Thrust (N)").series(
        Series::points("measured", &throttle, measured)
            .color(Color::GREY)
            .width(0.8),
    );
    if let Some((s, t)) = curve(fit, None) {
        over_throttle =
            over_throttle.series(Series::line("fitted, at rest", &s, &t).color(Color::Cycle(0)));
    }
    let points = |x: &[f64]| {
        Series::points("", x, &residual)
            .color(Color::Cycle(0))
            .width(0.8)
    };
    Ok(vec![
        Figure::new(format!("{id}-curve"), fit.name)
            .caption("Thrust over throttle: the model at rest, and the measurement, which lags behind its throttle; below, what the free run leaves.")
            .share_x()
            .panel(over_throttle)
            .panel(
                Panel::new("Throttle", "Measured − free run (N)")
                    .series(points(&throttle))
                    .series(zero.clone()),
            ),
        Figure::new(format!("{id}-time"), format!("{} over time", fit.name))
            .caption("Measured thrust and free run of the model; below, what the free run leaves.")
            .share_x()
            .panel(panel)
            .panel(
                Panel::new("Time (s)", "Measured − free run (N)")
                    .series(points(trial.time_s()))
                    .series(zero),
            ),
    ])
}

/// The report over all fits.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn report(
    overview: &Overview<'_>,
    fits: &[ThrustFit<'_>],
    figures: &[Vec<Figure>],
) -> Result<Report> {
    let mut report = overview.begin()?;
    if fits.len() < overview.rows.len() {
        report.callout(
            Callout::Failure,
            format!(
                "{} of {} logs could not be fitted.",
                overview.rows.len() - fits.len(),
                overview.rows.len()
            ),
        );
    }
    for (fit, figures) in fits.iter().zip(figures) {
        report.section(fit.name);
        card_blocks(&mut report, fit.made)?;
        if let Some(flight) = fit.flight {
            report.table(runs::table(&flight.runs))?;
        }
        for figure in figures {
            report.figure(figure)?;
        }
    }
    overview.end(&mut report);
    Ok(report)
}
