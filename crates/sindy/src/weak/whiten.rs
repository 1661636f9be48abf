//! Decorrelation of overlapping windows: the covariance of the weak residual and its banded Cholesky factor.

use nalgebra::DMatrix;

use super::window::Window;

/// Share of each variance that is added to the diagonal, so that overlapping windows stay invertible; it costs about as
/// small a share of the information.
const NUGGET: f64 = 1e-4;

/// Replaces the rows of `matrix`, one for each of `windows` in order, by `L⁻¹ D⁻¹` times them, where
/// `D (R + ν I) D = D L Lᵀ D`, `D² = diag C`, and `C_kl = Σ_i w_i² φ'_k(t_i) φ'_l(t_i)`.
pub(super) fn whiten(windows: &[&Window], matrix: &mut DMatrix<f64>) {
    let deviation: Vec<f64> = windows
        .iter()
        .map(|w| w.slope.iter().map(|s| s * s).sum::<f64>().sqrt())
        .collect();
    // Row k of L from its first column inside the band, which starts at `from[k]`.
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(windows.len());
    let mut from: Vec<usize> = Vec::with_capacity(windows.len());
    let columns = matrix.ncols();
    for k in 0..windows.len() {
        let start = from.last().copied().unwrap_or(0);
        let first = (start..k)
            .find(|&l| windows[l].rows.end > windows[k].rows.start)
            .unwrap_or(k);
        let mut row = Vec::with_capacity(k - first + 1);
        for l in first..=k {
            let mut c = overlap(windows[k], windows[l]) / (deviation[k] * deviation[l]);
            if l == k {
                c += NUGGET;
            }
            let other: &[f64] = if l == k { &row } else { &factor[l] };
            let low = first.max(if l == k { first } else { from[l] });
            let other_first = if l == k { first } else { from[l] };
            for j in low..l {
                c -= row[j - first] * other[j - other_first];
            }
            row.push(if l == k {
                // The nugget bounds the pivot from below but for rounding.
                c.max(NUGGET * 0.5).sqrt()
            } else {
                c / factor[l][l - from[l]]
            });
        }
        for column in 0..columns {
            let mut v = matrix[(k, column)] / deviation[k];
            for l in first..k {
                v -= row[l - first] * matrix[(l, column)];
            }
            matrix[(k, column)] = v / row[k - first];
        }
        factor.push(row);
        from.push(first);
    }
}

/// `Σ_i w_i² φ'_a φ'_b` over the rows that both windows cover.
fn overlap(a: &Window, b: &Window) -> f64 {
    let from = a.rows.start.max(b.rows.start);
    let to = a.rows.end.min(b.rows.end);
    (from..to)
        .map(|i| a.slope[i - a.rows.start] * b.slope[i - b.rows.start])
        .sum()
}
