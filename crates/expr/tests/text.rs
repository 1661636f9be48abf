//! Text goes round: what is printed reads back as the same expression.

mod common;

use common::{NAMES, any_text, polynomial_text, same, value};
use proptest::prelude::*;
use sindy_expr::Expr;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn prop_display_reads_back_equal(text in any_text()) {
        let e = Expr::parse(&text).expect("valid by construction");
        let printed = e.to_string();
        let back = Expr::parse(&printed).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(&back, &e);
        prop_assert_eq!(back.to_string(), printed);
        let at = [0.3, -1.2, 4.5, 0.0, f64::NAN];
        prop_assert!(same(value(&e, &NAMES, &at), value(&back, &NAMES, &at)));
    }

    #[test]
    fn prop_simplified_and_derived_read_back_equal(text in any_text()) {
        let e = Expr::parse(&text).expect("valid by construction");
        for derived in [e.simplify(), e.derivative("x")] {
            let printed = derived.to_string();
            prop_assert_eq!(Expr::parse(&printed).ok(), Some(derived), "{}", printed);
        }
    }

    #[test]
    fn prop_simplifying_a_polynomial_twice_changes_nothing(text in polynomial_text()) {
        let once = Expr::parse(&text).expect("valid by construction").simplify();
        prop_assert_eq!(once.simplify(), once);
    }

    #[test]
    fn prop_any_string_parses_or_fails_cleanly(text in "\\PC{0,60}") {
        check(&text)?;
    }

    #[test]
    fn prop_any_tokens_parse_or_fail_cleanly(
        tokens in prop::collection::vec(
            prop::sample::select(&[
                "x", "1", ".5", "1e", "e3", "(", ")", ",", "+", "-", "*", "/", "^", "<", "<=", "==", "!", "=",
                "and", "or", "not", "if", "if(", "sin(", "sin", "min(", "pi", "nan", "\"", "\"a b\"", "µ", ".", " ", "\n",
            ][..]),
            0..25,
        )
    ) {
        check(&tokens.concat())?;
        check(&tokens.join(" "))?;
    }
}

fn check(text: &str) -> Result<(), TestCaseError> {
    match Expr::parse(text) {
        Ok(e) => prop_assert_eq!(Expr::parse(&e.to_string()).ok(), Some(e)),
        Err(error) => {
            prop_assert!(text.is_char_boundary(error.position));
            prop_assert_eq!(text[..error.position].chars().count() + 1, error.column);
            prop_assert!(!error.to_string().is_empty());
        }
    }
    Ok(())
}
