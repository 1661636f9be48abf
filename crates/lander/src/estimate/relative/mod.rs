//! Kalman filter of the vehicle's motion relative to the deck.
//!
//! ```text
//! vertical      h' = v_q - v_p    v_q' = a - b    z_q' = v_q
//!               v_p' = a_p        a_p' = -2 ζ ω a_p - ω² v_p + w    b' = w_b
//! horizontal    p' = v - v_d      v' = a - b      v_d' = a_d + w_d  b' = w_b
//!               a_d' = -a_d/τ + w_a
//! a = R f - g e_z
//! ```
//!
//! h is the height above the deck's reference point, v_q and v_p the velocities
//! of vehicle and deck, a the measured acceleration (specific force f in body
//! axes turned by the attitude R), b its bias, z_q the altitude, p the horizontal
//! position relative to the deck on each axis. Heave is modelled as band-limited noise
//! around ω with the damping ratio ζ ([`DeckPrior`]). Settings may change between steps:
//! a known period halves the error of the relative velocity. The horizontal acceleration a_d of a deck that turns or
//! changes its speed is a Gauss–Markov process; a deck that keeps its velocity has none.
//!
//! The filter does not estimate the attitude. Attitude errors enter as a horizontal bias,
//! and as errors of range and tag in proportion to the distance. Vertical and horizontal
//! axes have separate filters; each of them counts the attitude error. Biases hold for
//! world axes. After a change of heading the filter must learn the horizontal biases
//! again, as fast as `bias_walk` allows.
//!
//! **Delays.** A reading corrects the state at the time of measurement. The filter keeps
//! the last N states with their inputs, and the M readings between them, and computes
//! again from the reading on. The result equals that of readings without latency, in any
//! order of arrival.
//!
//! * Readings older than N - 1 steps are counted and ignored. So N - 1 steps must be
//!   longer than the largest age: 0.31 s at 100 Hz and N = 32, 0.155 s at 200 Hz.
//! * M must be at least the number of readings within that age. With more readings, the
//!   filter keeps them for a shorter time, and the largest age decreases.
//! * Readings may fall between two steps; the attitude is interpolated to their time.
//!   Readings newer than the last IMU sample (`imu.delay_s`) wait. Readings stamped more
//!   than a step after the step's end are rejected.
//! * A state takes 76 numbers, a reading about 18: with N = 32, M = 64 and `f64` 29 kB,
//!   with `f32` half of it. Computing a step again costs as much as the step.
//!
//! **Consistency.** A reading whose innovation lies outside the gate is ignored. The
//! running mean of the normalised innovation squared and the number of successive
//! rejections show whether the filter has diverged ([`Health::diverged`]). Then call
//! [`RelativeFilter::restart`]. Readings that are not finite are counted and ignored.
//! While IMU samples are not finite, the last acceleration and attitude are held.
//!
//! **Limits.** Without GNSS velocity, and near the ground without the barometer, only the
//! prior separates the vehicle's own velocity from that of the deck. Their difference,
//! which a landing needs, is not affected. If vehicle and deck are at rest, rounding to
//! whole centimetres is not white: the height then keeps an error of up to half a quantum.

mod belief;
mod checks;
mod correction;
mod health;
mod history;
mod reading;
mod settings;
mod transition;

use belief::{AP, Belief, H, P, VD, VP, VQ, VX, ZQ};
use health::Monitors;
use history::{Accounts, History, Insertion, Node, Past};

pub use health::{Health, SensorHealth};
pub use reading::{
    BarometerReading, BeaconReading, GnssVelocity, ImuSample, RangeReading, Reading, Sensor,
    TagReading,
};
pub use settings::{
    BarometerModel, BeaconModel, DeckPrior, Gate, GnssModel, ImuModel, InitialSpread, RangeModel,
    TagModel,
};

use crate::check::positive;
use touchdown_flight::error::SettingsError;
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

/// Kalman filter of the vehicle relative to the deck; see the
/// [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct RelativeFilter<R> {
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: R,
    /// The inertial unit.
    pub imu: ImuModel<R>,
    /// The range finder.
    pub range: RangeModel<R>,
    /// The camera and the tag.
    pub tag: TagModel<R>,
    /// Satellite navigation.
    pub gnss: GnssModel<R>,
    /// The barometer.
    pub barometer: BarometerModel<R>,
    /// Broadcast of the deck.
    #[cfg_attr(feature = "serde", serde(default))]
    pub beacon: BeaconModel<R>,
    /// Prior of the deck's motion.
    pub deck: DeckPrior<R>,
    /// Uncertainty before any reading.
    pub initial: InitialSpread<R>,
    /// Gates and the monitor of consistency.
    pub gate: Gate<R>,
}

