//! Flights of an independent vertical vehicle, with range noise: the truth behind them is known.
//!
//! Nothing of the simulator is used. Thrust goes with a first-order rotor speed and its square; the ground effect is an
//! exponential of height, or Cheeseman and Bennett's image, through one lag; air drag of the rotors is linear in climb rate; turbulence is an
//! Ornstein–Uhlenbeck process. The ground rests, or heaves as a sum of sines, as a deck does. The autopilot flies by what it measures.
#![allow(dead_code, unreachable_pub)]

#[path = "accelerometer.rs"]
mod accelerometer;
#[path = "course.rs"]
mod course;
#[path = "found.rs"]
pub mod found;
#[path = "surroundings.rs"]
mod surroundings;

use accelerometer::Accelerometer;
use course::Course;
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use surroundings::{Ground, Velocity};
use touchdown_identify::Origin;
use touchdown_model::card::Term;
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

/// Law of the extra lift with height.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Law {
    /// Falls by e over a length.
    Exponential,
    /// One image of the rotor below the ground (Cheeseman & Bennett 1955).
    Image,
}

/// Step of the simulation (s).
const STEP_S: f64 = 0.001;
/// Rotor speed in hover (1/min): thrust goes with its square.
const HOVER_RPM: f64 = 5000.0;
/// Days on which a flight is tried.
const DAYS: u64 = 20;
/// Gravity (m/s²).
const GRAVITY_MPS2: f64 = 9.81;

/// The vehicle and its sensors.
#[derive(Clone, Copy, Debug)]
pub struct Vehicle {
    /// Rotor radius (m).
    pub rotor_radius_m: f64,
    /// Throttle in hover.
    pub hover_throttle: f64,
    /// Lag of the rotor speed (s).
    pub motor_lag_s: f64,
    /// Share of thrust that goes with the throttle, the rest with its square.
    pub linear: f64,
    /// Law of the extra lift.
    pub law: Law,
    /// Extra lift at the ground, over thrust, of an exponential; strength of the image otherwise (1 for one rotor).
    pub amplitude: f64,
    /// Height over which the extra lift of an exponential falls by e; height of the rotor over the zero of heights otherwise
    /// (rotor radii).
    pub decay_radii: f64,
    /// Lag of the extra lift (s).
    pub wake_lag_s: f64,
    /// Loss of thrust with climb rate, relative (s/m).
    pub damping_s_per_m: f64,
    /// Turbulence, standard deviation (m/s²).
    pub turbulence_mps2: f64,
    /// Range noise (m), standard deviation.
    pub range_noise_m: f64,
    /// How long before its row the range was true (s), for the log and the autopilot alike.
    pub range_late_s: f64,
    /// Rate of the range (Hz).
    pub range_hz: f64,
    /// Noise of the accelerometer (m/s²), standard deviation of a sample.
    pub accelerometer_noise_mps2: f64,
    /// How long before its stamp the accelerometer felt the force (s), for the log and the autopilot alike.
    pub accelerometer_late_s: f64,
    /// Cutoff of the low-pass filter behind the accelerometer (Hz); 0 without one. It delays by 0.225 over the cutoff.
    pub accelerometer_cutoff_hz: f64,
    /// Time constant of a filter of first order behind the accelerometer (s); 0 without one. It delays by that.
    pub accelerometer_lag_s: f64,
    /// Whether the log has the accelerometer.
    pub accelerometer: bool,
    /// Whether the logged height is the autopilot's estimate instead of the range.
    pub filtered_height: bool,
    /// Whether the log has the rotor speed.
    pub rotor_speed: bool,
    /// Whether the log has a climb rate: that of a filter of satellites and accelerometer, which is inertial.
    pub filtered_climb: bool,
    /// Speed of the ground's heave (m/s), standard deviation.
    pub ground_mps: f64,
    /// Middle of its periods (s).
    pub ground_period_s: f64,
    /// Rate of the log (Hz).
    pub log_hz: f64,
    /// Commands of the autopilot from one row to the next, of which the last is logged.
    pub commands_a_row: usize,
    /// Rows of the log from one logged command to the next; the rows in between repeat it.
    pub rows_a_throttle: usize,
    /// How long before the row that logs it a command acts (s), less than the time from one to the next.
    pub throttle_late_s: f64,
    /// Standard deviation of a flight's constant error of height (rotor radii), of a uniform distribution.
    pub height_error_radii: f64,
}

