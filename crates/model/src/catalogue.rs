//! The catalogue of forms: for each its name, equation, parts, state, rate, output and flight kernel.
//!
//! Prediction fills the expressions of a form with a card's terms ([`Card::equations`](crate::Card::equations)). Flight takes
//! the terms that the form's kernel holds ([`Part::terms`]). A test compares the two
//! (`tests/catalogue.rs`). A new form is one variant with its names, one entry and, where it flies, one kernel here.
//!
//! | form | equation | state |
//! | --- | --- | --- |
//! | [`Form::StaticSqrt`] | `√T = Θ(s) ξ`, with a lag `T_m` where it has one | `x = √T` or none |
//! | [`Form::StaticThrust`] | `T = Θ(s, u) ξ` | – |
//! | [`Form::LaggedMotors`] | `T = Σ_i Θ(u_i) ξ`, `T_m u_i' = s_i - u_i` | `u_i` |
//! | [`Form::FirstOrder`] | (7) | `x = √T` |
//! | [`Form::Library`] | (8) | `x = √T` |
//! | [`Form::Empirical`] | (2) | – |
//! | [`Form::Static`] | `f = T h(z)` | – |
//! | [`Form::Derivative`] | (9) | `f` |
//! | [`Form::Ratio`] | `y' = Θ(y, z, v_p) ξ`, `f = T y` | `y` |
//! | [`Form::Lag`] | `G' = (h(z) - G)/τ`, `f = T (G + k(z) v_p)` | `g` |

use serde::{Deserialize, Serialize};
use touchdown_flight::ground_effect::{
    Empirical, GroundEffectModel, Lag, Polynomial, Ratio, StaticMap,
};
use touchdown_flight::thrust::{FirstOrder, LaggedThrottle, Library, StaticThrust, ThrustModel};

use crate::error::CardError;

/// The lag of the motors in flight where a static card has none (s): lags of small rotors are 0.03 to 0.1 s. Half or twice
/// of it changes how far a controller leads its throttle, not where it hovers.
pub const ASSUMED_LAG_S: f64 = 0.05;

/// The part of a thrust card that is the delay of its measurement. It does not fly.
pub const DEAD_TIME: &str = "dead_time";

/// The form of a model.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Thrust: a static polynomial for `√T`.
    StaticSqrt,
    /// Thrust: a static polynomial for `T`.
    StaticThrust,
    /// Thrust: one lag on each motor's throttle, then a polynomial for each motor's `T`, summed.
    LaggedMotors,
    /// Rotor speed: a polynomial of the command through dead time and a first-order lag.
    RotorLag,
    /// Thrust: eq. (7), `x' = (c0 s + c1 - x)/T_m`, `x = √T`.
    FirstOrder,
    /// Thrust: eq. (8), `x' = Θ(x, s) ξ`.
    Library,
    /// Ground effect: eq. (2), a function of height with one coefficient.
    Empirical,
    /// Ground effect: `f = T h(z)`.
    Static,
    /// Ground effect: eq. (9), `f' = Θ(f, s, z, v_p, v_q) ξ`.
    Derivative,
    /// Ground effect: `y = f/T`, `y' = Θ(y, z, v_p) ξ`.
    Ratio,
    /// Ground effect: `y = f/T = G + k(z) v_p`, `G' = (h(z) - G)/τ`.
    Lag,
}

/// A part of a form: a sum of terms with coefficients, or a single coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The name, the `of` of a card's terms.
    pub name: &'static str,
    /// The terms that the kernel of flight holds; empty where there is no kernel. `1` alone is
    /// a single coefficient.
    pub terms: &'static [&'static str],
    /// Whether a card may lack the part; [`Entry::at_rest`] holds then.
    pub optional: bool,
}

impl Part {
    const fn sum(name: &'static str, terms: &'static [&'static str]) -> Self {
        Self {
            name,
            terms,
            optional: false,
        }
    }

    const fn single(name: &'static str) -> Self {
        Self::sum(name, &["1"])
    }
}

/// How the state at the start follows from the measured output there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// There is no state.
    None,
    /// `x = √T`.
    RootOfThrust,
    /// The force itself.
    Force,
    /// Force over free-air thrust, less what the model gives without memory.
    Ratio,
}

/// A form of the catalogue. Parts and constants stand in braces in its expressions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The number of its equation in the paper, where it has one.
    pub equation: Option<&'static str>,
    /// The parts, in the order of parameters.
    pub parts: &'static [Part],
    /// The state, where there is one.
    pub state: Option<&'static str>,
    /// The state's rate.
    pub rate: Option<&'static str>,
    /// Thrust or force, N.
    pub output: &'static str,
    /// Thrust or force of a card that lacks the optional part, N.
    pub at_rest: Option<&'static str>,
    /// The state at the start.
    pub start: Start,
}

/// `x²` with the sign of x, for `x = √T`.
const SQUARE: &str = "x*abs(x)";

