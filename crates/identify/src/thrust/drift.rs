//! Thrust that changes along a log at the same throttle: a load cell that warms up, a battery that sags.

use nalgebra::{DMatrix, DVector};
use touchdown_model::Card;
use touchdown_trial::Trial;

use super::{is_flight, predict};
use crate::warning::Warning;

/// Parts of a log, whose measured thrusts are compared with the fitted ones. Fewer leave too few degrees of freedom, more are as
/// short as the steps of throttle.
const PARTS: usize = 20;
/// Rows of a part at least: what varies from one to the next is not noise then.
const PART_ROWS: usize = 10;
/// Least change of the thrust along a log for a warning. If the frequency of the throttle rises along the log, a change of 2 % moves a
/// lag out of its interval, and a curve of too low a degree looks like a change of 1 %.
const LEAST_CHANGE: f64 = 0.015;
/// Least change over its standard error: with 15 degrees of freedom chance reaches it in a thousandth of the logs.
const LEAST_T: f64 = 4.0;

/// Least share of the time's variance that thrust and its rise do not explain. It is 0.0008 for a throttle that rises once along the
/// log, where a missed curve looks like drift, 0.17 and more for a sine that becomes quicker, and 0.9 for steps (the tests below).
const LEAST_OWN: f64 = 0.1;

/// A warning of the log whose thrust changes most significantly, if one does.
pub(super) fn of_thrust(card: &Card, trials: &[Trial]) -> Option<Warning> {
    let of_stand = trials.iter().filter(|trial| !is_flight(trial));
    let drifts = of_stand.filter_map(|trial| drift(&predict(card, trial).ok()?, trial));
    let significant = drifts.filter(|d| d.share.abs() > LEAST_CHANGE && d.t > LEAST_T);
    let most = significant.max_by(|a, b| a.t.total_cmp(&b.t))?;
    Some(Warning::ThrustDrifts {
        share: most.share,
        over_s: most.over_s,
    })
}

/// A change of thrust along a log.
struct ThrustDrift {
    /// From its start to its end, as a share of the thrust.
    share: f64,
    /// Its duration (s).
    over_s: f64,
    /// The change over its standard error.
    t: f64,
}

/// The change of measured over predicted thrust along a trial, beside what a wrong curve and hysteresis would explain, over its parts:
/// `T = T_p (a + b T_p + c T_p² + d ΔT_p + e t)`, by least squares.
fn drift(predicted: &[f64], trial: &Trial) -> Option<ThrustDrift> {
    let (time, thrust) = (trial.time_s(), trial.channel("thrust_n")?);
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| thrust[i].is_finite() && predicted[i].is_finite())
        .collect();
    if rows.len() < PARTS * PART_ROWS {
        return None;
    }
    let (from_s, to_s) = (time[rows[0]], time[rows[rows.len() - 1]]);
    let parts: Vec<Part> = rows
        .chunks(rows.len().div_ceil(PARTS))
        .map(|part| {
            let mean = |of: &dyn Fn(usize) -> f64| {
                part.iter().map(|&i| of(i)).sum::<f64>() / part.len() as f64
            };
            Part {
                at: (mean(&|i| time[i]) - from_s) / (to_s - from_s),
                fitted_n: mean(&|i| predicted[i]),
                rise_n: predicted[part[part.len() - 1]] - predicted[part[0]],
                measured_n: mean(&|i| thrust[i]),
            }
        })
        .collect();
    let most_n = parts.iter().map(|p| p.fitted_n.abs()).fold(0.0, f64::max);
    let columns = DMatrix::from_fn(parts.len(), 5, |i, k| {
        let (load, rise) = (parts[i].fitted_n / most_n, parts[i].rise_n / most_n);
        load * [1.0, load, load * load, rise, parts[i].at][k]
    });
    let spare = parts
        .len()
        .checked_sub(columns.ncols())
        .filter(|n| *n > 0)?;
    let measured = parts.iter().map(|p| p.measured_n / most_n);
    let measured = DVector::from_iterator(parts.len(), measured);
    let inverse = columns.tr_mul(&columns).try_inverse()?;
    let last = columns.ncols() - 1;
    // What the other columns leave of the time, over what a constant leaves.
    let (first, time) = (columns.column(0), columns.column(last));
    let along = first.dot(&time) / first.norm_squared();
    let centred = time - first * along;
    let own = 1.0 / (inverse[(last, last)] * centred.norm_squared());
    let fitted = &inverse * columns.tr_mul(&measured);
    let variance = (&measured - &columns * &fitted).norm_squared() / spare as f64;
    let error = (variance * inverse[(last, last)]).sqrt();
    (own > LEAST_OWN).then(|| ThrustDrift {
        share: fitted[last],
        over_s: to_s - from_s,
        t: fitted[last].abs() / error,
    })
}

