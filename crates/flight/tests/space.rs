//! Vectors and attitudes against closed forms.

use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;
use touchdown_flight::{Attitude, Real, Vector};

type V = Vector<f64>;
type A = Attitude<f64>;

fn distance<R: Real>(a: Vector<R>, b: Vector<R>) -> f64 {
    (a - b).norm().to_f64()
}

#[test]
fn analytic_vectors() {
    let (a, b) = (V::new(1.0, 2.0, -2.0), V::new(-3.0, 0.5, 4.0));
    assert_eq!(a.norm(), 3.0);
    assert_eq!(a.dot(b), -10.0);
    assert_eq!(a.cross(b), V::new(9.0, 2.0, 6.5));
    assert_eq!(a.limited(1.5), V::new(0.5, 1.0, -1.0));
    assert_eq!(a.limited(5.0), a);
    assert_eq!(a.horizontal(), V::new(1.0, 2.0, 0.0));
    // Squares that overflow or vanish do not.
    assert!((V::new(3e200, 4e200, 0.0).norm() / 5e200 - 1.0).abs() < 1e-15);
    assert!((V::new(3e-200, 0.0, 4e-200).norm() / 5e-200 - 1.0).abs() < 1e-15);
    assert_eq!(V::ZERO.direction(), None);
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(V::new(0.0, bad, 1.0).direction(), None);
        assert_eq!(V::new(0.0, bad, 1.0).finite_or(a), a);
    }
}

#[test]
fn analytic_a_third_of_a_turn() {
    // 120° about (1, 1, 1) sends x to y, y to z, z to x.
    let turn = A::from_quaternion([0.5; 4]).unwrap();
    let v = V::new(1.0, 2.0, 3.0);
    assert_eq!(turn.rotate(v), V::new(3.0, 1.0, 2.0));
    assert_eq!(turn.unrotate(turn.rotate(v)), v);
    let third = turn.rotation_vector();
    // Rounding of numbers of order one.
    assert!(
        distance(
            third,
            V::new(1.0, 1.0, 1.0) * (2.0 * PI / 3.0 / 3f64.sqrt())
        ) < 1e-15
    );
}

#[test]
fn analytic_a_quaternion_and_its_negative_are_one_attitude() {
    let turn = Vector::new(0.4, -0.2, 0.7);
    let q = Attitude::from_rotation_vector(turn).to_quaternion();
    for sign in [1.0, -1.0] {
        let same = Attitude::from_quaternion(q.map(|part: f64| sign * part)).unwrap();
        // A few roundings of numbers below one.
        assert!((same.rotation_vector() - turn).norm() < 1e-15, "{sign}");
    }
}

#[test]
fn analytic_lengths_at_the_ends_of_the_range() {
    for scale in [1e-200, 1e-13, 1.0, 1e16, 1e200] {
        let length = Vector::new(3.0 * scale, -4.0 * scale, 12.0 * scale).norm();
        assert!((length / (13.0 * scale) - 1.0).abs() < 1e-15, "{length}");
    }
    let infinite = f64::INFINITY;
    assert_eq!(Vector::new(infinite, -infinite, infinite).norm(), infinite);
    assert_eq!(Vector::<f64>::ZERO.norm(), 0.0);
    assert!(Vector::new(0.0, f64::NAN, 1.0).norm().is_nan());
}

#[test]
fn analytic_level_is_exact() {
    assert_eq!(A::from_thrust_direction(V::UP, 0.0), Some(A::LEVEL));
    assert_eq!(A::from_thrust_direction(V::UP * 13.4, 0.0), Some(A::LEVEL));
    let v = V::new(0.1, -0.7, 13.4397);
    assert_eq!(A::LEVEL.rotate(v), v);
    assert_eq!(A::LEVEL.tilt_rad(), 0.0);
    assert_eq!(A::LEVEL.yaw_rad(), 0.0);
    assert_eq!(A::LEVEL.up(), V::UP);
}

