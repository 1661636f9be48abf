//! Recursive search for periodic motion: least squares of a constant and a harmonic
//! at each frequency of a grid.
//!
//! At the frequency ω the velocities y_j at the times t_j are fitted by
//! `o + c cos ω(t_j - t) - s sin ω(t_j - t)` with weights that decay over 2.5 periods.
//! This is the floating-mean periodogram of Zechmeister & Kürster (2009) in recursive
//! form. It needs nine sums for each frequency: a step rotates them by ω dt and adds
//! the new velocity.
//!
//! Each step updates a few frequencies, with the mean of the readings since their last
//! update. Displacements are differenced to velocities: the slow error of an inertial
//! altitude would otherwise outweigh the waves.
//!
//! Comments on constants give the change of the relative prediction error, measured as in
//! `search.rs`.

use super::Observed;
use super::harmonics::MOST;
use touchdown_flight::real::{Real, r};

/// Frequencies of the grid. Over periods of 0.4 to 16 s neighbours are 13 % apart, about
/// the line width that 2.5 periods resolve.
const BINS: usize = 32;
/// Steps between two updates of a frequency. More steps cost less computing time, but
/// at 100 Hz eight steps are already a fifth of the shortest period.
const GROUPS: usize = 8;
/// Frequencies that each step updates.
const GROUP_SIZE: usize = BINS / GROUPS;
/// Memory, in periods. It is a compromise: halved, two tones are found sooner (0.26 to
/// 0.09), but a sea is predicted worse (0.44 to 0.53), as with the double value.
const MEMORY: f64 = 2.5;
/// Safety factor on the line shape of larger peaks. Halved, the line shape of one tone
/// starts false harmonics (0.06 to 0.14); doubled: changes of at most 0.07.
const MARGIN: f64 = 3.0;
/// Least phase difference, rad, that two separate peaks accumulate within the memory.
/// Halved, one tone becomes two (0.06 to 0.12); doubled, a sea has too few (0.44 to 0.52).
const SEPARATION: f64 = 4.5;
/// Least sum of weights of a fit: twice its three unknowns.
const LEAST_WEIGHT: f64 = 6.0;
/// Least determinant of the normal equations, over the squared sum of weights. Over less
/// than about half a period, constant, cosine and sine are not identifiable.
const LEAST_DETERMINANT: f64 = 1e-3;
/// Gain of the running mean of the velocity's noise: 50 updates, half a second at 100 Hz.
const NOISE_GAIN: f64 = 0.02;
/// Least variance of the velocity's noise at a frequency, over the mean of all: that of 0.6 Hz at 100 Hz. Slower than that the
/// error of an inertial altitude exceeds the noise of the readings.
const LEAST_NOISE: f64 = 0.05;
/// Least variance of the motion before the first harmonic, over that of the noise. A
/// smaller motion is not detectable.
const LEAST_SIGNAL: f64 = 0.1;
/// Share of the sum of squares above which a frequency counts as that of the motion. It
/// equals the share at which the first harmonic starts.
const CLEAR_SHARE: f64 = 0.35;

/// Sums over the weighted velocities, with e = exp(i ω (t_j - t)).
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
    /// Share of the sum of squares of y that the harmonic explains.
    share: R,
}

/// Readings since the last update of a group of frequencies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PendingReadings<R> {
    sum: R,
    count: R,
    time: R,
    /// Sum, count and time of the previous interval.
    before: [R; 3],
}

