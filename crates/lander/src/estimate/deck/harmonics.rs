//! Extended Kalman filter of a drifting offset and up to three harmonics whose
//! frequencies are states.

use super::DeckMotionPrediction;
use touchdown_flight::real::{Real, r};

/// Largest number of harmonics.
pub(super) const MOST: usize = 3;
/// Gain of the running mean of the power, per radian: a memory of three periods. This and
/// the next two hardly matter: halved or doubled, they change the relative prediction
/// error by at most 0.05 (example `heave_prediction`, four seeds).
const POWER_MEMORY: f64 = 1.0 / (3.0 * core::f64::consts::TAU);
/// Rate at which a frequency returns to its anchor, over κ.
const RETURN: f64 = 3.0;
/// Relative standard deviation of an anchor.
const WIDTH: f64 = 0.05;
/// Index of the first harmonic, after the offset and its rate.
const FIRST: usize = 2;
const SIZE: usize = FIRST + 3 * MOST;

/// State of the filter: offset o and its rate, then place c, quadrature s and frequency
/// ω of each harmonic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Harmonics<R> {
    count: usize,
    x: [R; SIZE],
    p: [[R; SIZE]; SIZE],
    /// Mean of c² + s² over some periods.
    mean_power: [R; MOST],
    /// Frequencies Ω to which the harmonics of an incoherent motion return.
    anchor: [R; MOST],
}

/// Measurement equation of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Row {
    /// `o + Σ c`.
    Displacement,
    /// `o - Σ ω s`.
    Velocity,
}

/// Coherence of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coherence<R> {
    /// Decay rate κ of amplitude and phase, 1/s.
    pub(super) rate: R,
    /// Growth of the variances of the offset and its rate, per second.
    pub(super) drift: [R; 2],
}

/// `e^-x`, and `1 - e^-2x` without its cancellation.
fn fading<R: Real>(x: R) -> [R; 2] {
    let less = (-x).exp_m1();
    [R::ONE + less, -less * (R::ONE + R::ONE + less)]
}

/// Index of a harmonic's place c.
const fn at(k: usize) -> usize {
    FIRST + 3 * k
}

impl<R: Real> Harmonics<R> {
    /// An offset without harmonics, with the variances of the offset and its rate.
    pub(super) fn new(offset: R, variance: [R; 2]) -> Self {
        let mut harmonics = Self {
            count: 0,
            x: [R::ZERO; SIZE],
            p: [[R::ZERO; SIZE]; SIZE],
            mean_power: [R::ZERO; MOST],
            anchor: [R::ZERO; MOST],
        };
        harmonics.reset(offset, variance);
        harmonics
    }

