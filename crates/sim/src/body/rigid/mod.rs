//! The whole vehicle: a rigid body with four rotors in six degrees of freedom.
//!
//! ```text
//! m v' = b_z Σ F_i - m g e_z + D + contact
//! I ω' = Σ r_i × F_i e_3 + Σ s_i κ T_i e_3 - ω × (I ω + h e_3) - h' e_3 + contact
//! h = -Σ s_i J Ω_i                           s_i = ±1; J Ω_hover: `rotor_momentum_kg_m2_ps`
//! q' = q ∘ (0, ω)/2
//! F_i = T_i (1 + ε_i) + f_i + n_i            ([`crate::rotors`]; turbulence n_i)
//! D = -(c_1 σ + c_2 |u|) u                    u: air speed in the rotors' plane
//! σ = min(1, Ω/(0.7 Ω_hover))                 Ω: mean speed of the rotors
//! ```
//!
//! Body axes: x forward, y left, z up; world axes: x, y horizontal, z up; q
//! turns body into world coordinates. ω is in body axes. Rotor axes are parallel to the
//! body's z. Climb damping and upwash follow from speeds along the deck's normal, less the
//! vertical wind, and act along the rotor's axis. Rotors that turn clockwise seen from
//! above (front left, rear right) turn the body the other way: s_i = 1. Their angular momentum h
//! cancels in pairs unless the vehicle yaws; a change of h turns the body at once, before the
//! reaction torque κ T_i follows.
//!
//! The model omits gradients of the wind over the vehicle. A level, centred vehicle with equal rotors is
//! [`crate::body::vertical`].

mod kernel;
mod state;
mod trim;

use crate::body::BodySettings;
use crate::body::contact::{ContactLog, ContactState, Foot, LegSettings, Legs};
use crate::body::plant::PlantSettings;
use crate::body::rotors::{RotorPlace, Rotors, RotorsTarget, Shares};
use crate::check;
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::number::vector::{add, along, cross, dot, sub, to_world};

pub(crate) use kernel::{Dynamics, Input, LegContact, VehicleVariation};
pub use state::RigidState;
pub(crate) use state::{MotionState, SIZE};

/// Sign of the reaction torque of each rotor.
pub(crate) const SPIN: [f64; 4] = [1.0, -1.0, 1.0, -1.0];

/// Disturbances of the vehicle during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Velocity of the air, world axes, m/s.
    pub wind_mps: [f64; 3],
    /// Turbulent force on each rotor, N.
    pub turbulence_n: [f64; 4],
}

/// Forces and accelerations at the start of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loads {
    /// Acceleration of the reference point, world axes, m/s².
    pub acceleration_mps2: [f64; 3],
    /// Angular acceleration, body axes, rad/s².
    pub angular_acceleration: [f64; 3],
    /// Force of each rotor along its axis F_i, N.
    pub rotor_n: [f64; 4],
    /// Ground effect and climb damping of each rotor f_i, N.
    pub ground_effect_n: [f64; 4],
    /// Steady inflow, from which the turbulence follows.
    pub target: RotorsTarget,
}

impl Disturbance {
    #[inline]
    fn input(&self, throttle: &[f64; 4], shares: Shares) -> Input<f64> {
        Input {
            throttle: *throttle,
            wind_mps: self.wind_mps,
            turbulence_n: self.turbulence_n,
            shares,
        }
    }
}

impl Loads {
    #[inline]
    fn of(acting: Dynamics<f64>, target: RotorsTarget) -> Self {
        Self {
            acceleration_mps2: acting.acceleration_mps2,
            angular_acceleration: acting.angular_acceleration,
            rotor_n: acting.rotor_n,
            ground_effect_n: acting.ground_effect_n,
            target,
        }
    }
}

/// Model of the vehicle; its coefficients are constant.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidVehicle {
    rotors: Rotors,
    hubs_m: [[f64; 3]; 4],
    body: BodySettings,
    mass_kg: f64,
    gravity_mps2: f64,
    /// Share of the linear drag that a rotor's root of thrust gives, 1/√N.
    spin_share: f64,
    /// Angular momentum of a rotor over its root of thrust, kg m²/s/√N.
    momentum_share: f64,
    thrust_scale_error: [f64; 4],
    legs: Option<Legs>,
}

/// Speed of the rotors over that of the hover from which on the linear drag is c_1, that of half the weight. Blade flapping and
/// induced drag are proportional to the rotors' speed; c_1 is their value in flight, where it changes little. A standing
/// vehicle whose rotors stop loses them. Halved, it loses them 0.05 s later; doubled, drag would change in flight.
const FLYING_SPIN: f64 = 0.7;

