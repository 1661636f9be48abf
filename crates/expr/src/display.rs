//! Canonical text, which parses back to an equal expression.

use std::fmt;

use crate::expr::Expr;
use crate::lexer::is_bare_name;
use crate::node::{Binary, Id, Node, Unary};
use crate::parse::level;

/// A piece of output still to be written; an explicit stack of these stands in
/// for recursion, so that depth is no concern.
pub(crate) enum Piece {
    Text(&'static str),
    /// A node, in a place that needs at least this level to go without parentheses.
    Node(Id, u8),
}

impl fmt::Display for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut stack = vec![Piece::Node(self.root(), level::ANY)];
        while let Some(piece) = stack.pop() {
            match piece {
                Piece::Text(text) => f.write_str(text)?,
                Piece::Node(id, needed) => {
                    let node = &self.nodes()[id as usize];
                    if node_level(node) < needed {
                        f.write_str("(")?;
                        stack.push(Piece::Text(")"));
                    }
                    write_node(f, node, &mut stack)?;
                }
            }
        }
        Ok(())
    }
}

/// Writes a leaf at once; of any other node pushes the pieces, last first.
fn write_node(f: &mut fmt::Formatter<'_>, node: &Node, stack: &mut Vec<Piece>) -> fmt::Result {
    use Piece::{Node as Child, Text};
    match *node {
        Node::Const(bits) => f.write_str(&number(f64::from_bits(bits)))?,
        Node::Var(ref name) if is_bare_name(name) => f.write_str(name)?,
        Node::Var(ref name) => write!(f, "\"{}\"", name.replace('"', "\"\""))?,
        Node::Unary(Unary::Neg, a) => stack.extend([Child(a, level::NEGATE), Text("-")]),
        Node::Unary(Unary::Not, a) => stack.extend([Child(a, level::NOT), Text("not ")]),
        Node::Unary(op, a) => {
            stack.extend([Text(")"), Child(a, level::ANY), Text("("), Text(op.name())]);
        }
        Node::Binary(op, a, b) => {
            let Some((sign, left, right)) = infix(op) else {
                stack.extend([
                    Text(")"),
                    Child(b, level::ANY),
                    Text(", "),
                    Child(a, level::ANY),
                    Text("("),
                    Text(op.name()),
                ]);
                return Ok(());
            };
            stack.extend([Child(b, right), Text(sign), Child(a, left)]);
        }
        Node::If(condition, a, b) => stack.extend([
            Text(")"),
            Child(b, level::ANY),
            Text(", "),
            Child(a, level::ANY),
            Text(", "),
            Child(condition, level::ANY),
            Text("if("),
        ]),
    }
    Ok(())
}

/// An infix operator with its spaces, and the levels that its sides need.
fn infix(op: Binary) -> Option<(&'static str, u8, u8)> {
    use level::{AND, ATOM, NEGATE, NOT, OR, PRODUCT, SUM};
    Some(match op {
        Binary::Add => (" + ", SUM, PRODUCT),
        Binary::Sub => (" - ", SUM, PRODUCT),
        Binary::Mul => ("*", PRODUCT, NEGATE),
        Binary::Div => ("/", PRODUCT, NEGATE),
        Binary::Pow => ("^", ATOM, NEGATE),
        Binary::Lt => (" < ", SUM, SUM),
        Binary::Le => (" <= ", SUM, SUM),
        Binary::Gt => (" > ", SUM, SUM),
        Binary::Ge => (" >= ", SUM, SUM),
        Binary::Eq => (" == ", SUM, SUM),
        Binary::Ne => (" != ", SUM, SUM),
        Binary::And => (" and ", AND, NOT),
        Binary::Or => (" or ", OR, AND),
        Binary::Min | Binary::Max | Binary::Hypot | Binary::Atan2 => return None,
    })
}

fn node_level(node: &Node) -> u8 {
    match *node {
        Node::Const(bits) if f64::from_bits(bits).is_sign_negative() => level::NEGATE,
        Node::Unary(Unary::Neg, _) => level::NEGATE,
        Node::Unary(Unary::Not, _) => level::NOT,
        Node::Binary(op, ..) => operator_level(op),
        _ => level::ATOM,
    }
}

/// How tightly the operator itself binds.
pub(crate) fn operator_level(op: Binary) -> u8 {
    match op {
        Binary::Or => level::OR,
        Binary::And => level::AND,
        Binary::Lt | Binary::Le | Binary::Gt | Binary::Ge | Binary::Eq | Binary::Ne => {
            level::COMPARE
        }
        Binary::Add | Binary::Sub => level::SUM,
        Binary::Mul | Binary::Div => level::PRODUCT,
        Binary::Pow => level::POWER,
        Binary::Min | Binary::Max | Binary::Hypot | Binary::Atan2 => level::ATOM,
    }
}

/// The shortest text that reads back as the same number.
fn number(value: f64) -> String {
    let size = value.abs();
    if value.is_nan() {
        "nan".to_owned()
    } else if size == 0.0 || value.is_infinite() || (1e-5..1e17).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}
