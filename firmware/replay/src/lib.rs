//! Recorded steps of the controllers in single precision, replayed on any target.
//!
//! A recording is a sequence of words: what is called, its settings, then the inputs of one
//! call after another. Host and chip run [`replay`] on the same recording; both write the
//! results of every call as words, which must be the same bits.
#![no_std]
#![forbid(unsafe_code)]

mod computer;
mod models;
mod vertical;
mod words;

pub use computer::{
    ComputerRecording, State as ComputerState, computer_start, computer_step, record,
};
pub use models::ModelCall;
pub use vertical::{VerticalRecording, vertical_step};
pub use words::{Port, Reader, Writer};

/// What a recording calls: its first word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Callee {
    /// A step of one model.
    Model(ModelCall),
    /// `VerticalController::step`.
    Vertical,
    /// `Computer::step`.
    Computer,
    /// `Computer::initial`.
    ComputerStart,
}

impl Callee {
    /// The word of the callee.
    #[must_use]
    pub fn word(self) -> u32 {
        match self {
            Self::Vertical => 1,
            Self::Computer => 2,
            Self::ComputerStart => 3,
            Self::Model(call) => 16 + call.word(),
        }
    }

    /// The callee of a word.
    #[must_use]
    pub fn of_word(word: u32) -> Option<Self> {
        match word {
            1 => Some(Self::Vertical),
            2 => Some(Self::Computer),
            3 => Some(Self::ComputerStart),
            _ => ModelCall::of_word(word.checked_sub(16)?).map(Self::Model),
        }
    }
}

/// Replays a recording to its end. Returns false for an unknown callee or unusable settings.
pub fn replay(port: &mut impl Port) -> bool {
    match port.word().and_then(Callee::of_word) {
        Some(Callee::Model(call)) => models::replay(call, port),
        Some(Callee::Vertical) => vertical::replay(port),
        Some(Callee::Computer) => computer::replay(port),
        Some(Callee::ComputerStart) => computer::start(port),
        None => return false,
    }
    .is_some()
}
