//! The flight to a deck that is not seen, or not below: by its broadcast, by dead reckoning, or by a search.
//!
//! | what is known | where to, horizontally | at which height |
//! | --- | --- | --- |
//! | the tag, less than [`SEEN_S`] ago | the axis of the approach | along a cone, [`CONE`] times the distance, down to the hover |
//! | a place, by the beacon or from earlier | there | `height_m`, or the present one if that is greater |
//! | it has come there, without the tag | a spiral about it, turns `pitch` apart | as before |
//! | no height | the same | `unknown_climb_m` above the altitude where the tag was lost |
//!
//! The vehicle flies at a speed from which it can stop with half of its acceleration, so that it tilts little and
//! the camera keeps looking down. A deck under way carries the whole flight along. While it is out of sight it may turn, so the vehicle
//! then moves and climbs faster.

use super::{Computer, ComputerState};
use crate::check::positive;
use crate::estimate::relative::RelativeEstimate;
use crate::space_controller::{Motion, Target};
use crate::state_machine::Phase;
use touchdown_flight::error::SettingsError;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::ReferencePoint;
use touchdown_flight::space::Vector;

// Effects of halving and doubling below are expected from single flights, not measured.

/// Age of the tag up to which the estimate counts as seen, s: an inertial unit carries a position of centimetres for a
/// second. Halved, tilting away for a moment breaks off the approach; doubled, the vehicle descends unseeing.
const SEEN_S: f64 = 1.0;
/// Height over distance on the way to the pad: the camera's half view of 0.6 less a tilt of 0.2. Halved, the
/// pad leaves the view; doubled, the approach takes twice the height.
const CONE: f64 = 3.0;
/// Distance from the axis over the height from which on a hover over the deck takes over: well within the cone.
const NEAR: f64 = 0.2;
/// Distance between two turns of the spiral over the height: two half views of 0.6, less a share that overlaps.
/// Halved, a search takes twice as long; doubled, it has gaps.
const PITCH: f64 = 0.9;
/// Distance at which the vehicle has come to a place, m.
const ARRIVED_M: f64 = 0.5;
/// Uncertainty of the height beyond which it is not known, m: more than that of a place by satellites.
const UNKNOWN_M: f64 = 5.0;
/// Rate at which errors of height and place vanish, 1/s: slow against the attitude control.
const RATE: f64 = 0.7;
/// Factor on acceleration and climb rate while a deck under way is out of sight: one that turns at 10 m/s is 4 m away after 2 s. Of 600 landings
/// on it without a broadcast (`turns.toml`, seeds 9401 and 9402, 1.37 kg) 585 succeed, without it 527, with 1.5 and 6 557 and 563; these without the
/// sea's `TURN_MPS2`. All with a deck estimator for periods from 0.8 s on.
const HASTE: f64 = 3.0;

/// Settings of the flight to a deck that is not below.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Seek<R> {
    /// Greatest horizontal speed relative to the deck, m/s.
    pub speed_mps: R,
    /// Greatest horizontal acceleration, m/s²; three times that while a deck under way is out of sight.
    pub acceleration_mps2: R,
    /// Greatest vertical speed, m/s; likewise.
    pub climb_mps: R,
    /// Least height above the deck while the tag is not seen, m.
    pub height_m: R,
    /// Climb of a vehicle that does not know its height above the deck, m.
    pub unknown_climb_m: R,
    /// Standard deviation of the height above the deck at the start, as the operator states it, m.
    pub start_sd_m: R,
    /// Radius at which the spiral begins again, m.
    pub reach_m: R,
}

impl<R: Real> Default for Seek<R> {
    /// 3 m/s, 1 m/s², 1 m/s; 7 m, where the view is 8 m wide and a tag of 0.4 m has 2.9 pixels in a cell; 2.5 m; 1.5 m,
    /// as by air pressure since the start from the deck; 35 m.
    fn default() -> Self {
        Self {
            speed_mps: r(3.0),
            acceleration_mps2: R::ONE,
            climb_mps: R::ONE,
            height_m: r(7.0),
            unknown_climb_m: r(2.5),
            start_sd_m: r(1.5),
            reach_m: r(35.0),
        }
    }
}

impl<R: Real> Seek<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// All must be positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("seeking.speed_mps", self.speed_mps)?;
        positive("seeking.acceleration_mps2", self.acceleration_mps2)?;
        positive("seeking.climb_mps", self.climb_mps)?;
        positive("seeking.height_m", self.height_m)?;
        positive("seeking.unknown_climb_m", self.unknown_climb_m)?;
        positive("seeking.start_sd_m", self.start_sd_m)?;
        positive("seeking.reach_m", self.reach_m)
    }
}

/// State of that flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SeekState<R> {
    /// Velocity that is flown: horizontally relative to the deck, vertically in the world, m/s.
    velocity_mps: Option<Vector<R>>,
    /// Length of the spiral so far, m; none before the place is reached.
    spiral_m: Option<R>,
    /// Altitude at which sight was lost, m.
    lost_at_m: Option<R>,
}

