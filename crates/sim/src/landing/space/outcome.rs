//! How a landing ended, and its figures.

use serde::Serialize;
use touchdown_lander::estimate::relative::SensorHealth;
use touchdown_lander::state_machine::{Phase, Reason};

use super::flight_log::FlightLog;

/// Why a landing is a crash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CrashCause {
    /// Touched too fast.
    Speed,
    /// Touched too far tilted.
    Tilt,
    /// Fell off the deck after a touch.
    FellOff,
    /// Came down beside the deck.
    Missed,
    /// Rotors stopped in the air.
    StoppedInAir,
    /// Flew away, or turned over in flight.
    Lost,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum SpaceOutcome {
    /// On the deck, rotors stopped.
    Landed {
        /// Descents that it took.
        attempts: u32,
    },
    /// Hit something, or the deck too hard.
    Crashed {
        /// Why.
        cause: CrashCause,
    },
    /// Tipped over on the deck.
    TippedOver,
    /// Gave the landing up and holds.
    GivenUp {
        /// Why.
        reason: Option<Reason>,
    },
    /// None of these by the end of the time: in flight, or on the deck with its rotors stopped for less than `watch_s`.
    TimedOut,
}

impl SpaceOutcome {
    /// It landed.
    #[must_use]
    pub fn landed(&self) -> bool {
        matches!(self, Self::Landed { .. })
    }

    /// It crashed or tipped over.
    #[must_use]
    pub fn crashed(&self) -> bool {
        matches!(self, Self::Crashed { .. } | Self::TippedOver)
    }
}

/// The first touch after the start of the last descent, by the true state: when a foot
/// feels the deck, or the reference point comes down to the landed height over it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Touch {
    /// Time since the start of the trial, s.
    pub time_s: f64,
    /// T_L: time since the start of the descent, s.
    pub t_l_s: f64,
    /// V_L: speed of the reference point relative to the deck along its normal, m/s.
    pub v_l_mps: f64,
    /// S_L = ∫|v| dt over the descent, m.
    pub s_l_m: f64,
    /// Tilt from the deck's normal, rad.
    pub tilt_rad: f64,
    /// Distance of the reference point from the deck's centre, in its plane, m.
    pub lateral_m: f64,
    /// Speed relative to the deck in its plane, m/s.
    pub lateral_mps: f64,
}

/// The worst of all contacts with the deck, by the true state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// Greatest speed of the reference point towards the deck, along its normal, in the
    /// step in which a foot comes down, m/s; 0 where it never approached.
    pub speed_mps: f64,
    /// Greatest tilt from the deck's normal with a foot on the deck, rad.
    pub tilt_rad: f64,
}

/// A descent that was not flown to its end, or a hover that sank: the vehicle climbed away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Abort {
    /// Time since the start of the trial, s.
    pub time_s: f64,
    /// Why.
    pub reason: Option<Reason>,
    /// Height above the deck, m.
    pub height_m: f64,
}

/// Result of one landing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpaceLanding {
    /// Index of the trial.
    pub trial_index: u64,
    /// How it ended.
    pub outcome: SpaceOutcome,
    /// The first touch of the last descent.
    pub touch: Option<Touch>,
    /// Time from the start of the trial to that of the last descent, s.
    pub before_descent_s: Option<f64>,
    /// Time spent waiting for the planner, s.
    pub waited_s: f64,
    /// Descents begun.
    pub descents: u32,
    /// Descents broken off, and hovers that sank and were climbed away from.
    pub aborts: Vec<Abort>,
    /// Times that all feet left the deck again.
    pub bounces: u32,
    /// Way that feet slid, m.
    pub slide_m: f64,
    /// Greatest force on a foot, N.
    pub greatest_foot_n: f64,
    /// The hardest contact of the whole trial, aborted descents and bounces too; none
    /// where no foot has touched the deck.
    pub impact: Option<Impact>,
    /// Estimated latency of readings beyond their stated ages, at the end, s.
    pub estimated_latency_s: f64,
    /// Phase of the landing computer at the end; none where another computer flies.
    pub last_phase: Option<Phase>,
    /// What kept the vehicle from a descent for the longest time, if it approaches or holds at the end.
    pub waits_for: Option<Reason>,
    /// Time of the end, s.
    pub end_s: f64,
    /// Steps of the integration.
    pub steps: u64,
    /// The record, if asked for.
    pub trace: Option<SpaceTrace>,
}

