//! Fits over fields, written in candidate terms.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::Conserved;
use super::joined::summed;
use crate::identify::evidence::{TermEvidence, of_regression};
use crate::solve::fit::Fit;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::{Alternative, OutputErrorFit};

impl Conserved {
    /// Coefficients of all candidates from those of the fields: `ξ = N a`.
    pub(in crate::identify) fn terms(&self, of_fields: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.candidates];
        for (field, a) in self.fields.iter().zip(of_fields) {
            for &(candidate, factor) in field {
                out[candidate] += factor * a;
            }
        }
        out
    }

    /// The factors of a candidate in the fields that are kept.
    fn row(&self, candidate: usize, kept: &[usize]) -> DVector<f64> {
        let factor = |&j: &usize| {
            let own = self.fields[j].iter().find(|(k, _)| *k == candidate);
            own.map_or(0.0, |(_, factor)| *factor)
        };
        DVector::from_iterator(kept.len(), kept.iter().map(factor))
    }

    /// An output error fit over fields as one over candidates, whose fronts have the candidates of `equations`.
    pub(in crate::identify) fn terms_of_fit(
        &self,
        fit: &OutputErrorFit,
        equations: &[Range<usize>],
    ) -> OutputErrorFit {
        let coefficients = self.terms(&fit.coefficients);
        let kept = kept(&fit.coefficients);
        let unknown = kept.iter().any(|&j| fit.std_errors[j].is_infinite());
        let std_error = |j: usize| match coefficients[j] != 0.0 {
            true if unknown => f64::INFINITY,
            true => {
                let row = self.row(j, &kept);
                row.dot(&(&fit.covariance * &row)).max(0.0).sqrt()
            }
            false => 0.0,
        };
        let std_errors: Vec<f64> = (0..self.candidates).map(std_error).collect();
        let worth = coefficients.iter().zip(&std_errors);
        let evidence = worth.map(|(c, error)| match *c != 0.0 {
            true => (c / error).powi(2) - fit.penalty,
            false => -fit.penalty,
        });
        let fronts = equations.iter().map(|own| self.front(fit, own)).collect();
        OutputErrorFit {
            evidence: evidence.collect(),
            coefficients,
            std_errors,
            fronts,
            exchanges: Vec::new(),
            ..fit.clone()
        }
    }

    /// The joint front in the candidates of one equation.
    fn front(&self, fit: &OutputErrorFit, own: &Range<usize>) -> Vec<Alternative> {
        let points: Vec<&Alternative> = fit.fronts.iter().flatten().collect();
        let supports: Vec<Vec<usize>> = points.iter().map(|p| p.support.clone()).collect();
        let shown = self.shown(&supports, &kept(&fit.coefficients), own);
        let alternative = |(at, support): (usize, Vec<usize>)| Alternative {
            support,
            ..points[at].clone()
        };
        shown.into_iter().map(alternative).collect()
    }

    /// The points of a joint front that an equation shows, each with its candidates in `own`. Of points that differ only in other
    /// equations the one of the model is shown, or else the last, whose error is the least.
    pub(super) fn shown(
        &self,
        supports: &[Vec<usize>],
        chosen: &[usize],
        own: &Range<usize>,
    ) -> Vec<(usize, Vec<usize>)> {
        let mut out: Vec<(usize, Vec<usize>)> = Vec::new();
        for (at, fields) in supports.iter().enumerate() {
            let terms = self.touched(fields, own);
            match out.iter_mut().find(|(_, shown)| *shown == terms) {
                Some((before, _)) if supports[*before] != chosen => *before = at,
                Some(_) => {}
                None => out.push((at, terms)),
            }
        }
        out
    }

    /// The candidates in `own` that some of these fields have.
    fn touched(&self, fields: &[usize], own: &Range<usize>) -> Vec<usize> {
        let touches = |candidate: &usize| {
            fields
                .iter()
                .any(|&j| self.fields[j].iter().any(|(k, _)| k == candidate))
        };
        own.clone().filter(touches).collect()
    }

    /// The evidence for each candidate from a regression over fields: the fields are taken with the candidate's coefficient as one of
    /// the unknowns.
    pub(super) fn evidence_of_regression(
        &self,
        fit: &Fit,
        (parts, total): (&[Gram], &Gram),
        independent: f64,
    ) -> Vec<TermEvidence> {
        let kept = kept(fit.coefficients.as_slice());
        let coefficients = self.terms(fit.coefficients.as_slice());
        let mut out = vec![TermEvidence::NONE; self.candidates];
        for (candidate, evidence) in out.iter_mut().enumerate() {
            if coefficients[candidate] == 0.0 {
                continue;
            }
            let row = self.row(candidate, &kept);
            let largest = row.iamax();
            let pivot = kept[largest];
            // a = S b with b = a, but for the pivot: there b is the candidate's coefficient.
            let mut sums = DMatrix::identity(fit.support.len(), fit.support.len());
            for (&j, factor) in kept.iter().zip(row.iter()) {
                sums[(pivot, j)] = -factor / row[largest];
            }
            sums[(pivot, pivot)] = 1.0 / row[largest];
            let mut changed = fit.coefficients.clone();
            changed[pivot] = coefficients[candidate];
            let parts: Vec<Gram> = parts.iter().map(|g| summed(g, &sums)).collect();
            let fit = Fit {
                coefficients: changed,
                ..fit.clone()
            };
            *evidence = of_regression(&fit, &parts, &summed(total, &sums), independent)[pivot];
        }
        out
    }
}

/// The fields whose coefficients are not zero.
pub(super) fn kept(coefficients: &[f64]) -> Vec<usize> {
    (0..coefficients.len())
        .filter(|&j| coefficients[j] != 0.0)
        .collect()
}
