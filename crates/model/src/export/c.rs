//! C99.

use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Outside, VelocityInput};
use touchdown_flight::real::r;
use touchdown_flight::thrust::{Library, ThrustModel};

use super::flying::FlyingModel;
use super::{ExportedFile, Number, comment, vectors};
use crate::card::Card;

macro_rules! piece {
    ($name:literal) => {
        include_str!(concat!("c/", $name, ".c"))
    };
}
pub(super) use piece;

/// What makes a family's code: its pieces of C in their order, and its numbers.
struct Family<R> {
    pieces: Vec<&'static str>,
    constants: Vec<R>,
}

/// Source, header, test with its vectors, and Makefile.
pub(super) fn files<R: Number>(
    card: &Card,
    model: &FlyingModel<R>,
    name: &str,
) -> Vec<ExportedFile> {
    let (family, header, limits) = match model {
        FlyingModel::Thrust(model) => (thrust::<R>(model), include_str!("c/thrust.h"), None),
        FlyingModel::GroundEffect(model) => (
            ground_effect(model),
            include_str!("c/ground.h"),
            Some(model),
        ),
    };
    let lines = comment::lines(card, model);
    let file = |extension: &str, text: String| ExportedFile {
        name: format!("{name}{extension}"),
        text,
    };
    vec![
        file(".c", source(&lines, &family, limits, name)),
        file(".h", self::header(&lines, &filled::<R>(header, name), name)),
        file("_test.c", vectors::test_program(model, name)),
        ExportedFile {
            name: "Makefile".to_owned(),
            text: include_str!("c/Makefile.in").replace("NAME", name),
        },
    ]
}

/// The elementary functions that a family needs: exponential and sine, or `exp(x) - 1`.
pub(super) fn elementary<R: Number>(with_sine: bool) -> Vec<&'static str> {
    let single = R::TYPES[0] == "float";
    let mut pieces = if single {
        vec![piece!("float_bits"), piece!("float_exponential")]
    } else {
        vec![piece!("double_bits"), piece!("double_exponential")]
    };
    match (with_sine, single) {
        (true, true) => pieces.push(piece!("float_sine")),
        (true, false) => pieces.extend([piece!("double_exp"), piece!("double_sine")]),
        (false, true) => pieces.push(piece!("float_exp_m1")),
        (false, false) => pieces.push(piece!("double_exp_m1")),
    }
    pieces
}

fn thrust<R: Number>(model: &ThrustModel<R>) -> Family<R> {
    let mut pieces = vec![piece!("basics")];
    let is_library = matches!(
        model,
        ThrustModel::Library(_) | ThrustModel::LibraryOfRotors(_)
    );
    pieces.extend(elementary::<R>(is_library));
    let (middle, constants): (Vec<&str>, Vec<R>) = match model {
        ThrustModel::FirstOrder(m) => (
            vec![piece!("lag"), piece!("cubic"), piece!("thrust_first_order")],
            vec![m.c0, m.c1, m.t_m_s],
        ),
        ThrustModel::Library(m) => (
            vec![piece!("min"), piece!("cubic"), piece!("thrust_library")],
            library(m).to_vec(),
        ),
        ThrustModel::LibraryOfRotors(m) => (
            vec![
                piece!("min"),
                piece!("cubic"),
                piece!("thrust_library_names"),
                piece!("thrust_library"),
                piece!("thrust_library_of_rotors"),
            ],
            [&library(&m.library)[..], &[m.root_factor]].concat(),
        ),
        ThrustModel::Static(m) => (
            vec![piece!("lag"), piece!("cubic"), piece!("thrust_static")],
            [&m.coefficients[..], &[m.t_m_s]].concat(),
        ),
        ThrustModel::LaggedThrottle(m) => (
            vec![
                piece!("lag"),
                piece!("cubic"),
                piece!("thrust_lagged_throttle"),
            ],
            [&m.coefficients[..], &[m.t_m_s]].concat(),
        ),
    };
    pieces.extend(middle);
    pieces.push(piece!("thrust"));
    Family { pieces, constants }
}

/// The coefficients of eq. (8), in the order of the C code.
fn library<R: Number>(m: &Library<R>) -> [R; 8] {
    [m.one, m.x, m.s, m.s2, m.x3, m.s3, m.exp_neg_x_s, m.sin_x_s]
}

fn ground_effect<R: Number>(guarded: &Guarded<R>) -> Family<R> {
    let mut pieces = vec![piece!("basics")];
    let constants = match &guarded.model {
        // A card always has a model; none is a map that is zero.
        GroundEffectModel::None => {
            pieces.extend([
                piece!("ground_memoryless"),
                piece!("psi"),
                piece!("ground_static"),
            ]);
            vec![R::ZERO, R::ZERO, R::ZERO, R::ZERO, R::ONE, R::ONE, R::ONE]
        }
        GroundEffectModel::Empirical(m) => {
            pieces.extend([
                piece!("ground_memoryless"),
                piece!("min"),
                piece!("ground_empirical"),
            ]);
            vec![m.mu, m.rotor_radius_m, m.rotor_offset_m]
        }
        GroundEffectModel::StaticMap(m) => {
            pieces.extend([
                piece!("ground_memoryless"),
                piece!("psi"),
                piece!("ground_static"),
            ]);
            [&m.h[..], &m.length_m].concat()
        }
        GroundEffectModel::Polynomial(m) => {
            pieces.extend(elementary::<R>(false));
            pieces.extend([piece!("lags"), piece!("ground_polynomial")]);
            m.theta.to_vec()
        }
        GroundEffectModel::Ratio(m) => {
            pieces.extend(elementary::<R>(false));
            pieces.extend([piece!("lags"), piece!("psi"), piece!("ground_ratio")]);
            [&m.xi[..], &m.length_m].concat()
        }
        GroundEffectModel::Lag(m) => {
            pieces.extend(elementary::<R>(false));
            pieces.extend([piece!("lag"), piece!("psi"), piece!("ground_lag")]);
            [&m.map.h[..], &m.map.length_m, &m.k, &[m.tau_s]].concat()
        }
    };
    pieces.push(piece!("ground"));
    Family { pieces, constants }
}

