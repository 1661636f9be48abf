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

use super::process::Launch;

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

/// The autopilot's program, and what its parameters depend on.
pub(super) struct LaunchSettings<'a> {
    pub(super) program: &'a Path,
    pub(super) scenario: &'a SpaceScenario,
    /// Whether the companion lands, so that its checklist decides on parameters.
    pub(super) with_companion: bool,
    /// Parameters beside those that are listed here.
    pub(super) parameters: &'a [(String, f64)],
    pub(super) keep: bool,
}

impl LaunchSettings<'_> {
    /// The parameters with those that were asked for, which come last.
    fn parameters(
        &self,
        mut parameters: Vec<(String, f64)>,
        of_companion: &[(&str, f64)],
    ) -> Vec<(String, f64)> {
        if self.with_companion {
            let more = of_companion.iter();
            parameters.extend(more.map(|(name, value)| (name.to_string(), *value)));
        }
        parameters.retain(|(name, _)| self.parameters.iter().all(|(asked, _)| asked != name));
        parameters.extend_from_slice(self.parameters);
        parameters
    }
}

/// A PX4 to start as an instance.
pub(super) fn px4(settings: &LaunchSettings<'_>, instance: u16) -> Result<Launch> {
    let program = absolute(settings.program)?;
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
    let tuning = Tuning::of(settings.scenario);
    let parameters = px4_parameters(&tuning, settings.scenario);
    let environment = settings
        .parameters(parameters, &PX4_OF_COMPANION)
        .into_iter()
        .map(|(name, value)| (format!("PX4_PARAM_{name}"), value.to_string()))
        .chain([("PX4_SYS_AUTOSTART".to_string(), PX4_AIRFRAME.to_string())])
        .collect();
    let number = instance.to_string();
    let arguments = ["-i", &number, "-d", "-w", ".", &etc.display().to_string()];
    Ok(Launch {
        arguments: arguments.map(str::to_string).to_vec(),
        program,
        environment,
        leftovers: ["px4_lock", "px4-sock"]
            .map(|name| PathBuf::from(format!("/tmp/{name}-{instance}")))
            .to_vec(),
        files: Vec::new(),
        keep: settings.keep,
    })
}

fn px4_parameters(tuning: &Tuning, scenario: &SpaceScenario) -> Vec<(String, f64)> {
    let sensors = &scenario.sensors;
    let mut parameters: Vec<(String, f64)> = [
        ("THR_MDL_FAC", 0.0),
        ("MPC_THR_HOVER", tuning.hover),
        // No remote control, and this command is the ground station.
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

/// UDP ports of an ArduPilot.
pub(super) struct ArduPilotPorts {
    /// It sends its motor signals there.
    pub(super) simulator: u16,
    /// It sends MAVLink there.
    pub(super) mavlink: u16,
    /// It opens this one for a remote control.
    pub(super) remote_control: u16,
}

/// An ArduCopter to start as an instance.
pub(super) fn ardupilot(
    settings: &LaunchSettings<'_>,
    instance: u16,
    ports: &ArduPilotPorts,
) -> Result<Launch> {
    let (lat, lon) = (place::LATITUDE_DEG, place::LONGITUDE_DEG);
    let mut arguments = vec![
        "--model".to_string(),
        "JSON:127.0.0.1".to_string(),
        "--wipe".to_string(),
        format!("--sysid={}", instance + 1),
        format!("--sim-port-out={}", ports.simulator),
        format!("--rc-in-port={}", ports.remote_control),
        // At sea level: higher up ArduPilot would raise its outputs for thin air.
        format!("--home={lat},{lon},0,90"),
        "--defaults=touchdown.parm".to_string(),
        format!("--serial0=udpclient:127.0.0.1:{}", ports.mavlink),
    ];
    arguments.extend([1, 2].map(|k| format!("--serial{k}=none:{k}")));
    let tuning = Tuning::of(settings.scenario);
    let parameters = ardupilot_parameters(&tuning, settings.scenario);
    let mut text = String::new();
    for (name, value) in settings.parameters(parameters, &ARDUPILOT_OF_COMPANION) {
        let _ = writeln!(text, "{name} {value}");
    }
    Ok(Launch {
        program: absolute(settings.program)?,
        arguments,
        environment: Vec::new(),
        leftovers: Vec::new(),
        files: vec![("touchdown.parm", text)],
        keep: settings.keep,
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
        // No scaling of the thrust by battery or tilt.
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
        // No remote control but this command.
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

/// The absolute path of an autopilot's program.
///
/// # Errors
/// Where there is no file.
pub(super) fn absolute(program: &Path) -> Result<PathBuf> {
    let absolute = std::path::absolute(program).map_err(|e| Error::file(program, e))?;
    if absolute.is_file() {
        return Ok(absolute);
    }
    let found = if absolute.is_dir() {
        "a folder"
    } else {
        "no file"
    };
    Err(Error::Arguments(format!(
        "{}: expected the autopilot's program, found {found}",
        program.display()
    )))
}
