//! All sensors of one landing, and their readings in transit.
//!
//! Every sensor has its own random stream and draws a constant number of values for each
//! sample. So a fault or a switched-off sensor does not change the others.

use touchdown_flight::Vector;
use touchdown_lander::computer::NormalReading;
use touchdown_lander::estimate::relative::{
    BarometerReading, BeaconReading, GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};

use super::SensorSettings;
use super::barometer::Barometer;
use super::beacon::Beacon;
use super::camera::fast::FastCamera;
use super::camera::sensor::TagCamera;
use super::gnss::Gnss;
use super::inertial::InertialUnit;
use super::range_finder::RangeFinder;
use crate::STEP_S;
use crate::body::rigid::RigidState;
use crate::deck::rigid::DeckPose;
use crate::number::vector::{axes_of, dot, sub};
use crate::random::{Purpose, Stream};

/// Faults of the sensors at a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SensorFaults {
    /// The camera detects no tag.
    pub(crate) tag_lost: bool,
    /// Share of missing range readings, in addition to the sensor's own losses.
    pub(crate) range_missing_share: f64,
    /// Additional latency of range, tag and GNSS, and the part that the vehicle knows, s.
    pub(crate) extra_latency_s: f64,
    pub(crate) known_extra_latency_s: f64,
    pub(crate) nan: NanReadings,
}

/// Sensors whose readings are NaN.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NanReadings {
    pub(crate) specific_force: bool,
    pub(crate) attitude: bool,
    pub(crate) rates: bool,
    pub(crate) range: bool,
    pub(crate) tag: bool,
    pub(crate) gnss: bool,
    pub(crate) barometer: bool,
}

/// Rounding error of the sum of two times, s; far below the step of 1 ms.
const ROUNDING_S: f64 = 1e-9;

/// True state of vehicle and deck at a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth<'a> {
    pub(crate) step: u64,
    pub(crate) faults: SensorFaults,
    pub(crate) state: &'a RigidState,
    pub(crate) deck: &'a DeckPose,
    /// Acceleration of the reference point, m/s².
    pub(crate) acceleration_mps2: [f64; 3],
    pub(crate) half_side_m: Option<f64>,
}

impl Truth<'_> {
    /// Time since the start of the trial, s.
    pub(super) fn time_s(&self) -> f64 {
        self.step as f64 * STEP_S
    }

    /// Height above the deck along its normal, m.
    pub(super) fn height_m(&self) -> f64 {
        dot(
            self.deck.axes[2],
            sub(self.state.position_m, self.deck.origin_m),
        )
    }
}

/// Readings that arrive at the landing computer in a control step.
#[derive(Clone, Debug)]
pub(crate) struct Arrivals {
    pub(crate) imu: ImuSample<f64>,
    pub(crate) readings: Vec<Reading<f64>>,
    pub(crate) normal: Option<NormalReading<f64>>,
    /// Numbers of the frames of the tags among the readings.
    pub(crate) frames: Vec<u64>,
}

/// A reading whose age at arrival is not set yet.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Message {
    Reading(Reading<f64>),
    /// A tag, with the deck's normal and the number of its frame.
    Tag(TagReading<f64>, Vector<f64>, u64),
}

/// A reading in transit.
#[derive(Clone, Copy, Debug)]
struct Pending {
    arrives_s: f64,
    message: Message,
    /// Age at arrival that the vehicle knows, s.
    age_s: f64,
}

/// The sensors of one landing.
pub(crate) struct SensorSuite {
    pub(crate) inertial: InertialUnit,
    pub(crate) range_finder: RangeFinder,
    pub(crate) camera: TagCamera,
    gnss: Option<Gnss>,
    barometer: Option<Barometer>,
    beacon: Option<Beacon>,
    pending: Vec<Pending>,
}

impl SensorSuite {
    pub(crate) fn new(
        settings: &SensorSettings,
        camera: &FastCamera,
        control_period_s: f64,
        start: &RigidState,
        gravity_mps2: f64,
        seed: u64,
        trial: u64,
    ) -> Self {
        let stream = |purpose| Stream::new(seed, trial, purpose);
        let imu = &settings.imu;
        Self {
            inertial: InertialUnit::new(imu, control_period_s, start, gravity_mps2, stream),
            range_finder: RangeFinder::new(&settings.range, stream(Purpose::Range)),
            camera: TagCamera::new(&settings.tag, camera, stream(Purpose::Camera)),
            gnss: (settings.with_gnss).then(|| Gnss::new(&settings.gnss, stream(Purpose::Gnss))),
            barometer: (settings.with_barometer)
                .then(|| Barometer::new(&settings.barometer, stream(Purpose::Barometer))),
            beacon: (settings.with_beacon)
                .then(|| Beacon::new(&settings.beacon, stream(Purpose::Beacon))),
            pending: Vec::with_capacity(16),
        }
    }

