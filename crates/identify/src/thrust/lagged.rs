//! A first-order lag on every motor's own command, then a polynomial for each motor's thrust, summed:
//! `T = Σ_i (c0 + c1 u_i + c2 u_i²)`, `u_i = lag(s_i; T_m)`.

use sindy::statistics::regression::{Clusters, cluster_errors, least_squares};
use sindy::trajectory::delay::first_order_lag;
use sindy::{Gram, Library, Samples};
use touchdown_model::card::{Card, Term};
use touchdown_model::{Form, Kind};
use touchdown_trial::Trial;

use super::search::minimise;
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, range, score};
use crate::scores::Errors;
use crate::settings::ThrustSettings;
use crate::unit;
use crate::warning::Warning;

/// Groups that a record is split into for standard errors.
/// Student's t is 2.09 then, and stretches are still many lags long.
const PIECES: usize = 20;
/// Shortest lag that is searched for (s).
/// Below the sampling of any log.
const SHORTEST_S: f64 = 1e-3;

/// A trial's rows without gaps in the throttles.
struct MotorRecord {
    time: Vec<f64>,
    motors: Vec<Vec<f64>>,
    thrust: Vec<f64>,
}

impl MotorRecord {
    fn of(trial: &Trial) -> Result<Self> {
        let motors = super::motors(trial)?;
        let thrust = trial.require("thrust_n")?;
        let keep: Vec<usize> = (0..trial.len())
            .filter(|&i| motors.iter().all(|m| m[i].is_finite()))
            .collect();
        if keep.len() < 2 * PIECES {
            return Err(Error::data(
                trial.name(),
                format!("at least {} rows with a throttle", 2 * PIECES),
                keep.len().to_string(),
            ));
        }
        super::check_moves(trial.name(), motors.iter().copied())?;
        let pick = |c: &[f64]| keep.iter().map(|&i| c[i]).collect::<Vec<_>>();
        Ok(Self {
            time: pick(trial.time_s()),
            motors: motors.iter().map(|m| pick(m)).collect(),
            thrust: pick(thrust),
        })
    }

    /// `Σ_i u_i^k` for k = 0..=degree, one column each.
    fn powers(&self, lag_s: f64, degree: usize) -> Vec<Vec<f64>> {
        let n = self.time.len();
        let mut out = vec![vec![0.0; n]; degree + 1];
        for motor in &self.motors {
            let u = first_order_lag(&self.time, motor, lag_s, 0.0);
            for i in 0..n {
                let mut power = 1.0;
                for column in &mut out {
                    column[i] += power;
                    power *= u[i];
                }
            }
        }
        out
    }
}

fn names(degree: usize) -> Vec<String> {
    (0..=degree).map(|k| format!("p{k}")).collect()
}

fn gram(records: &[MotorRecord], lag_s: f64, degree: usize) -> Result<Gram> {
    let names = names(degree);
    let mut all: Vec<&str> = names.iter().map(String::as_str).collect();
    all.push("y");
    let mut samples = Samples::new(&all);
    for r in records {
        let mut columns = r.powers(lag_s, degree);
        columns.push(r.thrust.clone());
        samples.push_group(columns)?;
    }
    Ok(Gram::total(&Gram::accumulate(
        &Library::parse(&names)?,
        "y",
        &samples,
    )?))
}

/// The lag of the motors and the polynomial of their thrust, fitted to records.
pub(super) struct LaggedMotors {
    records: Vec<MotorRecord>,
    lag_s: f64,
    lag_error_s: f64,
    /// Coefficients of `1`, `u`, `u^2`, …
    coefficients: Vec<f64>,
    std_errors: Vec<f64>,
    rows: usize,
}

impl LaggedMotors {
    /// Least squares in free run over the lag and the polynomial.
    pub(super) fn fit(trials: &[Trial], settings: &ThrustSettings) -> Result<Self> {
        let records: Vec<MotorRecord> =
            trials.iter().map(MotorRecord::of).collect::<Result<_>>()?;
        let degree = settings.degree;
        let all = vec![true; degree + 1];
        let cost = |lag_s: f64| {
            gram(&records, lag_s, degree)
                .map_or(f64::INFINITY, |g| g.residual_sum(&least_squares(&g, &all)))
        };
        let lag_s = minimise(SHORTEST_S, settings.max_lag_s, cost);
        let total = gram(&records, lag_s, degree)?;
        let coefficients = least_squares(&total, &all).as_slice().to_vec();
        let (lag_error_s, std_errors) = standard_errors(&records, lag_s, &coefficients)?;
        Ok(Self {
            records,
            lag_s,
            lag_error_s,
            coefficients,
            std_errors,
            rows: total.rows,
        })
    }

    pub(super) fn card(
        &self,
        trials: &[Trial],
        settings: &ThrustSettings,
        origin: &Origin,
    ) -> FittedCard {
        let mut card = origin.card(
            "thrust-lagged-motors",
            Kind::Thrust,
            Form::LaggedMotors,
            "T = Σ_i (c0 + c1 u_i + c2 u_i^2 + …) [N], T_m u_i' = s_i - u_i, s_i throttle of motor i in [0, 1]",
        );
        let motors = self.records.first().map_or(0, |r| r.motors.len());
        card.constants.insert("motors".into(), motors as f64);
        card.terms.extend(self.terms());
        let throttles = self.records.iter().flat_map(|r| r.motors.iter().flatten());
        if let Some(r) = range(throttles.copied()) {
            card.validity.inputs.insert("s".into(), r);
        }
        card.validity.output = range(self.records.iter().flat_map(|r| r.thrust.iter().copied()));
        let mut errors = Vec::new();
        for (trial, r) in trials.iter().zip(&self.records) {
            let predicted = evaluate(r, self.lag_s, &self.coefficients);
            if let Some(e) = Errors::of(&predicted, &r.thrust) {
                card.scores
                    .push(score(trial.name(), true, "free_run", e, "N"));
                errors.push(e);
            }
        }
        let fit = format!(
            "least squares in free run over the lag and the polynomial; standard errors over {PIECES} stretches a log"
        );
        card.provenance.method = method(&[("fit", fit)]);
        let rmse = Errors::pool(&errors).map_or(f64::NAN, |e| e.rmse);
        let at_bound = self.lag_s > 0.99 * settings.max_lag_s || self.lag_s < 1.01 * SHORTEST_S;
        let lag_s = self.lag_s;
        FittedCard {
            lag_s: Some(lag_s),
            warnings: Vec::from_iter(at_bound.then_some(Warning::LagAtBound { lag_s })),
            ..FittedCard::new(card, (rmse, "N"), self.rows)
        }
    }

