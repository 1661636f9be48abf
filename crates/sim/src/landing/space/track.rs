//! The deck over the time of a landing.

use crate::deck::course::Course;
use crate::deck::rigid::{DeckPose, RigidDeck};
use crate::error::SimError;
use crate::number::vector::{add, scale};

/// Largest distance between knots, s.
const KNOTS_S: f64 = 0.1;
/// Largest phase of the fastest wave between two knots, rad. The error of the spline is then
/// below 1e-5 of the wave's amplitude, and below 3e-4 of that of its acceleration.
const KNOT_RAD: f64 = 0.8;
/// Number of knots in a piece of the spline, which is computed at once.
const PIECE: f64 = 100.0;
/// Least number of waves for which the spline may have that error. Each of fewer waves is a larger
/// part of the motion.
const MANY: usize = 5;
/// Largest phase between two knots for fewer waves, rad: an error of 1e-10 of the amplitude.
const FEW_RAD: f64 = 0.13;
/// Distance of knots below which direct evaluation of a few waves costs less, s.
const LEAST_KNOTS_S: f64 = 0.01;

/// Time in which a deck that was held speeds up to its motion, s: the deck then accelerates
/// by at most 0.75 of its own speed per second, which disturbs a hover less than the motion itself. Half of it doubles that.
const RELEASE_S: f64 = 2.0;

/// How the deck's own time runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum DeckClock {
    /// With the time of the landing.
    #[default]
    Running,
    /// It stands.
    Held,
    /// It stood until this time of the landing, s, and then sped up within [`RELEASE_S`].
    Released(f64),
}

impl DeckClock {
    /// The deck's own time, its rate and the rate's derivative, s, 1 and 1/s.
    fn at(self, time_s: f64) -> Option<[f64; 3]> {
        match self {
            Self::Running => None,
            Self::Held => Some([0.0; 3]),
            Self::Released(since_s) => {
                let elapsed_s = (time_s - since_s).max(0.0);
                let u = elapsed_s / RELEASE_S;
                Some(if u < 1.0 {
                    [
                        RELEASE_S * u.powi(3) * (1.0 - 0.5 * u),
                        u * u * (3.0 - 2.0 * u),
                        6.0 * u * (1.0 - u) / RELEASE_S,
                    ]
                } else {
                    [elapsed_s - 0.5 * RELEASE_S, 1.0, 0.0]
                })
            }
        }
    }
}

/// The deck over time; waves as a spline, piece by piece.
pub(super) struct Track {
    deck: RigidDeck,
    clock: DeckClock,
    /// Step of the knots, where there are waves.
    knots_s: Option<f64>,
    piece: Option<(f64, RigidDeck)>,
    shift_s: f64,
    /// Course of a deck under way or turned, from the start of the landing on.
    course: Option<Course>,
}

impl Track {
    /// A deck that at the start of the landing is where it is at `shift_s`.
    pub(super) fn new(deck: RigidDeck, shift_s: f64) -> Self {
        let knots_s = match &deck {
            RigidDeck::Harmonics(waves) => {
                let frequencies = waves.iter().map(|wave| wave.angular_frequency);
                let fastest = frequencies.fold(0.0, f64::max);
                let many = waves.len() >= MANY;
                let turn = if many { KNOT_RAD } else { FEW_RAD };
                let knots_s = KNOTS_S.min(turn / fastest);
                (many || knots_s >= LEAST_KNOTS_S).then_some(knots_s)
            }
            _ => None,
        };
        Self {
            deck,
            clock: DeckClock::Running,
            knots_s,
            piece: None,
            shift_s,
            course: None,
        }
    }

    /// The same deck on a course.
    pub(super) fn on_course(self, course: Option<Course>) -> Self {
        Self { course, ..self }
    }

    /// Holds the deck where it is at the start.
    pub(super) fn hold(&mut self) {
        self.clock = DeckClock::Held;
    }

    /// Place of the course at a time, world axes, m.
    pub(super) fn travelled_m(&self, time_s: f64) -> [f64; 3] {
        let own_s = self.clock.at(time_s).map_or(time_s, |[own_s, ..]| own_s);
        self.course.as_ref().map_or([0.0; 3], |course| {
            let [x, y] = course.at(own_s).place_m;
            [x, y, 0.0]
        })
    }

    /// Whether the deck is held.
    pub(super) fn is_held(&self) -> bool {
        self.clock == DeckClock::Held
    }

    /// Share of its motion that a deck which was held has reached, in [0, 1]; none if it was never held.
    pub(super) fn released_share(&self, time_s: f64) -> Option<f64> {
        self.clock.at(time_s).map(|[_, rate, _]| rate)
    }

    /// Lets a deck that was held move from now on.
    pub(super) fn release(&mut self, time_s: f64) {
        self.clock = DeckClock::Released(time_s);
    }

