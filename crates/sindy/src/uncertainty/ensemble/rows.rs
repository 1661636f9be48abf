//! Drawing single rows: every replicate's statistics in one pass over the data.

use rayon::prelude::*;

use super::{Ensemble, Ensembled};
use crate::data::samples::{BlockSource, passed};
use crate::error::SindyError;
use crate::library::Library;
use crate::solve::fit::{Fit, Solver};
use crate::statistics::gram::plan::Plan;
use crate::statistics::gram::weighted::{PANEL, Panel};
use crate::statistics::gram::{Gram, check};
use crate::uncertainty::resample::{RowDraws, generator};

impl Ensemble {
    /// Fits every replicate of the rows of all groups together, one result for each target: a replicate draws as
    /// many rows as there are, with replacement, and its statistics are sums weighted by how often each row was
    /// drawn. All replicates are summed in one pass over the data (after one that counts the rows), in memory
    /// for 32 numbers for each different product of two terms and thread, whatever the number of rows. Targets
    /// share the rows and the terms of a replicate. The draws depend on the seed and on the source's blocks.
    ///
    /// For rows that are independent of each other. Those of a time series are not: their intervals come out too
    /// narrow, and [`Ensemble::run`] on trajectories or blocks is right.
    ///
    /// ```
    /// use sindy::uncertainty::ensemble::Ensemble;
    /// use sindy::{Library, Samples, Stlsq};
    ///
    /// let x: Vec<f64> = (0..1000).map(|i| (0.37 * f64::from(i)).sin()).collect();
    /// let y = x.iter().enumerate().map(|(i, x)| 2.0 * x + 0.1 * (i as f64 * i as f64).sin()).collect();
    /// let mut samples = Samples::new(&["x", "y"]);
    /// samples.push_group(vec![x, y])?;
    /// let library = Library::parse(&["1", "x", "x^3"])?;
    /// let solver = Stlsq::new(0.1, 0.0)?;
    /// let y = &Ensemble::new(100, 1)?.run_rows(&library, &["y"], &samples, &solver)?[0];
    /// assert_eq!(y.inclusion[1], 1.0);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// A term or a target that names no column, fewer than two rows, as many terms to leave out as there
    /// are, no finite rows in a replicate, an error of the solver, or a pass that failed
    /// ([`BlockSource::failure`]; a source must bear two).
    pub fn run_rows(
        &self,
        library: &Library,
        targets: &[&str],
        source: &dyn BlockSource,
        solver: &dyn Solver,
    ) -> Result<Vec<Ensembled>, SindyError> {
        let p = library.len();
        self.check_omit(p)?;
        let plan = Plan::new(library, targets, source.names())?;
        let mut rows = 0;
        source.for_each_block(&mut |block| rows += block.columns.first().map_or(0, |c| c.len()));
        passed(source)?;
        if rows < 2 {
            return Err(SindyError::too_short(2, rows));
        }
        let all: Vec<usize> = (0..self.replicates).collect();
        let mut batches: Vec<Batch> = all
            .chunks(PANEL)
            .map(|replicates| {
                let (draws, terms) = replicates
                    .iter()
                    .map(|&r| {
                        let mut rng = generator(self.seed, r);
                        let terms = self.terms(p, &mut rng);
                        (RowDraws::new(rng, rows), terms)
                    })
                    .unzip();
                Batch {
                    panel: Panel::new(&plan),
                    draws,
                    terms,
                }
            })
            .collect();
        source.for_each_block(&mut |block| {
            let n = block.columns.first().map_or(0, |c| c.len());
            batches.par_iter_mut().for_each(|batch| {
                let draws = &mut batch.draws;
                batch
                    .panel
                    .add_rows(&plan, block.columns, 0..n, |rows, weights| {
                        for (b, draws) in draws.iter_mut().enumerate() {
                            if self.resample {
                                draws.fill(rows, weights, (b, PANEL));
                            } else {
                                (0..rows).for_each(|r| weights[r * PANEL + b] = 1.0);
                            }
                        }
                    });
            });
        });
        passed(source)?;
        let replicates: Vec<Vec<Replicate>> = batches
            .par_iter()
            .map(|batch| batch.fits(self, &plan, solver))
            .collect::<Result<_, _>>()?;
        let mut of_target = vec![Vec::with_capacity(self.replicates); targets.len()];
        for Replicate { terms, fits } in replicates.into_iter().flatten() {
            for (list, fit) in of_target.iter_mut().zip(fits) {
                list.push((terms.clone(), fit));
            }
        }
        Ok(of_target
            .iter()
            .map(|fits| self.summarise(p, fits))
            .collect())
    }
}

/// The terms of a replicate, and the fit of each target over them.
struct Replicate {
    terms: Vec<usize>,
    fits: Vec<Fit>,
}

/// Replicates that are summed together.
struct Batch {
    panel: Panel,
    draws: Vec<RowDraws>,
    terms: Vec<Vec<usize>>,
}

