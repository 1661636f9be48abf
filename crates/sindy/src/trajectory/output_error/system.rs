//! The candidate terms of all equations, compiled once: values, gradients, and one step with sensitivities.

pub(super) mod implicit;
mod slope_noise;
mod transition;

use nalgebra::DMatrix;
use sindy_expr::{Expr, Program, Scratch};

pub(super) use self::transition::multiply;
use self::transition::{second_half, transition};
use super::disturbed::DiffusionCandidates;
use crate::error::{SindyError, require, same_size};
use crate::library::{Library, compile};
use crate::model::{Term, Time};

/// States, inputs, and for each state a library; all terms of all libraries are *candidates*, numbered
/// equation by equation. Terms that are known stand beside them.
#[derive(Clone, Debug)]
pub struct System {
    pub(super) n: usize,
    /// States that are measured; they come first.
    pub(super) measured: usize,
    pub(super) inputs: usize,
    pub(super) discrete: bool,
    /// Whether the integrator is implicit.
    pub(super) stiff: bool,
    /// Values of the distinct terms.
    values: Program,
    /// Their derivatives by the states that are not zero throughout, and which they are: (term, state).
    gradients: Program,
    places: Vec<(usize, usize)>,
    /// The parts of all candidates, in the order of these.
    pub(super) parts: Vec<Part>,
    /// Candidates that subsets are chosen among exactly: those of each equation, or all where they are joined.
    pub(super) groups: Vec<Vec<usize>>,
    /// For each distinct term the parts that use it.
    users: Vec<Vec<Part>>,
    /// Known terms: (equation, term, coefficient); and for each distinct term those of them that it is in.
    pub(super) fixed: Vec<(usize, usize, f64)>,
    known: Vec<Vec<(usize, f64)>>,
    /// Terms that the squared diffusion of each state may have, where disturbances may depend on the state.
    pub(super) diffusion: Option<DiffusionCandidates>,
}

/// A term of a candidate: in one equation, times a factor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) candidate: usize,
    pub(super) equation: usize,
    /// The distinct term.
    pub(super) term: usize,
    factor: f64,
}

/// A model's coefficients, and the working memory of its steps.
pub(super) struct Work {
    /// Coefficients that are not zero, and those of known terms: (equation, term, coefficient).
    active: Vec<(usize, usize, f64)>,
    /// The same, for each state that their terms depend on.
    slopes: Vec<Slope>,
    row: Vec<f64>,
    theta: [Vec<f64>; 3],
    gradient: Vec<f64>,
    scratch: Scratch,
    jacobian: [DMatrix<f64>; 3],
    stages: [Vec<f64>; 4],
    point: Vec<f64>,
    /// Scratch, each n x n.
    products: [DMatrix<f64>; 4],
}

/// What the derivative of a term by a state gives to `∂f/∂x`.
#[derive(Clone, Copy)]
struct Slope {
    /// The derivative's place among [`System::gradients`].
    gradient: usize,
    equation: usize,
    state: usize,
    coefficient: f64,
}

/// One step's end, and its derivatives by where it started and by the coefficients.
pub(super) struct Step {
    /// Where it ends, n.
    pub state: Vec<f64>,
    /// By the state it started from, n x n.
    pub transition: DMatrix<f64>,
    /// By the coefficients of all candidates, n x P.
    pub forcing: DMatrix<f64>,
}

impl System {
    /// Compiles the libraries (one for each state) over the named states and inputs.
    ///
    /// # Errors
    /// A number of libraries that is not that of the states, or a term with a name that is neither a state
    /// nor an input.
    pub fn new(
        time: Time,
        states: &[String],
        inputs: &[String],
        libraries: &[Library],
    ) -> Result<Self, SindyError> {
        let none = vec![Vec::new(); states.len()];
        Self::with_known(time, (states, states.len()), inputs, libraries, &none)
    }

