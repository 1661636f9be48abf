//! From chosen relations to the result: standard errors, model, warnings.

use super::compare::{Comparison, Sought};
use super::relation::{Candidates, Linear, Place, Relation, readable};
use super::result::{ComparedRelation, ImplicitIdentification, RationalEquation, RationalTerm};
use super::run::Choice;
use crate::error::SindyError;
use crate::identify::{Identification, Progress};
use crate::library::Library;
use crate::model::{Model, Term};
use crate::numerics::prime;
use crate::statistics::criteria::TWENTY_TO_ONE;
use sindy_expr::{Expr, Scratch};

/// Rounds of the last fit, at most: relations come from a fit, so that one is the rule.
const ROUNDS: usize = 4;
/// Change of a coefficient in standard errors below which the last fit has settled.
const SETTLED: f64 = 0.05;
/// Twice the logarithm of a likelihood ratio of a hundred: rivals with at most one coefficient more are reported below it.
const AS_WELL: f64 = 9.21;
/// Points of the box of the data at which denominators are looked at.
const POINTS: usize = 2000;

impl Comparison<'_, '_> {
    /// The result where all equations are those of the ordinary identification.
    pub(super) fn explicit(
        &self,
        found: Identification,
        chosen: &Choice,
    ) -> Result<ImplicitIdentification, SindyError> {
        let mut equations = Vec::new();
        for (i, terms) in found.model.equations().iter().enumerate() {
            let intervals = &found.equations[i].intervals;
            let term = |(k, t): (usize, &Term)| of_term(t, intervals.get(k).copied().flatten());
            equations.push(RationalEquation {
                state: self.run.data.states()[i].clone(),
                numerator: terms.iter().enumerate().map(term).collect(),
                denominator: vec![held(&Expr::constant(1.0))],
                noise: found.equations[i].noise,
                residual: found.equations[i].residual,
                compared: self.described(i, chosen),
            });
        }
        let mut warnings = found.warnings;
        warnings.extend(alternatives(&equations));
        Ok(ImplicitIdentification {
            equations,
            model: found.model,
            outcome: found.outcome,
            reason: format!("no denominator is worth its terms; {}", found.choice.reason),
            inputs_between: found.inputs_between,
            data: found.data,
            warnings,
        })
    }

