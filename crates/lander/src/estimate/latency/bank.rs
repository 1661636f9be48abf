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
pub(super) struct Follow<R, const D: usize> {
    /// Memory τ of the observers, s.
    pub(super) memory_s: R,
    /// Readings that come sooner than this after the previous one are left out, s.
    pub(super) spacing_s: R,
    /// The observed axes of a vector in world axes.
    pub(super) axes: fn(Vector<R>) -> [R; D],
}

/// A measured position: the deck's point in body axes, seen from the vehicle's reference point, and the reading's stamped age.
#[derive(Clone, Copy)]
pub(super) struct Sight<R> {
    pub(super) arm_m: Vector<R>,
    pub(super) age_s: R,
}

/// Observer of the position on D axes under one assumed latency.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hypothesis<R, const D: usize> {
    /// Age of the position, s.
    age_s: R,
    place: [R; D],
    velocity: [R; D],
    bias: [R; D],
    /// Time since the observer started, s; none before the first reading.
    followed_s: Option<R>,
    /// Sum of squared errors with fading memory, m².
    squares: R,
    /// Number of these errors, with the same memory.
    counted: R,
}

/// The observers, from the shortest latency to the longest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bank<R, const D: usize> {
    hypotheses: [Hypothesis<R, D>; HYPOTHESES],
}

/// What the sums of a bank say.
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

impl<R: Real, const D: usize> Bank<R, D> {
    pub(super) const fn new() -> Self {
        let zeros = [R::ZERO; D];
        Self {
            hypotheses: [Hypothesis {
                age_s: R::ZERO,
                place: zeros,
                velocity: zeros,
                bias: zeros,
                followed_s: None,
                squares: R::ZERO,
                counted: R::ZERO,
            }; HYPOTHESES],
        }
    }

    pub(super) fn age(&mut self, dt: R) {
        for hypothesis in &mut self.hypotheses {
            hypothesis.age_s += dt;
        }
    }

    /// Advances all observers to a reading and adds up their errors. Returns whether the errors count.
    #[inline(never)]
    pub(super) fn compare<const N: usize, const M: usize>(
        &mut self,
        estimator: &LatencyEstimator<R>,
        follow: &Follow<R, D>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        sight: Sight<R>,
    ) -> bool {
        // The interval between readings is the same for all observers.
        let first = &self.hypotheses[0];
        let step_s = first.age_s - sight.age_s;
        if first.followed_s.is_some() && step_s <= follow.spacing_s {
            return false;
        }
        let gone = R::ONE - (-(step_s / follow.memory_s)).exp();
        let gap = step_s >= follow.memory_s * r(GAP);
        // Of the memory's filter: for place, velocity and bias.
        let theta = R::ONE - gone;
        let gains = [
            R::ONE - theta * theta * theta,
            r::<R>(1.5) * gone * gone * (R::ONE + theta) / step_s,
            gone * gone * gone / (step_s * step_s),
        ];
        let mut errors = [R::ZERO; HYPOTHESES];
        for (k, hypothesis) in self.hypotheses.iter_mut().enumerate() {
            let age_s = sight.age_s + estimator.latency(k);
            let attitude = filter.attitude_at(relative, age_s);
            let place = (follow.axes)(-attitude.rotate(sight.arm_m));
            let moved = filter.moved(relative, hypothesis.age_s, age_s);
            let mut next = Hypothesis {
                age_s,
                followed_s: hypothesis.followed_s.map(|so_far| so_far + step_s),
                ..*hypothesis
            };
            *hypothesis = match moved.filter(|_| !gap && next.followed_s.is_some()) {
                Some(moved) => {
                    errors[k] = next.follow(place, moved.map(follow.axes), step_s, gains);
                    next
                }
                None => hypothesis.restarted(place, age_s),
            };
            if !hypothesis.is_finite() {
                *hypothesis = hypothesis.restarted(place, age_s);
            }
        }
        // While the filter's memory still fills, the other observers start later than the
        // first: by their latencies plus one interval between readings.
        let least_s = follow.memory_s * r(SETTLED);
        let wait_s = estimator.greatest_s + step_s;
        let counts = self.hypotheses[0].is_settled(least_s + wait_s);
        if counts {
            let kept = (-(step_s / estimator.evidence_s)).exp();
            for (hypothesis, error) in self.hypotheses.iter_mut().zip(errors) {
                let settled = hypothesis.is_settled(least_s);
                hypothesis.count(error, settled, kept);
            }
        }
        counts
    }

    /// Compares the sums, of which the least is at least the mean squared error `floor_m2`. `believed` is the latency that counts, in
    /// distances between two compared ones. None where too few are comparable.
    #[inline(never)]
    pub(super) fn verdict(
        &self,
        follow: &Follow<R, D>,
        floor_m2: R,
        believed: R,
    ) -> Option<Verdict<R>> {
        let counted = self.hypotheses[0].counted;
        let least_s = follow.memory_s * r(SETTLED);
        let compared = self
            .hypotheses
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
        for (mean, one) in squares.iter_mut().zip(&self.hypotheses).take(compared) {
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

impl<R: Real, const D: usize> Hypothesis<R, D> {
    /// Restarts at a measured position and keeps the sums of errors.
    fn restarted(&self, place: [R; D], age_s: R) -> Self {
        Self {
            age_s,
            place,
            velocity: [R::ZERO; D],
            bias: [R::ZERO; D],
            followed_s: Some(R::ZERO),
            ..*self
        }
    }

    /// Whether the observer started at least `least_s` ago.
    fn is_settled(&self, least_s: R) -> bool {
        self.followed_s.is_some_and(|so_far| so_far >= least_s)
    }

    /// Adds the squared error of a reading if it `counts`; the sums first fade to the
    /// share `kept`.
    fn count(&mut self, error: R, counts: bool, kept: R) {
        self.squares *= kept;
        self.counted *= kept;
        if counts {
            self.squares += error;
            self.counted += R::ONE;
        }
    }

    /// Advances by `step_s` with the measured motion, corrects by the measured position
    /// and returns the squared error. The gains are those for place, velocity and bias.
    fn follow(
        &mut self,
        measured: [R; D],
        [faster, farther]: [[R; D]; 2],
        step_s: R,
        [of_place, of_velocity, of_bias]: [R; 3],
    ) -> R {
        let half = r::<R>(0.5);
        let mut squares = R::ZERO;
        for d in 0..D {
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
        let finite = |values: &[R; D]| values.iter().all(|value| value.is_finite());
        finite(&self.place) && finite(&self.velocity) && finite(&self.bias)
    }
}
