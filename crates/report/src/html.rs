//! The page of a report.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::font;
use crate::report::{Block, Callout, Report};
use crate::scene::PLAYER;
use crate::table::{Align, Table};
use crate::words::Words;
use crate::{Result, files};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// plotly.js 3.7.0, its basic bundle: the traces that figures use and no others.
const PLOTLY: &str = include_str!("../plotly/plotly-basic.min.js");

/// Nothing may be loaded: the page is what it carries.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'";

impl Report {
    /// The whole page.
    pub fn html(&self) -> String {
        let any = |kind: fn(&Block) -> bool| self.blocks.iter().any(kind);
        let interactive = any(|block| matches!(block, Block::Figure(_)));
        let watched = any(|block| matches!(block, Block::Scene(_)));
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    link rel="icon" href="data:,";
                    title { (self.title) }
                    style { (PreEscaped(typefaces())) (PreEscaped(STYLE)) }
                }
                body {
                    (head(self))
                    div.columns {
                        (contents(self))
                        main { (body(self)) }
                    }
                    @if interactive {
                        script { (PreEscaped(PLOTLY)) }
                        script { (PreEscaped(SCRIPT)) }
                    }
                    @if watched { script { (PreEscaped(PLAYER)) } }
                }
            }
        };
        page.into_string()
    }

    /// Writes the page, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::write_atomic(path.as_ref(), self.html().as_bytes())
    }
}

fn typefaces() -> String {
    let face = |weight: u32, bytes: &[u8]| {
        let data = STANDARD.encode(bytes);
        format!(
            "@font-face{{font-family:Inter;font-weight:{weight};src:url(data:font/otf;base64,{data}) format('opentype')}}\n"
        )
    };
    face(400, font::REGULAR) + &face(600, font::SEMIBOLD)
}

fn head(report: &Report) -> Markup {
    html! {
        header {
            h1 { (report.title) }
            @if !report.subtitle.is_empty() { p.subtitle { (report.subtitle) } }
            @if !report.facts.is_empty() {
                dl.facts { @for (name, value) in &report.facts { div { dt { (name) } dd { (value) } } } }
            }
        }
    }
}

/// Sections with their parts; none for a report that is one section.
fn contents(report: &Report) -> Markup {
    type Entry<'a> = (usize, &'a str);
    let mut sections: Vec<(Option<Entry<'_>>, Vec<Entry<'_>>)> = Vec::new();
    for (index, block) in report.blocks.iter().enumerate() {
        match (block, sections.last_mut()) {
            (Block::Section(title), _) => sections.push((Some((index, title)), Vec::new())),
            (Block::Subsection(title), Some((_, parts))) => parts.push((index, title)),
            (Block::Subsection(title), None) => sections.push((None, vec![(index, title)])),
            _ => {}
        }
    }
    let link = |(index, title): Entry<'_>| html! { a href=(format!("#s{index}")) { (title) } };
    html! {
        @if sections.len() > 1 {
            nav aria-label="Contents" {
                p { "Contents" }
                ul { @for (section, parts) in sections { li {
                    @if let Some(section) = section { (link(section)) }
                    @if !parts.is_empty() { ul { @for part in parts { li { (link(part)) } } } }
                } } }
            }
        }
    }
}

fn body(report: &Report) -> Markup {
    let words = Words::new(report.terms);
    let silent = Words::new(&[]);
    let (mut figures, mut tables, mut depth) = (0, 0, 0_usize);
    html! {
        @for (index, block) in report.blocks.iter().enumerate() {
            @let words = if depth == 0 { &words } else { &silent };
            @match block {
                Block::Section(title) => ({ words.heading(); html! { h2 id=(format!("s{index}")) { (title) } } }),
                Block::Subsection(title) => ({ words.heading(); html! { h3 id=(format!("s{index}")) { (title) } } }),
                Block::Paragraph(text) => p { (words.set(text)) },
                Block::List(items) => ul { @for item in items { li { (words.set(item)) } } },
                Block::Code(text) => pre { code { (text) } },
                Block::Callout(kind, text) => (callout(*kind, text, words)),
                Block::Verdict(kind, text) => p.verdict.(looks(*kind).0) role="note" { (words.set(text)) },
                Block::Highlights(items) => (highlights(items, words)),
                Block::Table(table) => ({ tables += 1; self::table(table, tables, words) }),
                Block::Figure(chart) => ({ figures += 1; chart.markup(figures, words) }),
                Block::Scene(player) => ({ figures += 1; player.markup(figures, words) }),
                Block::FoldBegin(summary) => ({ depth += 1; PreEscaped(fold(summary)) }),
                Block::FoldEnd => ({ depth -= 1; PreEscaped("</div></details>".to_owned()) }),
            }
            // Nothing stands between the verdict and the picture that shows it.
            @if !matches!(block, Block::Verdict(..) | Block::Highlights(_)) { (words.explanations()) }
        }
    }
}

/// The open end of a fold.
fn fold(summary: &str) -> String {
    let line = html! { summary { (summary) } };
    format!("<details>{}<div>", line.into_string())
}

/// Class and word of a remark.
fn looks(kind: Callout) -> (&'static str, &'static str) {
    match kind {
        Callout::Note => ("note", "Note"),
        Callout::Success => ("success", "Success"),
        Callout::Warning => ("warning", "Warning"),
        Callout::Failure => ("failure", "Failure"),
    }
}

fn callout(kind: Callout, text: &str, words: &Words<'_>) -> Markup {
    let (class, word) = looks(kind);
    html! { p.callout.(class) role="note" { strong { (word) "." } " " (words.set(text)) } }
}

fn highlights(items: &[[String; 3]], words: &Words<'_>) -> Markup {
    html! {
        dl.highlights {
            @for [name, value, remark] in items {
                div { dt { (words.set(name)) } dd { (value) } @if !remark.is_empty() { dd.remark { (words.set(remark)) } } }
            }
        }
    }
}

/// A cell of more letters than this may break within a word on a narrow page: lists of names have no blanks to break at.
const LONG_CELL: usize = 40;

fn table(table: &Table, number: usize, words: &Words<'_>) -> Markup {
    let class = |column: usize| match table.columns[column].align {
        Align::Left => "left",
        Align::Right => "right",
        Align::Center => "center",
    };
    html! {
        figure.table id=(format!("table-{number}")) {
            figcaption { b { "Table " (number) "." } " " (words.set(&table.caption)) }
            div.scroll tabindex="0" {
                table {
                    thead { tr {
                        @for (index, column) in table.columns.iter().enumerate() {
                            th.(class(index)) scope="col" {
                                (words.mark(&column.name))
                                @if !column.unit.is_empty() { " " span.unit { "(" (column.unit) ")" } }
                            }
                        }
                    } }
                    tbody { @for row in &table.rows { tr {
                        @for (index, cell) in row.iter().enumerate() {
                            td.(class(index)).long[cell.shown().len() > LONG_CELL] {
                                @let shown = words.mark(cell.shown());
                                @if cell.is_bold() { b { (shown) } } @else { (shown) }
                            }
                        }
                    } } }
                }
            }
            @for note in &table.notes { p.remark { (words.set(note)) } }
        }
    }
}
