//! Figures and report of thrust models.

use rayon::prelude::*;
use touchdown_campaign::progress::Progress;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::thrust::{self, plateau::Plateau};
use touchdown_identify::{FittedCard, IdentificationSettings};
use touchdown_model::Form;
use touchdown_report::{Callout, Color, Figure, Panel, Report, Series};
use touchdown_trial::Trial;

use super::{About, Overview, Shown, armed_intervals, card_blocks, remarks, slug};
use crate::colors::{MEASURED, of_form};
use crate::error::Result;
use crate::page::{put_table, show};

/// Points of the fitted curve.
const CURVE: usize = 101;

/// A card and the logs that it was fitted to.
#[derive(Clone, Copy, Debug)]
pub struct ThrustFit<'a> {
    /// Its name in the report: that of its log.
    pub name: &'a str,
    /// The logs.
    pub trials: &'a [Trial],
    /// The fit.
    pub made: &'a FittedCard,
    /// Results of flights; absent if thrust was measured.
    pub flight: Option<&'a FlightResult>,
}

/// Cards, each with its logs.
#[derive(Clone, Copy, Debug)]
pub struct ThrustFits<'a>(pub &'a [ThrustFit<'a>]);

impl ThrustFits<'_> {
    /// The report, with its figures; a step of `progress` for each card.
    ///
    /// # Errors
    /// A card that does not run on its own log, or a figure that cannot be drawn.
    pub fn shown(&self, about: &About<'_>, progress: &dyn Progress) -> Result<Shown> {
        let overview = Overview::of("Throttle to thrust", about);
        let figures = figures(self.0, about.settings, progress)?;
        let report = report(&overview, self.0, &figures)?;
        Ok(Shown {
            figures: figures.into_iter().flatten().collect(),
            report,
        })
    }
}

/// A log beside the card that was fitted to it.
struct Seen<'a> {
    name: &'a str,
    trial: &'a Trial,
    made: &'a FittedCard,
}

/// Figures of every fit: thrust and residual over throttle; thrust and residual over time, where the log has a
/// course and not just steady rows.
fn figures(
    fits: &[ThrustFit<'_>],
    settings: &IdentificationSettings,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Figure>>> {
    let of_log = |id: &str, seen: &Seen<'_>| match seen.made.card.form {
        Form::StaticSqrt | Form::StaticThrust => of_steady(id, seen, settings),
        _ => of_course(id, seen),
    };
    fits.par_iter()
        .enumerate()
        .map(|(index, fit)| {
            let mut made = Vec::new();
            for (k, trial) in fit.trials.iter().enumerate() {
                let one = fit.trials.len() == 1;
                let name = if one { fit.name } else { trial.name() };
                let id = match one {
                    true => format!("{:03}-{}", index + 1, slug(name)),
                    false => format!("{:03}-{:03}-{}", index + 1, k + 1, slug(name)),
                };
                let seen = Seen {
                    name,
                    trial,
                    made: fit.made,
                };
                made.extend(of_log(&id, &seen)?);
            }
            made.extend(super::front_figure(fit.made));
            progress.step();
            Ok(made)
        })
        .collect()
}

/// The fitted steady curve, over the throttles of the log.
fn curve(fit: &Seen<'_>, battery_v: Option<f64>) -> Option<(Vec<f64>, Vec<f64>)> {
    let [lo, hi] = *fit.made.card.validity.inputs.get("s")?;
    let throttle: Vec<f64> = (0..CURVE)
        .map(|i| lo + (hi - lo) * i as f64 / (CURVE - 1) as f64)
        .collect();
    let battery = vec![battery_v.unwrap_or(f64::NAN); CURVE];
    let thrust = thrust::at_rest(&fit.made.card, &throttle, &battery).ok()?;
    Some((throttle, thrust))
}

fn of_steady(id: &str, fit: &Seen<'_>, settings: &IdentificationSettings) -> Result<Vec<Figure>> {
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
        let color = of_form(fit.made.card.form);
        over_throttle = over_throttle.series(Series::line(name, &s, &t).color(color));
    }
    let zero = Series::horizontal("", 0.0);
    let what = if by_plateau { "plateaus" } else { "rows" };
    let mut out = vec![
        Figure::new(format!("{id}-curve"), fit.name)
            .caption(format!(
                "Thrust over throttle, {} {what}, the way up and the way down apart; below, the residual of the fit.",
                points.len()
            ))
            .share_x()
            .panel(over_throttle)
            .panel(residual.series(zero.clone())),
    ];
    // Single rows are steady points at unrelated times, so no line joins them.
    if by_plateau {
        let (with_model, _) = course(fit)?;
        out.push(
            Figure::new(format!("{id}-time"), format!("{} over time", fit.name))
                .caption("Measured thrust and free run of the model; below, the residual at the plateaus.")
                .share_x()
                .panel(with_model)
                .panel(over_time.series(zero)),
        );
    }
    Ok(out)
}

