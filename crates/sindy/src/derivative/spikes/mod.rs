//! Spikes: single samples far off a signal that is smooth without them.
//!
//! Each sample is compared with the polynomial of degree 5 through its six nearest neighbours,
//!
//! ```text
//! e_k = y_k - Σ_j w_j y_j,    z_k = |e_k| / √(1 + Σ_j w_j²)
//! ```
//!
//! so that `z` of white noise has the noise's standard deviation σ. A sample is suspicious where `z` is more than 8
//! times the larger of σ ([`super::noise_level`]) and the scale of `z` within 15 samples, by its lower quartile (a
//! Hampel identifier; the local scale is for noise that changes and for stretches too fast for the polynomial).
//! Suspicion is not enough: fast parts of a clean signal raise it too. Samples are spikes only if *leaving them out*,
//! at most three in a row and few altogether, leaves nothing suspicious around them. A jump, a kink or a fast turn is
//! hardly ever cured that way (the corner of a kink may be, in data without any noise). The last three samples at
//! either end are compared with a parabola from inside.
//!
//! Valid for signals that are smooth over seven samples; never for maps in discrete time. Gaussian noise passes
//! 8 σ once in 10¹⁵ samples.
//!
//! Sources: F. R. Hampel, "The influence curve and its role in robust estimation", J. Am. Stat. Assoc. 69 (1974);
//! R. K. Pearson, "Outliers in process modeling and identification", IEEE Trans. Control Syst. Technol. 10 (2002).

#[cfg(test)]
mod tests;

use std::ops::Range;

use rayon::prelude::*;

use super::noise::quantum;
use super::noise_level;
use crate::data::grid;
use crate::error::SindyError;
use crate::numerics::upper_median;

/// Neighbours that a sample is compared with: a polynomial through three on each side.
const NEIGHBOURS: usize = 6;
/// Scales beyond which a sample is suspicious. White noise exceeds six in one of 10⁹ samples; half of it takes the noise
/// of heavy tails for spikes.
const FAR: f64 = 8.0;
/// Samples on either side that the local scale comes from: its median is known to a fifth.
const AROUND: usize = 15;
/// The least scale, as a share of the signal's spread: the rounding of six printed digits.
const FLOOR: f64 = 1e-6;
/// Most consecutive samples that may be removed; longer excursions are events of the system.
const IN_A_ROW: usize = 3;
/// Most samples of one suspicious neighbourhood (longer ones are no spikes), and most of them that may be removed.
const LONGEST: usize = 40;
const MOST: usize = 8;
/// A larger share of spikes is something else: a second regime, or heavy-tailed noise.
const SHARE: f64 = 0.05;
/// Number of neighbourhoods after which the search stops if hardly any can be corrected. It only limits computing time.
const PATIENCE: usize = 1000;
/// Steps of the signal's resolution that may be due to it: rounding errs by one, its differences by two.
const STEPS: f64 = 3.0;
/// Samples at either end that are compared with a parabola from inside, for want of neighbours on one side.
const END: usize = 3;
/// How much further off than the two before it a spike there is: extrapolation errs smoothly.
const SUDDEN: f64 = 4.0;
/// Samples below which no sample counts as a spike: the local scale needs as many.
const FEWEST: usize = 25;

/// A sample that is none of its signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spike {
    /// Its index.
    pub row: usize,
    /// The value that the neighbours predict.
    pub value: f64,
    /// Its distance from that, in standard deviations of the noise.
    pub distance: f64,
}

/// Finds the spikes of `y` sampled at `time`; none where there are fewer than 25 samples, or where more than
/// 5 % would be spikes.
///
/// # Errors
/// Lengths that differ, non-finite values, times that do not increase.
pub fn spikes(time: &[f64], y: &[f64]) -> Result<Vec<Spike>, SindyError> {
    if y.len() < FEWEST && time.len() == y.len() {
        return Ok(Vec::new());
    }
    grid::check(time, y, FEWEST)?;
    let sigma = noise_level(time, y)?.sigma.max(FLOOR * spread(y));
    if !(sigma > 0.0 && sigma.is_finite()) {
        return Ok(Vec::new());
    }
    let mut search = Search {
        time,
        y,
        sigma,
        least: STEPS * quantum(y).unwrap_or(0.0),
        aside: Vec::new(),
        first: Vec::new(),
    };
    let mut found = search.inside();
    let mut at_ends = search.ends(&found);
    if !at_ends.is_empty() {
        // A spike at an end hides those beside it, and they spoil what it is judged by.
        search.aside = at_ends.iter().map(|s| s.row).collect();
        found = search.inside();
        at_ends = search.ends(&found);
    }
    found.extend(at_ends);
    found.sort_unstable_by_key(|s| s.row);
    if found.len() as f64 > SHARE * y.len() as f64 {
        found.clear();
    }
    Ok(found)
}

