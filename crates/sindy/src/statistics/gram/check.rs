//! Which statistics a solver can use.

use super::Gram;
use crate::error::{SindyError, same_size};

/// Refuses statistics that no solver can use.
///
/// # Errors
/// No terms, no rows, shapes that do not fit, or an entry that is not finite.
pub fn check(gram: &Gram) -> Result<(), SindyError> {
    let p = gram.xty.len();
    if p == 0 {
        return Err(SindyError::shape("terms of the library", 1, 0));
    }
    for (what, found) in [
        ("rows of the Gram matrix", gram.xtx.nrows()),
        ("columns of the Gram matrix", gram.xtx.ncols()),
    ] {
        same_size(what, p, found)?;
    }
    if gram.rows == 0 {
        return Err(SindyError::too_short(1, 0));
    }
    let not_finite = |what: &str, index| SindyError::NotFinite {
        what: what.to_string(),
        index,
    };
    if let Some(j) = (0..p).find(|&j| gram.xtx.column(j).iter().any(|v| !v.is_finite())) {
        return Err(not_finite("Gram matrix, column", j));
    }
    if let Some(j) = (0..p).find(|&j| !gram.xty[j].is_finite()) {
        return Err(not_finite("products of terms and target", j));
    }
    if !gram.yty.is_finite() || gram.yty < 0.0 {
        return Err(not_finite("sum of squares of the target", 0));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_unusable_statistics_are_refused_by_name() {
        assert!(check(&Gram::zeros(0)).is_err());
        assert_eq!(
            check(&Gram::zeros(2)),
            Err(SindyError::TooShort {
                needed: 1,
                found: 0
            })
        );
        let mut gram = Gram::zeros(2);
        gram.rows = 3;
        assert_eq!(check(&gram), Ok(()));
        gram.xtx[(0, 1)] = f64::NAN;
        assert!(check(&gram).unwrap_err().to_string().contains("Gram"));
        gram.xtx = nalgebra::DMatrix::zeros(3, 2);
        assert!(check(&gram).unwrap_err().to_string().contains("rows of"));
        let mut gram = Gram::zeros(2);
        gram.rows = 3;
        gram.yty = f64::INFINITY;
        assert!(check(&gram).is_err());
    }
}
