//! Relations by regression, one left side after the other.

use super::relation::{Candidates, Relation};
use super::rows::Rows;
use crate::error::SindyError;
use crate::identify::regress::best_subsets;

/// Coefficients of a denominator's term that are tried, in units of the constant over the term's size.
const GRID: [f64; 8] = [-0.6, -0.2, 0.1, 0.3, 1.0, 3.0, 10.0, 40.0];
/// Pairs of coefficients that are tried, at most.
const MOST_TRIED: usize = 2500;
/// Relations that are kept of one denominator's terms, and of all, for a fit.
const PER_SHAPE: usize = 3;
const REFINED: usize = 60;
/// Nodes of a branch and bound for one left side, at most.
const NODES: u64 = 4_000;
/// Coefficients of a relation, at most.
const MOST: usize = 9;
/// Relations that are kept for the comparison by trajectories, at most.
const KEPT: usize = 5;
/// Relations that fit as well, beside them.
const RIVALS: usize = 8;
/// Relations with one term more and with one exchanged that are compared by trajectories, at most.
const NEIGHBOURS: usize = 3;
/// Scores that are worse than the best by more are not compared by trajectories.
const BEYOND: f64 = 80.0;

/// A relation with what it leaves under the windows.
#[derive(Clone, Debug)]
pub(super) struct ScoredRelation {
    pub relation: Relation,
    /// Smaller is better: `n ln R + p (ln n + 2 ln P)` over n independent windows.
    pub score: f64,
    /// The same without the penalty.
    misfit: f64,
}

/// The relations of an equation that are worth a comparison by trajectories, best first.
pub(super) fn relations(
    rows: &Rows,
    candidates: &Candidates,
) -> Result<Vec<ScoredRelation>, SindyError> {
    let (count, price) = prices(rows, candidates);
    let mut starts = of_left_sides(rows, candidates)?;
    starts.extend(of_denominators(rows, candidates, (count, price))?);
    let mut found: Vec<ScoredRelation> = Vec::new();
    for start in starts {
        add(rows, &start.reduced(candidates), (count, price), &mut found);
    }
    found.sort_by(|a, b| a.score.total_cmp(&b.score));
    Ok(kept(&found))
}

/// Windows that count, and the price of a coefficient.
fn prices(rows: &Rows, candidates: &Candidates) -> (f64, f64) {
    let count = rows.independent.max(2.0 * MOST as f64);
    (count, count.ln() + 2.0 * (candidates.len() as f64).ln())
}

/// The best relation over each of the denominators of `others`, which are relations of other equations, best first: reactions with
/// enzymes, growth on a substrate and linked bodies divide several rates of change by the same.
pub(super) fn over_shared<'r>(
    rows: &Rows,
    candidates: &Candidates,
    others: impl Iterator<Item = &'r Relation>,
) -> Result<Vec<ScoredRelation>, SindyError> {
    let (count, price) = prices(rows, candidates);
    let mut found = Vec::new();
    for other in others {
        let mut best = over(rows, &other.denominator, (count, price))?;
        best.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, relation)) = best.first() {
            add(
                rows,
                &relation.reduced(candidates),
                (count, price),
                &mut found,
            );
        }
    }
    found.sort_by(|a, b| a.score.total_cmp(&b.score));
    Ok(found)
}

/// The best subsets of the numerator over a denominator, with their scores; none where it changes its sign.
fn over(
    rows: &Rows,
    denominator: &[(usize, f64)],
    (count, price): (f64, f64),
) -> Result<Vec<(f64, Relation)>, SindyError> {
    let relation = Relation {
        numerator: Vec::new(),
        denominator: denominator.to_vec(),
    };
    let mut out = Vec::new();
    if !rows.is_regular(&relation) {
        return Ok(out);
    }
    for subset in &best_subsets(&rows.gram_over(&relation), NODES)?.sizes {
        let fit = &subset.fit;
        let coefficients = fit.terms() + relation.free();
        if fit.terms() == 0 || coefficients > MOST {
            continue;
        }
        let mean = rows.mean_square(fit.residual_sum).max(f64::MIN_POSITIVE);
        let score = count * mean.ln() + price * coefficients as f64;
        let kept = fit.coefficients.iter().copied().enumerate();
        let numerator = kept.filter(|(_, c)| *c != 0.0).collect();
        let denominator = relation.denominator.clone();
        out.push((
            score,
            Relation {
                numerator,
                denominator,
            },
        ));
    }
    Ok(out)
}

