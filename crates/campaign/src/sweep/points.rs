//! A checked sweep: its points, its draws, and the landing computer and vehicle of each landing.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use sha2::{Digest as _, Sha256};
use toml::{Table, Value};
use touchdown_files::TomlError;
use touchdown_model::Card;
use touchdown_sim::deck::rigid::{RigidDeck, RigidMotion};
use touchdown_sim::landing::space::{SpaceLander, SpaceScenario};

use super::axes::{Axes, LANDINGS};
use super::beside::FilesBeside;
use super::draw::Distribution;
use super::keys::set;
use super::part::CampaignPart;
use super::policy::{is_policy, names_policy, policy_of};
use super::recent::RecentlyUsed;
use super::settings::SweepSettings;
use super::store::SWEEP;
use super::{software_in_the_loop, vehicle};
use crate::error::{Error, Result};
use crate::measured_deck::{MeasuredDeck, SERIES};
use crate::place::Place;
use crate::settings_file::{check_seed, to_toml};
use crate::vehicle::VehicleSettings;

/// A sweep that has been checked.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// As given, but for cards and `[vehicle]`, which have become part of `scenario`, and keys, which are dotted.
    pub(super) settings: SweepSettings,
    pub(super) base: Table,
    pub(super) grid: Vec<(String, Vec<Value>)>,
    pub(super) random: Vec<(String, Distribution)>,
    deck: Option<RigidDeck>,
    /// What the measured motion is, in a line.
    motion: Option<String>,
    /// What may be wrong with it, or with the vehicle.
    warnings: Vec<String>,
    /// What of the vehicle follows from `[vehicle]` and the thrust card, in a line.
    vehicle: Option<String>,
    pub(super) beside: FilesBeside,
    pub(super) file: String,
    sha256: String,
    /// The landers of points that were flown last, where all of their trials share them.
    flown: RecentlyUsed<SpaceLander>,
}

/// What is wrong with a measured motion beside one of the scenario.
const TWO_DECKS: &str = "the deck moves as measured: remove `scenario.deck` and its keys";

impl Sweep {
    /// Reads a sweep file with everything that it names; `trials` and `seed` override the file's.
    ///
    /// # Errors
    /// Files that cannot be read; keys and values that make no sense at any point of the grid or for any draw, with
    /// file, key, expected and found.
    pub fn read(path: &Path, trials: Option<u64>, seed: Option<u64>) -> Result<Self> {
        Self::read_part(path, trials, seed, CampaignPart::Whole)
    }

    /// As [`Self::read`], for a run that flies a part: only what the part flies is built beforehand.
    ///
    /// # Errors
    /// As [`Self::read`]; blocks that the campaign does not have.
    pub fn read_part(
        path: &Path,
        trials: Option<u64>,
        seed: Option<u64>,
        part: CampaignPart,
    ) -> Result<Self> {
        let sweep = Self::load(path, trials, seed)?;
        part.check(sweep.blocks())?;
        sweep.check(part)?;
        Ok(sweep)
    }

    /// As [`Self::read`], without building what is going to be flown: for sweeps that are checked, or compared with one
    /// that is.
    pub(super) fn load(path: &Path, trials: Option<u64>, seed: Option<u64>) -> Result<Self> {
        let mut settings = SweepSettings::read(path)?;
        settings.trials = trials.unwrap_or(settings.trials);
        settings.seed = seed.unwrap_or(settings.seed);
        let folder = path.parent().unwrap_or(Path::new("."));
        Self::unchecked(settings, folder, path.display().to_string())
    }

    /// The sweep of a campaign, from where its files are. It was checked when the campaign was begun, and is not again.
    ///
    /// # Errors
    /// A place without a campaign.
    pub fn of(place: &Place) -> Result<Self> {
        let path = place.path(SWEEP);
        if let Place::Folder(_) = place {
            return Self::load(&path, None, None);
        }
        let file = path.display().to_string();
        let settings = SweepSettings::parse(&String::from_utf8_lossy(&place.read(SWEEP)?), &file)?;
        // Files that a sweep names are read from a folder.
        let local = tempfile::tempdir().map_err(|e| Error::file(&path, e))?;
        FilesBeside::copy(&settings, place, local.path())?;
        Self::unchecked(settings, local.path(), file)
    }

