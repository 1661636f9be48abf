//! A stretch of data with the nodes of its trajectory.

use super::Piece;
use crate::model::Interpolation;
use crate::numerics::{hermite, spline_slopes};

/// Samples from one node to the next, at most: defects are closed in steps of this length, and cost grows with their
/// number.
const NODE: usize = 10;
/// Nodes are so close that states change by this share of their scatter in between (root mean square). With twice the
/// distance coarse chaotic data cannot be started.
const CHANGE: f64 = 0.3;
/// One stretch of data as the search sees it.
pub(super) struct Record {
    pub time: Vec<f64>,
    /// One column for each state.
    pub states: Vec<Vec<f64>>,
    inputs: Vec<Input>,
    /// Square roots of the rows' weights.
    weights: Option<Vec<f64>>,
    /// By state, where it is measured: the number of the sample in each row. None where all are in all rows.
    samples: Vec<Vec<Option<usize>>>,
    /// The states at the nodes, as they are estimated now.
    pub nodes: Vec<Vec<f64>>,
    /// The rows of the nodes, the first of them 0.
    pub rows: Vec<usize>,
    /// Variance of each state over the nodes as they were first.
    pub spread: Vec<f64>,
}

/// One input.
struct Input {
    values: Vec<f64>,
    /// At the samples, of a cubic one.
    slopes: Vec<f64>,
    how: Interpolation,
}

impl Record {
    pub(super) fn new(piece: &Piece<'_>) -> Self {
        let n = piece.time.len();
        let pace = piece.smooth.iter().map(|c| pace(c)).fold(0.0, f64::max);
        let node = ((CHANGE / pace) as usize).clamp(1, NODE);
        let rows: Vec<usize> = (0..n.saturating_sub(1)).step_by(node).collect();
        let smooth = piece.smooth.iter();
        let spread = smooth.map(|c| variance(rows.iter().map(|&r| c[r])));
        Self {
            spread: spread.collect(),
            time: piece.time.to_vec(),
            states: piece.states.iter().map(|c| c.to_vec()).collect(),
            inputs: piece
                .inputs
                .iter()
                .zip(&piece.between)
                .map(|(values, how)| Input {
                    values: values.to_vec(),
                    slopes: match how {
                        Interpolation::Cubic => spline_slopes(piece.time, values),
                        _ => Vec::new(),
                    },
                    how: *how,
                })
                .collect(),
            weights: piece.weights.map(|w| w.iter().map(|w| w.sqrt()).collect()),
            samples: piece.seen.iter().map(|seen| numbered(seen)).collect(),
            nodes: rows
                .iter()
                .map(|&r| piece.smooth.iter().map(|c| c[r]).collect())
                .collect(),
            rows,
        }
    }

    /// The inputs at a part of the way from sample `row` to the next; of a held one, the value of the sample.
    pub(super) fn inputs_at(&self, row: usize, part: f64) -> Vec<f64> {
        let one = |input: &Input| {
            let (a, b) = (input.values[row], input.values[row + 1]);
            match input.how {
                Interpolation::ZeroOrderHold => a,
                Interpolation::Linear => a + part * (b - a),
                Interpolation::Cubic => {
                    let h = self.time[row + 1] - self.time[row];
                    hermite(a, b, h * input.slopes[row], h * input.slopes[row + 1], part)
                }
            }
        };
        self.inputs.iter().map(one).collect()
    }

    /// The rows of node `node` and of what follows it: the next node, or the last row.
    pub(super) fn between(&self, node: usize) -> (usize, usize) {
        let next = self.rows.get(node + 1).copied();
        (self.rows[node], next.unwrap_or(self.time.len() - 1))
    }

    /// Whether no node follows.
    pub(super) fn is_last(&self, node: usize) -> bool {
        node + 1 == self.rows.len()
    }

    /// The residual of state `i` at `row`, by the root of its weight.
    pub(super) fn residual(&self, i: usize, row: usize, x: f64) -> f64 {
        (self.states[i][row] - x) * self.root_weight(row)
    }

    pub(super) fn root_weight(&self, row: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w[row])
    }

    /// The number of the sample of state `i` at `row`; `None` where it is not measured there.
    pub(super) fn sample(&self, i: usize, row: usize) -> Option<usize> {
        self.samples.get(i).map_or(Some(row), |own| own[row])
    }

    /// Whether any state is compared at `row`.
    pub(super) fn is_compared(&self, row: usize) -> bool {
        let seen = self.samples.iter().any(|own| own[row].is_some());
        self.root_weight(row) > 0.0 && (self.samples.is_empty() || seen)
    }

    /// Whether the start of an arc may be seen by too few values to be found.
    pub(super) fn is_sparse(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Nodes that hold some samples of every state on average, with the first and the last of them.
    pub(super) fn nodes_of(&self, samples: usize, measured: usize) -> usize {
        let counts = self.samples.iter().take(measured);
        let least = counts.map(|own| own.iter().flatten().count()).min();
        let apart = least.map_or(1.0, |n| self.time.len() as f64 / n.max(1) as f64);
        let rows = self.time.len() as f64 / self.rows.len() as f64;
        (samples as f64 * apart / rows).ceil() as usize
    }
}

/// The numbers of the rows that are seen, among these.
fn numbered(seen: &[bool]) -> Vec<Option<usize>> {
    let mut count = 0;
    let number = |seen: &bool| {
        let number = count;
        count += usize::from(*seen);
        seen.then_some(number)
    };
    seen.iter().map(number).collect()
}

/// Variance of values about their mean.
fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    values.map(|v| (v - mean).powi(2)).sum::<f64>() / n
}

/// Root mean square of the steps of a signal over its standard deviation.
fn pace(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    let steps = x.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / n;
    if variance > 0.0 {
        (steps / variance).sqrt()
    } else {
        0.0
    }
}
