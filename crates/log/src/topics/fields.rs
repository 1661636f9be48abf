//! Names and sums of the fields of a topic.

use std::collections::HashMap;

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

/// Adds new names and returns the index of each name, or `usize::MAX` if there are too many. `None`
/// if these are the topic's first names.
pub(super) fn unite(known: &mut Vec<String>, names: &[String]) -> Option<Vec<usize>> {
    if names.starts_with(known) {
        known.extend_from_slice(&names[known.len()..]);
    }
    if known.starts_with(names) {
        return None;
    }
    let mut places: HashMap<String, usize> = HashMap::new();
    for (place, name) in known.iter().enumerate() {
        places.entry(name.clone()).or_insert(place);
    }
    let place = |name: &String| {
        *places.entry(name.clone()).or_insert_with(|| {
            if known.len() >= MOST_NAMES {
                return usize::MAX;
            }
            known.push(name.clone());
            known.len() - 1
        })
    };
    Some(names.iter().map(place).collect())
}
