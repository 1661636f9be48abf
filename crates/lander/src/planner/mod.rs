//! When to descend onto a moving deck, and how.
//!
//! The descent is the `terminal` reference, a quintic that ends at touchdown; its
//! duration T is free within limits. So the planner reads the prediction of the
//! deck at the times at which a descent that starts now could end, and says go
//! with the best of them that is *quiescent*; while there is none it waits.
//!
//! ```text
//! now       duration_min      duration_max                    horizon
//!  ├──────────────┼──── reach now ────┼──────── reach later ──────┤
//!                 └ go with the best   └ worth waiting for?
//! ```
//!
//! **Severity** of a touchdown time: the largest share of any limit in
//! [`Quiescence`] that is used within `dwell_s` around it; up to 1 is quiescent.
//! A prediction that is not finite is never touched down on. Among quiescent
//! times that with the least `severity + cost_per_s · T` is taken.
//!
//! **Waiting** ends after `wait_s`. As long as the deadline is farther away than
//! the look-ahead, only a quiescent time will do. Then the best of what is in
//! sight before the deadline is taken, quiescent or not: the planner goes as soon as
//! nothing better is left to wait for, and at the deadline with the best that is
//! in reach. Without a usable prediction it never goes.
//!
//! **Limits of the descent** hold for the reference: its greatest speed, and its
//! greatest acceleration together with the greatest of the deck on the way.

mod forecast;
mod quintic;
mod settings;

pub use forecast::{DeckForecast, DeckOutlook};
pub use settings::{Descent, Planner, Quiescence};

use touchdown_flight::kernel::{Sum, usable_dt};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::Terminal;

/// Steps in which the horizon is looked at.
const STEPS: usize = 128;

/// State of a [`Planner`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlannerState<R> {
    waited: Sum<R>,
}

impl<R: Real> PlannerState<R> {
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

/// What a planner says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Verdict<R> {
    /// Descend now.
    Go(Plan<R>),
    /// Wait for a better moment.
    Wait {
        /// Time until a descent to a predicted window can start, s; none where no
        /// window is in sight.
        window_in_s: Option<R>,
    },
    /// No prediction in reach is usable.
    Blind,
    /// No descent from this height is within the limits now.
    OutOfReach,
}

impl<R: Copy> Verdict<R> {
    /// The plan, where it says go.
    pub fn plan(&self) -> Option<Plan<R>> {
        match self {
            Self::Go(plan) => Some(*plan),
            _ => None,
        }
    }
}

/// What is in sight, by touchdown time.
struct Sight<R> {
    step_s: R,
    /// Severity at each time, infinite where nothing is known.
    severity: [R; STEPS + 1],
    /// Sink rate of a descent that ends then; none where none within limits does.
    sink_rate_mps: [Option<R>; STEPS + 1],
    /// Something is known of the deck at the end of a descent.
    known: bool,
}

impl<R: Real> Planner<R> {
    /// The state before any waiting.
    #[must_use]
    pub fn initial(&self) -> PlannerState<R> {
        PlannerState::default()
    }

    /// Waits `dt` seconds and says what to do now, see [`Self::assess`].
    pub fn step(
        &self,
        state: &mut PlannerState<R>,
        start_height_m: R,
        hurry: bool,
        forecast: &impl DeckForecast<R>,
        dt: R,
    ) -> Verdict<R> {
        state.waited.add(usable_dt(dt));
        self.assess(state.waited.value(), start_height_m, hurry, forecast)
    }

    /// What to do after waiting for `waited_s`, from a hover at `start_height_m`
    /// above the deck. In a hurry, the best in reach will do.
    #[must_use]
    pub fn assess(
        &self,
        waited_s: R,
        start_height_m: R,
        hurry: bool,
        forecast: &impl DeckForecast<R>,
    ) -> Verdict<R> {
        let sight = self.look(start_height_m, forecast);
        let Some(last) = sight.sink_rate_mps.iter().rposition(Option::is_some) else {
            return if sight.known {
                Verdict::OutOfReach
            } else {
                Verdict::Blind
            };
        };
        let Some(now) = self.best_now(&sight) else {
            return Verdict::Blind;
        };
        let go = |(i, sink_rate_mps): (usize, R)| {
            Verdict::Go(Plan {
                reference: Terminal {
                    start_height_m,
                    end_height_m: self.descent.end_height_m,
                    sink_rate_mps,
                    duration_s: sight.time_s(i),
                },
                severity: sight.severity[i],
                quiescent: sight.severity[i] <= R::ONE,
            })
        };
        if sight.severity[now.0] <= R::ONE {
            return go(now);
        }
        let left_s = if hurry {
            R::ZERO
        } else {
            (self.wait_s - waited_s).max(R::ZERO)
        };
        let ahead_s = |i: usize| sight.time_s(i) - sight.time_s(last);
        let mut later = (last + 1..=STEPS).filter(|&i| ahead_s(i) <= left_s);
        if left_s <= ahead_s(STEPS)
            && !later
                .clone()
                .any(|i| sight.severity[i] < sight.severity[now.0])
        {
            return go(now);
        }
        Verdict::Wait {
            window_in_s: later.find(|&i| sight.severity[i] <= R::ONE).map(ahead_s),
        }
    }

