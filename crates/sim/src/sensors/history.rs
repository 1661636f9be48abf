//! The values of the last steps, for sensors that report them later.

/// A ring of the last values.
pub(crate) struct History<T> {
    values: Vec<T>,
    /// Index of the oldest value, which the next one replaces.
    next: usize,
}

impl<T: Copy> History<T> {
    /// A history of `steps` values, all equal to the first.
    pub(crate) fn new(steps: usize, first: T) -> Self {
        Self {
            values: vec![first; steps],
            next: 0,
        }
    }

    /// Adds the value of a step.
    pub(crate) fn push(&mut self, value: T) {
        self.values[self.next] = value;
        self.next = (self.next + 1) % self.values.len();
    }

    /// The value that is `age` steps older than the newest.
    pub(crate) fn at(&self, age: usize) -> T {
        let n = self.values.len();
        self.values[(self.next + n - 1 - age) % n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_ring_holds_the_last_values() {
        let mut history = History::new(3, 0);
        assert_eq!([0, 1, 2].map(|age| history.at(age)), [0; 3]);
        for step in 1..=7 {
            history.push(step);
        }
        assert_eq!([0, 1, 2].map(|age| history.at(age)), [7, 6, 5]);
    }
}
