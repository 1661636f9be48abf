//! From samples to the statistics of the weak system.

use nalgebra::DMatrix;
use rayon::prelude::*;
use sindy_expr::{Program, Scratch};

use super::WeakForm;
use super::whiten::whiten;
use super::width::{FEWEST, choose_half_width};
use super::window::{REACH, Window, place};
use crate::data::gaps::{GapSettings, Segments, segments};
use crate::data::samples::{BlockSource, Samples};
use crate::error::{SindyError, require};
use crate::library::Library;
use crate::statistics::gram::Gram;

/// Rows in which the terms are evaluated at a time.
const CHUNK: usize = 256;
/// Windows that one thread integrates at a time. Rows at both ends are evaluated twice.
const TOGETHER: usize = 512;

/// The weak system: statistics by state and group, and what was set aside.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakSystem {
    /// `grams[s][g]` of state `s` (in the order that was asked for) and group `g`. `rows` are windows,
    /// `skipped` windows in which a term was not finite. A group without windows has no rows.
    pub grams: Vec<Vec<Gram>>,
    /// The half-width `H` that was used, in the unit of time.
    pub half_width: f64,
    /// Windows in all groups, without those that were skipped.
    pub windows: usize,
    /// Rows with a NaN in a column that is used.
    pub missing_rows: usize,
    /// Steps of time that were too long to integrate over.
    pub holes: usize,
    /// Stretches without gaps that were too short for a window.
    pub short: usize,
}

impl WeakSystem {
    /// The statistics of state `s` over all groups (`s` counts from 0, in the order that was asked for).
    ///
    /// # Panics
    /// If there is no such state.
    #[must_use]
    pub fn total(&self, s: usize) -> Gram {
        Gram::total(&self.grams[s])
    }
}

pub(super) fn build(
    settings: &WeakForm,
    library: &Library,
    time: &str,
    states: &[&str],
    samples: &Samples,
) -> Result<WeakSystem, SindyError> {
    require(!states.is_empty(), "states", "at least one", "none")?;
    let program = library.compile(samples.names())?;
    let time = samples.position(time)?;
    let states = states
        .iter()
        .map(|s| samples.position(s))
        .collect::<Result<Vec<_>, _>>()?;
    let mut used = states.clone();
    for name in library.variables() {
        used.push(samples.position(&name)?);
    }
    used.sort_unstable();
    used.dedup();
    let parts = (0..samples.groups())
        .map(|g| split(samples, g, time, &used))
        .collect::<Result<Vec<_>, _>>()?;
    let half_width = match settings.half_width {
        Some(h) => h,
        None => chosen_width(settings, samples, time, &states, &parts)?,
    };
    let mut out = WeakSystem {
        grams: vec![Vec::with_capacity(parts.len()); states.len()],
        half_width,
        windows: 0,
        missing_rows: parts.iter().map(|p| p.missing_rows).sum(),
        holes: parts.iter().map(|p| p.holes).sum(),
        short: 0,
    };
    let mut skipped = 0;
    for (g, part) in parts.iter().enumerate() {
        let columns: Vec<&[f64]> = samples.group(g).iter().map(Vec::as_slice).collect();
        let mut total = vec![Gram::zeros(library.len()); states.len()];
        for range in &part.ranges {
            let stretch: Vec<&[f64]> = columns.iter().map(|c| &c[range.clone()]).collect();
            let windows = place(
                stretch[time],
                half_width,
                settings.spacing * half_width,
                settings.power as i32,
            );
            out.short += usize::from(windows.is_empty());
            let sums = integrate(&windows, &program, &stretch, &states);
            add(settings.generalised, &windows, &sums, &mut total);
        }
        out.windows += total[0].rows;
        skipped += total[0].skipped;
        for (all, gram) in out.grams.iter_mut().zip(total) {
            all.push(gram);
        }
    }
    if out.windows + skipped == 0 {
        return Err(too_short(samples, time, half_width));
    }
    Ok(out)
}

fn split(samples: &Samples, g: usize, time: usize, used: &[usize]) -> Result<Segments, SindyError> {
    let columns = samples.group(g);
    let in_use: Vec<&[f64]> = used.iter().map(|&c| columns[c].as_slice()).collect();
    segments(&columns[time], &in_use, GapSettings::default()).map_err(|e| match e {
        SindyError::NotFinite { index, .. } => {
            // Name the column as the user knows it.
            let bad = std::iter::once(&time)
                .chain(used)
                .find(|&&c| columns[c][index].is_infinite());
            SindyError::NotFinite {
                what: bad.map_or_else(String::new, |&c| samples.names()[c].clone()),
                index,
            }
        }
        other => other,
    })
}

