//! The deck that moves as it was measured, for vertical landings and those in space.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use touchdown_sim::SimError;
use touchdown_sim::deck::character::SeriesCharacter;
use touchdown_sim::deck::faults::{SeriesFault, listed};
use touchdown_sim::deck::noise::SeriesNoise;
use touchdown_sim::deck::rigid::{Axis, RigidDeck};
use touchdown_sim::deck::series::{MotionSeries, SeriesFormat};
use touchdown_sim::deck::slow::LONGEST_PERIOD_S;
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
    /// Cutoff below which the motion is kept, Hz; `"noise"`, the default, for the one with the least error at this
    /// noise; `"off"` to run through every row.
    #[serde(default)]
    pub cutoff_hz: Cutoff,
    /// Longest period of the heave that counts as waves, s; slower heave (tide, drift of the sensor) is left out. Without it,
    /// [`LONGEST_PERIOD_S`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_period_s: Option<f64>,
    /// Greatest acceleration of the heave, m/s²; without it, that of gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest_acceleration_mps2: Option<f64>,
    /// What its columns mean.
    #[serde(default)]
    pub format: SeriesFormat,
}

/// Where a measured motion is smoothed.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged, expecting = "a frequency in Hz, \"noise\" or \"off\"")]
pub enum Cutoff {
    /// A frequency, Hz.
    Hz(f64),
    /// A word.
    Word(CutoffWord),
}

impl Default for Cutoff {
    fn default() -> Self {
        Self::Word(CutoffWord::Noise)
    }
}

/// What takes the place of a frequency.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CutoffWord {
    /// By the noise of the series.
    Noise,
    /// No smoothing.
    Off,
}

/// Name of a measured motion in the folder of a campaign or run.
pub const SERIES: &str = "series.csv";

/// Greatest acceleration of the heave by default, m/s²: that of gravity. A deck that falls faster leaves everything on
/// it behind. Half of it refuses small boats in steep waves; twice of it passes the noise of most sensors.
const GREATEST_MPS2: f64 = 9.806_65;
/// Share of the greatest acceleration that motion faster than waves may have without a warning. Clean seas have up to a fifth.
const FAST_SHARE: f64 = 1.0 / 3.0;
/// What to do about faults.
const REPAIR: &str = "Remove these rows, or use another part of the recording";
/// Share of the significant height that smoothing may take beyond the noise without a warning. The cutoff that follows the
/// noise takes up to a twentieth.
const SMOOTHED_SHARE: f64 = 0.15;
/// Noise over the heave without it, beyond which too many waves are lost with the noise. At a half, smoothing takes a fiftieth of a JONSWAP
/// sea's height and a quarter of its greatest acceleration; at a sixth, a hundredth and a tenth.
const HIDING_SHARE: f64 = 0.25;
/// Share of the mean square acceleration near the cutoff from which on faster waves are taken to be lost. Of 64 recordings of one or two
/// JONSWAP seas (400 s, 8 and 20 Hz, noise of 3 to 80 mm) 13 are above: their waves lose 21 to 57 % of their acceleration (root mean
/// square). Those of the others lose up to 22 %.
const NEAR_CUTOFF_SHARE: f64 = 0.6;
/// Share of the heave's standard deviation that may be noise or short waves without a warning. With ten rows in a mean period,
/// noise of a tenth makes as much acceleration as the waves.
const EITHER_SHARE: f64 = 0.1;
/// Mean roll or pitch beyond which a line says that it is left out, rad: a degree. Inertial units are mounted to about that.
const MEAN_ANGLE_RAD: f64 = 0.0175;
/// Rows in a mean period of which a JONSWAP sea leaves less than that share open. A wind sea on a swell needs more.
const ROWS_PER_PERIOD: f64 = 12.0;

/// A measured motion of the deck, ready to be landed on.
#[derive(Clone, Debug)]
pub struct MeasuredDeck {
    /// The motion, as a spline.
    pub deck: RigidDeck,
    /// What the motion is, in a line.
    pub text: String,
    /// Mean period of the heave, s; absent with fewer than two.
    pub mean_period_s: Option<f64>,
    /// What is wrong with it, or may be.
    pub warnings: Vec<String>,
    /// The file.
    pub bytes: Vec<u8>,
}

