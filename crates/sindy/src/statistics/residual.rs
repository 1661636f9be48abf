//! Residuals of a fit, row by row.

use nalgebra::DVector;
use sindy_expr::Scratch;

use crate::data::samples::{BlockSource, position};
use crate::error::{SindyError, same_size};
use crate::library::Library;

/// Rows that are evaluated at a time.
const CHUNK: usize = 256;

/// The residuals `y - Θ ξ` of `target`, one vector for each group of `source`, in the target's unit; NaN in rows
/// whose target or terms are not finite, which fits leave out.
///
/// # Errors
/// Not one coefficient for each term, names without a column, a pass that failed.
pub fn residuals(
    library: &Library,
    target: &str,
    coefficients: &DVector<f64>,
    source: &dyn BlockSource,
) -> Result<Vec<Vec<f64>>, SindyError> {
    let mut out = vec![Vec::new(); source.groups()];
    each_row(library, target, coefficients, source, |group, _, r| {
        out[group].push(r);
    })?;
    Ok(out)
}

/// The residual of every row times term `j`, one vector for each group: what coefficient `j` is estimated from (its
/// sum is zero for least squares), and so what its uncertainty comes from. NaN as in [`residuals`].
///
/// # Errors
/// As [`residuals`]; no term `j`.
pub fn scores(
    library: &Library,
    target: &str,
    coefficients: &DVector<f64>,
    j: usize,
    source: &dyn BlockSource,
) -> Result<Vec<Vec<f64>>, SindyError> {
    if j >= library.len() {
        return Err(SindyError::shape(
            "terms of the library (more than)",
            j,
            library.len(),
        ));
    }
    let mut out = vec![Vec::new(); source.groups()];
    each_row(library, target, coefficients, source, |group, theta, r| {
        out[group].push(theta(j) * r);
    })?;
    Ok(out)
}

/// Calls `visit` with group, terms by index, and residual of each row.
fn each_row(
    library: &Library,
    target: &str,
    coefficients: &DVector<f64>,
    source: &dyn BlockSource,
    mut visit: impl FnMut(usize, &dyn Fn(usize) -> f64, f64),
) -> Result<(), SindyError> {
    let p = library.len();
    same_size("coefficients (one per term)", p, coefficients.len())?;
    let program = library.compile(source.names())?;
    let target = position(source.names(), target)?;
    let mut theta = vec![0.0; CHUNK * p];
    let mut scratch = Scratch::default();
    source.for_each_block(&mut |block| {
        let n = block.columns.first().map_or(0, |c| c.len());
        for start in (0..n).step_by(CHUNK) {
            let rows = CHUNK.min(n - start);
            let part: Vec<&[f64]> = block
                .columns
                .iter()
                .map(|c| &c[start..start + rows])
                .collect();
            let theta = &mut theta[..rows * p];
            program.eval_block(&part, theta, &mut scratch);
            for r in 0..rows {
                let mut residual = part[target][r];
                let mut usable = residual.is_finite();
                for j in 0..p {
                    let term = theta[j * rows + r];
                    usable &= term.is_finite();
                    residual -= coefficients[j] * term;
                }
                let residual = if usable { residual } else { f64::NAN };
                visit(block.group, &|j| theta[j * rows + r], residual);
            }
        }
    });
    source.failure().map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gram, Samples, statistics::regression::least_squares};

    #[test]
    fn analytic_residuals_and_scores_of_least_squares() {
        let mut samples = Samples::new(&["x", "y"]);
        for n in [300, 7] {
            let x: Vec<f64> = (0..n).map(|i| f64::from(i).sin()).collect();
            let y = x.iter().map(|x| x * x).collect();
            samples.push_group(vec![x, y]).unwrap();
        }
        samples
            .push_group(vec![vec![f64::NAN, 1.0], vec![0.0, f64::INFINITY]])
            .unwrap();
        let library = Library::parse(&["1", "x"]).unwrap();
        let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
        let xi = least_squares(&gram, &[true; 2]);
        let r = residuals(&library, "y", &xi, &samples).unwrap();
        let lengths: Vec<usize> = r.iter().map(Vec::len).collect();
        assert_eq!(lengths, [300, 7, 2]);
        assert!(r[2].iter().all(|v| v.is_nan()));
        let squares: f64 = r[..2].iter().flatten().map(|r| r * r).sum();
        // Rounding of 307 numbers below one.
        assert!((squares - gram.residual_sum(&xi)).abs() < 1e-11);
        for j in 0..2 {
            let s = scores(&library, "y", &xi, j, &samples).unwrap();
            assert!(s[..2].iter().flatten().sum::<f64>().abs() < 1e-11);
        }
        assert!(scores(&library, "y", &xi, 2, &samples).is_err());
        assert!(residuals(&library, "z", &xi, &samples).is_err());
        assert!(residuals(&library, "y", &DVector::zeros(3), &samples).is_err());
    }
}
