//! Eq. (8): a sparse library for `x = √T`.

use std::collections::BTreeMap;

use sindy::trajectory::shooting::{OdeModel, Parameter, Refined};
use sindy::{Gram, Library};
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::record::StandRecords;
use crate::error::Result;
use crate::estimate::{Estimate, kept, terms};
use crate::fitted::{FittedCard, Origin, method, outcome};
use crate::front::Front;
use crate::settings::{IdentificationSettings, SmoothingSettings};
use crate::sparse_fit::{SparseFit, sparse_fit};
use crate::warning::Warning;

/// Least standard deviation of the prior on a coefficient of eq. (8): one that regression puts near zero stays free to
/// grow to the size of a small term.
const LEAST_PRIOR_SD: f64 = 0.1;

/// Eq. (8): `x' = Θ(x, s) ξ` by Savitzky–Golay derivatives and SR3 with λ and ν chosen by
/// cross-validation; then, if the settings ask for it, refined in free run.
///
/// # Errors
/// Missing channels or too few unbroken data.
pub fn library(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let records = StandRecords::of(trials, settings, true)?;
    let library = Library::parse(&settings.thrust.library)?;
    let mut fitted = SparseLibrary::fit(&records, &library, settings)?;
    if settings.thrust.refine {
        fitted.refine(&records, settings)?;
    }
    let card = fitted.card(&settings.smoothing, origin);
    let terms = library.len();
    let none_eliminated = fitted.terms.len() == terms;
    Ok(FittedCard {
        front: fitted.front,
        warnings: Vec::from_iter(none_eliminated.then_some(Warning::NoTermEliminated { terms })),
        ..records.finish(card, trials)?
    })
}

/// Eq. (8), fitted.
struct SparseLibrary {
    /// The terms that are kept.
    terms: Vec<String>,
    coefficients: Vec<Estimate>,
    /// How the search in free run ended, if there was one.
    refined: Option<Refined>,
    sparse: SparseFit,
    front: Option<Front>,
}

impl SparseLibrary {
    /// Regression on derivatives.
    fn fit(
        records: &StandRecords,
        library: &Library,
        settings: &IdentificationSettings,
    ) -> Result<Self> {
        let grams = Gram::accumulate(library, "x_dot", &records.samples()?)?;
        let sparse = sparse_fit(&grams, settings)?;
        let (xi, support) = (&sparse.fit.coefficients, &sparse.fit.support);
        Ok(Self {
            terms: kept(library.names(), support),
            coefficients: Estimate::of_regression(&grams, xi, support),
            refined: None,
            front: Front::of(("x'", "√N/s"), library, &grams, &sparse, settings)?,
            sparse,
        })
    }

    /// Fits the same terms in free run.
    fn refine(&mut self, records: &StandRecords, settings: &IdentificationSettings) -> Result<()> {
        let names: Vec<String> = (0..self.terms.len()).map(|k| format!("c{k}")).collect();
        let products = names.iter().zip(&self.terms);
        let rhs: Vec<String> = products.map(|(n, term)| format!("{n}*({term})")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let model = OdeModel::new(&["x"], &["s"], &names, &[&rhs.join(" + ")], "x*abs(x)")?;
        // The library is nearly collinear. A prior of the coefficients' own size keeps the search from wandering along
        // directions that the data do not identify.
        let start =
            |c: &Estimate| Parameter::free(c.value).prior(c.value.abs().max(LEAST_PRIOR_SD));
        let parameters: Vec<Parameter> = self.coefficients.iter().map(start).collect();
        let (refined, clusters) = records.free_run(&model, &parameters, settings)?;
        self.coefficients = Estimate::refined(&refined, clusters).collect();
        self.refined = Some(refined);
        Ok(())
    }

    fn card(&self, smoothing: &SmoothingSettings, origin: &Origin) -> Card {
        let mut card = origin.card(
            "thrust-library",
            Kind::Thrust,
            Form::Library,
            "x' = Θ(x, s) ξ, x = √T [√N], s throttle in [0, 1]",
        );
        card.terms = terms("x'", &self.terms, &self.coefficients);
        card.provenance.method = self.method(smoothing);
        card
    }

    /// How it was fitted, by key.
    fn method(&self, smoothing: &SmoothingSettings) -> BTreeMap<String, String> {
        let derivative = format!(
            "Savitzky–Golay, window {} at 100 Hz, degree {}",
            smoothing.thrust_window, smoothing.degree
        );
        let mut notes = vec![("derivative", derivative)];
        notes.extend(self.sparse.notes.iter().cloned());
        notes.extend(self.refined.iter().map(|refined| {
            let outcome = outcome(refined);
            let text = format!("free run over long stretches, each with its own start: {outcome}");
            ("refinement", text)
        }));
        method(&notes)
    }
}
