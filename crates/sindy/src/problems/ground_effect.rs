//! A model of the ground-effect force over a moving platform.

use super::{Problem, Trajectory};

/// A published fit of the ground-effect force f in N on a multirotor above a moving platform, with the
/// throttle s in [0, 1], the height z above the platform in m, the vertical velocities of the platform v_p
/// and of the vehicle v_q in m/s, time in seconds,
///
/// ```text
/// f' = 0.804 - 0.088 f - 3.912 s + 0.586 z + 1.051 v_p - 1.049 v_q + 4.854 s^2
///      + 1.103 v_p v_q - 2.504 z^2 - 0.535 v_p^2 - 0.562 v_q^2
/// ```
///
/// five trajectories of 30 s at 100 Hz with smooth throttle, platform and vehicle motion, in which z is the
/// difference of the two heights and the velocities are their derivatives; library: these 11 terms. The
/// velocity terms are those of v_q - v_p to rounding, -1.05 v - 0.55 v^2, which makes this a test of
/// nearly dependent effects.
///
/// Source: equation (12) of "Data-Driven Modeling of Ground Effect For UAV Landing on a Vertical
/// Oscillating Platform".
#[must_use]
pub fn ground_effect() -> Problem {
    let truth = vec![
        ("1", 0.804),
        ("f", -0.088),
        ("s", -3.912),
        ("z", 0.586),
        ("v_p", 1.051),
        ("v_q", -1.049),
        ("s^2", 4.854),
        ("v_p*v_q", 1.103),
        ("z^2", -2.504),
        ("v_p^2", -0.535),
        ("v_q^2", -0.562),
    ];
    Problem {
        name: "ground effect",
        states: vec!["f"],
        inputs: vec!["s", "z", "v_p", "v_q"],
        terms: truth.iter().map(|(term, _)| (*term).to_owned()).collect(),
        truth: vec![truth],
        trajectories: (0..5_i32).map(|k| trajectory(f64::from(k))).collect(),
        step: 0.01,
        rows: 3000,
    }
}

/// The k-th of the trajectories: amplitudes, frequencies and phases differ from one to the next.
fn trajectory(k: f64) -> Trajectory {
    let throttle = format!(
        "{:?} + 0.08*sin({:?}*t + {k:?}) + 0.04*sin({:?}*t)",
        0.45 + 0.02 * k,
        0.7 + 0.11 * k,
        2.3 + 0.17 * k
    );
    // Heights q of the vehicle and p of the platform, and their derivatives.
    let (a, wa, b, wb) = (0.10 + 0.01 * k, 0.9 + 0.13 * k, 0.05, 2.1 - 0.19 * k);
    let (c, wc) = (0.04 + 0.015 * k, 1.6 + 0.23 * k);
    let q = format!("0.35 + {a:?}*sin({wa:?}*t + {k:?}) + {b:?}*sin({wb:?}*t)");
    let p = format!("{c:?}*sin({wc:?}*t + {:?})", 2.0 * k);
    let v_q = format!(
        "{:?}*cos({wa:?}*t + {k:?}) + {:?}*cos({wb:?}*t)",
        a * wa,
        b * wb
    );
    let v_p = format!("{:?}*cos({wc:?}*t + {:?})", c * wc, 2.0 * k);
    Trajectory {
        start: vec![0.4 + 0.2 * k],
        inputs: vec![throttle, format!("{q} - {p}"), v_p, v_q],
    }
}