/// A part of a log.
struct Part {
    /// When, as a share of the log.
    at: f64,
    /// Mean of the fitted thrust (N).
    fitted_n: f64,
    /// How much the fitted thrust rises (N).
    rise_n: f64,
    /// Mean of the measured thrust (N).
    measured_n: f64,
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::fitted::Origin;
    use crate::settings::{IdentificationSettings, ThrustForm};
    use crate::thrust::{fit, test_stand};

    const ROWS: u32 = 6000;

    /// Steps of a stand of `√T = 0.2 + 4 s - 0.5 s²`; `measured(T, t)` is what its load cell shows.
    fn stand(measured: impl Fn(f64, f64) -> f64) -> Trial {
        let root = |s: f64, _| 0.2 + 4.0 * s - 0.5 * s * s;
        test_stand::log(ROWS, test_stand::steps, root, measured)
    }

    fn share(trial: Trial, form: impl Into<Option<ThrustForm>>) -> Option<f64> {
        let mut settings = IdentificationSettings::default();
        settings.thrust.form = form.into();
        let fitted = fit(&[trial], &settings, &Origin::default()).unwrap();
        fitted.warnings.iter().find_map(|w| match w {
            Warning::ThrustDrifts { share, .. } => Some(*share),
            _ => None,
        })
    }

    #[test]
    fn analytic_a_scale_that_drifts_is_warned_of_in_every_form() {
        for form in [
            ThrustForm::FirstOrder,
            ThrustForm::LaggedMotors,
            ThrustForm::StaticSqrt,
            ThrustForm::Library,
        ] {
            // A line through a curve and a static form under a lag misfit, but not along the log.
            assert_eq!(share(stand(|f, _| f), form), None, "{form:?}");
            for change in [-0.1, -0.03, 0.03, 0.1] {
                let drifting = stand(|f, t| f * (1.0 + change * t / 60.0));
                let found = share(drifting, form).unwrap();
                // Relative to the fitted thrust, which is that of the middle.
                let expected = change / (1.0 + 0.5 * change);
                // A static form misses the transients, by a hundredth of the thrust of a part.
                assert!(
                    (found - expected).abs() < 0.2 * change.abs(),
                    "{form:?}: {found}"
                );
            }
        }
    }

    #[test]
    fn analytic_a_battery_that_sags_under_a_sine_that_becomes_quicker_is_warned_of() {
        // The mean thrust falls with the sag, and with the amplitude behind the lag. Of a form that misses quick changes that looks alike.
        let quicker = |sag: f64| {
            let throttle = |t: f64| 0.5 + 0.25 * (0.5 * TAU * t * (1.0 + t / 20.0)).sin();
            let volts = |t: f64| 1.0 - sag * t / 60.0;
            let root = |s: f64, t: f64| (5.2 * s - 0.8 * s * s - 0.3) * volts(t);
            test_stand::log(ROWS, throttle, root, |f, _| f)
        };
        assert_eq!(share(quicker(0.0), None), None);
        for form in [
            ThrustForm::FirstOrder,
            ThrustForm::LaggedMotors,
            ThrustForm::Library,
        ] {
            for sag in [0.03, 0.1] {
                let found = share(quicker(sag), form);
                assert!(
                    found.is_some_and(|share| share < -0.5 * sag),
                    "{form:?}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn analytic_a_curve_that_is_missed_is_no_drift() {
        // The throttle rises once along the log: what the curve misses changes along the log as well.
        let root = |s: f64, _| 0.2 + 4.0 * s + 3.0 * (s - 0.5).powi(3);
        let trial = test_stand::log(ROWS, |t| 0.2 + 0.75 * t / 60.0, root, |f, _| f);
        assert_eq!(share(trial, ThrustForm::FirstOrder), None);
    }
}
