//! Eq. (8): a sparse library for `x = √T`.

use std::collections::BTreeMap;

use sindy::numerics::golden_section;
use sindy::trajectory::shooting::{OdeModel, Outcome, Parameter, Refined};
use sindy::{Gram, Library};
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::free_run::{FOLDS, HeldOut};
use super::output_error::{LagFit, LagForm};
use super::record::{StandRecords, dead_time_by_regression};
use crate::error::Result;
use crate::estimate::{Estimate, kept, term, terms};
use crate::fitted::{FittedCard, Origin, method, outcome, unconverged};
use crate::front::Front;
use crate::settings::{DeadTime, IdentificationSettings, SmoothingSettings, ThrustForm};
use crate::sparse_fit::{SparseFit, sparse_fit};
use crate::warning::Warning;

/// Least standard deviation of the prior on a coefficient of eq. (8): one that regression puts near zero stays free to
/// grow to the size of a small term.
const LEAST_PRIOR_SD: f64 = 0.1;
/// Share of the period to which the dead time is narrowed: a tenth of what its own clock errs by.
const NARROW: f64 = 0.05;

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
    LibraryFit::new(trials, settings)?.card(trials, settings, origin)
}

/// Eq. (8) with its records and its error on folds.
pub(super) struct LibraryFit {
    records: StandRecords,
    fitted: SparseLibrary,
    dead_time: Option<Estimate>,
    /// Candidate terms.
    candidates: usize,
}

impl LibraryFit {
    pub(super) fn new(trials: &[Trial], settings: &IdentificationSettings) -> Result<Self> {
        super::output_error::check_clock(trials)?;
        let one_lag = match settings.thrust.dead_time {
            DeadTime::None | DeadTime::Regression => None,
            DeadTime::Auto | DeadTime::Estimate => Some(one_lag(trials, settings)?),
        };
        let records = StandRecords::of(trials, settings, one_lag.as_ref().map(LagFit::between))?;
        let library = Library::parse(&settings.thrust.library)?;
        let fit = |dead_time_s: f64| -> Result<(StandRecords, SparseLibrary)> {
            let records = records.delayed_by(dead_time_s);
            let mut fitted = SparseLibrary::fit(&records, &library, settings)?;
            if settings.thrust.refine {
                fitted.refine(&records, settings)?;
            }
            Ok((records, fitted))
        };
        let candidates = library.len();
        let of = |(records, fitted), dead_time| Self {
            records,
            fitted,
            dead_time,
            candidates,
        };
        match settings.thrust.dead_time {
            DeadTime::None => Ok(of(fit(0.0)?, None)),
            DeadTime::Regression => {
                let found = dead_time_by_regression(&records, settings)?;
                Ok(of(fit(found)?, Some(Estimate::bare(found))))
            }
            DeadTime::Auto | DeadTime::Estimate => {
                let none = of(fit(0.0)?, None);
                let Some(guess) = one_lag.and_then(|fit| fit.dead_time()) else {
                    return Ok(none);
                };
                let start = of(fit(guess.value)?, None);
                let best = start.narrowed(&records, guess.value, settings)?;
                let moved = best - guess.value;
                let half = (0.5 * (guess.ci95[1] - guess.ci95[0])).hypot(moved);
                let estimate = Estimate {
                    value: best,
                    std_error: guess.std_error.hypot(moved),
                    ci95: [(best - half).max(0.0), best + half],
                };
                let with = of(fit(best)?, Some(estimate));
                let better = with.held_out(settings)?.rmse() < none.held_out(settings)?.rmse();
                Ok(if better { with } else { none })
            }
        }
    }

