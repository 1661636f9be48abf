//! The truth is never the model that is fitted to it, and no part of it knows a part above it.

use std::fs;
use std::path::{Path, PathBuf};

/// Parts of the crate, each with those above it behind it.
const LAYERS: [&str; 9] = [
    "error", "check", "number", "random", "deck", "air", "body", "sensors", "rig",
];
/// Parts that know the flight crate: readings that the landing computer takes, and whole landings.
const FLYING: [&str; 2] = ["sensors", "landing"];

/// Sources of a folder of the crate, or of all of it.
fn sources(below: &str) -> Vec<(PathBuf, String)> {
    let mut folders = vec![
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("src")
            .join(below),
    ];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the crate's sources") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&path).expect("UTF-8 source");
                sources.push((path, text));
            }
        }
    }
    sources
}

/// Lines of code: neither comments nor the tests at a file's end.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let lines = text.lines().map(str::trim_start);
    lines
        .take_while(|line| *line != "#[cfg(test)]")
        .filter(|line| !line.starts_with("//"))
}

#[test]
fn prop_no_module_of_the_plant_uses_a_flight_model() {
    for (path, text) in sources("") {
        if path
            .components()
            .any(|part| FLYING.iter().any(|name| part.as_os_str() == *name))
        {
            continue;
        }
        let found = code(&text)
            .find(|line| line.contains("touchdown_flight") || line.contains("touchdown_lander"));
        assert_eq!(found, None, "{}", path.display());
    }
}

#[test]
fn prop_no_gain_and_no_fitted_coefficient_stands_here() {
    // Words for gains, laws and models with coefficients, in flight and lander.
    const TUNED: [&str; 9] = [
        "Gains",
        "k_p",
        "k_i",
        "Composite",
        "Imbc",
        "Ssc",
        "Lag",
        "StaticMap",
        "Polynomial",
    ];
    for (path, text) in sources("") {
        let mut words =
            code(&text).flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'));
        let found = words.find(|word| TUNED.contains(word));
        assert_eq!(found, None, "{}", path.display());
    }
}

#[test]
fn prop_modules_use_only_those_below_them() {
    let mut folders = 0;
    for (i, layer) in LAYERS.iter().enumerate() {
        if !Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("src")
            .join(layer)
            .is_dir()
        {
            continue;
        }
        folders += 1;
        for (path, text) in sources(layer) {
            for above in LAYERS[i + 1..].iter().chain(&["landing"]) {
                let import = format!("crate::{above}::");
                let found = code(&text).find(|line| line.contains(&import));
                assert_eq!(found, None, "{}", path.display());
            }
        }
    }
    assert_eq!(folders, 6);
}
