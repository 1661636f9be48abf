//! The vertical controller in C99: the laws of `touchdown-flight` with the models of two cards.

use touchdown_flight::Measurement;
use touchdown_flight::deck::HarmonicFilter;
use touchdown_flight::error::SettingsError;
use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::method::{Feedforward, Method, VerticalLanding, VerticalSettings};
use touchdown_flight::real::r;
use touchdown_flight::thrust::ThrustModel;
use touchdown_flight::types::Limits;
use touchdown_flight::vertical_controller::VerticalController;

use super::c::{elementary, filled, guarded_header, piece};
use super::flying::FlyingModel;
use super::vectors::{Sequence, dt, test_of};
use super::{ExportedFile, Number, Precision, identifier};
use crate::card::{Card, Form};
use crate::error::CardError;

/// Name of the files and of all that they define.
pub const VERTICAL_NAME: &str = "vertical";
/// Acceleration of gravity in the exported settings, m/s².
const GRAVITY_MPS2: f64 = 9.81;
/// Height at which the descent begins in the exported settings: the paper's landings on the ground, m.
const START_HEIGHT_M: f64 = 0.8;
/// Frequency of the deck in the recorded vectors, rad/s: half a hertz, as the paper's.
const DECK_ANGULAR_FREQUENCY: f64 = core::f64::consts::PI;
/// Recorded steps of each configuration: 1.5 s, in which both limits are met.
const STEPS: usize = 150;
/// The vertical controller of a method in C99, which calls the exports of its cards: `thrust`, and
/// `ground_effect` where the method feeds a model forward. They are expected in folders beside.
///
/// # Errors
/// A card of the wrong kind or without the vehicle's mass, a method that does not fly vertically,
/// or a model that the method does not feed forward.
pub fn export_vertical(
    thrust: &Card,
    ground_effect: Option<&Card>,
    method: Method,
    precision: Precision,
) -> Result<Vec<ExportedFile>, CardError> {
    check(thrust, ground_effect, method)?;
    match precision {
        Precision::Single => files::<f32>(thrust, ground_effect, method),
        Precision::Double => files::<f64>(thrust, ground_effect, method),
    }
}

fn refused(card: &Card, reason: String) -> CardError {
    CardError::NotForFlight {
        card: card.name.clone(),
        reason,
    }
}

fn check(thrust: &Card, ground_effect: Option<&Card>, method: Method) -> Result<(), CardError> {
    let name = method.name();
    if !Method::VERTICAL.contains(&method) {
        let reason = format!("method `{name}` needs an inertial unit and flies in space only");
        return Err(refused(thrust, reason));
    }
    match (method.feedforward(), ground_effect) {
        (Feedforward::None, None) => Ok(()),
        (Feedforward::None, Some(card)) => Err(refused(
            card,
            format!("method `{name}` feeds no ground effect forward; leave this card out"),
        )),
        (_, None) => Err(refused(
            thrust,
            format!("method `{name}` feeds the ground effect forward; expected its card as well"),
        )),
        (feedforward, Some(card)) => {
            if (card.form == Form::Empirical) == (feedforward == Feedforward::Empirical) {
                Ok(())
            } else {
                let form = card.form.name();
                let reason =
                    format!("method `{name}` does not feed a model of form `{form}` forward");
                Err(refused(card, reason))
            }
        }
    }
}

/// The models and settings that an export is made of.
struct Export<R: Number> {
    thrust: ThrustModel<R>,
    ground_effect: Guarded<R>,
    mass_kg: R,
    limits: Limits<R>,
}

