//! Recordings of simulated landings in single precision, and their replay on the host.

mod landings;

pub use landings::{Recording, SEED, SingleLanding, recordings, space};

use touchdown_replay::{Port, replay};

/// The host's side of a replay: words from a slice, results into a vector.
struct HostPort<'a> {
    inputs: core::slice::Iter<'a, u32>,
    results: Vec<u32>,
}

impl Port for HostPort<'_> {
    fn word(&mut self) -> Option<u32> {
        self.inputs.next().copied()
    }

    fn write(&mut self, word: u32) {
        self.results.push(word);
    }
}

/// The results of a recording on this machine; none if it cannot be replayed.
#[must_use]
pub fn replayed(inputs: &[u32]) -> Option<Vec<u32>> {
    let mut port = HostPort {
        inputs: inputs.iter(),
        results: Vec::new(),
    };
    replay(&mut port).then_some(port.results)
}
