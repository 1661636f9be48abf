//! A step of the landing computer.

mod level;
mod sensing;

use crate::computer::support::Support;
use crate::computer::{Computer, ComputerOutput, ComputerState, Descent, Sensed};
use crate::estimate::deck::DeckMotionPrediction;
use crate::estimate::relative::{Health, RelativeEstimate};
use crate::guidance::GuidanceCommand;
use crate::planner::{DeckOutlook, Plan};
use crate::space_controller::{Motion, SpaceCommand, SpaceControllerState, Target};
use crate::state_machine::{Frame, MachineInput, Maneuver, Phase};
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::{Reference, Terminal};
use touchdown_flight::space::{Attitude, Vector};

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Time from the start after which the vehicle's own velocity suffices to control it, s: several
/// readings of every sensor. In that time a wind that changes by 1 m/s moves it by 5 cm. Halved, a deck
/// that is seen late is not followed from the start; doubled, gusts push the vehicle farther.
pub(super) const BLIND_START_S: f64 = 0.5;
/// Age of the tag up to which it corrects the velocity, where no satellites do, s.
const CORRECTED_S: f64 = 0.3;

/// Time without a sample of the inertial unit after which velocities are no longer followed, s: an acceleration that was
/// held for it is wrong by 1 m/s², the velocity by 0.3 m/s, as much as a known one may be. Until then a gap is bridged.
const UNFELT_S: f64 = 0.3;

/// Thrust over the weight that such a vehicle gets, and for how long, s: with errors of the thrust of 3 % it still rises, by 1.0
/// to 2.2 m (without drag), rather than sinks onto a deck that it does not feel.
const RISE_SHARE: f64 = 1.08;
const RISE_S: f64 = 2.0;

/// What the computer knows of its motion.
#[derive(Clone, Copy)]
struct Knowledge<R> {
    /// Position and velocity relative to the deck are known.
    position: bool,
    /// The vehicle's own velocity is known.
    velocity: bool,
    /// Time since the last tag arrived, over what the height allows, s. Its latency does not count: it is known, or was found, and the
    /// estimate's uncertainty has it.
    tag_age_s: R,
    /// Age of the last sample of the inertial unit, s.
    unfelt_s: R,
}