impl<R: Number> Export<R> {
    fn new(thrust: &Card, ground_effect: Option<&Card>) -> Result<Self, CardError> {
        let FlyingModel::Thrust(model) = FlyingModel::<R>::of(thrust)? else {
            return Err(refused(thrust, "expected a thrust card".into()));
        };
        let air = match ground_effect.map(FlyingModel::<R>::of).transpose()? {
            Some(FlyingModel::GroundEffect(air)) => air,
            Some(FlyingModel::Thrust(_)) => {
                return Err(refused(
                    thrust,
                    "expected one thrust card, found two".into(),
                ));
            }
            None => Guarded::new(GroundEffectModel::None, Validity::default()),
        };
        let mass_kg = thrust.vehicle.mass_kg.ok_or_else(|| {
            let reason = "expected the vehicle's mass for its controller; set `vehicle.mass_kg`";
            refused(thrust, reason.into())
        })?;
        let full = model.rest(R::ONE);
        Ok(Self {
            thrust: model,
            ground_effect: air,
            mass_kg: r(mass_kg),
            limits: Limits {
                // No throttle gives more than the model's thrust at full throttle.
                thrust_max_n: full * full,
                ..Limits::default()
            },
        })
    }

    fn controller(
        &self,
        method: Method,
        moves: bool,
    ) -> Result<VerticalController<R>, SettingsError> {
        let settings = VerticalSettings {
            limits: self.limits,
            ..VerticalSettings::default()
        };
        let landing = VerticalLanding {
            mass_kg: self.mass_kg,
            gravity_mps2: r(GRAVITY_MPS2),
            start_height_m: r(START_HEIGHT_M),
            deck_angular_frequency: moves.then_some(r(DECK_ANGULAR_FREQUENCY)),
            deck_acceleration: moves,
        };
        settings.controller(method, &landing, self.thrust, self.ground_effect)
    }

    /// The settings in C, in the order of their declaration.
    fn settings(&self, method: Method) -> String {
        let settings = VerticalSettings::<R>::default();
        let gains = settings.gains;
        let deck = HarmonicFilter::<R>::new(r(DECK_ANGULAR_FREQUENCY));
        let text = |values: &[R]| {
            let values: Vec<_> = values.iter().map(|value| value.literal()).collect();
            values.join(", ")
        };
        let lines = [
            text(&[self.mass_kg, r(GRAVITY_MPS2)]),
            law_name(method).to_owned(),
            text(&[gains.k_p, gains.gamma, gains.k_i, gains.integral_limit_n]),
            text(&[deck.angular_frequency]),
            format!("{{{}}}", text(&settings.imbc_poles_per_s)),
            text(&[
                settings.ssc_rho_n,
                settings.ssc_phi_mps,
                settings.ssc_filter_s,
            ]),
            text(&[settings.c_per_s, r(START_HEIGHT_M), settings.end_height_m]),
            "false".to_owned(),
            text(&[deck.angular_frequency, deck.measurement_sd, deck.process_sd]),
            text(&[deck.enable_after_s, settings.deck_lead_s]),
            text(&[self.limits.thrust_min_n, self.limits.thrust_max_n]),
            text(&[self.limits.throttle_min, self.limits.throttle_max]),
        ];
        lines.map(|line| format!("    {line},\n")).concat()
    }

    /// Rows of the law, whether the deck filter runs, the measurement, dt, and the command. The
    /// first row of a configuration holds its start and the throttle there.
    fn rows(&self, method: Method) -> Result<Vec<Vec<R>>, SettingsError> {
        // Eq. (10) flies with the exported model, or with none.
        let composite = match method {
            Method::Imbc | Method::Ssc => Method::Feedback,
            method => method,
        };
        let recorded = [
            (composite, false),
            (composite, true),
            (Method::Imbc, true),
            (Method::Ssc, false),
            (Method::Ssc, true),
        ];
        let mut rows = Vec::new();
        for (of, moves) in recorded {
            let controller = self.controller(of, moves)?;
            rows.extend(landing(&controller, law_number(of), moves));
        }
        Ok(rows)
    }
}

fn law_name(method: Method) -> &'static str {
    match method {
        Method::Imbc => "NAME_IMBC",
        Method::Ssc => "NAME_SSC",
        _ => "NAME_COMPOSITE",
    }
}

