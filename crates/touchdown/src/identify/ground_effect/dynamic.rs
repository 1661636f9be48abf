//! Forms with memory, refined by multiple shooting: the ratio form and the lag form.

use sindy::SavitzkyGolay;
use sindy::shooting::{OdeModel, Parameter, Record, Refined};
use touchdown_flight::ground_effect::Ratio;
use touchdown_model::flight::psi_definitions;
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use super::statics::{map_coefficients, psi};
use crate::error::Result;
use crate::identify::making::{Made, Origin, method, term};
use crate::identify::settings::IdentificationSettings;
use crate::identify::unit;

/// Rate at which the searches start: a wake lag of 0.25 s.
const START_RATE: f64 = 4.0;
/// Standard deviation of the prior on a window's start, in units of f/T.
const START_SD: f64 = 0.05;
/// Correlation of two estimates from which they count as confounded.
const CONFOUNDED: f64 = 0.95;

/// `y' = Θ(y, z, v_p) ξ`, `f = T y`.
pub(super) fn ratio(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<Made> {
    let lengths = settings.ground_effect.lengths_m;
    let (h, ..) = map_coefficients(trials, lengths)?;
    let [p1, p2, p3] = psi(lengths);
    let names = ["a0", "ay", "a1", "a2", "a3", "av", "avv", "av2", "av3"];
    let rhs = format!(
        "a0 + ay*y + a1*{p1} + a2*{p2} + a3*{p3} + v_p*(av + avv*v_p + av2*{p2} + av3*{p3})"
    );
    let model = OdeModel::new(&["y"], &["T", "z", "v_p"], &names, &[&rhs], "T*y")?;
    let rate = START_RATE;
    // A prior as wide as the coefficients can be keeps what the data do not carry near the static map.
    let parameters = [
        Parameter::free(rate * h[0]).prior(1.0),
        Parameter::free(-rate).within(
            -1.0 / settings.ground_effect.lag_bounds_s[0],
            -1.0 / settings.ground_effect.lag_bounds_s[1],
        ),
        Parameter::free(rate * h[1]).prior(1.0),
        Parameter::free(rate * h[2]).prior(1.0),
        Parameter::free(rate * h[3]).prior(1.0),
        Parameter::free(0.0).prior(1.0),
        Parameter::free(0.0).prior(3.0),
        Parameter::free(0.0).prior(3.0),
        Parameter::free(0.0).prior(3.0),
    ];
    let refined = refine(trials, settings, model, &parameters)?;
    let mut card = origin.card(
        "ground-effect-ratio",
        Kind::GroundEffect,
        Form::Ratio,
        "f = T y, y' = Θ(y, z, v_p) ξ [1/s], z height above the deck [m], v_p deck velocity [m/s]",
    );
    (card.constants, card.definitions) = psi_definitions(lengths);
    for (j, name) in Ratio::<f64>::TERMS.into_iter().enumerate() {
        let unit = unit::of_coefficient("y'", name);
        card.terms.push(term(
            "y'",
            name,
            refined.parameters[j],
            refined.std_errors[j],
            &unit,
        ));
    }
    let lag_s = -1.0 / refined.parameters[1];
    Ok(finish(card, trials, &refined, &names, lag_s, settings))
}

/// `y = G + k(z) v_p`, `G' = (h(z) - G)/tau`, `f = T y`.
pub(super) fn lag(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<Made> {
    let lengths = settings.ground_effect.lengths_m;
    let (h, ..) = map_coefficients(trials, lengths)?;
    let [p1, p2, p3] = psi(lengths);
    let names = ["tau", "h0", "h1", "h2", "h3", "k0", "k1"];
    let rhs = format!("(h0 + h1*{p1} + h2*{p2} + h3*{p3} - g)/tau");
    let output = format!("T*(g + (k0 + k1*{p3})*v_p)");
    let model = OdeModel::new(&["g"], &["T", "z", "v_p"], &names, &[&rhs], &output)?;
    let [lo, hi] = settings.ground_effect.lag_bounds_s;
    let parameters = [
        Parameter::free((1.0 / START_RATE).clamp(lo, hi)).within(lo, hi),
        Parameter::free(h[0]).prior(0.3),
        Parameter::free(h[1]).prior(0.3),
        Parameter::free(h[2]).prior(0.3),
        Parameter::free(h[3]).prior(0.3),
        Parameter::free(0.0).prior(0.3),
        Parameter::free(0.0).prior(0.3),
    ];
    let refined = refine(trials, settings, model, &parameters)?;
    let mut card = origin.card(
        "ground-effect-lag",
        Kind::GroundEffect,
        Form::Lag,
        "f = T y, y = G + k(z) v_p, G' = (h(z) - G)/tau, z height above the deck [m], v_p deck velocity [m/s]",
    );
    (card.constants, card.definitions) = psi_definitions(lengths);
    let places = [
        ("tau", "1", "s"),
        ("h", "1", "1"),
        ("h", "psi1", "1"),
        ("h", "psi2", "1"),
        ("h", "psi3", "1"),
        ("k", "1", "s/m"),
        ("k", "psi3", "s/m"),
    ];
    for (j, (of, expression, unit)) in places.into_iter().enumerate() {
        card.terms.push(term(
            of,
            expression,
            refined.parameters[j],
            refined.std_errors[j],
            unit,
        ));
    }
    let lag_s = refined.parameters[0];
    Ok(finish(card, trials, &refined, &names, lag_s, settings))
}

fn refine(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    model: OdeModel,
    parameters: &[Parameter],
) -> Result<Refined> {
    // Over holes the model is integrated in steps that the shortest lag of the search allows.
    let model = model.with_max_step(0.6 * settings.ground_effect.lag_bounds_s[0])?;
    let filter = SavitzkyGolay::new(settings.smoothing.window, settings.smoothing.degree)?;
    let guesses: Vec<Vec<f64>> = trials
        .iter()
        .map(|t| {
            let smooth = t.smooth_force(&filter)?.value;
            Ok(smooth
                .iter()
                .zip(&t.free_air_thrust_n)
                .map(|(f, t)| f / t)
                .collect())
        })
        .collect::<Result<_>>()?;
    let records: Vec<Record<'_>> = trials
        .iter()
        .zip(&guesses)
        .enumerate()
        .map(|(group, (t, guess))| Record {
            time: &t.time_s,
            inputs: vec![&t.free_air_thrust_n, &t.height_m, &t.deck_velocity_mps],
            measured: &t.force_n,
            start: vec![guess],
            group,
        })
        .collect();
    Ok(settings
        .shooting
        .build(START_SD)
        .refine(&model, &records, parameters)?)
}

fn finish(
    mut card: touchdown_model::Card,
    trials: &[GroundTrial],
    refined: &Refined,
    names: &[&str],
    lag_s: f64,
    settings: &IdentificationSettings,
) -> Made {
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
                warnings.push(format!(
                    "lag and deck velocity are confounded: the estimates of `{}` and `{}` correlate with {r:.2}",
                    names[a], names[b]
                ));
            }
        }
    }
    let [lo, hi] = settings.ground_effect.lag_bounds_s;
    if lag_s <= lo * 1.001 || lag_s >= hi * 0.999 {
        warnings.push(format!(
            "the lag {lag_s:.3} s sits at its bound: the data do not carry it"
        ));
    }
    Made {
        card,
        rmse: refined.rmse,
        rmse_unit: "N",
        rows_used: trials.iter().map(|t| t.time_s.len()).sum(),
        lag_s: Some(lag_s),
        warnings,
    }
}
