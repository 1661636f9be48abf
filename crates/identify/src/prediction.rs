//! Free-run prediction from a model card: the reference evaluation of every form, through expressions.

use sindy::OdeModel;
use sindy_expr::Expr;
use touchdown_model::card::{Card, Form};

use crate::error::{Error, Result};

/// Height of the saturation of eq. (2): as in flight.
const EMPIRICAL_MAX: &str = "0.6";

/// Longest step of an integration (s), whatever the card says: its nonlinear terms may be faster than its linear one.
/// A third of the usual lag of rotors, where a fourth-order step errs by less than 1e-4.
const LONGEST_STEP_S: f64 = 0.02;

/// A card, ready to predict over a record.
#[derive(Clone, Debug)]
pub struct Predictor {
    model: OdeModel,
    parameters: Vec<f64>,
    inputs: Vec<String>,
    clamps: Vec<Option<[f64; 2]>>,
    start: Start,
}

/// How the state at the start follows from the measured output there.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Start {
    /// No state.
    None,
    /// `x = √T`.
    RootOfThrust,
    /// The force itself.
    Force,
    /// Force over free-air thrust, less what the model gives without memory.
    Ratio,
}

/// The columns that predictions can be asked for, by the symbols of the cards.
#[derive(Clone, Copy, Debug, Default)]
pub struct Columns<'a> {
    /// Throttle `s`.
    pub throttle: &'a [f64],
    /// Height above the deck `z` (m).
    pub height_m: &'a [f64],
    /// Deck velocity `v_p` (m/s).
    pub deck_velocity_mps: &'a [f64],
    /// Vehicle velocity `v_q` (m/s).
    pub vehicle_velocity_mps: &'a [f64],
    /// Free-air thrust `T` (N).
    pub free_air_thrust_n: &'a [f64],
    /// Battery voltage `u` (V).
    pub battery_v: &'a [f64],
}

impl<'a> Columns<'a> {
    fn get(&self, symbol: &str) -> Option<(&'a [f64], &'static str)> {
        Some(match symbol {
            "s" => (self.throttle, "throttle"),
            "z" => (self.height_m, "height_m"),
            "v_p" => (self.deck_velocity_mps, "deck_velocity_mps"),
            "v_q" => (self.vehicle_velocity_mps, "vehicle_velocity_mps"),
            "T" => (self.free_air_thrust_n, "free-air thrust"),
            "u" => (self.battery_v, "battery_v"),
            _ => return None,
        })
    }
}

/// The equations of a card as expressions in its parameters `p0`, `p1`, ….
struct Equations {
    /// The state's name; none for maps without memory.
    state: Option<&'static str>,
    /// Its rate.
    rhs: Option<String>,
    /// Thrust or force (N).
    output: String,
    start: Start,
}

impl Equations {
    /// A form whose state is `x = √T`.
    fn of_root(rhs: String) -> Self {
        Self {
            state: Some("x"),
            rhs: Some(rhs),
            output: "x*abs(x)".to_string(),
            start: Start::RootOfThrust,
        }
    }

    /// A form without memory.
    fn at_rest(output: String) -> Self {
        Self {
            state: None,
            rhs: None,
            output,
            start: Start::None,
        }
    }

    fn with_memory(state: &'static str, rhs: String, output: String, start: Start) -> Self {
        Self {
            state: Some(state),
            rhs: Some(rhs),
            output,
            start,
        }
    }