fn law_number<R: Number>(method: Method) -> R {
    match method {
        Method::Imbc => R::ONE,
        Method::Ssc => r(2.0),
        _ => R::ZERO,
    }
}

/// A recorded landing: noisy measurements of a descent, with values that are not finite, steps of
/// other lengths, and far errors that meet the limits.
fn landing<R: Number>(controller: &VerticalController<R>, law: R, moves: bool) -> Vec<Vec<R>> {
    let mut sequence = Sequence::new(3);
    let mut measurement = Measurement {
        height_m: r(START_HEIGHT_M),
        ..Measurement::default()
    };
    let flag = if moves { R::ONE } else { R::ZERO };
    let throttle = r(0.6);
    let row = |m: &Measurement<R>, dt: R, command: [R; 3]| {
        let measured = [m.height_m, m.relative_velocity_mps, m.vehicle_velocity_mps];
        [&[law, flag], &measured[..], &[dt], &command[..]].concat()
    };
    let mut state = controller.initial(&measurement, throttle);
    let sent = state.vertical.command;
    let start = [sent.thrust_n, sent.throttle, R::ZERO];
    // Not a time step: the start, whose dt is the throttle that is being sent.
    let mut rows = vec![row(&measurement, throttle, start)];
    for step in 0..STEPS {
        // Whole numbers below 150 are exact.
        #[allow(clippy::cast_precision_loss)]
        let share = step as f64 / STEPS as f64;
        let far = if step % 50 > 44 { 4.0 } else { 0.05 };
        measurement.height_m = r(START_HEIGHT_M * (1.0 - share) + far * (sequence.next() - 0.5));
        measurement.relative_velocity_mps = r(-0.2 + far * (sequence.next() - 0.5));
        measurement.vehicle_velocity_mps = r(-0.2 + 0.4 * (sequence.next() - 0.5));
        match step % 41 {
            7 => measurement.height_m = r(f64::NAN),
            17 => measurement.vehicle_velocity_mps = r(f64::INFINITY),
            29 => measurement.relative_velocity_mps = r(f64::NAN),
            _ => {}
        }
        let dt = dt(step);
        let command = controller.step(&mut state, &measurement, dt);
        let command = [command.thrust_n, command.throttle, command.ground_effect_n];
        rows.push(row(&measurement, dt, command));
    }
    rows
}

fn files<R: Number>(
    thrust: &Card,
    ground_effect: Option<&Card>,
    method: Method,
) -> Result<Vec<ExportedFile>, CardError> {
    let export = Export::<R>::new(thrust, ground_effect)?;
    let unusable = |error: SettingsError| refused(thrust, error.to_string());
    let rotors = identifier(&thrust.name);
    let air = ground_effect.map(|card| identifier(&card.name));
    let names: Vec<&str> = [Some(rotors.as_str()), air.as_deref()]
        .into_iter()
        .flatten()
        .collect();
    let linked = |text: &str| {
        text.replace("@THRUST@", &format!("{rotors}_"))
            .replace(
                "@GROUND@",
                &format!("{}_", air.as_deref().unwrap_or_default()),
            )
            .replace(
                "@GROUND_STATE@",
                &air.as_ref()
                    .map_or_else(String::new, |air| format!("    {air}_state air;\n")),
            )
    };
    let opening = format!(
        "/* Vertical controller, method `{}`, with the cards {}.\n * Written by touchdown {} \
         (touchdown export), not by hand.\n */\n",
        method.name(),
        names.join(" and "),
        env!("CARGO_PKG_VERSION"),
    );
    let includes: String = names
        .iter()
        .map(|name| format!("#include \"{name}.h\"\n"))
        .collect();
    let declarations = linked(include_str!("c/vertical.h"));
    let header = guarded_header(
        &opening,
        &format!("{includes}\n#include <stdbool.h>\n"),
        &declarations,
        VERTICAL_NAME,
    );
    let settings = export.settings(method);
    let source = linked(&source::<R>(&opening, &settings, air.is_some()));
    let rows = export.rows(method).map_err(unusable)?;
    let body = BODY.replace("CONFIGURATION", &(STEPS + 1).to_string());
    let join = |before: &str, after: &str| {
        let parts: Vec<_> = names
            .iter()
            .map(|name| format!("{before}{name}{after}"))
            .collect();
        parts.join(" ")
    };
    let sources: Vec<_> = names
        .iter()
        .map(|name| format!("../{name}/{name}.c"))
        .collect();
    let makefile = include_str!("c/Makefile.vertical.in")
        .replace("MODELS", &sources.join(" "))
        .replace("INCLUDES", &join("-I../", ""))
        .replace("NAME", VERTICAL_NAME);
    let file = |extension: &str, text: String| ExportedFile {
        name: format!("{VERTICAL_NAME}{extension}"),
        text,
    };
    Ok(vec![
        file(".c", filled::<R>(&source, VERTICAL_NAME)),
        file(".h", filled::<R>(&header, VERTICAL_NAME)),
        file("_test.c", test_of(&rows, &body, VERTICAL_NAME)),
        ExportedFile {
            name: "Makefile".to_owned(),
            text: makefile,
        },
    ])
}

