//! Units of coefficients: the unit of the equation over that of the term.

use std::fmt::Write as _;

/// Base units, in the order that they are printed in; the newton counts in halves, for √N.
const BASES: [&str; 4] = ["N", "m", "s", "V"];

/// Twice the exponent of each base unit.
type Halves = [i32; BASES.len()];

/// What the variables of our equations are measured in. Throttle and the ψ are pure numbers, and `y` is a ratio of
/// forces.
fn of_variable(name: &str) -> Option<Halves> {
    Some(match name {
        "1" | "s" | "y" | "psi1" | "psi2" | "psi3" => [0; 4],
        "x" => [1, 0, 0, 0],
        "f" | "T" => [2, 0, 0, 0],
        "z" => [0, 2, 0, 0],
        "v_p" | "v_q" => [0, 2, -2, 0],
        "u" => [0, 0, 0, 2],
        // The argument of a transcendental function is taken as a pure number, and so is its value.
        n if n.starts_with("exp(") || n.starts_with("sin(") => [0; 4],
        _ => return None,
    })
}

/// A product of variables and their whole powers.
fn of_term(term: &str) -> Option<Halves> {
    term.split('*').try_fold([0; 4], |sum: Halves, factor| {
        let (name, power) = match factor.trim().rsplit_once('^') {
            Some((name, power)) => (name, power.parse().ok()?),
            None => (factor.trim(), 1),
        };
        let unit = of_variable(name)?;
        Some(std::array::from_fn(|k| sum[k] + power * unit[k]))
    })
}

/// The unit of the coefficient of `term` in an equation whose left-hand side has twice the exponents `equation`.
fn coefficient(equation: Halves, term: &str) -> Option<String> {
    let term = of_term(term)?;
    let halves: Halves = std::array::from_fn(|k| equation[k] - term[k]);
    let list = |sign: i32| {
        let mut out = String::new();
        for (base, &h) in BASES.iter().zip(&halves).filter(|(_, h)| *h * sign > 0) {
            let gap = if out.is_empty() { "" } else { " " };
            let _ = match h.abs() {
                1 => write!(out, "{gap}√{base}"),
                2 => write!(out, "{gap}{base}"),
                h if h % 2 == 0 => write!(out, "{gap}{base}^{}", h / 2),
                h => write!(out, "{gap}{base}^({h}/2)"),
            };
        }
        out
    };
    let (above, below) = (list(1), list(-1));
    let above = if above.is_empty() {
        "1".to_string()
    } else {
        above
    };
    Some(match below.as_str() {
        "" => above,
        b if b.contains(' ') => format!("{above}/({b})"),
        b => format!("{above}/{b}"),
    })
}

/// The unit of a coefficient in an equation for `x'`, `f'`, `y'`, `x` or `T`. A term that is no product of powers is
/// named in place of its unit.
pub(super) fn of_coefficient(equation: &str, term: &str) -> String {
    let (name, halves): (&str, Halves) = match equation {
        "x'" => ("√N/s", [1, 0, -2, 0]),
        "f'" => ("N/s", [2, 0, -2, 0]),
        "y'" => ("1/s", [0, 0, -2, 0]),
        "x" => ("√N", [1, 0, 0, 0]),
        _ => ("N", [2, 0, 0, 0]),
    };
    // In the motors' own polynomial `u` is a lagged throttle.
    let term = if equation == "T" && term.starts_with('u') {
        "1"
    } else {
        term
    };
    coefficient(halves, term).unwrap_or_else(|| format!("{name} over the unit of {term}"))
}

#[cfg(test)]
mod tests {
    use super::of_coefficient;

    #[test]
    fn analytic_units_of_the_equations() {
        let cases = [
            ("x'", "1", "√N/s"),
            ("x'", "x", "1/s"),
            ("x'", "s^2", "√N/s"),
            ("x'", "x^3", "1/(N s)"),
            ("x'", "exp(-x)*s", "√N/s"),
            ("f'", "f", "1/s"),
            ("f'", "z", "N/(m s)"),
            ("f'", "v_p", "N/m"),
            ("f'", "v_p*v_q", "N s/m^2"),
            ("f'", "z^2", "N/(m^2 s)"),
            ("y'", "psi2", "1/s"),
            ("y'", "v_p*psi2", "1/m"),
            ("y'", "v_p^2", "s/m^2"),
            ("x", "s*u", "√N/V"),
            ("T", "u^2", "N"),
            ("x'", "cos(x)", "√N/s over the unit of cos(x)"),
        ];
        for (equation, term, unit) in cases {
            assert_eq!(of_coefficient(equation, term), unit, "{equation} {term}");
        }
    }
}
