//! Trimming: leaving out the rows that fit worst.

use crate::data::samples::{Block, BlockSource};
use crate::error::{SindyError, at_least_zero, require};
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::statistics::gram::{Accumulate, Gram};
use crate::statistics::residual::residuals;

/// Fits that leave out the rows with the largest residuals,
///
/// ```text
/// min over ξ, v   1/2 Σ_i v_i (y_i - θ_i ξ)² + …     v_i in {0, 1},  Σ v_i = h
/// ```
///
/// by turns: a fit to the rows that are kept, and then the h rows of smallest residual over all data, until they
/// are the same. Any [`Solver`] will do. For least squares on given terms each turn lowers the sum of squares; a
/// solver whose terms change may not settle, and the iteration limit ends it.
///
/// The first fit is to all rows. Gross errors in `y` are found from there; rows that are far off *in the terms* may
/// drag that fit with them, and keep a place that they should not have.
///
/// A turn costs two passes over the source, and a number for each row is held.
///
/// ```
/// use sindy::statistics::gram::Accumulate;
/// use sindy::solve::relaxed::Trimming;
/// use sindy::{Library, Samples, Stlsq};
///
/// let x: Vec<f64> = (0..200).map(|i| f64::from(i).sin()).collect();
/// let y = (0..200).map(|i| if i % 10 == 0 { 50.0 } else { 2.0 * x[i] }).collect();
/// let mut samples = Samples::new(&["x", "y"]);
/// samples.push_group(vec![x, y])?;
/// let library = Library::parse(&["1", "x"])?;
/// let trimmed =
///     Trimming::new(0.85)?.run(&Accumulate::new(&library, "y"), &samples, &Stlsq::new(0.01, 0.0)?)?;
/// assert_eq!(trimmed.fit.support, [false, true]);
/// assert!((trimmed.fit.coefficients[1] - 2.0).abs() < 1e-12);
/// # Ok::<(), sindy::SindyError>(())
/// ```
///
/// Sources: K. Champion et al., IEEE Access 8 (2020); P. J. Rousseeuw, K. Van Driessen, "Computing LTS
/// regression for large data sets", Data Mining and Knowledge Discovery 12 (2006).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trimming {
    keep: f64,
    max_iterations: usize,
}

/// The fit after trimming.
#[derive(Clone, Debug, PartialEq)]
pub struct Trimmed {
    /// The fit to the rows that were kept.
    pub fit: Fit,
    /// Their statistics, one for each group.
    pub grams: Vec<Gram>,
    /// Which rows of each group were kept. Rows that are not finite, or of weight 0, never are.
    pub kept: Vec<Vec<bool>>,
    /// The sum of (weighted) squared residuals of the rows kept, after each turn.
    pub squares: Vec<f64>,
    /// [`Outcome::Converged`] if the rows no longer change, else [`Outcome::IterationLimit`]. Why the solver
    /// stopped is in `fit`.
    pub outcome: Outcome,
}

impl Trimming {
    /// Keeps this share of the rows that can be used; at most 50 turns.
    ///
    /// # Errors
    /// A share outside (0, 1].
    pub fn new(keep: f64) -> Result<Self, SindyError> {
        require(
            keep > 0.0 && keep <= 1.0,
            "keep",
            "above 0, at most 1",
            keep,
        )?;
        Ok(Self {
            keep,
            max_iterations: 50,
        })
    }

    /// The same with another limit of turns, at least 1.
    #[must_use]
    pub fn max_iterations(self, limit: usize) -> Self {
        Self {
            max_iterations: limit.max(1),
            ..self
        }
    }

