//! Implicit equations: rational right-hand sides from measured trajectories.
//!
//! ```text
//! x' = N(x, u)/D(x, u),    N = Σ_j ξ_j θ_j,    D = φ_0 + Σ_k η_k φ_k
//! ```
//!
//! as enzymes, switches, satiated predators and linked bodies have them. Its steps:
//!
//! 1. **Ordinary model.** [`Identify`](crate::Identify) on the candidates of numerators. It stays where no denominator is worth its
//!    terms.
//! 2. **Relations.** For each equation, under windows of the [weak form](crate::weak): best subsets of `Σ ξ_j θ_j = x' Σ η_k φ_k`
//!    with each `x' φ_k` in turn as the left side, and best subsets of numerators over denominators of one and two terms whose
//!    coefficients are tried on a grid. No slope of the data stands in the terms of the latter, so that noise biases them less.
//!    Factors that N and D share are cancelled. Then best subsets of numerators over the denominators of the other equations.
//! 3. **Trajectories.** With small changes of coefficients
//!
//!    ```text
//!    x' = Σ ξ_j θ_j/D - Σ η_k φ_k N/D²  +  (D - φ_0) N/D²
//!    ```
//!
//!    is linear in ξ and η, and [output error](crate::trajectory::output_error) fits it. At its solution D and N are taken anew,
//!    until coefficients move by less than a twentieth of a standard error: a fit of N/D with the exact likelihood. All relations of
//!    an equation, the others being the best, then those with one term exchanged or one more than the best, and all candidates at
//!    the best, are compared by the extended Bayesian criterion.
//! 4. **Result.** The best is fitted once more on all rows, with the tests, the handling of noise that is not white and the
//!    warnings of [`identify`](crate::identify). The first term of each denominator has the coefficient 1.
//!
//! **Warnings** name relations with odds below 20 to 1 against them, those that follow the data as well (a likelihood ratio below
//! 100) with at most one coefficient more and are not the same right side with a factor that N and D share, models that leave
//! more than ten times what neighbouring samples show where no noise is visible, denominators that vanish within the ranges of
//! the data, and models that leave more than the noise. A denominator that changes its sign on the trajectories is refused. Relations that no step has tried cannot be named:
//! with noise of several percent on short relaxations simpler relations fit as well, and the right one may not be among them.
//!
//! **Valid** for continuous time with all states measured. Equations may be [known](crate::identify::Settings::known) as a whole.
//!
//! ```
//! use sindy::implicit::IdentifyImplicit;
//! use sindy::model::{Inputs, Model, Simulation, Term, Time};
//! use sindy::{Dataset, Library};
//!
//! // An enzyme with a supply, by Michaelis and Menten.
//! let law = vec![vec![Term::parse("0.6 - 1.5*x/(0.3 + x)", 1.0)?]];
//! let model = Model::new(Time::Continuous, &["x"], &[], law)?;
//! let time: Vec<f64> = (0..200).map(|k| 0.03 * f64::from(k)).collect();
//! let mut data = Dataset::new(&["x"], &[])?;
//! for start in [1.5, 0.02] {
//!     let run = model.simulate(&[start], &time, &Inputs::none(), &Simulation::adaptive())?;
//!     data.push("run", run.time, run.states, None)?;
//! }
//! let (above, below) = (Library::polynomial(&["x"], 3)?, Library::polynomial(&["x"], 2)?);
//! let found = IdentifyImplicit::new(above, below)?.run(&data, &mut |_| ())?;
//! assert_eq!(format!("{:.3}", found.equations[0]), "x' = (0.600 - 3.00*x)/(1 + 3.33*x)");
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: K. Kaheman, J. N. Kutz, S. L. Brunton, "SINDy-PI: a robust algorithm for parallel implicit sparse identification of
//! nonlinear dynamics", Proceedings of the Royal Society A 476 (2020); N. M. Mangan, S. L. Brunton, J. L. Proctor, J. N. Kutz,
//! "Inferring biological networks by sparse identification of nonlinear dynamics", IEEE Transactions on Molecular, Biological and
//! Multi-Scale Communications 2 (2016); H. G. Bock, "Recent advances in parameter identification techniques for ODE" (1983).

mod choose;
mod compare;
mod doubts;
mod nested;
mod relation;
mod report;
mod result;
mod rows;
mod run;
mod starts;
#[cfg(test)]
mod tests;

pub use result::{ComparedRelation, ImplicitIdentification, RationalEquation, RationalTerm};
pub use run::IdentifyImplicit;
