//! Exponentials and bounded rational functions.

use sindy_expr::Expr;

use super::{Library, check_terms, check_variables, parse};
use crate::error::{SindyError, require};

impl Library {
    /// Decaying exponentials `exp(-r x)` of each variable, for each rate r (per unit of the variable; a
    /// negative rate grows).
    ///
    /// ```
    /// use sindy::Library;
    /// let library = Library::exponentials(&["x", "y"], &[1.0, 2.5])?;
    /// assert_eq!(library.names(), ["exp(-x)", "exp(-y)", "exp(-2.5*x)", "exp(-2.5*y)"]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// No variables, a name that is empty or occurs twice, no rates, a rate that is 0, not finite or occurs
    /// twice, or more than [`super::MAX_TERMS`] terms.
    pub fn exponentials<S: AsRef<str>>(variables: &[S], rates: &[f64]) -> Result<Self, SindyError> {
        check_variables(variables)?;
        check_numbers(
            "rates",
            "distinct finite numbers other than 0",
            rates,
            |r| r.is_finite() && r != 0.0,
        )?;
        check_terms(rates.len().checked_mul(variables.len()))?;
        let mut terms = Vec::new();
        for rate in rates {
            for name in variables {
                terms.push(apply("exp(v)", &scaled(-rate, name.as_ref()))?);
            }
        }
        Ok(Self::of(terms))
    }

    /// Bounded rational functions `1/(1 + (x/s)^2)^p` of each variable, for each scale s (in the variable's
    /// unit) and power p: 1 at 0, ½ at x = s for p = 1, falling as `x^(-2p)`, and between 0 and 1 for every
    /// finite x. Multiplied by polynomials they make the odd and the rising ones.
    ///
    /// ```
    /// use sindy::Library;
    /// let library = Library::bounded_rationals(&["z"], &[0.1], &[1, 2])?;
    /// assert_eq!(library.names(), ["1/(1 + (z/0.1)^2)", "1/(1 + (z/0.1)^2)^2"]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// No variables, a name that is empty or occurs twice, no scales or powers, a scale that is not positive and
    /// finite, a power of 0 or above 64, one that occurs twice, or more than [`super::MAX_TERMS`] terms.
    pub fn bounded_rationals<S: AsRef<str>>(
        variables: &[S],
        scales: &[f64],
        powers: &[u32],
    ) -> Result<Self, SindyError> {
        check_variables(variables)?;
        check_numbers("scales", "distinct positive finite numbers", scales, |s| {
            s.is_finite() && s > 0.0
        })?;
        let whole: Vec<f64> = powers.iter().map(|&p| f64::from(p)).collect();
        check_numbers(
            "powers",
            "distinct whole numbers from 1 to 64",
            &whole,
            |p| (1.0..=64.0).contains(&p),
        )?;
        let count = scales.len().checked_mul(powers.len());
        check_terms(count.and_then(|n| n.checked_mul(variables.len())))?;
        let one = Expr::constant(1.0);
        let mut terms = Vec::new();
        for &scale in scales {
            for &power in powers {
                for name in variables {
                    let mut ratio = Expr::variable(name.as_ref());
                    if scale != 1.0 {
                        ratio = ratio / Expr::constant(scale);
                    }
                    let mut below = &one + &ratio.powi(2);
                    if power > 1 {
                        below = below.pow(&Expr::constant(f64::from(power)));
                    }
                    terms.push(&one / &below);
                }
            }
        }
        Ok(Self::of(terms))
    }
}

/// Refuses an empty list, numbers that do not pass `good`, and numbers that occur twice.
fn check_numbers(
    key: &'static str,
    expected: &str,
    numbers: &[f64],
    good: impl Fn(f64) -> bool,
) -> Result<(), SindyError> {
    require(!numbers.is_empty(), key, expected, "none")?;
    check_terms(Some(numbers.len()))?;
    let twice = |(i, n): &(usize, &f64)| numbers[..*i].contains(n);
    let bad = |(i, n): &(usize, &f64)| !good(**n) || twice(&(*i, *n));
    match numbers.iter().enumerate().find(bad) {
        Some((_, number)) => Err(SindyError::setting(key, expected, number)),
        None => Ok(()),
    }
}

/// A number times a variable, without needless ones.
pub(super) fn scaled(number: f64, name: &str) -> Expr {
    let variable = Expr::variable(name);
    match number {
        1.0 => variable,
        -1.0 => -variable,
        _ => Expr::constant(number) * variable,
    }
}

/// The function of one argument `v` that the text names, applied to an expression.
pub(super) fn apply(function: &str, argument: &Expr) -> Result<Expr, SindyError> {
    Ok(parse(function)?.substitute("v", argument))
}
