//! Terms as numbers times powers: the form in which equal ones are equal.

use std::collections::HashMap;

use sindy_expr::{Expr, Factor};

/// Factor, power in the numerator, power in the denominator.
type Power = (usize, u32, u32);

/// A term: a number times powers of the [`Alphabet`]'s factors, in its order.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Factored {
    /// The number's bits.
    number: u64,
    /// Factors ascending.
    powers: Vec<Power>,
}

/// The factors that terms are made of: variables first, in the order given (others by first appearance),
/// then all else by its text.
pub(super) struct Alphabet {
    factors: Vec<Expr>,
    /// How many of them are variables.
    variables: usize,
}

impl Alphabet {
    /// The factors of `terms`, and the terms in them.
    pub(super) fn new(terms: &[Expr], variables: &[String]) -> (Self, Vec<Factored>) {
        let mut place: HashMap<Key, usize> = HashMap::new();
        let mut factors: Vec<(Key, Expr)> = Vec::new();
        let mut add = |base: Expr| -> usize {
            let key = Key::of(&base, variables);
            *place.entry(key.clone()).or_insert_with(|| {
                factors.push((key, base));
                factors.len() - 1
            })
        };
        let read: Vec<(f64, Vec<Power>)> = terms
            .iter()
            .map(|term| {
                let (mut number, factors) = term.factors();
                let mut powers = Vec::new();
                for factor in factors {
                    match constant(&factor).map(|c| number * c) {
                        Some(folded) if folded.is_finite() => number = folded,
                        _ => powers.push((add(factor.base), factor.above, factor.below)),
                    }
                }
                (number, powers)
            })
            .collect();
        let mut order: Vec<usize> = (0..factors.len()).collect();
        // Variables that were not given stay in order of appearance: the sort is stable.
        order.sort_by(|&a, &b| factors[a].0.rank().cmp(&factors[b].0.rank()));
        let mut rank = vec![0; order.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(new, &old)| rank[old] = new);
        let terms = read
            .into_iter()
            .map(|(number, powers)| {
                let ranked = powers.into_iter().map(|(f, a, b)| (rank[f], a, b));
                Factored::new(number, ranked.collect())
            })
            .collect();
        let variables = factors.iter().filter(|f| f.0.rank().0 < 2).count();
        let factors = order.iter().map(|&old| factors[old].1.clone()).collect();
        (Self { factors, variables }, terms)
    }

    /// Whether the term is a product of whole powers of variables.
    pub(super) fn is_monomial(&self, term: &Factored) -> bool {
        let variable = |&(factor, _, below): &Power| factor < self.variables && below == 0;
        f64::from_bits(term.number) == 1.0 && term.powers.iter().all(variable)
    }

    /// The term as an expression: number, then factors in order, then what is divided by.
    pub(super) fn expr(&self, term: &Factored) -> Expr {
        let side = |power: fn(&Power) -> u32| -> Vec<Expr> {
            let powers = term.powers.iter().map(|p| (&self.factors[p.0], power(p)));
            let raised = powers.filter(|p| p.1 > 0).map(|(base, n)| match n {
                1 => base.clone(),
                _ => base.pow(&Expr::constant(f64::from(n))),
            });
            raised.collect()
        };
        let (mut above, below) = (side(|p| p.1), side(|p| p.2));
        let number = f64::from_bits(term.number);
        let negative = number == -1.0 && !above.is_empty();
        if negative {
            above[0] = -&above[0];
        } else if number != 1.0 {
            above.insert(0, Expr::constant(number));
        }
        let above = Expr::product(above);
        if below.is_empty() {
            above
        } else {
            above / Expr::product(below)
        }
    }
}

impl Factored {
    fn new(number: f64, mut powers: Vec<Power>) -> Self {
        powers.sort_unstable();
        powers.dedup_by(|later, first| {
            let same = later.0 == first.0;
            if same {
                first.1 = first.1.saturating_add(later.1);
                first.2 = first.2.saturating_add(later.2);
            }
            same
        });
        for (_, above, below) in &mut powers {
            // x/x^3 is 1/x^2, but x/x stays: it has no value at 0.
            if *above < *below {
                *below -= *above;
                *above = 0;
            }
        }
        powers.retain(|p| p.1 > 0 || p.2 > 0);
        Self {
            number: number.to_bits(),
            powers,
        }
    }

    /// The product of two terms.
    pub(super) fn times(&self, other: &Self) -> Self {
        let number = f64::from_bits(self.number) * f64::from_bits(other.number);
        Self::new(number, [&self.powers[..], &other.powers].concat())
    }
}

/// The value of a factor without variables, such as `sqrt(2)`.
fn constant(factor: &Factor) -> Option<f64> {
    if !factor.base.variables().is_empty() {
        return None;
    }
    let value = factor.base.simplify().as_constant()?;
    Some(value.powf(f64::from(factor.above)) / value.powf(f64::from(factor.below)))
}

/// What makes two factors the same.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Key {
    /// One of the given variables.
    Given(usize),
    /// Another variable.
    Variable(String),
    /// Anything else, tidied.
    Other(String),
}

impl Key {
    fn of(base: &Expr, variables: &[String]) -> Self {
        if let [name] = base.variables()[..]
            && *base == Expr::variable(name)
        {
            return match variables.iter().position(|v| v == name) {
                Some(place) => Self::Given(place),
                None => Self::Variable(name.to_string()),
            };
        }
        Self::Other(base.simplify().to_string())
    }

    fn rank(&self) -> (usize, usize, &str) {
        match self {
            Self::Given(place) => (0, *place, ""),
            Self::Variable(_) => (1, 0, ""),
            Self::Other(text) => (2, 0, text),
        }
    }
}
