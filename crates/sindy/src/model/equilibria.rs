//! Equilibria within a box, and what happens near them.

use nalgebra::{Complex, DMatrix, DVector, SVD, Schur};

use super::jacobian::Jacobian;
use super::{Model, Time};
use crate::error::{SindyError, finite, require, same_size};
use crate::numerics::upper_median;

/// A Newton step below this part of the box's width ends an iteration.
const STEP: f64 = 1e-10;
/// Equilibria nearer to each other than this part of the box's width are one.
const SAME: f64 = 1e-6;
/// Iterations of Newton's method: enough for the linear convergence at a multiple root.
const ITERATIONS: usize = 100;
/// Real parts (in discrete time: distances from the unit circle) below this part of the largest
/// eigenvalue count as zero.
const ZERO: f64 = 1e-9;
/// Imaginary parts below this part of the largest eigenvalue count as zero: rounding moves a double
/// eigenvalue by the square root of the machine precision.
const REAL: f64 = 1e-7;

/// A search for the equilibria of a model within a box: states where `f(x, u) = 0` in continuous time, or
/// `f(x, u) = x` in discrete time, for an input u that does not change.
///
/// Newton's method with the exact Jacobian and step halving starts from the origin (if it is inside) and
/// from points spread evenly over the box, the additive sequence with the generalised golden ratio
/// (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018). Nothing is random. Where the Jacobian is
/// singular, the step is that of least norm. The result is an equilibrium to rounding; that *all* were
/// found cannot be known, and more starts make it likelier.
///
/// ```
/// use sindy::model::{Search, Stability};
///
/// let lorenz = sindy::problems::lorenz().model()?;
/// let found = Search::new(&[(-30.0, 30.0), (-30.0, 30.0), (0.0, 60.0)]).run(&lorenz)?;
/// assert_eq!(found.equilibria.len(), 3);
/// assert!(found.equilibria.iter().all(|e| e.stability == Stability::Saddle));
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    ranges: Vec<(f64, f64)>,
    input: Vec<f64>,
    starts: usize,
}

/// The result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibria {
    /// The distinct equilibria in the box, ordered by their states.
    pub equilibria: Vec<Equilibrium>,
    /// Points that Newton's method started from.
    pub starts: usize,
    /// Starts that led to an equilibrium inside the box.
    pub inside: usize,
    /// Starts that led to an equilibrium outside it.
    pub outside: usize,
}

/// A state in which the model rests.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// The state.
    pub state: Vec<f64>,
    /// Eigenvalues of the Jacobian there, largest real part first; empty if they could not be computed.
    pub eigenvalues: Vec<Complex<f64>>,
    /// The stability that they imply.
    pub stability: Stability,
}

/// How solutions near an equilibrium behave, by its linearisation.
///
/// "Decaying" is a negative real part in continuous time, a magnitude below 1 in discrete time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stability {
    /// All eigenvalues decaying and real.
    StableNode,
    /// All decaying, some complex.
    StableFocus,
    /// All growing and real.
    UnstableNode,
    /// All growing, some complex.
    UnstableFocus,
    /// Some decaying, some growing.
    Saddle,
    /// All neither decaying nor growing, and complex. The nonlinear model may differ.
    Centre,
    /// Some eigenvalue neither decays nor grows: the linearisation does not decide. Equilibria that form
    /// a curve are all of this kind.
    NonHyperbolic,
    /// The eigenvalues could not be computed (the Jacobian is not finite).
    Undetermined,
}

impl Search {
    /// A search within a box, `(low, high)` for each state, from 200 points and with zero input.
    #[must_use]
    pub fn new(ranges: &[(f64, f64)]) -> Self {
        Self {
            ranges: ranges.to_vec(),
            input: Vec::new(),
            starts: 200,
        }
    }

    /// The input at which the model rests, one value for each; zero if this is not called.
    #[must_use]
    pub fn input(mut self, input: &[f64]) -> Self {
        self.input = input.to_vec();
        self
    }

    /// The number of points to start from, at least 1.
    #[must_use]
    pub fn starts(mut self, starts: usize) -> Self {
        self.starts = starts;
        self
    }

