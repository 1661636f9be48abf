//! The expression type.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use crate::node::{Id, Node};

/// An expression over named variables.
///
/// Cloning is cheap. Two expressions are equal when their canonical texts are;
/// `x + y` and `y + x` are different. The text from `Display` parses back to an
/// equal expression, provided it stays within the parser's limits.
///
/// The operators `+ - * /` and unary `-` build what is written without
/// rearranging it; [`Expr::simplify`] tidies.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Expr {
    /// Distinct nodes, children before parents, depth first; the last is the root.
    nodes: Arc<[Node]>,
}

impl Expr {
    pub(crate) fn from_nodes(nodes: Vec<Node>) -> Self {
        Self {
            nodes: nodes.into(),
        }
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(crate) fn root(&self) -> Id {
        (self.nodes.len() - 1) as Id
    }

    /// A number. NaN and infinities are allowed and print as `nan` and `inf`.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self::from_nodes(vec![Node::constant(value)])
    }

    /// A variable of any name, an odd one included: it is quoted when printed.
    /// (An empty name cannot be written as text.)
    #[must_use]
    pub fn variable(name: &str) -> Self {
        Self::from_nodes(vec![Node::Var(Arc::from(name))])
    }

    /// The number, if this is nothing but a number.
    #[must_use]
    pub fn as_constant(&self) -> Option<f64> {
        self.nodes[self.root() as usize].as_const()
    }

    /// The names of all variables, sorted, each once.
    #[must_use]
    pub fn variables(&self) -> Vec<&str> {
        let names: BTreeSet<&str> = self
            .nodes
            .iter()
            .filter_map(|node| match node {
                Node::Var(name) => Some(&**name),
                _ => None,
            })
            .collect();
        names.into_iter().collect()
    }
}

impl fmt::Debug for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Expr({self})")
    }
}
