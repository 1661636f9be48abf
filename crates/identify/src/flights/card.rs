//! Cards from a ground effect that flights gave: what a flight computer flies and `land` takes.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use touchdown_model::card::{Card, Form, Kind, Outside, VelocityInput};
use touchdown_model::flight::psi_definitions;

use super::drift::DRIFT_S;
use super::ground::{Basis, GroundEffect};
use super::model::{Curve, LENGTHS, ModelTerms};
use super::trajectory::Noise;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, score};
use crate::scores::Errors;
use crate::settings::IdentificationSettings;
use crate::warning::{Warning, sentences};

/// Heights that a curve is carried over into bounded rationals at.
/// Several for each length of the rationals. The projection is smooth, so their number hardly matters.
const POINTS: usize = 60;
/// Factors of the standard lengths that are tried.
/// Steps of √2, from a third to three times the standard lengths.
const STRETCH: [f64; 7] = [0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8];
/// A curve that is missed by more than this share of its greatest value is warned of.
/// Curves of ten flights are known to some 10 %: the card may add half of that in silence.
const MISSED: f64 = 0.05;

/// Steps of the acceleration between two values of the throttle from which it counts as logged less often. Jitter of two streams of
/// one rate makes 1.1, half the rate 2.
const BETWEEN_ROWS: f64 = 1.5;

/// A curve as `Σ h_i ψ_i(z)`.
struct RationalCurve {
    lengths_m: [f64; 3],
    h: [Option<Estimate>; 3],
    /// Greatest error over greatest value.
    missed: f64,
}

impl GroundEffect {
    /// The ground-effect card: eq. (2), or a map of bounded rationals, with the wake's lag where that was resolved.
    #[must_use]
    pub fn card(&self, settings: &IdentificationSettings, origin: &Origin) -> FittedCard {
        let mut origin = origin.clone();
        origin.vehicle.rotor_radius_m = Some(self.rotor_radius_m);
        origin.vehicle.mass_kg = settings.flight.mass_kg.or(origin.vehicle.mass_kg);
        let (name, form, equation) = match (self.lag, self.fit.shape.curve) {
            (Some(_), _) => (
                "ground-effect-lag",
                Form::Lag,
                "f/T = G + k v_p, tau G' = h(z) - G, h = h1 psi1 + h2 psi2 + h3 psi3",
            ),
            (None, Curve::Empirical) => (
                "ground-effect-empirical",
                Form::Empirical,
                "f = q/(1-q) T [N], q = mu (r/(4 (z + h_r)))^2",
            ),
            (None, _) => (
                "ground-effect-static",
                Form::Static,
                "f = T (h1 psi1 + h2 psi2 + h3 psi3) [N]",
            ),
        };
        let mut card = origin.card(name, Kind::GroundEffect, form, equation);
        card.validity.inputs.insert("z".into(), self.heights_m);
        card.validity.output = Some(settings.ground_effect.ratio_limits);
        card.validity.outside = Outside::Fade;
        let mut warnings = Vec::new();
        if form == Form::Empirical {
            self.put_eq_2(&mut card);
        } else {
            warnings.extend(self.put_rationals(&mut card));
        }
        if form == Form::Lag {
            self.put_dynamics(&mut card);
            warnings.push(Warning::ClimbForDeckVelocity);
        }
        let refused = self.refused.iter().cloned();
        warnings.extend(refused.map(Warning::NotIdentified));
        if self.basis == Basis::Accelerometer && self.noise.is_none() {
            warnings.push(Warning::HeightsOfFilter);
        }
        if self.lag.is_none() && self.noise.is_some_and(|n| n.ground.is_some()) {
            warnings.push(Warning::MovingGroundWithoutLag);
        }
        card.description = self.basis.description().into();
        card.provenance.method = self.method();
        self.finish(card, settings, self.lag.map(|t| t.value), warnings)
    }

    /// Eq. (2): mu, rotor radius and rotor height.
    fn put_eq_2(&self, card: &mut Card) {
        let offset = self.fit.value("rotor_offset").unwrap_or(0.0) * self.rotor_radius_m;
        card.constants.insert("r".into(), self.rotor_radius_m);
        card.constants.insert("h_r".into(), offset);
        if let Some(mu) = self.spread.number(&self.fit, "mu") {
            card.terms.push(term("mu", "1", mu, "1"));
        }
    }

