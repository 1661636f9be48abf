//! Signals with known derivatives, and seeded noise, for the tests of this module.

use rand::RngExt;
use rand::SeedableRng;

/// Independent standard normal numbers (Box–Muller).
pub(crate) fn gauss(seed: u64, n: usize) -> Vec<f64> {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    (0..n)
        .map(|_| {
            let (u, v): (f64, f64) = (rng.random(), rng.random());
            (-2.0 * (1.0 - u).ln()).sqrt() * (2.0 * std::f64::consts::PI * v).cos()
        })
        .collect()
}

/// A state and its derivative.
pub(crate) type Column = (Vec<f64>, Vec<f64>);

/// A system's states and their derivatives, column by column: RK4 with 10 steps a sample.
pub(crate) fn simulate<const N: usize>(
    rhs: impl Fn([f64; N]) -> [f64; N],
    start: [f64; N],
    n: usize,
    dt: f64,
) -> (Vec<f64>, Vec<Column>) {
    let mut x = start;
    let mut out = vec![(Vec::with_capacity(n), Vec::with_capacity(n)); N];
    let h = dt / 10.0;
    for _ in 0..n {
        let d = rhs(x);
        for (k, column) in out.iter_mut().enumerate() {
            column.0.push(x[k]);
            column.1.push(d[k]);
        }
        for _ in 0..10 {
            let at = |k: &[f64; N], s: f64| std::array::from_fn(|i| x[i] + s * k[i]);
            let k1 = rhs(x);
            let k2 = rhs(at(&k1, h / 2.0));
            let k3 = rhs(at(&k2, h / 2.0));
            let k4 = rhs(at(&k3, h));
            x = std::array::from_fn(|i| {
                x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            });
        }
    }
    ((0..n).map(|i| dt * i as f64).collect(), out)
}

/// Time, first state and its derivative of the Lorenz system from (-8, 7, 27).
pub(crate) fn lorenz(n: usize, dt: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (t, mut states) = simulate(lorenz_rhs, [-8.0, 7.0, 27.0], n, dt);
    let (x, dx) = states.swap_remove(0);
    (t, x, dx)
}

/// Lorenz (10, 28, 8/3).
pub(crate) fn lorenz_rhs([x, y, z]: [f64; 3]) -> [f64; 3] {
    [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z]
}
