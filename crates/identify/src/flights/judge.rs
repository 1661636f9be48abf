//! Cards judged on a flight that they have not seen: the force along the rotors that the models that fly give, beside mass
//! times specific force.
//!
//! ```text
//! F = k (T(s) + f(z + b, v, T)),   minimum over k and b of Σ (m a − F)² in each armed interval
//! ```
//!
//! `T` is the thrust card in free run from the start of the motors, `f` the ground-effect card from its rest where the vehicle
//! leaves the ground. Battery, air and mass differ from flight to flight, and so does the zero of a height: the scale `k` and
//! the height offset `b` are free in each armed interval, or held at numbers that the user gives.

use serde::Serialize;
use sindy::numerics::golden_section;
use touchdown_flight::ground_effect::{GroundEffect as _, GroundEffectInput, Guarded};
use touchdown_flight::thrust::{ThrustModel, ThrustState};
use touchdown_model::Card;
use touchdown_trial::Trial;

use super::phases::{Phase, Phases};
use super::segments::FEWEST_ROWS;
use super::thrust::{no_mass, without_force};
use super::{Flight, FlightSettings, ForceFrom};
use crate::delayed::delayed;
use crate::error::{Error, Result};
use crate::thrust::dead_time_s;

/// Hole in the stamps over which the motors are not followed (s): several of their lags, after which they are at rest.
const LONGEST_HOLE_S: f64 = 0.5;
/// Greatest height offset that is looked for, in rotor radii: the landing gear is shorter. Half leaves out tall legs, twice lets
/// a wrong curve pass for a wrong zero.
const GREATEST_OFFSET_RADII: f64 = 1.0;
/// Width to which the search narrows the offset, over its greatest: a thousandth of a radius moves no force.
const NARROW: f64 = 1e-3;

/// What the armed intervals of a flight do not choose; what is absent is free in each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    /// Thrust over that of the card.
    pub scale: Option<f64>,
    /// What is added to logged heights (m).
    pub height_offset_m: Option<f64>,
}

/// The cards that predict a flight.
#[derive(Clone, Copy, Debug)]
pub struct FlightCards<'a> {
    /// Throttle to thrust.
    pub thrust: &'a Card,
    /// The ground effect; without one, only rows out of ground effect are judged.
    pub ground_effect: Option<&'a Card>,
    /// Rotors of the vehicle, where they are not those of the card's vehicle.
    pub rotors: Option<u32>,
}

impl FlightCards<'_> {
    fn rotor_radius_m(&self) -> Option<f64> {
        let of_ground = self.ground_effect.and_then(|c| c.vehicle.rotor_radius_m);
        of_ground.or(self.thrust.vehicle.rotor_radius_m)
    }
}

/// Scale and height offset of an armed interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct IntervalFactors {
    /// The armed interval, from 1.
    pub number: usize,
    /// Its first and last judged stamp (s).
    pub time_s: [f64; 2],
    /// Rows that are judged.
    pub rows: usize,
    /// Thrust over that of the card.
    pub scale: f64,
    /// Whether it was held.
    pub scale_is_held: bool,
    /// What is added to logged heights (m); absent for thrust alone.
    pub height_offset_m: Option<f64>,
    /// Whether it was held.
    pub height_offset_is_held: bool,
    /// Whether it lies on a bound of the search.
    pub height_offset_is_at_bound: bool,
}

/// A flight beside its prediction. Rows that are not judged are NaN.
#[derive(Clone, Debug)]
pub struct JudgedFlight {
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Throttle.
    pub throttle: Vec<f64>,
    /// Height as logged, and the offset (m); empty for thrust alone.
    pub height_m: Vec<f64>,
    /// Measured force (N): along the rotors, or beyond the scaled thrust where a ground effect is judged.
    pub measured_n: Vec<f64>,
    /// Predicted force (N).
    pub predicted_n: Vec<f64>,
    /// The armed intervals.
    pub intervals: Vec<IntervalFactors>,
}

