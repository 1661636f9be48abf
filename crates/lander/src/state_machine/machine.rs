//! State and step of the state machine.

use super::conditions::Conditions;
use super::{
    Frame, MachineInput, MachineOutput, Maneuver, OperatorRequest, Phase, Reason, StateMachine,
};
use crate::control::WINDY_SLOPE;
use touchdown_flight::kernel::{Sum, usable_dt};
use touchdown_flight::real::{Real, r};

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Fall of a vehicle that rocks about a foot, in times of a free fall: the foot carries half
/// of the weight, √2, and thrust a share. Halved, landings in a wind of 10 m/s climb away from the
/// deck; doubled, a fall in the air is noticed 0.1 s later at 0.39 rad of tilt.
const ROCKING: f64 = 1.5;

/// Share of `contact_s` for which a vehicle that leans into the wind must touch: on one foot it hardly presses, and the next
/// gust lifts it. At 1, 93 of 100 land at 10 m/s for 97. The effect of halving was not measured.
const WINDY_CONTACT: f64 = 0.2;

/// Share of the time until a rough sea's deck may strike for which a hover waits without sight of it: the rest is needed to
/// climb as fast as the deck. Tuned on 20 landings on a boat, other values were not measured.
const BELATED: f64 = 0.25;
/// Greatest speed of the deck up to which the hover stays at its height, m/s: that of seas of
/// 0.5 m. Halved, the default sea raises the hover; doubled, decks of 1.4 m/s strike a vehicle at 0.8 m.
/// Each metre of a raised hover is for 1 m/s more.
pub(crate) const CALM_MPS: f64 = 0.7;

/// Time for which a condition has held without interruption.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct HoldTimer<R>(Option<R>);

impl<R: Real> HoldTimer<R> {
    /// The first step with the condition does not count, nor does a gap.
    fn update(&mut self, holds: bool, dt: R, gap: bool) {
        self.0 = match self.0 {
            Some(so_far) if holds && !gap => Some(so_far + dt),
            _ => holds.then_some(R::ZERO),
        };
    }

    fn lasts(self, time_s: R) -> bool {
        self.0.is_some_and(|so_far| so_far >= time_s)
    }
}

/// Numbers of go-arounds that the operator did not order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct GoArounds {
    /// Out of a descent, for the wind.
    wind: u8,
    /// Out of a descent, for another reason.
    descent: u8,
    /// Out of a hover.
    hover: u8,
}

impl GoArounds {
    fn count(&mut self, descending: bool, reason: Option<Reason>) {
        let counter = match (descending, reason) {
            (true, Some(Reason::Wind)) => &mut self.wind,
            (true, _) => &mut self.descent,
            (false, _) => &mut self.hover,
        };
        *counter = counter.saturating_add(1);
    }

    fn all(self) -> u8 {
        self.wind
            .saturating_add(self.descent)
            .saturating_add(self.hover)
    }
}

/// State of a [`StateMachine`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MachineState<R> {
    phase: Phase,
    reason: Option<Reason>,
    go_arounds: GoArounds,
    last_request: OperatorRequest,
    /// Time in this phase and in those that share its limit, s.
    clock: Sum<R>,
    /// Time in Approach, Hold and Wait since the last descent, s.
    waited: Sum<R>,
    ready: HoldTimer<R>,
    touching: HoldTimer<R>,
    supported: HoldTimer<R>,
    evidence: HoldTimer<R>,
    apart: HoldTimer<R>,
    /// Time in which a vehicle that touched leaning comes down on its other feet, s; 0 for an
    /// upright one.
    rock_s: R,
    unsupported: HoldTimer<R>,
    beyond: HoldTimer<R>,
    sinking: HoldTimer<R>,
    saturated: HoldTimer<R>,
    lost: HoldTimer<R>,
    /// The vehicle has climbed since it lost sight of the deck.
    escaped: bool,
}

impl<R> MachineState<R> {
    /// The phase of the landing.
    pub fn phase(&self) -> Phase {
        self.phase
    }
}

impl<R: Real> MachineState<R> {
    /// The vehicle leaned when it touched, so that it rocks from foot to foot.
    fn rocks(&self) -> bool {
        self.rock_s > R::ZERO
    }
}

/// Phases that share a time limit.
#[derive(PartialEq)]
enum Stage {
    Waiting,
    Landing,
    Climbing,
    Ended,
}

