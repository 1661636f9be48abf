//! The search: Gauss–Newton steps, each with a choice among all candidates.

use std::ops::ControlFlow;

use nalgebra::DVector;

use super::arcs::{Normal, linearise};
use super::choice::{Chosen, Linearised};
use super::colour::whitened;
use super::follow::{ArcSettings, Follow};
use super::multiples::multiples;
use super::noise::Trace;
use super::record::Record;
use super::system::System;
use super::{OutputErrorFit, Piece, Settings, Settled, Start, Step};
use crate::solve::outcome::Outcome;

/// By how much longer the next arcs are. Twofold growth takes twice as many stages to the same end.
const ARC_GROWTH: usize = 4;
/// Steps at one length of arcs, at most, but for the last. Intermediate lengths need no convergence.
const PATIENCE: usize = 6;
/// Change of a coefficient, in standard errors, below which a length of arcs is settled.
pub(super) const SETTLED: f64 = 0.1;
/// Change of a coefficient, in standard errors, below which the search is done: a tenth of what two printed digits of a
/// standard error show. Half of it takes a step more.
pub(super) const DONE: f64 = 0.01;
/// Samples of every state in the first arcs, at least: a start is found from two, and coefficients from the others.
const SAMPLES_OF_AN_ARC: usize = 4;
/// Weight of a defect against a residual when a step is judged: steps that close defects at the cost of residuals pass.
const DEFECT: f64 = 10.0;
/// A step may raise the sum of squares by this factor: closing defects costs.
pub(super) const WORSE: f64 = 1.5;
/// Steps shorter than this share of the whole are made whatever they do: after six halvings of the step.
pub(super) const SHORTEST: f64 = 0.02;
/// Standard deviations of a white autocorrelation, `1/√rows`, within which it counts as zero.
const SCATTERS: f64 = 2.0;
/// Lags of the autocorrelation are summed up to this share of the rows: longer ones have too few products.
const LONGEST_LAG: usize = 10;

/// Where the search stands.
struct State<'a> {
    system: &'a System,
    records: Vec<Record>,
    xi: DVector<f64>,
    sigma: Vec<f64>,
    colour: Vec<f64>,
    cut: ArcSettings,
}

/// The result of a step.
struct StepResult {
    chosen: Chosen,
    arcs: usize,
    /// Values compared of each measured state.
    samples: Vec<usize>,
    /// The share of the step that was made.
    part: f64,
}

