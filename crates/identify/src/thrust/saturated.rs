//! Thrust beyond the range of the load cell, which shows its greatest value instead.

use touchdown_model::Card;
use touchdown_trial::Trial;

use super::{root_at_rest, throttle};
use crate::error::Result;
use crate::warning::Warning;

/// Rows of the greatest thrust from which on it may be the end of a range: of a tenth of a second at 100 Hz.
const LEAST_ROWS: usize = 10;
/// How many times as often as any other thrust the greatest one has to occur. Noise makes it the rarest, and a log without noise
/// repeats the thrusts of other levels as often.
const OFTEN: usize = 3;

/// The end of a load cell's range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saturation {
    /// Thrust at which the load cell stands (N).
    pub(super) limit_n: f64,
    /// Rows of it, in all trials.
    pub(super) rows: usize,
}

/// Leaves the thrust out of the rows in which the load cell stands at the end of its range.
pub(super) fn without_saturated(trials: &mut [Trial]) -> Result<Option<Saturation>> {
    // The thrust of a flight comes from its accelerometer.
    let of_stand = |t: &&Trial| t.channel("specific_force_mps2").is_none();
    let thrust = trials.iter().filter(of_stand);
    let thrust = thrust.filter_map(|t| t.channel("thrust_n")).flatten();
    let Some(saturation) = end_of_range(thrust.copied().filter(|t| t.is_finite()).collect()) else {
        return Ok(None);
    };
    for trial in trials {
        if let Some(thrust) = trial.channel("thrust_n") {
            let below = |t: &f64| {
                if *t < saturation.limit_n {
                    *t
                } else {
                    f64::NAN
                }
            };
            let left = thrust.iter().map(below).collect();
            trial.insert("thrust_n", left)?;
        }
    }
    Ok(Some(saturation))
}

/// The greatest thrust, if it occurs much more often than any other but the least, which is that of a rotor that stands.
fn end_of_range(mut thrust_n: Vec<f64>) -> Option<Saturation> {
    thrust_n.sort_by(f64::total_cmp);
    let counts: Vec<(f64, usize)> = thrust_n
        .chunk_by(|a, b| a == b)
        .map(|equal| (equal[0], equal.len()))
        .collect();
    let (&(limit_n, rows), others) = counts.split_last()?;
    let most = others.iter().skip(1).map(|(_, count)| *count).max()?;
    (rows >= LEAST_ROWS && rows > OFTEN * most).then_some(Saturation { limit_n, rows })
}

impl Saturation {
    pub(super) fn warning(self) -> Warning {
        Warning::LoadCellSaturated {
            limit_n: self.limit_n,
            rows: self.rows,
        }
    }

    /// Ends the card's range of throttle where its thrust at rest reaches the limit. A card without one keeps its range.
    pub(super) fn bound(self, card: &mut Card, trials: &[Trial]) {
        let Some([low, _]) = card.validity.inputs.get("s").copied() else {
            return;
        };
        let all = trials.iter().filter_map(|trial| throttle(trial).ok());
        let mut all: Vec<f64> = all.flatten().filter(|s| s.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        let volts = trials.iter().filter_map(|t| t.channel("battery_v"));
        let volts = super::plateau::median(volts.flatten().copied()).unwrap_or(f64::NAN);
        let Ok(roots) = root_at_rest(card, &all, &vec![volts; all.len()]) else {
            return;
        };
        let within = roots.iter().map(|x| x * x.abs() <= self.limit_n);
        let reached = all.iter().zip(within).filter(|(_, within)| *within);
        let high = reached.map(|(s, _)| *s).fold(low, f64::max);
        card.validity.inputs.insert("s".into(), [low, high]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitted::Origin;
    use crate::settings::{IdentificationSettings, ThrustForm};
    use crate::thrust::fit;

    /// `(0.2 + 4 s)²` behind a lag of 0.06 s, in steps of a second, at 100 Hz, with noise of 0.02 N.
    fn log(limit_n: f64) -> Trial {
        let (mut throttle, mut thrust) = (Vec::new(), Vec::new());
        let mut x = 2.0;
        for i in 0..3000 {
            let s = 0.25 + 0.06 * f64::from((7 * (i / 100)) % 11);
            x += (0.2 + 4.0 * s - x) * (1.0 - (-0.01_f64 / 0.06).exp());
            throttle.push(s);
            // The sine is of no period of the steps.
            thrust.push((x * x + 0.02 * (2.4 * f64::from(i * i % 1009)).sin()).min(limit_n));
        }
        let time = (0..3000).map(|i| 0.01 * f64::from(i)).collect();
        let trial = Trial::new("t", time).unwrap();
        let trial = trial.with_channel("throttle", throttle).unwrap();
        trial.with_channel("thrust_n", thrust).unwrap()
    }

    #[test]
    fn analytic_rows_at_the_end_of_a_range_are_left_out_and_bound_the_card() {
        for form in [
            None,
            Some(ThrustForm::FirstOrder),
            Some(ThrustForm::StaticSqrt),
        ] {
            let mut settings = IdentificationSettings::default();
            settings.thrust.form = form;
            let fit = |limit_n: f64| fit(&[log(limit_n)], &settings, &Origin::default()).unwrap();
            let is_told = |w: &Warning| matches!(w, Warning::LoadCellSaturated { .. });
            assert!(!fit(100.0).warnings.iter().any(is_told), "{form:?}");
            // Of 12 N above a throttle of 0.816 nothing is known.
            let fitted = fit(8.0);
            let told = fitted.warnings.iter().find(|w| is_told(w)).unwrap();
            assert!(told.to_string().contains("stands at 8 N in"), "{told}");
            let [_, high] = fitted.card.validity.inputs["s"];
            // √8 = 0.2 + 4 s at 0.657: the highest level below is 0.61.
            assert!((high - 0.61).abs() < 1e-9, "{form:?}: {high}");
            let at_rest = super::super::at_rest(&fitted.card, &[0.61], &[f64::NAN]).unwrap();
            // A hundredth is of the noise; with the limit as thrust it errs by 0.3 N and more.
            assert!(
                (at_rest[0].sqrt() - 2.64).abs() < 0.01,
                "{form:?}: {at_rest:?}"
            );
        }
    }

    #[test]
    fn analytic_the_top_of_a_staircase_is_no_end_of_a_range() {
        let levels = |at: &[f64], rows: usize| {
            let all = at.iter().flat_map(|level| vec![*level; rows]);
            end_of_range(all.collect())
        };
        // Without noise each level repeats its thrust.
        assert!(levels(&[0.0, 1.0, 2.0, 3.0], 100).is_none());
        // A table in which the greatest thrust stands twice.
        assert!(levels(&[0.0, 1.0, 2.0, 3.0, 3.0], 1).is_none());
        assert!(levels(&[5.0], 100).is_none());
        let mut all: Vec<f64> = (0..500).map(|i| 0.01 * f64::from(i)).collect();
        all.extend([5.0; 60]);
        let found = end_of_range(all).unwrap();
        assert_eq!((found.limit_n, found.rows), (5.0, 60));
    }
}
