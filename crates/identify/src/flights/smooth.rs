//! Channels made fit for use: holes filled, spikes taken out, derivatives by local parabolas.

use nalgebra::{Matrix3, Vector3};

/// Longest hole in a channel that is filled from its neighbours (s).
/// A vehicle in flight does not turn within it; a longer one may hide a landing. Half drops heights of 2 Hz sensors.
pub(super) const LONGEST_HOLE_S: f64 = 0.5;
/// Half of the window whose median a height is judged by (s).
/// Spikes of range finders are shorter; a climb of 5 m/s stays within its own spread.
const MEDIAN_HALF_S: f64 = 0.5;
/// A height this far from the median around it is a spike, if it is also many times as far as its neighbours are (m).
/// Above the noise of any height sensor in use. On logs without spikes nothing moves (measured).
const SPIKE_M: f64 = 0.3;
/// How many times.
/// One value in 5e8 of a normal distribution. On logs without spikes nothing moves (measured).
const SPIKE_SPREADS: f64 = 6.0;
/// No vehicle climbs so fast: such a step of the height is a leap of the sensor (m/s).
/// Faster than multirotors climb or fall. On logs without spikes nothing moves (measured).
const LEAP_MPS: f64 = 20.0;
/// A stretch between two leaps is wrong if it is shorter than this (s).
/// Outages of range finders last a second or two. Longer ones may be flight, and stay.
const EXCURSION_S: f64 = 5.0;
/// Values in a median at most.
/// Bounds the cost of 1 kHz logs: 101 values give the median's place to a tenth of the spread.
const MOST_IN_MEDIAN: usize = 101;

/// Holes up to [`LONGEST_HOLE_S`] filled: held at the value before, or on a line between neighbours.
pub(super) fn filled(time: &[f64], values: &[f64], hold: bool) -> Vec<f64> {
    let mut out = values.to_vec();
    let mut last: Option<usize> = None;
    for i in 0..values.len() {
        if !values[i].is_finite() {
            continue;
        }
        if let Some(k) = last.filter(|&k| k + 1 < i && time[i] - time[k] <= LONGEST_HOLE_S) {
            for j in k + 1..i {
                let share = if hold {
                    0.0
                } else {
                    (time[j] - time[k]) / (time[i] - time[k])
                };
                out[j] = values[k] + share * (values[i] - values[k]);
            }
        }
        last = Some(i);
    }
    out
}

/// Every index, with those of the times within `half_s` of its own.
fn windows(
    time: &[f64],
    half_s: f64,
) -> impl Iterator<Item = (usize, std::ops::RangeInclusive<usize>)> + '_ {
    let (mut a, mut b) = (0, 0);
    (0..time.len()).map(move |i| {
        while time[i] - time[a] > half_s {
            a += 1;
        }
        while b + 1 < time.len() && time[b + 1] - time[i] <= half_s {
            b += 1;
        }
        (i, a..=b)
    })
}