    /// The deck at a time of the trial.
    pub(super) fn at(&mut self, time_s: f64) -> Result<DeckPose, SimError> {
        let Some([own_s, rate, gain]) = self.clock.at(time_s) else {
            return self.under_way_at(time_s);
        };
        let mut pose = self.under_way_at(own_s)?;
        // By the chain rule: velocities times the rate, accelerations times its square and velocities times its derivative.
        let rates = |first: [f64; 3], second: [f64; 3]| {
            let accelerations = add(scale(second, rate * rate), scale(first, gain));
            (scale(first, rate), accelerations)
        };
        (pose.velocity_mps, pose.acceleration_mps2) =
            rates(pose.velocity_mps, pose.acceleration_mps2);
        (pose.angular_velocity, pose.angular_acceleration) =
            rates(pose.angular_velocity, pose.angular_acceleration);
        Ok(pose)
    }

    /// The deck in the world at a time of its own.
    fn under_way_at(&mut self, time_s: f64) -> Result<DeckPose, SimError> {
        let pose = self.moving_at(time_s)?;
        Ok(match &self.course {
            Some(course) => course.pose(time_s, &pose),
            None => pose,
        })
    }

    /// The deck about its course, at a time of its own.
    fn moving_at(&mut self, time_s: f64) -> Result<DeckPose, SimError> {
        let time_s = time_s + self.shift_s;
        let Some(knots_s) = self.knots_s else {
            return Ok(self.deck.at(time_s));
        };
        let length_s = PIECE * knots_s;
        let piece = (time_s / length_s).floor();
        match &self.piece {
            Some((of, spline)) if *of == piece => Ok(spline.at(time_s)),
            _ => {
                let from_s = piece * length_s;
                let spline = self.deck.splined(from_s, from_s + length_s, knots_s)?;
                let pose = spline.at(time_s);
                self.piece = Some((piece, spline));
                Ok(pose)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck::rigid::{Axis, RigidMotion, Tone};

    #[test]
    fn analytic_a_held_deck_stands_and_then_moves_by_the_derivatives_of_its_place() {
        let tones = [(Axis::Heave, 0.2, 0.4), (Axis::Roll, 0.1, 0.3)];
        let motion = RigidMotion::Sines {
            tones: tones
                .map(|(axis, amplitude, frequency_hz)| Tone {
                    axis,
                    amplitude,
                    frequency_hz,
                    phase_rad: 0.7,
                })
                .to_vec(),
        };
        let deck = motion.build(9.81, 0, 0).unwrap();
        let mut track = Track::new(deck.clone(), 5.0);
        track.hold();
        let held = track.at(3.0).unwrap();
        // As said of `FEW_RAD`.
        assert!((held.origin_m[2] - deck.at(5.0).origin_m[2]).abs() < 1e-10);
        assert_eq!(
            (held.velocity_mps, held.angular_velocity),
            ([0.0; 3], [0.0; 3])
        );
        track.release(10.0);
        let h = 1e-4;
        for k in 0..40 {
            let t = 10.05 + 0.1 * f64::from(k);
            let [before, now, after] = [t - h, t, t + h].map(|t| track.at(t).unwrap());
            // Central differences: errors of h² times the third derivative, and of rounding over h.
            let velocity = (after.origin_m[2] - before.origin_m[2]) / (2.0 * h);
            assert!((velocity - now.velocity_mps[2]).abs() < 1e-6, "{t}");
            let acceleration = (after.velocity_mps[2] - before.velocity_mps[2]) / (2.0 * h);
            assert!(
                (acceleration - now.acceleration_mps2[2]).abs() < 1e-6,
                "{t}"
            );
            let spin = (after.angular_velocity[0] - before.angular_velocity[0]) / (2.0 * h);
            assert!((spin - now.angular_acceleration[0]).abs() < 1e-6, "{t}");
        }
        // Half of the ramp is lost.
        let late = track.at(20.0).unwrap().origin_m[2];
        assert!((late - deck.at(5.0 + 9.0).origin_m[2]).abs() < 1e-9);
    }

    #[test]
    fn analytic_many_waves_of_any_frequency_are_their_sum() {
        for fastest_hz in [0.2, 1.0, 5.0, 8.0, 40.0] {
            let tones = (1..=6).map(|k| Tone {
                axis: Axis::Heave,
                amplitude: if k == 6 { 0.1 } else { 0.0 },
                frequency_hz: fastest_hz * f64::from(k) / 6.0,
                phase_rad: 0.3,
            });
            let motion = RigidMotion::Sines {
                tones: tones.collect(),
            };
            let deck = motion.build(9.81, 0, 0).unwrap();
            let mut track = Track::new(deck.clone(), 37.3);
            let acceleration = 0.1 * (std::f64::consts::TAU * fastest_hz).powi(2);
            for k in 0..20_000 {
                let t = 0.0013 * f64::from(k);
                let (is, was) = (track.at(t).unwrap(), deck.at(t + 37.3));
                // The tolerance is that of `KNOT_RAD`.
                let apart = (is.origin_m[2] - was.origin_m[2]).abs();
                assert!(apart < 1e-5 * 0.1, "{fastest_hz} Hz, {t} s: {apart} m");
                let apart = (is.acceleration_mps2[2] - was.acceleration_mps2[2]).abs();
                assert!(
                    apart < 3e-4 * acceleration,
                    "{fastest_hz} Hz, {t} s: {apart}"
                );
            }
        }
    }
}
