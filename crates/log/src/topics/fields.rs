//! Names and sums of the fields of a topic.

use std::collections::{HashMap, HashSet};

/// Sums of one field, in the order of the file.
#[derive(Clone, Copy)]
pub(super) struct FieldSums {
    pub(super) count: usize,
    pub(super) sum: f64,
    pub(super) min: f64,
    pub(super) max: f64,
}

impl FieldSums {
    pub(super) const EMPTY: Self = Self {
        count: 0,
        sum: 0.0,
        min: f64::INFINITY,
        max: f64::NEG_INFINITY,
    };

    #[inline]
    pub(super) fn push(&mut self, value: f64) {
        if value.is_finite() {
            self.count += 1;
            self.sum += value;
            self.min = self.min.min(value);
            self.max = self.max.max(value);
        }
    }
}

/// Largest number of field names of one topic with several sources. It bounds the memory for
/// recordings whose JSON messages all have new names.
const MOST_NAMES: usize = 1 << 16;

/// The names of a topic that has one source or several.
#[derive(Default)]
pub(super) struct UnitedNames {
    names: Vec<String>,
    places: HashMap<String, usize>,
}

impl UnitedNames {
    /// Adds those names of a source that follow the ones with a place, and appends the place of each:
    /// `usize::MAX` for one name too many.
    pub(super) fn unite(&mut self, names: &[String], places: &mut Vec<usize>) {
        for name in names.iter().skip(places.len()) {
            let place = match self.places.get(name) {
                Some(&place) => place,
                None if self.names.len() < MOST_NAMES => {
                    self.places.insert(name.clone(), self.names.len());
                    self.names.push(name.clone());
                    self.names.len() - 1
                }
                None => usize::MAX,
            };
            places.push(place);
        }
    }

    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    pub(super) fn into_names(self) -> Vec<String> {
        self.names
    }
}

/// Numbers the names that occur before: the second `a` becomes `a#2`.
pub(super) fn make_unique(names: &mut [String]) {
    let mut taken: HashSet<String> = HashSet::with_capacity(names.len());
    let mut repeats: HashMap<String, usize> = HashMap::new();
    for name in names {
        if taken.insert(name.clone()) {
            continue;
        }
        let count = repeats.entry(name.clone()).or_insert(1);
        let free = loop {
            *count += 1;
            let candidate = format!("{name}#{count}");
            if taken.insert(candidate.clone()) {
                break candidate;
            }
        };
        *name = free;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_repeated_names_are_numbered() {
        let mut names = ["a", "b", "a", "a#2", "a"].map(str::to_owned);
        make_unique(&mut names);
        assert_eq!(names, ["a", "b", "a#2", "a#2#2", "a#3"]);
    }
}
