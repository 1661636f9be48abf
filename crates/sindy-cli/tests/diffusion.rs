//! Disturbances whose variance depends on the state: `sindy fit --diffusion`.

use crate::common::{fails, json, number, says, words, write};

/// Rows of dx = (2 x - 2 x³) dt + √(0.2 + 0.4 x²) dW, by Euler and Maruyama in tenths of a row. Normal numbers are sums of twelve
/// uniform ones of a linear congruential generator (Knuth's MMIX).
fn double_well(rows: usize) -> String {
    let mut seed = 1_u64;
    let mut normal = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (seed >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    };
    let mut out = "t,x\n".to_owned();
    let mut x: f64 = 1.0;
    let h: f64 = 0.002;
    for k in 0..rows {
        out += &format!("{},{x}\n", 0.02 * k as f64);
        for _ in 0..10 {
            x += (2.0 * x - 2.0 * x.powi(3)) * h + ((0.2 + 0.4 * x * x) * h).sqrt() * normal();
        }
    }
    out
}

#[test]
fn analytic_the_variance_of_disturbances_is_found_as_text_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "well.csv", &double_well(6000));
    let fit = words(
        "fit {} --states x --noise process --diffusion poly(2)",
        &[&data],
    );
    let said = says(&fit);
    let line = said.lines().find(|l| l.starts_with("var(dx)/dt = "));
    assert!(line.is_some_and(|l| l.ends_with("*x^2")), "{said}");
    let found = json(0, &fit);
    let own = found["diffusion"]["x"].as_array().unwrap();
    let terms: Vec<&str> = own.iter().map(|t| t["term"].as_str().unwrap()).collect();
    assert_eq!(terms, ["1", "x^2"], "{found}");
    for (term, truth) in own.iter().zip([0.2, 0.4]) {
        let z = (number(&term["coefficient"]) - truth) / number(&term["std_error"]);
        assert!(z.abs() < 4.0, "{term}");
    }
    // Without the option a warning names it, and there is no such key.
    let without = json(0, &words("fit {} --states x --noise process", &[&data]));
    assert!(without["diffusion"].is_null(), "{without}");
    assert!(
        without["warnings"].to_string().contains("--diffusion"),
        "{without}"
    );
}

#[test]
fn prop_a_diffusion_that_makes_no_sense_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "well.csv", &double_well(300));
    for (more, named) in [
        ("", "unless `noise` is `process` or `both`"),
        (
            "--noise measurement",
            "unless `noise` is `process` or `both`",
        ),
        ("--noise process --discrete", "--discrete"),
        ("--noise process --stream", "--stream"),
        ("--noise process --second-order", "--second-order"),
    ] {
        let fit = format!("fit {{}} --states x --diffusion poly(2) {more}");
        let error = fails(2, &words(&fit, &[&data]));
        assert!(error.contains(named), "{more}: {error}");
    }
    let foreign = words("fit {} --states x --noise process --diffusion y", &[&data]);
    assert!(fails(2, &foreign).contains("`y`"));
}
