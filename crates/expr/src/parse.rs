//! Tokens to expressions, by precedence climbing.

use std::str::FromStr;

use crate::arena::Builder;
use crate::error::ParseError;
use crate::expr::Expr;
use crate::lexer::{Lexeme, Lexer, Token, reserved_words};
use crate::node::{Binary, Id, Unary};
use crate::suggest::nearest;

/// Longest text that is parsed, in bytes.
pub const MAX_TEXT_BYTES: usize = 64 * 1024;

/// Deepest nesting of parentheses, calls, prefix operators and exponents.
pub const MAX_NESTING: usize = 200;

/// How tightly operators bind, loosest first. Shared with the printer.
pub(crate) mod level {
    pub(crate) const ANY: u8 = 0;
    pub(crate) const OR: u8 = 1;
    pub(crate) const AND: u8 = 2;
    pub(crate) const NOT: u8 = 3;
    pub(crate) const COMPARE: u8 = 4;
    pub(crate) const SUM: u8 = 5;
    pub(crate) const PRODUCT: u8 = 6;
    pub(crate) const NEGATE: u8 = 7;
    pub(crate) const POWER: u8 = 8;
    pub(crate) const ATOM: u8 = 9;
}

type Parsed<T> = Result<T, Box<ParseError>>;

impl Expr {
    /// Parses a text. The language is described at the [crate] root.
    ///
    /// # Errors
    /// [`ParseError`] with the place, what was expected there and what was found.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        parse(text).map_err(|error| *error)
    }
}

impl FromStr for Expr {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        Self::parse(text)
    }
}

struct Parser<'t> {
    text: &'t str,
    lexer: Lexer<'t>,
    next: Lexeme,
    builder: Builder,
    nesting: usize,
}

fn parse(text: &str) -> Parsed<Expr> {
    if text.len() > MAX_TEXT_BYTES {
        let expected = format!("at most {MAX_TEXT_BYTES} bytes of text");
        return Err(ParseError::new(
            text,
            0,
            expected,
            format!("{} bytes", text.len()),
        ));
    }
    let mut lexer = Lexer::new(text);
    let next = lexer.next()?;
    let mut parser = Parser {
        text,
        lexer,
        next,
        builder: Builder::default(),
        nesting: 0,
    };
    let root = parser.expression(level::ANY)?;
    match parser.next.token {
        Token::End => Ok(parser.builder.finish(root)),
        _ => Err(parser.unexpected("an operator or the end of the text")),
    }
}

