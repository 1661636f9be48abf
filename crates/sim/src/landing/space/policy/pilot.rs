//! A policy in the place of the landing computer's controller.

use touchdown_flight::Attitude;
use touchdown_lander::computer::{Computer, ComputerOutput};
use touchdown_lander::space_controller::SpaceCommand;
use touchdown_lander::state_machine::Maneuver;

use super::action::CommandKind;
use super::network::Policy;
use super::observation::Observation;

/// A policy during a landing.
#[derive(Debug)]
pub(in super::super) struct Pilot<'a> {
    policy: &'a Policy,
    weight_n: f64,
    /// Steps of the landing computer between two decisions.
    steps: u64,
    /// Steps for which the last decision holds yet.
    left: u64,
    /// Thrust, and attitude or rates; none where the observation was not finite.
    command: Option<[f64; 5]>,
}

/// What a policy asks for.
pub(in super::super) struct PolicyCommand {
    pub(in super::super) command: SpaceCommand<f64>,
    /// Rates about body axes in the place of the attitude, rad/s.
    pub(in super::super) rates: Option<[f64; 3]>,
}

impl<'a> Pilot<'a> {
    pub(in super::super) fn new(
        policy: &'a Policy,
        computer: &Computer<f64>,
        period_s: f64,
    ) -> Self {
        Self {
            policy,
            weight_n: computer.controller.mass_kg * computer.controller.gravity_mps2,
            steps: (policy.settings().decision_s / period_s).round() as u64,
            left: 0,
            command: None,
        }
    }

    /// The policy's command while the landing computer descends towards a target; what the computer asks for stands in all other
    /// phases, and while it does not know its motion. Where an observation is not finite at a decision, the computer's command
    /// stands until one is.
    pub(in super::super) fn command(
        &mut self,
        output: &ComputerOutput<f64>,
        computer: &Computer<f64>,
        observe: impl FnOnce() -> Observation,
    ) -> Option<PolicyCommand> {
        let descends = matches!(
            output.state_machine.maneuver,
            Maneuver::Descend | Maneuver::Commit
        );
        if !descends || output.target.is_none() {
            self.left = 0;
            return None;
        }
        let seen = observe();
        if self.left == 0 {
            self.command = self.decide(&seen.numbers());
            self.left = self.command.map_or(1, |_| self.steps);
        }
        self.left -= 1;
        let [thrust_n, turn @ ..] = self.command?;
        let (attitude, rates) = match self.policy.settings().action.kind.command() {
            CommandKind::Attitude => (turn, None),
            CommandKind::Rates => (seen.attitude, Some([turn[0], turn[1], turn[2]])),
        };
        let controller = &computer.controller;
        let thrust_n = controller.limits.thrust(thrust_n);
        Some(PolicyCommand {
            command: SpaceCommand {
                thrust_n,
                throttle: controller.thrust.throttle_for(thrust_n),
                attitude: Attitude::from_quaternion(attitude)?,
                ..SpaceCommand::default()
            },
            rates,
        })
    }

    fn decide(&self, seen: &[f64; Observation::NUMBERS]) -> Option<[f64; 5]> {
        if !seen.iter().all(|value| value.is_finite()) {
            return None;
        }
        let action = self.policy.action(seen);
        let mut command = [0.0; 5];
        let settings = &self.policy.settings().action;
        settings.command(self.weight_n, &action, &mut command);
        Some(command)
    }
}
