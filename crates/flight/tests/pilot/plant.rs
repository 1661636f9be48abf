//! A point mass with rotors, attitude lag, ground effect, wind and delays.

use std::collections::VecDeque;

use touchdown_flight::control::{Composite, Delays, Horizontal, Law};
use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::pilot::{Motion, Pilot, PilotCommand};
use touchdown_flight::thrust::{FirstOrder, ThrustModel, ThrustState};
use touchdown_flight::{Attitude, Limits, Real, Vector};

use crate::common::{GRAVITY, MASS_KG, WEIGHT_N, map};

pub(crate) type Space = Vector<f64>;

/// Rotors that follow within 60 ms.
pub(crate) fn rotors<R: Real>() -> ThrustModel<R> {
    ThrustModel::FirstOrder(FirstOrder {
        c0: R::from_f64(6.9),
        c1: R::from_f64(0.3),
        t_m_s: R::from_f64(0.06),
    })
}

/// No observer, delays as in [`Plant`].
pub(crate) fn pilot<R: Real>(ground_effect: GroundEffectModel<R>) -> Pilot<R> {
    let pilot = Pilot {
        mass_kg: R::from_f64(MASS_KG),
        gravity_mps2: R::from_f64(GRAVITY),
        law: Law::Composite(Composite::default()),
        horizontal: Horizontal::default(),
        thrust: rotors(),
        ground_effect: Guarded::new(ground_effect, Validity::default()),
        observer: None,
        adaptation: None,
        delays: Delays::default(),
        rotors_m: None,
        limits: Limits::default(),
    };
    pilot.validate().unwrap();
    pilot
}

pub(crate) fn hover_throttle() -> f64 {
    rotors::<f64>().throttle_for(WEIGHT_N)
}

/// Steps of 10 ms; what is sensed is 20 ms old, commands act after 10 ms.
#[derive(Clone, Debug)]
pub(crate) struct Plant {
    /// Ground effect over that of the tests' map.
    pub(crate) gain: f64,
    pub(crate) thrust_scale: f64,
    pub(crate) wind_n: Space,
    pub(crate) position_m: Space,
    pub(crate) velocity_mps: Space,
    pub(crate) up: Space,
    rotors: ThrustState<f64>,
    lift: f64,
    sensed: VecDeque<Motion<f64>>,
    sent: VecDeque<PilotCommand<f64>>,
}

impl Plant {
    pub(crate) fn new(position_m: Space) -> Self {
        let model = rotors::<f64>();
        Self {
            gain: 0.0,
            thrust_scale: 1.0,
            wind_n: Vector::ZERO,
            position_m,
            velocity_mps: Vector::ZERO,
            up: Vector::UP,
            rotors: ThrustState {
                x: model.rest(hover_throttle()),
            },
            lift: 0.0,
            sensed: VecDeque::new(),
            sent: VecDeque::new(),
        }
    }

    fn acceleration(&self) -> Space {
        let axial = self.rotors.thrust_n() * (self.thrust_scale + self.lift);
        (self.up * axial + self.wind_n) * (1.0 / MASS_KG) - Vector::UP * GRAVITY
    }

    /// What is sensed now of 20 ms ago; the attitude is that of now.
    pub(crate) fn sense(&mut self) -> Motion<f64> {
        let attitude = Attitude::from_thrust_direction(self.up, 0.0).unwrap();
        self.sensed.push_back(Motion {
            position_m: self.position_m,
            relative_velocity_mps: self.velocity_mps,
            vehicle_velocity_mps: self.velocity_mps,
            acceleration_mps2: self.acceleration(),
            attitude,
            deck_normal: Vector::UP,
        });
        if self.sensed.len() > 3 {
            self.sensed.pop_front();
        }
        Motion {
            attitude,
            ..self.sensed[0]
        }
    }

    pub(crate) fn fly(&mut self, command: &PilotCommand<f64>) {
        self.sent.push_back(*command);
        if self.sent.len() > 2 {
            self.sent.pop_front();
        }
        let command = self.sent[0];
        let model = rotors::<f64>();
        for _ in 0..10 {
            let dt = 1e-3;
            model.step(&mut self.rotors, command.throttle, dt);
            let target = self.gain * map::<f64>().ratio(self.position_m.z.max(0.05));
            self.lift += (target - self.lift) * dt / 0.162;
            let wanted = command.attitude.up();
            self.up = (self.up + (wanted - self.up) * (dt / 0.08))
                .direction()
                .unwrap();
            self.velocity_mps += self.acceleration() * dt;
            self.position_m += self.velocity_mps * dt;
        }
    }
}
