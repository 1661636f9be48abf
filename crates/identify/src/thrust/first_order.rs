//! Eq. (7): one lag for `x = √T`.

use sindy::statistics::regression::{Clusters, least_squares};
use sindy::trajectory::shooting::{OdeModel, Parameter, Refined};
use sindy::{Gram, Library};
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::record::StandRecords;
use crate::error::Result;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, outcome};
use crate::settings::{IdentificationSettings, ThrustSettings};

/// Shortest lag (s).
/// Below it the integration's step decides; no rotor is as quick.
const SHORTEST_LAG_S: f64 = 2e-3;
/// Eq. (7): `x' = (c0 s + c1 - x)/T_m`, started from regression, fitted in free run.
///
/// # Errors
/// Missing channels or too few unbroken data.
pub fn first_order(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let records = StandRecords::of(trials, settings, false)?;
    let (refined, clusters) = fit(&records, settings)?;
    let card = card(&refined, clusters, origin);
    Ok(FittedCard {
        lag_s: Some(refined.parameters[2]),
        ..records.finish(card, trials)?
    })
}

/// The parameters c0, c1 and T_m.
fn fit(records: &StandRecords, settings: &IdentificationSettings) -> Result<(Refined, Clusters)> {
    let model = OdeModel::new(
        &["x"],
        &["s"],
        &["c0", "c1", "T_m"],
        &["(c0*s + c1 - x)/T_m"],
        "x*abs(x)",
    )?;
    let [c0, c1, t_m] = start(records, &settings.thrust)?;
    let parameters = [
        Parameter::free(c0),
        Parameter::free(c1),
        Parameter::free(t_m).within(SHORTEST_LAG_S, settings.thrust.max_lag_s),
    ];
    records.free_run(&model, &parameters, settings)
}

/// The parameters by regression on derivatives.
fn start(records: &StandRecords, settings: &ThrustSettings) -> Result<[f64; 3]> {
    let library = Library::parse(&["1", "x", "s"])?;
    let gram = Gram::total(&Gram::accumulate(&library, "x_dot", &records.samples()?)?);
    let xi = least_squares(&gram, &[true; 3]);
    let t_m = if xi[1] < 0.0 { -1.0 / xi[1] } else { 0.1 };
    let t_m = t_m.clamp(2.0 * SHORTEST_LAG_S, 0.9 * settings.max_lag_s);
    // Where the regression makes no sense, start from the range of the data.
    Ok(if xi[2] > 0.0 {
        [xi[2] * t_m, xi[0] * t_m, t_m]
    } else {
        [5.0, 0.0, t_m]
    })
}

fn card(refined: &Refined, clusters: Clusters, origin: &Origin) -> Card {
    let mut card = origin.card(
        "thrust-first-order",
        Kind::Thrust,
        Form::FirstOrder,
        "x' = (c0 s + c1 - x)/T_m, x = √T [√N], s throttle in [0, 1]",
    );
    let names = [("c0", "√N"), ("c1", "√N"), ("T_m", "s")];
    for ((name, unit), estimate) in names.into_iter().zip(Estimate::refined(refined, clusters)) {
        card.terms.push(term(name, "1", estimate, unit));
    }
    card.provenance.method = method(&[
        (
            "fit",
            "least squares in free run over long stretches, each with its own start; began at regression on derivatives"
                .into(),
        ),
        ("outcome", outcome(refined)),
    ]);
    card
}