/// State of a [`RelativeFilter`] that remembers N - 1 steps and M readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeState<R: Real, const N: usize = 32, const M: usize = 64> {
    history: History<R, N, M>,
    accounts: Accounts<R>,
    sighting: Option<DeckSighting<R>>,
}

impl<R: Real, const N: usize, const M: usize> RelativeState<R, N, M> {
    /// Zeros, to be brought to [`RelativeFilter::initial`] in place: so large a state is not
    /// handed through the stack. All bits are zero, so that flash does not hold them either.
    pub(crate) const BLANK: Self = Self {
        history: History::BLANK,
        accounts: Accounts {
            monitors: Monitors::BLANK,
            barometer_origin_m: None,
        },
        sighting: None,
    };
}

/// The deck's height from one reading: the integral of the vehicle's estimated velocity,
/// less the measured height. Its error is an offset with a slowly drifting rate (the
/// noise of the accelerometer). Faster changes are the deck's heave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckSighting<R> {
    /// Height of the deck, m.
    pub displacement_m: R,
    /// Standard deviation of the reading, m.
    pub sd_m: R,
    /// Age of the reading, s.
    pub age_s: R,
}

/// The estimate, with standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeEstimate<R> {
    /// Vehicle relative to the deck's reference point; z is the height, m.
    pub position_m: Vector<R>,
    /// Velocity of the vehicle, m/s.
    pub velocity_mps: Vector<R>,
    /// Velocity of the deck, m/s.
    pub deck_velocity_mps: Vector<R>,
    /// Vertical acceleration of the deck, m/s².
    pub deck_acceleration_mps2: R,
    /// Horizontal acceleration of a deck that turns or changes its speed, m/s².
    pub course_mps2: Vector<R>,
    /// Acceleration of the vehicle, bias removed, m/s².
    pub acceleration_mps2: Vector<R>,
    /// Bias of the acceleration, world axes, m/s².
    pub bias_mps2: Vector<R>,
    /// Altitude above the start, m.
    pub altitude_m: R,
    /// Standard deviation of the position, m.
    pub position_sd_m: Vector<R>,
    /// Standard deviation of the velocity relative to the deck, m/s.
    pub relative_velocity_sd_mps: Vector<R>,
    /// Standard deviation of the vehicle's velocity, m/s.
    pub velocity_sd_mps: Vector<R>,
    /// Standard deviation of the deck's velocity, m/s.
    pub deck_velocity_sd_mps: Vector<R>,
    /// Standard deviation of the deck's vertical acceleration, m/s².
    pub deck_acceleration_sd_mps2: R,
}

impl<R: Real> RelativeEstimate<R> {
    /// Height above the deck's reference point, m.
    #[must_use]
    pub fn height_m(&self) -> R {
        self.position_m.z
    }

    /// Velocity relative to the deck, m/s.
    #[must_use]
    pub fn relative_velocity_mps(&self) -> Vector<R> {
        self.velocity_mps - self.deck_velocity_mps
    }
}

impl<R: Real> Default for RelativeFilter<R> {
    /// The defaults of the parts, g = 9.81 m/s².
    fn default() -> Self {
        Self {
            gravity_mps2: r(9.81),
            imu: ImuModel::default(),
            range: RangeModel::default(),
            tag: TagModel::default(),
            gnss: GnssModel::default(),
            barometer: BarometerModel::default(),
            beacon: BeaconModel::default(),
            deck: DeckPrior::default(),
            initial: InitialSpread::default(),
            gate: Gate::default(),
        }
    }
}

