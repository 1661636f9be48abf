//! Candidate terms of a partial differential equation: derivatives in space of products of the fields.

use std::fmt;

use crate::error::{SindyError, require};

/// Powers and orders at most: beyond them the sums of noise lose their digits.
const MOST: u8 = 8;

/// `∂^α (u^a v^b ...)`: the derivative of a product of powers of the fields.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FieldTerm {
    /// Powers of the fields.
    pub(super) powers: Vec<u8>,
    /// Orders of the derivatives, one for each axis of space.
    pub(super) orders: Vec<u8>,
}

impl FieldTerm {
    /// The sum of the powers.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.powers.iter().map(|p| usize::from(*p)).sum()
    }

    /// The sum of the orders.
    #[must_use]
    pub fn order(&self) -> usize {
        self.orders.iter().map(|o| usize::from(*o)).sum()
    }
}

/// Candidate terms, with the names of fields and axes of space.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldLibrary {
    pub(super) fields: Vec<String>,
    pub(super) space: Vec<String>,
    pub(super) terms: Vec<FieldTerm>,
}

impl FieldLibrary {
    /// A constant, and all derivatives up to `order` of all products of the fields up to `degree`.
    ///
    /// # Errors
    /// No field or axis, a degree outside 1 to 8, an order above 8.
    pub fn polynomial(
        fields: &[&str],
        degree: u8,
        space: &[&str],
        order: u8,
    ) -> Result<Self, SindyError> {
        require((1..=MOST).contains(&degree), "degree", "1 to 8", degree)?;
        require(order <= MOST, "order", "0 to 8", order)?;
        let mut terms = Vec::new();
        for powers in indices(fields.len(), degree) {
            let constant = powers.iter().all(|p| *p == 0);
            for orders in indices(space.len(), if constant { 0 } else { order }) {
                let powers = powers.clone();
                terms.push(FieldTerm { powers, orders });
            }
        }
        Self::new(fields, space, terms)
    }

    /// The highest order that is looked for where nobody says: 4 in one dimension of space, 2 in more.
    #[must_use]
    pub fn usual_order(dimensions: usize) -> u8 {
        if dimensions == 1 { 4 } else { 2 }
    }

    /// Terms as they are printed: `1`, `u`, `u^2*v`, `u_xx`, `(u^2)_x`, `(u*v)_xy`.
    ///
    /// # Errors
    /// A text that is no such term, with the reason; a term that occurs twice.
    pub fn parse(fields: &[&str], space: &[&str], terms: &[&str]) -> Result<Self, SindyError> {
        let read = |text: &&str| parse(fields, space, text);
        let terms = terms.iter().map(read).collect::<Result<_, _>>()?;
        Self::new(fields, space, terms)
    }

    fn new(fields: &[&str], space: &[&str], terms: Vec<FieldTerm>) -> Result<Self, SindyError> {
        require(!fields.is_empty(), "fields", "at least one", "none")?;
        let dimensions = (1..=3).contains(&space.len());
        require(dimensions, "space", "one to three axes", space.len())?;
        let odd = |c: char| c.is_whitespace() || "^*().".contains(c);
        let odd = fields
            .iter()
            .chain(space)
            .find(|n| n.is_empty() || n.contains(odd));
        let found = odd.map_or("", |n| n);
        let expected = "names without blanks, ^, *, dots and brackets";
        require(odd.is_none(), "names", expected, format!("`{found}`"))?;
        let owned = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        let out = Self {
            fields: owned(fields),
            space: owned(space),
            terms,
        };
        for (j, term) in out.terms.iter().enumerate() {
            if out.terms[..j].contains(term) {
                return Err(SindyError::DuplicateTerm {
                    name: out.name(term),
                });
            }
        }
        Ok(out)
    }

    /// The number of terms.
    #[must_use]
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// Whether there are no terms.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// The terms as text.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.terms.iter().map(|t| self.name(t)).collect()
    }

    /// A term as text.
    pub(super) fn name(&self, term: &FieldTerm) -> String {
        Named {
            term,
            fields: &self.fields,
            space: &self.space,
        }
        .to_string()
    }
}

/// All vectors of `n` numbers with a sum of at most `most`, in the order of their sums.
fn indices(n: usize, most: u8) -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    for sum in 0..=most {
        compositions(n, sum, &mut Vec::new(), &mut out);
    }
    out
}

fn compositions(n: usize, sum: u8, begun: &mut Vec<u8>, out: &mut Vec<Vec<u8>>) {
    if begun.len() + 1 >= n {
        let mut whole = begun.clone();
        whole.push(sum);
        whole.truncate(n);
        out.push(whole);
        return;
    }
    for first in (0..=sum).rev() {
        begun.push(first);
        compositions(n, sum - first, begun, out);
        begun.pop();
    }
}

/// A term with the names that it is printed with.
pub(super) struct Named<'a> {
    pub(super) term: &'a FieldTerm,
    pub(super) fields: &'a [String],
    pub(super) space: &'a [String],
}

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factors: Vec<String> = self
            .fields
            .iter()
            .zip(&self.term.powers)
            .filter(|(_, p)| **p > 0)
            .map(|(name, p)| match p {
                1 => name.clone(),
                p => format!("{name}^{p}"),
            })
            .collect();
        let product = match factors.is_empty() {
            true => "1".to_owned(),
            false => factors.join("*"),
        };
        if self.term.order() == 0 {
            return f.write_str(&product);
        }
        match self.term.degree() {
            1 => f.write_str(&product)?,
            _ => write!(f, "({product})")?,
        }
        let axes = self.space.iter().zip(&self.term.orders);
        let letters: Vec<&str> = axes
            .flat_map(|(name, order)| vec![name.as_str(); usize::from(*order)])
            .collect();
        match self.space.iter().all(|name| name.chars().count() == 1) {
            true => write!(f, "_{}", letters.concat()),
            false => write!(f, "_{}", letters.join(".")),
        }
    }
}

