//! The forms that a fit was chosen from, with their errors on held-out parts.

use serde::Serialize;

use crate::settings::ThrustForm;

/// A form that was tried, and how it predicts parts that it has not seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormScore {
    /// The form.
    pub form: &'static str,
    /// Whether it has a lag.
    pub lag: bool,
    /// Whether it has a term of the battery's voltage.
    pub battery: bool,
    /// Coefficients, with lag and dead time.
    pub parameters: usize,
    /// Root mean square error on held-out parts (N); null where it could not be fitted.
    pub held_out_rmse_n: Option<f64>,
    /// Its standard error over the parts (N).
    pub std_error_n: Option<f64>,
    /// Whether it was chosen.
    pub chosen: bool,
    /// Why it could not be fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl FormScore {
    /// The form with what it has beside it: `static_sqrt with lag and battery`.
    #[must_use]
    pub fn name(&self) -> String {
        let lag = self.lag && self.form == ThrustForm::StaticSqrt.name();
        let with = match (lag, self.battery) {
            (false, false) => "",
            (true, false) => " with lag",
            (false, true) => " with battery",
            (true, true) => " with lag and battery",
        };
        format!("{}{with}", self.form)
    }
}
