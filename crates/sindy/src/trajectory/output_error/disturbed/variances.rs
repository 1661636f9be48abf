//! The variances of disturbances and measurement, by maximum likelihood around a filter.

use super::filter::{Belief, Pass};
use super::{Disturbance, Sources};
use crate::numerics::{golden_section, upper_median};
use crate::trajectory::output_error::Start;
use crate::trajectory::output_error::record::Record;

/// Rows that the likelihood looks at, at most: they give a variance to 3 %.
pub(super) const ROWS: usize = 4000;
/// Widths to which logarithms are narrowed: of what a step leaves, and of the odds between its parts.
const NARROW_TOTAL: f64 = 0.05;
const NARROW_ODDS: f64 = 0.2;
/// Logarithm of the odds between measurement and disturbance that counts as one of the two alone.
const ALONE: f64 = 9.0;
/// Sweeps over all states; with a third nothing changes by more than [`NARROW_ODDS`].
const SWEEPS: usize = 2;

/// How far from the present values is searched, as logarithms: of what a step leaves, and of the odds.
#[derive(Clone, Copy)]
pub(super) struct Range {
    total: f64,
    odds: f64,
}

/// From a first guess on.
pub(super) const WIDE: Range = Range {
    total: 7.0,
    odds: 2.0 * ALONE,
};
/// From an estimate on.
pub(super) const NARROW: Range = Range {
    total: 0.7,
    odds: 3.0,
};

/// The variances of a state as the search moves them: of what one step leaves, `q h + 2 r`, and the odds `2 r / (q h)`.
#[derive(Clone, Copy)]
struct Share {
    total: f64,
    odds: f64,
}

/// A first guess: half of what neighbouring rows differ by.
pub(super) fn first(
    records: &[Record],
    measured: usize,
    start: &Start,
    sources: Sources,
) -> Disturbance {
    let period = period(records);
    let square = |sigma: &f64| sigma * sigma;
    let measurement = match sources {
        Sources::Both => start.sigma.iter().map(square),
        Sources::Process => start.floor.iter().map(square),
    };
    Disturbance {
        process: start.sigma.iter().map(|s| 2.0 * s * s / period).collect(),
        measurement: measurement.take(measured).collect(),
        sources,
        diffusion: None,
    }
}

/// The largest difference between two estimates: in the logarithm of what a step leaves, or in the measurement's share of it.
pub(super) fn distance(a: &Disturbance, b: &Disturbance, records: &[Record]) -> f64 {
    let period = period(records);
    let of = |noise: &Disturbance, i: usize| {
        let process = noise.process[i] * period;
        let measured = noise.measurement.get(i).map_or(0.0, |r| 2.0 * r);
        [(process + measured).ln(), measured / (process + measured)]
    };
    let differences = (0..a.process.len()).flat_map(|i| {
        let pairs = of(a, i).into_iter().zip(of(b, i));
        pairs.map(|(a, b)| (a - b).abs())
    });
    differences.fold(0.0, f64::max)
}

/// The most likely variances around the filter's passes.
pub(super) fn estimate(
    passes: &[(&Record, &Pass)],
    from: &Disturbance,
    range: Range,
) -> Disturbance {
    let records = passes.iter().map(|(record, _)| *record);
    let period = median(records.flat_map(|r| r.time.windows(2).map(|w| w[1] - w[0])));
    let measured = from.measurement.len();
    let mut noise = from.clone();
    for _ in 0..SWEEPS {
        for i in 0..noise.process.len() {
            let both = from.sources == Sources::Both && i < measured;
            let mut share = match both {
                true => Share::new(noise.process[i] * period, 2.0 * noise.measurement[i]),
                false => Share {
                    total: (noise.process[i] * period).ln(),
                    odds: f64::NEG_INFINITY,
                },
            };
            let cost = |share: Share| {
                let mut tried = noise.clone();
                share.put(&mut tried, i, (period, both));
                cost(passes, &tried, ROWS)
            };
            if both {
                let around = [
                    (share.odds - range.odds).max(-ALONE),
                    (share.odds + range.odds).min(ALONE),
                ];
                share.odds = middle(golden_section(
                    around,
                    |a, b| b - a > NARROW_ODDS,
                    |odds| cost(Share { odds, ..share }),
                ));
            }
            let around = [share.total - range.total, share.total + range.total];
            share.total = middle(golden_section(
                around,
                |a, b| b - a > NARROW_TOTAL,
                |total| cost(Share { total, ..share }),
            ));
            share.put(&mut noise, i, (period, both));
        }
    }
    noise
}

impl Share {
    /// From the disturbance over a step and twice the noise.
    fn new(process: f64, measurement: f64) -> Self {
        Self {
            total: (process + measurement).ln(),
            odds: (measurement / process).ln(),
        }
    }

    /// Writes the variances of state `i`.
    fn put(self, noise: &mut Disturbance, i: usize, (period, both): (f64, bool)) {
        let total = self.total.exp();
        if both {
            let measured = 1.0 / (1.0 + (-self.odds).exp());
            noise.process[i] = total * (1.0 - measured) / period;
            noise.measurement[i] = 0.5 * total * measured;
        } else {
            noise.process[i] = total / period;
        }
    }
}

/// Twice the negative log-likelihood of about `most` rows around the filter's linearisation; infinite where the filter fails.
pub(super) fn cost(passes: &[(&Record, &Pass)], noise: &Disturbance, most: usize) -> f64 {
    let rows: usize = passes.iter().map(|(_, pass)| pass.steps.len()).sum();
    let share = (most as f64 / rows as f64).min(1.0);
    let mut sum = 0.0;
    for (record, pass) in passes {
        let mut belief = Belief::first(record, noise);
        let looked = (share * pass.steps.len() as f64).ceil() as usize;
        for (k, step) in pass.steps.iter().take(looked).enumerate() {
            let mean = &step.to + &step.transition * (&belief.mean - &step.from);
            belief.predict(mean, step, noise);
            if record.is_compared(k + 1) {
                let Some(update) = belief.update(record, k + 1, noise) else {
                    return f64::INFINITY;
                };
                sum += update.log_determinant + update.innovation.norm_squared();
            }
        }
    }
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Median time between rows.
fn period(records: &[Record]) -> f64 {
    median(
        records
            .iter()
            .flat_map(|r| r.time.windows(2).map(|w| w[1] - w[0])),
    )
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    upper_median(&mut values.collect::<Vec<_>>()).unwrap_or(1.0)
}

fn middle([low, high]: [f64; 2]) -> f64 {
    0.5 * (low + high)
}