impl Default for Vehicle {
    fn default() -> Self {
        Self {
            rotor_radius_m: 0.12,
            hover_throttle: 0.45,
            motor_lag_s: 0.045,
            linear: 0.3,
            law: Law::Exponential,
            amplitude: 0.09,
            decay_radii: 1.2,
            wake_lag_s: 0.1,
            damping_s_per_m: 0.022,
            turbulence_mps2: 0.08,
            range_noise_m: 0.002,
            range_hz: 50.0,
            range_late_s: 0.0,
            accelerometer_noise_mps2: 0.15,
            accelerometer_late_s: 0.0,
            accelerometer_cutoff_hz: 0.0,
            accelerometer_lag_s: 0.0,
            accelerometer: true,
            filtered_height: false,
            rotor_speed: false,
            filtered_climb: false,
            ground_mps: 0.0,
            ground_period_s: 2.0,
            log_hz: 100.0,
            commands_a_row: 1,
            rows_a_throttle: 1,
            throttle_late_s: 0.0,
            height_error_radii: 0.0,
        }
    }
}

impl Vehicle {
    /// Extra lift at rest over thrust out of ground effect.
    pub fn extra_lift(&self, height_m: f64) -> f64 {
        let radii = height_m / self.rotor_radius_m;
        match self.law {
            Law::Exponential => self.amplitude * (-radii / self.decay_radii).exp(),
            Law::Image => {
                let share = self.amplitude / (4.0 * (radii + self.decay_radii)).powi(2);
                share / (1.0 - share)
            }
        }
    }

    /// A vehicle of 30 g with motion capture at 100 Hz. The wake is as much faster as the rotors are smaller. Rougher air throws
    /// it onto the ground.
    pub fn draw_30_g(random: &mut Pcg64, accelerometer: bool) -> Self {
        let usual = Self::draw(random, accelerometer, 0.0005, 100.0);
        let mut between = |low, high| uniform(random, low, high);
        Self {
            rotor_radius_m: between(0.020, 0.026),
            wake_lag_s: between(0.03, 0.10),
            motor_lag_s: between(0.04, 0.08),
            turbulence_mps2: between(0.01, 0.04),
            damping_s_per_m: between(0.03, 0.08),
            accelerometer_noise_mps2: between(0.2, 0.5),
            ..usual
        }
    }

    /// A vehicle with sensors of its own: from 7 to 16 inch propellers, at the given noise (m) and rate (Hz) of the range.
    pub fn draw(
        random: &mut Pcg64,
        accelerometer: bool,
        range_noise_m: f64,
        range_hz: f64,
    ) -> Self {
        let law = if uniform(random, 0.0, 1.0) < 0.5 {
            Law::Exponential
        } else {
            Law::Image
        };
        let mut between = |low, high| uniform(random, low, high);
        let [amplitude, decay_radii] = match law {
            Law::Exponential => [between(0.06, 0.14), between(0.9, 1.5)],
            Law::Image => [between(0.8, 2.0), between(0.5, 0.8)],
        };
        Self {
            rotor_radius_m: between(0.09, 0.20),
            hover_throttle: between(0.35, 0.55),
            motor_lag_s: between(0.03, 0.07),
            linear: between(0.1, 0.6),
            law,
            amplitude,
            decay_radii,
            wake_lag_s: between(0.06, 0.2),
            damping_s_per_m: between(0.01, 0.035),
            turbulence_mps2: between(0.04, 0.12),
            range_noise_m,
            range_hz,
            accelerometer_noise_mps2: between(0.1, 0.3),
            accelerometer,
            ..Self::default()
        }
    }

    /// The true [`QUANTITIES`], and the [`LATENCY`].
    pub fn truth(&self) -> [f64; 8] {
        let r = self.rotor_radius_m;
        let far = self.extra_lift(6.0 * r);
        let lift = |radii: f64| (self.extra_lift(radii * r) - far) / (1.0 + far);
        [
            lift(0.5),
            lift(1.0),
            lift(2.0),
            self.wake_lag_s,
            (self.extra_lift(0.5 * r) / self.extra_lift(3.0 * r)).ln() / 2.5,
            self.damping_s_per_m,
            self.motor_lag_s,
            self.accelerometer_latency_s(),
        ]
    }

    /// Latency of the accelerometer (s), with that of its filters at low frequencies.
    pub fn accelerometer_latency_s(&self) -> f64 {
        let of_filter = match self.accelerometer_cutoff_hz {
            0.0 => 0.0,
            hz => 2f64.sqrt() / (std::f64::consts::TAU * hz),
        };
        self.accelerometer_late_s + self.accelerometer_lag_s + of_filter
    }

