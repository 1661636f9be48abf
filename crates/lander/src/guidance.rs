//! From what a landing wants flown to what the controller flies.
//!
//! | manoeuvre ([`Maneuver`]) | horizontally | vertically |
//! | --- | --- | --- |
//! | `Hover`, deck | over the pad | to the height at the climb rate, in the deck's frame |
//! | `Hover`, world | stop where it is | stop where it is |
//! | `Descend`, `Commit` | over the pad | the plan, from its start |
//! | `ClimbAway` | stop where it is | up at the climb rate |
//! | `Idle` | | thrust taken back at a rate |
//! | `Rest` | | thrust as it is |
//! | `Disarm` | | off |
//!
//! In the world's frame only velocities are used (IMU and GNSS), not the position
//! relative to the deck. The plan compensates known delays: it gives position and
//! velocity for the time of the measurement, and acceleration for the time when the
//! rotors follow the command. After its end the plan continues downwards at its sink
//! rate, to `press_m` below, so that a floating vehicle is pressed down. The heading is
//! that of the first step.

use crate::check::{not_negative, positive};
use crate::space_controller::{Motion, Target};
use crate::state_machine::{Frame, Maneuver};
use touchdown_flight::error::SettingsError;
use touchdown_flight::kernel::{Sum, usable_dt};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::{Reference, ReferencePoint};
use touchdown_flight::space::Vector;

/// Guidance: its rates and delays.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Guidance<R> {
    /// Vertical speed towards a hover and away from the deck, m/s.
    pub climb_mps: R,
    /// Acceleration to and from that speed, m/s².
    pub climb_mps2: R,
    /// Acceleration away from the deck in a go-around, m/s².
    pub away_mps2: R,
    /// Rate at which the thrust decreases on the deck, N/s.
    pub idle_n_per_s: R,
    /// Distance below its end to which a plan continues, m.
    pub press_m: R,
    /// Age of position and velocity when the controller gets them, s.
    pub sensing_s: R,
    /// Time from a command to the rotors' force, s: the command's delay and the time constant with which thrust follows.
    pub acting_s: R,
}

/// State of a [`Guidance`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuidanceState<R> {
    /// Present height and vertical velocity of the reference in a hover or climb. The
    /// frame says whether the velocity is relative to the deck.
    slew: Option<(Frame, R, R)>,
    /// The present plan and the time since its start, s.
    plan: Option<(Reference<R>, Sum<R>)>,
    /// Constant heading, rad.
    heading_rad: Option<R>,
}

/// Greatest speed at which the way to a hover begins, over the climb rate. A vehicle that is estimated to be faster is rather
/// stopped than led: the estimate may be wrong for a moment, and the way would follow it for seconds.
const FASTEST_START: f64 = 2.0;

/// Order of the guidance to the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuidanceCommand<R> {
    /// Fly to a target ([`SpaceController::step`](crate::space_controller::SpaceController::step)).
    Track(Target<R>),
    /// Reduce the thrust ([`SpaceController::idle`](crate::space_controller::SpaceController::idle)).
    Idle {
        /// Rate, N/s.
        rate_n_per_s: R,
    },
    /// Rotors off.
    Off,
}

impl<R: Real> Default for Guidance<R> {
    /// 0.5 m/s, 1 m/s² (away from the deck 3 m/s²), 40 N/s, 0.15 m; 20 ms and 40 ms.
    fn default() -> Self {
        Self {
            climb_mps: r(0.5),
            climb_mps2: R::ONE,
            away_mps2: r(3.0),
            idle_n_per_s: r(40.0),
            press_m: r(0.15),
            sensing_s: r(0.02),
            acting_s: r(0.04),
        }
    }
}