    /// Becomes [`Self::new`] in place.
    pub(super) fn reset(&mut self, offset: R, variance: [R; 2]) {
        self.count = 0;
        self.x = [R::ZERO; SIZE];
        self.x[0] = offset;
        for row in &mut self.p {
            *row = [R::ZERO; SIZE];
        }
        (self.p[0][0], self.p[1][1]) = (variance[0], variance[1]);
        (self.mean_power, self.anchor) = ([R::ZERO; MOST], [R::ZERO; MOST]);
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    fn size(&self) -> usize {
        (FIRST + 3 * self.count).min(SIZE)
    }

    /// The harmonics: a number and its index for each, within bounds that the compiler sees.
    fn each(&self) -> impl Iterator<Item = usize> + use<R> {
        (0..MOST).take(self.count)
    }

    fn x(&self, i: usize) -> R {
        self.x.get(i).copied().unwrap_or(R::ZERO)
    }

    fn p(&self, i: usize, j: usize) -> R {
        let row = self.p.get(i);
        row.and_then(|row| row.get(j)).copied().unwrap_or(R::ZERO)
    }

    pub(super) fn frequency(&self, k: usize) -> R {
        self.x(at(k) + 2)
    }

    pub(super) fn frequency_sd(&self, k: usize) -> R {
        self.p(at(k) + 2, at(k) + 2).max(R::ZERO).sqrt()
    }

    /// Square of the amplitude.
    pub(super) fn power(&self, k: usize) -> R {
        let (c, s) = (self.x(at(k)), self.x(at(k) + 1));
        c * c + s * s
    }

    /// Mean of the squared amplitude over some periods.
    pub(super) fn mean_power(&self, k: usize) -> R {
        self.mean_power.get(k).copied().unwrap_or(R::ZERO)
    }

    pub(super) fn set_mean_power(&mut self, k: usize, power: R) {
        if let Some(place) = self.mean_power.get_mut(k) {
            *place = power;
        }
    }

    /// Variance of place and quadrature together.
    pub(super) fn power_variance(&self, k: usize) -> R {
        self.p(at(k), at(k)) + self.p(at(k) + 1, at(k) + 1)
    }

    /// Adds a harmonic that is independent of the others, if there is room.
    pub(super) fn add(&mut self, state: [R; 3], variance: [R; 3]) {
        let (first, count) = (at(self.count), self.count);
        let places = (self.anchor.get_mut(count), self.mean_power.get_mut(count));
        let (Some(anchor), Some(mean_power)) = places else {
            return;
        };
        *anchor = state[2];
        *mean_power = state[0] * state[0] + state[1] * state[1];
        self.count += 1;
        let own = first..first + 3;
        for (i, row) in self.p.iter_mut().enumerate() {
            for (j, element) in row.iter_mut().enumerate() {
                if own.contains(&i) || own.contains(&j) {
                    *element = if i == j && i >= first {
                        variance.get(i - first).copied().unwrap_or(R::ZERO)
                    } else {
                        R::ZERO
                    };
                }
            }
        }
        for (x, state) in self.x.iter_mut().skip(first).zip(state) {
            *x = state;
        }
    }

    pub(super) fn anchor(&self, k: usize) -> R {
        self.anchor.get(k).copied().unwrap_or(R::ZERO)
    }

    /// Moves the anchor of a harmonic towards a frequency by a share of the distance.
    pub(super) fn pull(&mut self, k: usize, frequency: R, share: R) {
        if let Some(anchor) = self.anchor.get_mut(k) {
            *anchor += share * (frequency - *anchor);
        }
    }

    /// Drops a harmonic.
    pub(super) fn remove(&mut self, k: usize) {
        let Some(last) = self
            .count
            .checked_sub(1)
            .filter(|&last| k <= last && last < MOST)
        else {
            return;
        };
        for i in 0..3 {
            let (to, from) = ((at(k) + i).min(SIZE - 1), (at(last) + i).min(SIZE - 1));
            self.x[to] = self.x[from];
            self.p.swap(to, from);
        }
        for row in &mut self.p {
            for i in 0..3 {
                row.swap((at(k) + i).min(SIZE - 1), (at(last) + i).min(SIZE - 1));
            }
        }
        self.mean_power.swap(k, last);
        self.anchor.swap(k, last);
        self.count = last;
    }

    /// Place and quadrature after a time.
    fn turned(&self, k: usize, cosine: R, sine: R) -> (R, R) {
        let (c, s) = (self.x(at(k)), self.x(at(k) + 1));
        (cosine * c - sine * s, sine * c + cosine * s)
    }

    #[inline(never)]
    pub(super) fn propagate(&mut self, coherence: &Coherence<R>, dt: R) {
        let n = self.size();
        let loss = coherence.rate * dt;
        let [keep, fading] = fading(loss);
        let stay = (R::ONE - r::<R>(RETURN) * loss).max(R::ZERO);
        for k in self.each() {
            let i = at(k);
            let w = self.x[i + 2];
            let (sine, cosine) = (w * dt).sin_cos();
            let (cosine, sine) = (keep * cosine, keep * sine);
            let share = (dt * w * r(POWER_MEMORY)).min(R::ONE);
            // The second moment includes the variance of the estimate.
            let moment = self.power(k) + self.power_variance(k);
            self.mean_power[k] += share * (moment - self.mean_power[k]);
            let gained = fading * self.mean_power[k];
            let (c, s) = self.turned(k, cosine, sine);
            (self.x[i], self.x[i + 1]) = (c, s);
            let (by_c, by_s) = (-dt * s, dt * c);
            self.x[i + 2] = self.anchor[k] + stay * (w - self.anchor[k]);
            let turn = |a: &mut R, b: &mut R, w: &mut R| {
                let (of_c, of_s) = (
                    cosine * *a - sine * *b + by_c * *w,
                    sine * *a + cosine * *b + by_s * *w,
                );
                (*a, *b, *w) = (of_c, of_s, stay * *w);
            };
            // Rows, then columns: F P Fᵀ.
            if let Some([a, b, w]) = self.p.get_mut(i..i + 3) {
                for ((a, b), w) in a.iter_mut().zip(b).zip(w).take(n) {
                    turn(a, b, w);
                }
            }
            for row in self.p.iter_mut().take(n) {
                if let Some([a, b, w]) = row.get_mut(i..i + 3) {
                    turn(a, b, w);
                }
            }
            // The force drives the velocity, so it enters the quadrature.
            self.p[i + 1][i + 1] += gained;
            // The stationary variance of an incoherent frequency is that of its anchor.
            let width = r::<R>(WIDTH) * self.anchor[k];
            self.p[i + 2][i + 2] += (R::ONE - stay * stay) * width * width;
        }
        self.x[0] += dt * self.x[1];
        let [offset, rate, ..] = &mut self.p;
        for (offset, rate) in offset.iter_mut().zip(rate).take(n) {
            *offset += dt * *rate;
        }
        for row in self.p.iter_mut().take(n) {
            row[0] += dt * row[1];
        }
        self.p[0][0] += coherence.drift[0] * dt;
        self.p[1][1] += coherence.drift[1] * dt;
    }

    /// Expected reading, and the part of its gradient by the state that is not zero.
    fn expected(&self, row: Row) -> (R, [(usize, R); 1 + 2 * MOST], usize) {
        let mut value = self.x[0];
        let mut h = [(0, R::ONE); 1 + 2 * MOST];
        let mut length = 1;
        let mut slots = h.iter_mut().skip(1);
        let mut put = |entry| {
            if let Some(slot) = slots.next() {
                *slot = entry;
                length += 1;
            }
        };
        for k in self.each() {
            let i = at(k);
            match row {
                Row::Displacement => {
                    value += self.x[i];
                    put((i, R::ONE));
                }
                Row::Velocity => {
                    let (s, w) = (self.x[i + 1], self.x[i + 2]);
                    value -= w * s;
                    put((i + 1, -w));
                    put((i + 2, -s));
                }
            }
        }
        (value, h, length)
    }

    /// Corrects by a reading, whose innovation is limited to `gate` standard deviations.
    /// Returns the limited reading and its normalised innovation squared.
    #[inline(never)]
    pub(super) fn correct(&mut self, row: Row, reading: R, noise: R, gate: R) -> (R, R) {
        let n = self.size();
        let (value, h, length) = self.expected(row);
        let h = h.get(..length).unwrap_or(&[]);
        let mut spread = [R::ZERO; SIZE];
        for (spread, row) in spread.iter_mut().zip(&self.p).take(n) {
            for &(j, h) in h {
                *spread += row.get(j).copied().unwrap_or(R::ZERO) * h;
            }
        }
        let of = |list: &[R; SIZE], j: usize| list.get(j).copied().unwrap_or(R::ZERO);
        let mut variance = noise;
        for &(j, h) in h {
            variance += h * of(&spread, j);
        }
        let limit = gate * variance.sqrt();
        let residual = (reading - value).clamp(-limit, limit);
        let mut gain = [R::ZERO; SIZE];
        // Joseph's form: A = (1 - K h) P, then A (1 - K h)ᵀ + K noise Kᵀ.
        let mut ah = [R::ZERO; SIZE];
        let rows = self.x.iter_mut().zip(&self.p).zip(&spread).take(n);
        for (((x, row), spread_i), (gain, ah)) in rows.zip(gain.iter_mut().zip(&mut ah)) {
            *gain = *spread_i / variance;
            *x += *gain * residual;
            for &(j, h) in h {
                *ah += (of(row, j) - *gain * of(&spread, j)) * h;
            }
        }
        for i in (0..SIZE).take(n) {
            let (gain_i, ah) = (gain[i], ah[i]);
            let noise = gain_i * noise;
            for j in (i..SIZE).take(n - i) {
                let c = (self.p[i][j] - gain_i * spread[j]) - ah * gain[j] + noise * gain[j];
                self.p[i][j] = c;
                self.p[j][i] = c;
            }
            // Rounding can make a vanishing variance negative.
            self.p[i][i] = self.p[i][i].max(R::ZERO);
        }
        (value + residual, residual * residual / variance)
    }

    /// Limits the frequencies to a band.
    pub(super) fn limit(&mut self, lowest: R, highest: R) {
        for k in self.each() {
            self.x[at(k) + 2] = self.x[at(k) + 2].clamp(lowest, highest);
        }
    }

    /// The predicted motion after a time, without the offset.
    pub(super) fn predict(&self, coherence: &Coherence<R>, time: R) -> DeckMotionPrediction<R> {
        let ahead = Ahead::new(self, coherence, time);
        DeckMotionPrediction {
            displacement_m: ahead.mean[0],
            displacement_sd_m: ahead.sd(self, 0),
            ..ahead.motion(self)
        }
    }

    /// As [`Self::predict`], without displacement and its standard deviation, which are zero.
    pub(super) fn predict_motion(
        &self,
        coherence: &Coherence<R>,
        time: R,
    ) -> DeckMotionPrediction<R> {
        Ahead::new(self, coherence, time).motion(self)
    }

    /// The acceleration of [`Self::predict`].
    pub(super) fn predict_acceleration(&self, coherence: &Coherence<R>, time: R) -> R {
        let keep = (-(coherence.rate * time)).exp();
        let mut acceleration = R::ZERO;
        for k in self.each() {
            let w = self.x[at(k) + 2];
            let (sine, cosine) = (w * time).sin_cos();
            let (c, _) = self.turned(k, keep * cosine, keep * sine);
            acceleration -= w * w * c;
        }
        acceleration
    }

    /// Whether all numbers are finite: zero times any of them is then zero.
    pub(super) fn is_finite(&self) -> bool {
        let all = self.x.iter().chain(self.p.iter().flatten());
        all.fold(R::ZERO, |sum, &c| sum + c * R::ZERO) == R::ZERO
    }
}

/// The harmonics after a time.
struct Ahead<R> {
    /// Displacement, velocity and acceleration.
    mean: [R; 3],
    /// Variances that force and wandering frequency add to them.
    added: [R; 3],
    /// Their gradients by the harmonics' states.
    gradient: [[R; 3 * MOST]; 3],
}

impl<R: Real> Ahead<R> {
    #[inline(never)]
    fn new(harmonics: &Harmonics<R>, coherence: &Coherence<R>, time: R) -> Self {
        let rate = coherence.rate;
        let loss = rate * time;
        let [keep, fading] = fading(loss);
        let third = r::<R>(1.0 / 3.0);
        // Variance of the phase due to the random walk of the frequency.
        let wander = r::<R>(2.0 * RETURN * WIDTH * WIDTH) * rate * time * time * time * third;
        let (mut mean, mut added) = ([R::ZERO; 3], [R::ZERO; 3]);
        let mut gradient = [[R::ZERO; 3 * MOST]; 3];
        for k in harmonics.each() {
            let w = harmonics.x[at(k) + 2];
            let (w2, angle) = (w * w, w * time);
            let (sine, cosine) = angle.sin_cos();
            let (cosine, sine) = (keep * cosine, keep * sine);
            let (c, s) = harmonics.turned(k, cosine, sine);
            mean[0] += c;
            mean[1] -= w * s;
            mean[2] -= w2 * c;
            let of_k = [
                [cosine, -sine, -time * s],
                [-w * sine, -w * cosine, -s - w * time * c],
                [-w2 * cosine, w2 * sine, w2 * time * s - r::<R>(2.0) * w * c],
            ];
            for (gradient, of_k) in gradient.iter_mut().zip(of_k) {
                for (place, value) in gradient.iter_mut().skip(3 * k).zip(of_k) {
                    *place = value;
                }
            }
            // Variance that the force adds: q ∫ exp(-2κu) sin² ωu du to the place, the
            // same with cos² to the quadrature; q is 2 κ times the mean power.
            let [cos2, sin2] = [cosine * cosine - sine * sine, r::<R>(2.0) * sine * cosine];
            let turning = (w * sin2 - rate * cos2 + rate) / (w2 + rate * rate) * rate;
            let half_power = r::<R>(0.5) * harmonics.mean_power[k];
            let of_c = half_power * (fading - turning).max(R::ZERO);
            let of_s = half_power * (fading + turning).max(R::ZERO);
            let phase = wander * w2;
            added[0] += of_c + phase * s * s;
            added[1] += w2 * (of_s + phase * c * c);
            added[2] += w2 * w2 * (of_c + phase * s * s);
        }
        Self {
            mean,
            added,
            gradient,
        }
    }

