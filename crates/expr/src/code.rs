//! Export as C and Rust expressions.

use std::collections::HashMap;

use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary, whole_exponent};
use crate::parse::level;

/// C99 helpers that the text from [`Expr::to_c`] may call; paste once, above the
/// first use.
pub const C_SUPPORT: &str = "\
#include <math.h>

static inline int sindy_true(double x) { return x < 0.0 || x > 0.0; }
static inline int sindy_ne(double a, double b) { return a < b || a > b; }
static inline double sindy_sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }
static inline double sindy_min(double a, double b) { return a < b || isnan(a) ? a : b; }
static inline double sindy_max(double a, double b) { return a > b || isnan(a) ? a : b; }
static inline double sindy_powi(double x, int n)
{
    double h;
    if (n < 0) return 1.0 / sindy_powi(x, -n);
    if (n == 0) return 1.0;
    if (n == 1) return x;
    if (n % 2 == 1) return sindy_powi(x, n - 1) * x;
    h = sindy_powi(x, n / 2);
    return h * h;
}
";

/// Rust helpers that the text from [`Expr::to_rust`] may call; paste once, beside
/// the first use.
pub const RUST_SUPPORT: &str = "\
fn sindy_true(x: f64) -> bool { x < 0.0 || x > 0.0 }
fn sindy_ne(a: f64, b: f64) -> bool { a < b || a > b }
fn sindy_sign(x: f64) -> f64 { if x > 0.0 { 1.0 } else if x < 0.0 { -1.0 } else { x } }
fn sindy_min(a: f64, b: f64) -> f64 { if a < b || a.is_nan() { a } else { b } }
fn sindy_max(a: f64, b: f64) -> f64 { if a > b || a.is_nan() { a } else { b } }
fn sindy_powi(x: f64, n: i32) -> f64 {
    match n {
        ..0 => 1.0 / sindy_powi(x, -n),
        0 => 1.0,
        1 => x,
        _ if n % 2 == 1 => sindy_powi(x, n - 1) * x,
        _ => {
            let h = sindy_powi(x, n / 2);
            h * h
        }
    }
}
";

impl Expr {
    /// A C99 expression of type `double` with the same value. It needs
    /// [`C_SUPPORT`]. Variables appear under [`code_identifier`] of their names.
    ///
    /// Arithmetic is that of [`Program`](crate::Program) operation for operation, up
    /// to the C library's functions and to contraction of `a*b + c` by the compiler
    /// (`-ffp-contract=off` prevents it).
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// assert_eq!(Expr::parse("2*x^2/3 + sin(motor.m1)")?.to_c(), "2.0*(x*x)/3.0 + sin(motor__m1)");
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn to_c(&self) -> String {
        self.to_c_with(code_identifier)
    }

    /// As [`Expr::to_c`], with variables named by `name` (a C expression that needs
    /// no parentheses, such as `in[0]`).
    #[must_use]
    pub fn to_c_with(&self, name: impl Fn(&str) -> String) -> String {
        emit(self, Dialect::C, name)
    }

    /// A Rust expression of type `f64` with the same value. It needs
    /// [`RUST_SUPPORT`]. Variables appear under [`code_identifier`] of their names.
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// assert_eq!(Expr::parse("2*x^2/3 + sin(y)")?.to_rust(), "2.0*(x*x)/3.0 + f64::sin(y)");
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn to_rust(&self) -> String {
        self.to_rust_with(code_identifier)
    }

    /// As [`Expr::to_rust`], with variables named by `name`.
    #[must_use]
    pub fn to_rust_with(&self, name: impl Fn(&str) -> String) -> String {
        emit(self, Dialect::Rust, name)
    }
}

/// An identifier for C and Rust that replaces a variable's name.
///
/// ASCII letters, digits and `_` stay, `.` becomes `__`, any other character `_u`,
/// its code point in hexadecimal, `_`. A name that starts with a digit gets `_` in
/// front; a reserved word or a name of the mathematical library gets `_` at the
/// end. Two names meet only if one is spelt like the escape of the other.
///
/// ```
/// use sindy_expr::code_identifier;
/// assert_eq!(code_identifier("motor.m1"), "motor__m1");
/// assert_eq!(code_identifier("σ"), "_u3c3_");
/// assert_eq!(code_identifier("double"), "double_");
/// ```
#[must_use]
pub fn code_identifier(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '0'..='9' if out.is_empty() => out.extend(['_', c]),
            'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => out.push(c),
            '.' => out.push_str("__"),
            _ => out.push_str(&format!("_u{:x}_", u32::from(c))),
        }
    }
    let taken = RESERVED.split_ascii_whitespace().any(|word| word == out);
    if taken || out.is_empty() || out == "_" {
        out.push('_');
    }
    out
}

