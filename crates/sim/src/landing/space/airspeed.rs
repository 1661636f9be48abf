//! The air in which a vehicle can land, and that of a scenario.

use super::belief::thrust_to_weight;
use super::scenario::SpaceScenario;
use crate::error::SimError;

/// Share of the greatest thrust that weight and drag may need: a tenth is left for the landing.
pub const THRUST_SHARE: f64 = 0.9;

/// Airspeeds up to which a vehicle can land, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airspeeds {
    /// At which weight W and horizontal drag D need [`THRUST_SHARE`] of the greatest thrust:
    /// `√(W² + D²) = 0.9 T_max`. Giving up in more air is right.
    pub thrust_mps: f64,
    /// Beyond which no descent begins: the trim leans by more than `lander.wind_slope`, or by more than the
    /// controller may lean, which is `horizontal.tilt_limit_rad` or the tilt at which [`THRUST_SHARE`] of
    /// the greatest thrust carries the weight.
    pub descent_mps: f64,
}

impl SpaceScenario {
    /// The airspeeds up to which the true vehicle can land. Infinite for one without drag, and zero
    /// for one whose greatest thrust does not hold it.
    ///
    /// # Errors
    /// Motors or a mass that make no sense.
    pub fn greatest_airspeeds(&self) -> Result<Airspeeds, SimError> {
        let plant = self.truth.plant(&self.plant);
        let weight_n = plant.weight_n();
        let most = THRUST_SHARE * thrust_to_weight(&plant)?;
        let horizontal_n = weight_n * (most * most - 1.0).max(0.0).sqrt();
        // Drag acts in the rotors' plane, by the air u that passes in it: W sin α = D(u), u = V cos α.
        let control = &self.control;
        let by_tilt = control.horizontal.tilt_limit_rad.tan();
        let by_thrust = horizontal_n / weight_n;
        let slope = control.state_machine.wind_slope.min(by_tilt).min(by_thrust);
        let sine = slope / slope.hypot(1.0);
        let in_plane_mps = self.airspeed_of_drag(weight_n * sine);
        Ok(Airspeeds {
            thrust_mps: self.airspeed_of_drag(horizontal_n),
            descent_mps: in_plane_mps * slope.hypot(1.0),
        })
    }

    /// The air whose drag `c_1 V + c_2 V²` is this, m/s.
    fn airspeed_of_drag(&self, drag_n: f64) -> f64 {
        let (c1, c2) = (self.body.drag_ns_per_m, self.body.drag_ns2_per_m2);
        if drag_n <= 0.0 {
            return 0.0;
        }
        // Of the two forms of the root the one that does not cancel; it holds for c_2 = 0, too.
        2.0 * drag_n / (c1 + (c1 * c1 + 4.0 * c2 * drag_n).sqrt())
    }

    /// The horizontal air that passes a vehicle above the deck, m/s: the steady wind, with the gusts of wind and faults at their
    /// height where that is more, less the velocity of a deck under way (the sum of both speeds where
    /// it turns), and two standard deviations of the turbulence. The wake of a deckhouse adds nothing: it
    /// takes more from the mean than its turbulence gives back.
    #[must_use]
    pub fn passing_air_mps(&self) -> f64 {
        let [x, y, _] = self.wind.steady_mps;
        let of_wind = self.wind.gust.map(|gust| gust.velocity_mps);
        let of_faults = self.faults.gust.map(|gust| gust.velocity_mps);
        let both = of_wind.zip(of_faults);
        let both = both.map(|(a, b)| [a[0] + b[0], a[1] + b[1], 0.0]);
        let gusts = [of_wind, of_faults, both].into_iter().flatten();
        let gusty = gusts.map(|[along, across, _]| self.passing_mean_mps([x + along, y + across]));
        let mean_mps = gusty.fold(self.passing_mean_mps([x, y]), f64::max);
        let turbulence = self.wind.dryden.map_or(0.0, |dryden| {
            let [along, across, _] = dryden.intensity_mps;
            along.max(across)
        });
        mean_mps + 2.0 * turbulence
    }

