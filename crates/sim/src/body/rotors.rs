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
//! z_i is the height of rotor i along the deck's normal, z_c the mean of the four. ρ_i is
//! the rotor's share of the plate's solid angle ([`DeckSurface::edge_share`]), ρ_c the mean
//! of the four. w_i is the rotor's speed along the normal less the vertical wind, u_i the
//! speed of the deck point below. All motors share a battery, whose voltage sags with the
//! mean throttle. The second plant's law uses the height without that of the rotor plane,
//! and the same ρ_i.
//!
//! Rotors are numbered front left, rear left, rear right, front right.
//!
//! [`DeckSurface::edge_share`]: crate::air::ground::DeckSurface::edge_share

use crate::air::ground::{WakeLag, rotor_force};
use crate::air::height_table::HeightTable;
use crate::body::plant::{Law, Plant, PlantSettings};
use crate::error::SimError;
use crate::number::Number;

use crate::air::turbulence::TURBULENCE_CORRELATION;

/// Least √(4 T_i) in ratios of induced speeds, √N: 3 % of the value in hover. It only
/// keeps the ratio finite for a rotor that stands still.
const LEAST_ROOT: f64 = 0.1;

/// State of four rotors and the air around them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorsState<N = f64> {
    /// x_i = √(4 T_i), each rotor on the scale of the whole vehicle, √N.
    pub root_thrust: [N; 4],
    /// Lagged inflow q1_i of each rotor; the lift ratio G_i - 1 of the second plant.
    pub inflow: [N; 4],
    /// Lagged fountain q2, the same for all; unused by the second plant.
    pub fountain: N,
}

/// Position and speeds of a rotor relative to the deck.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorPlace {
    /// Position of the hub in the deck's axes: forward, port, height along the normal, m.
    pub place_m: [f64; 3],
    /// Speed along the deck's normal less the vertical wind w_i, m/s.
    pub climb_mps: f64,
    /// Speed of the deck point below, along its normal u_i, m/s.
    pub deck_mps: f64,
}

/// Steady inflow and upwash of the rotors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorsTarget<N = f64> {
    /// q1*_i (the steady lift ratio of the second plant).
    pub inflow: [N; 4],
    /// q2*.
    pub fountain: N,
    /// P(z_i) ρ_i.
    pub upwash: [N; 4],
    /// z_c, at least 0.05 m.
    pub mean_height_m: N,
}

/// Each rotor's share of the plate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares<N = f64> {
    /// ρ_i.
    pub(crate) plate: [N; 4],
    /// P(z_i) ρ_i.
    pub(crate) upwash: [N; 4],
}

/// Effect of the deck on the rotors, constant over a step of the integration: steady
/// inflow, rates of the lags, and upwash.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldRotors<N> {
    pub(crate) target: RotorsTarget<N>,
    /// Rate of each rotor's lag, and of the fountain's.
    rotor_pace: [N; 4],
    fountain_pace: N,
    /// P(z_i) ρ_i u_i, m/s.
    pub(crate) air_mps: [N; 4],
}

/// Forces along the rotors' axes, without turbulence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorForces<N = f64> {
    /// T_i in free air, N.
    pub free_air_n: [N; 4],
    /// Ground effect and climb damping f_i, N.
    pub ground_effect_n: [N; 4],
}

