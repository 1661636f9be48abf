//! One sparse fit from the statistics of trials, by the solver and the criterion that the settings ask for.

use sindy::choose::select::{
    Family, Rule, Selection, best_subsets, deal, select, sr3_points, stlsq_thresholds,
};
use sindy::solve::stepwise::Direction;
use sindy::{Fit, Gram, Outcome, SindyError, Solver as _, Stepwise};

use crate::error::Result;
use crate::settings::{IdentificationSettings, SolverName};

/// Nodes at most of an exact search: some seconds.
/// It ends searches of large libraries, whose result is then without proof.
const NODE_LIMIT: u64 = 2_000_000;

/// A fit with how it came about.
pub(super) struct SparseFit {
    /// The fit to all trials.
    pub(super) fit: Fit,
    /// Root mean square residual of that.
    pub(super) training_rmse: f64,
    /// Root mean square error on held-out trials.
    pub(super) left_out_rmse: Option<f64>,
    /// Solver, choice and outcome, in words.
    pub(super) notes: [(&'static str, String); 3],
}

/// The rule by which the settings choose.
pub(super) fn rule(settings: &IdentificationSettings) -> Rule {
    match settings.choice.criterion.criterion() {
        None => Rule::LeftOut,
        Some(criterion) => Rule::Criterion {
            criterion,
            effective_rows: settings.choice.effective_rows,
        },
    }
}

/// Folds of the cross-validation: each group, or sets of groups.
///
/// # Errors
/// More folds than groups.
pub(super) fn folds(grams: &[Gram], settings: &IdentificationSettings) -> Result<Vec<Gram>> {
    Ok(match settings.choice.folds {
        0 => grams.to_vec(),
        folds => deal(grams, folds, settings.choice.seed)?,
    })
}

/// The best subset of every size, as a family.
pub(super) fn subsets() -> impl Family {
    best_subsets(Some(NODE_LIMIT))
}

/// The exact search behind it.
pub(super) fn search() -> sindy::BestSubset {
    sindy::BestSubset::new().node_limit(NODE_LIMIT)
}

/// Chooses a fit to the groups `grams`.
///
/// # Errors
/// Statistics that cannot be fitted, or fewer than two groups where groups are left out.
pub(super) fn sparse_fit(grams: &[Gram], settings: &IdentificationSettings) -> Result<SparseFit> {
    let rule = rule(settings);
    let folds = folds(grams, settings)?;
    let of = |family: &dyn Family| -> std::result::Result<Selection, SindyError> {
        select(&folds, family, rule)
    };
    let (selection, solver) = match settings.choice.solver {
        SolverName::Sr3 => {
            let points = settings.sr3.points();
            let selection = of(&sr3_points(&points)?)?;
            let (lambda, nu) = points[selection.chosen];
            let text = format!(
                "SR3 with l0, λ = {lambda:e}, ν = {nu}; coefficients by least squares on its support"
            );
            (selection, text)
        }
        SolverName::Stlsq => {
            let thresholds = &settings.sr3.thresholds;
            let selection = of(&stlsq_thresholds(thresholds, 0.0)?)?;
            let threshold = thresholds[selection.chosen];
            (selection, format!("STLSQ, scaled, threshold {threshold}"))
        }
        SolverName::BestSubset => {
            let text = "best subset of every size by branch and bound".to_string();
            (of(&subsets())?, text)
        }
        SolverName::Stepwise => {
            // Without a criterion the settings are refused before.
            let criterion = settings.choice.criterion.criterion();
            let criterion = criterion.unwrap_or(sindy::Criterion::Bic);
            let mut stepwise = Stepwise::new(Direction::Both, criterion);
            if let Some(rows) = settings.choice.effective_rows {
                stepwise = stepwise.effective_rows(rows)?;
            }
            let selection = of(&|gram: &Gram| Ok(vec![stepwise.fit(gram)?]))?;
            (selection, format!("stepwise by {criterion:?}"))
        }
        SolverName::LeastSquares => {
            let all = |gram: &Gram| {
                let support = vec![true; gram.xty.len()];
                Ok(vec![Fit::on_support(gram, support, Outcome::Converged, 1)])
            };
            (of(&all)?, "least squares on all terms".to_string())
        }
    };
    let member = selection.member();
    Ok(SparseFit {
        fit: member.fit.clone(),
        training_rmse: member.training_rmse,
        left_out_rmse: member.left_out.map(|l| l.rmse),
        notes: [
            ("solver", solver),
            ("choice", selection.reason.clone()),
            ("outcome", format!("{:?}", member.fit.outcome)),
        ],
    })
}
