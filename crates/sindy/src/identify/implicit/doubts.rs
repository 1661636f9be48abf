//! What qualifies implicit equations: other relations, approximations, denominators that vanish.

use sindy_expr::Scratch;

use super::compare::{Comparison, Sought};
use super::relation::Relation;
use super::result::RationalEquation;
use crate::error::SindyError;
use crate::identify::ratio;
use crate::library::Library;
use crate::numerics::prime;
use crate::statistics::criteria::TWENTY_TO_ONE;

/// Twice the logarithm of a likelihood ratio of a hundred: rivals with at most one coefficient more are reported below it.
const AS_WELL: f64 = 9.21;
/// Points of the box of the data at which denominators are looked at.
const POINTS: usize = 2000;
/// A residual of data without visible noise above this multiple of what neighbouring samples show is an approximation: integrators
/// of the data at relative tolerances of 1e-6 and less leave some times as much, rational functions in place of a root or an
/// exponential 40 to 100 times.
const APPROXIMATE: f64 = 10.0;

impl Comparison<'_, '_> {
    /// The least and the greatest value of each column.
    pub(super) fn ranges(&self) -> Vec<(f64, f64)> {
        let all = |c: usize| {
            let stretches = self.run.stretches.iter();
            stretches.flat_map(move |s| s.columns[c].iter())
        };
        (0..self.run.data.names().len())
            .map(|c| {
                all(c).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                    (a.min(*v), b.max(*v))
                })
            })
            .collect()
    }

    /// A warning for each state without visible noise of which the model leaves much more than its neighbouring samples show.
    pub(super) fn approximations(&self, equations: &[RationalEquation]) -> Vec<String> {
        let noise = &self.run.noise;
        let all = equations
            .iter()
            .zip(noise.sigma.iter().zip(&noise.tolerated));
        all.filter_map(|(equation, (sigma, tolerated))| {
            let left = equation.residual?;
            (sigma < tolerated && left > APPROXIMATE * sigma).then(|| {
                format!(
                    "the data of {} show no noise, but the model leaves {left:.2e}, {} times what neighbouring samples show: it may \
                     approximate a right side that is not in the library",
                    equation.state,
                    ratio(left / sigma)
                )
            })
        })
        .collect()
    }

    /// A warning for each denominator that vanishes in the box of the data.
    pub(super) fn poles(&self, relations: &[Option<Relation>]) -> Result<Vec<String>, SindyError> {
        let names = self.run.data.names();
        let points = points(&self.ranges(), POINTS);
        let mut out = Vec::new();
        for (i, (relation, sought)) in relations.iter().zip(self.sought).enumerate() {
            let (Some(relation), Sought::Relation(of)) = (relation, sought) else {
                continue;
            };
            let below = Library::of(vec![relation.sides(&of.0).1]).compile(&names)?;
            let mut scratch = Scratch::new();
            let mut value = [0.0];
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for point in &points {
                below.eval_row(point, &mut value, &mut scratch);
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

/// Evenly spread points of a box.
pub(super) fn points(ranges: &[(f64, f64)], number: usize) -> Vec<Vec<f64>> {
    let point = |k: usize| {
        let all = ranges.iter().enumerate();
        all.map(|(c, (a, b))| a + (b - a) * halton(k, c)).collect()
    };
    (0..number).map(point).collect()
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

/// A warning for each equation of which several relations are likely, or follow the data as well with at most one coefficient more.
pub(super) fn alternatives(equations: &[RationalEquation]) -> Vec<String> {
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
