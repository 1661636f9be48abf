//! Conditions of the table of transitions, from the input of a step.

use super::{Funnel, MachineInput, Reason, StateMachine};
use crate::control::WINDY_SLOPE;
use touchdown_flight::real::{Real, r};

/// Conditions that follow from one input, without memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Conditions {
    /// Why height and velocity above the deck are not known.
    pub(super) blind: Option<Reason>,
    /// `blind`, or the tag is lost.
    pub(super) stale: Option<Reason>,
    /// Why a descent may not begin.
    pub(super) unready: Option<Reason>,
    /// The first limit of the vehicle's motion that is exceeded.
    pub(super) beyond: Option<Reason>,
    /// The closing speed exceeds its limit; false while the speed is not known.
    pub(super) sinking: bool,
    /// The wind pushes harder than friction holds, in a descent.
    pub(super) gust: bool,
    /// A gust, just before the touch, that can be waited out: another descent comes soon, which it does not over a rough sea.
    pub(super) gust_at_touch: bool,
    /// The deck is not within its limits.
    pub(super) rough_deck: bool,
    pub(super) battery_low: bool,
    pub(super) battery_critical: bool,
    pub(super) at_hold_height: bool,
    pub(super) over_pad: bool,
    pub(super) at_commit_height: bool,
    /// The height is known, and at most the commit height.
    pub(super) sunk: bool,
    pub(super) above_commit_height: bool,
    /// The vehicle is at or above the hover height.
    pub(super) up: bool,
    /// The height is known, and at least `safe_height_m`.
    pub(super) safe: bool,
    pub(super) touching: bool,
    /// Touching, or as low at up to twice the speeds of a touchdown.
    pub(super) resting: bool,
    /// The lowest foot is as low as on the deck, at any speed.
    pub(super) low: bool,
    /// The legs feel the deck, at a height and speed of a touchdown.
    pub(super) supported: bool,
    pub(super) evidence: bool,
    /// At rest on the legs at an idle thrust, whatever the estimated velocity.
    pub(super) held: bool,
    /// Evidence while the vehicle slides on its feet.
    pub(super) slides: bool,
    pub(super) unsupported: bool,
}

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Slope beyond its limit at which a descent is aborted: a gust of 1.5 m/s at 12 m/s. Halved, most descents
/// at 10 m/s are aborted; doubled, gusts that push the vehicle off the deck are landed in.
const GUST_SLOPE: f64 = 0.08;

/// Height above that of a touchdown up to which a vehicle that the deck carries stands on it, m: what the inertial unit alone errs in
/// half a second on a deck that accelerates by 0.4 m/s² otherwise than expected. Other values were not measured. Not in wind: a vehicle that
/// leans is carried by one foot first, and falls onto the others (6 of 200 crash on a car at 10 m/s instead of 1).
const HELD_M: f64 = 0.05;

/// Force of the deck over `support_share` that counts as contact at any estimated velocity: below 0.2 m the tag is out of view, and a deck
/// that sways was estimated to move by up to 0.5 m/s otherwise. Other values were not measured. Not in wind, where a vehicle
/// that leans presses with one foot before it is down; 200 landings on a car at 10 m/s are the same with it.
const PRESSED: f64 = 4.0;

/// Thrust over weight at which the rotors stop in any attitude: attitude control then has hardly any torque, so that waiting longer
/// sets no foot down more softly. Other values were not measured.
const ALMOST_OFF: f64 = 0.1;

/// `value` lies in [0, limit]; NaN does not.
fn up_to<R: Real>(value: R, limit: R) -> bool {
    value >= R::ZERO && value <= limit
}

/// The first reason that is not excluded.
fn first(reasons: &[(bool, Reason)]) -> Option<Reason> {
    reasons
        .iter()
        .find_map(|&(bad, reason)| bad.then_some(reason))
}

impl<R: Real> MachineInput<R> {
    /// The estimate of the vehicle's state is finite.
    fn is_known(&self) -> bool {
        let estimates = [
            self.height_m,
            self.foot_drop_m,
            self.relative_velocity_mps,
            self.lateral_error_m,
            self.lateral_speed_mps,
            self.tilt_rad,
        ];
        estimates.iter().all(|value| value.is_finite())
    }