/// Whether readings correct the velocity.
#[inline]
fn is_corrected<R: Real>(health: &Health<R>) -> bool {
    health.gnss.fresh || health.tag.age_s <= r(CORRECTED_S)
}

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// One control period of `dt` seconds: from the readings at its beginning to the
    /// command for its duration.
    pub fn step(
        &self,
        state: &mut ComputerState<R, G::State>,
        sensed: &Sensed<'_, R>,
        dt: R,
    ) -> ComputerOutput<R> {
        let dt = usable_dt(dt);
        let mistimed = self.estimate(state, sensed, dt);
        let estimate = self.relative.ahead(&state.relative, self.imu_latency_s);
        let health = self.relative.health(&state.relative);
        let knowledge = self.knowledge(state, &estimate, &health);
        let attitude = self.relative.attitude_at(&state.relative, R::ZERO);
        let motion = self.motion(&estimate, attitude, state.normal);
        self.watch_weather(state, (&estimate, is_corrected(&health)), attitude, dt);
        self.watch_consistency(state, &health, dt);

        let deck = self.forecast_deck(state, &estimate);
        let (plan, reference) = self.plan(state, &motion, dt);
        let deck_speed_mps = self.greatest_deck_speed(state, &deck, &estimate);
        let weight_n = self.controller.mass_kg * self.controller.gravity_mps2;
        let seen = MachineInput {
            tag_age_s: knowledge.tag_age_s,
            range_age_s: health.range.age_s,
            imu_age_s: health.imu.age_s,
            diverged: !knowledge.position || health.diverged || mistimed,
            height_m: motion.position_m.z,
            foot_drop_m: motion.position_m.z - self.feet_height_m(&motion),
            height_sd_m: estimate.position_sd_m.z,
            relative_velocity_mps: motion.relative_velocity_mps.z,
            lateral_error_m: self.off_axis_m(state, &motion),
            lateral_speed_mps: motion.relative_velocity_mps.horizontal().norm(),
            tilt_rad: self.tilt_beside_trim_rad(state, attitude),
            saturated: state.command.saturated || state.command.limited,
            deck_tilt_rad: state.tilt_rad,
            deck_speed_mps,
            wind_slope: self.wind_slope(state),
            gusty: self.is_gusty(state, &health),
            hold_extra_m: self.hold_extra_m(state, deck_speed_mps, motion.position_m.z, dt),
            battery_share: sensed.battery_share,
            thrust_share: state.demand_n() / weight_n,
            load_factor: sensed.imu.specific_force_mps2.z / self.controller.gravity_mps2,
            support_share: state
                .support
                .share(self.state_machine.support_share, weight_n),
            contact: sensed.contact,
            go: !state.may_be_late && reference.is_some(),
            request: sensed.request,
        };
        let descended = state.state_machine.phase() == Phase::Descend;
        let state_machine = self.state_machine.step(&mut state.state_machine, &seen, dt);
        state.hurry = state_machine.hurry;
        let begins = state_machine.phase == Phase::Descend && !descended;
        state.carried_over &= !knowledge.position || health.diverged;
        self.restart_diverged(state, &health, state_machine.phase, dt);

        let (command, target) = self.fly(
            state,
            state_machine.maneuver,
            reference,
            (&motion, &estimate),
            knowledge,
            dt,
        );
        let controller = state.controller.as_ref();
        let disturbance_n = controller.map_or(Vector::ZERO, |state| state.disturbance_n);
        state.command = command.unwrap_or_default();
        self.feel_support(state, &motion, dt);
        ComputerOutput {
            command,
            state_machine,
            estimate,
            health,
            deck,
            plan: plan.filter(|_| begins),
            latency_s: state.latency.latency_s(),
            target,
            disturbance_n,
        }
    }

    /// Estimates the force of the deck on the legs.
    fn feel_support(&self, state: &mut ComputerState<R, G::State>, motion: &Motion<R>, dt: R) {
        match &state.controller {
            Some(controller) => {
                let unexplained_n = self.controller.unexplained_n(controller, motion);
                let above_contact_m = self.feet_height_m(motion) - self.contact_height_m;
                state.support.step(unexplained_n.z, above_contact_m, dt);
            }
            None => state.support = Support::default(),
        }
    }

    /// What is known now; from the next step on the barometer counts accordingly.
    fn knowledge(
        &self,
        state: &mut ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
        health: &Health<R>,
    ) -> Knowledge<R> {
        state.needs_barometer = self.needs_barometer(state, estimate);
        let wider = self.wider(estimate, health);
        state.wider = wider;
        let tag_age_s = self.relative.tag_silent_s(&state.relative) / wider;
        // Who has lost the tag knows less and less, and flies in the world's frame all the longer.
        let seen = tag_age_s <= self.state_machine.tag_age_s;
        Knowledge {
            position: self.knows_enough(state, estimate, if seen { wider } else { R::ONE }),
            velocity: self.moves_known(estimate),
            tag_age_s,
            unfelt_s: health.imu.age_s,
        }
    }

    /// Flies a manoeuvre, or the hover of a vehicle that does not know its motion.
    ///
    /// After the controller has started, velocities suffice; so they do where the deck is not
    /// seen at the start. The state machine gets the report that the position is not known and
    /// orders a flight in the world's frame (in touchdown it holds or reduces the thrust). Of that flight the vertical part is flown
    /// also by a vehicle that knows no more than how fast it climbs.
    fn fly(
        &self,
        state: &mut ComputerState<R, G::State>,
        maneuver: Maneuver<R>,
        reference: Option<Reference<R>>,
        (motion, estimate): (&Motion<R>, &RelativeEstimate<R>),
        knowledge: Knowledge<R>,
        dt: R,
    ) -> (Option<SpaceCommand<R>>, Option<Target<R>>) {
        state.flown_s += dt;
        let started = state.controller.is_some() || state.flown_s > r(BLIND_START_S);
        let known = knowledge.position || (started && knowledge.velocity);
        let felt = knowledge.unfelt_s <= r(UNFELT_S);
        let sought = if known && felt {
            self.seek(state, estimate, motion, dt)
        } else {
            None
        };
        if let Some(target) = sought {
            self.fly_to(state, motion, target, dt)
        } else if (known && felt) || maneuver == Maneuver::Disarm {
            self.act(state, maneuver, reference.as_ref(), motion, dt)
        } else if started && felt && maneuver.is_in_the_world() && self.climb_known(estimate) {
            self.fly_level(state, maneuver, motion, dt)
        } else {
            let rises = !felt && knowledge.unfelt_s <= r(UNFELT_S + RISE_S);
            (Some(self.hover(state, motion, rises, dt)), None)
        }
    }

    /// The controller with a target that is not the guidance's.
    #[inline(never)]
    fn fly_to(
        &self,
        state: &mut ComputerState<R, G::State>,
        motion: &Motion<R>,
        target: Target<R>,
        dt: R,
    ) -> (Option<SpaceCommand<R>>, Option<Target<R>>) {
        let yaw_rad = self.guidance.interrupt(&mut state.guidance, motion);
        let target = Target { yaw_rad, ..target };
        let controller = self.started(&mut state.controller, motion, state.hover_throttle);
        let command = self.controller.step(controller, motion, &target, dt);
        (Some(command), Some(target))
    }

    /// The controller, which starts with the first target.
    #[inline(never)]
    fn started<'a>(
        &self,
        controller: &'a mut Option<SpaceControllerState<R, G::State>>,
        motion: &Motion<R>,
        throttle: R,
    ) -> &'a mut SpaceControllerState<R, G::State> {
        controller.get_or_insert_with(|| self.controller.initial(motion, throttle))
    }

    /// Guidance and controller.
    #[inline(never)]
    fn act(
        &self,
        state: &mut ComputerState<R, G::State>,
        maneuver: Maneuver<R>,
        reference: Option<&Reference<R>>,
        motion: &Motion<R>,
        dt: R,
    ) -> (Option<SpaceCommand<R>>, Option<Target<R>>) {
        let mut deck_mps2 = if self.deck_acceleration {
            Vector::UP * self.deck_acceleration_ahead(state)
        } else {
            Vector::ZERO
        };
        deck_mps2 += state.course_mps2;
        let flown = match maneuver {
            Maneuver::ClimbAway => self.guidance_away(state, motion),
            _ => self.guidance,
        };
        let guidance = &mut state.guidance;
        let mut order = flown.step(guidance, maneuver, reference, motion, deck_mps2, dt);
        let over_deck = match maneuver {
            Maneuver::Hover { frame, .. } => frame == Frame::Deck,
            maneuver => matches!(maneuver, Maneuver::Descend | Maneuver::Commit),
        };
        if let GuidanceCommand::Track(target) = &mut order {
            if over_deck {
                self.press_on(state, maneuver == Maneuver::Commit, target, dt);
            } else {
                self.keep_course(state, motion, target);
                self.search_upwind(state, target);
            }
        }
        let feet_height_m = self.feet_height_m(motion);
        let low_slope = self.low_slope(state, feet_height_m);
        let may_touch = feet_height_m < self.contact_height_m;
        let lift_rise_s = self.lift_rise_s(state, may_touch);
        if let GuidanceCommand::Idle { rate_n_per_s } = &mut order {
            *rate_n_per_s = *rate_n_per_s / self.idle_slower(state, motion);
        }
        let controller = self.started(&mut state.controller, motion, state.hover_throttle);
        match order {
            GuidanceCommand::Track(mut target) => {
                if over_deck {
                    let above_m = target.vertical.height_m - self.contact_height_m;
                    target.position_m += state.lean * above_m.max(R::ZERO);
                    target.velocity_mps += state.lean * target.vertical.velocity_mps;
                    target.haste = state.sea.haste();
                }
                target.hold_estimates |= may_touch;
                if target.descending {
                    target.low_slope = low_slope;
                    target.lift_rise_s = lift_rise_s;
                }
                let command = self.controller.step(controller, motion, &target, dt);
                (Some(command), Some(target))
            }
            GuidanceCommand::Idle { rate_n_per_s } => {
                let command = self.controller.idle(controller, motion, rate_n_per_s, dt);
                (Some(command), None)
            }
            GuidanceCommand::Off => {
                state.controller = None;
                (None, None)
            }
        }
    }

    /// The deck's acceleration at the time when the rotors act. It is limited to that of
    /// the fastest deck on which the vehicle may land.
    fn deck_acceleration_ahead(&self, state: &ComputerState<R, G::State>) -> R {
        let ahead_s = self.guidance.acting_s + state.sightings.extra_age_s();
        let ahead_mps2 = self.deck.predict_acceleration(&state.deck, ahead_s);
        let fastest_mps = state.sea.harmonics_mps;
        let slowed = (self.state_machine.deck_speed_mps / fastest_mps).finite_or(R::ONE);
        state.sea.plausible_mps2(ahead_mps2) * slowed.min(R::ONE)
    }

    /// In the trim attitude, at the thrust that has held the height so far, or at the `W cos α` that holds it there: drag acts in the
    /// rotors' plane. With a little more thrust to rise.
    #[inline(never)]
    fn hover(
        &self,
        state: &mut ComputerState<R, G::State>,
        motion: &Motion<R>,
        rises: bool,
        dt: R,
    ) -> SpaceCommand<R> {
        let trim = state.trim_up;
        let share = if rises { r(RISE_SHARE) } else { R::ONE };
        let weight_n = self.controller.mass_kg * self.controller.gravity_mps2;
        let learned_n = state.steady.learned_n(self.controller.mass_kg);
        let holding_n = match learned_n {
            Some(steady_n) => (weight_n - steady_n.z) / trim.z,
            None => weight_n * trim.z,
        };
        let thrust_n = share * holding_n;
        let yaw_rad = motion.attitude.yaw_rad();
        let attitude = Attitude::from_thrust_direction(trim, yaw_rad)
            .unwrap_or_else(|| Attitude::from_yaw(yaw_rad));
        let command = SpaceCommand {
            thrust_n,
            throttle: self.controller.thrust.throttle_for(thrust_n),
            attitude,
            ..SpaceCommand::default()
        };
        if let Some(controller) = &mut state.controller {
            controller.disturbance_n = learned_n.unwrap_or(controller.disturbance_n);
            self.controller.follow(controller, motion, &command, dt);
        }
        command
    }

    /// The predicted motion of the deck.
    pub(in crate::computer) fn deck_ahead(
        &self,
        state: &ComputerState<R, G::State>,
        ahead_s: R,
    ) -> DeckMotionPrediction<R> {
        let extra_age_s = state.sightings.extra_age_s();
        self.deck.predict(&state.deck, ahead_s + extra_age_s)
    }

    /// Greatest expected speed of the deck, m/s: the sum over all harmonics, or two
    /// standard deviations before a harmonic is known; at least the present estimate.
    fn greatest_deck_speed(
        &self,
        state: &ComputerState<R, G::State>,
        now: &DeckMotionPrediction<R>,
        estimate: &RelativeEstimate<R>,
    ) -> R {
        let least = self.heaves_mps(state, estimate);
        if state.deck.count() == 0 {
            return least.max(r::<R>(2.0) * now.velocity_sd_mps);
        }
        least
            .max(state.sea.harmonics_mps)
            .max(now.velocity_mps.abs())
    }

    /// The descent to fly if one begins now.
    #[inline(never)]
    fn plan(
        &self,
        state: &mut ComputerState<R, G::State>,
        motion: &Motion<R>,
        dt: R,
    ) -> (Option<Plan<R>>, Option<Reference<R>>) {
        // The descent is that of the lowest foot in the trim attitude.
        let drop_m = self.trim_drop_m(state, motion);
        let height_m = motion.position_m.z;
        let raised = |reference: Reference<R>| reference.raised_by(drop_m);
        let is_watched = state.deck.observed_s() >= self.watch_s;
        match &self.descent {
            Descent::Straight(_) if !is_watched => (None, None),
            Descent::Straight(reference) => {
                let reference = raised(reference.starting_at(height_m - drop_m));
                (None, reference.validate().is_ok().then_some(reference))
            }
            Descent::Planned(planner) => {
                let phase = state.state_machine.phase();
                if phase != Phase::Wait {
                    // A hold between two waits does not reset the waiting time.
                    if phase == Phase::Hold {
                        state.planner.restart_scan();
                    } else {
                        state.planner.restart();
                    }
                    state.since_plan_s = R::ZERO;
                    return (None, None);
                }
                state.since_plan_s += dt;
                let (tilt_rad, extra_age_s) = (state.tilt_rad, state.sightings.extra_age_s());
                let forecast = |ahead_s: R| {
                    let heave = self.deck.predict_motion(&state.deck, ahead_s + extra_age_s);
                    DeckOutlook::from_heave(&heave, tilt_rad, R::ZERO)
                };
                let period_s = self.planner_period_s;
                let left_s = (period_s - state.since_plan_s).max(R::ZERO);
                let complete = planner.scan(&mut state.planner, &forecast, left_s, dt, period_s);
                if !complete || state.since_plan_s < period_s {
                    return (None, None);
                }
                let waited_s = state.since_plan_s;
                state.since_plan_s = R::ZERO;
                if !is_watched {
                    state.planner.restart_scan();
                    return (None, None);
                }
                let verdict = planner.step(
                    &mut state.planner,
                    height_m - drop_m,
                    state.hurry,
                    &forecast,
                    waited_s,
                );
                let plan = verdict.plan();
                let windy_mps = self.windy_sink_mps(state, planner.descent.sink_rate_max_mps);
                let faster_mps = windy_mps + self.moving_sink_mps(state, windy_mps);
                let reference = plan.map(|plan| {
                    let sink_rate_mps = plan.reference.sink_rate_mps + faster_mps;
                    raised(Reference::Terminal(Terminal {
                        sink_rate_mps,
                        ..plan.reference
                    }))
                });
                (plan, reference)
            }
        }
    }
}

#[cfg(test)]
mod tests;