/// Panels of thrust and residual over time.
fn course(fit: &Seen<'_>) -> Result<(Panel, Vec<f64>)> {
    let trial = fit.trial;
    let measured = trial.require("thrust_n")?;
    let predicted = thrust::predict(&fit.made.card, trial)?;
    // Gaps between the rows of a slower channel are no gaps in the line.
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| measured[i].is_finite())
        .collect();
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let panel = Panel::new("Time (s)", "Thrust (N)")
        .series(Series::line("measured", &pick(trial.time_s()), &pick(measured)).color(MEASURED))
        .series(
            Series::line("free run", trial.time_s(), &predicted).color(of_form(fit.made.card.form)),
        );
    let residual = measured
        .iter()
        .zip(&predicted)
        .map(|(m, p)| m - p)
        .collect();
    Ok((panel, residual))
}

fn of_course(id: &str, fit: &Seen<'_>) -> Result<Vec<Figure>> {
    let (panel, residual) = course(fit)?;
    let trial = fit.trial;
    let throttle = thrust::throttle(trial)?;
    let measured = trial.require("thrust_n")?;
    let zero = Series::horizontal("", 0.0);
    let color = of_form(fit.made.card.form);
    let mut over_throttle = Panel::new("Throttle", "Thrust (N)").series(
        Series::points("measured", &throttle, measured)
            .color(MEASURED)
            .width(0.8),
    );
    if let Some((s, t)) = curve(fit, None) {
        over_throttle = over_throttle.series(Series::line("fitted, at rest", &s, &t).color(color));
    }
    let points = |x: &[f64]| Series::points("", x, &residual).color(color).width(0.8);
    Ok(vec![
        Figure::new(format!("{id}-curve"), fit.name)
            .caption("Thrust over throttle: the model at rest, and the measurement, which lags behind its throttle; below, the residual of the free run.")
            .share_x()
            .panel(over_throttle)
            .panel(
                Panel::new("Throttle", "Measured − free run (N)")
                    .series(points(&throttle))
                    .series(zero.clone()),
            ),
        Figure::new(format!("{id}-time"), format!("{} over time", fit.name))
            .caption("Measured thrust and free run of the model; below, the residual of the free run.")
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
fn report(
    overview: &Overview<'_>,
    fits: &[ThrustFit<'_>],
    figures: &[Vec<Figure>],
) -> Result<Report> {
    let first = figures.first().and_then(|figures| figures.first());
    let mut report = overview.begin(verdict(fits, overview.summary.rows.len()), first)?;
    // Of many fits, the table says more than one after the other.
    if fits.len() > 1 {
        overview.all_fits(&mut report)?;
    }
    for (index, (fit, figures)) in fits.iter().zip(figures).enumerate() {
        match index {
            0 => {
                report.section(fit.name);
                of_fit(&mut report, fit, figures.iter().skip(1))?;
            }
            _ => {
                if index == 1 {
                    report.section("The other logs");
                }
                report.folded(fit.name, |inner| of_fit(inner, fit, figures.iter()))?;
            }
        }
    }
    if fits.len() <= 1 {
        overview.all_fits(&mut report)?;
    }
    overview.end(&mut report)?;
    Ok(report)
}

/// Coefficients, errors and figures of one log's fit.
fn of_fit<'a>(
    report: &mut Report,
    fit: &ThrustFit<'_>,
    mut figures: impl Iterator<Item = &'a Figure>,
) -> Result<()> {
    card_blocks(report, fit.made)?;
    if let Some(flight) = fit.flight {
        put_table(report, armed_intervals::table(&flight.runs))?;
    }
    figures.try_for_each(|figure| Ok(report.figure(figure).map(drop)?))
}

/// Root mean square residual over the greatest measured thrust above which a fit needs a warning. Close to the ground
/// the ground effect adds 10 to 20 % of the thrust, and what a thrust model leaves enters the ground effect. With half
/// of it, quadratic maps of good thrust stands need a warning; with twice as much, eq. (7) on fast sines needs none.
const LARGE_RESIDUAL: f64 = 0.02;

/// Root mean square residual (N) and its ratio to the greatest measured thrust, where both are known.
fn residual(fit: &ThrustFit<'_>) -> Option<(f64, f64)> {
    let mut scores = fit.made.card.scores.iter();
    let rmse_n = scores.find(|s| s.seen && s.unit == "N")?.rmse;
    let measured = fit.trials.iter().filter_map(|t| t.channel("thrust_n"));
    let measured = measured.flatten().copied();
    let greatest_n = measured.filter(|n| n.is_finite()).fold(0.0, f64::max);
    (greatest_n > 0.0).then_some((rmse_n, rmse_n / greatest_n))
}

/// The root mean square residual in words, in newtons where that is known.
fn residual_words(fit: &ThrustFit<'_>) -> String {
    match residual(fit) {
        Some((rmse_n, _)) => format!("{} N", show(rmse_n, 3)),
        None => format!("{} {}", show(fit.made.rmse, 3), fit.made.rmse_unit),
    }
}

/// How well thrust follows from throttle, and how many logs could not be fitted.
fn verdict(fits: &[ThrustFit<'_>], logs: usize) -> (Callout, String) {
    let failed = logs.saturating_sub(fits.len());
    let warnings: usize = fits.iter().map(|fit| fit.made.card.warnings.len()).sum();
    let by_rmse = |a: &&ThrustFit<'_>, b: &&ThrustFit<'_>| a.made.rmse.total_cmp(&b.made.rmse);
    let (best, worst) = (fits.iter().min_by(by_rmse), fits.iter().max_by(by_rmse));
    let mut said = match (fits, best, worst) {
        ([one], ..) => format!(
            "The card `{}` explains the thrust with a root mean square residual of {}",
            one.made.card.name,
            residual_words(one)
        ),
        (_, Some(best), Some(worst)) => format!(
            "{} logs are fitted one by one. The root mean square residual is {} ({}) to {} ({})",
            fits.len(),
            residual_words(best),
            best.name,
            residual_words(worst),
            worst.name
        ),
        _ => return (Callout::Failure, "No log could be fitted.".to_string()),
    };
    let ratios = fits.iter().filter_map(residual).map(|(_, ratio)| ratio);
    let ratio = ratios.max_by(f64::total_cmp);
    let most = if fits.len() > 1 { "at most " } else { "" };
    said += &ratio.map_or_else(
        || ".".to_string(),
        |ratio| {
            format!(
                ", {most}{} % of the greatest thrust.",
                show(100.0 * ratio, 1)
            )
        },
    );
    let large = ratio.is_some_and(|ratio| ratio > LARGE_RESIDUAL);
    if large {
        said += " That is too much to identify a ground effect with: fit all logs into one card, or choose another form of the thrust (`form` in [thrust]).";
    }
    if failed > 0 {
        said += &format!(" {failed} of {logs} logs could not be fitted.");
        return (Callout::Failure, said);
    }
    let kind = match warnings == 0 && !large {
        true => Callout::Success,
        false => Callout::Warning,
    };
    (kind, said + &remarks(warnings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use touchdown_identify::Origin;

    /// A slow sine of throttle, whose root of thrust follows `rest` with a lag of 0.1 s.
    fn trial(rest: impl Fn(f64) -> f64) -> Trial {
        const STEP_S: f64 = 0.01;
        let time_s: Vec<f64> = (0..2_000).map(|i| STEP_S * f64::from(i)).collect();
        let throttle: Vec<f64> = time_s.iter().map(|t| 0.5 + 0.3 * t.sin()).collect();
        let mut x = rest(throttle[0]);
        let thrust_n = throttle.iter().map(|&s| {
            x += STEP_S / 0.1 * (rest(s) - x);
            x * x
        });
        let thrust_n = thrust_n.collect();
        let mut trial = Trial::new("sine", time_s).expect("increasing times");
        trial.insert("throttle", throttle).expect("as many rows");
        trial.insert("thrust_n", thrust_n).expect("as many rows");
        trial
    }

    fn judged(rest: impl Fn(f64) -> f64) -> (Callout, String) {
        let trial = trial(rest);
        let settings = IdentificationSettings::default();
        let trials = std::slice::from_ref(&trial);
        let made = thrust::first_order(trials, &settings, &Origin::default()).expect("a fit");
        let fit = ThrustFit {
            name: "sine",
            trials,
            made: &made,
            flight: None,
        };
        verdict(&[fit], 1)
    }

    #[test]
    fn regress_a_large_residual_is_no_success() {
        let (kind, words) = judged(|s| 2.0 + 3.0 * s);
        assert_eq!(kind, Callout::Success, "{words}");
        // The supply sags: the root of thrust saturates, which no line follows.
        let (kind, words) = judged(|s| 5.0 * s - 4.0 * s * s);
        assert_eq!(kind, Callout::Warning, "{words}");
        assert!(
            words.contains("too much to identify a ground effect"),
            "{words}"
        );
        assert_eq!(verdict(&[], 1).0, Callout::Failure);
    }
}