/// Words of C, C++ and Rust, and names of <math.h> short enough to be a column's.
const RESERVED: &str = "
    abstract alignas alignof as asm async auto await become bool box break case catch char class
    const constexpr continue crate default delete do double dyn else enum explicit export extern
    f32 f64 false final float fn for friend gen goto i16 i32 i64 i8 if impl in inline int isize let
    long loop macro match mod move mut mutable namespace new nullptr operator override priv private
    protected pub public ref register restrict return self Self short signed sizeof static struct
    super switch template this throw trait true try type typedef typename typeof u16 u32 u64 u8
    union unsafe unsized unsigned usize using virtual void volatile wchar_t where while yield
    acos asin atan atan2 cbrt ceil cos cosh div erf exp exp2 expm1 fabs fdim floor fma fmax fmin
    fmod frexp gamma hypot isinf isnan j0 j1 jn ldexp lgamma log log10 log1p log2 logb lrint modf
    nan pow rint round scalb sin sinh sqrt tan tanh tgamma trunc y0 y1 yn HUGE_VAL INFINITY NAN
    sindy_true sindy_ne sindy_sign sindy_min sindy_max sindy_powi";

#[derive(Clone, Copy, PartialEq)]
enum Dialect {
    C,
    Rust,
}

/// Whether a place wants a number or a truth value.
#[derive(Clone, Copy, PartialEq)]
enum Want {
    Number,
    Truth,
}

