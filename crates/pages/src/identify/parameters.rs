//! The parameters of a model from flights, each with what it means.

use touchdown_identify::flights::result::FlightResult;
use touchdown_report::{Cell, Table};

use super::interval;

/// What each parameter means, by its name in the results.
const MEANINGS: [(&str, &str); 25] = [
    (
        "elasticity",
        "relative change of thrust over that of throttle, in hover",
    ),
    ("T_m", "lag of the motors"),
    ("dead_time", "delay of the measuring chain"),
    ("delay", "lag of the motors and dead time together"),
    (
        "drag",
        "part of the rotors' load that is drag; the rest is friction",
    ),
    (
        "curvature",
        "second order of √T over throttle; 0 without saturation",
    ),
    ("settling", "relative change of thrust after the start"),
    ("settling_time", "time constant of that change"),
    ("battery", "relative change of thrust per volt"),
    ("drift", "relative change of thrust per second"),
    ("damping", "relative loss of thrust per speed of climb"),
    ("near_damping", "what is added to it close to the ground"),
    (
        "amplitude",
        "relative ground effect at height 0, by its exponential curve",
    ),
    ("length", "height over which that curve falls to 37 %"),
    ("decay", "rate at which the ground effect falls with height"),
    ("mu", "factor of eq. (2)"),
    (
        "rotor_offset",
        "height of the rotors above the point of the logged height",
    ),
    (
        "images",
        "strength of the rotors' mirror images; 1 by theory",
    ),
    ("fountain", "strength of the fountain relative to an image"),
    (
        "fountain_distance",
        "distance of the rotors from the fountain",
    ),
    ("lag", "lag of the wake"),
    ("image_lag", "lag of the mirror images"),
    ("fountain_lag", "lag of the fountain"),
    (
        "accelerometer_latency",
        "age of the accelerometer's readings beside height and throttle",
    ),
    ("h", "coefficient of a bounded function of height"),
];

/// The parameters with their intervals.
pub(super) fn table(result: &FlightResult) -> Table {
    let mut table = Table::new("Parameters of the model, with 95 % intervals.")
        .text_column("parameter")
        .text_column("what it is")
        .number_column("value", "")
        .number_column("standard error", "")
        .number_column("95 % interval", "")
        .text_column("unit");
    for n in &result.numbers {
        table = table.row([
            Cell::text(n.words()),
            Cell::text(meaning(&n.name)),
            Cell::number(n.estimate.value, 4),
            Cell::number(n.estimate.std_error, 4),
            interval(n.estimate.ci95, 4),
            Cell::text(&n.unit),
        ]);
    }
    table.note(format!(
        "Intervals from {} {}, Student's t.",
        result.blocks,
        result.intervals_from.name()
    ))
}

/// What a parameter means; `h1`, `h2`, … mean the same.
fn meaning(name: &str) -> &'static str {
    let digits = |c: char| c.is_ascii_digit();
    let family = name.trim_end_matches(digits);
    let found = MEANINGS.iter().find(|(n, _)| *n == name || *n == family);
    found.map_or("", |(_, meaning)| *meaning)
}

#[cfg(test)]
mod tests {
    use super::*;
    use touchdown_identify::flights::model::{Curve, ModelTerms};

    #[test]
    fn prop_every_parameter_of_a_model_has_a_meaning() {
        let curves = [
            Curve::Exponential,
            Curve::Empirical,
            Curve::Rational,
            Curve::Images,
        ];
        for curve in curves {
            let all = ModelTerms {
                curvature: true,
                settling: true,
                battery: true,
                near_damping: true,
                accelerometer_latency: true,
                ..ModelTerms::plain(curve, true, true)
            };
            for parameter in all.parameters() {
                assert_ne!(meaning(parameter.name), "", "{}", parameter.name);
            }
        }
        assert_eq!(meaning("h2"), meaning("h1"));
    }
}