impl<R: Real> RelativeFilter<R> {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("relative.gravity_mps2", self.gravity_mps2)?;
        self.imu.validate()?;
        self.range.validate()?;
        self.tag.validate()?;
        self.gnss.validate()?;
        self.barometer.validate()?;
        self.beacon.validate()?;
        self.deck.validate()?;
        self.initial.validate()?;
        self.gate.validate()
    }

    /// The state before any reading, at rest and level.
    #[must_use]
    pub fn initial<const N: usize, const M: usize>(&self) -> RelativeState<R, N, M> {
        let mut state = RelativeState::BLANK;
        self.reset(&mut state);
        state
    }

    /// Returns a state to [`Self::initial`] in place.
    #[inline(never)]
    pub fn reset<const N: usize, const M: usize>(&self, state: &mut RelativeState<R, N, M>) {
        let mut belief = Belief::initial(self);
        if self.initial.height_sd_m > R::ZERO {
            belief.know_height(self.initial.height_m, self.initial.height_sd_m);
        }
        state.history.reset(&Node {
            belief,
            acceleration_mps2: Vector::ZERO,
            attitude: Attitude::LEVEL,
            dt: R::ZERO,
        });
        state.accounts.monitors = Monitors::default();
        state.accounts.barometer_origin_m = None;
        state.sighting = None;
    }

    /// Restarts with the initial spread, after a divergence. The counts of the sensors
    /// and the attitude are kept.
    pub fn restart<const N: usize, const M: usize>(&self, state: &mut RelativeState<R, N, M>) {
        self.restart_from(state, &Belief::initial(self));
    }

    /// As [`Self::restart`], but keeps the estimated velocity of the vehicle, with the
    /// standard deviation `velocity_sd_mps` on each axis. Use it if the position is lost
    /// but the velocity is not.
    pub fn restart_moving<const N: usize, const M: usize>(
        &self,
        state: &mut RelativeState<R, N, M>,
        velocity_sd_mps: R,
    ) {
        let mut belief = Belief::initial(self);
        let velocity_mps = state.history.newest().belief.velocity();
        belief.know_velocity(velocity_mps, velocity_sd_mps);
        belief.follow(self.initial.follows_sd_mps);
        self.restart_from(state, &belief);
    }

    /// Forgets what a long flight without sight of the deck has correlated with its velocity, which is again that of the
    /// prior. The first sight of the deck then corrects the place, not the velocity.
    pub(crate) fn rest_deck<const N: usize, const M: usize>(
        &self,
        state: &mut RelativeState<R, N, M>,
    ) {
        state
            .history
            .rest_deck(self.deck.horizontal_velocity_sd_mps);
    }

    #[inline(never)]
    fn restart_from<const N: usize, const M: usize>(
        &self,
        state: &mut RelativeState<R, N, M>,
        belief: &Belief<R>,
    ) {
        state.history.restart(belief);
        state.accounts.barometer_origin_m = None;
        for monitor in state.accounts.monitors.each() {
            monitor.reset();
        }
    }

    /// Propagates over `dt` seconds with an IMU sample and corrects by the readings that
    /// have arrived since. The estimate is for the time of the sample.
    pub fn step<const N: usize, const M: usize>(
        &self,
        state: &mut RelativeState<R, N, M>,
        imu: &ImuSample<R>,
        readings: &[Reading<R>],
        dt: R,
    ) -> RelativeEstimate<R> {
        self.step_with(state, imu, readings.iter().copied(), dt);
        self.ahead(state, R::ZERO)
    }

    /// [`Self::step`] with readings from an iterator; returns no estimate.
    pub fn step_with<const N: usize, const M: usize>(
        &self,
        state: &mut RelativeState<R, N, M>,
        imu: &ImuSample<R>,
        readings: impl IntoIterator<Item = Reading<R>>,
        dt: R,
    ) {
        let dt = usable_dt(dt);
        let accounts = &mut state.accounts;
        for monitor in accounts.monitors.each() {
            monitor.grow(dt);
        }
        let (mut acceleration, mut attitude) = {
            let last = state.history.newest();
            (last.acceleration_mps2, last.attitude)
        };
        let sensed = imu.attitude.rotate(imu.specific_force_mps2);
        if imu.is_finite() && sensed.is_finite() {
            acceleration = sensed - Vector::UP * self.gravity_mps2;
            attitude = imu.attitude;
            let monitor = accounts.monitors.of(Sensor::Imu);
            monitor.note(health::Fate::Used(R::ONE), self.imu.delay_s, &self.gate);
        } else {
            accounts.monitors.of(Sensor::Imu).not_finite();
        }
        state.history.push(acceleration, attitude, dt);
        let mut sighting = None;
        for reading in readings {
            let monitor = accounts.monitors.of(reading.sensor());
            if !reading.is_finite() {
                monitor.not_finite();
                continue;
            }
            if reading.age_s() < -dt {
                monitor.unusable();
                continue;
            }
            let back = reading.age_s() - self.imu.delay_s;
            let mut insertion = state.history.insert(&reading, back);
            if matches!(insertion, Insertion::NoRoom) {
                // Readings of this step fill the log. Once the states contain them, the
                // oldest one can leave the log.
                sighting = clearer(sighting, state.history.replay(self, accounts));
                insertion = state.history.insert(&reading, back);
            }
            let monitor = accounts.monitors.of(reading.sensor());
            match insertion {
                Insertion::Logged => {}
                Insertion::TooOld => monitor.too_old(),
                Insertion::NoRoom => monitor.no_room(),
            }
        }
        state.sighting = clearer(sighting, state.history.replay(self, accounts));
    }

    /// The estimate `age_s` after the last IMU sample, its acceleration and
    /// attitude held.
    #[must_use]
    pub fn ahead<const N: usize, const M: usize>(
        &self,
        state: &RelativeState<R, N, M>,
        age_s: R,
    ) -> RelativeEstimate<R> {
        let node = state.history.newest();
        let mut belief = node.belief;
        belief.propagate(self, &mut None, node.acceleration_mps2, age_s);
        let (vertical, [x, y]) = (&belief.vertical, &belief.horizontal);
        let bias_mps2 = belief.bias();
        RelativeEstimate {
            position_m: belief.position(),
            velocity_mps: belief.velocity(),
            deck_velocity_mps: belief.deck_velocity(),
            deck_acceleration_mps2: vertical.mean[AP],
            course_mps2: belief.deck_horizontal_acceleration(),
            acceleration_mps2: node.acceleration_mps2 - bias_mps2,
            bias_mps2,
            altitude_m: vertical.mean[ZQ],
            position_sd_m: Vector::new(x.sd(P), y.sd(P), vertical.sd(H)),
            relative_velocity_sd_mps: Vector::new(
                x.sd_of_difference(VX, VD),
                y.sd_of_difference(VX, VD),
                vertical.sd_of_difference(VQ, VP),
            ),
            velocity_sd_mps: Vector::new(x.sd(VX), y.sd(VX), vertical.sd(VQ)),
            deck_velocity_sd_mps: Vector::new(x.sd(VD), y.sd(VD), vertical.sd(VP)),
            deck_acceleration_sd_mps2: vertical.sd(AP),
        }
    }

    /// The attitude at the time of a reading of this age, interpolated between IMU
    /// samples. For readings beyond the memory it is the oldest attitude.
    #[must_use]
    pub fn attitude_at<const N: usize, const M: usize>(
        &self,
        state: &RelativeState<R, N, M>,
        age_s: R,
    ) -> Attitude<R> {
        self.past(state).attitude_at(age_s)
    }

    /// A walk back into the time before.
    pub(crate) fn past<'a, const N: usize, const M: usize>(
        &self,
        state: &'a RelativeState<R, N, M>,
    ) -> Past<'a, R, N, M> {
        Past::new(&state.history, self.imu.delay_s)
    }

    /// The deck's height from the most precise reading of the last step, for a deck
    /// estimator. None if no range or tag reading arrived.
    #[must_use]
    pub fn deck_sighting<const N: usize, const M: usize>(
        &self,
        state: &RelativeState<R, N, M>,
    ) -> Option<DeckSighting<R>> {
        state.sighting
    }

    /// [`Health::diverged`] alone.
    pub(crate) fn has_diverged<const N: usize, const M: usize>(
        &self,
        state: &RelativeState<R, N, M>,
    ) -> bool {
        let monitors = &state.accounts.monitors;
        [&monitors.range, &monitors.tag, &monitors.gnss]
            .iter()
            .any(|monitor| monitor.has_diverged(&self.gate))
    }

    /// Time since the newest tag that was used arrived, s: its age less its latency.
    pub(crate) fn tag_silent_s<const N: usize, const M: usize>(
        &self,
        state: &RelativeState<R, N, M>,
    ) -> R {
        state.accounts.monitors.tag.silent_s()
    }

    /// State of the sensors and consistency of the filter.
    #[must_use]
    pub fn health<const N: usize, const M: usize>(
        &self,
        state: &RelativeState<R, N, M>,
    ) -> Health<R> {
        let monitors = &state.accounts.monitors;
        Health {
            imu: monitors.imu.health(self.imu.stale_s),
            range: monitors.range.health(self.range.stale_s),
            tag: monitors.tag.health(self.tag.stale_s),
            gnss: monitors.gnss.health(self.gnss.stale_s),
            barometer: monitors.barometer.health(self.barometer.stale_s),
            beacon: monitors.beacon.health(self.beacon.stale_s),
            diverged: self.has_diverged(state),
        }
    }
}

/// The more precise of two sightings.
fn clearer<R: Real>(
    a: Option<DeckSighting<R>>,
    b: Option<DeckSighting<R>>,
) -> Option<DeckSighting<R>> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.sd_m <= a.sd_m { b } else { a }),
        _ => a.or(b),
    }
}
