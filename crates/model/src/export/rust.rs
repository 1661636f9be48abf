//! A Rust constant of `touchdown-flight`.

use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, StaticMap};
use touchdown_flight::thrust::{Library, ThrustModel};

use super::flying::FlyingModel;
use super::{ExportedFile, Number, comment, in_comment};
use crate::card::Card;

/// One file with one constant.
pub(super) fn file<R: Number>(card: &Card, model: &FlyingModel<R>, name: &str) -> ExportedFile {
    let (kind, value) = match model {
        FlyingModel::Thrust(model) => ("thrust::ThrustModel", thrust(model)),
        FlyingModel::GroundEffect(model) => ("ground_effect::Guarded", ground_effect(model)),
    };
    let constant = name.to_ascii_uppercase();
    let scalar = R::TYPES[1];
    let text = format!(
        "// {}\n\n/// The model of the card `{}`.\n\
         pub const {constant}: touchdown_flight::{kind}<{scalar}> = {value};\n",
        comment::lines(card, model).join("\n// "),
        in_comment(&card.name),
    );
    ExportedFile {
        name: format!("{name}.rs"),
        text,
    }
}

/// A structure's text: its path and its fields with their values.
fn structure(path: &str, fields: &[(&str, String)]) -> String {
    let fields: Vec<_> = fields.iter().map(|(k, v)| format!("{k}: {v}")).collect();
    format!("touchdown_flight::{path} {{ {} }}", fields.join(", "))
}

fn array<R: Number>(values: &[R]) -> String {
    let values: Vec<_> = values.iter().map(|value| value.text()).collect();
    format!("[{}]", values.join(", "))
}

fn thrust<R: Number>(model: &ThrustModel<R>) -> String {
    let (variant, inner) = match model {
        ThrustModel::FirstOrder(m) => {
            let fields = [("c0", m.c0), ("c1", m.c1), ("t_m_s", m.t_m_s)];
            ("FirstOrder", numbers("thrust::FirstOrder", &fields))
        }
        ThrustModel::Library(m) => ("Library", library(m)),
        ThrustModel::LibraryOfRotors(m) => {
            let fields = [
                ("library", library(&m.library)),
                ("root_factor", m.root_factor.text()),
            ];
            (
                "LibraryOfRotors",
                structure("thrust::LibraryOfRotors", &fields),
            )
        }
        ThrustModel::Static(m) => {
            let fields = [
                ("coefficients", array(&m.coefficients)),
                ("t_m_s", m.t_m_s.text()),
            ];
            ("Static", structure("thrust::StaticThrust", &fields))
        }
        ThrustModel::LaggedThrottle(m) => {
            let fields = [
                ("coefficients", array(&m.coefficients)),
                ("t_m_s", m.t_m_s.text()),
            ];
            (
                "LaggedThrottle",
                structure("thrust::LaggedThrottle", &fields),
            )
        }
    };
    format!("touchdown_flight::thrust::ThrustModel::{variant}({inner})")
}

fn library<R: Number>(m: &Library<R>) -> String {
    let fields = [
        ("one", m.one),
        ("x", m.x),
        ("s", m.s),
        ("s2", m.s2),
        ("x3", m.x3),
        ("s3", m.s3),
        ("exp_neg_x_s", m.exp_neg_x_s),
        ("sin_x_s", m.sin_x_s),
    ];
    numbers("thrust::Library", &fields)
}

fn numbers<R: Number>(path: &str, fields: &[(&str, R)]) -> String {
    let fields: Vec<_> = fields.iter().map(|&(k, v)| (k, v.text())).collect();
    structure(path, &fields)
}

fn map<R: Number>(map: &StaticMap<R>) -> String {
    let fields = [("h", array(&map.h)), ("length_m", array(&map.length_m))];
    structure("ground_effect::StaticMap", &fields)
}

fn ground_effect<R: Number>(guarded: &Guarded<R>) -> String {
    let variant = |name: &str, inner: String| {
        format!("touchdown_flight::ground_effect::GroundEffectModel::{name}({inner})")
    };
    let model = match &guarded.model {
        GroundEffectModel::None => {
            "touchdown_flight::ground_effect::GroundEffectModel::None".to_owned()
        }
        GroundEffectModel::Empirical(m) => {
            let fields = [
                ("mu", m.mu),
                ("rotor_radius_m", m.rotor_radius_m),
                ("rotor_offset_m", m.rotor_offset_m),
            ];
            variant("Empirical", numbers("ground_effect::Empirical", &fields))
        }
        GroundEffectModel::StaticMap(m) => variant("StaticMap", map(m)),
        GroundEffectModel::Polynomial(m) => {
            let fields = [("theta", array(&m.theta))];
            variant(
                "Polynomial",
                structure("ground_effect::Polynomial", &fields),
            )
        }
        GroundEffectModel::Ratio(m) => {
            let fields = [("xi", array(&m.xi)), ("length_m", array(&m.length_m))];
            variant("Ratio", structure("ground_effect::Ratio", &fields))
        }
        GroundEffectModel::Lag(m) => {
            let fields = [
                ("map", map(&m.map)),
                ("k", array(&m.k)),
                ("tau_s", m.tau_s.text()),
            ];
            variant("Lag", structure("ground_effect::Lag", &fields))
        }
    };
    let v = &guarded.validity;
    let outside = format!("touchdown_flight::ground_effect::Outside::{:?}", v.outside);
    let validity = [
        ("height_min_m", v.height_min_m.text()),
        ("height_max_m", v.height_max_m.text()),
        ("ratio_min", v.ratio_min.text()),
        ("ratio_max", v.ratio_max.text()),
        ("outside", outside),
    ];
    let velocity = format!(
        "touchdown_flight::ground_effect::VelocityInput::{:?}",
        guarded.velocity
    );
    let fields = [
        ("model", model),
        ("validity", structure("ground_effect::Validity", &validity)),
        ("velocity", velocity),
    ];
    structure("ground_effect::Guarded", &fields)
}
