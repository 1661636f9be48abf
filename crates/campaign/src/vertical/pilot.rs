//! The methods by name, as controllers of the flight crate.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use touchdown_flight::control::{Composite, Imbc, Law, Ssc};
use touchdown_flight::deck::HarmonicFilter;
use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::reference::{Exponential, Reference};
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_model::{Card, Form};
use touchdown_sim::deck::DeckMotion;

use super::settings::LandSettings;
use crate::error::{Error, Result};

/// A method of landing.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Method I: eq. (10) without feedforward.
    Feedback,
    /// Method II: eq. (10) with eq. (2) fed forward.
    Empirical,
    /// Method III: eq. (10) with the identified dynamic model fed forward.
    Dynamic,
    /// Internal-model-based control, reconstructed.
    Imbc,
    /// Smooth sliding control, reconstructed.
    Ssc,
}

impl Method {
    /// All methods, in the order of tables.
    pub const ALL: [Self; 5] = [
        Self::Feedback,
        Self::Empirical,
        Self::Dynamic,
        Self::Imbc,
        Self::Ssc,
    ];

    /// The name on the command line and in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Feedback => "feedback",
            Self::Empirical => "empirical",
            Self::Dynamic => "dynamic",
            Self::Imbc => "imbc",
            Self::Ssc => "ssc",
        }
    }
}

/// The cards that controllers are made from.
#[derive(Clone, Debug)]
pub struct Cards {
    /// Throttle to thrust.
    pub thrust: Card,
    /// Eq. (2), for `empirical`.
    pub empirical: Option<Card>,
    /// The dynamic model, for `dynamic`.
    pub dynamic: Option<Card>,
}

/// Builds the controller of a method. `acceleration`: whether the deck's acceleration, estimated by the
/// harmonic filter, is fed forward (never for `imbc`, whose law has no such term).
///
/// # Errors
/// A card that cannot be flown, or settings out of range.
pub fn autopilot(
    method: Method,
    cards: &Cards,
    settings: &LandSettings,
    acceleration: bool,
) -> Result<VerticalController<f64>> {
    let (scenario, control) = (&settings.scenario, &settings.control);
    let deck_frequency = scenario.deck.angular_frequency();
    let law = match method {
        Method::Feedback | Method::Empirical | Method::Dynamic => Law::Composite(Composite {
            gains: control.gains,
        }),
        Method::Imbc => Law::Imbc(Imbc {
            k_p: control.gains.k_p,
            gamma: control.gains.gamma,
            poles_per_s: control.imbc_poles_per_s,
            // Over a deck at rest the internal model still needs a frequency: half a hertz, the deck's own.
            ..Imbc::new(deck_frequency.unwrap_or(PI))
        }),
        Method::Ssc => Law::Ssc(Ssc {
            k_p: control.gains.k_p,
            gamma: control.gains.gamma,
            rho_n: control.ssc_rho_n,
            phi_mps: control.ssc_phi_mps,
            filter_s: control.ssc_filter_s,
        }),
    };
    let none = || Guarded::new(GroundEffectModel::None, Validity::default());
    let ground_effect = match method {
        Method::Empirical => empirical(cards)?.ground_effect()?,
        Method::Dynamic => card(&cards.dynamic, method)?.ground_effect()?,
        _ => none(),
    };
    if acceleration && matches!(scenario.deck, DeckMotion::Triangle { .. }) {
        return Err(Error::Arguments(
            "the harmonic filter needs a deck that moves in a sine; this one moves in a triangle"
                .into(),
        ));
    }
    let deck = match deck_frequency {
        Some(w) if acceleration && method != Method::Imbc => Some(HarmonicFilter {
            lead_s: control.deck_lead_s,
            ..HarmonicFilter::new(w)
        }),
        _ => None,
    };
    let pilot = VerticalController {
        mass_kg: scenario.plant.mass_kg,
        gravity_mps2: scenario.plant.gravity_mps2,
        law,
        reference: Reference::Exponential(Exponential {
            c_per_s: control.c_per_s,
            start_height_m: scenario.start_height_m,
            end_height_m: control.end_height_m,
        }),
        thrust: cards.thrust.thrust_model()?,
        ground_effect,
        deck,
        limits: control.limits,
    };
    pilot.validate()?;
    Ok(pilot)
}

fn card(card: &Option<Card>, method: Method) -> Result<&Card> {
    card.as_ref().ok_or_else(|| {
        Error::Arguments(format!(
            "method `{}` needs a ground-effect card",
            method.name()
        ))
    })
}

/// The card of `empirical`, which is eq. (2) and nothing else.
fn empirical(cards: &Cards) -> Result<&Card> {
    let card = card(&cards.empirical, Method::Empirical)?;
    if card.form == Form::Empirical {
        return Ok(card);
    }
    Err(Error::Arguments(format!(
        "method `empirical` needs a card of form `empirical` (eq. 2); card `{}` is of form {:?}",
        card.name, card.form
    )))
}

/// Checks controllers' settings without any card.
///
/// # Errors
/// The first setting out of range.
pub fn check(settings: &LandSettings) -> Result<()> {
    let cards = Cards {
        thrust: Card::parse(touchdown_model::published::EQ_11, "eq11")?,
        empirical: None,
        dynamic: None,
    };
    for method in [Method::Feedback, Method::Imbc, Method::Ssc] {
        autopilot(method, &cards, settings, false)?;
    }
    Ok(())
}
