//! The maps that come with the crate, and which of them fits a log.

use super::LogFormat;
use super::survey::{Survey, Topic};
use crate::Map;
use crate::suggest::basic_string;

/// The file names that the maps go by, and their texts.
const MAPS: [(&str, &str); 3] = [
    ("px4.toml", include_str!("../../maps/px4.toml")),
    ("ros.toml", include_str!("../../maps/ros.toml")),
    ("ardupilot.toml", include_str!("../../maps/ardupilot.toml")),
];

impl Map {
    /// The built-in map that makes a trial of the log, if one does: that of PX4, of ArduPilot or of ROS.
    #[must_use]
    pub fn built_in(survey: &Survey) -> Option<Self> {
        survey.recommended_map().and_then(Self::built_in_named)
    }

    /// The built-in map of this name: `px4`, `ardupilot` or `ros`.
    #[must_use]
    pub fn built_in_named(name: &str) -> Option<Self> {
        let text = Self::built_in_text(name)?;
        Self::parse(&built_in_path(name), text).ok()
    }

    /// Those that logs of this format may be made trials by.
    pub(super) fn built_in_for(format: LogFormat) -> Vec<Self> {
        let names: &[&str] = match format {
            LogFormat::Ulog => &["px4"],
            LogFormat::DataFlash => &["ardupilot"],
            LogFormat::Mcap | LogFormat::Rosbag => &["px4", "ros"],
        };
        let maps = names.iter().copied();
        maps.filter_map(Self::built_in_named).collect()
    }

    /// Whether it is the built-in map of this name.
    pub(super) fn is_built_in(&self, name: &str) -> bool {
        self.path() == built_in_path(name)
    }

    /// The text of the built-in map of this name, to start an own one from.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        let file = format!("{name}.toml");
        MAPS.iter()
            .find(|(known, _)| *known == file)
            .map(|(_, text)| *text)
    }
}

/// What a trial is made from, and the topics that tell it, as in the map of PX4.
const PX4: [(&str, &[&str]); 4] = [
    (
        "specific force",
        &["sensor_combined", "vehicle_acceleration"],
    ),
    ("tilt", &["vehicle_attitude"]),
    (
        "throttle",
        &[
            "actuator_motors",
            "vehicle_thrust_setpoint",
            "actuator_controls_0",
        ],
    ),
    ("height", &["distance_sensor", "vehicle_local_position"]),
];
/// As in the map of ArduPilot.
const ARDUPILOT: [(&str, &[&str]); 4] = [
    ("specific force", &["IMU"]),
    ("tilt", &["ATT"]),
    ("throttle", &["RCOU"]),
    ("height", &["RFND", "CTUN"]),
];
/// Topics or types of ROS, as in its map.
const ROS: [(&str, &[&str]); 3] = [
    (
        "specific force",
        &["imu/data_raw", "imu/data", "sensor_msgs/Imu"],
    ),
    (
        "height",
        &[
            "sensor_msgs/Range",
            "local_position/pose",
            "nav_msgs/Odometry",
            "geometry_msgs/PoseStamped",
            "geometry_msgs/PoseWithCovarianceStamped",
            "geometry_msgs/TransformStamped",
        ],
    ),
    (
        "throttle",
        &[
            "touchdown.Motors",
            "actuator_msgs/Actuators",
            "mav_msgs/Actuators",
            "setpoint_raw/target_attitude",
            "std_msgs/Float64MultiArray",
            "std_msgs/Float32MultiArray",
        ],
    ),
];

fn built_in_path(name: &str) -> String {
    format!("the built-in map {name}")
}

impl Survey {
    /// The name of the built-in map for the log: the one whose clock and motor commands it has.
    #[must_use]
    pub fn recommended_map(&self) -> Option<&'static str> {
        let has = |topics: &[&str]| topics.iter().any(|key| self.topic_like(key).is_some());
        let px4 = has(PX4[0].1) && has(PX4[1].1);
        match self.format {
            LogFormat::Ulog => px4.then_some("px4"),
            LogFormat::DataFlash => (has(&["IMU"]) && has(&["RCOU"])).then_some("ardupilot"),
            LogFormat::Mcap | LogFormat::Rosbag if px4 => Some("px4"),
            LogFormat::Mcap | LogFormat::Rosbag => {
                let fits = ROS[..2].iter().any(|(_, names)| has(names));
                fits.then_some("ros")
            }
        }
    }

    /// How many rows the map makes of the log at most: the messages of its clock.
    #[must_use]
    pub fn rows_by(&self, map: &Map) -> usize {
        let clocks = map.clocks().map_or(&[][..], |(_, clocks)| clocks);
        let clock = clocks.iter().find_map(|name| self.topic_like(name));
        let most = || self.topics.iter().map(|topic| topic.messages).max();
        clock.map_or_else(|| most().unwrap_or(0), |topic| topic.messages)
    }

    /// What the log lacks for thrust and ground effect to be found from it by a built-in map, one
    /// sentence each.
    #[must_use]
    pub fn lacks(&self) -> Vec<String> {
        let needs: &[(&str, &[&str])] = match self.format {
            LogFormat::Ulog => &PX4,
            LogFormat::DataFlash => &ARDUPILOT,
            _ if self.recommended_map() == Some("px4") => &PX4,
            _ => &ROS,
        };
        let without = |(what, names): &(&str, &[&str])| {
            if names.iter().any(|name| self.topic_like(name).is_some()) {
                return None;
            }
            let of_kind = |name: &&str| {
                let alike =
                    |topic: &&Topic| topic.messages > 0 && topic.kind.as_deref() == Some(name);
                let topics = self.topics.iter().filter(alike);
                topics.map(|topic| topic.key.as_str()).collect::<Vec<_>>()
            };
            let many = names.iter().map(of_kind).find(|topics| topics.len() > 1);
            Some(match many {
                Some(topics) => format!(
                    "{what}: it is not known which of {} to take; a map has to say it",
                    topics.join(", ")
                ),
                None => format!("{what}: there is no topic of {}", names.join(", ")),
            })
        };
        needs.iter().filter_map(without).collect()
    }

    /// The text of a map to start from, with all fields as comments.
    #[must_use]
    pub fn suggested_map(&self) -> String {
        let clock = self.topics.iter().max_by_key(|topic| topic.messages);
        let mut text = String::from("schema = 1\n");
        if let Some(clock) = clock {
            text.push_str(&format!("clock = {}\n", basic_string(&clock.key)));
        }
        text.push_str("\n[channels]\ntime_s = 'time_s'\n");
        for topic in &self.topics {
            for field in topic.fields.iter().filter(|field| field.count > 0) {
                let name = format!("{}.{}", topic.key, field.name);
                let name: String = name
                    .chars()
                    .map(|c| if c.is_control() { ' ' } else { c })
                    .collect();
                text.push_str(&format!("# '\"{name}\"'\n"));
            }
        }
        text
    }
}
