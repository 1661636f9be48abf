//! Warnings of decks: seas that are steeper than waves can be, and heaves that exceed gravity.

use std::f64::consts::TAU;

use touchdown_sim::deck::rigid::{Axis, RigidMotion, Tone};

use super::points::Sweep;
use crate::error::Result;

/// Steepness above which there is a warning: that of the steepest seas.
const STEEPEST: f64 = 1.0 / 15.0;

impl Sweep {
    /// Warnings of the decks of all points: the steepest sea, if its waves would break, and the quickest heave of tones, if it
    /// exceeds gravity. Random draws do not count.
    ///
    /// # Errors
    /// A point whose settings make no scenario.
    pub fn deck_warnings(&self) -> Result<Vec<String>> {
        let (mut steepest, mut quickest_g) = (0.0_f64, 0.0_f64);
        for point in 0..self.points_if_varied(&["deck", "plant.gravity_mps2"]) {
            let scenario = self.scenario(point)?;
            match &scenario.deck {
                RigidMotion::Sea(sea) => steepest = steepest.max(sea.spectrum.steepness()),
                RigidMotion::Sines { tones } => {
                    quickest_g = quickest_g.max(heave_mps2(tones) / scenario.plant.gravity_mps2);
                }
                _ => {}
            }
        }
        let sea = (steepest > STEEPEST).then(|| {
            format!(
                "the sea is steeper than waves can be: its significant height is {steepest:.2} of the length of its waves, \
                 2 pi H_s/(g T_p^2); waves break above {STEEPEST:.2}. Are deck.spectrum.significant_height_m and peak_period_s right?"
            )
        });
        let heave = (quickest_g > 1.0).then(|| {
            format!(
                "the deck heaves with up to {quickest_g:.1} times gravity, so no vehicle stays on it. Are the amplitudes of deck.tones in \
                 metres, and the frequencies in Hz?"
            )
        });
        Ok(sea.into_iter().chain(heave).collect())
    }
}

/// Greatest acceleration of the heave of tones, if their peaks coincide (m/s²).
fn heave_mps2(tones: &[Tone]) -> f64 {
    let heave = tones.iter().filter(|tone| tone.axis == Axis::Heave);
    heave
        .map(|tone| tone.amplitude.abs() * (TAU * tone.frequency_hz).powi(2))
        .sum()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Sweep;

    fn warning(heights: &str) -> Vec<String> {
        let file = format!(
            "[grid]\n\"deck.spectrum.significant_height_m\" = {heights}\n[scenario.deck]\nkind = \"sea\"\n\
             [scenario.deck.spectrum]\nshape = \"pierson_moskowitz\"\nsignificant_height_m = 0.1\npeak_period_s = 4.0\n"
        );
        let sweep = Sweep::new(
            toml::from_str(&file).unwrap(),
            Path::new(""),
            "s.toml".into(),
        );
        sweep.unwrap().deck_warnings().unwrap()
    }

    #[test]
    fn analytic_seas_that_would_break_are_told() {
        // Waves of 4 s are 24.97 m long, a fifteenth of which is 1.66 m.
        assert_eq!(warning("[0.5, 1.6]"), [""; 0]);
        let warned = warning("[0.5, 2.5]").join("; ");
        assert!(warned.contains("0.10 of the length"), "{warned}");
    }

    #[test]
    fn analytic_heaves_that_exceed_gravity_are_warned_of() {
        let warnings = |tones: &str| {
            let file = format!("[scenario.deck]\nkind = \"sines\"\ntones = [{tones}]\n");
            let settings = toml::from_str(&file).unwrap();
            let sweep = Sweep::new(settings, Path::new(""), "s.toml".into()).unwrap();
            sweep.deck_warnings().unwrap()
        };
        let tone = |axis: &str, amplitude: f64, hz: f64| {
            format!("{{ axis = \"{axis}\", amplitude = {amplitude}, frequency_hz = {hz} }}")
        };
        // 0.0062 (2 pi 6)² is 8.8 m/s².
        let shake = tone("heave", 0.0062, 6.0);
        assert_eq!(warnings(&shake), [""; 0]);
        // With 7.9 m/s² of 5 cm at 2 Hz it is 16.7 m/s².
        let both = warnings(&format!("{shake}, {}", tone("heave", 0.05, 2.0))).join("; ");
        assert!(both.contains("up to 1.7 times gravity"), "{both}");
        assert_eq!(warnings(&tone("roll", 0.3, 2.0)), [""; 0]);
    }
}
