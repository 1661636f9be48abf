//! What is known to be late is not taken for a force.

use touchdown_flight::{Attitude, Vector};
use touchdown_lander::state_machine::OperatorRequest;

use crate::world::{State, World, computer};

#[test]
fn analytic_a_swing_is_no_disturbance() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    world.request = OperatorRequest::Abort;
    // 0.1 rad, up to 0.5 rad/s: thrust turned by the 10 mrad of 20 ms is 0.13 N.
    world.attitude_at = Some(|t| {
        let roll = 0.1 * f64::sin(5.0 * t);
        Attitude::from_rotation_vector(Vector::new(roll, 0.0, 0.0))
    });
    world.velocity_mps.y = GRAVITY_SWING_MPS;
    let mut most = 0.0_f64;
    for i in 0..1500 {
        let output = world.step(&computer, &mut state);
        assert!(world.position_m.horizontal().norm() < 0.3);
        if i > 800 {
            most = most.max(output.disturbance_n.horizontal().norm());
        }
    }
    assert!(most < 0.03, "{most}");
}

/// v' = -g sin(0.1 sin 5t): without drift from v = g 0.1/5.
const GRAVITY_SWING_MPS: f64 = 9.81 * 0.1 / 5.0;
