//! Exact derivatives, by the chain rule from the leaves up.

use crate::arena::Builder;
use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary};

impl Expr {
    /// The partial derivative with respect to the variable `name`, simplified.
    ///
    /// Exact wherever the derivative exists. `sign`, `floor`, comparisons and logic
    /// are constant between their jumps and count as such; at a kink, `abs` has
    /// derivative `sign(0) = 0`, and `min`, `max` and `if` that of the branch they
    /// take. A power with an exponent that varies is differentiated for a positive
    /// base. By the chain rule, a part with an infinite slope makes the whole NaN even
    /// where what it is applied to does not move.
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// let e = Expr::parse("a*x^3 + exp(-x)")?;
    /// assert_eq!(e.derivative("x").to_string(), "3*a*x^2 - exp(-x)");
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn derivative(&self, name: &str) -> Self {
        let tidy = self.simplify();
        let mut b = Builder::default();
        let place = b.import_all(&tidy);
        // `None` means a derivative that is identically zero.
        let mut slopes: Vec<Option<Id>> = Vec::with_capacity(place.len());
        for node in tidy.nodes() {
            let at = |id: Id| place[id as usize];
            let slope = |id: Id| slopes[id as usize];
            let d = match *node {
                Node::Const(_) => None,
                Node::Var(ref found) => (**found == *name).then(|| b.constant(1.0)),
                Node::Unary(op, x) => slope(x).and_then(|dx| unary(&mut b, op, at(x), dx)),
                Node::Binary(op, x, y) => binary(&mut b, op, (at(x), slope(x)), (at(y), slope(y))),
                Node::If(condition, x, y) => choose(&mut b, at(condition), slope(x), slope(y)),
            };
            slopes.push(d);
        }
        let root = slopes[tidy.root() as usize].unwrap_or_else(|| b.constant(0.0));
        b.finish(root).simplify()
    }
}

fn choose(b: &mut Builder, condition: Id, x: Option<Id>, y: Option<Id>) -> Option<Id> {
    if x == y {
        return x;
    }
    let x = x.unwrap_or_else(|| b.constant(0.0));
    let y = y.unwrap_or_else(|| b.constant(0.0));
    Some(b.select(condition, x, y))
}

fn add(b: &mut Builder, op: Binary, x: Option<Id>, y: Option<Id>) -> Option<Id> {
    match (x, y) {
        (x, None) => x,
        (None, Some(y)) if op == Binary::Sub => Some(b.unary(Unary::Neg, y)),
        (None, y) => y,
        (Some(x), Some(y)) => Some(b.binary(op, x, y)),
    }
}

fn unary(b: &mut Builder, op: Unary, x: Id, dx: Id) -> Option<Id> {
    let one = b.constant(1.0);
    let two = b.constant(2.0);
    let (rule, factor) = match op {
        Unary::Neg => return Some(b.unary(Unary::Neg, dx)),
        Unary::Not | Unary::Sign | Unary::Floor | Unary::IsNan => return None,
        Unary::Sqrt => {
            let root = b.unary(Unary::Sqrt, x);
            (Binary::Div, b.binary(Binary::Mul, two, root))
        }
        Unary::Exp => (Binary::Mul, b.unary(Unary::Exp, x)),
        Unary::Log => (Binary::Div, x),
        Unary::Sin => (Binary::Mul, b.unary(Unary::Cos, x)),
        Unary::Cos => {
            let sine = b.unary(Unary::Sin, x);
            (Binary::Mul, b.unary(Unary::Neg, sine))
        }
        Unary::Tan => {
            let cosine = b.unary(Unary::Cos, x);
            (Binary::Div, b.binary(Binary::Pow, cosine, two))
        }
        Unary::Tanh => {
            let value = b.unary(Unary::Tanh, x);
            let square = b.binary(Binary::Pow, value, two);
            (Binary::Mul, b.binary(Binary::Sub, one, square))
        }
        Unary::Asin | Unary::Acos => {
            let square = b.binary(Binary::Pow, x, two);
            let rest = b.binary(Binary::Sub, one, square);
            let root = b.unary(Unary::Sqrt, rest);
            let signed = if op == Unary::Acos {
                b.unary(Unary::Neg, root)
            } else {
                root
            };
            (Binary::Div, signed)
        }
        Unary::Atan => {
            let square = b.binary(Binary::Pow, x, two);
            (Binary::Div, b.binary(Binary::Add, one, square))
        }
        Unary::Abs => (Binary::Mul, b.unary(Unary::Sign, x)),
    };
    Some(b.binary(rule, dx, factor))
}

