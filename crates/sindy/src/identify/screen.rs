//! Large libraries: the candidates that the output error looks at.

use super::follow::FollowedModel;
use super::rank::RankedModel;
use super::run::IdentificationRun;
use crate::library::Library;
use crate::model::Term;
use crate::trajectory::output_error::System;

/// Candidates of all equations above which the output error looks only at terms that regressions kept: its steps cost the
/// cube of their number. Half of it loses terms of larger libraries that no regression kept; twice takes eight times the
/// time.
const MOST_CANDIDATES: usize = 400;

/// The candidates of a large library that regressions kept, as a system of their own.
pub(super) struct Screen {
    pub system: System,
    /// Their numbers among all candidates.
    kept: Vec<usize>,
    all: usize,
}

impl Screen {
    /// Those of the best models, as many whole models as there is room for; `None` where all candidates have room.
    pub(super) fn of_large(run: &IdentificationRun<'_>, ranked: &[RankedModel]) -> Option<Self> {
        let all: usize = run.libraries.iter().map(|(l, _)| l.len()).sum();
        if all <= MOST_CANDIDATES {
            return None;
        }
        let mut keep = vec![false; all];
        for model in ranked {
            let with: Vec<bool> = keep
                .iter()
                .zip(&model.coefficients)
                .map(|(kept, c)| *kept || *c != 0.0)
                .collect();
            if with.iter().filter(|k| **k).count() <= MOST_CANDIDATES {
                keep = with;
            }
        }
        let mut libraries: Vec<Library> = Vec::new();
        let mut first = 0;
        for (library, _) in &run.libraries {
            let dropped: Vec<usize> = (0..library.len()).filter(|j| !keep[first + j]).collect();
            libraries.push(library.without(&dropped));
            first += library.len();
        }
        let known: Vec<Vec<Term>> = run.libraries.iter().map(|(_, k)| k.terms.clone()).collect();
        let states = run.data.states();
        let measured = (states, states.len() - run.positions.len());
        // All terms were compiled before.
        let system =
            System::with_known(run.time, measured, run.data.inputs(), &libraries, &known).ok()?;
        Some(Self {
            system,
            kept: (0..all).filter(|&j| keep[j]).collect(),
            all,
        })
    }

    /// The values of the candidates that are kept.
    pub(super) fn narrow<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let kept = self.kept.iter();
        kept.filter_map(|&j| values.get(j).copied()).collect()
    }

    /// A fit over all candidates again: nothing speaks for those that were left out.
    pub(super) fn widen(&self, found: &mut FollowedModel) {
        let fit = &mut found.fit;
        let wide = |values: &[f64], other: f64| {
            let mut out = vec![other; self.all];
            for (&j, value) in self.kept.iter().zip(values) {
                out[j] = *value;
            }
            out
        };
        if let Some(free) = &mut found.without_signs {
            *free = wide(free, 0.0);
        }
        fit.coefficients = wide(&fit.coefficients, 0.0);
        fit.std_errors = wide(&fit.std_errors, 0.0);
        fit.evidence = wide(&fit.evidence, f64::NEG_INFINITY);
        for alternative in fit.fronts.iter_mut().flatten() {
            for j in &mut alternative.support {
                *j = self.kept[*j];
            }
        }
    }
}
