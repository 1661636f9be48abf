//! Card to flight model: the families that a flight computer carries.

use std::collections::BTreeMap;

use touchdown_flight::ground_effect::{GroundEffect as _, Guarded, Validity};
use touchdown_flight::thrust::ThrustModel;

use crate::card::{Card, Form, Kind};
use crate::catalogue::{ASSUMED_LAG_S, DEAD_TIME, Terms};
use crate::error::CardError;

/// Names of the bounded functions of height, `psi_i = 1/(1 + (z/l_i)²)`, and of their lengths.
const PSI: [(&str, &str); 3] = [("psi1", "l1"), ("psi2", "l2"), ("psi3", "l3")];

/// Ratio limits in flight where a card names none.
const RATIO_LIMITS: [f64; 2] = [-0.1, 0.6];

/// The constants and definitions that cards with bounded functions of height carry.
#[must_use]
pub fn psi_definitions(lengths_m: [f64; 3]) -> (BTreeMap<String, f64>, BTreeMap<String, String>) {
    let constants = PSI
        .iter()
        .zip(lengths_m)
        .map(|((_, l), v)| ((*l).to_string(), v))
        .collect();
    let definitions = PSI
        .iter()
        .map(|(p, l)| ((*p).to_string(), psi_text(l)))
        .collect();
    (constants, definitions)
}

fn psi_text(length: &str) -> String {
    format!("1/(1 + (z/{length})^2)")
}

impl Card {
    /// The flight model of a thrust card for a vehicle of `rotors` rotors (or as many as the card says that it has): the
    /// thrust that was measured, times rotors of the vehicle over rotors measured. All rotors get the same throttle.
    ///
    /// # Errors
    /// As of [`Self::thrust_model`], and a card of some rotors for a vehicle of an unknown number.
    pub fn thrust_model_of(&self, rotors: Option<u32>) -> Result<ThrustModel<f64>, CardError> {
        let model = self.thrust_model()?;
        let Some(measured) = self.measured_rotors else {
            return Ok(model);
        };
        let rotors = rotors.or(self.vehicle.rotors).ok_or_else(|| {
            self.not_for_flight(&format!(
                "its thrust is that of {measured} rotor{}; how many has the vehicle? Set `rotors` in [vehicle]",
                if measured == 1 { "" } else { "s" }
            ))
        })?;
        Ok(model.of_rotors(f64::from(rotors) / f64::from(measured)))
    }

    /// The flight model of a thrust card, of the rotors that were measured.
    ///
    /// # Errors
    /// A card of another kind, or a form or term that no flight family holds.
    pub fn thrust_model(&self) -> Result<ThrustModel<f64>, CardError> {
        if self.kind != Kind::Thrust {
            return Err(
                self.not_for_flight("a thrust card is expected, this is one of ground effect")
            );
        }
        self.check_divergence()?;
        let model = self.form.thrust_kernel(self)?;
        self.check_parts()?;
        model
            .validate()
            .map_err(|e| self.not_for_flight(&e.to_string()))?;
        Ok(model)
    }

    /// The flight model of a ground-effect card, within its validity box.
    ///
    /// # Errors
    /// A card of another kind, or a form or term that no flight family holds.
    pub fn ground_effect(&self) -> Result<Guarded<f64>, CardError> {
        if self.kind != Kind::GroundEffect {
            return Err(
                self.not_for_flight("a ground-effect card is expected, this is one of thrust")
            );
        }
        self.check_divergence()?;
        let model = self.form.ground_effect_kernel(self)?;
        self.check_parts()?;
        let [height_min_m, height_max_m] =
            *self.validity.inputs.get("z").ok_or_else(|| {
                self.not_for_flight("the validity box has no range of heights `z`")
            })?;
        let [ratio_min, ratio_max] = match self.form {
            Form::Derivative => RATIO_LIMITS,
            _ => self.validity.output.unwrap_or(RATIO_LIMITS),
        };
        let guarded = Guarded {
            model,
            validity: Validity {
                height_min_m,
                height_max_m,
                ratio_min,
                ratio_max,
                outside: self.validity.outside,
            },
            velocity: self.validity.velocity_input.unwrap_or_default(),
        };
        guarded
            .validate()
            .map_err(|e| self.not_for_flight(&e.to_string()))?;
        Ok(guarded)
    }
}

impl Card {
    fn check_divergence(&self) -> Result<(), CardError> {
        if self.diverged {
            return Err(self.not_for_flight(
                "its free run leaves the data that it was fitted to; identify it with another form",
            ));
        }
        Ok(())
    }