/// The width of the middle nine tenths, scaled to a standard deviation: spikes do not matter.
fn spread(y: &[f64]) -> f64 {
    let mut values = y.to_vec();
    let last = values.len() - 1;
    let mut at = |share: f64| {
        let place = (share * last as f64) as usize;
        *values.select_nth_unstable_by(place, f64::total_cmp).1
    };
    (at(0.95) - at(0.05)) / 3.29
}

/// Whether some of the samples follow each other, more than may be left out together.
fn too_long(samples: &[usize]) -> bool {
    let mut sorted = samples.to_vec();
    sorted.sort_unstable();
    let mut all = sorted.windows(IN_A_ROW + 1);
    all.any(|w| w[IN_A_ROW] - w[0] == IN_A_ROW)
}

/// A sample beside the value that its neighbours predict.
struct Compared {
    value: f64,
    error: f64,
    /// Standard deviation of `error` for unit noise.
    scale: f64,
}

impl Compared {
    fn z(&self) -> f64 {
        self.error.abs() / self.scale
    }
}

/// Sample `k` against the polynomial through its nearest neighbours on both sides, `without` left out; near an end
/// more of them are on the other side.
fn compare(time: &[f64], y: &[f64], k: usize, without: &[usize]) -> Compared {
    let mut nodes = [0; NEIGHBOURS];
    let mut count = 0;
    let below = |k: usize| (0..k).rev().find(|j| !without.contains(j));
    let above = |k: usize| (k + 1..y.len()).find(|j| !without.contains(j));
    let (mut left, mut right) = (below(k), above(k));
    while count < NEIGHBOURS {
        nodes[count] = match (left, right) {
            (Some(j), other) if count % 2 == 0 || other.is_none() => {
                left = below(j);
                j
            }
            (_, Some(j)) => {
                right = above(j);
                j
            }
            _ => break,
        };
        count += 1;
    }
    against(time, y, k, &nodes[..count])
}

/// Sample `k` against the polynomial through `nodes`.
fn against(time: &[f64], y: &[f64], k: usize, nodes: &[usize]) -> Compared {
    let (mut value, mut squares) = (0.0, 1.0);
    for &j in nodes {
        let factors = nodes.iter().filter(|&&l| l != j);
        let weight: f64 = factors
            .map(|&l| (time[k] - time[l]) / (time[j] - time[l]))
            .product();
        value += weight * y[j];
        squares += weight * weight;
    }
    Compared {
        value,
        error: y[k] - value,
        scale: squares.sqrt(),
    }
}

struct Search<'a> {
    time: &'a [f64],
    y: &'a [f64],
    sigma: f64,
    least: f64,
    /// Samples that are left out of every comparison.
    aside: Vec<usize>,
    /// z of every sample, these left out.
    first: Vec<f64>,
}

