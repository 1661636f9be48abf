//! Regression: supports and coefficients from slopes or the weak form, as models and as starts.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::known::KnownPart;
use super::prepare::{Slopes, WEIGHT, blocks, regression_samples, slope_name, weight_name};
use super::settings::{Score, Settings};
use crate::choose::Grid;
use crate::choose::select::{Family, Rule, folded, select, sr3_points};
use crate::data::dataset::{Dataset, Stretch};
use crate::data::samples::Samples;
use crate::error::SindyError;
use crate::library::Library;
use crate::solve::exact::{BestSubset, BestSubsets, Subset};
use crate::solve::fit::Fit;
use crate::solve::outcome::Outcome;
use crate::solve::sign::{self, Sign};
use crate::solve::stepwise::{Direction, Stepwise};
use crate::statistics::criteria::Criterion;
use crate::statistics::gram::{Accumulate, Gram};
use crate::statistics::regression::{LastEigenspaces, Refits};
use crate::statistics::tsqr::CONDITION_LIMIT;
use crate::trajectory::output_error::irrelevant;
use crate::weak::WeakForm;

/// Terms above which best subsets are searched among those of a stepwise path only: the time of an exact search doubles
/// with every few terms.
const EXACT: usize = 40;
/// Terms of a best subset, at most. Equations of more terms are found by SR3, which has no limit.
const MOST_TERMS: usize = 14;
/// Terms of the sparser starts, at most: where data hardly distinguish terms, a criterion keeps far too many.
const SPARSE: usize = 4;
/// Nodes of a branch and bound, at most, for a start (some milliseconds; the output error mends what it misses) and for a
/// front (a fraction of a second; beyond it the front is reported as not proven).
pub(super) const NODES: u64 = 8_000;
pub(crate) const FRONT_NODES: u64 = 200_000;
/// Windows of the weak form lie an eighth of a half-width apart: this share of them is independent.
pub(super) const INDEPENDENT_WINDOWS: f64 = 0.25;

/// One regression for every equation.
#[derive(Clone)]
pub(super) struct Regression {
    /// For tables: solver and smoothing.
    pub name: String,
    pub solver: &'static str,
    pub smoothing: String,
    /// λ and ν where SR3 chose, one for each equation.
    pub points: Vec<Option<(f64, f64)>>,
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
    /// By equation, then block, where `grams` join all equations under invariants; else none.
    pub separate: Vec<Vec<Gram>>,
}

impl Statistics {
    fn regression(
        &self,
        solver: &'static str,
        how: &str,
        points: Vec<Option<(f64, f64)>>,
        fits: Vec<Fit>,
    ) -> Regression {
        Regression {
            name: format!("{how}; {}", self.smoothing),
            solver,
            smoothing: self.smoothing.clone(),
            points,
            fits,
        }
    }
}

/// Root mean square of every term of every equation.
pub(super) fn term_rms(grams: &[Vec<Gram>]) -> Vec<f64> {
    let of = |parts: &Vec<Gram>| Gram::total(parts).column_rms().as_slice().to_vec();
    grams.iter().flat_map(of).collect()
}

/// Statistics of slopes.
pub(super) fn of_slopes(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    libraries: &[(Library, KnownPart)],
    slopes: &Slopes,
    folds: usize,
) -> Result<Statistics, SindyError> {
    let samples = regression_samples(data, stretches, slopes, &blocks(stretches, folds))?;
    let weighted = stretches.iter().any(|s| s.weights.is_some());
    let mut grams = Vec::new();
    for (i, (library, known)) in libraries.iter().enumerate() {
        let target = slope_name(i);
        let library = known.with(library);
        let mut of = Accumulate::new(&library, &target);
        let own = weight_name(i);
        if !slopes.weights.is_empty() {
            of = of.weights(&own);
        } else if weighted {
            of = of.weights(WEIGHT);
        }
        let mut parts = of.over(&samples)?;
        if Gram::total(&parts).condition() > CONDITION_LIMIT {
            parts = of.triangle(true).over(&samples)?;
        }
        grams.push(parts.into_iter().map(|g| known.less(g)).collect());
    }
    Ok(Statistics {
        smoothing: slopes.name.clone(),
        grams,
        independent: 1.0 / slopes.window,
        separate: Vec::new(),
    })
}

