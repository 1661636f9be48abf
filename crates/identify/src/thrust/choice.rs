//! Which form: that with the least error in free run on held-out parts, or a simpler one that is as good.

use rayon::prelude::*;
use touchdown_trial::Trial;

use super::free_run::{CommandRecord, Free, HeldOut, Output, Problem, Shape, period_s};
use super::library::LibraryFit;
use super::output_error::{LagFit, LagForm, between, counts_rows};
use super::statics;
use crate::error::{Error, Result};
use crate::forms::FormScore;
use crate::settings::{IdentificationSettings, ThrustForm};

/// Rows up to which a trial is a table of steady points.
/// Tables of manufacturers have up to 40 rows; a record of a second has more than 60.
const FEW_ROWS: usize = 60;
/// Sampling period of thrust above which the lag of a rotor is not identifiable (s): lags of small rotors are 0.03 to
/// 0.1 s.
pub(super) const SLOWEST_PERIOD_S: f64 = 0.05;
/// A simpler form may err by this factor more than the best at most. Without it, logs with one odd stretch, whose standard
/// error is large, would get forms that are visibly worse.
const MOST_EXCESS: f64 = 1.05;

/// Share of the greatest thrust below which errors are equal: no load cell shows it.
pub(super) const FINEST: f64 = 1e-4;

/// Why a form that was fitted has no error on held-out parts.
const DIVERGES: &str = "its free run diverges on a part held out";

/// A form with and without lag and battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub form: ThrustForm,
    pub lag: bool,
    pub battery: bool,
}

/// The chosen form, and all that were tried.
pub(super) struct Choice {
    pub candidate: Candidate,
    pub scores: Vec<FormScore>,
}

/// Judges all forms that the trials allow.
///
/// # Errors
/// A throttle that stands still, or no form that can be fitted.
pub(super) fn choose(trials: &[Trial], settings: &IdentificationSettings) -> Result<Choice> {
    for trial in trials {
        super::check_moves(trial.name(), [super::throttle(trial)?.as_slice()])?;
    }
    let dynamic = has_course(trials);
    let with_battery = |trial: &Trial| {
        let volts = trial.channel("battery_v");
        volts.is_some_and(|v| v.iter().any(|v| v.is_finite()))
    };
    let batteries: &[bool] = match (settings.thrust.battery, trials.iter().all(with_battery)) {
        (true, _) => &[true],
        (false, true) => &[false, true],
        (false, false) => &[false],
    };
    let mut candidates = Vec::new();
    for &battery in batteries {
        for form in ThrustForm::ALL {
            let lags: &[bool] = match form {
                ThrustForm::StaticSqrt if dynamic => &[false, true],
                ThrustForm::StaticSqrt | ThrustForm::StaticThrust => &[false],
                // Eq. (8) is a library of throttle and thrust alone.
                ThrustForm::Library if battery => &[],
                _ if dynamic => &[true],
                _ => &[],
            };
            candidates.extend(lags.iter().map(|&lag| Candidate { form, lag, battery }));
        }
    }
    let judged: Vec<Result<(HeldOut, usize)>> = candidates
        .par_iter()
        .map(|candidate| judge(trials, settings, *candidate, dynamic))
        .collect();
    let largest = |trial: &Trial| crate::fitted::range(trial.channel("thrust_n")?.iter().copied());
    let most_n = trials.iter().filter_map(largest).map(|[_, most]| most);
    pick(&candidates, judged, FINEST * most_n.fold(0.0, f64::max))
}

/// Whether trials are records over time that show a lag, not steady points.
fn has_course(trials: &[Trial]) -> bool {
    if trials.iter().any(|t| counts_rows(t) || t.len() <= FEW_ROWS) {
        return false;
    }
    let records = CommandRecord::of(trials, false, false);
    records.is_ok_and(|records| period_s(&records) <= SLOWEST_PERIOD_S)
}

