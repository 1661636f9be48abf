//! Touchdown, crash or miss, judged by the true state, for single landings and SIMD lanes.

use touchdown_flight::touch::TouchClass;

use super::landing::SpaceLander;
use super::outcome::{CrashCause, Impact, SpaceLanding, SpaceOutcome, Touch};
use super::scenario::SpaceScenario;
use crate::body::contact::ContactLog;

/// Distance from the deck's centre within which the deck's plane decides on a miss, m: what a vehicle can be beside a plate
/// and still land on it. Halved or doubled, only flights from afar are judged otherwise.
const BESIDE_M: f64 = 5.0;
/// Slope of the steepest deck.
const STEEPEST: f64 = 0.3;

/// State of a vehicle relative to the deck after a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeckState {
    /// Place relative to the deck's centre, along its axes, m.
    pub(super) place_m: [f64; 3],
    /// Velocity relative to the deck, along its axes, m/s.
    pub(super) velocity_mps: [f64; 3],
    /// Velocity along the deck's normal before the step, m/s.
    pub(super) before_mps: f64,
    /// Tilt from the deck's normal, rad; needed near the deck only.
    pub(super) tilt_rad: f64,
}

/// Judges a landing by its contacts with the deck.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TouchdownJudge {
    pub(super) log: ContactLog,
    /// Feet on the deck at the step before.
    were_down: u32,
    impact: Option<Impact>,
}

impl TouchdownJudge {
    /// Whether a foot is on the deck, or the vehicle is at or below the landed height.
    pub(super) fn is_near(&self, lander: &SpaceLander, place_m: [f64; 3]) -> bool {
        self.log.feet_down > 0 || lander.has_come_down(place_m)
    }

    /// Whether the landing ends in this step, whose contacts [`Self::log`] has recorded.
    pub(super) fn judge(
        &mut self,
        scenario: &SpaceScenario,
        now: &DeckState,
    ) -> Option<SpaceOutcome> {
        let crash = &scenario.crash;
        let crashed = |cause| Some(SpaceOutcome::Crashed { cause });
        let down = self.log.feet_down > 0;
        if down {
            // The speed before the legs slowed the vehicle, of each foot that comes down, and that of a crash in any case.
            let crashes = crash.class(-now.before_mps) == TouchClass::Crash;
            let comes_down = self.log.feet_down > self.were_down;
            let speed_mps = if comes_down || crashes {
                (-now.before_mps).max(0.0)
            } else {
                0.0
            };
            let so_far = self.impact.unwrap_or(Impact {
                speed_mps: 0.0,
                tilt_rad: 0.0,
            });
            self.impact = Some(Impact {
                speed_mps: so_far.speed_mps.max(speed_mps),
                tilt_rad: so_far.tilt_rad.max(now.tilt_rad),
            });
        }
        self.were_down = self.log.feet_down;
        if down && crash.class(-now.before_mps) == TouchClass::Crash {
            return crashed(CrashCause::Speed);
        }
        if self.log.tipped_s.is_some() {
            return Some(SpaceOutcome::TippedOver);
        }
        if down && now.tilt_rad > crash.tilt_rad {
            return crashed(CrashCause::Tilt);
        }
        if self.log.fell_s.is_some() {
            return crashed(CrashCause::FellOff);
        }
        let [x, y, z] = now.place_m;
        // The plane of a deck that leans is no height far from it.
        let leans_m = STEEPEST * (x.hypot(y) - BESIDE_M).max(0.0);
        if z < scenario.landed_height_m - 0.15 - leans_m {
            return crashed(CrashCause::Missed);
        }
        None
    }

    /// The outcome of a landing whose rotors stopped `since` steps ago, once it has been watched for `watch` steps. A deck that
    /// drops away from a vehicle at rest unloads its feet for a moment, so it is watched as long again for three of them.
    pub(super) fn settled(&self, attempts: u32, since: u64, watch: u64) -> Option<SpaceOutcome> {
        if since < watch {
            return None;
        }
        if self.log.feet_down >= 3 {
            return Some(SpaceOutcome::Landed { attempts });
        }
        (since >= 2 * watch).then_some(SpaceOutcome::Crashed {
            cause: CrashCause::StoppedInAir,
        })
    }

    /// Writes outcome, times and impact into a landing.
    pub(super) fn enter(&self, landing: &mut SpaceLanding) {
        landing.bounces = self.log.bounces;
        landing.slide_m = self.log.slide_m;
        landing.greatest_foot_n = self.log.greatest_normal_n;
        landing.impact = self.impact;
    }
}

