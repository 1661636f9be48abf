//! Landing legs on a deck that moves and tilts.
//!
//! A foot at the depth δ below the deck's plane, with the velocity v of the foot
//! relative to the deck's material there, is pushed by
//!
//! ```text
//! normal      N = max(0, k δ - c v_n)                 while δ > 0 and over the deck
//! tangential  F = -k_t u - c_t v_t, |F| ≤ μ N          u: displacement from the anchor
//! ```
//!
//! Inside the friction cone the foot sticks to its anchor, so a vehicle at rest on a
//! tilted deck does not creep. At the edge of the cone it slides and drags the anchor
//! along, so that the spring force alone stays within μ N (elastic–plastic friction,
//! Dahl's stiff limit). Anchors are stored in the deck's axes. They are constant during a
//! step of the integration and move after it.
//!
//! A foot beyond the edge of a plate has no contact, nor has a foot deeper than
//! [`DEEPEST_M`], which has passed below the deck. Legs act along the deck's normal, not
//! along the body's axis. A touch inside a step of 1 ms shifts the start of the damping by
//! less than the step, which changes the speed after a bounce by 1 %.

mod log;

use serde::{Deserialize, Serialize};

use crate::STEP_S;
use crate::air::ground::DeckSurface;
use crate::body::plant::PlantSettings;
use crate::check;
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::number::Number;
use crate::number::vector::{Axes, add, along, corners, cross, dot, sub, to_world};

pub use log::ContactLog;

/// Depth below the deck's plane at which a foot is no longer on the deck, m. A touchdown
/// at 1 m/s compresses the default legs by 13 mm (`v √(m / 4k)`). Below that depth hard
/// touchdowns would fall through; a much larger depth would catch a vehicle that flies
/// under the deck's edge.
pub const DEEPEST_M: f64 = 0.05;

/// Clearance of a foot at rest below which its contact is computed, m. The value costs
/// only computing time: the force is zero above the deck.
const RESERVE_M: f64 = 0.001;
/// Time over which a moving foot may reach the deck, s: two steps of the integration, the
/// present one and one in reserve. The value costs only computing time.
const RESERVE_S: f64 = 2.0 * STEP_S;

/// Four feet at the corners of a square, under the arms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LegSettings {
    /// Distance of the feet from the vertical axis, m.
    pub radius_m: f64,
    /// Depth of the feet below the reference point, m.
    pub depth_m: f64,
    /// Stiffness of a leg k, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping of a leg c, N s/m.
    pub damping_ns_per_m: f64,
    /// Stiffness of a sticking foot k_t, N/m.
    pub tangential_stiffness_n_per_m: f64,
    /// Damping of a sticking foot c_t, N s/m.
    pub tangential_damping_ns_per_m: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Tilt from the deck's normal beyond which the vehicle has tipped over, rad.
    pub tipped_rad: f64,
}

impl Default for LegSettings {
    /// Four elastic legs of a vehicle of 1.37 kg, by order of magnitude; none was measured.
    ///
    /// - Normal: the weight compresses the legs by 1.7 mm, and the damping ratio of the
    ///   bounce is 0.5 (`4c / 2√(4k m)`).
    /// - Tangential: as stiff as along the normal, with a damping ratio of 0.3.
    /// - Friction: 0.6, as rubber on painted steel.
    /// - Tipping: beyond 0.98 rad, atan(0.15/0.10), the centre of mass is outside all feet.
    fn default() -> Self {
        Self {
            radius_m: 0.15,
            depth_m: 0.10,
            stiffness_n_per_m: 2_000.0,
            damping_ns_per_m: 25.0,
            tangential_stiffness_n_per_m: 2_000.0,
            tangential_damping_ns_per_m: 15.0,
            friction: 0.6,
            tipped_rad: 1.0,
        }
    }
}

impl LegSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Lengths, stiffnesses and the angle must be positive, damping and friction
    /// not negative.
    pub fn validate(&self) -> Result<(), SimError> {
        check::positive("radius_m", self.radius_m)?;
        check::positive("depth_m", self.depth_m)?;
        check::positive("stiffness_n_per_m", self.stiffness_n_per_m)?;
        check::not_negative("damping_ns_per_m", self.damping_ns_per_m)?;
        check::positive(
            "tangential_stiffness_n_per_m",
            self.tangential_stiffness_n_per_m,
        )?;
        check::not_negative(
            "tangential_damping_ns_per_m",
            self.tangential_damping_ns_per_m,
        )?;
        check::not_negative("friction", self.friction)?;
        check::within("tipped_rad", self.tipped_rad, 0.1, 3.2)
    }
}

/// Anchor of each foot in the deck's axes (forward, port); `None` in the air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactState {
    /// The anchors, m.
    pub stuck_m: [Option<[f64; 2]>; 4],
}

impl ContactState {
    #[inline]
    pub(crate) fn foothold(&self) -> Foothold<f64> {
        Foothold {
            sticks: self.stuck_m.map(|place| place.is_some()),
            stuck_m: self.stuck_m.map(Option::unwrap_or_default),
        }
    }