#[test]
fn analytic_rates_integrate_exactly() {
    // Yawing at 2 rad/s while pitched: after π/2 rad about the body's own z.
    let pitched = A::from_rotation_vector(V::new(0.0, 0.3, 0.0));
    let one = pitched.after(V::new(0.0, 0.0, 2.0), FRAC_PI_2 / 2.0);
    // Body z is unchanged, body x is where body y was.
    assert!(distance(one.up(), pitched.up()) < 1e-15);
    let x = one.rotate(V::new(1.0, 0.0, 0.0));
    assert!(distance(x, V::new(0.0, 1.0, 0.0)) < 1e-15);
    // Thousand small steps make the one: at rest in the rate, exact but for rounding.
    let rates = V::new(0.7, -1.1, 2.0);
    let mut many = pitched;
    for _ in 0..1000 {
        many = many.after(rates, 1e-3);
    }
    let apart = (many.inverse() * pitched.after(rates, 1.0)).rotation_vector();
    // 1000 roundings of 1e-16, in random directions and at worst in one.
    assert!(apart.norm() < 1e-13);
}

#[test]
fn analytic_tilt_near_zero_keeps_its_digits() {
    for tilt in [1e-12, 1e-7, 1e-3, 1.0, 3.0] {
        let a = A::from_rotation_vector(V::new(0.6, 0.8, 0.0) * tilt);
        // acos of the cosine would lose everything below 1e-8.
        assert!((a.tilt_rad() / tilt - 1.0).abs() < 1e-14, "{tilt}");
    }
}

#[test]
fn analytic_refuses_what_is_no_attitude() {
    assert_eq!(A::from_quaternion([0.0; 4]), None);
    assert_eq!(A::from_quaternion([1.0, f64::NAN, 0.0, 0.0]), None);
    assert_eq!(A::from_thrust_direction(V::ZERO, 0.0), None);
    assert_eq!(A::from_thrust_direction(V::UP, f64::NAN), None);
    let error = A::try_from([0.0; 4]).unwrap_err().to_string();
    assert_eq!(
        error,
        "attitude: expected a finite quaternion (w, x, y, z) other than 0, found 0"
    );
}

#[cfg(feature = "serde")]
#[test]
fn analytic_serde_round_trip_and_refusal() {
    let a = A::from_quaternion([0.5; 4]).unwrap();
    let text = serde_json::to_string(&a).unwrap();
    assert_eq!(text, "[0.5,0.5,0.5,0.5]");
    assert_eq!(serde_json::from_str::<A>(&text).unwrap(), a);
    assert!(serde_json::from_str::<A>("[0.0,0.0,0.0,0.0]").is_err());
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.0..3.0)
}

fn quaternion() -> impl Strategy<Value = [f64; 4]> {
    prop::array::uniform4(-1.0..1.0).prop_filter("long enough", |q: &[f64; 4]| {
        q.iter().map(|c| c * c).sum::<f64>() > 1e-3
    })
}

fn single(v: V) -> Vector<f32> {
    Vector::from_array(v.to_array().map(|c| c as f32))
}

proptest! {
    #[test]
    fn prop_a_product_turns_twice(a in quaternion(), b in quaternion(), v in vector()) {
        let (a, b) = (A::from_quaternion(a).unwrap(), A::from_quaternion(b).unwrap());
        let v = V::from_array(v);
        // A dozen roundings of numbers up to 5.
        prop_assert!(distance((a * b).rotate(v), a.rotate(b.rotate(v))) < 1e-14);
        prop_assert!(distance((a * a.inverse()).rotate(v), v) < 1e-14);
        prop_assert!((a.rotate(v).norm() - v.norm()).abs() < 1e-14);
    }

    #[test]
    fn prop_rotation_vectors_round_trip(v in vector()) {
        let v = V::from_array(v).limited(3.1);
        // Near half a turn the logarithm's error grows to that of an angle, 1e-15.
        prop_assert!(distance(A::from_rotation_vector(v).rotation_vector(), v) < 1e-13);
        let coarse = Attitude::<f32>::from_rotation_vector(single(v)).rotation_vector();
        // A few roundings of single precision, 1.2e-7, of numbers up to 3.
        prop_assert!(distance(coarse, single(v)) < 3e-6);
    }

    #[test]
    fn prop_thrust_direction_and_yaw_are_met(v in vector(), yaw in -3.1..3.1) {
        let v = V::from_array(v);
        prop_assume!(v.norm() > 1e-3);
        let a = A::from_thrust_direction(v, yaw).unwrap();
        prop_assert!(distance(a.up(), v.direction().unwrap()) < 1e-14);
        if v.z > 0.1 {
            // Pitch below 90°, by more than 1.9°: the error of the heading is that of
            // the axis over its horizontal part, at least 0.03.
            prop_assert!((a.yaw_rad() - yaw).abs() < 1e-13);
        }
    }
}