/// Statistics of the weak form; `None` where no stretch holds a window.
pub(super) fn of_weak_form(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    libraries: &[(Library, KnownPart)],
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
    let libraries: Vec<(Library, &KnownPart)> =
        libraries.iter().map(|(l, k)| (k.with(l), k)).collect();
    let shared = &libraries[0].0;
    let first = match WeakForm::default().system(shared, Dataset::TIME, &all, &samples) {
        Ok(system) => system,
        Err(SindyError::TooShort { .. }) => return Ok(None),
        Err(other) => return Err(other),
    };
    let half_width = first.half_width;
    let mut grams = Vec::new();
    for (((library, known), state), own) in libraries.iter().zip(&all).zip(first.grams) {
        let parts = if library == shared {
            own
        } else {
            // The same windows for all equations.
            let form = WeakForm::default().half_width(half_width)?;
            let system = form.system(library, Dataset::TIME, &[state], &samples)?;
            system.grams.into_iter().flatten().collect()
        };
        grams.push(parts.into_iter().map(|g| known.less(g)).collect());
    }
    Ok(Some(Statistics {
        smoothing: format!("weak form, half-width {half_width:.4}"),
        grams,
        independent: INDEPENDENT_WINDOWS,
        separate: Vec::new(),
    }))
}

/// The fit of an equation in which nothing is looked for.
fn nothing(gram: &Gram) -> Fit {
    Fit {
        coefficients: DVector::zeros(0),
        support: Vec::new(),
        residual_sum: gram.yty,
        outcome: Outcome::Optimal,
        iterations: 0,
    }
}

/// The best subsets of one equation; in a large library of those terms that a forward path meets first.
pub(crate) fn best_subsets(gram: &Gram, nodes: u64) -> Result<BestSubsets, SindyError> {
    signed_subsets(gram, &[], nodes)
}

