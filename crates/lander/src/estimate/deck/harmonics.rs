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

/// Index of a harmonic's place c.
const fn at(k: usize) -> usize {
    FIRST + 3 * k
}

impl<R: Real> Harmonics<R> {
    /// An offset without harmonics, with the variances of the offset and its rate.
    pub(super) fn new(offset: R, variance: [R; 2]) -> Self {
        let mut p = [[R::ZERO; SIZE]; SIZE];
        p[0][0] = variance[0];
        p[1][1] = variance[1];
        let mut x = [R::ZERO; SIZE];
        x[0] = offset;
        Self {
            count: 0,
            x,
            p,
            mean_power: [R::ZERO; MOST],
            anchor: [R::ZERO; MOST],
        }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    fn size(&self) -> usize {
        FIRST + 3 * self.count
    }

    pub(super) fn frequency(&self, k: usize) -> R {
        self.x[at(k) + 2]
    }

    pub(super) fn frequency_sd(&self, k: usize) -> R {
        self.p[at(k) + 2][at(k) + 2].max(R::ZERO).sqrt()
    }

    /// Square of the amplitude.
    pub(super) fn power(&self, k: usize) -> R {
        let (c, s) = (self.x[at(k)], self.x[at(k) + 1]);
        c * c + s * s
    }

    /// Mean of the squared amplitude over some periods.
    pub(super) fn mean_power(&self, k: usize) -> R {
        self.mean_power[k]
    }

    pub(super) fn set_mean_power(&mut self, k: usize, power: R) {
        self.mean_power[k] = power;
    }

    /// Variance of place and quadrature together.
    pub(super) fn power_variance(&self, k: usize) -> R {
        self.p[at(k)][at(k)] + self.p[at(k) + 1][at(k) + 1]
    }

    /// Adds a harmonic that is independent of the others, if there is room.
    pub(super) fn add(&mut self, state: [R; 3], variance: [R; 3]) {
        if self.count == MOST {
            return;
        }
        let first = at(self.count);
        self.anchor[self.count] = state[2];
        self.mean_power[self.count] = state[0] * state[0] + state[1] * state[1];
        self.count += 1;
        for i in 0..3 {
            for j in 0..SIZE {
                self.p[first + i][j] = R::ZERO;
                self.p[j][first + i] = R::ZERO;
            }
            self.x[first + i] = state[i];
            self.p[first + i][first + i] = variance[i];
        }
    }

    pub(super) fn anchor(&self, k: usize) -> R {
        self.anchor[k]
    }

    /// Moves the anchor of a harmonic towards a frequency by a share of the distance.
    pub(super) fn pull(&mut self, k: usize, frequency: R, share: R) {
        self.anchor[k] += share * (frequency - self.anchor[k]);
    }

    /// Drops a harmonic.
    pub(super) fn remove(&mut self, k: usize) {
        let last = self.count - 1;
        for i in 0..3 {
            let (to, from) = (at(k) + i, at(last) + i);
            self.x[to] = self.x[from];
            self.p.swap(to, from);
        }
        for row in &mut self.p {
            for i in 0..3 {
                row.swap(at(k) + i, at(last) + i);
            }
        }
        self.mean_power.swap(k, last);
        self.anchor.swap(k, last);
        self.count = last;
    }

    /// Place and quadrature after a time.
    fn turned(&self, k: usize, cosine: R, sine: R) -> (R, R) {
        let (c, s) = (self.x[at(k)], self.x[at(k) + 1]);
        (cosine * c - sine * s, sine * c + cosine * s)
    }

    pub(super) fn propagate(&mut self, coherence: &Coherence<R>, dt: R) {
        let n = self.size();
        let loss = coherence.rate * dt;
        let keep = (-loss).exp();
        let fading = -(-(loss + loss)).exp_m1();
        for k in 0..self.count {
            let i = at(k);
            let angle = self.x[i + 2] * dt;
            let (sine, cosine) = angle.sin_cos();
            let (cosine, sine) = (keep * cosine, keep * sine);
            let share = (dt * self.x[i + 2] * r(POWER_MEMORY)).min(R::ONE);
            // The second moment includes the variance of the estimate.
            let moment = self.power(k) + self.power_variance(k);
            self.mean_power[k] += share * (moment - self.mean_power[k]);
            let gained = fading * self.mean_power[k];
            let (c, s) = self.turned(k, cosine, sine);
            (self.x[i], self.x[i + 1]) = (c, s);
            let (by_c, by_s) = (-dt * s, dt * c);
            let stay = (R::ONE - r::<R>(RETURN) * loss).max(R::ZERO);
            self.x[i + 2] = self.anchor[k] + stay * (self.x[i + 2] - self.anchor[k]);
            // Rows, then columns: F P Fᵀ.
            for j in 0..n {
                let (a, b, w) = (self.p[i][j], self.p[i + 1][j], self.p[i + 2][j]);
                self.p[i][j] = cosine * a - sine * b + by_c * w;
                self.p[i + 1][j] = sine * a + cosine * b + by_s * w;
                self.p[i + 2][j] = stay * w;
            }
            for j in 0..n {
                let (a, b, w) = (self.p[j][i], self.p[j][i + 1], self.p[j][i + 2]);
                self.p[j][i] = cosine * a - sine * b + by_c * w;
                self.p[j][i + 1] = sine * a + cosine * b + by_s * w;
                self.p[j][i + 2] = stay * w;
            }
            // The force drives the velocity, so it enters the quadrature.
            self.p[i + 1][i + 1] += gained;
            // The stationary variance of an incoherent frequency is that of its anchor.
            let width = r::<R>(WIDTH) * self.anchor[k];
            self.p[i + 2][i + 2] += (R::ONE - stay * stay) * width * width;
        }
        self.x[0] += dt * self.x[1];
        for j in 0..n {
            self.p[0][j] += dt * self.p[1][j];
        }
        for j in 0..n {
            self.p[j][0] += dt * self.p[j][1];
        }
        self.p[0][0] += coherence.drift[0] * dt;
        self.p[1][1] += coherence.drift[1] * dt;
    }

    /// Expected reading and its gradient by the state.
    fn expected(&self, row: Row) -> (R, [R; SIZE]) {
        let mut h = [R::ZERO; SIZE];
        let mut value = self.x[0];
        h[0] = R::ONE;
        for k in 0..self.count {
            let i = at(k);
            match row {
                Row::Displacement => {
                    value += self.x[i];
                    h[i] = R::ONE;
                }
                Row::Velocity => {
                    let (s, w) = (self.x[i + 1], self.x[i + 2]);
                    value -= w * s;
                    h[i + 1] = -w;
                    h[i + 2] = -s;
                }
            }
        }
        (value, h)
    }

    /// Corrects by a reading, whose innovation is limited to `gate` standard deviations.
    /// Returns the limited reading and its normalised innovation squared.
    pub(super) fn correct(&mut self, row: Row, reading: R, noise: R, gate: R) -> (R, R) {
        let n = self.size();
        let (value, h) = self.expected(row);
        let mut spread = [R::ZERO; SIZE];
        let mut variance = noise;
        for i in 0..n {
            for j in 0..n {
                spread[i] += self.p[i][j] * h[j];
            }
            variance += h[i] * spread[i];
        }
        let limit = gate * variance.sqrt();
        let residual = (reading - value).clamp(-limit, limit);
        let mut gain = [R::ZERO; SIZE];
        for i in 0..n {
            gain[i] = spread[i] / variance;
            self.x[i] += gain[i] * residual;
        }
        // Joseph's form: A = (1 - K h) P, then A (1 - K h)ᵀ + K noise Kᵀ.
        let mut ah = [R::ZERO; SIZE];
        for i in 0..n {
            for j in 0..n {
                self.p[i][j] -= gain[i] * spread[j];
                ah[i] += self.p[i][j] * h[j];
            }
        }
        for i in 0..n {
            for j in i..n {
                let c = self.p[i][j] - ah[i] * gain[j] + gain[i] * noise * gain[j];
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
        for k in 0..self.count {
            self.x[at(k) + 2] = self.x[at(k) + 2].clamp(lowest, highest);
        }
    }

    /// The predicted motion after a time, without the offset.
    pub(super) fn predict(&self, coherence: &Coherence<R>, time: R) -> DeckMotionPrediction<R> {
        let n = self.size();
        let rate = coherence.rate;
        let loss = rate * time;
        let keep = (-loss).exp();
        let fading = -(-(loss + loss)).exp_m1();
        let third = r::<R>(1.0 / 3.0);
        // Variance of the phase due to the random walk of the frequency.
        let wander = r::<R>(2.0 * RETURN * WIDTH * WIDTH) * rate * time * time * time * third;
        let mut mean = [R::ZERO; 3];
        let mut added = [R::ZERO; 3];
        // Gradients of displacement, velocity and acceleration.
        let mut g = [[R::ZERO; SIZE]; 3];
        for k in 0..self.count {
            let i = at(k);
            let w = self.x[i + 2];
            let (w2, angle) = (w * w, w * time);
            let (sine, cosine) = angle.sin_cos();
            let (cosine, sine) = (keep * cosine, keep * sine);
            let (c, s) = self.turned(k, cosine, sine);
            mean[0] += c;
            mean[1] -= w * s;
            mean[2] -= w2 * c;
            let of_k = [
                [cosine, -sine, -time * s],
                [-w * sine, -w * cosine, -s - w * time * c],
                [-w2 * cosine, w2 * sine, w2 * time * s - r::<R>(2.0) * w * c],
            ];
            for (g, of_k) in g.iter_mut().zip(of_k) {
                g[i..i + 3].copy_from_slice(&of_k);
            }
            // Variance that the force adds: q ∫ exp(-2κu) sin² ωu du to the place, the
            // same with cos² to the quadrature; q is 2 κ times the mean power.
            let [cos2, sin2] = [cosine * cosine - sine * sine, r::<R>(2.0) * sine * cosine];
            let turning = (w * sin2 - rate * cos2 + rate) / (w2 + rate * rate) * rate;
            let half_power = r::<R>(0.5) * self.mean_power[k];
            let of_c = half_power * (fading - turning).max(R::ZERO);
            let of_s = half_power * (fading + turning).max(R::ZERO);
            let phase = wander * w2;
            added[0] += of_c + phase * s * s;
            added[1] += w2 * (of_s + phase * c * c);
            added[2] += w2 * w2 * (of_c + phase * s * s);
        }
        let mut sd = [R::ZERO; 3];
        for m in 0..3 {
            let mut variance = added[m];
            for i in FIRST..n {
                let mut sum = R::ZERO;
                for j in FIRST..n {
                    sum += self.p[i][j] * g[m][j];
                }
                variance += g[m][i] * sum;
            }
            sd[m] = variance.max(R::ZERO).sqrt();
        }
        DeckMotionPrediction {
            displacement_m: mean[0],
            velocity_mps: mean[1],
            acceleration_mps2: mean[2],
            displacement_sd_m: sd[0],
            velocity_sd_mps: sd[1],
            acceleration_sd_mps2: sd[2],
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.x.iter().all(|c| c.is_finite()) && self.p.iter().flatten().all(|c| c.is_finite())
    }
}
