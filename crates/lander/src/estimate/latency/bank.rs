//! Observers of a position, each under one assumed latency.

use super::{HYPOTHESES, LatencyEstimator};
use crate::estimate::relative::{RelativeFilter, RelativeState};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Memories τ after which an observer has forgotten its start: exp(-5) is below 1 %.
const SETTLED: f64 = 5.0;

/// Memories τ of a gap between readings after which the observers start again.
const GAP: f64 = 2.0;

/// Least share of the first observer's readings that another observer must have counted.
/// Below it the sums cover different flight times, so they are not comparable.
const LEAST_COMMON_SHARE: f64 = 0.9;

/// What a bank of observers follows, and with which memory.
#[derive(Clone, Copy)]
pub(super) struct Follow<R> {
    /// Memory τ of the observers, s.
    pub(super) memory_s: R,
    /// Readings that come sooner than this after the previous one are left out, s.
    pub(super) spacing_s: R,
    /// The observed axes of a vector in world axes; one axis alone comes with a zero, because two programs for one and two axes would take
    /// 1 kB more.
    pub(super) axes: fn(Vector<R>) -> [R; 2],
}

/// A measured position: the deck's point in body axes, seen from the vehicle's reference point, the reading's stamped age, and the
/// least mean squared error on the axes that are followed.
#[derive(Clone, Copy)]
pub(super) struct Sight<R> {
    pub(super) arm_m: Vector<R>,
    pub(super) age_s: R,
    pub(super) noise_m2: R,
}

/// Observer of the position on two axes under one assumed latency.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Track<R> {
    place: [R; 2],
    velocity: [R; 2],
    bias: [R; 2],
}

/// Sums of an observer's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Account<R> {
    /// Time since the observer started, s.
    followed_s: R,
    /// Sum of squared errors with fading memory, m².
    squares: R,
    /// Number of these errors, with the same memory.
    counted: R,
}

/// The observers' accounts, from the shortest latency to the longest.
type Accounts<R> = [Account<R>; HYPOTHESES];

/// The observers, from the shortest latency to the longest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bank<R> {
    tracks: [Track<R>; HYPOTHESES],
    accounts: Accounts<R>,
    /// Stamped age of the last reading, s; infinite before the first.
    age_s: R,
}

/// Comparison of the assumed latencies.
#[derive(Clone, Copy)]
pub(super) struct Verdict<R> {
    /// The best latency, in distances between two compared ones.
    pub(super) place: R,
    /// Logarithm of the odds of that latency against none.
    pub(super) against_none: R,
    /// The same against the latency that is believed.
    pub(super) against_believed: R,
    /// Mean squared error of the believed latency over that of the best, which counts as at least the floor.
    pub(super) ratio: R,
    /// Mean squared error of the best latency, m².
    pub(super) least_m2: R,
    /// Number of errors that it is a mean of.
    pub(super) counted: R,
}

impl<R: Real> Bank<R> {
    pub(super) const fn new(age_s: R) -> Self {
        let zeros = [R::ZERO; 2];
        Self {
            tracks: [Track {
                place: zeros,
                velocity: zeros,
                bias: zeros,
            }; HYPOTHESES],
            accounts: [Account {
                followed_s: R::ZERO,
                squares: R::ZERO,
                counted: R::ZERO,
            }; HYPOTHESES],
            age_s,
        }
    }

    pub(super) fn age(&mut self, dt: R) {
        self.age_s += dt;
    }

    /// Advances all observers to a reading and adds up their errors. Returns whether the errors count.
    #[inline(never)]
    pub(super) fn compare<const N: usize, const M: usize>(
        &mut self,
        estimator: &LatencyEstimator<R>,
        follow: &Follow<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        sight: Sight<R>,
    ) -> bool {
        // The interval between readings is the same for all observers.
        let step_s = self.age_s - sight.age_s;
        if step_s <= follow.spacing_s {
            return false;
        }
        let gap = step_s >= follow.memory_s * r(GAP);
        let gains = gains(step_s, follow.memory_s);
        let mut errors = [R::ZERO; HYPOTHESES];
        let mut past = filter.past(relative);
        let observers = self.tracks.iter_mut().zip(&mut self.accounts);
        for (k, ((track, account), error)) in observers.zip(&mut errors).enumerate() {
            let latency_s = estimator.latency(k);
            let age_s = sight.age_s + latency_s;
            let place = (follow.axes)(-past.attitude_at(age_s).rotate(sight.arm_m));
            let moved = past.moved(self.age_s + latency_s, age_s).filter(|_| !gap);
            let mut next = Track::at(place);
            let mut followed_s = R::ZERO;
            if let Some(moved) = moved {
                let mut followed = *track;
                *error = followed.follow(place, moved.map(follow.axes), step_s, gains);
                if followed.is_finite() {
                    (next, followed_s) = (followed, account.followed_s + step_s);
                }
            }
            (*track, account.followed_s) = (next, followed_s);
        }
        self.age_s = sight.age_s;
        let wait_s = estimator.greatest_s + step_s;
        let kept = (-(step_s / estimator.evidence_s)).exp();
        count(&mut self.accounts, &errors, follow, wait_s, kept)
    }

