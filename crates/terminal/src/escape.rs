//! Names from files may hold characters that command a terminal, or that turn the order of what is read. They are
//! shown as escapes. All text and JSON that a command prints passes through here.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character commands a terminal, ends a line, or changes the order or the place of others: control
/// characters (ESC, and U+009B, which begins sequences as ESC `[` does), marks and overrides of writing direction,
/// separators of lines, and characters without width.
fn commands(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}')
        || matches!(c, '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}')
}

fn escaped<'t>(
    text: &'t str,
    is_kept: fn(char) -> bool,
    escape: fn(&mut String, char),
) -> Cow<'t, str> {
    let is_escaped = |c: char| commands(c) && !is_kept(c);
    if !text.contains(is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_escaped(c) {
            escape(&mut out, c);
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// As Rust writes it: `\u{9b}`.
fn as_code(out: &mut String, c: char) {
    let _ = write!(out, "\\u{{{:x}}}", u32::from(c));
}

/// Text of several lines for people: commands to the terminal are escaped, but for ends of lines and tabs.
#[must_use]
pub fn text(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n' || c == '\t', as_code)
}

/// A name, a cell of a table or a sentence: ends of lines are escaped as well.
#[must_use]
pub fn line(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false, as_code)
}

/// JSON text. It is another spelling of the same values, because such characters stand in strings only.
#[must_use]
pub fn json(text: &str) -> Cow<'_, str> {
    // All of them lie in the basic plane, so that four digits suffice.
    let escape = |out: &mut String, c: char| {
        let _ = write!(out, "\\u{:04x}", u32::from(c));
    };
    escaped(text, |c| c == '\n', escape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_commands_to_a_terminal_are_shown_and_letters_stay() {
        let hostile = "a\u{1b}[31m\u{9b}2J\u{202e}b\u{2066}\r\u{7f}\n\tµ é 高 🚁";
        let shown = r"a\u{1b}[31m\u{9b}2J\u{202e}b\u{2066}\u{d}\u{7f}";
        assert_eq!(text(hostile), format!("{shown}\n\tµ é 高 🚁"));
        assert_eq!(line(hostile), format!(r"{shown}\u{{a}}\u{{9}}µ é 高 🚁"));
        assert!(matches!(text("a line\n\tof text"), Cow::Borrowed(_)));
    }

    #[test]
    fn prop_escaped_json_has_the_same_values() {
        let hostile: String = (0..0x1_0000).filter_map(char::from_u32).collect();
        let value = serde_json::json!({ hostile.clone(): hostile });
        let printed = serde_json::to_string_pretty(&value).unwrap();
        let escaped = json(&printed);
        assert!(!escaped.contains(|c: char| commands(c) && c != '\n'));
        let read: serde_json::Value = serde_json::from_str(&escaped).unwrap();
        assert_eq!(read, value);
    }
}
