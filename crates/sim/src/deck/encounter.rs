//! A ship under way meets the waves: their phase at the place where it is, at the angle at which they come.

use super::course::Course;
use super::rigid::{DeckCoordinates, RigidDeck, SeaSettings};
use super::spline::{MotionSpline, cubic_rates, natural_cubic};
use super::wave::{Spectrum, Wave};

/// Time between two knots of the cubic spline, s: waves are met at up to 6 rad/s, so its error is below
/// `5/384 (0.3)⁴`, 1.1e-4 of their amplitude (Hall 1968). Halved, a landing at sea takes twice as long to begin.
const KNOT_S: f64 = 0.05;

impl SeaSettings {
    /// The ship's motion about its course from time 0 to `to_s`, in one realisation of the waves.
    ///
    /// A wave with the number k = ω²/g that travels at the angle μ from the world's x axis has the phase
    /// `ω t - k (x cos μ + y sin μ)` at the place (x, y) of the ship: on a straight course the encounter
    /// frequency `ω - k u cos β`, with β = μ - ψ. The response is that of the present β and u.
    pub(crate) fn waves_along(
        &self,
        spectrum: &Spectrum,
        gravity_mps2: f64,
        (seed, index): (u64, u64),
        course: &Course,
        to_s: f64,
    ) -> RigidDeck {
        let (waves, directions) = self.realised(spectrum, seed, index);
        let bow_rad = course.at(0.0).heading_rad;
        let knots = (to_s / KNOT_S).ceil() as usize + 1;
        let times_s: Vec<f64> = (0..=knots).map(|i| KNOT_S * i as f64).collect();
        let at = |time_s: f64| {
            let ship = course.at(time_s);
            let mut sum = [0.0; 5];
            for (wave, direction_rad) in waves.iter().zip(&directions) {
                let (w, travels_rad) = (wave.angular_frequency, bow_rad + direction_rad);
                let (sin, cos) = travels_rad.sin_cos();
                let [x, y] = ship.place_m;
                let met = Wave {
                    phase_rad: wave.phase_rad + w * time_s
                        - w * w / gravity_mps2 * (x * cos + y * sin),
                    ..*wave
                };
                let heading_rad = travels_rad - ship.heading_rad;
                let moved =
                    self.ship
                        .response_under_way(&met, heading_rad, ship.speed_mps, gravity_mps2);
                for (sum, value) in sum.iter_mut().zip(moved.cosine) {
                    *sum += value;
                }
            }
            sum
        };
        let values: Vec<[f64; 5]> = times_s.iter().map(|&t| at(t)).collect();
        let mut coordinates = vec![DeckCoordinates::default(); times_s.len()];
        for axis in 0..5 {
            let values: Vec<f64> = values.iter().map(|value| value[axis]).collect();
            let second = natural_cubic(&times_s, &values);
            let rates = cubic_rates(&times_s, &values, &second);
            for (row, at) in coordinates.iter_mut().enumerate() {
                at.value[axis] = values[row];
                at.rate[axis] = rates[row];
                at.acceleration[axis] = second[row];
            }
        }
        RigidDeck::Spline(MotionSpline::new(&times_s, &coordinates))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck::course::CourseSettings;

    #[test]
    fn analytic_a_ship_meets_waves_at_their_encounter_frequency() {
        let g = 9.81;
        for (speed_mps, heading_rad) in [(0.0, 2.6), (5.0, 2.6), (5.0, 0.3), (12.0, 0.0)] {
            let sea = SeaSettings {
                waves: 1,
                heading_rad,
                ..SeaSettings::default()
            };
            let spectrum = sea.spectrum(g).unwrap();
            let (waves, directions) = sea.realised(&spectrum, 3, 4);
            let settings = CourseSettings {
                speed_mps,
                heading_rad: 0.7,
                ..CourseSettings::default()
            };
            let course = settings.course(60.0, 0.0);
            let deck = sea.waves_along(&spectrum, g, (3, 4), &course, 60.0);
            let (wave, beta) = (&waves[0], directions[0]);
            let harmonic = sea.ship.response_under_way(wave, beta, speed_mps, g);
            let w = wave.angular_frequency;
            let met = w - w * w / g * speed_mps * beta.cos();
            for k in 0..200 {
                let t = 1.0 + 0.29 * f64::from(k);
                let (sin, cos) = (met * t).sin_cos();
                let found = deck.coordinates(t);
                for axis in 0..5 {
                    let (c, s) = (harmonic.cosine[axis], harmonic.sine[axis]);
                    let size = c.hypot(s);
                    let value = c * cos + s * sin;
                    // Bounds of cubic splines (Hall 1968); their natural ends fade within a second.
                    let turn = (met * KNOT_S).abs();
                    let tolerance = 5.0 / 384.0 * turn.powi(4) * size + 1e-9;
                    assert!((found.value[axis] - value).abs() < tolerance, "{t} {axis}");
                    let rate = met * (s * cos - c * sin);
                    let tolerance = turn.powi(3) / 24.0 * size * met.abs() + 1e-9;
                    assert!((found.rate[axis] - rate).abs() < tolerance, "{t} {axis}");
                }
            }
        }
    }
}