    /// As [`Self::new`], with `known` terms of each equation that have their coefficients, beside the candidates, and only
    /// the first `measured` states in the data.
    ///
    /// # Errors
    /// As [`Self::new`]; known terms not of each equation, more measured states than states, or none.
    pub fn with_known(
        time: Time,
        (states, measured): (&[String], usize),
        inputs: &[String],
        libraries: &[Library],
        known: &[Vec<Term>],
    ) -> Result<Self, SindyError> {
        same_size("libraries (one per state)", states.len(), libraries.len())?;
        same_size(
            "known terms (one list per state)",
            states.len(),
            known.len(),
        )?;
        let some = (1..=states.len()).contains(&measured);
        require(some, "measured", "1 to the number of states", measured)?;
        let mut distinct: Vec<Expr> = Vec::new();
        let place = |distinct: &mut Vec<Expr>, term: &Expr| {
            let found = distinct.iter().position(|d| d == term);
            found.unwrap_or_else(|| {
                distinct.push(term.clone());
                distinct.len() - 1
            })
        };
        let mut parts = Vec::new();
        let mut groups = vec![Vec::new(); states.len()];
        for (equation, library) in libraries.iter().enumerate() {
            for term in library.terms() {
                groups[equation].push(parts.len());
                parts.push(Part {
                    candidate: parts.len(),
                    equation,
                    term: place(&mut distinct, term),
                    factor: 1.0,
                });
            }
        }
        let mut fixed = Vec::new();
        for (equation, terms) in known.iter().enumerate() {
            for term in terms {
                let at = place(&mut distinct, &term.expression);
                fixed.push((equation, at, term.coefficient));
            }
        }
        let mut known = vec![Vec::new(); distinct.len()];
        for &(equation, term, c) in &fixed {
            known[term].push((equation, c));
        }
        let columns: Vec<&str> = states.iter().chain(inputs).map(String::as_str).collect();
        let mut slopes = Vec::new();
        let mut places = Vec::new();
        for (term, expression) in distinct.iter().enumerate() {
            for (state, name) in states.iter().enumerate() {
                let slope = expression.derivative(name);
                if slope.as_constant() != Some(0.0) {
                    slopes.push(slope);
                    places.push((term, state));
                }
            }
        }
        Ok(Self {
            n: states.len(),
            measured,
            inputs: inputs.len(),
            discrete: matches!(time, Time::Discrete { .. }),
            stiff: false,
            values: compile(&distinct, &columns)?,
            gradients: compile(&slopes, &columns)?,
            places,
            users: users(&parts, distinct.len()),
            parts,
            groups,
            fixed,
            known,
            diffusion: None,
        })
    }

    /// The same with candidate terms for the squared diffusion of each state, over the named states and inputs.
    ///
    /// # Errors
    /// A term with a name that is neither a state nor an input.
    pub(crate) fn with_diffusion(
        mut self,
        columns: &[String],
        library: &Library,
    ) -> Result<Self, SindyError> {
        self.diffusion = Some(DiffusionCandidates::new(columns, library)?);
        Ok(self)
    }

    /// The same with the candidate terms of another system's diffusion.
    pub(crate) fn with_diffusion_of(self, other: &Self) -> Self {
        Self {
            diffusion: other.diffusion.clone(),
            ..self
        }
    }

    /// The same with sums of its candidates as candidates: for each, the old candidates with their factors. They may have terms in
    /// several equations, and subsets are chosen among all of them.
    pub(crate) fn joined(&self, sums: &[Vec<(usize, f64)>]) -> Self {
        let part = |candidate: usize, old: usize, factor: f64| {
            let own = self.parts.iter().filter(move |p| p.candidate == old);
            own.map(move |p| Part {
                candidate,
                factor: factor * p.factor,
                ..*p
            })
        };
        let all = sums.iter().enumerate().flat_map(|(candidate, sum)| {
            sum.iter()
                .flat_map(move |&(old, factor)| part(candidate, old, factor))
        });
        let parts: Vec<Part> = all.collect();
        Self {
            users: users(&parts, self.users.len()),
            parts,
            groups: vec![(0..sums.len()).collect()],
            ..self.clone()
        }
    }

    /// The number of candidates, P.
    pub(super) fn size(&self) -> usize {
        self.groups.iter().map(Vec::len).sum()
    }

    pub(super) fn work(&self, coefficients: &[f64]) -> Work {
        let n = self.n;
        let theta = || vec![0.0; self.values.outputs()];
        let all = self.parts.iter();
        let found = all.map(|p| (p.equation, p.term, coefficients[p.candidate] * p.factor));
        let active = found.filter(|(_, _, c)| *c != 0.0);
        Work {
            active: active.chain(self.fixed.iter().copied()).collect(),
            slopes: self.slopes(coefficients),
            row: vec![0.0; n + self.inputs],
            theta: [theta(), theta(), theta()],
            gradient: vec![0.0; self.gradients.outputs()],
            scratch: Scratch::new(),
            jacobian: std::array::from_fn(|_| DMatrix::zeros(n, n)),
            stages: std::array::from_fn(|_| vec![0.0; n]),
            point: vec![0.0; n],
            products: std::array::from_fn(|_| DMatrix::zeros(n, n)),
        }
    }

    fn slopes(&self, coefficients: &[f64]) -> Vec<Slope> {
        let mut slopes = Vec::new();
        for (gradient, &(term, state)) in self.places.iter().enumerate() {
            let chosen = self.users[term].iter();
            let chosen = chosen.map(|p| (p.equation, coefficients[p.candidate] * p.factor));
            let known = self.known[term].iter().copied();
            let all = chosen.filter(|(_, c)| *c != 0.0).chain(known);
            slopes.extend(all.map(|(equation, coefficient)| Slope {
                gradient,
                equation,
                state,
                coefficient,
            }));
        }
        slopes
    }

    pub(super) fn blank(&self) -> Step {
        Step {
            state: vec![0.0; self.n],
            transition: DMatrix::zeros(self.n, self.n),
            forcing: DMatrix::zeros(self.n, self.size()),
        }
    }

