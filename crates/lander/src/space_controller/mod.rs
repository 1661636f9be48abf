//! The controller in space: from position and motion relative to the deck to thrust and
//! attitude.

mod motion;

pub use motion::{Motion, SpaceCommand, Target};

use crate::control::allocation::allocate;
use crate::control::horizontal::Errors;
use crate::control::observer::{Felt, Record};
use crate::control::{Adaptation, AdaptationState, Delays, Horizontal, HorizontalState, Observer};
use touchdown_flight::control::channel::{ChannelInput, VerticalChannel, ground_input};
use touchdown_flight::control::{Law, Saturation, VerticalState};
use touchdown_flight::error::SettingsError;
use touchdown_flight::ground_effect::{GroundEffect, GroundEffectInput, Guarded, Lift};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::Real;
use touchdown_flight::reference::ReferencePoint;
use touchdown_flight::space::{Attitude, Vector};
use touchdown_flight::thrust::ThrustModel;
use touchdown_flight::types::Limits;

/// A landing controller in three dimensions: the vector law of eq. (10),
/// `f_u = m v_r' - K_P s - K_I ∫ s dt - m g - f_a^`.
///
/// The vertical law runs the same code as the
/// [`VerticalController`](touchdown_flight::vertical_controller::VerticalController); the
/// horizontal law is [`Horizontal`]. The vertical force has priority: the thrust grows to
/// compensate the tilt, and the horizontal force stays within the remaining limits of
/// tilt and thrust. Ground effect acts along the rotors' axis, as thrust does. The
/// ground-effect model uses the height along the deck's normal.
///
/// [`Method`](touchdown_flight::Method) lists law, model and observer of each method.
///
/// An observer or an adaptation needs the IMU's acceleration. Only [`Law::Composite`]
/// uses their vertical part.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize, G: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>, G: serde::Deserialize<'de>"
    ))
)]
pub struct SpaceController<R: Real, G = Guarded<R>> {
    /// Mass of the vehicle, kg.
    pub mass_kg: R,
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: R,
    /// The vertical law.
    pub law: Law<R>,
    /// The horizontal law.
    pub horizontal: Horizontal<R>,
    /// Throttle to thrust.
    pub thrust: ThrustModel<R>,
    /// The ground effect.
    pub ground_effect: G,
    /// Disturbance observer, if one is used.
    pub observer: Option<Observer<R>>,
    /// Adaptation of the ground effect's scale factor, if it is used.
    pub adaptation: Option<Adaptation<R>>,
    /// Delays that observer and adaptation compensate.
    pub delays: Delays<R>,
    /// Limits of the actuators.
    pub limits: Limits<R>,
}

/// State of a [`SpaceController`] whose ground-effect model has state `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceControllerState<R: Real, S> {
    /// Vertical law, models and the last command.
    pub vertical: VerticalState<R, S>,
    /// Horizontal law.
    pub horizontal: HorizontalState<R>,
    /// Estimated disturbance, world axes, N; zero without an observer.
    pub disturbance_n: Vector<R>,
    /// State of the adaptation, if one is used.
    pub adaptation: Option<AdaptationState<R>>,
    record: Record<R>,
    /// The last motion and target, with every value finite.
    motion: Motion<R>,
    target: Target<R>,
    /// The last commanded attitude.
    attitude: Attitude<R>,
}

