//! Some of the candidates as a system of their own: of large libraries those that the output error looks at.

use super::follow::FollowedModel;
use super::rank::RankedModel;
use super::run::IdentificationRun;
use crate::library::Library;
use crate::model::Term;
use crate::trajectory::output_error::{OutputErrorFit, System};

/// Candidates of all equations above which the output error looks only at terms that regressions kept: its steps cost the
/// cube of their number. Half of it loses terms of larger libraries that no regression kept; twice takes eight times the
/// time.
const MOST_CANDIDATES: usize = 400;

/// Candidates that were kept, as a system of their own.
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
        Self::of(run, &keep)
    }

    /// Those that are kept; under invariants and relations, fields.
    pub(super) fn of(run: &IdentificationRun<'_>, keep: &[bool]) -> Option<Self> {
        let kept: Vec<usize> = (0..keep.len()).filter(|&j| keep[j]).collect();
        let system = match &run.conserved {
            Some(conserved) => conserved.system_of(&kept),
            None => Self::system(run, keep)?,
        };
        Some(Self {
            system,
            kept,
            all: keep.len(),
        })
    }

    /// The system of single candidates.
    fn system(run: &IdentificationRun<'_>, keep: &[bool]) -> Option<System> {
        let mut libraries: Vec<Library> = Vec::new();
        let mut first = 0;
        for (library, _) in &run.libraries {
            let dropped: Vec<usize> = (0..library.len()).filter(|j| !keep[first + j]).collect();
            libraries.push(library.without(&dropped));
            first += library.len();
        }
        let known: Vec<Vec<Term>> = run.libraries.iter().map(|(_, k)| k.terms.clone()).collect();
        // All terms were compiled before.
        run.system_of_terms(run.data.inputs(), &libraries, &known)
    }

    /// The values of the candidates that are kept.
    pub(super) fn narrow<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let kept = self.kept.iter();
        kept.filter_map(|&j| values.get(j).copied()).collect()
    }

    /// A model over all candidates again.
    pub(super) fn widen(&self, found: &mut FollowedModel) {
        if let Some(free) = &mut found.without_signs {
            *free = self.wide(free, 0.0);
        }
        self.widen_fit(&mut found.fit);
    }

    /// A fit over all candidates again: nothing speaks for those that were left out.
    pub(super) fn widen_fit(&self, fit: &mut OutputErrorFit) {
        fit.coefficients = self.wide(&fit.coefficients, 0.0);
        fit.std_errors = self.wide(&fit.std_errors, 0.0);
        fit.evidence = self.wide(&fit.evidence, f64::NEG_INFINITY);
        for exchange in &mut fit.exchanges {
            let terms = exchange.dropped.iter_mut().chain(&mut exchange.added);
            terms.for_each(|term| *term = self.kept[*term]);
        }
        for alternative in fit.fronts.iter_mut().flatten() {
            for j in &mut alternative.support {
                *j = self.kept[*j];
            }
        }
    }

    fn wide(&self, values: &[f64], other: f64) -> Vec<f64> {
        let mut out = vec![other; self.all];
        for (&j, value) in self.kept.iter().zip(values) {
            out[j] = *value;
        }
        out
    }
}
