//! Compilation and evaluation.

mod common;

use common::{NAMES, any_text, same};
use proptest::prelude::*;
use sindy_expr::{CompileError, Expr, Program, Scratch};

fn parse_all(texts: &[&str]) -> Vec<Expr> {
    texts
        .iter()
        .map(|text| Expr::parse(text).expect(text))
        .collect()
}

#[test]
fn analytic_polynomial_library_costs_one_multiplication_a_monomial() {
    let library = parse_all(&[
        "1", "x", "y", "x^2", "x*y", "y^2", "x^3", "x^2*y", "x*y^2", "y^3", "y*x", "x^4",
    ]);
    let program = Program::compile(&library, &["x", "y"]).expect("valid");
    // Twelve outputs less 1, x, y, and y*x which is x*y.
    assert_eq!(program.operations(), 8);
    let mut out = [0.0; 24];
    program.eval_block(&[&[2.0, -1.0], &[3.0, 0.5]], &mut out, &mut Scratch::new());
    let first: Vec<f64> = out.iter().step_by(2).copied().collect();
    assert_eq!(
        first,
        [
            1.0, 2.0, 3.0, 4.0, 6.0, 9.0, 8.0, 12.0, 18.0, 27.0, 6.0, 16.0
        ]
    );
    let second: Vec<f64> = out.iter().skip(1).step_by(2).copied().collect();
    assert_eq!(
        second,
        [
            1.0, -1.0, 0.5, 1.0, -0.5, 0.25, -1.0, 0.5, -0.25, 0.125, -0.5, 1.0
        ]
    );
}

#[test]
fn analytic_whole_powers_follow_the_documented_order() {
    let x = 1.000_123_456_789_f64;
    for (n, expected) in [
        (2, x * x),
        (3, x * x * x),
        (5, (x * x) * (x * x) * x),
        (-2, 1.0 / (x * x)),
    ] {
        let found = common::value(&Expr::variable("x").powi(n), &["x"], &[x]);
        assert_eq!(found.to_bits(), f64::to_bits(expected), "x^{n}");
    }
    let cost = |n| {
        let e = Expr::variable("x").powi(n);
        Program::compile(&[e], &["x"]).expect("valid").operations()
    };
    assert_eq!(
        [
            cost(0),
            cost(1),
            cost(2),
            cost(8),
            cost(15),
            cost(64),
            cost(65)
        ],
        [0, 0, 1, 3, 6, 6, 1]
    );
}

#[test]
fn regress_unknown_names_are_explained() {
    let error = Program::compile(&parse_all(&["2*throtle + z"]), &["z", "throttle"])
        .expect_err("a misspelt name");
    assert_eq!(
        error.to_string(),
        "in `2*throtle + z`: unknown name `throtle` (did you mean `throttle`?); expected one of: z, throttle"
    );
    let error = Program::compile(&parse_all(&["x"]), &[]).expect_err("no inputs");
    assert_eq!(
        error.to_string(),
        "in `x`: unknown name `x`; expected one of: (no inputs)"
    );
    assert!(matches!(
        Program::compile(&[], &["a", "b", "a"]),
        Err(CompileError::DuplicateInput {
            first: 0,
            second: 2,
            ..
        })
    ));
}

#[test]
fn analytic_shared_and_repeated_outputs() {
    let program = Program::compile(
        &parse_all(&[
            "sin(x)",
            "sin(x)",
            "sin(x)^2 + sin(x)",
            "x",
            "3",
            "x",
            "if(x > 0, sin(x), 2)",
        ]),
        &["unused", "x"],
    )
    .expect("valid");
    assert_eq!(program.inputs(), ["unused", "x"]);
    assert_eq!(program.outputs(), 7);
    let x = 0.7_f64;
    let s = x.sin();
    let mut out = [0.0; 7];
    program.eval_row(&[9.0, x], &mut out, &mut Scratch::new());
    assert_eq!(out, [s, s, s * s + s, x, 3.0, x, s]);
}

#[test]
fn analytic_programs_without_inputs_or_outputs() {
    let constants = Program::compile(&parse_all(&["1", "2 + 3"]), &[]).expect("valid");
    let mut out = [0.0; 6];
    constants.eval_block(&[], &mut out, &mut Scratch::new());
    assert_eq!(out, [1.0, 1.0, 1.0, 5.0, 5.0, 5.0]);
    let nothing = Program::compile(&[], &["x"]).expect("valid");
    nothing.eval_block(&[&[1.0, 2.0]], &mut [], &mut Scratch::new());
    nothing.eval_block(&[&[]], &mut [], &mut Scratch::new());
}

#[test]
#[should_panic(expected = "rows of column `y`")]
fn prop_unequal_columns_are_refused() {
    let program = Program::compile(&parse_all(&["x + y"]), &["x", "y"]).expect("valid");
    program.eval_block(&[&[1.0, 2.0], &[1.0]], &mut [0.0; 2], &mut Scratch::new());
}

#[test]
fn prop_one_scratch_serves_many_programs() {
    let mut scratch = Scratch::new();
    for text in [
        "x + 1",
        "(x + 1)*(x + 2)*((x + 3)*(x + 4) + (x + 5)*(x + 6))",
        "-x",
    ] {
        let program = Program::compile(&parse_all(&[text]), &["x"]).expect("valid");
        let column: Vec<f64> = (0..600).map(f64::from).collect();
        let mut used = vec![0.0; 600];
        let mut fresh = vec![0.0; 600];
        program.eval_block(&[&column], &mut used, &mut scratch);
        program.eval_block(&[&column], &mut fresh, &mut Scratch::new());
        assert_eq!(used, fresh);
    }
}

/// Numbers of every kind.
fn datum() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        -3.0..3.0_f64,
        prop::sample::select(&[0.0, -0.0, 1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY][..]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn prop_blocks_equal_rows_bit_for_bit(
        texts in prop::collection::vec(any_text(), 1..5),
        seed_row in prop::collection::vec(datum(), 5 * 7),
        // Lengths around and across the size of a chunk.
        rows in prop::sample::select(&[1_usize, 2, 7, 255, 256, 257, 600][..]),
    ) {
        let exprs: Vec<Expr> = texts.iter().map(|t| Expr::parse(t).expect("valid")).collect();
        let program = Program::compile(&exprs, &NAMES).expect("known names");
        let columns: Vec<Vec<f64>> = (0..5)
            .map(|i| (0..rows).map(|r| seed_row[i * 7 + (r + r / 7) % 7]).collect())
            .collect();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let mut scratch = Scratch::new();
        let mut block = vec![f64::NAN; rows * exprs.len()];
        program.eval_block(&columns, &mut block, &mut scratch);
        let mut out = vec![0.0; exprs.len()];
        for r in 0..rows {
            let row: Vec<f64> = columns.iter().map(|c| c[r]).collect();
            program.eval_row(&row, &mut out, &mut scratch);
            for (k, &value) in out.iter().enumerate() {
                prop_assert!(same(value, block[k * rows + r]), "{} at {row:?}", texts[k]);
                // Compiling together changes nothing either.
                if r == 0 {
                    prop_assert!(same(value, common::value(&exprs[k], &NAMES, &row)), "{}", texts[k]);
                }
            }
        }
    }
}