    /// Compares the sums, of which the least is at least the mean squared error `floor_m2`. `believed` is the latency that counts, in
    /// distances between two compared ones. None where too few are comparable.
    #[inline(never)]
    pub(super) fn verdict(
        &self,
        follow: &Follow<R>,
        floor_m2: R,
        believed: R,
    ) -> Option<Verdict<R>> {
        let counted = self.accounts[0].counted;
        let least_s = follow.memory_s * r(SETTLED);
        let compared = self
            .accounts
            .iter()
            .take_while(|one| {
                one.is_settled(least_s) && one.counted >= counted * r(LEAST_COMMON_SHARE)
            })
            .count();
        // The parabola needs three points.
        if compared < 3 {
            return None;
        }
        let last = compared - 1;
        let mut squares = [R::ZERO; HYPOTHESES];
        for (mean, one) in squares.iter_mut().zip(&self.accounts).take(compared) {
            *mean = one.squares / one.counted;
        }
        let (mut best, mut least) = (0, squares[0]);
        for (k, &mean) in squares.iter().enumerate().take(compared) {
            if mean < least {
                (best, least) = (k, mean);
            }
        }
        let squares = |k: usize| squares.get(k).copied().unwrap_or(least);
        if best == last && believed > R::from_count(last) {
            return None;
        }
        // At an end of the range the parabola is centred on the next latency inside.
        let middle = best.max(1).min(last - 1);
        let (before, after) = (squares(middle - 1), squares(middle + 1));
        let bend = before + after - squares(middle) - squares(middle);
        let offset = (r::<R>(0.5) * (before - after) / bend).finite_or(R::ZERO);
        let unit = least.max(floor_m2) / counted;
        let evidence = |squares_m2: R| (squares_m2 - least) / unit;
        let lower = (0..last)
            .rfind(|&k| R::from_count(k) <= believed)
            .unwrap_or(0);
        let share = (believed - R::from_count(lower)).min(R::ONE);
        let there = squares(lower) + share * (squares(lower + 1) - squares(lower));
        Some(Verdict {
            place: (R::from_count(middle) + offset).clamp(R::ZERO, R::from_count(last)),
            against_none: evidence(squares(0)),
            against_believed: evidence(there),
            ratio: there / least.max(floor_m2),
            least_m2: least,
            counted,
        })
    }
}

/// Gains of the filter of fading memory, for place, velocity and bias.
fn gains<R: Real>(step_s: R, memory_s: R) -> [R; 3] {
    let gone = R::ONE - (-(step_s / memory_s)).exp();
    let theta = R::ONE - gone;
    [
        R::ONE - theta * theta * theta,
        r::<R>(1.5) * gone * gone * (R::ONE + theta) / step_s,
        gone * gone * gone / (step_s * step_s),
    ]
}

/// Counts a reading's squared errors where the observers have forgotten their start; the sums first fade to the share `kept`.
/// While the relative filter's memory still fills, the other observers start later than the first, by `wait_s`: their latencies plus one
/// interval between readings. Returns whether the errors count.
#[inline(never)]
fn count<R: Real>(
    accounts: &mut Accounts<R>,
    errors: &[R; HYPOTHESES],
    follow: &Follow<R>,
    wait_s: R,
    kept: R,
) -> bool {
    let least_s = follow.memory_s * r(SETTLED);
    let counts = accounts[0].is_settled(least_s + wait_s);
    if counts {
        for (account, &error) in accounts.iter_mut().zip(errors) {
            account.squares *= kept;
            account.counted *= kept;
            if account.is_settled(least_s) {
                account.squares += error;
                account.counted += R::ONE;
            }
        }
    }
    counts
}

impl<R: Real> Account<R> {
    /// Whether the observer started at least `least_s` ago.
    fn is_settled(&self, least_s: R) -> bool {
        self.followed_s >= least_s
    }
}

impl<R: Real> Track<R> {
    /// At rest at a measured position.
    fn at(place: [R; 2]) -> Self {
        Self {
            place,
            velocity: [R::ZERO; 2],
            bias: [R::ZERO; 2],
        }
    }

    /// Advances by `step_s` with the measured motion, corrects by the measured position
    /// and returns the squared error. The gains are those for place, velocity and bias.
    fn follow(
        &mut self,
        measured: [R; 2],
        [faster, farther]: [[R; 2]; 2],
        step_s: R,
        [of_place, of_velocity, of_bias]: [R; 3],
    ) -> R {
        let half = r::<R>(0.5);
        let mut squares = R::ZERO;
        for d in 0..2 {
            let (place, velocity, bias) =
                (&mut self.place[d], &mut self.velocity[d], &mut self.bias[d]);
            *place += (*velocity - *bias * (half * step_s)) * step_s + farther[d];
            *velocity += faster[d] - *bias * step_s;
            let error = measured[d] - *place;
            *place += error * of_place;
            *velocity += error * of_velocity;
            *bias -= error * of_bias;
            squares += error * error;
        }
        squares
    }

    fn is_finite(&self) -> bool {
        let finite = |values: &[R; 2]| values.iter().all(|value| value.is_finite());
        finite(&self.place) && finite(&self.velocity) && finite(&self.bias)
    }
}
