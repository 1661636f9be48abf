//! Text to tokens.

use crate::error::ParseError;
use crate::node::{Binary, Unary};

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token {
    Number(f64),
    /// A bare word: a variable, function, constant or logical operator.
    Word,
    /// A quoted name, unquoted.
    Quoted(String),
    Operator(Binary),
    Open,
    Close,
    Comma,
    End,
}

/// Reads one token after another from a text.
pub(crate) struct Lexer<'t> {
    text: &'t str,
    /// Byte offset of the next character to read.
    offset: usize,
}

/// A token and the bytes that it spans.
#[derive(Clone, Debug)]
pub(crate) struct Lexeme {
    pub(crate) token: Token,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

const WORDS: [&str; 7] = ["and", "or", "not", "if", "pi", "inf", "nan"];

/// Words that cannot be bare variable names.
pub(crate) fn reserved_words() -> impl Iterator<Item = &'static str> {
    let unary = Unary::FUNCTIONS.into_iter().map(Unary::name);
    let binary = Binary::FUNCTIONS.into_iter().map(Binary::name);
    unary.chain(binary).chain(WORDS)
}

/// Whether a variable's name can be written without quotes.
pub(crate) fn is_bare_name(name: &str) -> bool {
    !name.is_empty() && word_length(name) == name.len() && reserved_words().all(|w| w != name)
}

/// Bytes of the word at the start of `rest`, 0 if there is none.
fn word_length(rest: &str) -> usize {
    let starts = |c: char| c.is_alphabetic() || c == '_';
    let continues = |c: char| c.is_alphanumeric() || c == '_';
    let mut chars = rest.char_indices().peekable();
    match chars.next() {
        Some((_, c)) if starts(c) => {}
        _ => return 0,
    }
    while let Some((at, c)) = chars.next() {
        let dot_inside = c == '.' && chars.peek().is_some_and(|&(_, next)| continues(next));
        if !continues(c) && !dot_inside {
            return at;
        }
    }
    rest.len()
}

impl<'t> Lexer<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        Self { text, offset: 0 }
    }

    pub(crate) fn next(&mut self) -> Result<Lexeme, Box<ParseError>> {
        let rest = &self.text[self.offset..];
        self.offset += rest.len() - rest.trim_start().len();
        let start = self.offset;
        let rest = &self.text[start..];
        let Some(first) = rest.chars().next() else {
            return Ok(Lexeme {
                token: Token::End,
                start,
                end: start,
            });
        };
        let (token, length) = match first {
            '(' => (Token::Open, 1),
            ')' => (Token::Close, 1),
            ',' => (Token::Comma, 1),
            '"' => self.quoted(rest)?,
            '0'..='9' | '.' => self.number(rest)?,
            _ => match word_length(rest) {
                0 => self.operator(rest, first)?,
                length => (Token::Word, length),
            },
        };
        self.offset = start + length;
        Ok(Lexeme {
            token,
            start,
            end: self.offset,
        })
    }

    fn operator(&self, rest: &str, first: char) -> Result<(Token, usize), Box<ParseError>> {
        // Longer operators first, so that `<=` is not read as `<`.
        const OPERATORS: [Binary; 11] = [
            Binary::Le,
            Binary::Ge,
            Binary::Eq,
            Binary::Ne,
            Binary::Lt,
            Binary::Gt,
            Binary::Add,
            Binary::Sub,
            Binary::Mul,
            Binary::Div,
            Binary::Pow,
        ];
        if let Some(op) = OPERATORS.into_iter().find(|op| rest.starts_with(op.name())) {
            return Ok((Token::Operator(op), op.name().len()));
        }
        let expected = match first {
            '=' => "`==` for comparison",
            '&' => "`and`",
            '|' => "`or`",
            '!' | '~' => "`not`, or `!=` for comparison",
            '\'' => "double quotes around a name",
            '[' | '{' => "`(`",
            ']' | '}' => "`)`",
            _ => "a number, a name, an operator or a quoted name",
        };
        Err(ParseError::new(
            self.text,
            self.offset,
            expected,
            format!("`{}`", first.escape_debug()),
        ))
    }

    fn quoted(&self, rest: &str) -> Result<(Token, usize), Box<ParseError>> {
        let mut name = String::new();
        let mut chars = rest.char_indices().skip(1).peekable();
        while let Some((at, c)) = chars.next() {
            if c != '"' {
                name.push(c);
            } else if chars.next_if(|&(_, next)| next == '"').is_some() {
                name.push('"');
            } else if name.is_empty() {
                return Err(ParseError::new(
                    self.text,
                    self.offset,
                    "a name between the quotes",
                    "an empty name",
                ));
            } else {
                return Ok((Token::Quoted(name), at + 1));
            }
        }
        Err(ParseError::new(
            self.text,
            self.offset,
            "a closing `\"` for this quoted name",
            "the end of the text",
        ))
    }

    fn number(&self, rest: &str) -> Result<(Token, usize), Box<ParseError>> {
        let bytes = rest.as_bytes();
        let digits = |from: usize| {
            bytes[from..]
                .iter()
                .take_while(|b| b.is_ascii_digit())
                .count()
        };
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end += 1 + digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits(end + 1 + sign);
            end += 1 + sign + exponent;
        }
        let written = &rest[..end];
        let fail = |expected: &str| {
            let shown: String = written.chars().take(40).collect();
            ParseError::new(self.text, self.offset, expected, format!("`{shown}`"))
        };
        match written.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((Token::Number(value), end)),
            Ok(_) => Err(fail("a number of magnitude below 1.8e308")),
            Err(_) => Err(fail("a number such as 1, .5 or 1e-3")),
        }
    }
}
