//! Vectors of three numbers and unit quaternions (w, x, y, z).

pub(crate) type Vector = [f64; 3];

#[inline]
pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(crate) fn scale(a: Vector, s: f64) -> Vector {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline]
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline]
pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Three orthonormal axes, in world coordinates.
pub(crate) type Axes = [Vector; 3];

/// World coordinates of a vector given along `axes`.
#[inline]
pub(crate) fn to_world(axes: &Axes, v: Vector) -> Vector {
    let [a, b, c] = axes;
    let at = |k: usize| a[k] * v[0] + b[k] * v[1] + c[k] * v[2];
    [at(0), at(1), at(2)]
}

/// Components along `axes` of a world vector.
#[inline]
pub(crate) fn along(axes: &Axes, v: Vector) -> Vector {
    [dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)]
}

/// A unit quaternion w, x, y, z that turns body into world coordinates.
pub(crate) type Quaternion = [f64; 4];

/// Hamilton's product.
#[inline]
pub(crate) fn product(a: Quaternion, b: Quaternion) -> Quaternion {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

#[inline]
pub(crate) fn normalised(q: Quaternion) -> Quaternion {
    let n = 1.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    [q[0] * n, q[1] * n, q[2] * n, q[3] * n]
}

/// The body's axes in the world: columns of the rotation.
#[inline]
pub(crate) fn axes_of([w, x, y, z]: Quaternion) -> Axes {
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