    /// The touchdown time of least cost that a descent can reach from now: the
    /// quiescent ones first.
    fn best_now(&self, sight: &Sight<R>) -> Option<(usize, R)> {
        let mut best: Option<((bool, R), (usize, R))> = None;
        for (i, sink_rate_mps) in sight.sink_rate_mps.iter().enumerate() {
            let (Some(sink_rate_mps), severity) = (*sink_rate_mps, sight.severity[i]) else {
                continue;
            };
            if !severity.is_finite() {
                continue;
            }
            let cost = severity + self.cost_per_s * sight.time_s(i);
            let rank = (severity > R::ONE, cost);
            if best.is_none_or(|(least, _)| rank < least) {
                best = Some((rank, (i, sink_rate_mps)));
            }
        }
        best.map(|(_, found)| found)
    }

    /// Reads the forecast over the horizon.
    fn look(&self, start_height_m: R, forecast: &impl DeckForecast<R>) -> Sight<R> {
        let unknown = R::ONE / R::ZERO;
        let mut sight = Sight {
            step_s: self.horizon_s / r(STEPS as f64),
            severity: [unknown; STEPS + 1],
            sink_rate_mps: [None; STEPS + 1],
            known: false,
        };
        let mut severity = [unknown; STEPS + 1];
        let mut deck_mps2 = R::ZERO;
        for i in 0..=STEPS {
            let outlook = forecast.at(sight.time_s(i));
            if !outlook.is_usable() {
                continue;
            }
            let t = sight.time_s(i);
            sight.known |= t >= self.descent.duration_min_s && t <= self.descent.duration_max_s;
            let sink_rate_mps = self.sink_rate(&outlook);
            severity[i] = self.severity(&outlook, sink_rate_mps);
            deck_mps2 = deck_mps2.max(outlook.acceleration_mps2.abs());
            let reference = Terminal {
                start_height_m,
                end_height_m: self.descent.end_height_m,
                sink_rate_mps,
                duration_s: t,
            };
            sight.sink_rate_mps[i] = self.allows(&reference, deck_mps2).then_some(sink_rate_mps);
        }
        // The worst of the dwell around each time.
        let half = (r::<R>(0.5) * self.quiescence.dwell_s / sight.step_s).to_f64();
        let half = (libm::ceil(half - 1e-6).max(0.0) as usize).min(STEPS);
        for i in 0..=STEPS {
            let around = i.saturating_sub(half)..=(i + half).min(STEPS);
            sight.severity[i] = severity[around]
                .iter()
                .fold(R::ZERO, |worst, &s| worst.max(s));
        }
        sight
    }

    /// Sink rate for what is known of the deck.
    fn sink_rate(&self, outlook: &DeckOutlook<R>) -> R {
        let descent = &self.descent;
        (descent.sink_rate_mps + descent.sink_per_sd * outlook.velocity_sd_mps)
            .min(descent.sink_rate_max_mps)
    }

    /// The largest share of a limit that is used.
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
            (outlook.tilt_rad.abs() + k * outlook.tilt_sd_rad) / q.tilt_rad,
            relative / q.relative_speed_mps,
        ];
        shares.into_iter().fold(R::ZERO, R::max)
    }

    /// Whether a descent is within its limits, the deck accelerating by up to
    /// `deck_mps2` on the way.
    fn allows(&self, reference: &Terminal<R>, deck_mps2: R) -> bool {
        let descent = &self.descent;
        let t = reference.duration_s;
        if !(t >= descent.duration_min_s && t <= descent.duration_max_s)
            || reference.validate().is_err()
        {
            return false;
        }
        let (speed_mps, acceleration_mps2) = quintic::peaks(reference);
        speed_mps <= descent.speed_mps && acceleration_mps2 + deck_mps2 <= descent.acceleration_mps2
    }
}

impl<R: Real> Sight<R> {
    fn time_s(&self, i: usize) -> R {
        self.step_s * r(i as f64)
    }
}

impl<R: Real> DeckOutlook<R> {
    /// Finite, and with standard deviations that are ones.
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
