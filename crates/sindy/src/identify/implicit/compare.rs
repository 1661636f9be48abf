//! Relations compared by the trajectories that follow from them.

use super::relation::{Candidates, Linear, Relation};
use super::rows::Rows;
use crate::error::SindyError;
use crate::identify::known::KnownPart;
use crate::identify::prepare::{self, Slopes};
use crate::identify::rank::RANKED;
use crate::identify::run::IdentificationRun;
use crate::library::Library;
use crate::trajectory::output_error::{self, OutputErrorFit, Start, System};

/// Rounds between the coefficients and the terms that are linear at them, at most. Three suffice where slopes gave a start.
const ROUNDS: usize = 8;
/// Change of a coefficient in standard errors below which rounds end.
const SETTLED: f64 = 0.05;
/// Change of a coefficient in standard errors beyond which the last round is no fit of N/D: what was followed is a sum of terms
/// that are linear at the relation before, which follows the data better than the relation itself.
pub(super) const NEAR: f64 = 1.0;
/// A score that is worse than the least by more will not become the best: a second round changes true relations by less.
const HOPELESS: f64 = 300.0;
/// Steps of a fit that compares: enough for arcs of all lengths.
const ITERATIONS: usize = 30;
/// Halvings of a change that takes the denominator through zero.
const HALVINGS: usize = 6;

/// What is looked for in one equation.
pub(super) enum Sought {
    /// The whole equation is known.
    Known,
    /// A relation of these candidates, with their values on rows.
    Relation(Box<(Candidates, Rows)>),
}

/// Which terms a fit keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Terms {
    /// Those that are worth their penalty.
    Worthwhile,
    /// All, for the odds of a relation that is larger than it has to be.
    All,
}

/// The comparison of relations.
pub(super) struct Comparison<'a, 'd> {
    pub run: &'a IdentificationRun<'d>,
    pub slopes: &'a Slopes,
    /// By equation.
    pub sought: &'a [Sought],
}

/// One relation for each equation, as trajectories judge them.
#[derive(Clone, Debug)]
pub(super) struct Followed {
    /// By equation; `None` where it is known.
    pub relations: Vec<Option<Relation>>,
    /// Smaller is better: twice the negative logarithm of the likelihood, and a penalty for each coefficient.
    pub score: f64,
    /// The same without the penalty.
    pub misfit: f64,
}