    #[inline]
    pub(crate) fn of(foothold: &Foothold<f64>) -> Self {
        let stuck = |i: usize| foothold.sticks[i].then_some(foothold.stuck_m[i]);
        Self {
            stuck_m: std::array::from_fn(stuck),
        }
    }
}

/// [`ContactState`] for any number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foothold<N: Number> {
    pub(crate) sticks: [N::Truth; 4],
    pub(crate) stuck_m: [[N; 2]; 4],
}

/// Contact of one foot with the deck, in the deck's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Foot {
    /// Depth below the deck's plane δ (above 0: touching), m.
    pub depth_m: f64,
    /// Position of the foot: forward, port, m.
    pub place_m: [f64; 2],
    /// Force on the foot: forward, port, normal, N.
    pub force_n: [f64; 3],
    /// Whether friction is at its limit.
    pub slides: bool,
}

/// [`Foot`] for any number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FootState<N: Number> {
    pub(crate) depth_m: N,
    pub(crate) place_m: [N; 2],
    pub(crate) force_n: [N; 3],
    pub(crate) slides: N::Truth,
}

/// Motion of the body that the legs need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body<'a, N = f64> {
    pub(crate) position_m: [N; 3],
    pub(crate) velocity_mps: [N; 3],
    pub(crate) axes: &'a Axes<N>,
    pub(crate) rates: [N; 3],
}

/// A body in the deck's axes: position and velocity of its reference point relative to the
/// deck's material there, its rotation relative to the deck, its axes, and the feet
/// relative to the reference point.
struct Stance<N> {
    centre_m: [N; 3],
    velocity_mps: [N; 3],
    turning: [N; 3],
    axes: Axes<N>,
    arms_m: [[N; 3]; 4],
}

/// Model of the legs; its coefficients are constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Legs {
    settings: LegSettings,
    feet_m: [[f64; 3]; 4],
    half_side_m: Option<f64>,
    present: bool,
}

impl Legs {
    /// Checks the settings and builds the legs over the surface of `plant`.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn new(settings: &LegSettings, plant: &PlantSettings) -> Result<Self, SimError> {
        settings.validate()?;
        let (a, h) = (
            settings.radius_m * std::f64::consts::FRAC_1_SQRT_2,
            -settings.depth_m,
        );
        let deck = DeckSurface::new(&plant.wake())?;
        Ok(Self {
            settings: *settings,
            feet_m: [[a, a, h], [-a, a, h], [-a, -a, h], [a, -a, h]],
            half_side_m: deck.half_side_m(),
            present: deck.finite_plate(1.0) > 0.0,
        })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &LegSettings {
        &self.settings
    }

    /// Whether a foot may touch within a step of 1 ms.
    #[inline(always)]
    pub(crate) fn near<N: Number>(&self, body: &Body<'_, N>, deck: &DeckPose<N>) -> N::Truth {
        let normal = deck.axes[2];
        let above = dot(normal, sub(body.position_m, deck.origin_m));
        let [x, y, z] = along(body.axes, normal);
        // The lowest and the highest corner of the feet's square.
        let [a, _, h] = self.feet_m[0];
        let (centre, half) = (above + z * h, (x.abs() + y.abs()) * a);
        // The deck turns more slowly than the body, so its rotation is within the reserve.
        let [p, q, r] = body.rates;
        let turn = p.abs() + q.abs() + r.abs();
        let speed = dot(normal, sub(body.velocity_mps, deck.velocity_mps)).abs()
            + turn * self.settings.radius_m.max(self.settings.depth_m);
        let reserve = speed * RESERVE_S + RESERVE_M;
        let low = (centre - half).below(reserve);
        let passed = (centre + half + reserve).below(-DEEPEST_M);
        let present = above.splat(f64::from(u8::from(self.present))).above(0.0);
        low & !passed & present
    }

    /// A body in the deck's axes.
    #[inline(always)]
    fn stance<N: Number>(&self, body: &Body<'_, N>, deck: &DeckPose<N>) -> Stance<N> {
        let from_centre = sub(body.position_m, deck.origin_m);
        let axes = [
            along(&deck.axes, body.axes[0]),
            along(&deck.axes, body.axes[1]),
            along(&deck.axes, body.axes[2]),
        ];
        let velocity = sub(body.velocity_mps, deck.point_velocity(from_centre));
        let turning = sub(
            to_world(&axes, body.rates),
            along(&deck.axes, deck.angular_velocity),
        );
        let [a, _, h] = self.feet_m[0];
        let mut arms_m = [axes[0]; 4];
        for k in 0..3 {
            let at = corners(axes[0][k] * a, axes[1][k] * a, axes[2][k] * h);
            for i in 0..4 {
                arms_m[i][k] = at[i];
            }
        }
        Stance {
            centre_m: along(&deck.axes, from_centre),
            velocity_mps: along(&deck.axes, velocity),
            turning,
            axes,
            arms_m,
        }
    }

