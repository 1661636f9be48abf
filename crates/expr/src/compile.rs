//! Expressions to instructions: shared parts, whole powers, slots.

use std::collections::HashMap;

use crate::arena::Builder;
use crate::error::CompileError;
use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary, whole_exponent};
use crate::program::{Instruction, Op, Operand, Program, Target};
use crate::suggest::nearest;

impl Program {
    /// Compiles expressions; `inputs` names the columns in the order in which they
    /// will be given. Inputs that no expression uses are allowed.
    ///
    /// # Errors
    /// [`CompileError::UnknownName`] if an expression uses a name that is not an
    /// input, [`CompileError::DuplicateInput`] if an input is listed twice.
    pub fn compile(exprs: &[Expr], inputs: &[&str]) -> Result<Self, CompileError> {
        let mut place_of: HashMap<&str, u32> = HashMap::with_capacity(inputs.len());
        for (place, name) in inputs.iter().enumerate() {
            if let Some(first) = place_of.insert(name, place as u32) {
                return Err(CompileError::DuplicateInput {
                    name: (*name).to_owned(),
                    first: first as usize,
                    second: place,
                });
            }
        }
        let mut values = Lowering::default();
        let mut roots = Vec::with_capacity(exprs.len());
        for expr in exprs {
            for name in expr.variables() {
                if !place_of.contains_key(name) {
                    return Err(unknown(name, expr, inputs));
                }
            }
            roots.push(values.expression(expr));
        }
        Ok(Allocation::new(&values.builder, &roots, &place_of).finish(inputs, roots.len()))
    }
}

fn unknown(name: &str, expr: &Expr, inputs: &[&str]) -> CompileError {
    const LONGEST: usize = 80;
    let mut expression = Shortened {
        text: String::new(),
        left: LONGEST,
    };
    // The writer stops the printing once it has enough.
    if std::fmt::write(&mut expression, format_args!("{expr}")).is_err() {
        expression.text.push('…');
    }
    CompileError::UnknownName {
        name: name.to_owned(),
        expression: expression.text,
        known: inputs.iter().map(ToString::to_string).collect(),
        nearest: nearest(name, inputs.iter().copied()).map(ToOwned::to_owned),
    }
}

/// A writer that fails after a limit of characters.
struct Shortened {
    text: String,
    left: usize,
}

impl std::fmt::Write for Shortened {
    fn write_str(&mut self, s: &str) -> std::fmt::Result {
        for c in s.chars() {
            self.left = self.left.checked_sub(1).ok_or(std::fmt::Error)?;
            self.text.push(c);
        }
        Ok(())
    }
}

/// Nodes of all expressions together, each value once, with constant parts
/// folded and whole powers spelt out. Every rewrite keeps all bits of the result.
#[derive(Default)]
struct Lowering {
    builder: Builder,
}

impl Lowering {
    fn expression(&mut self, expr: &Expr) -> Id {
        let mut place: Vec<Id> = Vec::with_capacity(expr.nodes().len());
        for node in expr.nodes() {
            let id = match node.map(|child| place[child as usize]) {
                Node::Unary(op, a) => self.unary(op, a),
                Node::Binary(Binary::Pow, a, b) => self.power(a, b),
                Node::Binary(op, a, b) => self.binary(op, a, b),
                leaf_or_choice => self.builder.intern(leaf_or_choice),
            };
            place.push(id);
        }
        place[expr.root() as usize]
    }

    fn unary(&mut self, op: Unary, a: Id) -> Id {
        match self.builder.value(a) {
            Some(x) => self.builder.constant(op.apply(x)),
            None => self.builder.unary(op, a),
        }
    }

    fn binary(&mut self, op: Binary, a: Id, b: Id) -> Id {
        let (x, y) = (self.builder.value(a), self.builder.value(b));
        match (op, x, y) {
            (_, Some(x), Some(y)) => self.builder.constant(op.apply(x, y)),
            (Binary::Mul, Some(1.0), _) => b,
            (Binary::Mul | Binary::Div, _, Some(1.0)) => a,
            _ if op.commutes() && a > b => self.builder.binary(op, b, a),
            _ => self.builder.binary(op, a, b),
        }
    }

    fn power(&mut self, a: Id, b: Id) -> Id {
        match self.builder.value(b).and_then(whole_exponent) {
            Some(n) => self.whole_power(a, n),
            None => self.binary(Binary::Pow, a, b),
        }
    }

