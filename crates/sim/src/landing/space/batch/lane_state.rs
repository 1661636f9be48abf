//! State taken out of a lane, or put into one.

use crate::body::cascade::{AttitudeSetpoint, Setpoint};
use crate::body::contact::{Foot, FootState};
use crate::body::rigid::{MotionState, RigidState};
use crate::deck::rigid::DeckPose;
use crate::landing::space::touchdown::DeckState;
use crate::number::Number;
use crate::number::vector::sub;

/// The true state that the controller of a lane is given, in world axes: place and velocity of the
/// vehicle relative to the deck's centre, and the deck's motion.
pub(super) struct LaneState<N> {
    pub(super) place_m: [N; 3],
    pub(super) relative_mps: [N; 3],
    pub(super) velocity_mps: [N; 3],
    pub(super) acceleration_mps2: [N; 3],
    pub(super) attitude: [N; 4],
    pub(super) normal: [N; 3],
    pub(super) deck_mps2: [N; 3],
}

impl<N: Number> LaneState<N> {
    #[inline(always)]
    pub(super) fn of_all(
        state: &MotionState<N>,
        deck: &DeckPose<N>,
        acceleration_mps2: [N; 3],
    ) -> Self {
        Self {
            place_m: sub(state.position_m, deck.origin_m),
            relative_mps: sub(state.velocity_mps, deck.velocity_mps),
            velocity_mps: state.velocity_mps,
            acceleration_mps2,
            attitude: state.attitude,
            normal: deck.axes[2],
            deck_mps2: deck.acceleration_mps2,
        }
    }

    /// The state of one lane.
    pub(super) fn of(&self, lane: usize) -> LaneState<f64> {
        let of = |[x, y, z]: [N; 3]| [x.get(lane), y.get(lane), z.get(lane)];
        let [w, x, y, z] = self.attitude;
        LaneState {
            place_m: of(self.place_m),
            relative_mps: of(self.relative_mps),
            velocity_mps: of(self.velocity_mps),
            acceleration_mps2: of(self.acceleration_mps2),
            attitude: [w.get(lane), x.get(lane), y.get(lane), z.get(lane)],
            normal: of(self.normal),
            deck_mps2: of(self.deck_mps2),
        }
    }
}

/// State of all lanes relative to their decks.
pub(super) struct DeckStates<N: Number> {
    pub(super) place_m: [N; 3],
    pub(super) velocity_mps: [N; 3],
    pub(super) tilt_rad: N,
    pub(super) feet: [FootState<N>; 4],
    /// 1 where a foot slides.
    pub(super) slides: [N; 4],
}

impl<N: Number> DeckStates<N> {
    /// The state of one lane, and its feet.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize, before_mps: N) -> (DeckState, [Foot; 4]) {
        let ([a, b, c], [u, v, w]) = (&self.place_m, &self.velocity_mps);
        let mut feet = [Foot::default(); 4];
        for i in 0..4 {
            let (foot, slides) = (&self.feet[i], &self.slides[i]);
            feet[i] = Foot {
                depth_m: foot.depth_m.get(lane),
                place_m: [foot.place_m[0].get(lane), foot.place_m[1].get(lane)],
                force_n: [
                    foot.force_n[0].get(lane),
                    foot.force_n[1].get(lane),
                    foot.force_n[2].get(lane),
                ],
                slides: slides.get(lane) > 0.0,
            };
        }
        let standing = DeckState {
            place_m: [a.get(lane), b.get(lane), c.get(lane)],
            velocity_mps: [u.get(lane), v.get(lane), w.get(lane)],
            before_mps: before_mps.get(lane),
            tilt_rad: self.tilt_rad.get(lane),
        };
        (standing, feet)
    }
}

pub(super) fn ask_for<N: Number>(
    wanted: &mut Setpoint<N>,
    lane: usize,
    setpoint: &AttitudeSetpoint,
) {
    wanted.thrust_n = wanted.thrust_n.with(lane, setpoint.thrust_n);
    wanted.yaw_rate = wanted.yaw_rate.with(lane, setpoint.yaw_rate);
    for k in 0..4 {
        wanted.attitude[k] = wanted.attitude[k].with(lane, setpoint.attitude[k]);
    }
    for rate in wanted.body_rates.iter_mut().flatten() {
        *rate = rate.with(lane, 0.0);
    }
}

pub(super) fn state_of<N: Number>(state: &MotionState<N>, lane: usize) -> RigidState {
    let mut one = RigidState::default();
    one.take(&MotionState::from_array(
        &state.to_array().map(|value| value.get(lane)),
    ));
    one
}
