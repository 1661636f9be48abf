//! Free-run prediction from a model card: the reference evaluation of every form, through expressions.

use sindy::OdeModel;
use sindy_expr::Expr;
use touchdown_model::CardError;
use touchdown_model::card::Card;
use touchdown_model::catalogue::Start;

use crate::error::{Error, Result};

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

impl Predictor {
    /// Prepares a card.
    ///
    /// # Errors
    /// A form that is not predicted from throttle, height and velocities, or a term with a name that
    /// means nothing.
    pub fn new(card: &Card) -> Result<Self> {
        let equations = card.equations().map_err(|error| match error {
            CardError::Value {
                expected, found, ..
            } => Error::data(&card.name, expected, found),
            other => other.into(),
        })?;
        let parse = |text: &str| {
            Expr::parse(text)
                .map(|e| expand(card, &e))
                .map_err(|e| Error::data(&card.name, "an expression", format!("`{text}`: {e}")))
        };
        let output = parse(&equations.output)?;
        let rhs = equations.rate.as_deref().map(parse).transpose()?;
        let names: Vec<String> = (0..equations.parameters.len())
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
            parameters: equations.parameters,
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

/// Replaces a card's definitions, then its constants.
fn expand(card: &Card, expr: &Expr) -> Expr {
    let mut out = expr.clone();
    for (name, text) in &card.definitions {
        if let Ok(by) = Expr::parse(text) {
            out = out.substitute(name, &by);
        }
    }
    for (name, value) in &card.constants {
        out = out.substitute(name, &Expr::constant(*value));
    }
    out
}

/// The time constants that a card names (s).
pub(crate) fn time_constants_s(card: &Card) -> impl Iterator<Item = f64> {
    let lags = ["T_m", "tau"].map(|of| card.coefficient(of, "1"));
    let rates =
        [("x'", "x"), ("f'", "f"), ("y'", "y")].map(|(of, x)| -1.0 / card.coefficient(of, x));
    lags.into_iter()
        .chain(rates)
        .filter(|t| *t > 0.0 && t.is_finite())
}

/// Half of the fastest time constant that a card names (s): what one step of the integration may span.
fn max_step_s(card: &Card) -> f64 {
    let fastest = time_constants_s(card).fold(f64::INFINITY, f64::min);
    (0.5 * fastest).min(LONGEST_STEP_S)
}
