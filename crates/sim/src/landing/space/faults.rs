//! Faults of a landing: sensors, a rotor, a gust.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::sensors::suite::{NanReadings, SensorFaults};

/// The sensor that a fault concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultySensor {
    /// Specific forces of the inertial unit.
    Imu,
    /// Its attitude, for landing computer and attitude control alike.
    Attitude,
    /// Its rates, for the attitude control.
    Gyro,
    /// Range finder.
    Range,
    /// Camera.
    Tag,
    /// Satellite navigation.
    Gnss,
    /// Barometer.
    Barometer,
    /// All of them.
    All,
}

/// Start of the faults' clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultClock {
    /// The start of the trial.
    Start,
    /// The start of the first descent.
    #[default]
    Descent,
}

/// A time span.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSpan {
    /// Its start, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
}

/// A time span in which readings are not numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NanBurst {
    /// The sensor.
    pub sensor: FaultySensor,
    /// Its start, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
}

/// A rotor that gives less thrust in free air. Its torque and its ground effect stay those of an
/// undamaged rotor: its blades lost lift, not speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeakRotor {
    /// Which rotor, 0 to 3.
    pub rotor: usize,
    /// Remaining share of its thrust, 0 to 1.
    pub share: f64,
    /// Start of the fault, s.
    pub from_s: f64,
}

/// A gust at a time of the faults' clock; rise and fall are cosines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultGust {
    /// Velocity at its height, world axes, m/s.
    pub velocity_mps: [f64; 3],
    /// Its start, s.
    pub from_s: f64,
    /// Time of the rise, and of the fall, s.
    pub rise_s: f64,
    /// Time between rise and fall, s.
    pub hold_s: f64,
}

/// Faults of a landing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultSettings {
    /// Zero of the times below.
    pub since: FaultClock,
    /// No tag is found in these spans.
    pub tag_lost: Vec<TimeSpan>,
    /// Share of range readings that are missing, beside the sensor's own losses.
    pub range_missing_share: f64,
    /// Further latency of range, tag and GNSS, s.
    pub extra_latency_s: f64,
    /// Whether the vehicle knows the further latency, as it does if readings are stamped at their
    /// measurement.
    pub extra_latency_known: bool,
    /// A rotor that gives less thrust.
    pub rotor: Option<WeakRotor>,
    /// A gust.
    pub gust: Option<FaultGust>,
    /// Bursts of readings that are not numbers.
    pub nan: Vec<NanBurst>,
}

impl Default for FaultSettings {
    /// No faults. A latency that is set belongs to stamped readings.
    fn default() -> Self {
        Self {
            since: FaultClock::default(),
            tag_lost: Vec::new(),
            range_missing_share: 0.0,
            extra_latency_s: 0.0,
            extra_latency_known: true,
            rotor: None,
            gust: None,
            nan: Vec::new(),
        }
    }
}

impl FaultSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn validate(&self) -> Result<(), SimError> {
        let span = |key: &str, from_s: f64, to_s: f64| {
            check::not_negative(&format!("{key}.from_s"), from_s)?;
            check::that(
                to_s.is_finite() && to_s > from_s,
                &format!("{key}.to_s"),
                "a time after `from_s`",
                to_s,
            )
        };
        for lost in &self.tag_lost {
            span("tag_lost", lost.from_s, lost.to_s)?;
        }
        for burst in &self.nan {
            span("nan", burst.from_s, burst.to_s)?;
        }
        check::within("range_missing_share", self.range_missing_share, 0.0, 1.0)?;
        check::within("extra_latency_s", self.extra_latency_s, 0.0, 0.25)?;
        if let Some(rotor) = &self.rotor {
            check::within("rotor.rotor", rotor.rotor as f64, 0.0, 3.0)?;
            check::within("rotor.share", rotor.share, 0.0, 1.0)?;
            check::not_negative("rotor.from_s", rotor.from_s)?;
        }
        if let Some(gust) = &self.gust {
            for value in gust.velocity_mps {
                check::finite("gust.velocity_mps", value)?;
            }
            check::not_negative("gust.from_s", gust.from_s)?;
            check::positive("gust.rise_s", gust.rise_s)?;
            check::not_negative("gust.hold_s", gust.hold_s)?;
        }
        Ok(())
    }

    /// The first fault that is set, with its value.
    pub(super) fn first(&self) -> Option<(&'static str, String)> {
        let spans = |count: usize| (count > 0).then(|| format!("{count} in a list"));
        let share = |of: f64| (of != 0.0).then(|| of.to_string());
        let gust = self.gust.map(|gust| format!("{:?} m/s", gust.velocity_mps));
        [
            ("tag_lost", spans(self.tag_lost.len())),
            ("range_missing_share", share(self.range_missing_share)),
            ("extra_latency_s", share(self.extra_latency_s)),
            ("rotor", self.rotor.map(|rotor| rotor.share.to_string())),
            ("gust", gust),
            ("nan", spans(self.nan.len())),
        ]
        .into_iter()
        .find_map(|(key, found)| Some((key, found?)))
    }

    /// Faults of the sensors at a time on the faults' clock.
    pub(super) fn of_sensors(&self, since_s: f64) -> SensorFaults {
        let within = |from_s: f64, to_s: f64| since_s >= from_s && since_s < to_s;
        let is_nan = |sensor| {
            self.nan.iter().any(|burst| {
                (burst.sensor == sensor || burst.sensor == FaultySensor::All)
                    && within(burst.from_s, burst.to_s)
            })
        };
        SensorFaults {
            tag_lost: self
                .tag_lost
                .iter()
                .any(|span| within(span.from_s, span.to_s)),
            range_missing_share: self.range_missing_share,
            extra_latency_s: self.extra_latency_s,
            known_extra_latency_s: if self.extra_latency_known {
                self.extra_latency_s
            } else {
                0.0
            },
            nan: NanReadings {
                specific_force: is_nan(FaultySensor::Imu),
                attitude: is_nan(FaultySensor::Attitude),
                rates: is_nan(FaultySensor::Gyro),
                range: is_nan(FaultySensor::Range),
                tag: is_nan(FaultySensor::Tag),
                gnss: is_nan(FaultySensor::Gnss),
                barometer: is_nan(FaultySensor::Barometer),
            },
        }
    }
}
