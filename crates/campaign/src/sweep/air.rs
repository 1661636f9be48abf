//! The wind of the points beside the airspeeds in which the vehicle can land.

use std::fmt;

use super::points::Sweep;
use crate::error::Result;

/// Landings whose draws are looked at, at most: in about a second. A thousand know a share of 5 % to 1.4 %.
const LOOKED_AT: u64 = 1_000;
/// Step between the landings that are looked at. No common number of landings is a multiple of this prime, so all points and
/// trials come in turn.
const STRIDE: u64 = 1_000_000_007;

impl Sweep {
    /// The airspeeds up to which the vehicles of the windy points can land, and how many points have more air (mean, gust and
    /// two standard deviations), in a line; none in calm air above a deck that does not travel. Where wind or course are drawn,
    /// landings count in place of points.
    ///
    /// # Errors
    /// A point whose settings make no scenario.
    pub fn air(&self) -> Result<Option<String>> {
        let of_air = |key: &str| {
            ["wind", "course", "faults.gust"]
                .iter()
                .any(|of| key.starts_with(of))
        };
        let drawn = self.drawn().any(of_air);
        let swept = self.grid().iter().any(|(key, _)| of_air(key));
        if !drawn && !swept && self.scenario(0)?.passing_air_mps() <= 0.0 {
            return Ok(None);
        }
        let (looked_at, what) = match drawn {
            true if self.landings() > LOOKED_AT => (LOOKED_AT, "landings that were looked at"),
            true => (self.landings(), "landings"),
            false => (self.points(), "points"),
        };
        let [mut air, mut thrust, mut descent] = [Span::default(); 3];
        let [mut beyond_thrust, mut beyond_descent] = [0_u64; 2];
        for k in 0..looked_at {
            let (point, draws) = match drawn {
                true => {
                    let landing = k * STRIDE % self.landings();
                    (landing / self.trials(), self.draws(landing % self.trials()))
                }
                false => (k, Vec::new()),
            };
            let (scenario, _) = self.scenario_with(point, &draws)?;
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
        Ok(thrust.0.map(|_| {
            format!(
                "horizontal air with gusts and two standard deviations: {air} m/s. Weight and drag need 0.9 of the \
                 greatest thrust at {thrust} m/s: {beyond_thrust} of {looked_at} {what} have more, where giving up is right. \
                 No descent begins beyond {descent} m/s, by the tilt (control.lander.wind_slope, \
                 control.horizontal.tilt_limit_rad): {beyond_descent} of {looked_at} {what} have more"
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
    fn analytic_landings_beyond_are_counted_where_the_wind_is_drawn() {
        // Evenly from 0 to 36 m/s, twice of what 0.9 of the thrust holds: about half. Both points of a trial have the same draw.
        let file = "trials = 400\n[grid]\nground_effect_strength = [0.5, 1.0]\n\
            [random]\n\"wind.steady_mps.0\" = { kind = \"uniform\", min = 0.0, max = 36.0 }\n";
        let text = air(file).unwrap();
        let (_, rest) = text.split_once("greatest thrust at ").unwrap();
        let limit_mps: f64 = rest.split(' ').next().unwrap().parse().unwrap();
        let (_, rest) = rest.split_once("m/s: ").unwrap();
        let beyond: f64 = rest.split(' ').next().unwrap().parse().unwrap();
        assert!(rest.contains(" of 800 landings have more"), "{text}");
        // Three standard deviations of 400 draws are 60 of 800.
        let expected = 800.0 * (1.0 - limit_mps / 36.0);
        assert!((beyond - expected).abs() < 60.0, "{text}");
        // Of more landings than are looked at, all points and trials: in 1000 points of two trials, both trials.
        let strengths: Vec<String> = (0..1000)
            .map(|k| format!("{}", 0.5 + 1e-4 * f64::from(k)))
            .collect();
        let file = format!(
            "trials = 2\nseed = 1\n[grid]\nground_effect_strength = [{}]\n\
             [random]\n\"wind.steady_mps.0\" = {{ kind = \"choice\", of = [1.0, 30.0] }}\n",
            strengths.join(", ")
        );
        let text = air(&file).unwrap();
        assert!(
            text.contains("1.0 to 30.0 m/s")
                && text.contains(" 500 of 1000 landings that were looked at"),
            "{text}"
        );
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
        // A gust of the faults counts as well, beside the wind and alone.
        let gust = "faults = { gust = { velocity_mps = [25.0, 0.0, 0.0], from_s = 1.0, rise_s = 0.5, hold_s = 5.0 } }\n";
        let text = air(&format!("[scenario]\n{gust}")).unwrap();
        assert!(
            text.contains("25.0 m/s") && text.contains(": 1 of 1 points"),
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
