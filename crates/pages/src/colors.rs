//! One table of colours: the same thing has the same colour in all panels of all pages.

use touchdown_campaign::policy::POLICY;
use touchdown_flight::Method;
use touchdown_model::Form;
use touchdown_report::Color;

/// Raw measurements: seen, but behind everything else.
pub const MEASURED: Color = Color::Rgb(0xB8, 0xBE, 0xC6);
/// The simulated truth, and the fitted curve of measured points.
pub const TRUTH: Color = Color::BLACK;
/// Figures that the paper prints.
pub const PUBLISHED: Color = Color::Rgb(0xB0, 0x00, 0x30);
/// What a controller is to follow.
pub const REFERENCE: Color = Color::Cycle(8);
/// What an estimator on board returns.
pub const ESTIMATED: Color = Color::Cycle(4);
/// What a predictor on board returns.
pub const FORECAST: Color = Color::Cycle(3);
/// The deck or plate.
pub const DECK: Color = Color::Rgb(0x6B, 0x8E, 0x23);
/// Inputs that the reader needs for orientation: throttle, height.
pub const INPUT: Color = Color::GREY;
/// Force of the feet on the deck.
pub const FEET: Color = Color::Cycle(13);
/// Trials of any method, in figures whose axis names the method.
pub const TRIALS: Color = Color::Rgb(0x5A, 0x6B, 0x7D);
/// Errors on the data of the fit.
pub const TRAINING: Color = Color::GREY;
/// Errors on held-out trials.
pub const HELD_OUT: Color = Color::Cycle(14);

/// Error of a model's own terms beside those of the best subsets.
pub const OWN_TERMS: Color = Color::Cycle(3);

const DYNAMIC: Color = Color::Cycle(0);
const EMPIRICAL: Color = Color::Cycle(1);
const IMBC: Color = Color::Cycle(2);
const SSC: Color = Color::Cycle(3);
const FEEDBACK: Color = Color::Cycle(5);
const OBSERVER: Color = Color::Cycle(10);
const DYNAMIC_OBSERVER: Color = Color::Cycle(15);
const LEARNED: Color = Color::Cycle(11);

/// The colour of a method of vertical landing.
pub fn of_method(method: Method) -> Color {
    of_controller(method.name()).unwrap_or(Color::GREY)
}

/// The colour of a controller in space by its name: that of the same method in vertical landings.
pub fn of_controller(name: &str) -> Option<Color> {
    Some(match name {
        "feedback" => FEEDBACK,
        "empirical" => EMPIRICAL,
        "dynamic" => DYNAMIC,
        "imbc" => IMBC,
        "ssc" => SSC,
        "observer" => OBSERVER,
        "dynamic+observer" => DYNAMIC_OBSERVER,
        POLICY => LEARNED,
        _ => return None,
    })
}

/// The colour of a model by its form; models that are flown have their method's.
pub fn of_form(form: Form) -> Color {
    match form {
        Form::Lag => DYNAMIC,
        Form::Empirical => EMPIRICAL,
        Form::Static | Form::StaticSqrt | Form::StaticThrust => Color::Cycle(4),
        Form::Derivative => Color::Cycle(11),
        Form::Ratio | Form::RotorLag => Color::Cycle(2),
        Form::Library => Color::Cycle(9),
        Form::FirstOrder => Color::Rgb(0xC0, 0x20, 0xA0),
        // The form of lagged motors, and forms that have no colour of their own.
        _ => Color::Cycle(3),
    }
}

/// A colour for each of several models: its form's, or the next that none of them has where two share a form.
pub fn of_models(forms: &[Form]) -> Vec<Color> {
    let mut taken: Vec<Color> = Vec::new();
    for form in forms {
        let others = (0..16).map(Color::Cycle);
        let free =
            |color: &Color| !taken.contains(color) && !forms.iter().any(|f| of_form(*f) == *color);
        let own = Some(of_form(*form)).filter(|color| !taken.contains(color));
        taken.push(
            own.or_else(|| others.into_iter().find(free))
                .unwrap_or(Color::GREY),
        );
    }
    taken
}

/// Flights that colours tell apart; more have one colour.
pub const FLIGHTS: usize = 16;

/// The colour of the `index`-th of several flights: no method and no form has it.
pub fn of_flight(index: usize, flights: usize) -> Color {
    match flights {
        0..=1 => shade(0.25),
        2..=FLIGHTS => shade(index as f64 / (flights - 1) as f64),
        _ => shade(0.25),
    }
}

/// From cool and dark to warm and light, for a quantity that runs from 0 to 1 (after the map viridis, without its lightest end).
pub fn shade(share: f64) -> Color {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 190.0, 90.0],
        [200.0, 190.0, 20.0],
    ];
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (place as usize).min(STOPS.len() - 2);
    let [r, g, b] = [0, 1, 2].map(|k| {
        let mixed = STOPS[i][k] + (place - i as f64) * (STOPS[i + 1][k] - STOPS[i][k]);
        mixed.round() as u8
    });
    Color::Rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_method_and_its_model_share_a_colour() {
        assert_eq!(of_method(Method::Dynamic), of_form(Form::Lag));
        assert_eq!(of_method(Method::Empirical), of_form(Form::Empirical));
        let colors = Method::ALL.map(of_method);
        for (i, color) in colors.iter().enumerate() {
            assert!(!colors[..i].contains(color) && *color != Color::GREY);
        }
        let others = [DECK, TRIALS, REFERENCE, ESTIMATED, FEET, of_flight(0, 1)];
        let flights = (0..FLIGHTS).map(|i| of_flight(i, FLIGHTS));
        for other in others.into_iter().chain(flights) {
            assert!(!colors.contains(&other), "{other:?}");
        }
    }

    #[test]
    fn prop_models_of_one_form_are_apart() {
        let colors = of_models(&[Form::Lag, Form::Lag, Form::Static, Form::Lag]);
        assert_eq!(
            (colors[0], colors[2]),
            (of_form(Form::Lag), of_form(Form::Static))
        );
        for i in 0..4 {
            assert!(!colors[..i].contains(&colors[i]));
        }
    }

    #[test]
    fn analytic_shades_keep_within_the_map() {
        assert_eq!(shade(0.0), Color::Rgb(68, 1, 84));
        assert_eq!(shade(0.5), Color::Rgb(33, 145, 140));
        assert_eq!(shade(2.0), Color::Rgb(200, 190, 20));
    }
}
