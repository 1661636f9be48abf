//! The scenario of a landing in space: vehicle, deck, wind, sensors, faults and landing computer.

use serde::{Deserialize, Serialize};
use touchdown_flight::touch::{CRASH_MPS, TouchClass};
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::ControlSettings;

use super::belief::{BelievedSettings, TruthSettings};
use super::consistency;
use super::faults::FaultSettings;
use crate::STEP_S;
use crate::air::wind::WindSettings;
use crate::body::BodySettings;
use crate::body::cascade::CascadeSettings;
use crate::body::contact::LegSettings;
use crate::body::plant::PlantSettings;
use crate::check;
use crate::deck::course::CourseSettings;
use crate::deck::rigid::RigidMotion;
use crate::error::SimError;
use crate::landing::vertical::SpreadSettings;
use crate::number::vector::{dot, scale, sub};
use crate::sensors::SensorSettings;

/// Limits beyond which a touchdown is a crash.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrashSettings {
    /// Speed towards the deck at a touch, m/s.
    pub speed_mps: f64,
    /// Tilt from the deck's normal at a touch, rad.
    pub tilt_rad: f64,
    /// Distance from the straight way between start and deck beyond which the vehicle is lost, m; over a deck under way, from a way
    /// that travels along.
    pub lost_m: f64,
}

impl Default for CrashSettings {
    /// 0.6 m/s (a fall from 2 cm), 0.65 rad, 20 m. At that tilt on one foot the tip of a blade
    /// of the default airframe strikes the deck: atan(0.15/(0.226 + 0.12 - 0.15)).
    fn default() -> Self {
        Self {
            speed_mps: CRASH_MPS,
            tilt_rad: 0.65,
            lost_m: 20.0,
        }
    }
}

impl CrashSettings {
    /// The class of a touch at a speed towards the deck.
    #[must_use]
    pub fn class(&self, speed_mps: f64) -> TouchClass {
        TouchClass::of(speed_mps, self.speed_mps)
    }
}

/// Ground effect of measured quadrotors over that of the paper's model: four rotors at one radius of height then give
/// 1.09 times their thrust (1.173 at full strength). A coplanar pair was measured at 1.09 there, and published flights
/// fit a strength of 0.42.
const MEASURED_STRENGTH: f64 = 0.5;

/// Least height of a start above the landed height, m: a few times the error of a range finder. The effect of halving or doubling was not
/// measured.
const LEAST_START_M: f64 = 0.05;

/// A landing in six degrees of freedom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpaceScenario {
    /// Place at the start relative to the deck's centre, world axes, m.
    pub start_m: [f64; 3],
    /// Standard deviation of that place on each axis, m. A place less than 0.05 m above `landed_height_m`, or one that counts as lost,
    /// is drawn again.
    pub start_sd_m: [f64; 3],
    /// Height along the deck's normal at which the vehicle has landed, m.
    pub landed_height_m: f64,
    /// Time at which an unfinished trial ends as timed out, s.
    pub timeout_s: f64,
    /// Time that the simulation continues after the rotors have stopped, s.
    pub watch_s: f64,
    /// Time between two steps of the landing computer, s; a multiple of 1 ms.
    pub control_period_s: f64,
    /// Time from a command to the attitude control, s.
    pub command_delay_s: f64,
    /// Energy in the battery at the start, share of 1.
    pub battery_share: f64,
    /// Time in which a full battery is discharged, s.
    pub battery_s: f64,
    /// Whether the air is turbulent.
    pub turbulence: bool,
    /// Factor on the plant's `ground_effect_scale`; 1 is the paper's ground effect. The models that the landing
    /// computer flies are set apart from it.
    pub ground_effect_strength: f64,
    /// Vehicle, rotors and air, as stated.
    pub plant: PlantSettings,
    /// The body, as stated.
    pub body: BodySettings,
    /// The legs.
    pub legs: LegSettings,
    /// What the flight software believes of the vehicle.
    pub believed: BelievedSettings,
    /// How the true vehicle differs from the stated one.
    pub truth: TruthSettings,
    /// Attitude and rate control.
    pub cascade: CascadeSettings,
    /// Motion of the deck, about its course.
    pub deck: RigidMotion,
    /// Course of a deck under way.
    pub course: CourseSettings,
    /// Wind.
    pub wind: WindSettings,
    /// Sensors.
    pub sensors: SensorSettings,
    /// Faults.
    pub faults: FaultSettings,
    /// The landing computer.
    pub control: ControlSettings<f64>,
    /// The models that the landing computer flies.
    pub models: FlightModels<f64>,
    /// Differences between trials.
    pub spread: SpreadSettings,
    /// The limits of a crash.
    pub crash: CrashSettings,
}

