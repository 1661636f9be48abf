//! Checks of the settings.

use super::settings::{
    BarometerModel, BeaconModel, DeckPrior, Gate, GnssModel, ImuModel, InitialSpread, RangeModel,
    TagModel,
};
use crate::check::{not_negative, positive};
use touchdown_flight::error::{SettingsError, finite, ordered, within};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

fn finite_vector<R: Real>(key: &'static str, v: Vector<R>) -> Result<(), SettingsError> {
    finite(key, v.x)?;
    finite(key, v.y)?;
    finite(key, v.z)
}

impl<R: Real> ImuModel<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative("relative.imu.noise_density", self.noise_density)?;
        not_negative("relative.imu.bias_sd_mps2", self.bias_sd_mps2)?;
        not_negative("relative.imu.bias_walk", self.bias_walk)?;
        not_negative("relative.imu.attitude_sd_rad", self.attitude_sd_rad)?;
        not_negative("relative.imu.delay_s", self.delay_s)?;
        positive("relative.imu.stale_s", self.stale_s)
    }
}

impl<R: Real> RangeModel<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        finite_vector("relative.range.position_m", self.position_m)?;
        finite_vector("relative.range.direction", self.direction)?;
        positive("relative.range.direction", self.direction.norm())?;
        not_negative("relative.range.noise_sd_m", self.noise_sd_m)?;
        not_negative("relative.range.noise_share", self.noise_share)?;
        not_negative("relative.range.quantum_m", self.quantum_m)?;
        not_negative("relative.range.least_m", self.least_m)?;
        ordered(
            "relative.range.least_m",
            self.least_m,
            "relative.range.greatest_m",
            self.greatest_m,
        )?;
        let angle = self.greatest_angle_rad;
        within(
            "relative.range.greatest_angle_rad",
            angle,
            angle > R::ZERO && angle < r(1.5),
            "an angle above 0 and below 1.5 rad",
        )?;
        not_negative("relative.range.jitter_s", self.jitter_s)?;
        not_negative("relative.range.normal_sd_rad", self.normal_sd_rad)?;
        positive("relative.range.stale_s", self.stale_s)
    }
}

impl<R: Real> TagModel<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        finite_vector("relative.tag.position_m", self.position_m)?;
        not_negative("relative.tag.noise_sd_m", self.noise_sd_m)?;
        not_negative("relative.tag.jitter_s", self.jitter_s)?;
        positive("relative.tag.stale_s", self.stale_s)
    }
}

impl<R: Real> GnssModel<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative("relative.gnss.horizontal_sd_mps", self.horizontal_sd_mps)?;
        not_negative("relative.gnss.vertical_sd_mps", self.vertical_sd_mps)?;
        positive("relative.gnss.stale_s", self.stale_s)
    }
}

impl<R: Real> BarometerModel<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative("relative.barometer.noise_sd_m", self.noise_sd_m)?;
        not_negative("relative.barometer.drift", self.drift)?;
        not_negative("relative.barometer.trusted_above_m", self.trusted_above_m)?;
        positive("relative.barometer.stale_s", self.stale_s)
    }
}

impl<R: Real> BeaconModel<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("relative.beacon.horizontal_sd_m", self.horizontal_sd_m)?;
        positive("relative.beacon.vertical_sd_m", self.vertical_sd_m)?;
        positive("relative.beacon.velocity_sd_mps", self.velocity_sd_mps)?;
        positive("relative.beacon.stale_s", self.stale_s)
    }
}

impl<R: Real> DeckPrior<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative(
            "relative.deck.heave_velocity_sd_mps",
            self.heave_velocity_sd_mps,
        )?;
        positive(
            "relative.deck.heave_angular_frequency",
            self.heave_angular_frequency,
        )?;
        let damping = self.heave_damping_ratio;
        within(
            "relative.deck.heave_damping_ratio",
            damping,
            damping > R::ZERO && damping <= R::ONE,
            "a number above 0 and not above 1",
        )?;
        not_negative(
            "relative.deck.horizontal_velocity_sd_mps",
            self.horizontal_velocity_sd_mps,
        )?;
        not_negative(
            "relative.deck.horizontal_velocity_walk",
            self.horizontal_velocity_walk,
        )?;
        not_negative(
            "relative.deck.horizontal_acceleration_sd_mps2",
            self.horizontal_acceleration_sd_mps2,
        )?;
        positive(
            "relative.deck.horizontal_acceleration_s",
            self.horizontal_acceleration_s,
        )
    }
}

impl<R: Real> InitialSpread<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("relative.initial.position_sd_m", self.position_sd_m)?;
        not_negative("relative.initial.velocity_sd_mps", self.velocity_sd_mps)?;
        finite("relative.initial.height_m", self.height_m)?;
        not_negative("relative.initial.height_sd_m", self.height_sd_m)?;
        not_negative("relative.initial.follows_sd_mps", self.follows_sd_mps)
    }
}

impl<R: Real> Gate<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("relative.gate.gate_sd", self.gate_sd)?;
        within(
            "relative.gate.memory",
            self.memory,
            self.memory >= R::ONE,
            "a number of readings not below 1",
        )?;
        within(
            "relative.gate.nis_limit",
            self.nis_limit,
            self.nis_limit > R::ONE,
            "a number above 1",
        )?;
        within(
            "relative.gate.rejections",
            r::<R>(f64::from(self.rejections)),
            self.rejections > 0,
            "a number of readings not below 1",
        )
    }
}