/// A node and its derivative.
type Pair = (Id, Option<Id>);

fn binary(b: &mut Builder, op: Binary, (x, dx): Pair, (y, dy): Pair) -> Option<Id> {
    if dx.is_none() && dy.is_none() {
        return None;
    }
    match op {
        Binary::Add | Binary::Sub => add(b, op, dx, dy),
        Binary::Mul => {
            let left = dx.map(|dx| b.binary(Binary::Mul, dx, y));
            let right = dy.map(|dy| b.binary(Binary::Mul, x, dy));
            add(b, Binary::Add, left, right)
        }
        Binary::Div => {
            let left = dx.map(|dx| b.binary(Binary::Div, dx, y));
            let right = dy.map(|dy| {
                let two = b.constant(2.0);
                let square = b.binary(Binary::Pow, y, two);
                let product = b.binary(Binary::Mul, x, dy);
                b.binary(Binary::Div, product, square)
            });
            add(b, Binary::Sub, left, right)
        }
        Binary::Pow => {
            let from_base = dx.map(|dx| {
                let one = b.constant(1.0);
                let less = match b.value(y) {
                    Some(n) => b.constant(n - 1.0),
                    None => b.binary(Binary::Sub, y, one),
                };
                let power = b.binary(Binary::Pow, x, less);
                let scaled = b.binary(Binary::Mul, y, power);
                b.binary(Binary::Mul, scaled, dx)
            });
            let from_exponent = dy.map(|dy| {
                let power = b.binary(Binary::Pow, x, y);
                let log = b.unary(Unary::Log, x);
                let scaled = b.binary(Binary::Mul, power, log);
                b.binary(Binary::Mul, scaled, dy)
            });
            add(b, Binary::Add, from_base, from_exponent)
        }
        Binary::Min | Binary::Max => {
            let compare = if op == Binary::Min {
                Binary::Lt
            } else {
                Binary::Gt
            };
            let condition = b.binary(compare, x, y);
            choose(b, condition, dx, dy)
        }
        Binary::Hypot => {
            let left = dx.map(|dx| b.binary(Binary::Mul, x, dx));
            let right = dy.map(|dy| b.binary(Binary::Mul, y, dy));
            let above = add(b, Binary::Add, left, right)?;
            let below = b.binary(Binary::Hypot, x, y);
            Some(b.binary(Binary::Div, above, below))
        }
        Binary::Atan2 => {
            // d atan2(x, y), x the ordinate and y the abscissa.
            let left = dx.map(|dx| b.binary(Binary::Mul, y, dx));
            let right = dy.map(|dy| b.binary(Binary::Mul, x, dy));
            let above = add(b, Binary::Sub, left, right)?;
            let two = b.constant(2.0);
            let x2 = b.binary(Binary::Pow, x, two);
            let y2 = b.binary(Binary::Pow, y, two);
            let below = b.binary(Binary::Add, x2, y2);
            Some(b.binary(Binary::Div, above, below))
        }
        Binary::Lt
        | Binary::Le
        | Binary::Gt
        | Binary::Ge
        | Binary::Eq
        | Binary::Ne
        | Binary::And
        | Binary::Or => None,
    }
}
