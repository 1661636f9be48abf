//! Least squares in free run over lag, dead time and static curve.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sindy::numerics::golden_section;

use super::record::{CommandRecord, period_s};
use super::shape::{Output, Shape};
use super::signal::Between;

/// Shortest lag (s): no rotor is as quick, and no log resolves it.
pub(crate) const SHORTEST_LAG_S: f64 = 2e-3;
/// Longest dead time (s): longer ones are not of a command line but of a logger's clock.
pub(crate) const LONGEST_DEAD_TIME_S: f64 = 0.2;
/// Dead times at which the search starts (s), denser where those of real chains are.
const DEAD_TIMES_S: [f64; 10] = [0.0, 0.005, 0.01, 0.02, 0.03, 0.045, 0.065, 0.09, 0.13, 0.2];
/// Lags at which the search starts: a factor of two between them, within the reach of Gauss–Newton.
const LAGS: usize = 10;
/// Rows that the starts are compared on: enough to rank them.
const ROWS_OF_STARTS: usize = 3000;
/// Starts that are followed to their minimum.
const FOLLOWED: usize = 3;
/// Pieces that the rows are cut into for standard errors and folds; as many as Student's t asks for (2.1).
const PIECES: usize = 20;
/// Records up to which each has a free start. Of more, a start matters less than its parameter costs.
const FREE_STARTS: usize = 12;
/// Gauss–Newton steps at most; a fit from a good start takes five.
const MOST_STEPS: usize = 60;
/// Smaller gains than this share of the cost end a search: far below what a standard error resolves.
const CONVERGED: f64 = 1e-10;

/// Which parameters move besides the curve's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Free {
    /// The lag.
    pub lag: bool,
    /// The dead time.
    pub dead_time: bool,
    /// The records' starts.
    pub starts: bool,
}

impl Free {
    /// The curve alone.
    pub(crate) const CURVE: Self = Self {
        lag: false,
        dead_time: false,
        starts: false,
    };
}

/// A point of the search.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Coefficients of the curve, then the records' starts less their steady values.
    pub linear: DVector<f64>,
    /// The lag (s); 0 for a static curve.
    pub lag_s: f64,
    /// The dead time (s).
    pub dead_time_s: f64,
    /// Sum of squared residuals (N²).
    pub squares: f64,
    /// Whether the search ended at a minimum.
    pub converged: bool,
}

