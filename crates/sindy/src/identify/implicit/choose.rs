//! The choice among the relations of all equations by the trajectories that follow from them.

use super::compare::{Comparison, Followed, Sought, Terms};
use super::relation::{Candidates, Relation};
use super::rows::Rows;
use super::run::{Compared, SHARED};
use super::starts::{enlarged, exchanged};
use crate::error::SindyError;
use crate::identify::Progress;

/// Candidates of all equations above which terms that no regression kept are not looked for: steps cost the cube of their number.
const MOST_CANDIDATES: usize = 150;
/// Passes over the equations, each with the others held, at most.
const SWEEPS: usize = 2;

/// What was chosen.
pub(super) struct Choice {
    pub relations: Vec<Option<Relation>>,
    /// By equation, best first.
    pub compared: Vec<Vec<Compared>>,
}

/// Compares the relations of each equation, the other equations being the best so far.
pub(super) fn choose(
    comparison: &Comparison<'_, '_>,
    found: &[Vec<Relation>],
    ordinary: &[Option<Relation>],
    progress: &mut dyn FnMut(Progress),
) -> Result<Choice, SindyError> {
    let first: Vec<Option<Relation>> = found.iter().map(|f| f.first().cloned()).collect();
    let mut best: Option<Followed> = None;
    let shared = joint(found);
    let starts = [ordinary, &first].into_iter();
    for start in starts.chain(shared.iter().map(Vec::as_slice)) {
        // To the end: where denominators are far off, the first round of the true relations is worse than a long sum.
        let followed = comparison.follow(start, f64::INFINITY, Terms::Worthwhile)?;
        best = better(best, followed);
    }
    let mut relations = match &best {
        Some(best) => best.relations.clone(),
        None => first,
    };
    let total: usize = found.iter().map(Vec::len).sum();
    let mut compared = vec![Vec::new(); found.len()];
    let supports =
        |r: &[Option<Relation>]| -> Vec<_> { r.iter().flatten().map(Relation::support).collect() };
    for _ in 0..SWEEPS {
        let before = supports(&relations);
        let mut number = 0;
        for (i, alternatives) in found.iter().enumerate() {
            compared[i].clear();
            for alternative in alternatives {
                number += 1;
                progress(Progress::Relations { number, total });
                let one = compare(
                    comparison,
                    &relations,
                    (i, alternative, Terms::Worthwhile),
                    &mut best,
                )?;
                compared[i].push(one);
            }
            if let Some(best) = &best {
                relations.clone_from(&best.relations);
            }
            let (Some(own), Sought::Relation(of)) = (&relations[i], &comparison.sought[i]) else {
                continue;
            };
            for (other, terms) in neighbours(of, own, &compared[i]) {
                let one = compare(comparison, &relations, (i, &other, terms), &mut best)?;
                compared[i].push(one);
            }
            if let Some(best) = &best {
                relations.clone_from(&best.relations);
            }
        }
        best = better(best, among_all(comparison, &relations)?);
        if let Some(best) = &best {
            relations.clone_from(&best.relations);
        }
        if before == supports(&relations) {
            break;
        }
    }
    if let Some(best) = &best {
        relations.clone_from(&best.relations);
        for (compared, relation) in compared.iter_mut().zip(&relations) {
            let relation = relation.iter().cloned();
            compared.extend(relation.map(|relation| Compared {
                relation,
                score: best.score,
                misfit: best.misfit,
            }));
        }
    }
    compared.iter_mut().for_each(best_first);
    Ok(Choice {
        relations,
        compared,
    })
}

/// Relations near to the best one of an equation that were not compared: with one term exchanged, and with one more.
fn neighbours(
    (candidates, rows): &(Candidates, Rows),
    best: &Relation,
    compared: &[Compared],
) -> Vec<(Relation, Terms)> {
    let of = |relations: Vec<Relation>, terms| relations.into_iter().map(move |r| (r, terms));
    let exchanged = of(exchanged(rows, candidates, best), Terms::Worthwhile);
    let enlarged = of(enlarged(rows, candidates, best), Terms::All);
    let new = |r: &Relation| {
        let support = r.support();
        compared.iter().all(|c| c.relation.support() != support)
    };
    let all = exchanged.chain(enlarged);
    all.filter(|(relation, _)| new(relation)).collect()
}

