//! A controller and a simple vehicle for the tests.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test file uses its own part"
)]

pub mod recorded;

use touchdown_flight::control::{Composite, Law};
use touchdown_flight::ground_effect::{
    GroundEffectModel, Guarded, Lag, Ratio, StaticMap, Validity,
};
use touchdown_flight::reference::{Exponential, Reference};
use touchdown_flight::thrust::ThrustModel;
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_flight::{Limits, Measurement, Real};

pub const MASS_KG: f64 = 1.37;
pub const GRAVITY: f64 = 9.81;
pub const WEIGHT_N: f64 = MASS_KG * GRAVITY;

/// A lag model identified on a virtual rig.
pub fn lag<R: Real>() -> GroundEffectModel<R> {
    GroundEffectModel::Lag(Lag {
        map: map(),
        k: [-0.0353, 0.1067].map(R::from_f64),
        tau_s: R::from_f64(0.162),
    })
}

/// A derivative model of the ratio identified on a virtual rig.
pub fn ratio<R: Real>() -> GroundEffectModel<R> {
    GroundEffectModel::Ratio(Ratio::new(
        [
            -0.0311, -3.7681, 0.1613, 0.4663, 0.1354, 0.1646, -0.0047, 1.2235, -0.5224,
        ]
        .map(R::from_f64),
    ))
}

/// The lag model's map of height.
pub fn map<R: Real>() -> StaticMap<R> {
    StaticMap::new([-0.00901, 0.04948, 0.12176, 0.03698].map(R::from_f64))
}

/// The published thrust model, the ground landing's descent, and a method.
pub fn vertical_controller<R: Real>(ground_effect: GroundEffectModel<R>) -> VerticalController<R> {
    VerticalController {
        mass_kg: R::from_f64(MASS_KG),
        gravity_mps2: R::from_f64(GRAVITY),
        law: Law::Composite(Composite::default()),
        reference: Reference::Exponential(Exponential {
            c_per_s: R::from_f64(0.7073),
            start_height_m: R::from_f64(0.8),
            end_height_m: R::ZERO,
        }),
        thrust: ThrustModel::published(),
        ground_effect: Guarded::new(ground_effect, Validity::default()),
        deck: None,
        limits: Limits::default(),
    }
}

/// A measurement in double precision, in another one.
pub fn convert<R: Real>(m: &Measurement<f64>) -> Measurement<R> {
    Measurement {
        height_m: R::from_f64(m.height_m),
        relative_velocity_mps: R::from_f64(m.relative_velocity_mps),
        vehicle_velocity_mps: R::from_f64(m.vehicle_velocity_mps),
        acceleration_mps2: R::from_f64(m.acceleration_mps2),
    }
}
