//! Forms without memory: eq. (2) with fitted mu, and the static map `f = T h(z)`.

use sindy::statistics::regression::{Clusters, cluster_errors, least_squares};
use sindy::trajectory::shooting::{OdeModel, Parameter, Record};
use sindy::{Gram, Library, Samples};
use touchdown_model::flight::psi_definitions;
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use crate::error::Result;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method};
use crate::settings::IdentificationSettings;

/// Eq. (2): `f = T q/(1 - q)`, `q = mu (R/(4 z))²`, least squares on the force.
pub(super) fn empirical(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let r = origin
        .vehicle
        .rotor_radius_m
        .unwrap_or(settings.ground_effect.rotor_radius_m);
    let q = format!("mu*({r}/(4*z))^2");
    let model = OdeModel::new(
        &[],
        &["T", "z"],
        &["mu"],
        &[],
        &format!("T*({q})/(1 - {q})"),
    )?;
    let records: Vec<Record<'_>> = trials
        .iter()
        .enumerate()
        .map(|(group, t)| Record {
            time: &t.time_s,
            inputs: vec![&t.free_air_thrust_n, &t.height_m],
            measured: &t.force_n,
            start: Vec::new(),
            group,
        })
        .collect();
    // q stays below 0.6 at the smallest height of the data.
    let lowest = trials
        .iter()
        .flat_map(|t| &t.height_m)
        .copied()
        .fold(f64::INFINITY, f64::min);
    let most = 0.6 * (4.0 * lowest / r).powi(2);
    let refined = settings.shooting.build(0.0).refine(
        &model,
        &records,
        &[Parameter::free(1.0_f64.min(most)).within(0.0, most)],
    )?;
    let mut card = origin.card(
        "ground-effect-empirical",
        Kind::GroundEffect,
        Form::Empirical,
        "f = T q/(1 - q), q = mu (r/(4 z))^2 (at most 0.6), z height above the deck [m]",
    );
    card.constants.insert("r".into(), r);
    let mu = Estimate::clustered(
        refined.parameters[0],
        refined.std_errors[0],
        Clusters {
            groups: trials.len(),
            coefficients: 1,
        },
    );
    card.terms.push(term("mu", "1", mu, "1"));
    card.provenance.method = method(&[
        (
            "fit",
            "least squares on the force, standard errors by trial".into(),
        ),
        (
            "outcome",
            format!("{:?} after {} steps", refined.outcome, refined.iterations),
        ),
    ]);
    Ok(FittedCard {
        card,
        rmse: refined.rmse,
        rmse_unit: "N",
        rows_used: trials.iter().map(|t| t.time_s.len()).sum(),
        lag_s: None,
        front: None,
        warnings: Vec::new(),
    })
}

/// The bounded functions of height as expressions in `z`.
pub(super) fn psi(lengths_m: [f64; 3]) -> [String; 3] {
    lengths_m.map(|l| format!("1/(1 + (z/{l})^2)"))
}

/// Least squares of `f = T (h0 + h1 psi1 + h2 psi2 + h3 psi3)`.
pub(super) fn map(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let (h, errors, rmse, rows) = map_coefficients(trials, settings.ground_effect.lengths_m)?;
    let mut card = origin.card(
        "ground-effect-static",
        Kind::GroundEffect,
        Form::Static,
        "f = T h(z), z height above the deck [m]",
    );
    (card.constants, card.definitions) = psi_definitions(settings.ground_effect.lengths_m);
    for (k, expression) in ["1", "psi1", "psi2", "psi3"].into_iter().enumerate() {
        let estimate = Estimate::clustered(
            h[k],
            errors[k],
            Clusters {
                groups: trials.len(),
                coefficients: h.len(),
            },
        );
        card.terms.push(term("h", expression, estimate, "1"));
    }
    card.provenance.method = method(&[(
        "fit",
        "least squares on the force, standard errors by trial".into(),
    )]);
    Ok(FittedCard {
        card,
        rmse,
        rmse_unit: "N",
        rows_used: rows,
        lag_s: None,
        front: None,
        warnings: Vec::new(),
    })
}

/// Coefficients `h0..h3`, their standard errors, the residual and the rows used.
pub(super) fn map_coefficients(
    trials: &[GroundTrial],
    lengths_m: [f64; 3],
) -> Result<([f64; 4], [f64; 4], f64, usize)> {
    let mut samples = Samples::new(&["T", "z", "f"]);
    for t in trials {
        samples.push_group(vec![
            t.free_air_thrust_n.clone(),
            t.height_m.clone(),
            t.force_n.clone(),
        ])?;
    }
    let [a, b, c] = psi(lengths_m);
    let library = Library::parse(&[
        "T".to_string(),
        format!("T*{a}"),
        format!("T*{b}"),
        format!("T*{c}"),
    ])?;
    let grams = Gram::accumulate(&library, "f", &samples)?;
    let total = Gram::total(&grams);
    let h = least_squares(&total, &[true; 4]);
    let errors = cluster_errors(&grams, &h, &[true; 4]);
    let rmse = (total.residual_sum(&h) / total.rows.max(1) as f64).sqrt();
    let array = |v: &dyn Fn(usize) -> f64| [v(0), v(1), v(2), v(3)];
    let errors = array(&|k| errors.as_ref().map_or(f64::NAN, |e| e[k]));
    Ok((array(&|k| h[k]), errors, rmse, total.rows))
}
