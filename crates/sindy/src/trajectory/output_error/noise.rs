//! Whether residuals are noise of the measurement: a test by shifts in time.
//!
//! Noise of a measurement, of any colour, is independent of the trajectory. What disturbs the system, and what a model
//! lacks, acts through the equations: the residual `r` then follows the flow, `r' ≈ J(t) r + m(x(t))`. Over short
//! arcs, new starts and other coefficients of the kept terms absorb much of such a residual, and no more of noise than
//! of the same noise at other times. So with `Q` an orthonormal basis of what starts and coefficients do to an arc,
//!
//! ```text
//! T(s) = Σ_arcs ‖Qᵀ r(· - s)‖²,      p = share of the shifts s, with s = 0 among them, that have T(s) ≥ T(0)
//! ```
//!
//! where each state's residual is shifted around its record by a time of its own. A shift keeps the spectrum of the
//! residual and its distribution. So p is uniform where residuals are stationary noise, independent between states, and
//! larger than uniform where a fit has taken from them what follows the flow: the level of the test is at most the
//! nominal one. Shifts are those of a lattice (the fractional parts of multiples of roots of primes), not random.
//!
//! Source: K. D. Harris, "A shift test for independence in generic time series" (2020).

use nalgebra::{DMatrix, DVector};

use super::arcs::growth;
use super::colour::{self, Whitener, whitened};
use super::follow::{ArcSettings, Follow, Sensitivity};
use super::record::Record;
use super::{OutputErrorFit, Piece, Settings, System};
use crate::numerics::prime;

/// Shifts beside that of 0. The level of a test is kept exactly with any number; p of 0.05 scatters by 0.02.
const SHIFTS: usize = 99;
/// An eigenvalue of the scaled normal equations below this share of the largest is a direction that others give as well:
/// normal equations square the condition, and seven of sixteen digits are left.
const DEPENDENT: f64 = 1e-9;

/// Where the trajectories of a fit run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trace {
    pub(super) nodes: Vec<Vec<Vec<f64>>>,
    pub(super) substeps: usize,
}

/// What the start and the kept coefficients do to the values of an arc: by row, then state, in units of the residual.
struct Arc {
    /// The place of its first value among those of all records.
    first: usize,
    /// Orthonormal columns.
    basis: DMatrix<f64>,
}

