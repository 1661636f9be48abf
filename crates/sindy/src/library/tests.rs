//! Tests of constructors, products, sums and texts.
//!
//! `xval_` numbers: PySINDy 2.1.0, `get_feature_names(["x", "y"])` and `transform([[0.7, -1.3], [0.2, 0.5]])`
//! of the library named in the test, printed with all digits.

use super::*;
use proptest::prelude::*;
use sindy_expr::Scratch;

const XY: [&str; 2] = ["x", "y"];

fn spec(text: &str) -> Result<Library, SindyError> {
    Library::specification(text, &["x", "y", "z"])
}

fn names(text: &str) -> Vec<String> {
    spec(text).unwrap().names().to_vec()
}

/// Rows of terms at the two samples of the golden values.
fn values(library: &Library) -> [Vec<f64>; 2] {
    let program = library.compile(&XY.map(String::from)).unwrap();
    [[0.7, -1.3], [0.2, 0.5]].map(|row| {
        let mut out = vec![0.0; library.len()];
        program.eval_row(&row, &mut out, &mut Scratch::new());
        out
    })
}

fn assert_values(library: &Library, expected: [&[f64]; 2]) {
    for (found, expected) in values(library).iter().zip(expected) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            // Products and sines taken in another order: a few units in the last place of numbers of order one.
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}

#[test]
fn xval_polynomial_library() {
    let library = Library::polynomial(&XY, 3).unwrap();
    let expected = [
        "1", "x", "y", "x^2", "x*y", "y^2", "x^3", "x^2*y", "x*y^2", "y^3",
    ];
    assert_eq!(library.names(), expected);
    let first = [
        1.0,
        0.7,
        -1.3,
        0.48999999999999994,
        -0.9099999999999999,
        1.6900000000000002,
        0.3429999999999999,
        -0.6369999999999999,
        1.1829999999999998,
        -2.1970000000000005,
    ];
    let second = [
        1.0,
        0.2,
        0.5,
        0.04000000000000001,
        0.1,
        0.25,
        0.008000000000000002,
        0.020000000000000004,
        0.05,
        0.125,
    ];
    assert_values(&library, [&first, &second]);

    // include_interaction=False; interaction_only=True, in three variables; include_bias=False.
    let powers = Polynomial::new(3).interaction(Interaction::None);
    let expected = ["1", "x", "y", "x^2", "y^2", "x^3", "y^3"];
    assert_eq!(powers.library(&XY).unwrap().names(), expected);
    let only = Polynomial::new(3).interaction(Interaction::Only);
    let expected = ["1", "x", "y", "z", "x*y", "x*z", "y*z", "x*y*z"];
    assert_eq!(only.library(&["x", "y", "z"]).unwrap().names(), expected);
    let no_bias = Polynomial::new(2).bias(false).library(&XY).unwrap();
    assert_eq!(no_bias.names(), ["x", "y", "x^2", "x*y", "y^2"]);
}

#[test]
fn xval_fourier_library() {
    // PySINDy writes sin(1 x) for sin(x).
    let library = Library::fourier(&XY, 2).unwrap();
    let expected = [
        "sin(x)", "cos(x)", "sin(y)", "cos(y)", "sin(2*x)", "cos(2*x)", "sin(2*y)", "cos(2*y)",
    ];
    assert_eq!(library.names(), expected);
    let first = [
        0.644217687237691,
        0.7648421872844885,
        -0.963558185417193,
        0.26749882862458735,
        0.9854497299884601,
        0.16996714290024104,
        -0.5155013718214642,
        -0.8568887533689473,
    ];
    let second = [
        0.19866933079506122,
        0.9800665778412416,
        0.479425538604203,
        0.8775825618903728,
        0.3894183423086505,
        0.9210609940028851,
        0.8414709848078965,
        0.5403023058681398,
    ];
    assert_values(&library, [&first, &second]);
}

