//! Whether terms that no library has explain a part of the residual of a fit.
//!
//! What a model lacks is rarely known. But a term of another shape is mostly correlated with what is missing. So a list of terms is
//! tried one by one by what it would gain ([`output_error::gains`]): powers, products, kinks and saturations of states and inputs,
//! lags of inputs, slow waves in time. The largest gain is judged by its probability where no term is missing, times the number
//! of terms that were tried (Bonferroni's inequality). Known terms are tried as well: one that gains has another coefficient.

mod others;

use sindy_expr::Expr;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use self::others::{Others, TIME};
use super::follow::FollowedModel;
use super::run::IdentificationRun;
use crate::library::Library;
use crate::model::{Interpolation, Term};
use crate::trajectory::output_error::{self, Piece, System};

/// Level of the test. Every fit is tested: of true models one in a thousand is doubted.
const LEVEL: f64 = 0.001;
/// Shapes that are tried in all equations together, at most, and as many lags and waves: normal equations of so many terms take as
/// long as a step of the search.
const MOST: usize = 200;

/// A term that would explain a part of the residual of a fit.
#[derive(Clone, Debug)]
pub(super) struct Absent {
    equation: usize,
    term: String,
    /// Whether it is in the known part of the equation.
    known: bool,
    /// The probability of as large a gain where no term is missing.
    p: f64,
}

impl Absent {
    /// What it says of the model.
    pub(super) fn warning(&self, states: &[String]) -> String {
        let Self { term, p, .. } = self;
        let state = &states[self.equation];
        match self.known {
            true => format!(
                "equation of {state}: with another coefficient the known term {term} would explain a part of the residual \
                 (p = {p:.0e}): the known part is not that of the data, or a term is not in the library"
            ),
            false => format!(
                "equation of {state}: {term}, which is not in the library, would explain a part of the residual (p = {p:.0e}): the \
                 equation lacks this term or one like it"
            ),
        }
    }
}

/// A candidate of the test.
struct Candidate {
    equation: usize,
    term: Expr,
    /// That of the fit, or 0.
    coefficient: f64,
    known: bool,
}

impl IdentificationRun<'_> {
    /// The term that would explain most of the residual, where chance does not.
    pub(super) fn absent(&self, found: &FollowedModel, pieces: &[Piece<'_>]) -> Option<Absent> {
        // Under invariants fields are the candidates.
        if self.conserved.is_some() {
            return None;
        }
        let others = self.others();
        let candidates = self.tried(&found.fit.coefficients, &others);
        let system = self.system_of(&candidates, &others)?;
        let of = |p: &Piece<'_>| others.columns.iter().map(|c| c.values(p)).collect();
        let columns: Vec<Vec<Vec<f64>>> = pieces.iter().map(of).collect();
        let all = pieces.iter().zip(&columns);
        let pieces: Vec<Piece<'_>> = all.map(|(p, columns)| with_inputs(p, columns)).collect();
        let coefficients: Vec<f64> = candidates.iter().map(|c| c.coefficient).collect();
        let fit = (&found.fit, found.longest);
        let gains = output_error::gains(&system, &pieces, fit, &coefficients)?;
        let tried = coefficients.iter().filter(|c| **c == 0.0).count() as f64;
        let all = candidates.into_iter().zip(gains);
        let (best, gain) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let p = tried * ChiSquared::new(1.0).ok()?.sf(gain);
        (p < LEVEL).then(|| Absent {
            equation: best.equation,
            term: best.term.to_string(),
            known: best.known,
            p,
        })
    }

    /// The terms of the fit, equation by equation, and behind them those that are tried.
    fn tried(&self, fit: &[f64], others: &Others) -> Vec<Candidate> {
        let open = self.libraries.iter().filter(|(_, k)| !k.whole).count();
        let each = MOST / open.max(1);
        let mut out = Vec::new();
        let mut first = 0;
        for (equation, (library, known)) in self.libraries.iter().enumerate() {
            let own = &fit[first..first + library.len()];
            first += library.len();
            let mut add = |term: &Expr, coefficient: f64, known: bool| {
                out.push(Candidate {
                    equation,
                    term: term.clone(),
                    coefficient,
                    known,
                });
            };
            let terms = library.terms().iter().zip(own);
            terms
                .filter(|(_, c)| **c != 0.0)
                .for_each(|(term, c)| add(term, *c, false));
            // What says that a velocity is the derivative of its position is true by definition.
            if !self.positions.contains(&equation) {
                let known = known.terms.iter();
                known.for_each(|t| add(&t.expression, 0.0, true));
            }
            if !known.whole {
                let has = |other: &&Expr| {
                    let mut known = known.terms.iter();
                    library.terms().contains(other) || known.any(|t| t.expression == **other)
                };
                let more = others.shapes.iter().filter(|s| !has(s)).take(each);
                let more = more.chain(others.of_columns.iter().take(each));
                more.for_each(|term| add(term, 0.0, false));
            }
        }
        out
    }

    fn system_of(&self, candidates: &[Candidate], others: &Others) -> Option<System> {
        let states = self.data.states();
        let of = |i: usize| {
            let own = candidates.iter().filter(|c| c.equation == i);
            Library::of(own.map(|c| c.term.clone()).collect())
        };
        let libraries: Vec<Library> = (0..states.len()).map(of).collect();
        let known = self.libraries.iter().map(|(_, k)| k.terms.clone());
        let known: Vec<Vec<Term>> = known.collect();
        let mut inputs = self.data.inputs().to_vec();
        inputs.extend(others.columns.iter().map(|c| c.name.clone()));
        self.system_of_terms(&inputs, &libraries, &known)
    }

    /// What is tried in every equation.
    fn others(&self) -> Others {
        let names = self.data.names();
        let sizes: Vec<f64> = (0..names.len()).map(|j| self.deviation(j)).collect();
        let mut others = Others::shapes(&names, &sizes);
        let steps = self
            .stretches
            .iter()
            .map(|s| s.time.len().saturating_sub(1))
            .sum::<usize>();
        let spans = self.stretches.iter().filter_map(|s| match s.time {
            [first, .., last] => Some((*first, last - first)),
            _ => None,
        });
        let spans: Vec<(f64, f64)> = spans.collect();
        // Terms of a diffusion are compiled for the columns of the data.
        if self.diffusion.is_none() {
            if !names.iter().any(|name| name == TIME) {
                let start = spans.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
                others.add_waves(start, spans.iter().map(|s| s.1).fold(0.0, f64::max));
            }
            let step = spans.iter().map(|s| s.1).sum::<f64>() / steps as f64;
            others.add_lags(self.data.inputs(), &sizes[self.data.states().len()..], step);
        }
        others
    }

    /// The standard deviation of a state or an input over all rows.
    fn deviation(&self, column: usize) -> f64 {
        let all = || self.stretches.iter().flat_map(|s| s.columns[column]);
        let rows = all().count() as f64;
        let mean = all().sum::<f64>() / rows;
        (all().map(|v| (v - mean).powi(2)).sum::<f64>() / rows).sqrt()
    }
}

/// A piece with further inputs.
fn with_inputs<'a>(piece: &Piece<'a>, values: &'a [Vec<f64>]) -> Piece<'a> {
    let mut piece = piece.clone();
    for values in values {
        piece.inputs.push(values);
        piece.between.push(Interpolation::Linear);
    }
    piece
}
