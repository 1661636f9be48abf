//! The text of a library to tokens.

use sindy_expr::{MAX_NESTING, MAX_TEXT_BYTES};

use super::error;
use crate::error::SindyError;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    Word,
    Number,
    /// A name in quotes.
    Quoted,
    /// An operator, a parenthesis, a comma, or a character that nothing begins with.
    Symbol,
}

/// A token and the bytes that it spans.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) start: usize,
    pub(super) end: usize,
}

impl Token {
    pub(super) fn text<'t>(&self, text: &'t str) -> &'t str {
        &text[self.start..self.end]
    }

    /// The name of a word or of a quoted name.
    pub(super) fn name(&self, text: &str) -> Option<String> {
        match self.kind {
            TokenKind::Word => Some(self.text(text).to_string()),
            TokenKind::Quoted => Some(text[self.start + 1..self.end - 1].replace("\"\"", "\"")),
            TokenKind::Number | TokenKind::Symbol => None,
        }
    }
}

/// All tokens; parentheses in them match.
pub(super) fn scan(text: &str) -> Result<Vec<Token>, SindyError> {
    if text.len() > MAX_TEXT_BYTES {
        let expected = format!("at most {MAX_TEXT_BYTES} bytes of text");
        return Err(error(text, 0, expected, format!("{} bytes", text.len())));
    }
    let mut tokens = Vec::new();
    let mut open = Vec::new();
    let mut at = 0;
    loop {
        let rest = text[at..].trim_start();
        at = text.len() - rest.len();
        let Some(first) = rest.chars().next() else {
            break;
        };
        let (kind, length) = match first {
            '"' => (
                TokenKind::Quoted,
                quoted(rest).ok_or_else(|| unclosed(text, at))?,
            ),
            '0'..='9' => (TokenKind::Number, number(rest)),
            '.' if rest[1..].starts_with(|c: char| c.is_ascii_digit()) => {
                (TokenKind::Number, number(rest))
            }
            c if c.is_alphabetic() || c == '_' => (TokenKind::Word, word(rest)),
            _ if ["<=", ">=", "==", "!="]
                .iter()
                .any(|op| rest.starts_with(op)) =>
            {
                (TokenKind::Symbol, 2)
            }
            c => (TokenKind::Symbol, c.len_utf8()),
        };
        match first {
            '(' if open.len() == MAX_NESTING => {
                let expected = format!("at most {MAX_NESTING} levels of parentheses");
                return Err(error(text, at, expected, "a deeper one"));
            }
            '(' => open.push(at),
            ')' if open.pop().is_none() => {
                return Err(error(text, at, "no `)`: none is open", "`)`"));
            }
            _ => {}
        }
        let end = at + length;
        tokens.push(Token {
            kind,
            start: at,
            end,
        });
        at = end;
    }
    match open.pop() {
        Some(start) => {
            let column = text[..start].chars().count() + 1;
            let expected = format!("a `)` for the `(` in column {column}");
            Err(error(text, text.len(), expected, "the end of the text"))
        }
        None => Ok(tokens),
    }
}

fn unclosed(text: &str, at: usize) -> SindyError {
    let expected = "a closing `\"` for this quoted name";
    error(text, at, expected, "the end of the text")
}

/// Bytes of a quoted name, `""` inside it standing for one quote.
fn quoted(rest: &str) -> Option<usize> {
    let mut chars = rest.char_indices().skip(1).peekable();
    while let Some((at, c)) = chars.next() {
        if c == '"' && chars.next_if(|&(_, next)| next == '"').is_none() {
            return Some(at + 1);
        }
    }
    None
}

fn word(rest: &str) -> usize {
    let continues = |c: char| c.is_alphanumeric() || c == '_';
    let mut chars = rest.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        let dot_inside = c == '.' && chars.peek().is_some_and(|&(_, next)| continues(next));
        if !continues(c) && !dot_inside {
            return at;
        }
    }
    rest.len()
}

fn number(rest: &str) -> usize {
    let bytes = rest.as_bytes();
    let digits = |from: usize| {
        let tail = bytes.get(from..).unwrap_or_default();
        tail.iter().take_while(|b| b.is_ascii_digit()).count()
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end += 1 + digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        end += 1 + sign + digits(end + 1 + sign);
    }
    end
}
