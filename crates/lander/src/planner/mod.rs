//! Planner of the descent onto a moving deck: its start and its duration.
//!
//! The descent is the `terminal` reference, a quintic that ends at touchdown. Its
//! duration T is free within limits. So the planner reads the predicted deck motion at
//! all times at which a descent from now could end. It starts the best descent whose end
//! is *quiescent*, and waits if there is none.
//!
//! ```text
//! now       duration_min      duration_max                    horizon
//!  ├──────────────┼──── reach now ────┼──────── reach later ──────┤
//!                 └ go with the best   └ worth waiting for?
//! ```
//!
//! **Severity** of a touchdown time: the largest ratio of a predicted value to its limit
//! in [`Quiescence`], within `dwell_s` around that time. Up to 1 the deck is quiescent. A
//! time without a finite prediction is never chosen. Among quiescent times the planner
//! chooses the least `severity + cost_per_s · T`.
//!
//! A tilt beyond its limit is added instead, because it is the same at all times: it would hide the best of them.
//!
//! **Waiting** ends after `wait_s`. While this deadline lies beyond the horizon, only a
//! quiescent time is chosen. After that, the planner chooses the best time before the
//! deadline, quiescent or not. It starts as soon as no later time is better, and at the
//! latest at the deadline. Without a usable prediction it never starts.
//!
//! **Pace.** The predictions of a horizon are spread over the control periods between two
//! plans ([`Planner::scan`]), each made for the moment of the decision that follows, so that
//! no period has more than its share of the work.
//!
//! **A higher start** takes longer: above 0.85 m over its end, a descent's durations and its
//! greatest speed grow with the square root of the height, so that its acceleration stays.
//!
//! **Limits of the descent** hold for the reference's greatest speed, and for the sum of
//! its greatest acceleration and that of the deck during the descent.

mod forecast;
mod quintic;
mod scan;
mod settings;

pub use forecast::{DeckForecast, DeckOutlook};
pub use settings::{Descent, Planner, Quiescence};

use scan::Scan;
use touchdown_flight::kernel::{Sum, usable_dt};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::Terminal;

/// Steps of the horizon: 78 ms at the default of 10 s, well below the shortest dwell of
/// 0.2 s. More steps cost computing time in proportion.
const STEPS: usize = 128;

/// State of a [`Planner`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannerState<R> {
    waited: Sum<R>,
    scan: Scan<R>,
}

impl<R: Real> Default for PlannerState<R> {
    fn default() -> Self {
        Self {
            waited: Sum::default(),
            scan: Scan::default(),
        }
    }
}

impl<R: Real> PlannerState<R> {
    /// Forgets the waiting and the predictions so far.
    pub fn restart(&mut self) {
        self.waited = Sum::default();
        self.scan.restart();
    }

    /// Forgets the predictions so far.
    pub fn restart_scan(&mut self) {
        self.scan.restart();
    }

    /// Time waited so far, s.
    pub fn waited_s(&self) -> R {
        self.waited.value()
    }
}

/// A descent that starts now.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Plan<R> {
    /// The descent; touchdown is at its end.
    pub reference: Terminal<R>,
    /// Severity of the touchdown.
    pub severity: R,
    /// Whether the deck is then within its limits.
    pub quiescent: bool,
}

/// Decision of a planner.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Verdict<R> {
    /// Descend now.
    Go(Plan<R>),
    /// Wait for a better moment.
    Wait {
        /// Time until a descent to a predicted window can start, s; none if the horizon
        /// contains no window.
        window_in_s: Option<R>,
    },
    /// No prediction at the end of a possible descent is usable.
    Blind,
    /// No descent from this height is within the limits now.
    OutOfReach,
}

impl<R: Copy> Verdict<R> {
    /// The plan, if the decision is to descend.
    pub fn plan(&self) -> Option<Plan<R>> {
        match self {
            Self::Go(plan) => Some(*plan),
            _ => None,
        }
    }
}

