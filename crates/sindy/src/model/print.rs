//! Models as text, LaTeX, C99 and Rust.

use std::fmt::{self, Write as _};

use sindy_expr::{C_SUPPORT, Expr, RUST_SUPPORT, code_identifier};

use super::{Model, Term, Time};
use crate::error::SindyError;

/// Most significant digits that an `f64` can use.
const MOST_DIGITS: usize = 17;

/// One line for each equation, `x' = …` in continuous and `x[k+1] = …` in discrete time, with every term.
///
/// `{model}` prints coefficients with all their digits, `{model:.4}` with 4 significant digits (at least 1,
/// at most 17), `{model:#.4}` with their standard errors too, where known. A small coefficient prints as
/// such (`1.000e-9`); none is left out.
impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (state, terms) in self.states.iter().zip(&self.equations) {
            let mark = match self.time {
                Time::Continuous => "'",
                Time::Discrete { .. } => "[k+1]",
            };
            write!(f, "{}{mark} =", Expr::variable(state))?;
            if terms.is_empty() {
                f.write_str(" 0")?;
            }
            for (i, term) in terms.iter().enumerate() {
                let digits = f.precision();
                let size = Number::new(term.coefficient.abs(), digits).text();
                let shown = match term.std_error {
                    Some(error) if f.alternate() => {
                        format!(
                            "({size} ± {})",
                            Number::new(error, digits.map(|_| 2)).text()
                        )
                    }
                    _ => size,
                };
                f.write_str(sign(i, term))?;
                match factor(&term.expression, Expr::to_string, "*") {
                    None => f.write_str(&shown)?,
                    Some(name) => write!(f, "{shown}*{name}")?,
                }
            }
            f.write_str("\n")?;
        }
        Ok(())
    }
}

fn sign(place: usize, term: &Term) -> &'static str {
    match (place, term.coefficient.is_sign_negative()) {
        (0, false) => " ",
        (0, true) => " -",
        (_, false) => " + ",
        (_, true) => " - ",
    }
}

/// A term as a factor behind its coefficient, in parentheses if it needs them; `None` for the constant 1.
pub(crate) fn factor(
    expression: &Expr,
    print: impl Fn(&Expr) -> String,
    times: &str,
) -> Option<String> {
    if *expression == Expr::constant(1.0) {
        return None;
    }
    // Printed as the left factor of a product, a term has the parentheses that it needs.
    let text = print(&(expression * &Expr::variable("k")));
    let end = text.len() - times.len() - "k".len();
    Some(text[..end].to_owned())
}

/// A number split for print.
pub(crate) struct Number {
    digits: String,
    exponent: Option<i32>,
}

impl Number {
    /// With the given number of significant digits, or as many as the number has.
    pub(crate) fn new(value: f64, digits: Option<usize>) -> Self {
        let (scientific, longest) = match digits {
            Some(n) => {
                let n = n.clamp(1, MOST_DIGITS);
                (format!("{value:.*e}", n - 1), n as i32)
            }
            None => (format!("{value:e}"), MOST_DIGITS as i32),
        };
        let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        if !(-4..longest).contains(&exponent) {
            let digits = mantissa.to_owned();
            return Self {
                digits,
                exponent: Some(exponent),
            };
        }
        let digits = match digits {
            Some(_) => format!("{value:.*}", (longest - 1 - exponent) as usize),
            None => format!("{value}"),
        };
        Self {
            digits,
            exponent: None,
        }
    }

    pub(crate) fn text(&self) -> String {
        match self.exponent {
            None => self.digits.clone(),
            Some(e) => format!("{}e{e}", self.digits),
        }
    }

    fn latex(&self) -> String {
        match self.exponent {
            None => self.digits.clone(),
            Some(e) => format!(r"{} \cdot 10^{{{e}}}", self.digits),
        }
    }
}

impl Model {
    /// The equations in an `aligned` environment (of `amsmath`), coefficients with the given number of
    /// significant digits (1 to 17) or, without one, all of theirs. No term is left out.
    #[must_use]
    pub fn to_latex(&self, digits: Option<usize>) -> String {
        let mut lines = Vec::with_capacity(self.states.len());
        for (state, terms) in self.states.iter().zip(&self.equations) {
            let symbol = Expr::variable(state).to_latex();
            let mut line = match self.time {
                Time::Continuous => format!(r"\dot{{{symbol}}} &="),
                Time::Discrete { .. } => format!("{symbol}[k+1] &="),
            };
            if terms.is_empty() {
                line.push_str(" 0");
            }
            for (i, term) in terms.iter().enumerate() {
                line.push_str(sign(i, term));
                line.push_str(&Number::new(term.coefficient.abs(), digits).latex());
                if let Some(name) = factor(&term.expression, Expr::to_latex, r"\,") {
                    let runs_on = name.starts_with(|c: char| c.is_ascii_digit() || c == '-');
                    line.push_str(if runs_on { r" \cdot " } else { r"\," });
                    line.push_str(&name);
                }
            }
            lines.push(line);
        }
        format!(
            "\\begin{{aligned}}\n{}\n\\end{{aligned}}\n",
            lines.join(" \\\\\n")
        )
    }

