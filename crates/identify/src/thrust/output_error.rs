//! Forms with one lag, fitted by output error: eq. (7), the root of thrust behind a lag, and a lag on every motor's throttle.

use touchdown_model::card::{Card, Mark, Term};
use touchdown_model::{Form, Kind, unit};
use touchdown_trial::Trial;

use super::free_run::signal::Between;
use super::free_run::{
    Certainty, CommandRecord, Free, HeldOut, Output, Problem, Resolved, Shape, Solution,
    has_one_rate,
};
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, range, score, unconverged};
use crate::scores::Errors;
use crate::settings::{DeadTime, IdentificationSettings, ThrustForm};
use crate::warning::Warning;

/// The constant of a card that says whether its throttle is held between samples (1) or a straight line (0).
pub(super) const HELD: &str = "throttle_held";

/// A form with one lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LagForm {
    pub form: ThrustForm,
    pub degree: usize,
    pub battery: bool,
}

impl LagForm {
    /// Static curve and place of the lag.
    pub(super) fn shape(self) -> Shape {
        let (output, degree) = match self.form {
            ThrustForm::FirstOrder => (Output::Root, 1),
            ThrustForm::LaggedMotors => (Output::Thrust, self.degree),
            _ => (Output::Root, self.degree),
        };
        Shape {
            output,
            degree,
            battery: self.battery,
        }
    }

    fn records(self, trials: &[Trial]) -> Result<Vec<CommandRecord>> {
        CommandRecord::of(trials, self.form == ThrustForm::LaggedMotors, self.battery)
    }
}

/// What the throttle of records is between its samples.
pub(super) fn between(records: &[CommandRecord]) -> Between {
    Between::of(
        records
            .iter()
            .flat_map(|r| r.motors.iter().map(Vec::as_slice)),
    )
}

/// What held throttles are between their samples. A command that changes at any time is logged at the next sample: in the mean over
/// many changes its answer is that to a straight line from the sample before, in which the change took place. One that changes at
/// samples, be it at every one, is held, unless the evidence for lines is very strong: few rows after a change tell the two apart.
fn likelier<'a>(
    seen: Between,
    alone: Free,
    problem_of: impl Fn(Between) -> Problem<'a>,
) -> Between {
    if seen == Between::Linear {
        return seen;
    }
    let both = Free {
        dead_time: true,
        ..alone
    };
    let squares = |between| {
        let problem = problem_of(between);
        (problem.solve(both).squares, problem.len())
    };
    let ((held, rows), (lines, _)) = (squares(Between::Held), squares(Between::Linear));
    Between::likelier(held, lines, rows)
}

/// Refuses a lag in seconds from times that count rows.
pub(super) fn check_clock(trials: &[Trial]) -> Result<()> {
    match trials.iter().find(|t| counts_rows(t)) {
        None => Ok(()),
        Some(trial) => Err(Error::data(
            trial.name(),
            "times in seconds, which a lag needs (`time_s` of the map; static forms need none)",
            "times that count rows",
        )),
    }
}

/// Whether times are 0, 1, 2, … : the number of the row, not a clock.
pub(super) fn counts_rows(trial: &Trial) -> bool {
    let time = trial.time_s();
    time.first().is_some_and(|t| t.fract() == 0.0) && time.windows(2).all(|w| w[1] - w[0] == 1.0)
}

/// Residuals after steps over those on plateaus from which an answer is not that of one lag. Its interval takes in less than
/// that: errors of a log's clock and wandering noise stay below 2.
const MISFIT: f64 = 3.0;

/// A fit by output error.
pub(super) struct LagFit {
    form: LagForm,
    pub records: Vec<CommandRecord>,
    between: Between,
    /// What the card states.
    pub at: Solution,
    certainty: Certainty,
    /// Residuals after steps in units of those on plateaus, where there are both.
    misfit: Option<f64>,
    /// Its error on folds.
    pub held_out: HeldOut,
    rows: usize,
}

