//! The fitted models that the controllers use by default.

mod fitted;

use touchdown_flight::ground_effect::{
    GroundEffectModel, Guarded, Lag, StaticMap, Validity, VelocityInput,
};
use touchdown_flight::real::{Real, r};
use touchdown_flight::thrust::{Library, ThrustModel};

/// Fitted models of thrust and ground effect for the controllers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct FlightModels<R: Real> {
    /// Throttle to thrust.
    pub thrust: ThrustModel<R>,
    /// μ of eq. (2), for `empirical`.
    pub mu: R,
    /// The dynamic model, for `dynamic` and `dynamic+observer`.
    pub dynamic: Guarded<R>,
}

impl<R: Real> Default for FlightModels<R> {
    /// The models identified from the virtual rig's rich data of the default plant
    /// (seed 1). `fitted.rs` names the command.
    fn default() -> Self {
        let lag = Lag {
            map: StaticMap::new(fitted::LAG_H.map(r)),
            k: fitted::LAG_K.map(r),
            tau_s: r(fitted::LAG_TAU_S),
        };
        Self {
            thrust: ThrustModel::Library(Library::from_array(fitted::THRUST.map(r))),
            mu: r(fitted::MU),
            dynamic: Guarded {
                model: GroundEffectModel::Lag(lag),
                validity: Validity::default(),
                velocity: VelocityInput::NegativeRelative,
            },
        }
    }
}
