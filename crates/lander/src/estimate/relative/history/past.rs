//! Attitudes and motion at past times.

use super::History;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

/// Share of a step below which two times are equal: the rounding of ages in `f32`.
const ROUNDING: f64 = 1e-5;

/// A node, and the time from it to the newest one, s.
pub(super) type Place<R> = (u64, R);

/// A walk back into the history. Ages must not decrease from call to call, so that no node is passed twice.
pub(crate) struct Past<'a, R, const N: usize, const M: usize> {
    history: &'a History<R, N, M>,
    /// Age of the newest node, s.
    delay_s: R,
    /// How far the attitudes and the motion have been passed.
    attitudes: Place<R>,
    motion: Place<R>,
}

impl<'a, R: Real, const N: usize, const M: usize> Past<'a, R, N, M> {
    pub(in crate::estimate::relative) fn new(history: &'a History<R, N, M>, delay_s: R) -> Self {
        Self {
            history,
            delay_s,
            attitudes: history.now(),
            motion: history.now(),
        }
    }

    /// The attitude at the time of a reading of this age, interpolated between IMU samples; beyond the memory the oldest one.
    pub(crate) fn attitude_at(&mut self, age_s: R) -> Attitude<R> {
        let back = age_s - self.delay_s;
        self.history.attitude(&mut self.attitudes, back)
    }

    /// Change of velocity (m/s) and position (m) that the measured acceleration causes
    /// between `from_s` and `to_s` ago. Gravity is removed, the bias is not. Before the memory, its oldest acceleration is held.
    /// None if `to_s` is beyond the memory, or if `from_s` is before the first step.
    pub(crate) fn moved(&mut self, from_s: R, to_s: R) -> Option<[Vector<R>; 2]> {
        let (from, to) = (from_s - self.delay_s, to_s - self.delay_s);
        self.history.moved(&mut self.motion, from, to)
    }
}

impl<R: Real, const N: usize, const M: usize> History<R, N, M> {
    /// The newest node.
    pub(super) fn now(&self) -> Place<R> {
        (self.head, R::ZERO)
    }

    /// The node at or before a time, and the time since that node. Times closer to a node
    /// than rounding count as the node's. The walk begins at a newer place, and moves it to the last node passed.
    pub(super) fn time_at(&self, place: &mut Place<R>, back: R) -> Option<(u64, R)> {
        let (mut node, mut end) = *place;
        let mut left = back - end;
        if left <= R::ZERO {
            return Some((node, -left));
        }
        loop {
            let dt = self.nodes[Self::slot(node)].dt;
            let close = dt * r(ROUNDING);
            if left <= close {
                return Some((node, R::ZERO));
            }
            if node == self.oldest() {
                return None;
            }
            node -= 1;
            if left < dt - close {
                return Some((node, dt - left));
            }
            left = (left - dt).max(R::ZERO);
            end += dt;
            *place = (node, end);
        }
    }

    /// The attitude `back` seconds before the newest node, or the oldest known.
    pub(in crate::estimate::relative) fn attitude(
        &self,
        place: &mut Place<R>,
        back: R,
    ) -> Attitude<R> {
        let Some((node, offset)) = self.time_at(place, back.finite_or(R::ZERO).max(R::ZERO)) else {
            return self.nodes[Self::slot(self.oldest())].attitude;
        };
        let here = &self.nodes[Self::slot(node)];
        if offset > R::ZERO && node < self.head {
            let after = &self.nodes[Self::slot(node + 1)];
            here.attitude.between(after.attitude, offset / after.dt)
        } else {
            here.attitude
        }
    }

    /// Change of velocity and position that the acceleration causes between two times,
    /// `from` and `to` seconds before the newest node. The acceleration is held after the newest node and before the oldest one. None
    /// if `to` is before the oldest node, or if `from` is before the first step.
    fn moved(&self, place: &mut Place<R>, from: R, to: R) -> Option<[Vector<R>; 2]> {
        let (mut faster, mut farther) = (Vector::ZERO, Vector::ZERO);
        let mut add = |acceleration: Vector<R>, start: R, end: R| {
            let (start, end) = (start.min(from), end.max(to));
            if start > end {
                let middle = (start + end) * r(0.5);
                faster += acceleration * (start - end);
                farther += acceleration * ((start - end) * (middle - to));
            }
        };
        add(self.newest().acceleration_mps2, R::ZERO, to.min(R::ZERO));
        let (mut node, mut end) = *place;
        let oldest = self.oldest();
        while end < from {
            let here = &self.nodes[Self::slot(node)];
            let mut start = end + here.dt;
            if node == oldest {
                if oldest == 0 || end < to {
                    return None;
                }
                start = from;
            }
            node -= 1;
            // A newer node has no part in it, nor in what is older.
            if start > to {
                add(here.acceleration_mps2, start, end);
            } else {
                *place = (node, start);
            }
            end = start;
        }
        (from >= to).then_some([faster, farther])
    }
}