/// How much the residuals of a fit remember from row to row, for each measured state.
pub(crate) fn colour_of(system: &System, pieces: &[Piece<'_>], fit: &OutputErrorFit) -> Vec<f64> {
    let records = at(pieces, fit);
    colour::colour(&followed(system, fit, usize::MAX).residuals(&records))
}

/// Whether what is new in the residuals of a fit from row to row is white.
pub(crate) fn is_white(system: &System, pieces: &[Piece<'_>], fit: &OutputErrorFit) -> bool {
    let residuals = followed(system, fit, usize::MAX).residuals(&at(pieces, fit));
    colour::is_white(&whitened(&residuals, &fit.colour))
}

/// Records with their trajectories where a fit has them.
pub(super) fn at(pieces: &[Piece<'_>], fit: &OutputErrorFit) -> Vec<Record> {
    let mut records: Vec<Record> = pieces.iter().map(Record::new).collect();
    for (record, nodes) in records.iter_mut().zip(&fit.trace.nodes) {
        record.nodes.clone_from(nodes);
    }
    records
}

/// The model of a fit, followed in arcs of at most `longest` nodes.
pub(super) fn followed<'a>(
    system: &'a System,
    fit: &'a OutputErrorFit,
    longest: usize,
) -> Follow<'a> {
    Follow {
        system,
        coefficients: &fit.coefficients,
        sigma: &fit.sigma,
        colour: &fit.colour,
        cut: ArcSettings {
            growth: Settings::default().growth,
            longest,
            substeps: fit.trace.substeps,
        },
    }
}

/// The probability that residuals which are noise of the measurement would follow the model's flow as much as these do over
/// arcs of one of these numbers of nodes; `None` where no record holds two such arcs.
///
/// Of several lengths each T is taken in standard deviations over all shifts, and the largest counts.
pub(crate) fn independence(
    system: &System,
    pieces: &[Piece<'_>],
    fit: &OutputErrorFit,
    lengths: &[usize],
) -> Option<f64> {
    let records = at(pieces, fit);
    let nodes = records.iter().map(|r| r.rows.len()).max()?;
    let follow = |longest: usize| followed(system, fit, longest);
    let arcs: Vec<Vec<Arc>> = lengths
        .iter()
        .filter(|l| nodes >= 2 * **l)
        .map(|l| arcs(&follow(*l), &records))
        .collect::<Option<_>>()?;
    let residuals = whitened(&follow(usize::MAX).residuals(&records), &fit.colour);
    let absorbed: Vec<Vec<f64>> = (0..=SHIFTS)
        .map(|shift| {
            let r = shifted(&records, &residuals, &fit.sigma, shift);
            let of = |arcs: &Vec<Arc>| arcs.iter().map(|a| a.absorbs(&r)).sum::<f64>();
            arcs.iter().map(of).collect()
        })
        .collect();
    let mut largest = vec![f64::NEG_INFINITY; absorbed.len()];
    for k in 0..arcs.len() {
        let n = absorbed.len() as f64;
        let mean = absorbed.iter().map(|s| s[k]).sum::<f64>() / n;
        let variance = absorbed.iter().map(|s| (s[k] - mean).powi(2)).sum::<f64>() / n;
        for (largest, t) in largest.iter_mut().zip(&absorbed) {
            *largest = largest.max((t[k] - mean) / variance.sqrt());
        }
    }
    let at_least = largest.iter().filter(|t| **t >= largest[0]).count();
    largest[0]
        .is_finite()
        .then(|| at_least as f64 / largest.len() as f64)
}

/// All residuals, record by record, by row, then state, in units of their root mean square, but for each record's last row;
/// each state's are shifted by a number of samples of its own.
fn shifted(
    records: &[Record],
    residuals: &[Vec<Vec<f64>>],
    sigma: &[f64],
    shift: usize,
) -> DVector<f64> {
    let mut out = Vec::new();
    for (record, residuals) in records.iter().zip(residuals) {
        let by = |(i, r): (usize, &Vec<f64>)| {
            ((shift as f64 * lattice(i)).fract() * r.len() as f64) as usize
        };
        let by: Vec<usize> = residuals.iter().enumerate().map(by).collect();
        for row in 0..record.time.len() - 1 {
            for (i, r) in residuals.iter().enumerate() {
                if let Some(sample) = record.sample(i, row) {
                    out.push(r[(sample + by[i]) % r.len()] / sigma[i]);
                }
            }
        }
    }
    DVector::from_vec(out)
}

/// The step of the lattice for state `i`: the root of the `i`-th prime, so that multiples are spread evenly over several
/// states.
fn lattice(i: usize) -> f64 {
    (prime(i) as f64).sqrt()
}

/// The arcs of all records, cut as the search cuts them; `None` where the simulation leaves the finite numbers.
fn arcs(follow: &Follow<'_>, records: &[Record]) -> Option<Vec<Arc>> {
    let system = follow.system;
    let (n, p) = (system.n, system.size());
    let kept: Vec<usize> = (0..p).filter(|&j| follow.coefficients[j] != 0.0).collect();
    let (mut work, mut step) = (system.work(follow.coefficients), system.blank());
    let mut out = Vec::new();
    let mut place = 0;
    for record in records {
        let scales = follow.scales(record);
        let mut node = 0;
        while node < record.rows.len() {
            let (begin, mut at) = (node, Sensitivity::start(n, p));
            let mut rows = Vec::new();
            loop {
                let (from, to) = record.between(node);
                let mut x = record.nodes[node].clone();
                for row in from..to {
                    rows.push((row, at.m.clone()));
                    let scratch = (&mut work, &mut step);
                    follow.advance(
                        record,
                        row,
                        follow.cut.substeps,
                        &mut x,
                        scratch,
                        Some(&mut at),
                    );
                }
                node += 1;
                if record.is_last(node - 1)
                    || node - begin >= follow.cut.longest
                    || growth(&at.m, &scales) > follow.cut.growth
                {
                    break;
                }
            }
            if rows.iter().any(|(_, m)| m.iter().any(|v| !v.is_finite())) {
                return None;
            }
            let mut values: Vec<Vec<f64>> = Vec::new();
            let mut whitener = Whitener::new(follow.colour);
            for (row, m) in &rows {
                for i in 0..system.measured {
                    let Some(sample) = record.sample(i, *row) else {
                        continue;
                    };
                    let columns = (0..n).chain(kept.iter().map(|j| n + j));
                    let mut own: Vec<f64> = columns.map(|j| m[(i, j)] / follow.sigma[i]).collect();
                    whitener.apply(i, sample, &mut own);
                    values.push(own);
                }
            }
            let all = DMatrix::from_fn(values.len(), n + kept.len(), |k, j| values[k][j]);
            out.push(Arc {
                first: place,
                basis: orthonormal(all),
            });
            place += values.len();
        }
    }
    Some(out)
}

/// An orthonormal basis of the columns.
fn orthonormal(mut a: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in a.column_iter_mut() {
        let length = column.norm();
        if length > 0.0 {
            column /= length;
        }
    }
    let eigen = (a.transpose() * &a).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let kept: Vec<usize> = (0..a.ncols())
        .filter(|&k| eigen.eigenvalues[k] > DEPENDENT * largest)
        .collect();
    let mut v = eigen.eigenvectors.select_columns(&kept);
    for (mut column, &k) in v.column_iter_mut().zip(&kept) {
        column /= eigen.eigenvalues[k].sqrt();
    }
    a * v
}

impl Arc {
    /// What it absorbs of the sum of squares of `r`.
    fn absorbs(&self, r: &DVector<f64>) -> f64 {
        let own = r.rows(self.first, self.basis.nrows());
        self.basis.tr_mul(&own).norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::library::Library;
    use crate::model::Time;
    use crate::solve::outcome::Outcome;

    const ROWS: usize = 600;
    const STEP: f64 = 0.05;

    /// A pendulum, `q' = v`, `v' = -4 sin(q) - 0.1 v`, whose states are driven by noise of `drive` in a unit of time, by
    /// Euler's method in 20 steps from row to row; and the path without the noise.
    fn pendulum(drive: f64, rng: &mut rand_pcg::Pcg64) -> [Vec<Vec<f64>>; 2] {
        [drive, 0.0].map(|drive| {
            let (mut q, mut v) = (1.5_f64, 0.0);
            let mut columns = vec![Vec::new(), Vec::new()];
            let h = STEP / 20.0;
            for _ in 0..ROWS {
                columns[0].push(q);
                columns[1].push(v);
                for _ in 0..20 {
                    let kick: [f64; 2] = std::array::from_fn(|_| {
                        let z: f64 = StandardNormal.sample(rng);
                        drive * h.sqrt() * z
                    });
                    let middle = (q + 0.5 * h * v, v - 0.5 * h * (4.0 * q.sin() + 0.1 * v));
                    let slope = -4.0 * middle.0.sin() - 0.1 * middle.1;
                    (q, v) = (q + h * middle.1 + kick[0], v + h * slope + kick[1]);
                }
            }
            columns
        })
    }

    /// p of these rows at the true coefficients and the path without noise.
    fn p(rows: &[Vec<f64>], path: &[Vec<f64>]) -> f64 {
        let library = Library::parse(&["q", "v", "sin(q)"]).unwrap();
        let names = ["q".to_string(), "v".to_string()];
        let libraries = [library.clone(), library];
        let system = System::new(Time::Continuous, &names, &[], &libraries).unwrap();
        let time: Vec<f64> = (0..ROWS).map(|k| STEP * k as f64).collect();
        let piece = Piece {
            time: &time,
            states: rows.iter().map(Vec::as_slice).collect(),
            inputs: Vec::new(),
            between: Vec::new(),
            weights: None,
            seen: Vec::new(),
            smooth: path.to_vec(),
        };
        let record = Record::new(&piece);
        let fit = OutputErrorFit {
            coefficients: vec![0.0, 1.0, 0.0, 0.0, -0.1, -4.0],
            std_errors: vec![0.0; 6],
            covariance: nalgebra::DMatrix::zeros(1, 1),
            evidence: vec![0.0; 6],
            penalty: 0.0,
            sigma: vec![1.0, 2.0],
            colour: Vec::new(),
            disturbance: None,
            fronts: Vec::new(),
            exchanges: Vec::new(),
            multiples: Vec::new(),
            correlation: 1.0,
            score: 0.0,
            arcs: 1,
            values: 2 * ROWS,
            iterations: 1,
            outcome: Outcome::Converged,
            trace: Trace {
                nodes: vec![record.nodes],
                substeps: 4,
            },
        };
        independence(&system, &[piece], &fit, &[32, 8]).unwrap()
    }

    #[test]
    fn analytic_noise_of_any_colour_is_independent_and_a_disturbance_is_not() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(20);
        let [_, path] = pendulum(0.0, &mut rng);
        let mut refused = [0; 3];
        for (of, refused) in [0.0, 0.9, 1.0].into_iter().zip(&mut refused) {
            for _ in 0..60 {
                let mut rows = path.clone();
                for column in &mut rows {
                    let mut e = 0.0;
                    for v in column {
                        let z: f64 = StandardNormal.sample(&mut rng);
                        e = of * e + z;
                        *v += 0.01 * e;
                    }
                }
                *refused += usize::from(p(&rows, &path) <= 0.05);
            }
        }
        // Of 60 draws 3 are refused at a level of 0.05, with a standard deviation of 1.7: three of them.
        assert!(refused.iter().all(|r| *r <= 8), "{refused:?}");
        let found = (0..30).filter(|_| {
            let [driven, path] = pendulum(0.02, &mut rng);
            p(&driven, &path) <= 0.05
        });
        let found = found.count();
        // 24 of 30 show a power above 0.6 with 97.5 % confidence (Clopper & Pearson 1934).
        assert!(found >= 24, "{found}");
    }
}
