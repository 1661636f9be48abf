//! Axes: which values are shown, where the ticks stand, and what they say.

/// Largest magnitude that is drawn. Beyond it, differences of two values could overflow.
const LARGEST: f64 = 1e300;

/// Smallest width of a linear axis. Below it, divisions by the width could overflow.
const NARROWEST: f64 = 1e-290;

/// One axis: limits, kind and ticks.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) log: bool,
    pub(crate) ticks: Vec<Tick>,
}

/// A mark on an axis. Marks without text are minor.
#[derive(Debug, Clone)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

impl Axis {
    /// An axis from `low` to `high` with about `target` labelled ticks.
    pub(crate) fn new((low, high): (f64, f64), log: bool, target: usize) -> Self {
        let ticks = if log {
            log_ticks(low, high, target)
        } else {
            linear_ticks(low, high, target)
        };
        Self {
            low,
            high,
            log,
            ticks,
        }
    }

    /// Replaces numbers by names at 0, 1, 2, ….
    pub(crate) fn with_categories(mut self, names: &[String]) -> Self {
        let visible = |v: &f64| (self.low..=self.high).contains(v);
        self.ticks = (0..names.len())
            .map(|i| Tick {
                value: i as f64,
                label: names[i].clone(),
            })
            .filter(|tick| visible(&tick.value))
            .collect();
        self
    }

    /// Where `value` stands: 0 at the low end, 1 at the high end; NaN for what cannot be drawn.
    pub(crate) fn place(&self, value: f64) -> f64 {
        if !value.is_finite() || (self.log && value <= 0.0) {
            return f64::NAN;
        }
        if self.log {
            let (low, high) = (self.low.log10(), self.high.log10());
            return (value.clamp(1.0 / LARGEST, LARGEST).log10() - low) / (high - low);
        }
        (value.clamp(-LARGEST, LARGEST) - self.low) / (self.high - self.low)
    }
}

/// Smallest interval that holds all `values` that can be drawn; `None` if there are none.
pub(crate) fn extent(values: impl Iterator<Item = f64>, log: bool) -> Option<(f64, f64)> {
    values
        .filter(|v| v.is_finite() && (!log || *v > 0.0))
        .map(|v| v.clamp(-LARGEST, LARGEST))
        .fold(None, |acc, v| {
            Some(acc.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v))))
        })
}

/// Limits that show the interval `found` with `margin` of its width on both sides, never of no width.
pub(crate) fn limits(found: Option<(f64, f64)>, log: bool, margin: f64) -> (f64, f64) {
    if log {
        let (low, high) = found.unwrap_or((0.1, 1.0));
        let (low, high) = (low.max(1e-300).log10(), high.max(1e-300).log10());
        let pad = if high - low < 1e-9 {
            0.5
        } else {
            margin * (high - low)
        };
        let ends = [low - pad, high + pad].map(|e| 10f64.powf(e.clamp(-305.0, 305.0)));
        return (ends[0], ends[1]);
    }
    let (low, high) = found.unwrap_or((0.0, 1.0));
    let (low, high) = (low.clamp(-LARGEST, LARGEST), high.clamp(-LARGEST, LARGEST));
    let magnitude = low.abs().max(high.abs());
    // Ticks have at most 15 digits: a narrower axis could not be labelled.
    let narrowest = (1e-12 * magnitude).max(NARROWEST);
    let width = high - low;
    let pad = if width == 0.0 {
        if magnitude == 0.0 {
            1.0
        } else {
            (0.05 * magnitude).max(narrowest)
        }
    } else {
        (margin * width).max(0.5 * (narrowest - width))
    };
    (low - pad, high + pad)
}

/// The smallest of 1, 2, 5 × 10ⁿ that is not below `rough`, and n.
fn nice_step(rough: f64) -> (f64, i32) {
    let exponent = rough.log10().floor();
    let base = 10f64.powf(exponent);
    // 1 + 1e-9: a rough step of exactly 2 must not become 5 by rounding.
    let digit = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|d| rough <= d * base * (1.0 + 1e-9));
    let exponent = exponent as i32;
    digit.map_or((10.0 * base, exponent + 1), |d| (d * base, exponent))
}

fn linear_ticks(low: f64, high: f64, target: usize) -> Vec<Tick> {
    let (step, exponent) = nice_step((high - low) / target.max(1) as f64);
    let first = (low / step - 1e-9).ceil();
    let count = ((high / step + 1e-9).floor() - first).clamp(-1.0, 100.0) as i64 + 1;
    let largest = low.abs().max(high.abs());
    (0..count)
        .map(|i| {
            let multiple = first + i as f64;
            let value = multiple * step;
            Tick {
                value,
                label: label(value, largest, exponent),
            }
        })
        .filter(|tick| tick.value.is_finite())
        .collect()
}