#[test]
fn xval_tensored_and_concatenated_libraries() {
    // PolynomialLibrary(degree=1) * FourierLibrary(n_frequencies=1).
    let poly = Library::polynomial(&XY, 1).unwrap();
    let fourier = Library::fourier(&XY, 1).unwrap();
    let product = Library::product(&poly, &fourier).unwrap();
    let expected = [
        "sin(x)", "cos(x)", "sin(y)", "cos(y)", "x*sin(x)", "x*cos(x)", "x*sin(y)", "x*cos(y)",
        "y*sin(x)", "y*cos(x)", "y*sin(y)", "y*cos(y)",
    ];
    assert_eq!(product.names(), expected);
    let first = [
        0.644217687237691,
        0.7648421872844885,
        -0.963558185417193,
        0.26749882862458735,
        0.4509523810663837,
        0.5353895310991419,
        -0.6744907297920351,
        0.18724918003721114,
        -0.8374829934089983,
        -0.9942948434698351,
        1.2526256410423509,
        -0.34774847721196356,
    ];
    let second = [
        0.19866933079506122,
        0.9800665778412416,
        0.479425538604203,
        0.8775825618903728,
        0.03973386615901225,
        0.19601331556824833,
        0.0958851077208406,
        0.17551651237807456,
        0.09933466539753061,
        0.4900332889206208,
        0.2397127693021015,
        0.4387912809451864,
    ];
    assert_values(&product, [&first, &second]);

    // PolynomialLibrary(degree=2) + FourierLibrary(n_frequencies=1).
    let sum = Library::sum(&[Library::polynomial(&XY, 2).unwrap(), fourier]).unwrap();
    assert_eq!(sum.names()[..6], ["1", "x", "y", "x^2", "x*y", "y^2"]);
    assert_eq!(sum.names()[6..], ["sin(x)", "cos(x)", "sin(y)", "cos(y)"]);
}

#[test]
fn analytic_equal_products_are_merged() {
    // Degree 2 times degree 3 has the monomials of degree 5, each once.
    let product = spec("poly(2)*poly(3)").unwrap();
    let mut found = product.names().to_vec();
    let mut expected = spec("poly(5)").unwrap().names().to_vec();
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
    // The same whichever way round, and powers of whatever factor.
    assert_eq!(
        names("fourier(1, x)*fourier(1, x)"),
        ["sin(x)^2", "cos(x)*sin(x)", "cos(x)^2"]
    );
    assert_eq!(
        names("rational(2, y)*rational(2, y)"),
        ["1/(1 + (y/2)^2)^2"]
    );
    assert_eq!(names("z*poly(1, x, bias=false)*y"), ["x*y*z"]);
}

#[test]
fn analytic_a_quotient_cancels_only_where_no_point_is_lost() {
    assert_eq!(names("(x/y)*poly(1, y, bias=false)"), ["x*y/y"]);
    assert_eq!(names("(x/y^2)*poly(1, y, bias=false)"), ["x/y"]);
    assert_eq!(names("-x*exp(1, y)*2"), ["-2*x*exp(-y)"]);
    assert_eq!(names("-x*exp(1, y)"), ["-x*exp(-y)"]);
    // Numbers are numbers however they are written; one that overflows stays as it is.
    assert_eq!(names("sqrt(4)*x + 2*x"), ["sqrt(4)*x"]);
    assert_eq!(names("exp(1000*1)*poly(0)"), ["exp(1000*1)"]);
}

#[test]
fn analytic_texts_read() {
    assert_eq!(names("poly(1)"), ["1", "x", "y", "z"]);
    assert_eq!(names(" poly( 2 , y ) "), ["1", "y", "y^2"]);
    assert_eq!(
        names("poly(2, z, x, bias=false)"),
        ["z", "x", "z^2", "z*x", "x^2"]
    );
    assert_eq!(
        names("poly(2, x, y, interaction=none)"),
        ["1", "x", "y", "x^2", "y^2"]
    );
    assert_eq!(
        names("fourier(1, base=0.1, y)"),
        ["sin(0.1*y)", "cos(0.1*y)"]
    );
    assert_eq!(names("fourier(3, base=0.1, y)")[4], "sin(0.3*y)");
    assert_eq!(names("exp(1, x)"), ["exp(-x)"]);
    assert_eq!(names("exp(-2, .5, x)"), ["exp(2*x)", "exp(-0.5*x)"]);
    let rational = ["1/(1 + (x/0.1)^2)^2", "1/(1 + x^2)^2"];
    assert_eq!(names("rational(0.1, 1, x, power=2)"), rational);
    assert_eq!(names("sin(x)*y"), ["sin(x)*y"]);
    assert_eq!(names("exp(2*x)"), ["exp(2*x)"]);
    assert_eq!(names("exp(x)"), ["exp(x)"]);
    assert_eq!(names("(x + y)^2"), ["(x + y)^2"]);
    assert_eq!(names("(x - y)"), ["x - y"]);
    assert_eq!(names("-x"), ["-x"]);
    assert_eq!(names("x/y*z"), ["x/y*z"]);
    assert_eq!(names("y*x*x"), ["x^2*y"]);
    assert_eq!(
        names("x + 1e+2*y + x*1"),
        ["x", "1e2*y"].map(|n| n.replace("1e2", "100"))
    );
    assert_eq!(names("poly(1, x) + x + max(x, y)"), ["1", "x", "max(x, y)"]);
    assert_eq!(names("(poly(1, x) + y)*z"), ["z", "x*z", "y*z"]);
    assert_eq!(names("(x > 0)*poly(1, x)"), ["x > 0", "x*(x > 0)"]);
    assert_eq!(names("(x - y)*poly(1, x)"), ["x - y", "x*(x - y)"]);
    let two = Library::specifications(&["poly(1)", "x*y", "x"], &XY).unwrap();
    assert_eq!(two.names(), ["1", "x", "y", "x*y"]);
    let quoted = Library::specification("poly(1) + sin(\"a b\")", &["a b"]).unwrap();
    assert_eq!(quoted.names(), ["1", "\"a b\"", "sin(\"a b\")"]);
}

