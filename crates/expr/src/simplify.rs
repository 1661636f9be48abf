//! Constant folding, flattening of sums and products, collection of like terms.

use std::collections::HashMap;

use crate::arena::Builder;
use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary, constant_power, is_true};

/// Exponents of larger magnitude are not combined.
const MAX_EXPONENT: i32 = 1_000_000;

impl Expr {
    /// An equal, tidier expression: constants folded, sums and products flattened,
    /// like terms and equal factors collected (`x*y + y*x` is `2*x*y`, `x*x` is
    /// `x^2`), zeros and ones dropped. Terms keep their order of appearance; a
    /// product has its number first, then variables by name, then the rest.
    ///
    /// Equal for finite operands: `0*x` and `x - x` become `0`, `1*x` becomes `x`.
    /// Rounding may differ in the last digits. A fraction is reduced only if the
    /// factor stays below (`x/x^3` is `1/x^2`, but `x/x` stays), so that points outside
    /// the domain stay outside. A constant part that overflows or has no value is left
    /// as written.
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// let e = Expr::parse("2*y*x + 0*z - (x - 3)*1 - x*y")?;
    /// assert_eq!(e.simplify().to_string(), "x*y - x + 3");
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn simplify(&self) -> Self {
        let mut uses = vec![0_usize; self.nodes().len()];
        let mut parent_chain: Vec<Option<Chain>> = vec![None; self.nodes().len()];
        for node in self.nodes() {
            for child in node.children().into_iter().flatten() {
                uses[child as usize] += 1;
                parent_chain[child as usize] = chain_of(node);
            }
        }
        let mut pass = Simplifier {
            source: self.nodes(),
            deferred: Vec::with_capacity(self.nodes().len()),
            place: Vec::with_capacity(self.nodes().len()),
            builder: Builder::default(),
            split: HashMap::new(),
        };
        for (i, node) in self.nodes().iter().enumerate() {
            // A sum inside a sum is gathered by the outer one, a product likewise.
            let own = chain_of(node);
            let defer = own.is_some() && uses[i] == 1 && parent_chain[i] == own;
            let id = if defer { Id::MAX } else { pass.node(i as Id) };
            pass.deferred.push(defer);
            pass.place.push(id);
        }
        let root = pass.place[self.root() as usize];
        pass.builder.finish(root)
    }
}

/// A chain of binary operators, collected as one sum or product.
#[derive(Clone, Copy, PartialEq)]
enum Chain {
    Sum,
    Product,
}

fn chain_of(node: &Node) -> Option<Chain> {
    match node {
        Node::Binary(Binary::Add | Binary::Sub, ..) => Some(Chain::Sum),
        Node::Binary(Binary::Mul | Binary::Div, ..) => Some(Chain::Product),
        _ => None,
    }
}

struct Simplifier<'e> {
    source: &'e [Node],
    /// Source nodes that their parent gathers.
    deferred: Vec<bool>,
    /// New index of each source node; unused for deferred ones.
    place: Vec<Id>,
    builder: Builder,
    /// New products as number times rest.
    split: HashMap<Id, (f64, Id)>,
}

/// A node to gather from: in the source, or already built.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Source(Id),
    Built(Id),
}

