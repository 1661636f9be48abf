//! What of a landing's record can be drawn: what is not known is not a number, and left out.

use touchdown_sim::landing::space::TraceRow;

/// Standard deviation of the estimated height from which there is an estimate, m.
const KNOWN_M: f64 = 0.3;

/// A value of the landing computer's estimate of place or velocity.
pub(super) fn estimated(row: &TraceRow, value: f64) -> f64 {
    if row.estimated_sd_m[2] < KNOWN_M {
        value
    } else {
        f64::NAN
    }
}

/// The estimated heave velocity of the deck: 0 is said until a harmonic of it is known.
pub(super) fn estimated_deck_mps(row: &TraceRow) -> f64 {
    if row.estimated_deck_mps == 0.0 {
        f64::NAN
    } else {
        row.estimated_deck_mps
    }
}
