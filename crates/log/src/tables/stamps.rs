//! Which rows to keep so that their stamps increase.

/// Rows kept and dropped.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct KeptRows {
    pub(crate) rows: Vec<usize>,
    pub(crate) absent: usize,
    pub(crate) duplicate: usize,
    pub(crate) backward: usize,
}

/// Whether every stamp is one and comes after the one before it.
pub(crate) fn is_increasing(time_s: &[f64]) -> bool {
    let ends = [time_s.first(), time_s.last()];
    time_s.windows(2).all(|pair| pair[0] < pair[1])
        && ends.into_iter().flatten().all(|t| t.is_finite())
}

/// Keeps rows (of `rows`, in order) with strictly increasing stamps.
///
/// A row whose stamp is not after the latest kept one is dropped. If a single late stamp would
/// cost all rows after it, the smallest number of rows is dropped instead.
pub(crate) fn increasing(time_s: &[f64], rows: &[usize]) -> KeptRows {
    let mut kept = KeptRows::default();
    let stamped: Vec<usize> = rows
        .iter()
        .copied()
        .filter(|&i| time_s[i].is_finite())
        .collect();
    kept.absent = rows.len() - stamped.len();
    for &row in &stamped {
        if kept
            .rows
            .last()
            .is_none_or(|&last| time_s[row] > time_s[last])
        {
            kept.rows.push(row);
        }
    }
    if kept.rows.len() < stamped.len() {
        let longest = longest_increasing(time_s, &stamped);
        if longest.len() > kept.rows.len() {
            kept.rows = longest;
        }
        kept.duplicate = count_duplicates(time_s, &stamped, &kept.rows);
        kept.backward = stamped.len() - kept.rows.len() - kept.duplicate;
    }
    kept
}

/// Rows that must follow a step back, in order and before the time from which it leads, for a restart.
const RESTARTED: usize = 10;

/// Restarts of a clock: the time goes back and runs on from there, as where a file holds several runs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Restarts {
    /// The last two stamps.
    last: Option<(f64, f64)>,
    /// A step back, and the rows that have followed it in order.
    pending: Option<(StepBack, usize)>,
    first: Option<StepBack>,
    count: usize,
}

#[derive(Debug, Clone, Copy)]
struct StepBack {
    /// The first row of the new run.
    row: usize,
    from: f64,
    to: f64,
}

impl Restarts {
    /// The restarts among these rows; rows without a stamp are skipped.
    pub(crate) fn of(time_s: &[f64], rows: &[usize]) -> Self {
        let mut restarts = Self::default();
        rows.iter().for_each(|&row| restarts.push(row, time_s[row]));
        restarts
    }

    /// Adds the next row.
    pub(crate) fn push(&mut self, row: usize, stamp: f64) {
        if !stamp.is_finite() {
            return;
        }
        let Some((before, last)) = self.last.replace((f64::NAN, stamp)) else {
            self.last = Some((f64::NEG_INFINITY, stamp));
            return;
        };
        self.last = Some((last, stamp));
        if let Some((step, follow)) = &mut self.pending {
            *follow += 1;
            if stamp < last || stamp >= step.from {
                self.pending = None;
            } else if *follow == RESTARTED {
                self.first.get_or_insert(*step);
                self.count += 1;
                self.pending = None;
            }
        }
        // After a single late stamp the time is as before.
        if stamp < last && stamp <= before {
            let (from, to) = (last, stamp);
            self.pending = Some((StepBack { row, from, to }, 0));
        }
    }

    /// The warning: how often, where first, and what to do.
    pub(crate) fn warning(&self, column: &str) -> Option<String> {
        let StepBack { row, from, to } = self.first?;
        let times = match self.count {
            1 => "once".to_owned(),
            count => format!("{count} times"),
        };
        Some(format!(
            "{column} goes back {times} and runs on from there, first at row {row} (from 0), from {from} to {to}: several \
             runs in one file? Their rows cannot be told apart by time, and only an increasing part of them is used. Save \
             each run as a file of its own and give all files, or keep one run by a map, such as [filter] keep = 'row < {row}'"
        ))
    }
}

/// The longest strictly increasing subsequence, by patience sorting, O(n log n).
fn longest_increasing(time_s: &[f64], rows: &[usize]) -> Vec<usize> {
    let mut tails: Vec<usize> = Vec::new(); // positions in `rows`, the lowest end of each length
    let mut before: Vec<Option<usize>> = vec![None; rows.len()];
    for (position, &row) in rows.iter().enumerate() {
        let length = tails.partition_point(|&tail| time_s[rows[tail]] < time_s[row]);
        before[position] = length.checked_sub(1).map(|shorter| tails[shorter]);
        match tails.get_mut(length) {
            // The first of equal stamps is kept.
            Some(tail) if time_s[rows[*tail]] > time_s[row] => *tail = position,
            Some(_) => {}
            None => tails.push(position),
        }
    }
    let mut chain = Vec::with_capacity(tails.len());
    let mut at = tails.last().copied();
    while let Some(position) = at {
        chain.push(rows[position]);
        at = before[position];
    }
    chain.reverse();
    chain
}

