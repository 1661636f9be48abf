//! How landings ended, in words.

use std::collections::BTreeMap;

use super::row::LandingRow;

impl LandingRow {
    /// How the landing ended, in words.
    #[must_use]
    pub fn ending(&self) -> String {
        let outcome = match &self.why {
            Some(phase) if self.outcome == "timed_out" => format!("timed out in phase {phase}"),
            Some(why) => format!("{} ({why})", self.outcome),
            None => self.outcome.clone(),
        };
        outcome.replace('_', " ")
    }
}

/// How often each ending stands there, the most frequent one first.
#[must_use]
pub fn counted(endings: impl Iterator<Item = String>) -> String {
    let mut counts = BTreeMap::<String, usize>::new();
    for ending in endings {
        *counts.entry(ending).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let parts = counts
        .iter()
        .map(|(ending, count)| format!("{count} {ending}"));
    parts.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_most_frequent_ending_comes_first() {
        let endings = ["crashed", "timed out", "timed out", "given up (battery)"];
        assert_eq!(
            counted(endings.map(String::from).into_iter()),
            "2 timed out, 1 crashed, 1 given up (battery)"
        );
    }
}