    /// Force on a foot and its contact, in the deck's axes.
    #[inline(always)]
    fn foot<N: Number>(&self, i: usize, stance: &Stance<N>, contact: &Foothold<N>) -> FootState<N> {
        let (sticks, stuck_m) = (contact.sticks[i], contact.stuck_m[i]);
        let arm_m = stance.arms_m[i];
        let [x, y, z] = add(stance.centre_m, arm_m);
        let depth_m = -z;
        let [vx, vy, vn] = add(stance.velocity_mps, cross(stance.turning, arm_m));
        let s = &self.settings;
        let normal = depth_m * s.stiffness_n_per_m - vn * s.damping_ns_per_m;
        let half_m = self.half_side_m.unwrap_or(f64::INFINITY);
        let beside = x.abs().above(half_m) | y.abs().above(half_m);
        let on = depth_m.above(0.0) & !depth_m.above(DEEPEST_M) & !beside;
        let normal = N::select(on, normal.at_least(0.0), 0.0);
        let u = N::select(sticks, x - stuck_m[0], 0.0);
        let v = N::select(sticks, y - stuck_m[1], 0.0);
        let (k, c) = (
            -s.tangential_stiffness_n_per_m,
            s.tangential_damping_ns_per_m,
        );
        let (fx, fy) = (u * k - vx * c, v * k - vy * c);
        let force = (fx * fx + fy * fy).sqrt();
        let limit = normal * s.friction;
        let slides = limit.below(force) & on;
        let share = N::select(slides, limit / force, 1.0);
        let share = N::select(on, share, 0.0);
        FootState {
            depth_m,
            place_m: [x, y],
            force_n: [share * fx, share * fy, normal],
            slides,
        }
    }

    /// Force on the body in world axes and torque in body axes.
    #[inline(always)]
    pub(crate) fn load<N: Number>(
        &self,
        body: &Body<'_, N>,
        deck: &DeckPose<N>,
        contact: &Foothold<N>,
    ) -> ([N; 3], [N; 3]) {
        let zero = body.rates[0].splat(0.0);
        let stance = self.stance(body, deck);
        let (mut force, mut torque) = ([zero; 3], [zero; 3]);
        for i in 0..4 {
            let push = self.foot(i, &stance, contact).force_n;
            force = add(force, push);
            torque = add(torque, cross(stance.arms_m[i], push));
        }
        (to_world(&deck.axes, force), along(&stance.axes, torque))
    }

    /// Contact of the four feet.
    #[inline(always)]
    pub(crate) fn feet_at<N: Number>(
        &self,
        body: &Body<'_, N>,
        deck: &DeckPose<N>,
        contact: &Foothold<N>,
    ) -> [FootState<N>; 4] {
        let stance = self.stance(body, deck);
        [
            self.foot(0, &stance, contact),
            self.foot(1, &stance, contact),
            self.foot(2, &stance, contact),
            self.foot(3, &stance, contact),
        ]
    }

    /// [`Self::feet_at`] of one vehicle.
    pub(crate) fn feet(
        &self,
        body: &Body<'_>,
        deck: &DeckPose,
        contact: &ContactState,
    ) -> [Foot; 4] {
        self.feet_at(body, deck, &contact.foothold())
            .map(|foot| Foot {
                depth_m: foot.depth_m,
                place_m: foot.place_m,
                force_n: foot.force_n,
                slides: foot.slides,
            })
    }

    /// Updates the anchors after a step. A foot that lands gets an anchor, a sliding foot
    /// drags its anchor along, and a foot in the air has none.
    #[inline(always)]
    pub(crate) fn settle<N: Number>(
        &self,
        body: &Body<'_, N>,
        deck: &DeckPose<N>,
        contact: &mut Foothold<N>,
    ) {
        let feet = self.feet_at(body, deck, contact);
        for i in 0..4 {
            let (normal, [x, y]) = (feet[i].force_n[2], feet[i].place_m);
            let sticks = contact.sticks[i];
            let [a, b] = contact.stuck_m[i];
            let u = N::select(sticks, x - a, 0.0);
            let v = N::select(sticks, y - b, 0.0);
            let most =
                normal * (self.settings.friction / self.settings.tangential_stiffness_n_per_m);
            let way = (u * u + v * v).sqrt();
            let share = N::select(most.below(way), most / way, 1.0);
            contact.sticks[i] = normal.above(0.0);
            contact.stuck_m[i] = [x - share * u, y - share * v];
        }
    }

    /// Energy in the springs of legs and sticking feet, J.
    #[must_use]
    pub fn spring_energy_j(&self, feet: &[Foot; 4], contact: &ContactState) -> f64 {
        let s = &self.settings;
        let of = |(foot, stuck): (&Foot, &Option<[f64; 2]>)| {
            if foot.force_n[2] <= 0.0 {
                return 0.0;
            }
            let way2 = stuck.map_or(0.0, |[a, b]| {
                (foot.place_m[0] - a).powi(2) + (foot.place_m[1] - b).powi(2)
            });
            0.5 * s.stiffness_n_per_m * foot.depth_m * foot.depth_m
                + 0.5 * s.tangential_stiffness_n_per_m * way2
        };
        feet.iter().zip(&contact.stuck_m).map(of).sum()
    }
}