impl Phase {
    fn stage(self) -> Stage {
        match self {
            Self::Approach | Self::Hold | Self::Wait => Stage::Waiting,
            Self::Descend | Self::Commit | Self::Touchdown => Stage::Landing,
            Self::GoAround => Stage::Climbing,
            Self::Disarmed | Self::GivenUp => Stage::Ended,
        }
    }
}

/// Conditions of the table of transitions that depend on the past.
struct History {
    stop: bool,
    restart: bool,
    late: bool,
    settled: bool,
    contact: bool,
    confirmed: bool,
    apart: bool,
    unsupported: bool,
    astray: Option<Reason>,
    /// Sight of the deck has been lost for `lost_s`, and for `search_s`.
    lost: bool,
    searched: bool,
    /// The vehicle has climbed since.
    escaped: bool,
    sinks: bool,
    too_many: bool,
}

/// Time in which a vehicle falls by the height of its lowest foot below that of a level one,
/// [`ROCKING`] times that of a free fall.
fn rocking_s<R: Real>(drop_m: R) -> R {
    let fall_s = (drop_m.max(R::ZERO) * r(2.0 / 9.81)).sqrt();
    (r::<R>(ROCKING) * fall_s).finite_or(R::ZERO)
}

impl<R: Real> StateMachine<R> {
    /// The state at the start: on the approach.
    #[must_use]
    pub fn initial(&self) -> MachineState<R> {
        MachineState::default()
    }

    /// One step, `dt` seconds after the previous one. A `dt` that is not positive counts
    /// as zero.
    pub fn step(
        &self,
        state: &mut MachineState<R>,
        seen: &MachineInput<R>,
        dt: R,
    ) -> MachineOutput<R> {
        let conditions = self.conditions(seen);
        if state.phase != Phase::Touchdown {
            let leans = seen.foot_drop_m > self.leaning_m;
            state.rock_s = if leans {
                rocking_s(seen.foot_drop_m)
            } else {
                R::ZERO
            };
        }
        let past = self.remember(state, seen, &conditions, dt);
        let (phase, reason) = self.transition(state, seen, &conditions, &past);
        self.enter(state, phase, reason, past.stop, past.restart);
        let hover = |frame| Maneuver::Hover {
            height_m: self.hold_height_m(seen),
            frame,
        };
        let maneuver = match phase {
            // Who gives up at the deck and loses sight of it climbs, too.
            Phase::GivenUp if self.sinks_blindly(state, &conditions) => Maneuver::ClimbAway,
            Phase::Approach | Phase::Hold | Phase::Wait | Phase::GivenUp => {
                hover(match conditions.stale {
                    None => Frame::Deck,
                    Some(_) => Frame::World,
                })
            }
            Phase::Descend => Maneuver::Descend,
            Phase::Commit => Maneuver::Commit,
            // A foot that rocks on the deck has a speed, and wind pushes a vehicle that keeps
            // its thrust. Above the deck the thrust is neither reduced further nor, before
            // that counts as a bounce, increased.
            Phase::Touchdown
                if conditions.touching || conditions.held || (state.rocks() && conditions.low) =>
            {
                Maneuver::Idle
            }
            Phase::Touchdown => Maneuver::Rest,
            Phase::GoAround => Maneuver::ClimbAway,
            Phase::Disarmed => Maneuver::Disarm,
        };
        MachineOutput {
            phase,
            maneuver,
            reason: state.reason,
            waits_for: conditions
                .unready
                .filter(|_| matches!(phase, Phase::Approach | Phase::Hold)),
            go_arounds: state.go_arounds.all(),
            hurry: conditions.battery_critical,
        }
    }

