//! The comment above an export: what the code is made of, and where it may be believed.

use touchdown_flight::Real;
use touchdown_flight::ground_effect::{Outside, Validity};
use touchdown_flight::real::r;
use touchdown_flight::thrust::ThrustModel;

use super::flying::{FlyingModel, rotors_flown};
use super::in_comment;
use crate::card::{Card, Kind};

/// Steps of throttle over which the thrust at rest is looked at.
const THROTTLE_STEPS: u16 = 200;
/// Share of the greatest thrust by which the thrust at rest falls before that is stated. A stand measures no thrust better
/// than to 0.1 %, and single precision is a thousand times finer.
const FALLS_FROM: f64 = 1e-3;

/// The lines of the comment.
pub(super) fn lines<R: Real>(card: &Card, model: &FlyingModel<R>) -> Vec<String> {
    let mut lines = vec![
        format!("Model card `{}`: {}", card.name, card.equation),
        format!(
            "Written by touchdown {} (touchdown export), not by hand.",
            env!("CARGO_PKG_VERSION")
        ),
    ];
    match model {
        FlyingModel::Thrust(model) => thrust(card, model, &mut lines),
        FlyingModel::GroundEffect(model) => lines.push(limits(&model.validity)),
    }
    for (input, [low, high]) in &card.validity.inputs {
        lines.push(format!("Data: {} in [{low:?}, {high:?}]", described(input)));
    }
    if let (Kind::Thrust, Some([low, high])) = (card.kind, card.validity.output) {
        lines.push(format!("Data: measured thrust, N in [{low:?}, {high:?}]"));
    }
    lines.extend(card.warnings.iter().map(|text| format!("Warning: {text}")));
    lines.iter().map(|line| in_comment(line)).collect()
}

fn thrust<R: Real>(card: &Card, model: &ThrustModel<R>, lines: &mut Vec<String>) {
    lines.push(match (card.measured_rotors, rotors_flown(card)) {
        (Some(measured), Some(flown)) => format!(
            "Thrust: of {flown} rotor(s); measured with {measured}, so {:.6} times the measured thrust",
            f64::from(flown) / f64::from(measured)
        ),
        _ => "Thrust: of all rotors of the vehicle, measured together".to_owned(),
    });
    if let Some(lag_s) = card.assumed_lag_s() {
        lines.push(format!(
            "Motor lag: {lag_s} s, assumed: the card has none that was identified"
        ));
    }
    if let Some(Ok(volts)) = card.flown_battery_v() {
        lines.push(format!(
            "Battery: {volts:.3} V, the middle of the data; the model does not follow the voltage in flight"
        ));
    }
    if let Some([from, to]) = falls(model) {
        lines.push(format!(
            "Thrust at rest falls between the throttles {from} and {to}: of two throttles with the same thrust the inverse \
             gives the smaller one"
        ));
    }
}

/// The limits that the code keeps.
pub(super) fn limits<R: Real>(validity: &Validity<R>) -> String {
    let outside = match validity.outside {
        Outside::Clamp => "stays as at the greatest height",
        Outside::Fade => "falls to zero over one further range of heights",
    };
    // To the digits that single precision has.
    let digits = |x: R| (x.to_f64() * 1e6).round() / 1e6;
    format!(
        "Limits: heights {} to {} m, force over thrust {} to {}; above, the lift {outside}",
        digits(validity.height_min_m),
        digits(validity.height_max_m),
        digits(validity.ratio_min),
        digits(validity.ratio_max)
    )
}

/// An input of a card with its meaning and unit.
fn described(symbol: &str) -> String {
    let meaning = match symbol {
        "s" => "throttle, from 0 to 1",
        "u" => "battery voltage, V",
        "x" => "root of the thrust, sqrt(N)",
        "T" => "free-air thrust, N",
        "f" => "ground-effect force, N",
        "z" => "height above the deck, m",
        "v_p" => "velocity of the deck, m/s, up",
        "v_q" => "velocity of the vehicle, m/s, up",
        _ => return symbol.to_owned(),
    };
    format!("{symbol} ({meaning})")
}

/// The throttles between which the thrust at rest first falls.
fn falls<R: Real>(model: &ThrustModel<R>) -> Option<[f64; 2]> {
    let throttle = |i: u16| f64::from(i) / f64::from(THROTTLE_STEPS);
    let at_rest = |i: u16| model.rest(r(throttle(i))).to_f64().powi(2);
    let thrusts: Vec<f64> = (0..=THROTTLE_STEPS).map(at_rest).collect();
    let least_n = FALLS_FROM * thrusts.iter().copied().fold(0.0, f64::max);
    let (mut top, mut bottom) = (0, None);
    for (i, pair) in (1..).zip(thrusts.windows(2)) {
        match bottom {
            None if pair[1] >= thrusts[usize::from(top)] => top = i,
            None if pair[1] < thrusts[usize::from(top)] - least_n => bottom = Some(i),
            Some(_) if pair[1] < pair[0] => bottom = Some(i),
            Some(_) => break,
            None => {}
        }
    }
    bottom.map(|bottom| [throttle(top), throttle(bottom)])
}

