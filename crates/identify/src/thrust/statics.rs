//! Static maps: √T or T as a polynomial of throttle, with an optional battery term.

use nalgebra::DVector;
use sindy::statistics::regression::{Clusters, cluster_errors, least_squares};
use sindy::{Gram, Library, Samples};
use touchdown_model::{Form, Kind};
use touchdown_trial::Trial;

use super::plateau::{self, Plateau};
use super::rotor;
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, range, score};
use crate::scores::Errors;
use crate::settings::{IdentificationSettings, ThrustForm};
use crate::unit;

/// Sampling period from which the lag of a rotor cannot be seen (s).
const SLOWEST_PERIOD_S: f64 = 0.05;
/// Share of the largest thrust by which it must fall at full throttle to be warned of.
const FALLS_FROM: f64 = 0.01;

pub(super) fn fit(
    trials: &[Trial],
    settings: &IdentificationSettings,
    form: ThrustForm,
    origin: &Origin,
) -> Result<FittedCard> {
    let (points, by_plateau) = steady_points(trials, settings)?;
    let root = form == ThrustForm::StaticSqrt;
    let (degree, battery) = (settings.thrust.degree, settings.thrust.battery);
    let mut terms: Vec<String> = vec!["1".into(), "s".into()];
    terms.extend((2..=degree).map(|k| format!("s^{k}")));
    if battery {
        terms.push("s*u".into());
    }
    let levels = {
        let mut s: Vec<f64> = points.iter().map(|p| p.throttle).collect();
        s.sort_by(f64::total_cmp);
        s.dedup();
        s.len()
    };
    if points.len() <= terms.len() || levels <= degree {
        return Err(Error::data(
            trials.first().map_or("no trial", Trial::name),
            format!(
                "more than {degree} levels of throttle and more points than the {} terms",
                terms.len()
            ),
            format!(
                "{} points at {levels} levels with thrust above {} N",
                points.len(),
                settings.thrust.min_thrust_n
            ),
        ));
    }
    let target = |p: &Plateau| {
        if root {
            p.thrust_n.max(0.0).sqrt()
        } else {
            p.thrust_n
        }
    };
    let mut samples = Samples::new(&["s", "u", "y"]);
    for p in &points {
        let u = match p.battery_v {
            Some(u) => u,
            None if battery => {
                return Err(Error::data(
                    trials[0].name(),
                    "a channel `battery_v` (settings ask for a battery term)",
                    "none, or a gap",
                ));
            }
            None => 0.0,
        };
        samples.push_group(vec![vec![p.throttle], vec![u], vec![target(p)]])?;
    }
    let library = Library::parse(&terms)?;
    let grams = Gram::accumulate(&library, "y", &samples)?;
    let all = vec![true; terms.len()];
    let xi = least_squares(&Gram::total(&grams), &all);
    let errors = cluster_errors(&grams, &xi, &all)
        .unwrap_or_else(|| DVector::from_element(xi.len(), f64::NAN));

    let (of, unit, name, card_form, equation) = if root {
        (
            "x",
            "√N",
            "thrust-static-sqrt",
            Form::StaticSqrt,
            "√T = x(s), T [N], s throttle in [0, 1]",
        )
    } else {
        (
            "T",
            "N",
            "thrust-static",
            Form::StaticThrust,
            "T = T(s) [N], s throttle in [0, 1]",
        )
    };
    let mut card = origin.card(name, Kind::Thrust, card_form, equation);
    if battery {
        card.equation.push_str(", u battery voltage [V]");
    }
    for (j, text) in terms.iter().enumerate() {
        let estimate = Estimate::clustered(
            xi[j],
            errors[j],
            Clusters {
                groups: points.len(),
                coefficients: terms.len(),
            },
        );
        let unit = unit::of_coefficient(of, text);
        card.terms.push(term(of, text, estimate, &unit));
    }
    if let Some(r) = range(points.iter().map(|p| p.throttle)) {
        card.validity.inputs.insert("s".into(), r);
    }
    if let Some(r) = range(points.iter().map(|p| p.thrust_n)) {
        card.validity.output = Some(r);
    }
    let at = |p: &Plateau| -> f64 {
        let s = p.throttle;
        let mut y = (0..=degree).map(|k| xi[k] * s.powi(k as i32)).sum::<f64>();
        if battery {
            y += xi[degree + 1] * s * p.battery_v.unwrap_or(f64::NAN);
        }
        y
    };
    let of_branch = |descending: Option<bool>| -> (Option<Errors>, Option<Errors>, f64) {
        let chosen: Vec<&Plateau> = points
            .iter()
            .filter(|p| descending.is_none_or(|d| p.descending == d))
            .collect();
        let fitted: Vec<f64> = chosen.iter().map(|p| at(p)).collect();
        let wanted: Vec<f64> = chosen.iter().map(|p| target(p)).collect();
        let thrust: Vec<f64> = fitted
            .iter()
            .map(|y| if root { y * y.abs() } else { *y })
            .collect();
        let measured: Vec<f64> = chosen.iter().map(|p| p.thrust_n).collect();
        let bias = wanted.iter().zip(&fitted).map(|(w, f)| w - f).sum::<f64>()
            / wanted.len().max(1) as f64;
        (
            Errors::of(&fitted, &wanted),
            Errors::of(&thrust, &measured),
            bias,
        )
    };
    let own = of_branch(None).0;
    let rmse = own.map_or(f64::NAN, |e| e.rmse);
    for (label, branch) in [
        ("all points", None),
        ("ascending", Some(false)),
        ("descending", Some(true)),
    ] {
        if let (Some(e), Some(n), _) = of_branch(branch) {
            card.scores.push(score(
                label,
                true,
                "static",
                e,
                if root { "√N" } else { "N" },
            ));
            if root {
                card.scores.push(score(label, true, "static", n, "N"));
            }
        }
    }
    let mut warnings: Vec<String> = supply_limit(&points).into_iter().collect();
    if points.iter().any(|p| p.descending) && points.iter().any(|p| !p.descending) {
        let (up, down) = (of_branch(Some(false)).2, of_branch(Some(true)).2);
        let of = |descending| points.iter().filter(|p| p.descending == descending).count() as f64;
        // Twice the standard error of the difference of two means.
        if (up - down).abs() > 2.0 * rmse * (1.0 / of(true) + 1.0 / of(false)).sqrt() {
            warnings.push(format!(
            "ascending points lie {up:+.4} {unit} off the fit on average, descending ones {down:+.4} {unit}"
        ));
        }
    }
    card.provenance.method = method(&[
        (
            "fit",
            "least squares, each point once; standard errors robust to unequal noise".into(),
        ),
        (
            "points",
            if by_plateau {
                format!(
                    "{} plateaus, medians from {} s after each step, thrust above {} N",
                    points.len(),
                    settings.thrust.settle_s,
                    settings.thrust.min_thrust_n
                )
            } else {
                format!(
                    "{} rows with thrust above {} N",
                    points.len(),
                    settings.thrust.min_thrust_n
                )
            },
        ),
    ]);
    let mut lag_s = None;
    let shows_lag = |t: &Trial| {
        t.channel("rotor_rpm").is_some() && t.period_s().is_some_and(|p| p < SLOWEST_PERIOD_S)
    };
    if root && by_plateau && trials.iter().all(shows_lag) {
        match rotor::fit(trials, settings) {
            Ok(lag) => {
                let d = (lag.dead_time_s, lag.dead_time_error_s);
                let terms = [("T_m", lag.lag_s, lag.lag_error_s), ("dead_time", d.0, d.1)];
                for (of, value, error) in terms {
                    let estimate = Estimate::clustered(value, error, lag.clusters());
                    card.terms.push(term(of, "1", estimate, "s"));
                }
                card.provenance.method.insert("lag".into(), lag.describe());
                lag_s = Some(lag.lag_s);
            }
            Err(e) => warnings.push(format!("no lag of the rotor was fitted: {e}")),
        }
    }
    Ok(FittedCard {
        card,
        rmse,
        rmse_unit: if root { "√N" } else { "N" },
        rows_used: points.len(),
        lag_s,
        front: None,
        warnings,
    })
}

