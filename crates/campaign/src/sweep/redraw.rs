//! Draws of vehicles that do not lift themselves, and of starts from which no landing can begin, are replaced and counted.

use rayon::prelude::*;
use toml::{Table, Value};
use touchdown_flight::thrust::LEAST_THRUST_TO_WEIGHT;
use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::landing::space::{TruthSettings, thrust_to_weight};

use super::axes::{of_lift, of_start};
use super::keys::set;
use super::points::Sweep;
use crate::error::Result;

/// Draws of one trial that are replaced before the sweep is refused. With half of all draws too heavy, one trial in 1e30
/// needs as many. Half as many refuses nothing sooner that matters; twice as many takes longer to refuse.
const MOST_REDRAWS: u32 = 100;

/// Thrust over weight that no multirotor exceeds: racing quadrotors have up to about 15. Up to here landings are as usual; at a
/// few hundred all crash.
const MOST_THRUST_TO_WEIGHT: f64 = 20.0;

impl Sweep {
    /// The drawn values of a trial, and how many draws they replace: those whose true vehicle has a thrust over weight
    /// below 1.3 at a point of the grid. All values of a trial are drawn again together.
    pub(super) fn accepted(&self, trial: u64) -> (Vec<Value>, u32) {
        let seed = self.settings.seed;
        let draws = |n: u32| -> Vec<Value> {
            let drawn = self.random.iter();
            drawn
                .map(|(key, of)| match n {
                    0 => of.draw(seed, trial, key),
                    n => of.redraw(seed, trial, key, n),
                })
                .collect()
        };
        for n in 0..MOST_REDRAWS {
            let drawn = draws(n);
            if self.lifts(&drawn) {
                return (drawn, n);
            }
        }
        (draws(MOST_REDRAWS), MOST_REDRAWS)
    }

    /// Draws that were replaced in all trials.
    pub(super) fn redrawn(&self) -> u64 {
        if !self.random.iter().any(|(key, _)| of_lift(key)) {
            return 0;
        }
        (0..self.trials())
            .map(|trial| u64::from(self.accepted(trial).1))
            .sum()
    }

    /// Draws of starts that were replaced in all landings.
    pub(super) fn redrawn_starts(&self) -> Result<u64> {
        // An autopilot in the loop starts on the deck.
        if self.settings.autopilot.is_some() {
            return Ok(0);
        }
        let seed = self.settings.seed;
        let drawn = self.random.iter().any(|(key, _)| of_start(key));
        let of_point = |point: u64| -> Result<u64> {
            let shared = self.scenario(point)?;
            let of_trial = |trial| -> Result<u64> {
                let redrawn = if drawn {
                    let (own, _) = self.scenario_with(point, &self.draws(trial))?;
                    own.redrawn_starts(trial, seed)
                } else {
                    shared.redrawn_starts(trial, seed)
                };
                Ok(u64::from(redrawn))
            };
            (0..self.trials()).map(of_trial).sum()
        };
        (0..self.points()).into_par_iter().map(of_point).sum()
    }

    /// Refuses a trial whose draws never lift.
    pub(super) fn check_redrawn(&self, trial: u64, redrawn: u32) -> Result<()> {
        if redrawn < MOST_REDRAWS {
            return Ok(());
        }
        let expected =
            format!("expected a thrust over weight of at least {LEAST_THRUST_TO_WEIGHT}");
        let swept = self.lifts_of_points().into_iter();
        if let Some((point, lift)) = swept.min_by(|a, b| a.1.total_cmp(&b.1))
            && lift < LEAST_THRUST_TO_WEIGHT
        {
            let message = format!("{expected}; found {lift:.2} at point {point}, without a draw");
            return Err(self.bad("grid", &message));
        }
        let message = format!("{expected}; found less in {MOST_REDRAWS} draws of trial {trial}");
        Err(self.bad("random", &message))
    }

