//! The truth is never the model that is fitted to it.

use std::path::Path;

#[test]
fn prop_no_module_uses_a_flight_model() {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("the crate's sources") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                sources.push(path);
            }
        }
    }
    let mut importers = Vec::new();
    for path in sources {
        let text = std::fs::read_to_string(&path).expect("UTF-8 source");
        // Examples in doc comments may show a pilot; code may not.
        let uses = |line: &&str| {
            line.contains("touchdown_flight::") && !line.trim_start().starts_with("//")
        };
        // Whole landings simulate the landing computer and the models it counts on.
        if path.ancestors().any(|folder| folder.ends_with("src/space")) {
            continue;
        }
        for line in text.lines().filter(uses) {
            let name = path
                .file_name()
                .and_then(|n| n.to_str())
                .unwrap_or_default();
            importers.push((name.to_owned(), line.trim().to_owned()));
        }
    }
    // The landing speaks to a pilot in the flight crate's words, and only that.
    let expected = "use touchdown_flight::types::{Command, Measurement};";
    assert_eq!(importers, [("landing.rs".to_owned(), expected.to_owned())]);
}

#[test]
fn prop_the_plant_does_not_use_whole_landings() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = std::fs::read_dir(&source).expect("the crate's sources");
    let modules = [
        "rigid.rs",
        "rotors.rs",
        "plant.rs",
        "ground.rs",
        "contact.rs",
        "motor.rs",
    ];
    let mut seen = 0;
    for entry in files {
        let path = entry.expect("a readable entry").path();
        let name = path
            .file_name()
            .and_then(|n| n.to_str())
            .unwrap_or_default();
        if modules.contains(&name) {
            let text = std::fs::read_to_string(&path).expect("UTF-8 source");
            assert!(!text.contains("crate::space"), "{name}");
            seen += 1;
        }
    }
    assert_eq!(seen, modules.len());
}
