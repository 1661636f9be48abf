//! Short names of the keys that a grid varies.

/// The names of dotted keys in labels: of each as many of its last parts as tell it from the others. A place in a list, or an axis,
/// stands with what it is in.
pub(super) fn names<'a>(keys: &[&'a str]) -> Vec<&'a str> {
    let mut names: Vec<&str> = keys.iter().map(|key| named(key, 0)).collect();
    loop {
        let shared: Vec<usize> = (0..keys.len())
            .filter(|&i| (0..keys.len()).any(|k| k != i && names[k] == names[i]))
            .collect();
        let mut longer = false;
        for i in shared {
            let name = named(keys[i], names[i].len());
            longer |= name != names[i];
            names[i] = name;
        }
        if !longer {
            return names;
        }
    }
}

/// The shortest end of a key with whole parts that is longer than that many bytes and names something; the key where there is none.
fn named(key: &str, longer_than: usize) -> &str {
    let place = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
    let ends = key.rmatch_indices('.').map(|(dot, _)| &key[dot + 1..]);
    let mut ends = ends.filter(|end| end.len() > longer_than);
    let found = ends.find(|end| {
        let first = end.split('.').next().unwrap_or(end);
        !place(first) && !["x", "y", "z"].contains(&first)
    });
    found.unwrap_or(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_keys_in_a_word() {
        let name = |key| names(&[key])[0];
        assert_eq!(name("control.controller"), "controller");
        assert_eq!(name("wind.steady_mps.0"), "steady_mps.0");
        assert_eq!(name("timeout_s"), "timeout_s");
        assert_eq!(name("control.relative.range.direction.z"), "direction.z");
    }

    #[test]
    fn regress_names_of_swept_keys_tell_them_apart() {
        let swept = [
            "sensors.range.schedule.rate_hz",
            "sensors.tag.schedule.rate_hz",
            "timeout_s",
        ];
        let expected = [
            "range.schedule.rate_hz",
            "tag.schedule.rate_hz",
            "timeout_s",
        ];
        assert_eq!(names(&swept), expected);
        // One of them has no further part.
        assert_eq!(
            names(&["watch_s", "control.watch_s"]),
            ["watch_s", "control.watch_s"]
        );
    }
}