    /// No wind into which the vehicle leans down to the deck.
    fn in_calm(&self) -> bool {
        self.wind_slope.abs() <= r(WINDY_SLOPE)
    }

    /// Whether the deck's motion is known.
    fn knows_deck(&self) -> bool {
        self.deck_tilt_rad.is_finite() && self.deck_speed_mps.is_finite()
    }

    /// Whether all numbers but the ages and those of the deck are finite.
    fn is_finite(&self) -> bool {
        let others = [
            self.hold_extra_m,
            self.wind_slope,
            self.battery_share,
            self.thrust_share,
            self.load_factor,
        ];
        self.is_known() && others.iter().all(|value| value.is_finite())
    }
}

impl<R: Real> StateMachine<R> {
    // Conditions that let a landing go on are written so that NaN fails them.
    pub(super) fn conditions(&self, seen: &MachineInput<R>) -> Conditions {
        let blind = self.blind(seen);
        let stale = blind.or((!up_to(seen.tag_age_s, self.tag_age_s)).then_some(Reason::TagLost));
        let height_m = seen.height_m;
        let within = |value: R, funnel: Funnel<R>| value <= funnel.at(height_m);
        let closing_mps = -seen.relative_velocity_mps;
        let beyond = first(&[
            (!up_to(seen.tilt_rad.abs(), self.tilt_rad), Reason::Tilt),
            (
                !within(seen.lateral_error_m.abs(), self.lateral_m),
                Reason::LateralError,
            ),
            (!within(closing_mps, self.closing_mps), Reason::ClosingSpeed),
        ]);
        let rough_deck = !(seen.deck_tilt_rad.abs() <= self.deck_tilt_rad
            && seen.deck_speed_mps.abs() <= self.deck_speed_mps);
        let windy = !(seen.wind_slope.abs() <= self.wind_slope);
        let battery_critical = seen.battery_share <= self.battery_critical;
        let battery_low = !battery_critical && !(seen.battery_share > self.battery_low);
        let height_error_m = height_m - self.hold_height_m(seen);
        // From higher up there is more way to correct an error.
        let wider = R::ONE + seen.hold_extra_m.max(R::ZERO);
        let hold_tolerance_m = wider * self.hold_tolerance_m;
        let slow = |speed_mps: R| speed_mps <= wider * self.hold_speed_mps;
        let at_hold_height = height_error_m.abs() <= hold_tolerance_m;
        let over_pad = seen.lateral_error_m.abs() <= wider * self.hold_lateral_m;
        let steady = slow(seen.relative_velocity_mps.abs()) && slow(seen.lateral_speed_mps);
        let unready = stale.or(beyond).or(first(&[
            (!seen.is_finite(), Reason::NotFinite),
            (!seen.knows_deck(), Reason::Deck),
            (!at_hold_height, Reason::Height),
            (!over_pad, Reason::LateralError),
            (!steady, Reason::Unsteady),
            (seen.saturated, Reason::Saturated),
            (rough_deck && !battery_critical, Reason::Deck),
            (windy && !battery_critical, Reason::Wind),
            (battery_low, Reason::BatteryLow),
        ]));

        let [soft, resting, supported] = self.on_deck(seen, blind.is_none());
        let touching = supported || soft;
        let low = blind.is_none() && self.as_low(seen, self.support_margin_m);
        let may_wait = !(low || battery_low || battery_critical) && seen.hold_extra_m <= R::ZERO;
        let slides = low
            && seen.relative_velocity_mps.abs() <= r::<R>(2.0) * self.touchdown_speed_mps
            && seen.lateral_speed_mps.is_finite();
        let idle = seen.thrust_share <= self.idle_thrust_share;
        let carried = idle && seen.load_factor >= self.carried_load_factor(seen);
        let felt = self.is_down(seen) && (carried || seen.contact == Some(true));
        let held = carried && seen.in_calm() && blind.is_none() && self.as_low(seen, r(HELD_M));
        Conditions {
            blind,
            stale,
            unready,
            beyond,
            sinking: closing_mps > self.closing_mps.at(height_m),
            gust: seen.wind_slope.abs() > self.wind_slope + r(GUST_SLOPE),
            gust_at_touch: may_wait && seen.gusty,
            rough_deck,
            battery_low,
            battery_critical,
            at_hold_height,
            over_pad,
            sunk: blind.is_none() && height_m <= self.commit_height_m,
            at_commit_height: height_m <= self.commit_height_m,
            above_commit_height: height_m > self.commit_height_m + self.commit_margin_m,
            safe: blind.is_none() && height_m >= self.safe_height_m.max(self.hold_height_m(seen)),
            up: stale.is_none() && height_error_m >= -hold_tolerance_m,
            touching,
            resting: touching || (resting && seen.foot_drop_m > self.leaning_m),
            low,
            supported,
            slides: slides && felt,
            held,
            evidence: (held && self.is_down(seen)) || (touching && felt),
            unsupported: idle
                && seen.load_factor < self.supported_load_factor
                && seen.contact != Some(true),
        }
    }

