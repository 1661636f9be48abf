//! The Python module `sindy._native`: what the package `sindy` calls.
//!
//! It converts between NumPy and the library, and nothing else: no numerics, no defaults of its own. Structured values
//! (settings, solvers, what an identification says of itself) cross as JSON, arrays as arrays.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `error` | errors of the library as Python exceptions |
//! | `run` | long calls: without the interpreter's lock, with Ctrl-C, with a number of threads |
//! | `arrays` | NumPy arrays as a source of blocks, read where they are |
//! | `library` | candidate terms |
//! | `solver` | sparse solvers from their description |
//! | `derivative` | methods of differentiation from their description |
//! | `slopes` | smoothed states and slopes |
//! | `weak` | the statistics of the weak form |
//! | `bootstrap` | intervals of coefficients and bands by resampling |
//! | `fit` | the automatic call, and fits by a given solver |
//! | `field` | partial differential equations from fields |
//! | `gram` | the statistics of rows: accumulated, merged, pickled, solved, searched for the best subsets |
//! | `partial` | partial sums of the automatic call: added file by file, merged, pickled, ended |
//! | `model` | models: predict, simulate, write |
//! | `touchdown` | trials, identification, model cards, landings, campaigns, the paper's experiments |

#![expect(
    clippy::needless_pass_by_value,
    reason = "PyO3 hands most arguments over by value"
)]

mod arrays;
mod bootstrap;
mod derivative;
mod error;
mod field;
mod fit;
mod gram;
mod horseshoe;
mod library;
mod model;
mod partial;
mod run;
mod slopes;
mod solver;
mod touchdown;
mod weak;

use pyo3::prelude::*;

/// The module.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::bootstrap::{
        band_of_iterations, band_of_predictions, band_of_runs, bootstrap_columns, bootstrap_slopes,
    };
    #[pymodule_export]
    use crate::field::{FieldEquations, identify_fields};
    #[pymodule_export]
    use crate::fit::{fit_columns, fit_slopes, identify};
    #[pymodule_export]
    use crate::gram::Gram;
    #[pymodule_export]
    use crate::horseshoe::sample_horseshoe;
    #[pymodule_export]
    use crate::library::Library;
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::partial::PartialSums;
    #[pymodule_export]
    use crate::slopes::slopes;
    #[pymodule_export]
    use crate::touchdown::campaign::{
        campaign_begin, campaign_blocks, campaign_fly, campaign_read, campaign_report,
        campaign_status,
    };
    #[pymodule_export]
    use crate::touchdown::card::Card;
    #[pymodule_export]
    use crate::touchdown::commanded::Commanded;
    #[pymodule_export]
    use crate::touchdown::identify::{identify_ground_effect, identify_thrust};
    #[pymodule_export]
    use crate::touchdown::land::{SpaceLandings, land_in_space};
    #[pymodule_export]
    use crate::touchdown::policy::Policy;
    #[pymodule_export]
    use crate::touchdown::reproduce::reproduce;
    #[pymodule_export]
    use crate::touchdown::space::Space;
    #[pymodule_export]
    use crate::touchdown::trial::Trial;
    #[pymodule_export]
    use crate::touchdown::validate::validate;
    #[pymodule_export]
    use crate::touchdown::vertical::{VerticalLandings, land_vertically};
    #[pymodule_export]
    use crate::weak::weak;

    use super::{Bound, PyModule, PyModuleMethods, PyResult};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("HEAD_ROWS", sindy::identify::stream::HEAD_ROWS)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