impl<R: Real> PendingReadings<R> {
    /// Velocity, its age, and its variance over that of a reading; none without
    /// readings.
    fn velocity(&self, observed: Observed) -> Option<[R; 3]> {
        let half = r::<R>(0.5);
        let [sum, count, time] = self.before;
        match observed {
            Observed::Velocity => (self.count > R::ZERO).then(|| {
                let age = half * self.time;
                [self.sum / self.count, age, R::ONE / self.count]
            }),
            Observed::Displacement => {
                // From the middle of the previous interval to the middle of this one.
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

    /// Variance of the velocity's noise at a frequency over its mean. Differences of readings over the time Δ have
    /// `1 - cos ωΔ = 2 sin² ωΔ/2`: little at low frequencies.
    fn noise_at(&self, observed: Observed, w: R) -> R {
        let [.., interval] = self.before;
        let sine = (r::<R>(0.5) * w * interval).sin();
        match observed {
            Observed::Velocity => R::ONE,
            Observed::Displacement => (r::<R>(2.0) * sine * sine).max(r(LEAST_NOISE)),
        }
    }

    /// Begins the next interval.
    fn begin_next(&mut self) {
        *self = Self {
            before: [self.sum, self.count, self.time],
            ..Self::default()
        };
    }
}

/// The grid of frequencies and the fit at each of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spectrum<R> {
    /// rad/s.
    frequencies: [R; BINS],
    bins: [Bin<R>; BINS],
    pending: [PendingReadings<R>; GROUPS],
    /// The group that the next step updates.
    group: usize,
    /// Variance of a velocity over that of a reading, a running mean.
    noise: R,
    /// Time since the start, s.
    time: R,
}

/// A peak of the spectrum: velocity `c cos ω(t_j - t) - s sin ω(t_j - t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak<R> {
    pub(super) angular_frequency: R,
    pub(super) c: R,
    pub(super) s: R,
    /// Share of the sum of squares that it explains.
    pub(super) share: R,
    /// Explained sum of squares over the variance of a reading.
    pub(super) explained: R,
    /// Variance of the velocity's noise at its frequency, over the mean of all frequencies.
    pub(super) noise: R,
    /// Number of observed periods.
    pub(super) periods: R,
}

/// Product of complex numbers.
fn times<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Index of the largest share.
fn largest<R: Real>(shares: &[R; BINS]) -> usize {
    let [first, ..] = shares;
    let (mut best, mut most) = (0, *first);
    for (k, &share) in shares.iter().enumerate().skip(1) {
        if share > most {
            (best, most) = (k, share);
        }
    }
    best
}

impl<R: Real> Bin<R> {
    /// Fades and rotates the sums over a time, then adds a velocity and its age.
    fn update(&mut self, w: R, time: R, velocity: Option<[R; 3]>) {
        // e^-x, to 1e-4 over one interval. After a gap of five memories 0.05 of the sums is left, in place of 0.007.
        let x = w * time * r(1.0 / (MEMORY * core::f64::consts::TAU));
        let keep = R::ONE / (R::ONE + x * (R::ONE + r::<R>(0.5) * x));
        let half = w * time * r(0.5);
        let (sine, cosine) = half.sin_cos();
        let middle = [cosine, -sine];
        let turn = times(middle, middle);
        let twice = times(turn, turn);
        let scaled = |z: [R; 2]| [z[0] * keep, z[1] * keep];
        self.one *= keep;
        self.y *= keep;
        self.yy *= keep;
        self.e = scaled(times(self.e, turn));
        self.ee = scaled(times(self.ee, twice));
        self.ye = scaled(times(self.ye, turn));
        if let Some([y, age, _]) = velocity {
            // Displacements at even times: the velocity is as old as the last update.
            let (e, ee) = if age == time {
                (turn, twice)
            } else {
                let (sine, cosine) = (w * age).sin_cos();
                let e = [cosine, -sine];
                (e, times(e, e))
            };
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

    /// Weighted sum of squares of the velocities about their mean.
    fn spread(&self) -> R {
        (self.yy - self.y * self.y / self.one).max(R::ZERO)
    }

    fn fit(&self) -> Option<Peak<R>> {
        let n = self.one;
        if !(n > r(LEAST_WEIGHT)) {
            return None;
        }
        let half = r::<R>(0.5);
        let cc = (n + self.ee[0]) * half - self.e[0] * self.e[0] / n;
        let ss = (n - self.ee[0]) * half - self.e[1] * self.e[1] / n;
        let cs = self.ee[1] * half - self.e[0] * self.e[1] / n;
        let yc = self.ye[0] - self.y * self.e[0] / n;
        let ys = self.ye[1] - self.y * self.e[1] / n;
        let det = cc * ss - cs * cs;
        if !(det > r::<R>(LEAST_DETERMINANT) * n * n) {
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
            noise: R::ONE,
            periods: R::ZERO,
        })
    }
}

impl<R: Real> Spectrum<R> {
    /// A grid with a constant ratio between neighbours.
    pub(super) fn new(lowest: R, highest: R) -> Self {
        let mut spectrum = Self {
            frequencies: [R::ZERO; BINS],
            bins: [Bin::default(); BINS],
            pending: [PendingReadings::default(); GROUPS],
            group: 0,
            noise: R::ZERO,
            time: R::ZERO,
        };
        spectrum.reset(lowest, highest);
        spectrum
    }

    /// Becomes [`Self::new`] in place.
    pub(super) fn reset(&mut self, lowest: R, highest: R) {
        let step = (highest / lowest).ln() / R::from_count(BINS - 1);
        for (k, (frequency, bin)) in self.frequencies.iter_mut().zip(&mut self.bins).enumerate() {
            *frequency = lowest * (step * R::from_count(k)).exp();
            *bin = Bin::default();
        }
        for pending in &mut self.pending {
            *pending = PendingReadings::default();
        }
        self.group = 0;
        (self.noise, self.time) = (R::ZERO, R::ZERO);
    }

