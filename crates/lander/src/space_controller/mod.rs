//! The controller in space: from position and motion relative to the deck to thrust and
//! attitude.

mod motion;

pub use motion::{Motion, SpaceCommand, Target};

use crate::control::allocation::{VERTICAL_SHARE_MIN, allocate};
use crate::control::cushion::counted;
use crate::control::horizontal::Errors;
use crate::control::observer::{Felt, Record};
use crate::control::{
    Adaptation, AdaptationState, Delays, Horizontal, HorizontalState, Observer, WINDY_SLOPE,
};
use touchdown_flight::control::channel::{ChannelInput, VerticalChannel, ground_input};
use touchdown_flight::control::{Law, Saturation, VerticalState};
use touchdown_flight::error::{SettingsError, within};
use touchdown_flight::ground_effect::{GroundEffect, GroundEffectInput, Guarded, Lift};
use touchdown_flight::kernel::{lag_share, usable_dt};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::ReferencePoint;
use touchdown_flight::space::{Attitude, Vector};
use touchdown_flight::thrust::ThrustModel;
use touchdown_flight::types::Limits;

/// Least share of the motors' time constant: at half, no swing of the thrust grows, however long the control period is.
const LEAST_LAG_SHARE: f64 = 0.5;

/// Share of the greatest thrust that the weight and the trim may need: the rest is for
/// gusts and attitude. At 1 nothing would be left to climb away with; at 0.8 winds above
/// 13 m/s would be refused on the default airframe.
const THRUST_SHARE: f64 = 0.9;

/// Greatest tilt just above the deck, rad: at 0.65 on one foot the tips of the blades strike it, and the attitude
/// overshoots by 0.1. At 0.5, 100 landings at 12 m/s have 18 descents that drift off the pad, for 4; at 0.7, 3 of 100 strike.
const LOW_TILT_RAD: f64 = 0.55;

/// Share of the trim's vertical thrust that decides about the tilt there, if less is demanded. A vehicle that is pressed
/// down keeps its tilt; its horizontal demand would otherwise tilt it onto one foot. At 0, 80 of 100 land at 12 m/s
/// for 82. The effect of halving was not measured.
const LOW_UP_SHARE: f64 = 0.95;

/// What observer and adaptation learn in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Learn {
    /// Nothing: there is no reading, or the deck carries the vehicle.
    Nothing,
    /// The horizontal disturbance: the legs may touch, but wind still pushes.
    Aside,
    /// Everything.
    All,
}

/// Greatest tilt of a deck that an idling vehicle follows, rad: just above that of a deck on which it lands (`deck_tilt_rad`, 0.25 rad).
/// The effect of halving or doubling was not measured.
const GREATEST_DECK_RAD: f64 = 0.3;

