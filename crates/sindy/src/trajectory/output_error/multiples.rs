//! Multiples of one equation that another may hold unseen.
//!
//! On a slow manifold of a stiff system the terms of a fast equation cancel, `Σ_j ξ_fj θ_j = x_f' ≈ 0`. A multiple `μ` of this sum may
//! be added to another equation `i`: other terms, and the same trajectories but for the short time in which the fast state moves, over
//! which `x_i` shifts by `μ Δx_f`. In the linearisation around the solution, with `R` the sensitivities to candidates outside of the
//! support after those to the support are taken out, and `v` the coefficients of equation `f` in the candidates of `i`,
//!
//! ```text
//! σ_μ = s / ‖R v‖,    |μ| < σ_μ √(ln N + 2 ln P)   is worth less than the penalty of a term, and is not seen.
//! ```

use nalgebra::DVector;

use super::choice::Chosen;
use super::system::System;

/// The largest multiple of the equation `of` that may be added to another unseen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Multiple {
    /// The equation that it may be added to.
    pub equation: usize,
    pub of: usize,
    pub most: f64,
    /// Its largest term over the largest one of the equation that it may be added to.
    pub share: f64,
}

/// The multiples with the largest share, one for each equation; none where candidates have terms in several equations.
pub(super) fn multiples(
    system: &System,
    chosen: &Chosen,
    xi: &DVector<f64>,
    term_rms: &[f64],
) -> Vec<Multiple> {
    let mut out = Vec::new();
    if system.groups.len() != system.n {
        return out;
    }
    for i in 0..system.n {
        let all = (0..system.n).filter(|&f| f != i);
        let of = all.filter_map(|f| multiple(system, chosen, xi, term_rms, (i, f)));
        out.extend(of.max_by(|a, b| a.share.total_cmp(&b.share)));
    }
    out
}

fn multiple(
    system: &System,
    chosen: &Chosen,
    xi: &DVector<f64>,
    term_rms: &[f64],
    (i, f): (usize, usize),
) -> Option<Multiple> {
    let search = &chosen.search;
    // The terms of `f`, known ones among them, as candidates of `i`, with their coefficients.
    let found = system.parts.iter().filter(|p| p.equation == f);
    let found = found.map(|p| (p.term, xi[p.candidate]));
    let known = system.fixed.iter().filter(|(equation, ..)| *equation == f);
    let known = known.map(|&(_, term, c)| (term, c));
    let mut added = Vec::new();
    for (term, c) in found.chain(known).filter(|(_, c)| *c != 0.0) {
        let mut own = system.parts.iter().filter(|p| p.equation == i);
        added.push((own.find(|p| p.term == term)?.candidate, c));
    }
    let free: Vec<(usize, f64)> = added
        .iter()
        .copied()
        .filter(|(j, _)| !search.support[*j])
        .collect();
    let pairs = free.iter().flat_map(|a| free.iter().map(move |b| (a, b)));
    let information: f64 = pairs
        .map(|(&(j, v), &(k, w))| v * w * search.t[(j, k)] * search.length[j] * search.length[k])
        .sum();
    // Without free terms, standard errors of the support say it.
    if free.is_empty() {
        return None;
    }
    let most = (chosen.penalty() * chosen.variance / information.max(f64::MIN_POSITIVE)).sqrt();
    let largest = |terms: &mut dyn Iterator<Item = (usize, f64)>| {
        terms
            .map(|(j, c)| (c * term_rms[j]).abs())
            .fold(0.0, f64::max)
    };
    let own = largest(&mut system.groups[i].iter().map(|&j| (j, xi[j])));
    let share = most * largest(&mut added.into_iter()) / own;
    share.is_finite().then_some(Multiple {
        equation: i,
        of: f,
        most,
        share,
    })
}
