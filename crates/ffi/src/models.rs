//! Models of thrust and ground effect as the caller states them.

use touchdown_flight::ground_effect::{
    Empirical, GroundEffect as _, GroundEffectModel, Guarded, Lag, Outside, Polynomial, Ratio,
    StaticMap, Validity, VelocityInput,
};
use touchdown_flight::method::{Feedforward, Method};
use touchdown_flight::thrust::{
    FirstOrder, LaggedThrottle, Library, LibraryOfRotors, StaticThrust, ThrustModel,
};
use touchdown_lander::models::FlightModels;

use crate::error::{td_error, td_setting};
use crate::memory::{check, check_optional, read, write};
use crate::numbers::numbered;
use crate::refusal::Refusal;
use crate::vehicle::td_vehicle;

/// Form of a thrust model: what its coefficients are, in the order of a card.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_thrust_form {
    /// `first-order`, eq. (7): c0, c1, time constant in s.
    FirstOrder = 0,
    /// `library`, eq. (8): those of 1, x, s, s^2, x^3, s^3, exp(-x) s, sin(x) s.
    Library = 1,
    /// A cubic of throttle with a lag: four coefficients, time constant in s.
    Static = 2,
    /// A cubic of lagged throttle for the thrust: four coefficients, time constant in s.
    LaggedThrottle = 3,
    /// As library, then the root of the number of rotors over that of the card.
    LibraryOfRotors = 4,
}

/// Throttle to free-air thrust.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_thrust_model {
    /// A `td_thrust_form`.
    pub form: u32,
    /// Coefficients of the form; the rest is not used.
    pub coefficients: [f32; 9],
}

/// Form of a ground-effect model: what its coefficients are, in the order of a card.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_ground_effect_form {
    /// No ground effect.
    None = 0,
    /// `empirical`, eq. (2): mu, rotor radius in m, height of the rotors above the reference point in m.
    Empirical = 1,
    /// A static map of height: h0 to h3, three lengths in m.
    StaticMap = 2,
    /// `polynomial`, eq. (9): eleven coefficients.
    Polynomial = 3,
    /// The derivative form of the ratio: nine coefficients, three lengths in m.
    Ratio = 4,
    /// `lag`: h0 to h3, three lengths in m, k0, k1, time constant in s.
    Lag = 5,
}

/// What a model returns outside of its limits of height.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_outside {
    /// Its value at the limit.
    Clamp = 0,
    /// Less and less, down to zero.
    Fade = 1,
}

/// The velocity of the deck that a model is given.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_velocity_input {
    /// That of the deck in the world.
    Deck = 0,
    /// That of the deck relative to the vehicle.
    NegativeRelative = 1,
}

/// Ground effect within its limits of validity.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_ground_effect {
    /// A `td_ground_effect_form`.
    pub form: u32,
    /// Coefficients of the form; the rest is not used.
    pub coefficients: [f32; 12],
    /// Least height above the deck, m.
    pub height_min_m: f32,
    /// Greatest height above the deck, m.
    pub height_max_m: f32,
    /// Least force over thrust.
    pub ratio_min: f32,
    /// Greatest force over thrust.
    pub ratio_max: f32,
    /// A `td_outside`.
    pub outside: u32,
    /// A `td_velocity_input`.
    pub velocity: u32,
}

/// The models that a controller flies with.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_models {
    /// Throttle to thrust.
    pub thrust: td_thrust_model,
    /// Coefficient of eq. (2), for `TD_METHOD_EMPIRICAL`. That method has limits of its own: heights
    /// of 0.1 to 0.85 m, force over thrust of at most 0.6, and above the force stays. For other
    /// limits or a fade, state eq. (2) as `ground_effect` and fly `TD_METHOD_DYNAMIC`.
    pub empirical_mu: f32,
    /// Ground effect, for `TD_METHOD_DYNAMIC` and `TD_METHOD_DYNAMIC_OBSERVER`.
    pub ground_effect: td_ground_effect,
}

numbered!(td_thrust_form: FirstOrder, Library, Static, LaggedThrottle, LibraryOfRotors);
numbered!(td_ground_effect_form: None, Empirical, StaticMap, Polynomial, Ratio, Lag);
numbered!(td_outside: Clamp, Fade);
numbered!(td_velocity_input: Deck, NegativeRelative);

