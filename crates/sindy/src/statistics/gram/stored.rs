//! Statistics between processes: every number reads back exactly.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::{Gram, Weights};
use crate::statistics::tsqr::Triangle;

/// The numbers of a [`Gram`], matrices column after column.
#[derive(Serialize, Deserialize)]
#[serde(rename = "Gram", deny_unknown_fields)]
pub(super) struct StoredGram {
    xtx: Vec<f64>,
    xty: Vec<f64>,
    yty: f64,
    sum_y: f64,
    rows: usize,
    skipped: usize,
    /// Sum of the weights, and of their squares.
    weights: Option<(f64, f64)>,
    #[serde(default)]
    triangle: Option<Vec<f64>>,
}

impl From<Gram> for StoredGram {
    fn from(gram: Gram) -> Self {
        Self {
            xtx: gram.xtx.as_slice().to_vec(),
            xty: gram.xty.as_slice().to_vec(),
            yty: gram.yty,
            sum_y: gram.sum_y,
            rows: gram.rows,
            skipped: gram.skipped,
            weights: gram.weights.map(|w| (w.sum, w.squares)),
            triangle: gram.triangle.map(|t| t.matrix().as_slice().to_vec()),
        }
    }
}

impl TryFrom<StoredGram> for Gram {
    type Error = String;

    fn try_from(stored: StoredGram) -> Result<Self, String> {
        let p = stored.xty.len();
        let count = |what: &str, expected: usize, found: usize| match expected == found {
            true => Ok(()),
            false => Err(format!(
                "{what} of {p} terms: expected {expected} numbers, found {found}"
            )),
        };
        count("Gram matrix", p * p, stored.xtx.len())?;
        let triangle = match stored.triangle {
            None => None,
            Some(r) => {
                count("triangular factor", (p + 1) * (p + 1), r.len())?;
                Some(Triangle::of_matrix(DMatrix::from_vec(p + 1, p + 1, r)))
            }
        };
        Ok(Self {
            xtx: DMatrix::from_vec(p, p, stored.xtx),
            xty: stored.xty.into(),
            yty: stored.yty,
            sum_y: stored.sum_y,
            rows: stored.rows,
            skipped: stored.skipped,
            weights: stored
                .weights
                .map(|(sum, squares)| Weights { sum, squares }),
            triangle,
        })
    }
}
