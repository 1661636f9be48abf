//! Savitzky–Golay smoothing and differentiation.
//!
//! In a window of `2 h + 1` samples around sample `i` a polynomial of degree `d` is fitted by least
//! squares; the smoothed value is the polynomial at `t_i`, the derivative its slope there:
//!
//! ```text
//! min_a  Σ_{k = i-h}^{i+h} ( y_k - Σ_j a_j (t_k - t_i)^j )²,    ŷ_i = a_0,   ẏ_i = a_1
//! ```
//!
//! On a uniform grid this is a convolution with fixed weights. On a non-uniform grid the polynomial is
//! fitted to the true times, sample by sample. The first and last `h` samples use the polynomial of the
//! first and last whole window (SciPy's `mode="interp"`).
//!
//! Source: A. Savitzky, M. J. E. Golay, "Smoothing and differentiation of data by simplified least
//! squares procedures", Analytical Chemistry 36 (1964).

use nalgebra::{DMatrix, DVector};

use crate::data::grid;
use crate::error::{SindyError, require};

/// Outputs that the convolution holds in registers at a time.
const TILE: usize = 16;

/// Settings of a Savitzky–Golay filter, checked when built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SavitzkyGolay {
    window: usize,
    degree: usize,
}

/// Smoothed values and first derivatives, one of each per sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The smoothed signal, in the signal's unit.
    pub value: Vec<f64>,
    /// Its time derivative, in the signal's unit per unit of time.
    pub derivative: Vec<f64>,
}

impl SavitzkyGolay {
    /// A filter over `window` samples (odd) with polynomials of `degree` (below `window`).
    ///
    /// # Errors
    /// An even or too short window, or a degree that the window does not determine.
    pub fn new(window: usize, degree: usize) -> Result<Self, SindyError> {
        require(
            !window.is_multiple_of(2),
            "window",
            "an odd number of samples",
            window,
        )?;
        if degree == 0 || degree >= window {
            return Err(SindyError::setting(
                "degree",
                format!("1 to {} (below the window)", window.saturating_sub(1)),
                degree,
            ));
        }
        require(degree <= 12, "degree", "at most 12", degree)?;
        Ok(Self { window, degree })
    }

    /// The number of samples in a window.
    #[must_use]
    pub fn window(&self) -> usize {
        self.window
    }

    /// The degree of the polynomials.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Smooths `y` sampled at `time` and differentiates it.
    ///
    /// # Errors
    /// Fewer samples than a window, lengths that differ, non-finite values, or times that do not increase.
    pub fn apply(&self, time: &[f64], y: &[f64]) -> Result<Smoothed, SindyError> {
        let mut out = Smoothed {
            value: vec![0.0; y.len()],
            derivative: vec![0.0; y.len()],
        };
        self.apply_into(time, y, &mut out)?;
        Ok(out)
    }

    /// As [`SavitzkyGolay::apply`], into columns that are used again: on millions of samples most of the time
    /// of `apply` goes into fresh memory.
    ///
    /// # Errors
    /// As [`SavitzkyGolay::apply`].
    pub fn apply_into(
        &self,
        time: &[f64],
        y: &[f64],
        out: &mut Smoothed,
    ) -> Result<(), SindyError> {
        grid::check(time, y, self.window)?;
        out.value.resize(y.len(), 0.0);
        out.derivative.resize(y.len(), 0.0);
        match grid::uniform_period(time) {
            Some(dt) => self.uniform(dt, y, out),
            None => self.non_uniform(time, y, out),
        }
    }

    fn uniform(&self, dt: f64, y: &[f64], out: &mut Smoothed) -> Result<(), SindyError> {
        let (n, w, h) = (y.len(), self.window, self.window / 2);
        let (even, odd) = central_weights(h, self.degree);
        let scaled: Vec<f64> = odd.iter().map(|w| w / dt).collect();
        let inner = h..n - h;
        let (value, derivative) = (&mut out.value[inner.clone()], &mut out.derivative[inner]);
        pulp::Arch::new().dispatch(Convolution {
            y,
            even: &even,
            odd: &scaled,
            value,
            derivative,
        });
        let offsets: Vec<f64> = (0..w).map(|k| (k as f64 - h as f64) / h as f64).collect();
        let fit = projector(&offsets, self.degree)?; // (degree+1) x w, in units of h samples
        let scale = 1.0 / (h as f64 * dt);
        for (start, range) in [(0, 0..h), (n - w, n - h..n)] {
            let a = &fit * DVector::from_column_slice(&y[start..start + w]);
            for i in range {
                let u = (i as f64 - (start + h) as f64) / h as f64;
                let (value, slope) = horner(a.as_slice(), u);
                out.value[i] = value;
                out.derivative[i] = slope * scale;
            }
        }
        Ok(())
    }