/// What a horizon says about descents from now.
struct Sight<R> {
    /// The last time at which a descent may end.
    last: Option<usize>,
    /// The touchdown time of least cost, its severity and the sink rate; none without a
    /// prediction. Quiescent times have priority.
    best: Option<(usize, R, R)>,
    /// The prediction is usable at the end of at least one descent.
    known: bool,
}

impl<R: Real> Planner<R> {
    /// The state before any waiting.
    #[must_use]
    pub fn initial(&self) -> PlannerState<R> {
        PlannerState::default()
    }

    /// Adds `dt` seconds of waiting and decides; see [`Self::assess`]. Predicts the whole
    /// horizon at once, unless [`Self::scan`] has done so since the last decision.
    pub fn step(
        &self,
        state: &mut PlannerState<R>,
        start_height_m: R,
        hurry: bool,
        forecast: &impl DeckForecast<R>,
        dt: R,
    ) -> Verdict<R> {
        state.waited.add(usable_dt(dt));
        state.scan.advance(self, forecast, R::ZERO, STEPS + 1);
        let verdict = self.decide(state.waited.value(), start_height_m, hurry, &state.scan);
        state.scan.restart();
        verdict
    }

    /// Predicts the share of the horizon that falls on `dt` seconds of the `period_s`
    /// between two decisions; the next one is made `lead_s` from now. Returns whether the
    /// horizon is complete.
    pub fn scan(
        &self,
        state: &mut PlannerState<R>,
        forecast: &impl DeckForecast<R>,
        lead_s: R,
        dt: R,
        period_s: R,
    ) -> bool {
        let wanted = R::from_count(STEPS + 1) * (dt / period_s);
        // One more than the whole number below: rounding of times may cost a step.
        let share = (1..=STEPS)
            .find(|&count| R::from_count(count) > wanted)
            .unwrap_or(STEPS + 1);
        state.scan.advance(self, forecast, lead_s, share);
        state.scan.is_complete()
    }

    /// The decision after waiting for `waited_s`, in a hover at `start_height_m` above the
    /// deck. With `hurry`, the best possible descent starts now.
    #[must_use]
    pub fn assess(
        &self,
        waited_s: R,
        start_height_m: R,
        hurry: bool,
        forecast: &impl DeckForecast<R>,
    ) -> Verdict<R> {
        let mut scan = Scan::default();
        scan.advance(self, forecast, R::ZERO, STEPS + 1);
        self.decide(waited_s, start_height_m, hurry, &scan)
    }

    /// The decision by the predictions of a horizon.
    #[inline(never)]
    fn decide(&self, waited_s: R, start_height_m: R, hurry: bool, scan: &Scan<R>) -> Verdict<R> {
        let half = self.dwell_steps();
        let sight = self.look(start_height_m, scan, half);
        let Some(last) = sight.last else {
            return if sight.known {
                Verdict::OutOfReach
            } else {
                Verdict::Blind
            };
        };
        let Some((now, severity, sink_rate_mps)) = sight.best else {
            return Verdict::Blind;
        };
        let go = Verdict::Go(Plan {
            reference: Terminal {
                start_height_m,
                end_height_m: self.descent.end_height_m,
                sink_rate_mps,
                duration_s: self.time_s(now),
            },
            severity,
            quiescent: severity <= R::ONE,
        });
        if severity <= R::ONE {
            return go;
        }
        let left_s = if hurry {
            R::ZERO
        } else {
            (self.wait_s - waited_s).max(R::ZERO)
        };
        let ahead_s = |i: usize| self.time_s(i) - self.time_s(last);
        let mut later = (last + 1..=STEPS).filter(|&i| ahead_s(i) <= left_s);
        if left_s <= ahead_s(STEPS)
            && !later
                .clone()
                .any(|i| scan.worst_severity(i, half) < severity)
        {
            return go;
        }
        Verdict::Wait {
            window_in_s: later
                .find(|&i| scan.worst_severity(i, half) <= R::ONE)
                .map(ahead_s),
        }
    }

