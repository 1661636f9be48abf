//! A vehicle above a deck, in kinematics only: it does what it is told.

use touchdown_flight::Real;
use touchdown_lander::state_machine::{
    MachineInput, MachineOutput, MachineState, Maneuver, OperatorRequest, StateMachine,
};

pub(crate) const DT: f64 = 0.01;
/// Height of the reference point when standing on the deck, m.
pub(crate) const STANDING_M: f64 = 0.10;

/// An input with nothing wrong, hovering over the pad.
pub(crate) fn good() -> MachineInput<f64> {
    MachineInput {
        tag_age_s: 0.05,
        range_age_s: 0.02,
        imu_age_s: 0.002,
        diverged: false,
        foot_drop_m: 0.0,
        wind_slope: 0.0,
        gusty: false,
        hold_extra_m: 0.0,
        height_m: 0.8,
        height_sd_m: 0.005,
        relative_velocity_mps: 0.0,
        lateral_error_m: 0.02,
        lateral_speed_mps: 0.01,
        tilt_rad: 0.02,
        saturated: false,
        deck_tilt_rad: 0.03,
        deck_speed_mps: 0.15,
        battery_share: 0.7,
        thrust_share: 1.0,
        load_factor: 1.0,
        support_share: 0.0,
        contact: None,
        go: true,
        request: OperatorRequest::None,
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct World {
    pub(crate) height_m: f64,
    pub(crate) velocity_mps: f64,
    pub(crate) thrust_share: f64,
}

impl World {
    pub(crate) fn new() -> Self {
        Self {
            height_m: 0.8,
            velocity_mps: 0.0,
            thrust_share: 1.0,
        }
    }

    pub(crate) fn standing(&self) -> bool {
        self.height_m <= STANDING_M
    }

    pub(crate) fn seen(&self) -> MachineInput<f64> {
        MachineInput {
            height_m: self.height_m,
            relative_velocity_mps: self.velocity_mps,
            thrust_share: self.thrust_share,
            load_factor: if self.standing() {
                1.0
            } else {
                self.thrust_share
            },
            ..good()
        }
    }

    pub(crate) fn fly<R: Real>(&mut self, fly: Maneuver<R>) {
        let wanted = match fly {
            Maneuver::Hover { height_m, .. } => {
                (height_m.to_f64() - self.height_m).clamp(-0.5, 0.5)
            }
            Maneuver::Descend | Maneuver::Commit => -0.08,
            Maneuver::ClimbAway => 0.8,
            // Thrust taken back: it falls where nothing carries it.
            Maneuver::Idle => self.velocity_mps - 9.81 * (1.0 - self.thrust_share) * DT,
            Maneuver::Rest if self.standing() => self.velocity_mps,
            Maneuver::Rest => self.velocity_mps - 9.81 * (1.0 - self.thrust_share) * DT,
            Maneuver::Disarm => self.velocity_mps - 9.81 * DT,
        };
        self.thrust_share = match fly {
            Maneuver::Idle => (self.thrust_share - 3.0 * DT).max(0.2),
            Maneuver::Disarm => 0.0,
            Maneuver::Rest => self.thrust_share,
            _ => 1.0,
        };
        self.velocity_mps = wanted;
        self.height_m += DT * wanted;
        if self.standing() {
            self.height_m = STANDING_M;
            self.velocity_mps = self.velocity_mps.max(0.0);
        }
    }
}

/// A machine and its vehicle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight {
    pub(crate) state_machine: StateMachine<f64>,
    pub(crate) state: MachineState<f64>,
    pub(crate) world: World,
}

impl Flight {
    pub(crate) fn new() -> Self {
        let state_machine = StateMachine::default();
        state_machine.validate().unwrap();
        Self {
            state_machine,
            state: state_machine.initial(),
            world: World::new(),
        }
    }

    /// A step with what is seen changed by `change`.
    pub(crate) fn step(&mut self, change: impl Fn(&mut MachineInput<f64>)) -> MachineOutput<f64> {
        let mut seen = self.world.seen();
        change(&mut seen);
        let out = self.state_machine.step(&mut self.state, &seen, DT);
        self.world.fly(out.maneuver);
        out
    }

    /// Steps without trouble until `until` says so, at most 60 s.
    pub(crate) fn until(
        &mut self,
        until: impl Fn(&MachineOutput<f64>) -> bool,
    ) -> MachineOutput<f64> {
        for _ in 0..6000 {
            let out = self.step(|_| ());
            if until(&out) {
                return out;
            }
        }
        panic!("not within a minute: {self:?}");
    }
}
