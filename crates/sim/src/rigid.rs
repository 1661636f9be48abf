//! The whole vehicle: a rigid body with four rotors in six degrees of freedom.
//!
//! ```text
//! m v' = b_z Σ F_i - m g e_z + D + contact
//! I ω' = Σ r_i × F_i e_3 + Σ ± κ T_i e_3 - ω × I ω + contact
//! q' = q ∘ (0, ω)/2
//! F_i = T_i (1 + ε_i) + f_i + n_i            ([`crate::rotors`]; turbulence n_i)
//! D = -(c_1 + c_2 |u|) u                      u: air speed in the rotors' plane
//! ```
//!
//! Body axes: x forward, y left, z up; world axes: x, y horizontal, z up; q
//! turns body into world coordinates. ω is in body axes. Rotor axes are the
//! body's z; the climb damping and the upwash are those along the deck's normal,
//! less the vertical part of the wind, and act along the rotor's axis. Rotors that
//! turn clockwise seen from above (front left, rear right) turn the body the other
//! way. Left out: the rotors' own angular momentum (pairs cancel), and gradients of
//! the wind over the vehicle. Level, centred and with equal rotors it is [`crate::vehicle`].

mod state;

use crate::body::BodySettings;
use crate::contact::{ContactLog, Foot, LegSettings, Legs};
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::plant::PlantSettings;
use crate::rk4;
use crate::rotors::{RotorPlace, Rotors, RotorsTarget};
use crate::vector::{
    Axes, add, along, axes_of, cross, dot, normalised, product, scale, sub, to_world,
};

pub use state::RigidState;

/// Sign of the reaction torque of each rotor.
pub(crate) const SPIN: [f64; 4] = [1.0, -1.0, 1.0, -1.0];

/// What disturbs the vehicle during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Velocity of the air, world axes, m/s.
    pub wind_mps: [f64; 3],
    /// Turbulent force on each rotor, N.
    pub turbulence_n: [f64; 4],
}

/// What acted at the start of a step.
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
    /// Inflow at rest, from which the turbulence follows.
    pub target: RotorsTarget,
}

/// The vehicle with coefficients that do not change.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidVehicle {
    rotors: Rotors,
    hubs_m: [[f64; 3]; 4],
    body: BodySettings,
    mass_kg: f64,
    gravity_mps2: f64,
    thrust_scale_error: [f64; 4],
    legs: Option<Legs>,
}

