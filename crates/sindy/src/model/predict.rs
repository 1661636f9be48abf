//! The right-hand side of a model, over single rows and over whole columns.

use std::collections::HashMap;
use std::ops::Range;

use sindy_expr::{Expr, Program, Scratch};

use super::{Model, Term};
use crate::data::samples::{Block, BlockSource, position};
use crate::error::{SindyError, same_size};
use crate::library::compile;

/// Rows of the terms' values that are held at once: the values of 56 terms stay in a level-2 cache.
const CHUNK: usize = 512;

/// The distinct terms of all equations compiled together, and which of them each equation sums.
#[derive(Clone, Debug)]
pub(super) struct Compiled {
    program: Program,
    /// For each equation, its part of `entries`.
    rows: Vec<Range<usize>>,
    /// (term, coefficient).
    entries: Vec<(usize, f64)>,
}

impl Compiled {
    pub(super) fn new(
        states: &[String],
        inputs: &[String],
        equations: &[Vec<Term>],
    ) -> Result<Self, SindyError> {
        let columns: Vec<&str> = states.iter().chain(inputs).map(String::as_str).collect();
        let sums: Vec<Vec<(&Expr, f64)>> = equations
            .iter()
            .map(|terms| {
                terms
                    .iter()
                    .map(|t| (&t.expression, t.coefficient))
                    .collect()
            })
            .collect();
        Self::of_sums(&columns, &sums)
    }

    /// Sums of coefficient times expression, over the given columns.
    pub(super) fn of_sums(
        columns: &[&str],
        sums: &[Vec<(&Expr, f64)>],
    ) -> Result<Self, SindyError> {
        let mut place: HashMap<&Expr, usize> = HashMap::new();
        let mut distinct: Vec<Expr> = Vec::new();
        let mut entries = Vec::new();
        let mut rows = Vec::with_capacity(sums.len());
        for sum in sums {
            let start = entries.len();
            for &(expression, coefficient) in sum {
                let term = *place.entry(expression).or_insert_with(|| {
                    distinct.push(expression.clone());
                    distinct.len() - 1
                });
                entries.push((term, coefficient));
            }
            rows.push(start..entries.len());
        }
        Ok(Self {
            program: compile(&distinct, columns)?,
            rows,
            entries,
        })
    }

    /// Working memory for one row.
    pub(super) fn workspace(&self) -> Workspace {
        Workspace {
            terms: vec![0.0; self.program.outputs()],
            scratch: Scratch::new(),
        }
    }

    /// One row: `out[i]` is the sum of equation i, from the left.
    pub(super) fn row(&self, row: &[f64], out: &mut [f64], work: &mut Workspace) {
        self.program
            .eval_row(row, &mut work.terms, &mut work.scratch);
        for (out, range) in out.iter_mut().zip(&self.rows) {
            let mut sum = 0.0;
            for &(term, coefficient) in &self.entries[range.clone()] {
                sum += coefficient * work.terms[term];
            }
            *out = sum;
        }
    }

    /// For one row, the sum of the magnitudes of equation i's terms: the scale of its rounding error.
    pub(super) fn magnitudes(&self, row: &[f64], out: &mut [f64], work: &mut Workspace) {
        self.program
            .eval_row(row, &mut work.terms, &mut work.scratch);
        for (out, range) in out.iter_mut().zip(&self.rows) {
            let entries = &self.entries[range.clone()];
            *out = entries
                .iter()
                .map(|&(term, c)| (c * work.terms[term]).abs())
                .sum();
        }
    }