/// Reads a term as it is printed.
pub(super) fn parse(fields: &[&str], space: &[&str], text: &str) -> Result<FieldTerm, SindyError> {
    let text = text.trim();
    let fault = |reason: String| SindyError::Expression {
        text: text.to_owned(),
        reason,
    };
    let none = || vec![0; space.len()];
    let (powers, orders) = match product(fields, text) {
        Ok(powers) => (powers, none()),
        Err(reason) => {
            let Some((before, suffix)) = text.rsplit_once('_') else {
                return Err(fault(reason));
            };
            let inside = before.strip_prefix('(').and_then(|b| b.strip_suffix(')'));
            let powers = product(fields, inside.unwrap_or(before)).map_err(fault)?;
            let orders = derivative(space, suffix).map_err(fault)?;
            if inside.is_none() && powers.iter().map(|p| u32::from(*p)).sum::<u32>() > 1 {
                return Err(fault(format!(
                    "expected a derivative of a product, ({before})_{suffix}; products with derivatives cannot be integrated by parts"
                )));
            }
            (powers, orders)
        }
    };
    let term = FieldTerm { powers, orders };
    if term.degree() == 0 && term.order() > 0 {
        return Err(fault("the derivative of a constant is 0".to_owned()));
    }
    Ok(term)
}

fn product(fields: &[&str], text: &str) -> Result<Vec<u8>, String> {
    let mut powers = vec![0_u8; fields.len()];
    if text == "1" {
        return Ok(powers);
    }
    for factor in text.split('*') {
        let (name, power) = match factor.split_once('^') {
            Some((name, power)) => (name.trim(), power.trim().parse().ok()),
            None => (factor.trim(), Some(1)),
        };
        let place = fields.iter().position(|f| *f == name).ok_or_else(|| {
            format!(
                "expected products of the fields {}, found `{name}`",
                fields.join(", ")
            )
        })?;
        let sum = power.and_then(|p: u8| p.checked_add(powers[place]));
        powers[place] = sum
            .filter(|p| (1..=MOST).contains(p))
            .ok_or_else(|| format!("expected a power of 1 to {MOST}, found `{factor}`"))?;
    }
    Ok(powers)
}

fn derivative(space: &[&str], suffix: &str) -> Result<Vec<u8>, String> {
    let mut orders = vec![0_u8; space.len()];
    let short = space.iter().all(|name| name.chars().count() == 1);
    let letters: Vec<String> = match short {
        true => suffix.chars().map(String::from).collect(),
        false => suffix.split('.').map(str::to_owned).collect(),
    };
    for letter in letters {
        let axis = space.iter().position(|s| *s == letter).ok_or_else(|| {
            format!(
                "expected derivatives by {}, found `{letter}`",
                space.join(", ")
            )
        })?;
        orders[axis] += 1;
        if orders[axis] > MOST {
            return Err(format!("expected at most {MOST} derivatives by an axis"));
        }
    }
    Ok(orders)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_libraries_have_all_derivatives_of_all_products() {
        let library = FieldLibrary::polynomial(&["u"], 2, &["x"], 2).unwrap();
        let names = ["1", "u", "u_x", "u_xx", "u^2", "(u^2)_x", "(u^2)_xx"];
        assert_eq!(library.names(), names);
        // Products of two fields up to degree 3: 9, and 6 derivatives up to order 2 in two dimensions.
        let library = FieldLibrary::polynomial(&["u", "v"], 3, &["x", "y"], 2).unwrap();
        assert_eq!(library.len(), 1 + 9 * 6);
        assert!(library.names().contains(&"(u*v^2)_xy".to_owned()));
    }

    #[test]
    fn prop_printed_terms_are_read_again() {
        for space in [["x", "y"], ["lon", "lat"]] {
            let library = FieldLibrary::polynomial(&["u", "u_2"], 3, &space, 3).unwrap();
            let names = library.names();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let again = FieldLibrary::parse(&["u", "u_2"], &space, &names).unwrap();
            assert_eq!(again, library);
        }
    }

    #[test]
    fn prop_texts_that_are_no_terms_are_refused_with_a_reason() {
        for (text, reason) in [
            ("w", "the fields u, found `w`"),
            ("u^9", "a power of 1 to 8"),
            ("u^-1", "a power of 1 to 8"),
            ("u_z", "derivatives by x, found `z`"),
            ("1_x", "the derivative of a constant"),
            ("", "products of the fields"),
            ("u*u_x", "a derivative of a product, (u*u)_x"),
            ("u^2_x", "a derivative of a product"),
            ("u_xxxxxxxxx", "at most 8"),
        ] {
            let said = parse(&["u"], &["x"], text).unwrap_err().to_string();
            assert!(said.contains(reason), "{text}: {said}");
        }
        assert!(FieldLibrary::parse(&["u"], &["x"], &["u", "u"]).is_err());
    }
}