    /// Checks that every term belongs to a part that flies.
    fn check_parts(&self) -> Result<(), CardError> {
        let known = self.form.part_names();
        let unknown = |of: &str| !known.contains(&of) && of != DEAD_TIME;
        match (0..).zip(&self.terms).find(|(_, term)| unknown(&term.of)) {
            None => Ok(()),
            Some((i, term)) => Err(CardError::Value {
                card: self.name.clone(),
                key: format!("terms[{i}].of"),
                expected: format!("a part of form {}: {}", self.form.name(), known.join(", ")),
                found: format!("`{}`", term.of),
            }),
        }
    }

    /// The motor lag that flies where the card has none, s.
    #[must_use]
    pub fn assumed_lag_s(&self) -> Option<f64> {
        let assumed = match self.form {
            Form::StaticThrust => true,
            Form::StaticSqrt => self.terms_of("T_m").next().is_none(),
            _ => false,
        };
        assumed.then_some(ASSUMED_LAG_S)
    }

    /// The battery voltage at which a card flies whose thrust depends on it, V.
    pub(crate) fn flown_battery_v(&self) -> Option<Result<f64, CardError>> {
        self.terms
            .iter()
            .any(|term| without_battery(&term.expression).is_some())
            .then(|| self.battery_v())
    }

    /// The middle of the battery voltages that the card was fitted to (V).
    fn battery_v(&self) -> Result<f64, CardError> {
        let range = self.validity.inputs.get("u");
        let [low, high] = range.ok_or_else(|| {
            self.not_for_flight("the validity box has no range of battery voltages `u`")
        })?;
        Ok(0.5 * (low + high))
    }
}

/// The other factor of a product with the battery voltage.
fn without_battery(expression: &str) -> Option<&'static str> {
    match expression {
        "s*u" => Some("s"),
        "u*battery_v" => Some("u"),
        _ => None,
    }
}

impl Terms for Card {
    fn lengths(&self) -> Result<[f64; 3], CardError> {
        let mut out = [0.0; 3];
        for (value, (psi, length)) in out.iter_mut().zip(PSI) {
            if self.definitions.get(psi).map(String::as_str) != Some(psi_text(length).as_str()) {
                return Err(self.not_for_flight(&format!(
                    "definition `{psi}`: expected `{}`, found {}",
                    psi_text(length),
                    self.definitions
                        .get(psi)
                        .map_or("none".to_string(), |d| format!("`{d}`"))
                )));
            }
            *value = self.constant(length)?;
        }
        Ok(out)
    }

    fn constant(&self, name: &str) -> Result<f64, CardError> {
        self.constants
            .get(name)
            .copied()
            .ok_or_else(|| self.not_for_flight(&format!("it has no constant `{name}`")))
    }

    fn constant_or_zero(&self, name: &str) -> f64 {
        self.constants.get(name).copied().unwrap_or(0.0)
    }

    fn single(&self, of: &str) -> Result<f64, CardError> {
        let mut terms = self.terms_of(of);
        match (terms.next(), terms.next()) {
            (Some(term), None) if term.expression == "1" => Ok(term.value),
            _ => Err(self.not_for_flight(&format!("`{of}` must have exactly one term, `1`"))),
        }
    }

    fn single_or(&self, of: &str, otherwise: f64) -> Result<f64, CardError> {
        match self.terms_of(of).next() {
            Some(_) => self.single(of),
            None => Ok(otherwise),
        }
    }

    /// Every term must have a slot. A product of throttle and battery voltage counts at the middle of the card's voltages.
    fn collect<const N: usize>(&self, of: &str, slots: &[&str; N]) -> Result<[f64; N], CardError> {
        let mut out = [0.0; N];
        for term in self.terms_of(of) {
            let (expression, factor) = match without_battery(&term.expression) {
                Some(expression) => (expression, self.battery_v()?),
                None => (term.expression.as_str(), 1.0),
            };
            let slot = slots.iter().position(|s| *s == expression).ok_or_else(|| {
                self.not_for_flight(&format!(
                    "`{of}` has a term `{}` that the flight family lacks; it has {}",
                    term.expression,
                    slots.join(", ")
                ))
            })?;
            out[slot] += factor * term.value;
        }
        Ok(out)
    }

    fn not_for_flight(&self, reason: &str) -> CardError {
        CardError::NotForFlight {
            card: self.name.clone(),
            reason: reason.to_string(),
        }
    }
}