impl RigidVehicle {
    /// Checks the settings and builds the vehicle.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn new(plant: &PlantSettings, body: &BodySettings) -> Result<Self, SimError> {
        let rotors = Rotors::new(plant).map_err(|e| e.in_section("plant"))?;
        body.validate().map_err(|e| e.in_section("body"))?;
        // Each root is that of the whole thrust.
        let hover_root = (plant.mass_kg * plant.gravity_mps2).sqrt();
        Ok(Self {
            hubs_m: rotors.hubs_m(),
            rotors,
            body: *body,
            mass_kg: plant.mass_kg,
            gravity_mps2: plant.gravity_mps2,
            spin_share: 0.25 / (FLYING_SPIN * hover_root),
            momentum_share: body.rotor_momentum_kg_m2_ps / hover_root,
            thrust_scale_error: [0.0; 4],
            legs: None,
        })
    }

    /// The same vehicle with legs. Without legs it passes through the deck.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn with_legs(
        mut self,
        legs: &LegSettings,
        plant: &PlantSettings,
    ) -> Result<Self, SimError> {
        self.legs = Some(Legs::new(legs, plant).map_err(|e| e.in_section("legs"))?);
        Ok(self)
    }

    /// The same vehicle with rotors that give `1 + error` times their nominal thrust, for
    /// example -0.2 for a rotor that has lost a fifth.
    #[must_use]
    pub fn with_thrust_scale_error(mut self, error: [f64; 4]) -> Self {
        self.thrust_scale_error = error;
        self
    }

    /// The same vehicle with another scale γ of the ground effect, which is what
    /// [`PlantSettings::ground_effect_scale`] sets.
    ///
    /// # Errors
    /// The scale must not be negative.
    pub fn with_ground_effect_scale(mut self, scale: f64) -> Result<Self, SimError> {
        check::not_negative("plant.ground_effect_scale", scale)?;
        self.rotors = self.rotors.with_ground_effect_scale(scale);
        Ok(self)
    }

    /// Relative error of each rotor's thrust.
    #[must_use]
    pub fn thrust_scale_error(&self) -> [f64; 4] {
        self.thrust_scale_error
    }

    /// The rotors.
    #[must_use]
    pub fn rotors(&self) -> &Rotors {
        &self.rotors
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &BodySettings {
        &self.body
    }

    /// Mass, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Positions and speeds of the rotors relative to the deck, in air that moves at
    /// `wind_mps`.
    #[inline]
    #[must_use]
    pub fn places(
        &self,
        state: &RigidState,
        deck: &DeckPose,
        wind_mps: [f64; 3],
    ) -> [RotorPlace; 4] {
        let axes = state.axes();
        // The wind follows a tilted deck, so only its vertical part changes the climb rate.
        let climb = dot(deck.axes[2], state.velocity_mps) - wind_mps[2];
        let heave = dot(deck.axes[2], deck.velocity_mps);
        let turning = along(&deck.axes, deck.angular_velocity);
        self.hubs_m.map(|hub_m| {
            let arm_m = to_world(&axes, hub_m);
            let place_m = along(&deck.axes, sub(add(state.position_m, arm_m), deck.origin_m));
            let spun = to_world(&axes, cross(state.rates, hub_m));
            RotorPlace {
                place_m,
                climb_mps: climb + dot(deck.axes[2], spun),
                deck_mps: heave + turning[0] * place_m[1] - turning[1] * place_m[0],
            }
        })
    }

    #[inline]
    pub(crate) fn kind(&self) -> VehicleVariation<f64> {
        VehicleVariation {
            thrust_scale_error: self.thrust_scale_error,
            ground_effect_scale: self.rotors.ground_effect_scale(),
        }
    }

    /// Forces and accelerations in a state whose rotors keep their speed.
    #[must_use]
    pub fn loads(&self, state: &RigidState, deck: &DeckPose, disturbance: &Disturbance) -> Loads {
        let (kind, moving) = (self.kind(), state.moving());
        let (roots, place) = (&state.rotors.root_thrust, state.position_m);
        let hubs_m = self.hubs_over(place, &state.axes(), deck);
        let input = disturbance.input(&[0.0; 4], self.rotors.shares(&hubs_m));
        let around = self.around(&kind, roots, &hubs_m, &input.shares, deck);
        let standing = self.legs_near(state, deck).map(|legs| LegContact {
            legs,
            foothold: state.contact.foothold(),
        });
        let contact = standing.as_ref().map(|standing| (standing, deck));
        let drive = roots.map(|root| self.rotors.plant().motor().drive_for(root));
        let (_, acting) = self.rate(&kind, &moving, &input, &drive, &around, contact);
        Loads::of(acting, around.rotors.target)
    }

    /// The legs, if a foot may touch the deck within a step.
    #[inline]
    fn legs_near(&self, state: &RigidState, deck: &DeckPose) -> Option<&Legs> {
        let legs = self.legs.as_ref()?;
        let axes = state.axes();
        legs.near(&state.body(&axes), deck).then_some(legs)
    }

    /// Contact of the feet; all are in the air for a vehicle without legs.
    #[must_use]
    pub fn feet(&self, state: &RigidState, deck: &DeckPose) -> [Foot; 4] {
        let axes = state.axes();
        self.legs.as_ref().map_or_else(Default::default, |legs| {
            legs.feet(&state.body(&axes), deck, &state.contact)
        })
    }

    /// Energy in the springs of legs and feet, J.
    #[must_use]
    pub fn spring_energy_j(&self, state: &RigidState, deck: &DeckPose) -> f64 {
        let of = |legs: &Legs| legs.spring_energy_j(&self.feet(state, deck), &state.contact);
        self.legs.as_ref().map_or(0.0, of)
    }

    /// Adds the state after a step to the record of the contact.
    pub fn log_contact(
        &self,
        log: &mut ContactLog,
        time_s: f64,
        state: &RigidState,
        deck: &DeckPose,
    ) {
        let Some(legs) = &self.legs else { return };
        let axes = state.axes();
        if log.first_touch_s.is_none() && !legs.near(&state.body(&axes), deck) {
            return;
        }
        let up = dot(axes[2], deck.axes[2]).clamp(-1.0, 1.0);
        log.add(time_s, &self.feet(state, deck), up.acos(), legs.settings());
    }

    /// One Runge–Kutta step of `dt`; `deck` is the deck at the start, the middle
    /// and the end of the step. Returns the loads at its start.
    ///
    /// The effect of the deck is constant within the step: steady inflow (q1*, q2*), lags
    /// (t1, t2), shares of the plate (ρ), upwash (P ρ u) and the deck's normal. It is
    /// evaluated at the predicted position in the middle of the step.
    ///
    /// The error is of second order in the step, `dt²/(12 t1)` of the targets' rate, as if
    /// the lag of 30 ms were 3 µs longer. Compared with steps of 0.1 ms, a vehicle that
    /// descends into ground effect at 0.4 m/s moves by 0.03 µm, and one that crosses the
    /// edge of the deck at 2 m/s by less than a micrometre.
    #[inline]
    pub fn step(
        &self,
        state: &mut RigidState,
        deck: &[DeckPose; 3],
        throttle: &[f64; 4],
        disturbance: &Disturbance,
        dt: f64,
    ) -> Loads {
        let mut standing = self.legs_near(state, &deck[0]).map(|legs| LegContact {
            legs,
            foothold: state.contact.foothold(),
        });
        let (kind, mut moving) = (self.kind(), state.moving());
        let shares = self.shares_ahead(&moving, 0.5 * dt, &deck[1]);
        let (input, contact) = (disturbance.input(throttle, shares), standing.as_mut());
        let (acting, held) = self.advance(&kind, &mut moving, deck, &input, contact, dt);
        state.take(&moving);
        if let Some(standing) = &standing {
            state.contact = ContactState::of(&standing.foothold);
        }
        Loads::of(acting, held.target)
    }

    /// The level state at relative rest `height_m` above the centre of the deck, and the
    /// throttle that holds it. Forces are in balance as over a level deck in still air. The
    /// heading is along the world's x axis.
    #[must_use]
    pub fn balanced(&self, height_m: f64, deck: &DeckPose) -> (RigidState, f64) {
        let heave = deck.velocity_mps[2];
        let mean_error = 0.25 * self.thrust_scale_error.iter().sum::<f64>();
        let plant = self.rotors.plant();
        let (start, throttle) = plant.balanced(height_m, heave, heave, mean_error);
        let mut state = RigidState {
            position_m: add(deck.origin_m, [0.0, 0.0, height_m]),
            velocity_mps: deck.velocity_mps,
            ..RigidState::default()
        };
        state.rotors.root_thrust = [start.root_thrust; 4];
        let places = self.places(&state, deck, [0.0; 3]);
        let target = self.rotors.target(&state.rotors.root_thrust, &places);
        state.rotors.inflow = target.inflow;
        state.rotors.fountain = target.fountain;
        (state, throttle)
    }
}
