//! Course of a deck under way: straight, or with turns and speed changes.
//!
//! The bow has the direction ψ from the world's x axis to port, the deck the speed u along it:
//!
//! ```text
//! ψ = ψ0 + ∫ r0 s(t) dt      u = u0 + ∫ a0 s(t - P/4) dt - Δu/2      x' = u cos ψ,  y' = u sin ψ
//! ```
//!
//! s is a wave of the period P: 1 for the time T of a manoeuvre, 0 for a pause, -1 for T, 0 for a
//! pause. Its flanks are smooth cubics of 1 s; Δu is the whole gain of a manoeuvre. So turns to port and to
//! starboard alternate, as do gains and losses of speed, a quarter of a period later. The motion of
//! [`super::rigid`] is relative to this moving frame; waves are met along the course ([`super::rigid::SeaSettings`]).

use serde::{Deserialize, Serialize};

use super::rigid::{DeckCoordinates, DeckPose};
use super::spline::MotionSpline;
use crate::check;
use crate::error::SimError;
use crate::number::vector::{add, cross, scale};

/// Time in which a manoeuvre begins and ends, s: a rudder or a steering wheel is put over in about a
/// second. Halved, accelerations change twice as fast; doubled, manoeuvres below 2 s lose their greatest value.
const FLANK_S: f64 = 1.0;

/// Time between two knots, s: the quintic's error is below 1 µm at 15 m/s and 0.2 rad/s.
const KNOT_S: f64 = 0.1;

/// Course of a deck under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CourseSettings {
    /// Mean speed u0, m/s.
    pub speed_mps: f64,
    /// Direction of the bow at the start ψ0, from the world's x axis to port, rad; also that of a deck at rest.
    pub heading_rad: f64,
    /// Greatest rate of turn r0, rad/s.
    pub turn_rad_per_s: f64,
    /// Greatest change of speed per second a0, m/s².
    pub acceleration_mps2: f64,
    /// Time of a manoeuvre T, s; at least 1 s where there are manoeuvres.
    pub manoeuvre_s: f64,
    /// Time between two manoeuvres, s.
    pub pause_s: f64,
}

impl CourseSettings {
    /// Whether the deck travels or turns.
    #[must_use]
    pub fn is_under_way(&self) -> bool {
        let moves = [self.speed_mps, self.turn_rad_per_s, self.acceleration_mps2];
        moves.iter().any(|&size| size > 0.0)
    }