    /// The curve as bounded rationals of height; a warning where they miss it.
    fn put_rationals(&self, card: &mut Card) -> Option<Warning> {
        let rationals = self.rationals();
        (card.constants, card.definitions) = psi_definitions(rationals.lengths_m);
        for (expression, h) in ["psi1", "psi2", "psi3"].into_iter().zip(rationals.h) {
            card.terms.extend(h.map(|h| term("h", expression, h, "1")));
        }
        let curve = self.fit.shape.curve;
        if curve == Curve::Exponential {
            if let Some(a) = self.fit.value("amplitude") {
                card.constants.insert("exponential_amplitude".into(), a);
            }
            if let Some(decay) = self.decay_per_m() {
                card.constants
                    .insert("exponential_decay_per_m".into(), decay.value);
            }
        }
        (rationals.missed > MISSED).then_some(Warning::CurveMissed {
            curve: curve.name(),
            share: rationals.missed,
        })
    }

    /// Climb damping k and lag tau of the lag form.
    fn put_dynamics(&self, card: &mut Card) {
        card.validity.velocity_input = Some(VelocityInput::NegativeRelative);
        let damping = self.spread.number(&self.fit, "damping");
        let known = damping.filter(|_| self.basis != Basis::Poses);
        let k = known.filter(Estimate::differs_from_zero);
        let k = k.unwrap_or_else(|| Estimate::bare(0.0));
        card.terms.push(term("k", "1", k, "s/m"));
        card.terms
            .extend(self.lag.map(|tau| term("tau", "1", tau, "s")));
    }

    /// How the ground effect was fitted, by key.
    fn method(&self) -> BTreeMap<String, String> {
        let refit = if self.hovers.is_empty() {
            "one Gauss-Newton step each"
        } else {
            "each fitted anew"
        };
        let along = match self.noise {
            Some(_) => "maximum likelihood along the trajectories",
            None => "least squares of specific force",
        };
        let by = match self.noise {
            Some(_) => "the likeliest; intervals contain what others differ by",
            None => "chosen by flights left out",
        };
        let mut all = method(&[
            (
                "fit",
                format!(
                    "{along} over {} runs of the motors, scale and height error of each free; came to rest after {} steps",
                    self.pieces.len(),
                    self.fit.steps
                ),
            ),
            ("curve", format!("{}, {by}", self.fit.shape.curve.name())),
            ("basis", self.basis.name().to_string()),
            ("delay", self.delay_text()),
            (
                "intervals",
                format!(
                    "from {} {}, drawn {} times, {refit}; Student's t",
                    self.spread.count,
                    self.spread.blocks.name(),
                    self.spread.drawn(),
                ),
            ),
        ]);
        all.extend(self.noise.into_iter().flat_map(Noise::in_words));
        all.extend(self.accelerometer_latency_s().map(|latency| {
            let text = format!(
                "its readings are {:.4} s older than height and throttle, 95 % interval {:.4} to {:.4} s, as found with the model",
                latency.value, latency.ci95[0], latency.ci95[1]
            );
            ("accelerometer".to_string(), text)
        }));
        all
    }

    /// The card with its score and warnings.
    fn finish(
        &self,
        mut card: Card,
        settings: &IdentificationSettings,
        lag_s: Option<f64>,
        mut warnings: Vec<Warning>,
    ) -> FittedCard {
        warnings.extend(self.throttle_between_rows());
        warnings.extend(self.throttle_logged_late());
        let late_s = self.accelerometer_late_s();
        warnings.extend(late_s.map(|latency_s| Warning::AccelerometerLate { latency_s }));
        let late_s = self.range_late_s();
        warnings.extend(late_s.map(|latency_s| Warning::RangeLate { latency_s }));
        let (errors, unit) = self.errors(settings, &card.vehicle);
        card.scores
            .push(score("all flights", true, "free_run", errors, unit));
        card.warnings = sentences(&warnings);
        FittedCard {
            card,
            rmse: errors.rmse,
            rmse_unit: unit,
            rows_used: self.fit.rows,
            lag_s,
            forms: Vec::new(),
            front: None,
            warnings,
        }
    }

    /// A throttle that is logged less often than the acceleration whose lag is identified.
    fn throttle_between_rows(&self) -> Option<Warning> {
        let throttle_every_s = self.throttle_period_s;
        let slower = throttle_every_s > BETWEEN_ROWS * self.step_s();
        let lags = self.basis == Basis::Accelerometer && self.fit.index("T_m").is_some();
        (slower && lags).then_some(Warning::ThrottleBetweenRows {
            period_s: throttle_every_s,
        })
    }