impl Default for SpaceScenario {
    /// A still deck, from 0.8 m.
    fn default() -> Self {
        Self {
            start_m: [0.0, 0.0, 0.8],
            start_sd_m: [0.1, 0.1, 0.05],
            landed_height_m: 0.1,
            timeout_s: 80.0,
            watch_s: 0.5,
            control_period_s: 0.01,
            command_delay_s: 0.01,
            battery_share: 0.6,
            battery_s: 900.0,
            turbulence: true,
            ground_effect_strength: MEASURED_STRENGTH,
            plant: PlantSettings::default(),
            body: BodySettings::default(),
            legs: LegSettings::default(),
            believed: BelievedSettings::default(),
            truth: TruthSettings::default(),
            cascade: CascadeSettings::default(),
            deck: RigidMotion::Still {},
            course: CourseSettings::default(),
            wind: WindSettings::default(),
            sensors: SensorSettings::default(),
            faults: FaultSettings::default(),
            control: ControlSettings::default(),
            models: FlightModels::default(),
            spread: SpreadSettings::default(),
            crash: CrashSettings::default(),
        }
    }
}

impl SpaceScenario {
    /// The same scenario without noise and spread: trials differ in the deck's waves only.
    #[must_use]
    pub fn without_noise(mut self) -> Self {
        self.turbulence = false;
        self.spread = SpreadSettings::none();
        self.start_sd_m = [0.0; 3];
        self.sensors = self.sensors.perfect();
        self
    }

    /// Checks the settings that no constructor checks.
    pub(super) fn check(&self) -> Result<(), SimError> {
        for k in 0..3 {
            check::finite("start_m", self.start_m[k])?;
            check::not_negative("start_sd_m", self.start_sd_m[k])?;
        }
        check::not_negative("landed_height_m", self.landed_height_m)?;
        check::that(
            self.start_m[2] >= self.landed_height_m + LEAST_START_M,
            "start_m",
            &format!("a height of at least {LEAST_START_M} m above `landed_height_m`"),
            self.start_m[2],
        )?;
        check::within("timeout_s", self.timeout_s, STEP_S, 3600.0)?;
        check::within("watch_s", self.watch_s, 0.0, 60.0)?;
        check::period("control_period_s", self.control_period_s, 0.1)?;
        check::within("command_delay_s", self.command_delay_s, 0.0, 0.5)?;
        check::within("battery_share", self.battery_share, 0.0, 1.0)?;
        check::positive("battery_s", self.battery_s)?;
        check::not_negative("ground_effect_strength", self.ground_effect_strength)?;
        self.wind.validate().map_err(|e| e.in_section("wind"))?;
        self.sensors
            .validate()
            .map_err(|e| e.in_section("sensors"))?;
        self.faults.validate().map_err(|e| e.in_section("faults"))?;
        self.spread.validate().map_err(|e| e.in_section("spread"))?;
        check::positive("crash.speed_mps", self.crash.speed_mps)?;
        check::within("crash.tilt_rad", self.crash.tilt_rad, 0.01, 3.2)?;
        check::positive("crash.lost_m", self.crash.lost_m)?;
        let aside = self.start_m[0].hypot(self.start_m[1]);
        check::that(
            aside < self.crash.lost_m,
            "start_m",
            &format!(
                "a place less than `crash.lost_m` = {} m aside of the deck",
                self.crash.lost_m
            ),
            aside,
        )?;
        for sd_m in self.start_sd_m {
            check::that(
                sd_m <= self.crash.lost_m,
                "start_sd_m",
                &format!("at most `crash.lost_m` = {} m", self.crash.lost_m),
                sd_m,
            )?;
        }
        consistency::check(self)
    }

    /// Whether a landing can begin at a place relative to the deck's centre.
    pub(super) fn can_start_at(&self, place_m: [f64; 3]) -> bool {
        place_m[2] >= self.landed_height_m + LEAST_START_M && !self.is_lost(place_m)
    }

    /// Whether a place, relative to the deck's mean place, is farther than `crash.lost_m` from the straight way between start and deck.
    pub(super) fn is_lost(&self, place_m: [f64; 3]) -> bool {
        let most2_m2 = self.crash.lost_m * self.crash.lost_m;
        let far_from = |point_m: [f64; 3]| {
            let far_m = sub(place_m, point_m);
            // NaN is far.
            !(dot(far_m, far_m) <= most2_m2)
        };
        far_from(self.start_m) && {
            let way2_m2 = dot(self.start_m, self.start_m);
            let share = (dot(place_m, self.start_m) / way2_m2).clamp(0.0, 1.0);
            far_from(scale(self.start_m, share))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lost_is_far_from_the_way_to_the_deck() {
        let scenario = SpaceScenario {
            start_m: [30.0, 0.0, 40.0],
            ..SpaceScenario::default()
        };
        // Start, deck and a place half way, 25 m from both; then 19 and 21 m beside the way, whose direction is (0.6, 0, 0.8), beyond
        // its ends, and above.
        let lost = |place_m| scenario.is_lost(place_m);
        for place_m in [
            [30.0, 0.0, 40.0],
            [0.0; 3],
            [15.0, 0.0, 20.0],
            [15.0, 19.0, 20.0],
            [0.0, -19.0, 0.0],
        ] {
            assert!(!lost(place_m), "{place_m:?}");
        }
        for place_m in [
            [15.0, 21.0, 20.0],
            [15.0 - 21.0 * 0.8, 0.0, 20.0 + 21.0 * 0.6],
            [-21.0, 0.0, 0.0],
            [30.0, 0.0, 61.0],
            [f64::NAN, 0.0, 1.0],
        ] {
            assert!(lost(place_m), "{place_m:?}");
        }
    }
}
