//! The settings of a pass over a source, and what is done to a chunk of rows.

use std::ops::Range;

use sindy_expr::{Program, Scratch};

use super::driver::Driver;
use super::{Gram, Weights, kernel};
use crate::error::SindyError;
use crate::library::Library;
use crate::samples::{BlockSource, position};
use crate::tsqr::Triangle;

/// Rows that are evaluated at a time: 256 rows of 60 terms fit the second-level cache.
pub(super) const CHUNK: usize = 256;

/// How statistics are accumulated: settings of a pass over a source.
///
/// ```
/// use sindy::gram::{Accumulate, Gram};
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
    /// A term, a target or weights that name no column; a weight that is negative or not finite; a pass that
    /// failed ([`BlockSource::failure`]).
    pub fn over(&self, source: &dyn BlockSource) -> Result<Vec<Gram>, SindyError> {
        let names = source.names();
        // Only the columns that are used are compiled for, and copied.
        let mut used: Vec<String> = self.library.variables();
        if used.iter().any(|name| !names.contains(name)) {
            self.library.compile(names)?;
        }
        let mut place = |name: &str| -> Result<usize, SindyError> {
            position(names, name)?;
            Ok(used.iter().position(|n| n == name).unwrap_or_else(|| {
                used.push(name.to_string());
                used.len() - 1
            }))
        };
        let target = place(self.target)?;
        let weight = self.weights.map(place).transpose()?;
        let pass = Pass {
            program: self.library.compile(&used)?,
            target,
            weight,
            p: self.library.len(),
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
        if let Some(failure) = source.failure() {
            return Err(failure);
        }
        result?;
        driver.finish()
    }
}

/// What is done to every row.
pub(super) struct Pass {
    program: Program,
    target: usize,
    weight: Option<usize>,
    pub(super) p: usize,
    triangle: bool,
}

impl Pass {
    pub(super) fn zeros(&self) -> Gram {
        Gram {
            weights: self.weight.map(|_| Weights::default()),
            triangle: self.triangle.then(|| Triangle::new(self.p)),
            ..Gram::zeros(self.p)
        }
    }

    /// Adds the given rows, chunk by chunk, to the upper triangle of `gram`.
    pub(super) fn add_rows(
        &self,
        gram: &mut Gram,
        columns: &[&[f64]],
        range: Range<usize>,
        work: &mut Workspace,
    ) -> Result<(), SindyError> {
        for start in range.clone().step_by(CHUNK) {
            let rows = CHUNK.min(range.end - start);
            let part: Vec<&[f64]> = columns.iter().map(|c| &c[start..start + rows]).collect();
            let all = &mut work.columns[..rows * (self.p + 1)];
            let (theta, y) = all.split_at_mut(rows * self.p);
            self.program.eval_block(&part, theta, &mut work.scratch);
            y.copy_from_slice(part[self.target]);
            let weights = self.weight.map(|w| part[w]);
            gram.add_chunk(all, rows, weights, &mut work.products)?;
        }
        Ok(())
    }
}

impl Gram {
    /// Adds a chunk given as columns, the target the last of them. Rows with a non-finite entry are
    /// zeroed and counted; rows of weight zero are zeroed.
    fn add_chunk(
        &mut self,
        columns: &mut [f64],
        rows: usize,
        weights: Option<&[f64]>,
        products: &mut [f64],
    ) -> Result<(), SindyError> {
        let p = self.xty.len();
        let (mut used, mut skipped) = (rows, 0);
        let clear = |columns: &mut [f64], r: usize| {
            (0..=p).for_each(|j| columns[j * rows + r] = 0.0);
        };
        // The weights of the rows that are used.
        let mut weight = [0.0; CHUNK];
        if let Some(weights) = weights {
            for (r, &w) in weights.iter().enumerate() {
                if !(w >= 0.0 && w.is_finite()) {
                    let expected = "finite, at least 0";
                    return Err(SindyError::setting("weights", expected, w));
                }
                weight[r] = w;
                if w == 0.0 {
                    clear(columns, r);
                    used -= 1;
                }
            }
        }
        if !kernel::sum(columns).is_finite() {
            for r in 0..rows {
                if (0..=p).any(|j| !columns[j * rows + r].is_finite()) {
                    clear(columns, r);
                    weight[r] = 0.0;
                    used -= 1;
                    skipped += 1;
                }
            }
        }
        if let Some(sums) = &mut self.weights {
            for (r, w) in weight[..rows].iter().enumerate() {
                sums.sum += w;
                sums.squares += w * w;
                self.sum_y += w * columns[p * rows + r];
            }
            weight.iter_mut().for_each(|w| *w = w.sqrt());
            for column in columns.chunks_exact_mut(rows) {
                for (v, root) in column.iter_mut().zip(&weight) {
                    *v *= root;
                }
            }
        } else {
            self.sum_y += kernel::sum(&columns[rows * p..]);
        }
        kernel::upper_products(columns, rows, products);
        for (j, column) in products.chunks_exact(p + 1).enumerate().take(p) {
            let mut to = self.xtx.column_mut(j);
            for (to, product) in to.iter_mut().zip(&column[..=j]) {
                *to += product;
            }
        }
        let last = &products[p * (p + 1)..];
        for (to, product) in self.xty.iter_mut().zip(last) {
            *to += product;
        }
        self.yty += last[p];
        self.rows += used;
        self.skipped += skipped;
        if let Some(triangle) = &mut self.triangle {
            triangle.fold(columns, rows);
        }
        Ok(())
    }
}

/// What one thread needs to add rows.
pub(super) struct Workspace {
    scratch: Scratch,
    /// The terms and the target of one chunk, column after column.
    columns: Vec<f64>,
    /// Their products, (p+1) x (p+1); the upper triangle is used.
    products: Vec<f64>,
}

impl Workspace {
    pub(super) fn new(p: usize) -> Self {
        Self {
            scratch: Scratch::default(),
            columns: vec![0.0; CHUNK * (p + 1)],
            products: vec![0.0; (p + 1) * (p + 1)],
        }
    }
}