const LIBRARY: Entry = Entry {
    equation: Some("(8)"),
    parts: &[Part::sum("x'", &Library::<f64>::TERMS)],
    state: Some("x"),
    rate: Some("{x'}"),
    output: SQUARE,
    at_rest: None,
    start: Start::RootOfThrust,
};
const FIRST_ORDER: Entry = Entry {
    equation: Some("(7)"),
    parts: &[Part::single("c0"), Part::single("c1"), Part::single("T_m")],
    rate: Some("({c0}*s + {c1} - x)/{T_m}"),
    ..LIBRARY
};
const STATIC_SQRT: Entry = Entry {
    equation: None,
    parts: &[
        Part::sum("x", &["1", "s", "s^2", "s^3"]),
        Part {
            optional: true,
            ..Part::single("T_m")
        },
    ],
    rate: Some("({x} - x)/{T_m}"),
    at_rest: Some("({x})*abs({x})"),
    ..LIBRARY
};
const STATIC_THRUST: Entry = Entry {
    equation: None,
    parts: &[Part::sum("T", &[])],
    state: None,
    rate: None,
    output: "{T}",
    at_rest: None,
    start: Start::None,
};
const EMPIRICAL: Entry = Entry {
    equation: Some("(2)"),
    parts: &[Part::single("mu")],
    output: "T*min({mu}*({r}/(4*(z + {h_r})))^2, {q_max})/(1 - min({mu}*({r}/(4*(z + {h_r})))^2, {q_max}))",
    ..STATIC_THRUST
};
const STATIC: Entry = Entry {
    parts: &[Part::sum("h", &StaticMap::<f64>::TERMS)],
    output: "T*({h})",
    ..STATIC_THRUST
};
const DERIVATIVE: Entry = Entry {
    equation: Some("(9)"),
    parts: &[Part::sum("f'", &Polynomial::<f64>::TERMS)],
    state: Some("f"),
    rate: Some("{f'}"),
    output: "f",
    at_rest: None,
    start: Start::Force,
};
const RATIO: Entry = Entry {
    equation: None,
    parts: &[Part::sum("y'", &Ratio::<f64>::TERMS)],
    state: Some("y"),
    rate: Some("{y'}"),
    output: "T*y",
    start: Start::Ratio,
    ..DERIVATIVE
};
const LAG: Entry = Entry {
    parts: &[
        Part::single("tau"),
        Part::sum("h", &StaticMap::<f64>::TERMS),
        Part::sum("k", &["1", "psi3"]),
    ],
    state: Some("g"),
    rate: Some("({h} - g)/{tau}"),
    output: "T*(g + ({k})*v_p)",
    ..RATIO
};

impl Form {
    /// The forms of ground-effect models that are fitted by name, in the order of tables.
    pub const GROUND_EFFECT: [Self; 5] = [
        Self::Empirical,
        Self::Static,
        Self::Derivative,
        Self::Ratio,
        Self::Lag,
    ];

    /// The name in cards, in results and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StaticSqrt => "static_sqrt",
            Self::StaticThrust => "static_thrust",
            Self::LaggedMotors => "lagged_motors",
            Self::RotorLag => "rotor_lag",
            Self::FirstOrder => "first_order",
            Self::Library => "library",
            Self::Empirical => "empirical",
            Self::Static => "static",
            Self::Derivative => "derivative",
            Self::Ratio => "ratio",
            Self::Lag => "lag",
        }
    }

    /// What tables and legends call the form.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::StaticSqrt => "static map √T(s)",
            Self::StaticThrust => "static map T(s)",
            Self::LaggedMotors => "lagged motors",
            Self::RotorLag => "rotor lag",
            Self::FirstOrder => "eq. (7)",
            Self::Library => "eq. (8), SR3",
            Self::Empirical => "eq. (2), fitted μ",
            Self::Static => "static map T h(z)",
            Self::Derivative => "eq. (9), SR3",
            Self::Ratio => "ratio form",
            Self::Lag => "lag form",
        }
    }

    /// The form and its fit in a line.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::StaticSqrt => "√T as a polynomial of throttle, at rest",
            Self::StaticThrust => "T as a polynomial of throttle, at rest",
            Self::LaggedMotors => {
                "One lag on every motor's own throttle, then a polynomial for its thrust, summed"
            }
            Self::RotorLag => {
                "Rotor speed as a polynomial of the command, after a dead time and a lag"
            }
            Self::FirstOrder => "Eq. (7): x' = (c0 s + c1 - x)/T_m, x = √T, fitted in free run",
            Self::Library => {
                "Eq. (8): x' as a sparse sum of library terms, by SR3 on derivatives, refined in free run"
            }
            Self::Empirical => "Eq. (2) with a fitted coefficient mu",
            Self::Static => "A static map f = T h(z)",
            Self::Derivative => {
                "Eq. (9): f' as a sparse sum of library terms, by SR3 on derivatives"
            }
            Self::Ratio => "y = f/T, y' as a sum of bounded terms, refined by multiple shooting",
            Self::Lag => "y = G + k(z) v_p, G' = (h(z) - G)/tau, by multiple shooting",
        }
    }

    /// The ground-effect form of a name.
    #[must_use]
    pub fn ground_effect_named(name: &str) -> Option<Self> {
        Self::GROUND_EFFECT
            .into_iter()
            .find(|form| form.name() == name)
    }

    /// The names of the form's parts, of those that fly and those of the catalogue.
    pub(crate) fn part_names(self) -> Vec<&'static str> {
        match self.entry() {
            Some(entry) => entry.parts.iter().map(|part| part.name).collect(),
            // Several throttles, so without an entry; the parts of its kernel.
            None => vec!["T", "T_m"],
        }
    }

    /// The entry of the catalogue; none for forms that need more than one throttle.
    #[must_use]
    pub fn entry(self) -> Option<&'static Entry> {
        Some(match self {
            Self::Library => &LIBRARY,
            Self::FirstOrder => &FIRST_ORDER,
            Self::StaticSqrt => &STATIC_SQRT,
            Self::StaticThrust => &STATIC_THRUST,
            Self::Empirical => &EMPIRICAL,
            Self::Static => &STATIC,
            Self::Derivative => &DERIVATIVE,
            Self::Ratio => &RATIO,
            Self::Lag => &LAG,
            Self::LaggedMotors | Self::RotorLag => return None,
        })
    }
}