impl Search<'_> {
    /// Spikes with neighbours on both sides.
    fn inside(&mut self) -> Vec<Spike> {
        let n = self.y.len();
        self.first = (0..n)
            .into_par_iter()
            .map(|k| compare(self.time, self.y, k, &self.aside).z())
            .collect();
        let (mut found, mut cured) = (Vec::new(), 0);
        let places = self.neighbourhoods();
        for (tried, &(from, to)) in places.iter().enumerate() {
            if tried >= PATIENCE && cured < tried / 10 {
                return Vec::new();
            }
            // What is around it, but nothing of the next one.
            let reach = NEIGHBOURS / 2 + MOST;
            let before = tried.checked_sub(1).map_or(END, |i| places[i].1 + 1);
            let after = places.get(tried + 1).map_or(n - END, |next| next.0);
            let around = before.max(from.saturating_sub(reach))..after.min(to + reach + 1);
            if to - from < LONGEST
                && let Some(spikes) = self.cure((from, to), around)
            {
                cured += 1;
                found.extend(spikes);
            }
        }
        found
    }

    /// What z may be at `k`: above it, a sample is suspicious.
    fn bound(&self, k: usize) -> f64 {
        let range = k.saturating_sub(AROUND)..(k + AROUND + 1).min(self.y.len());
        let mut around = self.first[range].to_vec();
        let place = around.len() / 4;
        let quartile = *around.select_nth_unstable_by(place, f64::total_cmp).1;
        // The lower quartile of |N(0, 1)|: a few spikes, each of which disturbs seven samples, leave it alone.
        FAR * self.sigma.max(quartile / 0.318_639_363_964_375_2)
    }

    /// Ranges of samples, first and last, that may be spikes or are disturbed by one.
    fn neighbourhoods(&self) -> Vec<(usize, usize)> {
        let mut out: Vec<(usize, usize)> = Vec::new();
        for k in END..self.y.len() - END {
            if !(self.first[k] > FAR * self.sigma && self.first[k] > self.bound(k)) {
                continue;
            }
            match out.last_mut() {
                Some((_, last)) if k - *last <= NEIGHBOURS => *last = k,
                _ => out.push((k, k)),
            }
        }
        out
    }

    /// How suspicious the samples around a neighbourhood are without some of them: the sum of squares of what is
    /// above its bound.
    /// `bounds` are those of the rows from `first` on; sums above `enough` count as equal.
    fn suspicion(&self, first: usize, bounds: &[f64], without: &[usize], enough: f64) -> f64 {
        let mut sum = 0.0;
        for (k, bound) in (first..).zip(bounds) {
            if sum > enough {
                return sum;
            }
            if !without.contains(&k) {
                let share = compare(self.time, self.y, k, without).z() / bound;
                sum += if share > 1.0 { share * share } else { 0.0 };
            }
        }
        sum
    }

    /// The few samples of a neighbourhood without which nothing `around` it is suspicious; `None` if no few of them
    /// suffice.
    fn cure(&self, (from, to): (usize, usize), around: Range<usize>) -> Option<Vec<Spike>> {
        let first = around.start;
        let bounds: Vec<f64> = around.map(|k| self.bound(k)).collect();
        let mut without = self.aside.clone();
        let mut left = self.suspicion(first, &bounds, &without, f64::INFINITY);
        while left > 0.0 {
            // A small gain is no cure.
            let mut best = (0.8 * left, None);
            let singles = (from..=to).map(|k| vec![k]).collect();
            let pair = |k: usize| (k + 1..=to.min(k + NEIGHBOURS)).map(move |j| vec![k, j]);
            let pairs = (from..=to).flat_map(pair).collect();
            let triples = (from + 2..=to).map(|k| vec![k - 2, k - 1, k]).collect();
            let all: [Vec<Vec<usize>>; 3] = [singles, pairs, triples];
            for (more, sets) in all.iter().enumerate() {
                // More samples have to do much better than fewer.
                let mut enough = if more == 0 { best.0 } else { 0.5 * best.0 };
                for set in sets {
                    let mut tried = without.clone();
                    tried.extend(set.iter().filter(|k| !without.contains(k)));
                    let most = self.aside.len() + MOST;
                    if tried.len() == without.len() || tried.len() > most || too_long(&tried) {
                        continue;
                    }
                    let left = self.suspicion(first, &bounds, &tried, enough);
                    if left < enough {
                        (best, enough) = ((left, Some(tried)), left);
                    }
                }
            }
            (left, without) = (best.0, best.1?);
        }
        without.sort_unstable();
        let new = without.iter().filter(|row| !self.aside.contains(row));
        let spikes = new.filter_map(|&row| {
            let found = compare(self.time, self.y, row, &without);
            let far = found.z() > self.bound(row) && found.error.abs() > self.least;
            far.then(|| Spike {
                row,
                value: found.value,
                distance: found.error.abs() / self.sigma,
            })
        });
        Some(spikes.collect())
    }
}

impl Search<'_> {
    /// Spikes among the last samples of either end, whose neighbours are on one side only: a polynomial of degree 5 is
    /// blind there, as it multiplies noise by up to 30. A parabola multiplies it by 4.5, and is judged by what it
    /// makes of the samples before.
    fn ends(&self, found: &[Spike]) -> Vec<Spike> {
        let n = self.y.len();
        let mut out: Vec<Spike> = Vec::new();
        for last in [false, true] {
            // Counted from the end.
            let row = |i: usize| if last { n - 1 - i } else { i };
            let compared = |i: usize, out: &[Spike]| {
                let spike = |i: &usize| !found.iter().chain(out).any(|s| s.row == row(*i));
                let nodes: Vec<usize> = (i + 1..n).filter(spike).take(3).map(row).collect();
                against(self.time, self.y, row(i), &nodes)
            };
            let mut around: Vec<f64> = (END..END + AROUND).map(|i| compared(i, &[]).z()).collect();
            let median = upper_median(&mut around).unwrap_or(0.0);
            // 0.6745 is the median of |N(0, 1)|.
            let bound = FAR * self.sigma.max(median / 0.674_489_750_196_081_7);
            for i in (0..END).rev() {
                let against = compared(i, &out);
                let is_spike = |i: usize| found.iter().chain(&out).any(|s| s.row == row(i));
                // A signal that gets fast does so over several samples.
                let before = [i + 1, i + 2].into_iter().filter(|i| !is_spike(*i));
                let before = before.map(|i| compared(i, &out).z()).fold(0.0, f64::max);
                if !is_spike(i)
                    && against.z() > bound.max(SUDDEN * before)
                    && against.error.abs() > self.least
                {
                    out.push(Spike {
                        row: row(i),
                        value: against.value,
                        distance: against.error.abs() / self.sigma,
                    });
                }
            }
        }
        out
    }
}
