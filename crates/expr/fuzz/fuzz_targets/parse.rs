//! Any text parses or fails cleanly; what parses prints, reads back equal,
//! simplifies, differentiates, exports and evaluates without panic.
//!
//! Run with `cargo +nightly fuzz run parse` in `crates/expr`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sindy_expr::{Expr, MAX_TEXT_BYTES, Program, Scratch};

fuzz_target!(|text: &str| {
    let Ok(expr) = Expr::parse(text) else { return };
    let printed = expr.to_string();
    if printed.len() <= MAX_TEXT_BYTES {
        assert_eq!(Expr::parse(&printed).as_ref(), Ok(&expr));
    }
    let names = expr.variables();
    let derivative = names
        .first()
        .map_or_else(|| expr.clone(), |name| expr.derivative(name));
    let all = [expr.clone(), expr.simplify(), derivative];
    let _ = (expr.to_latex(), expr.to_c(), expr.to_rust());
    let program = Program::compile(&all, &names).expect("all names are known");
    let mut scratch = Scratch::new();
    let row = vec![0.75; names.len()];
    let mut out = [0.0; 3];
    program.eval_row(&row, &mut out, &mut scratch);
    let columns: Vec<&[f64]> = row.iter().map(std::slice::from_ref).collect();
    let mut block = [0.0; 3];
    program.eval_block(&columns, &mut block, &mut scratch);
    for (a, b) in out.iter().zip(&block) {
        assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()));
    }
});
