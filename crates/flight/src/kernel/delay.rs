//! The last values of a signal, to be read with a delay.

use crate::real::Real;

/// Values at the last N steps. Reading further back than they reach gives the
/// oldest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay<R, T, const N: usize> {
    /// Values, and the time since the value before, s.
    ring: [(T, R); N],
    newest: usize,
}

impl<R: Real, T: Copy, const N: usize> Delay<R, T, N> {
    /// `value` since ever.
    pub fn new(value: T) -> Self {
        Self {
            ring: [(value, R::ZERO); N],
            newest: 0,
        }
    }

    /// The value `dt` seconds after the last one.
    pub fn push(&mut self, value: T, dt: R) {
        let newest = (self.newest + 1) % N;
        self.newest = newest;
        self.ring[newest] = (value, dt);
    }

    /// The values before and after the time `delay_s` ago, and the share of the
    /// latter in the line between them.
    pub fn around(&self, delay_s: R) -> (T, T, R) {
        let mut left = delay_s;
        let mut at = self.newest % N;
        for _ in 1..N {
            let (value, step) = self.ring[at];
            let before = (at + N - 1) % N;
            if left <= step {
                let share = if step > R::ZERO {
                    R::ONE - left / step
                } else {
                    R::ONE
                };
                return (self.ring[before].0, value, share);
            }
            left -= step;
            at = before;
        }
        (self.ring[at].0, self.ring[at].0, R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::Delay;

    fn read(line: &Delay<f64, f64, 8>, delay_s: f64) -> f64 {
        let (a, b, share) = line.around(delay_s);
        a + share * (b - a)
    }

    #[test]
    fn analytic_a_ramp_is_read_late() {
        let mut line = Delay::new(0.0);
        let mut t = 0.0;
        // Uneven steps; values are their times, so a line is exact.
        for i in 0..50 {
            let dt = if i % 3 == 0 { 0.02 } else { 0.01 };
            t += dt;
            line.push(t, dt);
            if i > 10 {
                for delay in [0.0, 0.004, 0.01, 0.033, 0.07] {
                    // Roundings of sums of fifty terms below one.
                    assert!((read(&line, delay) - (t - delay)).abs() < 1e-14);
                }
            }
        }
        // Seven steps of at most 20 ms are all it remembers.
        assert!(t - read(&line, 10.0) < 0.14);
        assert_eq!(read(&Delay::new(3.0), 0.02), 3.0);
    }
}