/// Tangent of an angle below a quarter turn.
fn tan<R: Real>(angle_rad: R) -> R {
    let (sin, cos) = angle_rad.sin_cos();
    sin / cos
}

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
    /// Time constant with which the thrust follows its demand, as a share of the motors' own, in [0.5, 1]; 1: as the motors do.
    pub motor_lag_share: R,
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
    /// The thrust that is asked for, within the limits, N. The last command leads it.
    pub demand_n: R,
    /// Horizontal law.
    pub horizontal: HorizontalState<R>,
    /// Estimated disturbance, world axes, N; zero without an observer.
    pub disturbance_n: Vector<R>,
    /// State of the adaptation, if one is used.
    pub adaptation: Option<AdaptationState<R>>,
    record: Record<R>,
    /// The lift that the last command counted.
    counted: Lift<R>,
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
        let share = self.motor_lag_share;
        let accepted = share >= r(LEAST_LAG_SHARE) && share <= R::ONE;
        within("computer.motor_lag_share", share, accepted, "0.5 to 1")?;
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
            motor_lag_share: self.motor_lag_share,
            ground_effect: &self.ground_effect,
            limits: &self.limits,
        }
    }

    /// The state in a hover at `motion`: rotors and air in the steady state of `throttle`,
    /// the present command. The horizontal part of that thrust balances a disturbance.
    /// Values that are not finite count as zero.
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
            demand_n: thrust_n,
            horizontal: HorizontalState::default(),
            disturbance_n: self.observer.map_or(Vector::ZERO, |observer| {
                let aside_n = motion.attitude.up().horizontal() * -thrust_n;
                aside_n.limited(observer.limit_n)
            }),
            adaptation: self.adaptation.map(|adaptation| adaptation.initial()),
            record: Record::new(thrust_n, lift, motion.attitude.up()),
            counted: lift,
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
        let learn = match (sensed, target.hold_estimates) {
            (false, _) => Learn::Nothing,
            (true, true) => Learn::Aside,
            (true, false) => Learn::All,
        };
        // Observer and adaptation know all of the lift, so the observer does not take back what the command leaves.
        let all = self.advance_estimates(state, &motion, learn, dt);
        let share = if target.lift_rise_s > R::ZERO {
            lag_share(target.lift_rise_s, dt)
        } else {
            R::ONE
        };
        let lift = counted(state.counted, all, share);
        state.counted = lift;

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
        state.demand_n = output.demand_n;

        let errors = Errors {
            position_m: motion.position_m - target.position_m,
            velocity_mps: motion.relative_velocity_mps - target.velocity_mps,
            forward_mps2: target.deck_acceleration_mps2,
            against_mps2: self.against_mps2(state),
        };
        let horizontal = self.horizontal.hastened(target.descending, target.haste);
        let asked = horizontal.demand(&state.horizontal, &errors);
        let low = target.low_slope > R::ZERO;
        let (least_up_share, tilt_limit_rad) = self.tilt_limits(target.low_slope);
        let allocated = allocate(
            asked.acceleration_mps2 * self.mass_kg,
            output.vertical_n,
            least_up_share * self.mass_kg * self.gravity_mps2,
            self.limits.thrust_max_n + lift.total_n(self.limits.thrust_max_n),
            tilt_limit_rad,
            target.yaw_rad,
        );
        if let Some(allocated) = allocated {
            state.attitude = allocated.attitude;
        }
        let limited = asked.limited || allocated.is_none_or(|allocated| allocated.limited);
        horizontal.advance(&mut state.horizontal, &asked, limited, dt);
        SpaceCommand {
            thrust_n: output.command.thrust_n,
            throttle: output.command.throttle,
            attitude: state.attitude,
            ground_effect_n: output.command.ground_effect_n,
            saturated: output.saturation == Saturation::High,
            // The limit of the last decimetre is no lack of thrust.
            limited: limited && !low,
        }
    }

    /// Least vertical force that decides about the tilt, share of the weight, and greatest tilt, rad: of a vehicle just above
    /// the deck in a wind with this slope of the trim s, whose vertical thrust is `1/(1 + s²)` of the weight, or at slope 0 of
    /// any other.
    fn tilt_limits(&self, low_slope: R) -> (R, R) {
        let greatest_rad = self.greatest_tilt_rad();
        let least = r(VERTICAL_SHARE_MIN);
        if low_slope > R::ZERO {
            let trim = r::<R>(LOW_UP_SHARE) / (R::ONE + low_slope * low_slope);
            (trim.max(least), greatest_rad.min(r(LOW_TILT_RAD)))
        } else {
            (least, greatest_rad)
        }
    }

    /// Whether the trim leans by more than [`WINDY_SLOPE`].
    pub(crate) fn is_windy(&self, trim_up: Vector<R>) -> bool {
        trim_up.horizontal().norm() > r::<R>(WINDY_SLOPE) * trim_up.z
    }

    /// Greatest tilt that may be demanded, rad: the limit of the settings, or that at which
    /// [`THRUST_SHARE`] of the greatest thrust carries the weight.
    pub(crate) fn greatest_tilt_rad(&self) -> R {
        let weight_n = self.mass_kg * self.gravity_mps2;
        let greatest_n = r::<R>(THRUST_SHARE) * self.limits.thrust_max_n;
        let aside_n = (greatest_n * greatest_n - weight_n * weight_n).max(R::ZERO);
        let reserve_rad = aside_n.sqrt().atan2(weight_n);
        self.horizontal.tilt_limit_rad.min(reserve_rad)
    }

    /// Acceleration against the observed disturbance, m/s².
    fn against_mps2(&self, state: &SpaceControllerState<R, G::State>) -> Vector<R> {
        state.disturbance_n * (-R::ONE / self.mass_kg)
    }

    /// Direction of the thrust that holds the vehicle still in its disturbance.
    pub(crate) fn trim_up(&self, state: &SpaceControllerState<R, G::State>) -> Vector<R> {
        let against_mps2 = self.against_mps2(state);
        let aside_mps2 = self.horizontal.trim_mps2(&state.horizontal, against_mps2);
        // Drag in the rotors' plane also lifts a leaning vehicle.
        let least_mps2 = self.gravity_mps2 * r(0.5);
        let up_mps2 = (self.gravity_mps2 + against_mps2.z)
            .finite_or(self.gravity_mps2)
            .clamp(least_mps2, self.gravity_mps2);
        let most_mps2 = up_mps2 * tan(self.greatest_tilt_rad());
        let thrust = aside_mps2.limited(most_mps2) + Vector::UP * up_mps2;
        thrust.direction().unwrap_or(Vector::UP)
    }

    /// Reduces the thrust at `rate_n_per_s` over `dt` seconds, down to the least thrust. It
    /// is for a vehicle on the deck; observer and adaptation pause.
    ///
    /// The thrust leans from the deck's normal by the trim's slope. A vehicle that leans into the wind touches with one foot.
    /// Attitude control then resists the weight that turns it onto the others, the less the lower the thrust.
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
        let lift = self.advance_estimates(state, &motion, Learn::Nothing, dt);
        let last_n = state.demand_n;
        let thrust_n = self
            .limits
            .thrust((last_n - rate_n_per_s.abs() * dt).finite_or(last_n));
        state.demand_n = thrust_n;
        let command = &mut state.vertical.command;
        command.thrust_n = thrust_n;
        command.throttle = self.limits.throttle(self.thrust.throttle_for(thrust_n));
        command.ground_effect_n = lift.total_n(thrust_n).finite_or(R::ZERO);
        // A camera may take the tag for one that leans the other way.
        let up = motion.deck_normal.z.abs();
        let aside = motion.deck_normal.horizontal();
        let most = up * tan(r(GREATEST_DECK_RAD));
        let deck = Vector::UP * up + aside.limited(most);
        let normal = deck.direction().unwrap_or(Vector::UP);
        let trim = self.trim_up(state);
        let leaned = normal + trim.horizontal() * (R::ONE / trim.z);
        if let Some(attitude) = Attitude::from_thrust_direction(leaned, state.target.yaw_rad) {
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
        let lift = self.advance_estimates(state, &motion, Learn::Nothing, usable_dt(dt));
        let thrust_n = command.thrust_n.finite_or(state.vertical.command.thrust_n);
        self.take(state, command);
        state.vertical.command.ground_effect_n = lift.total_n(thrust_n).finite_or(R::ZERO);
    }

    /// Another controller's command in the place of the last one of [`Self::step`]. Observer and adaptation then learn from
    /// what is flown; the integrals, which do not, stand at zero.
    pub fn replace(
        &self,
        state: &mut SpaceControllerState<R, G::State>,
        command: &SpaceCommand<R>,
    ) {
        self.take(state, command);
        state.vertical.law = self.law.initial(state.vertical.command.thrust_n);
        state.horizontal = HorizontalState::default();
    }

    /// Another controller's thrust, throttle and attitude as the last command, within the limits.
    fn take(&self, state: &mut SpaceControllerState<R, G::State>, command: &SpaceCommand<R>) {
        let last = &mut state.vertical.command;
        last.thrust_n = self
            .limits
            .thrust(command.thrust_n.finite_or(last.thrust_n));
        state.demand_n = last.thrust_n;
        last.throttle = self
            .limits
            .throttle(command.throttle.finite_or(last.throttle));
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
        learn: Learn,
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
        if learn != Learn::Nothing {
            let felt = self.felt(state, motion);
            if let Some(observer) = &self.observer {
                let vertical_n = state.disturbance_n.z;
                observer.step(&mut state.disturbance_n, &felt, dt);
                if learn == Learn::Aside {
                    state.disturbance_n.z = vertical_n;
                }
            }
            if let Some(adaptation) = self.adaptation.as_ref().filter(|_| learn == Learn::All) {
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
