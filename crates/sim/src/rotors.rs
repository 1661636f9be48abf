//! Four rotors above a tilted, moving, finite deck.
//!
//! Each rotor has the motor law, its own height above the deck's plane and its
//! own ground effect; the force on it is [`rotor_force`], the law of the
//! vertical [`Plant`], which is the case of four equal rotors.
//!
//! ```text
//! q1*_i = γ E(z_i) ρ_i min(Σ_j q_ij, 0.5)       q1_i' = (q1*_i - q1_i)/t1(z_i, T_i)
//! q2*   = γ E(z_c) ρ_c q_ftn(z_c)                q2'   = (q2* - q2)/t2(z_c, T)
//! F_i   = T_i + T_i (G_i - 1) - (k_v/4) (x_i/√W) (w_i - P(z_i) ρ_i u_i)
//! ```
//!
//! z_i is the height of rotor i along the deck's normal, z_c the mean of the
//! four, ρ_i the share of the plate that it sees ([`Deck::edge_share`]), ρ_c
//! the mean of the four; w_i is its speed along the normal less the vertical
//! wind, u_i the speed of the deck point below. The battery is one: it sags with
//! the mean throttle. The second plant's law takes the height less that of the
//! rotor plane and ρ_i the same way.
//!
//! Rotors are numbered front left, rear left, rear right, front right.
//!
//! [`Deck::edge_share`]: crate::ground::Deck::edge_share

use crate::error::SimError;
use crate::ground::{LEAST_ROTOR_HEIGHT_M, WakeLag, rotor_force};
use crate::height_table::HeightTable;
use crate::noise::Stream;
use crate::plant::{Law, Plant, PlantSettings};

/// Least √(4 T_i) in ratios of induced speeds, √N.
const LEAST_ROOT: f64 = 0.1;
/// Correlation of the turbulent forces on two rotors (an assumption).
pub const TURBULENCE_CORRELATION: f64 = 0.5;

/// State of four rotors and the air around them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorsState {
    /// x_i = √(4 T_i): each rotor on the scale of the whole vehicle, √N.
    pub root_thrust: [f64; 4],
    /// Lagged inflow q1_i of each rotor; the lift ratio G_i - 1 of the second plant.
    pub inflow: [f64; 4],
    /// Lagged fountain q2, the same for all; unused by the second plant.
    pub fountain: f64,
}

/// Where a rotor is and how it moves, relative to the deck.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorPlace {
    /// Place of the hub in the deck's axes: forward, port, height along the normal, m.
    pub place_m: [f64; 3],
    /// Speed along the deck's normal less the vertical wind w_i, m/s.
    pub climb_mps: f64,
    /// Speed of the deck point below, along its normal u_i, m/s.
    pub deck_mps: f64,
}

/// Inflow at rest, and what the deck's air does to a rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorsTarget {
    /// q1*_i (the lift ratio at rest of the second plant).
    pub inflow: [f64; 4],
    /// q2*.
    pub fountain: f64,
    /// P(z_i) ρ_i.
    pub upwash: [f64; 4],
    /// z_c, held at 0.05 m or more.
    pub mean_height_m: f64,
}

/// Forces along the rotors' axes, without turbulence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorForces {
    /// T_i in free air, N.
    pub free_air_n: [f64; 4],
    /// Ground effect and climb damping f_i, N.
    pub ground_effect_n: [f64; 4],
}

/// Four rotors: the plant, and where they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotors {
    plant: Plant,
    offset_m: f64,
    table: HeightTable,
}

impl Rotors {
    /// Checks the settings and builds the rotors.
    ///
    /// # Errors
    /// Those of [`Plant::new`].
    pub fn new(settings: &PlantSettings) -> Result<Self, SimError> {
        let (plant, offset_m) = (Plant::new(settings)?, 0.5 * settings.rotor_spacing_m);
        Ok(Self {
            plant,
            offset_m,
            table: HeightTable::new(plant.deck, offset_m),
        })
    }

