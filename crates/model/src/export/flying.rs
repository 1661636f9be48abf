//! The flight model of a card in the precision of an export.

use touchdown_flight::Real;
use touchdown_flight::error::SettingsError;
use touchdown_flight::ground_effect::{
    Empirical, GroundEffect as _, GroundEffectModel, Guarded, Lag, Polynomial, Ratio, StaticMap,
    Validity,
};
use touchdown_flight::real::r;
use touchdown_flight::thrust::{
    FirstOrder, LaggedThrottle, Library, LibraryOfRotors, ROOT_THRUST_MAX, StaticThrust,
    ThrustModel,
};

use crate::card::{Card, Kind};
use crate::error::CardError;

/// The model that a card flies.
pub(super) enum FlyingModel<R: Real> {
    Thrust(ThrustModel<R>),
    GroundEffect(Guarded<R>),
}

impl<R: Real> FlyingModel<R> {
    /// The card's model, each number rounded to the precision.
    ///
    /// # Errors
    /// A card that does not fly; numbers that have no place in the precision; a greatest thrust beyond that of the models.
    pub(super) fn of(card: &Card) -> Result<Self, CardError> {
        let refused = |reason: String| CardError::NotForFlight {
            card: card.name.clone(),
            reason,
        };
        let rounded =
            |error: SettingsError| refused(format!("in the precision of the export: {error}"));
        match card.kind {
            Kind::Thrust => {
                let model = card.thrust_model_of(rotors_flown(card))?;
                if model.rest(1.0) >= ROOT_THRUST_MAX {
                    let most_n = ROOT_THRUST_MAX * ROOT_THRUST_MAX;
                    return Err(refused(format!(
                        "expected a greatest thrust below {most_n} N, the most that a model holds"
                    )));
                }
                let model = thrust(&model);
                model.validate().map_err(rounded)?;
                Ok(Self::Thrust(model))
            }
            Kind::GroundEffect => {
                let model = guarded(&card.ground_effect()?);
                model.validate().map_err(rounded)?;
                Ok(Self::GroundEffect(model))
            }
        }
    }
}

/// Rotors of which an export gives the thrust. Without a number of the vehicle, those that were measured.
pub(super) fn rotors_flown(card: &Card) -> Option<u32> {
    card.vehicle.rotors.or(card.measured_rotors)
}

fn thrust<R: Real>(model: &ThrustModel<f64>) -> ThrustModel<R> {
    match *model {
        ThrustModel::FirstOrder(m) => ThrustModel::FirstOrder(FirstOrder {
            c0: r(m.c0),
            c1: r(m.c1),
            t_m_s: r(m.t_m_s),
        }),
        ThrustModel::Library(m) => ThrustModel::Library(library(&m)),
        ThrustModel::LibraryOfRotors(m) => ThrustModel::LibraryOfRotors(LibraryOfRotors {
            library: library(&m.library),
            root_factor: r(m.root_factor),
        }),
        ThrustModel::Static(m) => ThrustModel::Static(StaticThrust {
            coefficients: m.coefficients.map(r),
            t_m_s: r(m.t_m_s),
        }),
        ThrustModel::LaggedThrottle(m) => ThrustModel::LaggedThrottle(LaggedThrottle {
            coefficients: m.coefficients.map(r),
            t_m_s: r(m.t_m_s),
        }),
    }
}

fn library<R: Real>(m: &Library<f64>) -> Library<R> {
    Library::from_array([m.one, m.x, m.s, m.s2, m.x3, m.s3, m.exp_neg_x_s, m.sin_x_s].map(r))
}

fn map<R: Real>(m: &StaticMap<f64>) -> StaticMap<R> {
    StaticMap {
        h: m.h.map(r),
        length_m: m.length_m.map(r),
    }
}

fn guarded<R: Real>(guarded: &Guarded<f64>) -> Guarded<R> {
    let model = match guarded.model {
        GroundEffectModel::None => GroundEffectModel::None,
        GroundEffectModel::Empirical(m) => GroundEffectModel::Empirical(Empirical {
            mu: r(m.mu),
            rotor_radius_m: r(m.rotor_radius_m),
            rotor_offset_m: r(m.rotor_offset_m),
        }),
        GroundEffectModel::StaticMap(m) => GroundEffectModel::StaticMap(map(&m)),
        GroundEffectModel::Polynomial(m) => GroundEffectModel::Polynomial(Polynomial {
            theta: m.theta.map(r),
        }),
        GroundEffectModel::Ratio(m) => GroundEffectModel::Ratio(Ratio {
            xi: m.xi.map(r),
            length_m: m.length_m.map(r),
        }),
        GroundEffectModel::Lag(m) => GroundEffectModel::Lag(Lag {
            map: map(&m.map),
            k: m.k.map(r),
            tau_s: r(m.tau_s),
        }),
    };
    let v = &guarded.validity;
    Guarded {
        model,
        validity: Validity {
            height_min_m: r(v.height_min_m),
            height_max_m: r(v.height_max_m),
            ratio_min: r(v.ratio_min),
            ratio_max: r(v.ratio_max),
            outside: v.outside,
        },
        velocity: guarded.velocity,
    }
}
