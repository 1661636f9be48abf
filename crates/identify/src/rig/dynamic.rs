//! Forms with memory, refined by multiple shooting: the ratio form and the lag form.

use sindy::SavitzkyGolay;
use sindy::statistics::regression::Clusters;
use sindy::trajectory::shooting::{OdeModel, Parameter, Record, Refined};
use touchdown_flight::ground_effect::Ratio;
use touchdown_model::flight::psi_definitions;
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use super::statics::{map_coefficients, psi};
use crate::error::Result;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method};
use crate::settings::IdentificationSettings;
use crate::unit;
use crate::warning::Warning;

/// Rate at which the searches start: a wake lag of 0.25 s.
/// The middle of the lags of small rotors in the logarithm; the search is free from there.
const START_RATE: f64 = 4.0;
/// Standard deviation of the prior on a window's start, in units of f/T.
/// A half of the effect at one radius: the start of a window is nearly free.
const START_SD: f64 = 0.05;
/// Standard deviation of the prior on a window's start in newtons: that of f/T at the weight of a small vehicle.
/// As above. A window of fifty lags hardly depends on it.
const START_SD_N: f64 = 0.5;
/// Correlation of two estimates from which they count as confounded.
/// Variance inflation of ten, the limit that is used for the data as well.
const CONFOUNDED: f64 = 0.95;

/// One parameter: its name in the equations, its place in the card, and where the search starts.
struct Place {
    name: &'static str,
    of: &'static str,
    expression: &'static str,
    unit: String,
    start: Parameter,
}

fn place(
    name: &'static str,
    (of, expression): (&'static str, &'static str),
    unit: &str,
    start: Parameter,
) -> Place {
    Place {
        name,
        of,
        expression,
        unit: unit.to_string(),
        start,
    }
}

/// A form with memory in the ratio f/T: its card's head, its equations, and its parameters, memory first.
struct Shape {
    name: &'static str,
    form: Form,
    equation: &'static str,
    state: &'static str,
    rhs: String,
    output: String,
    places: Vec<Place>,
    lag_s: fn(&[f64]) -> f64,
}

/// `y' = Θ(y, z, v_p) ξ`, `f = T y`.
pub(super) fn ratio(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let lengths = settings.ground_effect.lengths_m;
    let (h, ..) = map_coefficients(trials, lengths)?;
    let [p1, p2, p3] = psi(lengths);
    let rate = START_RATE;
    let [lo, hi] = settings.ground_effect.lag_bounds_s;
    // A prior as wide as the coefficients can be keeps what the data do not carry near the static map.
    let starts = [
        Parameter::free(rate * h[0]).prior(1.0),
        Parameter::free(-rate).within(-1.0 / lo, -1.0 / hi),
        Parameter::free(rate * h[1]).prior(1.0),
        Parameter::free(rate * h[2]).prior(1.0),
        Parameter::free(rate * h[3]).prior(1.0),
        Parameter::free(0.0).prior(1.0),
        Parameter::free(0.0).prior(3.0),
        Parameter::free(0.0).prior(3.0),
        Parameter::free(0.0).prior(3.0),
    ];
    let names = ["a0", "ay", "a1", "a2", "a3", "av", "avv", "av2", "av3"];
    let places = names
        .into_iter()
        .zip(Ratio::<f64>::TERMS)
        .zip(starts)
        .map(|((name, expression), start)| {
            let unit = unit::of_coefficient("y'", expression);
            place(name, ("y'", expression), &unit, start)
        })
        .collect();
    let shape = Shape {
        name: "ground-effect-ratio",
        form: Form::Ratio,
        equation: "f = T y, y' = Θ(y, z, v_p) ξ [1/s], z height above the deck [m], v_p deck velocity [m/s]",
        state: "y",
        rhs: format!(
            "a0 + ay*y + a1*{p1} + a2*{p2} + a3*{p3} + v_p*(av + avv*v_p + av2*{p2} + av3*{p3})"
        ),
        output: "T*y".to_string(),
        places,
        lag_s: |parameters| -1.0 / parameters[1],
    };
    fit(trials, settings, origin, &shape)
}

