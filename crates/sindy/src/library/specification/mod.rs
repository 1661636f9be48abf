//! Libraries written as one text.

mod constructor;
mod scan;

use std::ops::Range;

use sindy_expr::Expr;

use super::Library;
use super::algebra::MAX_PAIRS;
use super::factored::Alphabet;
use crate::error::SindyError;
use scan::{Token, TokenKind, scan};

impl Library {
    /// Reads a library over `variables` from a text, as it stands on a command line or in a settings file.
    ///
    /// | written | library |
    /// | --- | --- |
    /// | `poly(3)` | [`Library::polynomial`] of degree 3 in all variables; `bias=false`, `interaction=all`, `none` or `only` |
    /// | `fourier(2)` | [`Library::fourier`] with two frequencies; `base=0.5` |
    /// | `exp(1, 2)` | [`Library::exponentials`] with rates 1 and 2 |
    /// | `rational(0.1, 0.5)` | [`Library::bounded_rationals`] with these scales; `power=2`, also several times |
    /// | `poly(2, x, y)` | any of these, of some variables only |
    /// | `sin(x)*y` | one term: an expression of the language of [`sindy_expr`] |
    /// | `poly(2)*fourier(1)` | [`Library::product`] |
    /// | `poly(3) + sin(x)*y` | [`Library::sum`] |
    /// | `(poly(1) + exp(1))*y` | parentheses group libraries, or make one term of a sum: `(x + y)^2`, `(x - y)` |
    ///
    /// A `+` that is not in parentheses joins libraries; a difference, comparison or logic word needs
    /// parentheses to be a term. `exp` of nothing but numbers is the library, not the number e. A product of
    /// variables takes their order from `variables`; other terms keep the form in which they are written.
    ///
    /// ```
    /// use sindy::Library;
    /// let library = Library::specification("poly(2, x, bias=false) + exp(1, x)*y", &["x", "y"])?;
    /// assert_eq!(library.names(), ["x", "x^2", "y*exp(-x)"]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// A text that does not read: with its column, what was expected there and what was found. Names that are
    /// not among the variables, settings out of range, more than [`super::MAX_TERMS`] terms.
    pub fn specification<S: AsRef<str>>(text: &str, variables: &[S]) -> Result<Self, SindyError> {
        super::check_variables(variables)?;
        let variables = variables.iter().map(|v| v.as_ref().to_string()).collect();
        let tokens = scan(text)?;
        let mut reader = Reader {
            text,
            tokens: &tokens,
            variables,
            work: 0,
        };
        reader.sum(0..tokens.len())
    }

    /// The sum of several texts, each as for [`Library::specification`].
    ///
    /// # Errors
    /// No texts; as [`Library::specification`].
    pub fn specifications<T, S>(texts: &[T], variables: &[S]) -> Result<Self, SindyError>
    where
        T: AsRef<str>,
        S: AsRef<str>,
    {
        let read = |text: &T| Self::specification(text.as_ref(), variables);
        Self::sum(&texts.iter().map(read).collect::<Result<Vec<_>, _>>()?)
    }
}

/// Names that make a library when a parenthesis follows.
const CONSTRUCTORS: [&str; 4] = ["poly", "fourier", "exp", "rational"];

struct Reader<'t> {
    text: &'t str,
    tokens: &'t [Token],
    variables: Vec<String>,
    /// Terms and products of terms that were built so far.
    work: usize,
}

