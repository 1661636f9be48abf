//! The controller in space of one lane.

use touchdown_flight::Attitude;
use touchdown_lander::guidance::GuidanceCommand;
use touchdown_lander::space_controller::Motion;
use touchdown_lander::state_machine::Maneuver;

use super::Batch;
use super::lane_flight::LaneFlight;
use super::lane_state::LaneState;
use crate::number::vector::dot;
use crate::sensors::suite::vector;

/// Commanded thrust and attitude.
pub(super) struct ThrustCommand {
    pub(super) thrust_n: f64,
    pub(super) attitude: [f64; 4],
}

impl Batch {
    /// One step of the controller on the true state.
    pub(super) fn command(&self, flight: &mut LaneFlight, seen: &LaneState<f64>) -> ThrustCommand {
        let dt = self.lander.scenario.control_period_s;
        let motion = Motion {
            position_m: vector(seen.place_m),
            relative_velocity_mps: vector(seen.relative_mps),
            vehicle_velocity_mps: vector(seen.velocity_mps),
            acceleration_mps2: vector(seen.acceleration_mps2),
            attitude: Attitude::from_quaternion(seen.attitude).unwrap_or_default(),
            deck_normal: vector(seen.normal),
        };
        let throttle = flight.throttle();
        let memory = flight
            .controller
            .get_or_insert_with(|| self.controller.initial(&motion, throttle));
        let deck_mps2 = vector(seen.deck_mps2);
        let plan = self.reference.starting_at(motion.position_m.z);
        let guidance = &mut flight.guidance;
        let order = self.guidance.step(
            guidance,
            Maneuver::Descend,
            Some(&plan),
            &motion,
            deck_mps2,
            dt,
        );
        let command = match order {
            GuidanceCommand::Track(mut target) => {
                let height_m = dot(seen.normal, seen.place_m);
                target.hold_estimates = height_m < self.lander.computer.contact_height_m;
                self.controller.step(memory, &motion, &target, dt)
            }
            GuidanceCommand::Idle { .. } | GuidanceCommand::Off => {
                self.controller.idle(memory, &motion, f64::INFINITY, dt)
            }
        };
        ThrustCommand {
            thrust_n: command.thrust_n,
            attitude: command.attitude.to_quaternion(),
        }
    }
}
