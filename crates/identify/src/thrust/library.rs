//! Eq. (8): a sparse library for `x = √T`.

use sindy::statistics::regression::{Clusters, cluster_errors};
use sindy::trajectory::shooting::{OdeModel, Parameter};
use sindy::{Gram, Library};
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::record::StandRecords;
use crate::error::Result;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, outcome};
use crate::front::Front;
use crate::settings::IdentificationSettings;
use crate::sparse_fit::sparse_fit;
use crate::unit;
use crate::warning::Warning;

/// Least standard deviation of the prior on a coefficient of eq. (8): one that regression puts near zero stays free to
/// grow to the size of a small term.
const LEAST_PRIOR_SD: f64 = 0.1;
/// The coefficients of a sparse fit of eq. (8), by term of the library.
struct Coefficients {
    /// Places of the terms in the library.
    support: Vec<usize>,
    values: Vec<f64>,
    std_errors: Vec<f64>,
    clusters: Clusters,
}

impl Coefficients {
    /// Those of a regression on derivatives.
    fn of_regression(grams: &[Gram], fit: &sindy::Fit) -> Self {
        let support: Vec<usize> = (0..fit.support.len()).filter(|&j| fit.support[j]).collect();
        let errors = cluster_errors(grams, &fit.coefficients, &fit.support);
        let error = |&j: &usize| errors.as_ref().map_or(f64::NAN, |e| e[j]);
        Self {
            values: support.iter().map(|&j| fit.coefficients[j]).collect(),
            std_errors: support.iter().map(error).collect(),
            clusters: Clusters {
                groups: grams.iter().filter(|g| g.rows > 0).count(),
                coefficients: support.len(),
            },
            support,
        }
    }

    /// The same terms fitted in free run, and how that ended.
    fn refined(
        self,
        library: &Library,
        records: &StandRecords,
        settings: &IdentificationSettings,
    ) -> Result<(Self, String)> {
        let names: Vec<String> = (0..self.support.len()).map(|k| format!("c{k}")).collect();
        let rhs: Vec<String> = self
            .support
            .iter()
            .zip(&names)
            .map(|(&j, n)| format!("{n}*({})", library.names()[j]))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let model = OdeModel::new(&["x"], &["s"], &names, &[&rhs.join(" + ")], "x*abs(x)")?;
        // The library is nearly collinear. A prior of the coefficients' own size keeps the search from wandering along
        // directions that the data do not identify.
        let parameters: Vec<Parameter> = self
            .values
            .iter()
            .map(|&v| Parameter::free(v).prior(v.abs().max(LEAST_PRIOR_SD)))
            .collect();
        let (refined, clusters) = records.free_run(&model, &parameters, settings)?;
        let note = format!(
            "free run over long stretches, each with its own start: {}",
            outcome(&refined)
        );
        let refined = Self {
            values: refined.parameters,
            std_errors: refined.std_errors,
            clusters,
            ..self
        };
        Ok((refined, note))
    }

    fn card(&self, library: &Library, origin: &Origin) -> Card {
        let mut card = origin.card(
            "thrust-library",
            Kind::Thrust,
            Form::Library,
            "x' = Θ(x, s) ξ, x = √T [√N], s throttle in [0, 1]",
        );
        for (k, &j) in self.support.iter().enumerate() {
            let name = &library.names()[j];
            let estimate = Estimate::clustered(self.values[k], self.std_errors[k], self.clusters);
            let unit = unit::of_coefficient("x'", name);
            card.terms.push(term("x'", name, estimate, &unit));
        }
        card
    }
}

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
    let grams = Gram::accumulate(&library, "x_dot", &records.samples()?)?;
    let sparse = sparse_fit(&grams, settings)?;
    let front = Front::of(("x'", "√N/s"), &library, &grams, &sparse, settings)?;
    let mut coefficients = Coefficients::of_regression(&grams, &sparse.fit);
    let mut notes = vec![(
        "derivative",
        format!(
            "Savitzky–Golay, window {} at 100 Hz, degree {}",
            settings.smoothing.thrust_window, settings.smoothing.degree
        ),
    )];
    notes.extend(sparse.notes.iter().cloned());
    if settings.thrust.refine {
        let (refined, note) = coefficients.refined(&library, &records, settings)?;
        coefficients = refined;
        notes.push(("refinement", note));
    }
    let mut card = coefficients.card(&library, origin);
    card.provenance.method = method(&notes);
    let terms = library.len();
    let none_eliminated = coefficients.support.len() == terms;
    let warning = none_eliminated.then_some(Warning::NoTermEliminated { terms });
    Ok(FittedCard {
        front,
        warnings: warning.into_iter().collect(),
        ..records.finish(card, trials)?
    })
}
