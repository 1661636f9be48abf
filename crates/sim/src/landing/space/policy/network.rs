//! A policy: layers of a network, and what its numbers mean.

use serde::{Deserialize, Serialize};

use super::action::ActionSettings;
use super::observation::Observation;
use crate::check;
use crate::error::SimError;

/// The schema of policies that this version reads and writes.
const SCHEMA: u32 = 1;
/// The most layers, and the most outputs of one.
const LAYERS: usize = 16;
const OUTPUTS: usize = 4096;
/// The most weights: as JSON they take some 10 MB, and the text of a policy is at most 16 MiB.
const WEIGHTS: usize = 500_000;
/// The largest size of a number of a policy. With it every action is finite: 16 layers of 4096 outputs stay below 1e155 times the
/// observation. Networks that learned something are far below; a thousandth of it would refuse scales of small numbers.
const LARGEST: f64 = 1e6;

/// A learned policy, as its file has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicySettings {
    /// Schema of the file: 1.
    pub schema: u32,
    /// Time between two decisions, s.
    pub decision_s: f64,
    /// From actions to commands.
    pub action: ActionSettings,
    /// From the numbers of an observation to the input of the first layer.
    pub input: InputSettings,
    /// The layers. The output of the last is the action.
    pub layers: Vec<LayerSettings>,
}

/// Input k of the first layer is `(observation[k] - offset[k]) scale[k]`, within ±`limit`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputSettings {
    /// What is subtracted.
    pub offset: Vec<f64>,
    /// What is multiplied with.
    pub scale: Vec<f64>,
    /// Limit of the input's size; none without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
}

/// A layer: `activation(weights input + bias)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerSettings {
    /// A row for each output, of a number for each input.
    pub weights: Vec<Vec<f64>>,
    /// A number for each output.
    pub bias: Vec<f64>,
    /// What is applied to each output.
    pub activation: Activation,
}

impl LayerSettings {
    /// Number of its weights.
    #[must_use]
    pub fn weights(&self) -> usize {
        self.weights.iter().map(Vec::len).sum()
    }
}

/// Function of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// The output itself.
    Linear,
    /// Hyperbolic tangent.
    Tanh,
    /// The output where it is positive, else 0.
    Relu,
}

impl Activation {
    fn of(self, x: f64) -> f64 {
        match self {
            Self::Linear => x,
            Self::Tanh => libm::tanh(x),
            // NaN stays.
            Self::Relu if x <= 0.0 => 0.0,
            Self::Relu => x,
        }
    }
}

/// A policy that has been checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Policy {
    settings: PolicySettings,
}

impl Policy {
    /// Checks a policy.
    ///
    /// # Errors
    /// Layers that do not fit one another, the observation or the action, and numbers that are no number or larger than 1e6, by
    /// their key, what is expected and what was found.
    pub fn new(settings: PolicySettings) -> Result<Self, SimError> {
        let schema = settings.schema;
        check::that(
            schema == SCHEMA,
            "schema",
            &SCHEMA.to_string(),
            f64::from(schema),
        )?;
        check::period("decision_s", settings.decision_s, 1.0)?;
        settings
            .action
            .validate()
            .map_err(|e| e.in_section("action"))?;
        let input = &settings.input;
        for (key, values) in [("offset", &input.offset), ("scale", &input.scale)] {
            numbers(&format!("input.{key}"), values, Observation::NUMBERS)?;
        }
        if let Some(limit) = input.limit {
            check::positive("input.limit", limit)?;
        }
        let count = settings.layers.len();
        let expected = format!("1 to {LAYERS} layers");
        check::that(
            (1..=LAYERS).contains(&count),
            "layers",
            &expected,
            count as f64,
        )?;
        let mut inputs = Observation::NUMBERS;
        for (k, layer) in settings.layers.iter().enumerate() {
            let outputs = layer.weights.len();
            let (least, most) = match k + 1 == count {
                true => (
                    settings.action.kind.numbers(),
                    settings.action.kind.numbers(),
                ),
                false => (1, OUTPUTS),
            };
            let expected = match k + 1 == count {
                true => format!("{most} rows, one for each number of the action"),
                false => format!("1 to {OUTPUTS} rows"),
            };
            let key = format!("layers.{k}.weights");
            check::that(
                (least..=most).contains(&outputs),
                &key,
                &expected,
                outputs as f64,
            )?;
            for (i, row) in layer.weights.iter().enumerate() {
                numbers(&format!("{key}.{i}"), row, inputs)?;
            }
            numbers(&format!("layers.{k}.bias"), &layer.bias, outputs)?;
            inputs = outputs;
        }
        let weights: usize = settings.layers.iter().map(LayerSettings::weights).sum();
        let expected = format!("at most {WEIGHTS} weights");
        check::that(weights <= WEIGHTS, "layers", &expected, weights as f64)?;
        Ok(Self { settings })
    }

    /// What it was made of.
    #[must_use]
    pub fn settings(&self) -> &PolicySettings {
        &self.settings
    }

    /// The action for an observation, before it is limited to [-1, 1].
    #[must_use]
    pub fn action(&self, observation: &[f64; Observation::NUMBERS]) -> Vec<f64> {
        let input = &self.settings.input;
        let limit = input.limit.unwrap_or(f64::INFINITY);
        let mut values: Vec<f64> = (observation.iter().zip(&input.offset))
            .zip(&input.scale)
            .map(|((x, offset), scale)| ((x - offset) * scale).clamp(-limit, limit))
            .collect();
        for layer in &self.settings.layers {
            values = (layer.weights.iter().zip(&layer.bias))
                .map(|(row, bias)| {
                    let sum: f64 = row.iter().zip(&values).map(|(w, x)| w * x).sum();
                    layer.activation.of(sum + bias)
                })
                .collect();
        }
        values
    }
}

