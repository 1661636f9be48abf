//! The forms with memory that can be fitted: for each its equations, its parameters and where their search starts.

use sindy::trajectory::shooting::Parameter;
use touchdown_flight::ground_effect::Ratio;
use touchdown_model::{Form, unit};

use super::{DynamicForm, Place};
use crate::error::{Error, Result};
use crate::rig::GroundTrial;
use crate::rig::statics::{StaticMap, psi};
use crate::settings::IdentificationSettings;

/// Rate at which the searches start: a wake lag of 0.25 s.
/// The middle of the lags of small rotors in the logarithm; the search is free from there.
const START_RATE: f64 = 4.0;
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

impl DynamicForm {
    /// The form of that name in the catalogue.
    pub(super) fn of(
        form: Form,
        trials: &[GroundTrial],
        settings: &IdentificationSettings,
    ) -> Result<Self> {
        match form {
            Form::Ratio => Self::ratio(trials, settings),
            Form::Lag => Self::lag(trials, settings),
            other => Err(Error::not_fitted(other)),
        }
    }

    /// `y' = Θ(y, z, v_p) ξ`, `f = T y`; the search starts at the static map.
    fn ratio(trials: &[GroundTrial], settings: &IdentificationSettings) -> Result<Self> {
        let lengths = settings.ground_effect.lengths_m();
        let h = StaticMap::fit(trials, lengths)?.coefficients();
        let [p1, p2, p3] = psi(lengths);
        let rate = START_RATE;
        let [lo, hi] = settings.ground_effect.lag_bounds_s;
        // A prior as wide as the coefficients can be keeps those that the data do not identify near the static map.
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
        Ok(Self {
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
        })
    }

    /// `y = G + k(z) v_p`, `G' = (h(z) - G)/tau`, `f = T y`; the search starts at the static map.
    fn lag(trials: &[GroundTrial], settings: &IdentificationSettings) -> Result<Self> {
        let lengths = settings.ground_effect.lengths_m();
        let h = StaticMap::fit(trials, lengths)?.coefficients();
        let [p1, p2, p3] = psi(lengths);
        let [lo, hi] = settings.ground_effect.lag_bounds_s;
        let tau = Parameter::free((1.0 / START_RATE).clamp(lo, hi)).within(lo, hi);
        let near = |start: f64| Parameter::free(start).prior(0.3);
        Ok(Self {
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
        })
    }
}
