//! The noise of the simulated sensors beside what the landing computer believes of it.

use std::collections::BTreeMap;

use touchdown_sim::landing::space::SpaceScenario;

use super::points::Sweep;
use crate::error::Result;

/// Ratio of a sensor's noise to the believed noise above which there is a warning. The estimator refuses readings beyond five
/// standard deviations. With twice the noise that is one reading in 80, with three times the noise one in ten.
const TOLD: f64 = 2.0;

/// A sensor's noise and the belief: their keys and values.
struct Noise {
    key: &'static str,
    value: f64,
    believed_key: &'static str,
    believed: f64,
}

fn noises(scenario: &SpaceScenario) -> Vec<Noise> {
    let (sensors, believed) = (&scenario.sensors, &scenario.control.relative);
    let noise = |key, value, believed_key, believed| Noise {
        key,
        value,
        believed_key,
        believed,
    };
    let mut all = vec![
        noise(
            "sensors.imu.noise_density",
            sensors.imu.noise_density,
            "control.relative.imu.noise_density",
            believed.imu.noise_density,
        ),
        noise(
            "sensors.range.noise_sd_m",
            sensors.range.noise_sd_m,
            "control.relative.range.noise_sd_m",
            believed.range.noise_sd_m,
        ),
    ];
    if sensors.with_gnss {
        all.extend([
            noise(
                "sensors.gnss.horizontal_sd_mps",
                sensors.gnss.horizontal_sd_mps,
                "control.relative.gnss.horizontal_sd_mps",
                believed.gnss.horizontal_sd_mps,
            ),
            noise(
                "sensors.gnss.vertical_sd_mps",
                sensors.gnss.vertical_sd_mps,
                "control.relative.gnss.vertical_sd_mps",
                believed.gnss.vertical_sd_mps,
            ),
        ]);
    }
    if sensors.with_barometer {
        all.push(noise(
            "sensors.barometer.noise_sd_m",
            sensors.barometer.noise_sd_m,
            "control.relative.barometer.noise_sd_m",
            believed.barometer.noise_sd_m,
        ));
    }
    if sensors.with_beacon {
        all.push(noise(
            "sensors.beacon.velocity_sd_mps",
            sensors.beacon.velocity_sd_mps,
            "control.relative.beacon.velocity_sd_mps",
            believed.beacon.velocity_sd_mps,
        ));
    }
    all
}

impl Sweep {
    /// Sensors whose noise is much more than the landing computer believes at some points, a sentence for each. Random draws
    /// are not looked at.
    ///
    /// # Errors
    /// A point whose settings make no scenario.
    pub fn noise_warnings(&self) -> Result<Vec<String>> {
        let points = self.points_if_varied(&["sensors", "control.relative"]);
        let mut worst = BTreeMap::<&str, Noise>::new();
        for point in 0..points {
            for noise in noises(&self.scenario(point)?) {
                let share = |n: &Noise| n.value / n.believed;
                let known = worst.get(noise.key).map_or(TOLD, share);
                if share(&noise) > known {
                    worst.insert(noise.key, noise);
                }
            }
        }
        let text = |noise: &Noise| {
            format!(
                "the landing computer believes in less noise than the sensor has: {} = {}, {} = {}. It refuses good readings \
                 then; set both",
                noise.key, noise.value, noise.believed_key, noise.believed
            )
        };
        Ok(worst.values().map(text).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Sweep;

    fn warnings(file: &str) -> Vec<String> {
        let settings = toml::from_str(file).unwrap();
        let sweep = Sweep::new(settings, Path::new(""), "s.toml".into()).unwrap();
        sweep.noise_warnings().unwrap()
    }

    #[test]
    fn analytic_noise_beyond_the_belief_is_told_with_both_keys() {
        assert!(warnings("[grid]\nground_effect_strength = [0.5, 1.0]\n").is_empty());
        let range = "[grid]\n\"sensors.range.noise_sd_m\" = [0.005, 0.05]\n";
        let told = warnings(range);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].contains(
            "sensors.range.noise_sd_m = 0.05, control.relative.range.noise_sd_m = 0.005"
        ));
        let both = "[grid]\n\"sensors.range.noise_sd_m\" = [0.05]\n\"control.relative.range.noise_sd_m\" = [0.05]\n";
        assert!(warnings(both).is_empty());
        let unused =
            "[scenario]\nsensors = { with_gnss = false, gnss = { horizontal_sd_mps = 0.5 } }\n";
        assert!(warnings(unused).is_empty());
    }
}