impl<R: Real, G: GroundEffect<R>> SpaceController<R, G> {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.channel().validate()?;
        self.horizontal.validate()?;
        if let Some(observer) = &self.observer {
            observer.validate()?;
        }
        if let Some(adaptation) = &self.adaptation {
            adaptation.validate()?;
        }
        self.delays.validate()
    }

    fn channel(&self) -> VerticalChannel<'_, R, G> {
        VerticalChannel {
            mass_kg: self.mass_kg,
            gravity_mps2: self.gravity_mps2,
            law: &self.law,
            thrust: &self.thrust,
            ground_effect: &self.ground_effect,
            limits: &self.limits,
        }
    }

    /// The state in a hover at `motion`: rotors and air in the steady state of `throttle`,
    /// the present command. Values that are not finite count as zero.
    pub fn initial(&self, motion: &Motion<R>, throttle: R) -> SpaceControllerState<R, G::State> {
        let motion = motion.or_previous(&Motion::default());
        let ground = self.ground(&motion);
        let channel = self.channel();
        let vertical = channel.initial(&ground, throttle);
        let thrust_n = vertical.thrust.thrust_n();
        let full = GroundEffectInput {
            thrust_n,
            throttle: vertical.command.throttle,
            ..ground
        };
        let lift = self.ground_effect.lift(&vertical.ground_effect, &full);
        let target = Target {
            vertical: ReferencePoint {
                height_m: motion.position_m.z,
                ..ReferencePoint::default()
            },
            yaw_rad: motion.attitude.yaw_rad(),
            ..Target::default()
        };
        SpaceControllerState {
            vertical,
            horizontal: HorizontalState::default(),
            disturbance_n: Vector::ZERO,
            adaptation: self.adaptation.map(|adaptation| adaptation.initial()),
            record: Record::new(thrust_n, lift, motion.attitude.up()),
            motion,
            target,
            // Level, so that no command exceeds the tilt limit.
            attitude: Attitude::from_yaw(target.yaw_rad),
        }
    }

    /// One control period: from the motion at its beginning to the command for its `dt`
    /// seconds.
    ///
    /// Values that are not finite are replaced by the last finite ones. The command is
    /// always finite and within the limits.
    pub fn step(
        &self,
        state: &mut SpaceControllerState<R, G::State>,
        motion: &Motion<R>,
        target: &Target<R>,
        dt: R,
    ) -> SpaceCommand<R> {
        let dt = usable_dt(dt);
        let sensed = motion.acceleration_mps2.is_finite();
        let motion = motion.or_previous(&state.motion);
        let target = target.or_previous(&state.target);
        (state.motion, state.target) = (motion, target);
        let lift = self.advance_estimates(state, &motion, sensed && !target.hold_estimates, dt);

        let up = motion.attitude.up();
        let channel = self.channel();
        let input = ChannelInput {
            measurement: motion.vertical(),
            reference: target.vertical,
            deck_acceleration_mps2: target.deck_acceleration_mps2.z,
            disturbance_n: state.disturbance_n.z,
            cos_tilt: up.z,
        };
        let output = channel.command(&mut state.vertical, &input, lift, dt);

        let errors = Errors {
            position_m: motion.position_m - target.position_m,
            velocity_mps: motion.relative_velocity_mps - target.velocity_mps,
            forward_mps2: target.deck_acceleration_mps2
                - state.disturbance_n * (R::ONE / self.mass_kg),
        };
        let asked = self.horizontal.demand(&state.horizontal, &errors);
        let allocated = allocate(
            asked.acceleration_mps2 * self.mass_kg,
            output.vertical_n,
            self.mass_kg * self.gravity_mps2,
            self.limits.thrust_max_n + lift.total_n(self.limits.thrust_max_n),
            self.horizontal.tilt_limit_rad,
            target.yaw_rad,
        );
        if let Some(allocated) = allocated {
            state.attitude = allocated.attitude;
        }
        let limited = asked.limited || allocated.is_none_or(|allocated| allocated.limited);
        self.horizontal
            .advance(&mut state.horizontal, &asked, limited, dt);
        SpaceCommand {
            thrust_n: output.command.thrust_n,
            throttle: output.command.throttle,
            attitude: state.attitude,
            ground_effect_n: output.command.ground_effect_n,
            saturated: output.saturation == Saturation::High,
            limited,
        }
    }

    /// Reduces the thrust at `rate_n_per_s` over `dt` seconds, down to the least thrust,
    /// along the deck's normal. It is for a vehicle on the deck; observer and adaptation
    /// pause.
    pub fn idle(
        &self,
        state: &mut SpaceControllerState<R, G::State>,
        motion: &Motion<R>,
        rate_n_per_s: R,
        dt: R,
    ) -> SpaceCommand<R> {
        let dt = usable_dt(dt);
        let motion = motion.or_previous(&state.motion);
        state.motion = motion;
        let lift = self.advance_estimates(state, &motion, false, dt);
        let last_n = state.vertical.command.thrust_n;
        let thrust_n = self
            .limits
            .thrust((last_n - rate_n_per_s.abs() * dt).finite_or(last_n));
        let command = &mut state.vertical.command;
        command.thrust_n = thrust_n;
        command.throttle = self.limits.throttle(self.thrust.throttle_for(thrust_n));
        command.ground_effect_n = lift.total_n(thrust_n).finite_or(R::ZERO);
        let yaw_rad = state.target.yaw_rad;
        if let Some(attitude) = Attitude::from_thrust_direction(motion.deck_normal, yaw_rad) {
            state.attitude = attitude;
        }
        SpaceCommand {
            thrust_n,
            throttle: state.vertical.command.throttle,
            attitude: state.attitude,
            ground_effect_n: state.vertical.command.ground_effect_n,
            saturated: false,
            limited: false,
        }
    }

    /// Advances models and record with another controller's command for the next `dt`
    /// seconds. Observer and adaptation pause.
    pub fn follow(
        &self,
        state: &mut SpaceControllerState<R, G::State>,
        motion: &Motion<R>,
        command: &SpaceCommand<R>,
        dt: R,
    ) {
        let motion = motion.or_previous(&state.motion);
        state.motion = motion;
        let lift = self.advance_estimates(state, &motion, false, usable_dt(dt));
        let last = &mut state.vertical.command;
        let thrust_n = command.thrust_n.finite_or(last.thrust_n);
        last.thrust_n = self.limits.thrust(thrust_n);
        last.throttle = self
            .limits
            .throttle(command.throttle.finite_or(last.throttle));
        last.ground_effect_n = lift.total_n(thrust_n).finite_or(R::ZERO);
        if command.attitude.is_finite() {
            state.attitude = command.attitude;
        }
    }

    /// Advances models, record, observer and adaptation. Returns the scaled lift of the
    /// ground effect.
    fn advance_estimates(
        &self,
        state: &mut SpaceControllerState<R, G::State>,
        motion: &Motion<R>,
        learn: bool,
        dt: R,
    ) -> Lift<R> {
        let ground = self.ground(motion);
        let lift = self
            .channel()
            .advance_models(&mut state.vertical, &ground, dt);
        let strength = match (&self.adaptation, &state.adaptation) {
            (Some(adaptation), Some(adapted)) => adaptation.strength(adapted),
            _ => R::ONE,
        };
        let thrust_n = state.vertical.thrust.thrust_n();
        let up = motion.attitude.up();
        state.record.push(thrust_n, lift, strength, up, dt);
        if learn {
            let felt = self.felt(state, motion);
            if let Some(observer) = &self.observer {
                observer.step(&mut state.disturbance_n, &felt, dt);
            }
            if let Some(adaptation) = &self.adaptation {
                let adapted = state.adaptation.get_or_insert_with(|| adaptation.initial());
                adaptation.step(adapted, &felt, dt);
            }
        }
        Lift {
            ratio: strength * lift.ratio,
            force_n: strength * lift.force_n,
        }
    }

    /// Measured force less thrust and ground effect of the models, world axes, N.
    pub(crate) fn unexplained_n(
        &self,
        state: &SpaceControllerState<R, G::State>,
        motion: &Motion<R>,
    ) -> Vector<R> {
        self.felt(state, motion).unexplained_n
    }

    fn felt(&self, state: &SpaceControllerState<R, G::State>, motion: &Motion<R>) -> Felt<R> {
        state.record.felt(
            &self.delays,
            motion.acceleration_mps2,
            self.mass_kg,
            self.gravity_mps2,
        )
    }

    /// The ground-effect model's input, except thrust and throttle: the height is along the
    /// deck's normal.
    fn ground(&self, motion: &Motion<R>) -> GroundEffectInput<R> {
        GroundEffectInput {
            height_m: motion.position_m.dot(motion.deck_normal),
            ..ground_input(&motion.vertical())
        }
    }
}
