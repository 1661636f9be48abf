//! Expressions built from others: sums, products, powers, substitution and operators.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::arena::Builder;
use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary};

impl Expr {
    /// The product of variables raised to whole powers, in the order given:
    /// `monomial(&[("x", 2), ("y", 1)])` is `x^2*y`. Powers of 0 are left out; the
    /// empty product is `1`.
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// assert_eq!(Expr::monomial(&[("x", 2), ("y", 1)]).to_string(), "x^2*y");
    /// assert_eq!(Expr::monomial(&[("x", 0)]).to_string(), "1");
    /// ```
    #[must_use]
    pub fn monomial(factors: &[(&str, u32)]) -> Self {
        Self::product(
            factors
                .iter()
                .filter(|(_, power)| *power > 0)
                .map(|&(name, power)| match power {
                    1 => Self::variable(name),
                    _ => Self::variable(name).pow(&Self::constant(f64::from(power))),
                }),
        )
    }

    /// The sum of terms, from the left; the empty sum is `0`. Takes time
    /// proportional to the total size, which repeated `+` does not.
    #[must_use]
    pub fn sum(terms: impl IntoIterator<Item = Self>) -> Self {
        Self::fold(Binary::Add, 0.0, terms)
    }

    /// The product of factors, from the left; the empty product is `1`.
    #[must_use]
    pub fn product(factors: impl IntoIterator<Item = Self>) -> Self {
        Self::fold(Binary::Mul, 1.0, factors)
    }

    fn fold(op: Binary, empty: f64, parts: impl IntoIterator<Item = Self>) -> Self {
        let mut builder = Builder::default();
        let mut total = None;
        for part in parts {
            let part = builder.import(&part);
            total = Some(match total {
                None => part,
                Some(sum) => builder.binary(op, sum, part),
            });
        }
        let root = total.unwrap_or_else(|| builder.constant(empty));
        builder.finish(root)
    }

    /// This expression raised to a whole power.
    #[must_use]
    pub fn powi(&self, exponent: i32) -> Self {
        self.pow(&Self::constant(f64::from(exponent)))
    }

    /// This expression raised to another.
    #[must_use]
    pub fn pow(&self, exponent: &Self) -> Self {
        self.join(Binary::Pow, exponent)
    }

    fn join(&self, op: Binary, other: &Self) -> Self {
        let mut builder = Builder::default();
        let a = builder.import(self);
        let b = builder.import(other);
        let root = builder.binary(op, a, b);
        builder.finish(root)
    }

    /// This expression with every use of the variable `name` replaced by `by`
    /// (in which `name` may occur again; it is not replaced there).
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// let e = Expr::parse("x^2 + y")?.substitute("x", &Expr::parse("x - 1")?);
    /// assert_eq!(e.to_string(), "(x - 1)^2 + y");
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn substitute(&self, name: &str, by: &Self) -> Self {
        let mut builder = Builder::default();
        let by = builder.import(by);
        let mut place: Vec<Id> = Vec::with_capacity(self.nodes().len());
        for node in self.nodes() {
            let id = match node {
                Node::Var(found) if **found == *name => by,
                _ => builder.intern(node.map(|child| place[child as usize])),
            };
            place.push(id);
        }
        builder.finish(place[self.root() as usize])
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Expr {
            type Output = Expr;
            fn $method(self, other: Expr) -> Expr {
                self.join(Binary::$trait, &other)
            }
        }
        impl $trait<&Expr> for &Expr {
            type Output = Expr;
            fn $method(self, other: &Expr) -> Expr {
                self.join(Binary::$trait, other)
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for &Expr {
    type Output = Expr;
    fn neg(self) -> Expr {
        let mut builder = Builder::default();
        let a = builder.import(self);
        let root = builder.unary(Unary::Neg, a);
        builder.finish(root)
    }
}

impl Neg for Expr {
    type Output = Expr;
    fn neg(self) -> Expr {
        -&self
    }
}
