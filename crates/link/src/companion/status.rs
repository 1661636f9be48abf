//! What a companion says of its flight.

use touchdown_lander::state_machine::{Phase, Reason};

use super::{Companion, Ending, Stage};
use crate::checklist::Checklist;
use crate::timing::Quantiles;

impl Companion {
    /// The stage.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// The checklist as it was last judged.
    #[must_use]
    pub fn checklist(&self) -> &Checklist {
        &self.checklist
    }

    /// Notes for the operator since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Why control ended, or was handed over.
    #[must_use]
    pub fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// Setpoints sent in control so far.
    #[must_use]
    pub fn setpoints(&self) -> u64 {
        self.setpoints
    }

    /// The phase of the landing, once the companion has been in control.
    #[must_use]
    pub fn phase(&self) -> Option<Phase> {
        self.output.map(|output| output.state_machine.phase)
    }

    /// Why the landing was interrupted or given up last, once the companion has been in control.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        self.output.and_then(|output| output.state_machine.reason)
    }

    /// What keeps the vehicle from its descent, while it approaches and holds in control.
    #[must_use]
    pub fn waits_for(&self) -> Option<Reason> {
        self.output
            .and_then(|output| output.state_machine.waits_for)
    }

    /// Height above the deck as the landing computer last estimated it in control, m.
    #[must_use]
    pub fn height_m(&self) -> Option<f64> {
        self.output.map(|output| output.estimate.position_m.z)
    }

    /// Latency of the readings beyond their stamped ages, as the landing computer estimates it, s.
    #[must_use]
    pub fn latency_s(&self) -> Option<f64> {
        self.computed.map(|output| output.latency_s)
    }

    /// Deviations of the period from 10 ms so far, while setpoints were streamed.
    #[must_use]
    pub fn jitter(&self) -> Option<Quantiles> {
        self.jitter.quantiles()
    }
}
