//! Vectors and attitudes in space: world axes x, y horizontal, z up; body axes
//! x forward, y left, z along the thrust.

use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use crate::error::SettingsError;
use crate::real::{Real, r};

/// Three components along x, y, z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Vector<R> {
    /// Component along x.
    pub x: R,
    /// Component along y.
    pub y: R,
    /// Component along z, up.
    pub z: R,
}

impl<R: Real> Vector<R> {
    /// The vector of length zero.
    pub const ZERO: Self = Self::new(R::ZERO, R::ZERO, R::ZERO);
    /// The unit vector along z.
    pub const UP: Self = Self::new(R::ZERO, R::ZERO, R::ONE);

    /// A vector of three components.
    #[must_use]
    pub const fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    /// A vector of the components x, y, z.
    #[must_use]
    pub fn from_array([x, y, z]: [R; 3]) -> Self {
        Self { x, y, z }
    }

    /// The components x, y, z.
    #[must_use]
    pub fn to_array(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }

    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Length, without overflow of its square.
    #[must_use]
    pub fn norm(self) -> R {
        let square = self.dot(self);
        // Squares that are far from both ends of the range, also of f32.
        if square > r(1e-24) && square < r(1e30) {
            return square.sqrt();
        }
        let largest = self.x.abs().max(self.y.abs()).max(self.z.abs());
        if largest > R::ZERO && largest.is_finite() {
            let v = Self::new(self.x / largest, self.y / largest, self.z / largest);
            largest * v.dot(v).sqrt()
        } else {
            // Zero, infinite or NaN.
            self.x.abs() + self.y.abs() + self.z.abs()
        }
    }

    /// The vector of length one in the same direction; none for a vector that
    /// is zero or not finite.
    #[must_use]
    pub fn direction(self) -> Option<Self> {
        let norm = self.norm();
        (norm > R::ZERO && norm.is_finite())
            .then(|| Self::new(self.x / norm, self.y / norm, self.z / norm))
    }

    /// The vector shortened to the length `longest` where it is longer.
    #[must_use]
    pub fn limited(self, longest: R) -> Self {
        let norm = self.norm();
        if norm > longest {
            self * (longest / norm)
        } else {
            self
        }
    }

    /// The components x and y, with z zero.
    #[must_use]
    pub fn horizontal(self) -> Self {
        Self::new(self.x, self.y, R::ZERO)
    }

    /// Every component is finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }

    /// `self` if every component is finite, otherwise `fallback`.
    #[must_use]
    pub fn finite_or(self, fallback: Self) -> Self {
        if self.is_finite() { self } else { fallback }
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Neg for Vector<R> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    fn mul(self, factor: R) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<R: Real> AddAssign for Vector<R> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real> SubAssign for Vector<R> {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// A rotation from body to world axes, as a unit quaternion (w, x, y, z).
///
/// The product `a * b` turns by b first, then by a; with `a` body → world and
/// `b` sensor → body it is sensor → world. Results of products and steps are
/// normalised, so that the length does not drift.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "[R; 4]", into = "[R; 4]"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Attitude<R> {
    w: R,
    v: Vector<R>,
}

impl<R: Real> Default for Attitude<R> {
    fn default() -> Self {
        Self::LEVEL
    }
}

impl<R: Real> Attitude<R> {
    /// Body axes along world axes.
    pub const LEVEL: Self = Self {
        w: R::ONE,
        v: Vector::ZERO,
    };

    /// Zeros, which are no attitude: for memory that an attitude is written to later.
    pub const BLANK: Self = Self {
        w: R::ZERO,
        v: Vector::ZERO,
    };

    /// The attitude of a quaternion (w, x, y, z) of any length; none where it is
    /// zero or not finite.
    #[must_use]
    pub fn from_quaternion([w, x, y, z]: [R; 4]) -> Option<Self> {
        let largest = w.abs().max(x.abs()).max(y.abs()).max(z.abs());
        let finite = w.is_finite() && Vector::new(x, y, z).is_finite();
        (finite && largest > R::ZERO).then(|| {
            // Scaled first: neither overflow nor underflow of the squares.
            let scaled = [w, x, y, z].map(|c| c / largest);
            Self::normalised(scaled[0], Vector::new(scaled[1], scaled[2], scaled[3]))
        })
    }

    /// The unit quaternion (w, x, y, z).
    #[must_use]
    pub fn to_quaternion(self) -> [R; 4] {
        [self.w, self.v.x, self.v.y, self.v.z]
    }

    /// A turn about `rotation` by its length in rad (exponential map).
    #[must_use]
    pub fn from_rotation_vector(rotation: Vector<R>) -> Self {
        let angle = rotation.norm();
        let half = angle * r(0.5);
        // sin(α/2)/α; below, α²/48 is under the rounding.
        let factor = if half * half < R::EPSILON {
            r(0.5)
        } else {
            half.sin() / angle
        };
        Self::normalised(half.cos(), rotation * factor)
    }

    /// The turn as a vector: axis times angle, the angle in [0, π] (logarithm).
    #[must_use]
    pub fn rotation_vector(self) -> Vector<R> {
        // q and -q are the same attitude: the shorter turn.
        let sign = if self.w < R::ZERO { -R::ONE } else { R::ONE };
        let (w, v) = (self.w * sign, self.v * sign);
        let sine = v.norm();
        let factor = if sine * sine < R::EPSILON {
            r(2.0)
        } else {
            r::<R>(2.0) * sine.atan2(w) / sine
        };
        v * factor
    }

    /// Level, turned by `yaw_rad` about the vertical (positive from x to y).
    #[must_use]
    pub fn from_yaw(yaw_rad: R) -> Self {
        Self::about(Vector::UP, yaw_rad)
    }

    /// The attitude whose body z axis points along `direction` and whose heading
    /// is `yaw_rad`: `R = R_z(ψ) R_y(θ) R_x(φ)` with θ = atan2(a, c) and
    /// φ = atan2(-b, √(a² + c²)), (a, b, c) being the direction seen from the
    /// heading. None where the direction is zero or a number is not finite.
    ///
    /// A vertical direction and zero yaw give [`Self::LEVEL`] exactly.
    #[must_use]
    pub fn from_thrust_direction(direction: Vector<R>, yaw_rad: R) -> Option<Self> {
        if !yaw_rad.is_finite() {
            return None;
        }
        let heading = Self::from_yaw(yaw_rad);
        let seen = heading.unrotate(direction.direction()?);
        let level = (seen.x * seen.x + seen.z * seen.z).sqrt();
        let (pitch, roll) = (
            half_turn(seen.x, seen.z, level),
            half_turn(-seen.y, level, R::ONE),
        );
        let ((sp, cp), (sr, cr)) = (pitch, roll);
        let tilt = Self {
            w: cp * cr,
            v: Vector::new(cp * sr, sp * cr, -(sp * sr)),
        };
        Some(heading * tilt)
    }

    /// World components of a vector in body axes.
    #[must_use]
    pub fn rotate(self, body: Vector<R>) -> Vector<R> {
        let t = self.v.cross(body) * r(2.0);
        body + t * self.w + self.v.cross(t)
    }

    /// Body components of a vector in world axes.
    #[must_use]
    pub fn unrotate(self, world: Vector<R>) -> Vector<R> {
        self.inverse().rotate(world)
    }

    /// The rotation from world to body axes.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            w: self.w,
            v: -self.v,
        }
    }

