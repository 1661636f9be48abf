//! Figures and report of ground-effect models.

use touchdown_identify::FittedCard;
use touchdown_identify::rig::identifiability::Identifiability;
use touchdown_identify::rig::levels::Level;
use touchdown_identify::rig::{GroundTrial, predict};
use touchdown_report::{Callout, Cell, Figure, Panel, Report, Series, Table};

use super::{About, Overview, Shown, card_blocks, front_figure, remarks, slug};
use crate::colors::{MEASURED, of_form};
use crate::error::Result;
use crate::front;
use crate::page::{folded_figures, minus, show};

/// Trials that are drawn over time at most; all are in the figures over height.
const DRAWN_TRIALS: usize = 6;

/// The ground effect of a force rig, by every form.
#[derive(Clone, Copy, Debug)]
pub struct RigFit<'a> {
    /// The trials.
    pub trials: &'a [GroundTrial],
    /// What they can identify.
    pub before: &'a Identifiability,
    /// The cards of the forms that were fitted.
    pub cards: &'a [FittedCard],
    /// The levels of identification on held-out logs; empty where there are too few logs.
    pub levels: &'a [Level],
}

impl RigFit<'_> {
    /// The report, with its figures.
    ///
    /// # Errors
    /// A card that does not run on its own trials, or a figure that cannot be drawn.
    pub fn shown(&self, about: &About<'_>) -> Result<Shown> {
        let overview = Overview::of("Ground effect", about);
        let mut figures = figures(self.trials, self.cards)?;
        let report = report(&overview, self.before, self.cards, self.levels, &figures)?;
        figures.extend(self.cards.iter().filter_map(front_figure));
        Ok(Shown { figures, report })
    }
}

/// Force over height and residual over height of every form; then the free runs of all forms on some trials.
fn figures(trials: &[GroundTrial], fits: &[FittedCard]) -> Result<Vec<Figure>> {
    let run = |made: &FittedCard| -> Result<Vec<Vec<f64>>> {
        trials.iter().map(|t| Ok(predict(&made.card, t)?)).collect()
    };
    let runs = fits.iter().map(run).collect::<Result<Vec<_>>>()?;
    let of_forms = fits.iter().zip(&runs).enumerate();
    let mut out: Vec<Figure> = of_forms
        .map(|(index, (made, predicted))| over_height(index, made, trials, predicted))
        .collect();
    let step = trials.len().div_ceil(DRAWN_TRIALS).max(1);
    out.extend(
        (0..trials.len())
            .step_by(step)
            .map(|i| over_time(i, &trials[i], fits, &runs)),
    );
    Ok(out)
}

/// Measured and predicted force of one form over height, all trials together, and the residual.
fn over_height(
    index: usize,
    made: &FittedCard,
    trials: &[GroundTrial],
    predicted: &[Vec<f64>],
) -> Figure {
    let color = of_form(made.card.form);
    let height: Vec<f64> = trials
        .iter()
        .flat_map(|t| t.height_m.iter().copied())
        .collect();
    let measured: Vec<f64> = trials
        .iter()
        .flat_map(|t| t.force_n.iter().copied())
        .collect();
    let predicted = predicted.concat();
    let residual = minus(&measured, &predicted);
    let dots =
        |name: &str, y: &[f64], color| Series::points(name, &height, y).color(color).width(0.8);
    Figure::new(format!("{:02}-{}-height", index + 1, slug(&made.card.name)), &made.card.name)
        .caption(format!(
            "Ground-effect force over height in {} trials, measured and in free run; below, the residual of the free run.",
            trials.len()
        ))
        .share_x()
        .panel(
            Panel::new("Height (m)", "Force (N)")
                .series(dots("measured", &measured, MEASURED))
                .series(dots("free run", &predicted, color)),
        )
        .panel(
            Panel::new("Height (m)", "Measured − free run (N)")
                .series(dots("", &residual, color))
                .series(Series::horizontal("", 0.0)),
        )
}

/// One trial over time: the measured force, the free runs of all forms, and their residuals.
fn over_time(i: usize, trial: &GroundTrial, fits: &[FittedCard], runs: &[Vec<Vec<f64>>]) -> Figure {
    let time_s = &trial.time_s;
    let mut force = Panel::new("Time (s)", "Force (N)")
        .series(Series::line("measured", time_s, &trial.force_n).color(MEASURED));
    let mut residual = Panel::new("Time (s)", "Measured − free run (N)");
    for (made, of_form_runs) in fits.iter().zip(runs) {
        let color = of_form(made.card.form);
        let predicted = &of_form_runs[i];
        let error = minus(&trial.force_n, predicted);
        force = force.series(Series::line(&made.card.name, time_s, predicted).color(color));
        residual = residual.series(Series::line("", time_s, &error).color(color));
    }
    Figure::new(
        format!("trial-{:03}-{}", i + 1, slug(&trial.name)),
        format!("{} over time", trial.name),
    )
    .caption(
        "Ground-effect force, measured and in free run; below, the residuals of the free runs.",
    )
    .share_x()
    .panel(force)
    .panel(residual.series(Series::horizontal("", 0.0)))
}

