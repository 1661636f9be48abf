//! What a hover waited for.

use touchdown_lander::state_machine::{Phase, Reason};

/// For how many steps of the landing computer each condition has kept the vehicle from its descent, since the last descent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Waits(Vec<(Reason, u32)>);

impl Waits {
    /// A step of the landing computer.
    pub fn update(&mut self, phase: Phase, waits_for: Option<Reason>) {
        if phase == Phase::Descend {
            self.0.clear();
        }
        let Some(reason) = waits_for else {
            return;
        };
        match self.0.iter_mut().find(|(of, _)| *of == reason) {
            Some((_, steps)) => *steps += 1,
            None => self.0.push((reason, 1)),
        }
    }

    /// The condition that kept it for the longest time; none if the landing is not kept in `phase`.
    #[must_use]
    pub fn longest(&self, phase: Phase) -> Option<Reason> {
        let kept = matches!(phase, Phase::Approach | Phase::Hold);
        let longest = self.0.iter().max_by_key(|(_, steps)| *steps);
        longest.filter(|_| kept).map(|(reason, _)| *reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_longest_wait_since_the_last_descent_is_named() {
        let mut waits = Waits::default();
        let mut flown = |phase, reason, steps| {
            for _ in 0..steps {
                waits.update(phase, reason);
            }
            waits.longest(phase)
        };
        assert_eq!(
            flown(Phase::Hold, Some(Reason::Deck), 9),
            Some(Reason::Deck)
        );
        // Ready, it waits for the planner.
        assert_eq!(flown(Phase::Wait, None, 1), None);
        assert_eq!(flown(Phase::Descend, None, 1), None);
        assert_eq!(flown(Phase::GoAround, None, 1), None);
        let (wind, unsteady) = (Some(Reason::Wind), Some(Reason::Unsteady));
        assert_eq!(flown(Phase::Approach, unsteady, 2), unsteady);
        assert_eq!(flown(Phase::Hold, wind, 4), wind);
        assert_eq!(flown(Phase::Hold, unsteady, 1), wind);
    }
}