/// Four rotors: the plant and the positions of the hubs.
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

    /// γ: scale of the ground effect.
    #[must_use]
    pub fn ground_effect_scale(&self) -> f64 {
        self.plant.ground_effect_scale()
    }

    /// The same rotors with another γ.
    pub(crate) fn with_ground_effect_scale(mut self, scale: f64) -> Self {
        self.plant = self.plant.with_ground_effect_scale(scale);
        self
    }

    /// ρ from a known 1/S0.
    #[inline(always)]
    fn plate<N: Number>(&self, places_m: &[[N; 3]; 4], inverse_angle: [N; 4]) -> [N; 4] {
        let mut shares = inverse_angle;
        if self.plant.deck.half_side_m().is_some() {
            let angles = self.plant.deck.solid_angles(places_m);
            for i in 0..4 {
                shares[i] = angles[i] * inverse_angle[i];
            }
        } else {
            shares = [shares[0].splat(1.0); 4];
        }
        shares
    }

    /// Shares of the plate of rotors at `places_m` in the deck's axes.
    #[inline(always)]
    pub(crate) fn shares<N: Number>(&self, places_m: &[[N; 3]; 4]) -> Shares<N> {
        let heights = places_m.map(|place| place[2]);
        let (mut at, mut upwash, mut inverse_angle) = (*places_m, heights, heights);
        for i in 0..4 {
            at[i][2] = at[i][2].at_least(self.plant.deck.least_rotor_height_m());
            let of = self.table.at(at[i][2]);
            (upwash[i], inverse_angle[i]) = (of.upwash, of.inverse_angle);
        }
        let plate = self.plate(&at, inverse_angle);
        for i in 0..4 {
            upwash[i] = upwash[i] * plate[i];
        }
        Shares { plate, upwash }
    }

    /// Steady inflow at the positions of the rotors.
    #[must_use]
    pub fn target(&self, root_thrust: &[f64; 4], places: &[RotorPlace; 4]) -> RotorsTarget {
        let deck_mps = places.map(|rotor| rotor.deck_mps);
        let places_m = places.map(|rotor| rotor.place_m);
        let (scale, shares) = (self.ground_effect_scale(), self.shares(&places_m));
        self.held(scale, root_thrust, &places_m, deck_mps, &shares)
            .target
    }

    /// Effect of the deck on rotors at `places_m` in its axes with `shares` of the plate,
    /// for the scale γ of the ground effect and speeds `deck_mps` of the points below.
    #[inline(always)]
    pub(crate) fn held<N: Number>(
        &self,
        scale: N,
        root_thrust: &[N; 4],
        places_m: &[[N; 3]; 4],
        deck_mps: [N; 4],
        shares: &Shares<N>,
    ) -> HeldRotors<N> {
        let zero = scale.splat(0.0);
        let least_m = self.plant.deck.least_rotor_height_m();
        let mut at = *places_m;
        let share = &shares.plate;
        let mut held = HeldRotors {
            target: RotorsTarget {
                inflow: [zero; 4],
                fountain: zero,
                upwash: shares.upwash,
                mean_height_m: zero,
            },
            rotor_pace: [zero; 4],
            fountain_pace: zero,
            air_mps: [zero; 4],
        };
        let target = &mut held.target;
        for i in 0..4 {
            at[i][2] = at[i][2].at_least(least_m);
            held.air_mps[i] = target.upwash[i] * deck_mps[i];
        }
        let mean_height_m = 0.25 * (at[0][2] + at[1][2] + at[2][2] + at[3][2]);
        target.mean_height_m = mean_height_m;
        match &self.plant.law {
            Law::WakeLag(law) => {
                let mut speeds = *root_thrust;
                for i in 0..4 {
                    speeds[i] = speeds[i].at_least(LEAST_ROOT);
                }
                let rotors = law.rotors_at(scale, &at, &speeds);
                for i in 0..4 {
                    target.inflow[i] = rotors.target[i] * share[i];
                }
                held.rotor_pace = rotors.pace;
                let mean_share = 0.25 * (share[0] + share[1] + share[2] + share[3]);
                let (fountain, pace) = law.fountain_at(scale, mean_height_m);
                target.fountain = fountain * mean_share;
                held.fountain_pace = pace;
            }
            Law::Exponential(law) if self.plant.present => {
                for i in 0..4 {
                    let height_m = places_m[i][2] - self.plant.rotor_height_m;
                    target.inflow[i] = law.target_at(scale, height_m) * share[i];
                }
            }
            Law::Exponential(_) => {}
        }
        held
    }

    /// Rate of the state. Throttles are limited to [0, 1].
    #[must_use]
    pub fn derivative(
        &self,
        state: &RotorsState,
        target: &RotorsTarget,
        throttle: &[f64; 4],
        places: &[RotorPlace; 4],
    ) -> RotorsState {
        let (rotor_pace, fountain_pace) = match &self.plant.law {
            Law::WakeLag(law) => (
                places.map(|rotor| law.rotor_pace(rotor.place_m[2])),
                law.fountain_pace(target.mean_height_m),
            ),
            Law::Exponential(_) => ([0.0; 4], 0.0),
        };
        let held = HeldRotors {
            target: *target,
            rotor_pace,
            fountain_pace,
            air_mps: [0.0; 4],
        };
        self.rate(state, &held, &self.drive(throttle))
    }

    /// Drive of the motors by throttles, which are limited to [0, 1].
    #[inline(always)]
    pub(crate) fn drive<N: Number>(&self, throttle: &[N; 4]) -> [N; 4] {
        let mut s = *throttle;
        for i in 0..4 {
            s[i] = s[i].within(0.0, 1.0);
        }
        let load = 0.25 * (s[0] + s[1] + s[2] + s[3]);
        for i in 0..4 {
            s[i] = self.plant.motor.drive(s[i], load);
        }
        s
    }

    /// Rate of the motors.
    #[inline(always)]
    pub(crate) fn spin_up<N: Number>(&self, root_thrust: &[N; 4], drive: &[N; 4]) -> [N; 4] {
        let mut rate = *root_thrust;
        for i in 0..4 {
            rate[i] = self.plant.motor.derivative_under(root_thrust[i], drive[i]);
        }
        rate
    }

    /// Rate of the state under a drive of the motors.
    #[inline(always)]
    pub(crate) fn rate<N: Number>(
        &self,
        state: &RotorsState<N>,
        held: &HeldRotors<N>,
        drive: &[N; 4],
    ) -> RotorsState<N> {
        let mut rate = RotorsState {
            root_thrust: self.spin_up(&state.root_thrust, drive),
            ..*state
        };
        let target = &held.target;
        match &self.plant.law {
            Law::WakeLag(law) => {
                let mut square = state.fountain.splat(0.0);
                for i in 0..4 {
                    let (q, x) = (state.inflow[i], state.root_thrust[i]);
                    square = square + 0.25 * (x * x);
                    let pace = held.rotor_pace[i];
                    rate.inflow[i] = law.lag_rate(q, target.inflow[i], pace, x);
                }
                let (q, to) = (state.fountain, target.fountain);
                rate.fountain = law.lag_rate(q, to, held.fountain_pace, square.sqrt());
            }
            Law::Exponential(law) => {
                for i in 0..4 {
                    rate.inflow[i] = law.derivative(state.inflow[i], target.inflow[i]);
                }
                rate.fountain = state.fountain.splat(0.0);
            }
        }
        rate
    }

    /// Forces along the rotors' axes, with the rotors climbing at `climb_mps` along
    /// the deck's normal.
    #[inline(always)]
    pub(crate) fn forces<N: Number>(
        &self,
        state: &RotorsState<N>,
        held: &HeldRotors<N>,
        climb_mps: &[N; 4],
    ) -> RotorForces<N> {
        let mut forces = RotorForces {
            free_air_n: state.root_thrust,
            ground_effect_n: state.root_thrust,
        };
        let ratios = match &self.plant.law {
            Law::WakeLag(_) => WakeLag::lift_ratios(&state.inflow, state.fountain),
            Law::Exponential(_) => state.inflow,
        };
        for i in 0..4 {
            let (x, ratio) = (state.root_thrust[i], ratios[i]);
            let air_mps = climb_mps[i] - held.air_mps[i];
            forces.free_air_n[i] = 0.25 * (x * x);
            forces.ground_effect_n[i] = rotor_force(x, ratio, self.plant.damping_per_root, air_mps);
        }
        forces
    }

    /// Standard deviation of the turbulent force on each rotor, N. Rotors are
    /// correlated by [`TURBULENCE_CORRELATION`]; four equal ones add up to
    /// [`Plant::turbulence_sd_n`].
    #[inline(always)]
    #[must_use]
    pub fn turbulence_sd_n<N: Number>(
        &self,
        root_thrust: &[N; 4],
        target: &RotorsTarget<N>,
    ) -> [N; 4] {
        // Var(Σ n_i) = (4 + 12 c) sd².
        let share = 1.0 / (4.0 + 12.0 * TURBULENCE_CORRELATION).sqrt();
        let mut sd_n = *root_thrust;
        for i in 0..4 {
            let inflow = [target.inflow[i], target.fountain];
            sd_n[i] = self.plant.turbulence_at(root_thrust[i], inflow) * share;
        }
        sd_n
    }
}
