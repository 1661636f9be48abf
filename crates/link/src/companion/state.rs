//! State of a flight for people who watch it: the topics beside the decoded messages, in the recording and in the live view.
//!
//! | topic | schema | content |
//! | --- | --- | --- |
//! | `/stage` | `touchdown.Stage` | stage of the companion, and why control ended |
//! | `/phase` | `touchdown.Phase` | phase of the landing, why it was interrupted, and what a hover waits for |
//! | `/tf` | `foxglove.FrameTransform` | `world` to `deck`, `world` to `vehicle` |
//! | `/vehicle/pose`, `/deck/pose` | `foxglove.PoseInFrame` | estimated poses |
//! | `/estimate` | `touchdown.Estimate` | estimated motion relative to the deck, and the controller's target |
//! | `/deck/estimate` | `touchdown.DeckEstimate` | estimated motion of the deck |
//! | `/plan` | `touchdown.Plan` | the planned descent, when it begins |
//! | `/command` | `touchdown.Command` | thrust, throttle and attitude that the landing computer commands |
//! | `/timing` | `touchdown.Timing` | time since the tick before, age of the newest reading, estimated latency |
//! | `/checklist` | `touchdown.Checklist` | the checklist, when a verdict changes |
//!
//! What has no value has no key. Axes are east, north, up. The origin of `world` is at the altitude of the start, above or below the deck's reference
//! point: only the position relative to the deck is estimated, so `world` moves horizontally with the deck.

use serde_json::{Value, json};
use touchdown_flight::{Attitude, Vector};
use touchdown_foxglove::Topic;
use touchdown_foxglove::messages::{
    POSE, TRANSFORM, estimate, pose, present, quaternion, schema, stamp, transform,
};
use touchdown_lander::computer::ComputerOutput;
use touchdown_lander::estimate::deck::DeckMotionPrediction;
use touchdown_lander::planner::Plan;
use touchdown_lander::space_controller::SpaceCommand;
use touchdown_lander::state_machine::{Phase, Reason};

use super::{Ending, Stage};
use crate::checklist::Checklist;

/// Time between two states, in ticks: 20 Hz. Twice of it is a picture that stutters; half of it doubles the size of the
/// topics in the recording.
const EVERY_TICKS: u32 = 5;
const WORLD: &str = "world";

/// Places of the topics.
#[derive(Clone, Copy)]
enum Place {
    Stage,
    Phase,
    Transform,
    VehiclePose,
    DeckPose,
    Estimate,
    DeckEstimate,
    Plan,
    Command,
    Timing,
    Checklist,
}

/// Names and schemas of the topics, in the order of [`Place`].
const TOPICS: [(&str, &str); 11] = [
    ("/stage", "touchdown.Stage"),
    ("/phase", "touchdown.Phase"),
    ("/tf", TRANSFORM),
    ("/vehicle/pose", POSE),
    ("/deck/pose", POSE),
    ("/estimate", "touchdown.Estimate"),
    ("/deck/estimate", "touchdown.DeckEstimate"),
    ("/plan", "touchdown.Plan"),
    ("/command", "touchdown.Command"),
    ("/timing", "touchdown.Timing"),
    ("/checklist", "touchdown.Checklist"),
];

/// Estimated motion.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Of the vehicle relative to the deck, m.
    position_m: Vector<f64>,
    velocity_mps: Vector<f64>,
    position_sd_m: Vector<f64>,
    /// Above the start, m.
    altitude_m: f64,
    attitude: Attitude<f64>,
    deck: DeckMotionPrediction<f64>,
    /// Height and vertical velocity of the controller's target.
    target: Option<[f64; 2]>,
}

/// The state of a flight at a tick.
#[derive(Clone, Copy, Debug)]
pub struct FlightState {
    time_us: u64,
    stage: Stage,
    ending: Option<Ending>,
    phase: Option<Phase>,
    reason: Option<Reason>,
    waits_for: Option<Reason>,
    motion: Option<Motion>,
    plan: Option<Plan<f64>>,
    command: Option<SpaceCommand<f64>>,
    timing: Timing,
}

/// Timing of a tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Timing {
    /// Time since the tick before, s.
    pub(crate) period_s: f64,
    /// Age of the newest reading, s.
    pub(crate) reading_age_s: Option<f64>,
    /// Estimated latency of the readings beyond their stamped ages, s.
    pub(crate) latency_s: Option<f64>,
}

