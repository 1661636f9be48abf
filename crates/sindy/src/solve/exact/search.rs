//! The depth-first search over nodes, and its books: the best of every size, and what was left open.

use super::BestSubset;
use super::node::Node;
use crate::solve::outcome::Outcome;
use crate::solve::sign::{Sign, broken, is_constrained};
use crate::statistics::normal::{Additions, Normal};

/// How many nodes pass between two questions to the caller.
const ASK: u64 = 1024;

/// The best residuals of a search, in shares of `yᵀ y`.
pub(super) struct BestPerSize {
    /// By size: the smallest residual, and its subset; infinite where none keeps the signs.
    pub(super) best: Vec<(f64, u128)>,
    /// By size: the smallest bound of all pruned parts of the tree.
    pub(super) open: Vec<f64>,
    pub(super) nodes: u64,
    pub(super) stopped: Option<Outcome>,
}

impl BestPerSize {
    /// Whether no subset of this size keeps the signs, or a smaller one is better.
    pub(super) fn is_beaten(&self, size: usize) -> bool {
        let own = self.best[size].0;
        own == f64::INFINITY || self.best[..size].iter().any(|b| b.0 < own)
    }
}

struct Search<'a> {
    normal: &'a Normal,
    /// Signs of the columns of `normal`; empty where none is given.
    signs: Vec<Sign>,
    found: BestPerSize,
    terms: usize,
    floor: f64,
    keep: f64,
    node_limit: u64,
    keep_going: &'a mut dyn FnMut() -> bool,
    /// One node for each depth.
    levels: Vec<Node>,
}

/// `None` if the matrix is not positive definite.
pub(super) fn run(
    normal: &Normal,
    signs: &[Sign],
    settings: &BestSubset,
    keep_going: &mut dyn FnMut() -> bool,
) -> Option<BestPerSize> {
    let m = normal.terms.len();
    let max = settings.max_size.min(m);
    let mut best = vec![(f64::INFINITY, 0); max + 1];
    best[0] = (1.0, 0);
    let signs = match is_constrained(signs) {
        true => normal.terms.iter().map(|&j| signs[j]).collect(),
        false => Vec::new(),
    };
    let mut search = Search {
        normal,
        signs,
        found: BestPerSize {
            best,
            open: vec![f64::INFINITY; max + 1],
            nodes: 0,
            stopped: None,
        },
        terms: m,
        floor: normal.floor,
        keep: 1.0 - settings.tolerance,
        node_limit: settings.node_limit,
        keep_going,
        levels: Vec::new(),
    };
    search.forward(normal);
    if max == 0 {
        return Some(search.found);
    }
    let factor = normal.g.clone().cholesky()?;
    let l = factor.l_dirty();
    let z = l.solve_lower_triangular(&normal.b)?.as_slice().to_vec();
    search.levels.push(Node::root(m, |i, c| l[(i, c)], z));
    search.offer(m, search.levels[0].residual, all(m));
    search.visit(0);
    Some(search.found)
}

fn all(m: usize) -> u128 {
    if m >= 128 { u128::MAX } else { (1 << m) - 1 }
}

impl Search<'_> {
    fn offer(&mut self, size: usize, residual: f64, mask: u128) {
        let better = self.found.best.get(size).is_some_and(|b| residual < b.0);
        if better && self.keeps_signs(mask) {
            self.found.best[size] = (residual, mask);
        }
    }

    /// Whether the least-squares estimate of a subset keeps all signs.
    fn keeps_signs(&self, mask: u128) -> bool {
        if self.signs.is_empty() {
            return true;
        }
        let index: Vec<usize> = (0..self.terms).filter(|j| mask >> j & 1 == 1).collect();
        let estimate = self.normal.solve(&index, |_| 0.0);
        let signs: Vec<Sign> = index.iter().map(|&j| self.signs[j]).collect();
        broken(&signs, estimate.as_slice()).next().is_none()
    }

    /// First candidates: forward selection.
    fn forward(&mut self, normal: &Normal) {
        let mut additions = Additions::new(normal);
        let mut mask = 0;
        for size in 1..self.found.best.len() {
            let best = additions.gains().max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((j, _)) = best else {
                return;
            };
            additions.add(j);
            mask |= 1 << j;
            self.offer(size, 1.0 - additions.explained(), mask);
        }
    }

    /// Whether a part of the tree cannot better the best of this size.
    fn ruled_out(&self, size: usize, bound: f64) -> bool {
        // Where signs leave no subset of this size, a smaller one has to be bettered.
        let best = match self.signs.is_empty() {
            true => self.found.best[size].0,
            false => self.found.best[..=size]
                .iter()
                .fold(f64::INFINITY, |least, b| least.min(b.0)),
        };
        bound >= best * self.keep - self.floor
    }

    fn visit(&mut self, depth: usize) {
        self.found.nodes += 1;
        if self.found.nodes.is_multiple_of(ASK) && !(self.keep_going)() {
            self.found.stopped = Some(Outcome::Stopped);
        }
        if self.found.nodes >= self.node_limit {
            self.found.stopped.get_or_insert(Outcome::NodeLimit);
        }
        self.levels[depth].prepare();
        if self.levels.len() == depth + 1 {
            self.levels.push(Node::new(self.terms));
        }
        // Taken out, so that the books may be written while it is read.
        let node = std::mem::take(&mut self.levels[depth]);
        self.leading(&node);
        let n = node.free.len();
        // Small subtrees first: they improve the best ones before the large ones are looked at.
        for i in (0..n.saturating_sub(1)).rev() {
            self.child(depth, &node, i);
        }
        self.levels[depth] = node;
    }

    /// The fixed terms with the first of the free ones: all of their residuals are at hand.
    fn leading(&mut self, node: &Node) {
        let mut residual = node.residual;
        let mut mask = node.free.iter().fold(node.fixed, |m, &j| m | 1 << j);
        for i in (0..node.free.len()).rev() {
            residual += node.z[i] * node.z[i];
            mask &= !(1 << node.free[i]);
            self.offer(node.k + i, residual, mask);
        }
    }

    /// The subsets without free term `i`, with those before it, and with some of those after it.
    fn child(&mut self, depth: usize, node: &Node, i: usize) {
        let size = node.k + node.free.len();
        let own = node.residual + node.cost[i];
        let whole = node.free.iter().fold(node.fixed, |m, &j| m | 1 << j);
        self.offer(size - 1, own, whole & !(1 << node.free[i]));
        // Sizes below: at least one more goes, out of those after i, the cheapest of them at the end.
        let mut sum = node.cost[i];
        let mut open = false;
        let smallest = node.k + i + 1;
        for s in (smallest..size - 1).rev() {
            sum += node.cost[s + 1 - node.k];
            if s < self.found.best.len() && !self.ruled_out(s, bound(node, i, sum)) {
                open = true;
                break;
            }
        }
        if open && self.found.stopped.is_none() {
            let mut next = std::mem::take(&mut self.levels[depth + 1]);
            next.child_of(node, i);
            self.levels[depth + 1] = next;
            self.visit(depth + 1);
            return;
        }
        let mut sum = node.cost[i];
        for s in (smallest..size - 1).rev() {
            sum += node.cost[s + 1 - node.k];
            if let Some(open) = self.found.open.get_mut(s) {
                *open = open.min(bound(node, i, sum));
            }
        }
    }
}

/// Lower bound of the residual after `i` and others after it are dropped, whose costs add up to `sum`.
fn bound(node: &Node, i: usize, sum: f64) -> f64 {
    node.residual + node.cost[i].max(sum / node.spread[i])
}