    /// The table of transitions, row by row.
    #[inline(never)]
    fn transition(
        &self,
        state: &MachineState<R>,
        seen: &MachineInput<R>,
        now: &Conditions,
        past: &History,
    ) -> (Phase, Option<Reason>) {
        use Phase::{
            Approach, Commit, Descend, Disarmed, GivenUp, GoAround, Hold, Touchdown, Wait,
        };
        let because = |phase: Phase, reason: Reason| (phase, Some(reason));
        let late = past.late.then_some(Reason::Late);
        let climbed = now.up || now.safe || past.late;
        let escape = now
            .stale
            .filter(|_| past.lost && !past.escaped && !now.safe);
        let unseen = now.stale.filter(|_| past.searched);
        let saturated = state.saturated.lasts(self.saturation_s);
        let strayed = past
            .astray
            .or(saturated.then_some(Reason::Saturated))
            .or(late);
        let unfit = now
            .rough_deck
            .then_some(Reason::Deck)
            .or(now.gust.then_some(Reason::Wind))
            .filter(|_| !now.battery_critical)
            .or(now.battery_low.then_some(Reason::BatteryLow));
        match state.phase {
            _ if seen.request == OperatorRequest::Disarm => because(Disarmed, Reason::Operator),

            // A sinking hover climbs first, before any other request.
            Approach | Hold | Wait if past.sinks => because(GoAround, Reason::ClosingSpeed),
            Hold | Wait if now.sunk => because(GoAround, Reason::Height),

            // So does one that does not see the deck.
            Approach | Hold | Wait if let Some(reason) = escape => because(GoAround, reason),
            Approach | Hold | Wait if let Some(reason) = unseen => because(GivenUp, reason),

            Approach if past.stop => because(Hold, Reason::Operator),
            Approach if now.battery_low => because(GivenUp, Reason::BatteryLow),
            Approach if past.late => because(GivenUp, now.unready.unwrap_or(Reason::Late)),
            Approach if now.stale.is_none() && now.at_hold_height && now.over_pad => (Hold, None),

            Hold | Wait if past.stop => because(Hold, Reason::Operator),

            Hold if now.battery_low => because(GivenUp, Reason::BatteryLow),
            Hold if past.late => because(GivenUp, now.unready.unwrap_or(Reason::Late)),
            Hold if past.settled => (Wait, None),

            Wait if now.battery_low => because(GivenUp, Reason::BatteryLow),
            Wait if let Some(reason) = now.unready => because(Hold, reason),
            Wait if seen.go => (Descend, None),
            Wait if past.late => because(GivenUp, Reason::Late),

            Descend if past.stop => because(GoAround, Reason::Operator),
            Descend if let Some(reason) = now.stale.or(strayed).or(unfit) => {
                because(GoAround, reason)
            }
            Descend if now.at_commit_height => (Commit, None),

            Commit if past.stop => because(GoAround, Reason::Operator),
            Commit if let Some(reason) = now.blind => because(GoAround, reason),
            Commit if past.contact => (Touchdown, None),
            Commit if let Some(reason) = strayed => because(GoAround, reason),
            Commit if now.gust_at_touch => because(GoAround, Reason::Wind),
            Commit if let (true, Some(reason)) = (now.above_commit_height, now.stale) => {
                because(GoAround, reason)
            }
            Commit if now.above_commit_height => (Descend, None),

            Touchdown if past.stop => because(GoAround, Reason::Operator),
            Touchdown if past.confirmed => (Disarmed, None),
            Touchdown if past.unsupported => because(GoAround, Reason::NotSupported),
            Touchdown if past.late => because(GoAround, Reason::Late),
            Touchdown if let (true, Some(reason)) = (past.apart, now.blind) => {
                because(GoAround, reason)
            }
            Touchdown if past.apart => because(Commit, Reason::Bounce),

            GoAround if climbed && now.battery_critical && !past.stop => (Approach, state.reason),
            GoAround if climbed && now.battery_low => because(GivenUp, Reason::BatteryLow),
            GoAround if climbed && past.too_many => (GivenUp, state.reason),
            GoAround if climbed && past.stop => because(Hold, Reason::Operator),
            GoAround if climbed => (Approach, state.reason),

            GivenUp if past.restart => (Approach, None),
            GivenUp if now.battery_critical && now.stale.is_none() && !past.stop => {
                (Approach, state.reason)
            }

            Disarmed if past.restart => (Approach, None),

            stay => (stay, state.reason),
        }
    }