/// Predicts a flight by cards that have not seen it.
///
/// # Errors
/// No mass, no specific force, no height for a ground effect, a card that does not fly, or no row in flight.
pub fn judge(
    trial: &Trial,
    cards: &FlightCards<'_>,
    settings: &FlightSettings,
    held: Held,
) -> Result<JudgedFlight> {
    let mass_kg = settings
        .mass_kg
        .or(cards.thrust.vehicle.mass_kg)
        .ok_or_else(no_mass)?;
    // The radius decides up to which height rows count as on the ground.
    let settings = &FlightSettings {
        rotor_radius_m: settings.rotor_radius_m.or(cards.rotor_radius_m()),
        ..*settings
    };
    let flight = Flight::of(trial, settings)?;
    if flight.force.is_empty() {
        return Err(without_force(trial.name(), &flight, settings));
    }
    let course = Course::of(&flight, cards, settings, mass_kg)?;
    let n = flight.time_s.len();
    let mut out = JudgedFlight {
        time_s: flight.time_s.clone(),
        throttle: flight.throttle.clone(),
        height_m: vec![f64::NAN; if course.model.is_some() { n } else { 0 }],
        measured_n: vec![f64::NAN; n],
        predicted_n: vec![f64::NAN; n],
        intervals: Vec::new(),
    };
    for (index, run) in Phases::of(&flight, settings).runs.iter().enumerate() {
        let rows: Vec<usize> = (run.rows[0]..=run.rows[1])
            .filter(|&i| course.counts[i])
            .collect();
        if rows.len() >= FEWEST_ROWS {
            let factors = course.fit(index + 1, &rows, held);
            course.put(&factors, &rows, &mut out);
            out.intervals.push(factors);
        }
    }
    if out.intervals.is_empty() {
        return Err(Error::data(
            trial.name(),
            match course.model {
                Some(_) => "rows in flight with height and specific force",
                None => "rows in flight out of ground effect with specific force",
            },
            "none",
        ));
    }
    Ok(out)
}

/// A flight with the thrust that its throttle gives.
struct Course<'a> {
    flight: &'a Flight,
    /// Rows that are judged.
    counts: Vec<bool>,
    /// Mass times specific force (N).
    force_n: Vec<f64>,
    /// By the thrust card (N).
    thrust_n: Vec<f64>,
    model: Option<Guarded<f64>>,
    greatest_offset_m: f64,
}

impl<'a> Course<'a> {
    fn of(
        flight: &'a Flight,
        cards: &FlightCards<'_>,
        settings: &FlightSettings,
        mass_kg: f64,
    ) -> Result<Self> {
        let model = cards.ground_effect.map(Card::ground_effect).transpose()?;
        if model.is_some() && flight.height_m.is_empty() {
            return Err(Error::data(
                &flight.name,
                "values of `height_m`: the ground effect needs heights",
                "no height",
            ));
        }
        let thrust = cards.thrust.thrust_model_of(cards.rotors)?;
        // Forces from poses are smoothed, and so is the throttle that acts on them.
        let throttle = match flight.force_from {
            ForceFrom::Poses if !flight.command.is_empty() => &flight.command,
            _ => &flight.throttle,
        };
        let late = delayed(&flight.time_s, throttle, dead_time_s(cards.thrust));
        let thrust_n = thrust_along(&thrust, &flight.time_s, &late);
        let radius_m = settings.rotor_radius_m;
        let far_m = radius_m
            .filter(|_| model.is_none())
            .map(|r| r * settings.reference_radii);
        let phases = Phases::of(flight, settings);
        let height = |i: usize| flight.height_m.get(i).copied().unwrap_or(f64::NAN);
        let counts = (0..flight.time_s.len()).map(|i| {
            let known = flight.force[i].is_finite() && thrust_n[i].is_finite();
            let place = match (model.is_some(), far_m) {
                (true, _) => height(i).is_finite(),
                (false, Some(far_m)) if !flight.height_m.is_empty() => height(i) > far_m,
                _ => true,
            };
            phases.rows[i] == Phase::Airborne && known && place
        });
        Ok(Self {
            counts: counts.collect(),
            force_n: flight
                .force
                .iter()
                .map(|f| mass_kg * settings.gravity_mps2 * f)
                .collect(),
            thrust_n,
            model,
            greatest_offset_m: GREATEST_OFFSET_RADII * radius_m.unwrap_or(0.1),
            flight,
        })
    }