    /// The right-hand side at (x, u) into `out`, the terms' values into `theta`.
    fn rhs(
        &self,
        (x, u): (&[f64], &[f64]),
        active: &[(usize, usize, f64)],
        row: &mut [f64],
        theta: &mut [f64],
        scratch: &mut Scratch,
        out: &mut [f64],
    ) {
        row[..self.n].copy_from_slice(x);
        row[self.n..].copy_from_slice(u);
        self.values.eval_row(row, theta, scratch);
        out.fill(0.0);
        for &(equation, term, c) in active {
            out[equation] += c * theta[term];
        }
    }

    /// `∂f/∂x` at the row that was evaluated last, into `out`.
    fn jacobian(
        &self,
        row: &[f64],
        slopes: &[Slope],
        gradient: &mut [f64],
        scratch: &mut Scratch,
        out: &mut DMatrix<f64>,
    ) {
        self.gradients.eval_row(row, gradient, scratch);
        out.fill(0.0);
        for slope in slopes {
            out[(slope.equation, slope.state)] += slope.coefficient * gradient[slope.gradient];
        }
    }

    /// One step from `x` over `h`, with the inputs at its start, middle and end. Where `sensitive`, the
    /// derivatives as well: the transition by Runge–Kutta of order 4 along the trajectory, the forcing
    /// by Simpson's rule.
    pub(super) fn step(
        &self,
        x: &[f64],
        (h, inputs): (f64, [&[f64]; 3]),
        sensitive: bool,
        work: &mut Work,
        out: &mut Step,
    ) {
        let Work {
            active,
            slopes,
            row,
            theta: [t0, tm, t1],
            gradient,
            scratch,
            jacobian: [j0, jm, j1],
            stages: [k1, k2, k3, k4],
            point,
            products: [shifted, a2, a3, a4],
        } = work;
        self.rhs((x, inputs[0]), active, row, t0, scratch, k1);
        if sensitive {
            self.jacobian(row, slopes, gradient, scratch, j0);
        }
        if self.discrete {
            out.state.copy_from_slice(k1);
            if sensitive {
                out.transition.copy_from(j0);
                out.forcing.fill(0.0);
                for p in &self.parts {
                    out.forcing[(p.equation, p.candidate)] += p.factor * t0[p.term];
                }
            }
            return;
        }
        let along = |point: &mut [f64], k: &[f64], h: f64| {
            for ((p, x), k) in point.iter_mut().zip(x).zip(k) {
                *p = x + h * k;
            }
        };
        along(point, k1, 0.5 * h);
        self.rhs((point, inputs[1]), active, row, tm, scratch, k2);
        along(point, k2, 0.5 * h);
        self.rhs((point, inputs[1]), active, row, tm, scratch, k3);
        along(point, k3, h);
        self.rhs((point, inputs[2]), active, row, t1, scratch, k4);
        for i in 0..self.n {
            out.state[i] = x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
        if !sensitive {
            return;
        }
        // Values and slopes at the end, and at the middle of the cubic through both ends.
        self.rhs((&out.state, inputs[2]), active, row, t1, scratch, k4);
        self.jacobian(row, slopes, gradient, scratch, j1);
        for i in 0..self.n {
            point[i] = 0.5 * (x[i] + out.state[i]) + h / 8.0 * (k1[i] - k4[i]);
        }
        self.rhs((point, inputs[1]), active, row, tm, scratch, k2);
        self.jacobian(row, slopes, gradient, scratch, jm);

        transition(h, [j0, jm, j1], [shifted, a2, a3, a4], &mut out.transition);
        let (mean, late) = (a2, a3);
        second_half(h, [jm, j1], mean, late);
        self.force(h, late, [t0, tm, t1], out);
    }

    /// The derivatives by the coefficients, from the terms at the start, the middle and the end of a step, by Simpson's rule; `late` is
    /// the transition from the middle to the end.
    fn force(&self, h: f64, late: &DMatrix<f64>, [t0, tm, t1]: [&[f64]; 3], out: &mut Step) {
        out.forcing.fill(0.0);
        let n = self.n;
        let (early, late) = (out.transition.as_slice(), late.as_slice());
        let forcing = out.forcing.as_mut_slice();
        for p in &self.parts {
            let weight = h / 6.0 * p.factor;
            let (start, middle) = (weight * t0[p.term], 4.0 * weight * tm[p.term]);
            let column = &mut forcing[p.candidate * n..][..n];
            let (early, late) = (&early[p.equation * n..], &late[p.equation * n..]);
            for ((to, early), late) in column.iter_mut().zip(early).zip(late) {
                *to += early * start + late * middle;
            }
            column[p.equation] += weight * t1[p.term];
        }
    }
}

/// For each distinct term the parts that use it.
fn users(parts: &[Part], distinct: usize) -> Vec<Vec<Part>> {
    let mut users = vec![Vec::new(); distinct];
    for part in parts {
        users[part.term].push(*part);
    }
    users
}
