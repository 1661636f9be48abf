//! The book's preprocessor for equations: LaTeX in the chapters becomes MathML in the pages, which browsers draw by themselves.
//!
//! mdBook runs it (`docs/book.toml`), with `supports RENDERER` as a question, or with the book as JSON on standard input.
//! An equation is a block fenced by three backticks and `math`, or a dollar and a backtick on either side within a line;
//! GitHub reads the same two.

use std::error::Error;
use std::fmt::Write as _;
use std::io::{Read as _, Write as _};

use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Parser, Storage, push_mathml};
use serde_json::Value;

fn main() -> Result<(), Box<dyn Error>> {
    if std::env::args().nth(1).as_deref() == Some("supports") {
        return Ok(());
    }
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let mut input: Value = serde_json::from_str(&text)?;
    let book = input.get_mut(1).ok_or("expected [context, book]")?;
    chapters(book)?;
    std::io::stdout().write_all(book.to_string().as_bytes())?;
    Ok(())
}

/// Converts the text of every chapter below `node`.
fn chapters(node: &mut Value) -> Result<(), Box<dyn Error>> {
    match node {
        Value::Array(items) => items.iter_mut().try_for_each(chapters),
        Value::Object(fields) => fields.iter_mut().try_for_each(|(key, value)| {
            match value {
                Value::String(markdown) if key == "content" => *markdown = convert(markdown)?,
                _ => chapters(value)?,
            }
            Ok(())
        }),
        _ => Ok(()),
    }
}

/// The chapter with its equations in MathML.
fn convert(markdown: &str) -> Result<String, Box<dyn Error>> {
    let mut out = String::with_capacity(markdown.len());
    let mut lines = markdown.lines();
    while let Some(line) = lines.next() {
        if line == "```math" {
            let latex: Vec<&str> = lines.by_ref().take_while(|l| *l != "```").collect();
            let mathml = mathml(&latex.join("\n"), DisplayMode::Block)?;
            writeln!(out, "<div class=\"equation\">{mathml}</div>")?;
        } else if line.starts_with("```") {
            writeln!(out, "{line}")?;
            for line in lines.by_ref() {
                writeln!(out, "{line}")?;
                if line.starts_with("```") {
                    break;
                }
            }
        } else {
            writeln!(out, "{}", inline(line)?)?;
        }
    }
    Ok(out)
}

/// The line with its equations in MathML.
fn inline(line: &str) -> Result<String, Box<dyn Error>> {
    let mut out = String::new();
    let mut rest = line;
    while let Some((before, after)) = rest.split_once("$`") {
        let (latex, after) = after
            .split_once("`$")
            .ok_or_else(|| format!("an equation without an end: {line}"))?;
        out.push_str(before);
        out.push_str(&mathml(latex, DisplayMode::Inline)?);
        rest = after;
    }
    Ok(out + rest)
}

/// The equation in MathML: for Markdown, without line breaks, which end a block of HTML, and bars, which end a cell of a
/// table; and with the blank before `minsize` and the non-breaking blank that pulldown-latex 0.8.0 gets wrong.
fn mathml(latex: &str, display_mode: DisplayMode) -> Result<String, Box<dyn Error>> {
    let storage = Storage::new();
    let config = RenderConfig {
        display_mode,
        ..RenderConfig::default()
    };
    let mut out = String::new();
    push_mathml(&mut out, Parser::new(latex, &storage), config)?;
    if out.contains("merror") {
        return Err(format!("not an equation: {latex}").into());
    }
    Ok(out
        .replace('\n', " ")
        .replace('|', "&#124;")
        .replace("&amp;nbsp;", "&#160;")
        .replace("\"minsize", "\" minsize"))
}
