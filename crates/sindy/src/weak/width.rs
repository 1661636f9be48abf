//! The half-width of the test functions, from the data.

use realfft::RealFftPlanner;

use crate::derivative::noise_level;
use crate::error::SindyError;

/// Samples below which a series does not identify its bandwidth: its spectrum has two dozen lines.
pub(super) const FEWEST: usize = 48;
/// Gain of the test function at the cut-off frequency: a tenth keeps the signal in, and most of the noise beyond out.
const LEFT: f64 = 0.1;
/// The least half-width in mean steps, so that sums approximate integrals.
const STEPS: f64 = 20.0;

/// The half-width for test functions `(1 - u²)^power`, in units of `time`, from `series` of times and values
/// (states only; no gaps). See [the module](super) for the rule.
///
/// # Errors
/// No series, or one with fewer than 48 samples, lengths that differ, values that are not finite, times
/// that do not increase.
pub fn choose_half_width(series: &[(&[f64], &[f64])], power: u32) -> Result<f64, SindyError> {
    let mut chosen = Vec::with_capacity(series.len());
    for (time, values) in series {
        if values.len() < FEWEST {
            return Err(SindyError::too_short(FEWEST, values.len()));
        }
        chosen.push(half_width_of(time, values, 1, (power, STEPS))?);
    }
    if chosen.is_empty() {
        return Err(SindyError::too_short(FEWEST, 0));
    }
    let middle = (chosen.len() - 1) / 2;
    Ok(*chosen.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The half-width for the derivative of this order of one series, at least so many mean `steps`.
pub(crate) fn half_width_of(
    time: &[f64],
    values: &[f64],
    order: u8,
    (power, steps): (u32, f64),
) -> Result<f64, SindyError> {
    let sigma = noise_level(time, values)?.sigma;
    let n = values.len();
    let span = time[n - 1] - time[0];
    let step = span / (n - 1) as f64;
    let mean = values.iter().sum::<f64>() / n as f64;
    // The signal on a uniform grid of as many samples, under a Hann taper, so that its ends leave no trace.
    let mut squares = 0.0;
    let mut i = 0;
    let mut tapered: Vec<f64> = (0..n)
        .map(|k| {
            let t = time[0] + step * k as f64;
            while i + 2 < n && time[i + 1] < t {
                i += 1;
            }
            let part = ((t - time[i]) / (time[i + 1] - time[i])).clamp(0.0, 1.0);
            let taper = (std::f64::consts::PI * k as f64 / (n - 1) as f64)
                .sin()
                .powi(2);
            squares += taper * taper;
            taper * (values[i] + part * (values[i + 1] - values[i]) - mean)
        })
        .collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = transform.make_output_vec();
    // Lengths fit by construction; a failure would leave the spectrum at zero, hence the widest window.
    if transform.process(&mut tapered, &mut spectrum).is_err() {
        return Ok(span / 4.0);
    }
    let noise = sigma * sigma * squares;
    // Mallows's criterion for the derivative: what is cut off, less noise, against the noise that passes.
    let (mut risk, mut least, mut cut) = (0.0, 0.0, 1);
    for (k, bin) in spectrum.iter().enumerate().skip(1) {
        risk += (k as f64).powi(2 * i32::from(order)) * (2.0 * noise - bin.norm_sqr());
        if risk < least {
            (least, cut) = (risk, k);
        }
    }
    let omega = std::f64::consts::TAU * cut as f64 / (step * n as f64);
    // The transform of (1 - u²)^p is close to exp(-(ω H)² / (2 (2 p + 3))).
    let width = (2.0 * (2.0 * f64::from(power) + 3.0) * -LEFT.ln()).sqrt() / omega;
    Ok(width.clamp(steps * step, (span / 4.0).max(steps * step)))
}
