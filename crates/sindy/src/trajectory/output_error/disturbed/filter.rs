//! The extended Kalman filter along a record, with the derivatives of its innovations by the coefficients.

use nalgebra::{DMatrix, DVector};

use super::{DiffusionCandidates, Disturbance};
use crate::trajectory::output_error::arcs::Sums;
use crate::trajectory::output_error::follow::{Follow, Sensitivity};
use crate::trajectory::output_error::record::Record;

/// A model and the variances that its filter believes.
pub(super) struct Filter<'a> {
    pub follow: Follow<'a>,
    pub noise: &'a Disturbance,
}

/// A step from one row to the next as the filter has linearised it: from `from` to `to`, with derivatives `transition`.
pub(super) struct Linear {
    pub from: DVector<f64>,
    pub to: DVector<f64>,
    pub transition: DMatrix<f64>,
    pub period: f64,
    /// Candidate terms of the diffusion at both ends; empty where disturbances do not depend on the state.
    pub terms: [Vec<f64>; 2],
}

/// One record as the filter has seen it.
pub(super) struct Pass {
    /// `[X | y]ᵀ [X | y]` of the innovations y and their derivatives by all candidates, mapped to unit covariance.
    pub sums: Sums,
    /// Sum of the logarithms of the determinants of that covariance.
    pub log_determinant: f64,
    /// By measured state and sample compared: innovations mapped to unit covariance.
    pub innovations: Vec<Vec<f64>>,
    /// By row compared: the same, NaN of states that are not measured there.
    pub errors: Vec<Vec<f64>>,
    /// By row compared: state and inputs before it.
    pub points: Vec<Vec<f64>>,
    /// By row from the second on.
    pub steps: Vec<Linear>,
}

/// Mean and covariance of the state.
pub(super) struct Belief {
    pub mean: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

/// What a row adds.
pub(super) struct Update {
    /// The states that are measured there.
    pub states: Vec<usize>,
    /// Innovations mapped to unit covariance.
    pub innovation: DVector<f64>,
    pub log_determinant: f64,
    /// The lower triangular root of the innovations' covariance.
    pub root: DMatrix<f64>,
    pub gain: DMatrix<f64>,
}

impl Belief {
    /// At a record's first row: measured states as they are measured, others anywhere in the range of the record.
    pub(super) fn first(record: &Record, noise: &Disturbance) -> Self {
        let measured = noise.measurement.len();
        let mut mean = DVector::from_column_slice(&record.nodes[0]);
        let mut variance = DVector::zeros(mean.len());
        for i in 0..mean.len() {
            if i >= measured || record.sample(i, 0).is_none() {
                variance[i] = record.spread[i];
            } else {
                variance[i] = noise.measurement[i];
                if record.root_weight(0) > 0.0 {
                    mean[i] = record.states[i][0];
                }
            }
        }
        Self {
            mean,
            covariance: DMatrix::from_diagonal(&variance),
        }
    }

    /// Over a step, to a mean. What disturbances add along the step is summed by the trapezoidal rule: half of it is there at the
    /// start and moves with the state, half comes at the end.
    pub(super) fn predict(&mut self, mean: DVector<f64>, step: &Linear, noise: &Disturbance) {
        let half = 0.5 * step.period;
        let [from, to] = &step.terms;
        self.mean = mean;
        for i in 0..self.mean.len() {
            self.covariance[(i, i)] += half * noise.rate(i, from);
        }
        self.covariance = &step.transition * &self.covariance * step.transition.transpose();
        for i in 0..self.mean.len() {
            self.covariance[(i, i)] += half * noise.rate(i, to);
        }
    }

