//! A vehicle in vertical flight: `m v_q' = x² (1 + ε) + f + n - W`.

use crate::body::plant::{Force, Plant, PlantState};
use crate::deck::DeckPoint;
use crate::number::rk4;

/// State of rotors, air and vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VerticalState {
    /// Rotors and air.
    pub plant: PlantState,
    /// Height of the vehicle z_q above the deck's mean height, m.
    pub height_m: f64,
    /// Velocity of the vehicle v_q, m/s.
    pub velocity_mps: f64,
}

impl VerticalState {
    /// Every value is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|value| value.is_finite())
    }

    #[inline]
    fn to_array(self) -> [f64; 5] {
        let PlantState {
            root_thrust,
            inflow: [a, b],
        } = self.plant;
        [root_thrust, a, b, self.height_m, self.velocity_mps]
    }

    #[inline]
    fn from_array([root_thrust, a, b, height_m, velocity_mps]: [f64; 5]) -> Self {
        Self {
            plant: PlantState {
                root_thrust,
                inflow: [a, b],
            },
            height_m,
            velocity_mps,
        }
    }
}

/// The vertical vehicle: the plant, its mass and its thrust scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalVehicle {
    plant: Plant,
    mass_kg: f64,
    thrust_scale_error: f64,
}

impl VerticalVehicle {
    /// A vehicle of `mass_kg` whose motors give `1 + thrust_scale_error` times
    /// their nominal thrust.
    #[must_use]
    pub fn new(plant: Plant, mass_kg: f64, thrust_scale_error: f64) -> Self {
        Self {
            plant,
            mass_kg,
            thrust_scale_error,
        }
    }

    /// Rotors and air.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// In relative rest `height_m` above the deck, with forces in balance and
    /// the air at rest; and the throttle that holds it.
    #[must_use]
    pub fn balanced(&self, height_m: f64, deck: DeckPoint) -> (VerticalState, f64) {
        let (plant, throttle) = self.plant.balanced(
            height_m,
            deck.velocity_mps,
            deck.velocity_mps,
            self.thrust_scale_error,
        );
        let state = VerticalState {
            plant,
            height_m: deck.height_m + height_m,
            velocity_mps: deck.velocity_mps,
        };
        (state, throttle)
    }

    /// Aerodynamic force in a state, without turbulence.
    #[inline]
    #[must_use]
    pub fn force(&self, state: &VerticalState, deck: DeckPoint) -> Force {
        self.plant.force(
            &state.plant,
            state.height_m - deck.height_m,
            state.velocity_mps,
            deck.velocity_mps,
        )
    }

    /// dv_q/dt, m/s², with the turbulent force `turbulence_n`.
    #[inline]
    #[must_use]
    pub fn acceleration_mps2(
        &self,
        state: &VerticalState,
        deck: DeckPoint,
        turbulence_n: f64,
    ) -> f64 {
        self.accelerated(self.force(state, deck), turbulence_n)
    }

    /// One Runge–Kutta step of `dt`; `deck` is the deck at the start, the
    /// middle and the end of the step.
    ///
    /// Where the inflow goes, how fast, and the upwash are held within the step, as
    /// they are in its middle; see [`RigidVehicle::step`](crate::body::rigid::RigidVehicle::step).
    #[inline]
    pub fn step(
        &self,
        state: &mut VerticalState,
        deck: &[DeckPoint; 3],
        throttle: f64,
        turbulence_n: f64,
        dt: f64,
    ) {
        let middle = state.height_m + 0.5 * dt * state.velocity_mps - deck[1].height_m;
        let held = self.plant.held(middle, deck[1].velocity_mps);
        let next = rk4::step(&state.to_array(), dt, |_, y| {
            let state = VerticalState::from_array(*y);
            let air_mps = state.velocity_mps - held.air_mps;
            let force = self.plant.force_at(&state.plant, air_mps);
            VerticalState {
                plant: self.plant.rate(&state.plant, throttle, &held),
                height_m: state.velocity_mps,
                velocity_mps: self.accelerated(force, turbulence_n),
            }
            .to_array()
        });
        *state = VerticalState::from_array(next);
    }

    #[inline]
    fn accelerated(&self, force: Force, turbulence_n: f64) -> f64 {
        let lift_n = force.total_n() + self.thrust_scale_error * force.free_air_n;
        (lift_n + turbulence_n - self.plant.weight_n()) / self.mass_kg
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::plant::PlantSettings;

    #[test]
    fn analytic_balanced_start_stays() {
        for settings in [PlantSettings::default(), PlantSettings::exponential()] {
            let plant = Plant::new(&settings).expect("defaults are valid");
            let vehicle = VerticalVehicle::new(plant, settings.mass_kg, -0.02);
            let deck = DeckPoint::default();
            let (start, throttle) = vehicle.balanced(0.2, deck);
            // Balance is solved in closed form: rounding only.
            assert!(vehicle.acceleration_mps2(&start, deck, 0.0).abs() < 1e-12);
            let mut state = start;
            for _ in 0..100 {
                vehicle.step(&mut state, &[deck; 3], throttle, 0.0, 0.001);
            }
            assert!((state.height_m - start.height_m).abs() < 1e-12);
        }
    }

    #[test]
    fn analytic_free_fall_without_rotors() {
        // Far from any surface, rotors stopped: z = -g t²/2, exact for RK4.
        let settings = PlantSettings {
            surface: crate::body::plant::Surface::Absent,
            ..PlantSettings::default()
        };
        let plant = Plant::new(&settings).expect("valid settings");
        let vehicle = VerticalVehicle::new(plant, settings.mass_kg, 0.0);
        let mut state = VerticalState {
            height_m: 100.0,
            ..VerticalState::default()
        };
        for _ in 0..1000 {
            vehicle.step(&mut state, &[DeckPoint::default(); 3], 0.0, 0.0, 0.001);
        }
        // 1000 additions near 100: 1000 ulp of 1.4e-14.
        assert!((state.height_m - (100.0 - 4.905)).abs() < 1e-10);
        assert!((state.velocity_mps + 9.81).abs() < 1e-10);
    }
}
