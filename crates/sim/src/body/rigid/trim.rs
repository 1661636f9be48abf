//! Hover in steady wind.

use super::{RigidState, RigidVehicle};
use crate::deck::rigid::DeckPose;
use crate::number::vector::{add, dot, scale};

/// Halvings of a quarter turn: the tilt is then exact to rounding.
const HALVINGS: usize = 60;

impl RigidVehicle {
    /// Tilt at which gravity balances the drag of a horizontal wind, rad:
    ///
    /// ```text
    /// W sin α = (c_1 + c_2 V cos α) V cos α
    /// ```
    ///
    /// Drag acts in the rotors' plane, so the thrust of this hover is `W cos α`.
    #[must_use]
    pub fn trim_tilt_rad(&self, air_mps: f64) -> f64 {
        let weight_n = self.mass_kg * self.gravity_mps2;
        let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
        for _ in 0..HALVINGS {
            let tilt = 0.5 * (low + high);
            let through = air_mps * tilt.cos();
            let drag_n = (self.body.drag_ns_per_m + self.body.drag_ns2_per_m2 * through) * through;
            if weight_n * tilt.sin() < drag_n {
                low = tilt;
            } else {
                high = tilt;
            }
        }
        0.5 * (low + high)
    }

    /// [`Self::balanced`], leaned into the air that passes it so that the vehicle keeps its
    /// velocity, that of the deck. Without such air it is that state to the bit.
    #[must_use]
    pub fn trimmed(&self, height_m: f64, deck: &DeckPose, wind_mps: [f64; 3]) -> (RigidState, f64) {
        let (mut state, throttle) = self.balanced(height_m, deck);
        let [x, y, _] = wind_mps;
        let air = [x - state.velocity_mps[0], y - state.velocity_mps[1]];
        let speed_mps = air[0].hypot(air[1]);
        if speed_mps <= 0.0 {
            return (state, throttle);
        }
        let tilt = self.trim_tilt_rad(speed_mps);
        // The thrust leans against the wind w: turned from e_z about w × e_z.
        let (sin, cos) = (0.5 * tilt).sin_cos();
        let [along, across] = air.map(|component| component / speed_mps);
        state.attitude = [cos, sin * across, -sin * along, 0.0];
        let root = tilt.cos().sqrt();
        for x in &mut state.rotors.root_thrust {
            *x *= root;
        }
        let places = self.places(&state, deck, [0.0; 3]);
        let target = self.rotors.target(&state.rotors.root_thrust, &places);
        state.rotors.inflow = target.inflow;
        state.rotors.fountain = target.fountain;
        let x = state.rotors.root_thrust[0];
        (state, self.rotors.plant().motor().throttle_for(x * x))
    }

    /// A trimmed state that leans further, so that it has a horizontal acceleration a: thrust and weight change by `m a`. The
    /// drag changes with the tilt; that is left out.
    #[must_use]
    pub fn following(
        &self,
        (mut state, throttle): (RigidState, f64),
        a: [f64; 3],
    ) -> (RigidState, f64) {
        let [x, y, _] = a;
        if x.hypot(y) <= 0.0 {
            return (state, throttle);
        }
        // Each root is that of the whole thrust.
        let before_n = 0.25 * state.rotors.root_thrust.iter().map(|x| x * x).sum::<f64>();
        let up = state.axes()[2];
        let along = [x, y, 0.0].map(|a| self.mass_kg * a);
        let thrust = add(scale(up, before_n), along);
        let after_n = dot(thrust, thrust).sqrt();
        // The shortest turn from the body's axis e_z of a level vehicle to the thrust.
        let [u, v, w] = scale(thrust, 1.0 / after_n);
        let c = (0.5 * (1.0 + w)).sqrt();
        state.attitude = [c, -0.5 * v / c, 0.5 * u / c, 0.0];
        let root = (after_n / before_n).sqrt();
        for x in &mut state.rotors.root_thrust {
            *x *= root;
        }
        let x = state.rotors.root_thrust[0];
        (state, self.rotors.plant().motor().throttle_for(x * x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::BodySettings;
    use crate::body::plant::PlantSettings;
    use crate::body::rigid::Disturbance;

    fn vehicle() -> RigidVehicle {
        RigidVehicle::new(&PlantSettings::default(), &BodySettings::default()).unwrap()
    }

    #[test]
    fn analytic_trim_tilt_balances_drag_and_weight() {
        // c_1 V + c_2 V² alone, as if the drag were horizontal: 0.39 rad at 10 m/s. In the
        // rotors' plane the air is slower by cos α, and the tilt a little less.
        for air_mps in [4.0_f64, 10.0, 15.0] {
            let horizontal = ((0.35 + 0.02 * air_mps) * air_mps / 13.4397).atan();
            let tilt = vehicle().trim_tilt_rad(air_mps);
            let through = air_mps * tilt.cos();
            let drag_n = (0.35 + 0.02 * through) * through;
            // The root is exact to rounding.
            assert!((13.4397 * tilt.sin() - drag_n).abs() < 1e-12, "{air_mps}");
            assert!(tilt < horizontal && tilt > 0.93 * horizontal, "{tilt}");
        }
    }

    #[test]
    fn analytic_a_trimmed_vehicle_does_not_accelerate() {
        let vehicle = vehicle();
        let deck = DeckPose::default();
        for wind_mps in [[7.0, 0.0, 0.0], [-4.0, 9.0, 0.0], [0.0, -12.0, 0.0]] {
            // Far above the deck: ground effect below a millionth of the weight.
            let (state, _) = vehicle.trimmed(50.0, &deck, wind_mps);
            let disturbance = Disturbance {
                wind_mps,
                ..Disturbance::default()
            };
            let loads = vehicle.loads(&state, &deck, &disturbance);
            for k in 0..3 {
                let a = loads.acceleration_mps2[k];
                assert!(a.abs() < 1e-4, "{wind_mps:?}: {a}");
            }
        }
    }

    #[test]
    fn analytic_a_following_vehicle_has_the_acceleration_of_its_deck() {
        let vehicle = vehicle();
        let wanted = [0.8, -1.5, 0.0];
        let deck = DeckPose::default();
        let still = vehicle.trimmed(50.0, &deck, [0.0; 3]);
        let (state, _) = vehicle.following(still, wanted);
        let loads = vehicle.loads(&state, &deck, &Disturbance::default());
        for k in 0..3 {
            // The inflow is that of the hover before, which changes the thrust by less.
            assert!(
                (loads.acceleration_mps2[k] - wanted[k]).abs() < 1e-3,
                "{:?}",
                loads.acceleration_mps2
            );
        }
        assert_eq!(vehicle.following(still, [0.0; 3]), still);
    }

    #[test]
    fn prop_without_wind_the_start_is_balanced_to_the_bit() {
        let (vehicle, deck) = (vehicle(), DeckPose::default());
        let trimmed = vehicle.trimmed(0.8, &deck, [0.0; 3]);
        assert_eq!(trimmed, vehicle.balanced(0.8, &deck));
    }
}