    fn of(parts: &mut Parts<'_>) -> Result<Self> {
        let card = parts.card;
        Ok(match card.form {
            // Eq. (8).
            Form::Library => Self::of_root(parts.sum("x'")?),
            // Eq. (7).
            Form::FirstOrder => {
                let (c0, c1, t_m) = (
                    parts.single("c0")?,
                    parts.single("c1")?,
                    parts.single("T_m")?,
                );
                Self::of_root(format!("({c0}*s + {c1} - x)/{t_m}"))
            }
            Form::StaticSqrt => {
                let map = parts.sum("x")?;
                if card.terms_of("T_m").next().is_some() {
                    let t_m = parts.single("T_m")?;
                    Self::of_root(format!("({map} - x)/{t_m}"))
                } else {
                    Self::at_rest(format!("({map})*abs({map})"))
                }
            }
            Form::StaticThrust => Self::at_rest(parts.sum("T")?),
            // Eq. (2).
            Form::Empirical => {
                let mu = parts.single("mu")?;
                let constant = |name: &str| card.constants.get(name).copied().unwrap_or(0.0);
                let (r, h_r) = (constant("r"), constant("h_r"));
                let q = format!("min({mu}*({r}/(4*(z + {h_r})))^2, {EMPIRICAL_MAX})");
                Self::at_rest(format!("T*{q}/(1 - {q})"))
            }
            Form::Static => Self::at_rest(format!("T*({})", parts.sum("h")?)),
            // Eq. (9).
            Form::Derivative => {
                let rhs = parts.sum("f'")?;
                Self::with_memory("f", rhs, "f".to_string(), Start::Force)
            }
            Form::Ratio => {
                let rhs = parts.sum("y'")?;
                Self::with_memory("y", rhs, "T*y".to_string(), Start::Ratio)
            }
            Form::Lag => {
                let (tau, h, k) = (parts.single("tau")?, parts.sum("h")?, parts.sum("k")?);
                let output = format!("T*(g + ({k})*v_p)");
                Self::with_memory("g", format!("({h} - g)/{tau}"), output, Start::Ratio)
            }
            Form::LaggedMotors | Form::RotorLag => {
                return Err(Error::data(
                    &card.name,
                    "a form that predicts from one throttle",
                    format!("{:?}", card.form),
                ));
            }
        })
    }
}

impl Predictor {
    /// Prepares a card.
    ///
    /// # Errors
    /// A form that is not predicted from throttle, height and velocities, or a term with a name that
    /// means nothing.
    pub fn new(card: &Card) -> Result<Self> {
        let mut parts = Parts {
            card,
            parameters: Vec::new(),
        };
        let equations = Equations::of(&mut parts)?;
        let parse = |text: &str| {
            Expr::parse(text)
                .map(|e| parts.expand(&e))
                .map_err(|e| Error::data(&card.name, "an expression", format!("`{text}`: {e}")))
        };
        let output = parse(&equations.output)?;
        let rhs = equations.rhs.as_deref().map(parse).transpose()?;
        let names: Vec<String> = (0..parts.parameters.len())
            .map(|i| format!("p{i}"))
            .collect();
        let mut inputs: Vec<String> = rhs
            .iter()
            .chain([&output])
            .flat_map(|e| e.variables().into_iter().map(String::from))
            .filter(|v| equations.state != Some(v.as_str()) && !names.contains(v))
            .collect();
        inputs.sort();
        inputs.dedup();
        if let Some(unknown) = inputs.iter().find(|v| Columns::default().get(v).is_none()) {
            return Err(Error::data(
                &card.name,
                "terms in s, z, v_p, v_q, T, u and the state",
                format!("the name `{unknown}`"),
            ));
        }
        let clamps = inputs
            .iter()
            .map(|v| card.validity.inputs.get(v).copied())
            .collect();
        let rhs: Vec<String> = rhs.iter().map(ToString::to_string).collect();
        let model = OdeModel::new(
            equations.state.as_slice(),
            &as_strs(&inputs),
            &as_strs(&names),
            &as_strs(&rhs),
            &output.to_string(),
        )?;
        let model = model.with_max_step(max_step_s(card))?;
        Ok(Self {
            model,
            parameters: parts.parameters,
            inputs,
            clamps,
            start: equations.start,
        })
    }

