//! A constant for the settings of `touchdown-ffi`, the C interface of the controllers.

use touchdown_flight::ground_effect::{
    GroundEffectModel, Guarded, Outside, Validity, VelocityInput,
};
use touchdown_flight::thrust::ThrustModel;

use super::flying::FlyingModel;
use super::{ExportedFile, Number, c, comment};
use crate::card::Card;

/// One header with one constant, and for eq. (2) its coefficient.
pub(super) fn file(card: &Card, model: &FlyingModel<f32>, name: &str) -> ExportedFile {
    let constants = c::constants(model);
    let constants: Vec<_> = constants.iter().map(|value| value.literal()).collect();
    let coefficients = constants.join(", ");
    let text = match model {
        FlyingModel::Thrust(model) => format!(
            "/* settings.models.thrust = {name}; */\n\
             static const td_thrust_model {name} = {{\n    {},\n    {{{coefficients}}},\n}};\n",
            thrust_form(model)
        ),
        FlyingModel::GroundEffect(model) => ground_effect(model, &coefficients, name),
    };
    ExportedFile {
        name: format!("{name}.h"),
        text: c::header(
            &comment::lines(card, model),
            &format!("#include \"touchdown.h\"\n\n{text}"),
            name,
        ),
    }
}

fn thrust_form(model: &ThrustModel<f32>) -> &'static str {
    match model {
        ThrustModel::FirstOrder(_) => "TD_THRUST_FORM_FIRST_ORDER",
        ThrustModel::Library(_) => "TD_THRUST_FORM_LIBRARY",
        ThrustModel::Static(_) => "TD_THRUST_FORM_STATIC",
        ThrustModel::LaggedThrottle(_) => "TD_THRUST_FORM_LAGGED_THROTTLE",
        ThrustModel::LibraryOfRotors(_) => "TD_THRUST_FORM_LIBRARY_OF_ROTORS",
    }
}

fn ground_effect(model: &Guarded<f32>, coefficients: &str, name: &str) -> String {
    let (form, mu) = match &model.model {
        GroundEffectModel::None => ("NONE", None),
        GroundEffectModel::Empirical(m) => ("EMPIRICAL", Some(m)),
        GroundEffectModel::StaticMap(_) => ("STATIC_MAP", None),
        GroundEffectModel::Polynomial(_) => ("POLYNOMIAL", None),
        GroundEffectModel::Ratio(_) => ("RATIO", None),
        GroundEffectModel::Lag(_) => ("LAG", None),
    };
    let outside = match model.validity.outside {
        Outside::Clamp => "CLAMP",
        Outside::Fade => "FADE",
    };
    let velocity = match model.velocity {
        VelocityInput::Deck => "DECK",
        VelocityInput::NegativeRelative => "NEGATIVE_RELATIVE",
    };
    let v = &model.validity;
    let limits = [v.height_min_m, v.height_max_m, v.ratio_min, v.ratio_max];
    let limits = limits.map(Number::literal).join(", ");
    // TD_METHOD_EMPIRICAL has the coefficient alone.
    let mu = match mu {
        None => String::new(),
        Some(m) if m.rotor_offset_m != 0.0 => {
            "\n/* TD_METHOD_EMPIRICAL knows no rotor offset, and this card has one: \
             fly the model by TD_METHOD_DYNAMIC. */\n"
                .to_owned()
        }
        Some(m) => format!(
            "\n/* For TD_METHOD_EMPIRICAL: settings.models.empirical_mu = {name}_mu;\n \
             * That method has no limits of a card. Its own:\n * {}.\n \
             * For those of the card, take the constant above with TD_METHOD_DYNAMIC. */\n\
             static const float {name}_mu = {};\n",
            comment::limits(&Validity::<f32>::default()),
            m.mu.literal()
        ),
    };
    format!(
        "/* For TD_METHOD_DYNAMIC: settings.models.ground_effect = {name}; */\n\
         static const td_ground_effect {name} = {{\n    TD_GROUND_EFFECT_FORM_{form},\n    \
         {{{coefficients}}},\n    {limits},\n    TD_OUTSIDE_{outside},\n    \
         TD_VELOCITY_INPUT_{velocity},\n}};\n{mu}"
    )
}