impl DeckState {
    /// A touch in a step that ends at `time_s`, after `t_l_s` and a path of `path_m` since the start of the descent.
    pub(super) fn touch(&self, time_s: f64, t_l_s: f64, path_m: f64) -> Touch {
        let ([x, y, _], [u, v, _]) = (self.place_m, self.velocity_mps);
        Touch {
            time_s,
            t_l_s,
            // The speed before the legs slowed the vehicle.
            v_l_mps: self.before_mps.abs(),
            s_l_m: path_m,
            tilt_rad: self.tilt_rad,
            lateral_m: x.hypot(y),
            lateral_mps: u.hypot(v),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A vehicle at a speed towards the deck before the step, tilted.
    fn standing(sinking_mps: f64, tilt_rad: f64) -> DeckState {
        DeckState {
            place_m: [0.3, -0.4, 0.2],
            velocity_mps: [0.05, 0.12, -0.1],
            before_mps: -sinking_mps,
            tilt_rad,
        }
    }

    /// The outcome of the last of several steps, each with its feet on the deck, and the impact of them all.
    fn judged(steps: &[(u32, DeckState)]) -> (Option<SpaceOutcome>, Option<Impact>) {
        let scenario = SpaceScenario::default();
        let mut touching = TouchdownJudge::default();
        let mut outcome = None;
        for (feet, now) in steps {
            touching.log.feet_down = *feet;
            outcome = touching.judge(&scenario, now);
        }
        (outcome, touching.impact)
    }

    #[test]
    fn prop_an_impact_is_the_hardest_step_in_which_a_foot_comes_down() {
        let of = |speed_mps, tilt_rad| {
            Some(Impact {
                speed_mps,
                tilt_rad,
            })
        };
        let air = (0, standing(0.9, 0.3));
        assert_eq!(judged(&[air]), (None, None));
        // The air does not count, nor a step in which no foot comes down, but for its tilt.
        let touch = (1, standing(0.2, 0.01));
        let sinking = (1, standing(0.4, 0.05));
        assert_eq!(judged(&[air, touch, sinking]), (None, of(0.2, 0.05)));
        // The fall onto further feet counts, one foot that leaves the deck does not.
        let further = (3, standing(0.35, 0.02));
        let leaves = (2, standing(0.38, 0.02));
        let fall = [air, touch, sinking, further, leaves];
        assert_eq!(judged(&fall), (None, of(0.35, 0.05)));
        // A bounce is a separate contact. A rising vehicle has no speed towards the deck.
        let bounce = (1, standing(0.3, 0.02));
        let all = [touch, sinking, air, bounce];
        assert_eq!(judged(&all), (None, of(0.3, 0.05)));
        assert_eq!(judged(&[(1, standing(-0.2, 0.0))]), (None, of(0.0, 0.0)));
        // A crash has its speed, with a foot that comes down or without.
        let fast = SpaceScenario::default().crash.speed_mps + 0.01;
        let crash = Some(SpaceOutcome::Crashed {
            cause: CrashCause::Speed,
        });
        assert_eq!(
            judged(&[touch, (1, standing(fast, 0.01))]),
            (crash, of(fast, 0.01))
        );
    }

    #[test]
    fn prop_crashes_need_a_foot_on_the_deck_but_where_there_is_none_to_come() {
        let crash = SpaceScenario::default().crash;
        let crashed = |cause| Some(SpaceOutcome::Crashed { cause });
        let (fast, tilted) = (crash.speed_mps + 0.01, crash.tilt_rad + 0.01);
        let said = |feet, now: DeckState| judged(&[(feet, now)]).0;
        assert_eq!(said(0, standing(fast, tilted)), None);
        assert_eq!(said(1, standing(fast, tilted)), crashed(CrashCause::Speed));
        assert_eq!(said(1, standing(0.0, tilted)), crashed(CrashCause::Tilt));
        let mut below = standing(0.0, 0.0);
        below.place_m[2] = SpaceScenario::default().landed_height_m - 0.16;
        assert_eq!(said(0, below), crashed(CrashCause::Missed));
        let mut touching = TouchdownJudge::default();
        touching.log.feet_down = 2;
        assert_eq!(touching.settled(2, 399, 200), None);
        let in_air = crashed(CrashCause::StoppedInAir);
        assert_eq!(touching.settled(2, 400, 200), in_air);
        touching.log.feet_down = 3;
        let landed = Some(SpaceOutcome::Landed { attempts: 2 });
        assert_eq!(touching.settled(2, 199, 200), None);
        assert_eq!(touching.settled(2, 200, 200), landed);
    }

    #[test]
    fn analytic_a_touch_tells_the_standing() {
        // Sides of 3 : 4 : 5 and 5 : 12 : 13, rounded once or twice.
        let touch = standing(0.25, 0.03).touch(9.0, 2.0, 0.7);
        assert!((touch.lateral_m - 0.5).abs() < 1e-15);
        assert!((touch.lateral_mps - 0.13).abs() < 1e-15);
        assert_eq!((touch.time_s, touch.t_l_s, touch.s_l_m), (9.0, 2.0, 0.7));
        assert_eq!((touch.v_l_mps, touch.tilt_rad), (0.25, 0.03));
    }
}