    /// Whether the deck is not where and as a deck without a course is: it travels, turns, or its bow has a direction of
    /// its own.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.is_under_way() || self.heading_rad.abs() > 0.0
    }

    /// Whether the deck turns or changes its speed.
    fn winds(&self) -> bool {
        self.turn_rad_per_s > 0.0 || self.acceleration_mps2 > 0.0
    }

    /// Checks the course.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn validate(&self) -> Result<(), SimError> {
        check::within("speed_mps", self.speed_mps, 0.0, 100.0)?;
        check::finite("heading_rad", self.heading_rad)?;
        check::within("turn_rad_per_s", self.turn_rad_per_s, 0.0, 1.0)?;
        check::within("acceleration_mps2", self.acceleration_mps2, 0.0, 10.0)?;
        check::not_negative("pause_s", self.pause_s)?;
        let least_s = if self.winds() { FLANK_S } else { 0.0 };
        check::within("manoeuvre_s", self.manoeuvre_s, least_s, 1e6)?;
        check::that(
            0.5 * self.acceleration_mps2 * self.manoeuvre_s <= self.speed_mps,
            "acceleration_mps2",
            "at most 2 `speed_mps` / `manoeuvre_s`, so that the deck never goes astern",
            self.acceleration_mps2,
        )
    }

    fn period_s(&self) -> f64 {
        2.0 * (self.manoeuvre_s + self.pause_s)
    }

    /// The course from time 0 to `to_s`, its manoeuvres ahead by a share of their period.
    #[must_use]
    pub fn course(&self, to_s: f64, phase: f64) -> Course {
        let ahead_s = phase * self.period_s();
        let knots = if self.winds() {
            (to_s / KNOT_S).ceil() as usize
        } else {
            1
        };
        let step_s = to_s / knots as f64;
        let mut now = Travel {
            heading_rad: self.heading_rad,
            // Where the gain of speed has come to, less half of the whole.
            speed_mps: self.speed_mps + self.acceleration_mps2 * self.gained_s(ahead_s),
            place_m: [0.0; 2],
        };
        let mut times_s = Vec::with_capacity(knots + 1);
        let mut coordinates = Vec::with_capacity(knots + 1);
        for knot in 0..=knots {
            let t = step_s * knot as f64;
            times_s.push(t);
            coordinates.push(self.coordinates(&now, t + ahead_s));
            now = self.advanced(&now, t + ahead_s, step_s);
        }
        Course(MotionSpline::new(&times_s, &coordinates))
    }

    /// Value of the wave s at a time.
    fn wave(&self, time_s: f64) -> f64 {
        let half_s = 0.5 * self.period_s();
        if half_s <= 0.0 {
            return 0.0;
        }
        let turn = (time_s / half_s).floor();
        let sign = if turn.rem_euclid(2.0) < 0.5 {
            1.0
        } else {
            -1.0
        };
        let since_s = time_s - turn * half_s;
        let flank = |t: f64| {
            let u = (t / FLANK_S).clamp(0.0, 1.0);
            u * u * (3.0 - 2.0 * u)
        };
        sign * flank(since_s) * flank(self.manoeuvre_s - since_s)
    }

    /// [`Self::wave`] of the speed, a quarter of a period later than that of the turns.
    fn speed_wave(&self, time_s: f64) -> f64 {
        self.wave(time_s - 0.25 * self.period_s())
    }

    /// `∫ s dt` of the speed up to a time within the first period, less half of a manoeuvre's, s.
    fn gained_s(&self, time_s: f64) -> f64 {
        let from_s = 0.25 * self.period_s();
        let steps = 1 + (self.period_s() / KNOT_S).min(1e5) as usize;
        let simpson = |from_s: f64, to_s: f64| {
            let h = (to_s - from_s) / steps as f64;
            let part = |i: usize| {
                let t = from_s + h * i as f64;
                let [a, b, c] = [t, t + 0.5 * h, t + h].map(|t| self.speed_wave(t));
                h / 6.0 * (a + 4.0 * b + c)
            };
            (0..steps).map(part).sum::<f64>()
        };
        let whole_s = simpson(from_s, from_s + self.manoeuvre_s);
        simpson(from_s, time_s) - 0.5 * whole_s
    }

    /// Place, heading and their derivatives.
    fn coordinates(&self, now: &Travel, time_s: f64) -> DeckCoordinates {
        let (sin, cos) = now.heading_rad.sin_cos();
        let (u, turn) = (now.speed_mps, self.turn_rad_per_s * self.wave(time_s));
        let gain = self.acceleration_mps2 * self.speed_wave(time_s);
        // The wave's slope, by a central difference: exact for its cubics up to rounding and their corners.
        let h = 1e-4;
        let slope = (self.wave(time_s + h) - self.wave(time_s - h)) / (2.0 * h);
        let [x, y] = now.place_m;
        let mut at = DeckCoordinates::default();
        at.value[..3].copy_from_slice(&[x, y, now.heading_rad]);
        at.rate[..3].copy_from_slice(&[u * cos, u * sin, turn]);
        let across = u * turn;
        at.acceleration[..3].copy_from_slice(&[
            gain * cos - across * sin,
            gain * sin + across * cos,
            self.turn_rad_per_s * slope,
        ]);
        at
    }

    /// The travel a step later, by Simpson's rule.
    fn advanced(&self, now: &Travel, time_s: f64, step_s: f64) -> Travel {
        let at = |share: f64| {
            // The integrals of the wave up to that share, by Simpson's rule as well.
            let h = share * step_s;
            let mean = |wave: &dyn Fn(f64) -> f64| {
                (wave(time_s) + 4.0 * wave(time_s + 0.5 * h) + wave(time_s + h)) / 6.0
            };
            let heading_rad = now.heading_rad + self.turn_rad_per_s * h * mean(&|t| self.wave(t));
            let speed_mps =
                now.speed_mps + self.acceleration_mps2 * h * mean(&|t| self.speed_wave(t));
            (heading_rad, speed_mps)
        };
        let points = [at(0.0), at(0.5), at(1.0)];
        let mean = |of: fn(f64) -> f64| {
            let [a, b, c] = points.map(|(heading, speed)| speed * of(heading));
            (a + 4.0 * b + c) / 6.0
        };
        let (heading_rad, speed_mps) = points[2];
        let [x, y] = now.place_m;
        Travel {
            heading_rad,
            speed_mps,
            place_m: [x + step_s * mean(f64::cos), y + step_s * mean(f64::sin)],
        }
    }
}

