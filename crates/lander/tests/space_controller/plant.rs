//! A point mass with rotors, attitude lag, ground effect, wind and delays, over
//! a deck that heaves and carries it.

use std::collections::VecDeque;

use touchdown_flight::control::{Composite, Law};
use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::thrust::{FirstOrder, ThrustModel, ThrustState};
use touchdown_flight::{Attitude, Limits, Real, Vector};
use touchdown_lander::control::{Delays, Horizontal};
use touchdown_lander::space_controller::{Motion, SpaceCommand, SpaceController};

use crate::common::flight::{GRAVITY, MASS_KG, WEIGHT_N, map};

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
pub(crate) fn space_controller<R: Real>(ground_effect: GroundEffectModel<R>) -> SpaceController<R> {
    let controller = SpaceController {
        mass_kg: R::from_f64(MASS_KG),
        gravity_mps2: R::from_f64(GRAVITY),
        law: Law::Composite(Composite::default()),
        horizontal: Horizontal::default(),
        motor_lag_share: R::ONE,
        thrust: rotors(),
        ground_effect: Guarded::new(ground_effect, Validity::default()),
        observer: None,
        adaptation: None,
        delays: Delays::default(),
        limits: Limits::default(),
    };
    controller.validate().unwrap();
    controller
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
    /// Amplitude and angular frequency of the deck's heave, from its mean at time
    /// zero.
    pub(crate) heave: (f64, f64),
    pub(crate) time_s: f64,
    pub(crate) position_m: Space,
    pub(crate) velocity_mps: Space,
    pub(crate) up: Space,
    rotors: ThrustState<f64>,
    lift: f64,
    sensed: VecDeque<Motion<f64>>,
    sent: VecDeque<SpaceCommand<f64>>,
}

impl Plant {
    pub(crate) fn new(position_m: Space) -> Self {
        let model = rotors::<f64>();
        Self {
            gain: 0.0,
            thrust_scale: 1.0,
            wind_n: Vector::ZERO,
            heave: (0.0, 1.0),
            time_s: 0.0,
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

    /// Height, velocity and acceleration of the deck at a time.
    pub(crate) fn deck(&self, time_s: f64) -> [f64; 3] {
        let (a, w) = self.heave;
        let (sin, cos) = (w * time_s).sin_cos();
        [a * sin, a * w * cos, -a * w * w * sin]
    }

    pub(crate) fn height_m(&self) -> f64 {
        self.position_m.z - self.deck(self.time_s)[0]
    }

    pub(crate) fn relative_velocity_mps(&self) -> f64 {
        self.velocity_mps.z - self.deck(self.time_s)[1]
    }

    /// Legs: 4 kN/m and 60 N s/m below 0.1 m; they push, never pull.
    pub(crate) fn legs_n(&self) -> f64 {
        let pressed = 0.1 - self.height_m();
        if pressed > 0.0 {
            (4000.0 * pressed - 60.0 * self.relative_velocity_mps()).max(0.0)
        } else {
            0.0
        }
    }

    pub(crate) fn acceleration(&self) -> Space {
        let axial = self.rotors.thrust_n() * (self.thrust_scale + self.lift);
        let outer = self.wind_n + Vector::UP * self.legs_n();
        // Feet on the deck do not slide.
        let grip = if self.legs_n() > 0.0 {
            self.velocity_mps.horizontal() * -30.0
        } else {
            Vector::ZERO
        };
        (self.up * axial + outer) * (1.0 / MASS_KG) - Vector::UP * GRAVITY + grip
    }

    /// What is sensed now of 20 ms ago; the attitude is that of now.
    pub(crate) fn sense(&mut self) -> Motion<f64> {
        let attitude = Attitude::from_thrust_direction(self.up, 0.0).unwrap();
        self.sensed.push_back(Motion {
            position_m: self.position_m - Vector::UP * self.deck(self.time_s)[0],
            relative_velocity_mps: self.velocity_mps - Vector::UP * self.deck(self.time_s)[1],
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

    pub(crate) fn fly(&mut self, command: &SpaceCommand<f64>) {
        self.sent.push_back(*command);
        if self.sent.len() > 2 {
            self.sent.pop_front();
        }
        let command = self.sent[0];
        let model = rotors::<f64>();
        for _ in 0..10 {
            let dt = 1e-3;
            model.step(&mut self.rotors, command.throttle, dt);
            let target = self.gain * map::<f64>().ratio(self.height_m().max(0.05));
            self.lift += (target - self.lift) * dt / 0.162;
            let wanted = command.attitude.up();
            self.up = (self.up + (wanted - self.up) * (dt / 0.08))
                .direction()
                .unwrap();
            self.velocity_mps += self.acceleration() * dt;
            self.position_m += self.velocity_mps * dt;
            self.time_s += dt;
        }
    }
}
