//! Short names of the keys that a grid varies.

use std::collections::{BTreeMap, BTreeSet};

use toml::Value;

use super::row::text;

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

/// Characters of a value in a label, at most.
const LONGEST: usize = 60;

/// Short texts of all values of a key, for labels: each as it is, or where it is long, what differs between the values.
pub(super) fn shown(all: &[Value]) -> Vec<String> {
    let parts: Vec<BTreeMap<String, String>> = all.iter().map(leaves).collect();
    let varies = |path: &&String| {
        parts
            .iter()
            .any(|other| other.get(*path) != parts[0].get(*path))
    };
    let paths: BTreeSet<&String> = parts
        .iter()
        .flat_map(BTreeMap::keys)
        .filter(varies)
        .collect();
    let short = |(value, parts): (&Value, &BTreeMap<String, String>)| {
        let whole = text(value);
        if whole.chars().count() <= LONGEST {
            return whole;
        }
        let own = parts.keys().filter(|path| paths.contains(path));
        let own: Vec<&str> = own.map(String::as_str).collect();
        let named = names(&own).into_iter().zip(&own);
        let words: Vec<String> = named
            .map(|(name, path)| format!("{name} {}", parts[*path]).trim().to_owned())
            .collect();
        cut(&if words.is_empty() {
            whole
        } else {
            words.join(" ")
        })
    };
    let short: Vec<String> = all.iter().zip(&parts).map(short).collect();
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    for text in &short {
        *uses.entry(text).or_default() += 1;
    }
    let numbered = short
        .iter()
        .enumerate()
        .map(|(i, text)| match uses[text.as_str()] {
            1 => text.clone(),
            _ => format!("{text} ({} of {})", i + 1, short.len()),
        });
    numbered.collect()
}

/// The end of a long text: paths of files begin alike.
fn cut(text: &str) -> String {
    let count = text.chars().count();
    if count <= LONGEST {
        return text.to_owned();
    }
    let end: String = text.chars().skip(count + 1 - LONGEST).collect();
    format!("…{end}")
}

/// The numbers and texts in a value, by their dotted paths.
fn leaves(value: &Value) -> BTreeMap<String, String> {
    fn add(value: &Value, path: String, out: &mut BTreeMap<String, String>) {
        let below = |key: &str| match path.is_empty() {
            true => key.to_owned(),
            false => format!("{path}.{key}"),
        };
        match value {
            Value::Table(table) => {
                let parts = table.iter();
                parts.for_each(|(key, value)| add(value, below(key), out));
            }
            Value::Array(list) => {
                let parts = list.iter().enumerate();
                parts.for_each(|(i, value)| add(value, below(&i.to_string()), out));
            }
            leaf => {
                out.insert(path, text(leaf));
            }
        }
    }
    let mut out = BTreeMap::new();
    add(value, String::new(), &mut out);
    out
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

    #[test]
    fn analytic_long_values_are_shown_by_what_differs_in_them() {
        let of = |texts: &[&str]| -> Vec<String> {
            let all: Vec<Value> = texts
                .iter()
                .map(|text| {
                    toml::from_str::<toml::Table>(&format!("v = {text}")).unwrap()["v"].clone()
                })
                .collect();
            shown(&all)
        };
        assert_eq!(of(&["1.5", "\"up\""]), ["1.5", "up"]);
        let gust = |speed: &str| {
            format!(
                "{{ from_s = 1.5, rise_s = 0.3, hold_s = 1.0, fall_s = 0.3, velocity_mps = [0.0, 0.0, {speed}] }}"
            )
        };
        let gusts = of(&[&gust("-6.0"), &gust("5.0")]);
        assert_eq!(gusts, ["velocity_mps.2 -6.0", "velocity_mps.2 5.0"]);
        let tone = |amplitude: &str, hz: &str| {
            format!(
                "[{{ axis = \"heave\", amplitude = {amplitude}, frequency_hz = {hz}, phase_rad = 0.0 }}]"
            )
        };
        let tones = of(&[
            &tone("0.001", "6.0"),
            &tone("0.001", "9.0"),
            &tone("0.002", "9.0"),
        ]);
        assert_eq!(tones[0], "amplitude 0.001 frequency_hz 6.0");
        assert_eq!(tones[2], "amplitude 0.002 frequency_hz 9.0");
        // Paths differ in their ends, and what is cut alike has a number.
        let file =
            |name: &str| format!("\"{}/{name}.csv\"", "measured/decks/of/a/voyage".repeat(3));
        let files = of(&[&file("calm"), &file("rough")]);
        assert!(
            files[0].starts_with('…') && files[0].ends_with("/calm.csv"),
            "{}",
            files[0]
        );
        assert_eq!(files[0].chars().count(), LONGEST);
        let end = "x".repeat(LONGEST);
        let alike = of(&[&format!("\"a{end}\""), &format!("\"b{end}\"")]);
        assert!(alike[0].ends_with("(1 of 2)") && alike[1].ends_with("(2 of 2)"));
    }
}
