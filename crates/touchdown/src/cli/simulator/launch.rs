//! How the two autopilots are started, and with which parameters.
//!
//! The rate controllers get the gains of the simulated attitude control (`scenario.cascade`), over the authority that the
//! motors of the scenario's vehicle have in hover. Everything else that is set is listed here; the rest are the autopilot's
//! own defaults.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use touchdown::{Error, Result};
use touchdown_link::simulator::place;
use touchdown_sim::landing::space::SpaceScenario;

use super::process::{Launch, free_udp, udp_is_free};

/// PX4's airframe of four rotors in X form for simulators.
const PX4_AIRFRAME: &str = "10016";
/// Least and greatest motor signals of ArduPilot in flight. Below the least one the plant's motors follow slowly.
const SPIN: [f64; 2] = [0.05, 1.0];
/// Idle signal of ArduPilot's armed motors on the ground.
const SPIN_ARMED: f64 = 0.03;

/// What the companion's checklist asks of PX4.
const PX4_OF_COMPANION: [(&str, f64); 3] = [
    ("COM_OF_LOSS_T", 0.5),
    ("COM_OBL_RC_ACT", 5.0),
    ("EKF2_RNG_CTRL", 0.0),
];
/// What the companion's checklist asks of ArduPilot.
const ARDUPILOT_OF_COMPANION: [(&str, f64); 2] = [("GUID_OPTIONS", 8.0), ("GUID_TIMEOUT", 0.5)];

/// Numbers of the vehicle that its autopilot is tuned to.
struct Tuning {
    /// Motor signal in hover.
    hover: f64,
    /// Places of the rotors: half of their spacing, m.
    arm_m: f64,
    /// Angular acceleration about x, y, z of a full differential signal on all motors, rad/s².
    authority: [f64; 3],
    gains: [[f64; 3]; 3],
}

impl Tuning {
    fn of(scenario: &SpaceScenario) -> Self {
        let (plant, body, cascade) = (&scenario.plant, &scenario.body, &scenario.cascade);
        let weight_n = plant.weight_n();
        let hover = scenario.models.thrust.throttle_for(weight_n);
        // From s (1 - k load) = b x + c x², T = x²: what one motor's signal changes at a constant load.
        let (root, motor) = (weight_n.sqrt(), &plant.motor);
        let slope_n = 2.0 * root * (1.0 - motor.sag * hover)
            / (motor.linear_loss + 2.0 * motor.quadratic_loss * root);
        let arm_m = 0.5 * plant.rotor_spacing_m;
        let levers = [arm_m, arm_m, body.torque_per_thrust_m];
        Self {
            hover,
            arm_m,
            authority: [0, 1, 2].map(|k| slope_n * levers[k] / body.inertia_kg_m2[k]),
            gains: [
                cascade.rate_gain_per_s,
                cascade.integral_gain_per_s2,
                cascade.derivative_gain,
            ],
        }
    }

    /// Proportional, integral and derivative gain about an axis, of a mixer whose entries are `mix`.
    fn gain(&self, axis: usize, mix: f64) -> [f64; 3] {
        self.gains
            .map(|gain| gain[axis] / (mix * self.authority[axis]))
    }
}

/// What is asked of an autopilot that is started.
pub(super) struct Wishes<'a> {
    pub(super) program: &'a Path,
    pub(super) scenario: &'a SpaceScenario,
    /// Whether the companion lands, so that its checklist decides on parameters.
    pub(super) companion: bool,
    /// Parameters beside those that are listed here.
    pub(super) parameters: &'a [(String, f64)],
    pub(super) keep: bool,
}

impl Wishes<'_> {
    /// The parameters with the wished ones, which come last.
    fn parameters(
        &self,
        mut parameters: Vec<(String, f64)>,
        of_companion: &[(&str, f64)],
    ) -> Vec<(String, f64)> {
        if self.companion {
            let more = of_companion.iter();
            parameters.extend(more.map(|(name, value)| (name.to_string(), *value)));
        }
        parameters.retain(|(name, _)| self.parameters.iter().all(|(wished, _)| wished != name));
        parameters.extend_from_slice(self.parameters);
        parameters
    }
}

