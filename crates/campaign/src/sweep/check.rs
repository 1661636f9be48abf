//! Whether all that a sweep is going to fly can be flown.

use rayon::prelude::*;
use touchdown_sim::landing::space::SpaceLander;

use super::points::Sweep;
use super::row::number;
use crate::error::Result;

/// Landers that are built beforehand, beside those of extremes.
const BUILT: u64 = 1_000;
/// Trials whose draws are looked at for extremes.
const DRAWN: u64 = 100_000;

impl Sweep {
    /// Builds landers of every point: that of its trials where nothing is drawn; else of the trials with the least and
    /// the greatest draws, and of as many others as are built in a few seconds; and those of the ends of all that is
    /// drawn.
    pub(super) fn check(&self) -> Result<()> {
        SpaceLander::new(&self.settings.scenario).map_err(|e| self.bad("scenario", &e))?;
        let trials = self.telling();
        let count = trials.len() as u64;
        let failed = (0..self.points() * count)
            .into_par_iter()
            .find_map_first(|k| self.built(k / count, trials[(k % count) as usize]).err());
        failed.map_or(Ok(()), Err)?;
        self.check_ends()
    }

    /// Builds landers with the ends of every distribution, the others as trial 0 draws them,
    /// at the first point.
    fn check_ends(&self) -> Result<()> {
        let draws = self.draws(0);
        for (k, (_, of)) in self.random.iter().enumerate() {
            for [drawn, limit] in of.ends() {
                let built = |value| {
                    let mut with_it = draws.clone();
                    with_it[k] = value;
                    if !self.lifts(&with_it) {
                        return Ok(());
                    }
                    self.built_with(0, &with_it).map(drop)
                };
                // The limit, as its author wrote it, says more than the number next to it.
                built(drawn).map_err(|error| built(limit).err().unwrap_or(error))?;
            }
        }
        Ok(())
    }

    /// The trials whose landers tell of those of the others.
    fn telling(&self) -> Vec<u64> {
        if self.random.is_empty() {
            return vec![0];
        }
        let mut least = vec![(f64::INFINITY, 0); self.random.len()];
        let mut greatest = vec![(f64::NEG_INFINITY, 0); self.random.len()];
        for trial in 0..self.trials().min(DRAWN) {
            for (k, value) in self.draws(trial).iter().enumerate() {
                let Some(value) = number(value) else {
                    continue;
                };
                if value < least[k].0 {
                    least[k] = (value, trial);
                }
                if value > greatest[k].0 {
                    greatest[k] = (value, trial);
                }
            }
        }
        let extremes = least.into_iter().chain(greatest).map(|(_, trial)| trial);
        let others = 0..self.trials().min((BUILT / self.points()).max(1));
        let mut trials: Vec<u64> = others.chain(extremes).collect();
        trials.sort_unstable();
        trials.dedup();
        trials
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    fn read(text: &str) -> Result<Sweep> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("sweep.toml");
        std::fs::write(&file, text).unwrap();
        Sweep::read(&file, None, None)
    }

    #[test]
    fn prop_a_large_sweep_is_refused_for_its_extreme_draws() {
        let of = |sd: f64| {
            read(&format!(
                "trials = 50_000\n[random]\n\"plant.mass_kg\" = {{ kind = \"normal\", mean = 1.4, sd = {sd}, max = 2.0 }}\n"
            ))
        };
        // Of 50 000, the least is some four standard deviations below the mean.
        let error = of(0.37).map(|_| ()).unwrap_err().to_string();
        assert!(
            error.contains("plant.mass_kg") && error.contains("-0."),
            "{error}"
        );
        let sweep = of(0.1).unwrap();
        let trials = sweep.telling();
        let least = |trial: &u64| number(&sweep.draws(*trial)[0]).unwrap();
        let known = trials.iter().map(least).fold(f64::INFINITY, f64::min);
        let all = (0..50_000)
            .map(|trial| least(&trial))
            .fold(f64::INFINITY, f64::min);
        assert_eq!(known, all);
        assert!(trials.len() <= 1_002, "{} landers", trials.len());
    }

    #[test]
    fn prop_ends_that_are_never_drawn_are_not_refused() {
        let of = |min: f64| {
            read(&format!(
                "trials = 2\n[random]\n\"plant.rotor_lag_s\" = {{ kind = \"uniform\", min = {min}, max = 0.1 }}\n"
            ))
        };
        // A lag must be above 0, which draws from 0 on are.
        of(0.0).unwrap();
        // One of 1e12 draws is below 0, hardly one of these two.
        let error = of(-1e-13).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("plant.rotor_lag_s"), "{error}");
    }

    #[test]
    fn prop_trials_of_a_point_share_a_lander_unless_something_is_drawn() {
        let sweep = read("trials = 2\n[grid]\n\"timeout_s\" = [20.0, 30.0]\n").unwrap();
        let lander = |landing| sweep.lander(landing).unwrap();
        assert!(Arc::ptr_eq(&lander(0), &lander(1)));
        assert_eq!(lander(1).scenario().timeout_s, 20.0);
        assert_eq!(lander(2).scenario().timeout_s, 30.0);
        assert_eq!(lander(0).scenario().timeout_s, 20.0);
        // Threads may fly two points in turns.
        let first = lander(0);
        assert_eq!(lander(3).scenario().timeout_s, 30.0);
        assert!(Arc::ptr_eq(&lander(1), &first));
        let drawn = "trials = 2\n[random]\n\"timeout_s\" = { kind = \"uniform\", min = 20.0, max = 30.0 }\n";
        let sweep = read(drawn).unwrap();
        let timeout_s = |landing| sweep.lander(landing).unwrap().scenario().timeout_s;
        assert_ne!(timeout_s(0), timeout_s(1));
    }
}