    /// The plant of which this is the general case.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Hub of each rotor from the vehicle's reference point: forward, left, up, m.
    #[must_use]
    pub fn hubs_m(&self) -> [[f64; 3]; 4] {
        let (a, h) = (self.offset_m, self.plant.rotor_height_m);
        [[a, a, h], [-a, a, h], [-a, -a, h], [a, -a, h]]
    }

    /// ρ of each rotor at its place in the deck's axes.
    #[inline]
    #[must_use]
    pub fn edge_shares(&self, places_m: &[[f64; 3]; 4]) -> [f64; 4] {
        let deck = &self.plant.deck;
        if deck.half_side_m().is_none() {
            return [1.0; 4];
        }
        let mut shares = [0.0; 4];
        for i in 0..4 {
            let [x, y, z] = places_m[i];
            let z = z.max(LEAST_ROTOR_HEIGHT_M);
            shares[i] = deck.solid_angle([x, y, z]) * self.table.at(z).inverse_angle;
        }
        shares
    }

    /// Inflow at rest at the places of the rotors.
    #[must_use]
    pub fn target(&self, root_thrust: &[f64; 4], places: &[RotorPlace; 4]) -> RotorsTarget {
        let share = self.edge_shares(&places.map(|rotor| rotor.place_m));
        self.target_with(root_thrust, places, &share)
    }

    /// [`Self::target`] with the ρ of each rotor known.
    #[inline]
    #[must_use]
    pub fn target_with(
        &self,
        root_thrust: &[f64; 4],
        places: &[RotorPlace; 4],
        share: &[f64; 4],
    ) -> RotorsTarget {
        let mut at = [[0.0; 3]; 4];
        let mut plate = [0.0; 4];
        let mut target = RotorsTarget::default();
        for i in 0..4 {
            let [x, y, z] = places[i].place_m;
            let z = z.max(LEAST_ROTOR_HEIGHT_M);
            at[i] = [x, y, z];
            let of = self.table.at(z);
            plate[i] = of.finite_plate;
            target.upwash[i] = of.upwash * share[i];
        }
        let mean_height_m = 0.25 * (at[0][2] + at[1][2] + at[2][2] + at[3][2]);
        target.mean_height_m = mean_height_m;
        match &self.plant.law {
            Law::WakeLag(law) => {
                let mut speeds = *root_thrust;
                for x in &mut speeds {
                    *x = x.max(LEAST_ROOT);
                }
                let sums = law.image_sums(&at, &speeds);
                for i in 0..4 {
                    target.inflow[i] = law.rotor_target_over(plate[i], sums[i]) * share[i];
                }
                let mean_share = 0.25 * (share[0] + share[1] + share[2] + share[3]);
                let plate = self.table.at(mean_height_m).finite_plate;
                target.fountain = law.fountain_target_over(plate, mean_height_m) * mean_share;
            }
            Law::Exponential(law) if self.plant.present => {
                for i in 0..4 {
                    let height_m = places[i].place_m[2] - self.plant.rotor_height_m;
                    target.inflow[i] = law.target(height_m) * share[i];
                }
            }
            Law::Exponential(_) => {}
        }
        target
    }

    /// Rate of the state; throttles are held to [0, 1].
    #[inline]
    #[must_use]
    pub fn derivative(
        &self,
        state: &RotorsState,
        target: &RotorsTarget,
        throttle: &[f64; 4],
        places: &[RotorPlace; 4],
    ) -> RotorsState {
        let mut s = *throttle;
        for s in &mut s {
            *s = s.clamp(0.0, 1.0);
        }
        let load = 0.25 * (s[0] + s[1] + s[2] + s[3]);
        let mut rate = RotorsState::default();
        let mut thrust = 0.0;
        for i in 0..4 {
            let x = state.root_thrust[i];
            thrust += 0.25 * x * x;
            rate.root_thrust[i] = self.plant.motor.derivative_at_load(x, s[i], load);
            rate.inflow[i] = match &self.plant.law {
                Law::WakeLag(law) => {
                    law.rotor_rate(state.inflow[i], target.inflow[i], places[i].place_m[2], x)
                }
                Law::Exponential(law) => law.derivative(state.inflow[i], target.inflow[i]),
            };
        }
        if let Law::WakeLag(law) = &self.plant.law {
            let (z, x) = (target.mean_height_m, thrust.sqrt());
            rate.fountain = law.fountain_rate(state.fountain, target.fountain, z, x);
        }
        rate
    }

