//! How the end of a step moves with its start.

use nalgebra::DMatrix;

/// The transition over a step by Runge–Kutta of order 4, from the Jacobians at its start, its middle and its end. The
/// four matrices between are scratch.
pub(super) fn transition(
    h: f64,
    [j0, jm, j1]: [&DMatrix<f64>; 3],
    [shifted, a2, a3, a4]: [&mut DMatrix<f64>; 4],
    out: &mut DMatrix<f64>,
) {
    let mut through =
        |jacobian: &DMatrix<f64>, by: &DMatrix<f64>, h: f64, to: &mut DMatrix<f64>| {
            // jacobian (I + h by)
            shifted.copy_from(by);
            *shifted *= h;
            add_identity(shifted);
            multiply(jacobian, shifted, to);
        };
    through(jm, j0, 0.5 * h, a2);
    through(jm, a2, 0.5 * h, a3);
    through(j1, a3, h, a4);
    out.zip_zip_apply(j0, a4, |t, a1, a4| *t = a1 + a4);
    out.zip_zip_apply(a2, a3, |t, a2, a3| *t = h / 6.0 * (*t + 2.0 * (a2 + a3)));
    add_identity(out);
}

/// The transition from the middle of a step to its end: the exponential of the mean Jacobian to second order, into `out`.
pub(super) fn second_half(
    h: f64,
    [jm, j1]: [&DMatrix<f64>; 2],
    mean: &mut DMatrix<f64>,
    out: &mut DMatrix<f64>,
) {
    mean.zip_zip_apply(jm, j1, |mean, jm, j1| *mean = 0.25 * h * (jm + j1));
    multiply(mean, mean, out);
    out.zip_apply(mean, |out, mean| *out = 0.5 * *out + mean);
    add_identity(out);
}

/// `to = a b` for a square `a` of few rows, for which general products take longer to start than to compute.
pub(in crate::trajectory::output_error) fn multiply(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    to: &mut DMatrix<f64>,
) {
    let n = a.nrows();
    let (a, columns) = (a.as_slice(), b.as_slice().chunks_exact(n));
    for (to, b) in to.as_mut_slice().chunks_exact_mut(n).zip(columns) {
        to.fill(0.0);
        for (a, b) in a.chunks_exact(n).zip(b) {
            to.iter_mut().zip(a).for_each(|(to, a)| *to += a * b);
        }
    }
}

fn add_identity(square: &mut DMatrix<f64>) {
    (0..square.nrows()).for_each(|i| square[(i, i)] += 1.0);
}
