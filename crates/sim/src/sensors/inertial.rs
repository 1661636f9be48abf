//! What the inertial unit felt in the last steps.

use crate::number::vector::add;

/// Specific forces in body axes and attitudes of the last steps.
pub(super) struct Felt {
    values: Vec<([f64; 3], [f64; 4])>,
    /// Place of the oldest, where the next one goes.
    next: usize,
}

impl Felt {
    /// Remembers so many steps, as if all before the first had felt alike.
    pub(super) fn new(steps: usize, force_mps2: [f64; 3], attitude: [f64; 4]) -> Self {
        Self {
            values: vec![(force_mps2, attitude); steps],
            next: 0,
        }
    }

    /// Takes in a step.
    pub(super) fn push(&mut self, force_mps2: [f64; 3], attitude: [f64; 4]) {
        self.values[self.next] = (force_mps2, attitude);
        self.next = (self.next + 1) % self.values.len();
    }

    /// The step that is `back` steps older than the newest.
    fn at(&self, back: usize) -> &([f64; 3], [f64; 4]) {
        let n = self.values.len();
        &self.values[(self.next + n - 1 - back) % n]
    }

    /// Mean specific force over `count` steps, the last of which is `late` steps older than the newest, m/s²;
    /// together no more than are remembered.
    pub(super) fn mean_mps2(&self, late: usize, count: usize) -> [f64; 3] {
        let steps = (late..late + count).rev();
        let sum = steps.fold([0.0; 3], |sum, back| add(sum, self.at(back).0));
        sum.map(|sum| sum / count as f64)
    }

    /// Attitude `late` steps before the newest.
    pub(super) fn attitude(&self, late: usize) -> [f64; 4] {
        self.at(late).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_means_of_a_ramp() {
        let level = [1.0, 0.0, 0.0, 0.0];
        let mut felt = Felt::new(6, [0.0; 3], level);
        // Sums and quotients of small whole numbers are exact.
        for step in 1..=20 {
            let force = f64::from(step);
            felt.push([force, 0.0, 2.0 * force], [force, 0.0, 0.0, 0.0]);
        }
        assert_eq!(felt.mean_mps2(0, 1), [20.0, 0.0, 40.0]);
        assert_eq!(felt.mean_mps2(0, 4), [18.5, 0.0, 37.0]);
        assert_eq!(felt.mean_mps2(2, 4), [16.5, 0.0, 33.0]);
        assert_eq!(felt.attitude(5)[0], 15.0);
    }
}
