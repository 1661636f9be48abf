//! Fig. 1 and Fig. 5(a)(b) from our data, and residuals.

use rayon::prelude::*;
use touchdown_identify::rig::{GroundTrial, predict};
use touchdown_model::{Card, Form};
use touchdown_report::{Figure, Panel, Series};

use super::coefficients;
use crate::error::Result;
use crate::experiments::ground_effect::{GroundEffectExperiment, kind_of};
use touchdown_pages::colors::{INPUT, MEASURED, PUBLISHED, TRUTH, of_form, shade};
use touchdown_pages::page::{Page, block_means, minus};

/// Points of each trial in the figure over height.
const POINTS_OF_TRIAL: usize = 60;

/// The figure that shows what each form predicts.
pub(super) fn models(page: &mut Page, ge: &GroundEffectExperiment) -> Result<()> {
    match nearest(ge, "triangle_low", 12.0) {
        Some(trial) => Ok(page.figure(fig1(ge, trial)?)?),
        None => Ok(()),
    }
}

/// All thrusts beside the best form, then residuals.
pub(super) fn write(page: &mut Page, ge: &GroundEffectExperiment) -> Result<()> {
    page.figure(fig5(
        ge,
        "approach",
        "fig5a-approach",
        "Approach at all thrusts (as the paper's Fig. 5(a))",
        "The plate rises from 0.75 m to 0.10 m. Points: measurement, means over 0.5 s. Lines: lag form on the rich data, in free run.",
        (30.0, 0.5),
    )?)?;
    page.figure(fig5(
        ge,
        "triangle_mid",
        "fig5b-oscillation",
        "Oscillation at all thrusts (as the paper's Fig. 5(b))",
        "The plate moves between 0.15 m and 0.25 m at 0.08 m/s; the first 10 s. Points: measurement, means over 0.1 s; their scatter is \
         turbulence and sensor noise. Lines: lag form on the rich data, in free run.",
        (10.0, 0.1),
    )?)?;
    page.report.subsection("Residuals");
    page.figure(over_time(ge)?)?;
    Ok(page.figure(over_height(ge)?)?)
}

/// The trial of a kind whose name states the thrust nearest to `thrust_n`.
fn nearest<'a>(
    ge: &'a GroundEffectExperiment,
    kind: &str,
    thrust_n: f64,
) -> Option<&'a GroundTrial> {
    let off = |t: &&GroundTrial| thrust(t).map_or(f64::INFINITY, |n| (n - thrust_n).abs());
    ge.validation
        .iter()
        .filter(|t| kind_of(&t.name) == kind)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// The free-air thrust in a validation trial's name, `kind-13N`.
fn thrust(trial: &GroundTrial) -> Option<f64> {
    trial
        .name
        .rsplit('-')
        .next()?
        .strip_suffix('N')?
        .parse()
        .ok()
}

fn card(ge: &GroundEffectExperiment, form: Form) -> Option<&Card> {
    // The paper's procedure on the paper's data; what is flown, on the rich data.
    let set = usize::from(form != Form::Derivative);
    ge.card(set, form)
}

fn fig1(ge: &GroundEffectExperiment, trial: &GroundTrial) -> Result<Figure> {
    let t = &trial.time_s;
    let mut force = Panel::new("Time (s)", "Ground-effect force f (N)")
        .height_weight(2.0)
        .series(
            Series::line("measured", t, &trial.force_n)
                .color(MEASURED)
                .width(1.0),
        )
        .series(
            Series::line("truth", t, trial.reference_n())
                .color(TRUTH)
                .width(2.6),
        );
    for form in [Form::Empirical, Form::Derivative, Form::Lag] {
        if let Some(card) = card(ge, form) {
            let line = Series::line(form.title(), t, &predict(card, trial)?).color(of_form(form));
            force = force.series(line);
        }
    }
    let eq_12 = coefficients::eq_12()?;
    force = force
        .series(Series::dashed("printed eq. (12)", t, &predict(&eq_12, trial)?).color(PUBLISHED));
    Ok(Figure::new("fig1-models", format!("Models in free run, trial {} (as the paper's Fig. 1)", trial.name))
        .caption(
            "Eq. (2) and lag form on the rich data, eq. (9) on the paper's. The printed eq. (12) belongs to \
             another rig: it starts from the true force and drifts with its own 11 s. Steps at the turns are those of v_p.",
        )
        .share_x()
        .size(900, 620)
        .panel(force)
        .panel(
            Panel::new("Time (s)", "Height z (m)")
                .height_weight(0.6)
                .y_range(0.1, 0.3)
                .series(Series::line("", t, &trial.height_m).color(INPUT)),
        ))
}

