//! One Markov chain over the scales of the prior and the noise.
//!
//! A step draws, in logarithms and with the coefficients integrated out ([`conditional`](super::conditional)),
//!
//! 1. each λ_j, from a slice over the whole range: its density may have two modes, one of a term that is there, one of a term
//!    that is not;
//! 2. τ with all λ_j as they are, then τ with all products `τ λ_j` as they are. The second leaves the coefficients' distribution
//!    alone and costs next to nothing. Together they end the correlation of τ with the λ_j (Y. Yu, X.-L. Meng, "To center or not
//!    to center", Journal of Computational and Graphical Statistics 20, 2011);
//! 3. c² and σ.

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_distr::{Distribution, Exp1, Gamma, StandardNormal};
use rand_pcg::Pcg64;

use super::conditional::{Factor, Statistics};
use super::prior::Prior;
use super::slice::{between, stepping_out};

/// The half-Cauchy distribution has less than a rounding error of its mass outside of [ε, 1/ε]: the range of ln λ.
const LOG_RANGE: f64 = 52.0 * std::f64::consts::LN_2;

/// Width by which slices of ln τ, ln c² and ln σ are stepped out: these are known to a factor of e or so, seldom better than by
/// some digits. A width that is too large costs one more evaluation for each halving.
const WIDTH: f64 = 1.0;

/// The draws of one chain.
pub(super) struct Chain {
    /// ln τ, ln c², ln σ of each draw.
    pub(super) logs: [Vec<f64>; 3],
    pub(super) targets: Vec<TargetChain>,
}

/// The draws of one target's coefficients, p x draws, in the units of the prior.
pub(super) struct TargetChain {
    pub(super) beta: DMatrix<f64>,
    pub(super) lambda: DMatrix<f64>,
    /// Given each draw's scales: mean and variance of the coefficients, and κ.
    pub(super) mean: DMatrix<f64>,
    pub(super) variance: DMatrix<f64>,
    pub(super) shrinkage: DMatrix<f64>,
}

/// Where a chain is.
#[derive(Clone)]
struct Scales {
    log_lambda: Vec<Vec<f64>>,
    log_tau: f64,
    log_slab: f64,
    log_sigma: f64,
}

/// `d = c² τ²λ²/(c² + τ²λ²)`, of logarithms.
fn prior_variance(log_lambda: f64, log_tau: f64, log_slab: f64) -> f64 {
    1.0 / ((-2.0 * (log_lambda + log_tau)).exp() + (-log_slab).exp())
}

/// The logarithm of the density of ln x, for x half-Cauchy with this logarithm of the scale.
fn log_half_cauchy(log_x: f64, log_scale: f64) -> f64 {
    let ratio = log_x - log_scale;
    ratio - (2.0 * ratio).exp().ln_1p()
}

/// The logarithm of the density of ln λ, cut off where λ has no mass.
fn log_local(log_lambda: f64) -> f64 {
    if log_lambda.abs() > LOG_RANGE {
        return f64::NEG_INFINITY;
    }
    log_half_cauchy(log_lambda, 0.0)
}

/// Where chains move: statistics of all targets, and the prior that they share.
pub(super) struct Target<'a> {
    pub(super) statistics: &'a [Statistics],
    pub(super) prior: &'a Prior,
}

