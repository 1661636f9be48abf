//! Candidate terms.

use pyo3::prelude::*;

use crate::error;

/// Candidate terms over named variables.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Library {
    pub(crate) terms: sindy::Library,
}

#[pymethods]
impl Library {
    /// The library of a text such as `poly(3) + fourier(2)*u`, over these variables.
    #[staticmethod]
    fn specification(text: &str, variables: Vec<String>) -> PyResult<Self> {
        let terms = sindy::Library::specification(text, &variables);
        let terms = terms.map_err(|e| error::of(&e))?;
        Ok(Self { terms })
    }

    /// The library of these expressions.
    #[staticmethod]
    fn of_terms(terms: Vec<String>) -> PyResult<Self> {
        let terms = sindy::Library::parse(&terms).map_err(|e| error::of(&e))?;
        Ok(Self { terms })
    }

    /// The terms as text.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.terms.names().to_vec()
    }

    /// The terms in LaTeX.
    fn to_latex(&self) -> Vec<String> {
        self.terms.to_latex()
    }

    /// The variables that occur.
    #[getter]
    fn variables(&self) -> Vec<String> {
        self.terms.variables()
    }

    fn __len__(&self) -> usize {
        self.terms.len()
    }
}