    /// Whether the true vehicle lifts itself with these draws at all points of the grid. Values that no vehicle has are
    /// left for its own checks.
    pub(super) fn lifts(&self, draws: &[Value]) -> bool {
        let drawn: Vec<(&str, &Value)> = self
            .random
            .iter()
            .zip(draws)
            .filter(|((key, _), _)| of_lift(key))
            .map(|((key, _), value)| (key.as_str(), value))
            .collect();
        if drawn.is_empty() {
            return true;
        }
        let points = if self.sweeps_lift() { self.points() } else { 1 };
        (0..points).all(|point| {
            let swept = self.values(point).into_iter();
            let keys = swept.filter(|(key, _)| of_lift(key)).chain(drawn.clone());
            self.lift(keys)
                .is_none_or(|lift| lift >= LEAST_THRUST_TO_WEIGHT)
        })
    }

    /// What is said of a true vehicle, or of points of the grid, with a thrust over weight below 1.3, or above that of any multirotor.
    /// They are flown: what is stated is meant.
    #[must_use]
    pub fn lift_warning(&self) -> Option<String> {
        // Draws are replaced until all points lift.
        if self.random.iter().any(|(key, _)| of_lift(key)) {
            return None;
        }
        let lifts: Vec<f64> = self
            .lifts_of_points()
            .iter()
            .map(|(_, lift)| *lift)
            .collect();
        let of = |beyond: &dyn Fn(f64) -> bool| -> Vec<f64> {
            lifts.iter().copied().filter(|lift| beyond(*lift)).collect()
        };
        let low = of(&|lift| lift < LEAST_THRUST_TO_WEIGHT);
        let high = of(&|lift| lift > MOST_THRUST_TO_WEIGHT);
        let points = self.points();
        if let Some(least) = low.iter().copied().reduce(f64::min) {
            return Some(if self.sweeps_lift() {
                format!(
                    "{} of {points} points have a greatest thrust below {LEAST_THRUST_TO_WEIGHT} times the weight, the least {least:.3} times",
                    low.len()
                )
            } else {
                format!(
                    "the vehicle has a greatest thrust of {least:.3} times its weight; expected at least {LEAST_THRUST_TO_WEIGHT}"
                )
            });
        }
        let most = high.iter().copied().reduce(f64::max)?;
        Some(if self.sweeps_lift() {
            format!(
                "{} of {points} points have a greatest thrust above {MOST_THRUST_TO_WEIGHT} times the weight, the greatest {most:.0} times: \
                 are mass and thrust in kg and N?",
                high.len()
            )
        } else {
            format!(
                "the vehicle has a greatest thrust of {most:.0} times its weight; expected at most {MOST_THRUST_TO_WEIGHT}: are mass and \
                 thrust in kg and N?"
            )
        })
    }

    /// Whether points of the grid differ in the thrust over weight.
    fn sweeps_lift(&self) -> bool {
        self.grid.iter().any(|(key, _)| of_lift(key))
    }

    /// Points of the grid and their thrust over weight, without draws; the first alone, where the grid does not change it. Values that
    /// no vehicle has are left out.
    fn lifts_of_points(&self) -> Vec<(u64, f64)> {
        let points = if self.sweeps_lift() { self.points() } else { 1 };
        let of_point = |point| {
            let swept = self.values(point).into_iter();
            let lift = self.lift(swept.filter(|(key, _)| of_lift(key)))?;
            Some((point, lift))
        };
        (0..points).filter_map(of_point).collect()
    }

    /// Thrust over weight of the true vehicle with these values.
    fn lift<'a>(&self, keys: impl Iterator<Item = (&'a str, &'a Value)>) -> Option<f64> {
        let part = |name: &str| Some((name.to_string(), self.base.get(name)?.clone()));
        let mut table: Table = ["plant", "truth"].into_iter().filter_map(part).collect();
        for (key, value) in keys {
            set(&mut table, key, value).ok()?;
        }
        let plant: PlantSettings = table.remove("plant")?.try_into().ok()?;
        let truth: TruthSettings = table.remove("truth")?.try_into().ok()?;
        thrust_to_weight(&truth.plant(&plant)).ok()
    }
}
