//! Eq. (9): Savitzky–Golay derivative of the force, regressed on the library by SR3.

use sindy::statistics::regression::{Clusters, cluster_errors};
use sindy::{Gram, Library, Samples, SavitzkyGolay};
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use crate::error::Result;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method};
use crate::front::Front;
use crate::settings::IdentificationSettings;
use crate::sparse_fit::sparse_fit;
use crate::unit;
use crate::warning::Warning;

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

/// Groups with data, and terms that are kept.
pub(super) fn clusters(grams: &[Gram], support: &[bool]) -> Clusters {
    Clusters {
        groups: grams.iter().filter(|g| g.rows > 0).count(),
        coefficients: support.iter().filter(|s| **s).count(),
    }
}

pub(super) fn fit(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let samples = samples(trials, settings)?;
    let (library, grams) = live_library(&samples, settings)?;
    let chosen = sparse_fit(&grams, settings)?;
    let front = Front::of(("f'", "N/s"), &library, &grams, &chosen, settings)?;
    let total = Gram::total(&grams);
    let (xi, support) = (&chosen.fit.coefficients, &chosen.fit.support);
    let errors = cluster_errors(&grams, xi, support);
    let clusters = clusters(&grams, support);
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
        .filter(|(j, _)| support[*j])
    {
        let estimate =
            Estimate::clustered(xi[j], errors.as_ref().map_or(f64::NAN, |e| e[j]), clusters);
        let unit = unit::of_coefficient("f'", name);
        card.terms.push(term("f'", name, estimate, &unit));
    }
    let zero: Vec<String> = settings
        .ground_effect
        .library
        .iter()
        .filter(|t| !library.names().contains(t))
        .cloned()
        .collect();
    let mut warnings = Vec::new();
    if !zero.is_empty() {
        warnings.push(Warning::ZeroTerms(zero));
    }
    let pole = card.coefficient("f'", "f");
    warnings.push(Warning::Attenuated {
        pole_per_s: pole,
        r_squared: total.r_squared(xi),
    });
    let mut notes = vec![(
        "derivative",
        format!(
            "Savitzky–Golay, window {}, degree {}",
            settings.smoothing.window, settings.smoothing.degree
        ),
    )];
    notes.extend(chosen.notes.iter().cloned());
    card.provenance.method = method(&notes);
    Ok(FittedCard {
        card,
        rmse: chosen.training_rmse,
        rmse_unit: "N/s",
        rows_used: total.rows,
        lag_s: (pole < 0.0).then(|| -1.0 / pole),
        front,
        warnings,
    })
}