impl td_thrust_model {
    fn new(model: &ThrustModel<f32>) -> Self {
        let (form, coefficients) = match *model {
            ThrustModel::FirstOrder(m) => (
                td_thrust_form::FirstOrder,
                [m.c0, m.c1, m.t_m_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            ),
            ThrustModel::Library(m) => (td_thrust_form::Library, library(&m, 0.0)),
            ThrustModel::Static(m) => (
                td_thrust_form::Static,
                cubic_with_lag(m.coefficients, m.t_m_s),
            ),
            ThrustModel::LaggedThrottle(m) => (
                td_thrust_form::LaggedThrottle,
                cubic_with_lag(m.coefficients, m.t_m_s),
            ),
            ThrustModel::LibraryOfRotors(m) => (
                td_thrust_form::LibraryOfRotors,
                library(&m.library, m.root_factor),
            ),
        };
        Self {
            form: form as u32,
            coefficients,
        }
    }

    /// The model for a vehicle that it carries.
    fn model_for(&self, vehicle: &td_vehicle) -> Result<ThrustModel<f32>, Refusal> {
        vehicle.check()?;
        let model = self.model()?;
        model.check_lift(vehicle.weight_n())?;
        Ok(model)
    }

    fn model(&self) -> Result<ThrustModel<f32>, Refusal> {
        let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = self.coefficients;
        let library = Library {
            one: c0,
            x: c1,
            s: c2,
            s2: c3,
            x3: c4,
            s3: c5,
            exp_neg_x_s: c6,
            sin_x_s: c7,
        };
        let unknown = |_| {
            Refusal::unknown(
                "models.thrust.form",
                "a constant of td_thrust_form",
                self.form,
            )
        };
        let model = match td_thrust_form::of(self.form).map_err(unknown)? {
            td_thrust_form::FirstOrder => ThrustModel::FirstOrder(FirstOrder { c0, c1, t_m_s: c2 }),
            td_thrust_form::Library => ThrustModel::Library(library),
            td_thrust_form::Static => ThrustModel::Static(StaticThrust {
                coefficients: [c0, c1, c2, c3],
                t_m_s: c4,
            }),
            td_thrust_form::LaggedThrottle => ThrustModel::LaggedThrottle(LaggedThrottle {
                coefficients: [c0, c1, c2, c3],
                t_m_s: c4,
            }),
            td_thrust_form::LibraryOfRotors => ThrustModel::LibraryOfRotors(LibraryOfRotors {
                library,
                root_factor: c8,
            }),
        };
        let refused =
            |error| Refusal::coefficient(error, "models.thrust.coefficients", &self.coefficients);
        model.validate().map_err(refused)?;
        Ok(model)
    }
}

fn library(m: &Library<f32>, root_factor: f32) -> [f32; 9] {
    [
        m.one,
        m.x,
        m.s,
        m.s2,
        m.x3,
        m.s3,
        m.exp_neg_x_s,
        m.sin_x_s,
        root_factor,
    ]
}

fn cubic_with_lag([c0, c1, c2, c3]: [f32; 4], t_m_s: f32) -> [f32; 9] {
    [c0, c1, c2, c3, t_m_s, 0.0, 0.0, 0.0, 0.0]
}

impl td_ground_effect {
    fn new(guarded: &Guarded<f32>) -> Self {
        let mut coefficients = [0.0; 12];
        let mut put = |values: &[f32]| {
            for (to, from) in coefficients.iter_mut().zip(values) {
                *to = *from;
            }
        };
        let form = match guarded.model {
            GroundEffectModel::None => td_ground_effect_form::None,
            GroundEffectModel::Empirical(m) => {
                put(&[m.mu, m.rotor_radius_m, m.rotor_offset_m]);
                td_ground_effect_form::Empirical
            }
            GroundEffectModel::StaticMap(m) => {
                let ([a, b, c, d], [e, f, g]) = (m.h, m.length_m);
                put(&[a, b, c, d, e, f, g]);
                td_ground_effect_form::StaticMap
            }
            GroundEffectModel::Polynomial(m) => {
                put(&m.theta);
                td_ground_effect_form::Polynomial
            }
            GroundEffectModel::Ratio(m) => {
                let ([a, b, c, d, e, f, g, h, i], [j, k, l]) = (m.xi, m.length_m);
                put(&[a, b, c, d, e, f, g, h, i, j, k, l]);
                td_ground_effect_form::Ratio
            }
            GroundEffectModel::Lag(m) => {
                let ([a, b, c, d], [e, f, g], [k0, k1]) = (m.map.h, m.map.length_m, m.k);
                put(&[a, b, c, d, e, f, g, k0, k1, m.tau_s]);
                td_ground_effect_form::Lag
            }
        };
        let Validity {
            height_min_m,
            height_max_m,
            ratio_min,
            ratio_max,
            outside,
        } = guarded.validity;
        Self {
            form: form as u32,
            coefficients,
            height_min_m,
            height_max_m,
            ratio_min,
            ratio_max,
            outside: match outside {
                Outside::Clamp => td_outside::Clamp,
                Outside::Fade => td_outside::Fade,
            } as u32,
            velocity: match guarded.velocity {
                VelocityInput::Deck => td_velocity_input::Deck,
                VelocityInput::NegativeRelative => td_velocity_input::NegativeRelative,
            } as u32,
        }
    }

