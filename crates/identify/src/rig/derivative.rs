//! Eq. (9): Savitzky–Golay derivative of the force, regressed on the library by SR3.

use std::collections::BTreeMap;

use sindy::{Gram, Library, Samples, SavitzkyGolay};
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use crate::error::Result;
use crate::estimate::{Estimate, kept, terms};
use crate::fitted::{FittedCard, Origin, method};
use crate::front::Front;
use crate::settings::{IdentificationSettings, SmoothingSettings as Smoothing};
use crate::sparse_fit::{SparseFit, sparse_fit};
use crate::warning::Warning;

/// The columns of eq. (9), smoothed, with the derivative of the force.
pub(super) fn samples(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
) -> Result<Samples> {
    let filter = SavitzkyGolay::new(settings.smoothing.window, settings.smoothing.degree)?;
    let mut samples = Samples::new(&["f", "s", "z", "v_p", "v_q", "f_dot"]);
    for t in trials {
        let force = t.smooth_force(&filter)?;
        samples.push_group(vec![
            force.value,
            t.throttle.clone(),
            t.height_m.clone(),
            t.deck_velocity_mps.clone(),
            t.vehicle_velocity_mps.clone(),
            force.derivative,
        ])?;
    }
    Ok(samples)
}

/// The library without the terms that are zero throughout the data.
pub(super) fn live_library(
    samples: &Samples,
    settings: &IdentificationSettings,
) -> Result<(Library, Vec<Gram>)> {
    let all = Library::parse(&settings.ground_effect.library)?;
    let total = Gram::total(&Gram::accumulate(&all, "f_dot", samples)?);
    let live: Vec<&String> = all
        .names()
        .iter()
        .enumerate()
        .filter(|(j, _)| total.xtx[(*j, *j)] > 0.0)
        .map(|(_, name)| name)
        .collect();
    let library = Library::parse(&live)?;
    let grams = Gram::accumulate(&library, "f_dot", samples)?;
    Ok((library, grams))
}

/// Terms of the settings that are not in the library, for they are zero throughout the data.
pub(super) fn zero_terms(library: &Library, settings: &IdentificationSettings) -> Vec<String> {
    let all = settings.ground_effect.library.iter();
    let zero = all.filter(|term| !library.names().contains(term));
    zero.cloned().collect()
}

/// Eq. (9), fitted.
pub(super) struct Derivative {
    library: Library,
    sparse: SparseFit,
    /// Of the terms that are kept.
    coefficients: Vec<Estimate>,
    front: Option<Front>,
    /// Share of the derivative's variance that is explained.
    r_squared: f64,
    rows: usize,
}

impl Derivative {
    pub(super) fn fit(trials: &[GroundTrial], settings: &IdentificationSettings) -> Result<Self> {
        let samples = samples(trials, settings)?;
        let (library, grams) = live_library(&samples, settings)?;
        let sparse = sparse_fit(&grams, settings)?;
        let front = Front::of(("f'", "N/s"), &library, &grams, &sparse, settings)?;
        let total = Gram::total(&grams);
        let (xi, support) = (&sparse.fit.coefficients, &sparse.fit.support);
        Ok(Self {
            coefficients: Estimate::of_regression(&grams, xi, support),
            front,
            r_squared: total.r_squared(xi),
            rows: total.rows,
            library,
            sparse,
        })
    }

    pub(super) fn card(&self, settings: &IdentificationSettings, origin: &Origin) -> FittedCard {
        let mut card = origin.card(
            "ground-effect-derivative",
            Kind::GroundEffect,
            Form::Derivative,
            "f' = Θ(f, s, z, v_p, v_q) ξ, f [N], s throttle, z height above the deck [m], v_p, v_q velocities of deck and vehicle [m/s]",
        );
        let expressions = kept(self.library.names(), &self.sparse.fit.support);
        card.terms = terms("f'", &expressions, &self.coefficients);
        card.provenance.method = self.method(&settings.smoothing);
        let pole_per_s = card.coefficient("f'", "f");
        FittedCard {
            lag_s: (pole_per_s < 0.0).then(|| -1.0 / pole_per_s),
            front: self.front.clone(),
            warnings: self.warnings(pole_per_s, settings),
            ..FittedCard::new(card, (self.sparse.training_rmse, "N/s"), self.rows)
        }
    }

    /// How it was fitted, by key.
    fn method(&self, smoothing: &Smoothing) -> BTreeMap<String, String> {
        let derivative = format!(
            "Savitzky–Golay, window {}, degree {}",
            smoothing.window, smoothing.degree
        );
        let mut notes = vec![("derivative", derivative)];
        notes.extend(self.sparse.notes.iter().cloned());
        method(&notes)
    }

    fn warnings(&self, pole_per_s: f64, settings: &IdentificationSettings) -> Vec<Warning> {
        let zero = zero_terms(&self.library, settings);
        let zero = (!zero.is_empty()).then_some(Warning::ZeroTerms(zero));
        let attenuated = Warning::Attenuated {
            pole_per_s,
            r_squared: self.r_squared,
        };
        zero.into_iter().chain([attenuated]).collect()
    }
}
