//! Where the noise of a map comes from.
//!
//! A regression predicts each row from the one before: right where noise acts on the map itself, and where rows are measured without
//! noise. Noise of the measurement is in what it predicts from as well, which spoils coefficients and terms. There trajectories of the
//! map are followed. Of the two the likelier is taken. Both give a probability density for all rows,
//!
//! ```text
//! -2 ln p = Σ_i ( (N - S) ln s_i² + S ln d_i² ) + penalty x (terms),       d_i² variance of state i over the data
//! ```
//!
//! with `s_i` the error of the next row, or the distance of the trajectories; the S rows where a trajectory starts are as likely as
//! any in the data.

use super::follow::FollowedModel;
use super::rank::RankedModel;
use super::regress::Statistics;
use super::run::IdentificationRun;
use super::{NoiseSource, map_outliers, neighbours};
use crate::error::SindyError;
use crate::model::Model;
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::statistics::gram::Gram;

/// Level of the test for errors of the next sample that depend on the state: of true maps one in a hundred is warned of.
const LACKS: f64 = 0.01;

impl IdentificationRun<'_> {
    /// Whether a map that was followed through noise of the measurement is likelier than the best regression, by odds of 20 to 1.
    pub(super) fn is_measured_map(
        &self,
        followed: &FollowedModel,
        ranked: &[RankedModel],
        statistics: &Statistics,
    ) -> bool {
        let fit = &followed.fit;
        if !followed.is_in_noise() {
            return false;
        }
        let states = self.data.states().len();
        let rows = (fit.values / states) as f64;
        let score = |sizes: &[f64], starts: f64, terms: usize| {
            let of = |(i, size): (usize, &f64)| {
                let spread = self.noise.spread(i);
                (rows - starts) * 2.0 * size.max(self.noise.floor[i]).ln()
                    + starts * 2.0 * spread.max(f64::MIN_POSITIVE).ln()
            };
            let all: f64 = sizes.iter().enumerate().map(of).sum();
            all + terms as f64 * fit.penalty
        };
        let terms = fit.coefficients.iter().filter(|c| **c != 0.0).count();
        let own = score(&fit.sigma, fit.arcs as f64, terms);
        let counts: Vec<f64> = statistics
            .grams
            .iter()
            .map(|parts| Gram::total(parts).rows.max(1) as f64)
            .collect();
        // Trajectories may have been followed on a part of the rows.
        let all: usize = self.stretches.iter().map(|s| s.time.len()).sum();
        let begun = self.stretches.len() as f64 * rows / all as f64;
        let other = |model: &RankedModel| {
            let fits = model.regression.fits.iter().zip(&counts);
            let sizes: Vec<f64> = fits.map(|(f, n)| (f.residual_sum / n).sqrt()).collect();
            score(&sizes, begun, model.terms())
        };
        let best = ranked.iter().map(other).fold(f64::INFINITY, f64::min);
        own < best - TWENTY_TO_ONE
    }

    /// In discrete time, warnings where the error of the next sample depends on the state (of noise of the measurement it does), and
    /// where single rows are far off.
    pub(super) fn lack_of_map(
        &self,
        model: &Model,
        followed: Option<&FollowedModel>,
    ) -> Result<Vec<String>, SindyError> {
        let mut out = Vec::new();
        if !self.settings.discrete {
            return Ok(out);
        }
        let is_measured = followed.is_some_and(FollowedModel::is_in_noise);
        if !is_measured && self.settings.noise == NoiseSource::Automatic {
            let p = neighbours::independence(model, &self.stretches, &self.noise.floor)?;
            out.extend(p.filter(|p| *p <= LACKS).map(|p| {
                format!(
                    "rows that are neighbours have errors of the next sample that are alike (p = {p:.2}): a term is not in the \
                     library, the noise depends on the state, or it is noise of the measurement (setting `noise`)"
                )
            }));
        }
        let left = map_outliers::left(self.data, &self.stretches, model)?;
        if left > 0 {
            out.push(format!(
                "{} far off what the model predicts from the row before, among those that it was fitted to: outliers, or a term \
                 is not in the library",
                match left {
                    1 => "1 row is".to_owned(),
                    n => format!("{n} rows are"),
                }
            ));
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::super::{Identification, Settings};
    use super::*;
    use crate::{Dataset, Identify, Library};

    /// Two runs of a Hénon map, with this noise on what is measured of x, and three tenths of it on y.
    fn henon(seed: u64, noise: f64, source: NoiseSource) -> Identification {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
        for start in [[0.1, 0.1], [-0.3, 0.2]] {
            let mut columns = vec![Vec::new(), Vec::new()];
            let [mut x, mut y] = start;
            for _ in 0..400 {
                let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
                columns[0].push(x + noise * a);
                columns[1].push(y + 0.3 * noise * b);
                (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
            }
            let time = (0..400).map(f64::from).collect();
            data.push("run", time, columns, None).unwrap();
        }
        let settings = Settings {
            discrete: true,
            noise: source,
            ..Settings::default()
        };
        let identify = Identify::new(Library::polynomial(&["x", "y"], 3).unwrap());
        let identify = identify.settings(settings).unwrap();
        identify.run(&data, &mut |_| ()).unwrap()
    }

    fn terms(found: &Identification) -> Vec<Vec<String>> {
        let of = |t: &crate::model::Term| t.expression.to_string();
        let equations = found.model.equations().iter();
        equations.map(|e| e.iter().map(of).collect()).collect()
    }

    #[test]
    fn analytic_noise_of_the_measurement_of_a_map_is_found() {
        for seed in 0..3 {
            for source in [NoiseSource::Automatic, NoiseSource::Measurement] {
                let found = henon(seed, 0.02, source);
                assert_eq!(
                    terms(&found),
                    [vec!["1", "y", "x^2"], vec!["x"]],
                    "{}",
                    found.model
                );
                assert_eq!(found.choice.method, "output_error");
                assert!(found.warnings.is_empty(), "{:?}", found.warnings);
                let noise = [0.02, 0.006];
                for (equation, noise) in found.equations.iter().zip(noise) {
                    // 800 samples less 100 for the starts of arcs: four times 1/√1400.
                    let left = equation.residual.unwrap() / noise;
                    assert!((left - 0.94).abs() < 0.11, "{left}");
                }
                let square = &found.model.equations()[0][2];
                // Two of three draws are within a standard error; four hold all.
                let error = (square.coefficient + 1.4).abs();
                assert!(error < 4.0 * square.std_error.unwrap(), "{square:?}");
            }
        }
    }

    #[test]
    fn analytic_rows_without_noise_and_noise_of_the_map_are_regressions() {
        for seed in 0..3 {
            let clean = henon(seed, 0.0, NoiseSource::Automatic);
            assert_eq!(
                terms(&clean),
                [vec!["1", "y", "x^2"], vec!["x"]],
                "{}",
                clean.model
            );
            assert_ne!(clean.choice.method, "output_error");
        }
    }
}
