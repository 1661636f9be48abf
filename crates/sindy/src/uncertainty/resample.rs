//! Resampling with replacement: the random numbers of every bootstrap of this crate.

use rand_distr::{Binomial, Distribution};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// The random numbers of replicate `r`, by the seed and its index alone: results are the same for any number of threads.
#[must_use]
pub fn generator(seed: u64, r: usize) -> Pcg64 {
    // Weyl's sequence keeps the seeds of replicates apart; the generator hashes them.
    let step = (r as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    Pcg64::seed_from_u64(seed.wrapping_add(step))
}

/// A number below `n`, each as likely but for one part in 2^64 / n.
pub fn below(rng: &mut Pcg64, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> 64) as usize
}

/// How often each of `n` blocks is drawn in `n` draws with replacement.
pub fn counts(rng: &mut Pcg64, n: usize) -> Vec<u32> {
    let mut counts = vec![0; n];
    for _ in 0..n {
        counts[below(rng, n)] += 1;
    }
    counts
}

/// Number of draws of each row, chunk by chunk: the number of draws in a chunk is binomial given
/// those that are left, and uniform within it, so that all together are `n` draws of `n` rows with
/// replacement.
pub(super) struct RowDraws {
    rng: Pcg64,
    rows_left: usize,
    draws_left: u64,
}

impl RowDraws {
    pub(super) fn new(rng: Pcg64, rows: usize) -> Self {
        Self {
            rng,
            rows_left: rows,
            draws_left: rows as u64,
        }
    }

    /// Adds to the weights of the next `rows` rows of replicate `b` of `stride`.
    pub(super) fn fill(&mut self, rows: usize, weights: &mut [f64], (b, stride): (usize, usize)) {
        let share = rows as f64 / self.rows_left as f64;
        let draws = match Binomial::new(self.draws_left, share) {
            Ok(binomial) if rows < self.rows_left => binomial.sample(&mut self.rng),
            _ => self.draws_left,
        };
        for _ in 0..draws {
            weights[below(&mut self.rng, rows) * stride + b] += 1.0;
        }
        self.rows_left -= rows;
        self.draws_left -= draws;
    }
}
