//! The Pareto front of a sparse fit, terms against error: the best subset of every size, proven by exact search,
//! and where the fit's own choice stands on it.

use serde::Serialize;
use sindy::choose::select::select;
use sindy::solve::exact::MAX_TERMS;
use sindy::{Gram, Library, Outcome};
use touchdown_model::{Card, unit};

use super::estimate::{Estimate, term};
use super::settings::IdentificationSettings;
use super::sparse_fit::{self, SparseFit};
use crate::error::Result;

/// The best subset of every size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Front {
    /// The left-hand side of the equation (`f'`, `x'`).
    pub of: String,
    /// Its unit.
    pub unit: String,
    /// The candidate terms.
    pub library: Vec<String>,
    /// Rows of data.
    pub rows: usize,
    /// Trials (or folds of them) of the cross-validation.
    pub groups: usize,
    /// What is proven.
    pub certificate: Certificate,
    /// By size: `sizes[k]` has k terms.
    pub sizes: Vec<Size>,
    /// The size that the rule of the settings takes from this front.
    pub chosen_terms: usize,
    /// Why.
    pub reason: String,
    /// Where the model's own terms stand.
    pub model: Standing,
}

/// A proof by exhaustion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// Subsets that there are: 2 to the number of terms.
    pub subsets: f64,
    /// Nodes of the search tree that were looked at to rule out the others.
    pub nodes: u64,
    /// Whether it is proven that no subset of any size fits better than the one shown.
    pub proven: bool,
    /// Ridge of the search, share of the scaled Gram matrix's diagonal; zero unless the terms are dependent.
    pub ridge: f64,
}

/// The best subset of one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Its terms.
    pub terms: Vec<String>,
    /// Their coefficients, by least squares.
    pub coefficients: Vec<f64>,
    /// Root mean square residual on the data of the fit, in the unit of the equation.
    pub training_rmse: f64,
    /// Root mean square error on held-out trials; the search is repeated without each of them.
    pub left_out_rmse: Option<f64>,
    /// Whether it is proven that no other subset of this size fits better.
    pub proven: bool,
    /// The relative gap that is left, where it is not.
    pub gap: f64,
    /// Root mean square error in free run over trials never trained on (N), where there are such.
    pub free_run_rmse_n: Option<f64>,
}

/// A model's own terms beside the best ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// Terms that it keeps.
    pub terms: usize,
    /// Root mean square residual of least squares on them.
    pub training_rmse: f64,
    /// Root mean square error of the solver on held-out trials.
    pub left_out_rmse: Option<f64>,
    /// Whether they are the best subset of their size.
    pub best_of_its_size: bool,
    /// By what share the residual is above that of the best subset of this size.
    pub excess: f64,
}

impl Front {
    /// The front of `library` for the equation of `of` (in `unit`) on the groups `grams`, beside a fit. `None` for
    /// more terms than the exact search takes.
    ///
    /// # Errors
    /// Statistics that cannot be fitted.
    pub(super) fn of(
        (of, unit): (&str, &str),
        library: &Library,
        grams: &[Gram],
        chosen: &SparseFit,
        settings: &IdentificationSettings,
    ) -> Result<Option<Self>> {
        if library.len() > MAX_TERMS {
            return Ok(None);
        }
        let total = Gram::total(grams);
        let found = sparse_fit::search().solve(&total)?;
        let folds = sparse_fit::folds(grams, settings)?;
        let selection = select(&folds, &sparse_fit::subsets(), sparse_fit::rule(settings))?;
        let names = library.names();
        let sizes: Vec<Size> = found
            .sizes
            .iter()
            .zip(&selection.members)
            .map(|(subset, member)| {
                let kept = || (0..names.len()).filter(|&j| subset.fit.support[j]);
                Size {
                    terms: kept().map(|j| names[j].clone()).collect(),
                    coefficients: kept().map(|j| subset.fit.coefficients[j]).collect(),
                    training_rmse: member.training_rmse,
                    left_out_rmse: member.left_out.map(|l| l.rmse),
                    proven: subset.fit.outcome == Outcome::Optimal,
                    gap: subset.gap(),
                    free_run_rmse_n: None,
                }
            })
            .collect();
        let terms = chosen.fit.terms();
        let best = found.sizes.get(terms);
        let least = sizes.get(terms).map_or(f64::NAN, |s| s.training_rmse);
        Ok(Some(Self {
            of: of.to_string(),
            unit: unit.to_string(),
            library: names.to_vec(),
            rows: total.rows,
            groups: folds.iter().filter(|g| g.rows > 0).count(),
            certificate: Certificate {
                subsets: 2f64.powi(names.len() as i32),
                nodes: found.nodes,
                proven: found.outcome == Outcome::Optimal,
                ridge: found.ridge,
            },
            chosen_terms: selection.fit().terms(),
            reason: selection.reason,
            model: Standing {
                terms,
                training_rmse: chosen.training_rmse,
                left_out_rmse: chosen.left_out_rmse,
                best_of_its_size: best.is_some_and(|b| b.fit.support == chosen.fit.support),
                excess: chosen.training_rmse / least - 1.0,
            },
            sizes,
        }))
    }

    /// The card of the best subset of `terms` terms: `card` with the terms of this equation replaced.
    #[must_use]
    pub fn card(&self, card: &Card, terms: usize) -> Card {
        let size = &self.sizes[terms.min(self.sizes.len() - 1)];
        let pairs = size.terms.iter().map(String::as_str);
        with_terms(card, &self.of, pairs.zip(size.coefficients.iter().copied()))
    }

