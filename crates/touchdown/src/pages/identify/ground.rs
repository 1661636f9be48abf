//! Figures and report of ground-effect models.

use touchdown_report::Cell;
use touchdown_report::{Color, Figure, Panel, Report, Series, Table};

use super::super::front;
use super::{Overview, card_blocks, front_figure, slug};
use crate::error::Result;
use crate::identify::FittedCard;
use crate::identify::ground_effect::identifiability::Identifiability;
use crate::identify::ground_effect::levels::Level;
use crate::identify::ground_effect::{GroundTrial, predict};

/// Trials that are drawn over time at most; all are in the figures over height.
const DRAWN_TRIALS: usize = 6;

/// Force over height and residual over height of every form; then the free runs of all forms on some trials.
///
/// # Errors
/// A card that does not run on its own trials.
pub fn figures(trials: &[GroundTrial], fits: &[FittedCard]) -> Result<Vec<Figure>> {
    let mut out = Vec::new();
    let mut runs: Vec<Vec<Vec<f64>>> = Vec::new();
    for (index, made) in fits.iter().enumerate() {
        let of_fit: Vec<Vec<f64>> = trials
            .iter()
            .map(|t| Ok(predict(&made.card, t)?))
            .collect::<Result<_>>()?;
        let join =
            |f: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> { (0..trials.len()).flat_map(f).collect() };
        let height = join(&|i| trials[i].height_m.clone());
        let measured = join(&|i| trials[i].force_n.clone());
        let predicted = join(&|i| of_fit[i].clone());
        let residual: Vec<f64> = measured
            .iter()
            .zip(&predicted)
            .map(|(m, p)| m - p)
            .collect();
        let dots =
            |name: &str, y: &[f64], color| Series::points(name, &height, y).color(color).width(0.8);
        out.push(
            Figure::new(format!("{:02}-{}-height", index + 1, slug(&made.card.name)), &made.card.name)
                .caption(format!(
                    "Ground-effect force over height in {} trials, measured and in free run; below, what the free run leaves.",
                    trials.len()
                ))
                .share_x()
                .panel(
                    Panel::new("Height (m)", "Force (N)")
                        .series(dots("measured", &measured, Color::GREY))
                        .series(dots("free run", &predicted, Color::Cycle(index))),
                )
                .panel(
                    Panel::new("Height (m)", "Measured − free run (N)")
                        .series(dots("", &residual, Color::Cycle(index)))
                        .series(Series::horizontal("", 0.0)),
                ),
        );
        runs.push(of_fit);
    }
    let step = trials.len().div_ceil(DRAWN_TRIALS).max(1);
    for (i, trial) in trials.iter().enumerate().step_by(step) {
        let mut force = Panel::new("Time (s)", "Force (N)")
            .series(Series::line("measured", &trial.time_s, &trial.force_n).color(Color::GREY));
        let mut residual = Panel::new("Time (s)", "Measured − free run (N)");
        for (index, (made, of_fit)) in fits.iter().zip(&runs).enumerate() {
            let left: Vec<f64> = trial
                .force_n
                .iter()
                .zip(&of_fit[i])
                .map(|(m, p)| m - p)
                .collect();
            let color = Color::Cycle(index);
            force =
                force.series(Series::line(&made.card.name, &trial.time_s, &of_fit[i]).color(color));
            residual = residual.series(Series::line("", &trial.time_s, &left).color(color));
        }
        out.push(
            Figure::new(
                format!("trial-{:03}-{}", i + 1, slug(&trial.name)),
                format!("{} over time", trial.name),
            )
            .caption(
                "Ground-effect force, measured and in free run; below, what the free runs leave.",
            )
            .share_x()
            .panel(force)
            .panel(residual.series(Series::horizontal("", 0.0))),
        );
    }
    Ok(out)
}

/// The report.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn report(
    overview: &Overview<'_>,
    before: &Identifiability,
    fits: &[FittedCard],
    levels: &[Level],
    figures: &[Figure],
) -> Result<Report> {
    let mut report = overview.begin()?;
    report
        .section("What the data can carry")
        .paragraph(format!(
            "The library of eq. (9) has condition {:.0} on these data; the lag's variance is inflated {:.1}-fold by the terms in the deck's velocity{}.",
            before.library.condition,
            before.lag_inflation,
            if before.confounded { ": they are confounded" } else { "" }
        ));
    let mut table = Table::new("Inputs.")
        .text_column("input")
        .number_column("standard deviation", "")
        .text_column("excited");
    for input in &before.library.inputs {
        table = table.row([
            Cell::text(&input.name),
            Cell::number(input.sd, 4),
            Cell::text(if input.hardly_excited {
                "hardly"
            } else {
                "yes"
            }),
        ]);
    }
    report.table(table)?;
    if let Some(delay) = before.force_delay_s {
        report.paragraph(format!(
            "The force follows its static value by about {delay:.2} s (lag and dead time together)."
        ));
    }
    if !before.advice.is_empty() {
        report.paragraph("To record, for a better model:");
        report.list(before.advice.iter().cloned());
    }
    if !levels.is_empty() {
        report.section("Levels of identification side by side");
        report.paragraph(
            "Each fitted anew to four fifths of the logs, and judged on the rest. Level 1: as published. Level 2: SR3 done right, the best \
             subset, the weak form. Level 3: judged by free run.",
        );
        report.table(front::levels(
            "Errors on the logs held out.",
            &[("", levels)],
        ))?;
    }
    report.section("Models");
    let (of_forms, of_trials) = figures.split_at(fits.len().min(figures.len()));
    for (made, figure) in fits.iter().zip(of_forms) {
        report.subsection(&made.card.name);
        card_blocks(&mut report, made)?;
        report.figure(figure)?;
        if let Some(figure) = front_figure(made) {
            report.figure(&figure)?;
        }
    }
    report.section("Free runs");
    for figure in of_trials {
        report.figure(figure)?;
    }
    overview.end(&mut report);
    Ok(report)
}
