//! Wind: the trim, the slope of the approach, the lowest foot, the search upwind.

use super::steady::Steady;
use super::{Computer, ComputerState};
use crate::estimate::relative::{Health, RelativeEstimate};
use crate::space_controller::{Motion, Target};
use crate::state_machine::Phase;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::kernel::{lag_by, lag_share};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Slope of the trim up to which the approach is vertical: a quarter of the camera's half
/// view of 0.6. Halved, calm air would move the approach; doubled, a tag at the edge of the
/// view would be lost in gusts at 12 m/s.
const UPRIGHT: f64 = 0.15;

/// Time constant of the approach's slope, s: long against gusts, short against a wait of
/// some waves. Halved, gusts move the axis; doubled, the vehicle waits longer for readiness.
const LEAN_S: f64 = 2.0;

/// The same over a deck under way, s: at 10 degrees per second the wind turns by a twentieth of a circle in 2 s.
/// The effect of halving or doubling was not measured.
const COURSE_LEAN_S: f64 = 0.7;

/// Memory of the mean disturbance that a vehicle counts on when it no longer knows its velocity, s: long against its own
/// motion in the hover. Gusts of 30 m still mislead it. The effects of halving and doubling were not measured.
const STEADY_S: f64 = 10.0;
/// Time between two values of that mean, s: short against a swing of the hover.
const VALUE_S: f64 = 0.05;

/// Slope of the trim up to which feet hold that just touch: friction of 0.6, less what the wind may change by until weight is on them. The
/// effects of halving and doubling were not measured. (While hovers waited for such a lull as well, 0.4 broke off a seventh more descents
/// at 12 m/s, and as many landings crashed.)
const TOUCH_SLOPE: f64 = 0.5;
/// Slope beyond its mean from which the wind is a gust: where it always pushes so hard, waiting does not help. The effects of halving and
/// doubling were not measured.
const BEYOND_MEAN: f64 = 0.04;

/// Distance by which gusts move a vehicle off its axis per slope of the approach, m: 0.07 m at
/// 10 m/s, two standard deviations. Halved, every second descent at 10 m/s is aborted for it; doubled, the
/// vehicle lands up to 0.25 m from the centre.
const GUSTS_M: f64 = 0.2;

/// Time without a tag after which a hover in the wind moves to find it, s: longer than any loss by
/// a gust. Halved, gusts move it away from the pad; doubled, it drifts twice as far before.
const LOST_S: f64 = 1.0;
/// Velocity of that search, upwind and up, m/s: twice the drift of the estimate without a tag. Halved, 2 of
/// 100 landings at 8 m/s never see the pad; doubled, it flies past.
const SEARCH_MPS: f64 = 0.15;
/// Height above the deck up to which the search climbs, m: the view then covers 1 m to each side of what
/// is below. Halved, it covers what gusts cover; doubled, the smaller tags are too small.
const SEARCH_M: f64 = 2.0;

