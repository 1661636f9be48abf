//! Seas that are steeper than waves can be, and decks that drop faster than a vehicle falls.

use std::f64::consts::TAU;

use touchdown_sim::deck::rigid::{Axis, RigidMotion, Tone};

use super::points::Sweep;
use crate::error::Result;

/// Steepness above which there is a warning: that of the steepest seas.
const STEEPEST: f64 = 1.0 / 15.0;

impl Sweep {
    /// A sentence about the steepest sea of all points, if its waves would break. Random draws are not looked at.
    ///
    /// # Errors
    /// A point whose settings make no scenario.
    pub fn steepness_warning(&self) -> Result<Option<String>> {
        let mut steepest: f64 = 0.0;
        for point in 0..self.points_if_varied(&["deck"]) {
            if let RigidMotion::Sea(sea) = &self.scenario(point)?.deck {
                steepest = steepest.max(sea.spectrum.steepness());
            }
        }
        Ok((steepest > STEEPEST).then(|| {
            format!(
                "the sea is steeper than waves can be: its significant height is {steepest:.2} of the length of its waves, \
                 2 pi H_s/(g T_p^2); waves break above {STEEPEST:.2}. Are deck.spectrum.significant_height_m and peak_period_s right?"
            )
        }))
    }
}

/// The heave of tones is more than this acceleration at times (m/s²): a deck on which nothing stays.
const FREE_FALL_MPS2: f64 = 9.81;

impl Sweep {
    /// A sentence about the quickest heave of all points, if its deck drops faster than a vehicle falls. Random draws are not looked at.
    ///
    /// # Errors
    /// A point whose settings make no scenario.
    pub fn heave_warning(&self) -> Result<Option<String>> {
        let mut quickest: f64 = 0.0;
        for point in 0..self.points_if_varied(&["deck"]) {
            if let RigidMotion::Sines { tones } = &self.scenario(point)?.deck {
                let heave = tones.iter().filter(|tone| tone.axis == Axis::Heave);
                let of = |tone: &Tone| tone.amplitude.abs() * (TAU * tone.frequency_hz).powi(2);
                quickest = quickest.max(heave.map(of).sum());
            }
        }
        Ok((quickest > FREE_FALL_MPS2).then(|| {
            format!(
                "the deck heaves with up to {quickest:.1} m/s², more than gravity: a vehicle does not stay on it. Are the amplitudes of \
                 deck.tones in metres, and the frequencies in Hz?"
            )
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Sweep;

    fn warning(heights: &str) -> Option<String> {
        let file = format!(
            "[grid]\n\"deck.spectrum.significant_height_m\" = {heights}\n[scenario.deck]\nkind = \"sea\"\n\
             [scenario.deck.spectrum]\nshape = \"pierson_moskowitz\"\nsignificant_height_m = 0.1\npeak_period_s = 4.0\n"
        );
        let sweep = Sweep::new(
            toml::from_str(&file).unwrap(),
            Path::new(""),
            "s.toml".into(),
        );
        sweep.unwrap().steepness_warning().unwrap()
    }

    #[test]
    fn analytic_seas_that_would_break_are_told() {
        // Waves of 4 s are 24.97 m long, a fifteenth of which is 1.66 m.
        assert_eq!(warning("[0.5, 1.6]"), None);
        let told = warning("[0.5, 2.5]").unwrap();
        assert!(told.contains("0.10 of the length"), "{told}");
    }

    #[test]
    fn analytic_decks_that_drop_faster_than_a_vehicle_falls_are_told() {
        let told = |tones: &str| {
            let file = format!("[scenario.deck]\nkind = \"sines\"\ntones = [{tones}]\n");
            let settings = toml::from_str(&file).unwrap();
            let sweep = Sweep::new(settings, Path::new(""), "s.toml".into()).unwrap();
            sweep.heave_warning().unwrap()
        };
        let tone = |axis: &str, amplitude: f64, hz: f64| {
            format!("{{ axis = \"{axis}\", amplitude = {amplitude}, frequency_hz = {hz} }}")
        };
        // 0.0062 (2 pi 6)² is 8.8 m/s².
        let shake = tone("heave", 0.0062, 6.0);
        assert_eq!(told(&shake), None);
        // Of 5 cm at 2 Hz, 7.9 m/s², beside it.
        let both = told(&format!("{shake}, {}", tone("heave", 0.05, 2.0))).unwrap();
        assert!(both.contains("up to 16.7 m/s²"), "{both}");
        assert_eq!(told(&tone("roll", 0.3, 2.0)), None);
    }
}
