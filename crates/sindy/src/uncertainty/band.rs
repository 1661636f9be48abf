//! Bands: where a prediction lies, point by point.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sindy_expr::Scratch;

use crate::error::{SindyError, require, same_size};
use crate::library::Library;
use crate::model::{Model, Run, RunOutcome};
use crate::numerics::quantile;

/// Pointwise bands: `lower[i][k]` is that of column i (a state) in row k, in its own unit.
///
/// A band covers the uncertainty of the *coefficients* only, without measurement noise and without missing terms of the
/// library. It is pointwise: a whole curve stays inside less often.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// The lower end.
    pub lower: Vec<Vec<f64>>,
    /// The middle: the median of the members, or the prediction.
    pub middle: Vec<Vec<f64>>,
    /// The upper end.
    pub upper: Vec<Vec<f64>>,
    /// How many members each row's ends come from; zero for a band from a covariance.
    pub members: Vec<usize>,
    /// How the members' runs ended; empty for predictions.
    pub outcomes: Vec<RunOutcome>,
}

impl Band {
    /// The band of the right-hand sides that `models` (such as [`models`](super::models) of a bootstrap) give over
    /// columns as in [`Model::predict`]: quantiles that hold the share `level` of the members between them. Members
    /// whose value is not finite are left out, and the row's count of members shows it; a row with fewer than two
    /// has NaN.
    ///
    /// # Errors
    /// As [`Model::predict`]; fewer than two models; a level that is not between 0 and 1.
    pub fn of_predictions(
        models: &[Model],
        columns: &[&[f64]],
        level: f64,
    ) -> Result<Self, SindyError> {
        check(models, level)?;
        let values: Vec<Vec<Vec<f64>>> = models
            .par_iter()
            .map(|model| model.predict(columns))
            .collect::<Result<_, _>>()?;
        let rows = columns.first().map_or(0, |c| c.len());
        Self::of_members(&values, rows, level)
    }

    /// The band of simulations: `run` runs each model, for instance by [`Model::simulate`] from one start. Quantiles
    /// are over the members that have reached a row; the band ends where fewer than half of them (or fewer than
    /// two) have. Members that blow up or leave their range have their outcome in `outcomes`, and are missing from rows after
    /// that: with many of them the band is too narrow.
    ///
    /// ```
    /// use sindy::model::{Inputs, Model, Simulation, Term, Time};
    /// use sindy::uncertainty::Band;
    ///
    /// let models = [1.9, 2.0, 2.1].map(|k| {
    ///     let decay = vec![vec![Term::parse("x", -k).unwrap()]];
    ///     Model::new(Time::Continuous, &["x"], &[], decay).unwrap()
    /// });
    /// let band = Band::of_runs(&models, 0.999, |model| {
    ///     model.simulate(&[1.0], &[0.0, 0.5, 1.0], &Inputs::none(), &Simulation::adaptive())
    /// })?;
    /// assert!(band.lower[0][2] < (-2.0_f64).exp() && (-2.0_f64).exp() < band.upper[0][2]);
    /// assert_eq!(band.finished(), 3);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// Of `run`; fewer than two models; a level that is not between 0 and 1; runs at different times.
    pub fn of_runs(
        models: &[Model],
        level: f64,
        run: impl Fn(&Model) -> Result<Run, SindyError> + Sync,
    ) -> Result<Self, SindyError> {
        check(models, level)?;
        let runs: Vec<Run> = models
            .par_iter()
            .map(&run)
            .collect::<Result<_, SindyError>>()?;
        let needed = models.len().div_ceil(2).max(2);
        let mut lengths: Vec<usize> = runs.iter().map(|r| r.time.len()).collect();
        lengths.sort_unstable();
        let rows = lengths[lengths.len() - needed];
        let longest = runs.iter().max_by_key(|r| r.time.len());
        for (run, longest) in runs.iter().zip(longest.into_iter().cycle()) {
            require(
                run.time == longest.time[..run.time.len()],
                "run",
                "the same times for all models",
                "different times",
            )?;
        }
        let (values, outcomes): (Vec<_>, Vec<_>) =
            runs.into_iter().map(|r| (r.states, r.outcome)).unzip();
        Ok(Self {
            outcomes,
            ..Self::of_members(&values, rows, level)?
        })
    }

