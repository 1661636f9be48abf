//! Whether all that a sweep is going to fly can be flown.

use std::collections::BTreeSet;
use std::ops::Range;

use rayon::prelude::*;
use touchdown_sim::landing::space::SpaceLander;

use super::part::CampaignPart;
use super::points::Sweep;
use super::row::number;
use crate::error::Result;

/// Landers that are built beforehand for a whole campaign, beside those of extremes.
const BUILT: u64 = 1_000;
/// Landings whose draws are looked at for extremes.
const DRAWN: usize = 100_000;

impl Sweep {
    /// Builds landers of a part of the campaign: one of every point that it flies; where something is drawn, those of the
    /// trials with the least and the greatest draws, and as many others as are built in a few seconds; and those of the
    /// ends of all that is drawn.
    pub(super) fn check(&self, part: CampaignPart) -> Result<()> {
        SpaceLander::new(&self.settings.scenario).map_err(|e| self.bad("scenario", &e))?;
        let failed = self.telling(part).into_par_iter().find_map_first(|k| {
            let built = self.built(k / self.trials(), k % self.trials());
            built.err()
        });
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

    /// The landings of a part whose landers tell of those of the others.
    fn telling(&self, part: CampaignPart) -> Vec<u64> {
        let own: Vec<Range<u64>> = part.blocks(self.blocks()).map(|b| self.range(b)).collect();
        let trials = self.trials();
        let mut telling: Vec<u64> = own
            .iter()
            .flat_map(|of| {
                let points = of.start / trials..of.end.div_ceil(trials);
                points.map(|point| (point * trials).max(of.start))
            })
            .collect();
        telling.dedup_by_key(|landing| *landing / trials);
        if self.random.is_empty() {
            return telling;
        }
        let extremes = self.extreme_trials(&own);
        let points = telling.clone().into_iter().map(|landing| landing / trials);
        let at = points.flat_map(|point| extremes.iter().map(move |trial| point * trials + trial));
        let extremes: Vec<u64> = at
            .filter(|landing| part.holds(landing / self.settings.block))
            .collect();
        let count: u64 = own.iter().map(|of| of.end - of.start).sum();
        // All parts together build as many as one run of the whole.
        let built = (BUILT * count).div_ceil(self.landings()).max(1);
        let step = usize::try_from(count.div_ceil(built)).unwrap_or(usize::MAX);
        telling.extend(own.into_iter().flatten().step_by(step.max(1)));
        telling.extend(extremes);
        telling.sort_unstable();
        telling.dedup();
        telling
    }

    /// The trials among those of these landings with the least and the greatest value of each key that is drawn.
    fn extreme_trials(&self, own: &[Range<u64>]) -> BTreeSet<u64> {
        let of_trials = own.iter().cloned().flatten().map(|k| k % self.trials());
        let looked_at: BTreeSet<u64> = of_trials.take(DRAWN).collect();
        let mut least = vec![(f64::INFINITY, None); self.random.len()];
        let mut greatest = vec![(f64::NEG_INFINITY, None); self.random.len()];
        for trial in looked_at {
            for (k, value) in self.draws(trial).iter().enumerate() {
                let Some(value) = number(value) else {
                    continue;
                };
                if value < least[k].0 {
                    least[k] = (value, Some(trial));
                }
                if value > greatest[k].0 {
                    greatest[k] = (value, Some(trial));
                }
            }
        }
        let extremes = least.into_iter().chain(greatest);
        extremes.filter_map(|(_, trial)| trial).collect()
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
        let trials = sweep.telling(CampaignPart::Whole);
        let least = |trial: &u64| number(&sweep.draws(*trial)[0]).unwrap();
        let known = trials.iter().map(least).fold(f64::INFINITY, f64::min);
        let all = (0..50_000)
            .map(|trial| least(&trial))
            .fold(f64::INFINITY, f64::min);
        assert_eq!(known, all);
        assert!(trials.len() <= 1_003, "{} landers", trials.len());
    }

    #[test]
    fn prop_a_part_looks_at_its_own_landings_and_no_others() {
        let settings = "trials = 5_000\nblock = 100\n[grid]\n\"timeout_s\" = [20.0, 30.0, 40.0]\n";
        let random =
            "[random]\n\"ground_effect_strength\" = { kind = \"normal\", mean = 0.6, sd = 0.1 }\n";
        let of = |text: &str| read(&format!("{settings}{text}")).unwrap();
        let shards = |of| (1..=of).map(move |i| format!("{i}/{of}").parse().unwrap());
        for (text, most) in [("", 3), (random, 1_000 + 3 + 6)] {
            let sweep = of(text);
            let whole = sweep.telling(CampaignPart::Whole);
            assert!((3..=most).contains(&whole.len()), "{}", whole.len());
            let mut built = 0;
            for shard in shards(75) {
                let part = CampaignPart::Shard(shard);
                let telling = sweep.telling(part);
                assert!(telling.iter().all(|landing| part.holds(landing / 100)));
                // Every point that it flies: it has two blocks, 75 blocks and so one or two points apart.
                let points = |landings: &mut dyn Iterator<Item = u64>| -> BTreeSet<u64> {
                    landings.map(|landing| landing / 5_000).collect()
                };
                let flown = part
                    .blocks(sweep.blocks())
                    .flat_map(|block| sweep.range(block));
                assert_eq!(points(&mut telling.iter().copied()), points(&mut { flown }));
                built += telling.len();
            }
            // Beside extremes and a landing of each point, as many as one run looks at.
            assert!(built <= 1_000 + 75 * (2 + 2 + 4), "{built}");
        }
        // The extremes are those of the part's own trials.
        let sweep = of(random);
        let part = CampaignPart::Blocks("7..8".parse().unwrap());
        let value = |trial: u64| number(&sweep.draws(trial)[0]).unwrap();
        let least = (700..800).min_by(|a, b| value(*a).total_cmp(&value(*b)));
        assert!(sweep.telling(part).contains(&least.unwrap()));
        // A part that nobody else flies is empty.
        let none = CampaignPart::Shard("200/200".parse().unwrap());
        assert!(sweep.telling(none).is_empty());
    }

    #[test]
    fn prop_a_fault_is_found_by_the_part_that_flies_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("sweep.toml");
        let text = "trials = 10\nblock = 10\n[grid]\n\"timeout_s\" = [20.0, -1.0]\n";
        std::fs::write(&file, text).unwrap();
        let of = |range: &str| {
            let part = CampaignPart::Blocks(range.parse().unwrap());
            Sweep::read_part(&file, None, None, part)
        };
        of("0..1").unwrap();
        let error = of("1..2").unwrap_err().to_string();
        assert!(error.contains("timeout_s"), "{error}");
        assert!(of("0..2").is_err() && of("1..3").is_err());
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
