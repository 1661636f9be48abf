//! Logs and commands in words.

use std::path::PathBuf;

/// The name in tables of what one fit is of: the log, or how many logs.
#[must_use]
pub fn label(logs: &[PathBuf]) -> String {
    match logs {
        [one] => one.display().to_string(),
        many => format!("{} logs together", many.len()),
    }
}

/// Warnings of logs, each once: with its log, or with how many logs it is of.
#[must_use]
pub fn once(warnings: impl IntoIterator<Item = (PathBuf, String)>) -> Vec<String> {
    let mut each: Vec<(String, Vec<PathBuf>)> = Vec::new();
    for (path, text) in warnings {
        match each.iter_mut().find(|(known, _)| *known == text) {
            Some((_, logs)) => logs.push(path),
            None => each.push((text, vec![path])),
        }
    }
    let of = |(text, logs): (String, Vec<PathBuf>)| match &logs[..] {
        [one] => format!("{}: {text}", one.display()),
        many => format!("{text} ({} logs)", many.len()),
    };
    each.into_iter().map(of).collect()
}

/// A word of a command line, quoted where a shell would take it apart.
#[must_use]
pub fn word(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+:,@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_string()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_warning_of_several_logs_stands_once() {
        let warnings = [("a", "tilt"), ("b", "tilt"), ("b", "spikes"), ("c", "tilt")];
        let warnings = warnings.map(|(path, text)| (PathBuf::from(path), text.to_string()));
        assert_eq!(once(warnings), ["tilt (3 logs)", "b: spikes"]);
    }

    #[test]
    fn analytic_words_are_quoted() {
        assert_eq!(word("a/b.csv"), "a/b.csv");
        assert_eq!(word("it's"), r"'it'\''s'");
    }
}
