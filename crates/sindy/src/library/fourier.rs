//! Sines and cosines.

use super::functions::{apply, scaled};
use super::{Library, check_terms, check_variables};
use crate::error::{SindyError, require};

impl Library {
    /// Sines and cosines of whole multiples of each variable, by rising frequency:
    /// `sin(x), cos(x), sin(y), cos(y), sin(2*x), …`.
    ///
    /// # Errors
    /// No variables, a name that is empty or occurs twice, no frequency, or more than [`super::MAX_TERMS`]
    /// terms.
    pub fn fourier<S: AsRef<str>>(variables: &[S], frequencies: usize) -> Result<Self, SindyError> {
        Self::fourier_of_base(variables, frequencies, 1.0)
    }

    /// Sines and cosines of `k ω x`, k = 1 … `frequencies`, with the angular base frequency ω = `base`
    /// (radians per unit of the variable). Multiples are rounded to 15 digits, so that 3 times 0.1 is 0.3.
    ///
    /// ```
    /// use sindy::Library;
    /// let library = Library::fourier_of_base(&["x"], 2, 0.5)?;
    /// assert_eq!(library.names(), ["sin(0.5*x)", "cos(0.5*x)", "sin(x)", "cos(x)"]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Library::fourier`]; a base that is not positive, or of which a multiple is not finite.
    pub fn fourier_of_base<S: AsRef<str>>(
        variables: &[S],
        frequencies: usize,
        base: f64,
    ) -> Result<Self, SindyError> {
        check_variables(variables)?;
        require(frequencies != 0, "frequencies", "at least 1", 0)?;
        require(
            base > 0.0 && (base * frequencies as f64).is_finite(),
            "base",
            "a positive number with finite multiples",
            base,
        )?;
        check_terms(frequencies.checked_mul(2 * variables.len()))?;
        let mut terms = Vec::new();
        for k in 1..=frequencies {
            let frequency = base * k as f64;
            // Fifteen digits survive writing and reading in every case.
            let frequency = format!("{frequency:.14e}").parse().unwrap_or(frequency);
            for name in variables {
                let angle = scaled(frequency, name.as_ref());
                terms.push(apply("sin(v)", &angle)?);
                terms.push(apply("cos(v)", &angle)?);
            }
        }
        Ok(Self::of(terms))
    }
}
