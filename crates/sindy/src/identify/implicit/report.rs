//! From chosen relations to the result: standard errors, model, warnings.

use super::choose::Choice;
use super::compare::{Comparison, NEAR, Sought};
use super::doubts::{alternatives, points};
use super::relation::{Candidates, Linear, Place, Relation, readable};
use super::result::{ComparedRelation, ImplicitIdentification, RationalEquation, RationalTerm};
use crate::error::SindyError;
use crate::identify::{Identification, Progress};
use crate::library::Library;
use crate::model::{Model, Term};
use sindy_expr::Expr;

/// Rounds of the last fit, at most: relations come from a fit, so that one is the rule.
const ROUNDS: usize = 4;
/// Change of a coefficient in standard errors below which the last fit has settled.
const SETTLED: f64 = 0.05;
/// Points at which right sides are compared: some ten for each of their coefficients.
const COMPARED: usize = 200;

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
                compared: self.described(i, chosen)?,
            });
        }
        let mut warnings = found.warnings;
        warnings.extend(self.approximations(&equations));
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
        let (linear, found, moved) = loop {
            round += 1;
            let linear = self.linear(&relations, false)?;
            let found = self.last_fit(&linear, progress)?;
            let (next, moved) = self.read(&relations, &linear, &found);
            relations = next;
            if moved < SETTLED || round == ROUNDS {
                break (linear, found, moved);
            }
        };
        if moved > NEAR {
            warnings.push(format!(
                "coefficients have not settled: the last step moved one by {moved:.1} standard errors. The printed equations may not \
                 follow the data as the fit did"
            ));
        }
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
        warnings.extend(self.approximations(&equations));
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
            compared: self.described(i, chosen)?,
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
        if equation.numerator.is_empty() {
            equation.denominator = vec![held(&Expr::constant(1.0))];
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

    fn described(&self, i: usize, chosen: &Choice) -> Result<Vec<ComparedRelation>, SindyError> {
        let Sought::Relation(of) = &self.sought[i] else {
            return Ok(Vec::new());
        };
        let state = &self.run.data.states()[i];
        let (names, all) = (self.run.data.names(), &chosen.compared[i]);
        // Wider than the data: columns that hardly move would make all terms alike.
        let wider = |(a, b): (f64, f64)| {
            let by = 0.5 * (a.abs() + b.abs());
            (a - by, b + by)
        };
        let grid = points(
            &self.ranges().into_iter().map(wider).collect::<Vec<_>>(),
            COMPARED,
        );
        all.iter()
            .map(|c| c.described(state, &of.0, &all[0], (&names, &grid)))
            .collect()
    }
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
