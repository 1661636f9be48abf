//! The settings of a pass over a source.

use super::Gram;
use super::driver::Driver;
use super::plan::Plan;
use crate::data::samples::{BlockSource, passed, position};
use crate::error::SindyError;
use crate::library::Library;

/// Sums of squares below this have lost digits: they are near the smallest numbers that there are.
const SMALLEST: f64 = 1e-290;

/// How statistics are accumulated: settings of a pass over a source.
///
/// ```
/// use sindy::statistics::gram::{Accumulate, Gram};
/// use sindy::{Library, Samples};
///
/// let mut samples = Samples::new(&["x", "y", "trust"]);
/// samples.push_group(vec![vec![1.0, 2.0, 3.0], vec![2.0, 4.0, 60.0], vec![1.0, 1.0, 0.0]])?;
/// let library = Library::parse(&["x"])?;
/// let gram = Gram::total(&Accumulate::new(&library, "y").weights("trust").over(&samples)?);
/// assert_eq!((gram.rows, gram.xty[0] / gram.xtx[(0, 0)]), (2, 2.0));
/// # Ok::<(), sindy::SindyError>(())
/// ```
///
/// The first 16 384 rows of a pass run on the calling thread. From then on the rows of each group are cut into
/// segments of 8192, which are shared out among the threads of the current `rayon` pool: blocks of less than
/// four segments are copied together first (at most 131 072 rows of the columns in use), larger ones are read
/// where they are. The segments of a group begin at its first row, wherever blocks begin, so that the bits
/// of the result depend neither on the size of the blocks nor on the number of threads. (A group whose rows
/// come in several parts, with those of other groups between, begins a new segment with each part.)
#[derive(Clone, Copy, Debug)]
pub struct Accumulate<'a> {
    library: &'a Library,
    target: &'a str,
    weights: Option<&'a str>,
    triangle: bool,
}

impl<'a> Accumulate<'a> {
    /// Of `target` over `library`, every row with weight one, without the triangular factor.
    #[must_use]
    pub fn new(library: &'a Library, target: &'a str) -> Self {
        Self {
            library,
            target,
            weights: None,
            triangle: false,
        }
    }

    /// The same with the weight of each row in the column of this name: at least 0 and finite; relative to each
    /// other (a weight is the inverse of the row's noise variance, in any unit). A row of weight 0 does
    /// not count, whatever its values.
    #[must_use]
    pub fn weights(self, column: &'a str) -> Self {
        Self {
            weights: Some(column),
            ..self
        }
    }

    /// The same with the triangular factor of `[Θ | y]` beside the Gram matrix (`true`) or without it.
    #[must_use]
    pub fn triangle(self, triangle: bool) -> Self {
        Self { triangle, ..self }
    }

    /// The library and the name of the target.
    pub(crate) fn names(&self) -> (&'a Library, &'a str) {
        (self.library, self.target)
    }

    /// The name of the column of weights.
    pub(crate) fn weight_column(&self) -> Option<&'a str> {
        self.weights
    }

    /// The statistics, one for each group of `source`. Rows in which the target or a term is not finite
    /// are left out and counted.
    ///
    /// # Errors
    /// A term, a target or weights that name no column; a weight that is negative or not finite; values whose squares
    /// are beyond the range of numbers (above some 1e150, or all below some 1e-145); a pass that failed
    /// ([`BlockSource::failure`]).
    pub fn over(&self, source: &dyn BlockSource) -> Result<Vec<Gram>, SindyError> {
        let mut of_targets = self.targets(&[self.target], source)?;
        Ok(of_targets.swap_remove(0))
    }

    /// As [`Accumulate::over`], of several targets in one pass: for each of them (that of the settings is not
    /// asked for) one for each group. Rows in which any target or a term is not finite are left out of
    /// all.
    ///
    /// # Errors
    /// As [`Accumulate::over`].
    pub fn targets(
        &self,
        targets: &[&str],
        source: &dyn BlockSource,
    ) -> Result<Vec<Vec<Gram>>, SindyError> {
        let names = source.names();
        // Only the columns that are used are compiled for, and copied.
        let mut used: Vec<String> = self.library.variables();
        if used.iter().any(|name| !names.contains(name)) {
            self.library.compile(names)?;
        }
        for name in targets.iter().copied().chain(self.weights) {
            position(names, name)?;
            if !used.iter().any(|n| n == name) {
                used.push(name.to_string());
            }
        }
        let pass = Pass {
            plan: Plan::new(self.library, targets, &used)?,
            weight: (self.weights)
                .map(|name| position(&used, name))
                .transpose()?,
            triangle: self.triangle,
        };
        let columns = used
            .iter()
            .map(|name| position(names, name))
            .collect::<Result<Vec<_>, _>>()?;
        let mut driver = Driver::new(&pass, source.groups());
        let mut result = Ok(());
        source.for_each_block(&mut |block| {
            if result.is_ok() {
                let part: Vec<&[f64]> = columns.iter().map(|&c| block.columns[c]).collect();
                result = driver.push(block.group, &part);
            }
        });
        passed(source)?;
        result?;
        let groups = driver.finish()?;
        let mut out = vec![Vec::with_capacity(groups.len()); targets.len()];
        for sums in &groups {
            for (list, gram) in out.iter_mut().zip(sums.grams(&pass.plan)) {
                list.push(gram);
            }
        }
        for (list, name) in out.iter().zip(targets) {
            self.check_range(list, name)?;
        }
        Ok(out)
    }

    /// Refuses sums of squares that are not numbers any more, or not with all their digits.
    fn check_range(&self, groups: &[Gram], target: &str) -> Result<(), SindyError> {
        let sum = |of: &dyn Fn(&Gram) -> f64| groups.iter().map(of).sum::<f64>();
        let held = |what: &dyn Fn() -> String, found: f64| {
            if found == 0.0 || (found >= SMALLEST && found.is_finite()) {
                return Ok(());
            }
            Err(SindyError::Range {
                what: what(),
                found,
            })
        };
        for j in 0..self.library.len() {
            let name = || format!("term `{}`", self.library.names()[j]);
            held(&name, sum(&|g| g.xtx[(j, j)]))?;
        }
        held(&|| format!("column `{target}`"), sum(&|g| g.yty))
    }
}

/// The work on every row.
pub(crate) struct Pass {
    pub(super) plan: Plan,
    pub(super) weight: Option<usize>,
    pub(super) triangle: bool,
}