    /// Steps of the horizon to each side of a touchdown time within the dwell.
    fn dwell_steps(&self) -> usize {
        let steps = r::<R>(0.5) * self.quiescence.dwell_s / self.step_s() - r(1e-6);
        (0..STEPS)
            .find(|&half| R::from_count(half) >= steps)
            .unwrap_or(STEPS)
    }

    /// Assesses the predictions of a horizon.
    fn look(&self, start_height_m: R, scan: &Scan<R>, half: usize) -> Sight<R> {
        let mut sight = Sight {
            last: None,
            best: None,
            known: false,
        };
        let mut least: Option<(bool, R)> = None;
        let descent = self.descent.at_height(start_height_m);
        let mut greatest_mps2 = R::ZERO;
        for i in 0..=STEPS {
            let t = self.time_s(i);
            if t > descent.duration_max_s {
                break;
            }
            let Some((sink_rate_mps, deck_mps2)) = scan.at(i) else {
                continue;
            };
            sight.known |= t >= descent.duration_min_s;
            greatest_mps2 = greatest_mps2.max(deck_mps2);
            let reference = Terminal {
                start_height_m,
                end_height_m: self.descent.end_height_m,
                sink_rate_mps,
                duration_s: t,
            };
            if !descent.allows(&reference, greatest_mps2) {
                continue;
            }
            sight.last = Some(i);
            let severity = scan.worst_severity(i, half);
            let rank = (severity > R::ONE, severity + self.cost_per_s * t);
            if severity.is_finite() && least.is_none_or(|least| rank < least) {
                least = Some(rank);
                sight.best = Some((i, severity, sink_rate_mps));
            }
        }
        sight
    }

    /// Time between two touchdown times, s.
    fn step_s(&self) -> R {
        self.horizon_s / R::from_count(STEPS)
    }

    fn time_s(&self, i: usize) -> R {
        self.step_s() * R::from_count(i)
    }

    /// Sink rate at touchdown, which grows with the uncertainty of the deck's velocity.
    fn sink_rate(&self, outlook: &DeckOutlook<R>) -> R {
        let descent = &self.descent;
        (descent.sink_rate_mps + descent.sink_per_sd * outlook.velocity_sd_mps)
            .min(descent.sink_rate_max_mps)
    }

    /// The largest ratio of a predicted value to its limit.
    fn severity(&self, outlook: &DeckOutlook<R>, sink_rate_mps: R) -> R {
        let q = &self.quiescence;
        let k = q.confidence;
        let half = r::<R>(0.5);
        let middle = half * (q.acceleration_max_mps2 + q.acceleration_min_mps2);
        let width = half * (q.acceleration_max_mps2 - q.acceleration_min_mps2);
        let acceleration = outlook.acceleration_mps2.abs() + k * outlook.acceleration_sd_mps2;
        let relative = sink_rate_mps + k * outlook.velocity_sd_mps + q.response_s * acceleration;
        let shares = [
            (outlook.velocity_mps.abs() + k * outlook.velocity_sd_mps) / q.speed_mps,
            ((outlook.acceleration_mps2 - middle).abs() + k * outlook.acceleration_sd_mps2) / width,
            relative / q.relative_speed_mps,
        ];
        let motion = shares.into_iter().fold(R::ZERO, R::max);
        let tilt = (outlook.tilt_rad.abs() + k * outlook.tilt_sd_rad) / q.tilt_rad;
        if tilt <= R::ONE {
            motion.max(tilt)
        } else {
            motion + tilt
        }
    }
}

impl<R: Real> DeckOutlook<R> {
    /// Whether all values are finite and no standard deviation is negative.
    fn is_usable(&self) -> bool {
        let means = [self.velocity_mps, self.acceleration_mps2, self.tilt_rad];
        let sds = [
            self.velocity_sd_mps,
            self.acceleration_sd_mps2,
            self.tilt_sd_rad,
        ];
        means.iter().all(|value| value.is_finite())
            && sds.iter().all(|&sd| sd.is_finite() && sd >= R::ZERO)
    }
}
