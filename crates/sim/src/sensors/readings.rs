//! Readings of one landing: when they are taken, when they arrive, how wrong
//! they are.
//!
//! Every sensor has a random stream of its own, from which it draws as many
//! numbers a sample whatever happens: a fault or a switch in one leaves the others
//! as they are.

use serde::Serialize;
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::computer::NormalReading;
use touchdown_lander::estimate::relative::{
    BarometerReading, GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};

use super::clock::{Clock, Wander};
use super::inertial::Felt;
use super::settings::SensorSettings;
use crate::STEP_S;
use crate::body::rigid::RigidState;
use crate::deck::rigid::DeckPose;
use crate::number::vector::{add, along, axes_of, dot, normalised, product, scale, sub};
use crate::random::{Purpose, Stream};
use crate::sensors::camera::fast::FastCamera;
use crate::sensors::camera::pipeline::CameraPipeline;

/// Steps between two samples of the inertial unit in a log.
pub(crate) const LOG_STEPS: u64 = 4;

/// A reading of the range finder, as it is logged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RangeRow {
    /// When it was taken, s.
    pub time_s: f64,
    /// Distance along the beam, m.
    pub distance_m: f64,
}

/// Faults of the sensors at a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SensorFaults {
    /// No tag is found.
    pub(crate) tag_lost: bool,
    /// Share of range readings that are missing, beside the sensor's own losses.
    pub(crate) range_missing_share: f64,
    /// Further latency of range, tag and GNSS, and the part of it that the vehicle knows, s.
    pub(crate) extra_latency_s: f64,
    pub(crate) known_extra_latency_s: f64,
    pub(crate) nan: NanReadings,
}

/// Sensors whose readings are not numbers.
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

/// What is true at a step.
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

/// What the landing computer gets at a control step.
#[derive(Clone, Debug)]
pub(crate) struct Heard {
    pub(crate) imu: ImuSample<f64>,
    pub(crate) readings: Vec<Reading<f64>>,
    pub(crate) normal: Option<NormalReading<f64>>,
}

#[derive(Clone, Copy, Debug)]
enum Said {
    Reading(Reading<f64>),
    /// A tag, with the normal.
    Tag(TagReading<f64>, Vector<f64>),
}

/// A reading on its way.
#[derive(Clone, Copy, Debug)]
struct Pending {
    arrives_s: f64,
    said: Said,
    /// Age at arrival as far as the vehicle knows, s.
    age_s: f64,
}

/// The sensors of one landing.
pub(crate) struct Sensing {
    pub(crate) settings: SensorSettings,
    control_steps: usize,
    imu: Stream,
    imu_bias_mps2: [f64; 3],
    /// Steps by which the inertial unit is late.
    late_steps: usize,
    felt: Felt,
    attitude: Stream,
    tilt_wander: [Wander; 2],
    /// Error of the attitude, a small turn about world axes, rad.
    turn: [f64; 3],
    turn_bias: [f64; 3],
    range: Clock,
    /// Whether readings of the range finder are kept for a log, and those since it was last taken.
    pub(crate) keeps_ranges: bool,
    pub(crate) taken: Vec<RangeRow>,
    pub(crate) tag: Clock,
    pub(crate) camera: FastCamera,
    /// Takes its place where images are rendered.
    pub(crate) pipeline: Option<Box<dyn CameraPipeline>>,
    gnss: Clock,
    gnss_wander: [Wander; 3],
    barometer: Clock,
    barometer_drift: f64,
    pending: Vec<Pending>,
}

