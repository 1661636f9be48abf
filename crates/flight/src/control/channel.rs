//! The vertical channel, shared by the controllers of one and three dimensions:
//! models, law, tilt, limits, throttle.

use super::{ControlInput, Law, LawState, Saturation};
use crate::error::{SettingsError, positive};
use crate::ground_effect::{GroundEffect, GroundEffectInput, Lift};
use crate::real::{Real, r};
use crate::reference::ReferencePoint;
use crate::thrust::{ThrustModel, ThrustState};
use crate::types::{Command, Limits, Measurement};

/// Least cosine of the tilt that is made up for: beyond 60° thrust does more
/// sideways than upward.
const COS_TILT_MIN: f64 = 0.5;

/// State of the vertical channel of a controller whose ground-effect model has
/// state `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalState<R, S> {
    /// State of the control law.
    pub law: LawState<R>,
    /// State of the thrust model.
    pub thrust: ThrustState<R>,
    /// State of the ground-effect model.
    pub ground_effect: S,
    /// The last command.
    pub command: Command<R>,
}

/// The vertical channel: the settings that it borrows from its controller.
#[derive(Debug)]
pub struct VerticalChannel<'a, R: Real, G> {
    /// Mass of the vehicle, kg.
    pub mass_kg: R,
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: R,
    /// The control law.
    pub law: &'a Law<R>,
    /// Throttle to thrust.
    pub thrust: &'a ThrustModel<R>,
    /// Time constant with which the thrust follows its demand, as a share of the motors' own; 1: as the motors do.
    pub motor_lag_share: R,
    /// The ground effect.
    pub ground_effect: &'a G,
    /// Limits of the actuators.
    pub limits: &'a Limits<R>,
}

/// Input of a step besides the models' lift; every number is finite.
#[derive(Clone, Copy, Debug)]
pub struct ChannelInput<R> {
    /// The vertical measurement.
    pub measurement: Measurement<R>,
    /// The reference at this time.
    pub reference: ReferencePoint<R>,
    /// Acceleration of the deck that is fed forward, m/s².
    pub deck_acceleration_mps2: R,
    /// Force that no model explains, up, N.
    pub disturbance_n: R,
    /// Cosine of the angle between the rotors' axis and the vertical.
    pub cos_tilt: R,
}

/// Output of a step.
#[derive(Clone, Copy, Debug)]
pub struct ChannelOutput<R> {
    /// The command to send.
    pub command: Command<R>,
    /// The thrust that is asked for, within the limits, N. The command may lead it.
    pub demand_n: R,
    /// How the command met the limits.
    pub saturation: Saturation,
    /// The vertical force that thrust and ground effect are to give together, N.
    pub vertical_n: R,
}

/// The ground-effect model's input for a level vehicle, from a measurement.
pub fn ground_input<R: Real>(measurement: &Measurement<R>) -> GroundEffectInput<R> {
    GroundEffectInput {
        height_m: measurement.height_m,
        vehicle_velocity_mps: measurement.vehicle_velocity_mps,
        deck_velocity_mps: measurement.deck_velocity_mps(),
        ..GroundEffectInput::default()
    }
}