    /// Why height and velocity above the deck are not known.
    fn blind(&self, seen: &MachineInput<R>) -> Option<Reason> {
        let tag_lost = !up_to(seen.tag_age_s, self.tag_age_s);
        let range_lost = !up_to(seen.range_age_s, self.range_age_s);
        // Range or tag gives the height; without both, the IMU carries it on for a while.
        let unmeasured = tag_lost && range_lost && !up_to(seen.height_sd_m, self.coast_sd_m);
        first(&[
            (!seen.is_known(), Reason::NotFinite),
            (
                seen.diverged,
                if tag_lost {
                    Reason::TagLost
                } else {
                    Reason::Diverged
                },
            ),
            (!up_to(seen.imu_age_s, self.imu_age_s), Reason::ImuStale),
            (unmeasured, Reason::RangeStale),
        ])
    }

    /// Whether the rotors may stop: a vehicle that leans on one foot would fall onto the others.
    fn is_down(&self, seen: &MachineInput<R>) -> bool {
        seen.foot_drop_m <= self.leaning_m || seen.thrust_share <= r(ALMOST_OFF)
    }

    /// Load factor from which something else than the rotors carries the vehicle. It is less where the rotors hardly turn, because a
    /// shaking deck carries a standing vehicle now more, now less.
    fn carried_load_factor(&self, seen: &MachineInput<R>) -> R {
        if seen.thrust_share <= r(ALMOST_OFF) {
            self.supported_load_factor - self.idle_thrust_share + seen.thrust_share
        } else {
            self.supported_load_factor
        }
    }

    /// Height of the hover over this deck, m.
    pub(super) fn hold_height_m(&self, seen: &MachineInput<R>) -> R {
        self.hold_height_m + seen.hold_extra_m.finite_or(R::ZERO).max(R::ZERO)
    }

    /// Whether the lowest foot is as low as in a touchdown, within a margin, and no switch denies contact.
    fn as_low(&self, seen: &MachineInput<R>, margin_m: R) -> bool {
        seen.contact != Some(false)
            && seen.height_m - seen.foot_drop_m <= self.touchdown_height_m + margin_m
    }

    /// Whether height and speed are those of a touchdown, those of one in gusts, and whether
    /// the legs feel the deck besides.
    fn on_deck(&self, seen: &MachineInput<R>, seeing: bool) -> [bool; 3] {
        let within = |margin_m: R, times: R, aside: R| {
            seeing
                && self.as_low(seen, margin_m)
                && seen.relative_velocity_mps.abs() <= times * self.touchdown_speed_mps
                && seen.lateral_speed_mps.abs() <= aside * self.touchdown_lateral_mps
        };
        let low = within(R::ZERO, R::ONE, R::ONE);
        // Less force is needed where height and speed agree with it.
        let twice = r::<R>(2.0);
        let supported = (low && seen.support_share >= self.support_share)
            || (within(self.support_margin_m, twice, R::ONE)
                && seen.support_share >= twice * self.support_share)
            || (seen.in_calm()
                && within(r(HELD_M), r(f64::INFINITY), r(f64::INFINITY))
                && seen.support_share >= r::<R>(PRESSED) * self.support_share);
        [low, within(R::ZERO, twice, twice), supported]
    }
}
