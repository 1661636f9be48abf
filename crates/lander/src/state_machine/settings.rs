//! Limits and times of the state machine.

use crate::check::{not_negative, positive};
use touchdown_flight::error::{SettingsError, ordered, within};
use touchdown_flight::real::{Real, r};

/// A limit that increases with height, `at_deck + per_m · height`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Funnel<R> {
    /// The limit at height zero.
    pub at_deck: R,
    /// Increase of the limit per metre of height.
    pub per_m: R,
}

impl<R: Real> Funnel<R> {
    /// The limit at a height. Negative heights count as zero.
    #[must_use]
    pub fn at(&self, height_m: R) -> R {
        self.at_deck + self.per_m * height_m.max(R::ZERO)
    }
}

/// State machine of a landing; see the [module](super).
///
/// | setting | default | what it bounds |
/// | --- | --- | --- |
/// | `hold_height_m`, `hold_tolerance_m` | 0.8, 0.15 | height of the hover, and how exactly it is held before a descent |
/// | `hold_lateral_m`, `hold_speed_mps` | 0.15, 0.25 | lateral error, speed relative to the deck at the start of a descent |
/// | `commit_height_m`, `commit_margin_m` | 0.30, 0.10 | height below which the vehicle continues without a tag; hysteresis above it |
/// | `touchdown_height_m` | 0.12 | greatest height in touchdown: that of contact plus the noise of the height |
/// | `touchdown_speed_mps`, `touchdown_lateral_mps` | 0.12, 0.25 | greatest speeds relative to the deck in touchdown |
/// | `idle_thrust_share`, `supported_load_factor` | 0.5, 0.7 | evidence that the deck carries the vehicle |
/// | `support_share`, `support_margin_m`, `support_s` | 0.04, 0.01, 0.03 | force of the deck on the legs, and for how long, before the thrust decreases |
/// | `tag_age_s`, `range_age_s`, `imu_age_s` | 0.3, 0.15, 0.05 | greatest ages, that of the tag without its latency |
/// | `coast_sd_m` | 0.03 | uncertainty of the height up to which the IMU alone carries it on |
/// | `lost_s`, `safe_height_m`, `search_s` | 2, 3.0, 30 | time without sight of the deck before a hover climbs, to which height, and until it gives up |
/// | `tilt_rad` | 0.35 | tilt of the vehicle |
/// | `lateral_m`, `closing_mps` | 0.10 + 0.25 z, 0.35 + 1.0 z | lateral error, speed towards the deck |
/// | `deck_tilt_rad`, `deck_speed_mps` | 0.14, 1.0 | the deck |
/// | `wind_slope` | 0.65 | the wind, by the trim's slope |
/// | `battery_low`, `battery_critical` | 0.2, 0.08 | remaining energy |
/// | `go_arounds`, `wind_go_arounds`, `hover_go_arounds` | 2, 10, 5 | aborted descents, those aborted for the wind, and go-arounds out of a hover, before giving up: one more gives up |
/// | `settle_s` | 0.5 | being ready before waiting for the planner |
/// | `contact_s`, `confirm_s` | 0.5, 0.2 | contact without any felt force before the thrust decreases, so that the last centimetres of the descent are flown; evidence before disarming |
/// | `bounce_s`, `fall_s` | 0.2, 0.05 | not touching, not supported |
/// | `excess_s`, `saturation_s` | 0.15, 0.3 | beyond a limit |
/// | `patience_s`, `landing_s`, `climb_s` | 120, 30, 5 | time limits of the phases |
/// | `greatest_step_s` | 0.1 | a longer step is a gap |
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct StateMachine<R> {
    /// Height of the hover above the deck, m.
    pub hold_height_m: R,
    /// Greatest error of that height at the start of a descent, m.
    pub hold_tolerance_m: R,
    /// Greatest lateral error at the start of a descent, m.
    pub hold_lateral_m: R,
    /// Greatest speed relative to the deck at the start of a descent, m/s. An oscillating
    /// hover does not improve during the descent.
    pub hold_speed_mps: R,
    /// Height below which the vehicle continues without a tag, m.
    pub commit_height_m: R,
    /// Hysteresis above the commit height, m.
    pub commit_margin_m: R,
    /// Greatest height in touchdown, m.
    pub touchdown_height_m: R,
    /// Greatest vertical speed relative to the deck in touchdown, m/s.
    pub touchdown_speed_mps: R,
    /// Greatest horizontal speed relative to the deck in touchdown, m/s.
    pub touchdown_lateral_mps: R,
    /// Greatest thrust in touchdown, share of the weight.
    pub idle_thrust_share: R,
    /// Least load factor of a vehicle that the deck carries.
    pub supported_load_factor: R,
    /// Least force of the deck on the legs that counts as contact, share of the weight. Above
    /// `touchdown_height_m` and `touchdown_speed_mps` twice as much counts.
    #[cfg_attr(feature = "serde", serde(default = "support_share"))]
    pub support_share: R,
    /// Height above `touchdown_height_m` up to which that force counts, m.
    #[cfg_attr(feature = "serde", serde(default = "support_margin_m"))]
    pub support_margin_m: R,
    /// Drop of the lowest foot below the others from which on the vehicle leans into the wind, m.
    #[cfg_attr(feature = "serde", serde(default = "leaning_m"))]
    pub leaning_m: R,
    /// Greatest time since a tag arrived, s.
    pub tag_age_s: R,
    /// Greatest age of the range, s.
    pub range_age_s: R,
    /// Greatest age of the IMU, s.
    pub imu_age_s: R,
    /// Standard deviation of the height up to which the IMU alone may carry it on, after range and tag, m.
    #[cfg_attr(feature = "serde", serde(default = "coast_sd_m"))]
    pub coast_sd_m: R,
    /// Time without sight of the deck after which a hover climbs to `safe_height_m`, s.
    #[cfg_attr(feature = "serde", serde(default = "lost_s"))]
    pub lost_s: R,
    /// Height above the deck at which the vehicle waits while it does not see the deck, m; at least `hold_height_m`.
    #[cfg_attr(feature = "serde", serde(default = "safe_height_m"))]
    pub safe_height_m: R,
    /// Time without sight of the deck after which the vehicle gives up, s.
    #[cfg_attr(feature = "serde", serde(default = "search_s"))]
    pub search_s: R,
    /// Greatest tilt of the vehicle, rad.
    pub tilt_rad: R,
    /// Greatest lateral error, m.
    pub lateral_m: Funnel<R>,
    /// Greatest speed towards the deck, m/s.
    pub closing_mps: Funnel<R>,
    /// Greatest tilt of the deck, rad.
    pub deck_tilt_rad: R,
    /// Greatest vertical speed of the deck, m/s.
    pub deck_speed_mps: R,
    /// Greatest slope of the trim in the wind at which a descent begins.
    #[cfg_attr(feature = "serde", serde(default = "wind_slope"))]
    pub wind_slope: R,
    /// Remaining energy at and below which no landing begins, in [0, 1].
    pub battery_low: R,
    /// Remaining energy at and below which the vehicle must land, in [0, 1].
    pub battery_critical: R,
    /// Number of aborted descents after which the machine still tries again, without those aborted for the wind.
    pub go_arounds: u8,
    /// Number of descents aborted for the wind after which it still tries again.
    #[cfg_attr(feature = "serde", serde(default = "wind_go_arounds"))]
    pub wind_go_arounds: u8,
    /// Number of go-arounds out of a hover after which it still tries again.
    #[cfg_attr(feature = "serde", serde(default = "hover_go_arounds"))]
    pub hover_go_arounds: u8,
    /// Time for which the vehicle must be ready before the planner decides, s.
    pub settle_s: R,
    /// Time of contact before the thrust decreases, s.
    pub contact_s: R,
    /// Time for which the legs feel the deck before the thrust decreases, s.
    #[cfg_attr(feature = "serde", serde(default = "support_s"))]
    pub support_s: R,
    /// Time of evidence before the rotors stop, s.
    pub confirm_s: R,
    /// Time without contact after which the touchdown counts as a bounce, s.
    pub bounce_s: R,
    /// Time without support before the vehicle climbs away, s.
    pub fall_s: R,
    /// Time beyond a limit before it counts, s.
    pub excess_s: R,
    /// Time of saturation before it counts, s.
    pub saturation_s: R,
    /// Greatest time in Approach, Hold and Wait, s.
    pub patience_s: R,
    /// Greatest time in Descend, Commit and Touchdown, s.
    pub landing_s: R,
    /// Greatest time in GoAround, s.
    pub climb_s: R,
    /// Longest step that is not a gap, s.
    pub greatest_step_s: R,
}

