//! Eq. (9) as published: Savitzky–Golay derivative of the force, regressed on the library by SR3.

use sindy::choose::cross_validate;
use sindy::regression::cluster_errors;
use sindy::{Gram, Grid, Library, Samples, SavitzkyGolay};
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use crate::error::Result;
use crate::identify::making::{Made, Origin, method, term};
use crate::identify::settings::IdentificationSettings;
use crate::identify::unit;

/// The columns of eq. (9), smoothed, with the derivative of the force.
pub(super) fn samples(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
) -> Result<Samples> {
    let filter = SavitzkyGolay::new(settings.smoothing.window, settings.smoothing.degree)?;
    let mut samples = Samples::new(&["f", "s", "z", "v_p", "v_q", "f_dot"]);
    for t in trials {
        let force = t.smooth_force(&filter)?;
        samples.push_group(vec![
            force.value,
            t.throttle.clone(),
            t.height_m.clone(),
            t.deck_velocity_mps.clone(),
            t.vehicle_velocity_mps.clone(),
            force.derivative,
        ])?;
    }
    Ok(samples)
}

/// The library without the terms that are zero throughout the data.
pub(super) fn live_library(
    samples: &Samples,
    settings: &IdentificationSettings,
) -> Result<(Library, Vec<Gram>)> {
    let all = Library::parse(&settings.ground_effect.library)?;
    let total = Gram::total(&Gram::accumulate(&all, "f_dot", samples)?);
    let live: Vec<&String> = all
        .names()
        .iter()
        .enumerate()
        .filter(|(j, _)| total.xtx[(*j, *j)] > 0.0)
        .map(|(_, name)| name)
        .collect();
    let library = Library::parse(&live)?;
    let grams = Gram::accumulate(&library, "f_dot", samples)?;
    Ok((library, grams))
}

pub(super) fn fit(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<Made> {
    let samples = samples(trials, settings)?;
    let (library, grams) = live_library(&samples, settings)?;
    let grid = Grid {
        thresholds: settings.sr3.thresholds.clone(),
        nus: settings.sr3.nus.clone(),
    };
    let choice = cross_validate(&grams, &grid)?;
    let total = Gram::total(&grams);
    let xi = choice.coefficients();
    let errors = cluster_errors(&grams, xi, &choice.solution.support);
    let mut card = origin.card(
        "ground-effect-derivative",
        Kind::GroundEffect,
        Form::Derivative,
        "f' = Θ(f, s, z, v_p, v_q) ξ, f [N], s throttle, z height above the deck [m], v_p, v_q velocities of deck and vehicle [m/s]",
    );
    for (j, name) in library
        .names()
        .iter()
        .enumerate()
        .filter(|(j, _)| choice.solution.support[*j])
    {
        let error = errors.as_ref().map_or(f64::NAN, |e| e[j]);
        card.terms.push(term(
            "f'",
            name,
            xi[j],
            error,
            &unit::of_coefficient("f'", name),
        ));
    }
    let left_out: Vec<&str> = settings
        .ground_effect
        .library
        .iter()
        .filter(|t| !library.names().contains(t))
        .map(String::as_str)
        .collect();
    let mut warnings = Vec::new();
    if !left_out.is_empty() {
        warnings.push(format!(
            "left out, for they are zero throughout the data: {}",
            left_out.join(", ")
        ));
    }
    let pole = card.coefficient("f'", "f");
    let r2 = total.r_squared(xi);
    warnings.push(format!(
        "regression on derivatives: errors in the measured force pull its coefficient towards zero (here \
         {pole:.3} 1/s); R² of the derivative is {r2:.2}"
    ));
    card.provenance.method = method(&[
        (
            "derivative",
            format!(
                "Savitzky–Golay, window {}, degree {}",
                settings.smoothing.window, settings.smoothing.degree
            ),
        ),
        (
            "solver",
            format!(
                "SR3 with l0, λ = {:e}, ν = {}; coefficients by least squares on its support",
                choice.point.lambda, choice.point.nu
            ),
        ),
        ("choice", choice.reason.clone()),
        ("outcome", format!("{:?}", choice.solution.outcome)),
    ]);
    Ok(Made {
        card,
        rmse: (total.residual_sum(xi) / total.rows.max(1) as f64).sqrt(),
        rmse_unit: "N/s",
        rows_used: total.rows,
        lag_s: (pole < 0.0).then(|| -1.0 / pole),
        warnings,
    })
}