impl Sensing {
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
        let mut imu = stream(Purpose::Imu);
        let mut attitude = stream(Purpose::Attitude);
        let mut gnss = Clock::new(settings.gnss.schedule, stream(Purpose::Gnss));
        let of_imu = &settings.imu;
        let imu_bias_mps2 = std::array::from_fn(|_| of_imu.bias_sd_mps2 * imu.normal());
        let turn_bias = [
            of_imu.tilt_bias_sd_rad * attitude.normal(),
            of_imu.tilt_bias_sd_rad * attitude.normal(),
            of_imu.yaw_bias_sd_rad * attitude.normal(),
        ];
        let tilt_wander = std::array::from_fn(|_| {
            let (sd, time_s) = (of_imu.tilt_wander_sd_rad, of_imu.tilt_wander_s);
            Wander::new(sd, time_s, control_period_s, &mut attitude)
        });
        let gnss_wander = std::array::from_fn(|_| {
            let of = &settings.gnss;
            let step_s = 1.0 / of.schedule.rate_hz;
            Wander::new(of.wander_sd_mps, of.wander_s, step_s, &mut gnss.stream)
        });
        let control_steps = steps(control_period_s);
        let level = along(&start.axes(), [0.0, 0.0, gravity_mps2]);
        let late_steps = steps(of_imu.latency_s);
        let remembered = (late_steps + control_steps).max(LOG_STEPS as usize);
        Self {
            settings: settings.clone(),
            control_steps,
            imu,
            imu_bias_mps2,
            late_steps,
            felt: Felt::new(remembered, level, start.attitude),
            attitude,
            tilt_wander,
            turn: turn_bias,
            turn_bias,
            range: Clock::new(settings.range.schedule, stream(Purpose::Range)),
            keeps_ranges: false,
            taken: Vec::new(),
            tag: Clock::new(settings.tag.schedule, stream(Purpose::Camera)),
            camera: camera.clone(),
            pipeline: None,
            gnss,
            gnss_wander,
            barometer: Clock::new(settings.barometer.schedule, stream(Purpose::Barometer)),
            barometer_drift: 0.0,
            pending: Vec::with_capacity(16),
        }
    }

    /// Takes the samples that are due at a step; to be called at every one.
    pub(crate) fn observe(&mut self, truth: &Truth<'_>, gravity_mps2: f64) {
        let faults = &truth.faults;
        let axes = truth.state.axes();
        let mut force = truth.acceleration_mps2;
        force[2] += gravity_mps2;
        self.felt.push(along(&axes, force), truth.state.attitude);

        let time_s = truth.step as f64 * STEP_S;
        let late = [faults.extra_latency_s, faults.known_extra_latency_s];
        if self.range.due(time_s) {
            let (delay_s, lost, age_s) = self.range.journey(late);
            let noise = self.range.stream.normal();
            let missing = self.range.stream.uniform() < faults.range_missing_share;
            let distance = self.distance(truth, &axes, noise);
            if let (Some(distance_m), false) = (distance, lost || missing) {
                let distance_m = nan_if(faults.nan.range, distance_m);
                let reading = RangeReading::level(distance_m, 0.0);
                if self.keeps_ranges {
                    self.taken.push(RangeRow { time_s, distance_m });
                }
                self.send(
                    time_s,
                    delay_s,
                    age_s,
                    Said::Reading(Reading::Range(reading)),
                );
            }
        }
        if self.tag.due(time_s) {
            let (delay_s, lost, age_s) = self.tag.journey(late);
            let seen = self.see(truth);
            let hidden = lost || faults.tag_lost;
            if let (Some((mut tag, mut normal)), false) = (seen, hidden) {
                if faults.nan.tag {
                    (tag.position_m, normal) = (NOTHING, NOTHING);
                    tag.covariance_m2 = [[f64::NAN; 3]; 3];
                }
                self.send(time_s, delay_s, age_s, Said::Tag(tag, normal));
            }
        }
        if self.settings.with_gnss && self.gnss.due(time_s) {
            let (delay_s, lost, age_s) = self.gnss.journey(late);
            let of = &self.settings.gnss;
            let sd = [
                of.horizontal_sd_mps,
                of.horizontal_sd_mps,
                of.vertical_sd_mps,
            ];
            let stream = &mut self.gnss.stream;
            let velocity: [f64; 3] = std::array::from_fn(|k| {
                let wander = self.gnss_wander[k].step(stream);
                truth.state.velocity_mps[k] + wander + sd[k] * stream.normal()
            });
            if !lost {
                let bad = faults.nan.gnss;
                let reading = GnssVelocity {
                    velocity_mps: vector(velocity.map(|v| nan_if(bad, v))),
                    age_s: 0.0,
                };
                self.send(
                    time_s,
                    delay_s,
                    age_s,
                    Said::Reading(Reading::Gnss(reading)),
                );
            }
        }
        if self.settings.with_barometer && self.barometer.due(time_s) {
            let (delay_s, lost, age_s) = self.barometer.journey([0.0; 2]);
            let of = &self.settings.barometer;
            let stream = &mut self.barometer.stream;
            self.barometer_drift += of.drift / of.schedule.rate_hz.sqrt() * stream.normal();
            let height_m = height(truth);
            let pressed = of.ground_effect_m * (-height_m.max(0.0) / 0.3).exp();
            let altitude_m = truth.state.position_m[2] + self.barometer_drift - pressed
                + of.noise_sd_m * stream.normal();
            if !lost {
                let bad = faults.nan.barometer;
                let reading = BarometerReading {
                    altitude_m: nan_if(bad, altitude_m),
                    age_s: 0.0,
                };
                self.send(
                    time_s,
                    delay_s,
                    age_s,
                    Said::Reading(Reading::Barometer(reading)),
                );
            }
        }
    }

    fn send(&mut self, time_s: f64, delay_s: f64, age_s: f64, said: Said) {
        self.pending.push(Pending {
            arrives_s: time_s + delay_s,
            said,
            age_s,
        });
    }

    /// What has arrived by a control step; to be called at every one.
    pub(crate) fn hear(&mut self, truth: &Truth<'_>) -> Heard {
        let now_s = truth.step as f64 * STEP_S;
        let imu = self.inertial(&truth.faults.nan);
        let (mut readings, mut normal) = (Vec::with_capacity(4), None);
        self.pending.retain(|pending| {
            if pending.arrives_s > now_s + 1e-9 {
                return true;
            }
            let age_s = pending.age_s + (now_s - pending.arrives_s);
            match pending.said {
                Said::Reading(reading) => readings.push(aged(reading, age_s)),
                Said::Tag(tag, seen) => {
                    readings.push(aged(Reading::Tag(tag), age_s));
                    normal = Some(NormalReading {
                        normal: seen,
                        age_s,
                    });
                }
            }
            false
        });
        Heard {
            imu,
            readings,
            normal,
        }
    }

    /// Mean specific force over a control period and the attitude at its end, both
    /// as late as the unit is.
    fn inertial(&mut self, nan: &NanReadings) -> ImuSample<f64> {
        let count = self.control_steps;
        let mean = self.felt.mean_mps2(self.late_steps, count);
        let imu = &self.settings.imu;
        let sd = imu.noise_density / (count as f64 * STEP_S).sqrt();
        let force: [f64; 3] =
            std::array::from_fn(|k| mean[k] + self.imu_bias_mps2[k] + sd * self.imu.normal());
        for k in 0..2 {
            self.turn[k] = self.turn_bias[k] + self.tilt_wander[k].step(&mut self.attitude);
        }
        let measured = self.believed(self.felt.attitude(self.late_steps));
        ImuSample {
            specific_force_mps2: vector(force.map(|f| nan_if(nan.specific_force, f))),
            attitude: if nan.attitude {
                Attitude::from_yaw(f64::NAN)
            } else {
                Attitude::from_quaternion(measured).unwrap_or_default()
            },
        }
    }

    /// Mean specific force over what is logged as a sample, without its noise.
    pub(crate) fn logged_force_mps2(&self) -> [f64; 3] {
        let mean = self.felt.mean_mps2(0, LOG_STEPS as usize);
        add(mean, self.imu_bias_mps2)
    }

    /// The attitude as the vehicle believes it to be.
    pub(crate) fn believed(&self, attitude: [f64; 4]) -> [f64; 4] {
        let [a, b, c] = scale(self.turn, 0.5);
        normalised(product([1.0, a, b, c], attitude))
    }

    /// The rates as the gyros tell them.
    pub(crate) fn rates(&mut self, rates: [f64; 3]) -> [f64; 3] {
        let sd = self.settings.imu.gyro_sd;
        rates.map(|rate| rate + sd * self.attitude.normal())
    }
}