impl LagFit {
    /// Least squares in free run; the dead time stays only where it predicts held-out parts better.
    pub(super) fn new(
        trials: &[Trial],
        settings: &IdentificationSettings,
        form: LagForm,
    ) -> Result<Self> {
        check_clock(trials)?;
        let records = form.records(trials)?;
        let longest_lag_s = settings.thrust.max_lag_s;
        let alone = Free {
            lag: true,
            dead_time: false,
            starts: form.shape().output == Output::Root && records.len() <= 12,
        };
        let problem_of = |between| Problem::new(&records, form.shape(), between, longest_lag_s);
        let between = match form.form {
            // A flight controller holds the commands of single motors, however often they change.
            ThrustForm::LaggedMotors => Between::Held,
            _ => likelier(between(&records), alone, problem_of),
        };
        let problem = problem_of(between);
        let mut at = problem.solve(alone);
        let mut held_out = problem.held_out(&at, alone);
        let mut certainty = problem.certainty(&at, alone)?;
        if settings.thrust.dead_time != DeadTime::None {
            let both = Free {
                dead_time: true,
                ..alone
            };
            let with = problem.solve(both);
            let with_held_out = problem.held_out(&with, both);
            let with_certainty = problem.certainty(&with, both)?;
            if with.dead_time_s > 0.0 && with_held_out.rmse() < held_out.rmse() {
                (at, held_out, certainty) = (with, with_held_out, with_certainty);
            } else {
                // A dead time that is not taken is still not known to be zero: the lag's interval holds both cases.
                certainty.lag = joined(certainty.lag, with_certainty.lag);
                certainty.dead_time = None;
            }
        }
        if let Some(early) = certainty.early {
            certainty.lag = if early.within_period {
                joined(certainty.lag, Some(early.lag))
            } else {
                Some(Resolved::AtBound { value: at.lag_s })
            };
        }
        if between == Between::Linear && has_one_rate(&records) {
            certainty.lag = certainty.lag.map(bounded);
        }
        let rows = problem.len();
        let misfit = problem.misfit(&at);
        Ok(Self {
            form,
            between,
            at,
            certainty,
            misfit,
            held_out,
            rows,
            records,
        })
    }

    /// What the throttle is between its samples.
    pub(super) fn between(&self) -> Between {
        self.between
    }

    /// The dead time as far as it is resolved; none where it was not taken.
    pub(super) fn dead_time(&self) -> Option<Estimate> {
        match self.certainty.dead_time? {
            Resolved::Within(estimate) => Some(estimate),
            Resolved::Below { .. } | Resolved::AtBound { .. } => None,
        }
    }

    pub(super) fn card(&self, trials: &[Trial], origin: &Origin) -> Result<FittedCard> {
        let mut card = self.named(origin);
        card.terms = self.terms();
        card.constants.insert(
            HELD.into(),
            f64::from(u8::from(self.between == Between::Held)),
        );
        if self.form.form == ThrustForm::LaggedMotors {
            let motors = self.records.first().map_or(1, |r| r.motors.len());
            card.constants.insert("motors".into(), motors as f64);
        }
        let throttles = self.records.iter().flat_map(|r| r.motors.iter().flatten());
        if let Some(r) = range(throttles.copied()) {
            card.validity.inputs.insert("s".into(), r);
        }
        let volts = self.records.iter().filter_map(|r| r.battery.as_ref());
        if let Some(r) = range(volts.flatten().copied()) {
            card.validity.inputs.insert("u".into(), r);
        }
        card.validity.output = range(self.records.iter().flat_map(|r| r.thrust.iter().copied()));
        card.provenance.method = method(&[
            (
                "fit",
                "output error: least squares in free run over lag, dead time and static curve; intervals of lag and dead \
                 time by the profile of the likelihood, widened for correlated residuals"
                    .into(),
            ),
            ("outcome", self.outcome().into()),
            ("throttle between samples", self.words_between().into()),
        ]);
        let mut errors = Vec::new();
        for trial in trials {
            let predicted = super::predict(&card, trial)?;
            if let Some(e) = Errors::of(&known(&predicted, trial)?, trial.require("thrust_n")?) {
                card.scores
                    .push(score(trial.name(), true, "free_run", e, "N"));
                errors.push(e);
            }
        }
        let rmse = Errors::pool(&errors).map_or(f64::NAN, |e| e.rmse);
        let lag_s = match self.certainty.lag {
            Some(Resolved::Within(estimate)) if self.at.converged => Some(estimate.value),
            _ => None,
        };
        Ok(FittedCard {
            lag_s,
            warnings: self.warnings(),
            ..FittedCard::new(card, (rmse, "N"), self.rows)
        })
    }