    /// True extra lift at half, one and two rotor radii over that at so many.
    pub fn lifts(&self, far_radii: f64) -> [f64; 3] {
        let at = |radii: f64| self.extra_lift(radii * self.rotor_radius_m);
        [0.5, 1.0, 2.0].map(|radii| (at(radii) - at(far_radii)) / (1.0 + at(far_radii)))
    }

    /// Thrust over weight of a rotor speed, as a share of the greatest.
    fn thrust(&self, speed: f64) -> f64 {
        let of = |s: f64| self.linear * s + (1.0 - self.linear) * s * s;
        of(speed) / of(self.hover_throttle)
    }
}

/// One flight: up, hovers and passes at many heights, bobbing near the ground, down. One whose error of height leads it to the
/// ground is flown again with half the error, or none. One that turbulence throws onto the ground is flown another day.
pub fn fly(vehicle: &Vehicle, seed: u64) -> Trial {
    let days = (0..DAYS).map(|day| seed ^ (day << 48));
    let flown = days.flat_map(|seed| [1.0, 0.5, 0.0].map(|share| (seed, share)));
    let flown = flown
        .map(|(of_day, share)| fly_with_error(vehicle, of_day, share))
        .find_map(|trial| trial);
    flown.expect("a flight clear of the ground")
}

/// The flight with this share of its error of height; `None` where it meets the ground.
fn fly_with_error(vehicle: &Vehicle, seed: u64, share: f64) -> Option<Trial> {
    let v = vehicle;
    let mut random = Pcg64::seed_from_u64(seed);
    let r = v.rotor_radius_m;
    let thrust_scale = 1.0 + 0.01 * normal(&mut random);
    let bias_mps2 = 0.05 * normal(&mut random);
    // Of a generator of its own: the rest of a flight stays as it is without an error of height.
    let mut of_height = Pcg64::seed_from_u64(seed ^ 0x4845_4947_4854);
    let width_m = 12f64.sqrt() * v.height_error_radii * r;
    let error_m = share * width_m * uniform(&mut of_height, -0.5, 0.5);
    let course = Course::draw(&mut random, r);
    let (every_log, every_range) = (
        (1.0 / (v.log_hz * STEP_S)).round() as usize,
        (1.0 / (v.range_hz * STEP_S)).round() as usize,
    );
    let mut world = World {
        height_m: 6.0 * r,
        climb_mps: 0.0,
        speed: v.hover_throttle,
        lift: v.extra_lift(6.0 * r),
        gust_mps2: 0.0,
    };
    let mut pilot = Pilot {
        height_m: world.height_m,
        climb_mps: 0.0,
        integral: 0.0,
    };
    let keep = (-STEP_S / 0.4f64).exp();
    let ground = Ground::draw(v, seed);
    let mut velocity = Velocity::new(seed);
    let mut accelerometer = Accelerometer::of(v);
    let mut throttle = v.hover_throttle;
    let mut logged_throttle = throttle;
    let (mut time, mut columns) = (Vec::new(), [const { Vec::new() }; 5]);
    let steps = (course.end_s() / STEP_S) as usize;
    let late = (v.throttle_late_s / STEP_S).round() as usize;
    let every_command = every_log / v.commands_a_row;
    let late_range = (v.range_late_s / STEP_S).round() as usize;
    let (mut range, mut heights_m) = (f64::NAN, Vec::new());
    for k in 0..steps {
        heights_m.push(world.height_m);
        let t = k as f64 * STEP_S;
        let force = thrust_scale
            * v.thrust(world.speed)
            * (1.0 + world.lift - v.damping_s_per_m * world.climb_mps)
            + world.gust_mps2 / GRAVITY_MPS2;
        let felt = accelerometer.step(force);
        if world.height_m <= 0.0 {
            return None;
        }
        if k % every_range == 0 {
            range = heights_m[k.saturating_sub(late_range)]
                + error_m
                + v.range_noise_m * normal(&mut random);
            pilot.range(range, v);
        }
        let [commands, logs] = [
            (k + late).is_multiple_of(every_command),
            k.is_multiple_of(every_log),
        ];
        let specific = if commands || logs {
            felt * GRAVITY_MPS2 + bias_mps2 + v.accelerometer_noise_mps2 * normal(&mut random)
        } else {
            f64::NAN
        };
        if commands {
            let period_s = every_command as f64 * STEP_S;
            throttle = pilot.step(v, course.at(t), specific, period_s);
        }
        if logs {
            if time.len().is_multiple_of(v.rows_a_throttle) {
                logged_throttle = throttle;
            }
            time.push(t);
            columns[0].push(logged_throttle);
            columns[1].push(specific);
            columns[2].push(if v.filtered_height {
                pilot.height_m
            } else {
                range
            });
            columns[3].push(HOVER_RPM * v.thrust(world.speed).sqrt());
            columns[4].push(velocity.step(k, world.climb_mps, specific, 1.0 / v.log_hz));
            range = f64::NAN;
        }
        world.gust_mps2 = keep * world.gust_mps2
            + v.turbulence_mps2 * (1.0 - keep * keep).sqrt() * normal(&mut random);
        world.step(v, throttle, force, ground.speed_mps(t));
    }
    let mut trial = Trial::new(format!("flight-{seed}"), time).expect("increasing time");
    let [throttle, specific, range, rotor_rpm, climb] = columns;
    trial.insert("throttle", throttle).expect("as long");
    if v.accelerometer {
        trial
            .insert("specific_force_mps2", specific)
            .expect("as long");
    }
    trial.insert("height_m", range).expect("as long");
    if v.rotor_speed {
        trial.insert("rotor_rpm", rotor_rpm).expect("as long");
    }
    if v.filtered_climb {
        trial
            .insert("vehicle_velocity_mps", climb)
            .expect("as long");
    }
    Some(trial)
}

