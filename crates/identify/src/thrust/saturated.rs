//! Thrust beyond the range of the load cell, which shows its greatest value instead.

use touchdown_model::Card;
use touchdown_trial::Trial;

use super::{is_flight, root_at_rest, throttle};
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
    /// Thrust at which the load cell stands; the least one where logs have several (N).
    pub(super) limit_n: f64,
    /// Rows of it, in all logs.
    pub(super) rows: usize,
}

/// Leaves out the thrust of the rows in which a load cell is at the end of its range. Each log may have a load cell of its own.
pub(super) fn without_saturated(trials: &mut [Trial]) -> Result<Option<Saturation>> {
    let mut found: Option<Saturation> = None;
    for trial in trials {
        let of_flight = is_flight(trial);
        let Some(thrust) = trial.channel("thrust_n").filter(|_| !of_flight) else {
            continue;
        };
        let known = thrust.iter().copied().filter(|t| t.is_finite());
        let Some(of_trial) = end_of_range(known.collect()) else {
            continue;
        };
        let below = |t: &f64| if *t < of_trial.limit_n { *t } else { f64::NAN };
        let left = thrust.iter().map(below).collect();
        trial.insert("thrust_n", left)?;
        found = Some(found.map_or(of_trial, |other| Saturation {
            limit_n: other.limit_n.min(of_trial.limit_n),
            rows: other.rows + of_trial.rows,
        }));
    }
    Ok(found)
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

    /// Ends the card's range of throttle where its thrust at rest exceeds the limit and all that was measured beside it. A card
    /// without a thrust at rest keeps its range.
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
        let measured = trials.iter().filter_map(|t| t.channel("thrust_n"));
        let most_n = measured.flatten().copied().fold(self.limit_n, f64::max);
        let within = roots.iter().map(|x| x * x.abs() <= most_n);
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
    use crate::thrust::{fit, test_stand};

    /// A stand of `√T = 0.2 + 4 s` whose load cell ends at this thrust (N).
    fn log(limit_n: f64) -> Trial {
        test_stand::log(
            3000,
            test_stand::steps,
            |s, _| 0.2 + 4.0 * s,
            |f, _| f.min(limit_n),
        )
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
            let is_saturated = |w: &Warning| matches!(w, Warning::LoadCellSaturated { .. });
            assert!(!fit(100.0).warnings.iter().any(is_saturated), "{form:?}");
            let fitted = fit(8.0);
            let warning = fitted.warnings.iter().find(|w| is_saturated(w)).unwrap();
            assert!(
                warning.to_string().contains("stands at 8 N in"),
                "{warning}"
            );
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
    fn analytic_each_log_has_the_end_of_its_own_load_cell() {
        // One load cell ends at 8 N, the other shows all: the range of the card is that of the latter.
        let mut trials = [log(8.0), log(100.0)];
        let whole = trials[1].channel("thrust_n").unwrap().to_vec();
        let found = without_saturated(&mut trials).unwrap().unwrap();
        assert_eq!(found.limit_n, 8.0);
        assert_eq!(trials[1].channel("thrust_n").unwrap(), whole);
        let gaps = trials[0]
            .channel("thrust_n")
            .unwrap()
            .iter()
            .filter(|t| t.is_nan());
        assert_eq!(gaps.count(), found.rows);
        let settings = IdentificationSettings::default();
        let fitted = fit(&[log(8.0), log(100.0)], &settings, &Origin::default()).unwrap();
        let [_, high] = fitted.card.validity.inputs["s"];
        assert!((high - 0.85).abs() < 1e-9, "{high}");
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
