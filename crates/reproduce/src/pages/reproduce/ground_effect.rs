//! IV-B.2: the ground-effect models.

use touchdown_identify::scores::Errors;
use touchdown_model::Form;
use touchdown_report::{Cell, Table};
use touchdown_sim::rig::sets::VALIDATION_KINDS;

use super::coefficients::{self, Column};
use super::first_page::all_kinds;
use super::identifiability::title;
use super::{ground_effect_figures as figures, identifiability, sparsity};
use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::ground_effect::{GroundEffectExperiment, kind_of};
use crate::experiments::results::Results;
use touchdown_pages::page::{Page, errors, maybe, show};

pub(super) fn write(page: &mut Page, run: &Run, results: &Results) -> Result<()> {
    let ge = &run.ground_effect;
    page.report.section("Ground effect (IV-B.2)");
    page.text(
        "The load cell measures the thrust near the plate. The ground-effect force `f` is what exceeds the free-air thrust `T` of eq. (8), which was \
         trained without the plate. `z` is the height above the plate, and `v_p` is the plate's velocity, up. The vehicle stands still. Five forms are fitted:",
    );
    page.report.list([
        "eq. (2): `f = T q/(1 - q)`, `q = μ (r/4z)²`, one coefficient μ;",
        "static map: `f = T h(z)`, h a sum of bounded functions of height;",
        "eq. (9): `f' = Θ(f, s, z, v_p, v_q) ξ` by SR3 on derivatives, with the terms of the printed eq. (12);",
        "ratio form: `y = f/T`, `y' = Θ(y, z, v_p) ξ`, refined by multiple shooting;",
        "lag form: `y = G + k(z) v_p`, `G' = (h(z) - G)/τ`, by multiple shooting.",
    ]);
    page.text(
        "Each form is fitted to two data sets. The paper's data are its three scenarios. The rich data add multi-sine motion of the plate and slow \
         sweeps over all heights. Free runs judge the forms on five other kinds of plate motion, at thrusts between 10 and 16 N.",
    );
    figures::models(page, ge)?;
    page.report.subsection("Errors in free run");
    for set in 0..2 {
        page.table(pooled(ge, set))?;
    }
    page.text(what_dynamics_add(run));
    figures::write(page, ge)?;
    identifiability::write(page, ge)?;
    sparsity::write(page, ge)?;
    let of_forms = Form::GROUND_EFFECT.map(|form| coefficients_of(run, results, form));
    let of_forms = of_forms.into_iter().collect::<Result<Vec<Table>>>()?;
    page.folded_tables("Coefficients of all forms", of_forms)?;
    let of_trials = [0, 1].map(|set| every_trial(ge, set));
    Ok(page.folded_tables("Errors of every validation trial", of_trials.into())?)
}

/// Errors of the best constant of each trial, its own mean, over the trials of one kind.
pub(super) fn constant(ge: &GroundEffectExperiment, kind: &str) -> Option<Errors> {
    let of_kind: Vec<Errors> = ge
        .validation
        .iter()
        .filter(|t| kind_of(&t.name) == kind)
        .filter_map(|t| {
            let reference = t.reference_n();
            let finite = reference.iter().filter(|v| v.is_finite());
            let mean = finite.clone().sum::<f64>() / finite.count().max(1) as f64;
            Errors::of(&vec![mean; reference.len()], reference)
        })
        .collect();
    Errors::pool(&of_kind)
}

fn pooled(ge: &GroundEffectExperiment, set: usize) -> Table {
    let mut table = Table::new(format!(
        "{}: mean / worst absolute error [N] over the trials of each kind.",
        title(&ge.sets[set])
    ))
    .text_column("Model");
    for kind in VALIDATION_KINDS {
        table = table.number_column(kind, "");
    }
    // The best mean of each kind in bold.
    let best = VALIDATION_KINDS.map(|kind| {
        (0..Form::GROUND_EFFECT.len())
            .filter_map(|model| ge.pooled(set, model, kind))
            .map(|e| e.mae)
            .fold(f64::INFINITY, f64::min)
    });
    for (model, form) in Form::GROUND_EFFECT.into_iter().enumerate() {
        let mut row = vec![Cell::text(form.title())];
        for (kind, best) in VALIDATION_KINDS.into_iter().zip(best) {
            let found = ge.pooled(set, model, kind);
            let cell = errors(found);
            row.push(if found.is_some_and(|e| e.mae <= best) {
                cell.bold()
            } else {
                cell
            });
        }
        table = table.row(row);
    }
    let mut row = vec![Cell::text("a constant: each trial's own mean")];
    row.extend(VALIDATION_KINDS.map(|kind| errors(constant(ge, kind))));
    table = table.row(row);
    let mut row = vec![Cell::text("the measurement's own noise")];
    row.extend(VALIDATION_KINDS.map(|kind| errors(ge.pooled_floor(kind))));
    table.row(row).note(
        "Against the plant's own force without turbulence and sensor noise. Best mean of each kind in bold. The constant knows the \
         trial that it is judged on; it says how much there was to predict. Dynamic forms are started from the true force.",
    )
}