impl Batch {
    fn fits(
        &self,
        ensemble: &Ensemble,
        plan: &Plan,
        solver: &dyn Solver,
    ) -> Result<Vec<Replicate>, SindyError> {
        self.terms
            .par_iter()
            .enumerate()
            .map(|(b, terms)| {
                let fit = |gram: Gram| {
                    check(&gram)?;
                    ensemble.fit(gram, terms, solver)
                };
                let grams = self.panel.grams(plan, b);
                Ok(Replicate {
                    terms: terms.clone(),
                    fits: grams.into_iter().map(fit).collect::<Result<_, _>>()?,
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use rand_pcg::Pcg64;

    use super::*;
    use crate::{Samples, Stlsq};
    use rand::{RngExt, SeedableRng};

    /// `y = 2 x + noise` and `z = x^2 - 1 + noise`, independent rows in two groups.
    fn samples(n: usize) -> Samples {
        let mut rng = Pcg64::seed_from_u64(7);
        let mut samples = Samples::new(&["x", "y", "z"]);
        for n in [n / 3, n - n / 3] {
            let mut noisy = || rng.random_range(-1.0..1.0);
            let x: Vec<f64> = (0..n).map(|_| noisy()).collect();
            let y = x.iter().map(|x| 2.0 * x + 0.3 * noisy()).collect();
            let z = x.iter().map(|x| x * x - 1.0 + 0.3 * noisy()).collect();
            samples.push_group(vec![x, y, z]).unwrap();
        }
        samples
    }

    fn library() -> Library {
        Library::parse(&["1", "x", "x^2", "x^3"]).unwrap()
    }

    #[test]
    fn prop_draws_are_as_many_as_rows_and_each_row_as_likely() {
        const ROWS: usize = 600;
        let mut counts = vec![0.0; ROWS];
        let mut squares = 0.0;
        for seed in 0..200 {
            let mut draws = RowDraws::new(Pcg64::seed_from_u64(seed), ROWS);
            let mut total = 0.0;
            for start in (0..ROWS).step_by(256) {
                let rows = 256.min(ROWS - start);
                let mut weights = vec![0.0; rows * PANEL];
                draws.fill(rows, &mut weights, (3, PANEL));
                for (r, w) in weights.chunks(PANEL).enumerate() {
                    counts[start + r] += w[3];
                    squares += (w[3] - 1.0).powi(2);
                    total += w[3];
                }
            }
            assert_eq!(total, ROWS as f64);
        }
        // Each count has mean 200 and standard deviation 14; six of them, for 600 rows.
        assert!(counts.iter().all(|c| (c - 200.0).abs() < 85.0));
        // The variance of a weight is 1 - 1/n; the mean of 120 000 squared deviations is within 0.02 of it.
        assert!((squares / 120_000.0 - 1.0).abs() < 0.02);
    }

    #[test]
    fn analytic_spread_is_the_standard_error() {
        let samples = samples(2000);
        let ensemble = Ensemble::new(400, 3).unwrap();
        let solver = Stlsq::new(0.1, 0.0).unwrap();
        let found = ensemble
            .run_rows(&library(), &["y", "z"], &samples, &solver)
            .unwrap();
        let [y, z] = found.as_slice() else {
            unreachable!("two targets")
        };
        assert!(y.inclusion[1] == 1.0 && z.inclusion[0] == 1.0 && z.inclusion[2] == 1.0);
        // y = a x: the standard error is 0.3/√3 / (√(1/3) √2000) = 0.0067; 400 replicates know it to 4 %, and the
        // sample's own noise and spread differ from their expectation by 3 %: four times that.
        let spread = (y.coefficients.row(1).variance()).sqrt();
        assert!((spread / 0.0067 - 1.0).abs() < 0.2, "{spread}");
        assert!((y.mean[1] - 2.0).abs() < 4.0 * 0.0067);
    }

    #[test]
    fn prop_same_seed_same_bits_for_any_number_of_threads() {
        let samples = samples(3000);
        let solver = Stlsq::new(0.05, 0.0).unwrap();
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let ensemble = Ensemble::new(70, 5).unwrap().omit(1);
            pool.install(|| {
                ensemble
                    .run_rows(&library(), &["y"], &samples, &solver)
                    .unwrap()
            })
        };
        let one = run(1);
        assert_eq!(one, run(2));
        assert_eq!(one, run(5));
        assert_eq!(one[0].offered.iter().sum::<usize>(), 3 * 70);
    }

    #[test]
    fn prop_without_resampling_all_replicates_are_the_plain_fit() {
        let samples = samples(500);
        let solver = Stlsq::new(0.1, 0.0).unwrap();
        let ensemble = Ensemble::new(3, 1).unwrap().resample(false);
        let y = &ensemble
            .run_rows(&library(), &["y"], &samples, &solver)
            .unwrap()[0];
        let gram = Gram::total(&Gram::accumulate(&library(), "y", &samples).unwrap());
        let plain = solver.fit(&gram).unwrap();
        for replicate in y.coefficients.column_iter() {
            // The same sums in another order.
            assert!((replicate - &plain.coefficients).amax() < 1e-12);
        }
    }

    #[test]
    fn prop_bad_input_is_refused() {
        let solver = Stlsq::new(0.1, 0.0).unwrap();
        let ensemble = Ensemble::new(3, 1).unwrap();
        let run = |samples: &Samples| ensemble.run_rows(&library(), &["y"], samples, &solver);
        let mut one = Samples::new(&["x", "y"]);
        assert!(matches!(run(&one), Err(SindyError::TooShort { .. })));
        one.push_group(vec![vec![1.0], vec![1.0]]).unwrap();
        assert!(matches!(run(&one), Err(SindyError::TooShort { .. })));
        let mut nothing = Samples::new(&["x", "y"]);
        nothing
            .push_group(vec![vec![f64::NAN; 9], vec![1.0; 9]])
            .unwrap();
        assert!(run(&nothing).is_err());
        assert!(matches!(
            ensemble.run_rows(&library(), &["w"], &samples(9), &solver),
            Err(SindyError::UnknownColumn { .. })
        ));
        assert!(
            ensemble
                .omit(4)
                .run_rows(&library(), &["y"], &samples(9), &solver)
                .is_err()
        );
    }
}
