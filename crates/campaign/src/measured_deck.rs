//! The deck that moves as it was measured, for vertical landings and those in space.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use touchdown_sim::SimError;
use touchdown_sim::deck::character::SeriesCharacter;
use touchdown_sim::deck::rigid::RigidDeck;
use touchdown_sim::deck::series::{MotionSeries, SeriesFormat};
use touchdown_sim::deck::spline::MotionSpline;

use crate::error::{Error, Result};

/// A measured motion of the deck: a table with a header.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SeriesSettings {
    /// The table (CSV), relative to the sweep file.
    pub file: PathBuf,
    /// Significant height that the heave is scaled to, m; without it, as measured.
    pub significant_height_m: Option<f64>,
    /// Cutoff below which the motion is kept, Hz, or `"noise"` for the lowest that takes away no more than the noise;
    /// without it, the motion runs through every row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutoff_hz: Option<Cutoff>,
    /// Greatest acceleration of the heave, m/s²; without it, that of gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest_acceleration_mps2: Option<f64>,
    /// What its columns mean.
    pub format: SeriesFormat,
}

/// Where a measured motion is smoothed.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cutoff {
    /// A frequency, Hz.
    Hz(f64),
    /// By the noise of the series.
    OfNoise(NoiseWord),
}

/// The word `"noise"`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseWord {
    /// `"noise"`.
    Noise,
}

/// Name of a measured motion in the folder of a campaign or run.
pub const SERIES: &str = "series.csv";

/// Greatest acceleration of the heave by default, m/s²: that of gravity. A deck that falls faster leaves everything on
/// it behind. Half of it refuses small boats in steep waves; twice of it passes the noise of most sensors.
const GREATEST_MPS2: f64 = 9.806_65;

/// A measured motion of the deck, ready to be landed on.
#[derive(Clone, Debug)]
pub struct MeasuredDeck {
    /// The motion, as a spline.
    pub deck: RigidDeck,
    /// What the motion is, in a line.
    pub text: String,
    /// Mean period of the heave, s; absent with fewer than two.
    pub mean_period_s: Option<f64>,
    /// The file.
    pub bytes: Vec<u8>,
}

impl MeasuredDeck {
    /// Reads, smooths and scales a motion, in this order, and checks its acceleration.
    ///
    /// # Errors
    /// A table that cannot be read, or a heave that is faster than allowed, with what to set.
    pub fn read(settings: &SeriesSettings, folder: &Path) -> Result<Self> {
        let at = folder.join(&settings.file);
        let bytes = std::fs::read(&at).map_err(|e| Error::file(&at, e))?;
        let bad = |message: String| Error::Settings {
            file: at.display().to_string(),
            message,
        };
        let unfit = |e: SimError| bad(e.to_string());
        let measured = MotionSeries::read_csv(bytes.as_slice(), &settings.format).map_err(unfit)?;
        let cutoff_hz = match settings.cutoff_hz {
            None => None,
            Some(Cutoff::Hz(hz)) if hz > 0.0 && hz.is_finite() => Some(hz),
            Some(Cutoff::Hz(hz)) => {
                let text = format!(
                    "cutoff_hz: expected a finite number above 0, or \"noise\"; found {hz}"
                );
                return Err(bad(text));
            }
            Some(Cutoff::OfNoise(_)) => measured.cutoff_of_noise_hz(),
        };
        let scaled = |motion: MotionSeries| match settings.significant_height_m {
            Some(height) => motion.scaled_to(height).map_err(unfit),
            None => Ok(motion),
        };
        let motion = match cutoff_hz {
            Some(hz) => scaled(measured.smoothed(hz))?,
            None => scaled(measured.clone())?,
        };
        // What was measured has the noise; smoothing leaves little of it to see.
        let noise_sd_m = measured.character().noise_sd_m;
        let character = SeriesCharacter {
            noise_sd_m,
            ..motion.character()
        };
        let most = settings.greatest_acceleration_mps2.unwrap_or(GREATEST_MPS2);
        let found = character.peak_acceleration_mps2;
        if !(found <= most) {
            let advice = match measured.cutoff_of_noise_hz() {
                Some(hz) if cutoff_hz.is_none() => format!(
                    "its noise is {noise_sd_m:.3} m: smooth it with cutoff_hz = {hz:.2} in [series], or \"noise\""
                ),
                _ => "lower cutoff_hz in [series]".to_owned(),
            };
            return Err(bad(format!(
                "expected a heave of at most {most} m/s², found {found:.2}; {advice}, or raise greatest_acceleration_mps2"
            )));
        }
        let smoothed = cutoff_hz.map_or_else(
            || "not smoothed".to_owned(),
            |hz| format!("smoothed at {hz:.2} Hz; the noise is that of the recording"),
        );
        Ok(Self {
            deck: motion.deck(),
            text: format!("measured deck: {character}; {smoothed}"),
            mean_period_s: character.mean_period_s,
            bytes,
        })
    }

    /// The motion, where it is a spline: always, for one that was read.
    #[must_use]
    pub fn spline(&self) -> Option<&MotionSpline> {
        match &self.deck {
            RigidDeck::Spline(spline) => Some(spline),
            _ => None,
        }
    }
}