/// Relations with one term more than this one, fitted under the windows, the nearest to the slopes first.
///
/// Under windows, noise can hide what the term is worth on trajectories. Nor does the relation to first order show it where other
/// coefficients move far when the term comes in, as those of a Hill function do with a rate at zero.
pub(super) fn enlarged(rows: &Rows, candidates: &Candidates, relation: &Relation) -> Vec<Relation> {
    let found = nearest(rows, candidates, &with_another(candidates, relation));
    let all = found.into_iter().filter(|f| f.contains(relation));
    all.take(NEIGHBOURS).collect()
}

/// Relations with one term exchanged for another on the same side, likewise: of each denominator, [`relations`] has only the best.
pub(super) fn exchanged(
    rows: &Rows,
    candidates: &Candidates,
    relation: &Relation,
) -> Vec<Relation> {
    let mut starts = Vec::new();
    for larger in with_another(candidates, relation) {
        // The side that has grown loses one of its old terms; a denominator keeps the one that is held at 1.
        let (above, below) = (relation.numerator.len(), relation.denominator.len());
        if larger.numerator.len() > above {
            starts.extend((0..above).map(|old| {
                let mut one = larger.clone();
                one.numerator.remove(old);
                one
            }));
        } else {
            starts.extend((1..below).map(|old| {
                let mut one = larger.clone();
                one.denominator.remove(old);
                one
            }));
        }
    }
    let found = nearest(rows, candidates, &starts);
    let all = found.into_iter().filter(|f| f.free() == relation.free());
    all.take(NEIGHBOURS).collect()
}

/// The relation with each further candidate, at 0.
fn with_another(candidates: &Candidates, relation: &Relation) -> Vec<Relation> {
    let has = |terms: &[(usize, f64)], j: usize| terms.iter().any(|t| t.0 == j);
    let above = (0..candidates.numerator.len()).filter(|j| !has(&relation.numerator, *j));
    let above = above.map(|j| {
        let mut with = relation.clone();
        with.numerator.push((j, 0.0));
        with
    });
    let below = (0..candidates.denominator.len()).filter(|k| !has(&relation.denominator, *k));
    let below = below.map(|k| {
        let mut with = relation.clone();
        with.denominator.push((k, 0.0));
        with
    });
    above.chain(below).collect()
}

/// Relations fitted under the windows, the nearest to the slopes first.
fn nearest(rows: &Rows, candidates: &Candidates, starts: &[Relation]) -> Vec<Relation> {
    let fitted = starts.iter().map(|start| rows.fitted(start));
    let mut found: Vec<(Relation, f64)> = fitted.filter(|f| f.1.is_finite()).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let all = found.into_iter();
    all.map(|(relation, _)| relation.reduced(candidates))
        .collect()
}

/// The best relations, and those with other terms that fit as well with at most one coefficient more.
fn kept(found: &[ScoredRelation]) -> Vec<ScoredRelation> {
    let Some(best) = found.first() else {
        return Vec::new();
    };
    let mut kept: Vec<ScoredRelation> = Vec::new();
    for one in found.iter().filter(|one| one.score <= best.score + BEYOND) {
        if kept.len() < KEPT && !kept.iter().any(|k| one.relation.contains(&k.relation)) {
            kept.push(one.clone());
        }
    }
    let most = best.relation.free() + 1;
    let mut rivals: Vec<&ScoredRelation> = found
        .iter()
        .filter(|r| r.relation.free() <= most && r.misfit <= best.misfit + BEYOND)
        .filter(|r| !r.relation.contains(&best.relation))
        .collect();
    rivals.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    let mut shapes: Vec<Vec<usize>> = Vec::new();
    for rival in rivals {
        let shape = rival.relation.denominators();
        let support = rival.relation.support();
        // The best of each denominator.
        if shapes.len() < RIVALS && !shapes.contains(&shape) {
            shapes.push(shape);
            if !kept.iter().any(|k| k.relation.support() == support) {
                kept.push(rival.clone());
            }
        }
    }
    kept
}