fn what_dynamics_add(run: &Run) -> String {
    let sine = |set: usize, form: Form| {
        let model = Form::GROUND_EFFECT.iter().position(|f| *f == form)?;
        run.ground_effect.pooled(set, model, "sine").map(|e| e.mae)
    };
    let all = |form| all_kinds(run, 1, form).map(|e| e.mae);
    let (map, lag) = (all(Form::Static), all(Form::Lag));
    let (map_sine, lag_sine) = (sine(1, Form::Static), sine(1, Form::Lag));
    let times = |a: Option<f64>, b: Option<f64>| show(a.zip(b).map_or(f64::NAN, |(a, b)| a / b), 1);
    let lags = run.ground_effect.sets.iter().map(|set| {
        let lag = Form::GROUND_EFFECT
            .iter()
            .zip(&set.models)
            .find(|(f, _)| **f == Form::Lag)
            .and_then(|(_, m)| m.lag_s);
        format!("{} s on the {}", maybe(lag), title(set).to_lowercase())
    });
    format!(
        "What dynamics add to a static map, on the rich data: {} N against {} N over all trials (static / lag {}), {} N against {} N on the \
         sine (static / lag {}). The lag τ is {}. (The plant of the default settings has two lags, so that no single one is true of it.)",
        maybe(lag),
        maybe(map),
        times(map, lag),
        maybe(lag_sine),
        maybe(map_sine),
        times(map_sine, lag_sine),
        lags.collect::<Vec<_>>().join(" and ")
    )
}

fn coefficients_of(run: &Run, results: &Results, form: Form) -> Result<Table> {
    let eq_12 = coefficients::eq_12()?;
    let ge = &run.ground_effect;
    let mut columns: Vec<Column<'_>> = ge
        .sets
        .iter()
        .enumerate()
        .filter_map(|(set, data)| {
            Some(Column {
                title: title(data),
                card: ge.card(set, form)?,
            })
        })
        .collect();
    if form == Form::Derivative {
        columns.push(Column {
            title: "Printed eq. (12)",
            card: &eq_12,
        });
    }
    let mut table = coefficients::table(
        &format!("{}: coefficients ± half the 95 % interval.", form.title()),
        &columns,
    );
    let [l1, l2, l3] = run.settings.identification.ground_effect.lengths_m();
    let bounded = format!("psi_i = 1/(1 + (z/l_i)²), l = {l1}, {l2}, {l3} m.");
    match form {
        Form::Empirical => table = table.note("The paper prints no μ."),
        Form::Derivative => {
            let lag = |set: &str| {
                let lag = results
                    .ground_effect
                    .lag_s
                    .get(set)
                    .and_then(|f| f.get(form.name()));
                maybe(lag.copied().flatten())
            };
            table = table.note(format!(
                "The coefficient of f, where it is kept, stands for a time constant: {} s and {} s here, {} s in print. Noise in f pulls it towards zero in any \
                 regression on derivatives.",
                lag("paper_data"),
                lag("rich_data"),
                show(-1.0 / eq_12.coefficient("f'", "f"), 1)
            ));
        }
        _ => table = table.note(bounded),
    }
    for set in &ge.sets {
        let model = Form::GROUND_EFFECT
            .iter()
            .position(|f| *f == form)
            .unwrap_or(0);
        for warning in &set.models[model].warnings {
            table = table.note(format!("{}: {warning}.", title(set)));
        }
    }
    Ok(table)
}

fn every_trial(ge: &GroundEffectExperiment, set: usize) -> Table {
    let mut table = Table::new(format!(
        "{}: mean / worst absolute error [N], trial by trial.",
        title(&ge.sets[set])
    ))
    .text_column("Trial");
    for form in Form::GROUND_EFFECT {
        table = table.number_column(form.title(), "");
    }
    table = table.number_column("noise", "");
    for (i, trial) in ge.validation.iter().enumerate() {
        let mut row = vec![Cell::text(trial.name.as_str())];
        row.extend(
            ge.sets[set]
                .errors
                .iter()
                .map(|model| errors(Some(model[i].truth))),
        );
        row.push(errors(Some(ge.floor[i])));
        table = table.row(row);
    }
    table.note("Noise: the measurement's own, against the same truth.")
}