// Recordings of earlier versions do not have the keys of these.

/// 0.58 rad, 14 m/s on the default airframe, less than the 0.7 rad of `horizontal.tilt_limit_rad` by gusts. On the deck the
/// rotors' part of the drag ends with their speed, and friction of 0.6 holds the frame's. Halved, nothing lands above
/// 9 m/s; at 0.5 6 of 100 landings at 12 m/s are given up for gusts. The effect of doubling was not measured.
fn wind_slope<R: Real>() -> R {
    r(0.65)
}

/// Twice the errors of the models in a calm descent (0.02). Halved, touchdowns begin
/// in the air (worst touch 0.14 for 0.09 m/s); doubled, the motors stop 0.1 s later (0.47 to 0.59 s
/// after the touch on a deck of 0.05 m at 0.5 Hz).
fn support_share<R: Real>() -> R {
    r(0.04)
}

/// The estimate's error at contact, one resolution of the range finder. Doubled, two
/// of 200 landings in gusts of 4 m/s touch harder (0.25 for 0.21 m/s); halved, none
/// changes but the stop in gusts, 0.02 s later.
fn support_margin_m<R: Real>() -> R {
    r(0.01)
}

// Effects of this one are expected from single flights, not measured.
/// 0.09 rad of the default feet, the trim of 3 m/s. Halved, calm air on a rolling deck counts as wind; doubled, touches in
/// 5 m/s of wind are bounces.
fn leaning_m<R: Real>() -> R {
    r(0.01)
}