impl<R: Real, G: GroundEffect<R>> VerticalChannel<'_, R, G> {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("mass_kg", self.mass_kg)?;
        positive("gravity_mps2", self.gravity_mps2)?;
        self.law.validate()?;
        self.thrust.validate()?;
        self.ground_effect.validate()?;
        self.limits.validate()
    }

    /// Rotors and air at rest at `throttle`, which is being sent. Thrust and
    /// throttle of `ground` are filled in.
    pub fn initial(
        &self,
        ground: &GroundEffectInput<R>,
        throttle: R,
    ) -> VerticalState<R, G::State> {
        let throttle = self.limits.throttle(throttle.finite_or(R::ZERO));
        let thrust = ThrustState {
            x: self.thrust.rest(throttle),
        };
        let ground = GroundEffectInput {
            thrust_n: thrust.thrust_n(),
            throttle,
            ..*ground
        };
        let ground_effect = self.ground_effect.rest(&ground);
        let lift = self.ground_effect.lift(&ground_effect, &ground);
        VerticalState {
            law: self.law.initial(thrust.thrust_n()),
            thrust,
            ground_effect,
            command: Command {
                thrust_n: thrust.thrust_n(),
                throttle,
                ground_effect_n: self.used_force(lift, thrust),
            },
        }
    }

    /// Advances thrust and ground effect over `dt` seconds under the throttle
    /// sent last; gives the lift now.
    pub fn advance_models(
        &self,
        state: &mut VerticalState<R, G::State>,
        ground: &GroundEffectInput<R>,
        dt: R,
    ) -> Lift<R> {
        let throttle = state.command.throttle;
        self.thrust.step(&mut state.thrust, throttle, dt);
        let ground = GroundEffectInput {
            thrust_n: state.thrust.thrust_n(),
            throttle,
            ..*ground
        };
        self.ground_effect
            .step(&mut state.ground_effect, &ground, dt)
    }

    /// The command for the next `dt` seconds under a lift.
    ///
    /// The law asks for the thrust of a level vehicle. Tilted by θ, thrust and lift
    /// act along the rotors' axis, and what they give upward is kept:
    /// `(T (1 + ratio) + force) cos θ = V`.
    pub fn command(
        &self,
        state: &mut VerticalState<R, G::State>,
        task: &ChannelInput<R>,
        lift: Lift<R>,
        dt: R,
    ) -> ChannelOutput<R> {
        let sent = state.command;
        let control = ControlInput {
            height_m: task.measurement.height_m,
            relative_velocity_mps: task.measurement.relative_velocity_mps,
            reference: task.reference,
            deck_acceleration_mps2: task.deck_acceleration_mps2,
            mass_kg: self.mass_kg,
            gravity_mps2: self.gravity_mps2,
        };
        let helped = Lift {
            force_n: lift.force_n + task.disturbance_n,
            ..lift
        };
        let demand = self.law.demand(&state.law, &control, helped, dt);
        let level_n = demand.thrust_n;
        let counted = if self.law.uses_ground_effect() {
            lift
        } else {
            Lift::default()
        };
        let vertical_n = level_n + counted.total_n(level_n);
        let cosine = task.cos_tilt.clamp(r(COS_TILT_MIN), R::ONE);
        let tilted_n = vertical_n / (R::ONE + counted.ratio) * (R::ONE / cosine - R::ONE);
        let asked = (level_n + tilted_n).finite_or(sent.thrust_n);
        let led_n = self.led_n(state.thrust, asked);
        let thrust_n = self.limits.thrust(led_n);
        let needed = self.thrust.throttle_near(thrust_n, sent.throttle);
        let throttle = self.limits.throttle(needed);
        // At the end of the throttle the rotors may not give what is asked for.
        let saturation = if led_n > thrust_n || throttle >= self.limits.throttle_max {
            Saturation::High
        } else if led_n < thrust_n || throttle <= self.limits.throttle_min {
            Saturation::Low
        } else {
            Saturation::No
        };
        let demand_n = self.limits.thrust(asked);
        let sent_level_n = demand_n - tilted_n.finite_or(R::ZERO);
        self.law
            .advance(&mut state.law, &demand, sent_level_n, saturation, dt);
        state.command = Command {
            thrust_n,
            throttle,
            ground_effect_n: self.used_force(lift, state.thrust),
        };
        ChannelOutput {
            command: state.command,
            demand_n,
            saturation,
            vertical_n,
        }
    }

    /// The thrust whose throttle brings the rotors to `asked_n` sooner than the throttle of `asked_n`, N. From x = √T, the
    /// throttle of `x + (√asked_n - x) / share` brings √T to `√asked_n` with the time constant `share · T_m`.
    fn led_n(&self, now: ThrustState<R>, asked_n: R) -> R {
        if self.motor_lag_share >= R::ONE {
            return asked_n;
        }
        let change = asked_n.max(R::ZERO).sqrt() - now.x;
        let root = (now.x + change / self.motor_lag_share).max(R::ZERO);
        (root * root).finite_or(asked_n)
    }

    /// The ground-effect force that the law uses, N.
    fn used_force(&self, lift: Lift<R>, thrust: ThrustState<R>) -> R {
        if self.law.uses_ground_effect() {
            lift.total_n(thrust.thrust_n()).finite_or(R::ZERO)
        } else {
            R::ZERO
        }
    }
}