/// Records, the rows of them that are compared, and the shape of the model.
pub(crate) struct Problem<'a> {
    pub records: &'a [CommandRecord],
    pub shape: Shape,
    pub between: Between,
    /// Longest lag (s).
    pub longest_lag_s: f64,
    /// Record and row of each measurement.
    pub(super) rows: Vec<(usize, usize)>,
    /// The piece that each measurement belongs to.
    pub pieces: Vec<usize>,
    /// Measured thrust (N).
    pub measured: Vec<f64>,
    /// Time between commands (s).
    pub period_s: f64,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        records: &'a [CommandRecord],
        shape: Shape,
        between: Between,
        longest_lag_s: f64,
    ) -> Self {
        let (mut rows, mut pieces, mut measured) = (Vec::new(), Vec::new(), Vec::new());
        let each = PIECES.div_ceil(records.len()).max(1);
        let mut periods = Vec::new();
        for (r, record) in records.iter().enumerate() {
            let finite: Vec<usize> = (0..record.time.len())
                .filter(|&i| record.thrust[i].is_finite())
                .collect();
            let count = finite.len();
            for (k, i) in finite.into_iter().enumerate() {
                rows.push((r, i));
                pieces.push(r * each + k * each / count);
                measured.push(record.thrust[i]);
            }
            periods.extend(record.time.windows(2).map(|w| w[1] - w[0]));
        }
        let commands_s = crate::thrust::plateau::median(periods.into_iter());
        Self {
            records,
            shape,
            between,
            longest_lag_s,
            rows,
            pieces,
            measured,
            period_s: commands_s.unwrap_or_else(|| period_s(records)),
        }
    }

    /// Measurements that are compared.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether each record has a start of its own.
    fn has_starts(&self, lag_s: f64) -> bool {
        self.shape.output == Output::Root && lag_s > 0.0 && self.records.len() <= FREE_STARTS
    }

    /// Columns of the linear parameters at every measurement.
    fn columns(&self, lag_s: f64, dead_time_s: f64) -> Vec<Vec<f64>> {
        let of_record: Vec<Vec<Vec<f64>>> = self
            .records
            .iter()
            .map(|r| self.shape.columns(r, self.between, lag_s, dead_time_s))
            .collect();
        let mut out: Vec<Vec<f64>> = (0..self.shape.coefficients())
            .map(|k| self.rows.iter().map(|&(r, i)| of_record[r][k][i]).collect())
            .collect();
        if self.has_starts(lag_s) {
            out.extend((0..self.records.len()).map(|of| {
                let start = |&(r, i): &(usize, usize)| {
                    let time = &self.records[r].time;
                    match r == of {
                        true => (-(time[i] - time[0]) / lag_s).exp(),
                        false => 0.0,
                    }
                };
                self.rows.iter().map(start).collect()
            }));
        }
        out
    }

    /// Predicted thrust at every measurement.
    pub(crate) fn predicted(&self, at: &Solution) -> Vec<f64> {
        let columns = self.columns(at.lag_s, at.dead_time_s);
        let z = sum(&columns, &at.linear);
        z.into_iter().map(|z| self.shape.thrust(z)).collect()
    }

    /// Derivatives of the predicted thrust by the free parameters, and the prediction: linear parameters first, then the
    /// logarithm of the lag, then the dead time.
    pub(crate) fn derivatives(&self, at: &Solution, free: Free) -> (Vec<Vec<f64>>, Vec<f64>) {
        self.derivatives_of(&self.columns(at.lag_s, at.dead_time_s), at, free)
    }

    fn derivatives_of(
        &self,
        columns: &[Vec<f64>],
        at: &Solution,
        free: Free,
    ) -> (Vec<Vec<f64>>, Vec<f64>) {
        let (lag, dead) = (at.lag_s, at.dead_time_s);
        let z = sum(columns, &at.linear);
        let slope: Vec<f64> = z.iter().map(|z| self.shape.slope(*z)).collect();
        let times = |c: &[f64]| c.iter().zip(&slope).map(|(c, s)| c * s).collect();
        let difference = |a: [f64; 2], b: [f64; 2], step: f64| -> Vec<f64> {
            let [a, b] = [a, b].map(|[l, d]| sum(&self.columns(l, d), &at.linear));
            b.iter().zip(&a).map(|(b, a)| (b - a) / step).collect()
        };
        let kept = match free.starts {
            true => columns.len(),
            false => self.shape.coefficients(),
        };
        let mut out: Vec<Vec<f64>> = columns[..kept].iter().map(|c| times(c)).collect();
        if free.lag {
            const STEP: f64 = 1e-3;
            let by = difference(
                [lag * (1.0 - STEP), dead],
                [lag * (1.0 + STEP), dead],
                2.0 * STEP,
            );
            out.push(times(&by));
        }
        if free.dead_time {
            // Wide beside the kinks at the samples, narrow beside the lag.
            let step = 0.05 * self.period_s.min(lag.max(SHORTEST_LAG_S));
            let low = (dead - step).max(0.0);
            let by = difference([lag, low], [lag, dead + step], dead + step - low);
            out.push(times(&by));
        }
        (out, z.iter().map(|z| self.shape.thrust(*z)).collect())
    }

    fn squares(&self, columns: &[Vec<f64>], by: &DVector<f64>, mask: Option<&[bool]>) -> f64 {
        let used = |i: usize| mask.is_none_or(|m| m[i]);
        let pairs = sum(columns, by).into_iter().zip(&self.measured);
        let of = pairs.enumerate().filter(|(i, _)| used(*i));
        let error = |z: f64, m: f64| (self.shape.thrust(z) - m).powi(2);
        let sum: f64 = of.map(|(_, (z, m))| error(z, *m)).sum();
        match sum.is_finite() {
            true => sum,
            false => f64::INFINITY,
        }
    }

    /// Follows a point downhill by Gauss–Newton steps with Levenberg's damping, over the rows of `mask`.
    pub(crate) fn refine(
        &self,
        mut at: Solution,
        free: Free,
        mask: Option<&[bool]>,
        most_steps: usize,
    ) -> Solution {
        let mut columns = self.columns(at.lag_s, at.dead_time_s);
        at.squares = self.squares(&columns, &at.linear, mask);
        at.converged = false;
        let mut damping = 1e-8;
        for _ in 0..most_steps {
            let (by, predicted) = self.derivatives_of(&columns, &at, free);
            let residual: Vec<f64> = predicted
                .iter()
                .zip(&self.measured)
                .map(|(p, m)| m - p)
                .collect();
            let (h, g) = normal(&by, &residual, mask);
            let mut better = None;
            while better.is_none() && damping < 1e9 {
                let next = self.moved(&at, &step(&h, &g, damping), free);
                // Lag and dead time alone move the columns.
                let moved = [next.lag_s, next.dead_time_s] != [at.lag_s, at.dead_time_s];
                let there = moved.then(|| self.columns(next.lag_s, next.dead_time_s));
                let of_next = there.as_ref().unwrap_or(&columns);
                let squares = self.squares(of_next, &next.linear, mask);
                if squares <= at.squares && squares.is_finite() {
                    columns = there.unwrap_or(columns);
                    better = Some(Solution { squares, ..next });
                } else {
                    damping = (damping * 10.0_f64).max(1e-6);
                }
            }
            let Some(next) = better else {
                at.converged = true;
                break;
            };
            let gain = at.squares - next.squares;
            damping = (damping * 0.1).max(1e-12);
            let done = gain <= CONVERGED * at.squares;
            at = next;
            if done {
                at.converged = true;
                break;
            }
        }
        at
    }

    fn moved(&self, at: &Solution, step: &DVector<f64>, free: Free) -> Solution {
        let mut next = at.clone();
        let kept = match free.starts {
            true => next.linear.len(),
            false => self.shape.coefficients(),
        };
        for k in 0..kept {
            next.linear[k] += step[k];
        }
        let mut rest = step.iter().skip(kept);
        if free.lag
            && let Some(by) = rest.next()
        {
            // A factor of ten at most, or the next step starts from nowhere.
            let factor = by.clamp(-2.3, 2.3).exp();
            next.lag_s = (next.lag_s * factor).clamp(SHORTEST_LAG_S, self.longest_lag_s);
        }
        if free.dead_time
            && let Some(by) = rest.next()
        {
            next.dead_time_s = (next.dead_time_s + by).clamp(0.0, LONGEST_DEAD_TIME_S);
        }
        next
    }

    /// A curve by regression at a lag and a dead time, as a start.
    pub(crate) fn start(&self, lag_s: f64, dead_time_s: f64, mask: Option<&[bool]>) -> Solution {
        let columns = self.columns(lag_s, dead_time_s);
        let target: Vec<f64> = match self.shape.output {
            Output::Root => self.measured.iter().map(|t| t.max(0.0).sqrt()).collect(),
            Output::Thrust => self.measured.clone(),
        };
        let (h, g) = normal(&columns, &target, mask);
        Solution {
            linear: step(&h, &g, 1e-12),
            lag_s,
            dead_time_s,
            squares: f64::INFINITY,
            converged: false,
        }
    }

    /// The least squares over all free parameters: starts on a grid of lags and dead times, the best of them followed
    /// to their minima, the dead time of the best narrowed by golden section.
    pub(crate) fn solve(&self, free: Free) -> Solution {
        if !free.lag {
            let start = self.start(0.0, 0.0, None);
            return self.refine(start, Free::CURVE, None, MOST_STEPS);
        }
        let stride = self.len().div_ceil(ROWS_OF_STARTS);
        let few: Vec<bool> = (0..self.len()).map(|i| i.is_multiple_of(stride)).collect();
        let ratio = self.longest_lag_s / SHORTEST_LAG_S;
        let dead_times = match free.dead_time {
            true => &DEAD_TIMES_S[..],
            false => &DEAD_TIMES_S[..1],
        };
        let fixed = Free {
            starts: free.starts,
            ..Free::CURVE
        };
        let from = |start: usize| {
            let (dead_time_s, k) = (dead_times[start / LAGS], start % LAGS);
            let lag_s = SHORTEST_LAG_S * ratio.powf((k as f64 + 0.5) / LAGS as f64);
            let start = self.start(lag_s, dead_time_s, Some(&few));
            self.refine(start, fixed, Some(&few), 3)
        };
        let all = (0..dead_times.len() * LAGS).into_par_iter();
        let mut starts: Vec<Solution> = all.map(from).collect();
        starts.sort_by(|a, b| a.squares.total_cmp(&b.squares));
        starts.truncate(FOLLOWED);
        let followed = starts.into_par_iter();
        let ends: Vec<Solution> = followed
            .map(|start| self.refine(start, free, None, MOST_STEPS))
            .collect();
        let ends = ends.into_iter();
        let best = ends.min_by(|a, b| a.squares.total_cmp(&b.squares));
        // The grid is never empty.
        let best = best.unwrap_or_else(|| self.start(SHORTEST_LAG_S, 0.0, None));
        match free.dead_time {
            true => self.narrowed(best, free),
            false => best,
        }
    }

    /// The profile over dead time, narrowed within a period of the commands: it has kinks where a delayed command
    /// passes a measurement.
    fn narrowed(&self, best: Solution, free: Free) -> Solution {
        let fixed = Free {
            dead_time: false,
            ..free
        };
        let low = (best.dead_time_s - self.period_s).max(0.0);
        let high = (best.dead_time_s + self.period_s).min(LONGEST_DEAD_TIME_S);
        let mut least = best;
        let narrow = 1e-2 * self.period_s;
        golden_section(
            [low, high],
            |a, b| b - a > narrow,
            |dead_time_s| {
                let start = Solution {
                    dead_time_s,
                    ..least.clone()
                };
                let end = self.refine(start, fixed, None, 6);
                let squares = end.squares;
                if squares < least.squares {
                    least = end;
                }
                squares
            },
        );
        self.refine(least, free, None, MOST_STEPS)
    }
}

