//! Expressions taken apart into factors.

use crate::arena::Builder;
use crate::expr::Expr;
use crate::node::{Binary, Id, Node, Unary, constant_power};

/// Powers that grow beyond this are not collected.
const MAX_POWER: u32 = 1_000_000;

/// A factor of a product: `base^above / base^below`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Factor {
    /// What is multiplied: neither a number nor itself a product, quotient or whole power.
    pub base: Expr,
    /// Its power in the numerator.
    pub above: u32,
    /// Its power in the denominator.
    pub below: u32,
}

impl Expr {
    /// This expression as a number times factors, in order of first appearance.
    ///
    /// Products, quotients, negations and whole powers at the top are taken apart, and factors that are
    /// written alike are collected; what stands inside a factor is left as it is written, and numerator and
    /// denominator do not cancel. Where that cannot be done in finite numbers, the expression is its own only
    /// factor.
    ///
    /// ```
    /// use sindy_expr::Expr;
    /// let (number, factors) = Expr::parse("-2*x*(y/x)^3*sin(x + 1)")?.factors();
    /// assert_eq!(number, -2.0);
    /// let text = factors.iter().map(|f| format!("{} {} {}", f.base, f.above, f.below));
    /// assert_eq!(text.collect::<Vec<_>>(), ["x 1 3", "y 3 0", "sin(x + 1) 1 0"]);
    /// # Ok::<(), sindy_expr::ParseError>(())
    /// ```
    #[must_use]
    pub fn factors(&self) -> (f64, Vec<Factor>) {
        self.collected().unwrap_or_else(|| {
            let whole = Factor {
                base: self.clone(),
                above: 1,
                below: 0,
            };
            (1.0, vec![whole])
        })
    }

    fn collected(&self) -> Option<(f64, Vec<Factor>)> {
        // Parents come after their children, so one pass from the root down knows each node's powers.
        let mut powers = vec![(0_u32, 0_u32); self.nodes().len()];
        *powers.last_mut()? = (1, 0);
        let mut number = 1.0;
        let mut bases = Vec::new();
        for id in (0..self.nodes().len()).rev() {
            let (above, below) = powers[id];
            if (above, below) == (0, 0) {
                continue;
            }
            let mut pass = |child: Id, above: u32, below: u32| {
                let power = &mut powers[child as usize];
                power.0 = sum(power.0, above)?;
                power.1 = sum(power.1, below)?;
                Some(())
            };
            match self.nodes()[id] {
                Node::Binary(Binary::Mul, a, b) => {
                    pass(a, above, below)?;
                    pass(b, above, below)?;
                }
                Node::Binary(Binary::Div, a, b) => {
                    pass(a, above, below)?;
                    pass(b, below, above)?;
                }
                Node::Unary(Unary::Neg, a) => {
                    if (above + below) % 2 == 1 {
                        number = -number;
                    }
                    pass(a, above, below)?;
                }
                Node::Binary(Binary::Pow, a, n) if self.whole(n).is_some() => {
                    let n = self.whole(n)?;
                    let times = |power: u32| power.checked_mul(n.unsigned_abs());
                    let (above, below) = (times(above)?, times(below)?);
                    match n {
                        0 => {}
                        1.. => pass(a, above, below)?,
                        _ => pass(a, below, above)?,
                    }
                }
                Node::Const(bits) => {
                    let value = f64::from_bits(bits);
                    number *= constant_power(value, f64::from(above));
                    number /= constant_power(value, f64::from(below));
                }
                _ => bases.push(id),
            }
        }
        if !number.is_finite() {
            return None;
        }
        let mut builder = Builder::default();
        let place = builder.import_all(self);
        let factor = |&id: &usize| Factor {
            base: builder.finish(place[id]),
            above: powers[id].0,
            below: powers[id].1,
        };
        Some((number, bases.iter().rev().map(factor).collect()))
    }

    fn whole(&self, id: Id) -> Option<i32> {
        let value = self.nodes()[id as usize].as_const()?;
        let whole = value.trunc() == value && value.abs() <= f64::from(MAX_POWER);
        whole.then_some(value as i32)
    }
}

fn sum(a: u32, b: u32) -> Option<u32> {
    a.checked_add(b).filter(|sum| *sum <= MAX_POWER)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (f64, Vec<(String, u32, u32)>) {
        let (number, factors) = Expr::parse(text).unwrap().factors();
        let factor = |f: Factor| (f.base.to_string(), f.above, f.below);
        (number, factors.into_iter().map(factor).collect())
    }

    #[test]
    fn analytic_products_quotients_and_powers_come_apart() {
        let of = |text: &str, above, below| (text.to_string(), above, below);
        assert_eq!(read("1"), (1.0, vec![]));
        assert_eq!(read("x*x"), (1.0, vec![of("x", 2, 0)]));
        assert_eq!(read("(2*x)^-2"), (0.25, vec![of("x", 0, 2)]));
        assert_eq!(read("x/x"), (1.0, vec![of("x", 1, 1)]));
        assert_eq!(read("-(-x)^3"), (1.0, vec![of("x", 3, 0)]));
        assert_eq!(read("(x + y)^0*y"), (1.0, vec![of("y", 1, 0)]));
        assert_eq!(read("x^0.5"), (1.0, vec![of("x^0.5", 1, 0)]));
        let pole = of("1 + x^2", 0, 2);
        assert_eq!(read("y/(1 + x^2)^2"), (1.0, vec![of("y", 1, 0), pole]));
    }

    #[test]
    fn prop_what_has_no_finite_number_is_left_whole() {
        for text in ["x/0", "1e300*x*1e300", "nan*x", "x^999999*x^999999"] {
            let (number, factors) = Expr::parse(text).unwrap().factors();
            assert_eq!((number, factors.len()), (1.0, 1), "{text}");
            assert_eq!(factors[0].base, Expr::parse(text).unwrap());
        }
        // A product of 2^80 factors, written in 80 steps.
        let mut e = Expr::variable("x");
        for _ in 0..80 {
            e = &e * &e;
        }
        assert_eq!(e.factors().1.len(), 1);
    }
}
