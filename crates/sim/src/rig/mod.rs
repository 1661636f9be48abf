//! The virtual force rig: a vehicle on a load cell above a moving plate.
//!
//! The vehicle stands still (v_q = 0), unless a trial moves it on its carriage;
//! the plate below it follows a prescribed height below the vehicle's standstill,
//! `z_s(t)`, so the plate's velocity is `v_p = -dz_s/dt`. A carriage that is
//! displaced upwards by q(t) gives the height `z = z_s + q` and the velocity
//! `v_q = dq/dt`; the vehicle's own inertia is taken off the load cell's reading.
//! A trial starts with motors and air at rest for its first throttle and height.

use serde::{Deserialize, Serialize};
use touchdown_trial::{Provenance, Source, Trial};

pub mod profile;
pub mod sets;

use crate::STEP_S;
use crate::air::turbulence::Turbulence;
use crate::body::plant::{Force, Plant, PlantSettings, PlantState, Surface};
use crate::check;
use crate::error::SimError;
use crate::number::rk4;
use crate::random::{Purpose, Stream, index_of_name};
use crate::rig::profile::{Profile, Signal};
use crate::sensors::LoadCellSettings;

/// Longest trial, s.
const LONGEST_S: f64 = 7_200.0;

/// Settings of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigSettings {
    /// Height of the vehicle's reference point z_q above the rig's zero, m.
    pub vehicle_height_m: f64,
    /// Whether air is turbulent and the load cell noisy. Quantum, latency,
    /// jitter and losses of the load cell stay.
    pub noise: bool,
    /// The load cell.
    pub load_cell: LoadCellSettings,
    /// Rotors and air.
    pub plant: PlantSettings,
}

impl Default for RigSettings {
    fn default() -> Self {
        Self {
            vehicle_height_m: 1.0,
            noise: true,
            load_cell: LoadCellSettings::default(),
            plant: PlantSettings::default(),
        }
    }
}

impl RigSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn validate(&self) -> Result<(), SimError> {
        check::finite("vehicle_height_m", self.vehicle_height_m)?;
        self.load_cell
            .validate()
            .map_err(|e| e.in_section("load_cell"))?;
        self.plant.validate().map_err(|e| e.in_section("plant"))
    }
}

/// One trial on the rig.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigTrial {
    /// Name; the trial's random numbers follow from it and the seed.
    pub name: String,
    /// Throttle over time.
    pub throttle: Profile,
    /// Height z_s of the standing vehicle above the plate over time, m.
    pub plate: Profile,
    /// Upward displacement q of the vehicle's carriage over time, m; the vehicle
    /// stands still if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub carriage: Option<Profile>,
    /// Length, s.
    pub duration_s: f64,
    /// Whether the plate is there; without it the height has no effect and is
    /// not recorded.
    #[serde(default = "yes")]
    pub plate_present: bool,
    /// Throttle at which the rotors rest before the start; the profile's first
    /// value if absent.
    #[serde(default)]
    pub start_throttle: Option<f64>,
}

fn yes() -> bool {
    true
}

impl RigTrial {
    fn check(&self, stream: &mut Stream) -> Result<Signals, SimError> {
        if self.name.trim().is_empty() {
            return Err(check::fail("name", "a name that is not empty", &"\"\""));
        }
        check::positive("duration_s", self.duration_s)?;
        check::within("duration_s", self.duration_s, 0.0, LONGEST_S)?;
        let throttle = self
            .throttle
            .resolve(stream)
            .map_err(|e| e.in_section("throttle"))?;
        let (low, high) = self.throttle.bounds();
        check::within("throttle", low, 0.0, 1.0)?;
        check::within("throttle", high, 0.0, 1.0)?;
        check::within(
            "start_throttle",
            self.start_throttle.unwrap_or(low),
            0.0,
            1.0,
        )?;
        let plate = self
            .plate
            .resolve(stream)
            .map_err(|e| e.in_section("plate"))?;
        let (low, _) = self.plate.bounds();
        check::that(low >= 0.0, "plate", "heights of at least 0 m", low)?;
        let standing = Profile::Constant { value: 0.0 };
        let profile = self.carriage.unwrap_or(standing);
        let carriage = profile
            .resolve(stream)
            .map_err(|e| e.in_section("carriage"))?;
        let lowest = low + profile.bounds().0;
        let expected = "a vehicle that stays above the plate";
        check::that(lowest >= 0.0, "carriage", expected, lowest)?;
        Ok(Signals {
            throttle,
            plate,
            carriage,
        })
    }
}