    /// The attitude `dt` seconds later at constant body rates, rad/s: exact,
    /// `q ∘ exp(ω dt)`.
    #[must_use]
    pub fn after(self, body_rates: Vector<R>, dt: R) -> Self {
        self * Self::from_rotation_vector(body_rates * dt)
    }

    /// The attitude at a share of the way from this one to `other`, by linear
    /// interpolation of the quaternions: for a turn α over the way it is off by
    /// less than α³/60.
    #[must_use]
    pub fn between(self, other: Self, share: R) -> Self {
        let product = self.w * other.w + self.v.dot(other.v);
        // q and -q are the same attitude: the shorter way.
        let part = if product < R::ZERO { -share } else { share };
        let rest = R::ONE - share;
        let (w, v) = (
            self.w * rest + other.w * part,
            self.v * rest + other.v * part,
        );
        Self::normalised(w, v)
    }

    /// The body's z axis in the world: the direction of thrust.
    #[must_use]
    pub fn up(self) -> Vector<R> {
        self.rotate(Vector::UP)
    }

    /// Angle between the body's z axis and the vertical, in [0, π], rad.
    #[must_use]
    pub fn tilt_rad(self) -> R {
        let Vector { x, y, z } = self.v;
        let sine = (x * x + y * y).sqrt();
        let cosine = (self.w * self.w + z * z).sqrt();
        r::<R>(2.0) * sine.atan2(cosine)
    }

    /// Heading of the body's x axis, in (-π, π], rad. Not defined (but finite)
    /// where that axis is vertical.
    #[must_use]
    pub fn yaw_rad(self) -> R {
        let forward = self.rotate(Vector::new(R::ONE, R::ZERO, R::ZERO));
        forward.y.atan2(forward.x)
    }

    /// Every number is finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.w.is_finite() && self.v.is_finite()
    }

    /// A turn about a unit vector.
    fn about(axis: Vector<R>, angle: R) -> Self {
        let (sine, cosine) = (angle * r(0.5)).sin_cos();
        Self {
            w: cosine,
            v: axis * sine,
        }
    }

    /// The attitude of a quaternion whose length is of the order of one.
    fn normalised(w: R, v: Vector<R>) -> Self {
        let scale = R::ONE / (w * w + v.dot(v)).sqrt();
        Self {
            w: w * scale,
            v: v * scale,
        }
    }
}

/// Sine and cosine of half the angle whose sine is `a/h` and whose cosine is `c/h`, both times
/// the same positive number; h is √(a² + c²).
fn half_turn<R: Real>(a: R, c: R, h: R) -> (R, R) {
    if c >= R::ZERO {
        // No difference that cancels; no angle where h is 0.
        (a, if h > R::ZERO { h + c } else { R::ONE })
    } else if a < R::ZERO {
        (c - h, -a)
    } else {
        (h - c, a)
    }
}

impl<R: Real> Mul for Attitude<R> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self::normalised(
            self.w * b.w - self.v.dot(b.v),
            b.v * self.w + self.v * b.w + self.v.cross(b.v),
        )
    }
}

impl<R: Real> TryFrom<[R; 4]> for Attitude<R> {
    type Error = SettingsError;

    /// As [`Self::from_quaternion`].
    fn try_from(quaternion: [R; 4]) -> Result<Self, SettingsError> {
        Self::from_quaternion(quaternion).ok_or(SettingsError::OutOfRange {
            key: "attitude",
            expected: "a finite quaternion (w, x, y, z) other than 0",
            found: quaternion[0].to_f64(),
        })
    }
}

impl<R: Real> From<Attitude<R>> for [R; 4] {
    fn from(attitude: Attitude<R>) -> Self {
        attitude.to_quaternion()
    }
}
