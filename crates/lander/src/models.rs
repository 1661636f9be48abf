//! The models that controllers count on.

use touchdown_flight::Real;
use touchdown_flight::ground_effect::{
    GroundEffectModel, Guarded, Lag, StaticMap, Validity, VelocityInput,
};
use touchdown_flight::thrust::{Library, ThrustModel};

/// The models that controllers count on, as identified beforehand.
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
    /// As `touchdown identify` finds them on the virtual rig's rich data of the
    /// default plant (seed 1).
    fn default() -> Self {
        let lag = Lag {
            map: StaticMap::new([-0.007_458, 0.041_323, 0.130_612, 0.031_397].map(R::from_f64)),
            k: [-0.035_058, 0.103_208].map(R::from_f64),
            tau_s: R::from_f64(0.176_759),
        };
        Self {
            thrust: ThrustModel::Library(Library::from_array(
                [
                    7.134_375,
                    -11.427_189,
                    112.592_380,
                    -55.082_173,
                    -0.119_445,
                    0.836_960,
                    -56.642_801,
                    2.049_671,
                ]
                .map(R::from_f64),
            )),
            mu: R::from_f64(1.958),
            dynamic: Guarded {
                model: GroundEffectModel::Lag(lag),
                validity: Validity::default(),
                velocity: VelocityInput::NegativeRelative,
            },
        }
    }
}
