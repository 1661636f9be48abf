//! The automatic call: relations of all equations, the choice among them, and the model.

use super::choose::{Choice, choose};
use super::compare::{Comparison, Sought};
use super::nested::writes;
use super::relation::{Candidates, Relation};
use super::result::{ComparedRelation, ImplicitIdentification};
use super::rows::Rows;
use super::starts::{ScoredRelation, over_shared, relations};
use crate::data::dataset::Dataset;
use crate::error::{SindyError, require};
use crate::identify::prepare::{self, Slopes};
use crate::identify::proportional::without_multiples;
use crate::identify::run::IdentificationRun;
use crate::identify::{Identification, Identify, Progress, Settings, regress, warnings};
use crate::library::Library;

/// Denominators of an equation that the others are tried with, and denominators that several equations start with, at most.
pub(super) const SHARED: usize = 3;

/// The automatic identification of implicit equations.
#[derive(Clone, Debug)]
pub struct IdentifyImplicit {
    numerator: Library,
    denominator: Library,
    settings: Settings,
}

/// A relation of one equation and its score, the other equations being the best.
#[derive(Clone, Debug)]
pub(super) struct Compared {
    pub relation: Relation,
    pub score: f64,
    /// The score without its penalties.
    pub misfit: f64,
}

impl IdentifyImplicit {
    /// With the candidate terms of numerators and denominators, the same for all equations. The constant is always one of those
    /// of denominators.
    ///
    /// # Errors
    /// More than [`MAX_TERMS`](crate::library::MAX_TERMS) terms.
    pub fn new(numerator: Library, denominator: Library) -> Result<Self, SindyError> {
        let one = Library::parse(&["1"])?;
        Ok(Self {
            numerator,
            denominator: Library::sum(&[one, denominator])?,
            settings: Settings::default(),
        })
    }

    /// The same with other settings; those of discrete time and of unmeasured velocities are refused.
    ///
    /// # Errors
    /// A setting outside its range; discrete time, states of second order, signs, invariants, equations of which a part is known.
    pub fn settings(self, settings: Settings) -> Result<Self, SindyError> {
        settings.validate()?;
        let expected = "continuous time (implicit equations)";
        require(!settings.discrete, "discrete", expected, settings.discrete)?;
        let found = settings.second_order.join(", ");
        let expected = "none (implicit equations; measure or add velocities)";
        require(
            settings.second_order.is_empty(),
            "second_order",
            expected,
            found,
        )?;
        for (key, texts) in [
            ("signs", &settings.signs),
            ("conserve", &settings.conserve),
            ("constraints", &settings.constraints),
            ("diffusion", &settings.diffusion),
        ] {
            let expected = "none (implicit equations)";
            require(texts.is_empty(), key, expected, texts.join(", "))?;
        }
        let expected = "false (implicit equations)";
        require(!settings.stable, "stable", expected, true)?;
        Ok(Self { settings, ..self })
    }