impl<R: Real> Guidance<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Rates must be positive, the other settings not negative.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("guidance.climb_mps", self.climb_mps)?;
        positive("guidance.climb_mps2", self.climb_mps2)?;
        positive("guidance.away_mps2", self.away_mps2)?;
        positive("guidance.idle_n_per_s", self.idle_n_per_s)?;
        not_negative("guidance.press_m", self.press_m)?;
        not_negative("guidance.sensing_s", self.sensing_s)?;
        not_negative("guidance.acting_s", self.acting_s)
    }

    /// The state before the first step.
    #[must_use]
    pub fn initial(&self) -> GuidanceState<R> {
        GuidanceState::default()
    }

    /// The order for the next `dt` seconds. `plan` is used if a descent begins in this
    /// step. Without a plan, a descent is a hover.
    ///
    /// `deck_acceleration_mps2` is predicted to the time when the thrust acts.
    pub fn step(
        &self,
        state: &mut GuidanceState<R>,
        maneuver: Maneuver<R>,
        plan: Option<&Reference<R>>,
        motion: &Motion<R>,
        deck_acceleration_mps2: Vector<R>,
        dt: R,
    ) -> GuidanceCommand<R> {
        let dt = usable_dt(dt);
        let heading_rad = self.heading_rad(state, motion);
        let mut order = match maneuver {
            Maneuver::Disarm => {
                *state = self.initial();
                GuidanceCommand::Off
            }
            Maneuver::Idle => GuidanceCommand::Idle {
                rate_n_per_s: self.idle_n_per_s,
            },
            Maneuver::Rest => GuidanceCommand::Idle {
                rate_n_per_s: R::ZERO,
            },
            Maneuver::Descend | Maneuver::Commit => {
                if state.plan.is_none() {
                    state.plan = plan.map(|plan| (*plan, Sum::default()));
                }
                let vertical = match &mut state.plan {
                    Some((reference, clock)) => {
                        let now = clock.value();
                        clock.add(dt);
                        self.on_the_plan(reference, now)
                    }
                    None => self.slew(state, Frame::Deck, motion, motion.position_m.z, dt),
                };
                GuidanceCommand::Track(Target {
                    descending: true,
                    ..self.over_the_pad(vertical, deck_acceleration_mps2)
                })
            }
            Maneuver::Hover {
                height_m,
                frame: Frame::Deck,
            } => {
                state.plan = None;
                let vertical = self.slew(state, Frame::Deck, motion, height_m, dt);
                GuidanceCommand::Track(self.over_the_pad(vertical, deck_acceleration_mps2))
            }
            Maneuver::Hover {
                frame: Frame::World,
                ..
            } => GuidanceCommand::Track(self.hover_in_the_world(state, motion, dt)),
            Maneuver::ClimbAway => GuidanceCommand::Track(self.climb_away(state, motion, dt)),
        };
        if let GuidanceCommand::Track(target) = &mut order {
            target.yaw_rad = heading_rad;
        }
        order
    }

    /// [`Maneuver::Hover`] in the world's frame, without a heading.
    pub(crate) fn hover_in_the_world(
        &self,
        state: &mut GuidanceState<R>,
        motion: &Motion<R>,
        dt: R,
    ) -> Target<R> {
        self.in_the_world(state, motion, [R::ZERO, self.climb_mps2], dt)
    }

    /// [`Maneuver::ClimbAway`], without a heading.
    pub(crate) fn climb_away(
        &self,
        state: &mut GuidanceState<R>,
        motion: &Motion<R>,
        dt: R,
    ) -> Target<R> {
        self.in_the_world(state, motion, [self.climb_mps, self.away_mps2], dt)
    }

    /// The heading to keep: that of the first flight, rad.
    pub(crate) fn heading_rad(&self, state: &mut GuidanceState<R>, motion: &Motion<R>) -> R {
        let at_first = || motion.attitude.yaw_rad().finite_or(R::ZERO);
        *state.heading_rad.get_or_insert_with(at_first)
    }

    /// Forgets plan and hover, which somebody else flies; returns the heading to keep, rad.
    pub(crate) fn interrupt(&self, state: &mut GuidanceState<R>, motion: &Motion<R>) -> R {
        let heading_rad = self.heading_rad(state, motion);
        *state = GuidanceState {
            heading_rad: Some(heading_rad),
            ..self.initial()
        };
        heading_rad
    }

    fn on_the_plan(&self, reference: &Reference<R>, time_s: R) -> ReferencePoint<R> {
        let sensed = reference.at(time_s - self.sensing_s);
        let lowest_m = reference.end_height_m() - self.press_m;
        ReferencePoint {
            height_m: sensed.height_m.max(lowest_m),
            velocity_mps: sensed.velocity_mps,
            acceleration_mps2: reference.at(time_s + self.acting_s).acceleration_mps2,
        }
    }

    fn over_the_pad(
        &self,
        vertical: ReferencePoint<R>,
        deck_acceleration_mps2: Vector<R>,
    ) -> Target<R> {
        Target {
            vertical,
            deck_acceleration_mps2,
            ..Target::default()
        }
    }

    /// A reference from the vehicle's height to a height above the deck, within climb
    /// rate and acceleration.
    fn slew(
        &self,
        state: &mut GuidanceState<R>,
        frame: Frame,
        motion: &Motion<R>,
        height_m: R,
        dt: R,
    ) -> ReferencePoint<R> {
        let most_mps = self.climb_mps * r(FASTEST_START);
        let (mut z, v) = match state.slew {
            Some((of, z, v)) if of == frame => (z, v),
            _ => {
                let v = motion.relative_velocity_mps.z;
                (motion.position_m.z, v.clamp(-most_mps, most_mps))
            }
        };
        let left_m = height_m - z;
        // The speed from which the reference can stop within the distance s: √(2 a s), and
        // s per step at the end.
        let speed = (r::<R>(2.0) * self.climb_mps2 * left_m.abs())
            .sqrt()
            .min(self.climb_mps)
            .min(left_m.abs() / dt.max(R::EPSILON));
        let wanted = if left_m < R::ZERO { -speed } else { speed };
        let change = self.climb_mps2 * dt;
        let velocity_mps = wanted.clamp(v - change, v + change).finite_or(R::ZERO);
        z += velocity_mps * dt;
        state.slew = Some((frame, z, velocity_mps));
        ReferencePoint {
            height_m: z,
            velocity_mps,
            acceleration_mps2: R::ZERO,
        }
    }

    /// Stops horizontally and accelerates to a vertical speed, independent of the deck.
    fn in_the_world(
        &self,
        state: &mut GuidanceState<R>,
        motion: &Motion<R>,
        [climb_mps, most_mps2]: [R; 2],
        dt: R,
    ) -> Target<R> {
        state.plan = None;
        let v = match state.slew {
            Some((Frame::World, _, v)) => v,
            _ => motion.vehicle_velocity_mps.z,
        };
        let change = most_mps2 * dt;
        let climb_mps = climb_mps.clamp(v - change, v + change).finite_or(R::ZERO);
        let acceleration_mps2 = ((climb_mps - v) / dt).finite_or(R::ZERO);
        state.slew = Some((Frame::World, R::ZERO, climb_mps));
        // The position error is zero, and the error of the relative velocity is that of
        // the vehicle's own velocity.
        let deck_mps = motion.vehicle_velocity_mps - motion.relative_velocity_mps;
        Target {
            vertical: ReferencePoint {
                height_m: motion.position_m.z,
                velocity_mps: climb_mps - deck_mps.z,
                acceleration_mps2,
            },
            position_m: motion.position_m,
            velocity_mps: -deck_mps,
            ..Target::default()
        }
    }
}
