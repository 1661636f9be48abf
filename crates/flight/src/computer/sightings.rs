//! Heights of the deck that wait until they are evenly old.

use crate::estimate::relative::DeckSighting;
use crate::real::{Real, r};

/// Most sightings that wait.
const MOST: usize = 32;

/// A queue by age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sightings<R> {
    waiting: [Option<DeckSighting<R>>; MOST],
}

impl<R: Real> Default for Sightings<R> {
    fn default() -> Self {
        Self {
            waiting: [None; MOST],
        }
    }
}

impl<R: Real> Sightings<R> {
    /// `dt` seconds later, with a new sighting, if there is one: the clearest
    /// height of those that have reached the age (to half a step).
    pub(super) fn step(&mut self, new: Option<DeckSighting<R>>, age_s: R, dt: R) -> Option<R> {
        for waiting in self.waiting.iter_mut().flatten() {
            waiting.age_s += dt;
        }
        if let (Some(new), Some(free)) = (new, self.waiting.iter_mut().find(|w| w.is_none())) {
            *free = Some(new);
        }
        let due = age_s - r::<R>(0.5) * dt;
        let mut best: Option<DeckSighting<R>> = None;
        for slot in &mut self.waiting {
            if let Some(sighting) = slot.filter(|sighting| sighting.age_s >= due) {
                *slot = None;
                if best.is_none_or(|best| sighting.sd_m < best.sd_m) {
                    best = Some(sighting);
                }
            }
        }
        best.map(|sighting| sighting.displacement_m)
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
        // Ages at each step of 10 ms; due at 50 ms.
        assert_eq!(
            queue.step(Some(sighting(0.02, 1.0, 0.005)), 0.05, 0.01),
            None
        );
        assert_eq!(
            queue.step(Some(sighting(0.03, 2.0, 0.002)), 0.05, 0.01),
            None
        );
        assert_eq!(queue.step(None, 0.05, 0.01), None);
        // Both are 50 ms old: the clearer one.
        assert_eq!(queue.step(None, 0.05, 0.01), Some(2.0));
        assert_eq!(queue.step(None, 0.05, 0.01), None);
        // One that is older already comes at once.
        assert_eq!(
            queue.step(Some(sighting(0.2, 3.0, 0.1)), 0.05, 0.01),
            Some(3.0)
        );
    }

    #[test]
    fn prop_no_more_than_fit_wait_and_all_leave() {
        let mut queue = Sightings::default();
        let mut out = 0;
        for _ in 0..100 {
            out += usize::from(
                queue
                    .step(Some(sighting(0.0, 0.0, 1.0)), 0.2, 0.01)
                    .is_some(),
            );
        }
        // All but those of the last 20 steps.
        assert_eq!(out, 80);
    }
}
