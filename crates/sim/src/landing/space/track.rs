//! The deck over the time of a landing.

use crate::deck::rigid::{DeckPose, RigidDeck};
use crate::error::SimError;

/// Largest distance between knots, s.
const KNOTS_S: f64 = 0.1;
/// Largest phase of the fastest wave between two knots, rad. The error of the spline is then
/// below 1e-5 of the wave's amplitude, and below 3e-4 of that of its acceleration.
const KNOT_RAD: f64 = 0.8;
/// Number of knots in a piece of the spline, which is computed at once.
const PIECE: f64 = 100.0;
/// Number of waves from which on the spline may have that error. With fewer waves each of
/// them carries a larger part of the motion.
const MANY: usize = 5;
/// Largest phase between two knots for fewer waves, rad: an error of 1e-10 of the amplitude.
const FEW_RAD: f64 = 0.13;
/// Distance of knots below which direct evaluation of a few waves costs less, s.
const LEAST_KNOTS_S: f64 = 0.01;

/// The deck over time; waves as a spline, piece by piece.
pub(super) struct Track {
    deck: RigidDeck,
    /// Step of the knots, where there are waves.
    knots_s: Option<f64>,
    piece: Option<(f64, RigidDeck)>,
    shift_s: f64,
}

impl Track {
    /// A deck that at the start of the landing is where it is at `shift_s`.
    pub(super) fn new(deck: RigidDeck, shift_s: f64) -> Self {
        let knots_s = match &deck {
            RigidDeck::Harmonics(waves) => {
                let frequencies = waves.iter().map(|wave| wave.angular_frequency);
                let fastest = frequencies.fold(0.0, f64::max);
                let many = waves.len() >= MANY;
                let turn = if many { KNOT_RAD } else { FEW_RAD };
                let knots_s = KNOTS_S.min(turn / fastest);
                (many || knots_s >= LEAST_KNOTS_S).then_some(knots_s)
            }
            _ => None,
        };
        Self {
            deck,
            knots_s,
            piece: None,
            shift_s,
        }
    }

    /// The deck at a time of the trial.
    pub(super) fn at(&mut self, time_s: f64) -> Result<DeckPose, SimError> {
        let time_s = time_s + self.shift_s;
        let Some(knots_s) = self.knots_s else {
            return Ok(self.deck.at(time_s));
        };
        let length_s = PIECE * knots_s;
        let piece = (time_s / length_s).floor();
        match &self.piece {
            Some((of, spline)) if *of == piece => Ok(spline.at(time_s)),
            _ => {
                let from_s = piece * length_s;
                let spline = self.deck.splined(from_s, from_s + length_s, knots_s)?;
                let pose = spline.at(time_s);
                self.piece = Some((piece, spline));
                Ok(pose)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck::rigid::{Axis, RigidMotion, Tone};

    #[test]
    fn analytic_many_waves_of_any_frequency_are_their_sum() {
        for fastest_hz in [0.2, 1.0, 5.0, 8.0, 40.0] {
            let tones = (1..=6).map(|k| Tone {
                axis: Axis::Heave,
                amplitude: if k == 6 { 0.1 } else { 0.0 },
                frequency_hz: fastest_hz * f64::from(k) / 6.0,
                phase_rad: 0.3,
            });
            let motion = RigidMotion::Sines {
                tones: tones.collect(),
            };
            let deck = motion.build(9.81, 0, 0).unwrap();
            let mut track = Track::new(deck.clone(), 37.3);
            let acceleration = 0.1 * (std::f64::consts::TAU * fastest_hz).powi(2);
            for k in 0..20_000 {
                let t = 0.0013 * f64::from(k);
                let (is, was) = (track.at(t).unwrap(), deck.at(t + 37.3));
                // As said of `KNOT_RAD`.
                let apart = (is.origin_m[2] - was.origin_m[2]).abs();
                assert!(apart < 1e-5 * 0.1, "{fastest_hz} Hz, {t} s: {apart} m");
                let apart = (is.acceleration_mps2[2] - was.acceleration_mps2[2]).abs();
                assert!(
                    apart < 3e-4 * acceleration,
                    "{fastest_hz} Hz, {t} s: {apart}"
                );
            }
        }
    }
}