/// What a trial prescribes over time.
struct Signals {
    throttle: Signal,
    plate: Signal,
    carriage: Signal,
}

/// Where the vehicle and the plate are at one time.
#[derive(Clone, Copy)]
struct RigMotion {
    height_m: f64,
    vehicle_velocity_mps: f64,
    deck_velocity_mps: f64,
}

impl Signals {
    fn at(&self, time_s: f64) -> RigMotion {
        let (below_m, falling_mps) = self.plate.at(time_s);
        let (up_m, rising_mps) = self.carriage.at(time_s);
        RigMotion {
            height_m: below_m + up_m,
            vehicle_velocity_mps: rising_mps,
            deck_velocity_mps: -falling_mps,
        }
    }
}

/// Force and its parts at every integration step, before any sensor.
struct History {
    measured_n: Vec<f64>,
    truth_n: Vec<f64>,
    free_air_n: Vec<f64>,
}

impl History {
    /// The value `age_s` before `time_s`, linear between steps; the first value
    /// before the start.
    fn at_age(values: &[f64], time_s: f64, age_s: f64) -> f64 {
        let position = ((time_s - age_s) / STEP_S).max(0.0);
        let below = (position as usize).min(values.len() - 1);
        let above = (below + 1).min(values.len() - 1);
        let share = (position - below as f64).min(1.0);
        values[below] + share * (values[above] - values[below])
    }
}

fn simulate(
    plant: &Plant,
    signals: &Signals,
    start: PlantState,
    steps: usize,
    turbulence: Option<Stream>,
) -> History {
    let throttle = &signals.throttle;
    let force = |state: &PlantState, at: RigMotion| -> Force {
        plant.force(
            state,
            at.height_m,
            at.vehicle_velocity_mps,
            at.deck_velocity_mps,
        )
    };
    let mut state = start;
    let mut here = signals.at(0.0);
    let mut turbulence = turbulence.map(|stream| {
        let sd_n = plant.turbulence_sd_n(&state, here.height_m);
        Turbulence::new(stream, plant.turbulence_correlation_s(), STEP_S, sd_n)
    });
    let mut history = History {
        measured_n: Vec::with_capacity(steps + 1),
        truth_n: Vec::with_capacity(steps + 1),
        free_air_n: Vec::with_capacity(steps + 1),
    };
    for step in 0..=steps {
        let now = force(&state, here);
        let extra_n = turbulence.as_ref().map_or(0.0, Turbulence::value_n);
        history.free_air_n.push(now.free_air_n);
        history.truth_n.push(now.total_n());
        history.measured_n.push(now.total_n() + extra_n);

        let t = step as f64 * STEP_S;
        let middle = t + 0.5 * STEP_S;
        let end = (step + 1) as f64 * STEP_S;
        let next = signals.at(end);
        let heights = [here, signals.at(middle), next].map(|place| place.height_m);
        let throttles = [throttle.at(t).0, throttle.at(middle).0, throttle.at(end).0];
        if let Some(turbulence) = &mut turbulence {
            turbulence.step(plant.turbulence_sd_n(&state, here.height_m));
        }
        let y = [state.root_thrust, state.inflow[0], state.inflow[1]];
        let y = rk4::step(&y, STEP_S, |stage, y| {
            let state = PlantState {
                root_thrust: y[0],
                inflow: [y[1], y[2]],
            };
            let rate = plant.derivative(&state, throttles[stage], heights[stage]);
            [rate.root_thrust, rate.inflow[0], rate.inflow[1]]
        });
        state = PlantState {
            root_thrust: y[0],
            inflow: [y[1], y[2]],
        };
        here = next;
    }
    history
}