    /// Velocity and acceleration with their standard deviations.
    fn motion(&self, harmonics: &Harmonics<R>) -> DeckMotionPrediction<R> {
        DeckMotionPrediction {
            velocity_mps: self.mean[1],
            acceleration_mps2: self.mean[2],
            velocity_sd_mps: self.sd(harmonics, 1),
            acceleration_sd_mps2: self.sd(harmonics, 2),
            ..DeckMotionPrediction::default()
        }
    }

    /// Standard deviation of displacement (0), velocity (1) or acceleration (2).
    #[inline(never)]
    fn sd(&self, harmonics: &Harmonics<R>, of: usize) -> R {
        let n = 3 * harmonics.count;
        let (Some(gradient), Some(variance)) = (self.gradient.get(of), self.added.get(of)) else {
            return R::ZERO;
        };
        let [_, _, rows @ ..] = &harmonics.p;
        // gᵀ P g of a symmetric P: what is below its diagonal counts twice, and half of the diagonal with it.
        let mut half = R::ZERO;
        for (i, (row, own)) in rows.iter().zip(gradient).take(n).enumerate() {
            let [_, _, row @ ..] = row;
            let (mut sum, mut last) = (R::ZERO, R::ZERO);
            for (p, gradient) in row.iter().zip(gradient).take(i + 1) {
                last = *p * *gradient;
                sum += last;
            }
            half += *own * (sum - r::<R>(0.5) * last);
        }
        (*variance + half + half).max(R::ZERO).sqrt()
    }
}