fn judge(
    trials: &[Trial],
    settings: &IdentificationSettings,
    candidate: Candidate,
    dynamic: bool,
) -> Result<(HeldOut, usize)> {
    let Candidate { form, lag, battery } = candidate;
    let degree = settings.thrust.degree;
    if form == ThrustForm::Library {
        let fit = LibraryFit::new(trials, settings)?;
        return Ok((fit.held_out(settings)?, fit.parameters()));
    }
    if lag {
        let form = LagForm {
            form,
            degree,
            battery,
        };
        let parameters = form.shape().coefficients() + 1;
        let fit = LagFit::new(trials, settings, form)?;
        let dead_time = usize::from(fit.dead_time().is_some());
        return Ok((fit.held_out, parameters + dead_time));
    }
    let root = form == ThrustForm::StaticSqrt;
    if !dynamic {
        return statics::held_out(trials, settings, root, battery);
    }
    let records = CommandRecord::of(trials, false, battery)?;
    let shape = Shape {
        output: if root { Output::Root } else { Output::Thrust },
        degree,
        battery,
    };
    let problem = Problem::new(
        &records,
        shape,
        between(&records),
        settings.thrust.max_lag_s,
    );
    let at = problem.solve(Free::CURVE);
    Ok((problem.held_out(&at, Free::CURVE), shape.coefficients()))
}

/// The form of least error, or the simplest that is as good.
///
/// Differences below `finest_n` (N) are none.
fn pick(
    candidates: &[Candidate],
    judged: Vec<Result<(HeldOut, usize)>>,
    finest_n: f64,
) -> Result<Choice> {
    let fitted: Vec<(usize, &HeldOut, usize)> = judged
        .iter()
        .enumerate()
        .filter_map(|(i, j)| j.as_ref().ok().map(|(h, p)| (i, h, *p)))
        .filter(|(_, h, _)| h.rmse().is_finite())
        .collect();
    let best = fitted
        .iter()
        .min_by(|a, b| a.1.rmse().total_cmp(&b.1.rmse()));
    let Some(&(_, best, _)) = best else {
        let name = "thrust";
        let finite = "data that a finite fit follows from (time in seconds, forces in newtons)";
        let infinite = Error::data(name, finite, "errors beyond all numbers");
        let all_failed = judged.iter().all(Result::is_err);
        let first = judged.into_iter().find_map(Result::err);
        return Err(first.filter(|_| all_failed).unwrap_or(infinite));
    };
    let chosen = fitted
        .iter()
        .filter(|(_, h, _)| {
            let equal = h.rmse() <= best.rmse() + finest_n;
            equal || h.as_good_as(best) && h.rmse() <= MOST_EXCESS * best.rmse()
        })
        .min_by_key(|(i, _, parameters)| (*parameters, *i))
        .map_or(0, |(i, ..)| *i);
    let scores = candidates.iter().zip(&judged).enumerate();
    let scores = scores.map(|(i, (candidate, judged))| {
        let fit = judged.as_ref().ok();
        let finite = |v: f64| v.is_finite().then_some(v);
        FormScore {
            form: candidate.form.name(),
            lag: candidate.lag,
            battery: candidate.battery,
            parameters: fit.map_or(0, |f| f.1),
            held_out_rmse_n: fit.and_then(|f| finite(f.0.rmse())),
            std_error_n: fit.and_then(|f| finite(f.0.std_error())),
            chosen: i == chosen,
            error: match judged {
                Err(error) => Some(error.to_string()),
                Ok((held_out, _)) if !held_out.rmse().is_finite() => Some(DIVERGES.to_owned()),
                Ok(_) => None,
            },
        }
    });
    Ok(Choice {
        candidate: candidates[chosen],
        scores: scores.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_form_whose_free_run_diverges_has_the_reason() {
        let candidate = |form| Candidate {
            form,
            lag: false,
            battery: false,
        };
        let candidates = [ThrustForm::StaticSqrt, ThrustForm::Library].map(candidate);
        let held_out = |squares: f64| HeldOut {
            pieces: vec![(squares, 10); 4],
        };
        let judged = vec![Ok((held_out(0.1), 3)), Ok((held_out(f64::INFINITY), 5))];
        let scores = pick(&candidates, judged, 0.0).unwrap().scores;
        assert!(scores[0].chosen && scores[0].error.is_none());
        assert_eq!(scores[1].held_out_rmse_n, None);
        assert_eq!(scores[1].error.as_deref(), Some(DIVERGES));
    }
}