/// Chooses the ticks whose state is published.
#[derive(Clone, Copy, Debug, Default)]
pub struct Publication {
    ticks: u32,
    stage: Option<Stage>,
    phase: Option<Phase>,
}

impl Publication {
    /// Whether a state is published: twenty times a second, and whenever stage, phase or plan change.
    #[must_use]
    pub fn includes(&mut self, state: &FlightState) -> bool {
        self.ticks += 1;
        let due = self.ticks >= EVERY_TICKS;
        let changed = (self.stage, self.phase) != (Some(state.stage), state.phase);
        let published = due || changed || state.plan.is_some();
        if published {
            (self.stage, self.phase) = (Some(state.stage), state.phase);
        }
        if due {
            self.ticks = 0;
        }
        published
    }
}

impl FlightState {
    /// The state at `time_us`; `computed` are the last results of the landing computer and the attitude they belong to.
    pub(crate) fn new(
        time_us: u64,
        (stage, ending): (Stage, Option<Ending>),
        computed: Option<(&ComputerOutput<f64>, Attitude<f64>)>,
        timing: Timing,
    ) -> Self {
        // Before control the landing starts again in every step: its phase, plan and command say nothing yet.
        let in_control = stage == Stage::InControl;
        let flown = computed.map(|(output, _)| output).filter(|_| in_control);
        Self {
            time_us,
            stage,
            ending,
            phase: flown.map(|output| output.state_machine.phase),
            reason: flown.and_then(|output| output.state_machine.reason),
            waits_for: flown.and_then(|output| output.state_machine.waits_for),
            motion: computed.map(|(output, attitude)| Motion {
                position_m: output.estimate.position_m,
                velocity_mps: output.estimate.relative_velocity_mps(),
                position_sd_m: output.estimate.position_sd_m,
                altitude_m: output.estimate.altitude_m,
                attitude,
                deck: output.deck,
                target: output
                    .target
                    .filter(|_| in_control)
                    .map(|target| [target.vertical.height_m, target.vertical.velocity_mps]),
            }),
            plan: flown.and_then(|output| output.plan),
            command: flown.and_then(|output| output.command),
            timing,
        }
    }

    /// Time, µs.
    #[must_use]
    pub fn time_us(&self) -> u64 {
        self.time_us
    }

    /// The messages: place of the topic, and JSON.
    pub(crate) fn messages(&self, mut to: impl FnMut(usize, Value)) {
        let time_ns = self.time_us.saturating_mul(1000);
        let mut add = |place: Place, value: Value| to(place as usize, present(value));
        let timestamp = stamp(time_ns);
        add(
            Place::Stage,
            json!({ "timestamp": timestamp, "stage": self.stage, "ending": self.ending }),
        );
        let Timing {
            period_s,
            reading_age_s,
            latency_s,
        } = self.timing;
        add(
            Place::Timing,
            json!({
                "timestamp": timestamp,
                "period_s": period_s,
                "reading_age_s": reading_age_s,
                "estimated_latency_s": latency_s,
            }),
        );
        if let Some(phase) = self.phase {
            let (reason, waits_for) = (self.reason, self.waits_for);
            add(
                Place::Phase,
                json!({ "timestamp": timestamp, "phase": phase, "reason": reason, "waits_for": waits_for }),
            );
        }
        if let Some(motion) = &self.motion {
            motion.messages(time_ns, &mut add);
        }
        if let Some(plan) = self.plan {
            let reference = plan.reference;
            add(
                Place::Plan,
                json!({
                    "timestamp": timestamp,
                    "start_height_m": reference.start_height_m,
                    "end_height_m": reference.end_height_m,
                    "sink_rate_mps": reference.sink_rate_mps,
                    "duration_s": reference.duration_s,
                    "severity": plan.severity,
                    "quiescent": plan.quiescent,
                }),
            );
        }
        if let Some(command) = self.command {
            add(
                Place::Command,
                json!({
                    "timestamp": timestamp,
                    "thrust_n": command.thrust_n,
                    "throttle": command.throttle,
                    "attitude": quaternion(command.attitude.to_quaternion()),
                    "ground_effect_n": command.ground_effect_n,
                    "saturated": command.saturated,
                    "limited": command.limited,
                }),
            );
        }
    }

