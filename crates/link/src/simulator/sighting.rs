//! The deck as a simulated camera sees it, sent to a companion as `LANDING_TARGET`.
//!
//! The message comes from a component of the vehicle's own system, as from a detector on board. Its frame is
//! `MAV_FRAME_BODY_FRD`, and its time is the autopilot's when the image was taken.

use mavlink::dialects::common::{LANDING_TARGET_DATA, MavBool, MavFrame, MavMessage};
use touchdown_flight::Vector;

use crate::axes;
use crate::wire::Encoder;

/// Component id of a camera.
const CAMERA: u8 = 100;

/// Writes sightings.
#[derive(Clone, Debug)]
pub struct Sightings {
    encoder: Encoder,
}

impl Default for Sightings {
    fn default() -> Self {
        Self {
            encoder: Encoder::new(1, CAMERA),
        }
    }
}

impl Sightings {
    /// The frame of a sighting: the deck's centre from the vehicle's reference point, body axes, m.
    pub fn message(&mut self, system: u8, position_m: Vector<f64>, taken_us: u64) -> Vec<u8> {
        self.encoder.system = system;
        let [x, y, z] = axes::body(position_m).to_array().map(|c| c as f32);
        let message = MavMessage::LANDING_TARGET(LANDING_TARGET_DATA {
            time_usec: taken_us,
            frame: MavFrame::MAV_FRAME_BODY_FRD,
            distance: position_m.norm() as f32,
            x,
            y,
            z,
            position_valid: MavBool::MAV_BOOL_TRUE,
            ..LANDING_TARGET_DATA::default()
        });
        let mut bytes = Vec::new();
        self.encoder.write(&message, &mut bytes);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Decoder;

    #[test]
    fn analytic_a_deck_below_and_to_port_is_down_and_left() {
        let bytes = Sightings::default().message(7, Vector::new(0.5, 0.25, -2.0), 1_234_567);
        let mut decoder = Decoder::default();
        decoder.push(&bytes);
        let frame = decoder.next_frame().unwrap();
        assert_eq!(frame.system, 7);
        let MavMessage::LANDING_TARGET(target) = frame.message else {
            panic!("{frame:?}");
        };
        // Binary fractions survive the single precision.
        assert_eq!([target.x, target.y, target.z], [0.5, -0.25, 2.0]);
        assert_eq!(target.time_usec, 1_234_567);
    }
}