    fn non_uniform(&self, time: &[f64], y: &[f64], out: &mut Smoothed) -> Result<(), SindyError> {
        let (n, w, h) = (y.len(), self.window, self.window / 2);
        let mut window = Window::new(w);
        for i in h..n - h {
            let centre = time[i];
            let span = (time[i + h] - time[i - h]) * 0.5;
            let (value, slope) = window.fit(
                time[i - h..=i + h].iter().map(|t| (t - centre) / span),
                &y[i - h..=i + h],
                self.degree,
            );
            out.value[i] = value;
            out.derivative[i] = slope / span;
        }
        for (start, range) in [(0, 0..h), (n - w, n - h..n)] {
            let centre = time[start + h];
            let span = (time[start + w - 1] - time[start]) * 0.5;
            let offsets: Vec<f64> = time[start..start + w]
                .iter()
                .map(|t| (t - centre) / span)
                .collect();
            let fit = projector(&offsets, self.degree)?;
            let a = &fit * DVector::from_column_slice(&y[start..start + w]);
            for i in range {
                let (value, slope) = horner(a.as_slice(), (time[i] - centre) / span);
                out.value[i] = value;
                out.derivative[i] = slope / span;
            }
        }
        Ok(())
    }
}

/// Room for one window of a non-uniform grid: its times, and two orthogonal polynomials on them.
struct Window {
    x: Vec<f64>,
    p: Vec<f64>,
    before: Vec<f64>,
}

impl Window {
    fn new(w: usize) -> Self {
        Self {
            x: vec![0.0; w],
            p: vec![0.0; w],
            before: vec![0.0; w],
        }
    }

    /// Value and slope at 0 of the least-squares polynomial through `y` at `x`: the sum over the polynomials
    /// that are orthogonal on `x`, by their three-term recurrence (G. E. Forsythe, J. SIAM 5 (1957)).
    fn fit(&mut self, x: impl Iterator<Item = f64>, y: &[f64], degree: usize) -> (f64, f64) {
        let Self {
            x: times,
            p,
            before,
        } = self;
        times.iter_mut().zip(x).for_each(|(t, x)| *t = x);
        p.fill(1.0);
        before.fill(0.0);
        // The polynomial and the one before at 0, and their slopes there.
        let (mut at, mut slope, mut at_before, mut slope_before) = (1.0, 0.0, 0.0, 0.0);
        let mut norm_before = f64::INFINITY;
        let mut out = (0.0, 0.0);
        for _ in 0..=degree {
            let (mut norm, mut moment, mut with_y) = (0.0, 0.0, 0.0);
            for ((p, x), y) in p.iter().zip(&*times).zip(y) {
                norm += p * p;
                moment += x * p * p;
                with_y += p * y;
            }
            let c = with_y / norm;
            out.0 += c * at;
            out.1 += c * slope;
            let (a, b) = (moment / norm, norm / norm_before);
            for ((p, before), x) in p.iter_mut().zip(&mut *before).zip(&*times) {
                (*before, *p) = (*p, (x - a) * *p - b * *before);
            }
            (slope_before, slope) = (slope, at - a * slope - b * slope_before);
            (at_before, at) = (at, -a * at - b * at_before);
            norm_before = norm;
        }
        out
    }
}

/// The matrix that turns window values into polynomial coefficients: the pseudo-inverse of the
/// Vandermonde matrix of `offsets`, by QR.
fn projector(offsets: &[f64], degree: usize) -> Result<DMatrix<f64>, SindyError> {
    let v = DMatrix::from_fn(offsets.len(), degree + 1, |i, j| offsets[i].powi(j as i32));
    let qr = v.qr();
    let qt = qr.q().transpose();
    qr.r()
        .solve_upper_triangular(&qt)
        .ok_or(SindyError::Singular {
            what: "Savitzky–Golay window",
        })
}

