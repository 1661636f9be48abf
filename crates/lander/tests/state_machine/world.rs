//! A vehicle above a deck, in kinematics only: it does what it is told.

use touchdown_flight::Real;
use touchdown_lander::state_machine::{
    Fly, Lander, LanderInput, LanderOutput, LanderState, Request,
};

pub(crate) const DT: f64 = 0.01;
/// Height of the reference point when standing on the deck, m.
pub(crate) const STANDING_M: f64 = 0.10;

/// An input with nothing wrong, hovering over the pad.
pub(crate) fn good() -> LanderInput<f64> {
    LanderInput {
        tag_age_s: 0.05,
        range_age_s: 0.02,
        imu_age_s: 0.002,
        diverged: false,
        height_m: 0.8,
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
        contact: None,
        go: true,
        request: Request::None,
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

    pub(crate) fn seen(&self) -> LanderInput<f64> {
        LanderInput {
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

    pub(crate) fn fly<R: Real>(&mut self, fly: Fly<R>) {
        let wanted = match fly {
            Fly::Hover { height_m, .. } => (height_m.to_f64() - self.height_m).clamp(-0.5, 0.5),
            Fly::Descend | Fly::Commit => -0.08,
            Fly::ClimbAway => 0.8,
            // Thrust taken back: it falls where nothing carries it.
            Fly::Idle => self.velocity_mps - 9.81 * (1.0 - self.thrust_share) * DT,
            Fly::Rest if self.standing() => self.velocity_mps,
            Fly::Rest => self.velocity_mps - 9.81 * (1.0 - self.thrust_share) * DT,
            Fly::Disarm => self.velocity_mps - 9.81 * DT,
        };
        self.thrust_share = match fly {
            Fly::Idle => (self.thrust_share - 3.0 * DT).max(0.2),
            Fly::Disarm => 0.0,
            Fly::Rest => self.thrust_share,
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
    pub(crate) lander: Lander<f64>,
    pub(crate) state: LanderState<f64>,
    pub(crate) world: World,
}

impl Flight {
    pub(crate) fn new() -> Self {
        let lander = Lander::default();
        lander.validate().unwrap();
        Self {
            lander,
            state: lander.initial(),
            world: World::new(),
        }
    }

    /// A step with what is seen changed by `change`.
    pub(crate) fn step(&mut self, change: impl Fn(&mut LanderInput<f64>)) -> LanderOutput<f64> {
        let mut seen = self.world.seen();
        change(&mut seen);
        let out = self.lander.step(&mut self.state, &seen, DT);
        self.world.fly(out.fly);
        out
    }

    /// Steps without trouble until `until` says so, at most 60 s.
    pub(crate) fn until(
        &mut self,
        until: impl Fn(&LanderOutput<f64>) -> bool,
    ) -> LanderOutput<f64> {
        for _ in 0..6000 {
            let out = self.step(|_| ());
            if until(&out) {
                return out;
            }
        }
        panic!("not within a minute: {self:?}");
    }
}