/// Digits of a tick: plain where that is short, otherwise with a power of ten.
fn label(value: f64, largest: f64, step_exponent: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = usize::try_from(-step_exponent).unwrap_or(0);
    // Many equal leading digits are easier to compare without powers of ten.
    let leading = largest.log10().floor() as i32 - step_exponent;
    let (greatest, finest) = if leading >= 4 { (1e9, 9) } else { (1e6, 5) };
    if largest < greatest && decimals <= finest {
        return minus(&format!("{value:.decimals$}"));
    }
    let exponent = value.abs().log10().floor() as i32;
    let digits = usize::try_from(exponent - step_exponent)
        .unwrap_or(0)
        .min(15);
    scientific(value, digits)
}

/// `1.5×10⁻³`, with `digits` decimals; a mantissa of exactly one is left out.
pub(crate) fn scientific(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let power = format!("10{}", superscript(exponent));
    match mantissa {
        "1" => power,
        "-1" => format!("\u{2212}{power}"),
        _ => format!("{}×{power}", minus(mantissa)),
    }
}

/// A typographic minus sign in place of the hyphen.
pub(crate) fn minus(number: &str) -> String {
    number.replace('-', "\u{2212}")
}

fn superscript(exponent: &str) -> String {
    let raise = |c: char| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        other => other,
    };
    exponent.chars().map(raise).collect()
}

/// Powers of ten, thinned to `target`; below two decades also 2 and 5 times them; below that, as on a linear axis.
fn log_ticks(low: f64, high: f64, target: usize) -> Vec<Tick> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let decades = high.log10() - low.log10();
    let inside = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
    if decades < 1.0 {
        return linear_ticks(low, high, target)
            .into_iter()
            .filter(|t| t.value > 0.0)
            .collect();
    }
    let every = ((decades / target.max(1) as f64).ceil() as i32).max(1);
    let digits: &[f64] = match decades {
        d if d < 3.0 => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        d if d < 9.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let mut ticks = Vec::new();
    for exponent in first..=last {
        for digit in digits {
            let value = digit * 10f64.powi(exponent);
            let labelled = if decades < 2.0 {
                [1.0, 2.0, 5.0].contains(digit)
            } else {
                *digit == 1.0
            };
            let label = if labelled && exponent.rem_euclid(every) == 0 {
                log_label(value, *digit, exponent)
            } else {
                String::new()
            };
            if inside(&value) {
                ticks.push(Tick { value, label });
            }
        }
    }
    ticks
}

fn log_label(value: f64, digit: f64, exponent: i32) -> String {
    if (-3..=3).contains(&exponent) {
        let decimals = usize::try_from(-exponent).unwrap_or(0);
        return format!("{value:.decimals$}");
    }
    let power = format!("10{}", superscript(&exponent.to_string()));
    if digit == 1.0 {
        power
    } else {
        format!("{digit}×{power}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        linear_ticks(low, high, 5)
            .into_iter()
            .map(|t| t.label)
            .collect()
    }

    #[test]
    fn analytic_nice_numbers() {
        assert_eq!(labels(0.0, 10.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(-0.3, 0.3), ["−0.2", "0", "0.2"]);
        let millions = ["0", "5×10⁵", "1.0×10⁶", "1.5×10⁶", "2.0×10⁶", "2.5×10⁶"];
        assert_eq!(labels(0.0, 2.5e6), millions);
        let offset = ["1000000.000", "1000000.001", "1000000.002"];
        assert_eq!(
            linear_ticks(1e6, 1e6 + 0.0021, 3)
                .iter()
                .map(|t| t.label.as_str())
                .collect::<Vec<_>>(),
            offset
        );
        let close = ["99.990", "99.995", "100.000", "100.005", "100.010"];
        assert_eq!(labels(99.99, 100.01), close);
    }

    #[test]
    fn analytic_decades() {
        let ticks = log_ticks(0.01, 100.0, 6);
        let labels: Vec<_> = ticks
            .iter()
            .map(|t| t.label.as_str())
            .filter(|l| !l.is_empty())
            .collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
    }

    proptest! {
        /// Whatever the data, limits are finite and of positive width, ticks are few, ascending and within them.
        #[test]
        fn prop_axes_of_any_data(values in proptest::collection::vec(any::<f64>(), 0..6), log: bool, target in 1usize..12) {
            let (low, high) = limits(extent(values.iter().copied(), log), log, 0.05);
            prop_assert!(low.is_finite() && high.is_finite() && low < high, "{} {}", low, high);
            let axis = Axis::new((low, high), log, target);
            prop_assert!(axis.ticks.len() <= 101 * 9);
            prop_assert!(axis.ticks.is_sorted_by(|a, b| a.value < b.value));
            for tick in &axis.ticks {
                let place = axis.place(tick.value);
                // 1e-6 of the axis is far below a pixel.
                prop_assert!((-1e-6..=1.0 + 1e-6).contains(&place), "{} at {}", tick.value, place);
            }
            for value in values.into_iter().filter(|v| v.is_finite() && (!log || *v > 1e-300)) {
                let place = axis.place(value);
                prop_assert!((-1e-6..=1.0 + 1e-6).contains(&place), "{} at {}", value, place);
            }
        }
    }
}
