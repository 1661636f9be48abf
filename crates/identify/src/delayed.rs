//! A signal some time ago.

/// A sampled signal, read at times that must not fall: linear between samples, held at its first and last value.
pub(crate) struct DelayedSignal<'a> {
    time: &'a [f64],
    values: &'a [f64],
    at: usize,
}

impl<'a> DelayedSignal<'a> {
    pub(crate) fn new(time: &'a [f64], values: &'a [f64]) -> Self {
        Self {
            time,
            values,
            at: 0,
        }
    }

    /// The signal at time `t`, which is not before the last one.
    pub(crate) fn at(&mut self, t: f64) -> f64 {
        let (time, values) = (self.time, self.values);
        while self.at + 1 < time.len() && time[self.at + 1] <= t {
            self.at += 1;
        }
        let k = self.at;
        if k + 1 >= time.len() || t <= time[k] {
            return values[k];
        }
        values[k] + (t - time[k]) / (time[k + 1] - time[k]) * (values[k + 1] - values[k])
    }
}

/// A signal delayed by `delay_s`, at its own times.
pub(crate) fn delayed(time: &[f64], values: &[f64], delay_s: f64) -> Vec<f64> {
    if delay_s == 0.0 {
        return values.to_vec();
    }
    let mut signal = DelayedSignal::new(time, values);
    time.iter().map(|t| signal.at(t - delay_s)).collect()
}
