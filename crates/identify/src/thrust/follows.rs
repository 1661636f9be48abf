//! Whether thrust follows the throttle: a channel that is no thrust, or a throttle that is inverted.

use touchdown_model::Card;
use touchdown_trial::Trial;

use super::choice::FINEST;
use super::plateau::{median, tenths};
use super::{LEAST_MOTION, root_at_rest, throttle};
use crate::error::{Error, Result};
use crate::fitted::range;
use crate::warning::Warning;

/// Share of the spread of the measured thrust by which a fit must fall from the lowest to the highest throttle to be of an
/// inverted throttle. Of such a log it falls by about the whole spread, of 2000 rows
/// of noise alone by a hundredth.
const FALLS_BY: f64 = 0.5;

/// Checks that the thrust of `trials` changes where their throttle does.
///
/// # Errors
/// A thrust that is the same in all rows.
pub(super) fn check_changes(trials: &[Trial]) -> Result<()> {
    let thrust = trials.iter().filter_map(|t| t.channel("thrust_n"));
    let Some([least_n, most_n]) = range(thrust.flatten().copied()) else {
        return Ok(());
    };
    let Some([low, high]) = throttles(trials)? else {
        return Ok(());
    };
    if most_n - least_n > FINEST * most_n.abs() || high - low <= LEAST_MOTION {
        return Ok(());
    }
    Err(Error::data(
        trials.first().map_or("no trial", Trial::name),
        "a thrust that follows the throttle",
        format!(
            "{least_n} to {most_n} N in all rows, while the throttle goes from {low} to {high}: thrust does not follow the \
             throttle. Check the map: is `thrust_n` the column of the load cell?"
        ),
    ))
}

/// Whether the thrust at rest of a fitted card falls from the lowest throttle of its data to the highest.
pub(super) fn inverted(card: &Card, trials: &[Trial]) -> Option<Warning> {
    let [low, high] = throttles(trials).ok()??;
    let channel = |name: &'static str| trials.iter().filter_map(move |t| t.channel(name));
    let volts = median(channel("battery_v").flatten().copied()).unwrap_or(f64::NAN);
    let roots = root_at_rest(card, &[low, high], &[volts; 2]).ok()?;
    let [at_low_n, at_high_n] = [roots[0], roots[1]].map(|x| x * x.abs());
    let [least_n, most_n] = tenths(channel("thrust_n").flatten().copied())?;
    (at_low_n - at_high_n > FALLS_BY * (most_n - least_n)).then_some(Warning::ThrottleInverted {
        throttle: [low, high],
        thrust_n: [at_low_n, at_high_n],
    })
}

/// Lowest and highest throttle of all trials.
fn throttles(trials: &[Trial]) -> Result<Option<[f64; 2]>> {
    let all: Vec<Vec<f64>> = trials.iter().map(throttle).collect::<Result<_>>()?;
    Ok(range(all.into_iter().flatten()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitted::{FittedCard, Origin};
    use crate::settings::{IdentificationSettings, ThrustForm};

    /// `(0.2 + 4 s)²` behind a lag of 0.06 s, in steps of a second, at 100 Hz.
    fn trial(logged: impl Fn(f64) -> f64, measured: impl Fn(f64) -> f64) -> Trial {
        let (mut throttle, mut thrust) = (Vec::new(), Vec::new());
        let mut x = 2.0;
        for i in 0..2000 {
            let s = 0.25 + 0.06 * f64::from((7 * (i / 100)) % 11);
            x += (0.2 + 4.0 * s - x) * (1.0 - (-0.01_f64 / 0.06).exp());
            throttle.push(logged(s));
            // The sine is of no period of the steps: noise of 0.02 N.
            thrust.push(measured(x * x) + 0.02 * (2.4 * f64::from(i)).sin());
        }
        let time = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        let trial = Trial::new("t", time).unwrap();
        let trial = trial.with_channel("throttle", throttle).unwrap();
        trial.with_channel("thrust_n", thrust).unwrap()
    }

    fn fit(trial: &Trial, form: Option<ThrustForm>) -> Result<FittedCard> {
        let mut settings = IdentificationSettings::default();
        settings.thrust.form = form;
        super::super::fit(std::slice::from_ref(trial), &settings, &Origin::default())
    }

    #[test]
    fn prop_an_inverted_throttle_is_warned_of_in_every_form() {
        let asked = |fitted: &FittedCard| {
            let inverted = |w: &&Warning| matches!(w, Warning::ThrottleInverted { .. });
            fitted
                .warnings
                .iter()
                .find(inverted)
                .map(ToString::to_string)
        };
        let [good, inverted] = [trial(|s| s, |f| f), trial(|s| 1.0 - s, |f| f)];
        for form in ThrustForm::ALL.map(Some).into_iter().chain([None]) {
            assert_eq!(asked(&fit(&good, form).unwrap()), None, "{form:?}");
            let fitted = fit(&inverted, form).unwrap();
            let text = asked(&fitted).unwrap_or_default();
            assert!(
                text.contains("is the throttle inverted?"),
                "{form:?}: {text}"
            );
            assert!(fitted.card.warnings.contains(&text), "{form:?}");
        }
    }

    #[test]
    fn analytic_noise_alone_is_no_inverted_throttle() {
        // 0.02 N of noise on 5 N: the fit falls or rises by chance.
        let fitted = fit(&trial(|s| s, |_| 5.0), Some(ThrustForm::FirstOrder)).unwrap();
        let inverted = |w: &Warning| matches!(w, Warning::ThrottleInverted { .. });
        assert!(!fitted.warnings.iter().any(inverted));
    }

    #[test]
    fn analytic_a_constant_thrust_is_refused() {
        let rows = 200;
        let log = |thrust_n: f64| {
            let trial = Trial::new("t", (0..rows).map(f64::from).collect()).unwrap();
            let throttle = (0..rows).map(|i| f64::from(i % 10) / 10.0).collect();
            let trial = trial.with_channel("throttle", throttle).unwrap();
            let mut thrust = vec![5.0; 200];
            thrust[7] = thrust_n;
            trial.with_channel("thrust_n", thrust).unwrap()
        };
        let text = check_changes(&[log(5.0)]).unwrap_err().to_string();
        assert!(
            text.contains("thrust does not follow the throttle"),
            "{text}"
        );
        assert!(text.contains("from 0 to 0.9"), "{text}");
        assert!(check_changes(&[log(5.1)]).is_ok());
        // Steady points in files of their own: the thrust of each is constant, that of all is not.
        let each = [5.0, 6.0].map(|thrust_n| {
            let trial = Trial::new("t", vec![0.0, 1.0]).unwrap();
            let trial = trial
                .with_channel("throttle", vec![0.1 * thrust_n; 2])
                .unwrap();
            trial.with_channel("thrust_n", vec![thrust_n; 2]).unwrap()
        });
        assert!(check_changes(&each).is_ok());
        assert!(
            check_changes(&each[..1]).is_ok(),
            "a throttle that stands still has an error of its own"
        );
    }
}
