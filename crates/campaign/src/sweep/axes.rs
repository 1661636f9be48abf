//! What a sweep varies, read from its settings and checked.

use toml::Value;

use super::draw::Distribution;
use super::keys::{distributions, lists, twice};
use super::settings::SweepSettings;
use crate::error::{Error, Result};

/// The most points of a grid.
const POINTS: u64 = 100_000;
/// The most landings of a campaign.
pub(super) const LANDINGS: u64 = 100_000_000;

/// The error of a key of the sweep file.
pub(super) type KeyError<'a> = dyn Fn(&str, &str) -> Error + 'a;

/// The axes of a sweep: keys with all their values, and keys with the distribution of their random values, both sorted.
pub(super) struct Axes {
    pub(super) grid: Vec<(String, Vec<Value>)>,
    pub(super) random: Vec<(String, Distribution)>,
}

/// Whether a key belongs to the vehicle or to its delays, of which the flight software has a belief.
fn of_vehicle(key: &str) -> bool {
    let delays = ["command_delay_s", "sensors.imu.latency_s"];
    let tops = ["plant", "body", "believed", "truth"];
    delays.contains(&key) || tops.contains(&key.split('.').next().unwrap_or(key))
}

/// Whether a key changes thrust over weight of the true vehicle.
pub(super) fn of_lift(key: &str) -> bool {
    let keys = [
        "plant",
        "plant.mass_kg",
        "plant.gravity_mps2",
        "truth",
        "truth.mass",
        "truth.thrust",
    ];
    keys.contains(&key) || key.starts_with("plant.motor")
}

/// Whether a key changes where a landing can begin.
pub(super) fn of_start(key: &str) -> bool {
    let tops = ["start_m", "start_sd_m", "landed_height_m", "crash"];
    tops.contains(&key.split('.').next().unwrap_or(key))
}

impl Axes {
    pub(super) fn of(settings: &SweepSettings, bad: &KeyError<'_>) -> Result<Self> {
        let mut grid = Vec::new();
        lists("", &settings.grid, &mut grid)
            .map_err(|(key, message)| bad(&format!("grid.{key}"), &message))?;
        let mut random = Vec::new();
        distributions("", &settings.random, &mut random)
            .map_err(|(key, message)| bad(&format!("random.{key}"), &message))?;
        grid.sort_by(|a, b| a.0.cmp(&b.0));
        random.sort_by(|a, b| a.0.cmp(&b.0));
        let axes = Self { grid, random };
        let keys: Vec<&String> = axes.keys().collect();
        for (i, key) in keys.iter().enumerate() {
            let clashes = |other: &&&String| {
                key == *other
                    || key.starts_with(&format!("{other}."))
                    || other.starts_with(&format!("{key}."))
            };
            if let Some(other) = keys[..i].iter().find(clashes) {
                let message = if key == other {
                    "is swept twice: expected it in [grid] or in [random], found it in both"
                        .to_owned()
                } else {
                    format!("is swept twice; `{other}` sweeps it as well")
                };
                return Err(bad(key, &message));
            }
        }
        Ok(axes)
    }

    fn keys(&self) -> impl Iterator<Item = &String> {
        let random = self.random.iter().map(|r| &r.0);
        self.grid.iter().map(|g| &g.0).chain(random)
    }

    pub(super) fn set_the_deck(&self) -> bool {
        self.keys().any(|k| k == "deck" || k.starts_with("deck."))
    }

    /// Whether a key of the vehicle, its belief or its truth is swept or drawn.
    pub(super) fn set_the_vehicle(&self) -> bool {
        self.keys().any(|key| of_vehicle(key))
    }

    /// Refuses grids with too many points or a value that stands twice, and campaigns with too many landings.
    pub(super) fn check_size(&self, trials: u64, bad: &KeyError<'_>) -> Result<()> {
        let points = self
            .grid
            .iter()
            .try_fold(1_u64, |n, (_, values)| n.checked_mul(values.len() as u64));
        let Some(points) = points.filter(|n| *n <= POINTS) else {
            let found = points.map_or("more".to_string(), |n| n.to_string());
            let message = format!("expected at most {POINTS} points, found {found}");
            return Err(bad("grid", &message));
        };
        for (key, values) in &self.grid {
            if let Some(value) = twice(values) {
                return Err(bad(
                    &format!("grid.{key}"),
                    &format!("{value} stands twice"),
                ));
            }
        }
        if points.checked_mul(trials).is_none_or(|n| n > LANDINGS) {
            let message = format!(
                "expected at most {LANDINGS} landings in all, found {trials} at each of {points} points"
            );
            return Err(bad("trials", &message));
        }
        Ok(())
    }
}
