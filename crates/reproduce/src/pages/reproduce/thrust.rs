//! IV-B.1: throttle to thrust.

use touchdown_identify::scores::Errors;
use touchdown_model::Form;
use touchdown_report::{Cell, Color, Figure, Panel, Series, Table};
use touchdown_trial::Trial;

use super::coefficients::{self, Column};
use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::thrust::{KINDS, MODELS, PlateState};
use touchdown_pages::colors::{DECK, INPUT, MEASURED, PUBLISHED, TRUTH, of_form};
use touchdown_pages::front;
use touchdown_pages::page::{Page, errors, minus, show};

/// Errors are drawn up to here (N); a step leaves a peak beyond it where dead time is not known.
const ERROR_SHOWN_N: f64 = 0.4;
/// Names of [`MODELS`] in tables and legends.
const TITLES: [&str; 3] = ["eq. (8)", "eq. (7)", "eq. (8), as published"];
/// Their colours: eq. (8) and eq. (7) by form, and one for the published procedure.
fn color(model: usize) -> Color {
    match model {
        0 => of_form(Form::Library),
        1 => of_form(Form::FirstOrder),
        _ => PUBLISHED,
    }
}

pub(super) fn write(page: &mut Page, run: &Run) -> Result<()> {
    let [present, removed] = &run.thrust;
    page.report.section("Throttle to thrust (IV-B.1)");
    page.text(
        "`x = √T` is the root of the thrust T in newtons, and `s` is the throttle in [0, 1]. Eq. (7) is `x' = (c0 s + c1 - x)/T_m`. Eq. (8) is \
         `x' = Θ(x, s) ξ` with the eight terms of the printed eq. (11). SR3 with l0 (eq. 6) chooses among them on Savitzky-Golay derivatives. \
         \"As published\" stops there: least squares give its coefficients. A free run refines the other two. For eq. (8), the dead time \
         of the load cell is estimated first. It is the shift at which the library explains the derivative best. Ramps and sines of the \
         throttle train the models; a ramp and a sine that none of them has seen judge them.",
    );
    page.table(errors_table(run))?;
    page.text(elimination(
        removed,
        run.settings.identification.thrust.library.len(),
    ));
    for (index, kind) in KINDS.into_iter().enumerate() {
        page.figure(fig4(removed, index, kind)?)?;
    }
    page.report
        .subsection("What the plate leaves in the reference");
    let (figure, sentence) = bias(present, removed)?;
    page.text(sentence);
    page.figure(figure)?;
    if let Some(found) = &removed.models[0].front {
        page.report.subsection("How many terms eq. (8) needs");
        page.text(format!(
            "Judged by the derivative, before the refinement in free run. {}",
            front::words(found)
        ));
        page.figure(front::figure(
            "front-thrust",
            "Plate removed: error of x' over the number of terms",
            found,
        ))?;
        page.table(front::table(
            "Eq. (8), plate removed: the best subset of every size.",
            found,
        ))?;
    }
    Ok(page.folded_tables(
        "Coefficients of eq. (8) and eq. (7)",
        coefficient_tables(run)?,
    )?)
}

fn coefficient_tables(run: &Run) -> Result<Vec<Table>> {
    let [present, removed] = &run.thrust;
    let eq_11 = coefficients::eq_11()?;
    let column =
        |title, state: &'_ PlateState, model: usize| (title, state.models[model].card.clone());
    let cards = [
        column("Plate removed", removed, 0),
        column("Plate at 0.75 m", present, 0),
        column("As published, removed", removed, 2),
        ("Printed eq. (11)", eq_11),
    ];
    let columns: Vec<Column<'_>> = cards
        .iter()
        .map(|(title, card)| Column { title, card })
        .collect();
    let eq_8 = coefficients::table("Eq. (8): coefficients ± half the 95 % interval, in √N/s over the unit of the term.", &columns)
        .note("`dead_time` [s] is that of the load cell. The printed model belongs to another rig.")
        .note("x, x³ and sin(x) s are nearly collinear on these data. Single coefficients differ more than their intervals say; their sum does not.");
    let columns =
        [("Plate removed", removed), ("Plate at 0.75 m", present)].map(|(title, state)| Column {
            title,
            card: &state.models[1].card,
        });
    let eq_7 = coefficients::table(
        "Eq. (7): c0 and c1 [√N], lag T_m [s], ± half the 95 % interval.",
        &columns,
    );
    Ok(vec![eq_8, eq_7])
}

fn errors_table(run: &Run) -> Table {
    let [present, removed] = &run.thrust;
    let mut table = Table::new(
        "Free run: mean / worst absolute error [N] against the plant's own thrust in free air.",
    )
    .text_column("Model")
    .number_column("Ramp, plate removed", "")
    .number_column("Sine, plate removed", "")
    .number_column("Ramp, at 0.75 m", "")
    .number_column("Sine, at 0.75 m", "");
    let cells = |pick: &dyn Fn(&PlateState, usize) -> Errors| -> Vec<Cell> {
        [removed, present]
            .into_iter()
            .flat_map(|state| [0, 1].map(|kind| errors(Some(pick(state, kind)))))
            .collect()
    };
    for (model, title) in TITLES.into_iter().enumerate() {
        let mut row = vec![Cell::text(title)];
        row.extend(cells(&|state, kind| state.runs[model][kind].errors));
        table = table.row(row);
    }
    let mut row = vec![Cell::text("the measurement's own noise")];
    row.extend(cells(&|state, kind| state.runs[0][kind].floor));
    table.row(row).note(
        "Errors below the noise are meaningful: the truth that they are taken against is free of it, as late as the load cell.",
    )
}