    /// Checks settings; files that they name are looked for in `folder`, and `file` names them in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn new(settings: SweepSettings, folder: &Path, file: String) -> Result<Self> {
        let sweep = Self::unchecked(settings, folder, file)?;
        sweep.check(CampaignPart::Whole)?;
        Ok(sweep)
    }

    fn unchecked(mut settings: SweepSettings, folder: &Path, file: String) -> Result<Self> {
        check_seed(settings.seed, &file)?;
        let bad = |key: &str, message: &str| Error::Settings {
            file: file.clone(),
            message: format!("key `{key}`: {message}"),
        };
        for (key, value, most) in [
            ("trials", settings.trials, LANDINGS),
            ("block", settings.block, 1_000_000),
        ] {
            if !(1..=most).contains(&value) {
                return Err(bad(key, &format!("expected 1 to {most}, found {value}")));
            }
        }
        let cards = std::mem::take(&mut settings.cards).from(folder);
        settings.vehicle.check(&file)?;
        let stated = settings.vehicle;
        let model = |card: &Card| stated.thrust(card);
        let thrust = cards.put_into(&model, &mut settings.scenario.models)?;
        let of_companion = software_in_the_loop::resolve(&mut settings, folder, &bad)?;
        let thrust = of_companion.or(thrust);
        let dynamic = cards.dynamic.as_deref().map(Card::read).transpose()?;
        let of_vehicle = vehicle::VehicleCards {
            thrust: thrust.as_ref(),
            dynamic: dynamic.as_ref(),
        };
        let keys = std::mem::take(&mut settings.stated);
        let (vehicle, overlap) =
            vehicle::put_into(&mut settings.scenario, &stated, of_vehicle, &keys, &bad)?;
        settings.vehicle = VehicleSettings::default();
        let axes = Axes::of(&settings, &bad)?;
        if axes.set_the_vehicle() {
            // What is swept or drawn of the vehicle changes the truth, not the belief.
            settings.scenario.believed = settings.scenario.complete_belief();
        }
        axes.check_size(settings.trials, &bad)?;
        let mut beside = FilesBeside::default();
        let (mut deck, mut motion) = (None, None);
        let mut warnings: Vec<String> = overlap.into_iter().collect();
        if let Some(given) = &mut settings.series {
            if settings.scenario.deck != RigidMotion::default() || axes.set_the_deck() {
                return Err(bad("series", TWO_DECKS));
            }
            let measured = MeasuredDeck::read(given, folder)?;
            (deck, motion) = (Some(measured.deck), Some(measured.text));
            warnings.extend(measured.warnings);
            beside.series = Some(measured.bytes);
            given.file = SERIES.into();
        }
        beside.policy = policy_of(&mut settings, folder, &axes, &bad)?;
        let Axes { grid, random } = axes;
        settings.grid = grid
            .iter()
            .map(|(key, values)| (key.clone(), Value::Array(values.clone())))
            .collect();
        settings.random = random
            .iter()
            .map(|(key, of)| Value::try_from(of).map(|value| (key.clone(), value)))
            .collect::<std::result::Result<_, _>>()
            .map_err(|e| bad("random", &e.to_string()))?;
        let base =
            Table::try_from(&settings.scenario).map_err(|e| bad("scenario", &e.to_string()))?;
        let sha256 = sha256(&settings, &beside)?;
        Ok(Self {
            settings,
            base,
            grid,
            random,
            deck,
            motion,
            warnings,
            vehicle,
            beside,
            file,
            sha256,
            flown: RecentlyUsed::default(),
        })
    }

    /// The settings, complete: cards as models, keys dotted.
    #[must_use]
    pub fn settings(&self) -> &SweepSettings {
        &self.settings
    }

    /// SHA-256 of everything that the landings depend on.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// The measured motion of the deck, as its file has it.
    #[must_use]
    pub fn measured(&self) -> Option<&[u8]> {
        self.beside.series.as_deref()
    }

    /// The files that stand beside the sweep in the folder of a campaign or run, by name: a measured motion, a policy.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        self.beside.named()
    }

    /// What the measured motion of the deck is, in a line: length, sampling, sea state, noise, peaks.
    #[must_use]
    pub fn motion(&self) -> Option<&str> {
        self.motion.as_deref()
    }

    /// What may be wrong with the vehicle or the measured motion of the deck, a sentence each.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What of the simulated vehicle follows from `[vehicle]` and the thrust card, in a line.
    #[must_use]
    pub fn vehicle(&self) -> Option<&str> {
        self.vehicle.as_deref()
    }

    /// The swept keys with their values.
    #[must_use]
    pub fn grid(&self) -> &[(String, Vec<Value>)] {
        &self.grid
    }

    /// The random keys.
    pub fn drawn(&self) -> impl Iterator<Item = &str> {
        self.random.iter().map(|(key, _)| key.as_str())
    }

    /// Whether all values of the k-th random key are numbers.
    pub(super) fn draws_numbers(&self, k: usize) -> bool {
        match &self.random[k].1 {
            Distribution::Choice { of } => of.iter().all(|v| super::row::number(v).is_some()),
            _ => true,
        }
    }

    /// Number of points of the grid; one without a grid.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.grid
            .iter()
            .map(|(_, values)| values.len() as u64)
            .product()
    }

    /// The number of points to look at for what begins with one of `parts`: one, where the grid varies none of it.
    pub(super) fn points_if_varied(&self, parts: &[&str]) -> u64 {
        let varied = |(key, _): &(String, _)| parts.iter().any(|part| key.starts_with(part));
        if self.grid.iter().any(varied) {
            self.points()
        } else {
            1
        }
    }

    /// Landings at each point.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.settings.trials
    }

    /// All landings.
    #[must_use]
    pub fn landings(&self) -> u64 {
        self.points() * self.trials()
    }

    /// Number of blocks.
    #[must_use]
    pub fn blocks(&self) -> u64 {
        self.landings().div_ceil(self.settings.block)
    }

    /// The landings of a block.
    #[must_use]
    pub fn range(&self, block: u64) -> Range<u64> {
        let from = block * self.settings.block;
        from..(from + self.settings.block).min(self.landings())
    }

    /// Which value of each swept key a point has; the last key changes first.
    #[must_use]
    pub fn places(&self, point: u64) -> Vec<usize> {
        let mut rest = point;
        let mut places: Vec<usize> = self
            .grid
            .iter()
            .rev()
            .map(|(_, values)| {
                let place = rest % values.len() as u64;
                rest /= values.len() as u64;
                place as usize
            })
            .collect();
        places.reverse();
        places
    }

    /// The swept keys with their values at a point.
    #[must_use]
    pub fn values(&self, point: u64) -> Vec<(&str, &Value)> {
        let keys = self.grid.iter().zip(self.places(point));
        keys.map(|((key, values), place)| (key.as_str(), &values[place]))
            .collect()
    }

    /// The drawn values of a trial, in the order of [`Self::drawn`].
    #[must_use]
    pub fn draws(&self, trial: u64) -> Vec<Value> {
        self.accepted(trial).0
    }

    /// The lander of a landing, by its place in the campaign; without draws, that of all trials of its point.
    ///
    /// # Errors
    /// Drawn values that make no sense, of trials that [`Self::read`] did not look at: in large campaigns, those whose
    /// draws are no extremes.
    pub fn lander(&self, landing: u64) -> Result<Arc<SpaceLander>> {
        let (point, trial) = (landing / self.trials(), landing % self.trials());
        if !self.random.is_empty() {
            return self.built(point, trial).map(Arc::new);
        }
        self.flown.shared(point, || self.built(point, trial))
    }

    /// The scenario of a point, without draws.
    ///
    /// # Errors
    /// Values that make no scenario.
    pub fn scenario(&self, point: u64) -> Result<SpaceScenario> {
        self.scenario_with(point, &[]).map(|(scenario, _)| scenario)
    }

    /// The scenario of a point with these values in place of draws, and all values that are set.
    pub(super) fn scenario_with<'a>(
        &'a self,
        point: u64,
        draws: &'a [Value],
    ) -> Result<(SpaceScenario, Vec<(&'a str, &'a Value)>)> {
        let mut table = self.base.clone();
        let mut values = self.values(point);
        for (key, value) in &values {
            self.set(&mut table, "grid", key, value)?;
        }
        let drawn = self.random.iter().zip(draws);
        for ((key, _), value) in drawn {
            self.set(&mut table, "random", key, value)?;
            values.push((key, value));
        }
        let scenario = table.clone().try_into();
        let scenario = scenario.map_err(|e: toml::de::Error| self.unread(&table, &values, &e))?;
        Ok((scenario, values))
    }

    /// The error of a table that is no scenario.
    fn unread(&self, table: &Table, values: &[(&str, &Value)], error: &toml::de::Error) -> Error {
        // Errors in tables of several kinds name no key above the unknown one: it is looked for in the text, whose lines nobody
        // knows.
        let text = toml::to_string(table).unwrap_or_default();
        let error = TomlError {
            line: None,
            ..TomlError::new(&text, error)
        };
        self.at(values, &error)
    }

    pub(super) fn built(&self, point: u64, trial: u64) -> Result<SpaceLander> {
        let (draws, redrawn) = self.accepted(trial);
        self.check_redrawn(trial, redrawn)?;
        self.built_with(point, &draws)
    }

    /// The lander of a point with these values in place of draws.
    pub(super) fn built_with(&self, point: u64, draws: &[Value]) -> Result<SpaceLander> {
        let (scenario, values) = self.scenario_with(point, draws)?;
        SpaceLander::new(&scenario)
            .and_then(|lander| lander.with_camera_pipelines(crate::camera::pipelines()))
            .and_then(|lander| match &self.deck {
                Some(deck) => lander.with_deck(deck.clone()),
                None => Ok(lander),
            })
            .and_then(|lander| match &self.beside.policy {
                Some(file) if is_policy(&values) => lander.with_policy(file.policy.clone()),
                _ => Ok(lander),
            })
            .map_err(|e| self.at(&values, &e))
    }

    /// Sets a key of a scenario. A policy is no controller of the landing computer: beside it the scenario's own stands by.
    fn set(&self, table: &mut Table, section: &str, key: &str, value: &Value) -> Result<()> {
        if names_policy(key, value) {
            return Ok(());
        }
        set(table, key, value).map_err(|e| self.bad(&format!("{section}.\"{key}\""), &e))
    }

    pub(super) fn bad(&self, key: &str, message: &dyn std::fmt::Display) -> Error {
        Error::Settings {
            file: self.file.clone(),
            message: format!("key `{key}`: {message}"),
        }
    }

    /// An error at a point or for a random value. Its values name the place.
    fn at(&self, values: &[(&str, &Value)], message: &dyn std::fmt::Display) -> Error {
        let at: Vec<String> = values
            .iter()
            .map(|(key, value)| format!("\"{key}\" = {value}"))
            .collect();
        match at.as_slice() {
            [] => self.bad("scenario", message),
            at => self.bad("scenario", &format!("with {}: {message}", at.join(", "))),
        }
    }
}

/// Identifies a sweep: version, settings, measured motion and policy.
fn sha256(settings: &SweepSettings, beside: &FilesBeside) -> Result<String> {
    let mut hash = Sha256::new();
    hash.update(env!("CARGO_PKG_VERSION"));
    hash.update(to_toml(&settings.without_places())?);
    beside.put_into(&mut hash);
    let bytes = hash.finalize();
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