/// Runs the search; `None` where no trajectory could be followed, or where `progress` ends it.
pub fn search(
    system: &System,
    pieces: &[Piece<'_>],
    start: &Start,
    settings: &Settings,
    progress: &mut dyn FnMut(Step<'_>) -> ControlFlow<()>,
) -> Option<OutputErrorFit> {
    let records: Vec<Record> = pieces.iter().map(Record::new).collect();
    let nodes = records.iter().map(|r| r.rows.len()).max()?;
    let nodes = nodes.min(settings.longest);
    let groups = &system.groups;
    let mut state = State {
        system,
        xi: DVector::from_column_slice(&start.coefficients),
        sigma: start.sigma.clone(),
        colour: start.colour.clone(),
        cut: ArcSettings {
            growth: settings.growth,
            longest: first_arc(&records, system, settings).min(nodes),
            substeps: 1,
        },
        records,
    };
    state.refine_steps();
    let mut outcome = Outcome::IterationLimit;
    let (mut iterations, mut at_length) = (0, 0);
    let mut breaks = None;
    let mut last = None;
    while iterations < settings.iterations {
        iterations += 1;
        at_length += 1;
        let normal = linearise(&state.follow(), &state.records, &mut breaks)?;
        let taken = state.step(&normal, groups, settings, at_length == 1, start)?;
        let settled = taken.chosen.same && taken.chosen.moved < SETTLED && taken.part == 1.0;
        let step = Step {
            step: iterations,
            terms: state.xi.iter().filter(|c| **c != 0.0).count(),
            sigma: &state.sigma,
            settled: settled.then(|| state.settled(&taken)),
        };
        if progress(step).is_break() {
            return None;
        }
        let done = settled && taken.chosen.moved < DONE;
        last = Some(taken);
        if state.cut.longest >= nodes {
            if done && !state.refine_steps() {
                outcome = Outcome::Converged;
                break;
            }
        } else if settled || at_length >= PATIENCE {
            state.refine_steps();
            // Where chaos has ended every arc, a longer limit cuts them as no limit does.
            state.cut.longest = match normal.reaches(state.cut.longest) {
                true => (state.cut.longest * ARC_GROWTH).min(nodes),
                false => nodes,
            };
            at_length = 0;
            breaks = None;
        }
    }
    Some(state.report(&last?, groups, start, (iterations, outcome)))
}

/// Nodes of the first arcs: as many as hold some samples of each state.
fn first_arc(records: &[Record], system: &System, settings: &Settings) -> usize {
    let sparse = records.iter().filter(|r| r.is_sparse());
    let nodes = sparse.map(|r| r.nodes_of(SAMPLES_OF_AN_ARC, system.measured));
    nodes.fold(settings.first_arc, usize::max)
}

impl State<'_> {
    fn follow(&self) -> Follow<'_> {
        Follow {
            system: self.system,
            coefficients: self.xi.as_slice(),
            sigma: &self.sigma,
            colour: &self.colour,
            cut: self.cut,
        }
    }

    fn settled(&self, taken: &StepResult) -> Settled {
        Settled {
            longest: self.cut.longest,
            coefficients: self.xi.iter().copied().collect(),
            std_errors: taken.chosen.std_errors(&self.xi),
        }
    }

    /// Halves the integrator's steps until its error is small beside the noise; whether there was need to.
    fn refine_steps(&mut self) -> bool {
        let before = self.cut.substeps;
        self.cut.substeps = self.follow().fine_substeps(&self.records);
        self.cut.substeps > before
    }

    /// Chooses terms in the linearisation, then steps there as far as the trajectories follow.
    fn step(
        &mut self,
        normal: &Normal,
        groups: &[Vec<usize>],
        settings: &Settings,
        anew: bool,
        start: &Start,
    ) -> Option<StepResult> {
        let values = normal.samples.iter().sum();
        let linearised = Linearised {
            xtx: &normal.xtx,
            xty: &normal.xty,
            yty: normal.yty,
            values,
            free: (normal.arcs() * self.system.n) as f64,
        };
        let chosen = linearised.choose(&self.xi, groups, (settings, start), anew);
        let (part, mut misfit) = self.move_by(normal, &chosen.change, values as f64)?;
        if part == 1.0 {
            let moved = self.xi.clone();
            chosen.clear(&mut self.xi);
            if self.xi != moved {
                (misfit, _) = self.follow().judge(&self.records, normal.cuts())?;
            }
            let all = self.sigma.iter_mut().zip(&misfit).zip(&start.floor);
            for (((s, m), floor), samples) in all.zip(&normal.samples) {
                *s = (m / *samples as f64).sqrt().max(*floor);
            }
        }
        Some(StepResult {
            chosen,
            arcs: normal.arcs(),
            samples: normal.samples.clone(),
            part,
        })
    }

    /// Moves coefficients and nodes by the step, halved until the trajectories are not much worse; returns the
    /// share that was made, and each state's misfit there.
    fn move_by(
        &mut self,
        normal: &Normal,
        change: &DVector<f64>,
        values: f64,
    ) -> Option<(f64, Vec<f64>)> {
        let merit = |sigma: &[f64], misfit: &[f64], defects: f64| {
            let sum: f64 = misfit.iter().zip(sigma).map(|(m, s)| m / s / s).sum();
            sum + DEFECT * defects
        };
        let before = merit(&self.sigma, &normal.misfit, normal.defects);
        let nodes: Vec<Vec<Vec<f64>>> = self.records.iter().map(|r| r.nodes.clone()).collect();
        let xi = self.xi.clone();
        let mut part = 1.0;
        loop {
            normal.move_nodes(&mut self.records, change, part);
            self.xi = &xi + change * part;
            let after = self.follow().judge(&self.records, normal.cuts());
            let good = after
                .as_ref()
                .is_some_and(|(m, d)| merit(&self.sigma, m, *d) < WORSE * before.max(values));
            if good || part < SHORTEST {
                return after.map(|(misfit, _)| (part, misfit));
            }
            for (record, nodes) in self.records.iter_mut().zip(&nodes) {
                record.nodes.clone_from(nodes);
            }
            part *= 0.5;
        }
    }

    fn report(
        &self,
        last: &StepResult,
        groups: &[Vec<usize>],
        start: &Start,
        (iterations, outcome): (usize, Outcome),
    ) -> OutputErrorFit {
        let values: usize = last.samples.iter().sum();
        let terms = self.xi.iter().filter(|c| **c != 0.0).count() as f64;
        let starts = (last.arcs * self.system.n) as f64 * (values as f64).ln();
        let noise = self.sigma.iter().zip(&last.samples);
        let noise: f64 = noise
            .map(|(s, samples)| *samples as f64 * 2.0 * s.ln())
            .sum();
        let chosen = &last.chosen;
        OutputErrorFit {
            coefficients: self.xi.iter().copied().collect(),
            std_errors: chosen.std_errors(&self.xi),
            covariance: chosen.covariance(&self.xi),
            evidence: chosen.evidence(),
            penalty: chosen.penalty(),
            fronts: chosen.fronts(groups),
            exchanges: chosen.exchanges(groups),
            multiples: match self.system.stiff {
                true => multiples(self.system, chosen, &self.xi, &start.term_rms),
                false => Vec::new(),
            },
            correlation: correlation(&whitened(
                &self.follow().residuals(&self.records),
                &self.colour,
            )),
            score: noise + terms * chosen.penalty() + starts,
            sigma: self.sigma.clone(),
            colour: self.colour.clone(),
            disturbance: None,
            arcs: last.arcs,
            values,
            iterations,
            outcome,
            trace: Trace {
                nodes: self.records.iter().map(|r| r.nodes.clone()).collect(),
                substeps: self.cut.substeps,
            },
        }
    }
}

