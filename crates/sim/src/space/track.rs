//! The deck over the time of a landing.

use crate::deck::rigid::{DeckPose, RigidDeck};
use crate::error::SimError;

/// Pieces in which a sea is made into a spline, s, and the step of its knots.
const PIECE_S: f64 = 10.0;
const KNOTS_S: f64 = 0.1;

/// The deck over time, waves as a spline.
pub(super) struct Track {
    pub(super) deck: RigidDeck,
    pub(super) piece: Option<(f64, RigidDeck)>,
    pub(super) shift_s: f64,
}

impl Track {
    /// The deck at a time of the trial.
    pub(super) fn at(&mut self, time_s: f64) -> Result<DeckPose, SimError> {
        let time_s = time_s + self.shift_s;
        let many = matches!(&self.deck, RigidDeck::Harmonics(waves) if waves.len() > 4);
        if !many {
            return Ok(self.deck.at(time_s));
        }
        let piece = (time_s / PIECE_S).floor() * PIECE_S;
        match &self.piece {
            Some((from, spline)) if *from == piece => Ok(spline.at(time_s)),
            _ => {
                let spline = self.deck.splined(piece, piece + PIECE_S, KNOTS_S)?;
                let pose = spline.at(time_s);
                self.piece = Some((piece, spline));
                Ok(pose)
            }
        }
    }
}