impl<'d> Comparison<'_, 'd> {
    /// Coefficients of all candidates in all equations.
    pub(super) fn size(&self) -> usize {
        let all = self.sought.iter();
        all.map(|s| match s {
            Sought::Known => 0,
            Sought::Relation(of) => of.0.len(),
        })
        .sum()
    }

    /// Penalty of a coefficient that was chosen among all candidates, over that of one of `own` candidates.
    pub(super) fn dearer(&self, own: usize) -> f64 {
        2.0 * (self.size() as f64 / own.max(1) as f64).ln()
    }

    /// All equations to first order.
    pub(super) fn linear(
        &self,
        relations: &[Option<Relation>],
        all: bool,
    ) -> Result<Vec<Option<Linear>>, SindyError> {
        let pairs = relations.iter().zip(self.sought);
        pairs
            .map(|(relation, sought)| match (relation, sought) {
                (Some(relation), Sought::Relation(of)) => Ok(Some(relation.linear(&of.0, all)?)),
                _ => Ok(None),
            })
            .collect()
    }

    /// Libraries and known parts of equations that are linear at the relations.
    pub(super) fn libraries(&self, linear: &[Option<Linear>]) -> Vec<(Library, KnownPart)> {
        let pairs = linear.iter().zip(&self.run.libraries);
        pairs
            .map(|(linear, (library, known))| match linear {
                Some(linear) => (linear.library.clone(), linear.known.clone()),
                None => (library.clone(), known.clone()),
            })
            .collect()
    }

    pub(super) fn system(&self, libraries: &[(Library, KnownPart)]) -> Result<System, SindyError> {
        let data = self.run.data;
        let own: Vec<Library> = libraries.iter().map(|l| l.0.clone()).collect();
        let known: Vec<_> = libraries.iter().map(|l| l.1.terms.clone()).collect();
        let states = (data.states(), data.states().len());
        let system = System::with_known(self.run.time, states, data.inputs(), &own, &known)?;
        Ok(system.stiff(self.run.system.is_stiff()))
    }

    /// The relations with the coefficients and terms that trajectories give them; `None` where they cannot be followed, or where
    /// rounds do not settle. Relations
    /// far from the `least` score are not followed to the end.
    pub(super) fn follow(
        &self,
        relations: &[Option<Relation>],
        least: f64,
        terms: Terms,
    ) -> Result<Option<Followed>, SindyError> {
        let mut at = self.held_at_largest(relations);
        let mut best: Option<Followed> = None;
        let mut moved = f64::INFINITY;
        for _ in 0..ROUNDS {
            let linear = self.linear(&at, false)?;
            let Some(fit) = self.fit(&at, &linear, terms)? else {
                break;
            };
            let count = fit.coefficients.iter().filter(|c| **c != 0.0).count();
            let dearer = self.dearer(fit.coefficients.len());
            let Some(next) = self.moved(&at, &linear, &fit.coefficients) else {
                break;
            };
            let before: Vec<f64> = linear
                .iter()
                .flatten()
                .flat_map(|l| l.coefficients.clone())
                .collect();
            let all = fit.coefficients.iter().zip(&before).zip(&fit.std_errors);
            moved = all
                .map(|((now, before), error)| (now - before).abs() / error.max(f64::MIN_POSITIVE))
                .fold(0.0, f64::max);
            let score = fit.score + count as f64 * dearer;
            best = Some(Followed {
                score,
                misfit: fit.score - count as f64 * fit.penalty,
                relations: next.clone(),
            });
            at = self.held_at_largest(&next);
            if score > least + HOPELESS {
                moved = 0.0;
            }
            if moved < SETTLED {
                break;
            }
        }
        Ok(best.filter(|_| moved < NEAR).map(|best| self.reduced(best)))
    }

    /// Without factors that numerators and denominators share.
    fn reduced(&self, mut followed: Followed) -> Followed {
        for (relation, sought) in followed.relations.iter_mut().zip(self.sought) {
            if let (Some(relation), Sought::Relation(of)) = (relation, sought) {
                *relation = relation.reduced(&of.0);
            }
        }
        followed
    }

    fn held_at_largest(&self, relations: &[Option<Relation>]) -> Vec<Option<Relation>> {
        let pairs = relations.iter().zip(self.sought);
        pairs
            .map(|(relation, sought)| match (relation, sought) {
                (Some(relation), Sought::Relation(of)) => Some(of.1.held_at_largest(relation)),
                _ => None,
            })
            .collect()
    }

    /// The fit of relations that are linear, on rows that are enough for a comparison.
    pub(super) fn fit(
        &self,
        at: &[Option<Relation>],
        linear: &[Option<Linear>],
        terms: Terms,
    ) -> Result<Option<OutputErrorFit>, SindyError> {
        let run = self.run;
        let system = self.system(&self.libraries(linear))?;
        let rows = run.settings.rows.min(RANKED);
        let states = run.data.states().len();
        let between = &run.inputs.between;
        let pieces = prepare::pieces(&run.stretches, states, self.slopes, between, rows);
        let own: Vec<&Linear> = linear.iter().flatten().collect();
        let size = own.iter().map(|l| l.coefficients.len()).sum::<usize>();
        if size == 0 {
            return Ok(None);
        }
        let values = pieces.iter().map(|p| p.time.len()).sum::<usize>() * states;
        let unit = (values as f64).ln() + 2.0 * (size as f64).ln();
        let start = Start {
            coefficients: own.iter().flat_map(|l| l.coefficients.clone()).collect(),
            sigma: run.noise.sigma.clone(),
            floor: run.noise.floor.clone(),
            chosen_from: size,
            term_rms: self.term_rms(at, linear),
            colour: Vec::new(),
            signs: Vec::new(),
        };
        let limits = output_error::Settings {
            growth: run.settings.growth,
            iterations: run.settings.iterations.min(ITERATIONS),
            penalty: match terms {
                Terms::Worthwhile => run.settings.penalty * (1.0 + self.dearer(size) / unit),
                Terms::All => 0.0,
            },
            longest: usize::MAX,
            first_arc: output_error::FIRST_ARC,
            relevance: run.settings.relevance,
        };
        Ok(output_error::search(
            &system,
            &pieces,
            &start,
            &limits,
            &mut output_error::silent,
        ))
    }

    /// Root mean square of every linear term.
    fn term_rms(&self, at: &[Option<Relation>], linear: &[Option<Linear>]) -> Vec<f64> {
        let all = at.iter().zip(linear).zip(self.sought);
        all.flat_map(|((at, linear), sought)| match (at, linear, sought) {
            (Some(at), Some(linear), Sought::Relation(of)) => of.1.term_rms(at, &linear.places),
            _ => Vec::new(),
        })
        .collect()
    }

    /// The relations with the coefficients of a linear fit, or as near to them as denominators keep their signs.
    pub(super) fn moved(
        &self,
        at: &[Option<Relation>],
        linear: &[Option<Linear>],
        coefficients: &[f64],
    ) -> Option<Vec<Option<Relation>>> {
        let mut from = 0;
        let mut out = Vec::new();
        for ((at, linear), sought) in at.iter().zip(linear).zip(self.sought) {
            let (Some(at), Some(linear), Sought::Relation(of)) = (at, linear, sought) else {
                out.push(None);
                continue;
            };
            let own = &coefficients[from..from + linear.places.len()];
            from += own.len();
            let to = at.with(&linear.places, own);
            let mut part = 1.0;
            let mut next = None;
            for _ in 0..HALVINGS {
                let tried = at.towards(&to, part);
                if of.1.is_regular(&tried) {
                    next = Some(tried);
                    break;
                }
                part *= 0.5;
            }
            out.push(Some(next?));
        }
        Some(out)
    }
}
