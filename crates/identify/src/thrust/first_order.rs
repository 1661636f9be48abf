//! Eq. (7): one lag for `x = √T`.

use touchdown_trial::Trial;

use super::output_error::{LagFit, LagForm};
use crate::error::Result;
use crate::fitted::{FittedCard, Origin};
use crate::settings::{IdentificationSettings, ThrustForm};

/// Eq. (7): `x' = (c0 s + c1 - x)/T_m`, with a dead time before the throttle where the data show one, by output error.
///
/// # Errors
/// Missing channels, times that count rows, or too few unbroken data.
pub fn first_order(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let form = LagForm {
        form: ThrustForm::FirstOrder,
        degree: 1,
        battery: settings.thrust.battery,
    };
    LagFit::new(trials, settings, form)?.card(trials, origin)
}
