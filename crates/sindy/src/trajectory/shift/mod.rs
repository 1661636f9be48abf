//! Past states and discrete time: columns of earlier and later rows.
//!
//! [`past`] adds delayed columns, so that a library may use what was: `x_ago3` is x three samples ago. [`next`]
//! adds the columns one sample later, `x_next`, the targets of a model in discrete time. Both work within one
//! group, never across a gap of time, and count the rows that have no past or no successor.
//!
//! A second-order recursion, found from its samples and run from its own start:
//!
//! ```
//! use sindy::model::{Limits, Model, Term, Time};
//! use sindy::trajectory::shift::{Delay, chain, next, past};
//! use sindy::{Gram, Library, Samples, Solver, Stlsq};
//!
//! // x[k+1] = 1.5 x[k] - 0.7 x[k-1]
//! let mut x = vec![1.0, 0.5];
//! for k in 1..60 {
//!     x.push(1.5 * x[k] - 0.7 * x[k - 1]);
//! }
//! let mut samples = Samples::new(&["x"]);
//! samples.push_group(vec![x.clone()])?;
//!
//! let delays = Delay::parse("x@1")?;
//! let with_past = past(&samples, &delays, None)?;
//! let pairs = next(&with_past.samples, &["x"], None, None)?;
//! let library = Library::polynomial(&["x", "x_ago1"], 2)?;
//! let gram = Gram::total(&Gram::accumulate(&library, "x_next", &pairs.samples)?);
//! let fit = Stlsq::new(0.1, 0.0)?.fit(&gram)?;
//!
//! let equation = Term::of_library(&library, fit.coefficients.as_slice())?;
//! let (older, shifts) = chain(&delays)?;
//! let states = [vec!["x".to_string()], older].concat();
//! let model = Model::new(Time::Discrete { period: 1.0 }, &states, &[], [vec![equation], shifts].concat())?;
//! let run = model.iterate(&[x[1], x[0]], 50, &[], &Limits::default())?;
//! assert!((run.states[0][50] - x[51]).abs() < 1e-9);
//! # Ok::<(), sindy::SindyError>(())
//! ```

mod delay;
mod runs;
#[cfg(test)]
mod tests;

use delay::By;
pub use delay::Delay;
use runs::Runs;
pub(crate) use runs::{Cut, uneven};

use crate::data::samples::{BlockSource, Samples};
use crate::error::{SindyError, require};
use crate::model::Term;

/// Samples with columns of other rows beside their own.
#[derive(Clone, Debug)]
pub struct Shifted {
    /// The rows that are left, with the added columns last: one group for each stretch without a gap.
    pub samples: Samples,
    /// The names of the added columns.
    pub added: Vec<String>,
    /// For each group, the group that it is a part of.
    pub origin: Vec<usize>,
    /// Rows that were dropped because their shifted sample lies before the beginning, after the end or beyond
    /// a gap.
    pub dropped: usize,
    /// Gaps in time at which groups were cut.
    pub gaps: usize,
    /// The period, where there was a time column or it was given.
    pub period: Option<f64>,
}

/// Adds the delayed columns: `x_ago3` for `x@3`, the value three rows before.
///
/// With a `time` column, samples have to have one period (the median step, every step within a thousandth of
/// it; steps from 1.5 periods on are gaps, which cut a group). Without, the rows of a group are taken to
/// follow each other. The first rows of each stretch, as many as the longest delay, have no past and are left
/// out. A NaN stays where it is and is delayed like any value.
///
/// # Errors
/// No delays, one that occurs twice; a column that does not exist, or already has the new name; times that are
/// not finite, do not increase or have no one period (interpolation is never done); a delay in time that is
/// not a whole number of periods; no row with a past.
pub fn past(
    samples: &Samples,
    delays: &[Delay],
    time: Option<&str>,
) -> Result<Shifted, SindyError> {
    require(!delays.is_empty(), "delays", "at least one", "none")?;
    let runs = Runs::new(samples, time, None)?;
    let mut columns = Vec::new();
    for delay in delays {
        let by = delay.in_samples(runs.period)?;
        columns.push(Column {
            name: format!("{}_ago{by}", delay.column),
            from: samples.position(&delay.column)?,
            back: by,
        });
    }
    let longest = columns.iter().map(|c| c.back).max().unwrap_or(0);
    shift(samples, &columns, runs, longest, 0)
}

