//! Finite differences of samples on their way to the statistics.

use std::ops::Range;

use rayon::prelude::*;

use super::FiniteDifference;
use crate::data::grid;
use crate::data::samples::{Block, BlockSource, Samples, position};
use crate::error::{SindyError, require};

/// Rows of a block: some segments for each of several threads, and few enough for a cache.
const ROWS: usize = 16 * SEGMENT;

/// Rows that one thread differentiates at a time.
const SEGMENT: usize = 8192;

/// Samples with the time derivatives of some of their columns as further columns: the derivative of `x` is
/// called `x_dot`. Derivatives are computed block by block as they are asked for and are never
/// held for all rows. They are those of [`FiniteDifference::apply`], group by group.
///
/// A value that is not finite makes the derivatives next to it so; [`Gram`](crate::Gram) leaves such rows out
/// and counts them.
///
/// ```
/// use sindy::derivative::{FiniteDifference, Rates};
/// use sindy::{Gram, Library, Samples};
///
/// let mut samples = Samples::new(&["x"]);
/// samples.push_group(vec![(0..200).map(|i| (-0.02 * f64::from(i)).exp()).collect()])?;
/// let rates = Rates::uniform(&samples, &["x"], FiniteDifference::new(2)?, 0.01)?;
/// let library = Library::parse(&["1", "x"])?;
/// let gram = &Gram::accumulate(&library, "x_dot", &rates)?[0];
/// let xi = sindy::statistics::regression::least_squares(gram, &[true; 2]);
/// assert!((xi[1] + 2.0).abs() < 1e-3); // dx/dt = -2 x
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rates<'a> {
    samples: &'a Samples,
    method: FiniteDifference,
    /// Columns that are differentiated.
    states: Vec<usize>,
    names: Vec<String>,
    clock: Clock,
}

#[derive(Clone, Debug)]
enum Clock {
    /// One period for all groups.
    Period(f64),
    /// A column of times; the period of each group that is uniform.
    Column(usize, Vec<Option<f64>>),
}

impl<'a> Rates<'a> {
    /// Derivatives of `states` of samples that are `period` apart.
    ///
    /// # Errors
    /// A period that is not positive and finite, an unknown column, a name `…_dot` that is taken, a group of
    /// fewer rows than the differences need.
    pub fn uniform(
        samples: &'a Samples,
        states: &[&str],
        method: FiniteDifference,
        period: f64,
    ) -> Result<Self, SindyError> {
        require(
            period > 0.0 && period.is_finite(),
            "period",
            "a positive, finite time",
            period,
        )?;
        Self::new(samples, states, method, Clock::Period(period))
    }

    /// Derivatives of `states` with respect to the column `time`, whose steps may differ.
    ///
    /// # Errors
    /// An unknown column, times that are not finite or do not increase within a group, a name
    /// `…_dot` that is taken, a group of fewer rows than the differences need.
    pub fn timed(
        samples: &'a Samples,
        states: &[&str],
        method: FiniteDifference,
        time: &str,
    ) -> Result<Self, SindyError> {
        let column = samples.position(time)?;
        let periods = (0..samples.groups())
            .map(|g| {
                let time = samples.group(g)[column].as_slice();
                grid::check(time, time, method.points())?;
                Ok(grid::uniform_period(time))
            })
            .collect::<Result<_, SindyError>>()?;
        Self::new(samples, states, method, Clock::Column(column, periods))
    }