    /// Fits and trims. `accumulate` names library and target; its weights, if any, weigh the squared residuals too.
    ///
    /// # Errors
    /// As [`Accumulate::over`]; errors of the solver.
    pub fn run(
        &self,
        accumulate: &Accumulate<'_>,
        source: &dyn BlockSource,
        solver: &dyn Solver,
    ) -> Result<Trimmed, SindyError> {
        let mut grams = accumulate.over(source)?;
        let mut fit = solver.fit(&Gram::total(&grams))?;
        let weights = weights(accumulate, source)?;
        let mut kept: Vec<Vec<bool>> = Vec::new();
        let mut squares = Vec::new();
        for _ in 0..self.max_iterations {
            let (library, target) = accumulate.names();
            let mut r = residuals(library, target, &fit.coefficients, source)?;
            for (r, w) in r.iter_mut().flatten().zip(weights.iter().flatten()) {
                *r *= if *w > 0.0 { w.sqrt() } else { f64::NAN };
            }
            let next = self.best(&r);
            if next == kept {
                return Ok(Trimmed {
                    fit,
                    grams,
                    kept,
                    squares,
                    outcome: Outcome::Converged,
                });
            }
            kept = next;
            let masked = Masked::new(source, &weights, &kept);
            let kept_only = Accumulate::clone(accumulate).weights(masked.column());
            grams = kept_only.over(&masked)?;
            fit = solver.fit(&Gram::total(&grams))?;
            squares.push(fit.residual_sum);
        }
        Ok(Trimmed {
            fit,
            grams,
            kept,
            squares,
            outcome: Outcome::IterationLimit,
        })
    }

    /// The rows of smallest residual, the earlier of two equal ones first.
    fn best(&self, residuals: &[Vec<f64>]) -> Vec<Vec<bool>> {
        let mut order: Vec<(f64, usize, usize)> = Vec::new();
        for (g, group) in residuals.iter().enumerate() {
            let usable = group.iter().enumerate().filter(|(_, r)| r.is_finite());
            order.extend(usable.map(|(i, r)| (r.abs(), g, i)));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let keep = (self.keep * order.len() as f64).ceil() as usize;
        let mut kept: Vec<Vec<bool>> = residuals.iter().map(|r| vec![false; r.len()]).collect();
        for &(_, g, i) in &order[..keep.min(order.len())] {
            kept[g][i] = true;
        }
        kept
    }
}

/// The weight of every row.
fn weights(
    accumulate: &Accumulate<'_>,
    source: &dyn BlockSource,
) -> Result<Vec<Vec<f64>>, SindyError> {
    let column = accumulate
        .weight_column()
        .map(|name| crate::data::samples::position(source.names(), name))
        .transpose()?;
    let mut out = vec![Vec::new(); source.groups()];
    source.for_each_block(&mut |block| match column {
        Some(column) => out[block.group].extend_from_slice(block.columns[column]),
        None => {
            let n = block.columns.first().map_or(0, |c| c.len());
            let group: &mut Vec<f64> = &mut out[block.group];
            group.resize(group.len() + n, 1.0);
        }
    });
    for &w in out.iter().flatten() {
        at_least_zero("weights", w)?;
    }
    source.failure().map_or(Ok(out), Err)
}

/// A source with one column more: the weight of rows that are kept, 0 in others.
struct Masked<'a> {
    source: &'a dyn BlockSource,
    weights: &'a [Vec<f64>],
    kept: &'a [Vec<bool>],
    names: Vec<String>,
}

impl<'a> Masked<'a> {
    fn new(source: &'a dyn BlockSource, weights: &'a [Vec<f64>], kept: &'a [Vec<bool>]) -> Self {
        let mut names = source.names().to_vec();
        let mut own = "kept".to_string();
        while names.contains(&own) {
            own.push('_');
        }
        names.push(own);
        Self {
            source,
            weights,
            kept,
            names,
        }
    }

    fn column(&self) -> &str {
        &self.names[self.names.len() - 1]
    }
}

impl BlockSource for Masked<'_> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn groups(&self) -> usize {
        self.source.groups()
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        let mut seen = vec![0; self.kept.len()];
        self.source.for_each_block(&mut |block| {
            let n = block.columns.first().map_or(0, |c| c.len());
            let rows = seen[block.group]..seen[block.group] + n;
            seen[block.group] += n;
            let own: Vec<f64> = self.weights[block.group][rows.clone()]
                .iter()
                .zip(&self.kept[block.group][rows])
                .map(|(w, &kept)| if kept { *w } else { 0.0 })
                .collect();
            let mut columns = block.columns.to_vec();
            columns.push(&own);
            visit(Block {
                group: block.group,
                columns: &columns,
            });
        });
    }

    fn failure(&self) -> Option<SindyError> {
        self.source.failure()
    }
}
