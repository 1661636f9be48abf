//! Cards from a ground effect that flights gave: what a flight computer flies and `land` takes.

use nalgebra::{DMatrix, DVector};
use touchdown_model::card::{Form, Kind, Outside, VelocityInput};
use touchdown_model::flight::psi_definitions;

use super::ground::{Basis, GroundEffect};
use super::hover::DRIFT_S;
use super::model::{Curve, LENGTHS, ModelTerms};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, score};
use crate::scores::Errors;
use crate::settings::IdentificationSettings;

/// Heights that a curve is carried over into bounded rationals at.
const POINTS: usize = 60;
/// Factors of the standard lengths that are tried.
const STRETCH: [f64; 7] = [0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8];
/// A curve that is missed by more than this share of its greatest value is told of.
const MISSED: f64 = 0.05;

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
        let lag = self.lag_s();
        let shape = self.fit.shape;
        let (form, equation) = match (lag, shape.curve) {
            (Some(_), _) => (
                Form::Lag,
                "f/T = G + k v_p, tau G' = h(z) - G, h = h1 psi1 + h2 psi2 + h3 psi3",
            ),
            (None, Curve::Empirical) => (
                Form::Empirical,
                "f = q/(1-q) T [N], q = mu (r/(4 (z + h_r)))^2",
            ),
            (None, _) => (Form::Static, "f = T (h1 psi1 + h2 psi2 + h3 psi3) [N]"),
        };
        let name = match form {
            Form::Lag => "ground-effect-lag",
            Form::Empirical => "ground-effect-empirical",
            _ => "ground-effect-static",
        };
        let mut card = origin.card(name, Kind::GroundEffect, form, equation);
        let mut warnings = Vec::new();
        let [lo, hi] = self.heights_m;
        card.validity.inputs.insert("z".into(), [lo, hi]);
        card.validity.output = Some(settings.ground_effect.ratio_limits);
        card.validity.outside = Outside::Fade;
        if form == Form::Empirical {
            let offset = self.fit.value("rotor_offset").unwrap_or(0.0) * self.rotor_radius_m;
            card.constants.insert("r".into(), self.rotor_radius_m);
            card.constants.insert("h_r".into(), offset);
            if let Some(mu) = self.spread.number(&self.fit, "mu") {
                card.terms.push(term("mu", "1", mu, "1"));
            }
        } else {
            let carried = self.carried();
            (card.constants, card.definitions) = psi_definitions(carried.lengths_m);
            for (expression, h) in ["psi1", "psi2", "psi3"].into_iter().zip(carried.h) {
                if let Some(h) = h {
                    card.terms.push(term("h", expression, h, "1"));
                }
            }
            if carried.missed > MISSED {
                warnings.push(format!(
                    "the bounded rationals of the card miss the fitted {} curve by {:.0} % of its greatest value",
                    shape.curve.name(),
                    100.0 * carried.missed
                ));
            }
            if shape.curve == Curve::Exponential {
                if let Some(a) = self.fit.value("amplitude") {
                    card.constants.insert("exponential_amplitude".into(), a);
                }
                if let Some(decay) = self.decay_per_m() {
                    card.constants
                        .insert("exponential_decay_per_m".into(), decay.value);
                }
            }
        }
        let damping = self
            .spread
            .number(&self.fit, "damping")
            .filter(Estimate::differs_from_zero);
        if form == Form::Lag {
            card.validity.velocity_input = Some(VelocityInput::NegativeRelative);
            let k = damping.map_or_else(
                || term("k", "1", Estimate::bare(0.0), "s/m"),
                |d| term("k", "1", d, "s/m"),
            );
            card.terms.push(k);
            if let Some(tau) = lag {
                card.terms.push(term("tau", "1", tau, "s"));
            }
            warnings.push(
                "k is the climb damping of the vehicle, the same at all heights; its climb stands for the deck's velocity, reversed: an \
                 approximation where the deck moves"
                    .into(),
            );
        }
        warnings.extend(self.refused.iter().map(ToString::to_string));
        if self.basis == Basis::Poses {
            warnings.push(
                "intervals hold what differs from flight to flight; what the smoothing of poses and a pilot's answers to \
                 disturbances move alike in all of them, some tenth of the curve, they do not"
                    .into(),
            );
        }
        card.description = match self.basis {
            Basis::Accelerometer => {
                "Identified from flights, relative to flight out of ground effect."
            }
            Basis::Poses => {
                "Identified from poses of flights, without accelerometer, relative to flight out of ground effect."
            }
            Basis::Hovers { .. } => {
                "Identified from hovers at rest, relative to hover out of ground effect."
            }
        }
        .into();
        card.provenance.method = method(&[
            (
                "fit",
                format!(
                    "least squares of specific force over {} runs of the motors, scale and height error of each free; \
                     came to rest after {} steps",
                    self.pieces.len(),
                    self.fit.steps
                ),
            ),
            (
                "curve",
                format!("{}, chosen by flights left out", shape.curve.name()),
            ),
            ("basis", self.basis.name().to_string()),
            ("delay", self.delay_text()),
            (
                "intervals",
                format!(
                    "from {} {}, drawn {} times, {}; Student's t",
                    self.spread.count,
                    self.spread.blocks.name(),
                    self.spread.drawn(),
                    if self.hovers.is_empty() {
                        "one Gauss-Newton step each"
                    } else {
                        "each fitted anew"
                    }
                ),
            ),
        ]);
        let (errors, unit) = self.errors(settings, &card.vehicle);
        card.scores
            .push(score("all flights", true, "free_run", errors, unit));
        card.warnings.clone_from(&warnings);
        FittedCard {
            card,
            rmse: errors.rmse,
            rmse_unit: unit,
            rows_used: self.fit.rows,
            lag_s: lag.map(|t| t.value),
            front: None,
            warnings,
        }
    }

    /// The delay from throttle to acceleration in words.
    fn delay_text(&self) -> String {
        self.delay_s().map_or_else(
            || "not identified".to_string(),
            |d| {
                format!(
                    "{:.3} s from throttle to acceleration (dead time and lag of the motors), 95 % interval {:.3} to {:.3} s",
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
    fn carried(&self) -> RationalCurve {
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
        let measured = self.basis == Basis::Accelerometer;
        let resolved = |name| self.spread.number(&self.fit, name).filter(|_| measured);
        let t_m = resolved("T_m");
        let s0 = self.hover_throttle;
        let weight = mass_kg * settings.flight.gravity_mps2;
        let n = self.fit.locals.len() as f64;
        let scale = self.fit.locals.iter().map(|l| l.scale).sum::<f64>() / n;
        let root = (weight * scale).sqrt();
        let elasticity = self.fit.index("elasticity")?;
        // Of √T at rest at hover: Taylor's polynomial, of which the third order is the drag's.
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
        let estimate = |k: usize| self.spread.estimate(&self.fit, |theta, _| at(theta)[k]);
        let orders = match self.fit.shape {
            ModelTerms { drag: true, .. } => 4,
            ModelTerms {
                curvature: true, ..
            } => 3,
            _ => 2,
        };
        let equation = match (t_m.is_some(), orders) {
            (true, 4) => "T_m x' = a0 + a1 s + a2 s^2 + a3 s^3 - x, x = sqrt(T)",
            (true, _) => "T_m x' = a0 + a1 s + a2 s^2 - x, x = sqrt(T)",
            (false, _) => "sqrt(T) = a0 + a1 s + a2 s^2",
        };
        let form = Form::StaticSqrt;
        let mut card = origin.card("thrust-from-flight", Kind::Thrust, form, equation);
        for (k, expression) in ["1", "s", "s^2", "s^3"]
            .into_iter()
            .enumerate()
            .take(orders)
        {
            card.terms.push(term("x", expression, estimate(k)?, "√N"));
        }
        if let Some(t_m) = t_m {
            card.terms.push(term("T_m", "1", t_m, "s"));
        }
        if let Some(dead) = resolved("dead_time") {
            card.terms.push(term("dead_time", "1", dead, "s"));
        }
        let used = self
            .pieces
            .iter()
            .flat_map(|p| p.rows.iter().map(|&i| p.throttle[i] * s0));
        if let Some(range) = crate::fitted::range(used) {
            card.validity.inputs.insert("s".into(), range);
        }
        card.description =
            "Identified from flights: thrust of the mean run of the motors, settled.".into();
        let spread_of_scale = self
            .fit
            .locals
            .iter()
            .map(|l| (l.scale - scale).powi(2))
            .sum::<f64>();
        let mut warnings = Vec::new();
        if self.fit.locals.len() > 1 {
            warnings.push(format!(
                "thrust at one throttle differs from run to run by {:.1} % (standard deviation)",
                100.0 * (spread_of_scale / (n - 1.0).max(1.0)).sqrt() / scale
            ));
        }
        if let Some(battery) = self.fit.value("battery") {
            warnings.push(if self.drift_of_time {
                format!(
                    "thrust changes by {:.1} % in {DRIFT_S} s; the card is for the start of the logs",
                    100.0 * battery
                )
            } else {
                format!(
                    "thrust changes by {:.1} % per volt of the battery; the card is for the mean voltage of the flights",
                    100.0 * battery
                )
            });
        }
        card.provenance.method = method(&[
            (
                "fit",
                "least squares of specific force, flights, scale of each run of the motors free"
                    .to_string(),
            ),
            ("delay", self.delay_text()),
        ]);
        card.warnings.clone_from(&warnings);
        let (errors, unit) = self.errors(settings, &card.vehicle);
        card.scores
            .push(score("all flights", true, "free_run", errors, unit));
        Some(FittedCard {
            card,
            rmse: errors.rmse,
            rmse_unit: unit,
            rows_used: self.fit.rows,
            lag_s: t_m.map(|t| t.value),
            front: None,
            warnings,
        })
    }
}