/// A PX4 to start as an instance.
pub(super) fn px4(wishes: &Wishes<'_>, instance: u16) -> Result<Launch> {
    let program = absolute(wishes.program)?;
    let etc = program
        .parent()
        .and_then(Path::parent)
        .map(|p| p.join("etc"));
    let Some(etc) = etc.filter(|etc| etc.is_dir()) else {
        return Err(Error::Arguments(format!(
            "{}: expected build/px4_sitl_default/bin/px4 of a PX4 build, with the folder etc beside bin",
            program.display()
        )));
    };
    let tuning = Tuning::of(wishes.scenario);
    let parameters = px4_parameters(&tuning, wishes.scenario);
    let environment = wishes
        .parameters(parameters, &PX4_OF_COMPANION)
        .into_iter()
        .map(|(name, value)| (format!("PX4_PARAM_{name}"), value.to_string()))
        .chain([("PX4_SYS_AUTOSTART".to_string(), PX4_AIRFRAME.to_string())])
        .collect();
    let number = instance.to_string();
    let here = "-w .".split(' ').map(str::to_string);
    Ok(Launch {
        arguments: ["-i", &number, "-d"]
            .map(str::to_string)
            .into_iter()
            .chain(here)
            .chain([etc.display().to_string()])
            .collect(),
        program,
        environment,
        leftovers: ["lock", "sock"]
            .map(|what| match what {
                "lock" => PathBuf::from(format!("/tmp/px4_lock-{instance}")),
                _ => PathBuf::from(format!("/tmp/px4-sock-{instance}")),
            })
            .to_vec(),
        files: Vec::new(),
        keep: wishes.keep,
    })
}