/// Heading, speed and place at a time.
#[derive(Clone, Copy)]
struct Travel {
    heading_rad: f64,
    speed_mps: f64,
    place_m: [f64; 2],
}

/// The course of a deck over time; it begins at the world's origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Course(MotionSpline);

/// Place, heading and speed of the moving frame at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoursePoint {
    /// Place, m.
    pub place_m: [f64; 2],
    /// Heading, rad.
    pub heading_rad: f64,
    /// Speed along it, m/s.
    pub speed_mps: f64,
}

impl Course {
    /// The moving frame at a time.
    #[must_use]
    pub fn at(&self, time_s: f64) -> CoursePoint {
        let at = self.0.at(time_s);
        CoursePoint {
            place_m: [at.value[0], at.value[1]],
            heading_rad: at.value[2],
            speed_mps: at.rate[0].hypot(at.rate[1]),
        }
    }

    /// The pose of a deck in the world, from that in the moving frame.
    #[must_use]
    pub fn pose(&self, time_s: f64, own: &DeckPose) -> DeckPose {
        let at = self.0.at(time_s);
        let (sin, cos) = at.value[2].sin_cos();
        let turned = |[x, y, z]: [f64; 3]| [cos * x - sin * y, sin * x + cos * y, z];
        let level = |of: [f64; 5]| [of[0], of[1], 0.0];
        let (turn, faster) = ([0.0, 0.0, at.rate[2]], [0.0, 0.0, at.acceleration[2]]);
        let arm = turned(own.origin_m);
        let own_mps = turned(own.velocity_mps);
        let around_mps = cross(turn, arm);
        // a = a_frame + α × r + ω × (ω × r) + 2 ω × v + a_own.
        let carried = add(cross(faster, arm), cross(turn, around_mps));
        let coriolis = scale(cross(turn, own_mps), 2.0);
        let own_mps2 = add(turned(own.acceleration_mps2), coriolis);
        let spin = turned(own.angular_velocity);
        DeckPose {
            origin_m: add(level(at.value), arm),
            velocity_mps: add(level(at.rate), add(around_mps, own_mps)),
            acceleration_mps2: add(level(at.acceleration), add(carried, own_mps2)),
            axes: own.axes.map(turned),
            angular_velocity: add(turn, spin),
            angular_acceleration: add(
                add(faster, cross(turn, spin)),
                turned(own.angular_acceleration),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck::rigid::{Axis, RigidMotion, Tone};

    /// Turns of 10 degrees per second and changes of 1 m/s², 3 s each.
    fn winding() -> CourseSettings {
        CourseSettings {
            speed_mps: 5.0,
            heading_rad: 0.4,
            turn_rad_per_s: 0.1745,
            acceleration_mps2: 1.0,
            manoeuvre_s: 3.0,
            pause_s: 4.0,
        }
    }

    #[test]
    fn analytic_a_straight_course_is_a_line() {
        let settings = CourseSettings {
            speed_mps: 5.0,
            heading_rad: 0.3,
            ..CourseSettings::default()
        };
        let course = settings.course(100.0, 0.7);
        for t in [0.0, 0.123, 50.0, 99.9] {
            let at = course.at(t);
            let (sin, cos) = 0.3_f64.sin_cos();
            // Rounding of a quintic over 100 s.
            assert!((at.place_m[0] - 5.0 * t * cos).abs() < 1e-9, "{t}");
            assert!((at.place_m[1] - 5.0 * t * sin).abs() < 1e-9, "{t}");
            assert!((at.heading_rad - 0.3).abs() < 1e-12);
        }
    }

    #[test]
    fn analytic_a_constant_turn_is_a_circle() {
        let settings = CourseSettings {
            speed_mps: 8.0,
            turn_rad_per_s: 0.2,
            manoeuvre_s: 1000.0,
            ..CourseSettings::default()
        };
        let course = settings.course(60.0, 0.1);
        let still = DeckPose::default();
        // One turn lasts 10 π s; places are those of Simpson's rule, with an error far below 1 µm.
        let (a, b) = (
            course.at(10.0),
            course.at(10.0 + 10.0 * std::f64::consts::PI),
        );
        let apart = (a.place_m[0] - b.place_m[0]).hypot(a.place_m[1] - b.place_m[1]);
        assert!(apart < 1e-6, "{apart}");
        let pose = course.pose(20.0, &still);
        let [x, y, _] = pose.acceleration_mps2;
        assert!((x.hypot(y) - 8.0 * 0.2).abs() < 1e-6);
        assert!((pose.angular_velocity[2] - 0.2).abs() < 1e-12);
    }

    #[test]
    fn analytic_rates_of_a_winding_deck_are_the_derivatives_of_its_pose() {
        let tone = |axis, amplitude, frequency_hz| Tone {
            axis,
            amplitude,
            frequency_hz,
            phase_rad: 0.7,
        };
        let motion = RigidMotion::Sines {
            tones: vec![
                tone(Axis::Surge, 0.3, 0.2),
                tone(Axis::Roll, 0.1, 0.3),
                tone(Axis::Pitch, 0.08, 0.25),
            ],
        };
        let deck = motion.build(9.81, 0, 0).unwrap();
        let course = winding().course(40.0, 0.35);
        let at = |t: f64| course.pose(t, &deck.at(t));
        let h = 1e-4;
        for k in 0..300 {
            let t = 0.5 + 0.1301 * f64::from(k);
            let [before, now, after] = [t - h, t, t + h].map(at);
            for i in 0..3 {
                let slope = |b: f64, a: f64| (a - b) / (2.0 * h);
                // Central differences: errors of h² times third derivatives, below 1e-7, and of rounding over h.
                let velocity = slope(before.origin_m[i], after.origin_m[i]);
                assert!((velocity - now.velocity_mps[i]).abs() < 1e-6, "{t} {i}");
                let acceleration = slope(before.velocity_mps[i], after.velocity_mps[i]);
                // The quintic's own acceleration is continuous, but has corners at the knots.
                assert!(
                    (acceleration - now.acceleration_mps2[i]).abs() < 1e-3,
                    "{t} {i}"
                );
                let turning = cross(now.angular_velocity, now.axes[0])[i];
                let turned = slope(before.axes[0][i], after.axes[0][i]);
                assert!((turned - turning).abs() < 1e-6, "{t} {i}");
                let spin = slope(before.angular_velocity[i], after.angular_velocity[i]);
                assert!((spin - now.angular_acceleration[i]).abs() < 1e-3, "{t} {i}");
            }
        }
    }

    #[test]
    fn prop_speed_keeps_its_mean_and_turns_their_limit() {
        let settings = winding();
        settings.validate().unwrap();
        let period_s = settings.period_s();
        let course = settings.course(4.0 * period_s, 0.2);
        let speeds: Vec<f64> = (0..5600)
            .map(|k| course.at(4.0 * period_s / 5600.0 * f64::from(k)).speed_mps)
            .collect();
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        // Four whole periods; the sum is a midpoint rule of a smooth wave.
        assert!((mean - 5.0).abs() < 1e-3, "{mean}");
        let greatest = speeds.iter().copied().fold(0.0, f64::max);
        // Two flanks of 1 s take half a second each from the 3 s of a gain.
        assert!((greatest - 6.0).abs() < 1e-3, "{greatest}");
        let astern = CourseSettings {
            speed_mps: 1.0,
            ..settings
        };
        let message = astern.validate().unwrap_err().to_string();
        assert!(message.contains("acceleration_mps2"), "{message}");
    }
}
