//! The pilot of one lane.

use touchdown_flight::Attitude;
use touchdown_flight::guidance::Order;
use touchdown_flight::lander::Fly;
use touchdown_flight::pilot::Motion;

use super::Batch;
use super::seat::Seat;
use crate::cascade::AttitudeSetpoint;
use crate::deck::rigid::DeckPose;
use crate::rigid::RigidState;
use crate::space::sensing::vector;
use crate::vector::{dot, sub};

impl Batch {
    /// One step of the pilot on the true state: what it asks for.
    pub(super) fn command(
        &self,
        seat: &mut Seat,
        state: &RigidState,
        deck: &DeckPose,
        acceleration_mps2: [f64; 3],
    ) -> AttitudeSetpoint {
        let dt = self.lander.scenario.control_period_s;
        let arm = sub(state.position_m, deck.origin_m);
        let motion = Motion {
            position_m: vector(arm),
            relative_velocity_mps: vector(sub(state.velocity_mps, deck.velocity_mps)),
            vehicle_velocity_mps: vector(state.velocity_mps),
            acceleration_mps2: vector(acceleration_mps2),
            attitude: Attitude::from_quaternion(state.attitude).unwrap_or_default(),
            deck_normal: vector(deck.axes[2]),
        };
        let throttle = seat.throttle();
        let memory = seat
            .pilot
            .get_or_insert_with(|| self.pilot.initial(&motion, throttle));
        let deck_mps2 = vector(deck.acceleration_mps2);
        let plan = self.reference.starting_at(motion.position_m.z);
        let guidance = &mut seat.guidance;
        let order = self
            .guidance
            .step(guidance, Fly::Descend, Some(&plan), &motion, deck_mps2, dt);
        let command = match order {
            Order::Track(mut target) => {
                let height_m = dot(deck.axes[2], arm);
                target.hold_estimates = height_m < self.lander.computer.contact_height_m;
                self.pilot.step(memory, &motion, &target, dt)
            }
            Order::Idle { .. } | Order::Off => self.pilot.idle(memory, &motion, f64::INFINITY, dt),
        };
        AttitudeSetpoint {
            thrust_n: command.thrust_n,
            attitude: command.attitude.to_quaternion(),
            yaw_rate: 0.0,
        }
    }
}