    /// Lag and coefficients as terms of a card.
    fn terms(&self) -> Vec<Term> {
        let clusters = Clusters {
            groups: PIECES * self.records.len(),
            coefficients: self.coefficients.len() + 1,
        };
        let lag = Estimate::clustered(self.lag_s, self.lag_error_s, clusters);
        let mut terms = vec![term("T_m", "1", lag, "s")];
        let coefficients = self.coefficients.iter().zip(&self.std_errors);
        terms.extend(coefficients.enumerate().map(|(k, (&value, &error))| {
            let (expression, estimate) = (power(k), Estimate::clustered(value, error, clusters));
            let unit = unit::of_coefficient("T", &expression);
            term("T", &expression, estimate, &unit)
        }));
        terms
    }
}

fn evaluate(record: &MotorRecord, lag_s: f64, xi: &[f64]) -> Vec<f64> {
    let powers = record.powers(lag_s, xi.len() - 1);
    (0..record.time.len())
        .map(|i| powers.iter().zip(xi).map(|(p, c)| p[i] * c).sum())
        .collect()
}

/// Standard errors of the lag and of the coefficients, from the linearised fit, over stretches of the logs.
fn standard_errors(records: &[MotorRecord], lag_s: f64, xi: &[f64]) -> Result<(f64, Vec<f64>)> {
    let degree = xi.len() - 1;
    let mut terms = names(degree);
    terms.push("by_lag".into());
    let mut all: Vec<&str> = terms.iter().map(String::as_str).collect();
    all.push("y");
    let mut samples = Samples::new(&all);
    let step = 0.01 * lag_s;
    for r in records {
        let mut columns = r.powers(lag_s, degree);
        let (more, less) = (evaluate(r, lag_s + step, xi), evaluate(r, lag_s - step, xi));
        columns.push(
            more.iter()
                .zip(&less)
                .map(|(a, b)| (a - b) / (2.0 * step))
                .collect(),
        );
        columns.push(r.thrust.clone());
        for span in super::pieces(r.time.len(), PIECES) {
            samples.push_group(columns.iter().map(|c| c[span.clone()].to_vec()).collect())?;
        }
    }
    let grams = Gram::accumulate(&Library::parse(&terms)?, "y", &samples)?;
    let mut at = xi.to_vec();
    at.push(0.0);
    let at = nalgebra::DVector::from_vec(at);
    let errors = cluster_errors(&grams, &at, &vec![true; terms.len()]);
    let errors = errors.map_or_else(|| vec![f64::NAN; terms.len()], |e| e.as_slice().to_vec());
    Ok((errors[degree + 1], errors[..=degree].to_vec()))
}

pub(super) fn predict(
    card: &Card,
    name: &str,
    time: Vec<f64>,
    motors: Vec<Vec<f64>>,
) -> Result<Vec<f64>> {
    let expected = motors_of(card);
    if motors.len() as f64 != expected {
        return Err(Error::data(
            name,
            format!("throttles of {expected} motors"),
            motors.len().to_string(),
        ));
    }
    let record = MotorRecord {
        time,
        motors,
        thrust: Vec::new(),
    };
    Ok(evaluate(
        &record,
        card.coefficient("T_m", "1"),
        &polynomial(card)?,
    ))
}

/// Steady thrust with the same throttle on all motors.
pub(super) fn at_rest(card: &Card, throttle: &[f64]) -> Result<Vec<f64>> {
    let (motors, xi) = (motors_of(card), polynomial(card)?);
    let of_motor = |s: f64| xi.iter().rev().fold(0.0, |sum, c| sum * s + c);
    Ok(throttle.iter().map(|s| motors * of_motor(*s)).collect())
}

fn motors_of(card: &Card) -> f64 {
    card.constants.get("motors").copied().unwrap_or(1.0)
}

/// The coefficients of `1`, `u`, `u^2`, …
fn polynomial(card: &Card) -> Result<Vec<f64>> {
    let names: Vec<String> = (0..=6).map(power).collect();
    let mut xi = Vec::new();
    for term in card.terms_of("T") {
        let Some(k) = names.iter().position(|n| *n == term.expression) else {
            return Err(Error::data(
                &card.name,
                format!("terms of `T` among {}", names.join(", ")),
                format!("`{}`", term.expression),
            ));
        };
        if xi.len() <= k {
            xi.resize(k + 1, 0.0);
        }
        xi[k] += term.value;
    }
    if xi.is_empty() {
        return Err(Error::data(&card.name, "terms of `T`", "none"));
    }
    Ok(xi)
}

/// The term of the k-th power.
fn power(k: usize) -> String {
    match k {
        0 => "1".to_string(),
        1 => "u".to_string(),
        _ => format!("u^{k}"),
    }
}
