//! The flight of a vehicle that knows how fast it climbs, and nothing else of its motion.

use crate::computer::{Computer, ComputerState};
use crate::space_controller::{Motion, SpaceCommand, SpaceControllerState, Target};
use crate::state_machine::Maneuver;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::kernel::lag_share;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// By how much more the vehicle brakes its drift than the air's drag does.
const DAMPING: f64 = 2.0;
/// Time constant of the drag that it feels, s: long against vibration, short against the drift, which the drag alone stops in 6 s.
const FELT_S: f64 = 0.5;
/// Time of a mean disturbance from which on it counts, s. What is felt beyond it is drag: in both the inertial unit has the same bias.
const LEARNED_S: f64 = 1.0;

/// A mean disturbance over `steady_s` seconds, if that is long enough.
pub(super) fn learned_n<R: Real>(steady_n: Vector<R>, steady_s: R) -> Option<Vector<R>> {
    (steady_s >= r(LEARNED_S)).then_some(steady_n)
}

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// A flight in the world's frame without the horizontal velocity, which counts as zero: the vehicle keeps its trim and drifts.
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
        let aside_n = learned_n(state.steady_n, state.steady_s)
            .map_or(controller.disturbance_n, |steady_n| {
                self.braking_n(controller, motion, steady_n, dt)
            });
        let command = self.controller.step(controller, &still, &target, dt);
        controller.disturbance_n = aside_n.horizontal() + Vector::UP * controller.disturbance_n.z;
        (Some(command), Some(target))
    }

    /// The disturbance to balance for a vehicle that does not know its velocity: the steady one, less what the drag of its drift adds
    /// to it, [`DAMPING`] times. To balance what is felt, as an observer does, would keep up the drift.
    #[cold]
    #[inline(never)]
    pub(super) fn braking_n(
        &self,
        controller: &SpaceControllerState<R, G::State>,
        motion: &Motion<R>,
        steady_n: Vector<R>,
        dt: R,
    ) -> Vector<R> {
        let felt_n = self.controller.unexplained_n(controller, motion);
        let drag_n = (felt_n - steady_n).finite_or(Vector::ZERO);
        let now_n = controller.disturbance_n;
        now_n + (steady_n - drag_n * r(DAMPING) - now_n) * lag_share(r(FELT_S), dt)
    }
}