impl Simplifier<'_> {
    fn node(&mut self, id: Id) -> Id {
        let source = self.source;
        match source[id as usize] {
            Node::Binary(Binary::Add | Binary::Sub, ..) => self.sum(id),
            Node::Binary(Binary::Mul | Binary::Div, ..) => self.product(Part::Source(id)),
            Node::Unary(Unary::Neg, _) => self.product(Part::Source(id)),
            Node::Unary(op, a) => {
                let a = self.place[a as usize];
                let folded = self.builder.value(a).map(|x| op.apply(x));
                self.folded_or(folded, Node::Unary(op, a))
            }
            Node::Binary(op, a, b) => {
                let (a, b) = (self.place[a as usize], self.place[b as usize]);
                let (x, y) = (self.builder.value(a), self.builder.value(b));
                if op == Binary::Pow {
                    return self.power(a, b);
                }
                let folded = x.zip(y).map(|(x, y)| op.apply(x, y));
                self.folded_or(folded, Node::Binary(op, a, b))
            }
            Node::If(condition, a, b) => {
                let [condition, a, b] = [condition, a, b].map(|i| self.place[i as usize]);
                match self.builder.value(condition) {
                    Some(value) if is_true(value) => a,
                    Some(_) => b,
                    None if a == b => a,
                    None => self.builder.select(condition, a, b),
                }
            }
            ref leaf => self.builder.intern(leaf.clone()),
        }
    }

    /// The folded value if it is a finite number, else the node.
    fn folded_or(&mut self, folded: Option<f64>, node: Node) -> Id {
        match folded {
            Some(value) if value.is_finite() => self.builder.constant(value),
            _ => self.builder.intern(node),
        }
    }

    fn power(&mut self, base: Id, exponent: Id) -> Id {
        let (x, n) = (self.builder.value(base), self.builder.value(exponent));
        let node = Node::Binary(Binary::Pow, base, exponent);
        match (x, n) {
            (_, Some(0.0)) => self.builder.constant(1.0),
            (_, Some(1.0)) => base,
            (Some(1.0), _) => base,
            (Some(x), Some(n)) => self.folded_or(Some(constant_power(x, n)), node),
            (None, Some(n)) if combinable(n).is_some() => {
                let id = self.builder.intern(node);
                self.product(Part::Built(id))
            }
            _ => self.builder.intern(node),
        }
    }

    /// The node of a part below `root`, and where it is if it is built: in the source are only the root and
    /// what it gathers.
    fn node_of(&self, part: Part, root: Part) -> (Node, Option<Id>) {
        let built = match part {
            Part::Source(id) if part == root || self.deferred[id as usize] => {
                return (self.source[id as usize].clone(), None);
            }
            Part::Source(id) => self.place[id as usize],
            Part::Built(id) => id,
        };
        (self.builder.node(built).clone(), Some(built))
    }

    // ---- sums

    fn sum(&mut self, root: Id) -> Id {
        let mut terms: Vec<(f64, Id)> = Vec::new();
        let mut where_is: HashMap<Id, usize> = HashMap::new();
        let one = self.builder.constant(1.0);
        let mut stack = vec![(Part::Source(root), 1.0)];
        while let Some((part, sign)) = stack.pop() {
            let (node, built) = self.node_of(part, Part::Source(root));
            let wrap = if built.is_some() {
                Part::Built
            } else {
                Part::Source
            };
            match node {
                Node::Binary(Binary::Add, a, b) => {
                    stack.extend([(wrap(b), sign), (wrap(a), sign)]);
                }
                Node::Binary(Binary::Sub, a, b) => {
                    stack.extend([(wrap(b), -sign), (wrap(a), sign)]);
                }
                _ => {
                    let id = built.expect("only sums are gathered unbuilt");
                    let (number, rest) = match self.builder.value(id) {
                        Some(value) if value.is_finite() => (value, one),
                        Some(_) => (1.0, id),
                        None => self.split.get(&id).copied().unwrap_or((1.0, id)),
                    };
                    if number == 0.0 {
                        continue;
                    }
                    let inner = self.builder.node(rest);
                    if number.abs() == 1.0 && chain_of(inner) == Some(Chain::Sum) {
                        stack.push((Part::Built(rest), sign * number));
                        continue;
                    }
                    let place = *where_is.entry(rest).or_insert(terms.len());
                    if place == terms.len() {
                        terms.push((0.0, rest));
                    }
                    let total = terms[place].0 + sign * number;
                    if total.is_finite() {
                        terms[place].0 = total;
                    } else {
                        // Overflow: the same rest once more, as a term of its own.
                        where_is.insert(rest, terms.len());
                        terms.push((sign * number, rest));
                    }
                }
            }
        }
        self.build_sum(&terms, one)
    }

    fn build_sum(&mut self, terms: &[(f64, Id)], one: Id) -> Id {
        let mut total: Option<Id> = None;
        for &(number, rest) in terms {
            // A number that is not finite stands in `rest`; it never cancels.
            let lasting = self.builder.value(rest).is_some_and(|v| !v.is_finite());
            if number == 0.0 && !lasting {
                continue;
            }
            let size = if total.is_some() {
                number.abs()
            } else {
                number
            };
            let term = if rest == one {
                self.builder.constant(size)
            } else {
                self.scaled(size, rest)
            };
            total = Some(match total {
                None => term,
                Some(sum) => {
                    let op = if number < 0.0 {
                        Binary::Sub
                    } else {
                        Binary::Add
                    };
                    self.builder.binary(op, sum, term)
                }
            });
        }
        total.unwrap_or_else(|| self.builder.constant(0.0))
    }

    // ---- products

    fn product(&mut self, root: Part) -> Id {
        let mut number = 1.0;
        let mut factors: Vec<(Id, i32, bool)> = Vec::new();
        let mut where_is: HashMap<(Id, bool), usize> = HashMap::new();
        let mut not_finite = false;
        let mut stack = vec![(root, 1_i32)];
        while let Some((part, exponent)) = stack.pop() {
            let (node, built) = self.node_of(part, root);
            let wrap = if built.is_some() {
                Part::Built
            } else {
                Part::Source
            };
            match node {
                Node::Binary(Binary::Mul, a, b) => {
                    stack.extend([(wrap(b), exponent), (wrap(a), exponent)]);
                    continue;
                }
                Node::Binary(Binary::Div, a, b) => {
                    stack.extend([(wrap(b), -exponent), (wrap(a), exponent)]);
                    continue;
                }
                Node::Unary(Unary::Neg, a) => {
                    if exponent % 2 != 0 {
                        number = -number;
                    }
                    stack.push((wrap(a), exponent));
                    continue;
                }
                Node::Binary(Binary::Pow, a, n) if built.is_some() => {
                    let whole = self.builder.value(n).and_then(combinable);
                    let combined = whole.and_then(|n| combine(exponent, n));
                    if let Some(combined) = combined {
                        stack.push((Part::Built(a), combined));
                        continue;
                    }
                }
                Node::Const(bits) => {
                    let value = f64::from_bits(bits);
                    let folded = number * constant_power(value, f64::from(exponent));
                    let kept =
                        folded.is_finite() && (folded != 0.0 || number == 0.0 || value == 0.0);
                    if kept && value.is_finite() {
                        number = folded;
                        continue;
                    }
                    not_finite = true;
                }
                _ => {}
            }
            let base = built.expect("only products are gathered unbuilt");
            // Numerator and denominator are collected apart.
            let key = (base, exponent > 0);
            let place = where_is.get(&key).copied();
            let sum = place.and_then(|p| factors[p].1.checked_add(exponent));
            match (place, sum) {
                (Some(place), Some(sum)) if sum.abs() <= MAX_EXPONENT => factors[place].1 = sum,
                _ => {
                    where_is.insert(key, factors.len());
                    factors.push((base, exponent, exponent > 0));
                }
            }
        }
        if number == 0.0 && !not_finite {
            return self.builder.constant(0.0);
        }
        for above in 0..factors.len() {
            let (base, exponent, is_above) = factors[above];
            if let Some(&below) = where_is.get(&(base, false)).filter(|_| is_above)
                && factors[below].1 + exponent < 0
            {
                factors[below].1 += exponent;
                factors[above].1 = 0;
            }
        }
        factors.retain(|&(_, exponent, _)| exponent != 0);
        let rest = self.build_product(factors);
        self.scaled(number, rest)
    }

    /// The product of the factors, without a number in front; 1 if there are none.
    fn build_product(&mut self, mut factors: Vec<(Id, i32, bool)>) -> Id {
        factors.sort_by(
            |&(a, ..), &(b, ..)| match (self.builder.node(a), self.builder.node(b)) {
                (Node::Var(x), Node::Var(y)) => x.cmp(y),
                (Node::Var(_), _) => std::cmp::Ordering::Less,
                (_, Node::Var(_)) => std::cmp::Ordering::Greater,
                _ => a.cmp(&b),
            },
        );
        let mut sides: [Option<Id>; 2] = [None, None];
        for (base, exponent, above) in factors {
            let size = exponent.abs();
            let power = if size == 1 {
                base
            } else {
                let size = self.builder.constant(f64::from(size));
                self.builder.binary(Binary::Pow, base, size)
            };
            let side = &mut sides[usize::from(!above)];
            *side = Some(match *side {
                None => power,
                Some(product) => self.builder.binary(Binary::Mul, product, power),
            });
        }
        let [above, below] = sides;
        let above = above.unwrap_or_else(|| self.builder.constant(1.0));
        match below {
            None => above,
            Some(below) => self.builder.binary(Binary::Div, above, below),
        }
    }

    /// A number times a product, the number put in front of the first factor.
    fn scaled(&mut self, number: f64, rest: Id) -> Id {
        if number == 1.0 {
            return rest;
        }
        let mut chain = Vec::new();
        let mut first = rest;
        while let Node::Binary(op @ (Binary::Mul | Binary::Div), a, b) = *self.builder.node(first) {
            chain.push((op, b));
            first = a;
        }
        let mut id = if self.builder.value(first) == Some(1.0) {
            self.builder.constant(number)
        } else if number == -1.0 {
            self.builder.unary(Unary::Neg, first)
        } else {
            let number = self.builder.constant(number);
            self.builder.binary(Binary::Mul, number, first)
        };
        for (op, b) in chain.into_iter().rev() {
            id = self.builder.binary(op, id, b);
        }
        self.split.insert(id, (number, rest));
        id
    }
}

/// A whole exponent other than 0 that takes part in collection.
fn combinable(value: f64) -> Option<i32> {
    let small = value.trunc() == value && value.abs() <= f64::from(MAX_EXPONENT) && value != 0.0;
    small.then_some(value as i32)
}

fn combine(a: i32, b: i32) -> Option<i32> {
    a.checked_mul(b).filter(|n| n.abs() <= MAX_EXPONENT)
}