    /// A horizontal wind less the velocity of the deck, m/s.
    fn passing_mean_mps(&self, [x, y]: [f64; 2]) -> f64 {
        let course = &self.course;
        if course.turn_rad_per_s > 0.0 {
            x.hypot(y) + course.speed_mps
        } else {
            let (sin, cos) = course.heading_rad.sin_cos();
            (x - course.speed_mps * cos).hypot(y - course.speed_mps * sin)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::air::wind::{DrydenSettings, GustSettings};

    #[test]
    fn analytic_the_trim_at_the_limits() {
        let scenario = SpaceScenario::default();
        let found = scenario.greatest_airspeeds().unwrap();
        let weight_n = scenario.plant.weight_n();
        let drag_n = |v: f64| (scenario.body.drag_ns_per_m + scenario.body.drag_ns2_per_m2 * v) * v;
        let greatest_n = weight_n * thrust_to_weight(&scenario.plant).unwrap();
        let needed = weight_n.hypot(drag_n(found.thrust_mps));
        // Some roundings.
        assert!((needed / (0.9 * greatest_n) - 1.0).abs() < 1e-14);
        // The trim in the rotors' plane at the descent's airspeed.
        let tilt = scenario.control.state_machine.wind_slope.atan();
        let balance = weight_n * tilt.sin() - drag_n(found.descent_mps * tilt.cos());
        assert!(balance.abs() < 1e-13 * weight_n);
    }

    #[test]
    fn analytic_the_descent_ends_where_the_controller_may_not_lean() {
        let mut scenario = SpaceScenario::default();
        let tilt = |scenario: &SpaceScenario| {
            // The trim at the descent's airspeed, solved by W sin α = D(V cos α).
            let found_mps = scenario.greatest_airspeeds().unwrap().descent_mps;
            let weight_n = scenario.plant.weight_n();
            let (c1, c2) = (scenario.body.drag_ns_per_m, scenario.body.drag_ns2_per_m2);
            let (mut low, mut high) = (0.0_f64, 1.5);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let u = found_mps * middle.cos();
                if weight_n * middle.sin() < (c1 + c2 * u) * u {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            low
        };
        // Bisection of 60 halves.
        scenario.control.horizontal.tilt_limit_rad = 0.3;
        assert!((tilt(&scenario) - 0.3).abs() < 1e-12);
        // A heavier vehicle leans less, for 0.9 of its thrust holds it up: cos α = 1/(0.9 T/W).
        scenario.control.horizontal.tilt_limit_rad = 0.7;
        scenario.plant.mass_kg *= 1.2;
        let most = 0.9 * thrust_to_weight(&scenario.plant).unwrap();
        let by_wind = scenario.control.state_machine.wind_slope.atan();
        assert!(most > 1.0 && (1.0 / most).acos() < by_wind.min(0.7));
        assert!((tilt(&scenario) - (1.0 / most).acos()).abs() < 1e-12);
    }

    #[test]
    fn analytic_ends_of_the_vehicles() {
        let mut scenario = SpaceScenario::default();
        scenario.body.drag_ns_per_m = 0.0;
        scenario.body.drag_ns2_per_m2 = 0.0;
        let free = scenario.greatest_airspeeds().unwrap();
        assert!(free.thrust_mps == f64::INFINITY && free.descent_mps == f64::INFINITY);
        let mut heavy = SpaceScenario::default();
        heavy.truth.mass = 1.5;
        assert!(heavy.greatest_airspeeds().unwrap().thrust_mps == 0.0);
    }

    #[test]
    fn analytic_air_above_a_deck_under_way() {
        let mut scenario = SpaceScenario::default();
        scenario.wind.steady_mps = [3.0, 4.0, 9.0];
        assert!((scenario.passing_air_mps() - 5.0).abs() < 1e-15);
        // Against the wind the speeds add up; with it they do not.
        scenario.course.speed_mps = 5.0;
        scenario.course.heading_rad = 4.0_f64.atan2(3.0);
        assert!(scenario.passing_air_mps() < 1e-14);
        scenario.course.turn_rad_per_s = 0.1;
        assert!((scenario.passing_air_mps() - 10.0).abs() < 1e-14);
        scenario.wind.dryden = Some(DrydenSettings {
            intensity_mps: [1.0, 1.5, 3.0],
            length_m: [30.0, 30.0, 3.0],
            passing_mps: 5.0,
        });
        assert!((scenario.passing_air_mps() - 13.0).abs() < 1e-14);
        // A gust of 5 m/s in the wind's direction adds its own; one against it leaves the steady wind.
        let mut gust = GustSettings {
            velocity_mps: [3.0, 4.0, 1.0],
            start_s: 4.0,
            rise_s: 1.0,
            hold_s: 0.0,
        };
        scenario.wind.gust = Some(gust);
        assert!((scenario.passing_air_mps() - 18.0).abs() < 1e-14);
        gust.velocity_mps = [-3.0, -4.0, 0.0];
        scenario.wind.gust = Some(gust);
        assert!((scenario.passing_air_mps() - 13.0).abs() < 1e-14);
    }
}