impl Target<'_> {
    /// A chain of `draws` draws after `warm_up` steps that are not kept.
    pub(super) fn run(&self, warm_up: usize, draws: usize, rng: &mut Pcg64) -> Chain {
        let mut at = self.start(rng);
        (0..warm_up).for_each(|_| self.step(&mut at, rng));
        let empty = |s: &Statistics| DMatrix::zeros(s.terms(), draws);
        let mut out = Chain {
            logs: [(); 3].map(|()| Vec::with_capacity(draws)),
            targets: self
                .statistics
                .iter()
                .map(|s| TargetChain {
                    beta: empty(s),
                    lambda: empty(s),
                    mean: empty(s),
                    variance: empty(s),
                    shrinkage: empty(s),
                })
                .collect(),
        };
        for r in 0..draws {
            self.step(&mut at, rng);
            for (log, value) in out
                .logs
                .iter_mut()
                .zip([at.log_tau, at.log_slab, at.log_sigma])
            {
                log.push(value);
            }
            for (i, target) in out.targets.iter_mut().enumerate() {
                let factor = self.factor(i, &at);
                let p = self.statistics[i].terms();
                let standard = DVector::from_fn(p, |_, _| StandardNormal.sample(rng));
                let (variance, shrinkage) = factor.spreads();
                target.beta.set_column(r, &factor.draw(standard));
                target.mean.set_column(r, &factor.mean);
                target.variance.set_column(r, &variance);
                target.shrinkage.set_column(r, &shrinkage);
                let lambda = at.log_lambda[i].iter().map(|l| l.exp());
                target
                    .lambda
                    .set_column(r, &DVector::from_iterator(p, lambda));
            }
        }
        out
    }

    /// A draw of the prior, and a noise up to the targets' root mean square: chains start further apart than they end.
    fn start(&self, rng: &mut Pcg64) -> Scales {
        let half_cauchy = |rng: &mut Pcg64| {
            let angle: f64 = std::f64::consts::FRAC_PI_2 * rng.random::<f64>();
            angle.tan().ln().clamp(-LOG_RANGE, LOG_RANGE)
        };
        let lambda = |s: &Statistics| (0..s.terms()).map(|_| half_cauchy(rng)).collect();
        let log_lambda = self.statistics.iter().map(lambda).collect();
        let log_tau = self.prior.global_scale().ln() + half_cauchy(rng);
        let (shape, rate) = self.prior.slab_shape_and_rate();
        // Shape and scale were checked when the prior was built.
        let precision = Gamma::new(shape, 1.0 / rate).map_or(shape / rate, |g| g.sample(rng));
        let widest = self.statistics.iter().map(|s| s.target_rms);
        let noise: f64 = Exp1.sample(rng);
        Scales {
            log_lambda,
            log_tau,
            log_slab: -precision.max(f64::MIN_POSITIVE).ln(),
            log_sigma: widest.fold(f64::MIN_POSITIVE, f64::max).ln() - noise,
        }
    }

    fn factor(&self, i: usize, at: &Scales) -> Factor<'_> {
        let variance = |l: &f64| prior_variance(*l, at.log_tau, at.log_slab);
        let variances = at.log_lambda[i].iter().map(variance).collect();
        Factor::new(&self.statistics[i], variances, at.log_sigma.exp())
    }

    /// The logarithm of the density of all targets, with the coefficients integrated out.
    fn log_likelihood(&self, at: &Scales) -> f64 {
        let of_one = |i| self.factor(i, at).log_density;
        (0..self.statistics.len()).map(of_one).sum()
    }

    fn step(&self, at: &mut Scales, rng: &mut Pcg64) {
        for i in 0..self.statistics.len() {
            self.step_local(i, at, rng);
        }
        self.step_global(at, rng);
        let (shape, rate) = self.prior.slab_shape_and_rate();
        let here = at.clone();
        let slab = |log_slab: f64| {
            let log_likelihood = self.log_likelihood(&Scales {
                log_slab,
                ..here.clone()
            });
            log_likelihood - shape * log_slab - rate * (-log_slab).exp()
        };
        at.log_slab = stepping_out(WIDTH, at.log_slab, slab, rng);
        let here = at.clone();
        let noise = |log_sigma: f64| {
            let log_likelihood = self.log_likelihood(&Scales {
                log_sigma,
                ..here.clone()
            });
            log_likelihood + log_sigma - self.prior.noise_rate() * log_sigma.exp()
        };
        at.log_sigma = stepping_out(WIDTH, at.log_sigma, noise, rng);
    }

    /// Each λ_j of target `i`.
    fn step_local(&self, i: usize, at: &mut Scales, rng: &mut Pcg64) {
        let mut factor = self.factor(i, at).one_by_one();
        let (log_tau, log_slab) = (at.log_tau, at.log_slab);
        for log_lambda in &mut at.log_lambda[i] {
            factor.next(|alone| {
                let density = |log_lambda: f64| {
                    let d = prior_variance(log_lambda, log_tau, log_slab);
                    log_local(log_lambda) + alone.log_density(d)
                };
                *log_lambda = between((-LOG_RANGE, LOG_RANGE), *log_lambda, density, rng);
                prior_variance(*log_lambda, log_tau, log_slab)
            });
        }
    }

    /// τ, twice.
    fn step_global(&self, at: &mut Scales, rng: &mut Pcg64) {
        let scale = self.prior.global_scale().ln();
        let here = at.clone();
        let with_lambda = |log_tau: f64| {
            let log_likelihood = self.log_likelihood(&Scales {
                log_tau,
                ..here.clone()
            });
            log_likelihood + log_half_cauchy(log_tau, scale)
        };
        let before = stepping_out(WIDTH, at.log_tau, with_lambda, rng);
        let logs = || here.log_lambda.iter().flatten();
        let with_product = |log_tau: f64| {
            let lambda = |l: &f64| log_local(l + before - log_tau);
            log_half_cauchy(log_tau, scale) + logs().map(lambda).sum::<f64>()
        };
        at.log_tau = stepping_out(WIDTH, before, with_product, rng);
        let change = before - at.log_tau;
        for log_lambda in at.log_lambda.iter_mut().flatten() {
            *log_lambda += change;
        }
    }
}
