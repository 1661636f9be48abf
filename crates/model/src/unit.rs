//! Units of coefficients: the unit of the equation over that of the term, and what a card may state in its place.

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

/// The coefficient of `term` in an equation whose left-hand side has twice the exponents `equation`.
fn coefficient(equation: Halves, term: &str) -> Option<Halves> {
    let term = of_term(term)?;
    Some(std::array::from_fn(|k| equation[k] - term[k]))
}

/// A unit as text.
fn text(halves: Halves) -> String {
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
    match below.as_str() {
        "" => above,
        b if b.contains(' ') => format!("{above}/({b})"),
        b => format!("{above}/{b}"),
    }
}

/// The unit of the left-hand side of an equation.
fn of_equation(name: &str) -> Option<(&'static str, Halves)> {
    Some(match name {
        "x'" => ("√N/s", [1, 0, -2, 0]),
        "f'" => ("N/s", [2, 0, -2, 0]),
        "y'" => ("1/s", [0, 0, -2, 0]),
        "x" => ("√N", [1, 0, 0, 0]),
        "T" => ("N", [2, 0, 0, 0]),
        _ => return None,
    })
}

/// In the motors' own polynomial `u` is a lagged throttle.
fn in_equation<'a>(equation: &str, term: &'a str) -> &'a str {
    match equation == "T" && term.starts_with('u') {
        true => "1",
        false => term,
    }
}

/// The unit of a coefficient in an equation for `x'`, `f'`, `y'`, `x` or `T`. A term that is no product of powers is
/// named in place of its unit.
#[must_use]
pub fn of_coefficient(equation: &str, term: &str) -> String {
    let (name, halves) = of_equation(equation).unwrap_or(("N", [2, 0, 0, 0]));
    let term = in_equation(equation, term);
    coefficient(halves, term).map_or_else(|| format!("{name} over the unit of {term}"), text)
}

/// The unit that the coefficient of `term` in a card's part `of` should have, where a card states another one in `stated`.
/// A card by hand may state none, or `1`.
pub(crate) fn fault(of: &str, term: &str, stated: &str) -> Option<String> {
    if ["", "1"].contains(&stated.trim()) {
        return None;
    }
    let expected = match of {
        "c0" | "c1" => [1, 0, 0, 0],
        "T_m" | "tau" | "dead_time" => [0, 0, 2, 0],
        "mu" => [0; 4],
        "h" => coefficient([0; 4], term)?,
        "k" => coefficient([0, -2, 2, 0], term)?,
        _ => coefficient(of_equation(of)?.1, in_equation(of, term))?,
    };
    (parse(stated) != Some(expected)).then(|| text(expected))
}

/// A unit of a card: products of base units with whole or half powers, and quotients of such.
fn parse(unit: &str) -> Option<Halves> {
    let mut depth = 0;
    let mut parts = unit.split(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == '/' && depth == 0
    });
    let above = product(parts.next()?)?;
    parts.try_fold(above, |sum, part| {
        let inner = part
            .trim()
            .strip_prefix('(')
            .and_then(|p| p.strip_suffix(')'));
        let below = product(inner.unwrap_or(part))?;
        Some(std::array::from_fn(|k| sum[k] - below[k]))
    })
}

/// A product of base units: `N m`, `√N`, `N^0.5`, `s^(3/2)`.
fn product(text: &str) -> Option<Halves> {
    let factors = text.split([' ', '*', '·']).filter(|f| !f.is_empty());
    factors
        .filter(|f| *f != "1")
        .try_fold([0; 4], |mut sum: Halves, factor| {
            let (root, factor) = match factor.strip_prefix('√') {
                Some(inner) => (0.5, inner),
                None => (1.0, factor),
            };
            let (base, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let power = power.trim_matches(['(', ')']);
            let power: f64 = match power.split_once('/') {
                Some((above, below)) => above.parse::<f64>().ok()? / below.parse::<f64>().ok()?,
                None => power.parse().ok()?,
            };
            let halves = 2.0 * root * power;
            let place = BASES.iter().position(|known| *known == base)?;
            // Units have small powers, and a half of one is whole here.
            (halves.fract() == 0.0 && halves.abs() < 100.0).then(|| sum[place] += halves as i32)?;
            Some(sum)
        })
}

#[cfg(test)]
mod tests {
    use super::{fault, of_coefficient};

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
            // What fits write, cards may state.
            assert_eq!(fault(equation, term, unit), None, "{equation} {term}");
        }
    }

    #[test]
    fn analytic_a_unit_of_another_dimension_is_a_fault() {
        let expected = |of, term, stated| fault(of, term, stated);
        for stated in ["√N", "N^0.5", "N^(1/2)", "N/√N", "1", ""] {
            assert_eq!(expected("c0", "1", stated), None, "{stated}");
        }
        for stated in ["N s/m^2", "N s / m^2", "N*s/m/m", "s N/(m m)"] {
            assert_eq!(expected("f'", "v_p*v_q", stated), None, "{stated}");
        }
        for (of, term, stated, unit) in [
            ("c0", "1", "N", "√N"),
            ("T_m", "1", "ms", "s"),
            ("x", "s", "N", "√N"),
            ("x'", "x^3", "N/s", "1/(N s)"),
            ("k", "psi3", "m/s", "s/m"),
            ("h", "psi1", "N", "1"),
            ("T", "u^2", "gf", "N"),
        ] {
            assert_eq!(
                expected(of, term, stated).as_deref(),
                Some(unit),
                "{of} {term}"
            );
        }
        // Terms and parts of no known unit are not judged.
        assert_eq!(
            expected("x'", "cos(x)", "√N/s over the unit of cos(x)"),
            None
        );
        assert_eq!(expected("n", "s", "rpm"), None);
    }
}
