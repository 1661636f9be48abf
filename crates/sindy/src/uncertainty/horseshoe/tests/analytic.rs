//! Limits with a closed form, and a posterior by quadrature.

use nalgebra::DMatrix;

use super::super::*;
use super::{long, of_logarithms};
use crate::statistics::normal::tests::reference;
use crate::statistics::regression::least_squares;

/// One term with 20 rows, and its posterior by the rectangle rule over the logarithms of all four scales: means of β, β², κ, ln τ,
/// ln c² and ln σ.
fn quadrature(prior: [f64; 4], rows: f64, g: f64, b: f64, yty: f64) -> [f64; 6] {
    let [tau_0, degrees, scale, rate] = prior;
    let shape = 0.5 * degrees;
    // Steps resolve what is analytic in a strip of half a unit or more around the axis; the ends have e⁻¹² of the mass.
    let grid = |low: f64, high: f64, step: f64| {
        (0..=((high - low) / step) as usize).map(move |i| low + step * i as f64)
    };
    let mut sums = [0.0; 7];
    let centre = 0.5 * (yty / rows).ln();
    for log_sigma in grid(centre - 1.2, centre + 1.2, 0.06) {
        let s2 = (2.0 * log_sigma).exp();
        for log_slab in grid(-2.0, 10.0, 0.5) {
            let slab = log_slab.exp();
            let outer = log_sigma
                - rate * log_sigma.exp()
                - rows * log_sigma
                - shape * log_slab
                - shape * scale * scale / slab;
            for log_tau in grid(tau_0.ln() - 14.0, tau_0.ln() + 14.0, 0.5) {
                for log_lambda in grid(-14.0, 14.0, 0.5) {
                    let (tau, lambda) = (log_tau.exp(), log_lambda.exp());
                    let d = slab * (tau * lambda).powi(2) / (slab + (tau * lambda).powi(2));
                    let kappa = s2 / (s2 + d * g);
                    let cauchy =
                        (lambda / (1.0 + lambda * lambda)) * (tau / (tau_0.powi(2) + tau * tau));
                    let misfit = (yty - b * b * d / (s2 + d * g)) / s2;
                    let weight = (outer - 0.5 * misfit).exp() * cauchy * kappa.sqrt();
                    let (mean, variance) = (d * b / (s2 + d * g), d * kappa);
                    let values = [
                        1.0,
                        mean,
                        mean * mean + variance,
                        kappa,
                        log_tau,
                        log_slab,
                        log_sigma,
                    ];
                    sums.iter_mut()
                        .zip(values)
                        .for_each(|(sum, v)| *sum += weight * v);
                }
            }
        }
    }
    std::array::from_fn(|k| sums[k + 1] / sums[0])
}

#[test]
fn analytic_one_term_equals_quadrature() {
    // A term of two and a half standard errors: neither there nor not there.
    let prior = [0.3, 5.0, 1.5, 2.0];
    let (rows, g, b, yty) = (20.0, 25.0, 11.0, 19.0);
    let expected = quadrature(prior, rows, g, b, yty);
    let mut gram = Gram::zeros(1);
    gram.xtx[(0, 0)] = g;
    gram.xty[0] = b;
    (gram.yty, gram.rows) = (yty, 20);
    let [tau_0, degrees, scale, rate] = prior;
    let found = long(3)
        .prior(Prior::new(tau_0, degrees, scale, rate).unwrap())
        .draws(20_000)
        .unwrap()
        .sample(&[gram])
        .unwrap();
    let target = &found.targets[0];
    let beta = target.marginals[0];
    let [tau, slab, sigma] = [0, 1, 2].map(|k| of_logarithms(&found.scales[k]));
    // Five standard errors of a mean of draws with these diagnostics. κ has a standard deviation below 1/2.
    let error = |sd: f64, m: &Marginal| 5.0 * sd / m.diagnostic.effective_draws.sqrt();
    let cases = [
        (beta.mean, error(beta.sd, &beta)),
        (
            beta.sd.powi(2) + beta.mean.powi(2),
            error(2.0 * beta.sd * beta.mean.max(beta.sd), &beta),
        ),
        (target.shrinkage[0], error(0.5, &beta)),
        (tau.0, error(tau.1, &found.global_scale)),
        (slab.0, error(slab.1, &found.slab_variance)),
        (sigma.0, error(sigma.1, &found.noise)),
    ];
    for (k, ((value, tolerance), expected)) in cases.into_iter().zip(expected).enumerate() {
        assert!(
            (value - expected).abs() < tolerance,
            "{k}: {value} {expected} ± {tolerance}"
        );
        // A tolerance that would hold for anything says nothing: it is a small part of what differs between priors.
        assert!(tolerance < 0.1, "{k}: {tolerance}");
    }
}

#[test]
fn analytic_much_data_give_least_squares_and_its_standard_errors() {
    // Each row 10⁴ times: the prior counts as a part in 10⁴ or less of the data.
    let one = reference();
    let mut gram = Gram::zeros(6);
    gram.merge_copies(&one, 1e4);
    let (found, least) = (
        Horseshoe::new(1)
            .sample(std::slice::from_ref(&gram))
            .unwrap(),
        least_squares(&one, &[true; 6]),
    );
    let inverse = gram.xtx.clone().try_inverse().unwrap();
    let variance = gram.residual_sum(&least) / gram.rows as f64;
    for (j, m) in found.targets[0].marginals.iter().enumerate() {
        let error = (variance * inverse[(j, j)]).sqrt();
        // Shrinkage by τ is some tenths of a standard error at most, of terms near zero.
        assert!(
            (m.mean - least[j]).abs() < 0.3 * error,
            "{j}: {m:?} {} {error}",
            least[j]
        );
        assert!((m.sd / error - 1.0).abs() < 0.1, "{j}: {m:?} {error}");
    }
    // σ of 6·10⁵ rows is known to a part in 1100.
    assert!(
        (found.noise.mean / variance.sqrt() - 1.0).abs() < 1e-3,
        "{:?}",
        found.noise
    );
}

#[test]
fn analytic_equal_variances_are_ridge_regression() {
    let gram = reference();
    let statistics = Statistics::new(&gram, Scaling::None);
    let (variance, sigma) = (0.3, 0.2);
    let factor = conditional::Factor::new(&statistics, vec![variance; 6], sigma);
    let ridge = DMatrix::identity(6, 6) * (sigma * sigma / variance);
    let expected = (&gram.xtx + ridge).lu().solve(&gram.xty).unwrap();
    // A condition of about 1e3.
    assert!((factor.mean - expected).amax() < 1e-11);
}