/// The comment on top of both files.
fn opening(lines: &[String]) -> String {
    format!("/* {}\n */\n", lines.join("\n * "))
}

/// The coefficients of a model, in the order of its C code.
pub(super) fn constants<R: Number>(model: &FlyingModel<R>) -> Vec<R> {
    match model {
        FlyingModel::Thrust(model) => thrust(model).constants,
        FlyingModel::GroundEffect(model) => ground_effect(model).constants,
    }
}

/// A header with its guard.
pub(super) fn header(lines: &[String], declarations: &str, name: &str) -> String {
    guarded_header(&opening(lines), "", declarations, name)
}

/// A header with its guard: opening comment, includes, and declarations with C linkage.
pub(super) fn guarded_header(
    opening: &str,
    includes: &str,
    declarations: &str,
    name: &str,
) -> String {
    let guard = format!("{}_H", name.to_ascii_uppercase());
    let includes = if includes.is_empty() {
        String::new()
    } else {
        format!("{includes}\n")
    };
    format!(
        "{opening}#ifndef {guard}\n#define {guard}\n\n{includes}#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n\
         {declarations}\n#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )
}

fn source<R: Number>(
    lines: &[String],
    family: &Family<R>,
    limits: Option<&Guarded<R>>,
    name: &str,
) -> String {
    let mut text = format!(
        "#include \"{name}.h\"\n\n#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n\
         #include <string.h>\n\n/* Coefficients, in the order that the model's comment names. */\n\
         static const REAL C[{}] = {{\n",
        family.constants.len()
    );
    for value in &family.constants {
        text.push_str(&format!("    {},\n", value.literal()));
    }
    text.push_str("};\n");
    if family.pieces.contains(&piece!("cubic")) {
        let epsilon = R::EPSILON.literal();
        text.push_str(&format!("static const REAL EPSILON = {epsilon};\n"));
    }
    if let Some(guarded) = limits {
        let v = &guarded.validity;
        text.push_str("/* Where the model may be believed: heights of the data, f / T. */\n");
        for (limit, value) in [
            ("HEIGHT_MIN_M", v.height_min_m),
            ("HEIGHT_MAX_M", v.height_max_m),
            ("RATIO_MIN", v.ratio_min),
            ("RATIO_MAX", v.ratio_max),
        ] {
            text.push_str(&format!(
                "static const REAL {limit} = {};\n",
                value.literal()
            ));
        }
    }
    for piece in &family.pieces {
        text.push('\n');
        text.push_str(piece);
    }
    let velocity = match limits.map(|guarded| guarded.velocity) {
        Some(VelocityInput::NegativeRelative) => {
            "    /* Identified under a vehicle at rest: -v for the deck's velocity. */\n    \
             result.vehicle_velocity_mps = R(0.0);\n    result.deck_velocity_mps = \
             input->deck_velocity_mps - input->vehicle_velocity_mps;\n"
        }
        _ => "",
    };
    let outside = match limits.map(|guarded| guarded.validity.outside) {
        Some(Outside::Fade) => {
            "    /* Above the box the lift falls to zero over one further range of heights. */\n    \
             remaining = clamp_of(R(1.0) - (state->input.height_m - HEIGHT_MAX_M) / (HEIGHT_MAX_M - \
             HEIGHT_MIN_M), R(0.0), R(1.0));\n"
        }
        _ => "",
    };
    let text = text
        .replace("@VELOCITY@", velocity)
        .replace("@OUTSIDE@", outside);
    // The card's own text is not code.
    opening(lines) + &filled::<R>(&text, name)
}

/// Pieces of C with names, type and literals of the precision.
pub(super) fn filled<R: Number>(text: &str, name: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    // R(0.5) is a literal of the type: the constant in double precision, rounded.
    while let Some(start) = literal_start(rest) {
        out.push_str(&rest[..start]);
        let inner = &rest[start + 2..];
        let end = inner.find(')').unwrap_or(inner.len());
        match inner[..end].parse::<f64>() {
            Ok(value) => out.push_str(&r::<R>(value).literal()),
            Err(_) => out.push_str(&rest[start..start + 2 + end + 1]),
        }
        rest = &inner[(end + 1).min(inner.len())..];
    }
    out.push_str(rest);
    out.replace("fabsR", &format!("fabs{}", R::ENDING))
        .replace("sqrtR", &format!("sqrt{}", R::ENDING))
        .replace("REAL", R::TYPES[0])
        .replace("NAME_", &format!("{name}_"))
}

/// The next `R(` that does not end a longer word.
fn literal_start(text: &str) -> Option<usize> {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices("R(")
        .map(|(at, _)| at)
        .find(|&at| !text[..at].ends_with(word))
}
