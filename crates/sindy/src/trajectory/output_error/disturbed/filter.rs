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

/// Simpson's weights of the ends and of the middle of a step.
pub(super) const ENDS: f64 = 1.0 / 6.0;
pub(super) const MIDDLE: f64 = 4.0 / 6.0;

impl Linear {
    /// The derivatives of the end by the state half a step before: the root of `transition`, to second order in the step.
    pub(super) fn second_half(&self) -> DMatrix<f64> {
        let n = self.transition.nrows();
        let change = &self.transition - DMatrix::identity(n, n);
        DMatrix::identity(n, n) + &change * 0.5 - &change * &change * 0.125
    }
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

    /// Over a step, to a mean. What disturbances add along the step is summed by Simpson's rule, and moves with the state. It is exact
    /// for a position whose velocity is disturbed, `var(x) = q h³/3`, where the rule of the ends says half as much again.
    pub(super) fn predict(&mut self, mean: DVector<f64>, step: &Linear, noise: &Disturbance) {
        let (ends, middle) = (ENDS * step.period, MIDDLE * step.period);
        let [from, to] = &step.terms;
        let n = mean.len();
        let rates: Vec<[f64; 2]> = (0..n)
            .map(|i| [noise.rate(i, from), noise.rate(i, to)])
            .collect();
        self.mean = mean;
        for (i, rate) in rates.iter().enumerate() {
            self.covariance[(i, i)] += ends * rate[0];
        }
        self.covariance = &step.transition * &self.covariance * step.transition.transpose();
        let half = step.second_half();
        for (i, rate) in rates.iter().enumerate() {
            let between = middle * 0.5 * (rate[0] + rate[1]);
            self.covariance
                .ger(between, &half.column(i), &half.column(i), 1.0);
            self.covariance[(i, i)] += ends * rate[1];
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::output_error::disturbed::Sources;

    #[test]
    fn analytic_a_disturbed_velocity_moves_the_position() {
        let (h, q) = (0.3, 0.7);
        let noise = Disturbance {
            process: vec![0.0, q],
            measurement: vec![0.0; 2],
            sources: Sources::Process,
            diffusion: None,
        };
        let step = Linear {
            from: DVector::zeros(2),
            to: DVector::zeros(2),
            transition: DMatrix::from_row_slice(2, 2, &[1.0, h, 0.0, 1.0]),
            period: h,
            terms: [Vec::new(), Vec::new()],
        };
        let mut belief = Belief {
            mean: DVector::zeros(2),
            covariance: DMatrix::zeros(2, 2),
        };
        belief.predict(DVector::zeros(2), &step, &noise);
        // An integrated random walk.
        let both = 0.5 * q * h * h;
        let truth = DMatrix::from_row_slice(2, 2, &[q * h.powi(3) / 3.0, both, both, q * h]);
        // Rounding.
        assert!((belief.covariance - truth).norm() < 1e-15);
    }
}