    /// The model; its numbers are not checked.
    fn guarded(&self) -> Result<Guarded<f32>, Refusal> {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = self.coefficients;
        let map = StaticMap {
            h: [a, b, c, d],
            length_m: [e, f, g],
        };
        let unknown = Refusal::unknown;
        let form = td_ground_effect_form::of(self.form).map_err(|_| {
            unknown(
                "models.ground_effect.form",
                "a constant of td_ground_effect_form",
                self.form,
            )
        })?;
        let outside = td_outside::of(self.outside).map_err(|_| {
            unknown(
                "models.ground_effect.outside",
                "a constant of td_outside",
                self.outside,
            )
        })?;
        let velocity = td_velocity_input::of(self.velocity).map_err(|_| {
            unknown(
                "models.ground_effect.velocity",
                "a constant of td_velocity_input",
                self.velocity,
            )
        })?;
        let model = match form {
            td_ground_effect_form::None => GroundEffectModel::None,
            td_ground_effect_form::Empirical => GroundEffectModel::Empirical(Empirical {
                mu: a,
                rotor_radius_m: b,
                rotor_offset_m: c,
            }),
            td_ground_effect_form::StaticMap => GroundEffectModel::StaticMap(map),
            td_ground_effect_form::Polynomial => GroundEffectModel::Polynomial(Polynomial {
                theta: [a, b, c, d, e, f, g, h, i, j, k],
            }),
            td_ground_effect_form::Ratio => GroundEffectModel::Ratio(Ratio {
                xi: [a, b, c, d, e, f, g, h, i],
                length_m: [j, k, l],
            }),
            td_ground_effect_form::Lag => GroundEffectModel::Lag(Lag {
                map,
                k: [h, i],
                tau_s: j,
            }),
        };
        Ok(Guarded {
            model,
            validity: Validity {
                height_min_m: self.height_min_m,
                height_max_m: self.height_max_m,
                ratio_min: self.ratio_min,
                ratio_max: self.ratio_max,
                outside: match outside {
                    td_outside::Clamp => Outside::Clamp,
                    td_outside::Fade => Outside::Fade,
                },
            },
            velocity: match velocity {
                td_velocity_input::Deck => VelocityInput::Deck,
                td_velocity_input::NegativeRelative => VelocityInput::NegativeRelative,
            },
        })
    }
}

impl td_models {
    pub(crate) fn new(models: &FlightModels<f32>) -> Self {
        Self {
            thrust: td_thrust_model::new(&models.thrust),
            empirical_mu: models.mu,
            ground_effect: td_ground_effect::new(&models.dynamic),
        }
    }

    /// The models of a method, for a vehicle that the thrust carries.
    pub(crate) fn models(
        &self,
        method: Method,
        vehicle: &td_vehicle,
    ) -> Result<FlightModels<f32>, Refusal> {
        let dynamic = self.ground_effect.guarded()?;
        if method.feedforward() == Feedforward::Dynamic {
            let coefficients = &self.ground_effect.coefficients;
            dynamic.validate().map_err(|error| {
                Refusal::coefficient(error, "models.ground_effect.coefficients", coefficients)
            })?;
        }
        Ok(FlightModels {
            thrust: self.thrust.model_for(vehicle)?,
            mu: self.empirical_mu,
            dynamic,
        })
    }
}

/// The models that fly by default: those of the paper's quadrotor at half of the paper's ground
/// effect.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_models_default(models: *mut td_models) -> td_error {
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { write(models, td_models::new(&FlightModels::default())) }.into()
}

/// The models at the paper's ground effect.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_models_paper(models: *mut td_models) -> td_error {
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { write(models, td_models::new(&FlightModels::paper())) }.into()
}

/// The throttle in [0, 1] that carries the vehicle in free air. `setting` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_hover_throttle(
    vehicle: *const td_vehicle,
    models: *const td_models,
    throttle: *mut f32,
    setting: *mut td_setting,
) -> td_error {
    let hover = || -> Result<(), Refusal> {
        check(throttle)?;
        check_optional(setting)?;
        // SAFETY: as the crate's documentation requires of every pointer.
        let (vehicle, models) = unsafe { (read(vehicle)?, read(models)?) };
        let model = models.thrust.model_for(&vehicle)?;
        let found = model.throttle_for(vehicle.weight_n());
        // SAFETY: as the crate's documentation requires of every pointer.
        Ok(unsafe { write(throttle, found) }?)
    };
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { Refusal::report(hover(), setting) }
}