struct World {
    height_m: f64,
    climb_mps: f64,
    speed: f64,
    lift: f64,
    gust_mps2: f64,
}

impl World {
    fn step(&mut self, v: &Vehicle, throttle: f64, force: f64, ground_mps: f64) {
        self.climb_mps += STEP_S * (force - 1.0) * GRAVITY_MPS2;
        self.height_m += STEP_S * (self.climb_mps - ground_mps);
        self.speed += (1.0 - (-STEP_S / v.motor_lag_s).exp()) * (throttle - self.speed);
        self.lift +=
            (1.0 - (-STEP_S / v.wake_lag_s).exp()) * (v.extra_lift(self.height_m) - self.lift);
    }
}

/// An autopilot by complementary filter and cascaded loops.
struct Pilot {
    height_m: f64,
    climb_mps: f64,
    integral: f64,
}

impl Pilot {
    fn range(&mut self, range_m: f64, v: &Vehicle) {
        let miss = range_m - self.height_m;
        // Steady gains of a Kalman filter: slower for noisier ranges.
        let bandwidth = 3.0;
        let dt = 1.0 / v.range_hz;
        self.height_m += (2.0 * bandwidth * dt).min(0.5) * miss;
        self.climb_mps += (bandwidth * bandwidth * dt).min(5.0) * miss;
    }

    fn step(
        &mut self,
        v: &Vehicle,
        [height_m, climb_mps, dither]: [f64; 3],
        specific: f64,
        dt: f64,
    ) -> f64 {
        self.climb_mps += dt * (specific - GRAVITY_MPS2);
        self.height_m += dt * self.climb_mps;
        let miss = height_m - self.height_m;
        self.integral = (self.integral + 0.8 * dt * miss).clamp(-0.2, 0.2);
        let wanted = climb_mps + 2.5 * miss;
        let acceleration = 5.0 * (wanted - self.climb_mps);
        let effort = acceleration / GRAVITY_MPS2 / 1.6 + self.integral;
        (v.hover_throttle * (1.0 + effort) + dither).clamp(0.1, 0.95)
    }
}

fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}

pub fn uniform(random: &mut Pcg64, lo: f64, hi: f64) -> f64 {
    lo + (hi - lo) * (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// The same vehicle with the other law of thrust by throttle: that of a thrust command where the first is nearer to one of speed.
pub fn another(vehicle: &Vehicle) -> Vehicle {
    Vehicle {
        linear: if vehicle.linear < 0.5 { 1.0 } else { 0.0 },
        ..*vehicle
    }
}

/// The thrust card of a vehicle of 1 kg.
pub fn thrust_card(vehicle: &Vehicle) -> Card {
    let hover = vehicle.linear * vehicle.hover_throttle
        + (1.0 - vehicle.linear) * vehicle.hover_throttle.powi(2);
    let mut card = Origin::default().card(
        "thrust",
        Kind::Thrust,
        Form::StaticThrust,
        "T = a1 s + a2 s^2",
    );
    for (expression, share) in [("s", vehicle.linear), ("s^2", 1.0 - vehicle.linear)] {
        card.terms.push(Term {
            of: "T".into(),
            expression: expression.into(),
            value: share / hover * GRAVITY_MPS2,
            std_error: None,
            ci95: None,
            unit: "N".into(),
            mark: None,
            upper_bound: None,
        });
    }
    card
}