    /// In the order that the language documents; at most 12 levels deep.
    fn whole_power(&mut self, a: Id, n: i32) -> Id {
        match n {
            ..0 => {
                let one = self.builder.constant(1.0);
                let below = self.whole_power(a, -n);
                self.binary(Binary::Div, one, below)
            }
            0 => self.builder.constant(1.0),
            1 => a,
            _ if n % 2 == 0 => {
                let half = self.whole_power(a, n / 2);
                self.binary(Binary::Mul, half, half)
            }
            _ => {
                let less = self.whole_power(a, n - 1);
                self.binary(Binary::Mul, less, a)
            }
        }
    }
}

/// Instructions in order, with as few slots as the lives of the values allow.
struct Allocation<'p> {
    builder: &'p Builder,
    /// Values that the outputs need, children first.
    order: Vec<Id>,
    /// Position in `order` after which a value is not read again.
    last_use: HashMap<Id, usize>,
    /// Outputs that receive a value.
    sinks: HashMap<Id, Vec<u32>>,
    place_of: &'p HashMap<&'p str, u32>,
}

impl<'p> Allocation<'p> {
    fn new(builder: &'p Builder, roots: &[Id], place_of: &'p HashMap<&'p str, u32>) -> Self {
        let mut sinks: HashMap<Id, Vec<u32>> = HashMap::new();
        for (k, &root) in roots.iter().enumerate() {
            sinks.entry(root).or_default().push(k as u32);
        }
        let order = depth_first(builder, roots);
        let mut last_use = HashMap::with_capacity(order.len());
        for (position, &id) in order.iter().enumerate() {
            for child in builder.node(id).children().into_iter().flatten() {
                last_use.insert(child, position);
            }
        }
        Self {
            builder,
            order,
            last_use,
            sinks,
            place_of,
        }
    }

    fn finish(self, inputs: &[&str], outputs: usize) -> Program {
        let mut code = Vec::with_capacity(self.order.len());
        let mut held: HashMap<Id, Operand> = HashMap::new();
        let mut free: Vec<u32> = Vec::new();
        let mut slots = 0_u32;
        for (position, &id) in self.order.iter().enumerate() {
            let operand = |id: Id| match self.builder.node(id) {
                Node::Const(bits) => Operand::Const(f64::from_bits(*bits)),
                Node::Var(name) => Operand::Input(self.place_of[&**name]),
                _ => held[&id],
            };
            let mut sinks = self
                .sinks
                .get(&id)
                .map_or(&[][..], Vec::as_slice)
                .iter()
                .copied();
            let node = self.builder.node(id);
            let op = match *node {
                Node::Const(_) | Node::Var(_) => None,
                Node::Unary(op, a) => Some(Op::Unary(op, operand(a))),
                Node::Binary(op, a, b) => Some(Op::Binary(op, operand(a), operand(b))),
                Node::If(c, a, b) => Some(Op::Select(operand(c), operand(a), operand(b))),
            };
            let source = match op {
                None => operand(id),
                Some(op) => {
                    // Straight to its first output, from where the others and later instructions read it.
                    let target = sinks.next().map_or_else(
                        || {
                            Target::Slot(free.pop().unwrap_or_else(|| {
                                slots += 1;
                                slots - 1
                            }))
                        },
                        Target::Output,
                    );
                    code.push(Instruction { op, target });
                    let place = match target {
                        Target::Slot(slot) => Operand::Slot(slot),
                        Target::Output(k) => Operand::Output(k),
                    };
                    held.insert(id, place);
                    place
                }
            };
            code.extend(sinks.map(|k| Instruction {
                op: Op::Copy(source),
                target: Target::Output(k),
            }));
            let mut children = node.children();
            // A value read twice by one instruction is freed once.
            for i in 1..children.len() {
                if children[..i].contains(&children[i]) {
                    children[i] = None;
                }
            }
            for child in children.into_iter().flatten() {
                if self.last_use[&child] == position
                    && let Some(Operand::Slot(slot)) = held.get(&child)
                {
                    free.push(*slot);
                }
            }
        }
        Program {
            inputs: inputs.iter().map(ToString::to_string).collect(),
            outputs,
            slots: slots as usize,
            code,
        }
    }
}

/// All values that the roots need, each once, children before parents.
fn depth_first(builder: &Builder, roots: &[Id]) -> Vec<Id> {
    let mut done = std::collections::HashSet::new();
    let mut order = Vec::new();
    let mut stack: Vec<(Id, bool)> = roots.iter().rev().map(|&root| (root, false)).collect();
    while let Some((id, children_done)) = stack.pop() {
        if done.contains(&id) {
            continue;
        }
        if children_done {
            done.insert(id);
            order.push(id);
        } else {
            stack.push((id, true));
            for child in builder.node(id).children().into_iter().rev().flatten() {
                stack.push((child, false));
            }
        }
    }
    order
}
