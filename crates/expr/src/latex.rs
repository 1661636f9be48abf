//! LaTeX for print.

use crate::display::{Piece, operator_level};
use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary};
use crate::parse::level;

impl Expr {
    /// LaTeX for mathematics mode (it needs `amsmath` for `if`).
    ///
    /// Divisions become fractions; what follows the first `_` of a name becomes its
    /// subscript; Greek letters, written as such or by name, become symbols.
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// let e = Expr::parse("0.5*sigma^2*v_p - sqrt(z)/2")?;
    /// assert_eq!(e.to_latex(), r"0.5\,\sigma^{2}\,v_{p} - \frac{\sqrt{z}}{2}");
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn to_latex(&self) -> String {
        let mut out = String::new();
        let mut stack = vec![Piece::Node(self.root(), level::ANY)];
        while let Some(piece) = stack.pop() {
            match piece {
                Piece::Text(text) => out.push_str(text),
                Piece::Node(id, needed) => {
                    let node = &self.nodes()[id as usize];
                    if node_level(node) < needed {
                        out.push_str(r"\left(");
                        stack.push(Piece::Text(r"\right)"));
                    }
                    match *node {
                        Node::Const(bits) => out.push_str(&number(f64::from_bits(bits))),
                        Node::Var(ref name) => out.push_str(&symbol(name)),
                        Node::Unary(op, a) => stack.extend(unary(op, a).into_iter().rev()),
                        Node::Binary(op, a, b) => {
                            let dot = op == Binary::Mul && self.starts_with_digit(b);
                            stack.extend(binary(op, a, b, dot).into_iter().rev());
                        }
                        Node::If(condition, a, b) => {
                            stack.extend(cases(condition, a, b).into_iter().rev());
                        }
                    }
                }
            }
        }
        out
    }

    /// Whether the right side of a product would run into the left one.
    fn starts_with_digit(&self, mut id: Id) -> bool {
        loop {
            match self.nodes()[id as usize] {
                Node::Const(_) => return true,
                Node::Binary(Binary::Pow, a, _) => id = a,
                _ => return false,
            }
        }
    }
}

use Piece::{Node as Child, Text};

fn node_level(node: &Node) -> u8 {
    match *node {
        Node::Const(bits) => {
            let value = f64::from_bits(bits);
            if value.is_sign_negative() {
                level::NEGATE
            } else if number(value).contains(r"\cdot") {
                level::PRODUCT
            } else {
                level::ATOM
            }
        }
        Node::Var(_) => level::ATOM,
        Node::Unary(Unary::Neg, _) => level::NEGATE,
        Node::Unary(Unary::Not, _) => level::NOT,
        Node::Unary(Unary::Sqrt | Unary::Abs | Unary::Floor, _) => level::ATOM,
        Node::Unary(..) => level::POWER,
        Node::Binary(Binary::Div | Binary::Min | Binary::Max | Binary::Atan2, ..) => level::POWER,
        Node::Binary(op, ..) => operator_level(op),
        Node::If(..) => level::ANY,
    }
}

fn unary(op: Unary, a: Id) -> Vec<Piece> {
    let (before, needed, after) = match op {
        Unary::Neg => ("-", level::POWER, ""),
        Unary::Not => (r"\lnot ", level::ATOM, ""),
        Unary::Sqrt => (r"\sqrt{", level::ANY, "}"),
        Unary::Exp => ("e^{", level::ANY, "}"),
        Unary::Log => (r"\ln\left(", level::ANY, r"\right)"),
        Unary::Sin => (r"\sin\left(", level::ANY, r"\right)"),
        Unary::Cos => (r"\cos\left(", level::ANY, r"\right)"),
        Unary::Tan => (r"\tan\left(", level::ANY, r"\right)"),
        Unary::Asin => (r"\arcsin\left(", level::ANY, r"\right)"),
        Unary::Acos => (r"\arccos\left(", level::ANY, r"\right)"),
        Unary::Atan => (r"\arctan\left(", level::ANY, r"\right)"),
        Unary::Tanh => (r"\tanh\left(", level::ANY, r"\right)"),
        Unary::Abs => (r"\left|", level::ANY, r"\right|"),
        Unary::Sign => (r"\operatorname{sgn}\left(", level::ANY, r"\right)"),
        Unary::Floor => (r"\left\lfloor ", level::ANY, r"\right\rfloor "),
        Unary::IsNan => (r"\operatorname{isnan}\left(", level::ANY, r"\right)"),
    };
    vec![Text(before), Child(a, needed), Text(after)]
}

