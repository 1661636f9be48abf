//! Landing legs on a deck that moves and tilts.
//!
//! A foot at the depth δ below the deck's plane, with the velocity v of the foot
//! relative to the deck's material there, is pushed by
//!
//! ```text
//! normal      N = max(0, k δ - c v_n)                 while δ > 0 and over the deck
//! tangential  F = -k_t u - c_t v_t, |F| ≤ μ N          u: way from where the foot stuck
//! ```
//!
//! Inside the cone of friction the foot sticks: a vehicle at rest on a tilted
//! deck does not creep. At its edge it slides, and the place where it sticks is
//! dragged along so that the spring alone stays within μ N (elastic–plastic
//! friction, Dahl's stiff limit). Places are kept in the deck's axes, held
//! during a step of the integration and moved after it. A foot beyond the edge
//! of a plate finds nothing, nor does one that is deeper than [`DEEPEST_M`]: it
//! has passed below. Legs act along the deck's normal, not along the body's. A touch
//! inside a step of 1 ms misplaces the onset of the damping by less than that:
//! 1 % of the speed of a bounce.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::ground::Deck;
use crate::plant::PlantSettings;
use crate::vector::{Axes, add, along, cross, dot, sub, to_world};

/// Depth below the deck's plane at which a foot is no longer on the deck, m.
pub const DEEPEST_M: f64 = 0.05;

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

/// Where each foot sticks, in the deck's axes (forward, port); `None` in the air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactState {
    /// The places, m.
    pub stuck_m: [Option<[f64; 2]>; 4],
}

/// One foot against the deck, in the deck's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Foot {
    /// Depth below the deck's plane δ (above 0: touching), m.
    pub depth_m: f64,
    /// Place of the foot: forward, port, m.
    pub place_m: [f64; 2],
    /// Force on the foot: forward, port, normal, N.
    pub force_n: [f64; 3],
    /// Whether friction is at its limit.
    pub slides: bool,
}

/// Motion of the body that the legs need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body<'a> {
    pub(crate) position_m: [f64; 3],
    pub(crate) velocity_mps: [f64; 3],
    pub(crate) axes: &'a Axes,
    pub(crate) rates: [f64; 3],
}