    /// Advances by `dt` seconds and adds a reading, if there is one.
    pub(super) fn step(&mut self, observed: Observed, y: Option<R>, dt: R) {
        self.time += dt;
        for pending in &mut self.pending {
            pending.time += dt;
            if let Some(y) = y {
                pending.sum += y;
                pending.count += R::ONE;
            }
        }
        let group = self.group % GROUPS;
        let pending = &mut self.pending[group];
        let (time, velocity) = (pending.time, pending.velocity(observed));
        pending.begin_next();
        if let Some([_, _, noise]) = velocity {
            self.noise += r::<R>(NOISE_GAIN) * (noise - self.noise);
        }
        let bins = self.bins.iter_mut().zip(&self.frequencies);
        for (bin, &frequency) in bins.skip(group * GROUP_SIZE).take(GROUP_SIZE) {
            bin.update(frequency, time, velocity);
        }
        self.group = (group + 1) % GROUPS;
    }

    /// The shares that the frequencies explain.
    fn shares(&self) -> [R; BINS] {
        let mut shares = [R::ZERO; BINS];
        for (share, bin) in shares.iter_mut().zip(&self.bins) {
            *share = bin.share;
        }
        shares
    }

    /// Peaks, the largest first. Each peak's line shape, with a margin, is subtracted
    /// from the shares before the next peak is chosen.
    pub(super) fn peaks(&self, observed: Observed) -> [Option<Peak<R>>; MOST] {
        let mut peaks = [None; MOST];
        let mut shares = self.shares();
        // A maximum at the edge of the band belongs to a frequency outside.
        shares[0] = R::ZERO;
        shares[BINS - 1] = R::ZERO;
        for place in &mut peaks {
            let best = largest(&shares);
            let Some(peak) = self.peak(observed, best, shares[best % BINS]) else {
                break;
            };
            *place = Some(peak);
            for (share, &w) in shares.iter_mut().zip(&self.frequencies) {
                // |∫ exp(i Δω t) exp(-t/T) dt / T|², with T the memory so far.
                let memory = r::<R>(MEMORY * core::f64::consts::TAU) / w;
                let phase = (w - peak.angular_frequency) * memory.min(self.time);
                *share -= r::<R>(MARGIN) * peak.share / (R::ONE + phase * phase);
                if phase.abs() < r(SEPARATION) {
                    *share = R::ZERO;
                }
            }
        }
        peaks
    }

    /// The fit at a grid frequency. A parabola through the neighbours refines the
    /// frequency.
    fn peak(&self, observed: Observed, best: usize, share: R) -> Option<Peak<R>> {
        // A frequency at an edge has no share.
        let bins = self.bins.get(best.checked_sub(1)?..)?;
        let [below, bin, above, ..] = bins else {
            return None;
        };
        let fit = bin.fit()?;
        if !(share > R::ZERO) {
            return None;
        }
        let [mut w, next] = [best, best + 1].map(|k| self.frequencies[k % BINS]);
        let half = r::<R>(0.5);
        let ratio = next / w;
        let [below, here, above] = [below, bin, above].map(|bin| bin.share);
        let curvature = below - here - here + above;
        if curvature < R::ZERO && below > R::ZERO {
            let shift = (half * (below - above) / curvature).clamp(-half, half);
            w *= R::ONE + shift * (ratio - R::ONE);
        }
        // Rotation since this frequency's last update.
        let pending = &self.pending[best / GROUP_SIZE % GROUPS];
        let angle = w * pending.time;
        let (sine, cosine) = angle.sin_cos();
        let [c, s] = times([fit.c, fit.s], [cosine, sine]);
        // Without the part that is the line shape of larger peaks.
        let own = (share / fit.share).min(R::ONE);
        let amplitude = own.sqrt();
        Some(Peak {
            angular_frequency: w,
            c: c * amplitude,
            s: s * amplitude,
            periods: self.time * w * r(1.0 / core::f64::consts::TAU),
            explained: fit.explained * own / self.noise,
            noise: pending.noise_at(observed, w),
            share,
        })
    }

    /// Whether all frequencies have been updated since this was last true.
    pub(super) fn round_done(&self) -> bool {
        self.group == 0
    }

    /// Variance of the velocity without its noise, over the longest memory, and the
    /// frequency that explains most of it. That frequency is the middle of the band if
    /// none explains enough. None before there are velocities.
    pub(super) fn spread(&self, noise: R) -> Option<[R; 2]> {
        let best = largest(&self.shares());
        let bin = &self.bins[0];
        if !(bin.one > R::ONE) {
            return None;
        }
        let noise = noise * self.noise;
        let variance = (bin.spread() / bin.one - noise).max(noise * r(LEAST_SIGNAL));
        let clear = self.bins[best % BINS].share > r(CLEAR_SHARE);
        let likely = if clear { best } else { BINS / 2 };
        Some([variance, self.frequencies[likely % BINS]])
    }
}