    /// A throttle that is logged later than its period explains.
    fn throttle_logged_late(&self) -> Option<Warning> {
        let late_s = self.logged_late_s()?;
        Some(Warning::ThrottleLoggedLate { late_s })
    }

    /// The delay from command to acceleration in words.
    fn delay_text(&self) -> String {
        self.delay_s().map_or_else(
            || "not identified".to_string(),
            |d| {
                format!(
                    "{:.3} s from command to acceleration (dead time and lag of the motors), 95 % interval {:.3} to {:.3} s",
                    d.value, d.ci95[0], d.ci95[1]
                )
            },
        )
    }

    /// Errors of the specific force in N where the mass is known, else in m/s².
    fn errors(
        &self,
        settings: &IdentificationSettings,
        vehicle: &touchdown_model::card::Vehicle,
    ) -> (Errors, &'static str) {
        let gravity = settings.flight.gravity_mps2;
        let (by, unit) = vehicle
            .mass_kg
            .map_or((gravity, "m/s^2"), |m| (gravity * m, "N"));
        let all: Vec<f64> = self
            .fit
            .residuals(&self.pieces)
            .into_iter()
            .flatten()
            .map(|r| by * r)
            .collect();
        let n = all.len().max(1) as f64;
        let errors = Errors {
            mae: all.iter().map(|e| e.abs()).sum::<f64>() / n,
            rmse: (all.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            worst: all.iter().fold(0.0, |w: f64, e| w.max(e.abs())),
            samples: all.len(),
        };
        (errors, unit)
    }

    /// The curve in bounded rationals, by least squares over the heights of the data.
    fn rationals(&self) -> RationalCurve {
        let r = self.rotor_radius_m;
        let [lo, hi] = self.heights_m.map(|h| (h / r).max(0.0));
        let hi = hi.min(lo + 8.0);
        let z: Vec<f64> = (0..POINTS)
            .map(|k| lo + (hi - lo) * k as f64 / (POINTS - 1) as f64)
            .collect();
        let values = self.fit.values();
        let curve = DVector::from_iterator(POINTS, z.iter().map(|z| values.at_rest(*z)));
        let most = curve.amax().max(1e-12);
        let mut best: Option<(f64, [f64; 3], DMatrix<f64>)> = None;
        let stretches: &[f64] = if self.fit.shape.curve == Curve::Rational {
            &[1.0]
        } else {
            &STRETCH
        };
        for stretch in stretches {
            let lengths = LENGTHS.map(|l| l * stretch);
            let psi = DMatrix::from_fn(POINTS, 3, |i, k| 1.0 / (1.0 + (z[i] / lengths[k]).powi(2)));
            let mut gram = psi.tr_mul(&psi);
            for k in 0..3 {
                gram[(k, k)] *= 1.0 + 1e-9;
            }
            let Some(inverse) = gram.try_inverse() else {
                continue;
            };
            let project = inverse * psi.transpose();
            let missed = (&psi * (&project * &curve) - &curve).amax() / most;
            if best.as_ref().is_none_or(|b| missed < b.0) {
                best = Some((missed, lengths, project));
            }
        }
        let Some((missed, lengths, project)) = best else {
            return RationalCurve {
                lengths_m: LENGTHS.map(|l| l * r),
                h: [None; 3],
                missed: 1.0,
            };
        };
        let h = std::array::from_fn(|k| {
            self.of_curve(|v| {
                z.iter()
                    .enumerate()
                    .map(|(i, z)| project[(k, i)] * v.at_rest(*z))
                    .sum()
            })
        });
        RationalCurve {
            lengths_m: lengths.map(|l| l * r),
            h,
            missed,
        }
    }

    /// The thrust card: a polynomial for √T behind a lag. `None` without mass or motor lag, which flight needs.
    #[must_use]
    pub fn thrust_card(
        &self,
        settings: &IdentificationSettings,
        origin: &Origin,
    ) -> Option<FittedCard> {
        if self.basis != Basis::Accelerometer {
            return None;
        }
        self.fit.index("T_m")?;
        self.thrust_of(settings, origin)
    }

    /// The same; without a lag of the motors, the static law alone. `None` without mass or accelerometer.
    #[must_use]
    pub fn thrust_of(
        &self,
        settings: &IdentificationSettings,
        origin: &Origin,
    ) -> Option<FittedCard> {
        let mut origin = origin.clone();
        let mass_kg = settings.flight.mass_kg.or(origin.vehicle.mass_kg)?;
        origin.vehicle.mass_kg = Some(mass_kg);
        if self.rotor_radius_m.is_finite() {
            origin.vehicle.rotor_radius_m = Some(self.rotor_radius_m);
        }
        if matches!(self.basis, Basis::Hovers { .. }) {
            return None;
        }
        let t_m = self.motor_lag_s();
        let polynomial = self.root_polynomial(mass_kg * settings.flight.gravity_mps2)?;
        let equation = match (t_m.is_some(), polynomial.len()) {
            (true, 4) => "T_m x' = a0 + a1 s + a2 s^2 + a3 s^3 - x, x = sqrt(T)",
            (true, _) => "T_m x' = a0 + a1 s + a2 s^2 - x, x = sqrt(T)",
            (false, _) => "sqrt(T) = a0 + a1 s + a2 s^2",
        };
        let form = Form::StaticSqrt;
        let mut card = origin.card("thrust-from-flight", Kind::Thrust, form, equation);
        for (expression, a) in ["1", "s", "s^2", "s^3"].into_iter().zip(polynomial) {
            card.terms.push(term("x", expression, a, "√N"));
        }
        for (of, estimate) in [("T_m", t_m), ("dead_time", self.dead_time_s())] {
            card.terms.extend(estimate.map(|e| term(of, "1", e, "s")));
        }
        let s0 = self.hover_throttle;
        let used = self
            .pieces
            .iter()
            .flat_map(|p| p.rows.iter().map(|&i| p.throttle[i] * s0));
        if let Some(range) = crate::fitted::range(used) {
            card.validity.inputs.insert("s".into(), range);
        }
        card.description =
            "Identified from flights: thrust of the mean run of the motors, settled.".into();
        card.provenance.method = method(&[
            (
                "fit",
                "least squares of specific force, flights, scale of each run of the motors free"
                    .to_string(),
            ),
            ("delay", self.delay_text()),
        ]);
        Some(self.finish(card, settings, t_m.map(|t| t.value), self.thrust_warnings()))
    }

    /// Mean thrust scale over the armed intervals.
    fn mean_scale(&self) -> f64 {
        let locals = &self.fit.locals;
        locals.iter().map(|l| l.scale).sum::<f64>() / locals.len() as f64
    }

    /// Coefficients of √T (√N) at rest as a polynomial of throttle: Taylor's about hover, at which thrust is the weight.
    fn root_polynomial(&self, weight_n: f64) -> Option<Vec<Estimate>> {
        let s0 = self.hover_throttle;
        let root = (weight_n * self.mean_scale()).sqrt();
        let elasticity = self.fit.index("elasticity")?;
        // The third order is that of the rotors' drag.
        let at = |theta: &[f64]| -> [f64; 4] {
            let number = |name| self.fit.index(name).map_or(0.0, |i| theta[i]);
            let drag = number("drag") / (1.0 + number("drag"));
            let first = 0.5 * theta[elasticity];
            let second = number("curvature") - drag * first * first;
            let third = -2.0 * drag * first * second;
            [
                root * (1.0 - first + second - third),
                root * (first - 2.0 * second + 3.0 * third) / s0,
                root * (second - 3.0 * third) / s0.powi(2),
                root * third / s0.powi(3),
            ]
        };
        let orders = match self.fit.shape {
            ModelTerms { drag: true, .. } => 4,
            ModelTerms {
                curvature: true, ..
            } => 3,
            _ => 2,
        };
        (0..orders)
            .map(|k| self.spread.estimate(&self.fit, |theta, _| at(theta)[k]))
            .collect()
    }

    /// What thrust at one throttle depends on besides.
    fn thrust_warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let (n, scale) = (self.fit.locals.len(), self.mean_scale());
        if n > 1 {
            let off = self.fit.locals.iter().map(|l| (l.scale - scale).powi(2));
            let variance = off.sum::<f64>() / (n as f64 - 1.0).max(1.0);
            warnings.push(Warning::ThrustScatter {
                share: variance.sqrt() / scale,
            });
        }
        warnings.extend(self.fit.value("battery").map(|change| {
            if self.drift_of_time {
                Warning::DriftWithTime {
                    share: change,
                    over_s: DRIFT_S,
                }
            } else {
                Warning::DriftWithVoltage {
                    share_per_v: change,
                }
            }
        }));
        warnings
    }
}
