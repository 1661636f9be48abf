//! Rotors and air of one vehicle above a deck: settings and dynamics.

mod settings;

use crate::air::exponential::Exponential;
use crate::air::ground::{DeckSurface, WakeLag, rotor_force};
use crate::body::motor::Motor;
use crate::check;
use crate::error::SimError;
use crate::number::Number;

pub use crate::air::ground::Surface;
pub use settings::{GroundLaw, PlantSettings};

/// State of rotors and air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantState {
    /// x = √T, T the thrust in free air, √N.
    pub root_thrust: f64,
    /// Lagged inflow: (rotor, fountain) of the wake law; (lift ratio, unused)
    /// of the exponential law.
    pub inflow: [f64; 2],
}

/// Vertical aerodynamic forces on the vehicle, without turbulence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Force {
    /// Thrust in free air T = x², N.
    pub free_air_n: f64,
    /// Ground effect and climb damping f, N.
    pub ground_effect_n: f64,
}

impl Force {
    /// T + f, N.
    #[must_use]
    pub fn total_n(&self) -> f64 {
        self.free_air_n + self.ground_effect_n
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    WakeLag(WakeLag),
    Exponential(Exponential),
}

/// Values that are constant over a step of the integration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldPlant {
    target: [f64; 2],
    pace: [f64; 2],
    /// P u, m/s.
    pub(crate) air_mps: f64,
}

/// Model of rotors and air; its coefficients are constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    pub(crate) motor: Motor,
    pub(crate) law: Law,
    pub(crate) deck: DeckSurface,
    pub(crate) present: bool,
    weight_n: f64,
    pub(crate) rotor_height_m: f64,
    pub(crate) damping_per_root: f64,
    turbulence: f64,
    turbulence_correlation_s: f64,
}