fn elimination(removed: &PlateState, library: usize) -> String {
    let terms = |model: usize| removed.models[model].card.terms_of("x'").count();
    let say = |n: usize| {
        if n >= library {
            "eliminates nothing".to_string()
        } else {
            format!("eliminates {} of the {library} terms", library - n)
        }
    };
    format!(
        "SR3 {} here; as published, on wider smoothing and without dead time, it {}. The printed eq. (11) has all eight. Eq. (7) is off by \
         {} N on the ramp: √T is not linear in the throttle of a motor whose supply sags.",
        say(terms(0)),
        say(terms(2)),
        show(removed.runs[1][0].errors.mae, 1)
    )
}

fn fig4(state: &PlateState, index: usize, kind: &str) -> Result<Figure> {
    let trial = &state.validation[index];
    let t = trial.time_s();
    let truth = trial.require("truth_free_air_n")?;
    let mut thrust = Panel::new("Time (s)", "Thrust (N)")
        .height_weight(1.5)
        .series(Series::line("measured", t, trial.require("thrust_n")?).color(MEASURED))
        .series(Series::line("truth", t, truth).color(TRUTH).width(2.4));
    let mut error =
        Panel::new("Time (s)", "Predicted − truth (N)").y_range(-ERROR_SHOWN_N, ERROR_SHOWN_N);
    for model in 0..MODELS.len() {
        let predicted = &state.runs[model][index].predicted_n;
        let dashed = Series::dashed(TITLES[model], t, predicted).color(color(model));
        thrust = thrust.series(dashed);
        // The error of eq. (7) would flatten the others; the panel above shows it.
        if MODELS[model] != "eq7" {
            let line = Series::line(TITLES[model], t, &minus(predicted, truth)).color(color(model));
            error = error.series(line);
        }
    }
    Ok(Figure::new(format!("fig4-thrust-{kind}"), format!("Thrust on the {kind} (as the paper's Fig. 4)"))
        .caption(format!(
            "Plate removed, free run from the first sample. Mean / worst error {} / {} N for eq. (8), {} / {} N as published. Below: \
             errors, cut off at ±{} N, without eq. (7), which is off by up to {} N.",
            show(state.runs[0][index].errors.mae, 3),
            show(state.runs[0][index].errors.worst, 2),
            show(state.runs[2][index].errors.mae, 3),
            show(state.runs[2][index].errors.worst, 2),
            ERROR_SHOWN_N,
            show(state.runs[1][index].errors.worst, 1)
        ))
        .share_x()
        .size(900, 680)
        .panel(
            Panel::new("Time (s)", "Throttle")
                .y_range(0.0, 1.0)
                .height_weight(0.6)
                .series(Series::line("", t, trial.require("throttle")?).color(INPUT)),
        )
        .panel(thrust)
        .panel(error))
}

/// Errors of each data set's eq. (8) over throttle on the slow ramp, and the force that the plate adds.
fn bias(present: &PlateState, removed: &PlateState) -> Result<(Figure, String)> {
    let ramp = |trial: &Trial| -> Result<Vec<usize>> {
        // The ramp proper, without the rests before and after it.
        let s = trial.require("throttle")?;
        Ok((1..s.len()).filter(|&i| s[i] > s[i - 1]).collect())
    };
    let take =
        |values: &[f64], at: &[usize]| -> Vec<f64> { at.iter().map(|&i| values[i]).collect() };
    let mut panel = Panel::new("Throttle", "Thrust beyond free air (N)");
    let mut means = Vec::new();
    for (state, name, of_state) in [
        (present, "eq. (8) trained with the plate, minus truth", DECK),
        (removed, "eq. (8) trained without it, minus truth", color(0)),
    ] {
        let trial = &state.validation[0];
        let at = ramp(trial)?;
        let error = minus(
            &state.runs[0][0].predicted_n,
            trial.require("truth_free_air_n")?,
        );
        let error = take(&error, &at);
        means.push(error.iter().sum::<f64>() / error.len().max(1) as f64);
        panel = panel.series(
            Series::line(name, &take(trial.require("throttle")?, &at), &error).color(of_state),
        );
    }
    let trial = &present.validation[0];
    let at = ramp(trial)?;
    let lift = minus(
        trial.require("truth_thrust_n")?,
        trial.require("truth_free_air_n")?,
    );
    panel = panel
        .series(
            Series::dashed(
                "ground effect of the plate at 0.75 m",
                &take(trial.require("throttle")?, &at),
                &take(&lift, &at),
            )
            .color(TRUTH),
        )
        .series(Series::horizontal("", 0.0));
    let sentence = format!(
        "The paper trains eq. (8) with the plate in its home position, 0.75 m below. Its ground effect is then part of the \"free air\" \
         thrust: over the ramp the model is off by {} N in the mean, against {} N with the plate removed. Subtracting such a model takes \
         that much from every f_GEF. The experiments below use the model trained without the plate.",
        show(means[0], 3),
        show(means[1], 3)
    );
    let figure = Figure::new("plate-bias", "Bias that the plate at 0.75 m leaves in the free-air thrust")
        .caption("On the validation ramp. The model trained with the plate follows the plate's own ground effect.")
        .size(900, 400)
        .panel(panel);
    Ok((figure, sentence))
}