    /// Identifies the equations of `data`; `progress` hears what is being done.
    ///
    /// # Errors
    /// Those of [`Identify::run`]; an equation of which only a part is known.
    pub fn run(
        &self,
        data: &Dataset,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ImplicitIdentification, SindyError> {
        let explicit = Identify::new(self.numerator.clone()).settings(self.settings.clone())?;
        let mut found = explicit.with_run(data, |run| self.identify(run, progress))?;
        found.data = data.report();
        Ok(found)
    }

    fn identify(
        &self,
        mut run: IdentificationRun<'_>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ImplicitIdentification, SindyError> {
        let partly = run
            .libraries
            .iter()
            .any(|(_, known)| !known.terms.is_empty() && !known.whole);
        let expected = "whole equations, such as x' = v (implicit equations)";
        require(!partly, "known", expected, "a part of one")?;
        let explicit = run.clone().go(progress)?;
        let denominator = without_multiples(
            self.denominator.clone(),
            run.data,
            &run.stretches,
            &mut run.warnings,
        )?;
        run.warnings.dedup();
        let mut smoothings = vec![slopes(&run, 1.0)?];
        if run.data.report().uniform {
            smoothings.push(slopes(&run, 2.0)?);
        }
        let mut sought: Vec<Sought> = Vec::new();
        let mut found: Vec<Vec<Relation>> = vec![Vec::new(); run.libraries.len()];
        for slopes in &smoothings {
            for (i, (library, known)) in run.libraries.iter().enumerate() {
                progress(Progress::Regression {
                    smoothing: format!("implicit relations of {}", run.data.states()[i]),
                });
                if known.whole {
                    sought.push(Sought::Known);
                    continue;
                }
                let candidates = Candidates {
                    numerator: library.clone(),
                    denominator: denominator.clone(),
                };
                let rows = Rows::new(&run, slopes, i, &candidates)?;
                merge(&mut found[i], relations(&rows, &candidates)?);
                sought.push(Sought::Relation(Box::new((candidates, rows))));
            }
        }
        // Signs of denominators are judged where less is smoothed.
        sought.truncate(run.libraries.len());
        add_shared(&mut found, &sought)?;
        let comparison = Comparison {
            run: &run,
            slopes: &smoothings[0],
            sought: &sought,
        };
        let ordinary = ordinary(&explicit, &sought);
        for (found, own) in found.iter_mut().zip(&ordinary) {
            let new = own
                .as_ref()
                .filter(|r| !found.iter().any(|f| f.support() == r.support()));
            found.extend(new.cloned());
        }
        let chosen = choose(&comparison, &found, &ordinary, progress)?;
        Self::conclude(&comparison, explicit, &chosen, progress)
    }

    /// The result for the relations that were chosen.
    fn conclude(
        comparison: &Comparison<'_, '_>,
        explicit: Identification,
        chosen: &Choice,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ImplicitIdentification, SindyError> {
        let run = comparison.run;
        let mut all = chosen.relations.iter().flatten();
        if all.all(Relation::is_explicit) {
            return comparison.explicit(explicit, chosen);
        }
        let slopes = comparison.slopes;
        let mut warnings = {
            let blocks = run.settings.folds;
            let statistics =
                regress::of_slopes(run.data, &run.stretches, &run.libraries, slopes, blocks)?;
            let samples = run.data.samples()?;
            warnings::of_data(&run.data.report(), &statistics, &run.libraries, &samples)?
        };
        warnings.splice(0..0, run.warnings.iter().cloned());
        comparison.rational(chosen, warnings, progress)
    }
}

/// Smoothed states and slopes, with `wider` windows.
fn slopes(run: &IdentificationRun<'_>, wider: f64) -> Result<Slopes, SindyError> {
    let n = run.data.states().len();
    if let Some(method) = run.settings.smoothing.differentiator()? {
        return prepare::with(&run.stretches, n, method);
    }
    let uniform = run.data.report().uniform;
    let filters = prepare::filters(&run.stretches, n, uniform, wider)?;
    prepare::by(filters.as_deref(), &run.stretches, n)
}

/// Adds relations with other terms.
fn merge(to: &mut Vec<Relation>, more: Vec<ScoredRelation>) {
    for one in more {
        if !to.iter().any(|r| r.support() == one.relation.support()) {
            to.push(one.relation);
        }
    }
}

/// Adds relations over the denominators of the other equations' best relations.
fn add_shared(found: &mut [Vec<Relation>], sought: &[Sought]) -> Result<(), SindyError> {
    let fractions = |own: &Vec<Relation>| -> Vec<Relation> {
        let all = own.iter().filter(|r| r.denominator.len() > 1);
        all.take(SHARED).cloned().collect()
    };
    let best: Vec<Vec<Relation>> = found.iter().map(fractions).collect();
    for (i, sought) in sought.iter().enumerate() {
        let Sought::Relation(of) = sought else {
            continue;
        };
        let others = best.iter().enumerate().filter(|(j, _)| *j != i);
        let others = others.flat_map(|(_, own)| own);
        merge(&mut found[i], over_shared(&of.1, &of.0, others)?);
    }
    Ok(())
}

/// The equations of an ordinary identification as relations.
fn ordinary(explicit: &Identification, sought: &[Sought]) -> Vec<Option<Relation>> {
    let pairs = explicit.model.equations().iter().zip(sought);
    pairs
        .map(|(terms, sought)| {
            let Sought::Relation(of) = sought else {
                return None;
            };
            let place = |term: &crate::model::Term| {
                let all = of.0.numerator.terms();
                Some((
                    all.iter().position(|t| *t == term.expression)?,
                    term.coefficient,
                ))
            };
            Some(Relation {
                numerator: terms.iter().filter_map(place).collect(),
                denominator: vec![(0, 1.0)],
            })
        })
        .collect()
}

impl Compared {
    /// For people, beside the best score.
    pub(super) fn described(
        &self,
        state: &str,
        candidates: &Candidates,
        best: &Self,
        grid: (&[String], &[Vec<f64>]),
    ) -> Result<ComparedRelation, SindyError> {
        let more = self.relation.free() as f64 - best.relation.free() as f64;
        let other = more <= 1.0 && !self.relation.contains(&best.relation);
        Ok(ComparedRelation {
            equation: super::report::equation(state, &self.relation, candidates),
            coefficients: self.relation.free(),
            against: self.score - best.score,
            worse: self.misfit - best.misfit,
            rival: other && !writes(&self.relation, &best.relation, candidates, grid)?,
        })
    }
}