    /// A C99 source file with the function `void name(const double *state, const double *input,
    /// double *out)` (no `input` if the model has none), which writes `dx/dt` or `x[k+1]`; `out` may be
    /// `state`. All digits are kept; compiled with `-ffp-contract=off`, it computes what
    /// [`Model::predict`] does up to the C library's functions.
    ///
    /// # Errors
    /// [`SindyError::Setting`] if `name` is not an identifier in C and Rust.
    pub fn to_c(&self, name: &str) -> Result<String, SindyError> {
        check_identifier(name)?;
        let has_inputs = !self.inputs.is_empty();
        let mut out = format!("{C_SUPPORT}\n/* {}", self.signature());
        let input = if has_inputs {
            "const double *input, "
        } else {
            ""
        };
        let _ = write!(
            out,
            " */\nvoid {name}(const double *state, {input}double *out)\n{{\n"
        );
        for (i, sum) in self.sums(|e, name| e.to_c_with(name)).iter().enumerate() {
            let _ = writeln!(out, "    const double f{i} = {sum};");
        }
        out.push_str("    (void)state;\n");
        out.push_str(if has_inputs { "    (void)input;\n" } else { "" });
        for i in 0..self.states.len() {
            let _ = writeln!(out, "    out[{i}] = f{i};");
        }
        out.push_str("}\n");
        Ok(out)
    }

    /// A Rust source file with the function `pub fn name(state: &[f64; N], input: &[f64; M]) -> [f64; N]`
    /// (no `input` if the model has none), which returns `dx/dt` or `x[k+1]`. All digits are kept and
    /// sums are in the order of [`Model::predict`].
    ///
    /// # Errors
    /// [`SindyError::Setting`] if `name` is not an identifier in C and Rust.
    pub fn to_rust(&self, name: &str) -> Result<String, SindyError> {
        check_identifier(name)?;
        let (n, m) = (self.states.len(), self.inputs.len());
        let input = if m > 0 {
            format!(", input: &[f64; {m}]")
        } else {
            String::new()
        };
        let unused = if m > 0 {
            "let _ = (state, input);"
        } else {
            "let _ = state;"
        };
        let mut out = format!(
            "/// {}\npub fn {name}(state: &[f64; {n}]{input}) -> [f64; {n}] {{\n    {unused}\n    [\n",
            self.signature()
        );
        for sum in self.sums(|e, name| e.to_rust_with(name)) {
            let _ = writeln!(out, "        {sum},");
        }
        out.push_str("    ]\n}\n");
        if out.contains("sindy_") {
            for line in RUST_SUPPORT.lines() {
                let mark = if line.starts_with("fn ") {
                    "\n#[allow(dead_code)]\n"
                } else {
                    ""
                };
                let _ = writeln!(out, "{mark}{line}");
            }
        }
        Ok(out)
    }

    /// A description of the function for a comment: names appear as identifiers, which cannot end the comment.
    fn signature(&self) -> String {
        let list = |names: &[String]| {
            let names: Vec<String> = names.iter().map(|n| code_identifier(n)).collect();
            names.join(", ")
        };
        let kind = match self.time {
            Time::Continuous => "Time derivatives of the states".to_owned(),
            Time::Discrete { period } => format!("The states one period ({period:?}) later"),
        };
        let inputs = if self.inputs.is_empty() {
            String::new()
        } else {
            format!("; input: {}", list(&self.inputs))
        };
        format!("{kind}. State: {}{inputs}.", list(&self.states))
    }

    /// Each right-hand side as code, one term a line.
    fn sums(&self, print: impl Fn(&Expr, &dyn Fn(&str) -> String) -> String) -> Vec<String> {
        let place = |name: &str| {
            let of = |names: &[String]| names.iter().position(|n| n == name);
            match (of(&self.states), of(&self.inputs)) {
                (Some(i), _) => format!("state[{i}]"),
                (None, Some(i)) => format!("input[{i}]"),
                (None, None) => code_identifier(name),
            }
        };
        self.equations
            .iter()
            .map(|terms| {
                let terms: Vec<String> = terms
                    .iter()
                    .map(|t| {
                        let product = Expr::constant(t.coefficient) * t.expression.clone();
                        print(&product, &place)
                    })
                    .collect();
                if terms.is_empty() {
                    "0.0".to_owned()
                } else {
                    terms.join("\n            + ")
                }
            })
            .collect()
    }
}

fn check_identifier(name: &str) -> Result<(), SindyError> {
    // What is escaped, reserved or empty comes back changed.
    if code_identifier(name) == name {
        return Ok(());
    }
    let found = format!("`{name}`");
    Err(SindyError::setting(
        "name",
        "an identifier of C and Rust",
        found,
    ))
}