/// `y = G + k(z) v_p`, `G' = (h(z) - G)/tau`, `f = T y`.
pub(super) fn lag(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let lengths = settings.ground_effect.lengths_m;
    let (h, ..) = map_coefficients(trials, lengths)?;
    let [p1, p2, p3] = psi(lengths);
    let [lo, hi] = settings.ground_effect.lag_bounds_s;
    let tau = Parameter::free((1.0 / START_RATE).clamp(lo, hi)).within(lo, hi);
    let near = |start: f64| Parameter::free(start).prior(0.3);
    let shape = Shape {
        name: "ground-effect-lag",
        form: Form::Lag,
        equation: "f = T y, y = G + k(z) v_p, G' = (h(z) - G)/tau, z height above the deck [m], v_p deck velocity [m/s]",
        state: "g",
        rhs: format!("(h0 + h1*{p1} + h2*{p2} + h3*{p3} - g)/tau"),
        output: format!("T*(g + (k0 + k1*{p3})*v_p)"),
        places: vec![
            place("tau", ("tau", "1"), "s", tau),
            place("h0", ("h", "1"), "1", near(h[0])),
            place("h1", ("h", "psi1"), "1", near(h[1])),
            place("h2", ("h", "psi2"), "1", near(h[2])),
            place("h3", ("h", "psi3"), "1", near(h[3])),
            place("k0", ("k", "1"), "s/m", near(0.0)),
            place("k1", ("k", "psi3"), "s/m", near(0.0)),
        ],
        lag_s: |parameters| parameters[0],
    };
    fit(trials, settings, origin, &shape)
}

fn fit(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
    shape: &Shape,
) -> Result<FittedCard> {
    let names: Vec<&str> = shape.places.iter().map(|p| p.name).collect();
    let parameters: Vec<Parameter> = shape.places.iter().map(|p| p.start).collect();
    let model = OdeModel::new(
        &[shape.state],
        &["T", "z", "v_p"],
        &names,
        &[&shape.rhs],
        &shape.output,
    )?;
    let smooth = smooth_forces(trials, settings)?;
    let guesses: Vec<Vec<f64>> = trials
        .iter()
        .zip(&smooth)
        .map(|(t, smooth)| {
            let thrust = t.free_air_thrust_n.iter();
            smooth.iter().zip(thrust).map(|(f, t)| f / t).collect()
        })
        .collect();
    let records = records(trials, &guesses, |t| {
        [&t.free_air_thrust_n, &t.height_m, &t.deck_velocity_mps].map(Vec::as_slice)
    });
    let refined = refine(&model, &records, settings, START_SD, &parameters)?;
    let mut card = origin.card(shape.name, Kind::GroundEffect, shape.form, shape.equation);
    (card.constants, card.definitions) = psi_definitions(settings.ground_effect.lengths_m);
    let clusters = clusters(trials, names.len());
    for (j, place) in shape.places.iter().enumerate() {
        let estimate = Estimate::clustered(refined.parameters[j], refined.std_errors[j], clusters);
        card.terms
            .push(term(place.of, place.expression, estimate, &place.unit));
    }
    let lag_s = (shape.lag_s)(&refined.parameters);
    Ok(finish(card, trials, &refined, &names, lag_s, settings))
}