    fn new(
        samples: &'a Samples,
        states: &[&str],
        method: FiniteDifference,
        clock: Clock,
    ) -> Result<Self, SindyError> {
        let mut names = samples.names().to_vec();
        let states = states
            .iter()
            .map(|state| {
                let name = format!("{state}_dot");
                require(
                    !names.contains(&name),
                    "states",
                    "columns whose derivatives have names of their own",
                    &name,
                )?;
                names.push(name);
                position(samples.names(), state)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let shortest = (0..samples.groups())
            .map(|g| samples.group(g).first().map_or(0, Vec::len))
            .min();
        if let Some(found) = shortest.filter(|n| *n < method.points()) {
            return Err(SindyError::too_short(method.points(), found));
        }
        Ok(Self {
            samples,
            method,
            states,
            names,
            clock,
        })
    }

    fn differentiate(&self, group: usize, state: usize, rows: Range<usize>, out: &mut [f64]) {
        let columns = self.samples.group(group);
        let y = &columns[state];
        match &self.clock {
            Clock::Period(dt) => self.method.uniform(*dt, y, rows, out),
            Clock::Column(time, periods) => match periods[group] {
                Some(dt) => self.method.uniform(dt, y, rows, out),
                None => self.method.non_uniform(&columns[*time], y, rows, out),
            },
        }
    }
}

impl BlockSource for Rates<'_> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn groups(&self) -> usize {
        self.samples.groups()
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        let mut slopes = vec![Vec::new(); self.states.len()];
        for group in 0..self.samples.groups() {
            let columns = self.samples.group(group);
            let n = columns.first().map_or(0, Vec::len);
            for start in (0..n).step_by(ROWS) {
                let rows = start..n.min(start + ROWS);
                for (out, &state) in slopes.iter_mut().zip(&self.states) {
                    out.resize(rows.len(), 0.0);
                    let part = |(k, out): (usize, &mut [f64])| {
                        let from = start + k * SEGMENT;
                        self.differentiate(group, state, from..from + out.len(), out);
                    };
                    if rows.len() <= SEGMENT {
                        part((0, out)); // The pool of threads is asked for only by those who have work for it.
                    } else {
                        out.par_chunks_mut(SEGMENT).enumerate().for_each(part);
                    }
                }
                let columns: Vec<&[f64]> = columns
                    .iter()
                    .map(|c| &c[rows.clone()])
                    .chain(slopes.iter().map(Vec::as_slice))
                    .collect();
                visit(Block {
                    group,
                    columns: &columns,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two groups, the first longer than a block.
    fn samples(uneven: f64) -> Samples {
        let mut samples = Samples::new(&["t", "x", "y"]);
        for n in [ROWS as u32 + 77, 40] {
            let time: Vec<f64> = (0..n)
                .map(|i| 0.01 * f64::from(i) + uneven * f64::from(i).sin())
                .collect();
            let x = time.iter().map(|t| t.sin()).collect();
            let y = time.iter().map(|t| (0.3 * t).cos()).collect();
            samples.push_group(vec![time, x, y]).unwrap();
        }
        samples
    }

    fn collected(source: &Rates<'_>) -> Vec<Vec<Vec<f64>>> {
        let mut groups = vec![vec![Vec::new(); source.names().len()]; source.groups()];
        source.for_each_block(&mut |block| {
            for (to, from) in groups[block.group].iter_mut().zip(block.columns) {
                to.extend_from_slice(from);
            }
        });
        groups
    }

    #[test]
    fn prop_blocks_hold_the_derivatives_of_whole_groups() {
        for (order, uneven) in [(2, 0.0), (4, 0.0), (6, 0.0), (2, 0.002), (6, 0.002)] {
            let samples = samples(uneven);
            let method = FiniteDifference::new(order).unwrap();
            let rates = Rates::timed(&samples, &["y", "x"], method, "t").unwrap();
            assert_eq!(rates.names(), ["t", "x", "y", "y_dot", "x_dot"]);
            for (g, columns) in collected(&rates).iter().enumerate() {
                let own = samples.group(g);
                assert_eq!(columns[..3], *own);
                for (slope, state) in [(3, 2), (4, 1)] {
                    let whole = method.apply(&own[0], &own[state]).unwrap();
                    assert_eq!(columns[slope], whole.derivative);
                }
            }
        }
    }

    #[test]
    fn prop_a_period_is_as_good_as_a_uniform_column() {
        let samples = samples(0.0);
        let method = FiniteDifference::new(2).unwrap();
        let timed = Rates::timed(&samples, &["x"], method, "t").unwrap();
        let uniform = Rates::uniform(&samples, &["x"], method, 0.01).unwrap();
        for (a, b) in collected(&timed).iter().zip(&collected(&uniform)) {
            for (a, b) in a[3].iter().zip(&b[3]) {
                // Periods that differ in rounding.
                assert!((a - b).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn prop_bad_input_is_refused_and_gaps_pass_through() {
        let samples = samples(0.0);
        let two = FiniteDifference::new(2).unwrap();
        assert!(matches!(
            Rates::uniform(&samples, &["w"], two, 0.01),
            Err(SindyError::UnknownColumn { .. })
        ));
        for period in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Rates::uniform(&samples, &["x"], two, period).is_err());
        }
        assert!(Rates::uniform(&samples, &["x", "x"], two, 0.01).is_err());
        assert!(Rates::timed(&samples, &["x"], two, "x").is_err());
        let mut short = Samples::new(&["x"]);
        short
            .push_group(vec![vec![1.0, f64::NAN, 2.0, 2.0, 2.0]])
            .unwrap();
        let six = FiniteDifference::new(6).unwrap();
        assert!(matches!(
            Rates::uniform(&short, &["x"], six, 0.01),
            Err(SindyError::TooShort {
                needed: 7,
                found: 5
            })
        ));
        let rates = Rates::uniform(&short, &["x"], two, 0.01).unwrap();
        let library = crate::Library::parse(&["1"]).unwrap();
        let gram = &crate::Gram::accumulate(&library, "x_dot", &rates).unwrap()[0];
        // The slope beside the gap at either side, and at it.
        assert_eq!((gram.rows, gram.skipped), (2, 3));
    }
}