    /// The result for relations with denominators, fitted once more on all rows.
    pub(super) fn rational(
        &self,
        chosen: &Choice,
        mut warnings: Vec<String>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ImplicitIdentification, SindyError> {
        let mut relations: Vec<Option<Relation>> = chosen
            .relations
            .iter()
            .map(|r| r.as_ref().map(in_order))
            .collect();
        let mut round = 0;
        let (linear, found) = loop {
            round += 1;
            let linear = self.linear(&relations, false)?;
            let found = self.last_fit(&linear, progress)?;
            let (next, moved) = self.read(&relations, &linear, &found);
            relations = next;
            if moved < SETTLED || round == ROUNDS {
                break (linear, found);
            }
        };
        let mut equations = Vec::new();
        let mut terms = Vec::new();
        for (i, relation) in relations.iter().enumerate() {
            let (equation, own) =
                self.equation(i, relation.as_ref(), linear[i].as_ref(), &found, chosen)?;
            equations.push(equation);
            terms.push(own);
        }
        let data = self.run.data;
        warnings.extend(found.warnings);
        warnings.dedup();
        warnings.extend(alternatives(&equations));
        warnings.extend(self.poles(&relations)?);
        Ok(ImplicitIdentification {
            model: Model::new(self.run.time, data.states(), data.inputs(), terms)?,
            reason: format!(
                "{} of {} relations follow the trajectories best; {}",
                relations.iter().flatten().count(),
                chosen.compared.iter().map(Vec::len).sum::<usize>(),
                found.choice.reason
            ),
            equations,
            outcome: found.outcome,
            inputs_between: found.inputs_between,
            data: found.data,
            warnings,
        })
    }

    /// The identification of equations that are linear at the relations.
    fn last_fit(
        &self,
        linear: &[Option<Linear>],
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        let mut run = self.run.clone();
        run.libraries = self.libraries(linear);
        run.system = self.system(&run.libraries)?;
        run.warnings.clear();
        let none = Vec::new();
        let coefficients = linear
            .iter()
            .map(|l| l.as_ref().map_or(&none, |l| &l.coefficients));
        let coefficients: Vec<Vec<f64>> = coefficients.cloned().collect();
        run.refine(self.slopes, &coefficients, progress)
    }

    /// The relations of a fit, and the largest change of a coefficient in standard errors.
    fn read(
        &self,
        relations: &[Option<Relation>],
        linear: &[Option<Linear>],
        found: &Identification,
    ) -> (Vec<Option<Relation>>, f64) {
        let mut moved: f64 = 0.0;
        let mut out = Vec::new();
        for (i, (relation, linear)) in relations.iter().zip(linear).enumerate() {
            let (Some(relation), Some(linear)) = (relation, linear) else {
                out.push(None);
                continue;
            };
            let mut coefficients = vec![0.0; linear.places.len()];
            for (j, term) in terms_of(found, i, linear) {
                coefficients[j] = term.coefficient;
            }
            for ((j, now), before) in coefficients.iter().enumerate().zip(&linear.coefficients) {
                let error = terms_of(found, i, linear)
                    .find(|t| t.0 == j)
                    .and_then(|t| t.1.std_error);
                moved = moved
                    .max((now - before).abs() / error.unwrap_or(now.abs()).max(f64::MIN_POSITIVE));
            }
            out.push(Some(relation.with(&linear.places, &coefficients)));
        }
        (out, moved)
    }

    /// An equation with its errors, and its terms in the model.
    fn equation(
        &self,
        i: usize,
        relation: Option<&Relation>,
        linear: Option<&Linear>,
        found: &Identification,
        chosen: &Choice,
    ) -> Result<(RationalEquation, Vec<Term>), SindyError> {
        let mut equation = RationalEquation {
            state: self.run.data.states()[i].clone(),
            numerator: Vec::new(),
            denominator: Vec::new(),
            noise: found.equations[i].noise,
            residual: found.equations[i].residual,
            compared: self.described(i, chosen),
        };
        let (Some(relation), Some(linear), Sought::Relation(of)) =
            (relation, linear, &self.sought[i])
        else {
            let known = found.model.equations()[i].clone();
            equation.numerator = known.iter().map(|t| of_term(t, None)).collect();
            equation.denominator.push(held(&Expr::constant(1.0)));
            return Ok((equation, known));
        };
        let candidates = &of.0;
        let below = relation.sides(candidates).1;
        equation.denominator.push(held(
            &candidates.denominator.terms()[relation.denominator[0].0],
        ));
        let fixed = self.run.libraries.len();
        let size = self.fitted(found, fixed);
        let intervals = &found.equations[i].intervals;
        let known = found.model.equations()[i].len() - terms_of(found, i, linear).count();
        let mut terms = Vec::new();
        for (k, (j, term)) in terms_of(found, i, linear).enumerate() {
            let interval = intervals.get(known + k).copied().flatten();
            let mut own = of_term(term, interval);
            // Chosen among all candidates, not among its own.
            let evidence = term
                .inclusion
                .map(|p| 2.0 * (p / (1.0 - p)).ln() - self.dearer(size));
            own.inclusion = evidence.map(|e| 1.0 / (1.0 + (-0.5 * e).exp()));
            let (to, expression) = match linear.places[j] {
                Place::Numerator(j) => (&mut equation.numerator, &candidates.numerator.terms()[j]),
                Place::Denominator(k) => (
                    &mut equation.denominator,
                    &candidates.denominator.terms()[k],
                ),
            };
            own.term = expression.to_string();
            own.expression = expression.clone();
            if matches!(linear.places[j], Place::Numerator(_)) {
                let over = match relation.is_explicit() {
                    true => expression.clone(),
                    false => readable(&(expression.clone() / below.clone()))?,
                };
                let mut model = Term::new(over, own.coefficient);
                (model.std_error, model.inclusion) = (own.std_error, own.inclusion);
                terms.push(model);
            }
            to.push(own);
        }
        Ok((equation, terms))
    }

    /// Coefficients of all equations that were fitted.
    fn fitted(&self, found: &Identification, equations: usize) -> usize {
        let all = found
            .model
            .equations()
            .iter()
            .take(equations)
            .zip(&self.run.libraries);
        let sizes = all.filter(|(_, (_, known))| !known.whole);
        sizes
            .map(|(terms, _)| terms.iter().filter(|t| t.inclusion.is_some()).count())
            .sum()
    }

    fn described(&self, i: usize, chosen: &Choice) -> Vec<ComparedRelation> {
        let Sought::Relation(of) = &self.sought[i] else {
            return Vec::new();
        };
        let state = &self.run.data.states()[i];
        let all = chosen.compared[i].iter();
        all.map(|c| c.described(state, &of.0, &chosen.compared[i][0]))
            .collect()
    }

    /// A warning for each denominator that vanishes in the box of the data.
    fn poles(&self, relations: &[Option<Relation>]) -> Result<Vec<String>, SindyError> {
        let names = self.run.data.names();
        let columns = |c: usize| {
            self.run
                .stretches
                .iter()
                .flat_map(move |s| s.columns[c].iter())
        };
        let bounds: Vec<(f64, f64)> = (0..names.len())
            .map(|c| {
                columns(c).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                    (a.min(*v), b.max(*v))
                })
            })
            .collect();
        let mut out = Vec::new();
        for (i, (relation, sought)) in relations.iter().zip(self.sought).enumerate() {
            let (Some(relation), Sought::Relation(of)) = (relation, sought) else {
                continue;
            };
            let below = Library::of(vec![relation.sides(&of.0).1]).compile(&names)?;
            let mut scratch = Scratch::new();
            let mut value = [0.0];
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..POINTS {
                let point: Vec<f64> = bounds
                    .iter()
                    .enumerate()
                    .map(|(c, (a, b))| a + (b - a) * halton(k, c))
                    .collect();
                below.eval_row(&point, &mut value, &mut scratch);
                (least, most) = (least.min(value[0]), most.max(value[0]));
            }
            if least <= 0.0 && most >= 0.0 {
                out.push(format!(
                    "equation of {}: the denominator vanishes within the ranges of the data, away from the trajectories: do not \
                     simulate there",
                    self.run.data.states()[i]
                ));
            }
        }
        Ok(out)
    }
}