/// Place on an Archimedean spiral with turns `pitch_m` apart, at a length from its centre that is
/// long against the pitch: `s = p θ²/(4 π)`, `r = p θ/(2 π)`.
fn spiral<R: Real>(length_m: R, pitch_m: R) -> Vector<R> {
    let turn = (length_m * r(4.0 * core::f64::consts::PI) / pitch_m)
        .max(R::ZERO)
        .sqrt();
    let (sin, cos) = turn.sin_cos();
    let radius_m = pitch_m * turn * r(0.5 / core::f64::consts::PI);
    Vector::new(cos, sin, R::ZERO) * radius_m
}

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// The target of a flight to the deck; none while the vehicle is over the deck and sees it, or does not
    /// wait for a descent.
    #[inline(never)]
    pub(super) fn seek(
        &self,
        state: &mut ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
        motion: &Motion<R>,
        dt: R,
    ) -> Option<Target<R>> {
        let seek = self.seek.as_ref()?;
        let tag_age_s = self.relative.health(&state.relative).tag.age_s;
        let waits = matches!(state.phase(), Phase::Approach | Phase::Hold | Phase::Wait);
        let above_m = (motion.position_m.z - self.contact_height_m).max(R::ZERO);
        let axis_m = state.lean * above_m;
        let aside_m = motion.position_m.horizontal() - axis_m;
        let tagged = tag_age_s <= r(SEEN_S);
        let seen = tagged && self.knows_from_above(estimate);
        // Over the deck, a velocity that is less certain is no loss of sight: the vehicle would climb again and again.
        let enough = tagged && self.knows_enough(state, estimate, self.higher(estimate));
        let near = enough && aside_m.norm() <= r::<R>(NEAR) * motion.position_m.z;
        if !waits || near {
            state.seek = SeekState::default();
            return None;
        }
        if seen {
            (state.seek.spiral_m, state.seek.lost_at_m) = (None, None);
        }
        let unseen = !seen;
        let heard = self.relative.health(&state.relative).beacon.fresh;
        if unseen && !heard && !self.under_way {
            self.relative.rest_deck(&mut state.relative);
        }
        let to_place = self.spiral_place(state, motion, aside_m, unseen, dt) - aside_m;
        let wanted = self.seek_velocity(state, estimate, motion, aside_m.norm(), unseen, to_place);
        let deck_mps = motion.vehicle_velocity_mps - motion.relative_velocity_mps;
        let now = Vector::new(
            motion.relative_velocity_mps.x,
            motion.relative_velocity_mps.y,
            motion.vehicle_velocity_mps.z,
        );
        let last = state.seek.velocity_mps.unwrap_or(now);
        let most_mps2 = seek.acceleration_mps2 * self.seek_haste(unseen);
        let change = (wanted - last).limited(most_mps2 * dt);
        let velocity = (last + change).finite_or(last);
        state.seek.velocity_mps = Some(velocity);
        Some(Target {
            vertical: ReferencePoint {
                height_m: motion.position_m.z,
                velocity_mps: velocity.z - deck_mps.z,
                acceleration_mps2: R::ZERO,
            },
            position_m: motion.position_m,
            velocity_mps: velocity.horizontal(),
            deck_acceleration_mps2: state.course_mps2,
            ..Target::default()
        })
    }

    /// Where to, from the axis of the approach: that axis, or the spiral about it once the vehicle has come there unseeing.
    fn spiral_place(
        &self,
        state: &mut ComputerState<R, G::State>,
        motion: &Motion<R>,
        aside_m: Vector<R>,
        unseen: bool,
        dt: R,
    ) -> Vector<R> {
        let Some(seek) = self.seek.as_ref().filter(|_| unseen) else {
            return Vector::ZERO;
        };
        if state.seek.spiral_m.is_none() && aside_m.norm() <= r(ARRIVED_M) {
            state.seek.spiral_m = Some(R::ZERO);
        }
        let Some(length_m) = &mut state.seek.spiral_m else {
            return Vector::ZERO;
        };
        let pitch_m = r::<R>(PITCH)
            * motion
                .position_m
                .z
                .clamp(r::<R>(0.7) * seek.height_m, seek.height_m);
        let place = spiral(*length_m, pitch_m);
        // It waits for a vehicle that lags behind.
        let behind_m = (place - aside_m).norm();
        if behind_m <= pitch_m {
            *length_m += seek.speed_mps * dt;
        }
        if place.norm() > seek.reach_m {
            *length_m = R::ZERO;
        }
        place
    }

    /// [`HASTE`], or 1.
    fn seek_haste(&self, unseen: bool) -> R {
        if unseen && self.under_way {
            r(HASTE)
        } else {
            R::ONE
        }
    }

    /// The velocity towards a place and the height there.
    fn seek_velocity(
        &self,
        state: &mut ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
        motion: &Motion<R>,
        aside_m: R,
        unseen: bool,
        to_place: Vector<R>,
    ) -> Vector<R> {
        let Some(seek) = &self.seek else {
            return Vector::ZERO;
        };
        let left_m = to_place.norm();
        let speed = (seek.acceleration_mps2 * left_m)
            .sqrt()
            .min(seek.speed_mps)
            .min(left_m * r(RATE));
        let aside = to_place.limited(speed);
        let height_m = motion.position_m.z;
        let up_m = if !unseen {
            let hold_m = self.state_machine.hold_height_m;
            let cone_m = (r::<R>(CONE) * aside_m).min(seek.height_m.max(height_m));
            cone_m.max(hold_m) - height_m
        } else if estimate.position_sd_m.z <= r(UNKNOWN_M) {
            (seek.height_m - height_m).max(R::ZERO)
        } else {
            let lost_at_m = *state.seek.lost_at_m.get_or_insert(estimate.altitude_m);
            lost_at_m + seek.unknown_climb_m - estimate.altitude_m
        };
        let most_mps = seek.climb_mps * self.seek_haste(unseen);
        let up_mps = (up_m * r(RATE)).clamp(-most_mps, most_mps);
        aside + Vector::UP * up_mps
    }
}