#[test]
fn analytic_errors_name_the_place() {
    let cases: [(&str, usize, &str, &str); 27] = [
        ("", 1, "a library or a term", "the end of the text"),
        (
            "poly(3",
            7,
            "a `)` for the `(` in column 5",
            "the end of the text",
        ),
        ("poly(3))", 8, "no `)`", "`)`"),
        ("poly()", 6, "the degree", "`)`"),
        ("poly(x)", 6, "the degree", "`x`"),
        ("poly(1.5)", 6, "a whole number, the degree", "`1.5`"),
        ("poly(-1)", 6, "a whole number, the degree", "`-`"),
        ("poly(1, 2)", 9, "the degree", "`2`"),
        ("poly(2, w)", 9, "x, y, z", "`w`"),
        ("poly(2, x, x)", 12, "each variable once", "`x`"),
        ("poly(2, bias=maybe)", 9, "`bias=true`", "`bias`"),
        ("poly(0, bias=false)", 1, "degree: at least 1", "0"),
        ("poly(2, sin(x))", 9, "a number or a variable", "`sin`"),
        ("poly(2) fourier(1)", 9, "`+`, `*` or the end", "`fourier`"),
        ("poly(2)^2", 8, "`+`, `*` or the end", "`^`"),
        ("poly(2) - x", 9, "`+`, `*` or the end", "`-`"),
        (
            "sin(poly(2))",
            5,
            "a library can only be added and multiplied",
            "`poly`",
        ),
        ("x - y", 3, "a difference needs parentheses", "`-`"),
        ("x > y", 3, "needs parentheses", "`>`"),
        ("x + ", 5, "a library or a term", "the end of the text"),
        ("x + sin(w)", 9, "one of: x, y, z", "`w`"),
        ("x + sni(x)", 5, "`sin`", "`sni`"),
        ("exp(0, 1)", 1, "rates: distinct finite numbers", "0"),
        ("rational(x)", 10, "scales", "`x`"),
        ("fourier(0)", 1, "frequencies: at least 1", "0"),
        ("fourier(1, base=x)", 12, "`base=`, a frequency", "`base`"),
        ("x + \"y", 5, "a closing", "the end of the text"),
    ];
    for (text, column, expected, found) in cases {
        let error = spec(text).unwrap_err();
        let SindyError::Specification {
            text: shown,
            column: at,
            expected: wanted,
            found: there,
        } = &error
        else {
            panic!("{text}: {error}")
        };
        assert_eq!((shown.as_str(), *at), (text, column), "{error}");
        assert!(wanted.contains(expected) && there == found, "{error}");
        assert!(error.to_string().contains("poly(degree)"), "{error}");
    }
}

#[test]
fn prop_too_many_terms_are_refused() {
    let too_many = |text: &str| {
        let error = Library::specification(text, &["a", "b", "c", "d"]).unwrap_err();
        assert!(error.to_string().contains("at most"), "{text}: {error}");
    };
    too_many("poly(30)");
    too_many("poly(4000000000)");
    too_many("poly(14)*fourier(1)");
    too_many("fourier(999999999)");
    too_many(&["poly(9)"; 400].join("+"));
    let many: Vec<String> = (0..9).map(|k| format!("v{k}")).collect();
    assert!(Library::polynomial(&many, 20).is_err());
    // As many as are allowed are made: 5000 powers of one variable with the constant.
    assert_eq!(Library::polynomial(&["x"], 4999).unwrap().len(), MAX_TERMS);
    assert!(Library::polynomial(&["x"], 5000).is_err());
}

#[test]
fn prop_bad_settings_are_refused() {
    let none: [&str; 0] = [];
    assert!(Library::polynomial(&none, 2).is_err());
    assert!(Library::polynomial(&["x", "x"], 2).is_err());
    assert!(Library::fourier(&[""], 2).is_err());
    assert!(Library::fourier_of_base(&["x"], 2, f64::NAN).is_err());
    assert!(Library::exponentials(&["x"], &[]).is_err());
    assert!(Library::exponentials(&["x"], &[1.0, 1.0]).is_err());
    assert!(Library::bounded_rationals(&["x"], &[0.0], &[1]).is_err());
    assert!(Library::bounded_rationals(&["x"], &[1.0], &[0]).is_err());
    assert!(Library::sum(&[]).is_err());
    let twice = Library::parse(&["x*y", "sin(x)", "y*x"]).unwrap_err();
    assert_eq!(twice, SindyError::DuplicateTerm { name: "y*x".into() });
}