/// The same among subsets that keep the signs: one for each term, or none.
pub(super) fn signed_subsets(
    gram: &Gram,
    signs: &[Sign],
    nodes: u64,
) -> Result<BestSubsets, SindyError> {
    let p = gram.xty.len();
    if p == 0 {
        let nothing = Subset {
            fit: nothing(gram),
            lower_bound: gram.yty,
        };
        return Ok(BestSubsets {
            sizes: vec![nothing],
            outcome: Outcome::Optimal,
            nodes: 0,
            ridge: 0.0,
        });
    }
    if p <= EXACT {
        return BestSubset::new()
            .max_size(MOST_TERMS)
            .node_limit(nodes)
            .solve_signed(gram, signs);
    }
    let forward = Stepwise::new(Direction::Forward, Criterion::Aic).at_most(EXACT);
    let (_, steps) = forward.path(gram)?;
    let mut met: Vec<usize> = steps.iter().map(|step| step.term).collect();
    met.sort_unstable();
    let own: Vec<Sign> = met.iter().filter_map(|&j| signs.get(j).copied()).collect();
    let mut found = BestSubset::new()
        .max_size(MOST_TERMS)
        .node_limit(nodes)
        .solve_signed(&part(gram, &met), &own)?;
    for subset in &mut found.sizes {
        let mut support = vec![false; p];
        met.iter()
            .zip(&subset.fit.support)
            .for_each(|(&j, s)| support[j] = *s);
        let fit = Fit::on_support(gram, support, subset.fit.outcome, subset.fit.iterations);
        subset.fit = sign::kept(gram, fit, signs);
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
pub(crate) fn relevant(refits: &mut Refits<'_>, fit: &Fit, share: f64) -> Fit {
    let rms = refits.gram.column_rms();
    let all = [(0..fit.support.len()).collect()];
    let mut support = fit.support.clone();
    for j in irrelevant(&fit.coefficients, rms.as_slice(), &all, share) {
        support[j] = false;
    }
    let coefficients = refits.on(&support);
    Fit::new(
        refits.gram,
        coefficients,
        support,
        fit.outcome,
        fit.iterations,
    )
}

/// Computes best subsets, and SR3 over the whole grid of λ and ν. Where free runs judge, every support that the grid
/// gives for all equations together is a separate candidate model. Otherwise the score chooses each equation's point.
pub(super) fn solve(
    statistics: &Statistics,
    signs: &[Vec<Sign>],
    settings: &Settings,
) -> Result<Vec<Regression>, SindyError> {
    let points = Grid {
        thresholds: settings.thresholds.clone(),
        nus: settings.nus.clone(),
    }
    .points()?;
    let family = sr3_points(&points)?;
    let inverses = Arc::<LastEigenspaces>::default();
    let equations: Vec<Equation> = statistics
        .grams
        .par_iter()
        .zip(signs)
        .map(|(parts, signs)| {
            let rows = statistics.independent;
            let family = (&family as &dyn Family, points.len());
            Equation::solve(parts, signs, rows, settings, family, inverses.clone())
        })
        .collect::<Result<_, _>>()?;
    let subsets: Vec<Fit> = equations.iter().map(|e| e.subset.clone()).collect();
    let none = vec![None; subsets.len()];
    let mut out = vec![statistics.regression("best_subset", "best subset", none, subsets)];
    let chosen = equations.iter().map(|e| e.grid[e.chosen].clone()).collect();
    let at = equations.iter().map(|e| Some(points[e.chosen])).collect();
    out.push(statistics.regression("sr3", "SR3", at, chosen));
    if settings.chosen_score() == Score::FreeRun {
        for (k, point) in points.iter().enumerate() {
            let fits: Vec<Fit> = equations.iter().map(|e| e.grid[k].clone()).collect();
            let same = |r: &Regression| {
                let mut pairs = r.fits.iter().zip(&fits);
                pairs.all(|(a, b)| a.support == b.support)
            };
            if !out.iter().any(same) {
                let how = format!("SR3, lambda {:.2e}, nu {}", point.0, point.1);
                let at = vec![Some(*point); fits.len()];
                out.push(statistics.regression("sr3", &how, at, fits));
            }
        }
    }
    Ok(out)
}

/// What was found for one equation.
struct Equation {
    subset: Fit,
    /// SR3 at every point of the grid, and the point that the score chooses.
    grid: Vec<Fit>,
    chosen: usize,
}

impl Equation {
    fn solve(
        parts: &[Gram],
        signs: &[Sign],
        independent: f64,
        settings: &Settings,
        (family, points): (&dyn Family, usize),
        inverses: Arc<LastEigenspaces>,
    ) -> Result<Self, SindyError> {
        let total = Gram::total(parts);
        if total.xty.is_empty() {
            return Ok(Self {
                subset: nothing(&total),
                grid: vec![nothing(&total); points],
                chosen: 0,
            });
        }
        let score = settings.chosen_score();
        let p = total.xty.len() as f64;
        let rows = (total.rows as f64 * independent).max(2.0 * p);
        let criterion = score.criterion().unwrap_or(Criterion::Bic);
        let scored = Rule::Criterion {
            criterion,
            effective_rows: Some(rows),
        };
        let folds = folded(parts, settings.folds);
        let left_out = score.criterion().is_none() && folds.len() > 1;
        let rule = if left_out { Rule::LeftOut } else { scored };
        let subset = if left_out && score == Score::LeftOut {
            let sizes = |gram: &Gram| sizes(gram, signs);
            select(&folds, &sizes, rule)?.fit().clone()
        } else {
            let found = signed_subsets(&total, signs, NODES)?;
            found.choose(&total, criterion, Some(rows))?.fit.clone()
        };
        let selection = select(&folds, family, rule)?;
        let members = selection.members.iter();
        let mut refits = Refits::new(&total, inverses);
        let mut settled = |fit: &Fit| {
            let relevant = relevant(&mut refits, fit, settings.relevance);
            sign::kept(&total, relevant, signs)
        };
        Ok(Self {
            subset: settled(&subset),
            grid: members.map(|m| settled(&m.fit)).collect(),
            chosen: selection.chosen,
        })
    }
}

/// A regression with given coefficients of every equation's candidates.
pub(super) fn from_coefficients(statistics: &Statistics, coefficients: &[Vec<f64>]) -> Regression {
    let fits = statistics.grams.iter().zip(coefficients);
    let fits = fits.map(|(parts, own)| {
        let support = own.iter().map(|c| *c != 0.0).collect();
        let own = DVector::from_column_slice(own);
        match own.is_empty() {
            true => nothing(&Gram::total(parts)),
            false => Fit::new(&Gram::total(parts), own, support, Outcome::Converged, 1),
        }
    });
    let fits: Vec<Fit> = fits.collect();
    let none = vec![None; fits.len()];
    statistics.regression("implicit", "implicit regression", none, fits)
}

/// The best subset of every size up to the largest; sizes that the data or the signs do not allow repeat the one before.
fn sizes(gram: &Gram, signs: &[Sign]) -> Result<Vec<Fit>, SindyError> {
    let found = signed_subsets(gram, signs, NODES)?;
    Ok((0..=MOST_TERMS)
        .filter_map(|k| of_size(&found, k))
        .collect())
}

/// The best subset of at most `terms` terms.
fn of_size(found: &BestSubsets, terms: usize) -> Option<Fit> {
    let mut sizes = found.sizes.iter().rev();
    sizes
        .find(|s| s.fit.terms() <= terms)
        .map(|s| s.fit.clone())
}

/// The best subsets of one term for each equation, of two, and so on: for data on which no model of [`solve`] can
/// be run freely.
pub(super) fn sparse(
    statistics: &Statistics,
    signs: &[Vec<Sign>],
) -> Result<Vec<Regression>, SindyError> {
    let equations = statistics.grams.iter().zip(signs);
    let found = equations
        .map(|(parts, signs)| signed_subsets(&Gram::total(parts), signs, NODES))
        .collect::<Result<Vec<_>, _>>()?;
    let of = |terms: usize| -> Vec<Fit> {
        let fits = found.iter().filter_map(|f| of_size(f, terms));
        fits.collect()
    };
    let regression = |terms: usize| {
        let none = vec![None; found.len()];
        let name = format!("best subset of {terms}");
        statistics.regression("best_subset", &name, none, of(terms))
    };
    Ok((1..=SPARSE).map(regression).collect())
}