impl SpaceLanding {
    /// A landing of which nothing has happened yet.
    pub(super) fn begun(trial_index: u64) -> Self {
        Self {
            trial_index,
            outcome: SpaceOutcome::TimedOut,
            touch: None,
            before_descent_s: None,
            waited_s: 0.0,
            descents: 0,
            aborts: Vec::new(),
            bounces: 0,
            slide_m: 0.0,
            greatest_foot_n: 0.0,
            impact: None,
            estimated_latency_s: 0.0,
            last_phase: None,
            waits_for: None,
            end_s: 0.0,
            steps: 0,
            trace: None,
        }
    }
}

/// Record of a landing: a row for every step of the landing computer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SpaceTrace {
    /// The rows.
    pub rows: Vec<TraceRow>,
    /// What an autopilot would have logged.
    pub log: FlightLog,
}

/// What the estimator makes of a sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorRow {
    /// Age of the newest reading that was used, s; infinite before the first.
    pub age_s: f64,
    /// Running mean of the normalised innovation squared: 1 for a consistent filter.
    pub nis: f64,
    /// Number of successive readings outside the gate.
    pub rejected_in_a_row: u32,
}

impl From<&SensorHealth<f64>> for SensorRow {
    fn from(health: &SensorHealth<f64>) -> Self {
        Self {
            age_s: health.age_s,
            nis: health.nis,
            rejected_in_a_row: health.rejected_in_a_row,
        }
    }
}

/// What was true, believed and asked for at one step of the landing computer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TraceRow {
    /// Time, s.
    pub time_s: f64,
    /// Place of the vehicle, world axes, m.
    pub position_m: [f64; 3],
    /// Its velocity, m/s.
    pub velocity_mps: [f64; 3],
    /// Its attitude w, x, y, z.
    pub attitude: [f64; 4],
    /// Its rates, body axes, rad/s.
    pub rates: [f64; 3],
    /// The deck's centre, m.
    pub deck_m: [f64; 3],
    /// Its velocity, m/s.
    pub deck_mps: [f64; 3],
    /// Its acceleration, m/s².
    pub deck_mps2: [f64; 3],
    /// The deck's normal.
    pub deck_normal: [f64; 3],
    /// Place relative to the deck's centre in its axes, m.
    pub relative_m: [f64; 3],
    /// Velocity relative to the deck's centre along its axes, m/s.
    pub relative_mps: [f64; 3],
    /// Force of each rotor, N.
    pub rotor_n: [f64; 4],
    /// Ground effect and climb damping of all rotors, N.
    pub ground_effect_n: f64,
    /// Normal forces on the feet, N.
    pub feet_n: [f64; 4],
    /// Wind, m/s.
    pub wind_mps: [f64; 3],
    /// Throttles.
    pub throttle: [f64; 4],
    /// Estimated place relative to the deck, world axes, m.
    pub estimated_m: [f64; 3],
    /// Estimated velocity relative to the deck, m/s.
    pub estimated_mps: [f64; 3],
    /// Estimated velocity of the vehicle, world axes, m/s.
    pub estimated_velocity_mps: [f64; 3],
    /// Standard deviation of the estimated place, m.
    pub estimated_sd_m: [f64; 3],
    /// Height that is flown to, and its velocity relative to the deck, m and m/s.
    pub target: Option<[f64; 2]>,
    /// Estimated latency of readings beyond their stated ages, s.
    pub estimated_latency_s: f64,
    /// Estimated heave velocity of the deck, m/s.
    pub estimated_deck_mps: f64,
    /// Its standard deviation, m/s.
    pub estimated_deck_sd_mps: f64,
    /// Estimated heave acceleration of the deck, m/s².
    pub estimated_deck_mps2: f64,
    /// Heave velocity of the deck that is expected [`TraceRow::FORECAST_S`] later, m/s.
    pub forecast_deck_mps: f64,
    /// Its standard deviation, m/s.
    pub forecast_deck_sd_mps: f64,
    /// Ground effect that the law counts on, N.
    pub counted_ground_effect_n: f64,
    /// Force that the observer sees, N.
    pub disturbance_n: [f64; 3],
    /// Thrust asked for, N; none with rotors off.
    pub thrust_n: Option<f64>,
    /// Attitude asked for.
    pub attitude_asked: Option<[f64; 4]>,
    /// Where the landing is.
    pub phase: Phase,
    /// Why it was interrupted.
    pub reason: Option<Reason>,
    /// What keeps the vehicle from a descent, while it approaches and holds.
    pub waits_for: Option<Reason>,
    /// The range finder.
    pub range: SensorRow,
    /// The camera that sees the tag.
    pub tag: SensorRow,
    /// Satellite navigation.
    pub gnss: SensorRow,
    /// The deck's broadcast.
    pub beacon: SensorRow,
    /// The estimator contradicts its sensors.
    pub diverged: bool,
}

impl TraceRow {
    /// How far ahead the recorded forecast of the deck looks, s.
    pub const FORECAST_S: f64 = 1.0;
}
