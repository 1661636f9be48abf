//! Whether terms that no library has explain a part of what a fit leaves.
//!
//! What a model lacks is rarely known. But a term of another shape is mostly correlated with what is missing: so a list of such terms,
//! powers, products, kinks and saturations of states and inputs, and slow waves in time, is tried one by one by what it would gain
//! ([`output_error::gains`]). The largest gain is judged by its probability where no term is missing, times the number that was
//! tried (Bonferroni's inequality). Known terms are tried as well: one that gains has another coefficient.

use std::f64::consts::TAU;

use sindy_expr::Expr;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::follow::FollowedModel;
use super::run::IdentificationRun;
use crate::library::{Library, parse};
use crate::model::{Interpolation, Term};
use crate::trajectory::output_error::{self, Piece, System};

/// Level of the test. Every fit is tested: of true models one in a thousand is doubted.
const LEVEL: f64 = 0.001;
/// Shapes in all equations that are tried, and waves, at most: normal equations of so many take as long as a step of the search.
const MOST: usize = 200;
/// Waves in time that are tried in each equation, at most, by their number over the longest stretch.
const WAVES: usize = 24;
/// The name of time where no column has it.
const TIME: &str = "t";

/// A term that would explain a part of what a fit leaves.
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
                "equation of {state}: with another coefficient the known term {term} would explain a part of what is left \
                 (p = {p:.0e}): the known part is not that of the data, or a term is not in the library"
            ),
            false => format!(
                "equation of {state}: {term}, which is not in the library, would explain a part of what is left (p = {p:.0e}): a term \
                 lacks there, this one or one like it"
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
    /// The term that explains most of what the fit leaves, where no chance does.
    pub(super) fn absent(&self, found: &FollowedModel, pieces: &[Piece<'_>]) -> Option<Absent> {
        // Under invariants fields are the candidates.
        if self.conserved.is_some() {
            return None;
        }
        let with_time = self.diffusion.is_none() && !self.data.names().contains(&TIME.to_owned());
        let candidates = self.tried(&found.fit.coefficients, with_time);
        let system = self.system_of(&candidates, with_time)?;
        let times: Vec<Vec<f64>> = pieces.iter().map(|p| self.since_start(p.time)).collect();
        let pieces: Vec<Piece<'_>> = pieces
            .iter()
            .zip(&times)
            .map(|(piece, time)| match with_time {
                true => with_input(piece, time),
                false => piece.clone(),
            })
            .collect();
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
    fn tried(&self, fit: &[f64], with_time: bool) -> Vec<Candidate> {
        let names = self.data.names();
        let sizes: Vec<f64> = (0..names.len()).map(|j| self.deviation(j)).collect();
        let shapes = shapes(&names, &sizes);
        let waves = match with_time {
            true => waves(self.longest_stretch()),
            false => Vec::new(),
        };
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
                let more = shapes.iter().filter(|s| !has(s)).take(each);
                let more = more.chain(waves.iter().take(each));
                more.for_each(|term| add(term, 0.0, false));
            }
        }
        out
    }

    fn system_of(&self, candidates: &[Candidate], with_time: bool) -> Option<System> {
        let states = self.data.states();
        let of = |i: usize| {
            let own = candidates.iter().filter(|c| c.equation == i);
            Library::of(own.map(|c| c.term.clone()).collect())
        };
        let libraries: Vec<Library> = (0..states.len()).map(of).collect();
        let known = self.libraries.iter().map(|(_, k)| k.terms.clone());
        let known: Vec<Vec<Term>> = known.collect();
        let mut inputs = self.data.inputs().to_vec();
        if with_time {
            inputs.push(TIME.to_owned());
        }
        let measured = (states, states.len() - self.positions.len());
        let system = System::with_known(self.time, measured, &inputs, &libraries, &known).ok()?;
        let system = system.stiff(self.system.is_stiff());
        Some(system.with_diffusion_of(&self.system))
    }

    /// The standard deviation of a state or an input over all rows.
    fn deviation(&self, column: usize) -> f64 {
        let all = || self.stretches.iter().flat_map(|s| s.columns[column]);
        let rows = all().count() as f64;
        let mean = all().sum::<f64>() / rows;
        (all().map(|v| (v - mean).powi(2)).sum::<f64>() / rows).sqrt()
    }

    fn longest_stretch(&self) -> f64 {
        let spans = self.stretches.iter().map(|s| match s.time {
            [first, .., last] => last - first,
            _ => 0.0,
        });
        spans.fold(0.0, f64::max)
    }

    /// Times since the first of all rows.
    fn since_start(&self, time: &[f64]) -> Vec<f64> {
        let starts = self.stretches.iter().filter_map(|s| s.time.first());
        let first = starts.copied().fold(f64::INFINITY, f64::min);
        time.iter().map(|t| t - first).collect()
    }
}

