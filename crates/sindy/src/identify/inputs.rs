//! What inputs are between their samples, chosen from the samples.

use super::Between;
use crate::data::dataset::Stretch;
use crate::model::Interpolation;
use crate::numerics::upper_median;

/// An input of which at least this share of the steps is none holds its values, if it jumps when it moves. Held inputs
/// stand still for nearly all steps and measured ones for hardly any, so that any share between decides alike.
const STILL: f64 = 0.5;
/// Least size of a jump, in standard deviations of the input: more than the last digit of a sensor, less than a
/// commanded step. Twice the value treats fine staircases as lines.
const JUMP: f64 = 0.05;
/// Straight lines that miss this share of an input's variance do not predict it; then a held input is tried as well.
/// Half of it tries more often, which costs time alone.
const ROUGH: f64 = 0.25;

/// What each input is taken for.
#[derive(Clone)]
pub(super) struct Choice {
    pub between: Vec<Interpolation>,
    /// The second best guess, where neither lines nor cubics predict an input.
    pub second: Option<Vec<Interpolation>>,
}

pub(super) fn choose(stretches: &[Stretch<'_>], states: usize, setting: Between) -> Choice {
    let inputs = stretches.first().map_or(0, |s| s.columns.len()) - states;
    let all = |how| Choice {
        between: vec![how; inputs],
        second: None,
    };
    match setting {
        Between::Hold => all(Interpolation::ZeroOrderHold),
        Between::Linear => all(Interpolation::Linear),
        Between::Cubic => all(Interpolation::Cubic),
        Between::Automatic => {
            let found: Vec<(Interpolation, bool)> =
                (0..inputs).map(|k| one(stretches, states + k)).collect();
            let second = found.iter().map(|(how, rough)| match rough {
                true => Interpolation::ZeroOrderHold,
                false => *how,
            });
            Choice {
                between: found.iter().map(|f| f.0).collect(),
                second: found.iter().any(|f| f.1).then(|| second.collect()),
            }
        }
    }
}

/// One input, and whether neither lines nor cubics predict it.
fn one(stretches: &[Stretch<'_>], column: usize) -> (Interpolation, bool) {
    let (mut rows, mut sum, mut square) = (0.0, 0.0, 0.0);
    let mut steps = Vec::new();
    let (mut line, mut cubic, mut judged) = (0.0, 0.0, 0.0);
    for s in stretches {
        let (t, u) = (s.time, s.columns[column]);
        rows += u.len() as f64;
        sum += u.iter().sum::<f64>();
        square += u.iter().map(|u| u * u).sum::<f64>();
        steps.extend(u.windows(2).map(|w| (w[1] - w[0]).abs()));
        for k in 3..u.len().saturating_sub(3) {
            line += (u[k] - foretold(t, u, k, &[k - 1, k + 1])).powi(2);
            cubic += (u[k] - foretold(t, u, k, &[k - 3, k - 1, k + 1, k + 3])).powi(2);
            judged += 1.0;
        }
    }
    let variance = (square / rows - (sum / rows).powi(2)).max(0.0);
    let mut jumps: Vec<f64> = steps.iter().copied().filter(|s| *s > 0.0).collect();
    let still = 1.0 - jumps.len() as f64 / steps.len().max(1) as f64;
    let jump = upper_median(&mut jumps).unwrap_or(0.0);
    if still >= STILL && jump > JUMP * variance.sqrt() {
        return (Interpolation::ZeroOrderHold, false);
    }
    let rough = line > ROUGH * variance * judged && cubic > ROUGH * variance * judged;
    match cubic < line {
        true => (Interpolation::Cubic, rough),
        false => (Interpolation::Linear, rough),
    }
}

/// The polynomial through the samples `at`, at sample `k`.
fn foretold(t: &[f64], u: &[f64], k: usize, at: &[usize]) -> f64 {
    at.iter()
        .map(|&i| {
            let others = at.iter().filter(|&&j| j != i);
            u[i] * others
                .map(|&j| (t[k] - t[j]) / (t[i] - t[j]))
                .product::<f64>()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn of(u: impl Fn(f64) -> f64) -> (Interpolation, bool) {
        let time: Vec<f64> = (0..400).map(|i| 0.1 * f64::from(i)).collect();
        let column: Vec<f64> = time.iter().map(|t| u(*t)).collect();
        let stretch = Stretch {
            trajectory: 0,
            time: &time,
            columns: vec![&column],
            weights: None,
            seen: Vec::new(),
        };
        let found = choose(&[stretch], 0, Between::Automatic);
        (found.between[0], found.second.is_some())
    }

    #[test]
    fn analytic_inputs_are_taken_for_what_made_them() {
        use Interpolation::{Cubic, Linear, ZeroOrderHold};
        assert_eq!(of(|t| (1.3 * t).sin()), (Cubic, false));
        // A square wave; a staircase of small steps over a long way is no hold but a quantised slope.
        assert_eq!(of(|t| (0.7 * t).sin().signum()), (ZeroOrderHold, false));
        assert_eq!(of(|t| (t * 4.0).floor() * 0.01).0, Linear);
        // Noise at every sample: no polynomial foretells it, so it may be held.
        let random = std::cell::RefCell::new(rand_pcg::Pcg64::seed_from_u64(3));
        let noise = |_: f64| random.borrow_mut().random_range(-1.0..1.0);
        assert_eq!(of(noise), (Linear, true));
        // Mostly smooth with some noise: lines pass less of it.
        let noisy = |t: f64| (0.3 * t).sin() + 0.05 * random.borrow_mut().random_range(-1.0..1.0);
        assert_eq!(of(noisy), (Linear, false));
    }
}