fn report(
    overview: &Overview<'_>,
    before: &Identifiability,
    fits: &[FittedCard],
    levels: &[Level],
    figures: &[Figure],
) -> Result<Report> {
    let (of_forms, of_trials) = figures.split_at(fits.len().min(figures.len()));
    let mut report = overview.begin(verdict(before, fits, levels), of_trials.first())?;
    identifiability(&mut report, before)?;
    if !levels.is_empty() {
        report.section("Levels of identification side by side");
        report.paragraph(
            "Every model is fitted again to four fifths of the logs, and the rest judges it. Level 1 is the published procedure. Level 2 is SR3 with \
             scaled columns, the best subset and the weak form. Level 3 is judged by free run.",
        );
        report.table(front::levels(
            "Errors on the held-out logs.",
            &[("", levels)],
        ))?;
    }
    report.section("Models");
    for (made, figure) in fits.iter().zip(of_forms) {
        report.subsection(&made.card.name);
        report.figure(figure)?;
        card_blocks(&mut report, made)?;
        if let Some(figure) = front_figure(made) {
            report.figure(&figure)?;
        }
    }
    folded_figures(
        &mut report,
        "Free runs on more logs",
        of_trials.iter().skip(1),
    )?;
    overview.all_fits(&mut report)?;
    overview.end(&mut report)?;
    Ok(report)
}

/// Which form predicts best, on held-out logs where there are some, and what the data cannot separate.
fn verdict(before: &Identifiability, fits: &[FittedCard], levels: &[Level]) -> (Callout, String) {
    let judged = |level: &&Level| {
        fits.iter()
            .any(|made| made.card.name.ends_with(level.model))
    };
    let held_out = levels.iter().filter(judged);
    let held_out = held_out.filter_map(|level| Some((level.model, level.free_run_rmse_n?)));
    let best = match held_out.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((model, rmse_n)) => format!(
            "On held-out logs, the form `{model}` predicts the ground effect best: its error in free run is {} N (RMSE).",
            show(rmse_n, 3)
        ),
        None => match fits {
            [one] => format!(
                "The card `{}` is fitted with a residual of {} {} (RMSE).",
                one.card.name,
                show(one.rmse, 3),
                one.rmse_unit
            ),
            _ => format!(
                "{} forms are fitted; too few logs are held out to rank them.",
                fits.len()
            ),
        },
    };
    let warnings: usize = fits.iter().map(|made| made.card.warnings.len()).sum();
    if before.confounded {
        let confounded = "The lag and the deck's velocity are confounded in these data.";
        return (Callout::Warning, format!("{best} {confounded}"));
    }
    let kind = if warnings == 0 {
        Callout::Success
    } else {
        Callout::Warning
    };
    (kind, format!("{best}{}", remarks(warnings)))
}

/// What the data can identify, and what to record.
fn identifiability(report: &mut Report, before: &Identifiability) -> Result<()> {
    report
        .section("What the data can identify")
        .paragraph(format!(
            "The library of eq. (9) has the condition number {:.0} on these data. The terms in the deck's velocity inflate the variance of the lag {:.1}-fold{}.",
            before.library.condition,
            before.lag_inflation,
            if before.confounded { ", so they are confounded" } else { "" }
        ));
    if let Some(delay) = before.force_delay_s {
        report.paragraph(format!(
            "The force follows its static value after about {delay:.2} s, lag and dead time together."
        ));
    }
    if !before.advice.is_empty() {
        report.paragraph("Record for a better model:");
        report.list(before.advice.iter().map(ToString::to_string));
    }
    let mut table = Table::new("Inputs of eq. (9).")
        .text_column("input")
        .number_column("standard deviation", "")
        .text_column("excited");
    for input in &before.library.inputs {
        let excited = if input.hardly_excited {
            "hardly"
        } else {
            "yes"
        };
        table = table.row([
            Cell::text(&input.name),
            Cell::number(input.sd, 4),
            Cell::text(excited),
        ]);
    }
    report.table(table.note(
        "f: ground-effect force (N); s: throttle, 0 to 1; z: height above the plate (m); v_p and v_q: velocities of plate and vehicle, up (m/s). \
         An input that hardly varies identifies no term.",
    ))?;
    Ok(())
}
