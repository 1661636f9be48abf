//! The choice of the diffusion's terms.
//!
//! Fisher's scoring makes the choice a best-subset problem, as that of the drift is ([`super::squares`]). A sum of terms counts only
//! if it is positive on every row, so all subsets of few terms are tried, best first.

use nalgebra::{DMatrix, DVector};

use super::Disturbance;
use super::diffusion::{Diffusion, DiffusionCandidates, sum};
use super::filter::Pass;
use super::squares::{Parameters, Squares, linearise};
use super::variances::cost;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::Settings;
use crate::trajectory::output_error::record::Record;
use crate::trajectory::output_error::select::Search;

/// Choices of terms, at most, each with coefficients that have converged. The last that is best by its likelihood is taken.
const CHOICES: usize = 6;
/// Steps of the coefficients of one choice, at most: the next choice goes on where they end.
const STEPS: usize = 25;
/// Change of a coefficient, in standard errors, below which they have converged: as [`super::DONE`].
const DONE: f64 = 0.01;
/// Change of a coefficient, in standard errors, below which two estimates are the same: it changes weights of rows by less than
/// a percent.
const SAME: f64 = 0.1;
/// The share of a measurement's variance that a step leaves, at least: a linearisation does not reach further.
const LEAST_LEFT: f64 = 0.1;
/// Halvings of a step, at most.
const HALVINGS: usize = 8;
/// Terms of one state, at most. Of 20 candidates this makes 60 000 subsets; of more, [`FEW_TERMS`] of 32 make 41 000.
const MOST_TERMS: usize = 6;
const FEW_TERMS: usize = 4;
const MANY: usize = 20;
/// A term of whose column others leave less than this share depends on them: half of the digits are left.
const DEPENDENT: f64 = 1e-8;

/// What every step of an estimate shares.
struct Estimate<'a> {
    passes: &'a [(&'a Record, &'a Pass)],
    candidates: &'a DiffusionCandidates,
    parameters: Parameters,
    /// The penalty of a term: `ln N + 2 ln P`.
    penalty: f64,
    /// The weight of it.
    weight: f64,
}

/// The most likely diffusion around the filter's passes, with the variances of the measurement; `None` where no sum of terms is
/// positive on all rows.
pub(super) fn estimate(
    passes: &[(&Record, &Pass)],
    from: &Disturbance,
    candidates: &DiffusionCandidates,
    settings: &Settings,
) -> Option<Disturbance> {
    let parameters = Parameters::new(candidates, from);
    let mut noise = from.clone();
    if noise.diffusion.is_none() {
        noise.diffusion = Some(Diffusion::constant(candidates, &noise.process));
    }
    let values = passes
        .iter()
        .flat_map(|(_, pass)| &pass.innovations)
        .map(Vec::len)
        .sum::<usize>() as f64;
    let offered = (parameters.states * candidates.offered) as f64;
    let estimate = Estimate {
        passes,
        candidates,
        parameters,
        penalty: values.ln() + 2.0 * offered.ln(),
        weight: settings.penalty,
    };
    let mut best: Option<(f64, Disturbance)> = None;
    for _ in 0..CHOICES {
        let before = estimate.vector(&noise);
        let chosen = estimate.choose(&noise)?;
        let same = supports(&before) == supports(&estimate.vector(&chosen));
        noise = estimate.refine(chosen)?;
        let score = estimate.score(&noise);
        if best.as_ref().is_none_or(|(least, _)| score < *least) {
            best = Some((score, noise.clone()));
        }
        if same {
            break;
        }
    }
    let (_, best) = best?;
    estimate.with_errors(best)
}

/// Whether two estimates have the same terms and coefficients.
pub(super) fn is_same(a: &Disturbance, b: &Disturbance) -> bool {
    let (Some(a), Some(b)) = (&a.diffusion, &b.diffusion) else {
        return a.diffusion.is_none() && b.diffusion.is_none();
    };
    let errors = b.std_errors.iter().flatten();
    let coefficients = a.coefficients.iter().flatten();
    let pairs = coefficients.zip(b.coefficients.iter().flatten());
    pairs
        .zip(errors)
        .all(|((a, b), error)| (*a != 0.0) == (*b != 0.0) && (a - b).abs() <= SAME * error)
}