/// Relations by best subsets, with `x'` times each term of the denominator in turn as the left side.
fn of_left_sides(rows: &Rows, candidates: &Candidates) -> Result<Vec<Relation>, SindyError> {
    let products = rows.products();
    let m = candidates.numerator.len();
    let mut out = Vec::new();
    for left in 0..candidates.denominator.len() {
        if products[(m + left, m + left)] == 0.0 {
            continue;
        }
        let gram = rows.gram(&products, m + left);
        for subset in &best_subsets(&gram, NODES)?.sizes {
            let fit = &subset.fit;
            if fit.terms() > MOST {
                break;
            }
            let relation = of_left_side(fit.coefficients.as_slice(), m, left);
            let rests = relation.numerator.is_empty() && (left > 0 || fit.terms() > 0);
            if !rests {
                out.push(relation);
            }
        }
    }
    Ok(out)
}

/// Relations by best subsets of the numerator over denominators of one and two terms beside the constant, whose coefficients are
/// tried on a grid: no slope of the data stands in their terms, so that noise biases them less.
fn of_denominators(
    rows: &Rows,
    candidates: &Candidates,
    price: (f64, f64),
) -> Result<Vec<Relation>, SindyError> {
    let below = candidates.denominator.len();
    let mut shapes: Vec<Vec<usize>> = (1..below).map(|k| vec![k]).collect();
    let singles = shapes.len();
    shapes.extend((1..below).flat_map(|k| (k + 1..below).map(move |l| vec![k, l])));
    let pairs = (shapes.len() - singles).max(1);
    // Pairs are thinned out where there are many.
    let every = (pairs * GRID.len() * GRID.len())
        .div_ceil(MOST_TRIED)
        .max(1);
    let mut found: Vec<(f64, Relation)> = Vec::new();
    for (number, shape) in shapes.iter().enumerate() {
        if number >= singles && !(number - singles).is_multiple_of(every) {
            continue;
        }
        let mut best: Vec<(f64, Relation)> = Vec::new();
        for point in points(shape.len()) {
            let scaled = shape.iter().zip(&point);
            let mut denominator = vec![(0, 1.0)];
            denominator.extend(scaled.map(|(&k, g)| (k, g / rows.size(k))));
            best.extend(over(rows, &denominator, price)?);
        }
        // The best of each number of coefficients.
        best.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut sizes = Vec::new();
        best.retain(|(_, r)| {
            let new = sizes.len() < PER_SHAPE && !sizes.contains(&r.free());
            if new {
                sizes.push(r.free());
            }
            new
        });
        found.extend(best);
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found.into_iter().take(REFINED).map(|f| f.1).collect())
}

/// The points of the grid in so many dimensions.
fn points(dimensions: usize) -> Vec<Vec<f64>> {
    let mut out = vec![Vec::new()];
    for _ in 0..dimensions {
        out = out
            .iter()
            .flat_map(|p: &Vec<f64>| GRID.iter().map(move |g| [p.as_slice(), &[*g]].concat()))
            .collect();
    }
    out
}

/// Adds a relation, fitted under the windows, unless its terms are there already.
fn add(rows: &Rows, relation: &Relation, (count, price): (f64, f64), to: &mut Vec<ScoredRelation>) {
    let support = relation.support();
    if to.iter().any(|s| s.relation.support() == support) {
        return;
    }
    let (relation, left) = rows.fitted(relation);
    if !left.is_finite() {
        return;
    }
    let mean = rows.mean_square(left).max(f64::MIN_POSITIVE);
    let misfit = count * mean.ln();
    to.push(ScoredRelation {
        score: misfit + price * relation.free() as f64,
        misfit,
        relation,
    });
}

/// `x' φ_left = Σ ξ_j θ_j + Σ η_k x' φ_k` as a relation; `coefficients` have the candidates without `left`.
fn of_left_side(coefficients: &[f64], m: usize, left: usize) -> Relation {
    let mut relation = Relation {
        numerator: Vec::new(),
        denominator: vec![(left, 1.0)],
    };
    for (j, &c) in coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        match j.checked_sub(m) {
            None => relation.numerator.push((j, c)),
            Some(k) => relation.denominator.push((k + usize::from(k >= left), -c)),
        }
    }
    relation
}
