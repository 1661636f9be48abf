//! Which model: flights left out in turn decide.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::FlightSettings;
use super::fit::{Fit, fit, settle};
use super::model::{Curve, Piece, Shape};
use super::spread::{Spread, Sure, moved, prior};

/// Errors beyond so many standard deviations of the plain model's count as that.
const CLIP: f64 = 4.0;

/// Error of one candidate on flights that it has not seen.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// What it has beside the plain model.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Root mean square error on flights left out, over all rows (gravities).
    pub rmse: f64,
    /// The same in ground effect; absent where no row is.
    pub rmse_near: Option<f64>,
    /// Whether it was chosen.
    pub chosen: bool,
}

/// Squares on flights left out: flight by flight, `[all rows, rows in ground effect]`, as sums and counts.
struct Unseen {
    sums: Vec<[f64; 2]>,
    rows: Vec<[f64; 2]>,
}

impl Unseen {
    fn rmse(&self, of: usize) -> f64 {
        let sum: f64 = self.sums.iter().map(|s| s[of]).sum();
        let rows: f64 = self.rows.iter().map(|s| s[of]).sum();
        (sum / rows).sqrt()
    }

    /// Mean and standard error, over flights, of how much greater our squares are than those of `other`.
    fn excess(&self, other: &Self, of: usize) -> (f64, f64) {
        let each: Vec<f64> = (0..self.sums.len())
            .filter(|&f| self.rows[f][of] > 0.0)
            .map(|f| self.sums[f][of] - other.sums[f][of])
            .collect();
        let n = each.len() as f64;
        let mean = each.iter().sum::<f64>() / n;
        let sd = (each.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        (mean, sd / n.sqrt())
    }
}

/// Takes the flights out in turn (runs, where there are fewer than three flights).
fn unseen(fit: &Fit, pieces: &[Piece], near: f64, clip: f64) -> Unseen {
    let by_flight = pieces.iter().any(|p| p.flight >= 2);
    let of = |i: usize| if by_flight { pieces[i].flight } else { i };
    let many = (0..pieces.len()).map(of).max().map_or(0, |m| m + 1);
    let n = fit.theta.len();
    let (prior, _) = prior(fit);
    let total = fit
        .reduced
        .iter()
        .fold(prior, |sum: DMatrix<f64>, r| sum + &r.matrix);
    let mut out = Unseen {
        sums: vec![[0.0; 2]; many],
        rows: vec![[0.0; 2]; many],
    };
    for out_of in 0..many {
        let mut matrix = total.clone();
        let mut vector = DVector::zeros(n);
        let held: Vec<usize> = (0..pieces.len()).filter(|&i| of(i) == out_of).collect();
        for &i in &held {
            matrix -= &fit.reduced[i].matrix;
            vector -= &fit.reduced[i].vector;
        }
        let Some(solved) = matrix.cholesky() else {
            continue;
        };
        let theta = moved(fit, &solved.solve(&vector));
        for &i in &held {
            let piece = &pieces[i];
            let from = fit.locals[i];
            let is_near = |k: usize| piece.height.get(k).is_some_and(|z| *z < near);
            let (local, sum, rows) = settle(piece, fit, &theta, from, clip, &|_| true);
            let (_, sum_near, rows_near) = settle(piece, fit, &theta, local, clip, &is_near);
            for (k, (s, r)) in [(sum, rows), (sum_near, rows_near)].into_iter().enumerate() {
                out.sums[out_of][k] += s;
                out.rows[out_of][k] += r;
            }
        }
    }
    out
}

/// A choice in the making.
pub(super) struct Choice<'a> {
    pieces: &'a [Piece],
    /// Heights below this are in ground effect, in R.
    near: f64,
    /// Greatest error of a row (gravities), the same for all candidates.
    clip: f64,
    /// The model so far.
    pub(super) best: Fit,
    unseen: Unseen,
    /// All that was tried.
    pub(super) tried: Vec<Candidate>,
}

impl<'a> Choice<'a> {
    pub(super) fn start(pieces: &'a [Piece], shape: Shape, near: f64) -> Self {
        let best = fit(pieces, shape, None);
        let clip = CLIP * best.sigma;
        let unseen = unseen(&best, pieces, near, clip);
        let mut out = Self {
            pieces,
            near,
            clip,
            best,
            unseen,
            tried: Vec::new(),
        };
        let candidate = out.candidate("plain", shape, &out.unseen, true);
        out.tried.push(candidate);
        out
    }

    fn candidate(&self, name: &str, shape: Shape, unseen: &Unseen, chosen: bool) -> Candidate {
        Candidate {
            name: name.to_string(),
            shape,
            rmse: unseen.rmse(0),
            rmse_near: Some(unseen.rmse(1)).filter(|r| r.is_finite()),
            chosen,
        }
    }

    /// Takes a richer shape if flights left out are predicted better by more than one standard error of the difference.
    /// With fewer than two flights or runs nothing can be left out, and nothing is added.
    pub(super) fn offer(&mut self, name: &str, shape: Shape, near_only: bool) -> bool {
        let richer = fit(self.pieces, shape, Some(&self.best));
        let of_richer = unseen(&richer, self.pieces, self.near, self.clip);
        let (gain, error) = self.unseen.excess(&of_richer, usize::from(near_only));
        let take = richer.converged && gain > error;
        let candidate = self.candidate(name, shape, &of_richer, take);
        if take {
            for c in &mut self.tried {
                c.chosen = false;
            }
            (self.best, self.unseen) = (richer, of_richer);
        }
        self.tried.push(candidate);
        take
    }

    /// Takes the curve that predicts flights left out best in ground effect; the exponential, which is where we
    /// start, unless another one is better by more than one standard error of the difference.
    pub(super) fn curves(&mut self) {
        for curve in [Curve::Rational, Curve::Empirical] {
            let shape = Shape {
                curve,
                ..self.best.shape
            };
            self.offer(curve.name(), shape, true);
        }
    }

    /// Goes to another shape, whatever flights left out say.
    pub(super) fn replace(&mut self, name: &str, shape: Shape, from: &Fit) {
        self.best = fit(self.pieces, shape, Some(from));
        self.unseen = unseen(&self.best, self.pieces, self.near, self.clip);
        for c in &mut self.tried {
            c.chosen = false;
        }
        let candidate = self.candidate(name, shape, &self.unseen, true);
        self.tried.push(candidate);
    }

    /// Tells the model of the disturbance that its residuals show.
    pub(super) fn colour(&mut self) {
        self.best = self.best.coloured(self.pieces);
        self.unseen = unseen(&self.best, self.pieces, self.near, self.clip);
    }

    /// A number of the model so far.
    pub(super) fn sure(&self, name: &str, settings: &FlightSettings) -> Option<Sure> {
        Spread::of(&self.best, self.pieces, settings.resamples, settings.seed)
            .number(&self.best, name)
    }
}
