//! The page of a report.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figure::{Kind, Panel};
use crate::font;
use crate::plotly_json::Place;
use crate::report::{Block, Callout, Drawn, Report};
use crate::series::{BAND_ALPHA, LEAST_DOT, has_points};
use crate::table::{Align, Table};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Nothing may be loaded: the page is what it carries.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'";

/// The whole page.
pub(crate) fn page(report: &Report) -> String {
    let interactive = report
        .blocks
        .iter()
        .any(|block| matches!(block, Block::Figure(_)));
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                link rel="icon" href="data:,";
                title { (report.title) }
                style { (PreEscaped(typefaces())) (PreEscaped(STYLE)) }
            }
            body {
                (head(report))
                div.columns {
                    (contents(report))
                    main { (body(report)) }
                }
                @if interactive {
                    script { (PreEscaped(plotly_js(&plotly::Plot::offline_js_sources()))) }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        }
    };
    page.into_string()
}

/// The first of the bundled scripts is plotly.js; the other (formulas in TeX) is not used.
fn plotly_js(scripts: &str) -> &str {
    let begin = scripts
        .find("<script")
        .and_then(|tag| Some(tag + scripts[tag..].find('>')? + 1))
        .unwrap_or(0);
    let end = scripts[begin..]
        .find("</script>")
        .map_or(scripts.len(), |length| begin + length);
    &scripts[begin..end]
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
            @if !report.subtitle.is_empty() { p.subtitle { (inline(&report.subtitle)) } }
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
    let (mut figures, mut tables) = (0, 0);
    html! {
        @for (index, block) in report.blocks.iter().enumerate() {
            @match block {
                Block::Section(title) => h2 id=(format!("s{index}")) { (title) },
                Block::Subsection(title) => h3 id=(format!("s{index}")) { (title) },
                Block::Paragraph(text) => p { (inline(text)) },
                Block::List(items) => ul { @for item in items { li { (inline(item)) } } },
                Block::Code(text) => pre { code { (text) } },
                Block::Callout(kind, text) => (callout(*kind, text)),
                Block::Highlights(items) => (highlights(items)),
                Block::Table(table) => ({ tables += 1; self::table(table, tables) }),
                Block::Figure(drawn) => ({ figures += 1; figure(drawn, figures) }),
            }
        }
    }
}

fn callout(kind: Callout, text: &str) -> Markup {
    let (class, word) = match kind {
        Callout::Note => ("note", "Note"),
        Callout::Success => ("success", "Success"),
        Callout::Warning => ("warning", "Warning"),
        Callout::Failure => ("failure", "Failure"),
    };
    html! { p.callout.(class) role="note" { strong { (word) "." } " " (inline(text)) } }
}

fn highlights(items: &[[String; 3]]) -> Markup {
    html! {
        dl.highlights {
            @for [name, value, remark] in items {
                div { dt { (name) } dd { (value) } @if !remark.is_empty() { dd.remark { (inline(remark)) } } }
            }
        }
    }
}

fn table(table: &Table, number: usize) -> Markup {
    let class = |column: usize| match table.columns[column].align {
        Align::Left => "left",
        Align::Right => "right",
        Align::Center => "center",
    };
    html! {
        figure.table id=(format!("table-{number}")) {
            figcaption { b { "Table " (number) "." } " " (inline(&table.caption)) }
            div.scroll tabindex="0" {
                table {
                    thead { tr {
                        @for (index, column) in table.columns.iter().enumerate() {
                            th.(class(index)) scope="col" {
                                (column.name)
                                @if !column.unit.is_empty() { " " span.unit { "(" (column.unit) ")" } }
                            }
                        }
                    } }
                    tbody { @for row in &table.rows { tr {
                        @for (index, cell) in row.iter().enumerate() {
                            td.(class(index)) { @if cell.is_bold() { b { (cell.shown()) } } @else { (cell.shown()) } }
                        }
                    } } }
                }
            }
            @for note in &table.notes { p.remark { (inline(note)) } }
        }
    }
}

