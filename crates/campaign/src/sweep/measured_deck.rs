//! The deck that moves as it was measured.

use std::path::Path;

use touchdown_sim::SimError;
use touchdown_sim::deck::rigid::RigidDeck;
use touchdown_sim::deck::series::MotionSeries;

use super::settings::{Cutoff, SeriesSettings};
use crate::error::{Error, Result};

/// Greatest acceleration of the heave by default, m/s²: that of gravity. A deck that falls faster leaves everything on
/// it behind. Half of it refuses small boats in steep waves; twice of it passes the noise of most sensors.
const GREATEST_MPS2: f64 = 9.806_65;

/// A measured motion of the deck.
pub(super) struct MeasuredDeck {
    pub(super) deck: RigidDeck,
    /// What the motion is, in a line.
    pub(super) text: String,
    /// The file.
    pub(super) bytes: Vec<u8>,
}

impl MeasuredDeck {
    /// Reads, smooths and scales a motion, in this order, and checks its acceleration.
    pub(super) fn read(settings: &SeriesSettings, folder: &Path) -> Result<Self> {
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
        let character = motion.character();
        let most = settings.greatest_acceleration_mps2.unwrap_or(GREATEST_MPS2);
        let found = character.peak_acceleration_mps2;
        if !(found <= most) {
            let advice = match measured.cutoff_of_noise_hz() {
                Some(hz) if cutoff_hz.is_none() => format!(
                    "its noise is {:.3} m: smooth it with cutoff_hz = {hz:.2} in [series], or \"noise\"",
                    measured.character().noise_sd_m
                ),
                _ => "lower cutoff_hz in [series]".to_owned(),
            };
            return Err(bad(format!(
                "expected a heave of at most {most} m/s², found {found:.2}; {advice}, or raise greatest_acceleration_mps2"
            )));
        }
        let smoothed = cutoff_hz.map_or_else(
            || "not smoothed".to_owned(),
            |hz| format!("smoothed at {hz:.2} Hz"),
        );
        Ok(Self {
            deck: motion.deck(),
            text: format!("measured deck: {character}; {smoothed}"),
            bytes,
        })
    }
}
