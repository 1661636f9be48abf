//! The wind of the points beside the airspeeds in which the vehicle can land.

use super::points::Sweep;
use crate::error::Result;

impl Sweep {
    /// The airspeeds up to which the vehicle of the first windy point can land, and how many points have more
    /// air (mean, gust and two standard deviations), in a line; none in calm air above a deck that does not travel. Random
    /// draws are not counted.
    ///
    /// # Errors
    /// A point whose settings make no scenario.
    pub fn air(&self) -> Result<Option<String>> {
        let varied = |key: &String| key.starts_with("wind") || key.starts_with("course");
        let first = self.scenario(0)?;
        if first.passing_air_mps() <= 0.0 && !self.grid().iter().any(|(key, _)| varied(key)) {
            return Ok(None);
        }
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        let (mut beyond, mut limits) = (0, None);
        for point in 0..self.points() {
            let scenario = self.scenario(point)?;
            let air_mps = scenario.passing_air_mps();
            let Ok(of_vehicle) = scenario.greatest_airspeeds() else {
                continue;
            };
            if air_mps > 0.0 {
                limits.get_or_insert(of_vehicle);
            }
            beyond += u64::from(air_mps > of_vehicle.thrust_mps);
            least = least.min(air_mps);
            most = most.max(air_mps);
        }
        Ok(limits.map(|limits| {
            let of = if most > least {
                format!("{least:.1} to {most:.1}")
            } else {
                format!("{most:.1}")
            };
            format!(
                "horizontal air with gusts and two standard deviations: {of} m/s. Weight and drag need 0.9 of the greatest thrust at {:.1} m/s: \
                 {beyond} of {} points have more, where giving up is right. No descent begins beyond {:.1} m/s, \
                 by the tilt (control.lander.wind_slope, control.horizontal.tilt_limit_rad)",
                limits.thrust_mps,
                self.points(),
                limits.descent_mps,
            )
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Sweep;

    fn air(file: &str) -> Option<String> {
        let settings = toml::from_str(file).unwrap();
        let sweep = Sweep::new(settings, Path::new(""), "s.toml".into()).unwrap();
        sweep.air().unwrap()
    }

    #[test]
    fn analytic_points_beyond_what_the_thrust_holds_are_counted() {
        assert!(air("[grid]\nground_effect_strength = [0.5, 1.0]\n").is_none());
        // The default airframe holds about 18 m/s with 0.9 of its thrust; turbulence counts twice.
        let text = air("[grid]\n\"wind.steady_mps\" = [[0.0, 0.0, 0.0], [12.0, 0.0, 0.0], [0.0, -25.0, 0.0]]\n").unwrap();
        assert!(
            text.contains("0.0 to 25.0 m/s") && text.contains(": 1 of 3 points"),
            "{text}"
        );
        let dryden = "[scenario.wind]\nsteady_mps = [12.0, 0.0, 0.0]\n\
            dryden = { intensity_mps = [4.0, 4.0, 1.0], length_m = [30.0, 30.0, 3.0], passing_mps = 12.0 }\n";
        let text = air(dryden).unwrap();
        assert!(
            text.contains("20.0 m/s") && text.contains(": 1 of 1 points"),
            "{text}"
        );
    }
}