#[test]
fn analytic_each_further_product_costs_one_operation() {
    let operations = |library: &Library| {
        let columns = ["x", "y", "z"].map(String::from);
        library.compile(&columns).unwrap().operations()
    };
    // 56 monomials of degree 5 or less in 3 variables; the constant and the variables cost nothing.
    let five = spec("poly(5)").unwrap();
    assert_eq!((five.len(), operations(&five)), (56, 52));
    // As a product (made in another order), and joined with itself.
    let product = spec("poly(2)*poly(3)").unwrap();
    assert_eq!((product.len(), operations(&product)), (56, 52));
    assert_eq!(operations(&spec("poly(3) + poly(5) + x*y").unwrap()), 52);
    // 6 sines and cosines, 6 multiplications for the degree 2, 9 monomials times 6.
    let tensor = spec("poly(2) + poly(2)*fourier(1)").unwrap();
    assert_eq!((tensor.len(), operations(&tensor)), (70, 6 + 6 + 9 * 6));
    // Ratio, square, sum, quotient; then one division for each product with it.
    let rational = spec("poly(2) + poly(2)*rational(0.1, x)").unwrap();
    assert_eq!((rational.len(), operations(&rational)), (20, 6 + 3 + 10));
}

#[test]
fn analytic_terms_print_in_latex() {
    let library = spec("poly(2, x, y, bias=false) + rational(2, z)").unwrap();
    let latex = library.to_latex();
    assert_eq!(latex[2..5], ["x^{2}", r"x\,y", "y^{2}"]);
    assert_eq!(latex[5], r"\frac{1}{1 + \left(\frac{z}{2}\right)^{2}}");
}

#[test]
fn analytic_rationals_are_bounded() {
    let library = Library::bounded_rationals(&["x"], &[0.1, 1e-300], &[1, 3]).unwrap();
    let program = library.compile(&["x".into()]).unwrap();
    for x in [0.0, 0.1, -5.0, 1e200, -f64::MAX, f64::MIN_POSITIVE] {
        let mut out = [f64::NAN; 4];
        program.eval_row(&[x], &mut out, &mut Scratch::new());
        assert!(out.iter().all(|v| (0.0..=1.0).contains(v)), "{x}: {out:?}");
    }
}

/// Texts that read, of any shape.
fn texts() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("x".to_string()),
        Just("sin(y)".to_string()),
        Just("(x - y)".to_string()),
        Just("1/z".to_string()),
        Just("2*x^2".to_string()),
        (0..4_u32).prop_map(|d| format!("poly({d})")),
        (1..3_u32).prop_map(|n| format!("fourier({n}, x, z)")),
        (1..4_u32).prop_map(|r| format!("exp({r}, y)")),
        (1..4_u32).prop_map(|p| format!("rational(0.5, x, power={p})")),
    ];
    leaf.prop_recursive(3, 8, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("{a} + {b}")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("({a})*({b})")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn prop_names_read_back_as_the_same_terms(text in texts()) {
        let Ok(library) = spec(&text) else {
            return Ok(()); // too many terms
        };
        prop_assert!(library.len() <= MAX_TERMS);
        let back = Library::parse(library.names()).unwrap();
        prop_assert_eq!(&back, &library);
    }

    #[test]
    fn prop_a_product_has_the_values_of_its_factors(a in texts(), b in texts(), x in 0.5..2.0, y in 0.5..2.0) {
        let (Ok(a), Ok(b)) = (spec(&a), spec(&b)) else { return Ok(()) };
        let Ok(product) = Library::product(&a, &b) else { return Ok(()) };
        let at = |library: &Library| {
            let columns = ["x", "y", "z"].map(String::from);
            let mut out = vec![0.0; library.len()];
            let program = library.compile(&columns).unwrap();
            program.eval_row(&[x, y, 1.5], &mut out, &mut Scratch::new());
            out
        };
        let (left, right) = (at(&a), at(&b));
        let mut found = at(&product);
        found.sort_by(f64::total_cmp);
        for l in &left {
            for r in &right {
                let value = l * r;
                // Up to a dozen factors multiplied in another order.
                let near = |v: &f64| (v - value).abs() <= 1e-12 * value.abs();
                let at = found.partition_point(|v| *v < value - 1e-12 * value.abs());
                prop_assert!(found.get(at).is_some_and(near), "{} {}", l, r);
            }
        }
    }

    #[test]
    fn prop_any_text_is_read_or_refused(text in "[ -~]{0,24}|[()+*a-z0-9,.=\"-]{0,40}") {
        if let Ok(library) = spec(&text) {
            prop_assert!(!library.is_empty());
            prop_assert_eq!(Library::parse(library.names()).unwrap(), library);
        }
    }
}