/// The sum of columns by their coefficients; columns beyond the coefficients count nothing.
fn sum(columns: &[Vec<f64>], by: &DVector<f64>) -> Vec<f64> {
    let mut out = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, c) in columns.iter().zip(by.iter()) {
        for (o, v) in out.iter_mut().zip(column) {
            *o += c * v;
        }
    }
    out
}

/// Normal equations of columns and a target over the rows of `mask`.
fn normal(by: &[Vec<f64>], target: &[f64], mask: Option<&[bool]>) -> (DMatrix<f64>, DVector<f64>) {
    let p = by.len();
    let (mut h, mut g) = (DMatrix::zeros(p, p), DVector::zeros(p));
    let used: Vec<usize> = (0..target.len())
        .filter(|&i| mask.is_none_or(|m| m[i]))
        .collect();
    for a in 0..p {
        for b in 0..=a {
            let sum: f64 = used.iter().map(|&i| by[a][i] * by[b][i]).sum();
            h[(a, b)] = sum;
            h[(b, a)] = sum;
        }
        g[a] = used.iter().map(|&i| by[a][i] * target[i]).sum();
    }
    (h, g)
}

/// The damped step of scaled normal equations; directions without data do not move.
fn step(h: &DMatrix<f64>, g: &DVector<f64>, damping: f64) -> DVector<f64> {
    let p = g.len();
    let scale = DVector::from_fn(p, |j, _| h[(j, j)].sqrt());
    let by = |j: usize| match scale[j] > 0.0 {
        true => 1.0 / scale[j],
        false => 0.0,
    };
    let scaled = DMatrix::from_fn(p, p, |a, b| {
        h[(a, b)] * by(a) * by(b) + if a == b { damping } else { 0.0 }
    });
    let right = DVector::from_fn(p, |j, _| g[j] * by(j));
    let eigen = scaled.symmetric_eigen();
    let mut out = DVector::zeros(p);
    for (k, value) in eigen.eigenvalues.iter().enumerate() {
        // Below the rounding of the sums there is no direction.
        if *value > 1e-13 {
            let vector = eigen.eigenvectors.column(k);
            out += vector * (vector.dot(&right) / value);
        }
    }
    DVector::from_fn(p, |j, _| out[j] * by(j))
}