    /// Advances the times for which conditions have held.
    fn remember(
        &self,
        state: &mut MachineState<R>,
        seen: &MachineInput<R>,
        now: &Conditions,
        dt: R,
    ) -> History {
        let dt = usable_dt(dt);
        let gap = dt > self.greatest_step_s;
        state.clock.add(dt);
        state.ready.update(now.unready.is_none(), dt, gap);
        state.touching.update(now.resting, dt, gap);
        state.supported.update(now.supported, dt, gap);
        state
            .evidence
            .update(now.evidence || (state.rocks() && now.slides), dt, gap);
        state.unsupported.update(now.unsupported, dt, gap);
        let down = now.touching || now.held || (state.rocks() && now.low);
        state.apart.update(!down, dt, false);
        state.beyond.update(now.beyond.is_some(), dt, false);
        state.sinking.update(now.sinking, dt, false);
        state.saturated.update(seen.saturated, dt, false);
        state.lost.update(now.stale.is_some(), dt, false);
        state.escaped &= now.stale.is_some();
        let late = match state.phase.stage() {
            Stage::Waiting => {
                state.waited.add(dt);
                state.waited.value() > self.patience_s
            }
            Stage::Landing => state.clock.value() > self.landing_s,
            Stage::Climbing => state.clock.value() > self.climb_s,
            Stage::Ended => false,
        };
        let windy = state.rocks() && seen.wind_slope > r(WINDY_SLOPE);
        let contact_s = if windy {
            self.contact_s * r(WINDY_CONTACT)
        } else {
            self.contact_s
        };
        let past = History {
            stop: seen.request == OperatorRequest::Abort,
            restart: seen.request == OperatorRequest::Restart
                && state.last_request != OperatorRequest::Restart,
            late,
            settled: state.ready.lasts(self.settle_s),
            contact: state.touching.lasts(contact_s) || state.supported.lasts(self.support_s),
            confirmed: state.evidence.lasts(self.confirm_s),
            apart: state.apart.lasts(self.bounce_s),
            unsupported: state.unsupported.lasts(self.fall_s + state.rock_s),
            astray: now.beyond.filter(|_| state.beyond.lasts(self.excess_s)),
            lost: state.lost.lasts(self.escape_s(seen)),
            searched: state.lost.lasts(self.search_s),
            escaped: state.escaped,
            sinks: state.sinking.lasts(self.excess_s),
            too_many: state.go_arounds.descent > self.go_arounds
                || state.go_arounds.wind > self.wind_go_arounds
                || state.go_arounds.hover > self.hover_go_arounds,
        };
        state.last_request = seen.request;
        past
    }

    /// Time without sight of the deck after which a hover climbs, s. Over a rough sea it is at most [`BELATED`] of the time in
    /// which the deck comes up.
    fn escape_s(&self, seen: &MachineInput<R>) -> R {
        let rough_mps = seen.hold_extra_m.finite_or(R::ZERO);
        if rough_mps > R::ZERO {
            let above_m = (seen.height_m - self.touchdown_height_m).max(R::ZERO);
            let strikes_s = above_m / (rough_mps + r(CALM_MPS));
            self.lost_s.min(strikes_s * r(BELATED))
        } else {
            self.lost_s
        }
    }

    /// Whether sight of the deck is lost, and the vehicle has not climbed to safety yet: to `safe_height_m`, or for
    /// `climb_s` where the height is not known.
    fn sinks_blindly(&self, state: &MachineState<R>, now: &Conditions) -> bool {
        now.stale.is_some()
            && !state.escaped
            && !now.safe
            && state.lost.lasts(self.lost_s)
            && !state.lost.lasts(self.lost_s + self.climb_s)
    }

    /// Enters the new phase.
    fn enter(
        &self,
        state: &mut MachineState<R>,
        phase: Phase,
        reason: Option<Reason>,
        stop: bool,
        restart: bool,
    ) {
        let ended = state.phase.stage() == Stage::Ended;
        if phase == Phase::GoAround && state.phase != Phase::GoAround {
            state.escaped = true;
            if reason != Some(Reason::Operator) {
                let descending = state.phase.stage() == Stage::Landing;
                state.go_arounds.count(descending, reason);
            }
        }
        if restart && ended && phase == Phase::Approach {
            state.go_arounds = GoArounds::default();
        }
        // The waiting time does not count while the operator holds the vehicle.
        let held = phase == Phase::Hold && stop;
        if phase.stage() != state.phase.stage() || held {
            state.clock = Sum::default();
        }
        if held || matches!(phase.stage(), Stage::Landing | Stage::Ended) {
            state.waited = Sum::default();
        }
        state.phase = phase;
        state.reason = reason;
    }
}
