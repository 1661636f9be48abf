//! The header that is checked in is the one that cbindgen prints from the sources.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, Language, RenameRule, Style};

const BEGIN: &str = "\
/* Touchdown: the vertical controller and the landing computer, in single precision.
 *
 * Written by cbindgen from crates/ffi/src, not by hand:
 * TOUCHDOWN_WRITE_HEADER=1 cargo test -p touchdown-ffi --test header
 *
 * The caller gives the memory: nothing allocates. z is up, SI units, throttle in [0, 1]. Pointers must point to
 * memory of their type that nothing else uses during a call. Every function may be called from any thread, but two
 * calls at once must not use the same handle.
 *
 * The functions of the simulator exist where TOUCHDOWN_WORLD is defined and the library was built with its feature
 * `world`.
 */";

fn printed() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = Config {
        language: Language::C,
        cpp_compat: true,
        style: Style::Both,
        documentation_style: DocumentationStyle::C99,
        usize_is_size_t: true,
        include_guard: Some("TOUCHDOWN_H".to_owned()),
        header: Some(BEGIN.to_owned()),
        no_includes: true,
        sys_includes: vec!["stddef.h".to_owned(), "stdint.h".to_owned()],
        enumeration: EnumConfig {
            rename_variants: RenameRule::QualifiedScreamingSnakeCase,
            ..EnumConfig::default()
        },
        // The features that are not in every library.
        defines: HashMap::from([("feature = world".to_owned(), "TOUCHDOWN_WORLD".to_owned())]),
        ..Config::default()
    };
    // Constants of which a number says that it is one: no signature names them.
    let constants = [
        "td_method",
        "td_thrust_form",
        "td_ground_effect_form",
        "td_outside",
        "td_velocity_input",
        "td_reading_kind",
        "td_request",
        "td_phase",
        "td_reason",
        "td_outcome",
    ];
    let mut builder = Builder::new().with_config(config);
    for name in constants {
        builder = builder.include_item(name);
    }
    builder = builder.with_src(folder.join("src/lib.rs"));
    let mut text = Vec::new();
    builder.generate().unwrap().write(&mut text);
    String::from_utf8(text).unwrap()
}

#[test]
fn regress_header_is_the_one_that_cbindgen_prints() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/touchdown.h");
    let printed = printed();
    if std::env::var_os("TOUCHDOWN_WRITE_HEADER").is_some() {
        fs::write(&path, &printed).unwrap();
    }
    let checked_in = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        checked_in == printed,
        "include/touchdown.h is not what cbindgen prints: run TOUCHDOWN_WRITE_HEADER=1 cargo test -p touchdown-ffi --test header"
    );
}
