//! Table of the deck's functions of the rotor height.

use std::sync::Arc;

use crate::air::ground::DeckSurface;
use crate::number::Number;

/// Spacing of the table, m.
const SPACING_M: f64 = 0.005;
/// Number of intervals: the table ends at 2.55 m, where the ground effect is below 0.1 % of
/// the thrust. Above it the formulas are evaluated, which only costs time.
const INTERVALS: usize = 500;

/// Adding and subtracting 1.5 · 2⁵² rounds an f64 to a whole number, because numbers of this
/// size have no fraction.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// P(z) and the solid angle of the plate from a rotor of the centred vehicle,
/// S0(z), as 1/S0: at one height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlateAtHeight<N> {
    pub(crate) upwash: N,
    pub(crate) inverse_angle: N,
}

/// Cubic Hermite interpolation of the two over the height. They vary on the
/// scale of the plate: at the spacing of 5 mm the error of P is below 1e-10 for
/// one of 1.5 m side, and below 1e-7 for one of 0.3 m.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HeightTable {
    deck: DeckSurface,
    offset_m: f64,
    /// For each interval the coefficients of P, then those of 1/S0, lowest order first.
    rows: Arc<[[f64; 8]]>,
}

impl HeightTable {
    pub(crate) fn new(deck: DeckSurface, offset_m: f64) -> Self {
        let exact = |z: f64| Self::exact(&deck, offset_m, z);
        let knots: Vec<_> = (0..=INTERVALS)
            .map(|i| {
                let z = deck.least_rotor_height_m() + SPACING_M * i as f64;
                // Slopes of order four over 1 mm, scaled to the spacing. P is held below the least
                // height: the first knot looks upwards.
                let h = 1e-3;
                let (from, weights) = if i == 0 {
                    (0.0, [-25.0, 48.0, -36.0, 16.0, -3.0])
                } else {
                    (-2.0, [1.0, -8.0, 0.0, 8.0, -1.0])
                };
                let mut slope = [0.0; 2];
                for (j, weight) in weights.into_iter().enumerate() {
                    let value = exact(z + (from + j as f64) * h);
                    for k in 0..2 {
                        slope[k] += weight / (12.0 * h) * SPACING_M * value[k];
                    }
                }
                (exact(z), slope)
            })
            .collect();
        let rows = knots.windows(2).map(|pair| {
            let ((v0, s0), (v1, s1)) = (pair[0], pair[1]);
            let mut row = [0.0; 8];
            for k in 0..2 {
                let rise = v1[k] - v0[k];
                row[4 * k..4 * k + 4].copy_from_slice(&[
                    v0[k],
                    s0[k],
                    3.0 * rise - 2.0 * s0[k] - s1[k],
                    s0[k] + s1[k] - 2.0 * rise,
                ]);
            }
            row
        });
        Self {
            deck,
            offset_m,
            rows: rows.collect(),
        }
    }

    fn exact(deck: &DeckSurface, offset_m: f64, z: f64) -> [f64; 2] {
        let angle = deck.solid_angle([offset_m, offset_m, z]);
        [deck.upwash(z), 1.0 / angle]
    }

    /// Both at the height z, at least the least of the laws.
    #[inline(always)]
    pub(crate) fn at<N: Number>(&self, z: N) -> PlateAtHeight<N> {
        let place = (z - self.deck.least_rotor_height_m()) * (1.0 / SPACING_M);
        if N::any(place.above(INTERVALS as f64)) {
            return self.at_any(z);
        }
        // The interval is the whole number next to its middle: t lies in [0, 1].
        let interval = ((place - 0.5) + WHOLE) - WHOLE;
        let t = place - interval;
        let [a0, a1, a2, a3, b0, b1, b2, b3] = interval.gather(&self.rows);
        PlateAtHeight {
            upwash: a0 + t * (a1 + t * (a2 + t * a3)),
            inverse_angle: b0 + t * (b1 + t * (b2 + t * b3)),
        }
    }

    /// [`Self::at`] where a height may be beyond the table.
    #[cold]
    fn at_any<N: Number>(&self, z: N) -> PlateAtHeight<N> {
        let greatest = self.deck.least_rotor_height_m() + SPACING_M * INTERVALS as f64;
        let [upwash, inverse_angle] = z.look_up(|z| {
            if z < greatest {
                let of = self.at(z);
                [of.upwash, of.inverse_angle]
            } else {
                Self::exact(&self.deck, self.offset_m, z)
            }
        });
        PlateAtHeight {
            upwash,
            inverse_angle,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::plant::{PlantSettings, Surface};

    #[test]
    fn analytic_table_is_the_formulas() {
        for (surface, side) in [
            (Surface::Plate, 1.5),
            (Surface::Plate, 0.8),
            (Surface::Ground, 1.5),
            (Surface::Absent, 1.5),
        ] {
            let settings = PlantSettings {
                surface,
                plate_side_m: side,
                ..PlantSettings::default()
            };
            let deck = DeckSurface::new(&settings.wake()).expect("valid settings");
            let table = HeightTable::new(deck, 0.16);
            for i in 0..40_000 {
                let z = 0.05 + 7.1e-5 * f64::from(i);
                let at = table.at(z);
                let exact = HeightTable::exact(&deck, 0.16, z);
                let found = [at.upwash, at.inverse_angle];
                for k in 0..2 {
                    // h⁴/384 = 1.6e-12 times fourth derivatives of 24/l⁴ (l = 0.4 m to the edge of
                    // the smaller plate: 900): 2e-9; the default plate, 0.75 m, ten times less.
                    let bound = if side < 1.0 { 2e-9 } else { 2e-10 };
                    assert!((found[k] - exact[k]).abs() < bound, "{k} at {z}");
                }
            }
        }
    }
}
