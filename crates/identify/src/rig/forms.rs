//! Every form from the logs of one force rig: what fits, what does not and why, and how the levels of identification compare.

use rayon::prelude::*;
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::levels::{self, Level};
use super::{GroundTrial, fit, prepare, without_gaps};
use crate::error::{Error, Result};
use crate::fitted::{FittedCard, Origin};
use crate::settings::IdentificationSettings;

/// One of this number of logs is held out when levels are compared. Fewer logs are not split.
const HELD_OUT_EVERY: usize = 5;
const FEWEST_LOGS: usize = 5;
/// Forms whose levels are compared.
const COMPARED: [Form; 4] = [Form::Static, Form::Derivative, Form::Ratio, Form::Lag];
/// How many steps [`held_out_levels`] reports at most.
pub const LEVEL_STEPS: u64 = COMPARED.len() as u64;

/// Forms with their cards, and forms that could not be fitted, with the reason.
#[derive(Debug, Default)]
pub struct FormFits {
    /// The forms that were fitted.
    pub forms: Vec<Form>,
    /// Their cards, in the same order.
    pub cards: Vec<FittedCard>,
    /// The others.
    pub failed: Vec<(Form, Error)>,
}

/// Refuses a card that is not the thrust of the whole vehicle, which a force rig holds.
///
/// # Errors
/// A card of a ground effect, or of fewer rotors than the vehicle has.
pub fn check_thrust_card(card: &Card, rotors: Option<u32>) -> Result<()> {
    let name = &card.name;
    if card.kind != Kind::Thrust {
        return Err(Error::Arguments(format!(
            "card `{name}`: key `kind`: expected `thrust` (the card gives the free-air thrust), found `ground_effect`"
        )));
    }
    match (card.measured_rotors, rotors.or(card.vehicle.rotors)) {
        (Some(measured), Some(all)) if measured != all => Err(Error::Arguments(format!(
            "card `{name}` has the thrust of {measured} of {all} rotors, and the force rig measures the force on all of them; \
             identify the thrust of the whole vehicle on the rig"
        ))),
        (Some(1), None) => Err(Error::Arguments(format!(
            "card `{name}` has the thrust of one rotor, and the force rig measures the force on a whole vehicle; identify the \
             thrust on the rig, or set rotors in [vehicle]"
        ))),
        _ => Ok(()),
    }
}

/// The ground effect in every log, and a sentence for each log of which rows are not used, because a channel has a gap.
///
/// # Errors
/// A log without a needed channel, or that the card does not run on.
pub fn prepare_all(trials: &[&Trial], thrust: &Card) -> Result<Vec<(GroundTrial, Option<String>)>> {
    let one = |trial: &&Trial| {
        let (whole, gaps) = without_gaps(trial)?;
        let warning = (gaps > 0).then(|| {
            format!(
                "{gaps} of {} rows have a gap in a necessary channel and are not used",
                trial.len()
            )
        });
        Ok((prepare(&whole, thrust)?, warning))
    };
    trials.par_iter().map(one).collect()
}

/// Fits one form.
///
/// # Errors
/// As of [`fit`], and a fit of which no term is left.
pub fn fit_one(
    form: Form,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    with_terms(fit(form, trials, settings, origin)?)
}

/// Fits `forms`; `origin` gives the origin of the card of each, and `done` is called after each.
pub fn fit_forms(
    forms: &[Form],
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: impl Fn(Form) -> Origin + Sync,
    done: impl Fn() + Sync,
) -> FormFits {
    let one = |&form: &Form| {
        let fitted = fit_one(form, trials, settings, &origin(form));
        done();
        (form, fitted)
    };
    let fits: Vec<_> = forms.par_iter().map(one).collect();
    let mut sorted = FormFits::default();
    for (form, fit) in fits {
        match fit {
            Ok(fit) => {
                sorted.forms.push(form);
                sorted.cards.push(fit);
            }
            Err(e) => sorted.failed.push((form, e)),
        }
    }
    sorted
}

/// The levels of identification, fitted to four fifths of the logs and judged on the rest; none where there are too few
/// logs. `done` is called [`LEVEL_STEPS`] times at most.
///
/// # Errors
/// A smaller part that cannot be fitted.
pub fn held_out_levels(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
    done: impl Fn() + Sync,
) -> Result<Vec<Level>> {
    if trials.len() < FEWEST_LOGS {
        return Ok(Vec::new());
    }
    let held_out = |i: usize| i % HELD_OUT_EVERY == HELD_OUT_EVERY - 1;
    let part = |unseen: bool| -> Vec<GroundTrial> {
        let of_part = (0..trials.len()).filter(|&i| held_out(i) == unseen);
        of_part.map(|i| trials[i].clone()).collect()
    };
    let (training, unseen) = (part(false), part(true));
    let fits = COMPARED
        .into_par_iter()
        .map(|form| {
            let made = fit_one(form, &training, settings, origin)?;
            done();
            Ok((form, made))
        })
        .collect::<Result<Vec<_>>>()?;
    let fits: Vec<levels::Fitted<'_>> = fits
        .iter()
        .map(|(form, made)| levels::Fitted {
            form: *form,
            made,
            free_run_rmse_n: None,
        })
        .collect();
    levels::compare(&training, &unseen, &fits, settings)
}

/// Refuses a fit that kept no term: its card predicts nothing.
fn with_terms(fitted: FittedCard) -> Result<FittedCard> {
    if fitted.card.terms.is_empty() {
        let name = &fitted.card.name;
        return Err(Error::data(name, "data that support a term", "none"));
    }
    Ok(fitted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card(kind: Kind, form: Form, measured_rotors: Option<u32>) -> Card {
        let mut card = Origin::default().card("c", kind, form, "");
        card.measured_rotors = measured_rotors;
        card
    }

    #[test]
    fn analytic_a_card_without_terms_is_refused() {
        let fitted = FittedCard {
            card: card(Kind::GroundEffect, Form::Derivative, None),
            rmse: 0.0,
            rmse_unit: "N/s",
            rows_used: 0,
            lag_s: None,
            forms: Vec::new(),
            front: None,
            warnings: Vec::new(),
        };
        let error = with_terms(fitted).unwrap_err().to_string();
        assert_eq!(error, "c: expected data that support a term, found none");
    }

    #[test]
    fn prop_only_the_thrust_of_the_whole_vehicle_is_subtracted() {
        let thrust = |measured| card(Kind::Thrust, Form::StaticSqrt, measured);
        assert!(check_thrust_card(&thrust(Some(4)), Some(4)).is_ok());
        assert!(check_thrust_card(&thrust(None), None).is_ok());
        for (refused, rotors, words) in [
            (thrust(Some(1)), Some(4), "1 of 4 rotors"),
            (thrust(Some(1)), None, "set rotors in [vehicle]"),
            (
                card(Kind::GroundEffect, Form::Lag, None),
                Some(4),
                "key `kind`",
            ),
        ] {
            let error = check_thrust_card(&refused, rotors).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