/// The terms of a card, as a flight kernel takes them.
pub(crate) trait Terms {
    /// The one coefficient of the part `of`.
    fn single(&self, of: &str) -> Result<f64, CardError>;
    /// The one coefficient of the part `of`, or `otherwise` where a card lacks the part.
    fn single_or(&self, of: &str, otherwise: f64) -> Result<f64, CardError>;
    /// The coefficients of the part `of` in the order of `slots`.
    fn collect<const N: usize>(&self, of: &str, slots: &[&str; N]) -> Result<[f64; N], CardError>;
    /// A constant.
    fn constant(&self, name: &str) -> Result<f64, CardError>;
    /// A constant that a card may lack; zero then.
    fn constant_or_zero(&self, name: &str) -> f64;
    /// The lengths of the bounded functions of height.
    fn lengths(&self) -> Result<[f64; 3], CardError>;
    /// A refusal.
    fn not_for_flight(&self, reason: &str) -> CardError;

    /// The map of height `h`.
    fn map(&self) -> Result<StaticMap<f64>, CardError> {
        Ok(StaticMap {
            h: self.collect("h", &StaticMap::<f64>::TERMS)?,
            length_m: self.lengths()?,
        })
    }
}

impl Form {
    /// The flight kernel of a thrust form with the coefficients of `card`.
    pub(crate) fn thrust_kernel(self, card: &impl Terms) -> Result<ThrustModel<f64>, CardError> {
        Ok(match self {
            Form::FirstOrder => ThrustModel::FirstOrder(FirstOrder {
                c0: card.single("c0")?,
                c1: card.single("c1")?,
                t_m_s: card.single("T_m")?,
            }),
            Form::Library => ThrustModel::Library(Library::from_array(
                card.collect("x'", &Library::<f64>::TERMS)?,
            )),
            Form::StaticSqrt => ThrustModel::Static(StaticThrust {
                coefficients: card.collect("x", &["1", "s", "s^2", "s^3"])?,
                t_m_s: card.single_or("T_m", ASSUMED_LAG_S)?,
            }),
            Form::StaticThrust => ThrustModel::LaggedThrottle(LaggedThrottle {
                coefficients: card.collect("T", &["1", "s", "s^2", "s^3"])?,
                t_m_s: ASSUMED_LAG_S,
            }),
            Form::LaggedMotors => {
                let of_motor = card.collect("T", &["1", "u", "u^2", "u^3"])?;
                let motors = card.constant("motors")?;
                ThrustModel::LaggedThrottle(LaggedThrottle {
                    coefficients: of_motor.map(|c| motors * c),
                    t_m_s: card.single("T_m")?,
                })
            }
            other => {
                return Err(card.not_for_flight(&format!("form {other:?} is no thrust form")));
            }
        })
    }

    /// The flight kernel of a ground-effect form with the coefficients of `card`.
    pub(crate) fn ground_effect_kernel(
        self,
        card: &impl Terms,
    ) -> Result<GroundEffectModel<f64>, CardError> {
        Ok(match self {
            Form::Empirical => GroundEffectModel::Empirical(Empirical {
                mu: card.single("mu")?,
                rotor_radius_m: card.constant("r")?,
                rotor_offset_m: card.constant_or_zero("h_r"),
            }),
            Form::Static => GroundEffectModel::StaticMap(card.map()?),
            Form::Derivative => GroundEffectModel::Polynomial(Polynomial {
                theta: card.collect("f'", &Polynomial::<f64>::TERMS)?,
            }),
            Form::Ratio => GroundEffectModel::Ratio(Ratio {
                xi: card.collect("y'", &Ratio::<f64>::TERMS)?,
                length_m: card.lengths()?,
            }),
            Form::Lag => GroundEffectModel::Lag(Lag {
                map: card.map()?,
                k: card.collect("k", &["1", "psi3"])?,
                tau_s: card.single("tau")?,
            }),
            other => {
                return Err(
                    card.not_for_flight(&format!("form {other:?} is no ground-effect form"))
                );
            }
        })
    }
}