    /// The predicted output (N) over a record, from the measured output at its start. Height is clamped
    /// to the card's validity box.
    ///
    /// # Errors
    /// A column that the card needs and that is not there.
    pub fn run(
        &self,
        name: &str,
        time: &[f64],
        columns: &Columns<'_>,
        start_n: f64,
    ) -> Result<Vec<f64>> {
        let mut owned: Vec<Vec<f64>> = Vec::with_capacity(self.inputs.len());
        for (symbol, clamp) in self.inputs.iter().zip(&self.clamps) {
            let (column, channel) = columns.get(symbol).unwrap_or((&[], "unknown"));
            if column.len() != time.len() {
                return Err(Error::data(name, format!("a channel `{channel}`"), "none"));
            }
            owned.push(match clamp {
                Some([lo, hi]) if symbol == "z" => {
                    column.iter().map(|v| v.clamp(*lo, *hi)).collect()
                }
                _ => column.to_vec(),
            });
        }
        let inputs: Vec<&[f64]> = owned.iter().map(Vec::as_slice).collect();
        let start = match self.start {
            Start::None => Vec::new(),
            Start::RootOfThrust => vec![start_n.max(0.0).sqrt()],
            Start::Force => vec![start_n],
            Start::Ratio => {
                // What the model gives without memory (the lag form's velocity term) is not in its state.
                let first: Vec<&[f64]> = inputs.iter().map(|c| c.get(..1).unwrap_or(c)).collect();
                let moment = self.model.free_run(
                    &self.parameters,
                    &[0.0],
                    time.get(..1).unwrap_or(time),
                    &first,
                )?;
                let thrust_n = columns
                    .free_air_thrust_n
                    .first()
                    .copied()
                    .unwrap_or(f64::NAN);
                vec![(start_n - moment.first().copied().unwrap_or(0.0)) / thrust_n]
            }
        };
        Ok(self
            .model
            .free_run(&self.parameters, &start, time, &inputs)?)
    }
}

fn as_strs(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

/// The terms of a card, as text with a parameter in place of each value.
struct Parts<'a> {
    card: &'a Card,
    parameters: Vec<f64>,
}

impl Parts<'_> {
    fn parameter(&mut self, value: f64) -> String {
        self.parameters.push(value);
        format!("p{}", self.parameters.len() - 1)
    }

    fn single(&mut self, of: &str) -> Result<String> {
        let values: Vec<f64> = self.card.terms_of(of).map(|t| t.value).collect();
        match values[..] {
            [value] => Ok(self.parameter(value)),
            _ => Err(Error::data(
                &self.card.name,
                format!("one term of `{of}`"),
                values.len().to_string(),
            )),
        }
    }

    fn sum(&mut self, of: &str) -> Result<String> {
        let card = self.card;
        let terms: Vec<String> = card
            .terms_of(of)
            .map(|t| format!("{}*({})", self.parameter(t.value), t.expression))
            .collect();
        if terms.is_empty() {
            return Err(Error::data(&card.name, format!("terms of `{of}`"), "none"));
        }
        Ok(format!("({})", terms.join(" + ")))
    }

    /// Replaces definitions, then constants.
    fn expand(&self, expr: &Expr) -> Expr {
        let mut out = expr.clone();
        for (name, text) in &self.card.definitions {
            if let Ok(by) = Expr::parse(text) {
                out = out.substitute(name, &by);
            }
        }
        for (name, value) in &self.card.constants {
            out = out.substitute(name, &Expr::constant(*value));
        }
        out
    }
}

/// Half of the fastest time constant that a card names (s): what one step of the integration may span.
fn max_step_s(card: &Card) -> f64 {
    let lags = ["T_m", "tau"].map(|of| card.coefficient(of, "1"));
    let rates =
        [("x'", "x"), ("f'", "f"), ("y'", "y")].map(|(of, x)| -1.0 / card.coefficient(of, x));
    let fastest = lags
        .into_iter()
        .chain(rates)
        .filter(|t| *t > 0.0)
        .fold(f64::INFINITY, f64::min);
    (0.5 * fastest).min(LONGEST_STEP_S)
}
