//! Wind and sea: the trim, the slope of the approach, the lowest foot, the height of the hover.

use super::{Computer, ComputerState, Descent};
use crate::space_controller::{Motion, Target};
use crate::state_machine::Phase;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::kernel::lag_step;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Slope of the trim up to which the approach is vertical: a quarter of the camera's half
/// view of 0.6. Halved, calm air would move the approach; doubled, a tag at the edge of the
/// view would be lost in gusts at 12 m/s.
const UPRIGHT: f64 = 0.15;

/// Time constant of the approach's slope, s: long against gusts, short against a wait of
/// some waves. Halved, gusts move the axis; doubled, the vehicle waits longer for readiness.
const LEAN_S: f64 = 2.0;

/// Distance by which gusts move a vehicle off its axis per slope of the approach, m: 0.07 m at
/// 10 m/s, two standard deviations. Halved, every second descent at 10 m/s is aborted for it; doubled, the
/// vehicle lands up to 0.25 m from the centre.
const GUSTS_M: f64 = 0.2;

/// Greatest speed of the deck up to which the hover stays at its height, m/s: that of seas of
/// 0.5 m. Halved, the default sea raises the hover; doubled, decks of 1.4 m/s strike a vehicle at 0.8 m.
const CALM_MPS: f64 = 0.7;

/// Greatest rise of the hover, m: a deck in waves of 4 m moves at 2 m/s. Above 3 m the range finder's
/// beam leaves a deck of 1.5 m at 0.25 rad.
const HIGHEST_M: f64 = 1.5;

/// Time constant with which the deck's greatest speed fades, s: a group of waves. Halved, the hover
/// sinks between two groups; doubled, it stays high for a minute.
const ROUGH_S: f64 = 30.0;