/// Follows the relations with `alternative` as that of equation `i`.
fn compare(
    comparison: &Comparison<'_, '_>,
    relations: &[Option<Relation>],
    (i, alternative, terms): (usize, &Relation, Terms),
    best: &mut Option<Followed>,
) -> Result<Compared, SindyError> {
    let mut tried = relations.to_vec();
    tried[i] = Some(alternative.clone());
    let least = best.as_ref().map_or(f64::INFINITY, |b| b.score);
    let followed = comparison.follow(&tried, least, terms)?;
    let infinite = (f64::INFINITY, f64::INFINITY);
    let (score, misfit) = followed.as_ref().map_or(infinite, |f| (f.score, f.misfit));
    let relation = followed.as_ref().and_then(|f| f.relations[i].clone());
    *best = better(best.take(), followed);
    Ok(Compared {
        relation: relation.unwrap_or_else(|| alternative.clone()),
        score,
        misfit,
    })
}

/// Sorts by score; the best of those with the same terms stays.
fn best_first(compared: &mut Vec<Compared>) {
    compared.sort_by(|a, b| a.score.total_cmp(&b.score));
    let mut seen = Vec::new();
    compared.retain(|c| {
        let support = c.relation.support();
        let new = !seen.contains(&support);
        seen.push(support);
        new
    });
}

fn better(best: Option<Followed>, other: Option<Followed>) -> Option<Followed> {
    match (best, other) {
        (Some(best), Some(other)) if other.score < best.score => Some(other),
        (Some(best), _) => Some(best),
        (None, other) => other,
    }
}

/// The relations with terms that all candidates offer to first order.
fn among_all(
    comparison: &Comparison<'_, '_>,
    relations: &[Option<Relation>],
) -> Result<Option<Followed>, SindyError> {
    if comparison.size() > MOST_CANDIDATES {
        return Ok(None);
    }
    let linear = comparison.linear(relations, true)?;
    let Some(fit) = comparison.fit(relations, &linear, Terms::Worthwhile)? else {
        return Ok(None);
    };
    let Some(moved) = comparison.moved(relations, &linear, &fit.coefficients) else {
        return Ok(None);
    };
    comparison.follow(&moved, f64::INFINITY, Terms::Worthwhile)
}

/// For each denominator that several equations can have, the relations of all equations with it, or the best of those without it:
/// the best by themselves, and those that were found over the denominator of another equation, which come last.
fn joint(found: &[Vec<Relation>]) -> Vec<Vec<Option<Relation>>> {
    let has = |shape: &[usize]| {
        let shape = shape.to_vec();
        move |r: &Relation| r.denominators() == shape
    };
    let all = found.iter().flatten().map(Relation::denominators);
    let mut shapes: Vec<Vec<usize>> = Vec::new();
    for shape in all.filter(|s| s.len() > 1) {
        let equations = found.iter().filter(|own| own.iter().any(has(&shape)));
        if equations.count() > 1 && shapes.len() < SHARED && !shapes.contains(&shape) {
            shapes.push(shape);
        }
    }
    let mut starts: Vec<Vec<Option<Relation>>> = Vec::new();
    for shape in &shapes {
        for last in [false, true] {
            let place = |own: &Vec<Relation>| match last {
                true => own.iter().rposition(has(shape)),
                false => own.iter().position(has(shape)),
            };
            let of = |own: &Vec<Relation>| own.get(place(own).unwrap_or(0)).cloned();
            let start: Vec<Option<Relation>> = found.iter().map(of).collect();
            if !starts.contains(&start) {
                starts.push(start);
            }
        }
    }
    starts
}