fn px4_parameters(tuning: &Tuning, scenario: &SpaceScenario) -> Vec<(String, f64)> {
    let sensors = &scenario.sensors;
    let mut parameters: Vec<(String, f64)> = [
        ("THR_MDL_FAC", 0.0),
        ("MPC_THR_HOVER", tuning.hover),
        // Nobody has sticks, and the ground station is this command.
        ("COM_RC_IN_MODE", 4.0),
        ("NAV_DLL_ACT", 0.0),
        ("CBRK_SUPPLY_CHK", 894_281.0),
        ("MIS_TAKEOFF_ALT", scenario.start_m[2].max(1.0)),
        // The latencies of the scenario's sensors, ms.
        ("EKF2_GPS_DELAY", 1e3 * sensors.gnss.schedule.latency_s),
        (
            "EKF2_BARO_DELAY",
            1e3 * sensors.barometer.schedule.latency_s,
        ),
        // One inertial unit, not three.
        ("EKF2_MULTI_IMU", 0.0),
        ("SENS_IMU_MODE", 1.0),
        ("SDLOG_BACKEND", 0.0),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec();
    // 1 front right, 2 rear left (counterclockwise), 3 front left, 4 rear right (clockwise); x forward, y right.
    for (k, (x, y, spin)) in [
        (1.0, 1.0, 1.0),
        (-1.0, -1.0, 1.0),
        (1.0, -1.0, -1.0),
        (-1.0, 1.0, -1.0),
    ]
    .into_iter()
    .enumerate()
    {
        parameters.push((format!("CA_ROTOR{k}_PX"), x * tuning.arm_m));
        parameters.push((format!("CA_ROTOR{k}_PY"), y * tuning.arm_m));
        let torque = spin * scenario.body.torque_per_thrust_m;
        parameters.push((format!("CA_ROTOR{k}_KM"), torque));
    }
    // Entries of PX4's normalised mixer for four rotors: √½ in roll and pitch, 1 in yaw.
    for (axis, name, mix) in [
        (0, "ROLL", 0.5_f64.sqrt()),
        (1, "PITCH", 0.5_f64.sqrt()),
        (2, "YAW", 1.0),
    ] {
        let gains = tuning.gain(axis, mix);
        for (letter, gain) in ["P", "I", "D"].into_iter().zip(gains) {
            parameters.push((format!("MC_{name}RATE_{letter}"), gain));
        }
    }
    parameters
}

/// The first PX4 instance whose ports are free.
pub(super) fn free_instance() -> Result<u16> {
    (0..10)
        .find(|i| {
            [14_540, 14_580, 18_570].into_iter().all(|port| udp_is_free(port + i))
                && std::net::TcpListener::bind(("127.0.0.1", touchdown_link::simulator::px4::PORT + i)).is_ok()
        })
        .ok_or_else(|| {
            Error::Arguments(
                "no free PX4 instance: the ports 4560, 14540, 14580 and 18570 plus 0 to 9 are taken".to_string(),
            )
        })
}

/// An ArduCopter to start, which sends motor signals to one port and MAVLink to the other.
pub(super) fn ardupilot(
    wishes: &Wishes<'_>,
    simulator_port: u16,
    mavlink_port: u16,
) -> Result<Launch> {
    let (lat, lon) = (place::LATITUDE_DEG, place::LONGITUDE_DEG);
    let mut arguments = vec![
        "--model".to_string(),
        "JSON:127.0.0.1".to_string(),
        "--wipe".to_string(),
        format!("--sim-port-out={simulator_port}"),
        format!("--rc-in-port={}", free_udp()?),
        // At sea level: higher up ArduPilot would raise its outputs for thin air.
        format!("--home={lat},{lon},0,90"),
        "--defaults=touchdown.parm".to_string(),
        format!("--serial0=udpclient:127.0.0.1:{mavlink_port}"),
    ];
    arguments.extend([1, 2].map(|k| format!("--serial{k}=none:{k}")));
    let tuning = Tuning::of(wishes.scenario);
    let parameters = ardupilot_parameters(&tuning, wishes.scenario);
    let mut text = String::new();
    for (name, value) in wishes.parameters(parameters, &ARDUPILOT_OF_COMPANION) {
        let _ = writeln!(text, "{name} {value}");
    }
    Ok(Launch {
        program: absolute(wishes.program)?,
        arguments,
        environment: Vec::new(),
        leftovers: Vec::new(),
        files: vec![("touchdown.parm", text)],
        keep: wishes.keep,
    })
}

fn ardupilot_parameters(tuning: &Tuning, scenario: &SpaceScenario) -> Vec<(String, f64)> {
    let [least, greatest] = SPIN;
    let range = &scenario.sensors.range;
    let mut parameters: Vec<(String, f64)> = [
        ("FRAME_CLASS", 1.0),
        ("FRAME_TYPE", 1.0),
        ("MOT_THST_EXPO", 0.0),
        ("MOT_SPIN_ARM", SPIN_ARMED),
        ("MOT_SPIN_MIN", least),
        ("MOT_SPIN_MAX", greatest),
        (
            "MOT_THST_HOVER",
            (tuning.hover - least) / (greatest - least),
        ),
        ("MOT_HOVER_LEARN", 0.0),
        // Thrust is ours alone: no scaling by battery or tilt.
        ("MOT_BAT_VOLT_MAX", 0.0),
        ("ATC_ANGLE_BOOST", 0.0),
        ("MOT_PWM_MIN", 1000.0),
        ("MOT_PWM_MAX", 2000.0),
        // The range finder of the world.
        ("RNGFND1_TYPE", 100.0),
        ("RNGFND1_ORIENT", 25.0),
        ("RNGFND1_MIN", range.least_m),
        ("RNGFND1_MAX", range.greatest_m),
        ("PLND_ENABLED", 0.0),
        // Nobody has sticks but this command.
        ("FS_THR_ENABLE", 0.0),
        ("FS_GCS_ENABLE", 0.0),
        ("ARMING_CHECK", 0.0),
        ("DISARM_DELAY", 0.0),
        ("SIM_RATE_HZ", 500.0),
        ("LOG_BACKEND_TYPE", 0.0),
        ("INS_GYRO_FILTER", scenario.cascade.gyro_cutoff_hz),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec();
    // Entries of ArduPilot's normalised mixer for four motors: one half.
    let signal = greatest - least;
    for (axis, name) in [(0, "RLL"), (1, "PIT"), (2, "YAW")] {
        let gains = tuning.gain(axis, 0.5 * signal);
        for (letter, gain) in ["P", "I", "D"].into_iter().zip(gains) {
            parameters.push((format!("ATC_RAT_{name}_{letter}"), gain));
        }
    }
    parameters
}

fn absolute(program: &Path) -> Result<PathBuf> {
    let absolute = std::path::absolute(program).map_err(|e| Error::file(program, e))?;
    if absolute.is_file() {
        Ok(absolute)
    } else {
        let missing = std::io::Error::from(std::io::ErrorKind::NotFound);
        Err(Error::file(program, missing))
    }
}