    /// The dead time (s) near `guess` at which the terms, refitted, leave the least residual in free run.
    fn narrowed(
        &self,
        records: &StandRecords,
        guess: f64,
        settings: &IdentificationSettings,
    ) -> Result<f64> {
        if !settings.thrust.refine {
            return Ok(guess);
        }
        let period_s = records.period_s();
        let model = self.fitted.model()?;
        let parameters = self.fitted.parameters();
        let cost = |dead_time_s: f64| {
            let run = records
                .delayed_by(dead_time_s)
                .free_run(&model, &parameters, settings, None);
            run.map_or(f64::INFINITY, |(refined, _)| refined.rmse)
        };
        let around = [(guess - 1.5 * period_s).max(0.0), guess + 1.5 * period_s];
        let wide = |a: f64, b: f64| b - a > NARROW * period_s;
        let [a, b] = golden_section(around, wide, cost);
        Ok(0.5 * (a + b))
    }

    /// The error of the terms on folds that their coefficients have not seen.
    pub(super) fn held_out(&self, settings: &IdentificationSettings) -> Result<HeldOut> {
        let model = self.fitted.model()?;
        let parameters = self.fitted.parameters();
        let folds = (0..FOLDS)
            .map(|fold| {
                let run = self
                    .records
                    .free_run(&model, &parameters, settings, Some(fold))?;
                Ok(run.0.parameters)
            })
            .collect::<Result<Vec<_>>>()?;
        self.records.held_out(&model, &folds)
    }

    /// Coefficients of the fit.
    pub(super) fn parameters(&self) -> usize {
        self.fitted.terms.len() + usize::from(self.dead_time.is_some())
    }

    pub(super) fn card(
        self,
        trials: &[Trial],
        settings: &IdentificationSettings,
        origin: &Origin,
    ) -> Result<FittedCard> {
        let mut card = self.fitted.card(&settings.smoothing, origin);
        if let Some(dead_time) = self.dead_time.filter(|d| d.value > 0.0) {
            card.terms.push(term("dead_time", "1", dead_time, "s"));
        }
        let outcome = self.fitted.refined.as_ref().map(|r| r.outcome);
        let converged = matches!(outcome, None | Some(Outcome::Converged));
        if !converged {
            card.terms.iter_mut().for_each(unconverged);
        }
        let made = self.records.finish(card, trials)?;
        let all_kept = self.fitted.terms.len() == self.candidates;
        let terms = self.candidates;
        let mut warnings = made.warnings;
        warnings.extend((!converged).then_some(Warning::NotConverged));
        warnings.extend(all_kept.then_some(Warning::NoTermEliminated { terms }));
        Ok(FittedCard {
            front: self.fitted.front,
            warnings,
            ..FittedCard {
                warnings: Vec::new(),
                ..made
            }
        })
    }
}

/// A quadratic for √T behind one lag: it tells what the throttle is between its samples, and the dead time where one is resolved
/// and predicts better.
fn one_lag(trials: &[Trial], settings: &IdentificationSettings) -> Result<LagFit> {
    let form = LagForm {
        form: ThrustForm::StaticSqrt,
        degree: 2,
        battery: false,
    };
    LagFit::new(trials, settings, form)
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

    /// The terms as a model in free run.
    fn model(&self) -> Result<OdeModel> {
        let names: Vec<String> = (0..self.terms.len()).map(|k| format!("c{k}")).collect();
        let products = names.iter().zip(&self.terms);
        let rhs: Vec<String> = products.map(|(n, term)| format!("{n}*({term})")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Ok(OdeModel::new(
            &["x"],
            &["s"],
            &names,
            &[&rhs.join(" + ")],
            "x*abs(x)",
        )?)
    }

    /// The coefficients as starts of a search. The library is nearly collinear. A prior of the coefficients' own size keeps
    /// the search from wandering along directions that the data do not identify.
    fn parameters(&self) -> Vec<Parameter> {
        let start =
            |c: &Estimate| Parameter::free(c.value).prior(c.value.abs().max(LEAST_PRIOR_SD));
        self.coefficients.iter().map(start).collect()
    }

    /// Fits the same terms in free run.
    fn refine(&mut self, records: &StandRecords, settings: &IdentificationSettings) -> Result<()> {
        let (refined, clusters) =
            records.free_run(&self.model()?, &self.parameters(), settings, None)?;
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