    /// Forces along the rotors' axes.
    #[inline]
    #[must_use]
    pub fn forces(
        &self,
        state: &RotorsState,
        target: &RotorsTarget,
        places: &[RotorPlace; 4],
    ) -> RotorForces {
        let mut forces = RotorForces::default();
        for i in 0..4 {
            let x = state.root_thrust[i];
            let ratio = match &self.plant.law {
                Law::WakeLag(_) => WakeLag::lift_ratio([state.inflow[i], state.fountain]),
                Law::Exponential(_) => state.inflow[i],
            };
            let air_mps = places[i].climb_mps - target.upwash[i] * places[i].deck_mps;
            forces.free_air_n[i] = 0.25 * x * x;
            forces.ground_effect_n[i] = rotor_force(x, ratio, self.plant.damping_per_root, air_mps);
        }
        forces
    }

    /// Standard deviation of the turbulent force on each rotor, N. Rotors are
    /// correlated by [`TURBULENCE_CORRELATION`]; four equal ones add up to
    /// [`Plant::turbulence_sd_n`].
    #[inline]
    #[must_use]
    pub fn turbulence_sd_n(&self, root_thrust: &[f64; 4], target: &RotorsTarget) -> [f64; 4] {
        // Var(Σ n_i) = (4 + 12 c) sd².
        let share = 1.0 / (4.0 + 12.0 * TURBULENCE_CORRELATION).sqrt();
        let fountain = target.fountain;
        std::array::from_fn(|i| {
            let inflow = [target.inflow[i], fountain];
            share * self.plant.turbulence_at(root_thrust[i], inflow)
        })
    }
}

/// Turbulent forces on four rotors: the process of [`Turbulence`] for each,
/// driven by noise that is partly common.
///
/// [`Turbulence`]: crate::noise::Turbulence
#[derive(Clone, Debug)]
pub struct RotorTurbulence {
    stream: Stream,
    decay: f64,
    gain: f64,
    values_n: [f64; 4],
}

impl RotorTurbulence {
    /// Stationary processes of the correlation time τ, stepped by `step_s`.
    #[must_use]
    pub fn new(mut stream: Stream, correlation_s: f64, step_s: f64, sd_n: [f64; 4]) -> Self {
        let noise = Self::noise(&mut stream);
        let decay = (-step_s / correlation_s).exp();
        Self {
            stream,
            decay,
            gain: (1.0 - decay * decay).sqrt(),
            values_n: std::array::from_fn(|i| sd_n[i] * noise[i]),
        }
    }

    /// Four normal numbers, correlated.
    #[inline]
    fn noise(stream: &mut Stream) -> [f64; 4] {
        let common = TURBULENCE_CORRELATION.sqrt() * stream.normal();
        let own = (1.0 - TURBULENCE_CORRELATION).sqrt();
        std::array::from_fn(|_| common + own * stream.normal())
    }

    /// The forces now, N.
    #[must_use]
    pub fn values_n(&self) -> [f64; 4] {
        self.values_n
    }

    /// One step at the standard deviations `sd_n`; returns the new forces, N.
    #[inline]
    pub fn step(&mut self, sd_n: [f64; 4]) -> [f64; 4] {
        let noise = Self::noise(&mut self.stream);
        for i in 0..4 {
            self.values_n[i] = self.decay * self.values_n[i] + self.gain * sd_n[i] * noise[i];
        }
        self.values_n
    }
}