/// Whether thrust falls towards the highest throttles, as it does where the supply gives no more.
fn supply_limit(points: &[Plateau]) -> Option<String> {
    let most = points
        .iter()
        .max_by(|a, b| a.thrust_n.total_cmp(&b.thrust_n))?;
    let top = points
        .iter()
        .map(|p| p.throttle)
        .fold(f64::NEG_INFINITY, f64::max);
    let at_top = plateau::median(
        points
            .iter()
            .filter(|p| p.throttle == top)
            .map(|p| p.thrust_n),
    )?;
    (most.throttle < top && at_top < (1.0 - FALLS_FROM) * most.thrust_n).then(|| {
        format!(
            "falls at the highest throttles: supply limit ({:.2} N at throttle {:.3}, {at_top:.2} N at {top:.3})",
            most.thrust_n, most.throttle
        )
    })
}

/// Plateaus of all trials, or their rows where a trial has fewer than four plateaus.
///
/// # Errors
/// A missing channel.
pub fn steady_points(
    trials: &[Trial],
    settings: &IdentificationSettings,
) -> Result<(Vec<Plateau>, bool)> {
    let mut points = Vec::new();
    let mut by_plateau = true;
    for trial in trials {
        let found = plateau::find(trial, settings.thrust.settle_s)?;
        if found.len() >= 4 {
            points.extend(found);
        } else {
            by_plateau = false;
            points.extend(plateau::rows(trial)?);
        }
    }
    points.retain(|p| p.thrust_n > settings.thrust.min_thrust_n);
    Ok((points, by_plateau))
}
