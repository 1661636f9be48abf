//! The known name nearest to an unknown one.

/// The name at the smallest edit distance, if that is at most a third of the word (at least 1). Differences of case
/// count nothing. A name that begins with the word, such as one with a unit after it, counts as one edit. The first
/// wins a tie.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const LONGEST: usize = 64;
    /// Shorter words begin too many names.
    const SHORTEST_BEGINNING: usize = 3;
    let fold = |s: &str| s.chars().flat_map(char::to_lowercase).collect::<Vec<_>>();
    let word = fold(word);
    if word.is_empty() || word.len() > LONGEST {
        return None;
    }
    let edits = |name: &[char]| {
        let begins = word.len() >= SHORTEST_BEGINNING && name.starts_with(&word);
        if begins && name.len() > word.len() {
            1
        } else {
            distance(&word, name)
        }
    };
    known
        .into_iter()
        .filter(|name| name.len() <= 4 * LONGEST)
        .map(|name| (edits(&fold(name)), name))
        .min_by_key(|&(distance, _)| distance)
        .filter(|&(distance, _)| distance <= (word.len() / 3).max(1))
        .map(|(_, name)| name)
}

/// Insertions, deletions, substitutions and exchanges of neighbours between two
/// words (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let substitution = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = substitution.min(row[j - 1] + 1).min(rows[i - 1][j] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_edit_distances() {
        let d = |a: &str, b: &str| {
            distance(
                &a.chars().collect::<Vec<_>>(),
                &b.chars().collect::<Vec<_>>(),
            )
        };
        assert_eq!(d("kitten", "sitting"), 3);
        assert_eq!(d("sni", "sin"), 1);
        assert_eq!(d("", "abc"), 3);
        assert_eq!(d("abc", "abc"), 0);
    }

    #[test]
    fn prop_far_words_suggest_nothing() {
        assert_eq!(
            nearest("throtle", ["thrust_n", "throttle"]),
            Some("throttle")
        );
        assert_eq!(nearest("Z", ["x", "z"]), Some("z"));
        assert_eq!(nearest("battery", ["x", "z"]), None);
        assert_eq!(nearest("", ["x", "z"]), None);
    }

    #[test]
    fn prop_a_name_without_its_unit_is_near() {
        let known = ["mass_kg", "throttle", "battery_voltage_v"];
        assert_eq!(nearest("battery", known), Some("battery_voltage_v"));
        assert_eq!(nearest("ma", ["mass_kg"]), None);
    }
}