fn supports(vector: &DVector<f64>) -> Vec<bool> {
    vector.iter().map(|c| *c != 0.0).collect()
}

impl Estimate<'_> {
    /// All parameters of a disturbance.
    fn vector(&self, noise: &Disturbance) -> DVector<f64> {
        let diffusion = noise.diffusion.iter().flat_map(|d| &d.coefficients);
        let measured = &noise.measurement[..self.parameters.measured];
        let all = diffusion.flatten().chain(measured).copied();
        DVector::from_vec(all.collect())
    }

    /// The disturbance of these parameters.
    fn disturbance(&self, vector: &DVector<f64>, noise: &Disturbance) -> Disturbance {
        let of = |i: usize| vector.as_slice()[self.parameters.of(i)].to_vec();
        let coefficients: Vec<Vec<f64>> = (0..self.parameters.states).map(of).collect();
        let mut out = noise.clone();
        for (i, process) in out.process.iter_mut().enumerate() {
            let rates = self.rows().map(|terms| sum(&coefficients[i], terms));
            let (rows, total) = rates.fold((0.0, 0.0), |(n, all), q| (n + 1.0, all + q));
            *process = total / rows;
        }
        for i in 0..self.parameters.measured {
            let least = LEAST_LEFT * noise.measurement[i];
            out.measurement[i] = vector[self.parameters.measurement() + i].max(least);
        }
        out.diffusion = Some(Diffusion::new(coefficients));
        out
    }

    /// Values of the candidates where steps begin.
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        let steps = self.passes.iter().flat_map(|(_, pass)| &pass.steps);
        steps.map(|step| step.terms[0].as_slice())
    }

    /// Whether the sum is positive wherever a step begins or ends.
    fn is_positive(&self, coefficients: &[f64]) -> bool {
        let steps = self.passes.iter().flat_map(|(_, pass)| &pass.steps);
        steps
            .flat_map(|step| &step.terms)
            .all(|terms| sum(coefficients, terms) > 0.0)
    }

    fn all_positive(&self, vector: &DVector<f64>) -> bool {
        (0..self.parameters.states)
            .all(|i| self.is_positive(&vector.as_slice()[self.parameters.of(i)]))
    }

    /// Twice the negative log-likelihood and the penalties.
    fn score(&self, noise: &Disturbance) -> f64 {
        let terms = noise.diffusion.iter().flat_map(|d| &d.coefficients);
        let terms = terms.flatten().filter(|c| **c != 0.0).count() as f64;
        cost(self.passes, noise, usize::MAX) + self.weight * self.penalty * terms
    }

    fn search(&self, noise: &Disturbance) -> Option<(Search, Squares)> {
        let squares = linearise(self.passes, noise, self.parameters)?;
        let p = self.parameters.len();
        let xtx = squares.total.view((0, 0), (p, p)).into_owned();
        let xtr = squares.total.view((0, p), (p, 1)).column(0).into_owned();
        let search = Search::new(&xtx, &xtr, squares.total[(p, p)], &self.vector(noise));
        Some((search, squares))
    }

    /// Mean square of what squared innovations leave, in units of what normal ones do: at least 1.
    fn variance(search: &Search, squares: &Squares) -> f64 {
        let terms = search.support.iter().filter(|s| **s).count() as f64;
        (search.residual() / (squares.values as f64 - terms).max(1.0)).max(1.0)
    }

    /// The best terms of each state that are positive, in the linearisation around a disturbance.
    fn choose(&self, noise: &Disturbance) -> Option<Disturbance> {
        let (mut search, squares) = self.search(noise)?;
        let mut variance = Self::variance(&search, &squares);
        for i in 0..self.parameters.states {
            let constant = self.parameters.of(i).start + self.candidates.constant;
            if self.candidates.constant >= self.candidates.offered && search.support[constant] {
                search.toggle(constant);
            }
        }
        // The penalty and the residual depend on each other.
        for _ in 0..2 {
            for i in 0..self.parameters.states {
                search = self.best_of(&search, i, self.weight * self.penalty * variance)?;
            }
            variance = Self::variance(&search, &squares);
        }
        Some(self.disturbance(&search.coefficients(), noise))
    }

    /// The search with the best positive terms of state `i`, beside what the others hold.
    fn best_of(&self, search: &Search, i: usize, penalty: f64) -> Option<Search> {
        let first = self.parameters.of(i).start;
        let members: Vec<usize> = (first..first + self.candidates.offered).collect();
        let (gram, free, _) = search.beside(&members, 0);
        let mut subsets = Vec::new();
        let most = if free.len() > MANY {
            FEW_TERMS
        } else {
            MOST_TERMS
        };
        let root = swept(&gram);
        grow(&root, (0, most), &mut Vec::new(), penalty, &mut subsets);
        subsets.sort_by(|a, b| a.0.total_cmp(&b.0));
        subsets.into_iter().find_map(|(_, subset)| {
            let support: Vec<usize> = subset.iter().map(|&k| free[k]).collect();
            let trial = search.at(&members, &support);
            let coefficients = trial.coefficients();
            let own = &coefficients.as_slice()[self.parameters.of(i)];
            self.is_positive(own).then_some(trial)
        })
    }

    /// The most likely coefficients of the same terms, by Fisher's scoring. Steps are halved while they leave the positive sums or
    /// raise the cost.
    fn refine(&self, mut noise: Disturbance) -> Option<Disturbance> {
        let mut before = cost(self.passes, &noise, usize::MAX);
        for _ in 0..STEPS {
            let (search, squares) = self.search(&noise)?;
            let from = self.vector(&noise);
            let change = search.coefficients() - &from;
            let variance = Self::variance(&search, &squares);
            let moved = (0..change.len())
                .filter(|&j| search.support[j])
                .map(|j| change[j].abs() / (search.variance(j) * variance).sqrt());
            if moved.fold(0.0, f64::max) < DONE {
                break;
            }
            let step = (0..HALVINGS).find_map(|k| {
                let vector = &from + &change * 0.5_f64.powi(k as i32);
                if !self.all_positive(&vector) {
                    return None;
                }
                let tried = self.disturbance(&vector, &noise);
                let after = cost(self.passes, &tried, usize::MAX);
                (after < before).then_some((tried, after))
            });
            let Some((tried, after)) = step else { break };
            (noise, before) = (tried, after);
        }
        Some(noise)
    }

    /// Standard errors, and what each term is worth.
    fn with_errors(&self, mut noise: Disturbance) -> Option<Disturbance> {
        let (search, squares) = self.search(&noise)?;
        let variance = Self::variance(&search, &squares);
        let kept = |value: &dyn Fn(usize) -> f64| -> Vec<Vec<f64>> {
            let of = |j: usize| if search.support[j] { value(j) } else { 0.0 };
            let states = 0..self.parameters.states;
            states
                .map(|i| self.parameters.of(i).map(of).collect())
                .collect()
        };
        if let Some(diffusion) = &mut noise.diffusion {
            diffusion.std_errors = kept(&|j| (search.variance(j) * variance).sqrt());
            diffusion.evidence = kept(&|j| search.change(j) / variance - self.penalty);
            diffusion.values = squares.values;
        }
        Some(noise)
    }
}

