//! The touch of a landing, as the landing computer estimates it.

use serde::Serialize;
use touchdown_flight::touch::{CRASH_MPS, TouchClass};
use touchdown_lander::computer::ComputerOutput;
use touchdown_lander::state_machine::Phase;

/// Ticks before the touch is found in which it may have been: the search for it takes up to 0.5 s.
const TICKS: usize = 50;

/// A touch by estimated speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EstimatedTouch {
    /// Greatest estimated speed towards the deck in the half second before the touch was found, m/s.
    pub speed_mps: f64,
    /// Its class.
    pub class: TouchClass,
}

/// Watches a landing for its touch.
#[derive(Clone, Debug)]
pub(super) struct TouchWatch {
    /// Estimated speeds towards the deck, at the last ticks of the descent.
    speeds_mps: [f64; TICKS],
    /// Ticks of the descent so far.
    ticks: usize,
    touch: Option<EstimatedTouch>,
}

impl Default for TouchWatch {
    fn default() -> Self {
        Self {
            speeds_mps: [0.0; TICKS],
            ticks: 0,
            touch: None,
        }
    }
}

impl TouchWatch {
    pub(super) fn watch(&mut self, output: &ComputerOutput<f64>) {
        let estimate = &output.estimate;
        match output.state_machine.phase {
            Phase::Descend | Phase::Commit => {
                let speed_mps = estimate.deck_velocity_mps.z - estimate.velocity_mps.z;
                self.speeds_mps[self.ticks % TICKS] = speed_mps;
                self.ticks += 1;
                self.touch = None;
            }
            Phase::Touchdown | Phase::Disarmed if self.touch.is_none() && self.ticks > 0 => {
                let speed_mps = self.speeds_mps.iter().fold(0.0_f64, |most, v| most.max(*v));
                self.touch = Some(EstimatedTouch {
                    speed_mps,
                    class: TouchClass::of(speed_mps, CRASH_MPS),
                });
            }
            _ => {}
        }
    }

    pub(super) fn touch(&self) -> Option<EstimatedTouch> {
        self.touch
    }
}