    /// Takes the samples that are due at a step. It must be called at every step.
    pub(crate) fn observe(&mut self, truth: &Truth<'_>, gravity_mps2: f64) {
        self.inertial
            .observe(truth.state, truth.acceleration_mps2, gravity_mps2);
        let time_s = truth.time_s();
        let readings = [
            self.range_finder.read(truth),
            self.camera.read(truth, &self.inertial),
            self.gnss.as_mut().and_then(|gnss| gnss.read(truth)),
            self.barometer.as_mut().and_then(|baro| baro.read(truth)),
            self.beacon.as_mut().and_then(|beacon| beacon.read(truth)),
        ];
        let sent = readings.into_iter().flatten();
        self.pending.extend(sent.map(|(message, transit)| Pending {
            arrives_s: time_s + transit.latency_s,
            message,
            age_s: transit.age_s,
        }));
    }

    /// The readings that have arrived by a control step. It must be called at every step.
    pub(crate) fn arrivals(&mut self, truth: &Truth<'_>) -> Arrivals {
        let now_s = truth.time_s();
        let imu = self.inertial.sample(&truth.faults.nan);
        let (mut readings, mut normal) = (Vec::with_capacity(4), None);
        let mut frames = Vec::new();
        self.pending.retain(|pending| {
            if pending.arrives_s > now_s + ROUNDING_S {
                return true;
            }
            let age_s = pending.age_s + (now_s - pending.arrives_s);
            match pending.message {
                Message::Reading(reading) => readings.push(aged(reading, age_s)),
                Message::Tag(tag, seen, frame) => {
                    frames.push(frame);
                    readings.push(aged(Reading::Tag(tag), age_s));
                    normal = Some(NormalReading {
                        normal: seen,
                        age_s,
                    });
                }
            }
            false
        });
        Arrivals {
            imu,
            readings,
            normal,
            frames,
        }
    }
}

fn aged(reading: Reading<f64>, age_s: f64) -> Reading<f64> {
    match reading {
        Reading::Range(reading) => Reading::Range(RangeReading { age_s, ..reading }),
        Reading::Tag(reading) => Reading::Tag(TagReading { age_s, ..reading }),
        Reading::Gnss(reading) => Reading::Gnss(GnssVelocity { age_s, ..reading }),
        Reading::Barometer(reading) => Reading::Barometer(BarometerReading { age_s, ..reading }),
        Reading::Beacon(reading) => Reading::Beacon(BeaconReading { age_s, ..reading }),
    }
}

pub(crate) fn nan_if(bad: bool, value: f64) -> f64 {
    if bad { f64::NAN } else { value }
}

pub(crate) fn vector([x, y, z]: [f64; 3]) -> Vector<f64> {
    Vector::new(x, y, z)
}

pub(crate) fn steps(time_s: f64) -> usize {
    (time_s / STEP_S).round() as usize
}

/// Angle between the body's z axis and the deck's normal, rad.
pub(crate) fn tilt_from(attitude: [f64; 4], deck: &DeckPose) -> f64 {
    dot(axes_of(attitude)[2], deck.axes[2])
        .clamp(-1.0, 1.0)
        .acos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::{CameraMode, SensorSettings};

    #[test]
    fn regress_logged_forces_are_means_of_four_steps_at_any_control_period() {
        for control_period_s in [0.001, 0.002, 0.01] {
            let mut settings = SensorSettings::default();
            settings.imu.bias_sd_mps2 = 0.0;
            let camera = settings
                .tag
                .fast(None, CameraMode::Fast)
                .expect("valid settings");
            let (state, deck) = (RigidState::default(), DeckPose::default());
            let mut suite =
                SensorSuite::new(&settings, &camera, control_period_s, &state, 0.0, 1, 0);
            for step in 0..10 {
                let truth = Truth {
                    step,
                    faults: SensorFaults::default(),
                    state: &state,
                    deck: &deck,
                    acceleration_mps2: [0.0, 0.0, step as f64],
                    half_side_m: None,
                };
                suite.observe(&truth, 0.0);
            }
            // Of 6, 7, 8 and 9, exactly; level, the turn of the axes is exact as well.
            assert_eq!(
                suite.inertial.logged_force_mps2()[2],
                7.5,
                "{control_period_s}"
            );
        }
    }
}
