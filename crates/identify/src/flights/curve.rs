//! The laws of the static curve.

use serde::Serialize;

/// Greatest share of the induced speed that images take away.
/// As eq. (2) in flight: beyond it `q/(1 - q)` grows without bound. No flight that we simulated reaches it (measured).
const Q_MAX: f64 = 0.6;
/// Least rotor height that images are used at, in R.
/// Images diverge at the plane itself. Half moves nothing; twice widens the interval at 0.4 R by 70 % (measured).
const LEAST_HEIGHT: f64 = 0.3;
/// Lengths of the bounded rationals, in R.
/// A factor of 2.4 apart, they span 0.3 to 6 R; a card tries others by factors of 0.35 to 2.8.
pub const LENGTHS: [f64; 3] = [0.6, 1.5, 3.5];
/// Most numbers of a curve.
pub const MOST: usize = 4;

/// The law of the static curve.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Curve {
    /// None: thrust alone.
    Free,
    /// `A e^(-z/L)`.
    Exponential,
    /// Eq. (2): `q/(1 - q)`, `q = μ (R/(4 (z + h_r)))²`.
    Empirical,
    /// `h1 ψ1 + h2 ψ2 + h3 ψ3`, `ψ_i = 1/(1 + (z/l_i)²)`.
    Rational,
    /// `q/(1 - q)` of four rotors, `ζ = z + h_r` and opposite axes 2c apart: μ times the images of a rotor itself, of its
    /// two neighbours and of the opposite one, and the fountain between them,
    ///
    /// `q = μ (1/(16 ζ²) + ζ/(8 (ζ² + c²/2)^(3/2)) + ζ/(16 (ζ² + c²)^(3/2))) + β ζ/(ζ² + c²)^(3/2)`
    ///
    /// (Cheeseman & Bennett 1955; Sanchez-Cuevas, Heredia & Ollero 2017), all lengths in R. The fountain is slower.
    Images,
}

impl Curve {
    /// The name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free_air",
            Self::Exponential => "exponential",
            Self::Empirical => "empirical",
            Self::Rational => "rational",
            Self::Images => "images",
        }
    }

    /// How many numbers it has.
    #[must_use]
    pub fn many(self) -> usize {
        match self {
            Self::Free => 0,
            Self::Exponential | Self::Empirical => 2,
            Self::Rational => 3,
            Self::Images => 4,
        }
    }

    /// Its two parts at a height in R, which may follow the height with different lags; only images have a second.
    #[must_use]
    pub fn parts(self, [a, b, c, d]: [f64; MOST], height: f64) -> [f64; 2] {
        match self {
            Self::Free => [0.0; 2],
            Self::Exponential => [a * (-height.max(0.0) / b).exp(), 0.0],
            Self::Empirical => [own_image(a, height + b), 0.0],
            Self::Rational => {
                let sum = (0..).zip([a, b, c]).map(|(i, h)| h * psi(i, height));
                [sum.sum(), 0.0]
            }
            Self::Images => {
                let rotor = (height + d).max(LEAST_HEIGHT);
                let source = |distance2: f64| {
                    let r2 = rotor * rotor + distance2;
                    rotor / (r2 * r2.sqrt())
                };
                let [near, far] = [source(0.5 * c * c), source(c * c)];
                let others = a * (near / 8.0 + far / 16.0);
                [own_image(a, rotor) + others, b * far]
            }
        }
    }

    /// The ratio of thrusts minus one from the parts.
    #[must_use]
    pub fn lift(self, parts: [f64; 2]) -> f64 {
        match self {
            Self::Empirical | Self::Images => {
                let q = (parts[0] + parts[1]).clamp(-Q_MAX, Q_MAX);
                q / (1.0 - q)
            }
            _ => parts[0],
        }
    }
}

/// `μ (R/(4 ζ))²` at a rotor height in R.
fn own_image(mu: f64, rotor: f64) -> f64 {
    let rotor = rotor.max(LEAST_HEIGHT);
    mu / (16.0 * rotor * rotor)
}

/// `ψ = 1/(1 + (z/l)²)` of a length, at a height in R.
#[must_use]
pub fn psi(of: usize, height: f64) -> f64 {
    1.0 / (1.0 + (height / LENGTHS[of]).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_images_are_those_of_four_rotors_far_away() {
        // Seen from far, four images and the fountain are one source of their summed strength: q z² is constant.
        let p = [1.0, 0.5, 1.8, 0.4];
        let far = |z: f64| {
            let [a, b] = Curve::Images.parts(p, z - 0.4);
            (a + b) * z * z
        };
        // Four images of 1/16 and the fountain; the next term is of order (c/z)²: 1e-3 at 100.
        assert!((far(100.0) - (4.0 / 16.0 + 0.5)).abs() < 1e-3);
    }

    #[test]
    fn analytic_images_of_rotors_far_apart_are_eq_2() {
        for z in [0.1, 0.5, 2.0] {
            let images = Curve::Images.parts([1.3, 0.0, 1e3, 0.5], z);
            let empirical = Curve::Empirical.parts([1.3, 0.5, 0.0, 0.0], z);
            let lift = [Curve::Images.lift(images), Curve::Empirical.lift(empirical)];
            // Neighbours a thousand radii away: 1e-9.
            assert!((lift[0] - lift[1]).abs() < 1e-8, "{lift:?}");
        }
    }
}