#[cfg(test)]
mod tests {
    use touchdown_flight::thrust::StaticThrust;

    use super::super::tests::cards;
    use super::super::{Language, Precision, export};
    use super::*;
    use crate::card::Form;

    const LANGUAGES: [(Language, &str); 3] = [
        (Language::C, " * "),
        (Language::CSettings, " * "),
        (Language::Rust, "// "),
    ];

    fn of(form: Form) -> Card {
        cards().into_iter().find(|card| card.form == form).unwrap()
    }

    /// The comment above an export, without the marks of the language.
    fn comment(card: &Card, language: Language, mark: &str) -> Vec<String> {
        let files = export(card, language, Precision::Single).unwrap();
        let above = files[0].text.lines();
        let lines = above.take_while(|line| line.starts_with(mark) || line.starts_with("/* "));
        lines
            .map(|line| {
                line.trim_start_matches(mark)
                    .trim_start_matches("/* ")
                    .to_owned()
            })
            .collect()
    }

    #[test]
    fn regress_all_languages_have_the_comment() {
        for mut card in cards() {
            card.warnings = vec!["a warning".into()];
            let [c, settings, rust] =
                LANGUAGES.map(|(language, mark)| comment(&card, language, mark));
            assert!(c == settings && c == rust, "{c:?} {settings:?} {rust:?}");
            assert_eq!(c.last().unwrap(), "Warning: a warning");
            let ranges = c.iter().filter(|line| line.starts_with("Data: "));
            assert!(ranges.count() >= card.validity.inputs.len());
        }
    }

    #[track_caller]
    fn states(card: &Card, expected: &str) {
        let lines = comment(card, Language::C, " * ");
        assert!(lines.iter().any(|line| line == expected), "{lines:#?}");
    }

    #[test]
    fn regress_the_comment_states_what_a_thrust_is_of() {
        let mut card = of(Form::Library);
        states(
            &card,
            "Thrust: of all rotors of the vehicle, measured together",
        );
        card.measured_rotors = Some(1);
        card.vehicle.rotors = Some(4);
        states(
            &card,
            "Thrust: of 4 rotor(s); measured with 1, so 4.000000 times the measured thrust",
        );
        let mut card = of(Form::StaticThrust);
        card.terms[1].expression = "s*u".into();
        card.terms[1].value = 0.7;
        card.validity.inputs.insert("u".into(), [13.2, 16.4]);
        states(
            &card,
            "Battery: 14.800 V, the middle of the data; the model does not follow the voltage in flight",
        );
        states(&card, "Data: u (battery voltage, V) in [13.2, 16.4]");
        let assumed = "Motor lag: 0.05 s, assumed: the card has none that was identified";
        states(&card, assumed);
        let mut card = of(Form::StaticSqrt);
        let lines = comment(&card, Language::C, " * ");
        assert!(
            !lines
                .iter()
                .any(|line| line == assumed || line.contains("Battery"))
        );
        card.terms.retain(|term| term.of != "T_m");
        states(&card, assumed);
    }

    #[test]
    fn regress_the_comment_states_a_falling_thrust() {
        let mut card = of(Form::StaticSqrt);
        let falls = |card: &Card| {
            let lines = comment(card, Language::C, " * ");
            lines
                .into_iter()
                .find(|line| line.contains("falls between"))
        };
        assert_eq!(falls(&card), None);
        // √T = 0.3 + 8.1 s - 5.4 s²: its greatest value at s = 0.75.
        card.terms[2].value = -5.4;
        card.terms[3].value = 0.0;
        let found = falls(&card).unwrap();
        assert!(
            found.contains("between the throttles 0.75 and 1:"),
            "{found}"
        );
    }

    #[test]
    fn analytic_the_falling_part_of_a_curve_is_found() {
        let curve = |coefficients| {
            falls(&ThrustModel::Static(StaticThrust {
                coefficients,
                t_m_s: 0.05,
            }))
        };
        // √T = 8 s - 5 s²: its greatest value at s = 0.8.
        assert_eq!(curve([0.0, 8.0, -5.0, 0.0]), Some([0.8, 1.0]));
        assert_eq!(curve([0.0, 5.0, 0.0, 0.0]), None);
        // √T = 1 + 6 s - 15 s² + 10 s³ falls between the roots of 6 - 30 s + 30 s², 0.276 and 0.724: in steps of 0.005.
        let [from, to] = curve([1.0, 6.0, -15.0, 10.0]).unwrap();
        assert!(
            (from - 0.276).abs() < 0.005 && (to - 0.724).abs() < 0.005,
            "{from} {to}"
        );
    }
}