/// The terms of eq. (9), refined in free run from the coefficients of a regression.
pub(super) fn polynomial(
    trials: &[GroundTrial],
    terms: &[(&str, f64)],
    settings: &IdentificationSettings,
) -> Result<Refined> {
    let names: Vec<String> = (0..terms.len()).map(|k| format!("c{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let rhs: Vec<String> = terms
        .iter()
        .zip(&names)
        .map(|((term, _), name)| format!("{name}*({term})"))
        .collect();
    let model = OdeModel::new(
        &["f"],
        &["s", "z", "v_p", "v_q"],
        &names,
        &[&rhs.join(" + ")],
        "f",
    )?;
    // As in eq. (8): a prior of the coefficients' own size keeps the search from wandering along directions that
    // the data do not carry.
    let parameters: Vec<Parameter> = terms
        .iter()
        .map(|(_, v)| Parameter::free(*v).prior(v.abs().max(1.0)))
        .collect();
    let smooth = smooth_forces(trials, settings)?;
    let records = records(trials, &smooth, |t| {
        [
            &t.throttle,
            &t.height_m,
            &t.deck_velocity_mps,
            &t.vehicle_velocity_mps,
        ]
        .map(Vec::as_slice)
    });
    refine(&model, &records, settings, START_SD_N, &parameters)
}

fn smooth_forces(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
) -> Result<Vec<Vec<f64>>> {
    let filter = SavitzkyGolay::new(settings.smoothing.window, settings.smoothing.degree)?;
    trials
        .iter()
        .map(|t| Ok(t.smooth_force(&filter)?.value))
        .collect()
}

/// A record of each trial, with the inputs that `pick` takes from it; every trial is a group for standard errors.
fn records<'a, const N: usize>(
    trials: &'a [GroundTrial],
    guesses: &'a [Vec<f64>],
    pick: impl Fn(&'a GroundTrial) -> [&'a [f64]; N],
) -> Vec<Record<'a>> {
    trials
        .iter()
        .zip(guesses)
        .enumerate()
        .map(|(group, (trial, guess))| Record {
            time: &trial.time_s,
            inputs: pick(trial).to_vec(),
            measured: &trial.force_n,
            start: vec![guess],
            group,
        })
        .collect()
}

fn refine(
    model: &OdeModel,
    records: &[Record<'_>],
    settings: &IdentificationSettings,
    start_sd: f64,
    parameters: &[Parameter],
) -> Result<Refined> {
    // Over holes the model is integrated in steps that the shortest lag of the search allows.
    let step_s = 0.6 * settings.ground_effect.lag_bounds_s[0];
    let model = model.clone().with_max_step(step_s)?;
    let shooting = settings.shooting.build(start_sd);
    Ok(shooting.refine(&model, records, parameters)?)
}

/// Every trial is a group.
fn clusters(trials: &[GroundTrial], coefficients: usize) -> Clusters {
    Clusters {
        groups: trials.len(),
        coefficients,
    }
}

fn finish(
    mut card: touchdown_model::Card,
    trials: &[GroundTrial],
    refined: &Refined,
    names: &[&str],
    lag_s: f64,
    settings: &IdentificationSettings,
) -> FittedCard {
    card.provenance.method = method(&[
        (
            "fit",
            format!(
                "multiple shooting, windows of {} s every {} s, every {} samples, start of each window free",
                settings.shooting.window_s, settings.shooting.stride_s, settings.shooting.every
            ),
        ),
        ("start", "static map by least squares".into()),
        (
            "outcome",
            format!("{:?} after {} steps", refined.outcome, refined.iterations),
        ),
    ]);
    let mut warnings = Vec::new();
    for b in 0..names.len() {
        for a in 0..b {
            let r = refined.correlation[(a, b)];
            let velocity = |n: &str| n.contains('v') || n.starts_with('k');
            let memory = |n: &str| n == "tau" || n == "ay";
            let pair = memory(names[a]) && velocity(names[b]);
            if pair && r.abs() > CONFOUNDED {
                warnings.push(Warning::LagConfounded {
                    pair: [a, b].map(|k| names[k].to_string()),
                    correlation: r,
                });
            }
        }
    }
    let [lo, hi] = settings.ground_effect.lag_bounds_s;
    if lag_s <= lo * 1.001 || lag_s >= hi * 0.999 {
        warnings.push(Warning::LagAtBound { lag_s });
    }
    FittedCard {
        card,
        rmse: refined.rmse,
        rmse_unit: "N",
        rows_used: trials.iter().map(|t| t.time_s.len()).sum(),
        lag_s: Some(lag_s),
        front: None,
        warnings,
    }
}
