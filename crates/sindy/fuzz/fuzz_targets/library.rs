//! Any text is read as a library or refused cleanly; the names of what is read read back as the same terms,
//! which compile, evaluate and print.
//!
//! Run with `cargo +nightly fuzz run library` in `crates/sindy`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sindy::Library;
use sindy::library::MAX_TERMS;

fuzz_target!(|text: &str| {
    let columns = ["x", "y", "a b"].map(String::from);
    let Ok(library) = Library::specification(text, &columns) else {
        return;
    };
    assert!((1..=MAX_TERMS).contains(&library.len()));
    let back = Library::parse(library.names()).expect("names read back, each term once");
    assert_eq!(back, library);
    assert_eq!(library.to_latex().len(), library.len());

    let program = library.compile(&columns).expect("names are columns");
    let mut out = vec![0.0; 2 * library.len()];
    let block: [&[f64]; 3] = [&[0.5, -2.0], &[0.0, f64::NAN], &[f64::MAX, 1.0]];
    program.eval_block(&block, &mut out, &mut Default::default());
});
