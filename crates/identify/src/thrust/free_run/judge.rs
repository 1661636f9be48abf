//! Errors of a fit on parts of the data that it has not seen.

use rayon::prelude::*;

use super::solve::{Free, Problem, Solution};

/// Parts that are held out in turn: a fit sees four fifths of the data.
pub(crate) const FOLDS: usize = 5;
/// Gauss–Newton steps from the fit to all data; a fold moves it little.
const STEPS: usize = 8;

/// Squared errors of each piece of the data, held out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HeldOut {
    /// Sum of squares (N²) and count of each piece.
    pub pieces: Vec<(f64, usize)>,
}

impl HeldOut {
    /// From predictions of each fold for all rows.
    pub(crate) fn of(pieces: &[usize], measured: &[f64], folds: &[Vec<f64>]) -> Self {
        let count = pieces.iter().max().map_or(0, |last| last + 1);
        let mut out = vec![(0.0, 0); count];
        for (i, (&piece, m)) in pieces.iter().zip(measured).enumerate() {
            let error = folds[piece % folds.len()][i] - m;
            out[piece].0 += if error.is_finite() {
                error * error
            } else {
                f64::INFINITY
            };
            out[piece].1 += 1;
        }
        out.retain(|p| p.1 > 0);
        Self { pieces: out }
    }

    /// Root mean square error (N).
    pub(crate) fn rmse(&self) -> f64 {
        let (sum, count) = self.total();
        (sum / count).sqrt()
    }

    fn total(&self) -> (f64, f64) {
        let sum = self.pieces.iter().map(|p| p.0).sum::<f64>();
        (sum, self.pieces.iter().map(|p| p.1).sum::<usize>() as f64)
    }

    /// Standard error of the root mean square error (N), over pieces.
    pub(crate) fn std_error(&self) -> f64 {
        let (sum, count) = self.total();
        let mean = sum / count;
        let pieces = self.pieces.len() as f64;
        let spread: f64 = self
            .pieces
            .iter()
            .map(|(s, n)| (s - mean * *n as f64).powi(2))
            .sum();
        (spread * pieces / (pieces - 1.0)).sqrt() / count / (2.0 * mean.sqrt())
    }

    /// Whether this one's error exceeds another's by at most one standard error of their difference, and both were
    /// judged on the same pieces.
    pub(crate) fn as_good_as(&self, other: &Self) -> bool {
        if self.pieces.len() != other.pieces.len() {
            return self.rmse() <= other.rmse() + other.std_error();
        }
        let pairs = self.pieces.iter().zip(&other.pieces);
        let excess: Vec<f64> = pairs.map(|(a, b)| a.0 - b.0).collect();
        let pieces = excess.len() as f64;
        let mean = excess.iter().sum::<f64>() / pieces;
        let spread: f64 = excess.iter().map(|e| (e - mean).powi(2)).sum();
        mean <= (spread / (pieces * (pieces - 1.0))).sqrt()
    }
}

impl Problem<'_> {
    /// The held-out error of a fit: every fold is predicted by a fit to the others, in one run over its record.
    pub(crate) fn held_out(&self, at: &Solution, free: Free) -> HeldOut {
        let free = Free {
            starts: false,
            ..free
        };
        let folds: Vec<Vec<f64>> = (0..FOLDS)
            .into_par_iter()
            .map(|fold| {
                let mask: Vec<bool> = self.pieces.iter().map(|p| p % FOLDS != fold).collect();
                let trained = self.refine(at.clone(), free, Some(&mask), STEPS);
                self.predicted(&trained)
            })
            .collect();
        HeldOut::of(&self.pieces, &self.measured, &folds)
    }
}