    /// The band `θ ξ ± z √(θ C θᵀ)` of a linear prediction over columns, in the order of `names`, with `C` the
    /// covariance of the coefficients and z the normal quantile of `level`. Rows whose terms are not finite
    /// have NaN.
    ///
    /// # Errors
    /// Shapes that do not fit, names without a column, a level that is not between 0 and 1.
    pub fn of_covariance(
        library: &Library,
        coefficients: &DVector<f64>,
        covariance: &DMatrix<f64>,
        names: &[String],
        columns: &[&[f64]],
        level: f64,
    ) -> Result<Self, SindyError> {
        check_level(level)?;
        let p = library.len();
        let rows = columns.first().map_or(0, |c| c.len());
        let unequal = columns.iter().find(|c| c.len() != rows);
        for (what, expected, found) in [
            ("coefficients (one per term)", p, coefficients.len()),
            ("rows of the covariance", p, covariance.nrows()),
            ("columns of the covariance", p, covariance.ncols()),
            ("columns (one per name)", names.len(), columns.len()),
            ("rows of a column", rows, unequal.map_or(rows, |c| c.len())),
        ] {
            same_size(what, expected, found)?;
        }
        let program = library.compile(names)?;
        let mut theta = vec![0.0; p * rows];
        if rows > 0 {
            program.eval_block(columns, &mut theta, &mut Scratch::default());
        }
        let z = normal_quantile(0.5 * (1.0 + level));
        let (mut lower, mut middle, mut upper) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..rows {
            let row = DVector::from_fn(p, |j, _| theta[j * rows + k]);
            let value = row.dot(coefficients);
            let half = z * row.dot(&(covariance * &row)).max(0.0).sqrt();
            let finite = row.iter().all(|v| v.is_finite());
            let keep = |v: f64| if finite { v } else { f64::NAN };
            lower.push(keep(value - half));
            middle.push(keep(value));
            upper.push(keep(value + half));
        }
        Ok(Self {
            lower: vec![lower],
            middle: vec![middle],
            upper: vec![upper],
            members: vec![0; rows],
            outcomes: Vec::new(),
        })
    }

    /// Members whose run came to its end.
    #[must_use]
    pub fn finished(&self) -> usize {
        let ended = |o: &&RunOutcome| **o == RunOutcome::Finished;
        self.outcomes.iter().filter(ended).count()
    }

    fn of_members(values: &[Vec<Vec<f64>>], rows: usize, level: f64) -> Result<Self, SindyError> {
        let columns = values.first().map_or(0, Vec::len);
        if let Some(other) = values.iter().find(|v| v.len() != columns) {
            return Err(SindyError::shape("states of a model", columns, other.len()));
        }
        let empty = || vec![Vec::with_capacity(rows); columns];
        let (mut lower, mut middle, mut upper) = (empty(), empty(), empty());
        let mut members = vec![usize::MAX; rows];
        for i in 0..columns {
            for k in 0..rows {
                let at = values.iter().filter_map(|member| member[i].get(k));
                let mut at: Vec<f64> = at.copied().filter(|v| v.is_finite()).collect();
                at.sort_by(f64::total_cmp);
                members[k] = members[k].min(at.len());
                let of = |q: f64| {
                    if at.len() < 2 {
                        f64::NAN
                    } else {
                        quantile(&at, q)
                    }
                };
                lower[i].push(of(0.5 * (1.0 - level)));
                middle[i].push(of(0.5));
                upper[i].push(of(0.5 * (1.0 + level)));
            }
        }
        Ok(Self {
            lower,
            middle,
            upper,
            members,
            outcomes: Vec::new(),
        })
    }
}

fn check(models: &[Model], level: f64) -> Result<(), SindyError> {
    if models.len() < 2 {
        return Err(SindyError::shape(
            "models of a band (at least)",
            2,
            models.len(),
        ));
    }
    check_level(level)
}

fn check_level(level: f64) -> Result<(), SindyError> {
    if level > 0.0 && level < 1.0 {
        Ok(())
    } else {
        Err(SindyError::setting("level", "between 0 and 1", level))
    }
}

/// The z at which the standard normal distribution has come to `probability`, for 0.5 to 1 - 10⁻⁹.
///
/// Newton's method on `Φ(z) = 1/2 + φ(z) Σ z^(2k+1)/(1·3·…·(2k+1))`.
pub(super) fn normal_quantile(probability: f64) -> f64 {
    let probability = probability.min(1.0 - 1e-9);
    let mut z: f64 = 0.0;
    for _ in 0..100 {
        let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        let (mut term, mut sum, mut k) = (z, z, 1.0);
        while term > 1e-17 * sum {
            k += 2.0;
            term *= z * z / k;
            sum += term;
        }
        // From below, where the distribution is concave, Newton's steps never go too far.
        let step = (probability - 0.5 - density * sum) / density;
        z += step;
        if step.abs() < 1e-14 * z {
            break;
        }
    }
    z
}
