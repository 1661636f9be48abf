//! Regression: supports and coefficients from slopes or the weak form, as models and as starts.

use nalgebra::DVector;

use super::prepare::{Slopes, WEIGHT, blocks, regression_samples, slope_name};
use super::settings::Settings;
use crate::choose::{Grid, Point, cross_validate};
use crate::criteria::Criterion;
use crate::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::exact::{BestSubset, BestSubsets};
use crate::fit::Fit;
use crate::gram::{Accumulate, Gram};
use crate::library::Library;
use crate::output_error::irrelevant;
use crate::samples::Samples;
use crate::stepwise::{Direction, Stepwise};
use crate::weak::WeakForm;

/// Terms above which best subsets are searched among those of a stepwise path only.
const EXACT: usize = 40;
/// Nodes of a branch and bound, at most, for a start and for a front.
const NODES: u64 = 8_000;
pub(super) const FRONT_NODES: u64 = 200_000;
/// The condition of the scaled library above which the triangular factor is accumulated as well.
const ILL_CONDITIONED: f64 = 1e6;

/// One regression for every equation.
pub(super) struct Regression {
    /// For tables: solver and smoothing.
    pub name: String,
    pub solver: &'static str,
    pub smoothing: String,
    /// λ and ν where SR3 chose, one for each equation.
    pub points: Vec<Option<Point>>,
    /// One for each equation.
    pub fits: Vec<Fit>,
}

/// The statistics of every equation by block, and what they came from.
pub(super) struct Statistics {
    pub smoothing: String,
    /// By equation, then block.
    pub grams: Vec<Vec<Gram>>,
    /// Rows that are independent, as a share.
    pub independent: f64,
}

/// Statistics of slopes.
pub(super) fn of_slopes(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    libraries: &[Library],
    slopes: &Slopes,
    folds: usize,
) -> Result<Statistics, SindyError> {
    let samples = regression_samples(data, stretches, slopes, &blocks(stretches, folds))?;
    let weighted = stretches.iter().any(|s| s.weights.is_some());
    let mut grams = Vec::new();
    for (i, library) in libraries.iter().enumerate() {
        let target = slope_name(i);
        let mut of = Accumulate::new(library, &target);
        if weighted {
            of = of.weights(WEIGHT);
        }
        let mut parts = of.over(&samples)?;
        if Gram::total(&parts).condition() > ILL_CONDITIONED {
            parts = of.triangle(true).over(&samples)?;
        }
        grams.push(parts);
    }
    Ok(Statistics {
        smoothing: slopes.name.clone(),
        grams,
        independent: 1.0 / slopes.window,
    })
}

/// Statistics of the weak form; `None` where no stretch holds a window.
pub(super) fn of_weak_form(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    libraries: &[Library],
    folds: usize,
) -> Result<Option<Statistics>, SindyError> {
    let mut names = vec![Dataset::TIME.to_owned()];
    names.extend(data.names());
    let mut samples = Samples::new(&names.iter().map(String::as_str).collect::<Vec<_>>());
    for (index, rows) in blocks(stretches, folds) {
        let s = &stretches[index];
        let mut columns = vec![s.time[rows.clone()].to_vec()];
        columns.extend(s.columns.iter().map(|c| c[rows.clone()].to_vec()));
        samples.push_group(columns)?;
    }
    let all: Vec<&str> = data.states().iter().map(String::as_str).collect();
    let first = match WeakForm::default().system(&libraries[0], Dataset::TIME, &all, &samples) {
        Ok(system) => system,
        Err(SindyError::TooShort { .. }) => return Ok(None),
        Err(other) => return Err(other),
    };
    let half_width = first.half_width;
    let mut grams = Vec::new();
    for ((library, state), own) in libraries.iter().zip(&all).zip(first.grams) {
        if *library == libraries[0] {
            grams.push(own);
            continue;
        }
        // The same windows for all equations.
        let form = WeakForm::default().half_width(half_width)?;
        let system = form.system(library, Dataset::TIME, &[state], &samples)?;
        grams.extend(system.grams);
    }
    Ok(Some(Statistics {
        smoothing: format!("weak form, half-width {half_width:.4}"),
        grams,
        // Windows lie an eighth of a half-width apart.
        independent: 0.25,
    }))
}