/// Height above the deck along its normal, m.
pub(crate) fn height(truth: &Truth<'_>) -> f64 {
    dot(
        truth.deck.axes[2],
        sub(truth.state.position_m, truth.deck.origin_m),
    )
}

fn aged(reading: Reading<f64>, age_s: f64) -> Reading<f64> {
    match reading {
        Reading::Range(reading) => Reading::Range(RangeReading { age_s, ..reading }),
        Reading::Tag(reading) => Reading::Tag(TagReading { age_s, ..reading }),
        Reading::Gnss(reading) => Reading::Gnss(GnssVelocity { age_s, ..reading }),
        Reading::Barometer(reading) => Reading::Barometer(BarometerReading { age_s, ..reading }),
    }
}

/// A vector that is none.
const NOTHING: Vector<f64> = Vector::new(f64::NAN, f64::NAN, f64::NAN);

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
    use crate::sensors::CameraMode;

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
            let mut sensing = Sensing::new(&settings, &camera, control_period_s, &state, 0.0, 1, 0);
            for step in 0..10 {
                let truth = Truth {
                    step,
                    faults: SensorFaults::default(),
                    state: &state,
                    deck: &deck,
                    acceleration_mps2: [0.0, 0.0, step as f64],
                    half_side_m: None,
                };
                sensing.observe(&truth, 0.0);
            }
            // Of 6, 7, 8 and 9, exactly; level, the turn of the axes is exact as well.
            assert_eq!(sensing.logged_force_mps2()[2], 7.5, "{control_period_s}");
        }
    }
}
