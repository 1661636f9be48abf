//! Forms without memory: eq. (2) with fitted mu, and the static map `f = T h(z)`.

use sindy::statistics::regression::least_squares;
use sindy::trajectory::shooting::{OdeModel, Parameter, Refined};
use sindy::{Gram, Library, Samples};
use touchdown_model::flight::psi_definitions;
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use super::trial::{clusters, records};
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, outcome};
use crate::settings::IdentificationSettings;

/// How the coefficients of both forms were fitted.
const FIT: &str = "least squares on the force, standard errors by trial";
/// Largest `q` of eq. (2), at the smallest height of the data: its pole is at 1.
const LARGEST_Q: f64 = 0.6;

/// Fits a form without memory.
///
/// # Errors
/// A form that is not here, or data that the form cannot be fitted to.
pub(super) fn fit(
    form: Form,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    match form {
        Form::Empirical => {
            let radius_m = origin.vehicle.rotor_radius_m;
            let radius_m = radius_m.unwrap_or(settings.ground_effect.rotor_radius_m);
            Ok(Empirical::fit(trials, settings, radius_m)?.card(origin))
        }
        Form::Static => {
            let lengths_m = settings.ground_effect.lengths_m();
            Ok(StaticMap::fit(trials, lengths_m)?.card(origin))
        }
        other => Err(Error::not_fitted(other)),
    }
}

/// Eq. (2): `f = T q/(1 - q)`, `q = mu (R/(4 z))²`, by least squares on the force.
struct Empirical {
    rotor_radius_m: f64,
    mu: Estimate,
    refined: Refined,
    rows: usize,
}

impl Empirical {
    fn fit(
        trials: &[GroundTrial],
        settings: &IdentificationSettings,
        rotor_radius_m: f64,
    ) -> Result<Self> {
        let q = format!("mu*({rotor_radius_m}/(4*z))^2");
        let force = format!("T*({q})/(1 - {q})");
        let model = OdeModel::new(&[], &["T", "z"], &["mu"], &[], &force)?;
        let records = records(trials, None, |t| {
            [&t.free_air_thrust_n, &t.height_m].map(Vec::as_slice)
        });
        let heights = trials.iter().flat_map(|t| &t.height_m).copied();
        let lowest = heights.fold(f64::INFINITY, f64::min);
        let most = LARGEST_Q * (4.0 * lowest / rotor_radius_m).powi(2);
        let start = Parameter::free(1.0_f64.min(most)).within(0.0, most);
        let refined = settings
            .shooting
            .build(0.0, super::trial::greatest_n(trials))
            .refine(&model, &records, &[start])?;
        let (mu, error) = (refined.parameters[0], refined.std_errors[0]);
        Ok(Self {
            rotor_radius_m,
            mu: Estimate::clustered(mu, error, clusters(trials, 1)),
            refined,
            rows: super::trial::rows(trials),
        })
    }

    fn card(&self, origin: &Origin) -> FittedCard {
        let mut card = origin.card(
            "ground-effect-empirical",
            Kind::GroundEffect,
            Form::Empirical,
            "f = T q/(1 - q), q = mu (r/(4 z))^2 (at most 0.6), z height above the deck [m]",
        );
        card.constants.insert("r".into(), self.rotor_radius_m);
        card.terms.push(term("mu", "1", self.mu, "1"));
        card.provenance.method =
            method(&[("fit", FIT.into()), ("outcome", outcome(&self.refined))]);
        FittedCard::new(card, (self.refined.rmse, "N"), self.rows)
    }
}

/// The bounded functions of height as expressions in `z`.
pub(super) fn psi(lengths_m: [f64; 3]) -> [String; 3] {
    lengths_m.map(|l| format!("1/(1 + (z/{l})^2)"))
}

/// `f = T (h0 + h1 psi1 + h2 psi2 + h3 psi3)` by least squares on the force.
pub(super) struct StaticMap {
    /// `h0` to `h3`.
    h: Vec<Estimate>,
    lengths_m: [f64; 3],
    rmse_n: f64,
    rows: usize,
}

impl StaticMap {
    pub(super) fn fit(trials: &[GroundTrial], lengths_m: [f64; 3]) -> Result<Self> {
        let mut samples = Samples::new(&["T", "z", "f"]);
        for t in trials {
            let columns = [&t.free_air_thrust_n, &t.height_m, &t.force_n];
            samples.push_group(columns.map(Clone::clone).into())?;
        }
        let mut terms = vec!["T".to_string()];
        terms.extend(psi(lengths_m).map(|psi| format!("T*{psi}")));
        let grams = Gram::accumulate(&Library::parse(&terms)?, "f", &samples)?;
        let total = Gram::total(&grams);
        let h = least_squares(&total, &[true; 4]);
        Ok(Self {
            h: Estimate::of_regression(&grams, &h, &[true; 4]),
            lengths_m,
            rmse_n: (total.residual_sum(&h) / total.rows.max(1) as f64).sqrt(),
            rows: total.rows,
        })
    }

    /// `h0` to `h3`.
    pub(super) fn coefficients(&self) -> [f64; 4] {
        std::array::from_fn(|k| self.h[k].value)
    }

    fn card(&self, origin: &Origin) -> FittedCard {
        let mut card = origin.card(
            "ground-effect-static",
            Kind::GroundEffect,
            Form::Static,
            "f = T h(z), z height above the deck [m]",
        );
        (card.constants, card.definitions) = psi_definitions(self.lengths_m);
        for (expression, h) in ["1", "psi1", "psi2", "psi3"].into_iter().zip(&self.h) {
            card.terms.push(term("h", expression, *h, "1"));
        }
        card.provenance.method = method(&[("fit", FIT.into())]);
        FittedCard::new(card, (self.rmse_n, "N"), self.rows)
    }
}
