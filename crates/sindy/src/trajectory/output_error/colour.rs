//! Noise that remembers: residuals of neighbouring rows are compared by what is new in them.
//!
//! For noise `e_k = φ e_{k-1} + ν_k`, ν white with variance σ² (an autoregression of first order; a random walk for φ = 1),
//! the likelihood is that of
//!
//! ```text
//! r_k - φ r_{k-1}   in units of σ,   and of an arc's first row   √(1 - φ²) r_0,
//! ```
//!
//! a linear map of the residuals, and so of their derivatives by starts and coefficients. φ is estimated from the residuals of
//! the fit before.
//!
//! Source: D. Cochrane, G. H. Orcutt, Journal of the American Statistical Association 44 (1949); S. J. Prais, C. B. Winsten,
//! Cowles Commission Discussion Paper 383 (1954), for the first row; D. A. Dickey, W. A. Fuller, Journal of the American
//! Statistical Association 74 (1979), for the unit root.

/// φ of a random walk: a little below 1, so that starts are held where nothing else does.
const WALK: f64 = 0.9999;
/// The noise is a random walk unless `n (1 - φ)` over a record of n rows is above this: Dickey and Fuller's test at 5 %.
const UNIT_ROOT: f64 = 14.1;
/// Standard deviations of a normal variable at a level of 1 %.
const SURE: f64 = 2.576;

/// Subtracts from each sample of an arc the noise that the one before predicts.
pub(super) struct Whitener<'a> {
    /// φ of each measured state.
    colour: &'a [f64],
    /// By state, the last sample and its values before the map.
    last: Vec<Option<usize>>,
    before: Vec<Vec<f64>>,
}

impl<'a> Whitener<'a> {
    pub(super) fn new(colour: &'a [f64]) -> Self {
        Self {
            colour,
            last: vec![None; colour.len()],
            before: vec![Vec::new(); colour.len()],
        }
    }

    /// Whether values of a state are changed at all.
    pub(super) fn changes(&self, state: usize) -> bool {
        self.phi(state) != 0.0
    }

    fn phi(&self, state: usize) -> f64 {
        self.colour.get(state).copied().unwrap_or(0.0)
    }

    /// Maps values of a state at a sample, which follows the last one if it is the next.
    pub(super) fn apply(&mut self, state: usize, sample: usize, values: &mut [f64]) {
        let phi = self.phi(state);
        if phi == 0.0 {
            return;
        }
        let own = values.to_vec();
        let last = self.last[state].replace(sample);
        if last.is_some_and(|last| last + 1 == sample) {
            let pairs = values.iter_mut().zip(&self.before[state]);
            pairs.for_each(|(v, before)| *v -= phi * before);
        } else {
            let first = (1.0 - phi * phi).sqrt();
            values.iter_mut().for_each(|v| *v *= first);
        }
        self.before[state] = own;
    }
}

/// φ of each state, from the residuals by record, state and row: the correlation of neighbours. Where that of a random walk is
/// not refused it is taken: a fit takes slow parts from the residual, so that it seems to remember less, and terms that follow
/// what is left of them would seem to be certain.
pub(crate) fn colour(residuals: &[Vec<Vec<f64>>]) -> Vec<f64> {
    let states = residuals.first().map_or(0, Vec::len);
    (0..states)
        .map(|i| {
            let phi = neighbours(residuals, i);
            let rows = residuals.iter().map(|r| r[i].len()).sum::<usize>() as f64;
            match rows / residuals.len() as f64 * (1.0 - phi) {
                short if short <= UNIT_ROOT => WALK,
                long if long.is_finite() => phi.max(0.0),
                _ => 0.0,
            }
        })
        .collect()
}

/// Whether neighbours are not correlated any more: noise that remembers and white noise beside it, or a missing term beside it, leave
/// correlations below 0. At a level of 1 % for each state.
pub(super) fn is_white(mapped: &[Vec<Vec<f64>>]) -> bool {
    let states = mapped.first().map_or(0, Vec::len);
    (0..states).all(|i| {
        let rows: usize = mapped.iter().map(|r| r[i].len()).sum();
        neighbours(mapped, i).abs() <= SURE / (rows as f64).sqrt()
    })
}

/// The correlation of neighbours in a state's residuals.
fn neighbours(residuals: &[Vec<Vec<f64>>], state: usize) -> f64 {
    let (mut square, mut product) = (0.0, 0.0);
    for record in residuals {
        square += record[state].iter().map(|r| r * r).sum::<f64>();
        product += record[state].windows(2).map(|w| w[0] * w[1]).sum::<f64>();
    }
    product / square
}

/// Residuals by record, state and row, mapped.
pub(super) fn whitened(residuals: &[Vec<Vec<f64>>], colour: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let state = |(i, values): (usize, &Vec<f64>)| {
        let mut whitener = Whitener::new(colour);
        let row = |(k, v): (usize, &f64)| {
            let mut one = [*v];
            whitener.apply(i, k, &mut one);
            one[0]
        };
        values.iter().enumerate().map(row).collect()
    };
    residuals
        .iter()
        .map(|record| record.iter().enumerate().map(state).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn analytic_an_autoregression_becomes_white() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        for phi in [0.0, 0.5, 0.95] {
            let mut e = 0.0;
            let series: Vec<f64> = (0..4000)
                .map(|_| {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    e = phi * e + z;
                    e
                })
                .collect();
            let found = colour(&[vec![series.clone()]])[0];
            // Its standard error is √((1 - φ²)/4000), at most 0.016.
            assert!((found - phi).abs() < 0.05, "{phi}: {found}");
            let white = &whitened(&[vec![series]], &[found])[0][0];
            let variance = white.iter().map(|v| v * v).sum::<f64>() / 4000.0;
            // The variance of a normal variable from 4000 draws has a standard error of 0.022.
            assert!((variance - 1.0).abs() < 0.08, "{phi}: {variance}");
            let left = colour(&[vec![white.clone()]])[0];
            assert!(left < 0.05, "{phi}: {left}");
        }
    }

    #[test]
    fn prop_rows_that_do_not_follow_stand_for_themselves() {
        let mut whitener = Whitener::new(&[0.6, 0.0]);
        let mut of = |row: usize, state: usize, v: f64| {
            let mut values = [v];
            whitener.apply(state, row, &mut values);
            values[0]
        };
        assert!((of(3, 0, 1.0) - 0.8).abs() < 1e-15);
        assert!((of(4, 0, 1.0) - 0.4).abs() < 1e-15);
        assert!((of(6, 0, 2.0) - 1.6).abs() < 1e-15);
        assert_eq!(of(7, 1, 2.0), 2.0);
        assert_eq!(colour(&[vec![vec![0.0; 5]]]), [0.0]);
        assert_eq!(colour(&[]), [0.0; 0]);
    }
}