    /// Whole columns of n rows; `out` holds the equations' columns one after another.
    fn columns(&self, columns: &[&[f64]], n: usize, out: &mut [f64]) {
        out.fill(0.0);
        let terms = self.program.outputs();
        let mut values = vec![0.0; terms * n.min(CHUNK)];
        let mut scratch = Scratch::new();
        for start in (0..n).step_by(CHUNK) {
            let end = n.min(start + CHUNK);
            let len = end - start;
            let part: Vec<&[f64]> = columns.iter().map(|c| &c[start..end]).collect();
            let values = &mut values[..terms * len];
            self.program.eval_block(&part, values, &mut scratch);
            for (i, range) in self.rows.iter().enumerate() {
                let out = &mut out[i * n + start..i * n + end];
                for &(term, coefficient) in &self.entries[range.clone()] {
                    for (out, value) in out.iter_mut().zip(&values[term * len..][..len]) {
                        *out += coefficient * value;
                    }
                }
            }
        }
    }
}

/// Working memory of [`Compiled::row`].
#[derive(Clone, Debug)]
pub(super) struct Workspace {
    terms: Vec<f64>,
    scratch: Scratch,
}

/// Evaluates a model row by row without allocating; see [`Model::evaluator`].
#[derive(Clone, Debug)]
pub struct Evaluator<'m> {
    model: &'m Model,
    row: Vec<f64>,
    work: Workspace,
}

impl Evaluator<'_> {
    /// The right-hand side at one state and input: `out` becomes `dx/dt` or `x[k+1]`. Values outside a
    /// term's domain give NaN or infinity, as in IEEE 754.
    ///
    /// # Panics
    /// If `state` or `out` does not have one value for each state, or `input` one for each input.
    pub fn eval(&mut self, state: &[f64], input: &[f64], out: &mut [f64]) {
        let n = self.model.states.len();
        assert_eq!(out.len(), n, "one place for each state");
        self.row[..n].copy_from_slice(state);
        self.row[n..].copy_from_slice(input);
        self.model.compiled.row(&self.row, out, &mut self.work);
    }
}

impl Model {
    /// The right-hand side as a function of one row.
    #[must_use]
    pub fn evaluator(&self) -> Evaluator<'_> {
        Evaluator {
            model: self,
            row: vec![0.0; self.states.len() + self.inputs.len()],
            work: self.compiled.workspace(),
        }
    }

    /// The right-hand side over columns of n rows: `columns` are the states and then the inputs, in the
    /// model's order; the result has one column of n values for each state. Each row has the same value
    /// as from [`Evaluator::eval`].
    ///
    /// # Errors
    /// [`SindyError::Shape`] for a wrong number of columns or columns of unequal length.
    pub fn predict(&self, columns: &[&[f64]]) -> Result<Vec<Vec<f64>>, SindyError> {
        let expected = self.states.len() + self.inputs.len();
        same_size("columns (states, then inputs)", expected, columns.len())?;
        let n = columns.first().map_or(0, |c| c.len());
        for column in columns {
            same_size("rows of a column", n, column.len())?;
        }
        if n == 0 {
            return Ok(vec![Vec::new(); self.states.len()]);
        }
        let mut out = vec![0.0; n * self.states.len()];
        self.compiled.columns(columns, n, &mut out);
        Ok(out.chunks_exact(n).map(<[f64]>::to_vec).collect())
    }

    /// The right-hand side over a source, block by block: columns are found by name, `visit` gets each
    /// block with one column of values for each state. Nothing larger than a block is held.
    ///
    /// # Errors
    /// [`SindyError::UnknownColumn`] if the source lacks a state or an input; a pass that failed
    /// ([`BlockSource::failure`]).
    pub fn predict_source(
        &self,
        source: &dyn BlockSource,
        visit: &mut dyn FnMut(Block<'_>, &[Vec<f64>]),
    ) -> Result<(), SindyError> {
        let places = self
            .columns()
            .into_iter()
            .map(|name| position(source.names(), name))
            .collect::<Result<Vec<_>, _>>()?;
        let mut failed = None;
        source.for_each_block(&mut |block| {
            let columns: Vec<&[f64]> = places.iter().map(|&p| block.columns[p]).collect();
            match self.predict(&columns) {
                Ok(values) => visit(block, &values),
                Err(error) => failed = Some(error),
            }
        });
        failed.or_else(|| source.failure()).map_or(Ok(()), Err)
    }
}
