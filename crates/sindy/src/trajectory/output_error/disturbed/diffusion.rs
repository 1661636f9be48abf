//! The squared diffusion of each state as a sum of terms.
//!
//! ```text
//! dx_i = f_i(x, u) dt + g_i(x, u) dW_i,        g_i²(x, u) = Σ_j c_ij θ_j(x, u)
//! ```
//!
//! Disturbances of different states are independent.

use sindy_expr::{Expr, Program, Scratch};

use super::Disturbance;
use crate::error::SindyError;
use crate::library::{Library, compile};

/// The least squared diffusion that the filter takes, as a share of its mean: rows on which it is smaller were not among those that
/// the terms were chosen on.
const LEAST: f64 = 1e-6;

/// Terms that the squared diffusion of a state may have, the same for all states.
#[derive(Clone, Debug)]
pub(crate) struct DiffusionCandidates {
    /// Values of the library's terms, and of the constant 1 behind them if it is none of them: the search starts there.
    program: Program,
    /// Terms of the library.
    pub(super) offered: usize,
    /// Where the constant is.
    pub(super) constant: usize,
}

/// Their values at points, with the working memory.
pub(super) struct DiffusionValues<'a> {
    program: &'a Program,
    row: Vec<f64>,
    scratch: Scratch,
}

/// The squared diffusion of all states.
#[derive(Clone, Debug, PartialEq)]
pub struct Diffusion {
    /// By state, coefficients of all candidates; zero outside the support.
    pub coefficients: Vec<Vec<f64>>,
    /// Their standard errors.
    pub std_errors: Vec<Vec<f64>>,
    /// Twice the log-likelihood that each term of the support is worth, less the penalty for it.
    pub evidence: Vec<Vec<f64>>,
    /// Independent values that they rest on.
    pub values: usize,
}

impl DiffusionCandidates {
    pub(crate) fn new(columns: &[String], library: &Library) -> Result<Self, SindyError> {
        let one = Expr::constant(1.0);
        let mut terms = library.terms().to_vec();
        let constant = terms.iter().position(|t| t.simplify() == one);
        if constant.is_none() {
            terms.push(one);
        }
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        Ok(Self {
            program: compile(&terms, &columns)?,
            offered: library.len(),
            constant: constant.unwrap_or(library.len()),
        })
    }

    pub(super) fn len(&self) -> usize {
        self.program.outputs()
    }

    pub(super) fn values(&self) -> DiffusionValues<'_> {
        DiffusionValues {
            program: &self.program,
            row: Vec::new(),
            scratch: Scratch::new(),
        }
    }
}

impl DiffusionValues<'_> {
    /// At a state and inputs.
    pub(super) fn at(&mut self, x: &[f64], u: &[f64]) -> Vec<f64> {
        self.row.clear();
        self.row.extend_from_slice(x);
        self.row.extend_from_slice(u);
        let mut out = vec![0.0; self.program.outputs()];
        self.program
            .eval_row(&self.row, &mut out, &mut self.scratch);
        out
    }
}

impl Diffusion {
    /// The constant that the search starts from.
    pub(super) fn constant(candidates: &DiffusionCandidates, process: &[f64]) -> Self {
        let of = |q: &f64| {
            let mut all = vec![0.0; candidates.len()];
            all[candidates.constant] = *q;
            all
        };
        Self::new(process.iter().map(of).collect())
    }

    /// Coefficients of which nothing else is known.
    pub(super) fn new(coefficients: Vec<Vec<f64>>) -> Self {
        Self {
            std_errors: Vec::new(),
            evidence: Vec::new(),
            values: 0,
            coefficients,
        }
    }
}

/// A sum of terms.
pub(super) fn sum(coefficients: &[f64], terms: &[f64]) -> f64 {
    let pairs = coefficients.iter().zip(terms).filter(|(c, _)| **c != 0.0);
    pairs.map(|(c, t)| c * t).sum()
}

impl Disturbance {
    /// What disturbances add to the variance of state `i` in a unit of time, where the candidate terms have these values.
    pub(super) fn rate(&self, i: usize, terms: &[f64]) -> f64 {
        match &self.diffusion {
            None => self.process[i],
            Some(diffusion) => sum(&diffusion.coefficients[i], terms).max(LEAST * self.process[i]),
        }
    }
}