/// Number of dropped rows that repeat the stamp of a kept one.
fn count_duplicates(time_s: &[f64], stamped: &[usize], kept: &[usize]) -> usize {
    let mut next = 0;
    stamped
        .iter()
        .filter(|&&row| {
            if kept.get(next) == Some(&row) {
                next += 1;
                return false;
            }
            kept.binary_search_by(|&k| time_s[k].total_cmp(&time_s[row]))
                .is_ok()
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn run(time_s: &[f64]) -> (Vec<usize>, usize, usize, usize) {
        let rows: Vec<usize> = (0..time_s.len()).collect();
        let kept = increasing(time_s, &rows);
        (kept.rows, kept.absent, kept.duplicate, kept.backward)
    }

    #[test]
    fn analytic_small_cases() {
        let nan = f64::NAN;
        assert_eq!(run(&[0.0, 1.0, 2.0]), (vec![0, 1, 2], 0, 0, 0));
        assert_eq!(run(&[0.0, 0.0, nan, 1.0]), (vec![0, 3], 1, 1, 0));
        // A stamp that steps back is dropped, not the one before it.
        assert_eq!(run(&[0.0, 1.0, 2.0, 1.5, 3.0]), (vec![0, 1, 2, 4], 0, 0, 1));
        // A stray late stamp does not cost the rows after it.
        assert_eq!(run(&[0.0, 1.0, 9e9, 2.0, 3.0]), (vec![0, 1, 3, 4], 0, 0, 1));
        assert_eq!(run(&[]), (vec![], 0, 0, 0));
        assert_eq!(run(&[f64::INFINITY, 1.0]), (vec![1], 1, 0, 0));
    }

    #[test]
    fn analytic_restarts_are_steps_back_from_which_the_time_runs_on() {
        let restarts = |stamps: &[f64]| {
            let rows: Vec<usize> = (0..stamps.len()).collect();
            let found = Restarts::of(stamps, &rows);
            (found.count, found.first.map(|step| step.row))
        };
        let run = |from: f64, rows: u32| (0..rows).map(move |i| from + f64::from(i));
        let stamps = |runs: &[(f64, u32)]| -> Vec<f64> {
            runs.iter()
                .flat_map(|&(from, rows)| run(from, rows))
                .collect()
        };
        assert_eq!(
            restarts(&stamps(&[(0.0, 30), (0.0, 30), (5.0, 30)])),
            (2, Some(30))
        );
        assert_eq!(restarts(&stamps(&[(0.0, 30), (30.0, 30)])), (0, None));
        // A late stamp, one that is early, a block that was written twice, and stamps in pairs.
        assert_eq!(
            restarts(&stamps(&[(0.0, 30), (9e9, 1), (30.0, 30)])),
            (0, None)
        );
        assert_eq!(
            restarts(&stamps(&[(0.0, 30), (3.0, 1), (30.0, 30)])),
            (0, None)
        );
        assert_eq!(restarts(&stamps(&[(0.0, 30), (25.0, 30)])), (0, None));
        assert_eq!(restarts(&stamps(&[(100.0, 2); 40])), (0, None));
        // The time decreases.
        let falling: Vec<f64> = run(0.0, 40).map(|t| -t).collect();
        assert_eq!(restarts(&falling), (0, None));
    }

    proptest! {
        #[test]
        fn prop_kept_rows_increase_and_counts_add_up(
            stamps in prop::collection::vec(0_u8..20, 0..60)
        ) {
            let time_s: Vec<f64> = stamps.iter().map(|&s| if s == 0 { f64::NAN } else { f64::from(s) }).collect();
            let rows: Vec<usize> = (0..time_s.len()).collect();
            let kept = increasing(&time_s, &rows);
            prop_assert!(kept.rows.windows(2).all(|p| p[0] < p[1] && time_s[p[0]] < time_s[p[1]]));
            prop_assert_eq!(kept.rows.len() + kept.absent + kept.duplicate + kept.backward, rows.len());
            // No shorter than the longest, found by dynamic programming.
            let mut best = vec![0_usize; rows.len()];
            for i in 0..rows.len() {
                if time_s[i].is_nan() { continue; }
                best[i] = 1 + (0..i).filter(|&j| time_s[j] < time_s[i]).map(|j| best[j]).max().unwrap_or(0);
            }
            prop_assert_eq!(kept.rows.len(), best.into_iter().max().unwrap_or(0));
        }
    }
}
