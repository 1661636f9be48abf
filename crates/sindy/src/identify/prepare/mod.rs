//! From a data set to what identification works on: noise, smoothed states, slopes, pieces.

mod series;
mod steep;

use super::regress::{Regression, Statistics};
use crate::data::dataset::{Dataset, Stretch};
use crate::data::samples::Samples;
use crate::derivative::savgol::{SavitzkyGolay, Smoothed};
use crate::derivative::{
    Differentiator, FiniteDifference, SavgolSearch, SmoothingSpline, choose_savgol, noise_level,
};
use crate::error::SindyError;
use crate::model::Interpolation;
use crate::numerics::upper_median;
use crate::trajectory::output_error::Piece;
pub(super) use series::is_uniform;
use series::{Series, rows_apart, smoothed};
pub(super) use steep::{by_row, is_steep, weights};

/// Rows below which a stretch is differenced, not smoothed: the choice of a window needs some windows' worth of rows.
const SMOOTHED: usize = 25;
/// Parts of a stretch that are looked at for motion, at most: the resolution of the moving part is a thirtieth.
const PARTS: usize = 32;
/// A state moves if its scatter exceeds this multiple of its noise. Over 25 rows the scatter of noise is within 1.5.
const MOVES: f64 = 2.0;
/// The least noise that is believed, as a share of a state's scatter: the rounding of six printed digits.
const FLOOR: f64 = 1e-6;

/// Residual of a model on data without noise that counts as following them, as a share of a state's scatter: less than
/// any sensor resolves. Half of it sends more of such data to the regression.
const TOLERATED: f64 = 5e-4;

/// Noise and scatter of each state.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    /// Standard deviation of the noise; the floor where none is visible.
    pub sigma: Vec<f64>,
    /// The least that is believed.
    pub floor: Vec<f64>,
    /// The largest residual of a model that follows the data: the noise, or a small share of the scatter.
    pub tolerated: Vec<f64>,
}

impl Noise {
    /// Noise of a map, which differences of samples do not show: the residual of the best regression.
    pub(super) fn of_map(&mut self, statistics: &Statistics, regressions: &[Regression]) {
        for (i, parts) in statistics.grams.iter().enumerate() {
            let rows = parts.iter().map(|g| g.rows).sum::<usize>().max(1) as f64;
            let left = regressions
                .iter()
                .map(|r| (r.fits[i].residual_sum / rows).sqrt());
            self.sigma[i] = left.fold(f64::INFINITY, f64::min).max(self.floor[i]);
            self.tolerated[i] = self.sigma[i];
        }
    }

    /// Of velocities that are not measured, which come last: as large beside their scatter as that of their positions. Nothing
    /// is compared with it; it is the scale of their defects.
    pub(super) fn of_velocities(&mut self, positions: &[usize]) {
        let first = self.sigma.len() - positions.len();
        for (k, &position) in positions.iter().enumerate() {
            let share = self.sigma[position] / self.floor[position];
            self.sigma[first + k] = share * self.floor[first + k];
            self.tolerated[first + k] = f64::INFINITY;
        }
    }

    /// The scatter of a state.
    pub(super) fn spread(&self, state: usize) -> f64 {
        self.floor[state] / FLOOR
    }

    /// Whether the noise of a state exceeds the residual that a good model has on data without noise.
    pub(super) fn is_visible(&self) -> bool {
        let least = self.tolerated.iter().zip(&self.floor);
        let mut all = self.sigma.iter().zip(least);
        all.any(|(sigma, (tolerated, floor))| sigma >= tolerated && sigma > floor)
    }
}

/// States smoothed and their slopes, by stretch and state, and how that was done.
pub(super) struct Slopes {
    /// For tables.
    pub name: String,
    pub smoothed: Vec<Vec<Smoothed>>,
    /// Rows at each end of a stretch whose slopes err more.
    pub edge: usize,
    /// Rows whose slopes are alike.
    pub window: f64,
    /// Weights of the rows by stretch, state and row; none where all slopes of a state are equally good.
    pub weights: Vec<Vec<Vec<f64>>>,
}