/// Adds the columns of the next row: `x_next` for each of `columns` (the states), the targets of a model in
/// discrete time `x[k+1] = f(x[k], u[k])`.
///
/// Rows are paired only within a group and, with a `time` column, only one `period` apart; rules and tolerance
/// as for [`past`]. The last row of each stretch has no successor and is left out. A pair with a NaN is left
/// for [`crate::Gram`] to skip and count.
///
/// # Errors
/// No columns, a column that does not exist, occurs twice or already has the new name; a period that is not
/// positive; times that are not finite, do not increase or have another period; no pair of rows.
pub fn next(
    samples: &Samples,
    columns: &[&str],
    time: Option<&str>,
    period: Option<f64>,
) -> Result<Shifted, SindyError> {
    require(!columns.is_empty(), "states", "at least one name", "none")?;
    let runs = Runs::new(samples, time, period)?;
    let column = |name: &&str| {
        Ok(Column {
            name: format!("{name}_next"),
            from: samples.position(name)?,
            back: 0,
        })
    };
    let columns: Vec<Column> = columns
        .iter()
        .map(column)
        .collect::<Result<_, SindyError>>()?;
    shift(samples, &columns, runs, 0, 1)
}

/// The states and equations that hold what was, to append to those of a model in discrete time:
/// `x_ago1[k+1] = x[k]`, `x_ago2[k+1] = x_ago1[k]`, … for each delayed column (state or input), down to its
/// longest delay.
///
/// # Errors
/// A delay in time: state it in samples of the model's period.
pub fn chain(delays: &[Delay]) -> Result<(Vec<String>, Vec<Vec<Term>>), SindyError> {
    let mut longest: Vec<(&str, usize)> = Vec::new();
    for delay in delays {
        let By::Samples(by) = delay.by else {
            let expected = "delays in samples";
            return Err(SindyError::setting(
                "delays",
                expected,
                format!("`{delay}`"),
            ));
        };
        match longest.iter_mut().find(|l| l.0 == delay.column) {
            Some(l) => l.1 = l.1.max(by),
            None => longest.push((&delay.column, by)),
        }
    }
    let (mut states, mut equations) = (Vec::new(), Vec::new());
    for (column, longest) in longest {
        let mut before = column.to_string();
        for by in 1..=longest {
            let variable = sindy_expr::Expr::variable(&before);
            equations.push(vec![Term::new(variable, 1.0)]);
            before = format!("{column}_ago{by}");
            states.push(before.clone());
        }
    }
    Ok((states, equations))
}

/// A column to add.
struct Column {
    name: String,
    from: usize,
    /// Rows back from the last row that a result needs.
    back: usize,
}

/// Keeps the rows that have `before` rows before and `after` rows after them in their run, and adds the
/// columns, taken `back` rows before the last of these.
fn shift(
    samples: &Samples,
    columns: &[Column],
    runs: Runs,
    before: usize,
    after: usize,
) -> Result<Shifted, SindyError> {
    let mut names: Vec<&str> = samples.names().iter().map(String::as_str).collect();
    for column in columns {
        if names.contains(&column.name.as_str()) {
            let expected = "a name that no column has yet";
            let found = format!("`{}`", column.name);
            return Err(SindyError::setting("added column", expected, found));
        }
        names.push(&column.name);
    }
    let mut shifted = Samples::new(&names);
    let (mut origin, mut dropped, mut longest) = (Vec::new(), runs.untimed, 0);
    for (group, rows) in runs.ranges {
        longest = longest.max(rows.len());
        if rows.len() <= before + after {
            dropped += rows.len();
            continue;
        }
        dropped += before + after;
        let kept = rows.start + before..rows.end - after;
        let own = samples
            .group(group)
            .iter()
            .map(|c| c[kept.clone()].to_vec());
        let moved = columns.iter().map(|c| {
            let start = kept.start + after - c.back;
            samples.group(group)[c.from][start..start + kept.len()].to_vec()
        });
        shifted.push_group(own.chain(moved).collect())?;
        origin.push(group);
    }
    if origin.is_empty() {
        return Err(SindyError::too_short(before + after + 1, longest));
    }
    Ok(Shifted {
        samples: shifted,
        added: columns.iter().map(|c| c.name.clone()).collect(),
        origin,
        dropped,
        gaps: runs.gaps,
        period: runs.period,
    })
}
