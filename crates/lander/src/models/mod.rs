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
    /// The models identified from the virtual rig's rich data (seed 1) at half of the paper's
    /// ground effect, which is about what measured quadrotors show. `fitted.rs` names the command.
    fn default() -> Self {
        Self::fitted(&fitted::MEASURED)
    }
}

impl<R: Real> FlightModels<R> {
    /// The same at the paper's ground effect.
    #[must_use]
    pub fn paper() -> Self {
        Self::fitted(&fitted::PAPER)
    }

    fn fitted(of: &fitted::GroundEffect) -> Self {
        // One by one: a loop over the constants would convert them in flight, in double
        // precision.
        let [one, x, s, s2, x3, s3, exp_neg_x_s, sin_x_s] = fitted::THRUST;
        let [h0, h1, h2, h3] = of.h;
        let [k0, k1] = of.k;
        let thrust = Library {
            one: r(one),
            x: r(x),
            s: r(s),
            s2: r(s2),
            x3: r(x3),
            s3: r(s3),
            exp_neg_x_s: r(exp_neg_x_s),
            sin_x_s: r(sin_x_s),
        };
        let lag = Lag {
            map: StaticMap::new([r(h0), r(h1), r(h2), r(h3)]),
            k: [r(k0), r(k1)],
            tau_s: r(of.tau_s),
        };
        Self {
            thrust: ThrustModel::Library(thrust),
            mu: r(of.mu),
            dynamic: Guarded {
                model: GroundEffectModel::Lag(lag),
                validity: Validity::default(),
                velocity: VelocityInput::NegativeRelative,
            },
        }
    }
}
