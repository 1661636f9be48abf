//! Signs that coefficients must have: a term whose estimate breaks its sign is left out.
//!
//! ```text
//! min over S, ξ_S   |y - Θ_S ξ_S|²,   |S| ≤ s,   ξ_j of the sign σ_j where one is given
//! ```
//!
//! At its minimum no coefficient of the support is at a bound, so ξ_S is ordinary least squares on S. The constrained problem
//! is therefore that of the best subset among those whose least-squares estimate keeps all signs.

use crate::error::SindyError;
use crate::solve::fit::Fit;
use crate::statistics::gram::Gram;

/// The sign that a coefficient must have if it is not zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sign {
    /// Either.
    #[default]
    Any,
    /// Above 0.
    Positive,
    /// Below 0.
    Negative,
}

impl Sign {
    /// Whether a coefficient may have this value; zero is a term that is left out.
    ///
    /// ```
    /// use sindy::solve::Sign;
    /// assert!(Sign::Negative.allows(-0.1) && Sign::Negative.allows(0.0) && !Sign::Negative.allows(0.1));
    /// assert!(Sign::Any.allows(0.1));
    /// ```
    #[must_use]
    pub fn allows(self, coefficient: f64) -> bool {
        match self {
            Self::Any => true,
            Self::Positive => coefficient >= 0.0,
            Self::Negative => coefficient <= 0.0,
        }
    }
}

/// Whether any sign is given.
pub(crate) fn is_constrained(signs: &[Sign]) -> bool {
    signs.iter().any(|s| *s != Sign::Any)
}

/// The coefficients that break their sign; no signs are as many that allow anything.
pub(crate) fn broken<'a>(
    signs: &'a [Sign],
    coefficients: &'a [f64],
) -> impl Iterator<Item = usize> + 'a {
    let pairs = signs.iter().zip(coefficients).enumerate();
    pairs.filter(|(_, (s, c))| !s.allows(**c)).map(|(j, _)| j)
}

/// Refuses signs that are neither none nor one for each term.
pub(crate) fn check(signs: &[Sign], terms: usize) -> Result<(), SindyError> {
    if signs.is_empty() || signs.len() == terms {
        return Ok(());
    }
    let what = "signs (none, or one per term)";
    Err(SindyError::shape(what, terms, signs.len()))
}

/// The fit without terms that break their sign: the one that contributes most goes first, the others are fitted again, until
/// all signs are kept.
pub(crate) fn kept(gram: &Gram, mut fit: Fit, signs: &[Sign]) -> Fit {
    let rms = gram.column_rms();
    loop {
        let part = |j: &usize| (fit.coefficients[*j] * rms[*j]).abs();
        let worst =
            broken(signs, fit.coefficients.as_slice()).max_by(|a, b| part(a).total_cmp(&part(b)));
        let Some(worst) = worst else { return fit };
        let mut support = fit.support.clone();
        support[worst] = false;
        fit = Fit::on_support(gram, support, fit.outcome, fit.iterations);
    }
}