/// `[X | y]ᵀ [X | y]`.
fn swept(gram: &Gram) -> DMatrix<f64> {
    let p = gram.xty.len();
    DMatrix::from_fn(p + 1, p + 1, |a, b| match (a < p, b < p) {
        (true, true) => gram.xtx[(a, b)],
        (true, false) => gram.xty[a],
        (false, true) => gram.xty[b],
        (false, false) => gram.yty,
    })
}

/// All subsets of at most `most` terms that add some from `next` on to `held`, with what they leave and their penalties. `t` is what
/// `held` leaves of all products.
fn grow(
    t: &DMatrix<f64>,
    (next, most): (usize, usize),
    held: &mut Vec<usize>,
    penalty: f64,
    out: &mut Vec<(f64, Vec<usize>)>,
) {
    let p = t.nrows() - 1;
    if !held.is_empty() {
        out.push((t[(p, p)] + penalty * held.len() as f64, held.clone()));
    }
    if held.len() == most {
        return;
    }
    for j in next..p {
        // Columns have unit length.
        if t[(j, j)] <= DEPENDENT {
            continue;
        }
        let column = t.column(j).into_owned();
        let left = t - &column * column.transpose() / t[(j, j)];
        held.push(j);
        grow(&left, (j + 1, most), held, penalty, out);
        held.pop();
    }
}
