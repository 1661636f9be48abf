//! On-line search for a periodic part: least squares of a constant and a harmonic
//! at each frequency of a grid.
//!
//! At the frequency ω the velocities y_j of the times t_j are fitted by
//! `o + c cos ω(t_j - t) - s sin ω(t_j - t)` with weights that fall off over 2.5
//! periods (the floating-mean periodogram of Zechmeister & Kürster 2009, made
//! recursive). What it needs are nine sums a frequency, which a new velocity turns
//! by ω dt and adds to. A few frequencies are brought up to date at a step, with
//! the mean of the readings since their last turn. Where readings are
//! displacements, velocities are differences of such means: in displacements the
//! slow error of an inertial altitude would outweigh the waves.

use super::Observed;
use super::harmonics::MOST;
use touchdown_flight::real::{Real, r};

/// Frequencies of the grid.
const BINS: usize = 32;
/// Steps after which a frequency has its turn again.
const TURNS: usize = 8;
/// Frequencies a step.
const SHARE: usize = BINS / TURNS;
/// Memory, in periods.
const MEMORY: f64 = 2.5;
/// Factor on the line shape of larger peaks.
const MARGIN: f64 = 3.0;
/// Least phase, rad, by which a further peak must run away from a larger one within
/// the memory to be told apart.
const SEPARATION: f64 = 4.5;

/// Sums over the weighted readings, e = exp(i ω (t_j - t)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bin<R> {
    /// Σ 1, Σ y, Σ y².
    one: R,
    y: R,
    yy: R,
    /// Σ e, Σ e², Σ y e.
    e: [R; 2],
    ee: [R; 2],
    ye: [R; 2],
    /// Share of the spread of y that the harmonic explains.
    share: R,
}

/// Readings since a group's last turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Gathered<R> {
    sum: R,
    count: R,
    time: R,
    /// Sum, count and time of the turn before.
    before: [R; 3],
}

impl<R: Real> Gathered<R> {
    /// Velocity, how long before now it was, and its variance over that of a
    /// reading; none without readings.
    fn velocity(&self, observed: Observed) -> Option<[R; 3]> {
        let half = r::<R>(0.5);
        let [sum, count, time] = self.before;
        match observed {
            Observed::Velocity => (self.count > R::ZERO).then(|| {
                let age = half * self.time;
                [self.sum / self.count, age, R::ONE / self.count]
            }),
            Observed::Displacement => {
                // From the middle of the last turn to the middle of this one.
                let between = half * (self.time + time);
                (self.count > R::ZERO && count > R::ZERO && between > R::ZERO).then(|| {
                    let rise = self.sum / self.count - sum / count;
                    let age = half * (self.time + between);
                    let noise = (R::ONE / self.count + R::ONE / count) / (between * between);
                    [rise / between, age, noise]
                })
            }
        }
    }

    /// Begins the next turn.
    fn turn(&mut self) {
        *self = Self {
            before: [self.sum, self.count, self.time],
            ..Self::default()
        };
    }
}

/// The grid and what is known at its frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spectrum<R> {
    /// rad/s.
    frequencies: [R; BINS],
    bins: [Bin<R>; BINS],
    gathered: [Gathered<R>; TURNS],
    turn: usize,
    /// Variance of a velocity over that of a reading, a running mean.
    noise: R,
    /// Time since the start, s.
    time: R,
}

/// A harmonic that stands out: velocity `c cos ω(t_j - t) - s sin ω(t_j - t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak<R> {
    pub(super) angular_frequency: R,
    pub(super) c: R,
    pub(super) s: R,
    /// Share of the spread that it explains.
    pub(super) share: R,
    /// What it explains, as a sum of squares over the variance of a reading.
    pub(super) explained: R,
    /// Periods that have been seen.
    pub(super) periods: R,
}

/// Product of complex numbers.
fn times<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Index of the largest.
fn largest<R: Real>(shares: &[R; BINS]) -> usize {
    let mut best = 0;
    for k in 1..BINS {
        if shares[k] > shares[best] {
            best = k;
        }
    }
    best
}

impl<R: Real> Bin<R> {
    /// Forgets and turns over a time; takes in a velocity of some age.
    fn update(&mut self, w: R, time: R, velocity: Option<[R; 3]>) {
        let memory = r::<R>(MEMORY * core::f64::consts::TAU) / w;
        let keep = (-time / memory).exp();
        let half = w * time * r(0.5);
        let middle = [half.cos(), -half.sin()];
        let turn = times(middle, middle);
        let scaled = |z: [R; 2]| [z[0] * keep, z[1] * keep];
        self.one *= keep;
        self.y *= keep;
        self.yy *= keep;
        self.e = scaled(times(self.e, turn));
        self.ee = scaled(times(self.ee, times(turn, turn)));
        self.ye = scaled(times(self.ye, turn));
        if let Some([y, age, _]) = velocity {
            let e = [(w * age).cos(), -(w * age).sin()];
            let ee = times(e, e);
            self.one += R::ONE;
            self.y += y;
            self.yy += y * y;
            for k in 0..2 {
                self.e[k] += e[k];
                self.ee[k] += ee[k];
                self.ye[k] += y * e[k];
            }
        }
        self.share = self.fit().map_or(R::ZERO, |fit| fit.share);
    }

    /// Spread of the readings about their mean, as a weighted sum of squares.
    fn spread(&self) -> R {
        (self.yy - self.y * self.y / self.one).max(R::ZERO)
    }