fn fig5(
    ge: &GroundEffectExperiment,
    kind: &str,
    id: &str,
    title: &str,
    caption: &str,
    (end, block): (f64, f64),
) -> Result<Figure> {
    let trials: Vec<&GroundTrial> = ge
        .validation
        .iter()
        .filter(|t| kind_of(&t.name) == kind)
        .collect();
    let mut force = Panel::new("Time (s)", "Ground-effect force f (N)")
        .height_weight(2.4)
        .x_range(0.0, end);
    if let Some(card) = card(ge, Form::Lag) {
        for (i, trial) in trials.iter().enumerate().rev() {
            let color = shade(i as f64 / (trials.len().max(2) - 1) as f64);
            let [x, y] = block_means(&trial.time_s, &trial.force_n, block);
            let name = thrust(trial).map_or_else(|| trial.name.clone(), |n| format!("{n} N"));
            force = force
                .series(
                    Series::line(name, &trial.time_s, &predict(card, trial)?)
                        .color(color)
                        .width(1.6),
                )
                .series(
                    Series::points(if i == 0 { "measured" } else { "" }, &x, &y)
                        .color(color)
                        .width(1.1),
                );
        }
    }
    let mut figure = Figure::new(id, title)
        .caption(caption)
        .share_x()
        .size(900, 640)
        .panel(force);
    if let Some(trial) = trials.first() {
        figure = figure.panel(
            Panel::new("Time (s)", "Height z (m)")
                .height_weight(0.6)
                .series(Series::line("", &trial.time_s, &trial.height_m).color(INPUT)),
        );
    }
    Ok(figure)
}

const JUDGED: [Form; 3] = [Form::Derivative, Form::Static, Form::Lag];

fn over_time(ge: &GroundEffectExperiment) -> Result<Figure> {
    let mut figure = Figure::new("residuals-time", "Residuals over time")
        .caption(
            "Predicted minus true force, trials at 13 N, in free run; eq. (9) on the paper's data, the others on the rich data. Steps of the plate's velocity leave peaks: \
             the plant's own law is none of the forms.",
        )
        .share_x()
        .size(900, 720);
    for (row, kind) in ["triangle_low", "sine", "fast_approach"]
        .into_iter()
        .enumerate()
    {
        let Some(trial) = nearest(ge, kind, 13.0) else {
            continue;
        };
        let mut panel =
            Panel::new("Time (s)", format!("{}: error (N)", trial.name)).x_range(0.0, 15.0);
        for form in JUDGED {
            let Some(card) = card(ge, form) else { continue };
            let residual = minus(&predict(card, trial)?, trial.reference_n());
            let name = if row == 0 { form.title() } else { "" };
            panel = panel.series(
                Series::line(name, &trial.time_s, &residual)
                    .color(of_form(form))
                    .width(1.4),
            );
        }
        figure = figure.panel(panel.series(Series::horizontal("", 0.0)));
    }
    Ok(figure)
}

fn over_height(ge: &GroundEffectExperiment) -> Result<Figure> {
    let mut figure = Figure::new("residuals-height", "Residuals over height")
        .caption(
            "Every validation trial, thinned; eq. (9) on the paper's data, the others on the rich data. Eq. (9) adds throttle and height where the \
             force multiplies them, so its error fans out with thrust away from the plate. Two branches at one height, as the plate comes and \
             goes, are missing dynamics. Note the scales.",
        )
        .share_x()
        .size(900, 760);
    for form in JUDGED {
        let Some(card) = card(ge, form) else { continue };
        let parts = ge
            .validation
            .par_iter()
            .map(|trial| -> Result<[Vec<f64>; 2]> {
                let residual = minus(&predict(card, trial)?, trial.reference_n());
                let every = (residual.len() / POINTS_OF_TRIAL).max(1);
                Ok([
                    trial.height_m.iter().copied().step_by(every).collect(),
                    residual.iter().copied().step_by(every).collect(),
                ])
            })
            .collect::<Result<Vec<_>>>()?;
        let [x, y] = [0, 1].map(|k| {
            parts
                .iter()
                .flat_map(|p| p[k].iter().copied())
                .collect::<Vec<f64>>()
        });
        figure = figure.panel(
            Panel::new("Height z (m)", "Predicted − truth (N)")
                .series(
                    Series::points(form.title(), &x, &y)
                        .color(of_form(form))
                        .width(0.9),
                )
                .series(Series::horizontal("", 0.0)),
        );
    }
    Ok(figure)
}
