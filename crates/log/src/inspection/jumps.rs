//! Jumps of time in a table: long steps from one row to the next, forward or back.

/// Jumps longer than this, in s, are reported together: a minute, and an hour for slow tables.
const LIMITS_S: [f64; 2] = [60.0, 3600.0];
const NAMES: [&str; 2] = ["a minute", "an hour"];
/// Least length of a jump, in median steps. Without it every step of a slow table would be a
/// jump.
const MEDIAN_STEPS: f64 = 100.0;

/// Counts jumps, row by row.
#[derive(Debug, Clone, Default)]
pub(crate) struct Jumps {
    last_s: Option<f64>,
    row: usize,
    first_s: f64,
    levels: [Level; LIMITS_S.len()],
}

#[derive(Debug, Clone, Default)]
struct Level {
    count: usize,
    /// The first jump: the row before it, its time since the table's first stamp, its length.
    first: Option<(usize, f64, f64)>,
    farthest_s: f64,
}

impl Jumps {
    /// Adds the next row of the file with its stamp, in s. Rows without a stamp are skipped.
    pub(crate) fn push(&mut self, row: usize, stamp_s: f64) {
        if !stamp_s.is_finite() {
            return;
        }
        let Some(last_s) = self.last_s.replace(stamp_s) else {
            (self.first_s, self.row) = (stamp_s, row);
            return;
        };
        let by_s = stamp_s - last_s;
        for (level, limit_s) in self.levels.iter_mut().zip(LIMITS_S) {
            if by_s.abs() > limit_s {
                level.count += 1;
                let since_s = last_s - self.first_s;
                level.first.get_or_insert((self.row, since_s, by_s));
                level.farthest_s = level.farthest_s.max(by_s.abs());
            }
        }
        self.row = row;
    }

    /// The warning for a table with this median step in s: number of jumps, place of the first,
    /// length.
    pub(crate) fn warning(&self, column: &str, median_s: f64) -> Option<String> {
        let at = LIMITS_S
            .iter()
            .position(|limit_s| MEDIAN_STEPS * median_s <= *limit_s)?;
        let level = &self.levels[at];
        let (row, since_s, by_s) = level.first?;
        let (times, farthest) = match level.count {
            1 => ("once".to_owned(), String::new()),
            count => (
                format!("{count} times"),
                format!(", the longest by {:.0} s", level.farthest_s),
            ),
        };
        Some(format!(
            "{column:?} jumps {times} by more than {}: after row {row}, {since_s:.3} s from the start, by {by_s:.0} s{farthest}",
            NAMES[at]
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(times: impl Iterator<Item = f64>, median_s: f64) -> Option<String> {
        let mut jumps = Jumps::default();
        for (row, t) in times.enumerate() {
            jumps.push(row, t);
        }
        jumps.warning("t", median_s)
    }

    #[test]
    fn analytic_jumps_are_counted_and_placed() {
        let at = |i: i32| 5.0 + 0.1 * f64::from(i);
        assert_eq!(told((0..100).map(at), 0.1), None);
        let hour = |i: i32| at(i) + if i >= 40 { 3600.0 } else { 0.0 };
        assert_eq!(
            told((0..100).map(hour), 0.1).unwrap(),
            "\"t\" jumps once by more than a minute: after row 39, 3.900 s from the start, by 3600 s"
        );
        let back = |i: i32| hour(i) - if i >= 70 { 7200.0 } else { 0.0 };
        let text = told((0..100).map(back), 0.1).unwrap();
        assert!(
            text.contains("2 times") && text.ends_with("the longest by 7200 s"),
            "{text}"
        );
        // A row every ten minutes is no jump; a day's pause is none by the minute.
        assert_eq!(told((0..100).map(|i| 600.0 * f64::from(i)), 600.0), None);
        let day = |i: i32| 2.0 * f64::from(i) + if i >= 9 { 86_400.0 } else { 0.0 };
        assert!(
            told((0..20).map(day), 2.0)
                .unwrap()
                .contains("once by more than an hour")
        );
    }
}