    fn fit(&self) -> Option<Peak<R>> {
        let n = self.one;
        if !(n > r(6.0)) {
            return None;
        }
        let half = r::<R>(0.5);
        let cc = (n + self.ee[0]) * half - self.e[0] * self.e[0] / n;
        let ss = (n - self.ee[0]) * half - self.e[1] * self.e[1] / n;
        let cs = self.ee[1] * half - self.e[0] * self.e[1] / n;
        let yc = self.ye[0] - self.y * self.e[0] / n;
        let ys = self.ye[1] - self.y * self.e[1] / n;
        let det = cc * ss - cs * cs;
        // Shorter than about half a period the three cannot be told apart.
        if !(det > r::<R>(1e-3) * n * n) {
            return None;
        }
        let a = (ss * yc - cs * ys) / det;
        let b = (cc * ys - cs * yc) / det;
        let explained = (a * yc + b * ys).max(R::ZERO);
        let spread = self.spread();
        let share = if spread > R::ZERO {
            (explained / spread).min(R::ONE)
        } else {
            R::ZERO
        };
        Some(Peak {
            angular_frequency: R::ZERO,
            c: a,
            s: -b,
            share,
            explained,
            periods: R::ZERO,
        })
    }
}

impl<R: Real> Spectrum<R> {
    /// A grid of equal ratios between neighbours.
    pub(super) fn new(lowest: R, highest: R) -> Self {
        let step = (highest / lowest).ln() / r((BINS - 1) as f64);
        Self {
            frequencies: core::array::from_fn(|k| lowest * (step * r(k as f64)).exp()),
            bins: [Bin::default(); BINS],
            gathered: [Gathered::default(); TURNS],
            turn: 0,
            noise: R::ZERO,
            time: R::ZERO,
        }
    }

    /// Takes a reading in (or none) after `dt` seconds.
    pub(super) fn step(&mut self, observed: Observed, y: Option<R>, dt: R) {
        self.time += dt;
        for gathered in &mut self.gathered {
            gathered.time += dt;
            if let Some(y) = y {
                gathered.sum += y;
                gathered.count += R::ONE;
            }
        }
        let gathered = &mut self.gathered[self.turn];
        let (time, velocity) = (gathered.time, gathered.velocity(observed));
        gathered.turn();
        if let Some([_, _, noise]) = velocity {
            self.noise += r::<R>(0.02) * (noise - self.noise);
        }
        for k in (self.turn * SHARE)..((self.turn + 1) * SHARE) {
            self.bins[k].update(self.frequencies[k], time, velocity);
        }
        self.turn = (self.turn + 1) % TURNS;
    }

    /// Peaks, the largest first. What the line shape of those before spreads to a
    /// frequency is taken off its share, with a margin, before the next is chosen.
    pub(super) fn peaks(&self) -> [Option<Peak<R>>; MOST] {
        let mut peaks = [None; MOST];
        let mut shares = self.bins.map(|bin| bin.share);
        // What is largest at the edge of the band lies outside.
        shares[0] = R::ZERO;
        shares[BINS - 1] = R::ZERO;
        for place in &mut peaks {
            let best = largest(&shares);
            let Some(peak) = self.peak(best, shares[best]) else {
                break;
            };
            *place = Some(peak);
            for k in 0..BINS {
                // |∫ exp(i Δω t) exp(-t/T) dt / T|², T the memory so far.
                let w = self.frequencies[k];
                let memory = r::<R>(MEMORY * core::f64::consts::TAU) / w;
                let phase = (w - peak.angular_frequency) * memory.min(self.time);
                shares[k] -= r::<R>(MARGIN) * peak.share / (R::ONE + phase * phase);
                if phase.abs() < r(SEPARATION) {
                    shares[k] = R::ZERO;
                }
            }
        }
        peaks
    }

    /// The fit at a frequency, which is refined by a parabola through its
    /// neighbours.
    fn peak(&self, best: usize, share: R) -> Option<Peak<R>> {
        let fit = self.bins[best].fit()?;
        if !(share > R::ZERO) {
            return None;
        }
        let frequencies = &self.frequencies;
        let mut w = frequencies[best];
        let half = r::<R>(0.5);
        let [below, here, above] = [best - 1, best, best + 1].map(|k| self.bins[k].share);
        let curvature = below - here - here + above;
        if curvature < R::ZERO && below > R::ZERO {
            let shift = (half * (below - above) / curvature).clamp(-half, half);
            w *= R::ONE + shift * (frequencies[best + 1] / frequencies[best] - R::ONE);
        }
        // From the frequency's last turn to now.
        let angle = w * self.gathered[best / SHARE].time;
        let [c, s] = times([fit.c, fit.s], [angle.cos(), angle.sin()]);
        // Less what larger peaks have spread to it.
        let own = (share / fit.share).min(R::ONE);
        let amplitude = own.sqrt();
        Some(Peak {
            angular_frequency: w,
            c: c * amplitude,
            s: s * amplitude,
            periods: self.time * w * r(1.0 / core::f64::consts::TAU),
            explained: fit.explained * own / self.noise,
            share,
        })
    }

    /// Every frequency has had its turn since the last time this was true.
    pub(super) fn round_done(&self) -> bool {
        self.turn == 0
    }

    /// Variance of the velocity beyond that of its noise, over the longest memory,
    /// and the frequency that explains most of it (the middle of the band where none
    /// does). A tenth of the noise stays: that little cannot be told from none. None
    /// before there are velocities.
    pub(super) fn spread(&self, noise: R) -> Option<[R; 2]> {
        let best = largest(&self.bins.map(|bin| bin.share));
        let bin = &self.bins[0];
        if !(bin.one > R::ONE) {
            return None;
        }
        let noise = noise * self.noise;
        let variance = (bin.spread() / bin.one - noise).max(noise * r(0.1));
        let clear = self.bins[best].share > r(0.35);
        let likely = if clear { best } else { BINS / 2 };
        Some([variance, self.frequencies[likely]])
    }
}
