//! Test functions on a grid: quadrature weights and the placing of windows.

use std::ops::Range;

use rayon::prelude::*;

/// Samples that a window needs on either side of its centre: a test function of fewer is no quadrature.
pub(super) const REACH: usize = 4;

/// One test function: the rows inside its support, with the weights of its two sums.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    /// Rows strictly inside the support.
    pub rows: Range<usize>,
    /// `w_i φ(t_i)`, in units of time.
    pub value: Vec<f64>,
    /// `w_i φ'(t_i)`, without unit.
    pub slope: Vec<f64>,
}

/// Quadrature weights of the rows of `time` (increasing): on a step the integral of the cubic through its
/// four nearest samples, or the trapezoid where that cubic would weigh a sample more than the step is
/// long. On a uniform grid, all but the outermost weights are the trapezoid's.
pub(super) fn quadrature(time: &[f64]) -> Vec<f64> {
    let n = time.len();
    let mut weights = vec![0.0; n];
    for i in 1..n {
        let step = time[i] - time[i - 1];
        let cubic = (i >= 2 && i + 1 < n).then(|| cubic(&time[i - 2..i + 2], step));
        match cubic.filter(|c| c.iter().all(|w| w.abs() <= step)) {
            Some(c) => (0..4).for_each(|k| weights[i - 2 + k] += c[k]),
            None => {
                weights[i - 1] += 0.5 * step;
                weights[i] += 0.5 * step;
            }
        }
    }
    weights
}

/// Weights of four samples for the integral over the middle step: Lagrange's polynomials by Gauss's rule of
/// two points, which is exact for cubics.
fn cubic(t: &[f64], step: f64) -> [f64; 4] {
    let middle = 0.5 * (t[1] + t[2]);
    let node = 0.5 * step / 3f64.sqrt();
    std::array::from_fn(|k| {
        let lagrange = |s: f64| {
            (0..4)
                .filter(|&l| l != k)
                .map(|l| (s - t[l]) / (t[k] - t[l]))
                .product::<f64>()
        };
        0.5 * step * (lagrange(middle - node) + lagrange(middle + node))
    })
}

/// Windows over one stretch of rows without gaps: centres on samples, at least `spacing` apart, the whole
/// support within the stretch and [`REACH`] samples on either side.
pub(crate) fn place(time: &[f64], half_width: f64, spacing: f64, power: i32) -> Vec<Window> {
    let n = time.len();
    if n == 0 {
        return Vec::new();
    }
    let weights = quadrature(time);
    // Half a part in a million: a support that ends at the first or last sample is inside.
    let reach = half_width * (1.0 - 5e-7);
    let mut next = time[0] + reach;
    let mut places = Vec::new();
    for centre in 0..n {
        let c = time[centre];
        if c < next {
            continue;
        }
        if c + reach > time[n - 1] {
            break;
        }
        next = c + spacing * (1.0 - 1e-9);
        let first = time.partition_point(|&t| t <= c - half_width);
        let last = time.partition_point(|&t| t < c + half_width);
        if centre - first < REACH || last - centre <= REACH {
            continue;
        }
        places.push((c, first..last));
    }
    let window = |(c, rows): (f64, Range<usize>)| {
        let mut value = Vec::with_capacity(rows.len());
        let mut slope = Vec::with_capacity(rows.len());
        for i in rows.clone() {
            let u = (time[i] - c) / half_width;
            let s = (1.0 - u * u).max(0.0);
            value.push(weights[i] * s.powi(power));
            slope.push(weights[i] * -2.0 * f64::from(power) * u * s.powi(power - 1) / half_width);
        }
        Window { rows, value, slope }
    };
    places.into_par_iter().map(window).collect()
}
