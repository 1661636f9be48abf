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