/// Three steps, less than a first contact (0.05 s). Halved or doubled, the stop moves
/// by 0.03 s.
fn support_s<R: Real>() -> R {
    r(0.03)
}

/// Three resolutions of the range finder: below the commit height, the time without a reading until it is exceeded is that of the last
/// decimetre. The effect of halving or doubling was not measured.
fn coast_sd_m<R: Real>() -> R {
    r(0.03)
}

/// Twice the second for which the deck estimator waits after a new latency, and less than the period of a sea of 0.5 m, in which the deck
/// takes a third of the hover's height. The effect of halving or doubling was not measured.
fn lost_s<R: Real>() -> R {
    r(2.0)
}

/// Above the crests of seas up to 2.5 m, and low enough to see the tags. The effect of halving or doubling was not measured.
fn safe_height_m<R: Real>() -> R {
    r(3.0)
}

/// More than aborted descents, because a hover is broken off far from the deck. With 2 for both, 391 of 400 vehicles landed in a sea of
/// 0.5 m instead of 397, when a hover of unknown height still counted as low. The effect of halving or doubling was not measured.
fn hover_go_arounds() -> u8 {
    5
}

/// Other gusts come every few seconds. Halved, 372 of 400 vehicles land at 12 m/s (1.37 kg) instead of 394. The effect of doubling was not
/// measured.
fn wind_go_arounds() -> u8 {
    10
}

/// A quarter of `patience_s`: what a battery can spare for a pad that may not be there.
fn search_s<R: Real>() -> R {
    r(30.0)
}

impl<R: Real> Default for StateMachine<R> {
    fn default() -> Self {
        let funnel = |at_deck, per_m| Funnel {
            at_deck: r(at_deck),
            per_m: r(per_m),
        };
        Self {
            hold_height_m: r(0.8),
            hold_tolerance_m: r(0.15),
            hold_lateral_m: r(0.15),
            hold_speed_mps: r(0.25),
            commit_height_m: r(0.30),
            commit_margin_m: r(0.10),
            touchdown_height_m: r(0.12),
            touchdown_speed_mps: r(0.12),
            touchdown_lateral_mps: r(0.25),
            idle_thrust_share: r(0.5),
            supported_load_factor: r(0.7),
            support_share: support_share(),
            support_margin_m: support_margin_m(),
            leaning_m: leaning_m(),
            tag_age_s: r(0.3),
            range_age_s: r(0.15),
            imu_age_s: r(0.05),
            coast_sd_m: coast_sd_m(),
            lost_s: lost_s(),
            safe_height_m: safe_height_m(),
            search_s: search_s(),
            tilt_rad: r(0.35),
            lateral_m: funnel(0.10, 0.25),
            closing_mps: funnel(0.35, 1.0),
            deck_tilt_rad: r(0.14),
            deck_speed_mps: r(1.0),
            wind_slope: wind_slope(),
            battery_low: r(0.2),
            battery_critical: r(0.08),
            go_arounds: 2,
            wind_go_arounds: wind_go_arounds(),
            hover_go_arounds: hover_go_arounds(),
            settle_s: r(0.5),
            contact_s: r(0.5),
            support_s: support_s(),
            // In the air the load factor falls below 0.7 within 0.15 s of a thrust of half the
            // weight: lag of the rotors 0.05 s, delays 0.05 s. Halved, that fall could come too
            // late; doubled, the rotors stop 0.2 s later.
            confirm_s: r(0.2),
            bounce_s: r(0.2),
            fall_s: r(0.05),
            excess_s: r(0.15),
            saturation_s: r(0.3),
            patience_s: r(120.0),
            landing_s: r(30.0),
            climb_s: r(5.0),
            greatest_step_s: r(0.1),
        }
    }
}