/// Weights of value and slope at the centre of a uniform window of `2 h + 1` samples: of the value those
/// at the centre and to its right (symmetric), of the slope, per sample, those to its right (antisymmetric).
///
/// Sums over the polynomials that are orthogonal on the window, by their three-term recurrence.
pub(crate) fn central_weights(h: usize, degree: usize) -> (Vec<f64>, Vec<f64>) {
    let x: Vec<f64> = (0..=h).map(|k| k as f64 / h as f64).collect();
    let mut before = vec![0.0; h + 1];
    let mut p = vec![1.0; h + 1];
    // Slopes at the centre of the last two polynomials.
    let (mut slope_before, mut slope) = (0.0, 0.0);
    let mut norm_before = 1.0;
    let (mut even, mut odd) = (vec![0.0; h + 1], vec![0.0; h]);
    for j in 0..=degree {
        let norm = p[0] * p[0] + 2.0 * p[1..].iter().map(|p| p * p).sum::<f64>();
        let (value, turn) = (p[0] / norm, slope / (norm * h as f64));
        if j % 2 == 0 {
            even.iter_mut().zip(&p).for_each(|(w, p)| *w += value * p);
        } else {
            odd.iter_mut()
                .zip(&p[1..])
                .for_each(|(w, p)| *w += turn * p);
        }
        let b = if j == 0 { 0.0 } else { norm / norm_before };
        let centre = p[0];
        for ((before, p), x) in before.iter_mut().zip(&mut p).zip(&x) {
            (*before, *p) = (*p, x * *p - b * *before);
        }
        (slope_before, slope) = (slope, centre - b * slope_before);
        norm_before = norm;
    }
    (even, odd)
}

/// [`convolve`] in whatever vector instructions the processor has: the same operations in the same order, so the
/// same bits on every machine.
struct Convolution<'a> {
    y: &'a [f64],
    even: &'a [f64],
    odd: &'a [f64],
    value: &'a mut [f64],
    derivative: &'a mut [f64],
}

impl pulp::WithSimd for Convolution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        convolve(self.y, self.even, self.odd, self.value, self.derivative);
    }
}

/// `value_i = e_0 y_i + Σ e_k (y_{i+k} + y_{i-k})`, `derivative_i = Σ o_k (y_{i+k} - y_{i-k})`, with outputs
/// starting `h` samples into `y`.
#[inline(always)]
fn convolve(y: &[f64], even: &[f64], odd: &[f64], value: &mut [f64], derivative: &mut [f64]) {
    let h = odd.len();
    let tiles = value.len() / TILE * TILE;
    let (value, value_rest) = value.split_at_mut(tiles);
    let (derivative, derivative_rest) = derivative.split_at_mut(tiles);
    let whole = value
        .chunks_exact_mut(TILE)
        .zip(derivative.chunks_exact_mut(TILE));
    for (t, (value, derivative)) in whole.enumerate() {
        let part = &y[t * TILE..t * TILE + TILE + 2 * h];
        let mut v: [f64; TILE] = std::array::from_fn(|i| even[0] * part[h + i]);
        let mut d = [0.0; TILE];
        for k in 1..=h {
            let (e, o) = (even[k], odd[k - 1]);
            let right = &part[h + k..h + k + TILE];
            let left = &part[h - k..h - k + TILE];
            for i in 0..TILE {
                v[i] += e * (right[i] + left[i]);
                d[i] += o * (right[i] - left[i]);
            }
        }
        value.copy_from_slice(&v);
        derivative.copy_from_slice(&d);
    }
    let rest = value_rest.iter_mut().zip(derivative_rest).enumerate();
    for (i, (value, derivative)) in rest {
        let centre = tiles + i + h;
        (*value, *derivative) = (even[0] * y[centre], 0.0);
        for k in 1..=h {
            *value += even[k] * (y[centre + k] + y[centre - k]);
            *derivative += odd[k - 1] * (y[centre + k] - y[centre - k]);
        }
    }
}

/// Value and slope of the polynomial with coefficients `a` (lowest first) at `u`.
fn horner(a: &[f64], u: f64) -> (f64, f64) {
    a.iter()
        .rev()
        .fold((0.0, 0.0), |(p, d), &c| (p * u + c, d * u + p))
}

#[cfg(test)]
mod tests;