impl Reader<'_> {
    fn word(&self, token: &Token) -> &str {
        token.text(self.text)
    }

    fn is(&self, at: usize, what: &str) -> bool {
        self.tokens.get(at).is_some_and(|t| self.word(t) == what)
    }

    /// The error at a token, or at the end of the text.
    fn fail(&self, at: usize, expected: impl Into<String>) -> SindyError {
        let (start, found) = match self.tokens.get(at) {
            Some(token) => {
                let word: String = self.word(token).chars().take(40).collect();
                (token.start, format!("`{word}`"))
            }
            None => (self.text.len(), "the end of the text".into()),
        };
        error(self.text, start, expected, found)
    }

    fn sum(&mut self, range: Range<usize>) -> Result<Library, SindyError> {
        let mut parts = Vec::new();
        for part in self.split(range, "+") {
            parts.push(if self.holds_library(part.clone()) {
                self.product(part)?
            } else {
                self.term(part)?
            });
        }
        match parts.len() {
            1 => Ok(parts.remove(0)),
            _ => Library::sum(&parts),
        }
    }

    fn product(&mut self, range: Range<usize>) -> Result<Library, SindyError> {
        let mut product: Option<Library> = None;
        for part in self.split(range, "*") {
            let factor = self.factor(part)?;
            product = Some(match product {
                None => factor,
                Some(product) => {
                    self.spend(product.len().saturating_mul(factor.len()))?;
                    Library::product_in(&product, &factor, &self.variables)?
                }
            });
        }
        product.ok_or_else(|| self.fail(self.tokens.len(), "a library"))
    }

    fn factor(&mut self, range: Range<usize>) -> Result<Library, SindyError> {
        let (first, last) = (range.start, range.end);
        if self.is_constructor(first) {
            return match self.closes(first + 1) {
                close if close + 1 == last => self.constructor(first, close),
                close => Err(self.fail(close + 1, "`+`, `*` or the end after a library")),
            };
        }
        if self.is(first, "(") && self.holds_library(range.clone()) {
            let close = self.closes(first);
            if close + 1 == last {
                return self.sum(first + 1..close);
            }
            if self.holds_library(first + 1..close) {
                return Err(self.fail(close + 1, "`+`, `*` or the end after a library"));
            }
        }
        match range.clone().find(|&at| self.is_constructor(at)) {
            Some(at) => {
                let expected = "a term: a library can only be added and multiplied";
                Err(self.fail(at, expected))
            }
            None => self.term(range),
        }
    }

    /// One term.
    fn term(&mut self, range: Range<usize>) -> Result<Library, SindyError> {
        if range.is_empty() {
            return Err(self.fail(range.start, "a library or a term"));
        }
        let mut depth = 0_usize;
        for at in range.clone() {
            match self.word(&self.tokens[at]) {
                "(" => depth += 1,
                ")" => depth -= 1,
                _ if depth > 0 => {}
                "<" | "<=" | ">" | ">=" | "==" | "!=" | "and" | "or" | "not" => {
                    let expected = "`+`, `*` or the end (a comparison or logic needs parentheses)";
                    return Err(self.fail(at, expected));
                }
                "-" if at > range.start && self.ends_value(at - 1) => {
                    let expected =
                        "`+`, `*` or the end (a difference needs parentheses: `(x - y)`)";
                    return Err(self.fail(at, expected));
                }
                _ => {}
            }
        }
        let start = self.tokens[range.start].start;
        let text = &self.text[start..self.tokens[range.end - 1].end];
        let expr = Expr::parse(text)
            .map_err(|e| error(self.text, start + e.position, e.expected, e.found))?;
        for name in expr.variables() {
            if !self.variables.iter().any(|v| v == name) {
                let is_it = |at: &usize| self.tokens[*at].name(self.text).as_deref() == Some(name);
                let at = range.clone().find(is_it).unwrap_or(range.start);
                return Err(self.fail(at, self.known()));
            }
        }
        let (alphabet, factored) = Alphabet::new(std::slice::from_ref(&expr), &self.variables);
        let monomial = factored.first().filter(|term| alphabet.is_monomial(term));
        let tidy = monomial.map(|term| alphabet.expr(term));
        self.spend(1)?;
        Ok(Library::of(vec![tidy.unwrap_or(expr)]))
    }

    /// Counts terms that were built, so that no text takes long.
    fn spend(&mut self, terms: usize) -> Result<(), SindyError> {
        self.work = self.work.saturating_add(terms);
        if self.work > MAX_PAIRS {
            let expected = format!("at most {MAX_PAIRS} terms and products of them");
            return Err(self.fail(0, expected));
        }
        Ok(())
    }

    fn ends_value(&self, at: usize) -> bool {
        self.tokens[at].kind != TokenKind::Symbol || self.is(at, ")")
    }

    fn is_constructor(&self, at: usize) -> bool {
        let Some(token) = self.tokens.get(at).filter(|t| t.kind == TokenKind::Word) else {
            return false;
        };
        let word = self.word(token);
        if !CONSTRUCTORS.contains(&word) || !self.is(at + 1, "(") {
            return false;
        }
        // `exp(1)` is a library, `exp(2*x)` and `exp(x)` are terms.
        let number = at + 2 + usize::from(self.is(at + 2, "-"));
        let is_number = self
            .tokens
            .get(number)
            .is_some_and(|t| t.kind == TokenKind::Number);
        let ends = self.is(number + 1, ",") || self.is(number + 1, ")");
        word != "exp" || (is_number && ends)
    }

    fn holds_library(&self, mut range: Range<usize>) -> bool {
        range.any(|at| self.is_constructor(at))
    }

    /// Where the parenthesis at `open` closes.
    fn closes(&self, open: usize) -> usize {
        let mut depth = 0_usize;
        let close = (open..self.tokens.len()).find(|&at| {
            match self.word(&self.tokens[at]) {
                "(" => depth += 1,
                ")" => depth -= 1,
                _ => {}
            }
            depth == 0
        });
        close.unwrap_or(self.tokens.len())
    }

    /// The parts between separators that are not in parentheses.
    fn split(&self, range: Range<usize>, separator: &str) -> Vec<Range<usize>> {
        let mut parts = Vec::new();
        let (mut depth, mut start) = (0_usize, range.start);
        for at in range.clone() {
            match self.word(&self.tokens[at]) {
                "(" => depth += 1,
                ")" => depth -= 1,
                word if depth == 0 && word == separator => {
                    parts.push(start..at);
                    start = at + 1;
                }
                _ => {}
            }
        }
        parts.push(start..range.end);
        parts
    }

    fn known(&self) -> String {
        format!("one of: {}", self.variables.join(", "))
    }
}

fn error(
    text: &str,
    position: usize,
    expected: impl Into<String>,
    found: impl Into<String>,
) -> SindyError {
    const LONGEST: usize = 120;
    let mut shown: String = text.chars().take(LONGEST).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    SindyError::Specification {
        text: shown,
        column: text[..position].chars().count() + 1,
        expected: expected.into(),
        found: found.into(),
    }
}