/// So many numbers.
fn numbers(key: &str, values: &[f64], count: usize) -> Result<(), SimError> {
    let expected = format!("{count} numbers");
    check::that(values.len() == count, key, &expected, values.len() as f64)?;
    match values.iter().find(|value| !(value.abs() <= LARGEST)) {
        // 1e300 rather than three hundred digits.
        Some(value) => Err(check::fail(
            key,
            "a number from -1e6 to 1e6",
            &format!("{value:?}"),
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(weights: Vec<Vec<f64>>, bias: Vec<f64>, activation: Activation) -> LayerSettings {
        LayerSettings {
            weights,
            bias,
            activation,
        }
    }

    /// Thrust alone, from height and its rate through two layers.
    fn settings() -> PolicySettings {
        let mut first = vec![0.0; 19];
        first[2] = 1.0;
        let mut second = vec![0.0; 19];
        second[5] = -2.0;
        let mut offset = vec![0.0; 19];
        offset[2] = 0.1;
        PolicySettings {
            schema: 1,
            decision_s: 0.04,
            action: ActionSettings {
                kind: crate::landing::space::ActionKind::Thrust,
                ..ActionSettings::default()
            },
            input: InputSettings {
                offset,
                scale: vec![1.0; 19],
                limit: Some(3.0),
            },
            layers: vec![
                layer(vec![first, second], vec![0.0, 0.5], Activation::Relu),
                layer(vec![vec![-0.5, 0.25]], vec![0.1], Activation::Tanh),
            ],
        }
    }

    #[test]
    fn analytic_the_action_of_a_small_network() {
        let policy = Policy::new(settings()).unwrap();
        let action = |height: f64, rate: f64| {
            let mut observation = [0.0; 19];
            (observation[2], observation[5]) = (height, rate);
            policy.action(&observation)[0]
        };
        // 1.1 m, sinking at 0.4 m/s: relu(1.0), relu(0.8 + 0.5).
        let by_hand = |a: f64, b: f64| (-0.5 * a + 0.25 * b + 0.1).tanh();
        // Sums of three terms below 1 round to a few last bits.
        assert!((action(1.1, -0.4) - by_hand(1.0, 1.3)).abs() < 1e-15);
        // Rising: the second is 0. 90 m: the first is limited.
        assert!((action(90.0, 0.9) - by_hand(3.0, 0.0)).abs() < 1e-15);
    }

    #[test]
    fn analytic_the_largest_network_has_a_finite_action() {
        let mut largest = settings();
        largest.input.limit = None;
        largest.input.scale = vec![LARGEST; 19];
        let wide = |inputs, outputs| {
            let weights = vec![vec![LARGEST; inputs]; outputs];
            layer(weights, vec![LARGEST; outputs], Activation::Linear)
        };
        // 64 outputs in the place of 4096: the bound of LARGEST holds for these, too.
        largest.layers = vec![wide(19, 64)];
        largest.layers.extend((2..LAYERS).map(|_| wide(64, 64)));
        largest.layers.push(wide(64, 1));
        let action = Policy::new(largest).unwrap().action(&[1e100; 19])[0];
        assert!(action.is_finite() && action > 1e150, "{action}");
    }

    #[test]
    fn prop_a_policy_has_a_greatest_number_of_weights() {
        let of = |width: usize| {
            let mut wide = settings();
            let zeros = |inputs, outputs| {
                let weights = vec![vec![0.0; inputs]; outputs];
                layer(weights, vec![0.0; outputs], Activation::Tanh)
            };
            wide.layers = vec![zeros(19, width), zeros(width, width), zeros(width, 1)];
            Policy::new(wide)
        };
        // 19 w + w² + w.
        assert!(of(697).is_ok());
        let error = of(698).unwrap_err().to_string();
        assert!(
            error.contains("`layers`") && error.contains("500000"),
            "{error}"
        );
    }

    #[test]
    fn prop_what_does_not_fit_is_refused_by_its_key() {
        type Spoil = fn(&mut PolicySettings);
        let cases: [(&str, Spoil); 11] = [
            ("layers.1.weights.0", |s| s.layers[1].weights[0][1] = -2e6),
            ("schema", |s| s.schema = 2),
            ("decision_s", |s| s.decision_s = 0.0),
            ("action.tilt_rad", |s| s.action.tilt_rad = 2.0),
            ("input.scale", |s| s.input.scale.truncate(3)),
            ("input.offset", |s| s.input.offset[4] = f64::NAN),
            ("input.limit", |s| s.input.limit = Some(-1.0)),
            ("layers", |s| s.layers.clear()),
            ("layers.1.weights", |s| {
                s.layers[1].weights.push(vec![0.0; 2]);
            }),
            ("layers.1.weights.0", |s| s.layers[1].weights[0].push(0.0)),
            ("layers.0.bias", |s| s.layers[0].bias[1] = f64::INFINITY),
        ];
        for (key, spoil) in cases {
            let mut bad = settings();
            spoil(&mut bad);
            let error = Policy::new(bad).unwrap_err().to_string();
            assert!(error.contains(&format!("`{key}`")), "{key}: {error}");
        }
    }
}