    /// The certificate in a sentence.
    #[must_use]
    pub fn says(&self) -> String {
        let Certificate {
            subsets,
            nodes,
            proven,
            ..
        } = self.certificate;
        if proven {
            format!(
                "Of the {subsets} subsets of the {} terms none fits better, size by size, than those shown: proven by branch and bound,                  which had to look at {nodes} nodes.",
                self.library.len()
            )
        } else {
            format!(
                "The search through the {subsets} subsets of the {} terms ended at {nodes} nodes: not proven for the sizes with a gap.",
                self.library.len()
            )
        }
    }
}

/// A card with other terms in the equation of `of`; an equation without terms is one of a constant zero.
pub(super) fn with_terms<'a>(
    card: &Card,
    of: &str,
    terms: impl Iterator<Item = (&'a str, f64)>,
) -> Card {
    let mut out = card.clone();
    out.terms.retain(|t| t.of != of);
    for (name, value) in terms {
        let unit = unit::of_coefficient(of, name);
        out.terms.push(term(of, name, Estimate::bare(value), &unit));
    }
    if !out.terms.iter().any(|t| t.of == of) {
        let unit = unit::of_coefficient(of, "1");
        out.terms.push(term(of, "1", Estimate::bare(0.0), &unit));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindy::Samples;
    use sindy::statistics::regression::least_squares;

    /// Four trials of `y = 2 a - b + 0.02 c + noise`.
    fn grams() -> (Library, Vec<Gram>) {
        let mut samples = Samples::new(&["a", "b", "c", "y"]);
        for g in 0..4 {
            let wave = |w: f64| -> Vec<f64> {
                (0..300)
                    .map(|i| (w * f64::from(i) + f64::from(g)).sin())
                    .collect()
            };
            let (a, b, c, noise) = (wave(0.11), wave(0.23), wave(0.31), wave(7.3));
            let y = (0..300)
                .map(|i| 2.0 * a[i] - b[i] + 0.02 * c[i] + 0.05 * noise[i])
                .collect();
            samples.push_group(vec![a, b, c, y]).unwrap();
        }
        let library = Library::parse(&["1", "a", "b", "c", "a*b", "c^2"]).unwrap();
        let grams = Gram::accumulate(&library, "y", &samples).unwrap();
        (library, grams)
    }

    #[test]
    fn analytic_front_is_that_of_all_subsets_one_by_one() {
        let (library, grams) = grams();
        let settings = IdentificationSettings::default();
        let chosen = sparse_fit::sparse_fit(&grams, &settings).unwrap();
        let front = Front::of(("f'", "N/s"), &library, &grams, &chosen, &settings)
            .unwrap()
            .unwrap();
        let total = Gram::total(&grams);
        for (k, size) in front.sizes.iter().enumerate() {
            let least = (0_u32..64)
                .filter(|mask| mask.count_ones() as usize == k)
                .map(|mask| {
                    let support: Vec<bool> = (0..6).map(|j| mask >> j & 1 == 1).collect();
                    total.residual_sum(&least_squares(&total, &support))
                })
                .fold(f64::INFINITY, f64::min);
            // Two routes to the same least squares: rounding.
            assert!(
                (size.training_rmse - (least / 1200.0).sqrt()).abs() < 1e-9,
                "{k}"
            );
            assert!(size.proven && size.gap == 0.0 && size.terms.len() == k);
        }
        assert!(front.certificate.proven);
        assert_eq!((front.certificate.subsets, front.sizes.len()), (64.0, 7));
        assert!(front.certificate.nodes < 64 && front.says().contains("64 subsets"));
        assert_eq!(front.sizes[2].terms, ["a", "b"]);
        assert!(front.model.best_of_its_size && front.model.excess.abs() < 1e-9);
    }

    #[test]
    fn prop_solver_criterion_folds_and_seed_change_what_they_say() {
        use crate::settings::{CriterionName, SolverName};
        let (_, grams) = grams();
        let mut settings = IdentificationSettings::default();
        let by =
            |settings: &IdentificationSettings| sparse_fit::sparse_fit(&grams, settings).unwrap();
        let note = |c: &SparseFit| c.notes[0].1.clone();
        let default = by(&settings);
        assert!(note(&default).starts_with("SR3"));
        for (solver, name) in [
            (SolverName::Stlsq, "STLSQ"),
            (SolverName::BestSubset, "best subset"),
            (SolverName::LeastSquares, "least squares on all"),
        ] {
            settings.choice.solver = solver;
            assert!(note(&by(&settings)).starts_with(name));
        }
        assert_eq!(by(&settings).fit.terms(), 6);
        settings.choice.solver = SolverName::Stepwise;
        settings.choice.criterion = CriterionName::Bic;
        let bic = by(&settings);
        assert!(note(&bic).contains("Bic"));
        // Fewer effective rows pay for fewer terms.
        settings.choice.effective_rows = Some(4.0);
        assert!(by(&settings).fit.terms() <= bic.fit.terms());
        settings = IdentificationSettings::default();
        settings.choice.folds = 2;
        let two = by(&settings);
        assert!(two.left_out_rmse != default.left_out_rmse);
        let other = (2..20).any(|seed| {
            settings.choice.seed = seed;
            by(&settings).left_out_rmse != two.left_out_rmse
        });
        assert!(other, "another seed deals other folds");
        settings.choice.folds = 5;
        assert!(sparse_fit::sparse_fit(&grams, &settings).is_err());
        settings = IdentificationSettings::default();
        settings.sr3.nu = Some(2.0);
        settings.sr3.lambda = Some(0.25);
        let fixed = by(&settings);
        assert!(
            note(&fixed).contains("λ = 2.5e-1, ν = 2"),
            "{}",
            note(&fixed)
        );
        // A threshold of √(2·0.25·2) = 1 on scaled coefficients leaves at most the largest.
        assert!(fixed.fit.terms() <= 1);
    }
}
