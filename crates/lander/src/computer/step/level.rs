//! The flight of a vehicle that knows how fast it climbs, and nothing else of its motion.

use crate::computer::{Computer, ComputerState};
use crate::guidance::GuidanceCommand;
use crate::space_controller::{Motion, SpaceCommand, Target};
use crate::state_machine::Maneuver;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::real::Real;
use touchdown_flight::space::Vector;

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// A flight in the world's frame without the horizontal velocity, which counts as zero: the vehicle keeps its trim and drifts. An
    /// observer would take away what the air's drag feels like, and with it what limits the drift.
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
        let flown = self.guidance_away(state, &still);
        let guidance = &mut state.guidance;
        match flown.step(guidance, maneuver, None, &still, Vector::ZERO, dt) {
            GuidanceCommand::Track(target) => {
                let aside_n = match &state.controller {
                    Some(controller) => controller.disturbance_n,
                    None => {
                        let weight_n = self.controller.mass_kg * self.controller.gravity_mps2;
                        state.trim_up * (-weight_n / state.trim_up.z)
                    }
                }
                .horizontal();
                let flown = self.track(state, &still, target, dt);
                if let Some(controller) = &mut state.controller {
                    let up_n = Vector::UP * controller.disturbance_n.z;
                    controller.disturbance_n = aside_n + up_n;
                }
                flown
            }
            GuidanceCommand::Idle { .. } | GuidanceCommand::Off => {
                (Some(self.hover(state, motion, false, dt)), None)
            }
        }
    }
}
