//! The flight of a vehicle that knows how fast it climbs, and nothing else of its motion.

use crate::computer::{Computer, ComputerState};
use crate::space_controller::{Motion, SpaceCommand, Target};
use crate::state_machine::Maneuver;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::real::Real;
use touchdown_flight::space::Vector;

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// A flight in the world's frame without the horizontal velocity, which counts as zero: the vehicle keeps its mean trim and drifts. An
    /// observer would take away what the air's drag feels like, and with it what limits the drift.
    #[cold]
    #[inline(never)]
    pub(super) fn fly_level(
        &self,
        state: &mut ComputerState<R, G::State>,
        maneuver: Maneuver<R>,
        motion: &Motion<R>,
        dt: R,
    ) -> (Option<SpaceCommand<R>>, Option<Target<R>>) {
        let mut still = *motion;
        for velocity in [
            &mut still.relative_velocity_mps,
            &mut still.vehicle_velocity_mps,
        ] {
            *velocity = Vector::UP * velocity.z;
        }
        let target = match maneuver {
            Maneuver::ClimbAway => {
                let flown = self.guidance_away(state, &still);
                flown.climb_away(&mut state.guidance, &still, dt)
            }
            _ => self
                .guidance
                .hover_in_the_world(&mut state.guidance, &still, dt),
        };
        let target = Target {
            yaw_rad: self.guidance.heading_rad(&mut state.guidance, motion),
            ..target
        };
        let weight_n = self.controller.mass_kg * self.controller.gravity_mps2;
        let trim = state.trim_up;
        let starts = state.controller.is_none();
        let controller = self.started(&mut state.controller, motion, state.hover_throttle);
        if starts {
            // What the hover in that trim, at the thrust `W cos α`, is in balance with.
            controller.disturbance_n = (Vector::UP - trim * trim.z) * weight_n;
        }
        state.steady.drift(motion.acceleration_mps2, dt);
        let learned_n = state.steady.learned_n(self.controller.mass_kg);
        let aside_n = learned_n.unwrap_or(controller.disturbance_n);
        let command = self.controller.step(controller, &still, &target, dt);
        controller.disturbance_n = aside_n.horizontal() + Vector::UP * controller.disturbance_n.z;
        (Some(command), Some(target))
    }
}