/// Runs one trial and records it.
///
/// Channels: `throttle`, `thrust_n` (the load cell: with latency, jitter and noise),
/// `vehicle_velocity_mps`, and with the plate `height_m`, `deck_height_m`
/// and `deck_velocity_mps`, all at their stamps. Beside them the truth without
/// turbulence and sensor noise, with the nominal latency only:
/// `truth_thrust_n` (x² + f) and `truth_free_air_n` (x²). The difference of
/// `thrust_n` and `truth_thrust_n` is the noise floor of the measurement.
///
/// The result is a pure function of the settings, the trial and the seed.
///
/// # Errors
/// Bad settings or a trial that the rig cannot do, with key and number.
pub fn run(settings: &RigSettings, trial: &RigTrial, seed: u64) -> Result<Trial, SimError> {
    settings.validate()?;
    let index = index_of_name(&trial.name);
    let mut phases = Stream::new(seed, index, Purpose::Signal);
    let signals = trial
        .check(&mut phases)
        .map_err(|e| e.of_trial(&trial.name))?;
    let plant = Plant::new(&PlantSettings {
        surface: if trial.plate_present {
            settings.plant.surface
        } else {
            Surface::Absent
        },
        ..settings.plant
    })?;
    let throttle = &signals.throttle;
    let start = plant.rest(
        trial.start_throttle.unwrap_or(throttle.at(0.0).0),
        signals.at(0.0).height_m,
    );
    let steps = (trial.duration_s / STEP_S).ceil() as usize;
    let turbulence = settings
        .noise
        .then(|| Stream::new(seed, index, Purpose::Turbulence));
    let history = simulate(&plant, &signals, start, steps, turbulence);

    let sensor = Stream::new(seed, index, Purpose::Sensor);
    let (time_s, channels) = channels(settings, trial, &signals, &history, sensor);
    let recording = |source| SimError::Recording {
        name: trial.name.clone(),
        source,
    };
    let provenance = Provenance::new(Source::VirtualRig {
        seed,
        scenario: trial.name.clone(),
    });
    let mut recorded = Trial::new(trial.name.clone(), time_s)
        .map_err(recording)?
        .with_provenance(provenance);
    for (name, values) in channels {
        recorded = recorded.with_channel(name, values).map_err(recording)?;
    }
    Ok(recorded)
}

/// Times of the samples and the recorded channels.
fn channels(
    settings: &RigSettings,
    trial: &RigTrial,
    signals: &Signals,
    history: &History,
    mut sensor: Stream,
) -> (Vec<f64>, Vec<(&'static str, Vec<f64>)>) {
    let cell = LoadCellSettings {
        noise_sd_n: if settings.noise {
            settings.load_cell.noise_sd_n
        } else {
            0.0
        },
        ..settings.load_cell
    };
    // A hundredth of a period absorbs the rounding of duration × rate.
    let samples = (trial.duration_s * cell.rate_hz + 0.01) as usize + 1;
    let time_s: Vec<f64> = (0..samples).map(|i| i as f64 / cell.rate_hz).collect();
    let thrust_n = time_s
        .iter()
        .map(|&t| {
            let age_s = cell.age_s(&mut sensor);
            cell.read(History::at_age(&history.measured_n, t, age_s), &mut sensor)
        })
        .collect();
    let at_nominal_latency = |values: &[f64]| -> Vec<f64> {
        let at = |&t: &f64| History::at_age(values, t, cell.latency_s);
        time_s.iter().map(at).collect()
    };
    let sampled = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { time_s.iter().map(|&t| f(t)).collect() };

    let throttle = &signals.throttle;
    let mut channels = vec![
        ("throttle", sampled(&|t| throttle.at(t).0)),
        ("thrust_n", thrust_n),
    ];
    if trial.plate_present {
        let zero = settings.vehicle_height_m;
        channels.push(("height_m", sampled(&|t| signals.at(t).height_m)));
        let deck_height_m = |t| zero - signals.plate.at(t).0;
        channels.push(("deck_height_m", sampled(&deck_height_m)));
        let deck_velocity_mps = |t| signals.at(t).deck_velocity_mps;
        channels.push(("deck_velocity_mps", sampled(&deck_velocity_mps)));
    }
    let vehicle_velocity_mps = |t| signals.at(t).vehicle_velocity_mps;
    channels.push(("vehicle_velocity_mps", sampled(&vehicle_velocity_mps)));
    channels.push(("truth_thrust_n", at_nominal_latency(&history.truth_n)));
    channels.push(("truth_free_air_n", at_nominal_latency(&history.free_air_n)));
    (time_s, channels)
}