/// Least lean of the approach at which the last decimetre is that of a vehicle in the wind: that of 6 m/s on the default airframe.
/// Halved, gusts in calm air count; doubled, 8 m/s does not.
const LOW_LEAN: f64 = 0.1;
/// Height of the lowest foot above contact at which that decimetre begins, over the feet's radius: 0.06 m, two fifths of a
/// second of the descent there. The effect of halving or doubling was not measured.
const LOW_HEIGHT: f64 = 0.4;
/// Increase of the sink rate at the touch with the slope of the approach, over the planner's greatest: gusts that move the
/// vehicle by 0.1 m/s would otherwise hold it just above the deck. Without it 16 of 187 touches at 10 and 12 m/s are harder than
/// 0.3 m/s, for 11. The effect of doubling was not measured.
const SINK_PER_SLOPE: f64 = 2.5;
/// Factor on the rate at which the thrust decreases on a foot in the wind, and the share of the weight down to which it holds: 0.03 s.
/// The effects of halving and doubling were not measured.
const WINDY_IDLE: f64 = 4.0;
const WINDY_SHARE: f64 = 0.6;
/// How much more slowly the thrust decreases per height of the lowest foot below the others over the distance
/// of the feet from the axis: half the rate at a third, the drop in the trim of 10 m/s. The effects of halving and doubling
/// were not measured.
const IDLE_PER_DROP: f64 = 3.0;
/// Rate at which the thrust decreases below [`Computer::carried_share`] while the vehicle leans, over the weight, 1/s.
/// With 0.6, twice as many landings at 8 m/s are hard (1.37 kg). With 0.2, as many; 4 more of 400 of 4 kg crash at
/// 12 m/s.
const CARRIED_PER_S: f64 = 0.3;
/// Least and greatest such share. With 0.5 for the greatest, a fifth more landings at 8 m/s are hard. Attitude control has hardly any torque
/// below the least.
const LEAST_CARRIED: f64 = 0.15;
const MOST_CARRIED: f64 = 0.6;
/// Friction of the feet that it counts on, that of rubber on painted steel. A vehicle that slides counts on less. With 0.65, a tenth fewer
/// landings at 10 m/s are hard (1.37 kg). The effects of halving and doubling were not measured.
const FRICTION: f64 = 0.6;
/// Speed across the deck from which a vehicle slides, m/s, and friction it counts on less per speed, s/m. One that turns about a foot
/// has up to that speed. With 0.15 m/s three times as many landings at 8 m/s are hard; with 0.3 m/s and 3 s/m 7 of 200 slide off a deck with
/// a friction of 0.4 at 10 m/s, for 4.
const SLIDING_MPS: f64 = 0.25;
const FRICTION_PER_MPS: f64 = 8.0;
/// Least rate at which the thrust of a vehicle decreases that slides on all feet, over the weight, 1/s. Without it 32 of 200 of 25 kg (`octorotor_25kg`,
/// `wind.toml`, seed 5201) crash at 12 m/s, and 11 of 15 kg, for 19 and 4. With 4, 18 and 4, and a tenth more landings at 8 m/s are hard.
const SLIDES_PER_S: f64 = 2.0;
/// Time in which a deck turns by as much as it has leaned before, s: a sixth of the period of a sea. Without it, vehicles of 25 kg whose deck
/// has turned under them count as leaning, and 22 and 33 of 400 crash (`octorotor_25kg`, the 12 m/s of `wind.toml` alone, seeds 7001 and 7002), for 10 and 14.
/// The effects of halving and doubling were not measured.
const TURNS_S: f64 = 1.0;
/// Speed across the deck of a vehicle that is not held, whichever way the deck has turned, m/s. With 0.25 m/s as many crash, and of 150 landings
/// of `quadrotor_15kg` at 8 m/s (seed 7003) 84 are hard for 71; with 0.8 m/s 11 and 15 of those 400 crash.
const FAST_SLIDE_MPS: f64 = 0.6;
/// Least slope that counts as between the friction and a lean.
const LEAST_SLOPE: f64 = 0.01;

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// How many times more slowly the thrust decreases on the deck: on one foot more slowly, so that the others come down softly;
    /// in the wind faster at first, and on all feet if the vehicle slides, so that weight holds it.
    pub(super) fn idle_slower(&self, state: &ComputerState<R, G::State>, motion: &Motion<R>) -> R {
        let drop_m = self.feet.drop_m(motion.attitude, motion.deck_normal);
        let weight_n = self.controller.mass_kg * self.controller.gravity_mps2;
        let share = state.demand_n() / weight_n;
        let slower = R::ONE + drop_m.max(R::ZERO) * (r::<R>(IDLE_PER_DROP) / self.feet.radius_m);
        let across_mps = motion.relative_velocity_mps.horizontal().norm();
        let turned_m = if across_mps > r(FAST_SLIDE_MPS) {
            self.turned_m(state)
        } else {
            R::ZERO
        };
        let leans = drop_m > self.state_machine.leaning_m + turned_m;
        if !leans && across_mps > r(SLIDING_MPS) {
            slower.min(self.guidance.idle_n_per_s / (r::<R>(SLIDES_PER_S) * weight_n))
        } else if !leans {
            slower
        } else if share <= self.carried_share(state, motion) {
            slower.max(self.guidance.idle_n_per_s / (r::<R>(CARRIED_PER_S) * weight_n))
        } else if share > r(WINDY_SHARE) && self.controller.is_windy(state.trim_up) {
            R::ONE / r(WINDY_IDLE)
        } else {
            slower
        }
    }

    /// How much lower one foot of a vehicle that stands on all of them may seem, because the deck has turned since its tag was seen, m.
    fn turned_m(&self, state: &ComputerState<R, G::State>) -> R {
        let unseen_s = self.relative.tag_silent_s(&state.relative);
        let share = (unseen_s * r(1.0 / TURNS_S)).min(R::ONE);
        self.feet.radius_m * state.tilt_rad * share
    }

    /// Share of the weight that the rotors may carry of a vehicle that leans by the slope l, so that friction μ holds its feet. The wind,
    /// and a deck that turns, push it by the slope s times the weight: `(μ - s)/(μ - l)`. The thrust T opposes this by `T l`, and leaves
    /// `W - T` of the weight to the feet. The more thrust there is, the more softly attitude control sets the other feet down.
    fn carried_share(&self, state: &ComputerState<R, G::State>, motion: &Motion<R>) -> R {
        let (up, normal) = (motion.attitude.up(), motion.deck_normal);
        let lean = up.cross(normal).norm() / up.dot(normal);
        let across_mps = motion.relative_velocity_mps.horizontal().norm();
        let slides_mps = (across_mps - r(SLIDING_MPS)).max(R::ZERO);
        let friction: R = r(FRICTION);
        let pushed = self.trim_slope(state) + self.turning_slope(state);
        let left = friction - pushed.norm() - r::<R>(FRICTION_PER_MPS) * slides_mps;
        let share = left / (friction - lean).max(r(LEAST_SLOPE));
        share.clamp(r(LEAST_CARRIED), r(MOST_CARRIED))
    }

    /// Slope of the trim behind the slope of the approach l: `(l + √(l² + 4 u²))/2` with u = [`UPRIGHT`], which is the least.
    fn steady_slope(&self, lean: Vector<R>) -> R {
        let slope = lean.norm();
        let twice = r::<R>(2.0 * UPRIGHT);
        r::<R>(0.5) * (slope + (slope * slope + twice * twice).sqrt())
    }

    /// [`Target::low_slope`] with the lowest foot at a height, as that of a level vehicle's reference point.
    pub(super) fn low_slope(&self, state: &ComputerState<R, G::State>, feet_height_m: R) -> R {
        let above_m = feet_height_m - self.contact_height_m;
        let is_low = above_m < r::<R>(LOW_HEIGHT) * self.feet.radius_m;
        if is_low && state.lean.norm() > r(LOW_LEAN) {
            self.steady_slope(state.lean)
        } else {
            R::ZERO
        }
    }

    /// [`Target::lift_rise_s`]; none in wind, where a descent has to end as well.
    pub(super) fn lift_rise_s(&self, state: &ComputerState<R, G::State>, may_touch: bool) -> R {
        if state.lean.norm() > r(LOW_LEAN) {
            R::ZERO
        } else {
            state.sea.lift_rise_s(may_touch)
        }
    }

    /// How much faster a descent ends in the wind, m/s.
    pub(super) fn windy_sink_mps(&self, state: &ComputerState<R, G::State>, most_mps: R) -> R {
        let beyond = self.steady_slope(state.lean) - r(UPRIGHT);
        r::<R>(SINK_PER_SLOPE) * most_mps * beyond.max(R::ZERO)
    }

    /// Follows wind and sea.
    #[inline(never)]
    pub(super) fn watch_weather(
        &self,
        state: &mut ComputerState<R, G::State>,
        (estimate, corrected): (&RelativeEstimate<R>, bool),
        attitude: Attitude<R>,
        dt: R,
    ) {
        self.take_over(state, attitude);
        state.unremembered_s += dt;
        if state.unremembered_s >= r(VALUE_S) {
            self.remember_disturbance(state, estimate, corrected);
        }
        state.trim_up = self.find_trim_up(state);
        self.lean(state, estimate, dt);
        self.watch_sea(state, estimate, dt);
    }

    /// Updates two means while readings correct the velocity: of the disturbance, and of the error of the acceleration, which is the part
    /// of it that the velocity did not follow. Without readings the vehicle drifts, and the observer sees the drag of the drift. A
    /// vehicle that balances this drag drifts on.
    fn remember_disturbance(
        &self,
        state: &mut ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
        corrected: bool,
    ) {
        let wind_slope = self.wind_slope(state);
        let steady = &mut state.steady;
        let over_s = core::mem::replace(&mut state.unremembered_s, R::ZERO);
        let Some(controller) = &state.controller else {
            *steady = Steady::NONE;
            return;
        };
        let known = corrected && self.controller.observer.is_some() && self.moves_known(estimate);
        let now_mps = known.then_some(estimate.velocity_mps);
        let before_mps = core::mem::replace(&mut steady.velocity_mps, now_mps);
        let (Some(now_mps), Some(before_mps)) = (now_mps, before_mps) else {
            return;
        };
        steady.learned_s = (steady.learned_s + over_s).min(r(STEADY_S));
        let share = over_s / steady.learned_s;
        steady.disturbance_n += (controller.disturbance_n - steady.disturbance_n) * share;
        let followed_mps2 = (now_mps - before_mps) * (R::ONE / over_s);
        let felt_mps2 = estimate.acceleration_mps2;
        steady.error_mps2 += (felt_mps2 - followed_mps2 - steady.error_mps2) * share;
        steady.wind_slope += (wind_slope - steady.wind_slope) * share;
    }

    /// Moves a hover whose tag is lost upwind and up. The camera of a leaning vehicle looks
    /// downwind: it never finds a pad from downwind of it.
    pub(super) fn search_upwind(&self, state: &ComputerState<R, G::State>, target: &mut Target<R>) {
        let tag_age_s = self.relative.health(&state.relative).tag.age_s;
        let waits = matches!(state.phase(), Phase::Approach | Phase::Hold | Phase::Wait);
        let seen = tag_age_s <= r(LOST_S) || state.flown_s <= r(LOST_S);
        let trim = state.trim_up.horizontal();
        if seen || !waits || trim.norm() <= r(UPRIGHT) {
            return;
        }
        let Some(upwind) = trim.direction() else {
            return;
        };
        target.velocity_mps += upwind * r(SEARCH_MPS);
        if target.vertical.height_m < r(SEARCH_M) {
            target.vertical.velocity_mps += r(SEARCH_MPS);
        }
    }

    /// Lets a flight in the world's frame travel with the deck, at its last known velocity and acceleration.
    pub(super) fn keep_course(
        &self,
        state: &ComputerState<R, G::State>,
        motion: &Motion<R>,
        target: &mut Target<R>,
    ) {
        if self.under_way {
            let deck_mps = motion.vehicle_velocity_mps - motion.relative_velocity_mps;
            target.velocity_mps += deck_mps.horizontal();
            target.deck_acceleration_mps2 += state.course_mps2;
        }
    }

    /// Remembers the attitude in which the vehicle was flown before the first step. One
    /// beyond the tilt limit is no hover.
    fn take_over(&self, state: &mut ComputerState<R, G::State>, attitude: Attitude<R>) {
        if state.taken_over.is_none() && attitude.is_finite() {
            let limit_rad = self.controller.greatest_tilt_rad();
            let hovers = attitude.tilt_rad() <= limit_rad;
            state.taken_over = Some(if hovers { attitude } else { Attitude::LEVEL });
        }
    }

    /// Height of the lowest foot along the deck's normal, as that of a level vehicle's
    /// reference point, m.
    pub(super) fn feet_height_m(&self, motion: &Motion<R>) -> R {
        let normal = motion.deck_normal.direction().unwrap_or(Vector::UP);
        motion.position_m.dot(normal) - self.feet.drop_m(motion.attitude, normal)
    }

    /// [`Feet::drop_m`](super::Feet::drop_m) of the trim attitude.
    pub(super) fn trim_drop_m(&self, state: &ComputerState<R, G::State>, motion: &Motion<R>) -> R {
        let yaw_rad = motion.attitude.yaw_rad();
        let trim = Attitude::from_thrust_direction(state.trim_up, yaw_rad);
        trim.map_or(R::ZERO, |trim| self.feet.drop_m(trim, motion.deck_normal))
    }

    /// Direction of thrust that holds the vehicle still in the wind.
    fn find_trim_up(&self, state: &ComputerState<R, G::State>) -> Vector<R> {
        match (&state.controller, state.taken_over) {
            (Some(controller), _) => self.controller.trim_up(controller),
            (None, Some(attitude)) => attitude.up(),
            (None, None) => Vector::UP,
        }
    }

    /// Size of [`Self::trim_slope`].
    pub(super) fn wind_slope(&self, state: &ComputerState<R, G::State>) -> R {
        self.trim_slope(state).norm()
    }

    /// Whether a gust pushes harder than feet hold that just touch. A vehicle that goes around may lose a deck under way, and without
    /// satellite velocities any deck: it does not wait. (Of 200 landings of `quadrotor_0.03kg` on a car at 10 m/s without a broadcast, 107
    /// land if it does, 140 otherwise.)
    pub(super) fn is_gusty(&self, state: &ComputerState<R, G::State>, health: &Health<R>) -> bool {
        let usual_slope = state.steady.wind_slope + r(BEYOND_MEAN);
        let may_wait = health.gnss.fresh && !self.under_way;
        may_wait && self.wind_slope(state) > usual_slope.max(r(TOUCH_SLOPE))
    }

    /// Slope of that direction: horizontal over vertical.
    fn trim_slope(&self, state: &ComputerState<R, G::State>) -> Vector<R> {
        let trim = state.trim_up;
        trim.horizontal() * (R::ONE / trim.z)
    }

    /// Slope of the thrust that follows a deck which turns or changes its speed.
    fn turning_slope(&self, state: &ComputerState<R, G::State>) -> Vector<R> {
        state.course_mps2 * (R::ONE / self.controller.gravity_mps2)
    }

    /// Tilt of the vehicle beyond what lies between upright and trim, rad. A vehicle
    /// in the wind leans by its trim tilt, and stands upright on the deck.
    pub(super) fn tilt_beside_trim_rad(
        &self,
        state: &ComputerState<R, G::State>,
        attitude: Attitude<R>,
    ) -> R {
        let (up, trim) = (attitude.up(), state.trim_up);
        let angle = |to: Vector<R>| up.cross(to).norm().atan2(up.dot(to));
        attitude.tilt_rad().min(angle(trim))
    }

    /// Follows the slope of the approach: none up to [`UPRIGHT`], then `s (1 - (UPRIGHT/s)²)`
    /// of the trim's slope s. Camera and range finder look along the body's axis, so a vehicle
    /// that leans into the wind keeps the pad in view from upwind of it.
    fn lean(&self, state: &mut ComputerState<R, G::State>, estimate: &RelativeEstimate<R>, dt: R) {
        state.course_mps2 = if self.deck_accelerates(state) {
            estimate.course_mps2
        } else {
            Vector::ZERO
        };
        // A deck that turns tilts the vehicle as wind does. One in waves turns back too soon.
        let turned = if self.under_way {
            self.turning_slope(state)
        } else {
            Vector::ZERO
        };
        let slope = self.trim_slope(state) + turned;
        let size = slope.norm();
        let wanted = if size > r(UPRIGHT) {
            let share = r::<R>(UPRIGHT) / size;
            slope * (R::ONE - share * share)
        } else {
            Vector::ZERO
        };
        let lag_s = if self.under_way {
            COURSE_LEAN_S
        } else {
            LEAN_S
        };
        let share = lag_share(r(lag_s), dt);
        let follow = |now, then| lag_by(now, then, share);
        state.lean = Vector::new(
            follow(state.lean.x, wanted.x),
            follow(state.lean.y, wanted.y),
            R::ZERO,
        );
    }

    /// Distance from the axis of the approach, which ends at the pad, less what gusts of the
    /// wind that leans it move the vehicle, m.
    pub(super) fn off_axis_m(&self, state: &ComputerState<R, G::State>, motion: &Motion<R>) -> R {
        let above_m = (motion.position_m.z - self.contact_height_m).max(R::ZERO);
        let off_m = (motion.position_m.horizontal() - state.lean * above_m).norm();
        (off_m - r::<R>(GUSTS_M) * state.lean.norm()).max(R::ZERO)
    }
}
