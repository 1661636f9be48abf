//! A simple ship: how waves move it, in five degrees of freedom.
//!
//! Heave and pitch are the closed forms of Jensen, Mansour & Olsen (2004) for a
//! box-shaped hull; roll is a damped oscillator on the effective
//! wave slope; surge and sway follow the water. For waves that travel at the
//! angle β from the ship's bow direction, k = ω²/g, k_e = k |cos β|, α = 1 - k u cos β/ω
//! for a ship of speed u (1 at rest),
//! A = 2 sin(kBα²/2) e^(-kTα²), and with phasors of e^(iαωt):
//!
//! ```text
//! D = 1 - 2 k T α² + i A²/(k B α²),  f = √((1 - kT)² + (A²/(kBα³))²),  χ = k_e L/2
//! heave  w/ζ = e^(-k_e T) f (sin χ / χ) / D
//! pitch  θ/ζ = ± i e^(-k_e T) f (24/((k_e L)² L)) (sin χ - χ cos χ) / D
//! roll   φ/ζ = -i k sin β e^(-kT) sinc(kB sin β/2) / (1 - r² + 2 i ζ_r r),  r = αω/ω_roll
//! surge, sway  = -i (cos β sinc χ, sin β sinc(kB sin β/2)) e^(-kT)
//! ```
//!
//! Pitch is positive bow down, roll positive port side up (right-handed about
//! x forward, y to port, z up). Long waves carry the ship along: heave is the
//! elevation, roll and pitch are the wave's slope.

use serde::{Deserialize, Serialize};

use super::harmonics::Harmonic;
use super::wave::Wave;
use crate::check;
use crate::error::SimError;

/// Size and roll of the ship, and position of its deck.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShipSettings {
    /// Length at the waterline L, m.
    pub length_m: f64,
    /// Beam B, m.
    pub beam_m: f64,
    /// Draught T, m.
    pub draught_m: f64,
    /// Natural period of roll, s.
    pub roll_period_s: f64,
    /// Damping ratio of roll.
    pub roll_damping: f64,
    /// Position of the deck's centre from the ship's centre (forward, port, up), m.
    pub deck_place_m: [f64; 3],
}

impl Default for ShipSettings {
    /// A work boat of 10 m.
    fn default() -> Self {
        Self {
            length_m: 10.0,
            beam_m: 3.5,
            draught_m: 0.8,
            roll_period_s: 3.0,
            roll_damping: 0.15,
            deck_place_m: [-2.0, 0.0, 1.0],
        }
    }
}

/// A complex number.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn over(self, d: Self) -> Self {
        let n = d.0 * d.0 + d.1 * d.1;
        Self(
            (self.0 * d.0 + self.1 * d.1) / n,
            (self.1 * d.0 - self.0 * d.1) / n,
        )
    }

    fn turned(self, phase_rad: f64, scale: f64) -> Self {
        let (sin, cos) = phase_rad.sin_cos();
        Self(
            scale * (self.0 * cos - self.1 * sin),
            scale * (self.0 * sin + self.1 * cos),
        )
    }
}

/// α² below which a ship counts as travelling with the waves.
const STATIC: f64 = 1e-6;

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}

impl ShipSettings {
    /// Checks the ship.
    ///
    /// # Errors
    /// Lengths, period and damping must be positive, the beam below ten
    /// draughts (beyond, the closed forms lose their damping).
    pub fn validate(&self) -> Result<(), SimError> {
        check::positive("length_m", self.length_m)?;
        check::positive("beam_m", self.beam_m)?;
        check::positive("draught_m", self.draught_m)?;
        check::that(
            self.beam_m <= 10.0 * self.draught_m,
            "beam_m",
            "at most ten draughts",
            self.beam_m,
        )?;
        check::positive("roll_period_s", self.roll_period_s)?;
        check::positive("roll_damping", self.roll_damping)?;
        for value in self.deck_place_m {
            check::finite("deck_place_m", value)?;
        }
        Ok(())
    }

    /// Motion of the deck's centre and attitude in one wave that travels at
    /// `heading_rad` from the bow's direction (0: from astern, π: from ahead).
    /// Angles are small: lever arms act to first order.
    #[must_use]
    pub fn response(&self, wave: &Wave, heading_rad: f64, gravity_mps2: f64) -> Harmonic {
        self.response_under_way(wave, heading_rad, 0.0, gravity_mps2)
    }