fn chosen_width(
    settings: &WeakForm,
    samples: &Samples,
    time: usize,
    states: &[usize],
    parts: &[Segments],
) -> Result<f64, SindyError> {
    let mut series: Vec<(&[f64], &[f64])> = Vec::new();
    for (g, part) in parts.iter().enumerate() {
        let columns = samples.group(g);
        for range in part.ranges.iter().filter(|r| r.len() >= FEWEST) {
            for &s in states {
                series.push((&columns[time][range.clone()], &columns[s][range.clone()]));
            }
        }
    }
    if series.is_empty() {
        let longest = parts
            .iter()
            .flat_map(|p| &p.ranges)
            .map(ExactSizeIterator::len)
            .max();
        return Err(SindyError::too_short(FEWEST, longest.unwrap_or(0)));
    }
    choose_half_width(&series, settings.power)
}

/// No window anywhere: how many samples one would need at the mean step of the longest group.
fn too_short(samples: &Samples, time: usize, half_width: f64) -> SindyError {
    let longest = (0..samples.groups())
        .map(|g| &samples.group(g)[time])
        .max_by_key(|t| t.len());
    let found = longest.map_or(0, Vec::len);
    let steps = match longest.map(Vec::as_slice) {
        Some([first, .., last]) => 2.0 * half_width * (found - 1) as f64 / (last - first),
        _ => 0.0,
    };
    SindyError::TooShort {
        // A cast of NaN (no time at an end) is 0, and the least number of samples remains.
        needed: (steps.ceil() as usize).saturating_add(1).max(2 * REACH + 1),
        found,
    }
}

/// The sums of each window: `∫ φ θ_j` for the terms, then `-∫ φ' x` for the states, and last `∫ φ`.
fn integrate(
    windows: &[Window],
    program: &Program,
    columns: &[&[f64]],
    states: &[usize],
) -> DMatrix<f64> {
    let width = program.outputs() + states.len() + 1;
    // One column for each window, so that its sums lie side by side.
    let mut sums = DMatrix::zeros(width, windows.len());
    let parts = sums.as_mut_slice().par_chunks_mut(width * TOGETHER);
    parts
        .zip(windows.par_chunks(TOGETHER))
        .for_each(|(sums, windows)| {
            integrate_some(windows, program, columns, states, sums);
        });
    sums
}

/// The same of consecutive windows, into `sums`, one after the other.
fn integrate_some(
    windows: &[Window],
    program: &Program,
    columns: &[&[f64]],
    states: &[usize],
    sums: &mut [f64],
) {
    let p = program.outputs();
    let width = p + states.len() + 1;
    let mut theta = vec![0.0; CHUNK * p];
    let mut scratch = Scratch::default();
    let (Some(first), Some(last)) = (windows.first(), windows.last()) else {
        return;
    };
    let rows = last.rows.end;
    let mut from = 0;
    for start in (first.rows.start / CHUNK * CHUNK..rows).step_by(CHUNK) {
        let end = rows.min(start + CHUNK);
        while from < windows.len() && windows[from].rows.end <= start {
            from += 1;
        }
        let here = windows[from..]
            .iter()
            .take_while(|w| w.rows.start < end)
            .count();
        if here == 0 {
            continue;
        }
        let part: Vec<&[f64]> = columns.iter().map(|c| &c[start..end]).collect();
        let n = end - start;
        let theta = &mut theta[..n * p];
        program.eval_block(&part, theta, &mut scratch);
        for k in from..from + here {
            let w = &windows[k];
            let (a, b) = (w.rows.start.max(start), w.rows.end.min(end));
            let value = &w.value[a - w.rows.start..b - w.rows.start];
            let slope = &w.slope[a - w.rows.start..b - w.rows.start];
            let sum = &mut sums[k * width..][..width];
            for j in 0..p {
                sum[j] += dot(value, &theta[j * n + a - start..j * n + b - start]);
            }
            for (j, &s) in states.iter().enumerate() {
                sum[p + j] -= dot(slope, &columns[s][a..b]);
            }
            sum[width - 1] += value.iter().sum::<f64>();
        }
    }
}

/// Adds the windows' rows, weighted, to the statistics of the states.
fn add(generalised: bool, windows: &[Window], sums: &DMatrix<f64>, total: &mut [Gram]) {
    let width = sums.nrows();
    let (p, used) = (width - 1 - total.len(), width - 1);
    let good: Vec<usize> = (0..windows.len())
        .filter(|&k| sums.column(k).iter().all(|v| v.is_finite()))
        .collect();
    let mut matrix = DMatrix::from_fn(good.len(), used, |r, c| sums[(c, good[r])]);
    if generalised {
        let kept: Vec<&Window> = good.iter().map(|&k| &windows[k]).collect();
        whiten(&kept, &mut matrix);
    } else {
        for (r, &k) in good.iter().enumerate() {
            matrix.row_mut(r).scale_mut(1.0 / sums[(width - 1, k)]);
        }
    }
    let theta = matrix.columns(0, p);
    let xtx = theta.tr_mul(&theta);
    for (s, gram) in total.iter_mut().enumerate() {
        let y = matrix.column(p + s);
        gram.xtx += &xtx;
        gram.xty += theta.tr_mul(&y);
        gram.yty += y.norm_squared();
        gram.sum_y += y.sum();
        gram.rows += good.len();
        gram.skipped += windows.len() - good.len();
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