impl MeasuredDeck {
    /// Reads a motion, leaves out its slow heave, smooths and scales it, in this order, and checks its acceleration.
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
        let longest_s = settings.longest_period_s.unwrap_or(LONGEST_PERIOD_S);
        if !(longest_s > 0.0) {
            return Err(bad(format!(
                "longest_period_s: expected a number above 0, or inf; found {longest_s}"
            )));
        }
        let measured = MotionSeries::read_csv(bytes.as_slice(), &settings.format).map_err(unfit)?;
        longer_than_waves(settings.longest_period_s, &measured).map_err(bad)?;
        let (unsmoothed, slow_m) = measured.without_slow_heave(longest_s);
        let cutoff_hz = cutoff_hz(settings.cutoff_hz, &measured).map_err(bad)?;
        let waves = cutoff_hz.map_or_else(|| unsmoothed.clone(), |hz| unsmoothed.smoothed(hz));
        let found = Findings {
            faults: measured.faults(&waves, cutoff_hz),
            noise: measured.noise(),
            cutoff: settings.cutoff_hz,
            cutoff_hz,
            measured: &measured,
            unsmoothed: &unsmoothed,
            waves: &waves,
        };
        let mut warnings = found.warnings(&at);
        let channels = &settings.format.channels;
        if measured.significant_height_m() == 0.0 && channels.iter().any(|c| c.axis == Axis::Heave)
        {
            warnings.push(format!(
                "{}: the heave is the same in all rows, so the deck does not heave. Is it the right column?",
                at.display()
            ));
        }
        let motion = match settings.significant_height_m {
            Some(height) => waves.clone().scaled_to(height).map_err(unfit)?,
            None => waves.clone(),
        };
        // What was measured has the noise; smoothing leaves little of it to see.
        let character = SeriesCharacter {
            noise_sd_m: found.noise.sd_m,
            ..motion.character()
        };
        let most = settings.greatest_acceleration_mps2.unwrap_or(GREATEST_MPS2);
        let peak = character.peak_acceleration_mps2;
        if !(peak <= most) {
            return Err(bad(format!(
                "expected a heave of at most {most} m/s², found {peak:.2}; {}, or raise greatest_acceleration_mps2",
                found.advice()
            )));
        }
        let smoothed = match (cutoff_hz, settings.cutoff_hz) {
            (Some(hz), _) => format!("smoothed at {hz:.2} Hz; the noise is that of the recording"),
            (None, Cutoff::Hz(hz)) => format!(
                "not smoothed: cutoff_hz = {hz} is above half of the rate of the rows, {:.2} Hz",
                0.5 / measured.step_s()
            ),
            (None, Cutoff::Word(_)) => "not smoothed".to_owned(),
        };
        let slow = slow_m.map_or_else(String::new, |range_m| {
            format!(
                "; heave slower than {longest_s} s, {range_m:.2} m from lowest to highest, left out"
            )
        });
        Ok(Self {
            deck: motion.deck(),
            text: format!(
                "measured deck: {character}; {smoothed}{slow}{}",
                mean_angles(&measured)
            ),
            mean_period_s: character.mean_period_s,
            warnings,
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

/// Mean roll and pitch that are left out, where they are more than [`MEAN_ANGLE_RAD`].
fn mean_angles(measured: &MotionSeries) -> String {
    let angles = ["roll", "pitch"]
        .into_iter()
        .zip(measured.mean_angles_rad());
    let angles = angles.filter(|(_, mean_rad)| mean_rad.abs() > MEAN_ANGLE_RAD);
    angles
        .map(|(axis, mean_rad)| format!("; mean {axis} of {mean_rad:.3} rad left out"))
        .collect()
}

/// Checks that a period which was set leaves the waves: the filter halves the power there.
fn longer_than_waves(
    longest_period_s: Option<f64>,
    measured: &MotionSeries,
) -> std::result::Result<(), String> {
    let (waves, _) = measured.without_slow_heave(LONGEST_PERIOD_S);
    match (longest_period_s, waves.mean_period_s()) {
        (Some(longest_s), Some(mean_s)) if longest_s <= mean_s => Err(format!(
            "longest_period_s: expected more than the mean period of the heave, {mean_s:.2} s, because slower heave is left out; \
             found {longest_s}"
        )),
        _ => Ok(()),
    }
}

/// The frequency at which a motion is smoothed; absent if not at all. Above half of the rate of the rows a series has no motion to
/// smooth.
fn cutoff_hz(cutoff: Cutoff, measured: &MotionSeries) -> std::result::Result<Option<f64>, String> {
    match cutoff {
        Cutoff::Hz(hz) if hz > 0.0 && hz.is_finite() => {
            Ok(Some(hz).filter(|hz| *hz <= 0.5 / measured.step_s()))
        }
        Cutoff::Hz(hz) => Err(format!(
            "cutoff_hz: expected a finite number above 0, \"noise\" or \"off\"; found {hz}"
        )),
        Cutoff::Word(CutoffWord::Noise) => Ok(measured.cutoff_of_noise_hz()),
        Cutoff::Word(CutoffWord::Off) => Ok(None),
    }
}

/// A measured motion and what smoothing leaves of it.
struct Findings<'a> {
    faults: Vec<SeriesFault>,
    /// Of the motion as it was recorded: rounded heights repeat in it.
    noise: SeriesNoise,
    /// As it was set, and as a frequency.
    cutoff: Cutoff,
    cutoff_hz: Option<f64>,
    measured: &'a MotionSeries,
    unsmoothed: &'a MotionSeries,
    waves: &'a MotionSeries,
}

impl Findings<'_> {
    /// What to do about an acceleration that no deck has.
    fn advice(&self) -> String {
        if !self.faults.is_empty() {
            return format!("the heave has faults: {}. {REPAIR}", listed(&self.faults));
        }
        let noise_sd_m = self.noise.sd_m;
        match (self.cutoff_hz, self.measured.cutoff_of_noise_hz()) {
            (None, Some(hz)) => format!(
                "its noise is {noise_sd_m:.3} m: smooth it with cutoff_hz = {hz:.2} in [series], or \"noise\""
            ),
            (Some(hz), _) => match self.waves.fast_motion() {
                Some(fast) if fast.above_hz < hz => format!(
                    "lower cutoff_hz in [series] from {hz:.2} to {:.2}, five times the mean frequency",
                    fast.above_hz
                ),
                _ => format!("lower cutoff_hz in [series], now {hz:.2}"),
            },
            (None, None) => "set cutoff_hz in [series]".to_owned(),
        }
    }

    /// What a user should look at before this motion is a deck.
    fn warnings(&self, file: &Path) -> Vec<String> {
        let file = file.display();
        let mut warnings = Vec::new();
        if !self.faults.is_empty() {
            warnings.push(format!(
                "{file}: the heave has faults: {}. Waves do not move so. {REPAIR}",
                listed(&self.faults)
            ));
        }
        let peak_mps2 = self.waves.peak_acceleration_mps2();
        if let Some(fast) = self.waves.fast_motion()
            && fast.peak_without_mps2 < (1.0 - FAST_SHARE) * peak_mps2
        {
            warnings.push(format!(
                "{file}: without motion above {:.2} Hz, five times the mean frequency, the greatest acceleration is {:.2} m/s² in \
                 place of {peak_mps2:.2} m/s². Are these short waves? If they are noise, set cutoff_hz = {:.2} in [series]",
                fast.above_hz, fast.peak_without_mps2, fast.above_hz
            ));
        }
        let of_noise = [self.sampling_warning(), self.smoothing_warning()];
        let of_noise = of_noise.into_iter().flatten();
        warnings.extend(of_noise.map(|text| format!("{file}: {text}")));
        warnings
    }

    /// Rows that are too few, or too far apart, to tell noise from waves, where nobody has said what to smooth. Where most of it is known to be
    /// noise, that is said by other words.
    fn sampling_warning(&self) -> Option<String> {
        if self.cutoff != Cutoff::default() {
            return None;
        }
        let SeriesNoise {
            sd_m,
            greatest_sd_m,
            rows_per_period,
        } = self.noise;
        let either_m = (greatest_sd_m * greatest_sd_m - sd_m * sd_m)
            .max(0.0)
            .sqrt();
        let Some(rows) = rows_per_period else {
            let moves = self.unsmoothed.significant_height_m() > 0.0;
            return moves.then(|| {
                "the recording is shorter than two waves: what is noise in it is uncertain, and with it how fast the deck moves. Record \
                 longer, or set cutoff_hz in [series]"
                    .to_owned()
            });
        };
        let heave_sd_m = self.unsmoothed.significant_height_m() / 4.0;
        let enough = (2.0 * rows).max(ROWS_PER_PERIOD).ceil();
        (either_m > (EITHER_SHARE * heave_sd_m).max(0.5 * sd_m)).then(|| {
            format!(
                "{rows:.1} rows in a mean period are too few to tell noise from short waves, and how fast these move: {either_m:.3} m \
                 (standard deviation) of the heave may be either, and is taken for waves. Record at least {enough} rows in a mean period, or set cutoff_hz in \
                 [series]"
            )
        })
    }

    /// Waves that are lost by smoothing.
    fn smoothing_warning(&self) -> Option<String> {
        let hz = self.cutoff_hz?;
        let noise_sd_m = self.noise.sd_m;
        let noise_m = 4.0 * noise_sd_m;
        let measured_m = self.unsmoothed.significant_height_m();
        let without_noise_m = (measured_m * measured_m - noise_m * noise_m)
            .max(0.0)
            .sqrt();
        let left_m = self.waves.significant_height_m();
        if noise_m > HIDING_SHARE * without_noise_m {
            return Some(format!(
                "noise of {noise_sd_m:.3} m hides waves: smoothing at {hz:.2} Hz leaves a significant height of {left_m:.3} m, and \
                 the faster waves are lost with the noise, so that the deck may move less than the real one. Record with less noise"
            ));
        }
        if left_m < (1.0 - SMOOTHED_SHARE) * without_noise_m {
            return Some(format!(
                "smoothing at {hz:.2} Hz leaves {left_m:.3} m of a significant height of {without_noise_m:.3} m. Raise cutoff_hz in \
                 [series]"
            ));
        }
        if self.cutoff != Cutoff::default() {
            return None;
        }
        let near = self.unsmoothed.acceleration_near_cutoff(hz, noise_sd_m)?;
        (near > NEAR_CUTOFF_SHARE).then(|| {
            format!(
                "noise of {noise_sd_m:.3} m hides short waves: smoothing at {hz:.2} Hz leaves an acceleration of which {:.0} % (mean square) \
                 is of waves above half of that frequency. Faster waves are lost with the noise: the waves of the deck may have a fifth to a half less \
                 acceleration than the real ones. Record with less noise or more often",
                100.0 * near
            )
        })
    }
}

#[cfg(test)]
mod tests;