/// Scatter of each state over all stretches, and the noise on it.
pub(super) fn noise(stretches: &[Stretch<'_>], states: usize) -> Noise {
    let mut out = Noise {
        sigma: Vec::new(),
        floor: Vec::new(),
        tolerated: Vec::new(),
    };
    for i in 0..states {
        let series: Vec<Series<'_>> = stretches.iter().map(|s| Series::measured(s, i)).collect();
        let all = || series.iter().flat_map(|s| s.values.iter());
        let n = all().count() as f64;
        let mean = all().sum::<f64>() / n;
        let scatter = (all().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let scale = if scatter > 0.0 {
            scatter
        } else {
            mean.abs().max(1.0)
        };
        let floor = FLOOR * scale;
        // The median over stretches, each of which counts once, however long.
        let mut levels: Vec<f64> = series
            .iter()
            .filter_map(|s| noise_level(&s.time, &s.values).ok())
            .map(|l| l.sigma)
            .collect();
        let level = upper_median(&mut levels).unwrap_or(0.0);
        out.floor.push(floor);
        out.sigma.push(level.max(floor));
        out.tolerated.push(level.max(TOLERATED * scale));
    }
    out
}

/// The moving part of each stretch, from the first motion until all states rest; `None` if nearly everything moves.
///
/// The resting part of a record contains nothing but noise. A filter that is chosen for the whole record then flattens
/// the short part that moves.
pub(super) fn moving<'a>(
    stretches: &[Stretch<'a>],
    states: usize,
    noise: &Noise,
) -> Option<Vec<Stretch<'a>>> {
    let mut out = Vec::new();
    let (mut rows, mut kept) = (0, 0);
    for s in stretches {
        let n = s.time.len();
        let parts = (n / SMOOTHED).clamp(1, PARTS);
        let edge = |k: usize| k * n / parts;
        let moves: Vec<bool> = (0..parts)
            .map(|k| {
                (0..states)
                    .any(|i| scatter(&s.columns[i][edge(k)..edge(k + 1)]) > MOVES * noise.sigma[i])
            })
            .collect();
        rows += n;
        // From the first part that moves to the last: a turning point is no rest.
        let first = moves.iter().position(|m| *m);
        if let (Some(first), Some(last)) = (first, moves.iter().rposition(|m| *m)) {
            let range = edge(first)..edge(last + 1);
            kept += range.len();
            out.push(s.part(range.clone()));
        }
    }
    (kept > 0 && 2 * kept < rows).then_some(out)
}

fn scatter(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// A filter for each state with a strength from the data; none where times are not uniform or all stretches
/// are short. `wider` multiplies the window.
pub(super) fn filters(
    stretches: &[Stretch<'_>],
    states: usize,
    uniform: bool,
    wider: f64,
) -> Result<Option<Vec<SavitzkyGolay>>, SindyError> {
    if !uniform {
        return Ok(None);
    }
    let mut filters = Vec::new();
    for i in 0..states {
        let series: Vec<Series<'_>> = stretches.iter().map(|s| Series::of(s, i)).collect();
        let long = series::long(&series, SMOOTHED);
        let Some(shortest) = long.iter().map(|s| s.0.len()).min() else {
            return Ok(None);
        };
        let most = (shortest - 1) / 2 * 2 - 1;
        let choice = choose_savgol(&long, &SavgolSearch::default())?;
        let window = (choice.filter.window() as f64 * wider / 2.0) as usize * 2 + 1;
        let degree = choice.filter.degree();
        let least = least_window(degree);
        filters.push(SavitzkyGolay::new(
            window.clamp(least, most.max(least)),
            degree,
        )?);
    }
    Ok(Some(filters))
}

/// Gives the velocities, which come last, the filters of their positions: noise of a difference is not white, and a choice
/// by it would take too narrow ones.
pub(super) fn as_positions(filters: &mut [SavitzkyGolay], positions: &[usize]) {
    let first = filters.len() - positions.len();
    for (k, &position) in positions.iter().enumerate() {
        filters[first + k] = filters[position];
    }
}

/// The least window of a degree that smooths at all.
fn least_window(degree: usize) -> usize {
    degree / 2 * 2 + 3
}

/// Slopes by the given filters, narrower where a stretch is too short for them; by a spline where there are none.
pub(super) fn by(
    filters: Option<&[SavitzkyGolay]>,
    stretches: &[Stretch<'_>],
    states: usize,
) -> Result<Slopes, SindyError> {
    let Some(filters) = filters else {
        return with(stretches, states, SmoothingSpline::cross_validated().into());
    };
    let one = |f: &SavitzkyGolay, time: &[f64], column: &[f64]| {
        let most = (time.len() - 1) / 2 * 2 - 1;
        if most >= f.window() {
            f.apply(time, column)
        } else if most >= least_window(f.degree()) {
            SavitzkyGolay::new(most, f.degree())?.apply(time, column)
        } else {
            FiniteDifference::new(2)?.apply(time, column)
        }
    };
    let smoothed = smoothed(stretches, states, |i, time, column| {
        one(&filters[i], time, column)
    })?;
    let text: Vec<String> = filters
        .iter()
        .map(|f| format!("{}/{}", f.window(), f.degree()))
        .collect();
    // In rows, of which one with a rate of its own has several between samples.
    let apart = (0..states).map(|i| rows_apart(stretches, i));
    let windows = filters.iter().zip(apart);
    let windows = windows.map(|(f, apart)| (f.window() as f64 * apart).round());
    let widest = windows.fold(1.0, f64::max);
    Ok(Slopes {
        name: format!("Savitzky–Golay, window/degree {}", text.join(", ")),
        smoothed,
        edge: widest as usize / 2,
        window: widest,
        weights: Vec::new(),
    })
}

/// Slopes by one given method; stretches too short for it are differenced.
pub(super) fn with(
    stretches: &[Stretch<'_>],
    states: usize,
    method: Differentiator,
) -> Result<Slopes, SindyError> {
    let (name, edge) = match method {
        Differentiator::SavitzkyGolay(f) => (
            format!(
                "Savitzky–Golay, window {}, degree {}",
                f.window(),
                f.degree()
            ),
            f.window() / 2,
        ),
        Differentiator::FiniteDifference(f) => {
            (format!("finite differences of order {}", f.order()), 0)
        }
        Differentiator::SmoothingSpline(_) => ("smoothing spline by cross-validation".into(), 5),
        Differentiator::Kalman(_) => ("Kalman smoother by maximum likelihood".into(), 5),
        Differentiator::Spectral(_) => ("spectral".into(), 5),
    };
    let smoothed = smoothed(stretches, states, |_, time, column| {
        match method.apply(time, column) {
            Err(SindyError::TooShort { .. }) => FiniteDifference::new(2)?.apply(time, column),
            other => other,
        }
    })?;
    let apart = (0..states).map(|i| rows_apart(stretches, i));
    let edge = (edge as f64 * apart.fold(1.0, f64::max)).round() as usize;
    Ok(Slopes {
        name,
        smoothed,
        edge,
        window: (2 * edge + 1) as f64,
        weights: Vec::new(),
    })
}

/// The raw states, unsmoothed: for discrete time.
pub(super) fn raw(stretches: &[Stretch<'_>], states: usize) -> Slopes {
    let smoothed = stretches
        .iter()
        .map(|s| {
            (0..states)
                .map(|i| {
                    let x = s.columns[i];
                    // "Slope": the next sample; the last row has none.
                    let next = x[1..].iter().copied().chain([f64::NAN]).collect();
                    Smoothed {
                        value: x.to_vec(),
                        derivative: next,
                    }
                })
                .collect()
        })
        .collect();
    Slopes {
        name: "none (discrete time)".into(),
        smoothed,
        edge: 0,
        window: 1.0,
        weights: Vec::new(),
    }
}

/// The name of state `i`'s slope among the columns; no expression can contain it.
pub(super) fn slope_name(i: usize) -> String {
    format!("(slope {i})")
}

/// The name of the column of weights.
pub(super) const WEIGHT: &str = "(weight)";

/// The name of the column of weights of state `i`'s slopes, where [`Slopes::weights`] has them.
pub(super) fn weight_name(i: usize) -> String {
    format!("(weight {i})")
}

/// Blocks of rows of each stretch: stretches are cut until there are `folds` of them.
pub(super) fn blocks(
    stretches: &[Stretch<'_>],
    folds: usize,
) -> Vec<(usize, std::ops::Range<usize>)> {
    let rows: usize = stretches.iter().map(|s| s.time.len()).sum();
    let most = if stretches.len() >= folds {
        usize::MAX
    } else {
        rows.div_ceil(folds).max(20)
    };
    let mut out = Vec::new();
    for (index, s) in stretches.iter().enumerate() {
        let n = s.time.len();
        let parts = n.div_ceil(most).max(1);
        for k in 0..parts {
            out.push((index, k * n / parts..(k + 1) * n / parts));
        }
    }
    out
}

/// Samples for regression on slopes, one group for each block.
pub(super) fn regression_samples(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    slopes: &Slopes,
    blocks: &[(usize, std::ops::Range<usize>)],
) -> Result<Samples, SindyError> {
    let states = data.states().len();
    let mut names = data.names();
    names.extend((0..states).map(slope_name));
    names.push(WEIGHT.into());
    if !slopes.weights.is_empty() {
        names.extend((0..states).map(weight_name));
    }
    let mut samples = Samples::new(&names.iter().map(String::as_str).collect::<Vec<_>>());
    for (index, range) in blocks {
        let (s, smooth) = (&stretches[*index], &slopes.smoothed[*index]);
        let n = s.time.len();
        // The ends are omitted if enough rows remain.
        let edge = if n > 4 * slopes.edge { slopes.edge } else { 0 };
        // In discrete time the last row has no successor.
        let n = n - usize::from(smooth[0].derivative[n - 1].is_nan());
        let rows = range.start.max(edge)..range.end.min(n - edge).max(range.start.max(edge));
        let mut columns: Vec<Vec<f64>> = smooth
            .iter()
            .map(|c| c.value[rows.clone()].to_vec())
            .collect();
        columns.extend(s.columns[states..].iter().map(|c| c[rows.clone()].to_vec()));
        columns.extend(smooth.iter().map(|c| c.derivative[rows.clone()].to_vec()));
        columns.push(match s.weights {
            Some(w) => w[rows.clone()].to_vec(),
            None => vec![1.0; rows.len()],
        });
        let own = slopes.weights.get(*index).into_iter().flatten();
        columns.extend(own.map(|w| w[rows.clone()].to_vec()));
        samples.push_group(columns)?;
    }
    Ok(samples)
}

/// Rows of a part of long data.
const PART: usize = 2000;

/// Pieces for the output error: all stretches, or evenly spread parts of them where there are more than
/// `most` rows.
pub(super) fn pieces<'a>(
    stretches: &[Stretch<'a>],
    states: usize,
    slopes: &Slopes,
    between: &[Interpolation],
    most: usize,
) -> Vec<Piece<'a>> {
    let rows: usize = stretches.iter().map(|s| s.time.len()).sum();
    let keep = (most as f64 / rows as f64).min(1.0);
    let part = if keep < 1.0 { most.min(PART) } else { rows };
    cut(stretches, states, slopes, between, (part, keep))
}

/// All stretches in parts.
pub(super) fn parts<'a>(
    stretches: &[Stretch<'a>],
    states: usize,
    slopes: &Slopes,
    between: &[Interpolation],
) -> Vec<Piece<'a>> {
    cut(stretches, states, slopes, between, (PART, 1.0))
}

/// An evenly spread share of all parts of so many rows.
fn cut<'a>(
    stretches: &[Stretch<'a>],
    states: usize,
    slopes: &Slopes,
    between: &[Interpolation],
    (part, keep): (usize, f64),
) -> Vec<Piece<'a>> {
    let mut out = Vec::new();
    // The first part is always taken.
    let mut due = 1.0 - keep;
    for (s, smooth) in stretches.iter().zip(&slopes.smoothed) {
        let n = s.time.len();
        for start in (0..n).step_by(part) {
            let end = n.min(start + part);
            due += keep;
            if end - start < 3 || due < 1.0 - 1e-9 {
                continue;
            }
            due -= 1.0;
            out.push(Piece {
                time: &s.time[start..end],
                states: s.columns[..states].iter().map(|c| &c[start..end]).collect(),
                inputs: s.columns[states..].iter().map(|c| &c[start..end]).collect(),
                between: between.to_vec(),
                weights: s.weights.map(|w| &w[start..end]),
                seen: s.seen.iter().map(|s| &s.rows[start..end]).collect(),
                smooth: smooth
                    .iter()
                    .map(|c| c.value[start..end].to_vec())
                    .collect(),
            });
        }
    }
    out
}

#[cfg(test)]
mod tests;
