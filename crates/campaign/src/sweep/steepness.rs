//! Seas that are steeper than waves can be.

use touchdown_sim::deck::rigid::RigidMotion;

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
}