    fn outcome(&self) -> &'static str {
        match self.at.converged {
            true => "Converged",
            false => "IterationLimit",
        }
    }

    fn words_between(&self) -> &'static str {
        match self.between {
            Between::Held => "held",
            Between::Linear => "straight lines",
        }
    }

    /// A card of the form, without terms.
    fn named(&self, origin: &Origin) -> Card {
        let (name, form, equation) = match (self.form.form, self.form.battery) {
            (ThrustForm::LaggedMotors, _) => (
                "thrust-lagged-motors",
                Form::LaggedMotors,
                "T = Σ_i (c0 + c1 u_i + c2 u_i^2 + …) [N], T_m u_i' = s_i - u_i, s_i throttle of motor i in [0, 1]",
            ),
            (ThrustForm::FirstOrder, false) => (
                "thrust-first-order",
                Form::FirstOrder,
                "x' = (c0 s + c1 - x)/T_m, x = √T [√N], s throttle in [0, 1]",
            ),
            _ => (
                "thrust-lagged-sqrt",
                Form::StaticSqrt,
                "x' = (x(s) - x)/T_m, x = √T [√N], s throttle in [0, 1]",
            ),
        };
        let mut card = origin.card(name, Kind::Thrust, form, equation);
        if self.form.battery {
            card.equation.push_str(match form {
                Form::LaggedMotors => ", battery_v battery voltage [V]",
                _ => ", u battery voltage [V]",
            });
        }
        card
    }

    fn terms(&self) -> Vec<Term> {
        let lag = self.certainty.lag.map(|r| resolved("T_m", r));
        let dead_time = match self.certainty.dead_time {
            Some(r) if self.at.dead_time_s > 0.0 => Some(resolved("dead_time", r)),
            _ => None,
        };
        let curve = self.curve();
        let mut terms: Vec<Term> = match self.form.form {
            ThrustForm::LaggedMotors => lag.into_iter().chain(curve).collect(),
            _ => curve.into_iter().chain(lag).collect(),
        };
        terms.extend(dead_time);
        if !self.at.converged {
            terms.iter_mut().for_each(unconverged);
        }
        terms
    }

    fn curve(&self) -> Vec<Term> {
        let estimates = &self.certainty.coefficients;
        if self.form.form == ThrustForm::FirstOrder && !self.form.battery {
            return vec![
                term("c0", "1", estimates[1], "√N"),
                term("c1", "1", estimates[0], "√N"),
            ];
        }
        let shape = self.form.shape();
        let (of, s, product) = match shape.output {
            Output::Thrust => ("T", "u", "u*battery_v"),
            Output::Root => ("x", "s", "s*u"),
        };
        let mut names: Vec<String> = (0..=shape.degree)
            .map(|k| match k {
                0 => "1".to_string(),
                1 => s.to_string(),
                _ => format!("{s}^{k}"),
            })
            .collect();
        if shape.battery {
            names.push(product.to_string());
        }
        names
            .iter()
            .zip(estimates)
            .map(|(name, e)| term(of, name, *e, &unit::of_coefficient(of, name)))
            .collect()
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut out = Vec::new();
        if !self.at.converged {
            out.push(Warning::NotConverged);
        }
        let early = self.certainty.early.filter(|early| !early.within_period);
        match (early, self.certainty.lag) {
            (Some(early), _) => out.push(Warning::AnswersEarly {
                early_s: early.early_s,
            }),
            (None, Some(Resolved::Below { bound, .. })) => {
                out.push(Warning::LagBelow { bound_s: bound });
            }
            (None, Some(Resolved::AtBound { value })) => {
                out.push(Warning::LagAtBound { lag_s: value });
            }
            (None, _) => {}
        }
        if let Some(ratio) = self.misfit.filter(|ratio| *ratio > MISFIT) {
            out.push(Warning::NotOneLag { ratio });
        }
        if let Some(Resolved::AtBound { value }) = self.certainty.dead_time {
            out.push(Warning::DeadTimeAtBound { dead_time_s: value });
        }
        out
    }
}

/// A prediction where the trial's inputs are known; gaps elsewhere count neither for nor against it.
fn known(predicted: &[f64], trial: &Trial) -> Result<Vec<f64>> {
    let measured = trial.require("thrust_n")?;
    let pairs = predicted.iter().zip(measured);
    Ok(pairs
        .map(|(p, m)| if p.is_nan() { *m } else { *p })
        .collect())
}

/// A lag whose dead time is either zero or free: the first one's value, and an interval that holds both.
fn joined(alone: Option<Resolved>, with: Option<Resolved>) -> Option<Resolved> {
    Some(match (alone?, with?) {
        (Resolved::Within(a), Resolved::Within(b)) => {
            let ci95 = [a.ci95[0].min(b.ci95[0]), a.ci95[1].max(b.ci95[1])];
            Resolved::Within(Estimate {
                value: a.value,
                std_error: a.std_error.max(b.std_error),
                ci95,
            })
        }
        (Resolved::AtBound { value }, _) => Resolved::AtBound { value },
        (Resolved::Within(a), Resolved::AtBound { .. }) => Resolved::Within(a),
        (Resolved::Within(a), Resolved::Below { bound, .. }) => Resolved::Below {
            value: a.value,
            bound: bound.max(a.ci95[1]),
        },
        (below, _) => below,
    })
}

/// A lag that may also be hysteresis: its upper bound.
fn bounded(lag: Resolved) -> Resolved {
    match lag {
        Resolved::Within(estimate) => Resolved::Below {
            value: estimate.value,
            bound: estimate.ci95[1],
        },
        other => other,
    }
}

/// A time as a card's term, marked where the data do not resolve it.
fn resolved(of: &str, found: Resolved) -> Term {
    match found {
        Resolved::Within(estimate) => term(of, "1", estimate, "s"),
        Resolved::Below { value, bound } => Term {
            mark: Some(Mark::UpperBound),
            upper_bound: Some(bound),
            ..term(of, "1", Estimate::bare(value), "s")
        },
        Resolved::AtBound { value } => Term {
            mark: Some(Mark::AtBound),
            ..term(of, "1", Estimate::bare(value), "s")
        },
    }
}
