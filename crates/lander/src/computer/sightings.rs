//! Queue that gives the deck's heights a constant age.

use crate::estimate::relative::DeckSighting;
use touchdown_flight::real::{Real, r};

/// Largest number of waiting sightings: one for each step, 0.64 s at 100 Hz.
const MOST: usize = 64;

/// A queue by age. Sightings leave it at the age `age_s + extra_age_s`. If they arrive
/// later than that, `extra_age_s` grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sightings<R> {
    /// Those that wait; the age of a free place is minus infinity.
    waiting: [DeckSighting<R>; MOST],
    /// Additional age at which sightings leave, s.
    extra_age_s: R,
    /// Additional age that sightings with a higher latency require, s.
    wanted_extra_age_s: R,
}

/// A place in the queue without a sighting.
fn free<R: Real>() -> DeckSighting<R> {
    DeckSighting {
        displacement_m: R::ZERO,
        sd_m: R::ZERO,
        age_s: r(f64::NEG_INFINITY),
    }
}

impl<R: Real> Default for Sightings<R> {
    fn default() -> Self {
        Self {
            waiting: [free(); MOST],
            extra_age_s: R::ZERO,
            wanted_extra_age_s: R::ZERO,
        }
    }
}

impl<R: Real> Sightings<R> {
    /// Advances by `dt` seconds and adds a sighting, if there is one. Returns the most
    /// precise height of those that have reached the age `age_s + extra_age_s` (to half a
    /// step), and the time since the previous one left. That time does not advance while
    /// `extra_age_s` grows.
    pub(super) fn step(&mut self, new: Option<DeckSighting<R>>, age_s: R, dt: R) -> (Option<R>, R) {
        let half = r::<R>(0.5) * dt;
        for waiting in &mut self.waiting {
            waiting.age_s += dt;
        }
        if let Some(new) = new {
            if new.age_s > age_s + self.wanted_extra_age_s + half {
                self.wanted_extra_age_s = new.age_s - age_s;
            }
            let free = |place: &&mut DeckSighting<R>| place.age_s == r(f64::NEG_INFINITY);
            if let Some(place) = self.waiting.iter_mut().find(free) {
                *place = new;
            }
        }
        let grown_s = (self.wanted_extra_age_s - self.extra_age_s).min(dt);
        self.extra_age_s += grown_s;
        let due = age_s + self.extra_age_s - half;
        let mut best: Option<DeckSighting<R>> = None;
        for place in &mut self.waiting {
            let sighting = *place;
            if sighting.age_s >= due {
                *place = free();
                // A sighting older than the queue's age waits until that age has grown.
                if sighting.age_s > due + dt {
                    continue;
                }
                if best.is_none_or(|best| sighting.sd_m < best.sd_m) {
                    best = Some(sighting);
                }
            }
        }
        (best.map(|sighting| sighting.displacement_m), dt - grown_s)
    }

    /// Becomes an empty queue in place.
    pub(super) fn reset(&mut self) {
        for waiting in &mut self.waiting {
            *waiting = free();
        }
        (self.extra_age_s, self.wanted_extra_age_s) = (R::ZERO, R::ZERO);
    }

    /// Additional age at which sightings leave, s.
    pub(super) fn extra_age_s(&self) -> R {
        self.extra_age_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sighting(age_s: f64, displacement_m: f64, sd_m: f64) -> DeckSighting<f64> {
        DeckSighting {
            displacement_m,
            sd_m,
            age_s,
        }
    }

    #[test]
    fn analytic_sightings_come_out_evenly_old_and_the_clearest_first() {
        let mut queue = Sightings::default();
        let mut step = |new| {
            let (height, elapsed_s) = queue.step(new, 0.05, 0.01);
            assert!((elapsed_s - 0.01).abs() < 1e-12);
            height
        };
        // Ages at each step of 10 ms; due at 50 ms.
        assert_eq!(step(Some(sighting(0.02, 1.0, 0.005))), None);
        assert_eq!(step(Some(sighting(0.03, 2.0, 0.002))), None);
        assert_eq!(step(None), None);
        // Both are 50 ms old: the clearer one.
        assert_eq!(step(None), Some(2.0));
        assert_eq!(step(None), None);
        assert_eq!(queue.extra_age_s(), 0.0);
    }

    #[test]
    fn analytic_where_sightings_come_later_the_queue_falls_behind_once() {
        // The height is the time at which it was taken; from 0.5 s on 0.12 s old, once 0.14 s.
        let mut queue = Sightings::default();
        let (mut now, mut clock) = (0.0, -0.05);
        for i in 0..200 {
            now += 0.01;
            let age_s = match i {
                0..50 => 0.03,
                100 => 0.14,
                _ => 0.12,
            };
            let new = sighting(age_s, now - age_s, 0.002);
            let (height, elapsed_s) = queue.step(Some(new), 0.05, 0.01);
            clock += elapsed_s;
            // What leaves is of the time that the clock tells, to half a step.
            assert!((now - clock - 0.05 - queue.extra_age_s()).abs() < 1e-9);
            if let Some(height) = height {
                assert!((height - clock).abs() < 0.0051, "{i} {height} {clock}");
            }
        }
        assert!((queue.extra_age_s() - 0.09).abs() < 1e-9);
    }

    #[test]
    fn prop_no_more_than_fit_wait_and_all_leave() {
        let mut queue = Sightings::default();
        let mut out = 0;
        for _ in 0..100 {
            out += usize::from(
                queue
                    .step(Some(sighting(0.0, 0.0, 1.0)), 0.2, 0.01)
                    .0
                    .is_some(),
            );
        }
        // All but those of the last 20 steps.
        assert_eq!(out, 80);
    }
}
