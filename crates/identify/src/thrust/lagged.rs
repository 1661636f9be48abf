//! A first-order lag on every motor's own command, then a polynomial for each motor's thrust, summed:
//! `T = Σ_i (c0 + c1 u_i + c2 u_i²)`, `u_i = lag(s_i; T_m)`, with `c u_i V` where a battery's voltage V is in it.

use touchdown_model::card::Card;

use super::free_run::signal::{Between, lagged};
use super::output_error::HELD;
use crate::error::{Error, Result};

/// The term of the battery's voltage.
pub(super) const BATTERY_TERM: &str = "u*battery_v";

/// Thrust (N) of a card along the throttles of its motors.
pub(super) fn predict(
    card: &Card,
    name: &str,
    time: &[f64],
    motors: &[Vec<f64>],
    battery_v: &[f64],
) -> Result<Vec<f64>> {
    let expected = motors_of(card);
    if motors.len() as f64 != expected {
        return Err(Error::data(
            name,
            format!("throttles of {expected} motors"),
            motors.len().to_string(),
        ));
    }
    let (lag_s, dead_time_s) = (card.coefficient("T_m", "1"), super::dead_time_s(card));
    let between = match card.constants.get(HELD) {
        Some(0.0) => Between::Linear,
        _ => Between::Held,
    };
    let xi = polynomial(card)?;
    let of_volts = card.coefficient("T", BATTERY_TERM);
    let mut out = vec![0.0; time.len()];
    for motor in motors {
        let u = lagged(time, motor, between, lag_s, dead_time_s);
        for (i, (out, u)) in out.iter_mut().zip(u).enumerate() {
            *out += horner(&xi, u);
            if of_volts != 0.0 {
                *out += of_volts * u * battery_v.get(i).copied().unwrap_or(f64::NAN);
            }
        }
    }
    Ok(out)
}

/// Steady thrust with the same throttle on all motors.
pub(super) fn at_rest(card: &Card, throttle: &[f64], battery_v: &[f64]) -> Result<Vec<f64>> {
    let (motors, xi) = (motors_of(card), polynomial(card)?);
    let of_volts = card.coefficient("T", BATTERY_TERM);
    let of_motor = |i: usize, s: f64| {
        let sag = match of_volts {
            0.0 => 0.0,
            c => c * s * battery_v.get(i).copied().unwrap_or(f64::NAN),
        };
        horner(&xi, s) + sag
    };
    let each = throttle.iter().enumerate();
    Ok(each.map(|(i, s)| motors * of_motor(i, *s)).collect())
}

fn horner(xi: &[f64], u: f64) -> f64 {
    xi.iter().rev().fold(0.0, |sum, c| sum * u + c)
}

/// The motors of a card.
pub(super) fn motors_of(card: &Card) -> f64 {
    card.constants.get("motors").copied().unwrap_or(1.0)
}

/// The coefficients of `1`, `u`, `u^2`, …
fn polynomial(card: &Card) -> Result<Vec<f64>> {
    let names: Vec<String> = (0..=6).map(power).collect();
    let mut xi = Vec::new();
    for term in card.terms_of("T").filter(|t| t.expression != BATTERY_TERM) {
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