/// Time without a tag after which a hover in the wind moves to find it, s: longer than any loss by
/// a gust. Halved, gusts move it away from the pad; doubled, it drifts twice as far before.
const LOST_S: f64 = 1.0;
/// Velocity of that search, upwind and up, m/s: twice the drift of the estimate without a tag. Halved, 2 of
/// 100 landings at 8 m/s never see the pad; doubled, it flies past.
const SEARCH_MPS: f64 = 0.15;
/// Height above the deck up to which the search climbs, m: the view then covers 1 m to each side of what
/// is below. Halved, it covers what gusts cover; doubled, the smaller tags are too small.
const SEARCH_M: f64 = 2.0;

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// Moves a hover whose tag is lost upwind and up. The camera of a leaning vehicle looks
    /// downwind: it never finds a pad from downwind of it.
    pub(super) fn search_upwind(&self, state: &ComputerState<R, G::State>, target: &mut Target<R>) {
        let tag_age_s = self.relative.health(&state.relative).tag.age_s;
        let waits = matches!(state.phase(), Phase::Approach | Phase::Hold | Phase::Wait);
        let seen = tag_age_s <= r(LOST_S) || state.flown_s <= r(LOST_S);
        let trim = self.trim_up(state).horizontal();
        if seen || !waits || trim.norm() <= r(UPRIGHT) {
            return;
        }
        let Some(upwind) = trim.direction() else {
            return;
        };
        target.velocity_mps += upwind * r(SEARCH_MPS);
        if target.vertical.height_m < r(SEARCH_M) {
            target.vertical.velocity_mps += r(SEARCH_MPS);
        }
    }

    /// Remembers the attitude in which the vehicle was flown before the first step. One
    /// beyond the tilt limit is no hover.
    pub(super) fn take_over(&self, state: &mut ComputerState<R, G::State>, attitude: Attitude<R>) {
        if state.taken_over.is_none() && attitude.is_finite() {
            let limit_rad = self.controller.greatest_tilt_rad();
            let hovers = attitude.tilt_rad() <= limit_rad;
            state.taken_over = Some(if hovers { attitude } else { Attitude::LEVEL });
        }
    }

    /// How much higher than in a calm sea the vehicle holds, m. A hover lags behind a deck that
    /// accelerates, and a deck that is not known yet may rise.
    pub(super) fn hold_extra_m(
        &self,
        state: &mut ComputerState<R, G::State>,
        deck_mps: R,
        dt: R,
    ) -> R {
        let fading_mps = lag_step(state.rough_mps, R::ZERO, r(ROUGH_S), dt);
        state.rough_mps = fading_mps.max(deck_mps.finite_or(R::ZERO));
        let most_m = match &self.descent {
            Descent::Planned(planner) => planner.reach_m() - self.state_machine.hold_height_m,
            Descent::Straight(_) => R::ZERO,
        };
        (state.rough_mps - r(CALM_MPS))
            .max(R::ZERO)
            .min(r::<R>(HIGHEST_M).min(most_m))
    }

    /// Height of the lowest foot along the deck's normal, as that of a level vehicle's
    /// reference point, m.
    pub(super) fn feet_height_m(&self, motion: &Motion<R>) -> R {
        let normal = motion.deck_normal.direction().unwrap_or(Vector::UP);
        motion.position_m.dot(normal) - self.feet.drop_m(motion.attitude, normal)
    }

    /// [`Feet::drop_m`](super::Feet::drop_m) of the trim attitude.
    pub(super) fn trim_drop_m(&self, state: &ComputerState<R, G::State>, motion: &Motion<R>) -> R {
        let yaw_rad = motion.attitude.yaw_rad();
        let trim = Attitude::from_thrust_direction(self.trim_up(state), yaw_rad);
        trim.map_or(R::ZERO, |trim| self.feet.drop_m(trim, motion.deck_normal))
    }

    /// Direction of thrust that holds the vehicle still in the wind.
    pub(super) fn trim_up(&self, state: &ComputerState<R, G::State>) -> Vector<R> {
        match (&state.controller, state.taken_over) {
            (Some(controller), _) => self.controller.trim_up(controller),
            (None, Some(attitude)) => attitude.up(),
            (None, None) => Vector::UP,
        }
    }

    /// Slope of that direction: horizontal over vertical.
    pub(super) fn wind_slope(&self, state: &ComputerState<R, G::State>) -> R {
        let trim = self.trim_up(state);
        trim.horizontal().norm() / trim.z
    }

    /// Tilt of the vehicle beyond what lies between upright and trim, rad. A vehicle
    /// in the wind leans by its trim tilt, and stands upright on the deck.
    pub(super) fn tilt_beside_trim_rad(
        &self,
        state: &ComputerState<R, G::State>,
        attitude: Attitude<R>,
    ) -> R {
        let (up, trim) = (attitude.up(), self.trim_up(state));
        let angle = |to: Vector<R>| up.cross(to).norm().atan2(up.dot(to));
        attitude.tilt_rad().min(angle(trim))
    }

    /// Follows the slope of the approach: none up to [`UPRIGHT`], then `s (1 - (UPRIGHT/s)²)`
    /// of the trim's slope s. Camera and range finder look along the body's axis, so a vehicle
    /// that leans into the wind keeps the pad in view from upwind of it.
    pub(super) fn lean(&self, state: &mut ComputerState<R, G::State>, dt: R) {
        let trim = self.trim_up(state);
        let slope = trim.horizontal() * (R::ONE / trim.z);
        let size = slope.norm();
        let wanted = if size > r(UPRIGHT) {
            let share = r::<R>(UPRIGHT) / size;
            slope * (R::ONE - share * share)
        } else {
            Vector::ZERO
        };
        let follow = |now, then| lag_step(now, then, r(LEAN_S), dt);
        state.lean = Vector::new(
            follow(state.lean.x, wanted.x),
            follow(state.lean.y, wanted.y),
            R::ZERO,
        );
    }

    /// Distance from the axis of the approach, which ends at the pad, less what gusts of the
    /// wind that leans it move the vehicle, m.
    pub(super) fn off_axis_m(&self, state: &ComputerState<R, G::State>, motion: &Motion<R>) -> R {
        let above_m = (motion.position_m.z - self.contact_height_m).max(R::ZERO);
        let off_m = (motion.position_m.horizontal() - state.lean * above_m).norm();
        (off_m - r::<R>(GUSTS_M) * state.lean.norm()).max(R::ZERO)
    }
}