/// Legs with coefficients that do not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Legs {
    settings: LegSettings,
    feet_m: [[f64; 3]; 4],
    half_side_m: Option<f64>,
    present: bool,
    reach_m: f64,
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
        let deck = Deck::new(plant)?;
        Ok(Self {
            settings: *settings,
            feet_m: [[a, a, h], [-a, a, h], [-a, -a, h], [a, -a, h]],
            half_side_m: deck.half_side_m(),
            present: deck.finite_plate(1.0) > 0.0,
            // 1 cm in reserve: the way of a step at 10 m/s.
            reach_m: settings.radius_m.hypot(settings.depth_m) + 0.01,
        })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &LegSettings {
        &self.settings
    }

    /// Whether no foot can touch, whatever the attitude.
    #[inline]
    pub(crate) fn clear(&self, position_m: [f64; 3], deck: &DeckPose) -> bool {
        let above = dot(deck.axes[2], sub(position_m, deck.origin_m));
        !self.present || above > self.reach_m || above < -self.reach_m - DEEPEST_M
    }

    /// Force on a foot, in the deck's axes, and how it stands.
    #[inline]
    fn foot(
        &self,
        arm_m: [f64; 3],
        body: &Body<'_>,
        deck: &DeckPose,
        stuck_m: Option<[f64; 2]>,
    ) -> Foot {
        let from_centre = sub(add(body.position_m, arm_m), deck.origin_m);
        let [x, y, z] = along(&deck.axes, from_centre);
        let mut foot = Foot {
            depth_m: -z,
            place_m: [x, y],
            ..Foot::default()
        };
        let over = self
            .half_side_m
            .is_none_or(|l| x.abs() <= l && y.abs() <= l);
        if !over || foot.depth_m <= 0.0 || foot.depth_m > DEEPEST_M {
            return foot;
        }
        let spun = to_world(body.axes, cross(body.rates, along(body.axes, arm_m)));
        let velocity = sub(
            add(body.velocity_mps, spun),
            deck.point_velocity(from_centre),
        );
        let [vx, vy, vn] = along(&deck.axes, velocity);
        let s = &self.settings;
        let normal = (s.stiffness_n_per_m * foot.depth_m - s.damping_ns_per_m * vn).max(0.0);
        let [u, v] = stuck_m.map_or([0.0; 2], |[a, b]| [x - a, y - b]);
        let (k, c) = (
            s.tangential_stiffness_n_per_m,
            s.tangential_damping_ns_per_m,
        );
        let (fx, fy) = (-k * u - c * vx, -k * v - c * vy);
        let (force, limit) = (fx.hypot(fy), s.friction * normal);
        foot.slides = force > limit;
        let share = if foot.slides { limit / force } else { 1.0 };
        foot.force_n = [share * fx, share * fy, normal];
        foot
    }

    /// Force on the body in world axes and torque in body axes.
    #[inline]
    pub(crate) fn load(
        &self,
        body: &Body<'_>,
        deck: &DeckPose,
        contact: &ContactState,
    ) -> ([f64; 3], [f64; 3]) {
        let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
        for (foot_m, stuck_m) in self.feet_m.iter().zip(contact.stuck_m) {
            let arm_m = to_world(body.axes, *foot_m);
            let foot = self.foot(arm_m, body, deck, stuck_m);
            let push = to_world(&deck.axes, foot.force_n);
            force = add(force, push);
            torque = add(torque, along(body.axes, cross(arm_m, push)));
        }
        (force, torque)
    }

    /// The four feet as they stand.
    pub(crate) fn feet(
        &self,
        body: &Body<'_>,
        deck: &DeckPose,
        contact: &ContactState,
    ) -> [Foot; 4] {
        std::array::from_fn(|i| {
            let arm_m = to_world(body.axes, self.feet_m[i]);
            self.foot(arm_m, body, deck, contact.stuck_m[i])
        })
    }

    /// Moves the places where feet stick after a step: a foot that lands sticks
    /// where it is, one that slides drags its place along, one that left has none.
    #[inline]
    pub(crate) fn settle(&self, body: &Body<'_>, deck: &DeckPose, contact: &mut ContactState) {
        let feet = self.feet(body, deck, contact);
        for (foot, stuck_m) in feet.iter().zip(&mut contact.stuck_m) {
            let normal = foot.force_n[2];
            let touching = foot.depth_m > 0.0 && normal > 0.0;
            *stuck_m = touching.then(|| {
                let [x, y] = foot.place_m;
                let [a, b] = stuck_m.unwrap_or(foot.place_m);
                let (u, v) = (x - a, y - b);
                let most =
                    self.settings.friction * normal / self.settings.tangential_stiffness_n_per_m;
                let way = u.hypot(v);
                let share = if way > most { most / way } else { 1.0 };
                [x - share * u, y - share * v]
            });
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

/// What happened between legs and deck, step by step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ContactLog {
    /// Time of the first touch, s.
    pub first_touch_s: Option<f64>,
    /// Times all feet have left the deck again after a touch.
    pub bounces: u32,
    /// Highest clearance of the lowest foot after the first touch, m.
    pub bounce_height_m: f64,
    /// Way that feet have slid, the greatest of the four, m.
    pub slide_m: f64,
    /// Greatest normal force on a foot, N.
    pub greatest_normal_n: f64,
    /// Greatest tilt from the deck's normal after the first touch, rad.
    pub greatest_tilt_rad: f64,
    /// Time at which the tilt passed the limit: the vehicle has tipped over, s.
    pub tipped_s: Option<f64>,
    /// Time at which a vehicle that had touched had no foot on the deck and one
    /// more than [`DEEPEST_M`] below its plane, s: it fell off.
    pub fell_s: Option<f64>,
    /// Way slid by each foot, m.
    pub slid_m: [f64; 4],
    /// Feet on the deck at the last step.
    pub feet_down: u32,
    /// Where feet were at the last step, and whether on the deck.
    #[serde(skip)]
    before: [Option<[f64; 2]>; 4],
}

impl ContactLog {
    /// Adds the feet after a step at the time t; `tilt_rad` is the angle
    /// between the body's z axis and the deck's normal.
    pub fn add(&mut self, time_s: f64, feet: &[Foot; 4], tilt_rad: f64, settings: &LegSettings) {
        let on = feet.map(|foot| (foot.force_n[2] > 0.0).then_some(foot.place_m));
        let down = on.iter().flatten().count() as u32;
        if down > 0 && self.first_touch_s.is_none() {
            self.first_touch_s = Some(time_s);
        }
        if self.first_touch_s.is_none() {
            return;
        }
        self.bounces += u32::from(self.feet_down > 0 && down == 0);
        self.feet_down = down;
        let deepest = feet.iter().map(|f| f.depth_m).fold(f64::MIN, f64::max);
        self.bounce_height_m = self.bounce_height_m.max(-deepest);
        self.greatest_tilt_rad = self.greatest_tilt_rad.max(tilt_rad);
        for i in 0..4 {
            self.greatest_normal_n = self.greatest_normal_n.max(feet[i].force_n[2]);
            if let (true, Some([x, y]), Some([a, b])) = (feet[i].slides, on[i], self.before[i]) {
                self.slid_m[i] += (x - a).hypot(y - b);
                self.slide_m = self.slide_m.max(self.slid_m[i]);
            }
        }
        self.before = on;
        if tilt_rad > settings.tipped_rad && self.tipped_s.is_none() {
            self.tipped_s = Some(time_s);
        }
        if down == 0 && deepest > DEEPEST_M && self.fell_s.is_none() {
            self.fell_s = Some(time_s);
        }
    }
}