fn source<R: Number>(opening: &str, settings: &str, has_air: bool) -> String {
    let mut pieces = vec![piece!("basics")];
    pieces.extend(elementary::<R>(true));
    pieces.push(if R::TYPES[0] == "float" {
        piece!("float_exp_m1")
    } else {
        piece!("double_exp_m1")
    });
    pieces.push(if R::TYPES[0] == "float" {
        piece!("float_tanh")
    } else {
        piece!("double_tanh")
    });
    pieces.extend([piece!("lag"), piece!("vertical_deck")]);
    pieces.push(if has_air {
        piece!("vertical_air")
    } else {
        piece!("vertical_no_air")
    });
    pieces.extend([piece!("vertical_laws"), piece!("vertical")]);
    let mut text = format!(
        "{opening}#include \"{VERTICAL_NAME}.h\"\n\n#include <math.h>\n#include <stdint.h>\n\
         #include <string.h>\n\nconst NAME_settings NAME_defaults = {{\n{settings}}};\n"
    );
    for piece in pieces {
        text.push('\n');
        text.push_str(piece);
    }
    text
}

const BODY: &str = "\
    NAME_settings settings = NAME_defaults;
    if (!NAME_settings_are_valid(&settings)) {
        (void)printf(\"the settings are not valid\\n\");
        failures++;
    }
    for (i = 0; i < ROWS; i++) {
        const WORD *row = VECTORS[i];
        NAME_measurement measurement;
        NAME_command command;
        measurement.height_m = real_of(row[2]);
        measurement.relative_velocity_mps = real_of(row[3]);
        measurement.vehicle_velocity_mps = real_of(row[4]);
        if ((i % CONFIGURATION) == 0) {
            settings.law = (NAME_law)(int)real_of(row[0]);
            settings.deck_filter = real_of(row[1]) > (REAL)0.0;
            NAME_init(&state, &settings, &measurement, real_of(row[5]));
            compare(i, state.thrust_n, row[6]);
            compare(i, state.throttle, row[7]);
            continue;
        }
        command = NAME_step(&state, &settings, &measurement, real_of(row[5]));
        compare(i, command.thrust_n, row[6]);
        compare(i, command.throttle, row[7]);
        compare(i, command.ground_effect_n, row[8]);
    }
    settings.mass_kg = (REAL)NAN;
    if (NAME_settings_are_valid(&settings)) {
        (void)printf(\"a mass that is not a number is valid\\n\");
        failures++;
    }
";
