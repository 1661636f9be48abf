//! The wind of the points beside the airspeeds in which the vehicle can land.

use std::fmt;

use super::points::Sweep;
use crate::error::Result;

impl Sweep {
    /// The airspeeds up to which the vehicles of the windy points can land, and how many points have more
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
        let [mut air, mut thrust, mut descent] = [Span::default(); 3];
        let [mut beyond_thrust, mut beyond_descent] = [0_u64; 2];
        for point in 0..self.points() {
            let scenario = self.scenario(point)?;
            let air_mps = scenario.passing_air_mps();
            let Ok(limits) = scenario.greatest_airspeeds() else {
                continue;
            };
            air.add(air_mps);
            if air_mps > 0.0 {
                thrust.add(limits.thrust_mps);
                descent.add(limits.descent_mps);
            }
            beyond_thrust += u64::from(air_mps > limits.thrust_mps);
            beyond_descent += u64::from(air_mps > limits.descent_mps);
        }
        let points = self.points();
        Ok(thrust.0.map(|_| {
            format!(
                "horizontal air with gusts and two standard deviations: {air} m/s. Weight and drag need 0.9 of the \
                 greatest thrust at {thrust} m/s: {beyond_thrust} of {points} points have more, where giving up is right. \
                 No descent begins beyond {descent} m/s, by the tilt (control.lander.wind_slope, \
                 control.horizontal.tilt_limit_rad): {beyond_descent} of {points} points have more"
            )
        }))
    }
}

/// The least and the greatest of speeds, m/s.
#[derive(Clone, Copy, Default)]
struct Span(Option<[f64; 2]>);

impl Span {
    fn add(&mut self, value: f64) {
        let [least, most] = self.0.unwrap_or([value; 2]);
        self.0 = Some([least.min(value), most.max(value)]);
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some([least, most]) if most > least => write!(f, "{least:.1} to {most:.1}"),
            Some([value, _]) => write!(f, "{value:.1}"),
            None => f.write_str("no"),
        }
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
        // Each point has limits of its own: of these two the controller of the first may not lean into 6 m/s.
        let tilts = |of: &str| {
            air(&format!(
                "[grid]\n\"control.horizontal.tilt_limit_rad\" = [{of}]\n\
                 [scenario.wind]\nsteady_mps = [6.0, 0.0, 0.0]\n"
            ))
            .unwrap()
        };
        let text = tilts("0.1, 0.5");
        let of = |tilt: &str| {
            let one = tilts(tilt);
            let (_, rest) = one.split_once("begins beyond ").unwrap();
            rest.split(' ').next().unwrap().to_owned()
        };
        let range = format!("begins beyond {} to {} m/s", of("0.1"), of("0.5"));
        assert!(
            text.contains(&range) && text.contains(": 0 of 2 points"),
            "{text}"
        );
        assert!(text.ends_with("): 1 of 2 points have more"), "{text}");
    }
}