/// The best subsets of one equation; in a large library of those terms that a forward path meets first.
pub(super) fn best_subsets(gram: &Gram, nodes: u64) -> Result<BestSubsets, SindyError> {
    let p = gram.xty.len();
    if p <= EXACT {
        return BestSubset::new().max_size(14).node_limit(nodes).solve(gram);
    }
    let (_, steps) = Stepwise::new(Direction::Forward, Criterion::Aic).path(gram)?;
    let mut met: Vec<usize> = Vec::new();
    for step in &steps {
        if !met.contains(&step.term) && met.len() < EXACT {
            met.push(step.term);
        }
    }
    met.sort_unstable();
    let mut found = BestSubset::new()
        .max_size(14)
        .node_limit(nodes)
        .solve(&part(gram, &met))?;
    for subset in &mut found.sizes {
        let mut support = vec![false; p];
        met.iter()
            .zip(&subset.fit.support)
            .for_each(|(&j, s)| support[j] = *s);
        subset.fit = Fit::on_support(gram, support, subset.fit.outcome, subset.fit.iterations);
    }
    Ok(found)
}

/// The statistics over some of the terms.
fn part(gram: &Gram, terms: &[usize]) -> Gram {
    Gram {
        xtx: gram.xtx.select_rows(terms).select_columns(terms),
        xty: DVector::from_fn(terms.len(), |a, _| gram.xty[terms[a]]),
        triangle: None,
        ..gram.clone()
    }
}

/// Least squares on a support without the terms that hardly contribute.
fn relevant(total: &Gram, fit: &Fit, share: f64) -> Fit {
    let rms = total.column_rms();
    let all = [(0..fit.support.len()).collect()];
    let mut support = fit.support.clone();
    for j in irrelevant(&fit.coefficients, rms.as_slice(), &all, share) {
        support[j] = false;
    }
    Fit::on_support(total, support, fit.outcome, fit.iterations)
}

/// Best subsets by the Bayesian criterion, and SR3 by cross-validation over λ and ν.
pub(super) fn solve(
    statistics: &Statistics,
    settings: &Settings,
) -> Result<Vec<Regression>, SindyError> {
    let mut subsets = Vec::new();
    let mut relaxed = Vec::new();
    let mut points = Vec::new();
    for parts in &statistics.grams {
        let total = Gram::total(parts);
        let p = total.xty.len() as f64;
        let rows = (total.rows as f64 * statistics.independent).max(2.0 * p);
        let found = best_subsets(&total, NODES)?;
        let best = found.choose(&total, Criterion::Bic, Some(rows))?;
        subsets.push(relevant(&total, &best.fit, settings.relevance));
        let folds = parts.iter().filter(|g| g.rows > 0).count();
        if folds < 2 {
            continue;
        }
        let grid = Grid {
            thresholds: settings.thresholds.clone(),
            nus: settings.nus.clone(),
        };
        let choice = cross_validate(parts, &grid)?;
        points.push(Some(choice.point));
        let fit = Fit::on_support(
            &total,
            choice.solution.support.clone(),
            choice.solution.outcome,
            choice.solution.iterations,
        );
        relaxed.push(relevant(&total, &fit, settings.relevance));
    }
    let name = |solver: &str| format!("{solver}; {}", statistics.smoothing);
    let mut out = vec![Regression {
        name: name("best subset"),
        solver: "best_subset",
        smoothing: statistics.smoothing.clone(),
        points: vec![None; subsets.len()],
        fits: subsets,
    }];
    if relaxed.len() == statistics.grams.len() {
        out.push(Regression {
            name: name("SR3"),
            solver: "sr3",
            smoothing: statistics.smoothing.clone(),
            points,
            fits: relaxed,
        });
    }
    Ok(out)
}