/// Value (0), slope (1) or curvature (2) of the parabola through the values within `half_s`, by least squares.
pub(super) fn local_parabola(
    time: &[f64],
    values: &[f64],
    half_s: f64,
    derivative: usize,
) -> Vec<f64> {
    windows(time, half_s)
        .map(|(i, around)| {
            let (mut gram, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for k in around.filter(|&k| values[k].is_finite()) {
                let t = (time[k] - time[i]) / half_s;
                let powers = Vector3::new(1.0, t, t * t);
                gram += powers * powers.transpose();
                right += values[k] * powers;
            }
            // Fewer than three values have no parabola, and where there is none there is none around it.
            match gram.try_inverse() {
                Some(inverse) if values[i].is_finite() => {
                    let fitted = inverse * right;
                    match derivative {
                        0 => fitted.x,
                        1 => fitted.y / half_s,
                        _ => 2.0 * fitted.z / (half_s * half_s),
                    }
                }
                _ => f64::NAN,
            }
        })
        .collect()
}

/// Mean with the weights `(1 - (t/half)²)^power`: what the slope (`power` 1) or the curvature (2) of a local parabola is
/// of the signal's true first or second derivative.
pub(super) fn bump(time: &[f64], values: &[f64], half_s: f64, power: i32) -> Vec<f64> {
    windows(time, half_s)
        .map(|(i, around)| {
            let (sum, weight) =
                around
                    .filter(|&k| values[k].is_finite())
                    .fold((0.0, 0.0), |(sum, weight), k| {
                        let t = (time[k] - time[i]) / half_s;
                        let w = (1.0 - t * t).max(0.0).powi(power) + 1e-12;
                        (sum + w * values[k], weight + w)
                    });
            sum / weight
        })
        .collect()
}

/// Takes out of heights what cannot be: spikes of less than half a second, and stretches of some seconds between two leaps.
/// Gives their count; they are gaps then.
pub(super) fn without_spikes(time: &[f64], height: &mut [f64]) -> usize {
    let before = height.iter().filter(|z| z.is_finite()).count();
    let known: Vec<usize> = (0..height.len())
        .filter(|&i| height[i].is_finite())
        .collect();
    let (mut a, mut b) = (0, 0);
    let mut spikes = Vec::new();
    let mut near = Vec::new();
    for &i in &known {
        while time[i] - time[known[a]] > MEDIAN_HALF_S {
            a += 1;
        }
        while b + 1 < known.len() && time[known[b + 1]] - time[i] <= MEDIAN_HALF_S {
            b += 1;
        }
        let every = (b + 1 - a).div_ceil(MOST_IN_MEDIAN);
        near.clear();
        near.extend(known[a..=b].iter().step_by(every).map(|&k| height[k]));
        let middle = middle(&mut near);
        let far = (height[i] - middle).abs();
        // Most heights lie near their median: the spread is only asked for where one does not.
        if far <= SPIKE_M {
            continue;
        }
        near.iter_mut().for_each(|z| *z = (*z - middle).abs());
        let spread = 1.4826 * self::middle(&mut near);
        if far > SPIKE_SPREADS * spread {
            spikes.push(i);
        }
    }
    for i in spikes {
        height[i] = f64::NAN;
    }
    excursions(time, height);
    before - height.iter().filter(|z| z.is_finite()).count()
}

/// Stretches between two leaps.
fn excursions(time: &[f64], height: &mut [f64]) {
    let known: Vec<usize> = (0..height.len())
        .filter(|&i| height[i].is_finite())
        .collect();
    let leaps: Vec<usize> = (1..known.len())
        .filter(|&k| {
            let (a, b) = (known[k - 1], known[k]);
            let step = (height[b] - height[a]).abs();
            step > SPIKE_M && step > LEAP_MPS * (time[b] - time[a])
        })
        .collect();
    let mut k = 0;
    while k + 1 < leaps.len() {
        let (from, to) = (leaps[k], leaps[k + 1]);
        let (first, last) = (known[from], known[to - 1]);
        // Away and back again.
        let back = (height[known[to]] - height[known[from - 1]]).abs()
            < 0.5 * (height[first] - height[known[from - 1]]).abs();
        if back && time[last] - time[first] < EXCURSION_S {
            for &i in &known[from..to] {
                height[i] = f64::NAN;
            }
            k += 2;
        } else {
            k += 1;
        }
    }
}

fn middle(values: &mut [f64]) -> f64 {
    let half = values.len() / 2;
    *values.select_nth_unstable_by(half, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_parabola_is_smoothed_to_itself() {
        let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let course: Vec<f64> = time.iter().map(|t| 1.0 + 2.0 * t - 3.0 * t * t).collect();
        let of = |derivative| local_parabola(&time, &course, 0.1, derivative);
        let (value, slope, curvature) = (of(0), of(1), of(2));
        for i in 0..100 {
            // Normal equations of three well-scaled columns lose a few digits.
            assert!((value[i] - course[i]).abs() < 1e-9);
            assert!((slope[i] - (2.0 - 6.0 * time[i])).abs() < 1e-7);
            assert!((curvature[i] + 6.0).abs() < 1e-5);
        }
    }

    #[test]
    fn analytic_short_holes_are_filled_and_long_ones_are_not() {
        let time = [0.0, 0.1, 0.2, 0.3, 1.0, 2.0];
        let values = [1.0, f64::NAN, f64::NAN, 4.0, f64::NAN, 5.0];
        assert_eq!(filled(&time, &values, true)[..4], [1.0, 1.0, 1.0, 4.0]);
        let line = filled(&time, &values, false);
        assert!((line[1] - 2.0).abs() < 1e-12 && line[4].is_nan());
    }

    #[test]
    fn analytic_a_bump_is_what_a_parabola_makes_of_a_derivative() {
        // A sine of 20 rad/s: its second derivative through the local parabola, and smoothed by the bump.
        let time: Vec<f64> = (0..400).map(|i| 0.005 * f64::from(i)).collect();
        let of = |f: fn(f64) -> f64| -> Vec<f64> { time.iter().map(|t| f(20.0 * t)).collect() };
        let height = of(f64::sin);
        let truth: Vec<f64> = height.iter().map(|z| -400.0 * z).collect();
        let seen = local_parabola(&time, &height, 0.1, 2);
        let smoothed = bump(&time, &truth, 0.1, 2);
        for i in 40..360 {
            // Sums over 41 samples approximate integrals: a few per cent.
            assert!(
                (seen[i] - smoothed[i]).abs() < 0.04 * 400.0,
                "{i}: {} {}",
                seen[i],
                smoothed[i]
            );
        }
    }

    #[test]
    fn analytic_spikes_and_excursions_go_and_flight_stays() {
        let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        // Stand, climb at 5 m/s, hover, fall at 6 m/s, stand.
        let course =
            |t: f64| (5.0 * (t - 5.0)).clamp(0.0, 4.0) - (6.0 * (t - 12.0)).clamp(0.0, 4.0);
        let truth: Vec<f64> = time.iter().map(|t| course(*t)).collect();
        let mut height = truth.clone();
        assert_eq!(
            without_spikes(&time, &mut height),
            0,
            "a flight has no spike"
        );
        for i in [100, 520, 521, 900] {
            height[i] = 28.0;
        }
        height[1400..1600].fill(28.0);
        assert_eq!(without_spikes(&time, &mut height), 204);
        for (z, t) in height.iter().zip(&truth).filter(|(z, _)| z.is_finite()) {
            assert_eq!(z, t);
        }
    }
}
