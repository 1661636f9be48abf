//! Sparse Bayesian regression from the sums of the rows.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde::Deserialize;
use sindy::solve::sr3::Scaling;
use sindy::uncertainty::Horseshoe;
use sindy::uncertainty::horseshoe::Prior;
use sindy::{Gram, SindyError};

use crate::error;
use crate::model::{Matrix, matrix};
use crate::run;

/// Settings as the Python side has them.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    global_scale: f64,
    slab_degrees: f64,
    slab_scale: f64,
    noise_rate: f64,
    chains: usize,
    warm_up: usize,
    draws: usize,
    seed: u64,
}

impl Settings {
    fn build(self) -> Result<Horseshoe, SindyError> {
        let prior = Prior::new(
            self.global_scale,
            self.slab_degrees,
            self.slab_scale,
            self.noise_rate,
        )?;
        Horseshoe::new(self.seed)
            .prior(prior)
            .scaling(Scaling::None)
            .chains(self.chains)?
            .warm_up(self.warm_up)
            .draws(self.draws)
    }
}

/// For each target: means, draws of the coefficients and of their local scales (terms x draws). Then the draws of τ, c² and σ, and
/// a warning if the chains have not converged.
type Sampled<'py> = (
    Vec<(Vec<f64>, Matrix<'py>, Matrix<'py>)>,
    [Vec<f64>; 3],
    Option<String>,
);

/// The posterior of the coefficients of several targets over the same terms, by `ΘᵀΘ`, `ΘᵀY`, the squares of the targets and the
/// number of rows.
#[pyfunction]
pub(crate) fn sample_horseshoe<'py>(
    py: Python<'py>,
    products: PyReadonlyArray2<'py, f64>,
    with_targets: PyReadonlyArray2<'py, f64>,
    squares: Vec<f64>,
    rows: usize,
    settings_json: &str,
) -> PyResult<Sampled<'py>> {
    let settings: Settings = error::read("horseshoe", settings_json)?;
    let (products, with_targets) = (products.as_array(), with_targets.as_array());
    let p = products.nrows();
    if products.ncols() != p || with_targets.dim() != (p, squares.len()) {
        return Err(error::of(&SindyError::Shape {
            what: "sums of the rows",
            expected: p,
            found: with_targets.nrows(),
        }));
    }
    let grams: Vec<Gram> = squares
        .iter()
        .zip(with_targets.columns())
        .map(|(yty, column)| {
            let mut gram = Gram::zeros(p);
            products
                .indexed_iter()
                .for_each(|(at, v)| gram.xtx[at] = *v);
            column
                .iter()
                .enumerate()
                .for_each(|(j, v)| gram.xty[j] = *v);
            (gram.yty, gram.rows) = (*yty, rows);
            gram
        })
        .collect();
    let posterior = run::owned(py, None, move |_| settings.build()?.sample(&grams))?;
    let warning = posterior.warning();
    let targets = posterior.targets.into_iter().map(|target| {
        let means = target.marginals.iter().map(|m| m.mean).collect();
        let n = target.draws.ncols();
        let draws = matrix(py, p, n, target.draws.as_slice().to_vec())?;
        let scales = matrix(py, p, n, target.local_scales.as_slice().to_vec())?;
        Ok((means, draws, scales))
    });
    Ok((targets.collect::<PyResult<_>>()?, posterior.scales, warning))
}