fn figure(drawn: &Drawn, number: usize) -> Markup {
    // "<" cannot end the script element early when it is written as an escape of JSON.
    let live = drawn.live.replace('<', "\\u003c");
    html! {
        figure.chart id=(format!("figure-{number}")) data-name=(drawn.figure.id) {
            div.keys {
                @for (panel, places) in drawn.figure.panels.iter().zip(&drawn.places) {
                    (keys(panel, places, drawn.figure.panels.len() > 1))
                }
            }
            div.plot style=(format!("height:{}px", drawn.height_px)) {
                div.still { (PreEscaped(&drawn.still)) }
                div.live {}
            }
            figcaption {
                b { "Figure " (number) ". " (drawn.figure.title) @if !drawn.figure.title.ends_with('.') { "." } }
                " " (inline(&drawn.figure.caption))
            }
            script type="application/json" { (PreEscaped(live)) }
        }
    }
}

/// The legend of a panel; each name switches its series on and off.
fn keys(panel: &Panel, places: &[Place], several: bool) -> Markup {
    let named = || {
        panel
            .series
            .iter()
            .zip(places)
            .enumerate()
            .filter(|(_, (series, _))| !series.name.is_empty())
    };
    let heading = panel.title.as_ref().or(several.then_some(&panel.y_label));
    html! {
        @if named().next().is_some() {
            div.group {
                @if let Some(heading) = heading { span.heading { (heading) } }
                @for (index, (series, place)) in named() {
                    @let (kind, at) = match place {
                        Place::Trace(trace) => ("trace", trace.to_string()),
                        Place::Shapes(first, count) => ("shapes", format!("{first},{count}")),
                    };
                    button.key type="button" aria-pressed="true" data-kind=(kind) data-at=(at) {
                        (sample(panel, index)) (series.name)
                    }
                }
            }
        }
    }
}

/// A sample of a series for the legend.
fn sample(panel: &Panel, index: usize) -> Markup {
    let series = &panel.series[index];
    let (color, width) = (panel.color_of(index).hex(), series.width.min(6.0));
    let area = matches!(series.kind, Kind::Band { .. } | Kind::Bars);
    let opacity = if series.kind == Kind::Bars {
        1.0
    } else {
        BAND_ALPHA
    };
    let line = !area && !matches!(series.kind, Kind::Points | Kind::ErrorBars { .. });
    let dash = match series.kind {
        Kind::Dashed => "7 4",
        Kind::Dotted => "2 3",
        Kind::HorizontalLine | Kind::VerticalLine => "5 3",
        _ => "none",
    };
    html! {
        svg width="26" height="10" viewBox="0 0 26 10" aria-hidden="true" {
            @if area { rect width="26" height="10" fill=(color) fill-opacity=(opacity) {} }
            @if line {
                path d="M0 5h26" fill="none" stroke=(color) stroke-width=(width) stroke-dasharray=(dash) {}
            }
            @if has_points(&series.kind) { circle cx="13" cy="5" r=((1.5 * width).max(LEAST_DOT)) fill=(color) {} }
        }
    }
}

/// Plain text with `` `code` `` and `**strong**`.
fn inline(text: &str) -> Markup {
    let code = |index: usize| index % 2 == 1;
    let parts: Vec<&str> = text.split('`').collect();
    // A mark without a partner stands for itself.
    let balanced = !parts.len().is_multiple_of(2);
    html! {
        @if balanced {
            @for (index, part) in parts.into_iter().enumerate() {
                @if code(index) { code { (part) } } @else { (strong(part)) }
            }
        } @else { (strong(text)) }
    }
}

fn strong(text: &str) -> Markup {
    let parts: Vec<&str> = text.split("**").collect();
    if parts.len().is_multiple_of(2) {
        return html! { (text) };
    }
    html! {
        @for (index, part) in parts.into_iter().enumerate() {
            @if index % 2 == 1 { strong { (part) } } @else { (part) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_marks_in_text() {
        assert_eq!(
            inline("a `b<c` **d** & e").into_string(),
            "a <code>b&lt;c</code> <strong>d</strong> &amp; e"
        );
        assert_eq!(inline("5 ` and 2**3").into_string(), "5 ` and 2**3");
    }

    #[test]
    fn analytic_only_the_chart_library_is_taken() {
        let sources = plotly::Plot::offline_js_sources();
        let script = plotly_js(&sources);
        assert!(script.contains("plotly.js v3"), "licence line of plotly.js");
        assert!(!script.contains("</script"));
        // plotly.min.js 3.0 is 4.6 MB; with the unused second script it would be 6.7 MB.
        assert!(
            (3_000_000..6_000_000).contains(&script.len()),
            "{} bytes",
            script.len()
        );
    }
}
