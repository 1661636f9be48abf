//! Stiff systems: regressions on rows whose times run over orders of magnitude, and equations that are known up to a multiple of
//! another one.

use super::Progress;
use super::prepare::{self, Slopes};
use super::regress::{NODES, Statistics, signed_subsets};
use super::run::IdentificationRun;
use crate::data::dataset::Stretch;
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;
use crate::solve::sign::Sign;
use crate::statistics::criteria::Criterion;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::{Multiple, OutputErrorFit};

/// Rounds between a model and the weights of rows, which depend on each other, where the noise of slopes spans orders of magnitude.
const WEIGHT_ROUNDS: usize = 3;

/// A multiple of another equation matters if its largest term is this share of the equation's largest: the smallest term of most
/// equations is larger, and such a multiple could make it or cancel it.
const MATTERS: f64 = 0.1;

impl IdentificationRun<'_> {
    /// Slopes over the number of the row, where times run over orders of magnitude: with rows weighted alike, and then by the noise that
    /// the model has by the statistics before.
    pub(super) fn stiff_regressions(
        &self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(Slopes, Vec<Statistics>), SindyError> {
        let n = self.data.states().len();
        let mut statistics = Vec::new();
        let mut slopes = prepare::by_row(&self.stretches, n)?;
        self.add(&slopes, &self.stretches, &mut statistics, progress)?;
        let rounds = if self.conserved.is_none() {
            WEIGHT_ROUNDS
        } else {
            0
        };
        for round in 1..=rounds {
            let coefficients = best(&statistics[round - 1], &self.signs)?;
            let noise = |(s, smooth): (&Stretch<'_>, &Vec<Smoothed>)| {
                let states = smooth.iter().map(|c| c.value.as_slice());
                let columns: Vec<&[f64]> = states.chain(s.columns[n..].iter().copied()).collect();
                self.system
                    .slope_noise(&coefficients, &columns, &self.noise.sigma)
            };
            let terms: Vec<_> = self
                .stretches
                .iter()
                .zip(&slopes.smoothed)
                .map(noise)
                .collect();
            slopes.weights = prepare::weights(&self.stretches, &self.noise, &terms);
            slopes.name = format!("smoothing spline over rows, weighted {round}");
            self.add(&slopes, &self.stretches, &mut statistics, progress)?;
        }
        Ok((slopes, statistics))
    }

    /// A warning for each equation of a stiff system that is not known up to a multiple of another.
    pub(super) fn warnings_of_multiples(&self, fit: &OutputErrorFit) -> Vec<String> {
        let states = self.data.states();
        let matter = fit.multiples.iter().filter(|m| m.share > MATTERS);
        let warning = |m: &Multiple| {
            let (own, of) = (&states[m.equation], &states[m.of]);
            format!(
                "equation of {own}: other terms are equally likely: with up to {:.1e} times the terms of the equation of {of} added, and \
                 its own coefficients adapted, it follows the data as well, and terms change by up to {:.0} % of the largest. Rows while \
                 fast states move, or less noise, decide between them",
                m.most,
                100.0 * m.share
            )
        };
        matter.map(warning).collect()
    }
}

/// Coefficients of the best subsets by the Bayesian criterion, equation by equation.
fn best(statistics: &Statistics, signs: &[Vec<Sign>]) -> Result<Vec<f64>, SindyError> {
    let mut out = Vec::new();
    for (parts, signs) in statistics.grams.iter().zip(signs) {
        let total = Gram::total(parts);
        // Of an equation that is known whole.
        if total.xty.is_empty() {
            continue;
        }
        let rows = total.rows as f64 * statistics.independent;
        let found = signed_subsets(&total, signs, NODES)?;
        let chosen = found.choose(&total, Criterion::Bic, Some(rows))?;
        out.extend(chosen.fit.coefficients.iter().copied());
    }
    Ok(out)
}