/// A number of Halton's sequence: evenly spread points, with a prime for each column.
fn halton(mut k: usize, column: usize) -> f64 {
    let base = prime(column);
    let (mut out, mut part) = (0.0, 1.0);
    while k > 0 {
        part /= base as f64;
        out += part * (k % base) as f64;
        k /= base;
    }
    out
}

/// Terms in the order of the libraries, the denominator's first one held at 1.
fn in_order(relation: &Relation) -> Relation {
    let first = relation.denominator.iter().map(|t| t.0).min().unwrap_or(0);
    relation.held_at(first)
}

/// The terms of a fit that are candidates of equation `i`, with their places.
fn terms_of<'f>(
    found: &'f Identification,
    i: usize,
    linear: &'f Linear,
) -> impl Iterator<Item = (usize, &'f Term)> {
    let all = found.model.equations()[i]
        .iter()
        .filter(|t| t.inclusion.is_some());
    all.filter_map(|term| {
        let place = linear
            .library
            .terms()
            .iter()
            .position(|t| *t == term.expression)?;
        Some((place, term))
    })
}

fn of_term(term: &Term, interval: Option<[f64; 2]>) -> RationalTerm {
    RationalTerm {
        term: term.expression.to_string(),
        expression: term.expression.clone(),
        coefficient: term.coefficient,
        std_error: term.std_error,
        inclusion: term.inclusion,
        interval,
    }
}

/// The term of a denominator that is held at 1.
fn held(expression: &Expr) -> RationalTerm {
    of_term(&Term::new(expression.clone(), 1.0), None)
}

/// A relation as text, with four digits.
pub(super) fn equation(state: &str, relation: &Relation, of: &Candidates) -> String {
    let relation = in_order(relation);
    let terms = |terms: &[(usize, f64)], library: &Library| {
        let term =
            |&(j, c): &(usize, f64)| of_term(&Term::new(library.terms()[j].clone(), c), None);
        terms.iter().map(term).collect()
    };
    let equation = RationalEquation {
        state: state.to_owned(),
        numerator: terms(&relation.numerator, &of.numerator),
        denominator: terms(&relation.denominator, &of.denominator),
        noise: 0.0,
        residual: None,
        compared: Vec::new(),
    };
    format!("{equation:.4}")
}

/// A warning for each equation of which several relations are likely, or follow the data as well with at most one coefficient more.
fn alternatives(equations: &[RationalEquation]) -> Vec<String> {
    let warning = |equation: &RationalEquation| {
        let others = equation.compared.iter().skip(1);
        let others = others.filter(|c| c.against < TWENTY_TO_ONE || c.rival && c.worse < AS_WELL);
        let others: Vec<&str> = others.map(|c| c.equation.as_str()).collect();
        (!others.is_empty()).then(|| {
            format!(
                "equation of {}: the data do not distinguish it from {}",
                equation.state,
                others.join("; ")
            )
        })
    };
    equations.iter().filter_map(warning).collect()
}