/// A piece with one more input.
fn with_input<'a>(piece: &Piece<'a>, values: &'a [f64]) -> Piece<'a> {
    let mut piece = piece.clone();
    piece.inputs.push(values);
    piece.between.push(Interpolation::Linear);
    piece
}

/// Time, and waves of whole numbers over a span.
fn waves(span: f64) -> Vec<Expr> {
    let frequency = |k: usize| rounded(TAU * k as f64 / span, 2);
    let both = |k: usize| {
        let omega = frequency(k);
        [
            format!("cos({omega}*{TIME})"),
            format!("sin({omega}*{TIME})"),
        ]
    };
    let texts = (1..=WAVES).flat_map(both).chain([TIME.to_owned()]);
    texts.filter_map(|text| parse(&text).ok()).collect()
}

/// Shapes of one variable, and products of two and three, the simplest first. Kinks are where a variable is 0, and saturations
/// begin at its standard deviation.
fn shapes(names: &[String], sizes: &[f64]) -> Vec<Expr> {
    let moving: Vec<(String, f64)> = names
        .iter()
        .zip(sizes)
        .filter(|(_, size)| **size > 0.0 && size.is_finite())
        .map(|(name, size)| (Expr::variable(name).to_string(), rounded(*size, 1)))
        .collect();
    let mut texts = Vec::new();
    for (s, size) in &moving {
        texts.extend([
            s.clone(),
            format!("{s}^2"),
            format!("{s}^3"),
            format!("{s}*abs({s})"),
            format!("tanh({}*{s})", rounded(4.0 / size, 1)),
            format!("{s}/({size} + abs({s}))"),
            format!("abs({s})"),
            format!("{s}^4"),
            format!("{s}^5"),
        ]);
    }
    let others = |i: usize| moving[i + 1..].iter().map(move |b| (i, b));
    let pairs = || (0..moving.len()).flat_map(others);
    texts.extend(pairs().map(|(i, (r, _))| format!("{}*{r}", moving[i].0)));
    for (i, (r, other)) in pairs() {
        let (s, size) = &moving[i];
        texts.extend([
            format!("{s}^2*{r}"),
            format!("{s}*{r}^2"),
            format!("{s}*abs({r})"),
            format!("{r}*abs({s})"),
            format!("{s}*{r}/({size} + abs({s}))"),
            format!("{s}*{r}/({other} + abs({r}))"),
            format!("{s}^3*{r}"),
            format!("{s}^2*{r}^2"),
            format!("{s}*{r}^3"),
        ]);
    }
    for (i, (a, _)) in moving.iter().enumerate() {
        for (j, (b, _)) in moving.iter().enumerate().skip(i + 1) {
            let last = moving.iter().skip(j + 1);
            texts.extend(last.map(|(c, _)| format!("{a}*{b}*{c}")));
        }
    }
    // All are well formed: names are quoted where they must be.
    texts.iter().filter_map(|text| parse(text).ok()).collect()
}

/// To so many digits behind the first, which are enough for a shape.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}").parse().unwrap_or(value)
}