    /// Searches.
    ///
    /// # Errors
    /// A box or an input that does not fit the model, is empty or not finite; no starts. That there are no
    /// equilibria is not an error.
    pub fn run(&self, model: &Model) -> Result<Equilibria, SindyError> {
        let n = model.states.len();
        same_size("ranges (one per state)", n, self.ranges.len())?;
        for (&(low, high), name) in self.ranges.iter().zip(&model.states) {
            if !(low < high && (high - low).is_finite()) {
                let found = format!("{low} to {high} for `{name}`");
                return Err(SindyError::setting(
                    "ranges",
                    "a finite, non-empty range",
                    found,
                ));
            }
        }
        require(self.starts != 0, "starts", "at least 1", 0)?;
        let input = if self.input.is_empty() {
            vec![0.0; model.inputs.len()]
        } else {
            self.input.clone()
        };
        same_size("input values", model.inputs.len(), input.len())?;
        finite("input", &input)?;

        let starts = self.points(n);
        let mut problem = Problem::new(model, input, &self.ranges)?;
        problem.measure(&starts);
        let mut found = Equilibria {
            equilibria: Vec::new(),
            starts: starts.len(),
            inside: 0,
            outside: 0,
        };
        let mut points: Vec<DVector<f64>> = Vec::new();
        for start in starts {
            let Some(y) = problem.newton(start) else {
                continue;
            };
            if !y.iter().all(|v| (-SAME..=1.0 + SAME).contains(v)) {
                found.outside += 1;
                continue;
            }
            found.inside += 1;
            if !points.iter().any(|p| (p - &y).amax() <= SAME) {
                points.push(y);
            }
        }
        for y in points {
            let state = problem.state(&y);
            let (eigenvalues, stability) = problem.linearised(&state)?;
            found.equilibria.push(Equilibrium {
                state,
                eigenvalues,
                stability,
            });
        }
        found.equilibria.sort_by(|a, b| {
            let pairs = a.state.iter().zip(&b.state);
            pairs
                .map(|(a, b)| a.total_cmp(b))
                .find(|o| o.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        Ok(found)
    }

    /// Starts in the unit box.
    fn points(&self, n: usize) -> Vec<DVector<f64>> {
        // The root of g^(n+1) = g + 1, by a contraction.
        let mut g = 2.0_f64;
        for _ in 0..64 {
            g = (1.0 + g).powf(1.0 / (n as f64 + 1.0));
        }
        let spread = (0..self.starts).map(|k| {
            DVector::from_fn(n, |j, _| (0.5 + k as f64 * g.powi(-(j as i32 + 1))).fract())
        });
        let origin = DVector::from_fn(n, |j, _| {
            let (low, high) = self.ranges[j];
            -low / (high - low)
        });
        let inside = origin.iter().all(|v| (0.0..=1.0).contains(v));
        inside.then_some(origin).into_iter().chain(spread).collect()
    }
}

/// The equations to be solved, in coordinates of the unit box.
struct Problem<'m> {
    model: &'m Model,
    jacobian: Jacobian,
    input: Vec<f64>,
    low: DVector<f64>,
    width: DVector<f64>,
    /// Sizes of the equations within the box.
    scale: DVector<f64>,
}

impl<'m> Problem<'m> {
    fn new(model: &'m Model, input: Vec<f64>, ranges: &[(f64, f64)]) -> Result<Self, SindyError> {
        let n = ranges.len();
        Ok(Self {
            model,
            jacobian: model.jacobian()?,
            input,
            low: DVector::from_fn(n, |j, _| ranges[j].0),
            width: DVector::from_fn(n, |j, _| ranges[j].1 - ranges[j].0),
            scale: DVector::repeat(n, 1.0),
        })
    }

    fn state(&self, y: &DVector<f64>) -> Vec<f64> {
        (&self.low + y.component_mul(&self.width))
            .iter()
            .copied()
            .collect()
    }

    /// The equations at `y` in units of their scale, and whether all are zero to rounding.
    fn residual(&self, y: &DVector<f64>) -> (DVector<f64>, bool) {
        let state = self.state(y);
        let n = state.len();
        let row = [state.as_slice(), &self.input].concat();
        let mut work = self.model.compiled.workspace();
        let (mut value, mut size) = (vec![0.0; n], vec![0.0; n]);
        self.model.compiled.row(&row, &mut value, &mut work);
        self.model.compiled.magnitudes(&row, &mut size, &mut work);
        if let Time::Discrete { .. } = self.model.time {
            for j in 0..n {
                value[j] -= state[j];
                size[j] += state[j].abs();
            }
        }
        // Infinity is not small beside infinity.
        let zero =
            (0..n).all(|j| value[j].is_finite() && value[j].abs() <= 4.0 * f64::EPSILON * size[j]);
        (DVector::from_vec(value).component_div(&self.scale), zero)
    }

    /// Sets each equation's scale to the median of its magnitude over the points where it is finite and
    /// not zero.
    fn measure(&mut self, points: &[DVector<f64>]) {
        let values: Vec<DVector<f64>> = points.iter().map(|y| self.residual(y).0).collect();
        for j in 0..self.scale.len() {
            let mut sizes: Vec<f64> = values
                .iter()
                .map(|v| v[j].abs())
                .filter(|v| v.is_finite() && *v > 0.0)
                .collect();
            self.scale[j] = upper_median(&mut sizes).unwrap_or(1.0);
        }
    }

    /// The Jacobian of the equations at a state, that of `f(x) - x` in discrete time.
    fn matrix(&self, state: &[f64]) -> Result<DMatrix<f64>, SindyError> {
        let (mut a, _) = self.jacobian.at(state, &self.input)?;
        if let Time::Discrete { .. } = self.model.time {
            for j in 0..state.len() {
                a[(j, j)] -= 1.0;
            }
        }
        Ok(a)
    }

    /// Newton's method from `y`; `None` if it does not converge.
    fn newton(&self, mut y: DVector<f64>) -> Option<DVector<f64>> {
        let (mut f, mut zero) = self.residual(&y);
        for _ in 0..ITERATIONS {
            if zero {
                return Some(y);
            }
            let step = self.step(&y, &f)?;
            let size = step.amax();
            if size <= STEP {
                // A short step is no proof of a zero: the equations must be small as well.
                return (f.amax() <= 1e-6).then(|| y + step);
            }
            let mut part = 1.0 / size.max(1.0);
            loop {
                let next = &y + part * &step;
                let (value, is_zero) = self.residual(&next);
                // Fails for NaN too.
                if is_zero || value.norm() <= (1.0 - 1e-4 * part) * f.norm() {
                    (y, f, zero) = (next, value, is_zero);
                    break;
                }
                part *= 0.5;
                if part < 1e-9 {
                    return None;
                }
            }
        }
        None
    }

    fn step(&self, y: &DVector<f64>, f: &DVector<f64>) -> Option<DVector<f64>> {
        let mut a = self.matrix(&self.state(y)).ok()?;
        for ((i, j), value) in indices(a.nrows()).zip(a.iter_mut()) {
            *value *= self.width[j] / self.scale[i];
        }
        if !a.iter().chain(f.iter()).all(|v| v.is_finite()) {
            return None;
        }
        let svd = SVD::try_new(a, true, true, f64::EPSILON, 10_000)?;
        let cut = 1e-13 * svd.singular_values.amax();
        // Without any slope there is no direction to go.
        (cut > 0.0).then(|| svd.solve(&-f, cut).ok())?
    }

    /// Eigenvalues of `∂f/∂x` and the stability that they imply.
    fn linearised(&self, state: &[f64]) -> Result<(Vec<Complex<f64>>, Stability), SindyError> {
        let (a, _) = self.jacobian.at(state, &self.input)?;
        if !a.iter().all(|v| v.is_finite()) {
            return Ok((Vec::new(), Stability::Undetermined));
        }
        let Some(schur) = Schur::try_new(a, f64::EPSILON, 10_000) else {
            return Ok((Vec::new(), Stability::Undetermined));
        };
        let mut values: Vec<Complex<f64>> = schur.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        let stability = classify(&values, self.model.time);
        Ok((values, stability))
    }
}

/// Row and column of the entries of an n × n matrix in storage order.
fn indices(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |j| (0..n).map(move |i| (i, j)))
}

fn classify(values: &[Complex<f64>], time: Time) -> Stability {
    let largest = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let (growth, zero): (Vec<f64>, f64) = match time {
        Time::Continuous => (values.iter().map(|v| v.re).collect(), ZERO * largest),
        Time::Discrete { .. } => (values.iter().map(|v| v.norm() - 1.0).collect(), ZERO),
    };
    let complex = |v: &Complex<f64>| v.im.abs() > REAL * largest;
    let neutral = growth.iter().filter(|g| g.abs() <= zero).count();
    let decaying = growth.iter().filter(|g| **g < -zero).count();
    let turning = values.iter().any(complex);
    match (neutral, decaying) {
        (n, _) if n == values.len() && values.iter().all(complex) => Stability::Centre,
        (1.., _) => Stability::NonHyperbolic,
        (_, 0) if turning => Stability::UnstableFocus,
        (_, 0) => Stability::UnstableNode,
        (_, d) if d < values.len() => Stability::Saddle,
        _ if turning => Stability::StableFocus,
        _ => Stability::StableNode,
    }
}