impl RigidVehicle {
    /// Checks the settings and builds the vehicle.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn new(plant: &PlantSettings, body: &BodySettings) -> Result<Self, SimError> {
        let rotors = Rotors::new(plant).map_err(|e| e.in_section("plant"))?;
        body.validate().map_err(|e| e.in_section("body"))?;
        Ok(Self {
            hubs_m: rotors.hubs_m(),
            rotors,
            body: *body,
            mass_kg: plant.mass_kg,
            gravity_mps2: plant.gravity_mps2,
            thrust_scale_error: [0.0; 4],
            legs: None,
        })
    }

    /// The same vehicle on legs; without them it passes through the deck.
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

    /// The same vehicle with rotors that give `1 + error` times their nominal
    /// thrust: a spread of motors, or (-0.2) one that has lost a fifth.
    #[must_use]
    pub fn with_thrust_scale_error(mut self, error: [f64; 4]) -> Self {
        self.thrust_scale_error = error;
        self
    }

    /// By how much the rotors' thrust differs from the nominal, as a share.
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

    /// Places and speeds of the rotors relative to the deck, with the air
    /// moving at `wind_mps`.
    #[inline]
    #[must_use]
    pub fn places(
        &self,
        state: &RigidState,
        deck: &DeckPose,
        wind_mps: [f64; 3],
    ) -> [RotorPlace; 4] {
        self.places_at(state, &state.axes(), deck, wind_mps)
    }

    #[inline]
    fn places_at(
        &self,
        state: &RigidState,
        axes: &Axes,
        deck: &DeckPose,
        wind_mps: [f64; 3],
    ) -> [RotorPlace; 4] {
        let normal = deck.axes[2];
        // Everything in the deck's axes; its rotation enters the speed of the point below.
        let centre = along(&deck.axes, sub(state.position_m, deck.origin_m));
        let turned: Axes = [
            along(&deck.axes, axes[0]),
            along(&deck.axes, axes[1]),
            along(&deck.axes, axes[2]),
        ];
        // Over a leaning deck the wind blows along it: only its vertical part climbs.
        let climb = dot(normal, state.velocity_mps) - wind_mps[2];
        let heave = dot(normal, deck.velocity_mps);
        let deck_rates = along(&deck.axes, deck.angular_velocity);
        let mut places = [RotorPlace::default(); 4];
        for (rotor, hub_m) in places.iter_mut().zip(self.hubs_m) {
            let place_m = add(centre, to_world(&turned, hub_m));
            let spun = cross(state.rates, hub_m);
            rotor.place_m = place_m;
            rotor.climb_mps = climb + to_world(&turned, spun)[2];
            rotor.deck_mps = heave + deck_rates[0] * place_m[1] - deck_rates[1] * place_m[0];
        }
        places
    }

    /// Rate of the state, and the loads. `legs` are given where they may touch.
    #[inline]
    fn rate(
        &self,
        state: &RigidState,
        deck: &DeckPose,
        throttle: &[f64; 4],
        disturbance: &Disturbance,
        share: &[f64; 4],
        legs: Option<&Legs>,
    ) -> (RigidState, Loads) {
        let axes = state.axes();
        let places = self.places_at(state, &axes, deck, disturbance.wind_mps);
        let roots = &state.rotors.root_thrust;
        let target = self.rotors.target_with(roots, &places, share);
        let forces = self.rotors.forces(&state.rotors, &target, &places);

        let (mut lift_n, mut torque) = (0.0, [0.0; 3]);
        let mut rotor_n = [0.0; 4];
        for i in 0..4 {
            let free_n = forces.free_air_n[i];
            let force_n = free_n * (1.0 + self.thrust_scale_error[i])
                + forces.ground_effect_n[i]
                + disturbance.turbulence_n[i];
            let [x, y, _] = self.hubs_m[i];
            lift_n += force_n;
            torque[0] += y * force_n;
            torque[1] -= x * force_n;
            torque[2] += SPIN[i] * self.body.torque_per_thrust_m * free_n;
            rotor_n[i] = force_n;
        }
        let air = sub(state.velocity_mps, disturbance.wind_mps);
        let (ahead, aside) = (dot(axes[0], air), dot(axes[1], air));
        let speed = (ahead * ahead + aside * aside).sqrt();
        let drag = -(self.body.drag_ns_per_m + self.body.drag_ns2_per_m2 * speed);
        let force = [drag * ahead, drag * aside, lift_n];

        let mut force = to_world(&axes, force);
        if let Some(legs) = legs {
            let (push, turn) = legs.load(&state.body(&axes), deck, &state.contact);
            force = add(force, push);
            torque = add(torque, turn);
        }
        let mut acceleration = scale(force, 1.0 / self.mass_kg);
        acceleration[2] -= self.gravity_mps2;
        let inertia = self.body.inertia_kg_m2;
        let [p, q, r] = state.rates;
        let momentum = [inertia[0] * p, inertia[1] * q, inertia[2] * r];
        let turning = sub(torque, cross(state.rates, momentum));
        let spin_up = [
            turning[0] / inertia[0],
            turning[1] / inertia[1],
            turning[2] / inertia[2],
        ];
        let rate = RigidState {
            rotors: self
                .rotors
                .derivative(&state.rotors, &target, throttle, &places),
            position_m: state.velocity_mps,
            velocity_mps: acceleration,
            attitude: product(state.attitude, [0.0, 0.5 * p, 0.5 * q, 0.5 * r]),
            rates: spin_up,
            contact: state.contact,
        };
        let loads = Loads {
            acceleration_mps2: acceleration,
            angular_acceleration: spin_up,
            rotor_n,
            ground_effect_n: forces.ground_effect_n,
            target,
        };
        (rate, loads)
    }

    /// ρ of each rotor in a state.
    #[inline]
    fn edge_shares(&self, position_m: [f64; 3], attitude: [f64; 4], deck: &DeckPose) -> [f64; 4] {
        let axes = axes_of(attitude);
        let mut places = self.hubs_m;
        for place in &mut places {
            let from_centre = sub(add(position_m, to_world(&axes, *place)), deck.origin_m);
            *place = along(&deck.axes, from_centre);
        }
        self.rotors.edge_shares(&places)
    }

    /// What acts in a state.
    #[must_use]
    pub fn loads(&self, state: &RigidState, deck: &DeckPose, disturbance: &Disturbance) -> Loads {
        let share = self.edge_shares(state.position_m, state.attitude, deck);
        let legs = self.legs_near(state, deck);
        self.rate(state, deck, &[0.0; 4], disturbance, &share, legs)
            .1
    }

    /// The legs, if a foot may touch the deck within a step.
    #[inline]
    fn legs_near(&self, state: &RigidState, deck: &DeckPose) -> Option<&Legs> {
        let near = |legs: &&Legs| !legs.clear(state.position_m, deck);
        self.legs.as_ref().filter(near)
    }

    /// The feet as they stand; all in the air for a vehicle without legs.
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

    /// Adds the state after a step to what is known of the contact.
    pub fn log_contact(
        &self,
        log: &mut ContactLog,
        time_s: f64,
        state: &RigidState,
        deck: &DeckPose,
    ) {
        let Some(legs) = &self.legs else { return };
        if log.first_touch_s.is_none() && legs.clear(state.position_m, deck) {
            return;
        }
        let up = dot(state.axes()[2], deck.axes[2]).clamp(-1.0, 1.0);
        log.add(time_s, &self.feet(state, deck), up.acos(), legs.settings());
    }

    /// One Runge–Kutta step of `dt`; `deck` is the deck at the start, the middle
    /// and the end of the step. Returns the loads at its start.
    ///
    /// ρ, what a rotor sees of the plate, is frozen within the step, at the place
    /// that velocity and rates lead to by its middle. The error is of second
    /// order in the step: across the edge of the deck at 2 m/s it moves the
    /// vehicle by less than a micrometre.
    #[inline]
    pub fn step(
        &self,
        state: &mut RigidState,
        deck: &[DeckPose; 3],
        throttle: &[f64; 4],
        disturbance: &Disturbance,
        dt: f64,
    ) -> Loads {
        let [p, q, r] = scale(state.rates, 0.25 * dt);
        let turned = normalised(product(state.attitude, [1.0, p, q, r]));
        let moved = add(state.position_m, scale(state.velocity_mps, 0.5 * dt));
        let share = self.edge_shares(moved, turned, &deck[1]);
        let (legs, contact) = (self.legs_near(state, &deck[0]), state.contact);
        let (first, loads) = self.rate(state, &deck[0], throttle, disturbance, &share, legs);
        let next = rk4::step_from(&state.to_array(), first.to_array(), dt, |stage, y| {
            let state = RigidState::from_array(y, contact);
            let deck = &deck[stage];
            let (rate, _) = self.rate(&state, deck, throttle, disturbance, &share, legs);
            rate.to_array()
        });
        *state = RigidState::from_array(&next, contact);
        state.attitude = normalised(state.attitude);
        if let Some(legs) = legs {
            let axes = state.axes();
            legs.settle(&state.body(&axes), &deck[2], &mut state.contact);
        }
        loads
    }

    /// Level and in relative rest `height_m` above the centre of the deck, with
    /// forces in balance there as over a level deck and the air at rest; and the
    /// throttle that holds it. Heading is along the deck's.
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