    /// By a row; `None` where its covariance is not positive.
    pub(super) fn update(
        &mut self,
        record: &Record,
        row: usize,
        noise: &Disturbance,
    ) -> Option<Update> {
        let weight = record.root_weight(row).powi(2);
        let states: Vec<usize> = (0..noise.measurement.len())
            .filter(|&i| record.sample(i, row).is_some())
            .collect();
        let seen = self.covariance.select_rows(&states);
        let mut s = seen.select_columns(&states);
        for (k, &i) in states.iter().enumerate() {
            s[(k, k)] += noise.measurement[i] / weight;
        }
        let cholesky = s.cholesky()?;
        let root = cholesky.l();
        let nu = DVector::from_fn(states.len(), |k, _| {
            record.states[states[k]][row] - self.mean[states[k]]
        });
        let gain = cholesky.solve(&seen).transpose();
        self.mean += &gain * &nu;
        self.covariance -= &gain * &seen;
        // The difference of symmetric matrices, but for rounding.
        self.covariance = (&self.covariance + self.covariance.transpose()) * 0.5;
        Some(Update {
            innovation: root.solve_lower_triangular(&nu)?,
            log_determinant: root.diagonal().iter().map(|r| 2.0 * r.ln()).sum(),
            states,
            root,
            gain,
        })
    }
}

impl Filter<'_> {
    /// Runs the filter along a record; `None` where it leaves the finite numbers.
    pub(super) fn run(&self, record: &Record) -> Option<Pass> {
        let system = self.follow.system;
        let (n, p, measured) = (system.n, system.size(), system.measured);
        let rows = record.time.len();
        let mut pass = Pass {
            sums: Sums::new(p),
            log_determinant: 0.0,
            innovations: vec![Vec::with_capacity(rows); measured],
            errors: Vec::with_capacity(rows),
            points: Vec::with_capacity(rows),
            steps: Vec::with_capacity(rows),
        };
        let (mut work, mut step) = (system.work(self.follow.coefficients), system.blank());
        let mut diffusion = system.diffusion.as_ref().map(DiffusionCandidates::values);
        let mut belief = Belief::first(record, self.noise);
        // Derivatives of the mean by the coefficients.
        let mut by = DMatrix::zeros(n, p);
        for row in 1..rows {
            let mut along = Sensitivity::start(n, p);
            let from = belief.mean.clone();
            let mut x: Vec<f64> = from.iter().copied().collect();
            let substeps = self.follow.cut.substeps;
            let scratch = (&mut work, &mut step);
            self.follow
                .advance(record, row - 1, substeps, &mut x, scratch, Some(&mut along));
            let finite = x.iter().chain(along.m.iter()).all(|v| v.is_finite());
            if !finite {
                return None;
            }
            let mut terms = |x: &[f64], part: f64| {
                let values = diffusion.as_mut();
                values.map_or(Vec::new(), |v| v.at(x, &record.inputs_at(row - 1, part)))
            };
            let linear = Linear {
                terms: [terms(from.as_slice(), 0.0), terms(&x, 1.0)],
                to: DVector::from_vec(x),
                transition: along.m.columns(0, n).into_owned(),
                period: record.time[row] - record.time[row - 1],
                from,
            };
            by = &linear.transition * by + along.m.columns(n, p);
            belief.predict(linear.to.clone(), &linear, self.noise);
            if record.is_compared(row) {
                let update = belief.update(record, row, self.noise)?;
                pass.add(&update, &by, measured)?;
                let inputs = record.inputs_at(row - 1, 0.0);
                pass.points
                    .push(linear.from.iter().copied().chain(inputs).collect());
                by -= &update.gain * by.select_rows(&update.states);
            }
            pass.steps.push(linear);
        }
        pass.sums.flush();
        Some(pass)
    }
}

impl Pass {
    /// Adds a row whose prediction has these derivatives by the coefficients.
    fn add(&mut self, update: &Update, by: &DMatrix<f64>, measured: usize) -> Option<()> {
        let z = &update.innovation;
        let x = update
            .root
            .solve_lower_triangular(&by.select_rows(&update.states))?;
        self.log_determinant += update.log_determinant;
        let mut errors = vec![f64::NAN; measured];
        for ((k, &i), z) in update.states.iter().enumerate().zip(z.iter()) {
            errors[i] = *z;
            self.innovations[i].push(*z);
            self.sums.push(x.row(k).iter().copied(), *z);
        }
        self.errors.push(errors);
        Some(())
    }
}
