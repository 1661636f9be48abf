//! Vectors of three numbers and unit quaternions (w, x, y, z).

use std::ops::Mul;

use crate::number::Number;

pub(crate) type Vector<N = f64> = [N; 3];

#[inline(always)]
pub(crate) fn add<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn scale<N, S: Copy>(a: Vector<N>, s: S) -> Vector<N>
where
    N: Number + Mul<S, Output = N>,
{
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
pub(crate) fn cross<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
pub(crate) fn sub<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn dot<N: Number>(a: Vector<N>, b: Vector<N>) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Three orthonormal axes, in world coordinates.
pub(crate) type Axes<N = f64> = [Vector<N>; 3];

/// World coordinates of a vector given along `axes`.
#[inline(always)]
pub(crate) fn to_world<N: Number>(axes: &Axes<N>, v: Vector<N>) -> Vector<N> {
    let [a, b, c] = axes;
    [
        a[0] * v[0] + b[0] * v[1] + c[0] * v[2],
        a[1] * v[0] + b[1] * v[1] + c[1] * v[2],
        a[2] * v[0] + b[2] * v[1] + c[2] * v[2],
    ]
}

/// `up` ± `x` ± `y` at the four corners of a square in the order of the rotors: front left, rear
/// left, rear right, front right.
#[inline(always)]
pub(crate) fn corners<N: Number>(x: N, y: N, up: N) -> [N; 4] {
    let (sum, difference) = (x + y, x - y);
    [up + sum, up - difference, up - sum, up + difference]
}

/// Components along `axes` of a world vector.
#[inline(always)]
pub(crate) fn along<N: Number>(axes: &Axes<N>, v: Vector<N>) -> Vector<N> {
    [dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)]
}

/// A unit quaternion w, x, y, z that turns body into world coordinates.
pub(crate) type Quaternion<N = f64> = [N; 4];

/// Hamilton's product.
#[inline(always)]
pub(crate) fn product<N: Number>(a: Quaternion<N>, b: Quaternion<N>) -> Quaternion<N> {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// `q` turned on by the rates ω (body axes) over a short time: `q + q ∘ (0, ω) t/2`,
/// `half_time_s` being t/2; not normalised.
#[inline(always)]
pub(crate) fn turned<N: Number>(
    q: Quaternion<N>,
    rates: Vector<N>,
    half_time_s: f64,
) -> Quaternion<N> {
    let [a, b, c] = scale(rates, half_time_s);
    product(q, [q[0].splat(1.0), a, b, c])
}

#[inline(always)]
pub(crate) fn normalised<N: Number>(q: Quaternion<N>) -> Quaternion<N> {
    let n = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let n = 1.0 / n;
    [q[0] * n, q[1] * n, q[2] * n, q[3] * n]
}

/// The body's axes in the world: columns of the rotation.
#[inline(always)]
pub(crate) fn axes_of<N: Number>([w, x, y, z]: Quaternion<N>) -> Axes<N> {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ],
        [
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        ],
        [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_axes_of_a_quaternion() {
        // 120° about (1, 1, 1) sends x to y, y to z, z to x: exact.
        let axes = axes_of([0.5, 0.5, 0.5, 0.5]);
        assert_eq!(axes, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        // A product of turns is the turn of the turned.
        let a = normalised([0.9, 0.1, -0.2, 0.3]);
        let b = normalised([0.7, -0.4, 0.5, 0.1]);
        let v = [0.3, -1.0, 2.0];
        let both = to_world(&axes_of(product(a, b)), v);
        let twice = to_world(&axes_of(a), to_world(&axes_of(b), v));
        // Rounding only.
        let back = along(&axes_of(a), to_world(&axes_of(a), v));
        for difference in [sub(both, twice), sub(back, v)] {
            assert!(dot(difference, difference).sqrt() < 1e-14);
        }
    }
}