impl<R: Real> StateMachine<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Limits and times must be positive. The heights of touchdown, commit (with its
    /// hysteresis) and hold must increase in this order. `idle_thrust_share` must be below
    /// `supported_load_factor`, and that below 1. Battery limits must be in [0, 1], the
    /// critical one below the low one.
    pub fn validate(&self) -> Result<(), SettingsError> {
        for (key, value) in self.positive_settings() {
            positive(key, value)?;
        }
        ordered(
            "lander.touchdown_height_m",
            self.touchdown_height_m,
            "lander.commit_height_m",
            self.commit_height_m,
        )?;
        ordered(
            "lander.commit_height_m + commit_margin_m",
            self.commit_height_m + self.commit_margin_m,
            "lander.hold_height_m - hold_tolerance_m",
            self.hold_height_m - self.hold_tolerance_m,
        )?;
        // The idle thrust alone must not count as support.
        ordered(
            "lander.idle_thrust_share",
            self.idle_thrust_share,
            "lander.supported_load_factor",
            self.supported_load_factor,
        )?;
        within(
            "lander.supported_load_factor",
            self.supported_load_factor,
            self.supported_load_factor < R::ONE,
            "a load factor below 1",
        )?;
        not_negative("lander.lateral_m.per_m", self.lateral_m.per_m)?;
        not_negative("lander.closing_mps.per_m", self.closing_mps.per_m)?;
        not_negative("lander.battery_critical", self.battery_critical)?;
        within(
            "lander.battery_low",
            self.battery_low,
            self.battery_low <= R::ONE,
            "a share not above 1",
        )?;
        ordered(
            "lander.battery_critical",
            self.battery_critical,
            "lander.battery_low",
            self.battery_low,
        )
    }

    fn positive_settings(&self) -> [(&'static str, R); 38] {
        [
            ("lander.hold_height_m", self.hold_height_m),
            ("lander.hold_tolerance_m", self.hold_tolerance_m),
            ("lander.hold_lateral_m", self.hold_lateral_m),
            ("lander.hold_speed_mps", self.hold_speed_mps),
            ("lander.commit_height_m", self.commit_height_m),
            ("lander.commit_margin_m", self.commit_margin_m),
            ("lander.touchdown_height_m", self.touchdown_height_m),
            ("lander.touchdown_speed_mps", self.touchdown_speed_mps),
            ("lander.touchdown_lateral_mps", self.touchdown_lateral_mps),
            ("lander.idle_thrust_share", self.idle_thrust_share),
            ("lander.support_share", self.support_share),
            ("lander.support_margin_m", self.support_margin_m),
            ("lander.leaning_m", self.leaning_m),
            ("lander.tag_age_s", self.tag_age_s),
            ("lander.range_age_s", self.range_age_s),
            ("lander.imu_age_s", self.imu_age_s),
            ("lander.coast_sd_m", self.coast_sd_m),
            ("lander.lost_s", self.lost_s),
            ("lander.safe_height_m", self.safe_height_m),
            ("lander.search_s", self.search_s),
            ("lander.tilt_rad", self.tilt_rad),
            ("lander.lateral_m.at_deck", self.lateral_m.at_deck),
            ("lander.closing_mps.at_deck", self.closing_mps.at_deck),
            ("lander.deck_tilt_rad", self.deck_tilt_rad),
            ("lander.deck_speed_mps", self.deck_speed_mps),
            ("lander.wind_slope", self.wind_slope),
            ("lander.settle_s", self.settle_s),
            ("lander.contact_s", self.contact_s),
            ("lander.support_s", self.support_s),
            ("lander.confirm_s", self.confirm_s),
            ("lander.bounce_s", self.bounce_s),
            ("lander.fall_s", self.fall_s),
            ("lander.excess_s", self.excess_s),
            ("lander.saturation_s", self.saturation_s),
            ("lander.patience_s", self.patience_s),
            ("lander.landing_s", self.landing_s),
            ("lander.climb_s", self.climb_s),
            ("lander.greatest_step_s", self.greatest_step_s),
        ]
    }
}