    /// [`Self::response`] of a ship with a speed u: waves are met at `α ω`, with
    /// `α = 1 - k u cos β/ω`. The harmonic keeps the wave's own frequency.
    #[must_use]
    pub fn response_under_way(
        &self,
        wave: &Wave,
        heading_rad: f64,
        speed_mps: f64,
        gravity_mps2: f64,
    ) -> Harmonic {
        let w = wave.angular_frequency;
        let k = w * w / gravity_mps2;
        let (sin_b, cos_b) = heading_rad.sin_cos();
        let met = 1.0 - k * speed_mps * cos_b / w;
        let met2 = met * met;
        let (beam, draught) = (k * self.beam_m, k * self.draught_m);
        let chi = 0.5 * k * cos_b.abs() * self.length_m;
        let side = 0.5 * beam * sin_b;
        let radiated = 2.0 * (0.5 * beam * met2).sin() * (-draught * met2).exp();
        // A ship that travels with the waves radiates none.
        let damping = if met2 > STATIC {
            radiated * radiated / (beam * met2)
        } else {
            0.0
        };
        // Phasors turn backwards where the ship overtakes the waves.
        let hull = Complex(1.0 - 2.0 * draught * met2, damping * met.signum());
        // A²/(k B α³), whose limit is 0 as well.
        let pushed = if met2 > STATIC { damping / met } else { 0.0 };
        let force =
            (-draught * cos_b.abs()).exp() * ((1.0 - draught).powi(2) + pushed * pushed).sqrt();
        // (sin χ - χ cos χ)/χ² is χ/3 for small χ.
        let lever = if chi < 1e-3 {
            chi / 3.0
        } else {
            (chi.sin() - chi * chi.cos()) / (chi * chi)
        };
        let depth = (-draught).exp();
        let r = w * met * self.roll_period_s / std::f64::consts::TAU;
        let roll_slope = k * sin_b * depth * sinc(side);

        let surge = Complex(0.0, -cos_b * depth * sinc(chi));
        let sway = Complex(0.0, -sin_b * depth * sinc(side));
        let heave = Complex(force * sinc(chi), 0.0).over(hull);
        let roll =
            Complex(0.0, -roll_slope).over(Complex(1.0 - r * r, 2.0 * self.roll_damping * r));
        let bow_down = cos_b.signum() * force * 6.0 / self.length_m * lever;
        let pitch = Complex(0.0, bow_down).over(hull);

        // Deck's place: displacement + (roll, pitch, 0) × place.
        let [x, y, z] = self.deck_place_m;
        let moved = [
            Complex(surge.0 + pitch.0 * z, surge.1 + pitch.1 * z),
            Complex(sway.0 - roll.0 * z, sway.1 - roll.1 * z),
            Complex(
                heave.0 + roll.0 * y - pitch.0 * x,
                heave.1 + roll.1 * y - pitch.1 * x,
            ),
            roll,
            pitch,
        ];
        // Re((a + ib) e^(iωt)) = a cos ωt - b sin ωt.
        let moved = moved.map(|c| c.turned(wave.phase_rad, wave.amplitude_m));
        Harmonic {
            angular_frequency: w,
            cosine: moved.map(|c| c.0),
            sine: moved.map(|c| -c.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;

    fn wave(angular_frequency: f64) -> Wave {
        Wave {
            amplitude_m: 0.3,
            angular_frequency,
            phase_rad: 0.4,
        }
    }

    #[test]
    fn analytic_long_waves_carry_the_ship_along() {
        let ship = ShipSettings {
            deck_place_m: [0.0; 3],
            ..ShipSettings::default()
        };
        let w = 0.05; // 125 s, 25 km long
        let k = w * w / G;
        for heading in [0.0, 0.7, 2.0, std::f64::consts::PI] {
            let h = ship.response(&wave(w), heading, G);
            for t in [0.0, 17.0, 60.0] {
                let angle: f64 = w * t + 0.4;
                let (elevation, along) = (0.3 * angle.cos(), 0.3 * angle.sin());
                let slope = k * along; // ∂ζ/∂s along the direction of travel
                let expected = [
                    along * heading.cos(),
                    along * heading.sin(),
                    elevation,
                    slope * heading.sin(),
                    -slope * heading.cos(),
                ];
                let (sin, cos) = (w * t).sin_cos();
                for axis in 0..5 {
                    let value = h.cosine[axis] * cos + h.sine[axis] * sin;
                    let size = if axis < 3 { 0.3 } else { 0.3 * k };
                    // Corrections are of order k B, ω/ω_roll: 1 %.
                    assert!((value - expected[axis]).abs() < 0.02 * size, "{axis}");
                }
            }
        }
    }

    #[test]
    fn analytic_short_waves_leave_it_and_roll_peaks_at_resonance() {
        let ship = ShipSettings::default();
        let size = |w: f64, heading: f64, axis: usize| {
            let h = ship.response(&wave(w), heading, G);
            h.cosine[axis].hypot(h.sine[axis]) / 0.3
        };
        for heading in [0.0, 1.0, 3.0] {
            for axis in 0..3 {
                // Waves of 1 m on a hull of 10 m by 3.5 m.
                assert!(size(7.85, heading, axis) < 0.1, "{heading} {axis}");
            }
        }
        let beam = std::f64::consts::FRAC_PI_2;
        let natural = std::f64::consts::TAU / 3.0;
        let k = natural * natural / G;
        // At resonance the slope is magnified by 1/(2 ζ) = 3.33, less e^(-kT) sinc.
        let expected = k * (-0.8 * k).exp() * sinc(0.5 * k * 3.5) / 0.3;
        assert!((size(natural, beam, 3) - expected).abs() < 1e-12);
        assert!(size(natural, 0.0, 3) < 1e-15);
    }

    #[test]
    fn analytic_lever_arm_of_the_deck() {
        let at = |place: [f64; 3]| {
            let ship = ShipSettings {
                deck_place_m: place,
                ..ShipSettings::default()
            };
            ship.response(&wave(1.1), 2.2, G).cosine
        };
        let (centre, bow) = (at([0.0; 3]), at([4.0, 0.0, 0.0]));
        // The bow goes down by 4 m times the pitch: rounding only.
        assert!((bow[2] - (centre[2] - 4.0 * centre[4])).abs() < 1e-15);
        let top = at([0.0, 0.0, 2.0]);
        assert!((top[0] - (centre[0] + 2.0 * centre[4])).abs() < 1e-15);
        assert!((top[1] - (centre[1] - 2.0 * centre[3])).abs() < 1e-15);
    }
}
