//! Heights: counted upwards from the deck, in metres.

use super::{DataWarning, label, quantile, sorted};
use crate::error::{Error, Result};
use crate::map_line::map_line;
use crate::rig::GroundTrial;
use crate::settings::GroundEffectSettings;

/// Height that no force rig reaches (m). Halls of wind tunnels are lower; the motion of a rig of 25 mm in
/// millimetres is already above.
const HIGHEST_M: f64 = 20.0;
/// Lengths of the slowest function of height up to which the effect of a height is identified. There that function is a fifth.
/// Of the default length, 0.45 m, that is 0.9 m, eight radii of the default rotor, where eq. (2) gives 0.1 %.
const FAR_LENGTHS: f64 = 2.0;
/// Rotor radii from which there is no ground effect: eq. (2) gives 0.4 %.
const FAR_RADII: f64 = 4.0;
/// Height below the deck that noise of a range finder explains (m): twice the noise of a common one.
const NOISE_M: f64 = 0.02;
/// Share of rows at each end that may be spikes of the sensor.
const SPIKES: f64 = 0.01;

/// Refuses heights that are counted downwards, that no rig reaches, or that are all far from the deck, and warns of another zero.
pub(super) fn check(
    trials: &[GroundTrial],
    settings: &GroundEffectSettings,
) -> Result<Option<DataWarning>> {
    let heights = sorted(trials.iter().flat_map(|t| t.height_m.iter().copied()));
    let of = |share| quantile(&heights, share).unwrap_or(f64::NAN);
    let (least_m, middle_m, most_m) = (of(SPIKES), of(0.5), of(1.0 - SPIKES));
    if middle_m < -NOISE_M {
        let found = format!(
            "{middle_m} m, the median: is it counted downwards? Then {}",
            map_line("height_m", "-", "")
        );
        return Err(Error::data(
            label(trials),
            "values of `height_m` above 0",
            found,
        ));
    }
    if most_m > HIGHEST_M {
        let found = format!(
            "{least_m} to {most_m} m, higher than force rigs are: is it in millimetres? Then {}; in centimetres with 0.01",
            map_line("height_m", "0.001 * ", "")
        );
        let expected = format!("values of `height_m` in metres, at most {HIGHEST_M}");
        return Err(Error::data(label(trials), expected, found));
    }
    let length_m = FAR_LENGTHS * settings.lengths_m()[2];
    let limit_m = length_m.max(FAR_RADII * settings.rotor_radius_m);
    if least_m > limit_m {
        let expected = format!(
            "heights below {limit_m:.2} m (twice the longest of `ground_effect.lengths_m`, or four rotor radii), within the ground effect"
        );
        let found = format!(
            "all above {least_m:.2} m. If `height_m` is in centimetres, {}. If the vehicle is large, set its `rotor_radius_m` and \
             `ground_effect.lengths_m`. Otherwise record heights of half a rotor radius to four",
            map_line("height_m", "0.01 * ", "")
        );
        return Err(Error::data(label(trials), expected, found));
    }
    let below = heights.partition_point(|h| *h < 0.0);
    let share = below as f64 / heights.len().max(1) as f64;
    Ok((least_m < -NOISE_M).then_some(DataWarning::HeightsBelowDeck { share, least_m }))
}