    /// Scale and offset of the least square error, where they are not held.
    fn fit(&self, number: usize, rows: &[usize], held: Held) -> IntervalFactors {
        let mut factors = IntervalFactors {
            number,
            time_s: [rows[0], rows[rows.len() - 1]].map(|i| self.flight.time_s[i]),
            rows: rows.len(),
            scale: 1.0,
            scale_is_held: held.scale.is_some(),
            height_offset_m: None,
            height_offset_is_held: held.height_offset_m.is_some(),
            height_offset_is_at_bound: false,
        };
        let scale_of = |lift: &[f64]| {
            held.scale
                .unwrap_or_else(|| self.likeliest_scale(rows, lift))
        };
        if self.model.is_none() {
            factors.scale = scale_of(&vec![0.0; rows.len()]);
            return factors;
        }
        let most_m = self.greatest_offset_m;
        let offset_m = held.height_offset_m.unwrap_or_else(|| {
            let squares = |offset_m: f64| {
                let lift = self.lift(rows, offset_m);
                let scale = scale_of(&lift);
                let of = |(&i, f): (&usize, &f64)| {
                    (self.force_n[i] - scale * (self.thrust_n[i] + f)).powi(2)
                };
                rows.iter().zip(&lift).map(of).sum()
            };
            // Curves fall with height, so the squares have one minimum.
            let narrow = |low: f64, high: f64| high - low > NARROW * most_m;
            let [low, high] = golden_section([-most_m, most_m], narrow, squares);
            let offset_m = 0.5 * (low + high);
            factors.height_offset_is_at_bound = offset_m.abs() > (1.0 - 2.0 * NARROW) * most_m;
            offset_m
        });
        factors.height_offset_m = Some(offset_m);
        factors.scale = scale_of(&self.lift(rows, offset_m));
        factors
    }

    fn likeliest_scale(&self, rows: &[usize], lift: &[f64]) -> f64 {
        let [mut product, mut square] = [0.0; 2];
        for (&i, lift) in rows.iter().zip(lift) {
            let total = self.thrust_n[i] + lift;
            product += self.force_n[i] * total;
            square += total * total;
        }
        product / square
    }

    /// The ground effect (N) of the rows, unscaled; at rest where a stretch of rows begins.
    fn lift(&self, rows: &[usize], offset_m: f64) -> Vec<f64> {
        let Some(model) = &self.model else {
            return vec![0.0; rows.len()];
        };
        let flight = self.flight;
        let mut before: Option<usize> = None;
        let mut state = None;
        let of_row = |&i: &usize| {
            let climb = flight.climb_mps.get(i).copied().unwrap_or(0.0);
            let input = GroundEffectInput {
                thrust_n: self.thrust_n[i],
                throttle: flight.throttle[i],
                height_m: flight.height_m[i] + offset_m,
                vehicle_velocity_mps: if climb.is_finite() { climb } else { 0.0 },
                deck_velocity_mps: 0.0,
                rotor_heights_m: None,
            };
            let dt = before.map_or(f64::INFINITY, |b| flight.time_s[i] - flight.time_s[b]);
            let now = state.get_or_insert_with(|| model.rest(&input));
            if dt > LONGEST_HOLE_S {
                *now = model.rest(&input);
            } else {
                model.advance(now, &input, dt);
            }
            before = Some(i);
            model.lift(now, &input).total_n(self.thrust_n[i])
        };
        rows.iter().map(of_row).collect()
    }

    /// Writes an armed interval.
    fn put(&self, factors: &IntervalFactors, rows: &[usize], out: &mut JudgedFlight) {
        let k = factors.scale;
        let offset_m = factors.height_offset_m.unwrap_or(0.0);
        let lift = self.lift(rows, offset_m);
        for (&i, lift) in rows.iter().zip(lift) {
            (out.measured_n[i], out.predicted_n[i]) = match self.model {
                Some(_) => (self.force_n[i] - k * self.thrust_n[i], k * lift),
                None => (self.force_n[i], k * self.thrust_n[i]),
            };
            if let Some(height) = out.height_m.get_mut(i) {
                *height = self.flight.height_m[i] + offset_m;
            }
        }
    }
}

/// The thrust (N) along a throttle, from rest at its first value and behind holes; NaN where the throttle is not known.
fn thrust_along(model: &ThrustModel<f64>, time_s: &[f64], throttle: &[f64]) -> Vec<f64> {
    let mut state: Option<ThrustState<f64>> = None;
    (0..time_s.len())
        .map(|i| {
            if !throttle[i].is_finite() {
                state = None;
                return f64::NAN;
            }
            let dt = if i == 0 {
                0.0
            } else {
                time_s[i] - time_s[i - 1]
            };
            let rest = ThrustState {
                x: model.rest(throttle[i]),
            };
            let now = state.get_or_insert(rest);
            if dt > LONGEST_HOLE_S {
                *now = rest;
            } else if i > 0 && throttle[i - 1].is_finite() {
                // A command acts until the next.
                model.step(now, throttle[i - 1], dt);
            }
            now.thrust_n()
        })
        .collect()
}