fn binary(op: Binary, a: Id, b: Id, dot: bool) -> Vec<Piece> {
    use level::{AND, ANY, ATOM, NOT, OR, POWER, PRODUCT, SUM};
    let infix = |sign, left, right| vec![Child(a, left), Text(sign), Child(b, right)];
    let call = |name| {
        vec![
            Text(name),
            Child(a, ANY),
            Text(", "),
            Child(b, ANY),
            Text(r"\right)"),
        ]
    };
    match op {
        Binary::Add => infix(" + ", SUM, PRODUCT),
        Binary::Sub => infix(" - ", SUM, PRODUCT),
        Binary::Mul => infix(if dot { r" \cdot " } else { r"\," }, PRODUCT, POWER),
        Binary::Div => {
            vec![
                Text(r"\frac{"),
                Child(a, ANY),
                Text("}{"),
                Child(b, ANY),
                Text("}"),
            ]
        }
        Binary::Pow => vec![Child(a, ATOM), Text("^{"), Child(b, ANY), Text("}")],
        Binary::Lt => infix(" < ", SUM, SUM),
        Binary::Le => infix(r" \le ", SUM, SUM),
        Binary::Gt => infix(" > ", SUM, SUM),
        Binary::Ge => infix(r" \ge ", SUM, SUM),
        Binary::Eq => infix(" = ", SUM, SUM),
        Binary::Ne => infix(r" \ne ", SUM, SUM),
        Binary::And => infix(r" \land ", AND, NOT),
        Binary::Or => infix(r" \lor ", OR, AND),
        Binary::Min => call(r"\min\left("),
        Binary::Max => call(r"\max\left("),
        Binary::Hypot => call(r"\operatorname{hypot}\left("),
        Binary::Atan2 => call(r"\operatorname{atan2}\left("),
    }
}

fn cases(condition: Id, a: Id, b: Id) -> Vec<Piece> {
    vec![
        Text(r"\begin{cases}"),
        Child(a, level::OR),
        Text(r" & \text{if } "),
        Child(condition, level::OR),
        Text(r" \\ "),
        Child(b, level::OR),
        Text(r" & \text{otherwise}\end{cases}"),
    ]
}

fn number(value: f64) -> String {
    let size = value.abs();
    let sign = if value.is_sign_negative() { "-" } else { "" };
    if value.is_nan() {
        r"\mathrm{NaN}".to_owned()
    } else if size.is_infinite() {
        format!(r"{sign}\infty ")
    } else if size == 0.0 || (1e-4..1e7).contains(&size) {
        format!("{value}")
    } else {
        let text = format!("{value:e}");
        match text.split_once('e') {
            Some((digits, exponent)) => format!(r"{digits} \cdot 10^{{{exponent}}}"),
            None => text,
        }
    }
}

const GREEK: &str = "α alpha β beta γ gamma δ delta ε epsilon ζ zeta η eta θ theta ι iota κ kappa \
    λ lambda μ mu µ mu ν nu ξ xi π pi ρ rho σ sigma τ tau υ upsilon φ phi χ chi ψ psi ω omega \
    Γ Gamma Δ Delta Θ Theta Λ Lambda Ξ Xi Π Pi Σ Sigma Υ Upsilon Φ Phi Ψ Psi Ω Omega";

/// A variable's name as a symbol with a subscript.
fn symbol(name: &str) -> String {
    match name.split_once('_') {
        Some((base, below)) if !base.is_empty() && !below.is_empty() => {
            format!("{}_{{{}}}", word(base), word(below))
        }
        _ => word(name),
    }
}

fn word(name: &str) -> String {
    let mut greek = GREEK.split_whitespace();
    while let (Some(letter), Some(command)) = (greek.next(), greek.next()) {
        if name == letter || name == command {
            return format!(r"\{command}");
        }
    }
    let is_simple = name.chars().all(|c| c.is_ascii_digit())
        || (name.chars().count() == 1 && name.chars().all(|c| c.is_ascii_alphanumeric()));
    if is_simple {
        return name.to_owned();
    }
    if name.chars().all(|c| c.is_ascii_alphanumeric()) {
        return format!(r"\mathrm{{{name}}}");
    }
    let mut out = String::from(r"\text{");
    for c in name.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            '~' => out.push_str(r"\textasciitilde{}"),
            '^' => out.push_str(r"\textasciicircum{}"),
            '\\' => out.push_str(r"\textbackslash{}"),
            _ => out.push(c),
        }
    }
    out.push('}');
    out
}