impl Parser<'_> {
    /// An expression whose operators bind at least as tightly as `loosest`.
    fn expression(&mut self, loosest: u8) -> Parsed<Id> {
        let mut left = self.operand(loosest)?;
        while let Some(op) = self.operator() {
            let (own, right_loosest) = binding(op);
            if own < loosest {
                break;
            }
            self.advance()?;
            let right = if op == Binary::Pow {
                self.nested(|parser| parser.expression(right_loosest))?
            } else {
                self.expression(right_loosest)?
            };
            left = self.builder.binary(op, left, right);
            if own == level::COMPARE
                && self
                    .operator()
                    .is_some_and(|next| binding(next).0 == level::COMPARE)
            {
                return Err(self.unexpected("`and` between two comparisons"));
            }
        }
        Ok(left)
    }

    /// The next binary operator, if there is one.
    fn operator(&self) -> Option<Binary> {
        match self.next.token {
            Token::Operator(op) => Some(op),
            Token::Word => match self.word() {
                "and" => Some(Binary::And),
                "or" => Some(Binary::Or),
                _ => None,
            },
            _ => None,
        }
    }

    fn operand(&mut self, loosest: u8) -> Parsed<Id> {
        match &self.next.token {
            Token::Number(value) => {
                let id = self.builder.constant(*value);
                self.advance()?;
                Ok(id)
            }
            Token::Quoted(name) => {
                let id = self.builder.variable(name);
                self.advance()?;
                Ok(id)
            }
            Token::Open => {
                self.advance()?;
                let inner = self.nested(|parser| parser.expression(level::ANY))?;
                self.expect(&Token::Close, "an operator or `)`")?;
                Ok(inner)
            }
            Token::Operator(Binary::Sub) => {
                self.advance()?;
                let inner = self.nested(|parser| parser.expression(level::NEGATE))?;
                Ok(self.builder.unary(Unary::Neg, inner))
            }
            Token::Word => self.named(loosest),
            _ => Err(self.unexpected("a value")),
        }
    }

    /// A variable, constant, function call or `not`.
    fn named(&mut self, loosest: u8) -> Parsed<Id> {
        let at = self.next.start;
        let constant = match self.word() {
            "and" | "or" => return Err(self.unexpected("a value")),
            "not" if loosest > level::NOT => {
                return Err(self.unexpected("a value (put `not …` in parentheses)"));
            }
            "not" => {
                self.advance()?;
                let inner = self.nested(|parser| parser.expression(level::NOT))?;
                return Ok(self.builder.unary(Unary::Not, inner));
            }
            "pi" => Some(std::f64::consts::PI),
            "inf" => Some(f64::INFINITY),
            "nan" => Some(f64::NAN),
            _ => None,
        };
        let word = &self.text[at..self.next.end];
        if let Some(value) = constant {
            self.advance()?;
            return Ok(self.builder.constant(value));
        }
        self.advance()?;
        if let Some(op) = Unary::FUNCTIONS.into_iter().find(|op| op.name() == word) {
            let [a] = self.arguments(word)?;
            return Ok(self.builder.unary(op, a));
        }
        if let Some(op) = Binary::FUNCTIONS.into_iter().find(|op| op.name() == word) {
            let [a, b] = self.arguments(word)?;
            return Ok(self.builder.binary(op, a, b));
        }
        if word == "if" {
            let [condition, a, b] = self.arguments(word)?;
            return Ok(self.builder.select(condition, a, b));
        }
        if self.next.token == Token::Open {
            let expected = nearest(word, reserved_words()).map_or_else(
                || "a known function (or `*` before the parenthesis)".to_owned(),
                |name| format!("a known function such as `{name}`"),
            );
            return Err(ParseError::new(
                self.text,
                at,
                expected,
                format!("`{}`", shorten(word)),
            ));
        }
        Ok(self.builder.variable(word))
    }

    fn arguments<const N: usize>(&mut self, function: &str) -> Parsed<[Id; N]> {
        self.expect(&Token::Open, &format!("`(` after the function `{function}` (a variable of that name is written in double quotes)"))?;
        let mut arguments = [0; N];
        for (i, argument) in arguments.iter_mut().enumerate() {
            *argument = self.nested(|parser| parser.expression(level::ANY))?;
            let takes = if N == 1 {
                "1 argument".to_owned()
            } else {
                format!("{N} arguments")
            };
            if i + 1 < N {
                self.expect(
                    &Token::Comma,
                    &format!("an operator or `,`: `{function}` takes {takes}"),
                )?;
            } else {
                self.expect(
                    &Token::Close,
                    &format!("an operator or `)`: `{function}` takes {takes}"),
                )?;
            }
        }
        Ok(arguments)
    }

    /// Runs one level deeper, so that hostile text cannot exhaust the stack.
    fn nested(&mut self, inner: impl FnOnce(&mut Self) -> Parsed<Id>) -> Parsed<Id> {
        if self.nesting == MAX_NESTING {
            return Err(ParseError::new(
                self.text,
                self.next.start,
                format!("at most {MAX_NESTING} levels of nesting"),
                "a deeper one",
            ));
        }
        self.nesting += 1;
        let result = inner(self);
        self.nesting -= 1;
        result
    }

    fn word(&self) -> &str {
        &self.text[self.next.start..self.next.end]
    }

    fn advance(&mut self) -> Parsed<()> {
        self.next = self.lexer.next()?;
        Ok(())
    }

    fn expect(&mut self, token: &Token, expected: &str) -> Parsed<()> {
        if self.next.token == *token {
            self.advance()
        } else {
            Err(self.unexpected(expected))
        }
    }

    fn unexpected(&self, expected: &str) -> Box<ParseError> {
        let found = match self.next.token {
            Token::End => "the end of the text".to_owned(),
            _ => format!("`{}`", shorten(self.word())),
        };
        ParseError::new(self.text, self.next.start, expected, found)
    }
}

fn shorten(word: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = word.chars().take(LONGEST).collect();
    if word.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}

/// How tightly an operator binds, and the loosest level allowed on its right.
fn binding(op: Binary) -> (u8, u8) {
    match op {
        Binary::Or => (level::OR, level::AND),
        Binary::And => (level::AND, level::NOT),
        Binary::Lt | Binary::Le | Binary::Gt | Binary::Ge | Binary::Eq | Binary::Ne => {
            (level::COMPARE, level::SUM)
        }
        Binary::Add | Binary::Sub => (level::SUM, level::PRODUCT),
        Binary::Mul | Binary::Div => (level::PRODUCT, level::NEGATE),
        Binary::Pow => (level::POWER, level::NEGATE),
        Binary::Min | Binary::Max | Binary::Hypot | Binary::Atan2 => (level::ATOM, level::ANY),
    }
}
