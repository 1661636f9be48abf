//! How one of several fits is chosen.

use super::Member;
use crate::statistics::criteria::Criterion;

/// Mean, and the standard error of the mean.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// The fit with the smallest mean square error over groups left out, and the one that the rule of one standard error takes
/// for it: the fewest terms whose error is within one standard error of the smallest, the better of equals. `errors` are
/// the mean squares of each fit by group. The standard error is that of paired differences: groups differ far more among
/// themselves than two fits do on one group.
pub(crate) fn within_one_error(errors: &[Vec<f64>], terms: &[usize]) -> OneError {
    let mean = |m: usize| mean_and_error(&errors[m]).0;
    let fits = 0..errors.len();
    let best = fits
        .clone()
        .min_by(|&a, &b| mean(a).total_cmp(&mean(b)))
        .unwrap_or(0);
    let within = |m: usize| {
        let pairs = errors[m].iter().zip(&errors[best]);
        let differences: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        let (mean, se) = mean_and_error(&differences);
        mean <= se
    };
    let chosen = fits
        .filter(|&m| m == best || within(m))
        .min_by(|&a, &b| terms[a].cmp(&terms[b]).then(mean(a).total_cmp(&mean(b))))
        .unwrap_or(best);
    let reason = format!(
        "fewest terms ({}) whose error on left-out groups ({:.4}) is within one standard error of the smallest ({:.4}, \
         {} terms)",
        terms[chosen],
        mean(chosen).sqrt(),
        mean(best).sqrt(),
        terms[best]
    );
    OneError {
        best,
        chosen,
        reason,
    }
}

/// The choice by the rule of one standard error.
pub(crate) struct OneError {
    pub best: usize,
    pub chosen: usize,
    pub reason: String,
}

pub(super) fn best_score(members: &[Member], criterion: Criterion) -> (usize, usize, String) {
    let score = |m: usize| members[m].score.unwrap_or(f64::INFINITY);
    let best = (0..members.len())
        .min_by(|&a, &b| {
            let terms = |m: usize| members[m].fit.terms();
            score(a).total_cmp(&score(b)).then(terms(a).cmp(&terms(b)))
        })
        .unwrap_or(0);
    let reason = format!(
        "best {criterion:?} ({:.1}), with {} terms",
        score(best),
        members[best].fit.terms()
    );
    (best, best, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_one_standard_error_of_the_paired_differences() {
        // By group; the differences to the best are alike in every group but the last.
        let best = vec![1.0, 4.0, 2.0, 9.0];
        let shifted = |by: [f64; 4]| best.iter().zip(by).map(|(a, b)| a + b).collect::<Vec<_>>();
        // Mean 0.1, standard error 0: beyond, although the groups' own scatter is twenty times that.
        let steady = shifted([0.1; 4]);
        // Mean 0.1, standard error 0.1: just within.
        let one = shifted([0.4, 0.0, 0.0, 0.0]);
        // Mean 0.11, standard error 0.0967: just beyond.
        let beyond = shifted([0.4, 0.04, 0.0, 0.0]);
        let of = |errors: Vec<Vec<f64>>, terms: &[usize]| {
            let found = within_one_error(&errors, terms);
            (found.best, found.chosen)
        };
        assert_eq!(of(vec![best.clone(), steady.clone()], &[3, 1]), (0, 0));
        assert_eq!(of(vec![best.clone(), one.clone()], &[3, 1]), (0, 1));
        assert_eq!(of(vec![best.clone(), beyond], &[3, 1]), (0, 0));
        // Of equal numbers of terms the better one; more terms never.
        assert_eq!(of(vec![best.clone(), one.clone()], &[1, 1]), (0, 0));
        assert_eq!(of(vec![one, best, steady], &[5, 3, 0]), (1, 1));
    }
}
