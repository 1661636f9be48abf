//! Vehicle and method as the caller states them.

use touchdown_flight::SettingsError;
use touchdown_flight::error::{positive, within};
use touchdown_flight::method::Method;
use touchdown_flight::thrust::LEAST_THRUST_TO_WEIGHT;
use touchdown_lander::settings::VehicleNumbers;

use crate::error::td_error;
use crate::numbers::numbered;
use crate::refusal::Refusal;

/// The vehicle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_vehicle {
    /// Mass, kg.
    pub mass_kg: f32,
    /// Acceleration of gravity, m/s^2.
    pub gravity_mps2: f32,
    /// Radius of a rotor, m.
    pub rotor_radius_m: f32,
    /// Greatest thrust of all rotors in free air, N.
    pub greatest_thrust_n: f32,
}

/// A method of landing. The last two need an inertial unit: the landing computer alone has them.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_method {
    /// Feedback without a model of the ground effect.
    Feedback = 0,
    /// The empirical law of height is fed forward.
    Empirical = 1,
    /// The identified dynamic model is fed forward.
    Dynamic = 2,
    /// Internal-model control, for a deck of known period.
    Imbc = 3,
    /// Smooth sliding control.
    Ssc = 4,
    /// A disturbance observer in place of a model.
    Observer = 5,
    /// The dynamic model and a disturbance observer.
    DynamicObserver = 6,
}

impl td_vehicle {
    pub(crate) fn standard() -> Self {
        let numbers = VehicleNumbers::default();
        Self {
            mass_kg: numbers.mass_kg,
            gravity_mps2: numbers.gravity_mps2,
            rotor_radius_m: numbers.rotor_radius_m,
            greatest_thrust_n: numbers.greatest_thrust_n,
        }
    }

    /// Weight, N.
    pub(crate) fn weight_n(&self) -> f32 {
        self.mass_kg * self.gravity_mps2
    }

    /// Checks that the vehicle has a weight, and a thrust that carries it.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        positive("vehicle.mass_kg", self.mass_kg)?;
        positive("vehicle.gravity_mps2", self.gravity_mps2)?;
        let share = f64::from(self.greatest_thrust_n) / f64::from(self.weight_n());
        within(
            "vehicle.greatest_thrust_n",
            self.greatest_thrust_n,
            share >= LEAST_THRUST_TO_WEIGHT,
            "at least 1.3 times the weight, mass_kg times gravity_mps2",
        )
    }

    pub(crate) fn numbers(&self) -> VehicleNumbers<f32> {
        VehicleNumbers {
            mass_kg: self.mass_kg,
            gravity_mps2: self.gravity_mps2,
            rotor_radius_m: self.rotor_radius_m,
            greatest_thrust_n: self.greatest_thrust_n,
        }
    }
}

numbered!(td_method: Feedback, Empirical, Dynamic, Imbc, Ssc, Observer, DynamicObserver);

/// The method of a [`td_method`].
pub(crate) fn method(number: u32) -> Result<Method, Refusal> {
    let unknown = |_| Refusal::unknown("method", "a constant of td_method", number);
    Ok(match td_method::of(number).map_err(unknown)? {
        td_method::Feedback => Method::Feedback,
        td_method::Empirical => Method::Empirical,
        td_method::Dynamic => Method::Dynamic,
        td_method::Imbc => Method::Imbc,
        td_method::Ssc => Method::Ssc,
        td_method::Observer => Method::Observer,
        td_method::DynamicObserver => Method::DynamicObserver,
    })
}