enum Piece {
    Text(&'static str),
    Owned(String),
    Node(Id, Want, u8),
}

fn emit(expr: &Expr, dialect: Dialect, name: impl Fn(&str) -> String) -> String {
    let mut names: HashMap<&str, String> = HashMap::new();
    let mut out = String::new();
    let mut stack = vec![Piece::Node(expr.root(), Want::Number, level::ANY)];
    while let Some(piece) = stack.pop() {
        match piece {
            Piece::Text(text) => out.push_str(text),
            Piece::Owned(text) => out.push_str(&text),
            Piece::Node(id, want, needed) => {
                let node = &expr.nodes()[id as usize];
                if let Node::Var(variable) = node
                    && want == Want::Number
                {
                    out.push_str(names.entry(variable).or_insert_with(|| name(variable)));
                    continue;
                }
                let (own, mut pieces) = pieces(expr.nodes(), id, want, dialect);
                if own < needed {
                    out.push('(');
                    stack.push(Piece::Text(")"));
                }
                pieces.reverse();
                stack.append(&mut pieces);
            }
        }
    }
    out
}

/// The text of a node and its binding strength.
fn pieces(nodes: &[Node], id: Id, want: Want, dialect: Dialect) -> (u8, Vec<Piece>) {
    use Piece::{Node as Child, Owned, Text};
    use Want::{Number, Truth};
    use level::{ANY, ATOM, NEGATE, OR, PRODUCT};
    let node = &nodes[id as usize];
    let is_c = dialect == Dialect::C;
    match (want, is_truth(node)) {
        (Number, true) => {
            let cast = if is_c { "(double)(" } else { "f64::from(" };
            return (ATOM, vec![Text(cast), Child(id, Truth, ANY), Text(")")]);
        }
        (Truth, false) => {
            let test = vec![Text("sindy_true("), Child(id, Number, ANY), Text(")")];
            return (ATOM, test);
        }
        _ => {}
    }
    match *node {
        Node::Const(bits) => {
            let value = f64::from_bits(bits);
            let own = if value.is_sign_negative() {
                NEGATE
            } else {
                ATOM
            };
            (own, vec![Owned(literal(value, is_c))])
        }
        Node::Var(_) => unreachable!("variables are written where names are known"),
        Node::Unary(Unary::Neg, a) => (NEGATE, vec![Text("-"), Child(a, Number, ATOM)]),
        Node::Unary(Unary::Not, a) => (NEGATE, vec![Text("!"), Child(a, Truth, ATOM)]),
        Node::Unary(op, a) => call(unary_function(op, is_c), &[a]),
        Node::Binary(Binary::Pow, a, n) => {
            let whole = nodes[n as usize].as_const().and_then(whole_exponent);
            let is_variable = matches!(nodes[a as usize], Node::Var(_));
            match whole {
                Some(2) if is_variable => {
                    let factor = || Child(a, Number, ATOM);
                    (PRODUCT, vec![factor(), Text("*"), factor()])
                }
                Some(n) => {
                    let tail = Owned(format!(", {n})"));
                    (ATOM, vec![Text("sindy_powi("), Child(a, Number, ANY), tail])
                }
                None => call(if is_c { "pow" } else { "f64::powf" }.to_owned(), &[a, n]),
            }
        }
        Node::Binary(op, a, b) => {
            let Some((sign, own, want, left, right)) = infix(op) else {
                return call(binary_function(op, is_c), &[a, b]);
            };
            let sides = [Child(a, want, left), Text(sign), Child(b, want, right)];
            (own, sides.into())
        }
        Node::If(condition, a, b) if is_c => (
            ANY,
            vec![
                Child(condition, Truth, OR),
                Text(" ? "),
                Child(a, Number, OR),
                Text(" : "),
                Child(b, Number, OR),
            ],
        ),
        Node::If(condition, a, b) => (
            ANY,
            vec![
                Text("if "),
                Child(condition, Truth, ANY),
                Text(" { "),
                Child(a, Number, ANY),
                Text(" } else { "),
                Child(b, Number, ANY),
                Text(" }"),
            ],
        ),
    }
}

/// A function with its arguments.
fn call(function: String, arguments: &[Id]) -> (u8, Vec<Piece>) {
    let mut pieces = vec![Piece::Owned(function), Piece::Text("(")];
    for (i, &argument) in arguments.iter().enumerate() {
        pieces.extend((i > 0).then_some(Piece::Text(", ")));
        pieces.push(Piece::Node(argument, Want::Number, level::ANY));
    }
    pieces.push(Piece::Text(")"));
    (level::ATOM, pieces)
}

/// An infix operator with its spaces, how tightly it binds, what its sides are, and the levels that they need.
fn infix(op: Binary) -> Option<(&'static str, u8, Want, u8, u8)> {
    use Want::{Number, Truth};
    use level::{AND, COMPARE, NEGATE, OR, PRODUCT, SUM};
    Some(match op {
        Binary::Add => (" + ", SUM, Number, SUM, PRODUCT),
        Binary::Sub => (" - ", SUM, Number, SUM, PRODUCT),
        Binary::Mul => ("*", PRODUCT, Number, PRODUCT, NEGATE),
        Binary::Div => ("/", PRODUCT, Number, PRODUCT, NEGATE),
        Binary::Lt => (" < ", COMPARE, Number, SUM, SUM),
        Binary::Le => (" <= ", COMPARE, Number, SUM, SUM),
        Binary::Gt => (" > ", COMPARE, Number, SUM, SUM),
        Binary::Ge => (" >= ", COMPARE, Number, SUM, SUM),
        Binary::Eq => (" == ", COMPARE, Number, SUM, SUM),
        Binary::And => (" && ", AND, Truth, COMPARE, COMPARE),
        Binary::Or => (" || ", OR, Truth, COMPARE, COMPARE),
        Binary::Ne | Binary::Min | Binary::Max | Binary::Pow | Binary::Hypot | Binary::Atan2 => {
            return None;
        }
    })
}

/// Whether the node is a truth value in C and Rust.
fn is_truth(node: &Node) -> bool {
    match node {
        Node::Unary(op, _) => matches!(op, Unary::Not | Unary::IsNan),
        Node::Binary(op, ..) => matches!(
            op,
            Binary::Lt
                | Binary::Le
                | Binary::Gt
                | Binary::Ge
                | Binary::Eq
                | Binary::Ne
                | Binary::And
                | Binary::Or
        ),
        _ => false,
    }
}

fn unary_function(op: Unary, is_c: bool) -> String {
    match (op, is_c) {
        (Unary::Sign, _) => "sindy_sign".to_owned(),
        (Unary::Abs, true) => "fabs".to_owned(),
        (Unary::Log, false) => "f64::ln".to_owned(),
        (Unary::IsNan, false) => "f64::is_nan".to_owned(),
        (_, true) => op.name().to_owned(),
        (_, false) => format!("f64::{}", op.name()),
    }
}

fn binary_function(op: Binary, is_c: bool) -> String {
    match op {
        Binary::Ne => "sindy_ne".to_owned(),
        Binary::Min | Binary::Max => format!("sindy_{}", op.name()),
        _ if is_c => op.name().to_owned(),
        _ => format!("f64::{}", op.name()),
    }
}

fn literal(value: f64, is_c: bool) -> String {
    let (infinity, nan) = if is_c {
        ("INFINITY", "NAN")
    } else {
        ("f64::INFINITY", "f64::NAN")
    };
    if value.is_nan() {
        nan.to_owned()
    } else if value.is_infinite() {
        let sign = if value < 0.0 { "-" } else { "" };
        format!("{sign}{infinity}")
    } else {
        format!("{value:?}")
    }
}