/// Terms that contribute less than a share of the largest of their group: of their equation, or of all where candidates are joined.
pub(crate) fn irrelevant(
    coefficients: &DVector<f64>,
    term_rms: &[f64],
    groups: &[Vec<usize>],
    share: f64,
) -> Vec<usize> {
    let part = |j: usize| (coefficients[j] * term_rms[j]).abs();
    let mut out = Vec::new();
    for members in groups {
        let largest = members.iter().map(|&j| part(j)).fold(0.0, f64::max);
        out.extend(
            members
                .iter()
                .copied()
                .filter(|&j| coefficients[j] != 0.0 && part(j) < share * largest),
        );
    }
    out
}

/// `1 + 2 Σ_k ρ_k` up to the first autocorrelation that is within its scatter of zero.
pub(super) fn correlation(series: &[Vec<Vec<f64>>]) -> f64 {
    let states = series.first().map_or(0, Vec::len);
    let mut worst: f64 = 1.0;
    for i in 0..states {
        let product = |lag: usize| -> f64 {
            series
                .iter()
                .map(|s| {
                    s[i].iter()
                        .zip(&s[i][lag.min(s[i].len())..])
                        .map(|(a, b)| a * b)
                        .sum::<f64>()
                })
                .sum()
        };
        let rows: usize = series.iter().map(|s| s[i].len()).sum();
        let square = product(0);
        let scatter = SCATTERS / (rows as f64).sqrt();
        let mut sum = 1.0;
        for lag in 1..rows / LONGEST_LAG {
            let rho = product(lag) / square;
            if !(rho > scatter) {
                break;
            }
            sum += 2.0 * rho;
        }
        worst = worst.max(sum);
    }
    worst
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn analytic_correlation_of_an_autoregression() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut series = |of: f64| -> Vec<f64> {
            let mut x = 0.0;
            let step = |_| {
                x = of * x + rng.random_range(-1.0..1.0);
                x
            };
            (0..20_000).map(step).collect()
        };
        let (white, half, most) = (series(0.0), series(0.5), series(0.8));
        // 1 + 2 Σ φ^k = (1 + φ)/(1 - φ), up to where ρ is lost in its scatter of 0.014.
        for (of, truth) in [(&white, 1.0), (&half, 3.0), (&most, 9.0)] {
            let found = correlation(&[vec![of.clone()]]);
            assert!((found / truth - 1.0).abs() < 0.12, "{truth}: {found}");
        }
        // The largest over states; several records are not joined.
        let two = [vec![white.clone(), half.clone()], vec![half, white]];
        let found = correlation(&two);
        assert!((1.8..2.3).contains(&found), "{found}");
        assert_eq!(correlation(&[]), 1.0);
        let zigzag: Vec<f64> = (0..100).map(|i| f64::from(1 - 2 * (i % 2))).collect();
        assert_eq!(correlation(&[vec![zigzag]]), 1.0);
    }

    #[test]
    fn prop_steps_that_lead_astray_are_halved() {
        let library = crate::Library::parse(&["x"]).unwrap();
        let names = ["x".to_string()];
        let time = crate::model::Time::Continuous;
        let system = System::new(time, &names, &[], &[library]).unwrap();
        let time: Vec<f64> = (0..200).map(|i| 0.02 * f64::from(i)).collect();
        let x: Vec<f64> = time.iter().map(|t| (-t).exp()).collect();
        let piece = Piece {
            time: &time,
            states: vec![&x],
            inputs: vec![],
            between: vec![],
            weights: None,
            seen: Vec::new(),
            smooth: vec![x.clone()],
        };
        // x' = -x is right; a step to x' = 29 x is not, however the starts are moved with it.
        for (change, whole) in [(1e-4, true), (30.0, false)] {
            let mut state = State {
                system: &system,
                records: vec![Record::new(&piece)],
                xi: DVector::from_vec(vec![-1.0]),
                sigma: vec![1e-3],
                colour: Vec::new(),
                cut: ArcSettings {
                    growth: 1e3,
                    longest: usize::MAX,
                    substeps: 1,
                },
            };
            let normal = linearise(&state.follow(), &state.records, &mut None).unwrap();
            let step = DVector::from_vec(vec![change]);
            let (part, _) = state.move_by(&normal, &step, 200.0).unwrap();
            assert_eq!(part == 1.0, whole, "{change}: {part}");
            assert_eq!(state.xi[0], -1.0 + change * part);
        }
    }
}
