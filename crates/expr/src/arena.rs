//! Building of expressions with shared parts.

use std::collections::HashMap;
use std::sync::Arc;

use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary};

/// A growing set of nodes in which equal nodes are one node.
#[derive(Default)]
pub(crate) struct Builder {
    nodes: Vec<Node>,
    index: HashMap<Node, Id>,
}

impl Builder {
    pub(crate) fn node(&self, id: Id) -> &Node {
        &self.nodes[id as usize]
    }

    pub(crate) fn value(&self, id: Id) -> Option<f64> {
        self.node(id).as_const()
    }

    /// Adds a node; the negative of a constant becomes a constant, so that one
    /// number has one form.
    pub(crate) fn intern(&mut self, node: Node) -> Id {
        if let Node::Unary(Unary::Neg, a) = node
            && let Some(value) = self.value(a)
        {
            return self.constant(-value);
        }
        if let Some(&id) = self.index.get(&node) {
            return id;
        }
        let id = Id::try_from(self.nodes.len()).expect("an expression has fewer than 2^32 nodes");
        self.nodes.push(node.clone());
        self.index.insert(node, id);
        id
    }

    pub(crate) fn constant(&mut self, value: f64) -> Id {
        self.intern(Node::constant(value))
    }

    pub(crate) fn variable(&mut self, name: &str) -> Id {
        self.intern(Node::Var(Arc::from(name)))
    }

    pub(crate) fn unary(&mut self, op: Unary, a: Id) -> Id {
        self.intern(Node::Unary(op, a))
    }

    pub(crate) fn binary(&mut self, op: Binary, a: Id, b: Id) -> Id {
        self.intern(Node::Binary(op, a, b))
    }

    pub(crate) fn select(&mut self, condition: Id, a: Id, b: Id) -> Id {
        self.intern(Node::If(condition, a, b))
    }

    /// Copies a whole expression in and returns its root.
    pub(crate) fn import(&mut self, expr: &Expr) -> Id {
        *self
            .import_all(expr)
            .last()
            .expect("an expression has a node")
    }

    /// Copies a whole expression in and returns where each of its nodes went.
    pub(crate) fn import_all(&mut self, expr: &Expr) -> Vec<Id> {
        let mut place: Vec<Id> = Vec::with_capacity(expr.nodes().len());
        for node in expr.nodes() {
            let node = node.map(|child| place[child as usize]);
            let id = self.intern(node);
            place.push(id);
        }
        place
    }

    /// What the root needs, in depth-first order: the one form of an expression,
    /// so that equal expressions have equal node lists.
    pub(crate) fn finish(&self, root: Id) -> Expr {
        const UNSEEN: Id = Id::MAX;
        let mut place = vec![UNSEEN; self.nodes.len()];
        let mut ordered: Vec<Node> = Vec::new();
        let mut stack = vec![(root, false)];
        while let Some((id, children_done)) = stack.pop() {
            if place[id as usize] != UNSEEN {
                continue;
            }
            let node = self.node(id);
            if children_done {
                place[id as usize] = ordered.len() as Id;
                ordered.push(node.map(|child| place[child as usize]));
            } else {
                stack.push((id, true));
                for child in node.children().into_iter().rev().flatten() {
                    stack.push((child, false));
                }
            }
        }
        Expr::from_nodes(ordered)
    }
}