impl Plant {
    /// Checks the settings and builds the plant.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn new(settings: &PlantSettings) -> Result<Self, SimError> {
        check::positive("mass_kg", settings.mass_kg)?;
        check::positive("gravity_mps2", settings.gravity_mps2)?;
        check::not_negative("rotor_height_m", settings.rotor_height_m)?;
        check::not_negative("climb_damping_ns_per_m", settings.climb_damping_ns_per_m)?;
        check::not_negative("turbulence", settings.turbulence)?;
        check::positive(
            "turbulence_correlation_s",
            settings.turbulence_correlation_s,
        )?;
        let weight_n = settings.weight_n();
        let motor = Motor::new(&settings.motor, weight_n).map_err(|e| e.in_section("motor"))?;
        let full_n = motor.rest(1.0) * motor.rest(1.0);
        check::that(
            weight_n < full_n,
            "mass_kg",
            &format!(
                "below {:.4} kg, the mass that full throttle lifts",
                full_n / settings.gravity_mps2
            ),
            settings.mass_kg,
        )?;
        let wake = WakeLag::new(&settings.wake())?;
        let exponential = Exponential::new(&settings.exponential, settings.ground_effect_scale)
            .map_err(|e| e.in_section("exponential"))?;
        Ok(Self {
            motor,
            law: match settings.ground_law {
                GroundLaw::WakeLag => Law::WakeLag(wake),
                GroundLaw::Exponential => Law::Exponential(exponential),
            },
            deck: DeckSurface::new(&settings.wake())?,
            present: settings.surface != Surface::Absent,
            weight_n,
            rotor_height_m: settings.rotor_height_m,
            damping_per_root: settings.climb_damping_ns_per_m / weight_n.sqrt(),
            turbulence: settings.turbulence,
            turbulence_correlation_s: settings.turbulence_correlation_s,
        })
    }

    /// The motors.
    #[must_use]
    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// Weight W, N.
    #[must_use]
    pub fn weight_n(&self) -> f64 {
        self.weight_n
    }

    /// Correlation time of the turbulence, s.
    #[must_use]
    pub fn turbulence_correlation_s(&self) -> f64 {
        self.turbulence_correlation_s
    }

    /// Steady inflow at the height z.
    #[inline]
    #[must_use]
    pub fn target(&self, height_m: f64) -> [f64; 2] {
        match &self.law {
            Law::WakeLag(law) => law.level_target(height_m + self.rotor_height_m),
            Law::Exponential(law) if self.present => [law.target(height_m), 0.0],
            Law::Exponential(_) => [0.0; 2],
        }
    }

    /// Steady state for a throttle and a height.
    #[must_use]
    pub fn rest(&self, throttle: f64, height_m: f64) -> PlantState {
        PlantState {
            root_thrust: self.motor.rest(throttle),
            inflow: self.target(height_m),
        }
    }

    /// γ: scale of the ground effect.
    #[must_use]
    pub fn ground_effect_scale(&self) -> f64 {
        match &self.law {
            Law::WakeLag(law) => law.scale(),
            Law::Exponential(law) => law.scale(),
        }
    }

    /// The same plant with another γ.
    pub(crate) fn with_ground_effect_scale(mut self, scale: f64) -> Self {
        self.law = match self.law {
            Law::WakeLag(law) => Law::WakeLag(law.with_scale(scale)),
            Law::Exponential(law) => Law::Exponential(law.with_scale(scale)),
        };
        self
    }

    /// Rate of the state. The throttle is limited to [0, 1].
    #[inline]
    #[must_use]
    pub fn derivative(&self, state: &PlantState, throttle: f64, height_m: f64) -> PlantState {
        self.rate(state, throttle, &self.held(height_m, 0.0))
    }

    /// Effect of the deck on the rotors at a height; see
    /// [`Rotors::held`](crate::body::rotors::Rotors) for four rotors.
    #[inline]
    pub(crate) fn held(&self, height_m: f64, deck_velocity_mps: f64) -> HeldPlant {
        let rotor_height_m = height_m + self.rotor_height_m;
        HeldPlant {
            target: self.target(height_m),
            pace: match &self.law {
                Law::WakeLag(law) => [
                    law.rotor_pace(rotor_height_m),
                    law.fountain_pace(rotor_height_m),
                ],
                Law::Exponential(_) => [0.0; 2],
            },
            air_mps: self.deck.upwash(rotor_height_m) * deck_velocity_mps,
        }
    }

    /// [`Self::derivative`] for a known effect of the deck.
    #[inline]
    pub(crate) fn rate(&self, state: &PlantState, throttle: f64, held: &HeldPlant) -> PlantState {
        let (x, [q1, q2]) = (state.root_thrust, state.inflow);
        let ([to1, to2], [pace1, pace2]) = (held.target, held.pace);
        PlantState {
            root_thrust: self.motor.derivative(x, throttle.clamp(0.0, 1.0)),
            inflow: match &self.law {
                Law::WakeLag(law) => [
                    law.lag_rate(q1, to1, pace1, x),
                    law.lag_rate(q2, to2, pace2, x),
                ],
                Law::Exponential(law) => [law.derivative(q1, to1), 0.0],
            },
        }
    }

    /// Lift ratio G - 1 of a state.
    #[inline]
    #[must_use]
    pub fn lift_ratio(&self, inflow: [f64; 2]) -> f64 {
        match &self.law {
            Law::WakeLag(_) => WakeLag::lift_ratio(inflow),
            Law::Exponential(_) => inflow[0],
        }
    }

    /// `T = x²` and `f = x² (G - 1) - k_v (x/√W) (v_q - P v_p)`: four times the
    /// force of one rotor, because level rotors are equal.
    #[inline]
    #[must_use]
    pub fn force(
        &self,
        state: &PlantState,
        height_m: f64,
        vehicle_velocity_mps: f64,
        deck_velocity_mps: f64,
    ) -> Force {
        let air_mps = self.air_speed(height_m, vehicle_velocity_mps, deck_velocity_mps);
        self.force_at(state, air_mps)
    }

    /// [`Self::force`] at a speed through the air.
    #[inline]
    pub(crate) fn force_at(&self, state: &PlantState, air_speed_mps: f64) -> Force {
        let x = state.root_thrust;
        let ratio = self.lift_ratio(state.inflow);
        Force {
            free_air_n: x * x,
            ground_effect_n: 4.0 * rotor_force(x, ratio, self.damping_per_root, air_speed_mps),
        }
    }

    /// v_q - P v_p: climb rate relative to the air that the deck moves.
    #[inline]
    fn air_speed(&self, height_m: f64, vehicle_velocity_mps: f64, deck_velocity_mps: f64) -> f64 {
        vehicle_velocity_mps - self.deck.upwash(height_m + self.rotor_height_m) * deck_velocity_mps
    }

    /// Standard deviation of the turbulent force in a state, N:
    /// `c_t x² (0.2 + (q1* + q2*)/0.15)`.
    #[inline]
    #[must_use]
    pub fn turbulence_sd_n(&self, state: &PlantState, height_m: f64) -> f64 {
        self.turbulence_at(state.root_thrust, self.target(height_m))
    }

    /// [`Self::turbulence_sd_n`] from the steady inflow.
    #[inline(always)]
    pub(crate) fn turbulence_at<N: Number>(&self, root_thrust: N, target: [N; 2]) -> N {
        let share = 0.2 + (target[0] + target[1]) * (1.0 / 0.15);
        self.turbulence * root_thrust * root_thrust * share
    }

    /// The steady state in which the vertical force equals the weight, and its throttle.
    /// The thrust has the relative error ε = `thrust_scale_error`, so the force is
    /// `x² (1 + ε) + f`.
    #[must_use]
    pub fn balanced(
        &self,
        height_m: f64,
        vehicle_velocity_mps: f64,
        deck_velocity_mps: f64,
        thrust_scale_error: f64,
    ) -> (PlantState, f64) {
        let inflow = self.target(height_m);
        // (1 + ε + G - 1) x² - d x - W = 0, its positive root.
        let a = 1.0 + thrust_scale_error + self.lift_ratio(inflow);
        let d = self.damping_per_root
            * self.air_speed(height_m, vehicle_velocity_mps, deck_velocity_mps);
        let x = (d + (d * d + 4.0 * a * self.weight_n).sqrt()) / (2.0 * a);
        let state = PlantState {
            root_thrust: x,
            inflow,
        };
        (state, self.motor.throttle_for(x * x))
    }
}