    /// A state in which every topic has a message, for the schemas.
    fn example() -> Self {
        Self {
            time_us: 0,
            stage: Stage::InControl,
            ending: Some(Ending::Landed),
            phase: Some(Phase::Approach),
            reason: Some(Reason::Operator),
            waits_for: Some(Reason::Operator),
            motion: Some(Motion {
                target: Some([0.5; 2]),
                ..Motion::default()
            }),
            plan: Some(Plan {
                reference: touchdown_flight::reference::Terminal {
                    start_height_m: 0.5,
                    end_height_m: 0.5,
                    sink_rate_mps: 0.5,
                    duration_s: 0.5,
                },
                severity: 0.5,
                quiescent: true,
            }),
            command: Some(SpaceCommand {
                thrust_n: 0.5,
                throttle: 0.5,
                attitude: Attitude::LEVEL,
                ground_effect_n: 0.5,
                saturated: false,
                limited: false,
            }),
            timing: Timing::default(),
        }
    }
}

impl Motion {
    fn messages(&self, time_ns: u64, add: &mut impl FnMut(Place, Value)) {
        let Vector { x, y, z } = self.position_m;
        let vehicle_m = [x, y, self.altitude_m];
        let deck_m = [0.0, 0.0, self.altitude_m - z];
        let (attitude, level) = (self.attitude.to_quaternion(), [1.0, 0.0, 0.0, 0.0]);
        for (child, position_m, rotation) in
            [("deck", deck_m, level), ("vehicle", vehicle_m, attitude)]
        {
            add(
                Place::Transform,
                transform(time_ns, [WORLD, child], position_m, rotation),
            );
        }
        add(
            Place::VehiclePose,
            pose(time_ns, WORLD, vehicle_m, attitude),
        );
        add(Place::DeckPose, pose(time_ns, WORLD, deck_m, level));
        let motion = [self.position_m, self.velocity_mps, self.position_sd_m];
        add(
            Place::Estimate,
            estimate(time_ns, motion.map(Vector::to_array), self.target),
        );
        let deck = &self.deck;
        add(
            Place::DeckEstimate,
            json!({
                "timestamp": stamp(time_ns),
                "estimated_heave_m": deck.displacement_m,
                "estimated_heave_sd_m": deck.displacement_sd_m,
                "estimated_heave_mps": deck.velocity_mps,
                "estimated_heave_sd_mps": deck.velocity_sd_mps,
                "estimated_heave_mps2": deck.acceleration_mps2,
            }),
        );
    }
}

/// The message of a checklist: place of the topic, and JSON.
pub(crate) fn checklist(time_us: u64, list: &Checklist) -> (usize, Value) {
    let timestamp = stamp(time_us.saturating_mul(1000));
    let message = json!({ "timestamp": timestamp, "verdict": list.verdict(), "items": list.items });
    (Place::Checklist as usize, message)
}

/// The topics with their schemas.
pub(crate) fn topics() -> Vec<Topic> {
    let mut examples = vec![Value::Null; TOPICS.len()];
    FlightState::example().messages(|place, message| examples[place] = message);
    let (place, message) = checklist(0, &Checklist::example());
    examples[place] = message;
    TOPICS
        .iter()
        .zip(examples)
        .map(|((name, schema_name), example)| Topic {
            name: (*name).to_string(),
            schema_name: (*schema_name).to_string(),
            schema: schema(&example).to_string(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_topic_has_a_schema_with_its_own_keys() {
        let topics = topics();
        assert_eq!(topics.len(), TOPICS.len());
        for topic in &topics {
            let schema: Value = serde_json::from_str(&topic.schema).unwrap();
            let properties = schema["properties"].as_object().unwrap();
            assert!(properties.contains_key("timestamp"), "{topic:?}");
            assert!(properties.len() > 1, "{topic:?}");
        }
        let list: Value = serde_json::from_str(&topics[Place::Checklist as usize].schema).unwrap();
        assert_eq!(
            list["properties"]["items"]["items"]["properties"]["sentence"]["type"],
            "string"
        );
    }

    #[test]
    fn analytic_the_vehicle_stands_above_the_deck_by_its_relative_height() {
        let mut state = FlightState::example();
        state.motion = Some(Motion {
            position_m: Vector::new(0.25, -0.5, 0.75),
            altitude_m: 2.0,
            ..Motion::default()
        });
        let mut poses = Vec::new();
        state.messages(|place, message| {
            if place == Place::VehiclePose as usize || place == Place::DeckPose as usize {
                poses.push(message["pose"]["position"].clone());
            }
        });
        // Binary fractions: exact.
        assert_eq!(poses[0], json!({ "x": 0.25, "y": -0.5, "z": 2.0 }));
        assert_eq!(poses[1], json!({ "x": 0.0, "y": 0.0, "z": 1.25 }));
    }
}
